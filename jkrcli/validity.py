"""Where the assumptions of JKR theory hold: plain functions of SI numbers, so that a stored file can be judged too.

Limits: Johnson and Greenwood, J. Colloid Interface Sci. 192 (1997) 326 (the adhesion map over the Tabor number);
geometrically linear kinematics and the half-space profile need small a/R and delta/h.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from .closed_form import tabor
from .errors import InputError

TABOR_JKR = 5.0  # JKR within some per cent above it
TABOR_DMT = 0.1  # rigid-body (DMT, Bradley) limit below it
MAX_A_OVER_R = 0.3
MAX_DELTA_OVER_H = 0.1
MAX_A_OVER_L = 0.1
Ratio = float | str  # a number, or why there is none
NO_TIP_RADIUS = "the indenter has no tip radius (pointed, flat or blunter than a parabola)"


@dataclass(frozen=True)
class Validity:
    """The numbers by which a result is judged; each a number or the reason why there is none.

    ``a_over_R``, ``delta_over_h``, ``a_over_h``, ``a_over_L``: at the largest radius of the series, L being the lateral
    or vertical size at which the body or its mesh ends. ``a_over_R_pull_off``: at pull-off under load control.
    """

    tabor: Ratio
    regime: str
    a_over_R: Ratio
    a_over_R_pull_off: Ratio
    delta_over_h: Ratio
    a_over_h: Ratio
    a_over_L: Ratio


def judge(
    *,
    a: float,
    delta: float,
    E_star: float,
    w: float,
    R: float | None,
    h: float | None,
    L: float | None,
    z0: float | None,
    a_pull_off: float | None = None,
) -> Validity:
    """Judge a series that ends at contact radius ``a`` [m] and displacement ``delta`` [m].

    ``R``: tip radius [m], None where the indenter has none. ``h``: thickness [m] of the layer that the contact feels,
    None or infinite for a half-space. ``L``: size [m] of the body or mesh, None for an unbounded exact solution.
    ``z0``: equilibrium distance of the adhesive forces [m]; ``w`` in J/m^2, ``E_star`` in Pa.
    """
    no_layer = "no layer: the specimen is a half-space"
    thickness = None if h is None or math.isinf(h) else h
    number = _tabor(R, w, E_star, z0)
    return Validity(
        number,
        regime(number) if isinstance(number, float) else f"unknown: {number}",
        _ratio(a, R, NO_TIP_RADIUS),
        "no pull-off radius given" if a_pull_off is None else _ratio(a_pull_off, R, NO_TIP_RADIUS),
        _ratio(delta, thickness, no_layer),
        _ratio(a, thickness, no_layer),
        _ratio(a, L, "the body is unbounded in this method"),
    )


def regime(number: float) -> str:
    """What a Tabor number means, in words, and which model to use instead of JKR."""
    if number > TABOR_JKR:
        return "JKR holds"
    if number >= TABOR_DMT:
        return "JKR is doubtful: use the Maugis-Dugdale transition model"
    return "JKR does not hold: use DMT (the limit of stiff, small or weakly adhering bodies)"


def check(judged: Validity) -> list[str]:
    """Warnings, each with its number and limit; empty where all is well or nothing is known."""
    return [
        *_above(judged.a_over_R, MAX_A_OVER_R, "a/R", "the geometrically linear theory and the indenter's profile err"),
        *_above(judged.delta_over_h, MAX_DELTA_OVER_H, "delta/h", "small strains no longer hold in the layer"),
        *_above(judged.a_over_L, MAX_A_OVER_L, "a/L", "the end of the body or mesh is felt at the contact"),
        *_tabor_warning(judged),
    ]


def _above(value: Ratio, limit: float, name: str, meaning: str) -> list[str]:
    if isinstance(value, str) or value <= limit:
        return []
    return [f"{name} = {value:.3g} at the largest contact radius is above {limit:g}: {meaning}"]


def _tabor_warning(judged: Validity) -> list[str]:
    if isinstance(judged.tabor, str) or judged.tabor >= TABOR_JKR:
        return []
    return [f"Tabor number {judged.tabor:.3g} is below {TABOR_JKR:g}: {judged.regime}"]


def _tabor(R: float | None, w: float, E_star: float, z0: float | None) -> Ratio:
    if R is None:
        return NO_TIP_RADIUS
    if z0 is None:
        return "no equilibrium distance z0 given"
    if w == 0:
        return "no adhesion (w = 0)"
    if min(R, w, E_star, z0) <= 0:
        raise InputError(f"Tabor number: R, w, E* and z0 must be > 0, got {R:g}, {w:g}, {E_star:g}, {z0:g}")
    return tabor(R, w, E_star, z0)


def _ratio(value: float, size: float | None, reason: str) -> Ratio:
    if size is None or math.isinf(size):
        return reason
    if size <= 0:
        raise InputError(f"validity: a size must be > 0 m, got {size:g}")
    return value / size
