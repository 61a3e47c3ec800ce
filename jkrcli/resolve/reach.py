"""How far a body has to be solved for its pull-off, with a work of adhesion or a measured force."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..adhesion.curve import LOAD_CONTROL, AdhesiveCurve
from ..adhesion.work_of_pull_off import work_from_pull_off
from ..base.errors import Estimate, InputError, JkrError, Unknown
from ..base.numerics import ROWS, Array
from ..bodies.indenters import Indenter
from ..bodies.problem import Loading, Problem
from ..formulas import adhesive_half_space
from ..methods.layered.solver import Layered
from ..methods.radii import ROOM
from ..series import Solution
from .analysis import nonadhesive
from .neglected import LEFT_OUT_ACCURACY
from .resolve import resolve_with

# Radii at which a half-space is looked at, and those of a body whose w is known.
REACH_RADII = (1e-13, 1e3)  # choice: [m], from below atoms to beyond every body

REACH_INSIDE = 0.99  # choice: of the radius at which the indenter ends
REACH_FURTHER = 3.0  # choice: times the thickness of layers, then the radius of the contact before: the next one's
REACH_OF_DEVICES = 1e3  # choice: w of a force under displacement control over that under load control; a cone's: 3


def solved_for(problem: Problem, works: Sequence[float], slopes: str = "auto", modulus_factor: float = 1.0) -> Solution:
    """The ``problem``, whatever its loading, solved as far as its pull-off asks with any of the ``works`` [J/m^2]
    > 0: to little more than the largest contact radius without load; coarsely where thin layers leave no more."""
    w, largest = max(works), 0.0
    for wider in _wider(problem, w, modulus_factor):
        body = nonadhesive(wider, slopes).scaled(modulus_factor)
        P = AdhesiveCurve(body, w).P
        largest = float(body.a[P <= 0].max(initial=body.a[0]))
        if P[-1] > 0:
            break
    try:
        return resolve_with(_to(problem, largest))
    except JkrError:
        return resolve_with(_to(problem, largest), method=Layered(LEFT_OUT_ACCURACY))


def solved_for_force(
    problem: Problem, load: float, stiffnesses: Sequence[float], slopes: str = "auto", modulus_factor: float = 1.0
) -> Solution:
    """The same for the pull-off force ``load`` [N, > 0] measured by devices of the ``stiffnesses`` [N/m] (default: load
    control), whose w is sought on series that reach farther and farther."""
    w = work_on_half_space(problem.indenter, modulus_factor * problem.E_star, load)
    for wider in _wider(problem, w * REACH_OF_DEVICES if stiffnesses else w, modulus_factor):
        body = nonadhesive(wider, slopes).scaled(modulus_factor)
        try:
            works = [work_from_pull_off(body, load, stiffness).w for stiffness in stiffnesses or (LOAD_CONTROL,)]
        except InputError as error:  # the force may lie beyond this series
            failed = error
        else:
            return solved_for(problem, works, slopes, modulus_factor)
    raise failed


def work_on_half_space(indenter: Indenter, E_star: float, load: float) -> float:
    """The w [J/m^2] of which a half-space lets go at the pull-off force ``load`` [N, > 0] under load control: over all
    radii the least w = (P_H + load)^2/(8 pi E* a^3) that holds it."""
    a, _, P_H = half_space_radii(indenter, E_star)
    return float(np.min((P_H + load) ** 2 / (8 * math.pi * E_star * a**3)))


def _wider(problem: Problem, w: float, modulus_factor: float) -> Iterator[Solution]:
    """The problem solved to wider and wider contacts, coarsely, at last to the radius that a half-space of its softest
    material keeps without load: adhesion holds a smaller one on anything stiffer, far smaller on thin layers."""
    below = [layer.material for layer in problem.specimen.layers], getattr(problem.specimen.base, "material", None)
    softest = min(problem.E_star, *(getattr(one, "E_star", math.inf) for one in (*below[0], below[1])))
    E_star = modulus_factor * softest
    a, delta_H, P_H = half_space_radii(problem.indenter, E_star)
    _, P = adhesive_half_space(a, delta_H, P_H, E_star, w)
    widest = min(float(a[P <= 0].max(initial=a[0])), problem.indenter.rim)
    layers = problem.layers
    grows = layers and problem.indenter.rim == math.inf
    reach = min(REACH_FURTHER * sum(layer.thickness for layer in layers), widest) if grows else widest
    while True:
        far = _to(problem, reach)
        yield resolve_with(far, method=Layered(LEFT_OUT_ACCURACY)) if layers else resolve_with(far)
        if reach == widest:
            return
        reach = min(REACH_FURTHER * reach, widest)


def _to(problem: Problem, a: float) -> Problem:
    """The problem to little more than the contact radius ``a`` [m], by rows that crowd towards first touch."""
    end = min(ROOM * a, REACH_INSIDE * problem.indenter.r_max, problem.indenter.rim)
    return replace(problem, loading=Loading("radius", end, ROWS, "log"))


def half_space_radii(indenter: Indenter, E_star: float) -> tuple[Array, Array, Array]:
    """Contact radii from atoms to the end of the indenter [m], ``ROWS`` per decade, with delta_H [m] and P_H [N] on a
    half-space."""
    least, most = REACH_RADII
    end = min(most, REACH_INSIDE * indenter.r_max, indenter.rim)
    a = indenter.a0 + np.geomspace(least, end - indenter.a0, round(ROWS * math.log10(most / least)))
    columns = indenter.half_space(a, E_star)
    if columns is None:
        raise InputError(f"{indenter.words} has no closed form on a half-space: describe the bodies in a case file")
    return a, *columns


@dataclass(frozen=True)
class Rough:
    """``E_star`` [Pa] by the formula without adhesion at the largest load, its contact radius ``a`` [m], and ``w``
    [J/m^2] by the pull-off force of JKR with that modulus: of a half-space, without an error."""

    E_star: float
    a: float
    w: Estimate


def rough(tip: Indenter, load: float, depth: float, adhesion: Estimate) -> Rough | Unknown:
    """A glance at the ``load`` [N] that holds the ``tip`` at a ``depth`` [m], and at the force of ``adhesion`` [N]."""
    if not (load > 0 and depth > 0):
        return Unknown("the largest load or its depth is not positive")
    a, delta, P = half_space_radii(tip, 1.0)
    if not delta[0] < depth < delta[-1]:
        return Unknown("the depth lies beyond the indenter")
    radius, unit = (float(np.exp(np.interp(np.log(depth), np.log(delta), np.log(column)))) for column in (a, P))
    E_star = load / unit
    w = adhesion if isinstance(adhesion, Unknown) else work_on_half_space(tip, E_star, adhesion)
    return Rough(E_star, radius, w)
