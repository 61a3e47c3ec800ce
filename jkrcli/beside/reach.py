"""How far a body has to be solved so that its pull-off lies in the series: to where adhesion holds it without load."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..adhesion import LOAD_CONTROL, AdhesiveCurve
from ..adhesion.stability_inverse import work_from_pull_off
from ..base import Array, InputError
from ..bodies import Indenter, Loading, Problem
from ..formulas.half_space import adhesive_half_space
from ..series import Solution
from .again import again
from .analysis import nonadhesive
from .expectation import COARSE


@dataclass(frozen=True)
class ReachTuning:
    """Radii at which a half-space is looked at, and those of a body whose w is known."""

    least: float = 1e-13  # choice: [m], below atoms
    most: float = 1e3  # choice: [m], beyond every body
    looked_at: int = 3200  # choice: of these radii, 200 per decade
    inside: float = 0.99  # choice: of the radius at which the indenter ends
    margin: float = 1.05  # choice: over the radius without load, so that it lies within
    points: int = 200  # choice: rows; pull-off points are solved at their own radii
    of_devices: float = 1e3  # choice: w of a force under displacement control over that under load control; a cone's: 3


TUNING = ReachTuning()


def solved_for(problem: Problem, works: Sequence[float], slopes: str = "auto", modulus_factor: float = 1.0) -> Solution:
    """The ``problem``, whatever its loading, solved as far as its pull-off asks with any of the ``works`` [J/m^2]
    > 0: to little more than the largest contact radius without load."""
    w = max(works)
    first = _reaching(problem, w, modulus_factor)
    body = nonadhesive(first, slopes).scaled(modulus_factor)
    held = np.flatnonzero(AdhesiveCurve(body, w).P <= 0)
    return again(_to(problem, float(body.a[held[-1]] if held.size else body.a[-1])))


def solved_for_force(
    problem: Problem, load: float, stiffnesses: Sequence[float], slopes: str = "auto", modulus_factor: float = 1.0
) -> Solution:
    """The same for the pull-off force ``load`` [N, > 0] measured by devices of the ``stiffnesses`` [N/m] (default: load
    control), whose w is looked for on a series that reaches far."""
    w = work_on_half_space(problem.indenter, modulus_factor * problem.E_star, load)
    wide = _reaching(problem, w * TUNING.of_devices if stiffnesses else w, modulus_factor)
    body = nonadhesive(wide, slopes).scaled(modulus_factor)
    found = [work_from_pull_off(body, load, stiffness).w for stiffness in stiffnesses or (LOAD_CONTROL,)]
    return solved_for(problem, found, slopes, modulus_factor)


def work_on_half_space(indenter: Indenter, E_star: float, load: float) -> float:
    """The w [J/m^2] of which a half-space lets go at the pull-off force ``load`` [N, > 0] under load control: over all
    radii the least w = (P_H + load)^2/(8 pi E* a^3) that holds it."""
    a, _, P_H = half_space_radii(indenter, E_star)
    return float(np.min((P_H + load) ** 2 / (8 * math.pi * E_star * a**3)))


def _reaching(problem: Problem, w: float, modulus_factor: float) -> Solution:
    """The problem solved to the contact radius that its half-space keeps without load: on a layer over a rigid base,
    which is stiffer, adhesion holds a smaller one."""
    E_star = modulus_factor * problem.E_star
    a, delta_H, P_H = half_space_radii(problem.indenter, E_star)
    _, P = adhesive_half_space(a, delta_H, P_H, E_star, w)
    far = _to(problem, float(a[P <= 0].max(initial=a[0])))
    return again(far) if problem.specimen.is_half_space else again(far, method=COARSE)


def _to(problem: Problem, a: float) -> Problem:
    """The problem to little more than the contact radius ``a`` [m], by rows that crowd towards first touch."""
    end = min(TUNING.margin * a, TUNING.inside * problem.indenter.r_max)
    return replace(problem, loading=Loading("radius", end, TUNING.points, "log"))


def half_space_radii(indenter: Indenter, E_star: float) -> tuple[Array, Array, Array]:
    """Contact radii from atoms to the end of the indenter [m], with delta_H [m] and P_H [N] on a half-space."""
    end = min(TUNING.most, TUNING.inside * indenter.r_max)
    a = indenter.a0 + np.geomspace(TUNING.least, end - indenter.a0, TUNING.looked_at)
    found = indenter.half_space(a, E_star)
    if found is None:
        raise InputError(f"{indenter.words} has no closed form on a half-space: describe the bodies in a case file")
    return a, *found
