"""Where the assumptions of JKR theory hold: plain functions of SI numbers, so that a stored file can be judged too.

Limits: Johnson and Greenwood, J. Colloid Interface Sci. 192 (1997) 326 (the adhesion map over the Tabor number);
geometrically linear kinematics and the half-space profile need small a/R and delta/h.

A layer needs its own number. The Tabor number compares how far the surface is drawn out at the contact edge with the
range z0 of the forces. On a thin compressible bonded layer that height is sqrt(2 w/K), K of Eq. 22 (Reedy, Thin-coating
contact mechanics with adhesion, J. Mater. Res. (2006), and doi 10.1557/jmr.2007.0329: behaviour is JKR-like for large
w over the coating's modulus and DMT-like for small). For nearly incompressible layers no such number was
found in the literature. On coated half-spaces the transition has been solved with Maugis' forces but not condensed into
one number (Stan and Adams, J. Mater. Res. (2016)); the half-spaces of the two materials bracket it.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..base.errors import InputError
from ..base.unknown import Estimate, Unknown
from ..bodies.indenter import Indenter
from ..bodies.materials import Elastic, contact_modulus
from ..bodies.problem import HalfSpace, Layer, Problem
from ..formulas.half_space import tabor
from ..formulas.thin_layer import foundation_modulus


@dataclass(frozen=True)
class TheoryLimits:
    """The limits of JKR theory, each with its source; a result beyond one is warned of."""

    tabor_jkr: float = 5.0  # theory: Johnson and Greenwood (1997), JKR within some per cent above it
    tabor_dmt: float = 0.1  # theory: the same, rigid-body (DMT, Bradley) limit below it
    a_over_R: float = 0.3  # choice: strains and slopes of order a/R
    delta_over_h: float = 0.1  # choice: strains of a tenth
    a_over_L: float = 0.1  # choice: nearer, the end of a mesh is felt
    nu_compressible: float = 0.45  # theory: Reedy (2006), thin layers agree with finite elements below it
    slack: float = 1e-6  # choice: a ratio that just meets its limit, but for round-off, gives no warning
    seen: int = 2  # theory: points per bend of a tabulated profile, with which slopes fitted through them see it


LIMITS = TheoryLimits()
NO_TIP_RADIUS = Unknown("the indenter has no tip radius (pointed, flat or blunter than a parabola)")
NO_RANGE, NO_ADHESION = Unknown("no equilibrium distance z0 given"), Unknown("no adhesion (w = 0)")


@dataclass(frozen=True)
class Validity:
    """The numbers by which a result is judged; each a number or the reason why there is none.

    ``a_over_R``, ``delta_over_h``, ``a_over_h``, ``a_over_L``: at the largest radius of the series, L being the lateral
    or vertical size at which the body or its mesh ends. ``a_over_R_pull_off``: at pull-off under load control.
    ``end_is_cut``: the specimen goes on where the model ends; the ends of a finite specimen are part of its solution.
    """

    tabor: Estimate
    regime: str
    a_over_R: Estimate
    a_over_R_pull_off: Estimate
    delta_over_h: Estimate
    a_over_h: Estimate
    a_over_L: Estimate
    end_is_cut: bool = True


def end_of_body(problem: Problem, facts: Mapping[str, Any]) -> float | None:
    """Distance [m] at which the body or its mesh ends sideways, or below where that is a cut through a half-space.

    ``facts``: those of the solution; finite elements give width_m and depth_m. None for an unbounded exact solution.
    """
    ends = [problem.specimen.radius, facts.get("width_m")]
    if isinstance(problem.specimen.base, HalfSpace):
        ends.append(facts.get("depth_m"))
    return min((float(end) for end in ends if isinstance(end, int | float) and end > 0), default=None)


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
    end_is_cut: bool = True,
) -> Validity:
    """Judge a series that ends at contact radius ``a`` [m] and displacement ``delta`` [m].

    ``R``: tip radius [m], None where the indenter has none. ``h``: thickness [m] of the layer that the contact feels,
    None or infinite for a half-space. ``L``: size [m] of the body or mesh, None for an unbounded exact solution.
    ``z0``: equilibrium distance of the adhesive forces [m]; ``w`` in J/m^2, ``E_star`` in Pa.
    """
    no_layer = Unknown("no layer: the specimen is a half-space")
    thickness = None if h is None or math.isinf(h) else h
    number = _tabor(R, w, E_star, z0)
    return Validity(
        number,
        _words(number),
        _ratio(a, R, NO_TIP_RADIUS),
        Unknown("no pull-off radius given") if a_pull_off is None else _ratio(a_pull_off, R, NO_TIP_RADIUS),
        _ratio(delta, thickness, no_layer),
        _ratio(a, thickness, no_layer),
        _ratio(a, L, Unknown("the body is unbounded in this method")),
        end_is_cut,
    )


def regime(number: float) -> str:
    """What a Tabor number means, in words, and which model to use instead of JKR."""
    if number > LIMITS.tabor_jkr:
        return "JKR holds"
    if number >= LIMITS.tabor_dmt:
        return "JKR is doubtful: use the Maugis-Dugdale transition model"
    return "JKR does not hold: use DMT (the limit of stiff, small or weakly adhering bodies)"


def layer_tabor(problem: Problem, w: float, z0: float | None) -> dict[str, Estimate | str]:
    """Counterparts of the Tabor number on a layer and what they mean, under names for a summary; empty elsewhere.

    One layer on a rigid base, "tabor_thin_layer": sqrt(2 w/K)/z0 where it is bonded and compressible; to be read where
    a/h is well above 1. Its limits are those of the half-space, as orders of magnitude. Layers on a half-space:
    "tabor_of_coating" and "tabor_of_substrate", the half-spaces of the top and of the lowest material that bracket it.
    """
    specimen = problem.specimen
    if not specimen.layers:
        return {}
    if isinstance(specimen.base, HalfSpace):
        return _coating_tabor(problem, specimen.base, w, z0)
    if len(specimen.layers) > 1:
        return {}
    number = _thin_tabor(specimen.layers[0], specimen.base.bonded, w, z0)
    return {"tabor_thin_layer": number, "regime_thin_layer": _words(number)}


def _coating_tabor(problem: Problem, base: HalfSpace, w: float, z0: float | None) -> dict[str, Estimate | str]:
    R, indenter = problem.indenter.tip_radius, problem.indenter.material
    coating = _tabor(R, w, problem.E_star, z0)
    substrate = _tabor(R, w, contact_modulus(base.material.surface, indenter), z0)
    ends = list(dict.fromkeys([_words(coating), _words(substrate)]))
    words = ends[0] if len(ends) == 1 else f"from the coating's to the substrate's: {ends[0]}; {ends[1]}"
    return {"tabor_of_coating": coating, "tabor_of_substrate": substrate, "regime_coated": words}


def _thin_tabor(layer: Layer, bonded: bool, w: float, z0: float | None) -> Estimate:
    if not bonded:
        return Unknown("the layer slides on its base: the literature has bonded layers only")
    if not isinstance(layer.material, Elastic):
        return Unknown("the layer is not homogeneous and isotropic: the literature has only such layers")
    if layer.material.nu > LIMITS.nu_compressible:
        return Unknown(
            f"nu = {layer.material.nu:g} is above {LIMITS.nu_compressible:g}: the layer is not compressible (Eq. 22)"
        )
    if z0 is None:
        return NO_RANGE
    if w == 0:
        return NO_ADHESION
    if min(w, z0) <= 0:
        raise InputError(f"Tabor number: w and z0 must be > 0, got {w:g} and {z0:g}")
    K = foundation_modulus(layer.material.E, layer.material.nu, layer.thickness)
    return math.sqrt(2 * w / K) / z0


def _words(number: Estimate) -> str:
    return f"unknown: {number}" if isinstance(number, Unknown) else regime(number)


def check(judged: Validity) -> list[str]:
    """Warnings, each with its number and limit; empty where all is well or nothing is known."""
    return [
        *_above(
            judged.a_over_R, LIMITS.a_over_R, "a/R", "the geometrically linear theory and the indenter's profile err"
        ),
        *_above(judged.delta_over_h, LIMITS.delta_over_h, "delta/h", "small strains no longer hold in the layer"),
        *_cut_warning(judged),
        *_tabor_warning(judged),
    ]


def _above(value: Estimate, limit: float, name: str, meaning: str) -> list[str]:
    if isinstance(value, Unknown) or value <= limit * (1 + LIMITS.slack):
        return []
    return [f"{name} = {value:.3g} at the largest contact radius is above {limit:g}: {meaning}"]


def _cut_warning(judged: Validity) -> list[str]:
    if not judged.end_is_cut:
        return []
    return _above(judged.a_over_L, LIMITS.a_over_L, "a/L", "the end of the mesh, where the body goes on, is felt")


def _tabor_warning(judged: Validity) -> list[str]:
    if isinstance(judged.tabor, Unknown) or judged.tabor >= LIMITS.tabor_jkr:
        return []
    return [f"Tabor number {judged.tabor:.3g} is below {LIMITS.tabor_jkr:g}: {judged.regime}"]


def _tabor(R: float | None, w: float, E_star: float, z0: float | None) -> Estimate:
    if R is None:
        return NO_TIP_RADIUS
    if z0 is None:
        return NO_RANGE
    if w == 0:
        return NO_ADHESION
    if min(R, w, E_star, z0) <= 0:
        raise InputError(f"Tabor number: R, w, E* and z0 must be > 0, got {R:g}, {w:g}, {E_star:g}, {z0:g}")
    return tabor(R, w, E_star, z0)


def _ratio(value: float, size: float | None, reason: Unknown) -> Estimate:
    if size is None or math.isinf(size):
        return reason
    if size <= 0:
        raise InputError(f"validity: a size must be > 0 m, got {size:g}")
    return value / size


def unresolved(indenter: Indenter, a: np.ndarray) -> tuple[str, ...]:
    """A warning where slopes fitted through the radii ``a`` [m] cannot see every bend of a tabulated profile."""
    bends = sum(indenter.a0 < kink < a[-1] for kink in indenter.kinks)
    if a.size >= LIMITS.seen * bends:
        return ()
    return (
        f"the {indenter.noun} bends at {bends} radii within the contact and the series has {a.size} points: slopes "
        "fitted through them miss what lies between; give more points, or take a method with exact slopes",
    )
