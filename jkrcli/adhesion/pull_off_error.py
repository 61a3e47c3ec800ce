"""The error of a critical point: that of the curve at its radius, and that of the place where the curve is stationary.

At fixed radius a the curve errs by d(delta), dP. The stationary point of F(a) = d(delta)/da + (dP/da)/k moves by
-dF/F'(a), and takes along what varies there: P under displacement control, delta under load control. F holds the rates
d(delta_H)/da and S'', so that their errors count too (``Slopes.joint``).

Of finite elements larger ones tell what they change of the curve around the point. Curves are fitted alike and compared
at equal nonadhesive displacement: radii of meshes err by more than their loads, and a wrong radius that nothing is read
at does no harm. d(x), x = log(a - a0), is how far the device's position lies off: it moves the value by d and the place
by -d'/x'', x'' being the bend of the position, and along with the place what varies there. At one place d passes
through zero by accident, and so it does all over where two meshes err alike: it is averaged, squared, around the place,
and with what the doubling before it changed, which second order makes the square of the ratio as large. Elements err in
proportion to what they compute, and a load grows severalfold within the radii of the average: d counts there over the
two parts of Eq. 13.

That is so of elements in proportion to the radius, alike at every place. Elements of one size err as the square of what
part of the radius they are: what they change at smaller radii is no measure of larger ones, and the points lost by the
larger elements themselves, at this work of adhesion and those nearby, tell the error. First order leaves all of what
doubling changes, second order a third.
"""

import math
from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import lru_cache

import numpy as np

from ..base.errors import InputError, Unknown
from ..base.numerics import ROUNDED, SAME, TINY, Array
from ..bodies.indenters import Indenter
from .curve import (
    CURVE_ORDER,
    CURVE_WIDEST,
    LOAD_CONTROL,
    NO_ADHESION,
    AdhesiveCurve,
    CriticalPoint,
    Equilibrium,
    Nonadhesive,
    position,
    transform,
)
from .rules import slopes_function

# Where curves are compared, and what is concluded.
# of what doubling changes, over (ratio - 1), at the end of the series: of values, and of places; tuned on random
# bodies, by `make bounds` and `make point-bounds`
COARSER_LEFT = (2.75, 2.25)
# Powers of a - a0 over that at the end, with which it falls towards first contact, where larger elements have few
# nodes: of values, and of places
COARSER_POWERS = (0.45, 0.3)  # tuned on random bodies, by `make bounds`
# of log(a - a0) on either side, over which values are averaged
COARSER_VALUES = 0.35  # tuned on random bodies, by `make bounds`
COARSER_RATES = 0.2  # and their rates; tuned on random bodies, by `make bounds`
COARSER_BEND = 0.15  # and over which the bend is that of a parabola; tuned on random bodies, by `make bounds`
COARSER_SPACING = 0.01  # theory: of log(a - a0), far below what meshes resolve
COARSER_POINTS = 1000  # theory: of the whole series, as close

SAME_STEP = 0.1  # choice: by how much elements of one size may differ
MOST_STEPS_SAME = 0.8  # choice: share of the elements that are of one size on a mesh that is even at the contact
# works of adhesion over that of the curve, at which points are compared; choice: radii within a third, w as their cube
NEARBY = tuple((1.35 ** (3 * np.linspace(-1, 1, 7))).tolist())
Errors = Mapping[str, float]


def pull_off_error(curve: AdhesiveCurve, point: CriticalPoint, stiffness: float) -> Errors | Unknown:
    """Half-widths of "delta" [m] and "P" [N] at the lowest ``point`` under control by a device of ``stiffness``
    [N/m] (0: load, inf: displacement), or why they are unknown; no less than what the exact solution of the bodies is
    off, nor than what another rule of slopes is that was computed, where that is more than both errors."""
    own = error_of_rows(curve, point, stiffness)
    if isinstance(own, Unknown):
        return own
    off = np.maximum(from_reference(curve, point, stiffness), _from_other_rule(curve, point, stiffness, own))
    return {name: max(error, float(least)) for (name, error), least in zip(own.items(), off, strict=True)}


@lru_cache(maxsize=4)  # warnings ask twice for what the result states
def error_of_rows(curve: AdhesiveCurve, point: CriticalPoint, stiffness: float) -> Errors | Unknown:
    """The same by the series alone."""
    if curve.w == 0:
        return Unknown(f"unknown: {NO_ADHESION}")
    if not curve.errors:
        return Unknown(f"unknown: {curve.slopes.error}")
    if point.a == curve.a[0]:  # at the rim of a flat end
        below = dict(zip(("delta", "P"), curve.below_first, strict=True))
        return {name: float(error) + below[name] for name, error in curve.error_at(np.array(point.a)).items()}
    if point.a == curve.series.rim:  # a row of the solution
        own, lower = curve.error_at(np.array(point.a)), _lower_between(curve, point, stiffness)
        if isinstance(lower, Unknown):
            return lower
        return {name: float(own[name]) + more for name, more in zip(("delta", "P"), lower.tolist(), strict=True)}
    here = curve.interpolation_at(np.array(point.a))
    if isinstance(here, Unknown):
        return here
    rest = _beyond_gaps(curve, point, stiffness)
    if isinstance(rest, Unknown):
        return rest
    # How far delta and P move with all radii, by what is unknown of them together
    found = (_pull_off(AdhesiveCurve(body, curve.w), curve, stiffness) for body in curve.nonadhesive.shifted)
    moved = [_distance(other, point) for other in found if not isinstance(other, Unknown)]
    together = np.max([np.zeros(2), *moved], axis=0)
    if curve.series.shift is not None and not moved:  # beyond the series: what it is at the radius of the point
        together = curve.shift_error_at(np.array(point.a))
    rest = np.hypot(rest, together)
    return {name: float(here[name]) + more for name, more in zip(("delta", "P"), rest.tolist(), strict=True)}


def _lower_between(curve: AdhesiveCurve, point: CriticalPoint, stiffness: float) -> Array | Unknown:
    """How far delta and P, (2,), lie off those of the ``point`` at a rim where a device may stand as low between the
    points, by what is not known there; 0 under load control: the load grows all the way down from a rim."""
    if stiffness == LOAD_CONTROL:
        return np.zeros(2)
    knots = curve.nonadhesive.knots.a
    a = np.sqrt(knots[1:] * knots[:-1])
    unsure = curve.interpolation_at(a)
    if isinstance(unsure, Unknown):
        return unsure
    off, errors = np.stack(curve.at(a)) - [[point.delta], [point.P]], np.stack(list(unsure.values()))
    reached = position(off[0] - errors[0], off[1] - errors[1], stiffness) < 0
    return (np.abs(off) + errors)[:, reached].max(axis=1, initial=0.0)


def from_reference(curve: AdhesiveCurve, point: CriticalPoint, stiffness: float) -> Array:
    """How far delta and P of the ``point``, (2,), lie from those of the exact solution of the bodies, where the curve
    is another one and there is such: no smaller error is stated, since it is not known which of the two is wrong."""
    body = curve.nonadhesive.reference
    found = NO_ADHESION if body is None else _pull_off(AdhesiveCurve(body, curve.w), curve, stiffness)
    return np.zeros(2) if isinstance(found, Unknown) else _distance(found, point) * (1 + ROUNDED)


def _from_other_rule(curve: AdhesiveCurve, point: CriticalPoint, stiffness: float, own: Errors) -> Array:
    """How far delta and P of the ``point``, (2,), lie from those by the other slopes that were computed, where that is
    more than both errors together; 0 elsewhere."""
    slopes = curve.slopes.other
    other = None if slopes is None else AdhesiveCurve(Nonadhesive(curve.series, slopes), curve.w)
    found = NO_ADHESION if other is None else _pull_off(other, curve, stiffness)
    if other is None or isinstance(found, Unknown):
        return np.zeros(2)
    theirs, off = error_of_rows(other, found, stiffness), _distance(found, point)
    if isinstance(theirs, Unknown):
        return np.zeros(2)
    both = np.array([own[name] + theirs[name] for name in ("delta", "P")])
    return np.where(off > both, off * (1 + ROUNDED), 0.0)


def _beyond_gaps(curve: AdhesiveCurve, point: CriticalPoint, stiffness: float) -> Array | Unknown:
    """The part (2,) of the half-widths that lies not in what is interpolated between the points."""
    by_mesh = error_by_mesh(curve, point, stiffness)
    if by_mesh is not None:
        return by_mesh + _scatter(curve, point, stiffness) if curve.slopes.method == "exact" else by_mesh
    further, at_radius = curve.nonadhesive.further, np.zeros(2)
    nearest = None if further is None else int(np.argmin(np.abs(further.a - point.a)))
    settled = further is None or abs(further.a[nearest] - point.a) <= SAME * (point.a - curve.series.a0)
    joint = further.slopes.joint if further is not None and settled else None
    if joint is not None:  # what was solved for the point counts
        moved = _propagated(curve, point, stiffness, joint[nearest])
    elif curve.slopes.joint is not None:
        joint = curve.nonadhesive.between(curve.slopes.joint, np.array(point.a))
        moved = _propagated(curve, point, stiffness, joint)
    else:
        moved = _by_others(curve, point, stiffness)
        at_radius = np.stack(list(curve.error_at(np.array(point.a)).values()))
    if isinstance(moved, Unknown) or further is None:
        return moved if isinstance(moved, Unknown) else at_radius + moved
    if settled:
        # From the solved radius a to the point by the bend of the curve, which jumps at a by about what it errs
        a = float(further.a[nearest])
        sides = np.clip(a * (1 + np.array([-1e-3, 0.0, 1e-3])), curve.a[0], curve.a[-1])
        rates = np.stack(curve.rates(sides))
        below, above = np.diff(position(rates[0], rates[1], stiffness)) / np.diff(sides)
        unsure = abs(above - below) / max(abs(above + below) / 2, TINY) * abs(point.a - a)
        return at_radius + moved + np.abs(rates[:, 1]) * unsure
    # where the search for a point that is solved has not settled on it, its last steps halve at best
    return at_radius + moved + 2 * _distance(curve.point(float(further.a[nearest])), point)


def _distance(other: Equilibrium, point: Equilibrium) -> Array:
    """How far delta and P of two states lie apart, (2,)."""
    return np.abs([other.delta - point.delta, other.P - point.P])


def _propagated(curve: AdhesiveCurve, point: CriticalPoint, stiffness: float, covariance: Array) -> Array | Unknown:
    """Propagation of the joint ``covariance`` of the columns and of their rates, to second order in the place."""
    slopes, a = curve.slopes, np.array(point.a)
    delta, P, delta_rate, P_rate = _gradients(curve, a)
    along = np.clip(a * (1 + np.array([-1e-3, 1e-3])), curve.a[0], curve.a[-1])
    F, along_rates = position(delta_rate, P_rate, stiffness), np.stack(curve.rates(along))
    bends = np.diff(along_rates)[:, 0] / float(along[1] - along[0])  # of delta [1/m] and P [N/m^2]
    bend = float(position(bends[0], bends[1], stiffness))
    if bend == 0:
        return Unknown("unknown: the curve is flat there")
    place = -F / bend
    rates = [float(rate) for rate in curve.rates(a)]
    total = delta + rates[0] * place, P + rates[1] * place
    first = np.array([slopes.quantile * math.sqrt(max(g @ covariance @ g, 0.0)) for g in total])
    # what is stationary there changes to second order
    moved = slopes.quantile**2 * max(float(place @ covariance @ place), 0.0)
    return first + np.abs(bends) * moved / 2


def gradients_at(curve: AdhesiveCurve, a: Array) -> tuple[Array, Array]:
    """Gradients (4,) of delta [m] and P [N] at the radius ``a`` [m] by (delta_H, P_H, S, S')."""
    delta, P, *_ = _gradients(curve, a)
    return delta[:4], P[:4]


def _gradients(curve: AdhesiveCurve, a: Array) -> tuple[Array, Array, Array, Array]:
    """Gradients of delta, P, d(delta)/da and dP/da by (delta_H, P_H, S, S', d(delta_H)/da, S''), each (6,)."""
    (_, _, S, dS, t), rates = curve.nonadhesive.with_rates(a)
    t, t_rate = math.sqrt(curve.w) * t, math.sqrt(curve.w) * rates.t
    by_dS = -t / (2 * dS)  # of t; of its rate: the two below
    rate_by_dS = -t / (4 * dS) * (1 / a - 3 * rates.dS / dS)
    rate_by_bend = by_dS
    delta = np.array([1, 0, 0, -by_dS, 0, 0])
    P = np.array([0, 1, -t, -S * by_dS, 0, 0])
    delta_rate = np.array([0, 0, 0, -rate_by_dS, 1, -rate_by_bend])
    P_rate = np.array([0, 0, rates.delta_H - t_rate, -t - dS * by_dS - S * rate_by_dS, S, -S * rate_by_bend])
    return delta, P, delta_rate, P_rate


def _by_others(curve: AdhesiveCurve, point: CriticalPoint, stiffness: float) -> Array | Unknown:
    """How far the point moves where every second row is left out: scatter from row to row moves it as much, a smooth
    rule eight times as much as it errs. The functions are interpolated each for itself, which shows the scatter: what
    belongs to one energy smooths it away, but not what neighbouring rows share. Smoothing splines do not see what rows
    share: their point is also compared with that of the slopes "integral", which errs itself."""
    slopes = curve.slopes
    halves = [_pull_off(half, curve, stiffness) for half in _apart(curve).halves]
    order = 2**CURVE_ORDER if curve.smooth else 1
    others = [_distance(other, point) / order for other in halves if not isinstance(other, Unknown)]
    if slopes.method != "exact":
        by_integral = _by_integral(curve)
        if isinstance(by_integral, Unknown):
            return by_integral
        other = _pull_off(by_integral, curve, stiffness)
        if isinstance(other, Unknown):
            return Unknown("unknown: with the slopes 'integral' the point lies outside the solution")
        theirs = error_of_rows(by_integral, other, stiffness)
        error = 0.0 if isinstance(theirs, Unknown) else np.array(list(theirs.values()))
        others.append(_distance(other, point) + error)
    if not others:
        return Unknown("not estimated: without every second row the point lies outside the solution")
    moved: Array = np.max(others, axis=0)
    return moved + _scatter(curve, point, stiffness) if slopes.method == "exact" and not curve.smooth else moved


def _scatter(curve: AdhesiveCurve, point: CriticalPoint, stiffness: float) -> Array:
    """How far delta and P, (2,), lie off those of the ``point`` where a device may stand as low as there: at the
    neighbouring rows at which the scatter of the rows does not tell whether it stands lower."""

    def x(other: AdhesiveCurve, a: Array) -> Array:
        return np.asarray(position(*other.at(a), stiffness))

    rows = curve.a[(curve.a > point.a / CURVE_WIDEST) & (curve.a < point.a * CURVE_WIDEST)]
    away, here = np.abs(rows - point.a), float(x(curve, np.array(point.a)))
    scatter = max(np.max(np.abs(x(half, rows) - x(curve, rows))[away <= np.sort(away)[min(4, rows.size - 1)]])
                  for half in _apart(curve).halves)  # fmt: skip
    there = np.stack(curve.at(np.append(rows[x(curve, rows) < here + 2 * scatter], point.a)))
    return np.abs(there - [[point.delta], [point.P]]).max(axis=1)


def _pull_off(other: AdhesiveCurve, curve: AdhesiveCurve, stiffness: float) -> CriticalPoint | Unknown:
    """The pull-off of the ``other`` curve; those under all ``devices`` of ``curve`` are computed with it."""
    other.find_critical(curve.devices)
    return other.pull_off(stiffness)


@lru_cache(maxsize=2)
def _apart(curve: AdhesiveCurve) -> AdhesiveCurve:
    """The same curve with its functions interpolated each for itself."""
    return AdhesiveCurve(curve.nonadhesive.apart, curve.w)


@lru_cache(maxsize=2)
def _by_integral(curve: AdhesiveCurve) -> AdhesiveCurve | Unknown:
    """The same curve by the slopes "integral", or why there is none."""
    if curve.slopes.against is not None:
        return AdhesiveCurve(Nonadhesive(*curve.slopes.against), curve.w)
    try:
        return transform(curve.series, slopes_function("integral")(curve.series), curve.w)
    except InputError as error:
        return Unknown(f"unknown: {error}")


# ---------------------------------------------------------------------- larger elements
def error_by_mesh(curve: AdhesiveCurve, point: Equilibrium, stiffness: float) -> Array | None:
    """Half-widths (2,) of delta [m] and P [N] at a critical ``point`` under a device of ``stiffness`` [N/m]; None
    where no larger elements tell them."""
    coarser, series = curve.series.coarser, curve.series
    others = () if coarser is None else larger_elements(curve.nonadhesive)
    if coarser is None or not others:
        return None
    # Errors of delta and P, and of their slopes over log(a - a0), by a profile that is known at points only
    shift = slope = np.zeros(2)
    if series.unresolved is not None:
        unit = np.array([1.0, float(curve.nonadhesive.parts(np.array(point.a)).S)])
        of_value, of_slope = (np.interp(point.a, series.a, values) for values in series.unresolved)
        shift, slope = of_value * unit, (point.a - series.a0) * of_slope * unit
    # nodes a step apart, the same at all radii
    spacing = np.diff(series.a)
    even = np.mean(np.abs(spacing / np.median(spacing) - 1) < SAME_STEP) >= MOST_STEPS_SAME
    if even and (moved := _lost_by_larger(curve, others[0], point, stiffness)) is not None:
        return np.hypot(moved / (coarser.ratio - 1), shift)
    steps = np.arange(-COARSER_VALUES, COARSER_VALUES + COARSER_SPACING / 2, COARSER_SPACING)
    a = series.a0 + (point.a - series.a0) * np.exp(steps)
    inside = (a >= max(curve.a[0], others[0].a[0])) & (a <= curve.a[-1])
    a, x = a[inside], steps[inside]
    near, around = np.abs(x) <= COARSER_BEND, np.abs(x) <= COARSER_RATES
    if np.count_nonzero(near) * COARSER_SPACING < COARSER_BEND:
        return None
    # What each step to elements `ratio` times as large changes of delta [m] and P [N] at the radii `a` [m], (2,
    # steps, n), over what second order makes it larger than the first; NaN below the first radius of the larger.
    off = np.full((len(others) + 1, 2, a.size), np.nan)
    off[0] = 0.0
    for level, other in enumerate(others, start=1):
        reached = a >= other.a[0]
        # How far delta [m] and P [N], (2, n), of the `other` functions' curve lie off that of `curve` at its radii
        # `a` [m], at equal nonadhesive displacement.
        body, root_w, a0 = curve.nonadhesive, np.sqrt(curve.w), other.series.a0
        here = body.parts(a[reached])
        first, last = other.a[[0, -1]]
        radii = np.clip(a0 + np.geomspace(first - a0, last - a0, COARSER_POINTS), first, last)
        there = other.parts(np.interp(here.delta_H, other.parts(radii).delta_H, radii))
        P_H = there.P_H + there.S * (here.delta_H - there.delta_H)  # what the table leaves of equal displacement
        pulled = there.S * there.t - here.S * here.t
        off[level][:, reached] = np.stack([-root_w * (there.t - here.t), P_H - here.P_H - root_w * pulled])
    second_order = coarser.ratio ** (2.0 * np.arange(len(others)))
    values, changes = np.stack(curve.at(a)), np.moveaxis(np.diff(off, axis=0) / second_order[:, None, None], 0, 1)
    bend = 2 * np.polyfit(x[near], position(values[0], values[1], stiffness)[near], 2)[0]
    along = np.polyfit(x[near], values[:, near].T, 2)[1]
    rates = np.gradient(np.asarray(position(changes[0], changes[1], stiffness)), x, axis=-1)
    moved = _mean(rates[:, around]) / abs(bend)
    fallen = ((point.a - series.a0) / (series.a[-1] - series.a0)) ** np.array(COARSER_POWERS)
    of_values, of_place = np.array(COARSER_LEFT) / (coarser.ratio - 1) * fallen
    relative = np.array([_mean(change) for change in changes / _sizes(curve, a)[:, None]])
    of_mesh = np.hypot(of_values * relative * _sizes(curve, np.array(point.a)), of_place * along * moved)
    return np.sqrt(of_mesh**2 + shift**2 + (along * float(position(slope[0], slope[1], stiffness)) / bend) ** 2)


def _lost_by_larger(curve: AdhesiveCurve, larger: Nonadhesive, point: Equilibrium, stiffness: float) -> Array | None:
    """How far the ``larger`` elements move delta [m] and P [N] of the ``point``, (2,), in the mean over works of
    adhesion nearby, where they have points at all: at one alone meshes agree by accident."""
    moved = []
    for factor in NEARBY:
        near, other = (AdhesiveCurve(body, factor * curve.w) for body in (curve.nonadhesive, larger))
        ours, theirs = near.pull_off(stiffness), other.pull_off(stiffness)
        if not isinstance(ours, Unknown) and not isinstance(theirs, Unknown):
            moved.append(_distance(ours, theirs) / _sizes(near, np.array(ours.a)))
    if not moved:
        return None
    size: Array = _sizes(curve, np.array(point.a))
    return size * np.sqrt(np.mean(np.square(moved), axis=0))


def _sizes(curve: AdhesiveCurve, a: Array) -> Array:
    """What delta [m] and P [N] are differences of, (2, ...) at the radii ``a`` [m]: without adhesion, and by it."""
    here, root_w = curve.nonadhesive.parts(a), np.sqrt(curve.w)
    pulled = root_w * here.t
    return np.stack([here.delta_H + pulled, here.P_H + here.S * pulled])


def _mean(values: Array) -> float:
    """The root of the mean square of what is known."""
    return float(np.sqrt(np.nanmean(values**2)))


@lru_cache(maxsize=2)
def larger_elements(body: Nonadhesive) -> tuple[Nonadhesive, ...]:
    """The functions by larger and larger elements, with slopes by the same rule: their columns err by as much more as
    second order says; as far as the rule finds them."""
    fits, more, coarser = [], 1.0, body.series.coarser
    while coarser is not None:
        more *= coarser.ratio**2
        try:
            # The functions of the coarse series, which errs more times as much as that of the body, by its rule;
            # InputError where this finds none
            coarse, series, rule = coarser.series, body.series, body.slopes.method
            errors = {
                name: more
                * getattr(coarse, name)
                * np.interp(coarse.a, series.a, series.errors[name] / getattr(series, name))
                for name in ("a", "P")
            }
            S, dS = (coarse.S, coarse.dS) if rule == "exact" else (None, None)
            coarse = replace(coarse, S=S, dS=dS, S0=series.S0, errors=errors, kinks=series.kinks, bends=series.bends)
            fits.append(Nonadhesive(coarse, slopes_function(rule)(coarse)))
        except InputError:
            break
        coarser = coarser.series.coarser
    return tuple(fits)


# --------------------------------------------------------------------------------------------------
# What the points of a tabulated profile leave open where contact is lost: how far fewer points move that state.
#
# At given contact radius fewer points change delta and P by d(a): the value changes by d, and the place by the slope
# of the position made of d over the bend of the curve, and along with it what varies there. Errors of F that cancel
# in the loads (a rigid shift of the profile leaves P as it is) cancel here too. Between points d passes through zero,
# elsewhere than the table's own error does: its mean square within an interval of the table on either side counts, of
# two profiles the larger. The order of the table's own error says what is left.


# Radii at which fewer points are looked at, and what is concluded.
FEWER_POINTS_LEFT = 1.8  # of what the order leaves of a mean; tuned on tables, by `make range-bounds`
FEWER_POINTS_RADII = 6  # on either side; choice: some to an interval
# of the radius, how far the outermost lie at least, and over which other panels tell how far a point moves; choice:
# the contact is still like it
FEWER_POINTS_NEAREST = 0.02
FEWER_POINTS_FARTHEST = 1.5  # and the factor by which at most; choice: the contact is still like it
FEWER_POINTS_BEND = 2  # on either side, through which the bend is that of a parabola; choice: with room for rounding


def decimation_error(
    indenter: Indenter, columns: Callable[[Array], list[Array]], point: Equilibrium, stiffness: float, end: float
) -> Array:
    """Half-widths (2,) of delta [m] and P [N] at a critical ``point`` under a device of ``stiffness`` [N/m].

    ``columns``: delta and P, (2, n), at contact radii up to ``end`` [m], under the table ``indenter`` and under the
    profiles through fewer of its points.
    """
    # Contact radii from an interval of the table below the point to one above, the middle one its own
    middle, knots = FEWER_POINTS_RADII, np.array([0.0, *indenter.joints])
    after = int(np.clip(np.searchsorted(knots, point.a), 1, knots.size - 1))
    width = max(knots[after] - knots[after - 1], FEWER_POINTS_NEAREST * point.a)
    below = max(point.a - width, point.a / FEWER_POINTS_FARTHEST)
    above = min(point.a + width, point.a * FEWER_POINTS_FARTHEST, end)
    steps = np.arange(middle + 1) / middle
    a = np.concatenate([below + (point.a - below) * steps, point.a + (above - point.a) * steps[1:]])
    values, *others = columns(a)
    changes = np.stack(others) - values
    rates = np.gradient(np.asarray(position(changes[:, 0], changes[:, 1], stiffness)), a, axis=-1)
    near = slice(middle - FEWER_POINTS_BEND, middle + FEWER_POINTS_BEND + 1)
    x = a[near] - a[middle]
    bend = 2 * np.polyfit(x, np.asarray(position(values[0], values[1], stiffness))[near], 2)[0]
    along = np.polyfit(x, values[:, near].T, 2)[1]
    of_F, of_slope, of_mean = indenter.left(np.array([point.a, point.a if point.c is None else point.c])).max(axis=1)
    moved = of_slope * _largest_mean(rates) / abs(bend)
    value = max(of_F, of_mean) * _largest_mean(changes)
    return FEWER_POINTS_LEFT * np.hypot(value, along * moved)


def _largest_mean(changes: Array) -> Array:
    """Over the profiles, the first axis, the largest of the roots of the mean squares along the radii, the last one."""
    return np.sqrt(np.mean(changes**2, axis=-1)).max(axis=0)
