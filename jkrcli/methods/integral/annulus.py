"""Pressure and surface around a contact with a tension of finite range, from the density of its equation.

    p(r) = (E*/2) [ - int_r^a phi'(t)/sqrt(t^2 - r^2) dt ] - (2 sigma/pi) arccos sqrt((a^2 - r^2)/(c^2 - r^2)),   r < a

and p = -sigma in a < r < c: both parts are continuous at a.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from ...base import Array
from ...bodies import Indenter
from .attraction import Attraction, Discs, Rims, tension_arc
from .density import TUNING, Density, pieces
from .quadrature import to_legendre


@dataclass(frozen=True, eq=False)
class AttractedSurface:
    """Pressure [Pa], compression positive, and gap [m] at the requested radii; ``own``: displacement of a half-space of
    the modulus E* under that pressure [m]."""

    rims: Rims
    pressure: Array
    gap: Array
    own: Array


def attracted_surface(
    attraction: Attraction, a: float, stress: float, length: float, r: Array, scale: float
) -> AttractedSurface:
    """Fields at the radii ``r`` > 0 [m] of a contact of radius ``a`` [m] under a tension ``stress`` [Pa] up to the
    separation ``length`` [m], on a body whose kernel varies over ``scale`` [m]."""
    s = 2 * stress / attraction.E_star
    discs = attraction.discs(np.array([a]))
    rims = discs.equilibria(s, length, attraction.reach)
    c = float(rims.c[0])
    phi = _density(attraction.indenter, discs, rims, s, scale)
    inside, beyond = r < a, r >= a
    ratio = np.clip((a**2 - r[inside] ** 2) / (c**2 - r[inside] ** 2), 0.0, 1.0)
    pressure = np.where(r < c, -stress, 0.0)
    pressure[inside] = attraction.E_star / 2 * phi.pressures(0.0, r[inside])
    pressure[inside] -= 2 * stress / math.pi * np.arccos(np.sqrt(ratio))
    gap = np.zeros_like(r)
    gap[beyond] = discs.separations(rims, s, r[None, beyond])[0]
    own = np.array([phi.arc(0.0, min(a, float(x)), float(x)) for x in r])
    outer = r[beyond]
    own[beyond] -= 2 / math.pi * s * tension_arc(np.full_like(outer, a), np.full_like(outer, c), outer)
    return AttractedSurface(rims, pressure, gap, own)


def _density(indenter: Indenter, discs: Discs, rims: Rims, s: float, scale: float) -> Density:
    """The density up to a, its smooth part on equal pieces."""
    a, order = float(discs.a[0]), TUNING.piece
    edges, x = pieces(a, scale, order)
    smooth = 2 / math.pi * (discs.basis.at(x) @ discs.smooth(rims, s)[0])
    return Density(indenter, a, float(rims.delta[0]), edges, smooth.reshape(-1, order) @ to_legendre(order))
