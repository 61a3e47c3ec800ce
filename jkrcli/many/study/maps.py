"""A map: quantities of a paraboloid on standard bodies over some axes. What a map is stands in its row, a ``Map``; how
axes are read, columns computed, forecast, printed and drawn stands here, once for all.
"""

from __future__ import annotations

import importlib
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np

from ...base import Array, InputError, Pool, Ranged, in_order, lists
from ...bodies import Elastic, Layer, Loading, Paraboloid, Problem, Rigid, Specimen
from ...methods import Method
from ...report import Figure, Result
from ...series import Series
from . import MAPS

Values: TypeAlias = dict[str, Any]  # of all axes: a tuple of several, else one
Columns: TypeAlias = dict[str, Array]
Work: TypeAlias = tuple[Callable[[Any], Columns], Sequence[Any]]  # what gives the rows of a cell, and the cells
Q = "w_R2_over_Estar_h3"


@dataclass(frozen=True)
class Axis:
    """An axis of a map, or one number or word of its bodies (``several`` False).

    ``default``: values where none are given, ``shown`` what help says of them; ``allowed``: their range, or the words;
    ``family``: a line for each, in the order given, else they rise; ``read``: what makes a value of something else.
    """

    default: Any
    help: str = ""
    allowed: Ranged | tuple[str, ...] | None = None
    shown: str | None = None
    several: bool = True
    family: bool = False
    read: Callable[[Any], Any] | None = None

    def values(self, chosen: Any) -> Any:
        """The values of this axis, each once; ValueError where one is not allowed."""
        if not self.several:
            return self._value(self.default if chosen is None else chosen)
        chosen = [chosen] if np.isscalar(chosen) else chosen
        values = [self._value(item) for item in (self.default if chosen is None or len(chosen) == 0 else chosen)]
        return tuple(dict.fromkeys(values) if self.family else sorted(set(values)))

    def _value(self, value: Any) -> Any:
        if self.read is not None:
            return self.read(value)
        if isinstance(self.allowed, Ranged):
            return self.allowed.read(value)
        if self.allowed is not None and value not in self.allowed:
            raise ValueError(f'must be {" or ".join(self.allowed)}, got "{value}"')
        return value


POISSON = Ranged("number", above=-1, most=0.5)
BASE = Axis("bonded", allowed=("bonded", "frictionless"), several=False)
SHOWN_Q, SHOWN_NU = (Q, "w R^2/(E* h^3)", "15.4g"), ("nu", "nu", "6g")


@dataclass(frozen=True)
class Map:
    """A row of the table: its ``help`` with an example, its axes by their options, the ``work`` that gives its columns,
    the CPU ``seconds`` that this takes.

    ``title`` names values in braces; ``shown``: column, heading and format of what is printed, or a function that gives
    the lines; ``order``: a column by which rows are sorted; ``draw``: its figure.
    """

    name: str
    help: str
    axes: Mapping[str, Axis]
    work: Callable[[Values], Work]
    seconds: Callable[[Values], float]
    title: str
    shown: Sequence[tuple[str, str, str]] | Callable[[Columns], Iterator[str]]
    draw: Callable[[Columns], Figure]
    order: str = ""

    def values(self, axes: Mapping[str, Any]) -> Values:
        """The values of all axes; InputError where one is unknown or outside its range."""
        if unknown := [name for name in axes if name not in self.axes]:
            raise InputError(f'{self.name} map: has no axis "{unknown[0]}" (axes: {", ".join(self.axes)})')
        values = {}
        for name, axis in self.axes.items():
            try:
                values[name] = axis.values(axes.get(name))
            except ValueError as error:
                raise InputError(f"{self.name} map: {name} {error}") from None
        return values

    def forecast(self, **axes: Any) -> float:
        """CPU seconds that the map over the ``axes`` takes."""
        return self.seconds(self.values(axes))

    def over(self, pool: Pool | None = None, **axes: Any) -> MapResult:
        """The map over the ``axes``; ``pool`` works on its cells (default: this process)."""
        values = self.values(axes)
        parts = in_order(pool, *self.work(values), f"{self.name} map")
        columns = {name: np.concatenate([part[name] for part in parts]) for name in parts[0]}
        if self.order:
            rows = np.argsort(columns[self.order], kind="stable")
            columns = {name: column[rows] for name, column in columns.items()}
        return MapResult(self, values, columns)


@dataclass(frozen=True, eq=False)
class MapResult(Result):
    """A map over the ``values`` of its axes: ``columns`` of one length, NaN and a ``reason`` where nothing is known."""

    map: Map
    values: Values
    columns: Columns

    def summary(self) -> dict[str, Any]:
        return lists(self.columns)

    @property
    def warnings(self) -> list[str]:
        reasons = [reason for reason in self.columns.get("reason", np.array([])).tolist() if reason]
        return [f"{len(reasons)} points are not known, the first: {reasons[0]}"] if reasons else []

    def words(self) -> list[str]:
        shown = self.map.shown
        lines = shown(self.columns) if callable(shown) else _table(self.columns, shown)
        return [self.map.title.format(**self.values), *lines]

    def figure(self) -> Figure:
        return self.map.draw(self.columns)


def _table(columns: Columns, shown: Sequence[tuple[str, str, str]]) -> Iterator[str]:
    widths = [int(form.split(".")[0].rstrip("g")) for _, _, form in shown]
    yield "  " + " ".join(f"{words:>{width}}" for (_, words, _), width in zip(shown, widths, strict=True))
    for row in zip(*(columns[name].tolist() for name, _, _ in shown), strict=True):
        yield "  " + " ".join(f"{value:>{form}}" for value, (_, _, form) in zip(row, shown, strict=True))


def map_of(name: str) -> Map:
    """The row of the map called ``name``."""
    if name not in MAPS:
        raise InputError(f'unknown map "{name}" (maps: {", ".join(MAPS)})')
    row: Map = importlib.import_module(f".{name.replace('-', '_')}_map", __package__).MAP
    return row


def rows(**columns: Any) -> Columns:
    """Columns of one length of numbers, words and arrays."""
    return dict(zip(columns, map(np.ravel, np.broadcast_arrays(*columns.values())), strict=True))


def within(least: float, most: float) -> Ranged:
    """The range of an axis."""
    return Ranged("number", least=least, most=most)


def series_at(radii: Array, specimen: Specimen, method: Method, sticks: bool = False) -> Series:
    """The series of a paraboloid of R = 1 m at the ``radii`` [m]."""
    loading = Loading.given("radius", tuple(radii.tolist()))
    return method(Problem(Paraboloid(1.0), specimen, loading, sticks)).series


def layer(nu: float, bonded: bool = True, thickness: float = 1.0) -> Specimen:
    """A layer of E* = 1 Pa and a ``thickness`` [m] on a rigid base."""
    return Specimen((Layer(Elastic(1 - nu**2, nu), thickness),), Rigid(bonded))
