"""A force curve of a sharp tip whose adhesion has a range of 0.3 nm, with noise: a table that ``jkr fit`` can read."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np

import jkrcli as jkr

CASE = jkr.parse_case("""
indenter = { shape = "paraboloid", radius = "20 nm" }
specimen.layers = [{ thickness = "50 nm", E = "2 GPa", nu = 0.4 }]
loading = { radius = "8 nm" }
""")
NOISE = {"delta": 1e-12, "P": 20e-12}  # m, N


def main(path: str) -> None:
    """Write 300 readings from pull-off under displacement control on to ``path``."""
    curve = jkr.transform(jkr.solve(CASE), 0.05, length=0.3e-9).curve
    places = np.linspace(curve.pull_off(np.inf).place, curve.places[-1], 300)
    random, (delta, P) = np.random.default_rng(1), curve.at(places)
    delta, P = (values + NOISE[name] * random.standard_normal(300) for name, values in (("delta", delta), ("P", P)))
    rows = "".join(f"{x * 1e9:.5f},{y * 1e9:.5f}\n" for x, y in zip(delta, P, strict=True))
    Path(path).write_text("delta_nm,P_nN\n" + rows, encoding="utf-8")


if __name__ == "__main__":
    target = sys.argv[1] if len(sys.argv) > 1 else "tip.csv"
    main(target)
    print(f"written {target}")
