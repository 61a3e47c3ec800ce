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


def branch(w: float) -> tuple[np.ndarray, ...]:
    """Positions of the base [m] that a moving edge holds with a stable contact, its load [N], and radii [m]."""
    a = np.geomspace(1e-9, 4e-6, 20000)
    log = np.log((R + a) / (R - a))
    delta = a * log / 2 - np.sqrt(2 * np.pi * a * w / E_STAR)
    P = E_STAR * ((R**2 + a**2) / 2 * log - a * R) - np.sqrt(8 * np.pi * w * E_STAR * a**3)
    base = delta + P / K
    stable = slice(int(np.argmin(base)), None)
    return base[stable], P[stable], a[stable]


def into(z: np.ndarray) -> np.ndarray:
    """Load of a sphere [N] at positions ``z`` [m] of the base on the way in."""
    base, P, _ = branch(W_IN)
    return np.where(z >= 0, np.interp(z, base, P), 0.0)


def back(z: np.ndarray) -> np.ndarray:
    """The same on the way out: from the turning point on the edge rests, the contact is as stiff as a punch of its
    radius; it recedes once that load has fallen to the one that a receding edge holds."""
    base, P, a = branch(W_IN)
    turn, a_turn = z.max(), np.interp(z.max(), base, a)
    punch = 2 * E_STAR * a_turn
    resting = np.interp(turn, base, P) + punch / (1 + punch / K) * (z - turn)
    base, P, a = branch(W_OUT)
    ends = np.interp(a_turn, a, base)
    return np.where(z >= base[0], np.where(z > ends, resting, np.interp(z, base, P)), 0.0)


def main(path: Path) -> None:
    way = np.linspace(-1.2e-6, 0.4e-6, ROWS)
    z = np.concatenate([way, np.full(PAUSE, way[-1]), way[::-1]])
    t = np.arange(z.size) * 2e-3
    inward = into(way)
    P = np.concatenate([inward + 0.5e-9, np.full(PAUSE, inward[-1]), back(way[::-1]) - 0.5e-9])
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
