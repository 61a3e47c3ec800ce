"""Hypotheses on what the model of a raw record leaves out, each as a change of the model by an amount.

``ALTERNATIVES`` is the list: an entry is a name, its family, what its amount is, its change, and how much of it is
likely before the data (``priors.py``). A change is made by a function of the fitted record, which stands here with the
equation, over time in the wing of that; what types there are is in ``model_changes.py``. The data are
asked for each by its score (``score_tests.py``).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache, partial
from typing import cast

import numpy as np

from ..adhesion.validity import EXCESS, LIMITS, STRAINED
from ..base.numerics import MOST_STEPS, SAME, SETTLED, UNSEEN, Array, PiecewiseCubic, cubic_spline
from ..base.process import REMEMBERED
from ..base.wings import offered
from ..bodies.problem import HalfSpace, Layer, Loading, Rigid, Specimen, without_side_walls
from ..methods.radii import DENSE
from .choices import Values
from .curve import APPROACH
from .fitted_record import CHANGE_SMALL, FittedRecord
from .force_curve import SLOW_EDGE_WIDEST, DirectionReadings, ForceCurveFit, creep, hysteresis
from .forward_model import FAMILY_BELOW_LIMIT, FUNCTIONS, Family, FittedBody, grid, on_grid, solved
from .free_rows import VIRTUAL
from .model_changes import (
    ADHESION,
    AMOUNT,
    BODY,
    CHANGE_BEYOND,
    DEVICE,
    LITTLE,
    MEMORY,
    TIP,
    AlternativeModel,
    BodyChange,
    Change,
    ChangedModel,
    LoadsChange,
    OfStretch,
    PositionChange,
    ShapeChange,
    StiffnessChange,
    root_of,
)
from .priors import LONG, PRIORS, RANGE, TENSION

# How far hypotheses are followed.
CHANGE_LARGEST = 6.0  # choice: amount up to which alternatives are searched where theory sets no limit


@lru_cache(maxsize=REMEMBERED)
def _radii(family: Family) -> Array:
    """Contact radii [m] at the nodes of its grid."""
    return np.exp(grid(family))


@lru_cache(maxsize=REMEMBERED)
def log_ratio(other: Family, family: Family) -> Array:
    """Logs (4, n) of D, T, H, V of an ``other`` body over a ``family``'s, on its grid; constant where one ends."""
    inside = np.clip(grid(family), max(family.low, other.low), min(family.high, other.high))
    return np.log(other.at(inside)[0] / family.at(inside)[0])


# --------------------------------------------------------------------------------------------------
# Alternatives of adhesion in a raw record: w over the contact radius, and adhesion of a range.
#
# With r = sqrt(w/s) the contact has delta = D - r T and P = s (H - r V): a change of w is one of the logs of T and V.

# Which ranges and laws of w are searched.
# choice: Tabor numbers, to begin with: chi^2 has two valleys over the range, the longer one about a factor 1.4 wide
ADHESION_TABOR = (3.0, 1.4, 1.0, 0.7, 0.5, 0.35, 0.25, 0.18, 0.12, 0.06, 0.03)
ADHESION_ENDLESS = 400.0  # choice: of how far adhesion deforms the body, a range from which on no longer one differs
ADHESION_NARROW = 0.5  # choice: of the contact radius, a ring between narrow and wide
ADHESION_EVERY = 7  # choice: of the nodes of a grid, at which rings are solved: splines between are good to 1e-5
ADHESION_SETTLED = 1e-6  # theory: such a step by Newton's method, whose errors are squared: the next is round-off


def work_over_radius(record: FittedRecord) -> Change | None:
    """ln w of the last direction rises by the amount times (a_max - a)/(a_max - a_min): T and V by half of it. The w of
    the record is then that at a_min, at pull-off."""
    a = record.radii[-1][0]
    if not record.work or not (a > 0).any():
        return None
    a_max, a_min = record.a_max, float(a[a > 0].min())

    def logs(family: Family, values: Values) -> Array:
        place = (a_max - _radii(family)) / max(a_max - a_min, LITTLE * a_max)
        half, zero = values[AMOUNT] / 2 * np.maximum(place, -1.0), np.zeros_like(place)
        return np.stack([zero, half, zero, half])

    name, most = f"q:{record.model.stretches[-1].kind}", CHANGE_LARGEST
    quantities = lambda values: {"w": values[name] * math.exp(values["ln_s"] + values[AMOUNT])}  # noqa: E731
    return BodyChange(of=logs, where="last", limits={AMOUNT: (-most, most)}, quantities=quantities)


def finite_range(record: FittedRecord) -> Change | None:
    """Adhesion of the range z0: the amount is z0^2 over that of the range whose ring of attraction is narrow (Maugis,
    J. Colloid Interface Sci. 150 (1992) 243, of a half-space; of other bodies near the edge only)."""
    if not record.work:
        return None
    E_star = record.body.problem.E_star
    return RangeChange(
        of=lambda _, values: (math.exp(values["ln_s"]) * E_star, range_of(record, values[AMOUNT])), where="each",
        coupled=True, starts=tuple((amount_of_range(record, record.neck / mu),) for mu in ADHESION_TABOR),
        limits={AMOUNT: (0.0, amount_of_range(record, ADHESION_ENDLESS * record.neck))},
        quantities=lambda values: {"range": range_of(record, values[AMOUNT])},
    )  # fmt: skip


def amount_of_range(record: FittedRecord, z0: float) -> float:
    """The amount of a range [m]: in proportion to its square while it is short, and finite where it is endless."""
    size = (z0 / record.narrow_range) ** 2
    return size / (1 + size / (record.neck / record.narrow_range) ** 2)


def range_of(record: FittedRecord, amount: float) -> float:
    """The range [m] of an amount."""
    least = (record.neck / record.narrow_range) ** 2  # of an endless range
    return record.narrow_range * math.sqrt(amount / (1 - amount / least)) if amount < least else math.inf


@dataclass(frozen=True, eq=False, kw_only=True)
class RangeChange(BodyChange):
    """A ring of attraction around the contact of each stretch, of E* [Pa] and the range [m] that ``of`` gives."""

    @staticmethod
    def logs(asked: Sequence[OfStretch]) -> Sequence[Array]:
        changes, rings = np.zeros((len(asked), FUNCTIONS, grid(asked[0].plain.family).size)), []
        for i, (change, plain, part, values) in enumerate(asked):
            E, z0 = change.of(plain.family, values)
            if (w := values[f"q:{part.kind}"] * math.exp(values["ln_s"])) > 0 and 0 < z0 < math.inf:
                rings.append((i, plain.family, E, z0, w))
        if not rings:
            return list(changes)

        # The stress sigma = w/z0 on a ring from a to m a shifts the displacement by 2 sigma a sqrt(m^2 - 1)/E* and the
        # load by 2 sigma a^2 (sqrt(m^2 - 1) + m^2 arccos(1/m)), JKR by sqrt(2 pi a w/E*) and sqrt(8 pi w E* a^3).
        places, families, *each = zip(*rings, strict=True)
        E, z0, w = np.array(each)[..., None]
        nodes = [np.stack([_radii(family), on_grid(family)[0, 0]]) for family in families]
        a, D = np.stack(nodes, axis=1)[..., ::ADHESION_EVERY]
        sigma = w / z0
        m = _rim(a, D, E, w, sigma)
        root, angle = np.sqrt(m**2 - 1), np.arccos(1 / m)
        shift = 2 * sigma * a * root / E / np.sqrt(2 * math.pi * a * w / E)
        pull = 2 * sigma * a**2 * (root + m**2 * angle) / np.sqrt(8 * math.pi * w * E * a**3)
        logs = np.stack([np.log(shift), np.log(pull)], axis=1)
        changes[list(places), 1::2] = logs @ _splines(grid(families[0]).size)
        return list(changes)


@lru_cache
def _splines(size: int) -> Array:
    """Values at ``size`` even nodes of the cubic splines through 1 at one of every ``ADHESION_EVERY`` nodes and 0 at
    the others of these, (some, size)."""
    nodes = np.arange(size)
    some = nodes[::ADHESION_EVERY]
    return cubic_spline(some, np.eye(some.size))(nodes).T


def _rim(a: Array, D: Array, E: Array, w: Array, sigma: Array) -> Array:
    """Ratio m of outer to inner radius of the ring whose stress ``sigma`` releases ``w``. With t = sqrt(m^2 - 1) and c
    = arccos(1/m), 1 = 4 sigma^2 a/(pi E* w) (t c - m + 1) + sigma D/(pi w) (t + (m^2 - 2) c); by Newton's method for
    the log of the right-hand side over that of m - 1, nearly straight; from its limits, of narrow rings and
    of wide ones."""
    own, pressed = 4 * sigma**2 / (math.pi * E * w) * a, sigma / (math.pi * w) * D
    near = 1 / (own + (math.sqrt(128) / 3 * pressed) ** (2 / 3))
    far = 2 / ((math.pi / 2 - 1) * own + np.sqrt(((math.pi / 2 - 1) * own) ** 2 + 2 * math.pi * pressed))
    x, goes_on = np.where(near < ADHESION_NARROW, near, np.maximum(far, ADHESION_NARROW)), np.ones((len(a), 1))
    for _ in range(MOST_STEPS):
        m = 1 + x
        root = np.sqrt(x * (2 + x))
        angle = np.arctan(root)
        released = own * (root * angle - x) + pressed * (root + (m**2 - 2) * angle)
        rate = own * (m * angle / root + 1 / m - 1) + pressed * (m / root + 2 * m * angle + (m - 2 / m) / root)
        step = -released / (x * rate) * np.log(released) * goes_on
        x *= np.exp(np.clip(step, -SLOW_EDGE_WIDEST, SLOW_EDGE_WIDEST))
        goes_on *= np.abs(step).max(axis=1, keepdims=True) >= ADHESION_SETTLED  # each by itself
        if not goes_on.any():
            break
    return 1 + x


def long_range(record: FittedRecord) -> Change | None:
    """From JKR to adhesion that pulls from so far that it deforms nothing (Derjaguin, Muller and Toporov, J. Colloid
    Interface Sci. 53 (1975) 314), at equal w: P = P_H(delta) - 2 pi w R. In full it is a finite range."""
    R, k = record.body.problem.indenter.tip_radius, record.model.k
    if R is None or not record.work:
        return None
    D, _, H, _ = on_grid(record.model.family)[0]
    qs = [np.full(part.P.size, max(record.values[f"q:{part.kind}"], 0.0)) for part in record.model.stretches]
    P_H = np.interp(record.depth - record.loads / k, D, H, left=0.0)
    change = record.modulus * (P_H - 2 * math.pi * R * np.concatenate(qs)) - record.loads
    return Change(column=np.where(record.a > 0, change * record.at_fixed_position, 0.0))


# --------------------------------------------------------------------------------------------------
# Alternatives of body and tip in a raw record: layers, a modulus over the depth, profiles, slip, surface tension,
# strains.
#
# Each is another body, by how the logs of its functions D = delta_H, T, H = P_H and V of the contact radius change:
# of tips by D, of moduli by the contact stiffness S, as dP_H = S d(delta_H).

# Bodies of which columns are taken, and which are searched.
BODY_THICK = 3.0  # choice: of the largest contact radius, the layer that a half-space is compared with
# of its thickness, radii it is solved at; theory: up to a contact of 0.44
BODY_UNDER = (3e-3, 0.5)
BODY_DECADES = 4  # choice: such layers to a decade of thickness, so that many curves share one solve
BODY_NEIGHBOUR = 0.02  # choice: of thickness and nu, for differences of two bodies
BODY_THIN = 4.0  # choice: contact radii over the thickness up to which a layer is searched
BODY_THICKNESSES = (0.3, 1.0)  # choice: contact radii over it, to begin with
BODY_SOFTEST = -0.6  # theory: S' stays above 0 up to ``CHANGES.beyond``
BODY_BLUNTEST = -1.5  # theory: profiles that rise, exponent 1/2
BODY_FLATTEST = -3.0  # theory: profiles that rise up to a/R = 1
BODY_PROFILES = (-1.0, -0.8, 0.0)  # choice: exponents less that of a paraboloid, to begin with
BODY_FINEST = 4.0  # theory: of kappa, below which the expansion for small kappa is not used


EULER = float(np.euler_gamma)


def layer_below(record: FittedRecord) -> Change | None:
    """A half-space as a layer on a rigid base at the depth a_max/amount."""
    specimen, a_max = record.body.problem.specimen, record.a_max
    if specimen.layers or specimen.radius is not None or not isinstance(specimen.base, HalfSpace):
        return None
    h = 10 ** (round(math.log10(BODY_THICK * a_max) * BODY_DECADES) / BODY_DECADES)
    changes = log_ratio(_on_rigid(record.body, h, BODY_UNDER[1]), record.model.family) * h / a_max
    return _on_base(record.body, a_max, a_max, changes)


@lru_cache(maxsize=REMEMBERED)
def _on_rigid(body: FittedBody, h: float, most: float) -> Family:
    """The body's half-space as a layer of thickness ``h`` [m] on a rigid base, up to ``most`` times that."""
    specimen = body.problem.specimen
    assert isinstance(specimen.base, HalfSpace)
    problem = replace(without_side_walls(body.problem), specimen=Specimen((Layer(specimen.base.material, h),), Rigid()))
    most = min(most, FAMILY_BELOW_LIMIT * problem.indenter.r_max / h)
    radii = tuple((h * np.geomspace(BODY_UNDER[0], most, DENSE)).tolist())
    return solved(replace(problem, loading=Loading.given("radius", radii)), body.tolerance)


def _on_base(body: FittedBody, a_max: float, h: float, per_amount: Array | None = None) -> Change:
    """The same in full, by the curves of one thickness ``h`` [m]: those of others are the same over a/h, but for the
    tip's shape, so that the change is made anew about what it leads to."""

    @lru_cache(maxsize=1)
    def ratios(family: Family) -> PiecewiseCubic:
        """Logs of D, T, H, V over those of the half-space, over ln(a/h)."""
        layer = _on_rigid(body, h, BODY_THIN)
        u = np.linspace(layer.low, layer.high, DENSE)
        return cubic_spline(u - math.log(h), np.log(layer.at(u)[0] / family.at(u)[0]).T)

    def logs(family: Family, values: Values) -> Array:
        spline = ratios(family)
        log = grid(family) + math.log(max(values[AMOUNT], LITTLE**2) / a_max)
        thick = np.exp(np.minimum(log - spline.x[0], 0.0))  # in proportion to a/h below
        return thick * spline(np.clip(log, spline.x[0], spline.x[-1])).T

    return BodyChange(
        of=logs, per_amount=per_amount, starts=tuple((amount,) for amount in BODY_THICKNESSES),
        limits={AMOUNT: (0.0, BODY_THIN)},
        quantities=lambda values: {"thickness": a_max / max(values[AMOUNT], LITTLE**2)},
        recentred=lambda fit: _on_base(body, a_max, a_max / max(fit.value(AMOUNT), LITTLE)),
    )  # fmt: skip


def of_layer(record: FittedRecord, symbol: str, quantity: str) -> Change | None:
    """The relative change of a quantity of the layer in contact, h or nu, this towards 1/2 at most; between bodies that
    are solved at even steps of it."""
    body, step = record.body, BODY_NEIGHBOUR
    if not body.own_parameters or not body.problem.specimen.layers:
        return None
    name = f"{symbol}:{body.layer_names[0]}"
    nominal = body.nominal(name)
    most = (0.5 - UNSEEN) / nominal - 1 if symbol == "nu" else CHANGE_LARGEST

    def at_node(i: int) -> Family:
        return body.with_values({name: nominal * (1 + min(i * step, most))}).family

    def logs(family: Family, values: Values) -> Array:
        i = math.floor(values[AMOUNT] / step)
        part = values[AMOUNT] / step - i
        return (1 - part) * log_ratio(at_node(i), family) + part * log_ratio(at_node(i + 1), family)

    return BodyChange(
        of=logs, per_amount=log_ratio(at_node(-1), record.model.family) / -step,
        limits={AMOUNT: (1 / (1 + CHANGE_LARGEST) - 1, most)},
        quantities=lambda values: {quantity: nominal * (1 + values[AMOUNT])},
    )  # fmt: skip


def graded(record: FittedRecord) -> Change:
    """ln S rises by the amount times a/a_max - 1: E* is that at the largest contact radius, which the rows tell."""

    def shape(family: Family, values: Values) -> tuple[Array, Array]:
        place = np.minimum(_radii(family) / record.a_max, CHANGE_BEYOND) - 1
        return np.zeros_like(place), values[AMOUNT] * place

    return ShapeChange(of=shape, limits={AMOUNT: (BODY_SOFTEST, CHANGE_LARGEST)})


def exponent(record: FittedRecord) -> Change:
    """A profile of exponent 2 + amount, as deep as the tip at a_max: ln D rises by the amount times ln(a/a_max)."""
    log = math.log(record.a_max)
    return ShapeChange(
        of=lambda family, values: _of_tip(values[AMOUNT] * (grid(family) - log)), recentred=_exponent_at_turn,
        starts=tuple((amount,) for amount in BODY_PROFILES), limits={AMOUNT: (BODY_BLUNTEST, CHANGE_LARGEST)},
        quantities=lambda values: {"exponent": 2 + values[AMOUNT]},
    )  # fmt: skip


def _exponent_at_turn(fit: ForceCurveFit) -> Change:
    """The same about the contact radius at the turn, which follows the unknowns: its error is one of E*."""
    part, values, model = fit.model.stretches[0], fit.model.values(fit.x), cast(ChangedModel, fit.model)
    turn, kind = part.turn, part.kind
    start = np.log(model.branch(part, values).radii(np.array([turn - values["z0"]])))
    (D, T, _, _), _, _ = model.followed(part, values).family.at(start)
    deflection = (turn - values["z0"]) - (D - root_of(values, kind) * T)  # of the device [m]

    def shape(family: Family, values: Values) -> tuple[Array, Array]:
        u, root = start, root_of(values, kind)
        for _ in range(MOST_STEPS):
            (D, T, _, _), (dD, dT, _, _), _ = family.at(u)
            step = (D - root * T - (turn - values["z0"] - deflection)) / (dD - root * dT)
            u = u - step
            if abs(float(step[0])) < SETTLED:
                break
        return _of_tip(values[AMOUNT] * (grid(family) - u))

    return replace(cast(ShapeChange, model.change), of=shape, coupled=True, recentred=None)


def quartic(record: FittedRecord) -> Change | None:
    """From the paraboloid to the sphere of the same radius: ln D rises by the amount times (a/R)^2/3."""
    if (R := record.body.problem.indenter.tip_radius) is None:
        return None
    return ShapeChange(
        of=lambda family, values: _of_tip(values[AMOUNT] * np.minimum(_radii(family) / R, 1.0) ** 2 / 3),
        limits={AMOUNT: (BODY_FLATTEST, CHANGE_LARGEST)},
    )


def _of_tip(D: Array) -> tuple[Array, Array]:
    """Changes of the logs of displacement and stiffness where the former alone changes, by ``D``."""
    return D, np.zeros_like(D)


def no_slip(record: FittedRecord) -> Change | None:
    """From surfaces that slide to such as do not: the amount times the logs of the latter's functions over the
    former's."""
    problem, sliding = record.body.problem, record.model.family
    if problem.sticks or problem.specimen.radius is not None:
        return None
    stuck = record.body.on_surface("sticking").family
    if np.abs(log_ratio(stuck, sliding)[:, -1]).max() < SAME:
        return None
    return BodyChange(of=lambda family, values: values[AMOUNT] * log_ratio(stuck, family))


def tension(record: FittedRecord) -> Change | None:
    """Surface tension Ups of a half-space, kappa = 2 Ups/E* = amount times a_max, to first order in kappa/a: delta_H
    times 1 + 2 x (l - 1), P_H times 1 + 3 x l, S times 1 + x (l + 1), S' times 1 + x with x = kappa/(pi a) and l = ln(2
    a/kappa) + Euler's constant."""
    problem, a_max = record.body.problem, record.a_max
    if problem.layers or problem.specimen.radius is not None:
        return None

    def relative(family: Family, amount: float) -> Array:
        """Changes of delta_H, S', P_H and S, in this order."""
        kappa, changes = max(amount, LITTLE**2) * a_max, np.ones((FUNCTIONS, grid(family).size))
        a = np.maximum(_radii(family), BODY_FINEST * kappa)
        log = np.log(2 / kappa * a) + EULER
        changes[0], changes[2], changes[3] = 2 * (log - 1), 3 * log, log + 1
        changes *= kappa / math.pi / a
        return changes

    def functions(changes: Array) -> Array:
        """Of D, T, H, V, from those of delta_H, S', P_H and S: T^2 goes with 1/S', V with S T."""
        changes[1] /= -2
        changes[3] += changes[1]
        return changes

    unit = problem.E_star * a_max / 2
    return BodyChange(
        of=lambda family, values: functions(np.log1p(relative(family, values[AMOUNT]))),
        per_amount=functions(relative(record.model.family, CHANGE_SMALL) / CHANGE_SMALL),
        starts=((CHANGE_SMALL,),), limits={AMOUNT: (0.0, 1.0)},
        quantities=lambda values: {"surface_tension": unit * math.exp(values["ln_s"]) * values[AMOUNT]},
    )  # fmt: skip


def amount_of_tension(record: FittedRecord, tension: float) -> float:
    """The amount of a surface tension [N/m]."""
    return 2 * tension / (record.E_star * record.a_max)


def strains(record: FittedRecord) -> Change | None:
    """What linear theory leaves out at large strains of half-spaces, as far as it is known: at fixed displacement P_H
    becomes P_H/(1 + excess(a/R))."""
    problem = record.body.problem
    R, known = problem.indenter.tip_radius, EXCESS.get(problem.indenter.noun)
    if known is None or problem.layers or R is None:
        return None
    excess = np.interp(record.a / R, STRAINED, known)
    return Change(column=-excess / (1 + excess) * record.P_H * record.at_fixed_position)


def likely_strains(record: FittedRecord) -> float:
    """What is known of them, but none where linear theory is taken as good, as everywhere else."""
    R = record.body.problem.indenter.tip_radius
    return 0.0 if R is not None and record.a_max <= LIMITS.a_over_R * R else PRIORS["large strains"].width


# --------------------------------------------------------------------------------------------------
# Alternatives of the device in a raw record, and of one direction against the other: stiffness, positions, flow.


def stiffness(record: FittedRecord) -> Change | None:
    """k (1 + amount) of the device, its loads as they are: rows and the turn are deeper by amount P/k."""
    model = record.model
    if not math.isfinite(model.k):
        return None
    column, part = record.by_position * record.loads, model.stretches[-1]
    resting = model.edges(record.fit.x)[-1][1]
    if resting is not None and "z0" in record.fit.names:
        by_turn = -record.by_unknown("z0") - record.by_position
        column = column + by_turn * float(resting.at(np.array([part.turn - record.values["z0"]]))[0, 0])
    return StiffnessChange(
        column=column / model.k, limits={AMOUNT: (LITTLE - 1, math.inf)},
        quantities=lambda values: {"stiffness": model.k * (1 + values[AMOUNT])},
    )  # fmt: skip


def misplaced(
    record: FittedRecord, error: Callable[[DirectionReadings], Array], name: str = AMOUNT
) -> PositionChange | None:
    """Rows of the retraction that stand deeper than their positions say by the amount times an ``error`` [m], which
    results call by a ``name``."""
    if len(record.model.stretches) < 2 or name in record.model.positions:
        return None
    return PositionChange(
        error=lambda part: error(part) * float(part.kind != APPROACH), quantities=lambda values: {name: values[AMOUNT]}
    )


def drift(record: FittedRecord) -> Change | None:
    """Depths that drift by the amount times the way in contact over the time of the record, 0 at the turn."""
    if len(record.model.stretches) < 2 or "drift" in record.model.positions:
        return None
    sign = {APPROACH: 1.0}
    return PositionChange(error=lambda part: sign.get(part.kind, -1.0) * record.time(part) * record.reach)


def virtual_deflection(record: FittedRecord) -> Change | None:
    """A parabola over the positions, 0 at contact, that free rows alone do not show; where none is fitted."""
    parts, names = record.model.stretches, record.fit.names
    if any(name.endswith(VIRTUAL) for name in names) or "z0" not in names:
        return None
    way = max(float(np.ptp(part.z[~part.touching])) if (~part.touching).any() else 0.0 for part in parts)
    if not way:
        return None
    shapes = [part.span * ((part.z - record.values["z0"]) / way) ** 2 for part in parts]
    return LoadsChange(column=np.concatenate(shapes))


def another_modulus(record: FittedRecord) -> Change | None:
    """E* (1 + amount) on the way back."""
    if len(record.model.stretches) < 2 or "ln_s" not in record.fit.names or record.retraction is None:
        return None

    def shape(family: Family, values: Values) -> tuple[Array, Array]:
        same = np.zeros_like(grid(family))
        return same, same + math.log1p(values[AMOUNT])

    column = np.where(record.rows(record.retraction), record.by_unknown("ln_s"), 0.0)
    return ShapeChange(of=shape, where="last", limits={AMOUNT: (LITTLE - 1, math.inf)}, column=column)


def slope_at_rest(record: FittedRecord) -> Change | None:
    """S (1 + amount) of the line along which the crack is pinned, about the turn."""
    part, rests = record.retraction, record.radii[-1][1]
    if part is None or np.count_nonzero(rests) < 3:
        return None
    column, rows = np.zeros(record.a.size), record.rows(part, rests)
    column[rows] = (record.by_position * record.at_fixed_position)[rows] * (part.z[rests] - part.turn)
    return Change(column=column)


ALTERNATIVES: tuple[AlternativeModel, ...] = (
    AlternativeModel("w over the contact radius", ADHESION, "relative rise towards pull-off", work_over_radius),
    AlternativeModel(RANGE, ADHESION, "square of the range over that of a narrow ring", finite_range,
          lambda record: amount_of_range(record, record.known.range) if record.work else 0.0),
    AlternativeModel(LONG, ADHESION, "from JKR to DMT", long_range),
    AlternativeModel("a rigid substrate below", BODY, "contact radius over depth", layer_below),
    AlternativeModel("thickness of the layer", BODY, "relative change",
          partial(of_layer, symbol="h", quantity="thickness")),
    AlternativeModel("nu of the layer", BODY, "relative change", partial(of_layer, symbol="nu", quantity="nu")),
    AlternativeModel("moduli that change with the contact radius", BODY, "relative rise", graded),
    AlternativeModel("exponent of the tip", TIP, "change of the exponent", exponent),
    AlternativeModel("sphere or paraboloid", TIP, "share of the sphere's quartic term", quartic),
    AlternativeModel("no slip", BODY, "from none to full", no_slip),
    AlternativeModel(TENSION, BODY, "2 tension/E* over the contact radius", tension,
          lambda record: amount_of_tension(record, record.known.tension)),
    AlternativeModel("large strains", BODY, "of what is known of them", strains, likely_strains),
    *(offered("hypotheses over time") or ()),
    AlternativeModel("residual depth", MEMORY, "of the depth of contact",
          lambda record: misplaced(record, lambda part: np.full(part.z.size, -record.reach)), of_directions=True),
    AlternativeModel("another modulus on retraction", MEMORY, "relative change", another_modulus, of_directions=True),
    AlternativeModel("another slope at rest", MEMORY, "relative change", slope_at_rest, of_directions=True),
    AlternativeModel("stiffness of the cantilever", DEVICE, "relative change", stiffness),
    AlternativeModel(VIRTUAL, DEVICE, "of the range of the load, over the free way", virtual_deflection,
          lambda _: PRIORS[VIRTUAL].spread),
    AlternativeModel("creep of the position", DEVICE, "of the travel, per decade of time",
          lambda record: misplaced(record, lambda part: part.travel * creep(record.time(part)), "creep"),
          of_directions=True),
    AlternativeModel("hysteresis of the position", DEVICE, "of the travel, at most",
          lambda record: misplaced(record, lambda part: part.travel * hysteresis(part.way), "hysteresis"),
          of_directions=True),
    AlternativeModel("scale of the position", DEVICE, "retraction against approach",
          lambda record: misplaced(record, lambda part: record.reach * part.way), of_directions=True),
    AlternativeModel("drift of the depth", DEVICE, "of the depth over the force curve", drift, of_directions=True),
)  # fmt: skip
