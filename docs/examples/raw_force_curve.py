"""Makes the messy record of the guide "from a raw force curve to E* and w": what an instrument writes, dirt and all.

A sphere of 5 um on a thick gel, E* = 200 kPa, w = 0.2 mJ/m^2 advancing and 1 mJ/m^2 receding, at a cantilever of
0.3 N/m: offset, tilt, drift, drag, noise, a pause at the turning point; German words, decimal commas, Windows-1252.

    python docs/examples/raw_force_curve.py cases/measured/raw-force-curve.txt
"""

import sys
from pathlib import Path

import numpy as np

R, E_STAR, W_IN, W_OUT, K = 5e-6, 200e3, 0.2e-3, 1e-3, 0.3
ROWS, PAUSE, NOISE, SEED = 900, 120, 0.2e-9, 3


def loads(z: np.ndarray, w: float, first: float) -> np.ndarray:
    """JKR load of a sphere [N] at positions ``z`` [m] of the base; none before ``first`` and the fold."""
    a = np.geomspace(1e-9, 4e-6, 20000)
    log = np.log((R + a) / (R - a))
    delta = a * log / 2 - np.sqrt(2 * np.pi * a * w / E_STAR)
    P = E_STAR * ((R**2 + a**2) / 2 * log - a * R) - np.sqrt(8 * np.pi * w * E_STAR * a**3)
    base = delta + P / K
    fold = int(np.argmin(base))
    return np.where(z >= max(first, base[fold]), np.interp(z, base[fold:], P[fold:]), 0.0)


def main(path: Path) -> None:
    way = np.linspace(-1.2e-6, 0.4e-6, ROWS)
    z = np.concatenate([way, np.full(PAUSE, way[-1]), way[::-1]])
    t = np.arange(z.size) * 2e-3
    inward = loads(way, W_IN, 0.0)
    P = np.concatenate([inward + 0.5e-9, np.full(PAUSE, inward[-1]), loads(way[::-1], W_OUT, -np.inf) - 0.5e-9])
    P += 14e-9 + 8e-4 * z + 2e-10 * t + np.random.default_rng(SEED).normal(0.0, NOISE, z.size)
    head = [
        "Prüfprotokoll Kraft-Weg-Messung",
        "Kugelradius [µm]: 5",
        f"Federkonstante: {K} N/m".replace(".", ","),
        "",
        "Zeit [s];Weg [µm];Kraft [nN]",
    ]
    rows = [f"{a:.3f};{b * 1e6 + 12.5:.5f};{c * 1e9:.4f}".replace(".", ",") for a, b, c in zip(t, z, P, strict=True)]
    path.write_bytes(("\r\n".join([*head, *rows]) + "\r\n").encode("cp1252"))


if __name__ == "__main__":
    target = Path(sys.argv[1] if len(sys.argv) > 1 else "raw-force-curve.txt")
    main(target)
    print(f"written {target}")
