"""The axes of a sweep in SI: every value that a key takes, checked in a case before anything is solved."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ...base import DISTRIBUTIONS, Distribution, InputError, draw
from ...case import AxisTable, CaseModel, DistributionTable, SamplesTable, SweepModel, model_of
from .paths import LAYER_COUNT, Tables, parse, value_at, with_values

W = "adhesion.w"


@dataclass(frozen=True)
class Axis:
    """``keys`` that vary together; each of ``rows`` holds one value per key, in SI."""

    keys: tuple[str, ...]
    rows: tuple[tuple[Any, ...], ...]


@dataclass(frozen=True)
class Trial:
    """The case in which values are tried: ``tables`` with the first value of every axis, and with all layers, however
    many a sweep keeps of them."""

    tables: Tables
    first: Mapping[str, Any]
    folder: Path

    def model(self, values: Mapping[str, Any]) -> CaseModel:
        """The case with ``values`` in place of those of ``first``; InputError says what is wrong with it."""
        return model_of(with_values(self.tables, {**self.first, **values}), "", self.folder)

    def si(self, values: Mapping[str, Any]) -> tuple[Any, ...]:
        """The values of keys that go together, in SI."""
        whole = self.model({key: value for key, value in values.items() if key != LAYER_COUNT})
        cut = self.model(values) if LAYER_COUNT in values else whole
        return tuple(value_at(cut if key == LAYER_COUNT else whole, key) for key in values)


def resolve(model: SweepModel, tables: Tables, folder: Path, source: str) -> tuple[tuple[Axis, ...], CaseModel]:
    """All axes, samples and several works of adhesion included, and the first case; a line per mistake."""
    _each_once(model, source)
    trial = Trial(tables, _first(model), folder)
    lines: list[str] = []
    with _noted(lines, f"{source}: base"):
        first = trial.model({})
    if lines:
        raise InputError(lines)
    axes = []
    for i, axis in enumerate(model.axes):
        with _noted(lines, f"{source}: axes[{i}]"):
            axes.append(_axis(axis, trial))
    if model.samples is not None:
        with _noted(lines, f"{source}: samples.of"):
            axes.append(_samples(model.samples, trial))
    if lines:
        raise InputError(list(dict.fromkeys(lines)))
    if not any(W in axis.keys for axis in axes) and len(first.adhesion.w) > 1:
        axes.append(Axis((W,), tuple((w,) for w in first.adhesion.w)))
    return tuple(axes), first


@contextlib.contextmanager
def _noted(lines: list[str], where: str) -> Iterator[None]:
    """A block whose mistakes are added to ``lines``, led by the name of the table they are in."""
    try:
        yield
    except InputError as error:
        lines += [f"{where}: {line.removeprefix(': ')}" for line in error.lines]


def _listed(axis: AxisTable) -> Mapping[str, Sequence[Any]]:
    """The values of each key of an axis as they stand in the file, of a range where it begins."""
    if axis.zip is not None:
        return axis.zip
    return {str(axis.key): (axis.start,) if axis.values is None else axis.values}


def _each_once(model: SweepModel, source: str) -> None:
    keys = [key for axis in model.axes for key in _listed(axis)] + list(model.samples.of if model.samples else ())
    if not keys:
        raise InputError(f"{source}: nothing varies: give [[axes]] or [samples]")
    if twice := sorted({key for key in keys if keys.count(key) > 1}):
        raise InputError(f"{source}: {twice[0]}: is varied twice; keys that go together stand in one zip")
    for key in keys:
        try:
            parse(key)
        except InputError as error:
            raise InputError(f"{source}: axes: {error}") from None


def _first(model: SweepModel) -> dict[str, Any]:
    """A value of every varied key that stands in the file, but for the number of layers."""
    first = {key: values[0] for axis in model.axes for key, values in _listed(axis).items()}
    for key, item in (model.samples.of if model.samples else {}).items():
        value = item.parameters[DISTRIBUTIONS[item.distribution].needed[0]]
        first[key] = value[0] if item.distribution == "choice" else value
    first.pop(LAYER_COUNT, None)
    return first


def _axis(axis: AxisTable, trial: Trial) -> Axis:
    listed = _listed(axis)
    keys = tuple(listed)
    if axis.zip is None and axis.values is None:
        return Axis(keys, tuple((value,) for value in _range(axis, trial)))
    rows = zip(*listed.values(), strict=True)
    return Axis(keys, tuple(trial.si(dict(zip(keys, row, strict=True))) for row in rows))


def _range(axis: AxisTable, trial: Trial) -> list[Any]:
    key, count = str(axis.key), axis.count or 2
    start, end = (_number(trial, key, value) for value in (axis.start, axis.end))
    if axis.spacing == "log" and not min(start, end) > 0:
        raise InputError(f"{key}: a log range needs from and to > 0, got {start:g} and {end:g}")
    spaced = (np.geomspace if axis.spacing == "log" else np.linspace)(start, end, count)
    spaced[[0, -1]] = start, end
    if isinstance(start, int) and isinstance(end, int):
        return sorted({round(value) for value in spaced.tolist()}, reverse=start > end)
    return spaced.tolist()


def _number(trial: Trial, key: str, value: Any) -> Any:
    (number,) = trial.si({key: value})
    if isinstance(number, bool) or not isinstance(number, int | float):
        raise InputError(f"{key}: is no number: give its values as a list")
    return number


def _samples(samples: SamplesTable, trial: Trial) -> Axis:
    distributions = [_distribution(key, table, trial) for key, table in samples.of.items()]
    return Axis(tuple(samples.of), tuple(draw(distributions, samples.count, samples.method, samples.seed)))


def _distribution(key: str, table: DistributionTable, trial: Trial) -> Distribution:
    if table.values is not None:
        return Distribution("choice", {"values": tuple(trial.si({key: value})[0] for value in table.values)})
    parameters = {
        name: value if name == "factor" else _number(trial, key, value) for name, value in table.parameters.items()
    }
    try:
        return Distribution(table.distribution, parameters)
    except InputError as error:
        raise InputError(f"{key}: {error}") from None
