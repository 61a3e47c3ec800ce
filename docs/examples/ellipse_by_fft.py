"""Nonadhesive contact of a rigid tip x^2/2R1 + y^2/2R2 with a half-space or a bonded layer, on a grid by FFT: load,
displacement and contact area, for `jkr import --contact-shape`.

    python docs/examples/ellipse_by_fft.py ellipse.csv
    python docs/examples/ellipse_by_fft.py cylinders.csv --R1 20e-6 --R2 8e-6 --thickness 2e-6 --nu 0.45
"""

import argparse

import numpy as np
from scipy.fft import irfft2, rfft2

options = argparse.ArgumentParser()
options.add_argument("table", nargs="?", default="ellipse.csv")
defaults = {"R1": 20e-6, "R2": 5e-6, "E": 1e6, "nu": 0.5, "thickness": np.inf, "depth": 0.6e-6}
for name, value in {**defaults, "points": 128, "rows": 30}.items():
    options.add_argument(f"--{name}", type=type(value), default=value)
given = options.parse_args()
E_star, n, h = given.E / (1 - given.nu**2), given.points, given.thickness

# The grid holds the contact at full depth, padded with zeros to twice its size
half = 1.15 * np.sqrt(2 * np.array([given.R1, given.R2]) * given.depth)  # more than the contact's half-axes
dx, dy = 2 * half / n
x, y = (np.arange(n) + 0.5) * dx - half[0], (np.arange(n) + 0.5) * dy - half[1]
f = x[:, None] ** 2 / (2 * given.R1) + y[None, :] ** 2 / (2 * given.R2)

if np.isinf(h):  # the displacement by a pressure 1 on one cell (Love 1929)
    X = (np.fft.fftfreq(2 * n) * 2 * n * dx)[:, None]
    Y = (np.fft.fftfreq(2 * n) * 2 * n * dy)[None, :]

    def corner(a, b):
        return a * np.arcsinh(b / np.abs(a)) + b * np.arcsinh(a / np.abs(b))

    ends = [(X + s * dx / 2, Y + t * dy / 2, s * t) for s in (1, -1) for t in (1, -1)]
    kernel = rfft2(sum(sign * corner(a, b) for a, b, sign in ends) / (np.pi * E_star))
else:  # 2 g/(E* k) of a bonded layer
    k = np.hypot(2 * np.pi * np.fft.fftfreq(2 * n, dx)[:, None], 2 * np.pi * np.fft.rfftfreq(2 * n, dy)[None, :])
    k[0, 0] = 1e-6 / h
    z, kappa = np.minimum(k * h, 300.0), 3 - 4 * given.nu
    g = (2 * kappa * np.sinh(2 * z) - 4 * z) / (2 * kappa * np.cosh(2 * z) + 1 + kappa**2 + 4 * z**2)
    kernel = 2 * g / (E_star * k)


def displaced(p):
    return irfft2(kernel * rfft2(p, (2 * n, 2 * n)), (2 * n, 2 * n))[:n, :n]


def cells_inside(p):
    """Cells within the edge, line by line: p^2 falls to 0 linearly there, between cells."""
    total = 0.0
    for line in p**2:
        touching = np.flatnonzero(line)
        total += touching.size
        if touching.size > 2:
            first, last = touching[[0, -1]]
            ends = line[first] / (line[first + 1] - line[first]), line[last] / (line[last - 1] - line[last])
            total += np.clip(ends, 0.0, 1.5).sum() - 1
    return total


rows, p = [], np.zeros((n, n))
for delta in given.depth * np.linspace(0.1, 1, given.rows):
    p[f < delta] += 1e-9 * E_star
    t, last, fresh = np.zeros_like(p), 1.0, True
    for _ in range(2000):  # conjugate gradients on the cells in contact (Polonsky and Keer 1999)
        gap = displaced(p) + f - delta
        inside = p > 0
        size = np.sum(gap[inside] ** 2)
        t = np.where(inside, gap + (0.0 if fresh else size / last) * t, 0.0)
        r = displaced(t)
        step = np.sum(gap[inside] * t[inside]) / np.sum(r[inside] * t[inside])
        p = np.maximum(p - step * t, 0.0)
        back = (p == 0) & (gap < 0)  # cells that overlap come into contact
        p[back] -= step * gap[back]
        last, fresh = size, bool(back.any())
        if not fresh and np.sqrt(size / inside.sum()) < 1e-7 * delta:
            break
    area = (cells_inside(p) + cells_inside(p.T)) / 2 * dx * dy
    rows.append((delta, p.sum() * dx * dy, area))

np.savetxt(given.table, rows, fmt="%.9g", delimiter=",", header="delta_m,P_N,area_m2", comments="")
print(f"{given.table}: load and area of contact at {len(rows)} depths to {given.depth:g} m")
