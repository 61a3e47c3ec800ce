"""Regular Coulomb waves of order zero, which take the place of sine and cosine where the edge of a contact oscillates.

F(eta, rho) obeys F'' = (2 eta/rho - 1) F, F(0) = 0, F'(0) = C, C^2 = 2 pi eta/(exp(2 pi eta) - 1) (Abramowitz and
Stegun 14.1). F(0, rho) = sin rho. Power series at the origin, Taylor series from step to step beyond it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.polynomial import polynomial

from ...base import Array


@dataclass(frozen=True)
class CoulombTuning:
    """Series of the waves."""

    first: float = 4.0  # rho up to which the series at the origin is summed; theory: its terms stay below exp(4)
    first_terms: int = 40  # theory: 4^40/40! is below rounding
    terms: int = 18  # of each centre beyond, 1 from the next; theory: 1/18! is below rounding


TUNING = CoulombTuning()


def amplitude(eta: float) -> float:
    """C = F'(eta, 0)."""
    return math.sqrt(2 * math.pi * eta / math.expm1(2 * math.pi * eta)) if eta else 1.0


def coulomb_waves(eta: float, rho: Array) -> tuple[Array, Array]:
    """F(eta, rho) and F'(eta, rho) for rho >= 0; |eta| < 1/2. Absolute error about 1e-14 per hundred rho."""
    if eta == 0:
        return np.sin(rho), np.cos(rho)
    F, slope = np.empty_like(rho), np.empty_like(rho)
    near = rho < TUNING.first
    series = coulomb_series(eta)
    F[near] = polynomial.polyval(rho[near], series)
    slope[near] = polynomial.polyval(rho[near], polynomial.polyder(series))
    if not near.all():
        centres, table = _table(eta, float(rho.max()), series)
        row = np.rint(rho[~near] - centres[0]).astype(int)
        ahead = rho[~near] - centres[row]
        F[~near], slope[~near] = (_horner(terms, row, ahead) for terms in (table, polynomial.polyder(table)))
    return F, slope


def _horner(table: Array, row: Array, ahead: Array) -> Array:
    """Sum of table[m, row] ahead^m."""
    total = table[-1][row]
    for terms in table[-2::-1]:
        total *= ahead
        total += terms[row]
    return total


def coulomb_series(eta: float) -> Array:
    """Coefficients of F at the origin."""
    c = [0.0, amplitude(eta)]
    for m in range(2, TUNING.first_terms):
        c.append((2 * eta * c[m - 1] - c[m - 2]) / (m * (m - 1)))
    return np.array(c)


def _table(eta: float, largest: float, series: Array) -> tuple[Array, Array]:
    """Centres rho_i and the Taylor coefficients (terms, i) of F about each."""
    centres = TUNING.first + np.arange(math.ceil(largest - TUNING.first) + 1)
    start = [float(polynomial.polyval(centres[0], s)) for s in (series, polynomial.polyder(series))]
    rows = [_taylor(eta, float(centres[0]), *start)]
    for centre in centres[1:]:
        F, slope = rows[-1].sum(), rows[-1] @ np.arange(rows[-1].size)
        rows.append(_taylor(eta, float(centre), float(F), float(slope)))
    return centres, np.array(rows).T


def _taylor(eta: float, rho: float, F: float, slope: float) -> Array:
    """Taylor coefficients of F about ``rho``, from (rho + d) F'' = (2 eta - rho - d) F."""
    t = [F, slope]
    for m in range(2, TUNING.terms + 1):
        before = t[m - 3] if m > 2 else 0.0
        t.append(((2 * eta - rho) * t[m - 2] - before - (m - 1) * (m - 2) * t[m - 1]) / (rho * m * (m - 1)))
    return np.array(t)
