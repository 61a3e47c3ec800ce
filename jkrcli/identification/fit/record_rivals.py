"""The rivals of a raw record: what the model leaves out, each as the change of all loads that a little of it makes.

``RIVALS`` is the list: an entry is a name, its family, what its amount is, how much of it is likely before the data,
and a function from the fit to a column: the derivative of the loads [N] by the amount, at fixed positions of the
device. Most columns are one more evaluation of the path of the device: on a body whose functions differ a little
(``Bent``), at other positions, at another stiffness. ``scores`` asks the data for each.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy.integrate import cumulative_trapezoid
from scipy.interpolate import CubicSpline

from ...adhesion.validity import LIMITS
from ...base.arrays import Array
from ...base.errors import JkrError
from ...bodies.indenters import Paraboloid, Sphere
from ...bodies.problem import HalfSpace, Layer, Loading, Rigid, Specimen
from ...data.measured.curve import APPROACH
from ...methods.layered.layered import unbounded
from .body import FittedBody, solved
from .device_path import grid, on_grid
from .family import Family
from .force_curve import DirectionReadings, ForceCurveFit, ForceCurveModel


@dataclass(frozen=True)
class RecordRivalTuning:
    """Amounts of which columns are taken, and what is known of rivals before the data."""

    little: float = 1e-3  # theory: relative amounts whose squares are below the noise of any record
    thick: float = 3.0  # choice: of the largest contact radius, the layer that a half-space is compared with
    under: tuple[float, float] = (3e-3, 0.5)  # of its thickness, radii it is solved at; theory: up to a contact of 0.44
    radii: int = 60  # choice: splines between them err by less than what a rival is told to
    decades: int = 4  # choice: such layers to a decade of thickness, so that many curves share one solve
    neighbour: float = 0.02  # choice: of thickness and nu, for differences of two bodies
    zone: float = 0.01  # choice: of the contact radius, width of the ring of attraction
    skin: float = 0.01  # choice: of the contact radius, length kappa of tension
    finest: float = 4.0  # theory: of kappa, below which the expansion for small kappa is not used
    same: float = 1e-6  # choice: relative difference of bodies below which they are one, errors of their solution
    widest_rim: float = 0.3  # choice: of the contact radius, a ring with which the search for its width begins
    steps: int = 12  # choice: of Newton's method for it; it needs four
    times: int = 150  # choice: instants at which hereditary integrals are taken
    longest: float = 10e-9  # choice: [m], range of adhesion that is likely; of molecules a nanometre, of hairs more
    cone: float = 1.0  # theory: exponent by which a cone's profile differs from a paraboloid's, and a cylinder's more
    strains: float = 2.0  # choice: of the effect of large strains on rubber, that of other materials
    device: float = 1.0  # choice: relative, by which a stiffness that someone measured may be off
    shape: float = 0.005  # choice: exponent of the profile within which a tip is what it is called


TUNING = RecordRivalTuning()
# Linear theory over the load of a neo-Hookean half-space under a rigid tip at equal depth, less 1, over the contact
# radius by the tip's, without friction; theory: finite elements, nu = 0.49, on two meshes.
STRAINS = {
    Paraboloid: ((0.0, 0.2, 0.3, 0.5, 0.7, 0.8), (0.0, 0.015, 0.026, 0.056, 0.108, 0.15)),
    Sphere: ((0.0, 0.2, 0.3, 0.5, 0.7, 0.8), (0.0, 0.010, 0.016, 0.029, 0.047, 0.061)),
}


@dataclass(frozen=True, eq=False)
class Bent(Family):
    """A family whose four logs differ by ``change``, a spline over log a (n, 4), constant beyond its ends."""

    change: CubicSpline | None = None

    def at(self, u: Array) -> tuple[Array, Array, Array]:
        assert self.change is not None
        value, by_u, by_uu = super().at(u)
        near = np.clip(u, self.change.x[0], self.change.x[-1])
        g, first, second = (self.change(near, order).T for order in range(3))
        factor = np.exp(g)
        return (
            factor * value, factor * (by_u + first * value),
            factor * (by_uu + 2 * first * by_u + (second + first**2) * value),
        )  # fmt: skip


@dataclass(frozen=True, eq=False)
class Situation:
    """A fit of a record of a ``body``, as rivals look at it."""

    body: FittedBody
    found: ForceCurveFit

    @property
    def model(self) -> ForceCurveModel:
        return self.found.model

    @cached_property
    def here(self) -> tuple[Array, Array]:
        """Residuals [N] of all rows and their derivatives by the unknowns."""
        return self.model.residuals(self.found.x, 0.0)

    @cached_property
    def back(self) -> DirectionReadings | None:
        """The retraction."""
        return next((part for part in self.model.stretches if part.kind != APPROACH), None)

    @cached_property
    def radii(self) -> list[tuple[Array, Array]]:
        """Contact radius [m] of the rows of each stretch, and which of them rest."""
        values = self.model.values(self.found.x)
        return [self.model.contact_radii(part, values) for part in self.model.stretches]

    @cached_property
    def a(self) -> Array:
        """Contact radius [m] of all rows, 0 where they are free."""
        return np.concatenate([a for a, _ in self.radii])

    @cached_property
    def widest(self) -> float:
        """Largest contact radius [m]."""
        return float(self.a.max())

    @cached_property
    def modulus(self) -> float:
        """Factor of the body's moduli."""
        return math.exp(self.model.values(self.found.x)["ln_s"])

    @cached_property
    def work(self) -> float:
        """The largest w of the directions [J/m^2], 0 where none adheres."""
        values = self.model.values(self.found.x)
        return max(0.0, *(values[f"q:{part.kind}"] for part in self.model.stretches)) * self.modulus

    @cached_property
    def by_position(self) -> Array:
        """Derivative of the loads by the position of the device [N/m], its turn where it is."""
        step = TUNING.little * min(part.reach for part in self.model.stretches)
        return self.moved(lambda part: np.full(part.z.size, step)) / step

    @property
    def yields(self) -> Array:
        """What is left at fixed position of a change of load at fixed displacement."""
        return 1 - self.by_position / self.model.k

    def of(self, model: ForceCurveModel) -> Array:
        """Change of the loads [N] in another model of the same unknowns."""
        return model.residuals(self.found.x, 0.0)[0] - self.here[0]

    def moved(self, by: Callable[[DirectionReadings], Array]) -> Array:
        """Change of the loads [N] where rows stand elsewhere ``by`` [m]; base lines stay."""
        values = self.model.values(self.found.x)
        parts = tuple(replace(part, z=part.z + by(part)) for part in self.model.stretches)
        tilts = [values[f"tilt:{old.kind}"] * (new.z - new.z[0] - old.z + old.z[0])
                 for old, new in zip(self.model.stretches, parts, strict=True)]  # fmt: skip
        return self.of(replace(self.model, stretches=parts)) - np.concatenate(tilts)

    def on(self, changes: Array) -> Array:
        """Change of the loads [N] where the logs of D, T, H, V change by ``changes`` (4, n) on the grid."""
        family = self.model.family
        spline = CubicSpline(grid(family), changes.T)
        return self.of(replace(self.model, family=Bent(family.logs, family.low, family.high, None, spline)))

    def neighbour(self, other: Family, size: float) -> Array:
        """Derivative of the loads by an amount ``size`` of which makes the body that of ``other``."""
        own = self.model.family
        inside = np.clip(grid(own), max(own.low, other.low), min(own.high, other.high))
        change = np.log(other.at(inside)[0] / own.at(inside)[0])
        return self.on(TUNING.little * change) / (TUNING.little * size)

    def of_body(self, D: Array, S: Array) -> Array:
        """Derivative of the loads by the size of relative changes of displacement and stiffness, on the grid: the load
        follows by dP = S d(delta), adhesion by S'."""
        u, e = grid(self.model.family), TUNING.little
        (d, t, h, v), (dD, dT, _, dV), _ = on_grid(self.model.family)
        s, ds = v / t, v / t * (dV / v - dT / t)
        dS = np.exp(e * S) * (ds + s * e * np.gradient(S, u, edge_order=2))
        rate = s * np.exp(e * (S + D)) * (dD + d * e * np.gradient(D, u, edge_order=2))
        H = h + cumulative_trapezoid(rate - s * dD, u, initial=0.0)
        T = np.log(ds / dS) / 2
        return self.on(np.stack([e * D, T, np.log(H / h), e * S + T])) / e

    def only(self, part: DirectionReadings, column: Array) -> Array:
        """A column on the rows of one stretch, 0 on the others."""
        own = np.concatenate([np.full(one.P.size, one is part) for one in self.model.stretches])
        return np.where(own, column, 0.0)

    def time(self, part: DirectionReadings) -> Array:
        """Time since the turn, in units of a whole record; by the number of rows where no column tells it."""
        spans = [float(np.ptp(one.t)) for one in self.model.stretches]
        if min(spans) > 0:
            return np.abs(part.t) / sum(spans)
        return np.abs(part.rows - part.rows[-1]) / sum(float(np.ptp(one.rows)) for one in self.model.stretches)


Column = Callable[[Situation], Array | None]


@dataclass(frozen=True)
class Rival:
    """One thing that the model leaves out. ``family``: what cannot be told from it as a rule; ``amount``: what a column
    is the derivative by, in words; ``column``: None where the rival has no meaning for this record.

    ``likely``: amount in either direction that is expected unless the user or the data say otherwise: 0 of what the
    description of the body rules out; ``positive``: in that direction only; ``possible``: the largest that any body,
    tip or device has. ``of_directions``: whether it sets one direction against the other.
    """

    name: str
    family: str
    amount: str
    column: Column
    likely: float = 0.0
    positive: bool = False
    possible: float = math.inf
    of_directions: bool = False


def work_over_radius(at: Situation) -> Array | None:
    """w of the last direction that rises as the contact shrinks, 0 at the largest radius and 1 at the smallest."""
    part = at.model.stretches[-1]
    a = at.radii[-1][0]
    if not at.work or not (a > 0).any():
        return None
    place = np.clip((at.widest - np.exp(grid(at.model.family))) / (at.widest - a[a > 0].min() + 1e-9 * at.widest), 0, 1)
    zero = np.zeros_like(place)
    e = TUNING.little
    return at.only(part, at.on(e / 2 * np.stack([zero, place, zero, place])) / e)


def work_over_speed(at: Situation) -> Array | None:
    """w of the retraction over the log of the speed of its edge."""
    part, values = at.back, at.model.values(at.found.x)
    name = "" if part is None else f"q:{part.kind}"
    if part is None or name not in at.found.names:
        return None
    a, rests = at.radii[at.model.stretches.index(part)]
    moves = (a > 0) & ~rests
    z, rows = np.unique(part.z[moves], return_index=True)  # readings of a position repeat
    if z.size < 3:
        return None
    speed = np.ones(part.z.size)
    speed[moves] = np.interp(part.z[moves], z, np.maximum(np.abs(np.gradient(a[moves][rows], z)), 1e-9))
    log = np.zeros(at.a.size)
    log[np.concatenate([moves if one is part else np.zeros(one.z.size, bool) for one in at.model.stretches])] = np.log(
        speed[moves] / np.median(speed[moves])
    )
    return at.here[1][:, at.found.names.index(name)] * values[name] * log


def layer_below(at: Situation) -> Array | None:
    """A rigid base at a depth, in contact radii over it; of a half-space only."""
    specimen = at.body.problem.specimen
    if specimen.layers or specimen.radius is not None or not isinstance(specimen.base, HalfSpace):
        return None
    h = TUNING.thick * at.widest
    h = 10 ** (round(math.log10(h) * TUNING.decades) / TUNING.decades)
    layer = Specimen((Layer(specimen.base.material, h),), Rigid())
    problem = replace(unbounded(at.body.problem), specimen=layer)
    radii = tuple((h * np.geomspace(*TUNING.under, TUNING.radii)).tolist())
    other = solved(replace(problem, loading=Loading.given("radius", radii)), at.body.tolerance)
    return at.neighbour(other, at.widest / h)


def of_layer(quantity: str) -> Column:
    """The relative change of ``quantity`` ("h" or "nu") of the layer in contact; nu towards 1/2 at most."""

    def column(at: Situation) -> Array | None:
        if not at.body.own_parameters or not at.body.problem.specimen.layers:
            return None
        name = f"{quantity}:{at.body.layer_names[0]}"
        other = at.body.with_values({name: at.body.nominal(name) * (1 - TUNING.neighbour)})
        return at.neighbour(other.family, -TUNING.neighbour)

    return column


def graded(at: Situation) -> Array:
    """Stiffness that rises in proportion to the contact radius."""
    place = np.exp(grid(at.model.family)) / at.widest
    return at.of_body(np.zeros_like(place), place)


def exponent(at: Situation) -> Array:
    """Exponent of the profile, the tip as it was at the largest radius."""
    return at.of_body(*_of_tip(grid(at.model.family) - math.log(at.widest)))


def quartic(at: Situation) -> Array | None:
    """From the paraboloid to the sphere of the same radius."""
    R = at.body.problem.indenter.tip_radius
    if R is None:
        return None
    return at.of_body(*_of_tip(np.minimum(np.exp(grid(at.model.family)) / R, 1.0) ** 2 / 3))


def _of_tip(D: Array) -> tuple[Array, Array]:
    return D, np.zeros_like(D)


def no_slip(at: Situation) -> Array | None:
    """From surfaces that slide to such as do not."""
    problem = at.body.problem
    if problem.sticks or problem.specimen.radius is not None:
        return None
    other, u = at.body.on_surface("sticking").family, np.array([at.model.family.high])
    same = np.abs(np.log(other.at(u)[0] / at.model.family.at(u)[0])).max() < TUNING.same
    return None if same else at.neighbour(other, 1.0)


def finite_range(at: Situation) -> Array | None:
    """The square of the range of adhesion, over that of which the ring of attraction is narrow (Maugis, J. Colloid
    Interface Sci. 150 (1992) 243, of a half-space; of other bodies near the edge only)."""
    if not at.work:
        return None
    u, w, E = grid(at.model.family), at.work, at.modulus * at.body.problem.E_star
    a, (D, _, _, _) = np.exp(u), on_grid(at.model.family)[0]
    sigma = w / narrow_range(at)
    m = _rim(a, D, E, w, sigma)
    root, angle = np.sqrt(m**2 - 1), np.arccos(1 / m)
    shift = 2 * sigma * a * root / E / np.sqrt(2 * math.pi * a * w / E)  # over those of JKR
    pull = 2 * sigma * a**2 * (root + m**2 * angle) / np.sqrt(8 * math.pi * w * E * a**3)
    zero = np.zeros_like(a)
    return at.on(TUNING.little * np.stack([zero, np.log(shift), zero, np.log(pull)])) / TUNING.little


def narrow_range(at: Situation) -> float:
    """The range z0 [m] of which the ring is ``TUNING.zone`` wide at the largest radius: d = pi E* z0^2/(4 w)."""
    return math.sqrt(4 * TUNING.zone * at.widest * at.work / (math.pi * at.modulus * at.body.problem.E_star))


def _rim(a: Array, D: Array, E: float, w: float, sigma: float) -> Array:
    """Ratio m of outer to inner radius where a constant tension ``sigma`` releases ``w``, by secants in sqrt(m - 1)."""

    def released(x: Array) -> Array:
        m = 1 + x**2
        root, angle = np.sqrt(m**2 - 1), np.arccos(1 / m)
        own: Array = 4 * sigma**2 * a / (math.pi * E) * (root * angle - m + 1)
        return own + sigma * D / math.pi * (root + (m**2 - 2) * angle)

    x = np.sqrt(np.minimum(math.pi * E * w / (4 * sigma**2 * a), TUNING.widest_rim))
    for _ in range(TUNING.steps):
        here = released(x)
        rate = (released(x * (1 + TUNING.little)) - here) / (x * TUNING.little)
        x = np.clip(x - (here - w) / rate, x / 3, 3 * x)
    return 1 + x**2


def tension(at: Situation) -> Array | None:
    """Surface tension of a half-space, its length kappa = 2 Ups/E* over the largest radius; first order in kappa/a."""
    specimen = at.body.problem.specimen
    if specimen.layers or specimen.radius is not None:
        return None
    kappa = TUNING.skin * at.widest
    a = np.maximum(np.exp(grid(at.model.family)), TUNING.finest * kappa)
    x, log = kappa / (math.pi * a), np.log(2 * a / kappa) + float(np.euler_gamma)
    changes = np.stack([2 * x * (log - 1), -x / 2, 3 * x * log, x * (log + 1) - x / 2])
    return at.on(TUNING.little * changes) / (TUNING.little * TUNING.skin)


def strains(at: Situation) -> Array | None:
    """What linear theory leaves out at large strains, as far as it is known: of half-spaces."""
    problem = at.body.problem
    told = next((told for kind, told in STRAINS.items() if isinstance(problem.indenter, kind)), None)
    if told is None or problem.specimen.layers or problem.indenter.tip_radius is None:
        return None
    excess = np.interp(at.a / problem.indenter.tip_radius, *told)
    return -excess / (1 + excess) * nonadhesive_load(at) * at.yields


def nonadhesive_load(at: Situation) -> Array:
    """Load [N] of all rows at their contact radii without adhesion."""
    H = at.model.family.at(np.log(np.maximum(at.a, 1e-6 * at.widest)))[0][2]
    return np.where(at.a > 0, at.modulus * H, 0.0)


def relaxing(memory: Callable[[Array], Array]) -> Column:
    """Moduli that fall by an amount of ``memory`` of the time since the strain, in units of the record (Ting 1966)."""

    def column(at: Situation) -> Array | None:
        if len(at.model.stretches) < 2:
            return None
        way, back = at.model.stretches
        (a_in, _), (a_out, _) = at.radii
        held_in, held_out = a_in > 0, a_out > 0
        if min(np.count_nonzero(held_in), np.count_nonzero(held_out)) < 4:
            return None
        t_in, t_out = -at.time(way)[held_in], at.time(back)[held_out]
        loads, P = nonadhesive_load(at), np.concatenate([part.P for part in at.model.stretches]) + at.here[0]
        split = way.P.size
        z = [at.model.depth(part, at.model.values(at.found.x)) for part in at.model.stretches]
        offsets = [P[:split][~held_in].mean() if (~held_in).any() else 0.0, 0.0]
        offsets[1] = P[split:][~held_out].mean() if (~held_out).any() else 0.0
        d_in = (z[0] - (P[:split] - offsets[0]) / at.model.k)[held_in]
        d_out = (z[1] - (P[split:] - offsets[1]) / at.model.k)[held_out]
        change = _hereditary(memory, (t_in, loads[:split][held_in], d_in, a_in[held_in]),
                             (t_out, d_out, a_out[held_out]), _stiffness(at, a_out[held_out]))  # fmt: skip
        column = np.zeros(at.a.size)
        column[np.concatenate([held_in, held_out])] = np.concatenate(change)
        return column * at.yields

    return column


def _stiffness(at: Situation, a: Array) -> Array:
    _, T, _, V = at.model.family.at(np.log(a))[0]
    stiffness: Array = at.modulus * V / T
    return stiffness


def _hereditary(
    memory: Callable[[Array], Array], way: tuple[Array, ...], back: tuple[Array, ...], S: Array
) -> tuple[Array, Array]:
    """Changes of load on the way in and back, per amount: rows of the way in with time, P_H, delta and a in the order
    of time; of the way back with time, delta and a in the order of position, and its contact stiffness."""
    t, P, d, a = way
    u, e, b = (item[::-1] for item in back)
    pick, last = (np.unique(np.linspace(0, n - 1, TUNING.times).astype(int)) for n in (t.size, u.size))
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


def stiffness(at: Situation) -> Array | None:
    """Relative change of the stiffness of the device, its loads as they are."""
    e = TUNING.little
    return at.of(replace(at.model, k=at.model.k * (1 + e))) / e if math.isfinite(at.model.k) else None


def of_return(place: Callable[[Situation, DirectionReadings], Array]) -> Column:
    """An error of the positions of the retraction against the approach, in units of the way in contact."""

    def column(at: Situation) -> Array | None:
        if len(at.model.stretches) < 2:
            return None
        reach = max(part.reach for part in at.model.stretches)
        e = TUNING.little * reach
        return at.moved(lambda part: e * place(at, part) if part is at.back else np.zeros(part.z.size)) / TUNING.little

    return column


def _way(at: Situation, part: DirectionReadings) -> Array:
    """From 0 at the turn to 1 at the far end."""
    return (part.turn - part.z) / float(part.turn - part.z.min())


def drifting(at: Situation) -> Array | None:
    """Drift of the depth, in units of the way in contact over the time of the record."""
    if len(at.model.stretches) < 2:
        return None
    reach = max(part.reach for part in at.model.stretches)
    sign = {part.kind: -1.0 if part is at.back else 1.0 for part in at.model.stretches}
    e = TUNING.little * reach
    return at.moved(lambda part: e * sign[part.kind] * at.time(part)) / TUNING.little


def of_retraction(at: Situation) -> Array | None:
    """Another modulus on the way back."""
    if len(at.model.stretches) < 2 or "ln_s" not in at.found.names or at.back is None:
        return None
    return at.only(at.back, at.here[1][:, at.found.names.index("ln_s")])


def slope_at_rest(at: Situation) -> Array | None:
    """Another slope of the line on which the edge rests, about the turn."""
    part = at.back
    if part is None:
        return None
    rests = at.radii[at.model.stretches.index(part)][1]
    if np.count_nonzero(rests) < 3:
        return None
    column = np.zeros(at.a.size)
    rows = np.concatenate([rests if one is part else np.zeros(one.z.size, bool) for one in at.model.stretches])
    column[rows] = (at.by_position * at.yields)[rows] * (part.z[rests] - part.turn)
    return column


def _bow(at: Situation, part: DirectionReadings) -> Array:
    way = _way(at, part)
    return 4 * way * (1 - way)


def _creep(at: Situation, part: DirectionReadings) -> Array:
    return np.log1p(100 * at.time(part))


def _dent(at: Situation, part: DirectionReadings) -> Array:
    return -np.ones(part.z.size)


BODY, TIP, ADHESION, DEVICE, MEMORY = "layer or base", "shape of the tip", "adhesion", "device", "relaxation or flow"
RIVALS: tuple[Rival, ...] = (
    Rival("w over the contact radius", ADHESION, "relative rise towards pull-off", work_over_radius),
    Rival("w over the speed of the edge", ADHESION, "relative rise per factor e of the speed", work_over_speed),
    Rival("adhesion of finite range", ADHESION, "square of the range over that of a narrow ring", finite_range,
          positive=True),
    Rival("a rigid base below", BODY, "contact radius over depth", layer_below),
    Rival("thickness of the layer", BODY, "relative change", of_layer("h")),
    Rival("nu of the layer", BODY, "relative change", of_layer("nu")),
    Rival("moduli that change with the contact radius", BODY, "relative rise", graded),
    Rival("exponent of the tip", TIP, "change of the exponent", exponent, TUNING.shape, possible=TUNING.cone),
    Rival("sphere or paraboloid", TIP, "share of the sphere's quartic term", quartic, possible=1.0),
    Rival("no slip", BODY, "from none to full", no_slip, 1.0, True),
    Rival("surface tension", BODY, "2 tension/E* over the contact radius", tension, positive=True),
    Rival("large strains", BODY, "of what is known of them", strains, 1.0, True, TUNING.strains),
    Rival("relaxation over a factor of time", MEMORY, "fall per factor e", relaxing(lambda t: np.log1p(100 * t))),
    Rival("relaxation of one time", MEMORY, "fall", relaxing(lambda t: 1 - np.exp(-4 * t))),
    Rival("residual depth", MEMORY, "of the depth of contact", of_return(_dent), of_directions=True),
    Rival("another modulus on the way back", MEMORY, "relative change", of_retraction, of_directions=True),
    Rival("another slope at rest", MEMORY, "relative change", slope_at_rest, of_directions=True),
    Rival("stiffness of the device", DEVICE, "relative change", stiffness, possible=TUNING.device),
    Rival("creep of the position", DEVICE, "of the depth, per factor e of time", of_return(_creep), of_directions=True),
    Rival("hysteresis of the position", DEVICE, "of the depth, at most", of_return(_bow), of_directions=True),
    Rival("scale of the position", DEVICE, "retraction against approach", of_return(_way), of_directions=True),
    Rival("drift of the depth", DEVICE, "of the depth over the record", drifting, of_directions=True),
)  # fmt: skip


def known_amount(at: Situation, rival: Rival, longest: float) -> float:
    """The amount of a rival in either direction that is likely; ``longest``: range of adhesion [m] that is."""
    if rival.column is finite_range and at.work:
        return (min(longest, TUNING.longest) / narrow_range(at)) ** 2
    R = at.body.problem.indenter.tip_radius
    if rival.column is strains and R is not None and at.widest <= LIMITS.a_over_R * R:
        return 0.0  # linear theory is taken as good up to there, as everywhere else
    return rival.likely


def columns(at: Situation, rivals: Sequence[Rival] = RIVALS) -> dict[Rival, Array]:
    """The columns of all rivals that mean anything for a record, by rival."""
    found = {}
    for rival in rivals:
        try:
            column = rival.column(at)
        except (JkrError, FloatingPointError):
            continue  # a neighbouring body that cannot be solved is no rival, and takes no fit with it
        if column is not None and np.isfinite(column).all() and column.any():
            found[rival] = column
    return found
