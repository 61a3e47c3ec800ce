"""Retractions of tips of 2 and 10 um from one gel, E* = 200 kPa, w = 1 mJ/m^2, with noise, and the case to fit them."""

from __future__ import annotations

from pathlib import Path

import numpy as np

E_STAR, W = 200e3, 1e-3  # Pa, J/m^2
TIPS = {"small": 2e-6, "large": 10e-6}  # m
CASE = """indenter = { shape = "paraboloid", radius = "5 um" }
specimen.half_space = { E = "150 kPa", nu = 0.5 }
loading = { radius = "1 um", points = 60, spacing = "log" }
"""


def main() -> None:
    """Write ``small.csv``, ``large.csv`` and ``gel.toml``."""
    random = np.random.default_rng(1)
    for name, R in TIPS.items():
        a = np.linspace(1, 3, 60) * (9 * np.pi * W * R**2 / (8 * E_STAR)) ** (1 / 3)
        delta = a**2 / R - np.sqrt(2 * np.pi * W * a / E_STAR)
        P = 4 * E_STAR * a**3 / (3 * R) - np.sqrt(8 * np.pi * W * E_STAR * a**3)
        delta, P = (x + 0.01 * np.ptp(x) * random.normal(size=60) for x in (delta, P))
        table = np.stack([delta * 1e9, P * 1e9], 1)
        np.savetxt(f"{name}.csv", table, "%.6g", ",", header="delta (nm),P (nN)", comments="")
    Path("gel.toml").write_text(CASE, encoding="utf-8")


if __name__ == "__main__":
    main()
    print("written small.csv, large.csv, gel.toml")
