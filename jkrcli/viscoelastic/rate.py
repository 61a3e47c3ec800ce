"""The motion of a contact's edge while the device moves evenly: an ordinary differential equation, da/dt = -+v(G).

Near rest the edge hardly moves for long, at the end it runs away within an instant. So not time but the length s of the
path (t/T, log a) is the independent variable: ds^2 = (dt/T)^2 + (d log a)^2. LSODA changes between Adams' formulae and
the stiff ones of Gear as it goes (Petzold, SIAM J. Sci. Stat. Comput. 4 (1983) 136). A slow edge is nearly in
equilibrium, its speed that of a small excess G/w0 - 1 of large numbers: the excess is an unknown of its own, with the
slope of G along the path, and drawn to what the state gives.
"""

from __future__ import annotations

import itertools
import math
import warnings
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Annotated, Any, Protocol, TypeAlias, runtime_checkable

import numpy as np

from ..adhesion import device_path
from ..adhesion.curve import DISPLACEMENT_CONTROL, LOAD_CONTROL, AdhesiveCurve, Nonadhesive, position
from ..adhesion.device_path import UNBOUNDED, path, turning_radius
from ..base.arguments import ranges_of, read_fields
from ..base.errors import Estimate, InputError, SolveError, Unknown, did_you_mean, positive
from ..base.numerics import LOOKED_AT, MOST_STEPS, Array, zeros_between
from ..base.registry import Registry
from ..base.units import Ranged, show

# --------------------------------------------------------------------------------------------------
# Laws of the work of adhesion over the speed of the contact's edge; each is a class that registers itself.
#
# A receding edge takes w(v) >= w0, an advancing one gives back w_a^2/w(v) <= w_a: the factor of speed is the same in
# both directions, divided by when the crack closes (Greenwood, J. Phys. D 37 (2004) 2557).

Speed: TypeAlias = Annotated[float, Ranged("speed", above=0)]
Exponent: TypeAlias = Annotated[float, Ranged("number", above=0, most=100)]
PositiveWork: TypeAlias = Annotated[float, Ranged("work", above=0)]

RATE_ENDS = {"n": (0.1, 3.0)}  # choice: exponents that are sought; measured ones are 0.1 to 1
RATE_LAWS = Registry()
rate_law = RATE_LAWS.register  # decorator: the name by which ``--rate law=...`` and ``--law`` call it


@runtime_checkable
class RateLaw(Protocol):
    """w over the edge's speed: a frozen dataclass whose fields, all > 0, are its parameters."""

    def work(self, w0: Any, v: Any) -> Any:
        """w [J/m^2] at the speeds ``v`` >= 0 [m/s], of any shape; ``w0`` at v = 0, growing without bound."""

    def speed(self, w0: float, excess: float) -> float:
        """The speed [m/s] at which w is ``excess`` >= 0 [J/m^2] beyond ``w0``: the inverse of ``work``. OverflowError
        beyond all numbers."""


@rate_law("power")
@dataclass(frozen=True)
class PowerRate:
    """w = w0 (1 + (v/v0)^n) (Gent and Schultz, J. Adhesion 3 (1972) 281; Maugis and Barquins 1978)."""

    v0: Speed
    n: Exponent

    def __post_init__(self) -> None:
        read_fields(self, "power", sought=True)

    def work(self, w0: Any, v: Any) -> Any:
        return w0 * (1 + (v / self.v0) ** self.n)

    def speed(self, w0: float, excess: float) -> float:
        return self.v0 * (excess / w0) ** (1 / self.n)


@rate_law("log")
@dataclass(frozen=True)
class LogRate:
    """w = w0 + b log(1 + v/v0): bonds that break thermally activated, b the thermal energy per area of a bond
    (Schallamach, Wear 6 (1963) 375; Chaudhury, J. Phys. Chem. B 103 (1999) 6562)."""

    v0: Speed
    b: PositiveWork

    def __post_init__(self) -> None:
        read_fields(self, "log", sought=True)

    def work(self, w0: Any, v: Any) -> Any:
        return w0 + self.b * np.log1p(v / self.v0)

    def speed(self, w0: float, excess: float) -> float:
        return self.v0 * math.expm1(excess / self.b)


def rate_law_of(values: Mapping[str, Any], where: str = "rate") -> RateLaw:
    """The law from its parameters, SI or text with units: ``{"law": "power", "v0": "1 um/s", "n": 0.6}``; "power" where
    none is named. InputError that begins with ``where``."""
    name = str(values.get("law", "power"))
    if name not in RATE_LAWS:
        known = ", ".join(RATE_LAWS)
        raise InputError(f'{where}: unknown law "{name}"{did_you_mean(name, RATE_LAWS)} (laws: {known})')
    allowed, entries = rate_parameters(name), {key: value for key, value in values.items() if key != "law"}
    for key in entries:
        if key not in allowed:
            hint = did_you_mean(key, allowed, 0.4)
            raise InputError(f'{where}: the law "{name}" has no parameter "{key}"{hint} (it has: {", ".join(allowed)})')
    if missing := [key for key in allowed if key not in entries]:
        raise InputError(f'{where}: the law "{name}" needs {", ".join(missing)} too, such as v0="1 um/s"')
    for key, value in entries.items():
        try:
            entries[key] = allowed[key].read(value)
        except ValueError as error:
            raise InputError(f"{where}: {key}: {error}") from None
    law: RateLaw = RATE_LAWS[name](**entries)
    return law


def rate_parameters(name: str) -> dict[str, Ranged]:
    """The parameters of the law called ``name``, by name, with their dimensions and ranges."""
    return dict(ranges_of(RATE_LAWS[name]))


def parameters_of(law: RateLaw) -> tuple[str, dict[str, float]]:
    """The name of a law and the values of its parameters, SI."""
    values = RATE_LAWS.keys_in_file(law)
    return values.pop(RATE_LAWS.word), values


# Accuracy and bounds of the integration.
# theory: of the excess, over which it is drawn to the state's: its round-off, 1e-16 over this, is an absolute step
MOTION_DRAWN = 1e-4
# tuned on cycles at speed, by `make constants`: of the relative tolerance; the unknowns are scaled to 1
MOTION_ABSOLUTE = 1e-2
MOTION_FASTEST = 1e200  # theory: in radii per T: a speed beyond numbers, its square must not overflow
MOTION_LONGEST = 1e15  # theory: of s; beyond it the round-off of a double is longer than a step
# tuned on cycles at speed, by `make constants`: of a motion's time, at its end: contact runs away, which inertia
# would delay
MOTION_INSTANT = 1e-6
# theory: distances to a fold, over the first, at which a slow edge is looked at; D rises by the square of the last
MOTION_NEARER = np.geomspace(1, 1e-6, 200)


@dataclass(frozen=True, eq=False)
class Motion(device_path.Piece):
    """The path of the edge from one state until it rests, leaves the series or the ramp ends.

    ``path``: of s gives t/T from the ramp's begin on, log a, the works [J] of device and edge over ``energy``, and the
    excess G/w - 1; ``nodes``: the s of the integrator's steps; ``ends``: "ramp", "rest", "lost" or "series".
    """

    rule: ByLaw
    unit: float
    energy: float
    path: Callable[[Array], Array]
    nodes: Array

    @cached_property
    def steps(self) -> Array:
        """The unknowns at the nodes, shape (5, n)."""
        return self.path(self.nodes)

    @property
    def first(self) -> tuple[float, float]:
        """Time [s] and radius [m] at the begin."""
        return self.ramp.t + self.unit * float(self.steps[0, 0]), math.exp(self.steps[1, 0])

    @property
    def last(self) -> tuple[float, float]:
        """Time [s] and radius [m] at the end."""
        t = self.ramp.t_end if self.ends == "ramp" else self.ramp.t + self.unit * float(self.steps[0, -1])
        return t, math.exp(self.steps[1, -1])

    @property
    def work(self) -> float:
        """Work of the device [J]."""
        return self.energy * float(self.steps[2, -1] - self.steps[2, 0])

    @property
    def dissipated(self) -> float:
        """Work of the edge, - int G d(pi a^2) [J]: what is not stored again."""
        return self.energy * float(self.steps[3, -1] - self.steps[3, 0])

    def rows(self, points: int) -> tuple[Array, Array]:
        """Times [s] and radii [m] of ``points`` states, even in s, to the last state."""
        return self._states(np.linspace(self.nodes[0], self._last_reported, points))

    @property
    def parting(self) -> tuple[float, float]:
        """Time [s] and radius [m] of the last state that is reported: the end, or an instant before contact is lost."""
        t, a = self._states(np.array([self._last_reported]))
        return float(t[0]), float(a[0])

    @property
    def _last_reported(self) -> float:
        """The s up to which states are reported."""
        tau, end = self.steps[0], float(self.nodes[-1])
        if self.ends != "lost":
            return end
        until = tau[-1] - MOTION_INSTANT * (tau[-1] - tau[0])
        i = min(int(np.searchsorted(tau, until)), tau.size - 1)
        low = float(self.nodes[max(i - 1, 0)])
        return (
            low
            if tau[0] == until
            else float(zeros_between(lambda s: self.path(s)[0] - until, np.array([low]), self.nodes[[i]], 0.0)[0])
        )

    def at(self, t: Array) -> Array:
        """Radii [m] at the times ``t`` [s] of the motion: s by Newton's method, from the nodes."""
        tau = np.clip((t - self.ramp.t) / self.unit, self.steps[0, 0], self.steps[0, -1])
        s = np.interp(tau, self.steps[0], self.nodes)
        low, high = self.nodes[[0, -1]]
        for _ in range(MOST_STEPS):
            times, radii = self._states(s)
            rate = self.speeds(radii, self.rule.edge.state(radii, self.ramp.at(times)).G) * self.unit / radii
            step = (tau - (times - self.ramp.t) / self.unit) * np.hypot(1, rate)
            s = np.clip(s + step, low, high)
            if np.max(np.abs(step), initial=0.0) < 1e-12 * (high - low):
                break
        return self._states(s)[1]

    def lowest(self) -> tuple[float, float]:
        """Time [s] and radius [m] at the least load: at an end, or where dP/dt = 0 between two nodes."""
        if self.rule.stiffness == LOAD_CONTROL:
            return self.last if self.ramp.rate < 0 else self.first

        signs = np.sign(self._load_rate(self.nodes))
        turns = np.flatnonzero((signs[:-1] < 0) & (signs[1:] > 0))
        inner = zeros_between(self._load_rate, self.nodes[turns], self.nodes[turns + 1], 1e-12)
        times, radii = self._states(np.array([self.nodes[0], *inner, self.nodes[-1]]))
        i = int(np.argmin(self.rule.edge.state(radii, self.ramp.at(times)).P))
        return float(times[i]), float(radii[i])

    def _load_rate(self, s: Array) -> Array:
        """(1 + S/k) dP/dt [N/s] = S dx/dt - S' L da/dt; of a receding edge by the excess that was followed, which has
        less round-off than the state's."""
        t, a = self._states(s)
        here, state = self.rule.edge.body.parts(a), self.rule.edge.state(a, self.ramp.at(t))
        excess = state.G / self.rule.w - 1 if self.rule.grows else self.path(s)[4]
        return here.S * self.ramp.rate - here.dS * state.lag * self._moving(excess)

    def speeds(self, a: Array, G: Array) -> Array:
        """da/dt [m/s] at energy release rates ``G`` [J/m^2]."""
        return self._moving(G / self.rule.w - 1)

    def _moving(self, excess: Array) -> Array:
        return np.array([self.rule.speed(e) for e in excess.tolist()])

    def _states(self, s: Array) -> tuple[Array, Array]:
        tau, u, *_ = self.path(s)
        ends = self.rule.edge.body.a[[0, -1]]
        return self.ramp.t + self.unit * tau, np.clip(np.exp(u), *ends)


@dataclass(frozen=True, eq=False)
class ByLaw(device_path.EdgeRule):
    """An edge that moves by a ``law`` of its speed: infinitely slowly in equilibrium, from which it differs where the
    law's excess of w is more than ``slow``."""

    edge: device_path.Edge
    law: RateLaw
    tolerance: float
    evaluations: int
    slow: float

    @property
    def w(self) -> float:
        """Work of adhesion [J/m^2] of an edge at rest."""
        return self.curve.w

    @property
    def forms(self) -> float:
        return float(self.edge.body.a[0])

    def speed(self, excess: float) -> float:
        """da/dt [m/s] where G is ``w (1 + excess)``, within what numbers hold; 0 where the contact line is pinned."""
        if not (excess < 0 if self.grows else excess > 0):
            return 0.0
        beyond = self.w * excess if not self.grows else -self.w * excess / (1 + excess) if excess > -1 else math.inf
        try:
            v = min(self.law.speed(self.w, beyond), MOTION_FASTEST)
        except OverflowError:
            v = MOTION_FASTEST
        return v if self.grows else -v

    def move(self, ramp: device_path.Ramp, now: device_path.Now) -> Motion | device_path.Follow:
        slowly = self._slowly(ramp, now)
        if slowly is not None:
            return slowly
        return move(self, ramp, now.t, now.place)

    def _slowly(self, ramp: device_path.Ramp, now: device_path.Now) -> device_path.Follow | None:
        """How far the edge is in equilibrium; None: not at all."""
        a = now.place
        if not (self.slow and ramp.rate and self.stands(now)):
            return None
        if self._excess(ramp, np.array([a]))[0] > self.slow:
            return None
        whole = self.along(ramp, a)
        near = whole.end + (a - whole.end) * MOTION_NEARER
        fast = np.flatnonzero(self._excess(ramp, near) > self.slow)
        return whole if not fast.size else replace(whole, end=float(near[fast[0]]), ends="fast", lands=None)

    def _excess(self, ramp: device_path.Ramp, a: Array) -> Array:
        """The excess of w over that at rest, at the speed of an edge in equilibrium at the radii ``a`` [m]."""
        rises = position(*self.curve.rates(a), self.stiffness)
        v = np.divide(abs(ramp.rate), rises, out=np.full_like(a, np.inf), where=rises > 0)
        return np.asarray(self.law.work(self.w, v) / self.w - 1)


def move(rule: ByLaw, ramp: device_path.Ramp, t: float, a: float) -> Motion:
    """The motion of the edge from radius ``a`` [m] at the time ``t`` [s] of a ``ramp`` on. SolveError where the
    integrator gives up, or takes too many evaluations."""
    from scipy.integrate import solve_ivp

    # T [s]: in which the device moves by the lag at G = w, or where it stands the edge by its radius
    if ramp.rate != 0:
        adhesive = rule.edge.position_at(np.array(a), rule.w) - rule.edge.position_at(np.array(a), 0.0)
        unit_of_time = float(abs(adhesive / ramp.rate))
    else:
        G = float(rule.edge.state(np.array(a), np.array(ramp.x)).G)
        unit_of_time = a / max(abs(rule.speed(G / rule.w - 1)), a / MOTION_LONGEST)
    unit, tolerance = unit_of_time, rule.tolerance
    energy = math.pi * a**2 * rule.w
    rates = _equations(rule, ramp, unit, energy)
    excess = float(rule.edge.state(np.array(a), np.array(ramp.x + ramp.rate * (t - ramp.t))).G) / rule.w - 1
    start = [(t - ramp.t) / unit, math.log(a), 0.0, 0.0, excess]
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", "lsoda", UserWarning)  # it gives up, reported below
        try:
            solution = solve_ivp(
                rates, (0.0, MOTION_LONGEST), start, method="LSODA", rtol=tolerance, atol=tolerance * MOTION_ABSOLUTE,
                dense_output=True, events=_events(rule, ramp, unit),
            )  # fmt: skip
        except OverflowError:  # a step that was tried left all numbers
            raise _unfollowed(a) from None
    if solution.status != 1:
        raise _unfollowed(math.exp(solution.y[1, -1]))
    pressed = ramp.at(ramp.t + unit * solution.y[0, -1]) > 0  # a smaller contact outside the data remains
    names = ("ramp", "series" if rule.grows or pressed else "lost", "rest")
    ends = next(name for name, times in zip(names, solution.t_events, strict=False) if len(times))
    phase = device_path.ADVANCE if rule.grows else device_path.RECEDE
    return Motion(rule, unit, energy, solution.sol, solution.t, phase=phase, ramp=ramp, ends=ends)


def _unfollowed(a: float) -> SolveError:
    return SolveError(
        f"the motion of the contact line could not be integrated beyond a = {a:.4g} m: look at v0 and n; an "
        "instrument that is very "
        "slow against v0 makes the cycle without --rate"
    )


def _equations(rule: ByLaw, ramp: device_path.Ramp, unit: float, energy: float) -> Callable[..., list[float]]:
    """d/ds of t/T, log a, the works of device and edge over ``energy``, and the excess of a receding edge."""
    rate, x0, loaded, edge, w = ramp.rate, ramp.x, rule.stiffness == LOAD_CONTROL, rule.edge, rule.w
    give = edge.give
    count = itertools.count(1)

    def rates(_: float, y: Any) -> list[float]:
        if next(count) > rule.evaluations:
            raise _unfollowed(math.exp(float(y[1])))
        tau, u, _, _, excess = y.tolist()
        a = math.exp(u)
        (_, P_H, S, dS, by_u, bend), lag, c, G = edge.at(u, x0 + rate * unit * tau)
        v = rule.speed(G / w - 1 if rule.grows else excess) * unit
        size = math.hypot(1.0, v / a)
        P = P_H - S * lag
        moved = (lag * v * dS + rate * unit) / S if loaded else rate * unit  # of delta, or of the device
        flows = [1 / size, v / a / size, P * moved / size / energy, -2 * math.pi * a * G * v / size / energy]
        if rule.grows:
            return [*flows, 0.0]
        d_lag = (by_u - lag * a * dS * (1 if loaded else give) / c) * v / a - rate * unit / c
        d_G = G * (bend - 1) * v / a + dS * lag / (2 * math.pi * a) * d_lag
        d_excess = d_G / w / size + (G / w - 1 - excess) / max(abs(excess), MOTION_DRAWN)
        return [*flows, d_excess]

    return rates


def _events(rule: ByLaw, ramp: device_path.Ramp, unit: float) -> list[Callable[..., float]]:
    """What ends a motion: the end of the ramp, the end of the series, and rest where the device moves towards it."""
    end = math.log(rule.edge.body.a[-1 if rule.grows else 0])
    lasts = (ramp.t_end - ramp.t) / unit

    def over(_: float, y: Any) -> float:
        return float(y[0]) - lasts if math.isfinite(lasts) else -1.0

    def out(_: float, y: Any) -> float:
        return float(y[1]) - end

    def rests(_: float, y: Any) -> float:
        return rule.edge.at(float(y[1]), ramp.x + ramp.rate * unit * float(y[0]))[-1] - rule.w

    towards = ramp.rate < 0 if rule.grows else ramp.rate > 0
    events: list[Callable[..., float]] = [over, out, *([rests] if towards else [])]
    for event in events:
        event.terminal = True  # type: ignore[attr-defined]
    over.direction = 1  # type: ignore[attr-defined]
    out.direction = rests.direction = 1 if rule.grows else -1  # type: ignore[attr-defined]
    return events


# --------------------------------------------------------------------------------------------------
# The history of a contact whose edge moves at its own speed: its path under a device's program, over time.

# Accuracy of the motions, and how their error is estimated.
HISTORY_TOLERANCE = 3e-11  # choice: relative, of a step of the integrator; leaves 3e-9 of the energies
HISTORY_EVALUATIONS = 100_000  # choice: guard, six times what the slowest pull in tests takes
# tuned on curves, by `make constants`: factor of the tolerance of the second run, from whose distance the error is
# told
HISTORY_COARSER = 4.0
# tuned on curves, by `make constants`: of the tolerance, no smaller error is stated; true ones are 0.01 to 1.7 of
# it
HISTORY_FLOOR = 0.5


@dataclass(frozen=True, eq=False)
class RateContact(device_path.Contact):
    """A contact whose contact line opens by ``law`` above ``w0`` [J/m^2], in a device of ``stiffness`` [N/m].

    It advances where G is below ``w_advance`` <= w0 [J/m^2]: by ``law_advance``, or, None, at once to equilibrium.
    ``tolerance``: relative, of the integrator's steps; ``evaluations`` of the edge's speed, the most of one motion;
    ``slow``: excess of w up to which a moving edge is in equilibrium.
    """

    body: Nonadhesive
    law: RateLaw
    w0: float
    w_advance: float
    stiffness: float = DISPLACEMENT_CONTROL
    law_advance: RateLaw | None = None
    tolerance: float = HISTORY_TOLERANCE
    evaluations: int = HISTORY_EVALUATIONS
    slow: float = HISTORY_TOLERANCE  # theory: equilibrium then errs as a step of the integrator does

    def __post_init__(self) -> None:
        positive("J/m^2", w0=self.w0)
        if not 0 <= self.w_advance <= self.w0:
            raise InputError(
                f"the work of adhesion of the opening contact line must be >= that of the closing one, got "
                f"{show(self.w0, 'work')} after {show(self.w_advance, 'work')}"
            )
        if self.law_advance is not None and self.w_advance == 0:
            raise InputError("a law of closing needs a work of adhesion > 0 on approach, got 0 J/m^2")

    @cached_property
    def edge(self) -> device_path.Edge:
        return device_path.Edge(self.body, self.stiffness)

    @property
    def advancing(self) -> AdhesiveCurve:
        """The equilibria of the advancing edge."""
        return AdhesiveCurve(self.body, self.w_advance)

    @cached_property
    def advance(self) -> device_path.EdgeRule:
        if self.law_advance is None:
            return device_path.EdgeRule(self.advancing, self.stiffness, True)
        return self._by(self.law_advance, self.advancing, True)

    @cached_property
    def recede(self) -> device_path.EdgeRule:
        return self._by(self.law, AdhesiveCurve(self.body, self.w0), False)

    def _by(self, law: RateLaw, curve: AdhesiveCurve, grows: bool) -> ByLaw:
        return ByLaw(curve, self.stiffness, grows, self.edge, law, self.tolerance, self.evaluations, self.slow)

    def history(self, program: device_path.Program, start: float | None = None) -> History:
        """What happens under ``program``; ``start``: the radius [m] of a contact that is there already."""
        return replace(self.once(program, start), beside=self.coarser.once(program, start))

    def once(self, program: device_path.Program, start: float | None = None) -> History:
        """What happens over time under ``program`` from the radius ``start`` [m] on, without its error."""
        return History(**vars(path(self, program, start or 0.0)))

    @property
    def coarser(self) -> RateContact:
        """The same contact followed less exactly."""
        return replace(self, tolerance=self.tolerance * HISTORY_COARSER)

    def turning(self, load: float | None, depth: float | None, speed: float) -> float:
        """The device's position where the approach comes to ``load`` [N] or ``depth`` [m]; both None: to the end of the
        series. ``speed`` of the approach [m/s, under load control N/s], on which it depends where the crack closes by
        a law. InputError where it does not come there."""

        if self.law_advance is None:
            place = turning_radius(self.advancing, self.stiffness, load=load, depth=depth)
            return self.advance.position(place)
        quantity, value = ("P", load) if depth is None else ("delta", depth)
        if value is None:
            raise InputError("cycle: a contact line that closes by a law needs a reversal: --to-load or --to-depth")
        try:
            x = self.once(device_path.Program.on(self.least, speed)).position_where(quantity, value)
        except SolveError as error:
            raise InputError(f"cycle: {error}") from None
        if x is None:
            turn = f"{quantity} = {show(value, 'load' if quantity == 'P' else 'length')}"
            raise InputError(f"cycle: the reversal at {turn} is not reached on approach within the solution")
        return x

    def within(self, _: Callable[[float], device_path.Program], x: float) -> float:
        """The turn ``x``: the body does not creep."""
        return x


@dataclass(frozen=True, eq=False)
class History(device_path.Path):
    """What happened to ``contact`` over time; ``beside``: the same, integrated less exactly."""

    contact: RateContact
    beside: History | None = None

    @property
    def turn(self) -> float:
        """The time [s] at which the contact last stopped to grow; that of the begin where it never grew."""
        grew = [piece.last[0] for piece in self.pieces if piece.phase == device_path.ADVANCE]
        return max(grew, default=self.pieces[0].first[0])

    @cached_property
    def pull_off(self) -> device_path.TimedState:
        """The state of least load since the contact last grew."""
        after = [
            piece
            for piece in self.pieces
            if piece.phase in (device_path.REST, device_path.RECEDE) and piece.last[0] >= self.turn
        ]
        lows = [self.state(piece, *piece.lowest()) for piece in after or self.pieces]
        return min(lows, key=lambda state: state.P)

    @property
    def lost(self) -> device_path.Jump | None:
        """The last loss of contact."""
        return next((jump for jump in reversed(self.jumps) if jump.end is None), None)

    @property
    def waited(self) -> float | None:
        """How long [s] the device stood still before contact was lost; None where it moved, or it was not lost."""
        ramp = next((piece.ramp for piece in reversed(self.pieces) if piece.ends == "lost"), None)
        return None if ramp is None or self.lost is None or ramp.rate != 0 else self.lost.t - ramp.t

    @property
    def error(self) -> dict[str, Estimate]:
        """Relative error of the integration of "P" and "t" at pull-off and of the time at which contact is "lost", both
        counted from the turn, and of the "balance": work of the device against stored energy and work of the edge."""
        if self.beside is None:
            return dict.fromkeys(("P", "t", "lost", "balance"), Unknown("integrated once only"))
        both = (self, self.beside)
        lost = [(history.lost.t if history.lost else math.nan) - history.turn for history in both]
        return {
            "P": self._stated(*(history.pull_off.P for history in both)),
            "t": self._stated(*(history.pull_off.t - history.turn for history in both)),
            "lost": Unknown("contact is not lost") if math.isnan(sum(lost)) else self._stated(*lost),
            "balance": self.balance,
        }

    def _stated(self, here: float, there: float) -> float:
        """Relative error of ``here``: errors are proportional to the tolerance."""
        size = max(abs(here), abs(there))
        changed = abs(here - there) / size / (HISTORY_COARSER - 1) if size else 0.0
        return max(changed, HISTORY_FLOOR * self.contact.tolerance)

    @property
    def fastest(self) -> float:
        """The largest speed [m/s] of the receding edge up to pull-off."""
        end, speeds = self.pull_off, [0.0]
        for piece in self.pieces:
            if piece.phase == device_path.RECEDE and piece.first[0] <= end.t:
                t, a = piece.rows(LOOKED_AT)
                t, a = np.append(t[t <= end.t], end.t), np.append(a[t <= end.t], end.a)
                t, a = t[t <= piece.last[0]], a[t <= piece.last[0]]
                speeds += (-piece.speeds(a, self.states(piece, t, a).G)).tolist()
        return max(speed for speed in speeds if math.isfinite(speed))  # where it jumps it has none

    def position_where(self, quantity: str, value: float) -> float | None:
        """The device's position where "P" [N] or "delta" [m] first rises to ``value``; None: it never does."""

        for piece in self.pieces:

            def excess(t: Array, piece: device_path.Piece = piece) -> Array:
                _, delta, P, _ = self.states(piece, t, piece.at(t))
                return (P if quantity == "P" else delta) - value

            t = piece.rows(LOOKED_AT)[0]
            met = np.flatnonzero(np.diff(np.sign(excess(t))) > 0)
            if met.size and piece.phase == device_path.ADVANCE:
                when = zeros_between(excess, t[met[:1]], t[met[:1] + 1], 0.0)
                return float(piece.ramp.at(when)[0])
        return None

    @property
    def dissipated(self) -> float:
        """Work of the receding edge, int G dA [J]."""
        return sum(piece.dissipated for piece in self.pieces if piece.phase == device_path.RECEDE)

    @property
    def energy_lost(self) -> Estimate:
        """Work that the device does over the whole program [J]: the area of the loop where contact is lost."""
        if self.contact.stiffness == LOAD_CONTROL:
            return UNBOUNDED
        if self.ends != "lost" and self.pieces[-1].phase != device_path.FREE:
            return Unknown("contact is not lost")
        return self.work

    @property
    def balance(self) -> float:
        """The energy that is missing, |work of the device - stored - int G dA| over the largest of the three [-]:
        that of the motion with the largest share."""
        missing = 0.0
        for piece in (piece for piece in self.pieces if isinstance(piece, Motion)):
            (t, a), (t_end, a_end) = piece.first, piece.last
            stored = self.contact.edge.stored((a, piece.ramp.at(t)), (a_end, piece.ramp.at(t_end)))
            if scale := max(abs(piece.dissipated), abs(stored), abs(piece.work)):
                missing = max(missing, abs(piece.work - stored - piece.dissipated) / scale)
        return missing

    def table(self, points: int) -> dict[str, Array]:
        """Rows of the whole history, at most ``points`` to a piece: "t_s", "a_m" (0 out of contact), "delta_m", "P_N",
        "device_m" (not under load control), "speed_m_per_s" (da/dt), "G_J_per_m2", "phase", "part"."""
        columns = self.rows(points)
        a, G, part = (columns[name] for name in ("a_m", "G_J_per_m2", "part"))
        speeds = [piece.speeds(a[part == i], G[part == i]) for i, piece in enumerate(self.pieces, start=1)]
        last = {name: columns.pop(name) for name in ("G_J_per_m2", "phase", "part")}
        return columns | {"speed_m_per_s": np.concatenate(speeds)} | last
