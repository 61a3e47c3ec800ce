"""The rivals of a raw record: what the model leaves out, each as the change of all loads that a little of it makes.

``RIVALS`` is the list: an entry is a name, its family, what its amount is, how much of it is likely before the data,
and a function from the fit to a column: the derivative of the loads [N] by the amount, at fixed positions of the
device. Most columns are one more evaluation of the path of the device: on a body whose functions differ a little
(``bent``), at other positions, at another stiffness. ``scores`` asks the data for each.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Hashable, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache, partial
from typing import Any, NamedTuple, cast

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.special import ndtri

from ...adhesion import LIMITS, Nonadhesive, Program, RelaxingContact
from ...adhesion.validity import EXCESS, STRAINED
from ...base import SAME, Array, InputError, JkrError
from ...bodies import HalfSpace, Layer, Loading, PowerRelaxation, Relaxation, Rigid, Specimen, StandardSolid
from ...data.measured.curve import APPROACH
from ...methods.layered.layered import unbounded
from ...methods.radii import DENSE
from .body import FittedBody, solved
from .device_path import grid, on_grid, rest
from .family import Family
from .force_curve import DirectionReadings, ForceCurveFit, ForceCurveModel, base_line
from .positions import creep, hysteresis
from .record_change import AMOUNT, LITTLE, Change, RivalModel, Values, bending, bent, of_body
from .record_situation import Situation
from .slow_edge import load_at, receding


@dataclass(frozen=True)
class RecordRivalTuning:
    """Amounts of which columns are taken, and what is known of rivals before the data."""

    thick: float = 3.0  # choice: of the largest contact radius, the layer that a half-space is compared with
    under: tuple[float, float] = (3e-3, 0.5)  # of its thickness, radii it is solved at; theory: up to a contact of 0.44
    decades: int = 4  # choice: such layers to a decade of thickness, so that many curves share one solve
    neighbour: float = 0.02  # choice: of thickness and nu, for differences of two bodies
    zone: float = 0.01  # choice: of the contact radius, width of the ring of attraction
    skin: float = 0.01  # choice: of the contact radius, length kappa of tension
    finest: float = 4.0  # theory: of kappa, below which the expansion for small kappa is not used
    narrow: float = 0.5  # choice: of the contact radius, a ring between narrow and wide
    every: int = 7  # choice: of the nodes of a grid, at which rings are solved: splines between are good to 1e-5
    steps: int = 12  # choice: of Newton's method for its width; it needs four
    widest_step: float = 2.0  # choice: of the log of that width
    settled: float = 1e-4  # choice: such a step, after which the next is below 1e-9
    pieces: int = 60  # choice: of the way of the tip in each direction, for the history of a body that relaxes
    deeper: float = 1.5  # choice: of the way in contact, to which that body is solved
    histories: int = 8  # choice: kept, more only saves time
    coarser: int = 2  # choice: steps joined in them, 1e-5 of the loads
    grows: float = 0.02  # choice: of the depth, by which a contact may grow again: noise of the deflection
    times: int = 50  # choice: instants of each direction at which those loads are solved; splines between them
    smooth: float = 2 / 3  # theory: power of the load in which they are drawn, at first contact it is delta^1.5
    instants: int = 100  # choice: at which hereditary integrals are taken
    longest: float = 10e-9  # choice: [m], range of adhesion that is likely; of molecules a nanometre, of hairs more
    cone: float = 3.0  # choice: three times what a cone's exponent differs from a paraboloid's by: one step overshoots
    strains: float = 2.0  # choice: of the effect of large strains on rubber, that of other materials
    device: float = 1.0  # choice: relative, by which a stiffness that someone measured may be off
    shape: float = 0.003  # choice: exponent of the profile within which a tip is what it is called: by as much its
    # radius of curvature changes over a factor e of the contact radius
    inside: float = 0.9  # choice: of the tip, up to which a layer below it is solved
    thin: float = 4.0  # choice: contact radii over the thickness up to which a layer is looked for
    thicknesses: tuple[float, ...] = (0.3, 1.0)  # choice: contact radii over it, to begin with
    incompressible: float = 0.4999  # choice: largest nu that is looked for; theory: 1/2 at most
    thinned: float = 0.9  # choice: relative, by which the thickness or nu of a layer may be smaller than it was said
    thickened: float = 4.0  # choice: the same, larger thickness
    grades: tuple[float, float] = (-0.6, 5.0)  # theory: S' stays above 0 up to ``farther``; choice: the largest
    pointed: tuple[float, float] = (-1.5, 6.0)  # theory: profiles that rise; choice: exponents 1/2 to 8
    quartics: tuple[float, float] = (-3.0, 6.0)  # theory: profiles that rise up to a/R = 1; choice: the largest
    rises: tuple[float, float] = (-5.0, 5.0)  # choice: of the log of w along a record
    farther: float = 1.5  # choice: of the largest radius, beyond which a modulus that changes is even
    profiles: tuple[float, ...] = (-1.0, -0.8, 0.0)  # choice: exponents less that of a paraboloid, to begin with
    # choice: Tabor numbers, to begin with: chi^2 has two valleys over the range, the longer one about a factor 1.4 wide
    tabor: tuple[float, ...] = (3.0, 1.4, 1.0, 0.7, 0.5, 0.35, 0.25, 0.18, 0.12, 0.06, 0.03)
    farthest: float = 1e3  # choice: range over how far adhesion deforms the body; longer ones change nothing
    tensions: tuple[float, ...] = (0.03,)  # choice: 2 tension/E* over the contact radius, to begin with
    exponents: tuple[float, ...] = (0.3, 0.8)  # choice: of the speed of the edge, to begin with
    rates: tuple[float, ...] = (0.3, 1.0)  # choice: rises of w at its usual speed, to begin with
    powers: tuple[float, float] = (0.1, 1.5)  # choice: of the speed of the edge, that are looked for; measured 0.1 to 1
    fewest: int = 3  # choice: positions that tell a speed


TUNING = RecordRivalTuning()
# What the unknowns of rivals mean, by dimension:
OF_RIVALS = {
    AMOUNT: "number", "thickness": "length", "nu": "number", "exponent": "number", "range": "length",
    "surface_tension": "tension", "stiffness": "stiffness", "fall": "number", "relaxation_time": "time", "n": "number",
    "creep": "number", "hysteresis": "number",
}  # fmt: skip
EXPONENT, TIME, ANY = "n", "relaxation_time", (-math.inf, math.inf)
Look = Callable[[Situation], Change | Array | None]


@dataclass(frozen=True)
class Rival:
    """One thing that the model leaves out. ``family``: what cannot be told from it as a rule; ``amount``: what a column
    is the derivative by, in words; ``look``: what a fit makes of it: a change, which can be fitted in full, or a column
    alone, of first order; None where the rival has no meaning for this record.

    ``likely``: amount in either direction that is expected unless the user or the data say otherwise: 0 of what the
    description of the body rules out; ``positive``: in that direction only; ``possible``: the largest that any body,
    tip or device has. ``of_directions``: whether it sets one direction against the other.
    """

    name: str
    family: str
    amount: str
    look: Look
    likely: float = 0.0
    positive: bool = False
    possible: float = math.inf
    of_directions: bool = False

    def limits(self) -> tuple[float, float]:
        """The least and the largest amount that there is."""
        return 0.0 if self.positive else -self.possible, self.possible


def of_family(
    changes: Callable[[Family, float], Array], limits: tuple[float, float] = ANY, *, last: bool = False
) -> Change:
    """A change of the body by ``changes`` (4, n) of its logs at an amount; of the ``last`` stretch alone or of all."""

    changed = lru_cache(maxsize=2)(changes)
    body = lru_cache(maxsize=2)(lambda family, amount: bent(family, changed(family, amount)))

    def bends(plain: ForceCurveModel, part: DirectionReadings, values: Values) -> Array | None:
        return None if last and part is not plain.stretches[-1] else changed(plain.family, values[AMOUNT])

    def model(plain: ForceCurveModel, part: DirectionReadings, values: Values) -> ForceCurveModel:
        if last and part is not plain.stretches[-1]:
            return plain
        return replace(plain, family=body(plain.family, values[AMOUNT]))

    return Change(((0.0,),), limits={AMOUNT: limits}, bends=bends, model=model)


def work_over_radius(at: Situation) -> Change | None:
    """The log of w of the last direction that rises as the contact shrinks, in proportion to the radius, by an amount
    from the largest to the smallest; told is w there, at pull-off."""
    a = at.radii[-1][0]
    if not at.work or not (a > 0).any():
        return None
    widest, least = at.widest, float(a[a > 0].min())

    def changes(family: Family, amount: float) -> Array:
        place = (widest - np.exp(grid(family))) / max(widest - least, LITTLE * widest)
        half, zero = amount / 2 * np.maximum(place, -1.0), np.zeros_like(place)
        return np.stack([zero, half, zero, half])

    name = f"q:{at.model.stretches[-1].kind}"
    told = lambda values: {"w": values[name] * math.exp(values["ln_s"] + values[AMOUNT])}  # noqa: E731
    return replace(of_family(changes, TUNING.rises, last=True), told=told)


def work_over_speed(at: Situation) -> Change | None:
    """w of the retraction over the speed of its edge."""
    part, values = at.back, at.model.values(at.found.x)
    name = "" if part is None else f"q:{part.kind}"
    if part is None or name not in at.found.names:
        return None
    a, rests = at.radii[at.model.stretches.index(part)]
    speeds = _speeds(part, a, (a > 0) & ~rests)
    if speeds is None:
        return None
    log = np.zeros(at.a.size)
    log[at.rows(part, (a > 0) & ~rests)] = speeds.at_rows
    column = at.here[1][:, at.found.names.index(name)] * values[name] * log
    return replace(_over_speed(speeds.typical), column=column)


@dataclass(frozen=True, eq=False)
class _Speeds:
    """Logs of the speed of the edge over the ``typical`` one, its median over the speed of the device, ``at_rows`` that
    move."""

    typical: float
    at_rows: Array


def _speeds(part: DirectionReadings, a: Array, moves: Array) -> _Speeds | None:
    """None where too few rows move. By position: a device that moves evenly is taken for granted."""
    z, rows = np.unique(part.z[moves], return_index=True)  # readings of a position repeat
    if z.size < TUNING.fewest:
        return None
    radii = a[moves][rows]
    log = np.log(np.maximum(np.abs(np.gradient(radii, z)), 1e-9))
    middle = float(np.median(log))
    return _Speeds(math.exp(middle), np.interp(part.z[moves], z, log - middle))


def _over_speed(typical: float) -> Change:
    """w0 (1 + amount (v/v_m)^n) of the retraction, v_m the ``typical`` speed of its edge over that of the device."""

    def back(model: ForceCurveModel, part: DirectionReadings, values: Values) -> Array:
        first, s = model.stretches[0], math.exp(values["ln_s"])
        q = max(values[f"q:{part.kind}"], LITTLE**3 * model.most)
        root = _root(values, first.kind)
        turn, n = part.turn - values["z0"], values[EXPONENT]
        held = rest(model.family, s, root, math.sqrt(q), model.k, turn)
        path = receding(model.family, s, q, model.k, (max(values[AMOUNT], LITTLE**2) * typical**-n, n), held, turn)
        return np.where(part.touching, load_at(path, held, turn, model.depth(part, values)), 0.0)

    return Change(
        tuple((amount, n) for amount in TUNING.rates for n in TUNING.exponents), (AMOUNT, EXPONENT),
        {AMOUNT: (0.0, 1e3), EXPONENT: TUNING.powers}, back=back, felt=True,
        told=lambda values: {name: values[name] for name in (AMOUNT, EXPONENT)},
    )  # fmt: skip


def layer_below(at: Situation) -> Change | None:
    """A rigid base at a depth, in contact radii over it; of a half-space only."""
    specimen, widest = at.body.problem.specimen, at.widest
    if specimen.layers or specimen.radius is not None or not isinstance(specimen.base, HalfSpace):
        return None
    h = TUNING.thick * widest
    h = 10 ** (round(math.log10(h) * TUNING.decades) / TUNING.decades)
    column = at.neighbour(_on_rigid(at.body, h, TUNING.under[1]), widest / h)
    return replace(_below(at.body, widest, widest), column=column)


def _on_rigid(body: FittedBody, h: float, most: float) -> Family:
    """The body's half-space as a layer of thickness ``h`` [m] on a rigid base, up to ``most`` times that."""
    specimen = body.problem.specimen
    assert isinstance(specimen.base, HalfSpace)
    problem = replace(unbounded(body.problem), specimen=Specimen((Layer(specimen.base.material, h),), Rigid()))
    most = min(most, TUNING.inside * problem.indenter.r_max / h)
    radii = tuple((h * np.geomspace(TUNING.under[0], most, DENSE)).tolist())
    return solved(replace(problem, loading=Loading.given("radius", radii)), body.tolerance)


def _below(body: FittedBody, widest: float, h: float) -> Change:
    """The same in full, made about a thickness ``h`` [m]: others are a matter of a/h, but for the tip's shape."""

    @lru_cache(maxsize=1)
    def ratios(family: Family) -> CubicSpline:
        other = _on_rigid(body, h, TUNING.thin)
        u = np.linspace(other.low, other.high, DENSE)
        return CubicSpline(u - math.log(h), np.log(other.at(u)[0] / family.at(u)[0]).T)

    def changes(family: Family, amount: float) -> Array:
        found = ratios(family)
        own = grid(family) + math.log(max(amount, LITTLE**2) / widest)
        least = np.exp(np.minimum(own - found.x[0], 0.0))  # in proportion to a/h below
        return least * found(np.clip(own, found.x[0], found.x[-1])).T

    def renewed(found: ForceCurveFit) -> Change:
        return replace(_below(body, widest, widest / max(found.value(AMOUNT), LITTLE)))

    told = lambda values: {"thickness": widest / max(values[AMOUNT], LITTLE**2)}  # noqa: E731
    starts = tuple((amount,) for amount in TUNING.thicknesses)
    return replace(of_family(changes, (0.0, TUNING.thin)), starts=starts, told=told, renewed=renewed)


def of_layer(quantity: str) -> Look:
    """The relative change of ``quantity`` ("h" or "nu") of the layer in contact; nu towards 1/2 at most."""

    def look(at: Situation) -> Change | None:
        if not at.body.own_parameters or not at.body.problem.specimen.layers:
            return None
        name = f"{quantity}:{at.body.layer_names[0]}"
        nominal = at.body.nominal(name)
        most = TUNING.incompressible / nominal - 1 if quantity == "nu" else TUNING.thickened

        def at_node(i: int) -> Family:
            return at.body.with_values({name: nominal * (1 + min(i * TUNING.neighbour, most))}).family

        def changes(family: Family, amount: float) -> Array:
            i = math.floor(amount / TUNING.neighbour)
            u, part = grid(family), amount / TUNING.neighbour - i
            inside = np.clip(u, family.low, family.high)
            one, other = (np.log(at_node(j).at(inside)[0] / family.at(inside)[0]) for j in (i, i + 1))
            return (1 - part) * one + part * other

        column = at.neighbour(at_node(-1), -TUNING.neighbour)
        told = {"h": lambda values: {"thickness": nominal * (1 + values[AMOUNT])},
                "nu": lambda values: {"nu": nominal * (1 + values[AMOUNT])}}[quantity]  # fmt: skip
        return replace(of_family(changes, (-TUNING.thinned, most)), told=told, column=column)

    return look


def graded(at: Situation) -> Change:
    """Stiffness that rises in proportion to the contact radius."""
    widest = at.widest

    def changes(family: Family, amount: float) -> Array:
        place = np.minimum(np.exp(grid(family)) / widest, TUNING.farther)
        return of_body(family, np.zeros_like(place), amount * place)

    return of_family(changes, TUNING.grades)


def exponent(at: Situation) -> Change:
    """Exponent of the profile, the tip as deep as it was at the largest radius: in full that at the turn."""
    return _power(at.widest)


def _power(widest: float) -> Change:
    def changes(family: Family, amount: float) -> Array:
        return of_body(family, *_of_tip(amount * (grid(family) - math.log(widest))))

    told = lambda values: {"exponent": 2 + values[AMOUNT]}  # noqa: E731
    starts = tuple((amount,) for amount in TUNING.profiles)
    return replace(of_family(changes, TUNING.pointed), starts=starts, told=told, renewed=_power_at_turn)


def _power_at_turn(found: ForceCurveFit) -> Change:
    """The same about the contact radius at the turn, which follows the unknowns: its error is one of E*."""
    part, values = found.model.stretches[0], found.model.values(found.x)
    (kind, turn), change = (part.kind, part.turn), cast(RivalModel, found.model).change
    start = np.log(found.model.branch(part, values).radii(np.array([turn - values["z0"]])))
    (D, T, _, _), _, _ = found.model.followed(part, values).family.at(start)  # type: ignore[attr-defined]
    bent_by = (turn - values["z0"]) - (D - _root(values, kind) * T)  # of the device [m]

    def changes(family: Family, values: Values) -> Array:
        u = start
        for _ in range(TUNING.steps):
            (D, T, _, _), (dD, dT, _, _), _ = family.at(u)
            off = D - _root(values, kind) * T - (turn - values["z0"] - bent_by)
            u = u - off / (dD - _root(values, kind) * dT)
        return of_body(family, *_of_tip(values[AMOUNT] * (grid(family) - u)))

    bends = lambda plain, part, values: changes(plain.family, values)  # noqa: E731
    return replace(change, **bending(bends), felt=True, renewed=None)


def _root(values: Values, kind: str) -> float:
    """The root of w over the moduli of a direction."""
    return values.get(f"r:{kind}", math.sqrt(max(values[f"q:{kind}"], 0.0)))


def quartic(at: Situation) -> Change | None:
    """From the paraboloid to the sphere of the same radius."""
    R = at.body.problem.indenter.tip_radius
    if R is None:
        return None

    def changes(family: Family, amount: float) -> Array:
        return of_body(family, *_of_tip(amount * np.minimum(np.exp(grid(family)) / R, 1.0) ** 2 / 3))

    return of_family(changes, TUNING.quartics)


def _of_tip(D: Array) -> tuple[Array, Array]:
    return D, np.zeros_like(D)


def no_slip(at: Situation) -> Change | None:
    """From surfaces that slide to such as do not."""
    problem = at.body.problem
    if problem.sticks or problem.specimen.radius is not None:
        return None
    other, u = at.body.on_surface("sticking").family, np.array([at.model.family.high])
    if np.abs(np.log(other.at(u)[0] / at.model.family.at(u)[0])).max() < SAME:
        return None

    def changes(family: Family, amount: float) -> Array:
        inside = np.clip(grid(family), max(family.low, other.low), min(family.high, other.high))
        return amount * np.log(other.at(inside)[0] / family.at(inside)[0])

    return of_family(changes)


def finite_range(at: Situation) -> Change | None:
    """The square of the range of adhesion, over that of which the ring of attraction is narrow (Maugis, J. Colloid
    Interface Sci. 150 (1992) 243, of a half-space; of other bodies near the edge only)."""
    if not at.work:
        return None
    E_star = at.body.problem.E_star

    def bends(plain: ForceCurveModel, part: DirectionReadings, values: Values) -> Array | None:
        s = math.exp(values["ln_s"])
        w, z0 = values[f"q:{part.kind}"] * s, range_of(at, values[AMOUNT])
        return None if w <= 0 or z0 == 0 else _ringed(plain.family, s * E_star, w, z0)

    starts = tuple((amount_of_range(at, neck(at) / mu),) for mu in TUNING.tabor)
    told = lambda values: {"range": range_of(at, values[AMOUNT])}  # noqa: E731
    most = amount_of_range(at, TUNING.farthest * neck(at))
    return Change(starts, limits={AMOUNT: (0.0, most)}, **bending(bends), felt=True, told=told)


def long_range(at: Situation) -> Array | None:
    """From JKR to adhesion that pulls from so far that it deforms nothing (Derjaguin, Muller and Toporov, J. Colloid
    Interface Sci. 53 (1975) 314), at equal w: 2 pi w R less than without adhesion at equal displacement. In full it
    is a finite range."""
    R, values = at.body.problem.indenter.tip_radius, at.model.values(at.found.x)
    if R is None or not at.work:
        return None
    D, _, H, _ = at.model.family.at(grid(at.model.family))[0]
    P = at.loads
    z = np.concatenate([at.model.depth(part, values) for part in at.model.stretches])
    works = [np.full(part.P.size, max(values[f"q:{part.kind}"], 0.0)) for part in at.model.stretches]
    pulled = at.modulus * (np.interp(z - P / at.model.k, D, H, left=0.0) - 2 * math.pi * R * np.concatenate(works))
    column: Array = np.where(at.a > 0, (pulled - P) * at.yields, 0.0)
    return column


def neck(at: Situation) -> float:
    """How far adhesion deforms the body at pull-off [m], about: the range there is 1 over Tabor's number of it."""
    R = at.body.problem.indenter.tip_radius or at.widest
    return float((at.work**2 * R / (at.modulus * at.body.problem.E_star) ** 2) ** (1 / 3))


def amount_of_range(at: Situation, z0: float) -> float:
    """The amount of a range [m]: in proportion to its square while it is short, and finite where it is endless."""
    size = (z0 / narrow_range(at)) ** 2
    return size / (1 + size / (neck(at) / narrow_range(at)) ** 2)


def range_of(at: Situation, amount: float) -> float:
    """The range [m] of an amount."""
    return narrow_range(at) * math.sqrt(amount / (1 - amount / (neck(at) / narrow_range(at)) ** 2))


def _ringed(family: Family, E: float, w: float, z0: float) -> Array:
    """Changes of the logs (4, n) of a body of E* ``E`` [Pa] whose adhesion ``w`` [J/m^2] has the range ``z0`` [m]."""
    sigma, some = w / z0, slice(None, None, TUNING.every)
    a, D = np.exp(grid(family)[some]), on_grid(family)[0][0, some]
    m = _rim(a, D, E, w, sigma)
    root, angle = np.sqrt(m**2 - 1), np.arccos(1 / m)
    shift = 2 * sigma * a * root / E / np.sqrt(2 * math.pi * a * w / E)  # over those of JKR
    pull = 2 * sigma * a**2 * (root + m**2 * angle) / np.sqrt(8 * math.pi * w * E * a**3)
    zero = np.zeros_like(a)
    changes: Array = np.stack([zero, np.log(shift), zero, np.log(pull)]) @ _through(grid(family).size, TUNING.every)
    return changes


@lru_cache
def _through(size: int, every: int) -> Array:
    """What cubic splines through some of ``size`` even nodes make of the values there at all nodes, (some, size)."""
    nodes = np.arange(size)
    some = nodes[::every]
    splines: Array = CubicSpline(some, np.eye(some.size))(nodes).T
    return splines


def narrow_range(at: Situation) -> float:
    """The range z0 [m] of which the ring is ``TUNING.zone`` wide at the largest radius: d = pi E* z0^2/(4 w)."""
    return math.sqrt(4 * TUNING.zone * at.widest * at.work / (math.pi * at.modulus * at.body.problem.E_star))


def _rim(a: Array, D: Array, E: float, w: float, sigma: float) -> Array:
    """Ratio m of outer to inner radius where a constant tension ``sigma`` releases ``w``, by Newton's method for the
    log of what it releases over that of m - 1, nearly straight; from its limits, of narrow rings and of wide ones."""
    own, pressed = 4 * sigma**2 / (math.pi * E * w) * a, sigma / (math.pi * w) * D
    near = 1 / (own + (math.sqrt(128) / 3 * pressed) ** (2 / 3))
    far = 2 / ((math.pi / 2 - 1) * own + np.sqrt(((math.pi / 2 - 1) * own) ** 2 + 2 * math.pi * pressed))
    x = np.where(near < TUNING.narrow, near, np.maximum(far, TUNING.narrow))
    for _ in range(TUNING.steps):
        m = 1 + x
        root = np.sqrt(x * (2 + x))
        angle = np.arctan(root)
        here = own * (root * angle - x) + pressed * (root + (m**2 - 2) * angle)
        rate = own * (m * angle / root + 1 / m - 1) + pressed * (m / root + 2 * m * angle + (m - 2 / m) / root)
        step = -here / (x * rate) * np.log(here)
        x *= np.exp(np.clip(step, -TUNING.widest_step, TUNING.widest_step))
        if float(np.abs(step).max()) < TUNING.settled:
            break
    return 1 + x


def tension(at: Situation) -> Change | None:
    """Surface tension of a half-space, its length kappa = 2 Ups/E* over the largest radius; first order in kappa/a."""
    specimen, widest = at.body.problem.specimen, at.widest
    if specimen.layers or specimen.radius is not None:
        return None

    def relative(family: Family, amount: float) -> Array:
        kappa = max(amount, LITTLE**2) * widest
        a = np.maximum(np.exp(grid(family)), TUNING.finest * kappa)
        x, log = kappa / (math.pi * a), np.log(2 * a / kappa) + float(np.euler_gamma)
        return x * np.stack([2 * (log - 1), 3 * log, log + 1, np.ones_like(a)])

    def of_four(changes: Array) -> Array:
        tip, load, S, dS = changes
        return np.stack([tip, -dS / 2, load, S - dS / 2])

    column = at.on(of_four(relative(at.model.family, TUNING.skin)) / TUNING.skin)
    unit = at.body.problem.E_star * widest / 2
    told = lambda values: {"surface_tension": unit * math.exp(values["ln_s"]) * values[AMOUNT]}  # noqa: E731
    starts = tuple((amount,) for amount in TUNING.tensions)
    change = of_family(lambda family, amount: of_four(np.log1p(relative(family, amount))), (0.0, 1.0))
    return replace(change, starts=starts, told=told, column=column)


def tension_amount(at: Situation, tension: float) -> float:
    """The amount of a surface tension [N/m]."""
    return 2 * tension / (at.body.problem.E_star * at.modulus * at.widest)


def strains(at: Situation) -> Array | None:
    """What linear theory leaves out at large strains, as far as it is known: of half-spaces."""
    problem = at.body.problem
    R, told = problem.indenter.tip_radius, EXCESS.get(problem.indenter.noun)
    if told is None or problem.specimen.layers or R is None:
        return None
    excess = np.interp(at.a / R, STRAINED, told)
    return -excess / (1 + excess) * at.nonadhesive[0] * at.yields


def relaxing(memory: Callable[[Array], Array], law: Callable[[Values, float], Relaxation], **own: Any) -> Look:
    """Moduli that fall by an amount of ``memory`` of the time since the strain, in units of the record (Ting 1966); in
    full by a ``law`` of the unknowns and of how long the record lasts, where nothing adheres."""

    def look(at: Situation) -> Change | Array | None:
        column = first_order(at)
        adheres, timed = any(part.tension for part in at.model.stretches), np.ptp(at.model.stretches[0].t) > 0
        if column is None or adheres or not timed or at.model.positions:
            return column
        load = _relaxed(at, lambda values: law(values, at.lasting))
        return Change(load=load, felt=True, column=column, told=partial(_fall, at.lasting), **own)

    def first_order(at: Situation) -> Array | None:
        if len(at.model.stretches) < 2:
            return None
        way, back = at.model.stretches
        (a_in, _), (a_out, _) = at.radii
        held_in, held_out = a_in > 0, a_out > 0
        if min(np.count_nonzero(held_in), np.count_nonzero(held_out)) < 4:
            return None
        t_in, t_out = -at.time(way)[held_in], at.time(back)[held_out]
        (loads, stiff), P = at.nonadhesive, np.concatenate([part.P for part in at.model.stretches]) + at.here[0]
        split = way.P.size
        z = [at.model.depth(part, at.model.values(at.found.x)) for part in at.model.stretches]
        offsets = [P[:split][~held_in].mean() if (~held_in).any() else 0.0, 0.0]
        offsets[1] = P[split:][~held_out].mean() if (~held_out).any() else 0.0
        d_in = (z[0] - (P[:split] - offsets[0]) / at.model.k)[held_in]
        d_out = (z[1] - (P[split:] - offsets[1]) / at.model.k)[held_out]
        change = _hereditary(memory, (t_in, loads[:split][held_in], d_in, a_in[held_in]),
                             (t_out, d_out, a_out[held_out]), stiff[split:][held_out])  # fmt: skip
        column = np.zeros(at.a.size)
        column[np.concatenate([held_in, held_out])] = np.concatenate(change)
        return column * at.yields

    return look


def _fall(lasting: float, values: Values) -> dict[str, float]:
    told = {"fall": values[AMOUNT]}
    return told | ({TIME: lasting * values[TIME]} if TIME in values else {})


def _relaxed(
    at: Situation, law: Callable[[Values], Relaxation]
) -> Callable[[ForceCurveModel, DirectionReadings, Values], Array]:
    """Loads [N] of all rows of a stretch of a body that relaxes, by its whole history."""
    way, back = at.model.stretches
    values, thin = at.model.values(at.found.x), slice(None, None, max(way.P.size // TUNING.pieces, 1))
    deflected = [(part.P - base_line(part, values)[0]) / at.model.k for part in (way, back)]
    x = np.concatenate([(way.z - deflected[0])[thin], [at.tip_turn], (back.z - deflected[1])[::-1][thin]])
    t = np.concatenate([way.t[thin], [0.0], back.t[::-1][thin]])
    order = np.argsort(t, kind="stable")
    body = at.body.to_depth(TUNING.deeper * at.reach)
    nonadhesive = Nonadhesive(body.series, body.slopes)

    @lru_cache(maxsize=TUNING.histories)
    def history(z0: float, moduli: Hashable) -> tuple[CubicSpline, ...]:
        contact = RelaxingContact(nonadhesive, cast(Relaxation, moduli), coarser=TUNING.coarser, grows=TUNING.grows)
        try:
            path = contact.history(Program(t[order], x[order] - z0)).path
            lost = min(path.lost, float(t.max()))
            both = [_dense_at_ends(*ends) for ends in ((path.begin, path.turn), (path.turn, lost))]
            return tuple(CubicSpline(one, path.states(one)[2] ** TUNING.smooth) for one in both)
        except InputError:  # there is no such history
            return (CubicSpline([t.min(), t.max()], [0.0, 0.0]),) * 2

    def load(model: ForceCurveModel, part: DirectionReadings, values: Values) -> Array:
        own = history(values["z0"], cast(Hashable, law(values)))[int(part.kind != APPROACH)]
        P: Array = np.maximum(own(np.clip(part.t, *own.x[[0, -1]])), 0.0) ** (1 / TUNING.smooth)
        return math.exp(values["ln_s"]) * np.where((part.t >= own.x[0]) & (part.t <= own.x[-1]), P, 0.0)

    return load


def _dense_at_ends(first: float, last: float) -> Array:
    place: Array = (1 - np.cos(math.pi * np.linspace(0, 1, TUNING.times))) / 2
    return first + (last - first) * place


def _hereditary(
    memory: Callable[[Array], Array], way: tuple[Array, ...], back: tuple[Array, ...], S: Array
) -> tuple[Array, Array]:
    """Changes of load on the way in and back, per amount: rows of the way in with time, P_H, delta and a in the order
    of time; of the way back with time, delta and a in the order of position, and its contact stiffness."""
    t, P, d, a = way
    u, e, b = (item[::-1] for item in back)
    pick, last = (np.unique(np.linspace(0, n - 1, TUNING.instants).astype(int)) for n in (t.size, u.size))
    t, P, d, a = t[pick], P[pick], d[pick], np.maximum.accumulate(a[pick])
    v, e, b, S = u[last], e[last], b[last], S[::-1][last]
    middle, dP = np.append(t[0], (t[1:] + t[:-1]) / 2), np.diff(P, prepend=0.0)
    into = -np.where(t[:, None] >= middle, memory(np.maximum(t[:, None] - middle, 0)), 0.0) @ dP
    first = np.interp(b, a, t)
    held = np.where(middle <= first[:, None], memory(v[:, None] - middle), 0.0) @ dP
    times = np.concatenate([middle, (v + np.append(0.0, v[:-1])) / 2])
    steps = np.diff(np.concatenate([d, e]), prepend=d[0])
    among = (times > first[:, None]) & (times <= v[:, None])
    since = np.where(among, memory(np.maximum(v[:, None] - times, 0)), 0.0) @ steps
    out = -(held + S * since)
    return np.interp(way[0], t, into), np.interp(u, v, out)[::-1]


def stiffness(at: Situation) -> Change | None:
    """Relative change of the stiffness of the device, its loads as they are: rows and the turn are deeper by P/k of
    it."""
    if not math.isfinite(at.model.k):
        return None
    column, values, part = at.by_position * at.loads, at.model.values(at.found.x), at.model.stretches[-1]
    resting = at.model.rest(part, values)
    if resting is not None and "z0" in at.found.names:
        by_turn = -at.here[1][:, at.found.names.index("z0")] - at.by_position
        column = column + by_turn * float(resting.at(np.array(part.turn - values["z0"]))[0])
    return Change(
        ((0.0,),),
        limits={AMOUNT: (LITTLE - 1, math.inf)},
        model=lambda plain, part, values: replace(plain, k=plain.k * (1 + values[AMOUNT])),
        told=lambda values: {"stiffness": at.model.k * (1 + values[AMOUNT])},
        column=column / at.model.k,
    )


def of_return(place: Callable[[Situation, DirectionReadings], Array], name: str = AMOUNT) -> Look:
    """An error of the positions of the retraction against the approach [m per amount], told by a ``name``."""

    def look(at: Situation) -> Change | None:
        return _moved(at, lambda part: place(at, part) if part.kind != APPROACH else np.zeros(part.z.size), name)

    return look


def _moved(at: Situation, place: Callable[[DirectionReadings], Array], name: str = AMOUNT) -> Change | None:
    if len(at.model.stretches) < 2 or name in at.model.positions:
        return None
    return Change(
        ((0.0,),), moved=lambda part, values: values[AMOUNT] * place(part), told=lambda values: {name: values[AMOUNT]},
        column=at.by_position * np.concatenate([place(part) for part in at.model.stretches]),
    )  # fmt: skip


def _scaled(at: Situation, part: DirectionReadings) -> Array:
    return at.reach * part.way


def drifting(at: Situation) -> Change | None:
    """Drift of the depth, in units of the way in contact over the time of the record."""
    if "drift" in at.model.positions:
        return None
    return _moved(at, lambda part: (1.0 if part.kind == APPROACH else -1.0) * at.time(part) * at.reach)


def of_retraction(at: Situation) -> Change | None:
    """Another modulus on the way back."""
    if len(at.model.stretches) < 2 or "ln_s" not in at.found.names or at.back is None:
        return None

    def changes(family: Family, amount: float) -> Array:
        same = np.zeros_like(grid(family))
        return of_body(family, same, same + math.log1p(amount))

    column = at.only(at.back, at.here[1][:, at.found.names.index("ln_s")])
    return replace(of_family(changes, (LITTLE - 1, math.inf), last=True), column=column)


def slope_at_rest(at: Situation) -> Array | None:
    """Another slope of the line on which the edge rests, about the turn."""
    part = at.back
    if part is None:
        return None
    rests = at.radii[at.model.stretches.index(part)][1]
    if np.count_nonzero(rests) < 3:
        return None
    column, rows = np.zeros(at.a.size), at.rows(part, rests)
    column[rows] = (at.by_position * at.yields)[rows] * (part.z[rests] - part.turn)
    return column


def _bow(at: Situation, part: DirectionReadings) -> Array:
    return part.travel * hysteresis(part.way)


def _creep(at: Situation, part: DirectionReadings) -> Array:
    return part.travel * creep(at.time(part))


def _dent(at: Situation, part: DirectionReadings) -> Array:
    return np.full(part.z.size, -at.reach)


BODY, TIP, ADHESION, DEVICE, MEMORY = "layer or base", "shape of the tip", "adhesion", "device", "relaxation or flow"
RANGE = Rival("adhesion of finite range", ADHESION, "square of the range over that of a narrow ring", finite_range,
              positive=True)  # fmt: skip
LONG = Rival("adhesion of long range (DMT)", ADHESION, "from JKR to DMT", long_range, positive=True, possible=1.0)
TENSION = Rival("surface tension", BODY, "2 tension/E* over the contact radius", tension, positive=True)
RIVALS: tuple[Rival, ...] = (
    Rival("w over the contact radius", ADHESION, "relative rise towards pull-off", work_over_radius),
    Rival("w over the speed of the edge", ADHESION, "relative rise per factor e of the speed", work_over_speed),
    RANGE,
    LONG,
    Rival("a rigid base below", BODY, "contact radius over depth", layer_below),
    Rival("thickness of the layer", BODY, "relative change", of_layer("h")),
    Rival("nu of the layer", BODY, "relative change", of_layer("nu")),
    Rival("moduli that change with the contact radius", BODY, "relative rise", graded),
    Rival("exponent of the tip", TIP, "change of the exponent", exponent, TUNING.shape, possible=TUNING.cone),
    Rival("sphere or paraboloid", TIP, "share of the sphere's quartic term", quartic, possible=1.0),
    Rival("no slip", BODY, "from none to full", no_slip, 1.0, True),
    TENSION,
    Rival("large strains", BODY, "of what is known of them", strains, 1.0, True, TUNING.strains),
    Rival("relaxation over a factor of time", MEMORY, "fall per factor e",
          relaxing(lambda t: np.log1p(100 * t), lambda values, lasting: PowerRelaxation(lasting, values[AMOUNT]),
                   starts=((0.1,), (0.3,)), limits={AMOUNT: (1e-4, 0.9)})),
    Rival("relaxation of one time", MEMORY, "fall",
          relaxing(lambda t: 1 - np.exp(-4 * t),
                   lambda values, lasting: StandardSolid(1 - values[AMOUNT], lasting * values[TIME]),
                   names=(AMOUNT, TIME), starts=((0.3, 0.03), (0.3, 0.2), (0.6, 0.5)),
                   limits={AMOUNT: (1e-4, 0.999), TIME: (1e-3, 10.0)})),
    Rival("residual depth", MEMORY, "of the depth of contact", of_return(_dent), of_directions=True),
    Rival("another modulus on the way back", MEMORY, "relative change", of_retraction, of_directions=True),
    Rival("another slope at rest", MEMORY, "relative change", slope_at_rest, of_directions=True),
    Rival("stiffness of the device", DEVICE, "relative change", stiffness, possible=TUNING.device),
    Rival("creep of the position", DEVICE, "of the travel, per decade of time", of_return(_creep, "creep"),
          of_directions=True),
    Rival("hysteresis of the position", DEVICE, "of the travel, at most", of_return(_bow, "hysteresis"),
          of_directions=True),
    Rival("scale of the position", DEVICE, "retraction against approach", of_return(_scaled), of_directions=True),
    Rival("drift of the depth", DEVICE, "of the depth over the record", drifting, of_directions=True),
)  # fmt: skip


class Known(NamedTuple):
    """What the user knows before the data: the longest ``range`` of adhesion [m], inf where nothing is, and the largest
    surface ``tension`` [N/m], 0 where nothing is; and the ``level`` of intervals."""

    range: float = math.inf
    tension: float = 0.0
    level: float = 0.95

    @property
    def wide(self) -> float:
        """Half-width of what is stated, in standard errors."""
        return float(ndtri((1 + self.level) / 2))


def known_amount(at: Situation, rival: Rival, known: Known) -> float:
    """The amount of a rival in either direction that is likely."""
    if rival.look is finite_range and at.work:
        return amount_of_range(at, known.range if math.isfinite(known.range) else TUNING.longest)
    if rival.look is tension:
        return tension_amount(at, known.tension)
    R = at.body.problem.indenter.tip_radius
    if rival.look is strains and R is not None and at.widest <= LIMITS.a_over_R * R:
        return 0.0  # linear theory is taken as good up to there, as everywhere else
    return rival.likely


def columns(at: Situation, rivals: Sequence[Rival] = RIVALS) -> dict[Rival, Array]:
    """The columns of all rivals that mean anything for a record, by rival."""
    found = {}
    for rival in rivals:
        try:
            look = rival.look(at)
            column = at.column(look) if isinstance(look, Change) else look
        except (JkrError, FloatingPointError):
            continue  # a neighbouring body that cannot be solved is no rival, and takes no fit with it
        if column is not None and np.isfinite(column).all() and column.any():
            found[rival] = column
    return found
