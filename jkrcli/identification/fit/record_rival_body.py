"""Rivals of body and tip in a raw record: layers, a modulus over the depth, profiles, slip, surface tension, strains.

Each is another body, by how the logs of its functions D = delta_H, T, H = P_H and V of the contact radius change: of
tips by D, of moduli by the contact stiffness S, as dP_H = S d(delta_H).
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import cast

import numpy as np
from scipy.interpolate import CubicSpline

from ...adhesion import LIMITS
from ...adhesion.validity import EXCESS, STRAINED
from ...base import MOST_STEPS, SAME, SETTLED, UNSEEN, Array
from ...bodies import HalfSpace, Layer, Loading, Rigid, Specimen, unbounded
from ...methods.radii import DENSE
from .attracted import TUNING as ATTRACTED
from .body import FittedBody, solved
from .device_path import grid
from .family import Family
from .fitted_record import FittedRecord, log_ratio
from .force_curve import ForceCurveModel
from .force_curve_fit import ForceCurveFit
from .force_curve_readings import DirectionReadings
from .record_change import AMOUNT, LITTLE, Change, RivalModel, Values, change_of_body, of_body
from .record_change import TUNING as CHANGES
from .record_rival_adhesion import root_of


@dataclass(frozen=True)
class BodyRivalTuning:
    """Bodies of which columns are taken, and which are searched."""

    thick: float = 3.0  # choice: of the largest contact radius, the layer that a half-space is compared with
    under: tuple[float, float] = (3e-3, 0.5)  # of its thickness, radii it is solved at; theory: up to a contact of 0.44
    decades: int = 4  # choice: such layers to a decade of thickness, so that many curves share one solve
    neighbour: float = 0.02  # choice: of thickness and nu, for differences of two bodies
    thin: float = 4.0  # choice: contact radii over the thickness up to which a layer is searched
    thicknesses: tuple[float, ...] = (0.3, 1.0)  # choice: contact radii over it, to begin with
    softest: float = -0.6  # theory: S' stays above 0 up to ``CHANGES.beyond``
    bluntest: float = -1.5  # theory: profiles that rise, exponent 1/2
    flattest: float = -3.0  # theory: profiles that rise up to a/R = 1
    profiles: tuple[float, ...] = (-1.0, -0.8, 0.0)  # choice: exponents less that of a paraboloid, to begin with
    finest: float = 4.0  # theory: of kappa, below which the expansion for small kappa is not used


TUNING = BodyRivalTuning()
EULER = float(np.euler_gamma)


def layer_below(record: FittedRecord) -> Change | None:
    """A half-space as a layer on a rigid base at the depth a_max/amount."""
    specimen, a_max = record.body.problem.specimen, record.a_max
    if specimen.layers or specimen.radius is not None or not isinstance(specimen.base, HalfSpace):
        return None
    h = 10 ** (round(math.log10(TUNING.thick * a_max) * TUNING.decades) / TUNING.decades)
    column = record.towards(_on_rigid(record.body, h, TUNING.under[1]), a_max / h)
    return replace(_on_base(record.body, a_max, a_max), column=column)


def _on_rigid(body: FittedBody, h: float, most: float) -> Family:
    """The body's half-space as a layer of thickness ``h`` [m] on a rigid base, up to ``most`` times that."""
    specimen = body.problem.specimen
    assert isinstance(specimen.base, HalfSpace)
    problem = replace(unbounded(body.problem), specimen=Specimen((Layer(specimen.base.material, h),), Rigid()))
    most = min(most, ATTRACTED.below_limit * problem.indenter.r_max / h)
    radii = tuple((h * np.geomspace(TUNING.under[0], most, DENSE)).tolist())
    return solved(replace(problem, loading=Loading.given("radius", radii)), body.tolerance)


def _on_base(body: FittedBody, a_max: float, h: float) -> Change:
    """The same in full, by the curves of one thickness ``h`` [m]: those of others are the same over a/h, but for the
    tip's shape, so that the change is made anew about what it leads to."""

    @lru_cache(maxsize=1)
    def ratios(family: Family) -> CubicSpline:
        """Logs of D, T, H, V over those of the half-space, over ln(a/h)."""
        layer = _on_rigid(body, h, TUNING.thin)
        u = np.linspace(layer.low, layer.high, DENSE)
        return CubicSpline(u - math.log(h), np.log(layer.at(u)[0] / family.at(u)[0]).T)

    def changes(family: Family, amount: float) -> Array:
        spline = ratios(family)
        log = grid(family) + math.log(max(amount, LITTLE**2) / a_max)
        thick = np.exp(np.minimum(log - spline.x[0], 0.0))  # in proportion to a/h below
        return thick * spline(np.clip(log, spline.x[0], spline.x[-1])).T

    def recentred(fit: ForceCurveFit) -> Change:
        return replace(_on_base(body, a_max, a_max / max(fit.value(AMOUNT), LITTLE)))

    quantities = lambda values: {"thickness": a_max / max(values[AMOUNT], LITTLE**2)}  # noqa: E731
    starts = tuple((amount,) for amount in TUNING.thicknesses)
    change = change_of_body(changes, (0.0, TUNING.thin))
    return replace(change, starts=starts, quantities=quantities, recentred=recentred)


def thickness(record: FittedRecord) -> Change | None:
    """h = h0 (1 + amount) of the layer in contact."""
    return _of_layer(record, "h", "thickness")


def poisson(record: FittedRecord) -> Change | None:
    """nu = nu0 (1 + amount) of the layer in contact, towards 1/2 at most."""
    return _of_layer(record, "nu", "nu")


def _of_layer(record: FittedRecord, symbol: str, quantity: str) -> Change | None:
    """The relative change of a quantity of the layer in contact, between bodies that are solved at even steps of it."""
    body, step = record.body, TUNING.neighbour
    if not body.own_parameters or not body.problem.specimen.layers:
        return None
    name = f"{symbol}:{body.layer_names[0]}"
    nominal = body.nominal(name)
    most = (0.5 - UNSEEN) / nominal - 1 if symbol == "nu" else CHANGES.largest

    def at_node(i: int) -> Family:
        return body.with_values({name: nominal * (1 + min(i * step, most))}).family

    def changes(family: Family, amount: float) -> Array:
        i = math.floor(amount / step)
        part = amount / step - i
        return (1 - part) * log_ratio(at_node(i), family) + part * log_ratio(at_node(i + 1), family)

    return replace(
        change_of_body(changes, (1 / (1 + CHANGES.largest) - 1, most)),
        quantities=lambda values: {quantity: nominal * (1 + values[AMOUNT])},
        column=record.towards(at_node(-1), -step),
    )


def graded(record: FittedRecord) -> Change:
    """ln S rises by the amount times a/a_max."""
    a_max = record.a_max

    def changes(family: Family, amount: float) -> Array:
        place = np.minimum(np.exp(grid(family)) / a_max, CHANGES.beyond)
        return of_body(family, np.zeros_like(place), amount * place)

    return change_of_body(changes, (TUNING.softest, CHANGES.largest))


def exponent(record: FittedRecord) -> Change:
    """A profile of exponent 2 + amount, as deep as the tip at a_max: ln D rises by the amount times ln(a/a_max)."""
    log = math.log(record.a_max)
    return replace(
        change_of_body(
            lambda family, amount: _of_tip(family, amount * (grid(family) - log)), (TUNING.bluntest, CHANGES.largest)
        ),
        starts=tuple((amount,) for amount in TUNING.profiles),
        quantities=lambda values: {"exponent": 2 + values[AMOUNT]},
        recentred=_exponent_at_turn,
    )


def _exponent_at_turn(fit: ForceCurveFit) -> Change:
    """The same about the contact radius at the turn, which follows the unknowns: its error is one of E*."""
    part, values, model = fit.model.stretches[0], fit.model.values(fit.x), cast(RivalModel, fit.model)
    turn, kind = part.turn, part.kind
    start = np.log(model.branch(part, values).radii(np.array([turn - values["z0"]])))
    (D, T, _, _), _, _ = model.followed(part, values).family.at(start)
    deflection = (turn - values["z0"]) - (D - root_of(values, kind) * T)  # of the device [m]

    def log_changes(plain: ForceCurveModel, part: DirectionReadings, values: Values) -> Array:
        u, root = start, root_of(values, kind)
        for _ in range(MOST_STEPS):
            (D, T, _, _), (dD, dT, _, _), _ = plain.family.at(u)
            step = (D - root * T - (turn - values["z0"] - deflection)) / (dD - root * dT)
            u = u - step
            if abs(float(step[0])) < SETTLED:
                break
        return _of_tip(plain.family, values[AMOUNT] * (grid(plain.family) - u))

    return replace(model.change, log_changes=log_changes, model=None, coupled=True, recentred=None)


def quartic(record: FittedRecord) -> Change | None:
    """From the paraboloid to the sphere of the same radius: ln D rises by the amount times (a/R)^2/3."""
    R = record.body.problem.indenter.tip_radius
    if R is None:
        return None

    def changes(family: Family, amount: float) -> Array:
        return _of_tip(family, amount * np.minimum(np.exp(grid(family)) / R, 1.0) ** 2 / 3)

    return change_of_body(changes, (TUNING.flattest, CHANGES.largest))


def _of_tip(family: Family, D: Array) -> Array:
    """Changes of the logs (4, n) where that of the displacement alone changes by ``D``."""
    return of_body(family, D, np.zeros_like(D))


def no_slip(record: FittedRecord) -> Change | None:
    """From surfaces that slide to such as do not: the amount times the logs of the latter's functions over the
    former's."""
    problem, sliding = record.body.problem, record.model.family
    if problem.sticks or problem.specimen.radius is not None:
        return None
    stuck, u = record.body.on_surface("sticking").family, np.array([sliding.high])
    if np.abs(np.log(stuck.at(u)[0] / sliding.at(u)[0])).max() < SAME:
        return None
    return change_of_body(lambda family, amount: amount * log_ratio(stuck, family))


def tension(record: FittedRecord) -> Change | None:
    """Surface tension Ups of a half-space, kappa = 2 Ups/E* = amount times a_max, to first order in kappa/a: delta_H
    times 1 + 2 x (l - 1), P_H times 1 + 3 x l, S times 1 + x (l + 1), S' times 1 + x with x = kappa/(pi a) and l = ln(2
    a/kappa) + Euler's constant."""
    problem, a_max = record.body.problem, record.a_max
    if problem.layers or problem.specimen.radius is not None:
        return None

    def relative(family: Family, amount: float) -> Array:
        kappa = max(amount, LITTLE**2) * a_max
        a = np.maximum(np.exp(grid(family)), TUNING.finest * kappa)
        x, log = kappa / (math.pi * a), np.log(2 * a / kappa) + EULER
        return x * np.stack([2 * (log - 1), 3 * log, log + 1, np.ones_like(a)])

    def functions(changes: Array) -> Array:
        """Of D, T, H, V: T^2 goes with 1/S', V with S T."""
        D, H, S, dS = changes
        return np.stack([D, -dS / 2, H, S - dS / 2])

    column = record.by_changes(functions(relative(record.model.family, CHANGES.small)) / CHANGES.small)
    change = change_of_body(lambda family, amount: functions(np.log1p(relative(family, amount))), (0.0, 1.0))
    unit = record.body.problem.E_star * a_max / 2
    quantities = lambda values: {"surface_tension": unit * math.exp(values["ln_s"]) * values[AMOUNT]}  # noqa: E731
    return replace(change, starts=((CHANGES.small,),), quantities=quantities, column=column)


def amount_of_tension(record: FittedRecord, tension: float) -> float:
    """The amount of a surface tension [N/m]."""
    return 2 * tension / (record.E_star * record.a_max)


def likely_tension(record: FittedRecord) -> float:
    """The amount of the largest tension that is known."""
    return amount_of_tension(record, record.known.tension)


def strains(record: FittedRecord) -> Array | None:
    """What linear theory leaves out at large strains of half-spaces, as far as it is known: at fixed displacement P_H
    becomes P_H/(1 + excess(a/R))."""
    problem = record.body.problem
    R, known = problem.indenter.tip_radius, EXCESS.get(problem.indenter.noun)
    if known is None or problem.layers or R is None:
        return None
    excess = np.interp(record.a / R, STRAINED, known)
    return -excess / (1 + excess) * record.nonadhesive[0] * record.at_fixed_position


def likely_strains(record: FittedRecord) -> float:
    """All of it, but none where linear theory is taken as good, as everywhere else."""
    R = record.body.problem.indenter.tip_radius
    return 0.0 if R is not None and record.a_max <= LIMITS.a_over_R * R else 1.0
