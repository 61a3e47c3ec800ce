"""The one result that every method gives: the nonadhesive series, its error budget and where it came from."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, Literal, NamedTuple, Protocol

import numpy as np

from ..base.errors import Estimate, InputError, Unknown
from ..base.numerics import ROUNDED, Array, pchip
from ..bodies.problem import Problem


class Column(NamedTuple):
    """A column of a series: what it is called in the file, its unit, and what it is; ``modulus``, ``profile``: the
    powers with which it grows with all moduli of the bodies, and with the height of the indenter's profile."""

    name: str
    unit: str
    words: str
    modulus: int = 0
    profile: int = 0


COLUMNS = {  # by the fields of ``Series``; one more is a line here, its field there, and the method that gives it
    "a": Column("a", "m", "contact radius, undeformed configuration"),
    "delta": Column("delta", "m", "displacement of the indenter, into the specimen positive", 0, 1),
    "P": Column("P", "N", "load, compression positive", 1, 1),
    "S": Column("S", "N/m", "slope dP/d(delta) of the nonadhesive contact", 1),
    "dS": Column("dS_da", "N/m^2", "derivative dS/da", 1),
}
JUDGED = 0.01  # of the largest depth, from which a profile's points count in the budget; choice: as elements do
NO_SMOOTHING = Unknown("no smoothing was done")


def _frozen(name: str, values: Array, size: int) -> Array:
    """A copy that cannot be written to; InputError where it is no column of ``size`` finite numbers."""
    array = np.array(values, dtype=float)
    if array.shape != (size,):
        raise InputError(f"series: {name} must be one-dimensional with {size} values, got shape {array.shape}")
    if not np.isfinite(array).all():
        raise InputError(f"series: {name}[{int(np.argmin(np.isfinite(array)))}] is not finite")
    array.setflags(write=False)
    return array


def _freeze(series: RawSeries | Series, names: Sequence[str]) -> None:
    """Put such copies in place of the columns that are there, as long as ``a``."""
    for name in names:
        if (values := getattr(series, name)) is not None:
            object.__setattr__(series, name, _frozen(name, values, np.size(series.a)))


@dataclass(frozen=True, eq=False)
class RawSeries:
    """Increments as a solver reports them, in order: contact radius ``a`` [m], ``delta`` [m], ``P`` [N].

    Repeated radii are normal: a node-based radius stays while the load grows. ``rows`` numbers them for messages.
    ``element``: distance [m] from the node whose radius it is to the next one, where it is known.
    """

    a: Array
    delta: Array
    P: Array
    rows: Array = field(default_factory=lambda: np.empty(0, dtype=int))
    element: Array | None = None

    def __post_init__(self) -> None:
        _freeze(self, ("a", "delta", "P", "element"))
        object.__setattr__(self, "rows", np.array(self.rows) if np.size(self.rows) else np.arange(1, self.a.size + 1))

    @property
    def touching(self) -> RawSeries:
        """The increments in contact: another program's table begins with the undeformed state."""
        return self.only(self.a > 0)

    def only(self, chosen: Array) -> RawSeries:
        """The ``chosen`` increments, a mask."""
        element = None if self.element is None else self.element[chosen]
        return RawSeries(self.a[chosen], self.delta[chosen], self.P[chosen], self.rows[chosen], element)


@dataclass(frozen=True, eq=False)
class Series:
    """Nonadhesive contact at strictly increasing radii; all arrays of equal length, read-only, SI.

    ``S = dP/d(delta)`` [N/m] and ``dS = dS/da`` [N/m^2] where the method knows them exactly, else None.
    ``errors``: estimated absolute errors per column (keys among ``COLUMNS``), half-widths at ``LEVEL``, at equal
    radius; where the radius has an error itself, those of a and P are at equal displacement (``errors_at_radius`` has
    them at equal radius).
    ``a0, S0``: contact radius and slope at first touch (both 0 for round indenters; ``S0 = None``: unknown).
    ``rim``: contact radius [m] of a full end, whose edge is pinned; ``pressed``: the displacement [m] up to which it is
    pressed there.
    ``kinks``: radii [m] at which the indenter's slope bends, and delta and P with it; ``bends``: those that are meant,
    and not what is left between the points of a table.
    ``own``: of columns that were read, the exact solution of the bodies they are claimed to be of, where there is one:
    a smooth fit departs from its shape no more than the columns ask for.
    ``coarser``: the same by larger elements, where there are such.
    ``unresolved``: errors (2, n) of delta [m] and of its slope by a profile that is known at points only, part of the
    ``errors``: the same at all rows nearby, and in the ``coarser`` series.
    ``shift``: half-width (n,) [m] of an error of the radii that all rows share: that of the edge beyond nodes.
    """

    a: Array
    delta: Array
    P: Array
    S: Array | None = None
    dS: Array | None = None
    errors: Mapping[str, Array] = field(default_factory=dict)
    a0: float = 0.0
    S0: float | None = 0.0
    rim: float = math.inf
    pressed: float = 0.0
    own: Series | None = None
    coarser: CoarseSeries | None = None
    kinks: tuple[float, ...] = ()
    bends: tuple[float, ...] = ()
    unresolved: Array | None = None
    shift: Array | None = None

    def __post_init__(self) -> None:
        _freeze(self, [*COLUMNS])
        errors = {key: _frozen(f"errors[{key}]", value, len(self)) for key, value in self.errors.items()}
        object.__setattr__(self, "errors", errors)
        if self.a.size < 1:
            raise InputError("series: holds no points")
        for name, rising, unit in (("contact radii", self.a, " m"), ("delta", self.delta, ""), ("P", self.P, "")):
            if (still := np.diff(rising, prepend=0.0) <= 0).any():
                i = int(np.argmax(still))
                raise InputError(f"series: {name} must be positive and increase, point {i + 1} is {rising[i]:g}{unit}")
        if not 0 <= self.a0 < self.a[0]:
            raise InputError(f"series: a0 must be >= 0 and below the first radius {self.a[0]:g} m, got {self.a0:g} m")
        for name, values in (("S", self.S), ("dS", self.dS)):
            if values is not None and (values <= 0).any():
                i = int(np.argmax(values <= 0))
                raise InputError(f"series: {name} must be > 0, point {i + 1} is {values[i]:g}; use --slopes integral")
        unknown = set(self.errors) - set(COLUMNS)
        if unknown:
            raise InputError(f"series: errors for unknown columns {sorted(unknown)}")

    def __len__(self) -> int:
        return self.a.size

    @property
    def stiffness(self) -> Array:
        """S [N/m], of differences where it is not known."""
        return np.gradient(self.P, self.delta) if self.S is None else self.S

    @property
    def end(self) -> tuple[float, float, float]:
        """Contact radius [m], displacement [m] and load [N] up to which it goes."""
        if self.rim < math.inf:
            return float(self.a[-1]), self.pressed, self.pressed * float(self.stiffness[-1])
        return float(self.a[-1]), float(self.delta[-1]), float(self.P[-1])

    def control_of_force(self, stiffness: float) -> float:
        """The stiffness [N/m] of the device that loses contact where one of ``stiffness`` measures its largest tension:
        its own, but of a full end 0: whatever holds it, it passes pull-off under load control."""
        return stiffness if self.rim == math.inf else 0.0

    @property
    def errors_at_radius(self) -> Mapping[str, Array]:
        """Errors of "delta" and "P" at equal contact radius, where that of the radius itself is stated (it and P's are
        at equal displacement): a wrong radius shifts delta along its curve, and P with it; else empty."""
        of_radius = self.errors.get("a")
        if of_radius is None or "P" not in self.errors or not of_radius.any() or len(self) < 2:
            return {}
        shift = of_radius * np.gradient(self.delta, self.a)
        return {"delta": shift + self.errors.get("delta", 0.0), "P": self.stiffness * shift + self.errors["P"]}

    def scaled(self, factor: float) -> Series:
        """The series of the same bodies with all moduli multiplied by ``factor``: P, S and S' scale, delta does not."""
        S0 = None if self.S0 is None else self.S0 * factor
        coarser = None if self.coarser is None else replace(self.coarser, series=self.coarser.series.scaled(factor))
        return replace(self, **self._times(factor, "modulus"), S0=S0, coarser=coarser)

    def under_profile(self, factor: float) -> Series:
        """The series of the same bodies under an indenter whose profile is ``factor`` times as high: delta and P scale,
        a, S and S' do not."""
        own = None if self.own is None else self.own.under_profile(factor)
        coarser = self.coarser
        coarser = None if coarser is None else replace(coarser, series=coarser.series.under_profile(factor))
        unresolved = None if self.unresolved is None else self.unresolved * factor
        return replace(self, **self._times(factor, "profile"), own=own, coarser=coarser, unresolved=unresolved)

    def _times(self, factor: float, of: Literal["modulus", "profile"]) -> dict[str, Any]:
        """The columns that are there, and their errors, for a ``factor`` of what they grow with by a power."""
        by = {key: factor ** getattr(column, of) for key, column in COLUMNS.items()}
        columns = {key: values * by[key] for key in COLUMNS if (values := getattr(self, key)) is not None}
        return columns | {"errors": {key: values * by[key] for key, values in self.errors.items()}}


@dataclass(frozen=True, eq=False)
class CoarseSeries:
    """A ``series`` of the same contact on elements ``ratio`` times as large, which may have its own; what the cut of
    the body costs is off in it, too."""

    series: Series
    ratio: float


@dataclass(frozen=True)
class ErrorBudget:
    """Estimated relative errors of the series (largest over its points), each a number or why it is unknown."""

    discretisation: Estimate
    truncation: Estimate
    radius: Estimate
    smoothing: Estimate = NO_SMOOTHING

    @property
    def series(self) -> Estimate:
        """The error of the series itself: the sum of discretisation, truncation and radius, or the first reason."""
        parts = (self.discretisation, self.truncation, self.radius)
        reason = next((part for part in parts if isinstance(part, Unknown)), None)
        return float(sum(part for part in parts if not isinstance(part, Unknown))) if reason is None else reason

    @property
    def total(self) -> Estimate:
        """Series and smoothing together; the reason, where the series' error is unknown."""
        if isinstance(self.series, Unknown) or isinstance(self.smoothing, Unknown):
            return self.series
        return self.series + self.smoothing

    def as_dict(self) -> dict[str, Estimate]:
        return {**vars(self), "total": self.total}


@dataclass(frozen=True, eq=False)
class PressureTable:
    """Contact pressure of every increment: ``p`` [Pa] of shape (increments, nodes) at the radii ``r`` [m]."""

    r: Array
    p: Array


class FilteredSeries(Protocol):
    """A case with every default written out."""

    def to_toml(self, method: str | None = None) -> str: ...


@dataclass(frozen=True, eq=False)
class Record:
    """What a solution keeps of the case it came from, beside the physics: for the transformation and for its file.

    ``w``: works of adhesion [J/m^2]; ``z0``: interatomic distance [m]; ``stress`` [Pa], ``length`` [m]: tension or
    range of adhesion of finite range, one of them or neither; ``path``: its file, as messages name it;
    ``case``: None where the problem was made in Python; ``versions``: of jkr and what it rests on, by name.
    """

    title: str = ""
    w: tuple[float, ...] = ()
    z0: float = 0.3e-9
    path: Path = Path("solved")
    case: FilteredSeries | None = None
    command_line: str = ""
    versions: Mapping[str, str] = field(default_factory=dict)
    stress: float | None = None
    length: float | None = None

    @property
    def toml(self) -> str:
        """The text of the case."""
        return "" if self.case is None else self.case.to_toml()


class Companions(Protocol):
    """What a solution leaves open, as others show that it was compared with: ``companions(radii)`` are relative errors
    (n, 4, radii) of delta, P, S, S' at radii [m], each set of one cause, alike from radius to radius and column to
    column; ``least``: relative errors that no other tells apart."""

    @property
    def least(self) -> float: ...

    def __call__(self, radii: Array) -> Array: ...


@dataclass(frozen=True, eq=False)
class KeptKernel:
    """The kernel of the contact equation that a solution was found with, as far as it reaches, and what is known of its
    errors: with it the same body is solved at other radii.

    ``coefficients`` (1 + m, n, n): of the kernel [1/m] and of its m companions, in even Legendre polynomials P_2i(x/c)
    P_2j(t/c) up to the radius c = ``reach`` [m]; it varies over the length ``scale`` [m]. ``of_side``: whether they are
    only what the side adds to the laterally unbounded body, whose kernel is exact. ``weights`` (m, 4): the part of what
    a companion changes of delta, P, S, S' that is left as an error; ``accuracy``: relative, to which that is computed;
    ``least``: relative errors that nothing tells apart. ``errors`` (3, 4, k): relative errors of these columns at
    ``radii`` (k,) [m] by elements, by the number of polynomials and by the cut.
    """

    coefficients: Array
    reach: float
    scale: float
    of_side: bool
    weights: Array
    accuracy: float
    least: float
    radii: Array
    errors: Array


@dataclass(frozen=True, eq=False, repr=False)
class Solution:
    """A solved problem: what every method returns, and what its file gives back.

    ``raw``: the increments, where the method works in increments; ``facts``: plain numbers and words about mesh, solver
    and choices; ``timings``: CPU seconds per stage; ``warnings``: sentences with numbers; ``companions``: where the
    method knows them; ``kernel``: where it took long to find and is small. ``touches``: of increments on nodes, the
    series at the moments at which the edge of the contact reaches these, where the method knows them. ``solver``: the
    Method that made it, as it was configured, where that is known.
    """

    problem: Problem
    series: Series
    budget: ErrorBudget
    method: str
    raw: RawSeries | None = None
    pressure: PressureTable | None = None
    facts: Mapping[str, Any] = field(default_factory=dict)
    timings: Mapping[str, float] = field(default_factory=dict)
    warnings: tuple[str, ...] = ()
    record: Record = field(default_factory=Record)
    companions: Companions | None = None
    kernel: KeptKernel | None = None
    touches: Series | None = None
    solver: Any = field(default=None, compare=False)

    def __post_init__(self) -> None:
        series, loading = self.series, self.problem.loading
        rim = self.problem.indenter.rim
        if rim < math.inf:  # what is prescribed besides a radius is borne by the full end
            pressed = {"depth": loading.maximum, "load": loading.maximum / float(series.stiffness[-1])}
            object.__setattr__(self, "series", replace(series, rim=rim, pressed=pressed.get(loading.to, 0.0)))

    def __repr__(self) -> str:
        a = self.increments.a
        return f"<Solution {self.record.path}: {a.size} rows by method {self.method}, a to {a[-1]:.4g} m>"

    @property
    def key(self) -> str:
        """Identity of the problem that was solved."""
        return self.problem.key

    @property
    def unresolved(self) -> Array:
        """Errors (2, n) of delta [m] and of its slope at the rows where the profile is known at points only: those of F
        at the surface, more as far as what lies below is softer, as of a spring in series."""
        series, of_profile = self.series, self.problem.indenter.resolution(self.series.a)
        if not of_profile.any():
            return of_profile
        softer: Array = np.maximum(2 * self.problem.E_star * series.a / series.stiffness, 1.0)
        return softer * of_profile

    def widened(self) -> Solution:
        """The same with the error of a profile that is known at points only: of delta, or of the radius where that is
        what errs, and S times it of P."""
        more, own = self._of_profile, self.budget.discretisation
        if not more:
            return self
        errors = {name: error + more.get(name, 0.0) for name, error in self.series.errors.items()}
        total = own if isinstance(own, Unknown) else own + self.profile_error
        return replace(
            self, series=replace(self.series, errors=errors), budget=replace(self.budget, discretisation=total)
        )

    @property
    def profile_error(self) -> float:
        """Largest relative error of a column by a profile that is known at points only; 0 for any other."""
        series = self.series
        judged = series.delta >= JUDGED * series.delta[-1]
        of_columns = (error / getattr(series, name) for name, error in self._of_profile.items())
        return max((float(np.max(relative[judged])) for relative in of_columns), default=0.0)

    @property
    def _of_profile(self) -> dict[str, Array]:
        """Errors of columns by a profile that is known at points only; none for any other."""
        series = self.series
        shift = np.zeros(1) if len(series) < 2 else self.unresolved[0]
        if not shift.any():
            return {}
        if "a" in series.errors and series.errors["a"].any():
            return {"P": series.stiffness * shift, "a": shift / np.gradient(series.delta, series.a)}
        return {"delta": shift, "P": series.stiffness * shift}

    @property
    def increments(self) -> RawSeries:
        """The rows as they were computed: ``raw``, or those of the series."""
        return self.raw or RawSeries(self.series.a, self.series.delta, self.series.P)

    @property
    def filtered(self) -> Series:
        """What can be known from the increments alone, without S, dS/da and errors; else the series itself."""
        return self.series if self.raw is None else replace(self.series, S=None, dS=None, errors={})

    def scaled(self, factor: float) -> Solution:
        """The solution for bodies whose moduli are all ``factor`` times as large; nothing is solved anew."""
        if factor == 1:
            return self
        raw = None if self.raw is None else replace(self.raw, P=self.raw.P * factor)
        pressure = None if self.pressure is None else replace(self.pressure, p=self.pressure.p * factor)
        problem, series = self.problem.scaled(factor), self.series.scaled(factor)
        touches = None if self.touches is None else self.touches.scaled(factor)
        return replace(self, problem=problem, series=series, raw=raw, pressure=pressure, touches=touches)

    @property
    def at_touches(self) -> Solution | None:
        """The same without increments, its series that at the moments at which nodes are reached; None where these are
        not known."""
        return None if self.touches is None else replace(self, series=self.touches, raw=None, touches=None)


def first_of_plateaus(a: Array) -> Array:
    """Mask of the increments at which the radius ``a`` exceeds every one before it (and 0): the ones to keep."""
    a = np.asarray(a, dtype=float)
    return a > np.maximum.accumulate(np.concatenate([[0.0], a[:-1]]))


def is_series(raw: RawSeries) -> bool:
    """Whether the increments are a series as they stand: radii, displacements and loads all increase."""
    return bool(first_of_plateaus(raw.a).all() and all((np.diff(column) > 0).all() for column in (raw.delta, raw.P)))


def filter_plateaus(raw: RawSeries) -> tuple[RawSeries, int]:
    """Keep the first increment of every run with the same outermost contact node (the paper's filter, Sec. 3).

    Increments without contact (a <= 0) are dropped too. Returns the kept increments and how many were dropped.
    """
    first_rows = raw.only(first_of_plateaus(raw.a))
    return first_rows, int(raw.a.size - first_rows.a.size)


# --------------------------------------------------------------------------------------------------
# How far two results of the same problem lie apart, column by column, with the worst row.


@dataclass(frozen=True, eq=False)
class Difference:
    """Relative differences of one ``column`` at the values ``x`` of ``over``: second minus first, over the first.

    Adhesive loads and displacements change sign: their differences are over the largest magnitude of the first.
    ``coverage``: the share of the wider of the two ranges that both have.
    """

    column: str
    over: str
    x: Array
    relative: Array
    coverage: float

    @property
    def worst_row(self) -> int:
        return int(np.argmax(np.abs(self.relative)))

    @property
    def worst(self) -> float:
        return float(np.abs(self.relative[self.worst_row]))


def series_differences(first: Series, second: Series) -> list[Difference]:
    """P and a at equal displacement, S and dS at equal radius where both carry them; over the common range."""
    differences = [
        _in_logs("P", "delta_m", first.delta, first.P, second.delta, second.P),
        _in_logs("a", "delta_m", first.delta, first.a, second.delta, second.a),
    ]
    for name in ("S", "dS"):
        y1, y2 = getattr(first, name), getattr(second, name)
        if y1 is not None and y2 is not None:
            differences.append(_in_logs(name, "a_m", first.a, y1, second.a, y2))
    return differences


def curve_differences(first: Mapping[str, Array], second: Mapping[str, Array]) -> list[Difference]:
    """The columns that two adhesive curves share, at equal contact radius, over the common range; of the rows without
    contact, of adhesion of finite range, the last one alone."""
    first, second = (
        {name: column[np.append(np.diff(curve["a_m"]) > 0, True)] for name, column in curve.items()}
        for curve in (first, second)
    )
    x, inside = _common(first["a_m"], second["a_m"])
    differences = []
    for name in first:
        if name in ("a_m", "level") or name not in second or name.endswith(("_err_N", "_err_m")):
            continue
        if first[name].dtype.kind != "f":
            continue
        scale = float(np.max(np.abs(first[name])))
        other = pchip(second["a_m"], second[name])(np.clip(x, second["a_m"][0], second["a_m"][-1]))
        relative = (other - first[name][inside]) / scale
        differences.append(Difference(name, "a_m", x, relative, _coverage(first["a_m"], second["a_m"])))
    return differences


def _in_logs(column: str, over: str, x1: Array, y1: Array, x2: Array, y2: Array) -> Difference:
    """Power laws are straight in logs: few points suffice."""
    x, inside = _common(x1, x2)
    if x2.size == 1:
        return Difference(column, over, x, y2 / y1[inside] - 1, _coverage(x1, x2))
    other = np.exp(pchip(np.log(x2), np.log(y2))(np.clip(np.log(x), np.log(x2[0]), np.log(x2[-1]))))
    return Difference(column, over, x, other / y1[inside] - 1, _coverage(x1, x2))


def _coverage(x1: Array, x2: Array) -> float:
    """Length that both ranges share, over that of the longer one."""
    shared = min(x1[-1], x2[-1]) - max(x1[0], x2[0])
    longest = max(x1[-1] - x1[0], x2[-1] - x2[0])
    return float(max(shared, 0.0) / longest) if longest > 0 else 1.0


def _common(x1: Array, x2: Array) -> tuple[Array, Array]:
    """The values of ``x1`` within the range of ``x2`` (up to round-off), and where they stand."""
    inside = (x1 >= x2[0] * (1 - ROUNDED)) & (x1 <= x2[-1] * (1 + ROUNDED))
    if not inside.any():
        raise InputError(
            f"nothing to compare: the ranges {x1[0]:.4g} to {x1[-1]:.4g} and {x2[0]:.4g} to {x2[-1]:.4g} do not overlap"
        )
    return x1[inside], inside
