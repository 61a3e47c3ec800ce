"""Contact radius and load of a silicone lens on glass, w = 30 mJ/m^2 while loading and 45 mJ/m^2 while unloading."""

from __future__ import annotations

import sys

import numpy as np

R, E_STAR = 1.5e-3, 1.8e6 / (1 - 0.49**2)  # m, Pa
NOISE = 20e-6  # N
BRANCHES = ((0.030, np.linspace(80e-6, 240e-6, 40)), (0.045, np.linspace(235e-6, 54e-6, 40)))  # w in J/m^2, a in m


def main(path: str) -> None:
    """Write both branches of an exact sphere to ``path``."""
    random, rows = np.random.default_rng(3), []
    for w, a in BRANCHES:
        P = E_STAR * ((R**2 + a**2) * np.arctanh(a / R) - a * R) - np.sqrt(8 * np.pi * w * E_STAR * a**3)
        rows += [*zip(a * 1e6, (P + NOISE * random.normal(size=a.size)) * 1e3, strict=True)]
    np.savetxt(path, rows, "%.5g", ",", header="a (um),P (mN)", comments="")


if __name__ == "__main__":
    target = sys.argv[1] if len(sys.argv) > 1 else "probe.csv"
    main(target)
    print(f"written {target}")
