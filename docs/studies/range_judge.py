"""What a curve of finite range states, against the same bodies on finer panels: columns, and every pull-off point."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from jkrcli.adhesion.curve import CONTROLS, CriticalPoint, position
from jkrcli.adhesion.finite_range import AttractedBody, FiniteRangeBody, FiniteRangeCurve, Range
from jkrcli.base.errors import JkrError
from jkrcli.base.numerics import Array
from jkrcli.bodies.problem import Problem, without_side_walls
from jkrcli.formulas import shift
from jkrcli.methods.integral.finite_range import Attraction
from jkrcli.methods.integral.fredholm import Panels, Quadrature
from jkrcli.methods.layered.contact import LayeredContact
from jkrcli.series import Series

Judged = tuple[str, float, float, bool]  # of a quantity: its name, ratio, stated error and whether it is clear
SMALL = 1e-8  # a true error to which the stated one need not be near
NARROWEST, WIDEST = 1e-3, 10.0  # of the annulus over the contact radius at pull-off, by JKR
ROUNDING = 1e-12  # of the doubled quadrature itself, relative
ACCURACY, NODES_IN_K = 1e-12, 48  # of the panels that are halved; twice those of the main solution
REFINED = (1e-7, 1e-6)  # tolerance of the method hybrid, which is the reference of cylinders, the first that is met
BEYOND = 1.15  # of c, to which the kernel is known
NODES = 9  # of the polynomial through exact states around pull-off
BESIDE = 0.02  # of its contact radius, how far they lie from it


@dataclass(frozen=True, eq=False)
class Finer:
    """The bodies on finer panels, and their relative ``accuracy``."""

    panels: Attraction
    accuracy: float


def work_within(series: Series, share: float | None = None) -> float:
    """The w [J/m^2] whose JKR pull-off under load control lies at the middle radius, or at the row nearest to this
    ``share`` of the largest, less that of a flat end."""
    assert series.S is not None
    assert series.dS is not None
    rate = np.gradient(series.P, series.a) / np.gradient(series.S * shift(1.0, series.a, series.dS), series.a)
    beyond = series.a - series.a0
    row = len(series) // 2 if share is None else int(np.argmin(np.abs(beyond - share * beyond[-1])))
    return float(rate[row] ** 2)


def ranged(problem: Problem, exact: Problem, series: Series, rng: np.random.Generator) -> list[Judged]:
    """P and delta of adhesion of a random finite range on a ``problem``, and at pull-off under load, displacement and a
    spring; ``exact``: with the shape behind a table."""
    w = work_within(series)
    width = 10 ** rng.uniform(math.log10(NARROWEST), math.log10(WIDEST)) * float(series.a[len(series) // 2])
    law = Range.of(w, stress=math.sqrt(math.pi * problem.E_star * w / (4 * width)))
    curve = FiniteRangeBody(problem, series, AttractedBody(problem)).curve(law)
    finer, spring = _finer(exact, curve), float(np.asarray(series.S)[len(series) // 2])
    found = _columns(curve, finer)
    for control, stiffness in {**CONTROLS, "spring": spring}.items():
        found += _point(curve.with_solved_points(stiffness), finer, control, stiffness)
    return [(f"range {name}", ratio, stated, clear) for name, ratio, stated, clear in found]


def _finer(problem: Problem, curve: FiniteRangeCurve) -> Finer:
    """The body on panels half as wide, with twice the nodes in k; a cylinder with a kernel of finer elements."""
    reach = min(BEYOND * float(curve.touching.c.max()), AttractedBody(problem).limit)
    if problem.specimen.radius is None:
        wide = without_side_walls(problem)
        contact = LayeredContact(wide.indenter, wide.specimen)
        panels = contact.attraction(reach, ACCURACY).basis.panels
        half = Quadrature(panels.order, float(np.diff(panels.edges).max()) / 2, 0)
        through = Panels.through(np.array([reach]), half, contact.indenter.a0)
        matrix = replace(contact, order=NODES_IN_K).matrix(through)
        return Finer(Attraction.of(contact.indenter, contact.E_star, through, matrix), ROUNDING)
    from jkrcli.hybrid.kernel import AdaptiveKernel  # a wing, which wide bodies do not need

    for tolerance in REFINED:
        try:
            kernel, errors, *_ = AdaptiveKernel(problem.indenter, problem.specimen, tolerance).accurate(reach)
        except JkrError as error:
            reason = error
            continue
        return Finer(kernel.attraction(reach, ACCURACY), float(errors.total.max()))
    raise reason


def _columns(curve: FiniteRangeCurve, finer: Finer) -> list[Judged]:
    """delta and P at every point, apart and in contact: at the worst."""
    panels, s, gap = finer.panels, 2 * curve.law.stress / curve.problem.E_star, curve.law.length
    held = panels.discs(curve.touching.a).equilibria(s, gap, panels.reach, curve.touching.c)
    without = curve.apart.c[curve.apart.c > 0]
    free = panels.apart(without, s, gap) if without.size else None
    found = []
    for name in ("delta", "P"):
        begin = [getattr(curve.apart, name)[: int(curve.complete)], *([] if free is None else [getattr(free, name)])]
        exact, stated = np.concatenate([*begin, getattr(held, name)]), curve.errors[name]
        unit = float(np.abs(exact).max())
        room = finer.accuracy * np.abs(exact) + ROUNDING * unit
        off = np.abs(getattr(curve, name) - exact)
        error = np.maximum(off - room, 0)
        ratio = np.divide(error, stated, out=np.zeros_like(error), where=error > 0)
        worst = int(np.argmax(ratio))
        clear = off[worst] > max(SMALL * unit, 3 * float(room[worst]))
        found.append((name, float(ratio[worst]), float(stated[worst]) / unit, bool(clear)))
    return found


def _point(curve: FiniteRangeCurve, finer: Finer, control: str, stiffness: float) -> list[Judged]:
    """P and delta where contact is lost, against the stationary state of polynomials through finer ones around it."""
    point = curve.pull_off(stiffness)
    if not isinstance(point, CriticalPoint) or point.a == 0 or kinked(curve, point, 2 * BESIDE):
        return []
    panels, s = finer.panels, 2 * curve.law.stress / curve.problem.E_star
    x = BESIDE * np.cos(np.pi * np.arange(NODES) / (NODES - 1))[::-1]
    near = np.full(NODES, point.c)
    states = panels.discs(point.a * (1 + x)).equilibria(s, curve.law.length, panels.reach, near)
    values = {name: getattr(states, name) for name in ("P", "delta")}
    unsure = {name: finer.accuracy * float(np.abs(column).max()) for name, column in values.items()}
    return stationary(control, stiffness, x, values, unsure, point, curve.point_error(point, stiffness))


def stationary(
    control: str, stiffness: float, x: Array, values: dict[str, Array], unsure: dict[str, float], point: CriticalPoint,
    stated: Any,
) -> list[Judged]:  # fmt: skip
    """The ``stated`` errors of a pull-off ``point`` against the stationary state of polynomials through ``values`` of P
    and delta at the steps ``x``, which may err by ``unsure``; none where it lies beyond them."""
    fits = {name: np.polynomial.Chebyshev.fit(x, column, x.size - 1) for name, column in values.items()}
    held = position(fits["delta"], fits["P"], stiffness)
    roots = held.deriv().roots()
    real = np.real(roots[np.abs(np.imag(roots)) < 1e-6])
    if not real.size or np.min(np.abs(real)) > x[-1]:
        return []
    place = float(real[np.argmin(np.abs(real))])
    move, found = _place_unsure(held, stiffness, unsure, place), []
    for name, fit in fits.items():
        truth, room = float(fit(place)), unsure[name] + abs(float(fit.deriv()(place))) * move
        off = abs(getattr(point, name) - truth)
        clear = off > max(SMALL * abs(truth), 3 * room)
        found.append((f"{control} {name}", max(off - room, 0.0) / stated[name], stated[name] / abs(truth), clear))
    return found


def _place_unsure(held: Any, stiffness: float, unsure: dict[str, float], place: float) -> float:
    """How far the stationary place may lie off by what the exact radii err by: their errors vary over some tenths."""
    by_load = 0.0 if math.isinf(stiffness) else unsure["P"] / (stiffness or 1.0)
    error = by_load if stiffness == 0 else unsure["delta"] + by_load
    bend = abs(float(held.deriv(2)(place)))
    return error / BESIDE / bend if bend > 0 else 0.0


def kinked(curve: FiniteRangeCurve, point: CriticalPoint, near: float) -> bool:
    """Whether a kink lies so ``near``, relative, that no polynomial goes through states around the ``point``."""
    assert point.c is not None
    return any(abs(kink / r - 1) < near for kink in curve.problem.indenter.kinks for r in (point.a, point.c))


def without_table(problem: Problem) -> Problem:
    """The ``problem`` with the shape behind its table, where it has one."""
    shape = getattr(problem.indenter, "shape", None)
    return problem if shape is None else replace(problem, indenter=shape)
