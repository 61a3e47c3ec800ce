"""Adhesive contact of an elliptic paraboloid x^2/2R1 + y^2/2R2 with a half-space of E* = 1, by pressures (c0 + c1 x^2 +
c2 y^2)/sqrt(1 - rho^2) on ellipses of half-axes a, b: nonadhesive (Hertz), and the minimum of the energy over all
ellipses (Giudici, Vella and Griffiths, arXiv 2407.00378)."""

import math
from functools import cache

import numpy as np
from scipy.optimize import brentq, fsolve, minimize_scalar

Array = np.ndarray
ANGLES = np.linspace(0, np.pi, 400, endpoint=False) + 1e-3


def displacements(a: float, b: float) -> Array:
    """Coefficients of (1, x^2, y^2) of the displacement, a row each, by the pressures with c0, c1, c2 = 1.

    Along a chord in the direction t the density is a polynomial over sqrt(1 - s^2): u = (1/pi) int int p ds dt.
    """
    c, s = np.cos(ANGLES), np.sin(ANGLES)
    A = c**2 / a**2 + s**2 / b**2
    weight = np.pi / ANGLES.size / np.sqrt(A)
    spread_x, spread_y = -1 / a**2 / A + c**2 / a**4 / A**2, -1 / b**2 / A + s**2 / b**4 / A**2
    of_x = [c**2 / (2 * A), (1 - c**2 / (a**2 * A)) ** 2 + c**2 / 2 * spread_x,
            (c * s / (b**2 * A)) ** 2 + c**2 / 2 * spread_y]  # fmt: skip
    of_y = [s**2 / (2 * A), (c * s / (a**2 * A)) ** 2 + s**2 / 2 * spread_x,
            (1 - s**2 / (b**2 * A)) ** 2 + s**2 / 2 * spread_y]  # fmt: skip
    columns = [[np.ones_like(A), 0 * A, 0 * A], of_x, of_y]
    return np.array([[np.sum(weight * entry) for entry in column] for column in columns]).T


def pressures(a: float, b: float, R1: float, R2: float) -> tuple[Array, Array]:
    """c of a rigid displacement 1, and of the profile alone: c = delta c_1 - c_f."""
    M = displacements(a, b)
    return np.linalg.solve(M, [1.0, 0, 0]), np.linalg.solve(M, [0.0, 1 / (2 * R1), 1 / (2 * R2)])


def load(c: Array, a: float, b: float) -> float:
    return float(2 * math.pi * a * b * (c[0] + c[1] * a**2 / 3 + c[2] * b**2 / 3))


@cache
def hertz_ratio(k: float) -> float:
    """b/a of the nonadhesive contact for R1/R2 = k."""

    def edge(ratio: float) -> float:
        """A rim without tension asks for c ~ 1 - rho^2: c1 a^2 = c2 b^2."""
        one, f = pressures(1.0, ratio, k, 1.0)
        delta = (f[0] + f[1]) / (one[0] + one[1])
        c = delta * one - f
        return float(c[0] + c[2] * ratio**2)

    return float(brentq(edge, 1e-3, 1.0, xtol=1e-14)) if k > 1 else 1.0


def hertz(k: float, areas: Array) -> tuple[Array, Array]:
    """Displacement and load of the nonadhesive contact at contact ``areas``, with sqrt(R1 R2) = 1."""
    R1, R2, ratio, found = math.sqrt(k), 1 / math.sqrt(k), hertz_ratio(k), []
    for area in areas:
        a = math.sqrt(area / (math.pi * ratio))
        one, f = pressures(a, a * ratio, R1, R2)
        delta = (f[0] + f[1] * a**2) / (one[0] + one[1] * a**2)
        found.append((delta, load(delta * one - f, a, a * ratio)))
    delta, P = np.transpose(found)
    return delta, P


PHI = np.linspace(0, 2 * np.pi, 400, endpoint=False)


def equilibrium(size: float, k: float, w: float, start: Array) -> tuple[float, float, Array]:
    """Displacement and load where the energy is stationary over both half-axes, of sqrt(a b) = ``size``: int (G - w)
    cos^2 = int (G - w) sin^2 = 0 around the edge, G = pi q^2/(2 g), q the pressure's factor, g = |grad rho|."""

    def out(x: Array) -> Array:
        delta, ratio = x[0], math.exp(x[1])
        a, b = size / math.sqrt(ratio), size * math.sqrt(ratio)
        one, f = pressures(a, b, math.sqrt(k), 1 / math.sqrt(k))
        c = delta * one - f
        cos, sin = np.cos(PHI), np.sin(PHI)
        q = c[0] + c[1] * (a * cos) ** 2 + c[2] * (b * sin) ** 2
        G = math.pi * q**2 / (2 * np.sqrt((cos / a) ** 2 + (sin / b) ** 2))
        return np.array([np.mean((G / w - 1) * cos**2), np.mean((G / w - 1) * sin**2)])

    x, _, ok, words = fsolve(out, start, xtol=1e-13, full_output=True)
    assert ok == 1 or np.abs(out(x)).max() < 1e-10, words
    ratio = math.exp(x[1])
    a, b = size / math.sqrt(ratio), size * math.sqrt(ratio)
    one, f = pressures(a, b, math.sqrt(k), 1 / math.sqrt(k))
    return float(x[0]), load(x[0] * one - f, a, b), x


def pull_off(k: float, w: float = 1.0) -> tuple[float, float]:
    """-P/(pi w sqrt(R1 R2)) where contact is lost under load and under displacement control, by the energy."""
    unit = w ** (1 / 3)
    sizes = unit * np.geomspace(2.2, 0.55, 60)
    x = np.array([(sizes[0] ** 2 - math.sqrt(2 * math.pi * w * sizes[0])) * 0.98, math.log(hertz_ratio(k))])
    rows = []
    for size in sizes:
        delta, P, x = equilibrium(size, k, w, x)
        rows.append((size, delta, P, x))

    def least(column: int) -> float:
        i = int(np.argmin([row[column] for row in rows]))
        ends = sorted((rows[i - 1][0], rows[i + 1][0]))
        at = minimize_scalar(lambda s: equilibrium(s, k, w, rows[i][3])[column - 1], bounds=ends, method="bounded",
                             options={"xatol": 1e-9 * unit}).x  # fmt: skip
        return -equilibrium(float(at), k, w, rows[i][3])[1] / (math.pi * w)

    return least(2), least(1)


def restricted(k: float) -> tuple[float, float]:
    """The same among the ellipses of the nonadhesive contact alone (Eq. 13 with a = sqrt(A/pi)): delta_H = d a^2, P_H =
    p a^3 are those of a half-space of another E* under a paraboloid of R = 1/d, so that both forces are JKR's."""
    (d,), _ = hertz(k, np.array([math.pi]))
    return float(1.5 / d), float(5 / 6 / d)
