"""The part of g - 1 that decays slowly: a modulus that changes right below the contact.

Below the surface of a layer with shear modulus G(z), gamma = (ln G)', the compliance matrix F in units of the local
1/(k G) obeys, z downwards (the equation behind the ``minors``),

    F' = -k R(F) + gamma F,      R = (1 - 2 F_rz - e F_rr^2, beta + 2 c F_rz - e F_rz^2, c F_rr - F_zz - e F_rr F_rz).

For large k it has the solution F = F_0 + F_1/k + F_2/k^2 + ..., F_0 of the half-space and, order by order,
J F_(n+1) = gamma F_n - F_n' - (products of lower orders) with J = dR/dF at F_0. That gives g - 1 ~ sum c_n/k^n, wrong
only by what the end of the smooth part, in the depth d, sends back: exp(-2 k d). With c_1 = -gamma (1 - nu/2)/(1 - nu)
the kernel of the contact equation has a logarithm at x = t. The sum is taken over in terms that exist for every k >= 0,

    t(k) = sum b_n (k^2 + q^2)^(-n/2),
    int_0^inf t(k) cos(ks) dk = sum b_n sqrt(pi)/Gamma(n/2) (s/2q)^m K_m(qs),   m = (n - 1)/2

(Basset's integral, Abramowitz and Stegun 9.6.25), and the rest of g - 1 decays like k^-(count + 1).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from ...base import Array
from ...bodies import Graded, Solid, Specimen, contact_modulus
from .minors import smooth_parts

COUNT = 6  # terms of the tail; tuned on graded layers, by `make tuning`


@dataclass(frozen=True, eq=False)
class Tail:
    """Slowly decaying part t(k) of g - 1, with ``coefficients`` b_n [m^-n], n = 1, 2, ..., and q = ``rate`` [1/m];
    ``finest``: the length [m] over which the modulus changes below the surface."""

    coefficients: Array
    rate: float
    finest: float

    @classmethod
    def of(cls, specimen: Specimen, indenter: Solid | None = None) -> Tail | None:
        """Tail of g - 1 of ``specimen`` under an ``indenter``; None where g - 1 decays exponentially."""
        material = specimen.layers[0].material if specimen.layers else None
        if not isinstance(material, Graded):
            return None
        c = surface_series(material, COUNT)[1:]
        rate = float(np.max(np.abs(c) ** (1 / np.arange(1, COUNT + 1))))
        if rate * specimen.top_thickness < 1e-12:  # rounding
            return None
        _, smooth = next(smooth_parts(material.law, specimen.top_thickness))
        factor = contact_modulus(specimen.surface, indenter) / specimen.surface.E_star
        return cls(factor * regularised(c, rate), rate, min(smooth, 1 / rate))

    @property
    def strength(self) -> float:
        """|b_1| [1/m], the factor of the kernel's logarithm."""
        return abs(float(self.coefficients[0]))

    def __call__(self, k: Array) -> Array:
        """t(k) [-]."""
        root = 1 / np.sqrt(k**2 + self.rate**2)
        return root * np.polynomial.polynomial.polyval(root, self.coefficients)

    def transform(self, s: Array) -> Array:
        """int_0^inf t(k) cos(ks) dk [1/m] at s > 0 [m]: like -b_1 ln(s) for s -> 0."""
        from scipy.special import k0e, k1e

        x = self.rate * s
        decay = np.exp(-x)
        whole = [k0e(x) * decay, x * k1e(x) * decay]  # x^m K_m(x), m = 0, 1, ...
        half = [math.sqrt(math.pi / 2) * decay, math.sqrt(math.pi / 2) * (1 + x) * decay]  # m = 1/2, 3/2, ...
        total = np.zeros_like(x)
        for n, b in enumerate(self.coefficients, start=1):
            m = (n - 1) / 2
            ladder, step = (whole, (n - 1) // 2) if n % 2 else (half, n // 2 - 1)
            if step == len(ladder):
                ladder.append(x**2 * ladder[-2] + 2 * (m - 1) * ladder[-1])
            total += b * math.sqrt(math.pi) / math.gamma(n / 2) / (2 * self.rate**2) ** m * ladder[step]
        return total


def surface_series(material: Graded, count: int) -> Array:
    """Coefficients c_0 = 1, c_1, ..., c_count [m^-n] of g ~ sum c_n/k^n at the top of a graded layer."""
    nu, size = material.nu, count + 1
    taylor = material.law.taylor(size + 1)
    rates = divided(taylor[1:] * np.arange(1, taylor.size), taylor)  # E'/E
    F = [np.outer((1 - nu, 1 - nu, nu - 0.5), np.eye(1, size)[0])]  # rr, zz, rz as power series in z
    e, J = 2 / (1 - nu), np.array([[-4.0, 0, -2], [0, 0, 2], [1, -1, -2]])
    for n in range(count):
        right = np.array([_product(rates, f) for f in F[n]])
        right[:, :-1] -= F[n][:, 1:] * np.arange(1, size)
        for a, b in zip(F[1:], reversed(F[1:]), strict=True):
            right += e * np.array([_product(a[0], b[0]), _product(a[2], b[2]), _product(a[0], b[2])])
        F.append(np.linalg.solve(J, right))
    return np.array([f[1, 0] for f in F]) / (1 - nu)


def divided(series: Array, divisor: Array) -> Array:
    """Quotient of two power series, as long as the first."""
    quotient = np.zeros_like(series)
    for n in range(series.size):
        quotient[n] = (series[n] - divisor[1 : n + 1] @ quotient[:n][::-1]) / divisor[0]
    return quotient


def _product(a: Array, b: Array) -> Array:
    """Product of two power series, cut at their length."""
    return np.convolve(a, b)[: a.size]


def regularised(c: Array, rate: float) -> Array:
    """Coefficients b with sum b_n (k^2 + q^2)^(-n/2) = sum c_n k^-n up to the last term."""
    b = c.copy()
    for n in range(1, c.size + 1):
        term = 1.0
        for j in range(1, (c.size - n) // 2 + 1):
            term *= -(n / 2 + j - 1) / j * rate**2
            b[n + 2 * j - 1] -= b[n - 1] * term
    return b
