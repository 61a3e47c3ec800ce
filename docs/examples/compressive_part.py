"""The compressive part of a JKR curve with noise and a shifted origin: E* = 1 MPa, w = 100 mJ/m^2, R = 10 um."""

from __future__ import annotations

import sys

import numpy as np

R, E_STAR, W = 10e-6, 1e6, 0.1  # m, Pa, J/m^2
SHIFT = 0.1e-6  # m, of the origin of the displacement
NOISE = 0.01  # of displacement and load at pull-off


def main(path: str) -> None:
    """Write 200 readings from P = 0 on to ``path``."""
    random = np.random.default_rng(15)
    a0 = (4.5 * np.pi * W * R**2 / E_STAR) ** (1 / 3)  # the radius at P = 0
    a = np.linspace(a0, 1.6 * a0, 200)
    delta = a**2 / R - np.sqrt(2 * np.pi * W * a / E_STAR) + SHIFT
    P = 4 * E_STAR * a**3 / (3 * R) - np.sqrt(8 * np.pi * W * E_STAR * a**3)
    delta += NOISE * 0.36e-6 * random.standard_normal(200)
    P += NOISE * 1.5 * np.pi * W * R * random.standard_normal(200)
    table = np.column_stack([delta * 1e6, P * 1e6])
    np.savetxt(path, table, delimiter=",", header="displacement (um),load (uN)", comments="", fmt="%.6g")


if __name__ == "__main__":
    target = sys.argv[1] if len(sys.argv) > 1 else "compression.csv"
    main(target)
    print(f"written {target}")
