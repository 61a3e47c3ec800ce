"""Parameters of a model: the scale on which each is sought, SI values by the unknowns of a search, what is known of
them afterwards, and what a user writes of them.
"""

from __future__ import annotations

import contextlib
import itertools
import math
from collections.abc import Callable, Container, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Annotated, Literal, TypeAlias

import numpy as np

from ..base.errors import LEVEL, InputError, did_you_mean
from ..base.numerics import HALF_WIDTH, SAME, Array, half_width
from ..base.registry import Reported
from ..base.units import FIRM, LARGE_WORK, SMALL_WORK, Named, Ranged, scale, show, texts_of
from .choices import Values

# --------------------------------------------------------------------------------------------------
# The result of any fit: values with their errors and intervals, their correlations, and warnings on both.

# Limits beyond which a reader is warned; nothing else depends on them.
ANSWER_APART = 0.99  # choice: correlation beyond which the data hardly separate two parameters
ANSWER_VAGUE = 0.3  # choice: relative standard error beyond which a value is little more than its order


@dataclass(frozen=True)
class FittedValue:
    """A parameter or what follows from it, SI. ``error``: standard error, ``low, high``: the confidence interval;
    None where the data do not determine it, or where it is fixed. ``systematic``: changes by one standard
    error of each uncertain input, by name, part of the interval; ``model``: half-widths from models near this one that
    the data do not exclude, beside it; ``lowers``: those of them by which the value is lower."""

    name: str
    value: float
    free: bool
    dimension: str
    error: float | None = None
    low: float | None = None
    high: float | None = None
    systematic: Values | None = None
    model: Values | None = None
    lowers: frozenset[str] = frozenset()

    def with_model(self, name: str, half_width: float) -> FittedValue:
        """The same with one more part by models near this one."""
        return replace(self, model={**(self.model or {}), name: half_width})

    def half_width(self, level: float) -> float | None:
        """Half of the interval at ``level``; where an end of it is open, by the standard error, if there is one."""
        if self.low is not None and self.high is not None:
            return (self.high - self.low) / 2
        return None if self.error is None else self.error * half_width(level)

    def parts(self, level: float) -> dict[str, float]:
        """The half-widths [SI] of the parts of the error by their kinds; nothing where it is not determined."""
        half = self.half_width(level)
        if self.error is None or half is None or self.low is self.high is None:
            return {}
        calibration = half * min(math.hypot(*(self.systematic or {}).values()) / (self.error or 1.0), 1.0)
        own = math.sqrt(half**2 - calibration**2)
        return {"statistical": own, "calibration": calibration, "model": math.hypot(*(self.model or {}).values())}

    @property
    def whole(self) -> tuple[float | None, float | None]:
        """The ends of the interval by all parts of the error together, no lower than what may be at least."""
        part, least = math.hypot(*(self.model or {}).values()), -math.inf
        if self.dimension in ("modulus", "work") or self.name == "modulus":
            least = 0.0
        low = None if self.low is None else max(self.value - math.hypot(self.value - self.low, part), least)
        return low, None if self.high is None else self.value + math.hypot(self.high - self.value, part)


@dataclass(frozen=True, eq=False, kw_only=True)
class Answer(Reported):
    """``estimates``: the parameters, then what follows from them; ``free``: names of those that were fitted, with their
    ``covariance`` (of SI values, or of logs), None where the data do not separate them; ``dof``: degrees of freedom;
    ``warnings``: sentences; ``body``: what was fitted, in words."""

    estimates: tuple[FittedValue, ...]
    free: tuple[str, ...]
    covariance: Array | None
    dof: int
    warnings: tuple[str, ...] = ()
    body: str = ""

    def estimate(self, name: str) -> FittedValue:
        """The estimate called ``name``."""
        known = {item.name: item for item in self.estimates}
        if name not in known:
            raise InputError(f'no estimate is called "{name}" (there are: {", ".join(known)})')
        return known[name]

    def value(self, name: str) -> float:
        """The value called ``name``, SI."""
        return self.estimate(name).value

    @property
    def correlation(self) -> Array | None:
        """Correlation coefficients of the free parameters; 0 of one that has no variance, as a w whose root is 0."""
        if self.covariance is None:
            return None
        variance = np.diag(self.covariance)
        sigma = np.sqrt(np.where(variance > 0, variance, 1.0))
        return self.covariance / np.outer(sigma, sigma)

    def correlated(self, one: str, two: str) -> float | None:
        """Correlation coefficient of two free parameters; None where there is none."""
        if (matrix := self.correlation) is None or not {one, two} <= set(self.free):
            return None
        return float(matrix[self.free.index(one), self.free.index(two)])

    @property
    def hardly_apart(self) -> Iterator[tuple[str, str, str]]:
        """Pairs of free parameters that the data hardly separate, with a sentence on each."""
        if (matrix := self.correlation) is None:
            return
        rows = matrix.tolist()
        for (i, one), (j, two) in itertools.combinations(enumerate(self.free), 2):
            if abs(rows[i][j]) > ANSWER_APART:
                yield one, two, f"{word(one)} and {word(two)} are strongly correlated ({rows[i][j]:.4f})"

    def vague(self, names: Sequence[str]) -> Iterator[str]:
        """A sentence on each of these that is little more than its order."""
        for item in map(self.estimate, names):
            if item.error is not None and item.error > ANSWER_VAGUE * item.value > 0:
                yield f"{word(item.name)} is uncertain by {item.error / item.value:.0%} (standard error)"


def word(name: str) -> str:
    """What a parameter is called in sentences."""
    return "E*" if name in ("modulus", "E_star") else name


Kind = Literal["log", "positive", "linear", "limit", "root"]
LOG: Kind = "log"
LINEAR: Kind = "linear"
LIMIT: Kind = "limit"
ROOT: Kind = "root"
LIMITED = (LIMIT, ROOT)  # that have an upper limit where 0 is not excluded

# Limits of what is known of a value.
PARAMETER_WIDEST = 10.0  # choice: half-width of a log, from which on a value is unknown


DIMENSIONS = {"modulus": "number", "w": "work", "delta0": "length", "P0": "load", "compliance": "number",
              "drift": "speed", "hysteresis": "number", "creep": "number", "range": "length",
              "stress": "modulus"}  # fmt: skip
OF_TRAVEL = ("hysteresis", "creep")  # errors of a device's positions, as fractions of its travel
POSITIONS = ("drift", *OF_TRAVEL)  # all errors of positions
OF_A_CYCLE = {"w_approach": "work", "a_turn": "length"}  # added where both directions are fitted; a_turn: radius there
OF_A_LAYER = {"E": "modulus", "h": "length", "nu": "number"}
KINDS: dict[str, Kind] = {"modulus": "log", "w": "positive", "delta0": "linear", "P0": "linear", "compliance": "linear",
                          "drift": "linear", "hysteresis": "linear", "creep": "linear",
                          "w_approach": "positive"}  # fmt: skip


MODULUS = {"modulus": Ranged("number", above=0)}  # the common factor of all moduli
ONE_SIDED = half_width(2 * LEVEL - 1) / HALF_WIDTH  # theory: one-sided over two-sided, of a normal value
ALIAS = "E_star"  # the common modulus by its value rather than as a factor


def dimension_of(name: str) -> str:
    """The dimension of a parameter of the model, or of "E:layer", "h:layer", "nu:layer"."""
    return (DIMENSIONS | OF_A_CYCLE).get(name) or OF_A_LAYER[name.partition(":")[0]]


@dataclass(frozen=True)
class Parameter:
    """One quantity of the model, SI: free between ``low`` and ``high``, or fixed at ``value``.

    ``value = None``: free, and the start follows from the data. Names: those of ``DIMENSIONS``, "E:layer" and
    "h:layer" for modulus and thickness of a named layer; others state their ``scale`` and the ``quantity`` they are.
    ``follows``: from other parameters, as E* does from the factor of the moduli.
    """

    name: str
    free: bool
    value: float | None = None
    low: float = -math.inf
    high: float = math.inf
    scale: Kind | None = None
    quantity: str = ""
    follows: bool = False

    def __post_init__(self) -> None:
        if not self.free and self.value is None:
            raise InputError(f"{self.name}: is fixed and needs a value")
        if (value := self.value) is not None:
            above = value > 0 if self.kind == "log" else value >= 0 or self.kind == "linear"
            if not (math.isfinite(value) and above):
                allowed = {"log": "> 0", "positive": "finite and >= 0", "linear": "finite"}[self.kind]
                raise InputError(f"{self.name}: must be {allowed}, got {value:g}")
            if self.free and not self.low <= value <= self.high:
                ends = f"{self.low:g} to {self.high:g}"
                raise InputError(f"{self.name}: the start {value:g} is outside its bounds {ends}")
        if not self.inner(self.low) < self.inner(self.high):
            raise InputError(f"{self.name}: bounds must increase and leave room, got {self.low:g} to {self.high:g}")

    @property
    def kind(self) -> Kind:
        """The scale on which it is fitted and intervals are made: "log", the signed "root", or as it is; "positive"
        where it cannot be less than 0, "limit" where it may come out so, though it is not.

        w as it is: its effect on a curve without adhesion is of first order in w (the shift by its root is along it).
        """
        return self.scale or KINDS.get(self.name, "log")

    @property
    def dimension(self) -> str:
        return self.quantity or dimension_of(self.name)

    @property
    def of_body(self) -> bool:
        """Whether the body must be solved anew when it changes."""
        return ":" in self.name

    def inner(self, value: float) -> float:
        """The optimiser's unknown for ``value``."""
        if self.kind == "log":
            return math.log(value) if value > 0 else -math.inf
        if self.kind == "root":
            return math.copysign(math.sqrt(abs(value)), value)
        return max(value, 0.0) if self.kind == "positive" else value

    def outer(self, x: float) -> float:
        """The value of the optimiser's unknown ``x``."""
        if self.kind == "log":
            return math.exp(x)
        if self.kind == "root":
            return x * abs(x)
        return max(x, 0.0) if self.kind == "positive" else x

    def derivative(self, x: float) -> float:
        """d(value)/dx."""
        return math.exp(x) if self.kind == "log" else 2 * abs(x) if self.kind == "root" else 1.0

    def estimate(self, x: float, sigma: float | None, t: float) -> FittedValue:
        """What is known of it where it is free, by its unknown and the standard error ``sigma`` of that; ``t`` of these
        make the interval."""
        if sigma is None or (self.kind == "log" and t * sigma > PARAMETER_WIDEST):
            error = None if sigma is None else self.derivative(x) * sigma
            return FittedValue(self.name, self.outer(x), True, self.dimension, error)
        low, high = x - t * sigma, x + t * sigma
        if self.kind in LIMITED and low <= 0:
            room, of_square = ONE_SIDED * t * sigma, -2 * x * (self.kind == "root")  # far below 0 rows show that
            x = max(x, 0.0)
            low, high = 0.0, max(x + room, math.sqrt(max(of_square, 0.0) * room))
        low, high = self.outer(low), self.outer(high)
        if self.kind == "linear":
            low, high = max(low, self.low), min(high, self.high)
        error = (high - low) / (2 * t) if self.kind == "root" else self.derivative(x) * sigma
        return FittedValue(self.name, self.outer(x), True, self.dimension, error, low, high)


@dataclass(frozen=True, eq=False)
class Unknowns:
    """The free ones of ``parameters``, in their order, as the first unknowns of a search: logs, or values in ``units``
    (by name, else SI)."""

    parameters: tuple[Parameter, ...]
    units: Values = field(default_factory=dict)

    @cached_property
    def free(self) -> tuple[Parameter, ...]:
        return tuple(parameter for parameter in self.parameters if parameter.free)

    @property
    def names(self) -> tuple[str, ...]:
        """Of the unknowns."""
        return tuple(parameter.name for parameter in self.free)

    @cached_property
    def scales(self) -> Array:
        """The units of the unknowns, 1 of logs."""
        return np.array([self.units.get(name, 1.0) for name in self.names])

    @property
    def fixed(self) -> dict[str, float]:
        """The values of the others by name, SI."""
        return {p.name: float(p.value) for p in self.parameters if not p.free and p.value is not None}

    def values(self, x: Array) -> dict[str, float]:
        """All parameters by name, SI; the unknowns ``x`` may go on behind."""
        own = x[: len(self.free)] * self.scales
        return self.fixed | {p.name: p.outer(float(y)) for p, y in zip(self.free, own, strict=True)}

    def at(self, values: Values) -> Array:
        """The unknowns at ``values``, SI."""
        return np.array([parameter.inner(values[parameter.name]) for parameter in self.free]) / self.scales

    def bounds(
        self, start: Array, reach: float, about: Mapping[str, tuple[float, float]] | None = None
    ) -> tuple[Array, Array]:
        """Least and largest unknowns of a search from ``start`` on: logs stay within ``reach`` of it, some ``about``
        another place and with another reach, all between the ends of their parameters; what comes behind has none."""
        low, high = np.full((2, start.size), np.inf) * [[-1], [1]]
        for i, (parameter, unit) in enumerate(zip(self.free, self.scales, strict=True)):
            log, ends = parameter.kind == "log", (parameter.low, parameter.high)
            least, most = (end / unit for end in (map(parameter.inner, ends) if log else ends))
            middle, by = (about or {}).get(parameter.name, (float(start[i]), reach if log else math.inf))
            middle = min(max(middle, least), most)
            low[i], high[i] = max(least, middle - by), min(most, middle + by)
        return low, high

    def covariance(self, whole: Array | None) -> Array | None:
        """That of the free parameters, logs or SI, from the one of all unknowns; None where there is none."""
        n = len(self.free)
        return None if whole is None else whole[:n, :n] * np.outer(self.scales, self.scales)

    def meaning(self, x: Array) -> dict[str, float]:
        """All parameters on their scales."""
        own = x[: len(self.free)] * self.scales
        fixed = self.fixed
        held = {p.name: p.inner(fixed[p.name]) for p in self.parameters if not p.free}
        return held | dict(zip(self.names, own.tolist(), strict=True))


def parameters_of(
    ranges: Mapping[str, Ranged], free: Container[str], known: Values,
    ends: Mapping[str, tuple[float, float]] | None = None,
) -> tuple[Parameter, ...]:  # fmt: skip
    """A parameter for each of the ``ranges`` of values by name, free or fixed at what is ``known``, SI: what is at most
    1 as it is, others > 0 by their logs; ``ends``: where some of them are sought."""
    parameters = []
    for name, ranged in ranges.items():
        most = ranged.most if ranged.below is None else ranged.below
        low, high, scale = -math.inf, math.inf, LINEAR if ranged.above is None else LOG
        if most == 1:
            low, high, scale = 0.0 if ranged.above is None else SAME, 1 - SAME, LINEAR
        if name in free:
            low, high = (ends or {}).get(name, (low, high))
            parameters.append(Parameter(name, True, None, low, high, scale, ranged.dimension))
        else:
            parameters.append(Parameter(name, False, known[name], scale=scale, quantity=ranged.dimension))
    return tuple(parameters)


# ---------------------------------------------------------------------- what a user writes
def check_law(name: str, laws: Mapping[str, object]) -> None:
    """Refuse the name of a law that is none of these."""
    if name not in laws:
        raise InputError(f'fit: unknown law "{name}"{did_you_mean(name, laws)} (laws: {", ".join(laws)})')


Level: TypeAlias = Annotated[float, Ranged("number", least=0.5, below=1)]  # of confidence intervals


def read_value(name: str, ranged: Ranged, text: str) -> float:
    """The value, SI, that a user writes for the parameter ``name``."""
    try:
        return ranged.read(text)
    except ValueError as error:
        raise InputError(f"fit: {name}: {error}") from None


@dataclass(frozen=True)
class Nameable:
    """What a user may name beside an ``option``: ``ranges`` by name; ``aliases``: other names of some of them, beside
    ``ALIAS``, the modulus of a body of ``E_star`` [Pa]."""

    option: str
    ranges: Mapping[str, Ranged]
    E_star: float
    aliases: Mapping[str, str] = field(default_factory=dict)

    @property
    def allowed(self) -> dict[str, Ranged]:
        """The ranges of all names."""
        others = {name: self.ranges[own] for name, own in self.aliases.items()}
        return {**self.ranges, ALIAS: Ranged("modulus", above=0), **others}

    def own(self, name: str) -> str:
        """The own name of a parameter; InputError where it is none of them."""
        if name not in self.allowed:
            hint, names = did_you_mean(name, self.allowed, 0.4), ", ".join(self.allowed)
            raise InputError(f'fit: unknown parameter "{name}"{hint} (with {self.option}: {names})')
        return "modulus" if name == ALIAS else self.aliases.get(name, name)

    def known(self, given: Named) -> dict[str, float]:
        """Values, SI, by the own names of the parameters; InputError where one is given twice, by two of its names."""
        values, named = dict[str, float](), dict[str, str]()
        for name, text in texts_of(given):
            own, value = self.own(name), read_value(name, self.allowed[name], text)
            if own in named:
                both = name if name == named[own] else f"{named[own]} and {name} are one parameter, which"
                raise InputError(f"fit: {both} is given twice")
            named[own] = name
            values[own] = value / self.E_star if name == ALIAS else value
        return values


def changes_by(
    name: str, centre: float, sigma: float, here: Values, outcome: Callable[[float], Values]
) -> dict[str, float]:
    """Change of everything in ``outcome`` by a change of the input ``name`` by ``sigma`` from its value ``centre``,
    where it is ``here``.

    The input is moved to both sides, where that is possible, the body solved anew and the data fitted again; InputError
    where it is uncertain by all of its value or more, but for Poisson's ratios.
    """
    if sigma >= centre and not name.startswith("nu"):
        raise InputError(f"the uncertainty of {name} is {sigma / centre:.3g} times its value: give less than the value")
    ends = [(centre, here)]
    for value in (centre - sigma, centre + sigma):
        with contextlib.suppress(InputError):  # beyond what the quantity can be, as nu > 1/2
            ends.append((value, outcome(value)))
    if len(ends) == 1:
        raise InputError(f"{name} cannot be {sigma:g} off its value {centre:g} to either side")
    (one, low), (two, high) = ends[-2:]
    return {key: (high[key] - low[key]) / (two - one) * sigma for key in here}


def implausible_work(w: float, E_star: float) -> str:
    """A remark on a work of adhesion w > 0 [J/m^2] that was found of a specimen of modulus ``E_star`` [Pa] and that
    surfaces hardly have; empty where many have it."""
    check = "check units of the data and the radius of the indenter"
    if w > LARGE_WORK:
        usual = f"surfaces have a few mJ/m^2 to {show(LARGE_WORK, 'work')}"
        return f"w = {show(w, 'work')} is implausible, {usual}: {check}"
    if w < SMALL_WORK and E_star >= FIRM:
        least = f"a few mJ/m^2 in air and hardly less than {show(SMALL_WORK, 'work')} in liquids"
        small = f"w = {show(w, 'work')} is implausibly small for E* = {show(E_star, 'modulus')}"
        return f"{small}: solids of such a modulus have {least}: {check}"
    return ""


def show_within(value: float, error: float, dimension: str, digits: int = 4, of_error: int = 3) -> str:
    """``value`` ± ``error`` [SI], each as ``show`` writes it; where the error is the larger, both in its unit and the
    value no finer: ``show_within(2e-9, 29e-6, "work") == "0 ± 29 uJ/m^2"``."""
    if not abs(value) < error < math.inf:
        return f"{show(value, dimension, digits)} ± {show(error, dimension, of_error)}"
    factor, unit = scale(error, dimension)
    places = max(1 - math.floor(math.log10(error / factor)), 0)
    return f"{round(value / factor, places) + 0.0:.{places}f} ± {error / factor:.{places}f} {unit}".strip()
