"""A sweep as it will be run: which cases there are, what each holds, which of them share a solve, and that solve.

Bodies that differ by one factor of all moduli share one: P, S and S' scale with the moduli and delta(a) does not, so
that every problem is solved at unit modulus, E = 1 Pa at its surface. The result depends on the problem alone, never on
which of several cases asked for it first.
"""

import contextlib
import copy
import hashlib
import itertools
import math
import re
import shlex
import time
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, fields, is_dataclass, replace
from functools import cached_property, partial
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np

from .. import __version__
from ..adhesion.curve import DISPLACEMENT_CONTROL, CriticalPoint, Equilibrium, Nonadhesive
from ..adhesion.device_path import stability_under
from ..adhesion.rules import checked_rule
from ..adhesion.validity import strain_size, strain_words
from ..base.errors import LEVEL, InputError, JkrError, Unknown, counted, did_you_mean
from ..base.files import check_target
from ..base.numerics import MOST_CELLS
from ..base.units import parse as parse_quantity
from ..bodies.problem import Problem
from ..case.models import Case, CaseModel, method_of, model_of
from ..case.store import read_solution, write_solution
from ..methods.protocol import Choice, Method, choose_method, least_first, survey
from ..report import tables
from ..resolve.analysis import Analysis, adhesive, nonadhesive, with_solved_points
from ..series import Record, Solution
from ..tables.text import MOST_COLUMNS
from .sweep_file import (
    DISTRIBUTIONS,
    MOST_CASES,
    AxisTable,
    Distribution,
    DistributionTable,
    SweepModel,
    draw,
    load_sweep,
)

# --------------------------------------------------------------------------------------------------
# Keys of a case file as paths, "specimen.layers[0].nu": written into its tables, read from its model.

KeyPath = tuple[str | int, ...]
Tables = dict[str, Any]
LAYER_COUNT = "specimen.layers.count"  # a key of sweeps alone: the first so many layers of the base case
_KEY = re.compile(r"[A-Za-z_]\w*(\[\d+\])?(\.[A-Za-z_]\w*(\[\d+\])?)*")
UNITS = {"m": "m", "Pa": "Pa", "N": "N", "J/m^2": "J_per_m2", "N/m": "N_per_m", "rad": "rad"}


RADIUS, TO_RADIUS = "indenter.radius", "loading.radius"


def parse(key: str) -> KeyPath:
    """``"specimen.layers[0].nu"`` -> ``("specimen", "layers", 0, "nu")``."""
    if not _KEY.fullmatch(key):
        raise InputError(f'must be a key of a case such as "specimen.layers[0].nu", got "{key}"')
    return tuple(int(part) if part.isdigit() else part for part in re.findall(r"\w+", key))


def with_values(tables: Tables, values: Mapping[str, Any]) -> Tables:
    """A copy of a case's tables in which every key has its value."""
    changed = copy.deepcopy(tables)
    for key, value in values.items():
        if key != LAYER_COUNT:
            _assign(changed, key, copy.deepcopy(value))
    if LAYER_COUNT in values:
        count = values[LAYER_COUNT]
        layers = changed.get("specimen", {}).get("layers", [])
        number = isinstance(count, int | float) and not isinstance(count, bool)
        if not (number and 0 <= count <= len(layers) and count == int(count)):
            raise InputError(f"{LAYER_COUNT}: must be a whole number from 0 to {len(layers)}, got {count}")
        changed["specimen"]["layers"] = layers[: int(count)]
    if RADIUS in values and TO_RADIUS not in values and changed["indenter"].get("shape") == "flat":
        with contextlib.suppress(KeyError, TypeError, ValueError):  # loaded otherwise, or no lengths: judged as a case
            R, a, other = (
                parse_quantity(length, "length") if isinstance(length, str) else float(length)
                for length in (tables["indenter"]["radius"], tables["loading"]["radius"], values[RADIUS])
            )
            changed["loading"]["radius"] = a / R * other  # the edge is pinned at the radius
    return changed


def _assign(tables: Tables, key: str, value: Any) -> None:
    *parents, last = parse(key)
    here: Any = tables
    for i, part in enumerate([*parents, last]):
        is_list = isinstance(here, list | tuple)
        if isinstance(part, int) and not (is_list and part < len(here)):
            there = counted(len(here) if is_list else 0, "entry", "entries")
            raise InputError(f"{key}: the base case has {there} there, numbered from 0")
        if isinstance(part, str) and not isinstance(here, dict):
            listed = "".join(f"[{p}]" if isinstance(p, int) else f".{p}" for p in parents[:i]).removeprefix(".")
            remedy = f"a list, its entries are {listed}[0], [1], ..." if is_list else "no table"
            raise InputError(f'{key}: has no "{part}": {listed} is {remedy}')
        if i == len(parents):
            here[part] = value
        else:
            here = here[part] if isinstance(part, int) else here.setdefault(part, {})


def value_at(model: CaseModel, key: str) -> Any:
    """The value of ``key`` in SI; tables as plain dicts, a list of one number as the number."""
    if key == LAYER_COUNT:
        return len(model.specimen.layers)
    here: Any = model.model_dump(exclude_none=True)
    for part in parse(key):
        here = here[part]
    if isinstance(here, tuple) and len(here) == 1 and isinstance(here[0], float):
        return here[0]
    return here


def unit_of(tables: Tables, key: str, value: Any, folder: Path | None) -> str:
    """The SI unit of ``key`` for a column's name, "" for plain numbers and words: the one that the case accepts."""
    if key == LAYER_COUNT or isinstance(value, bool) or not isinstance(value, int | float):
        return ""
    for unit, name in UNITS.items():
        try:
            model_of(with_values(tables, {key: f"{value!r} {unit}"}), "", folder)
        except InputError:
            continue
        return name
    return ""


# --------------------------------------------------------------------------------------------------
# The axes of a sweep in SI: every value that a key takes, checked in a case before anything is solved.

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
    # A value of every varied key that stands in the file, but for the number of layers
    values = {key: listed[0] for axis in model.axes for key, listed in _listed(axis).items()}
    for key, item in (model.samples.of if model.samples else {}).items():
        value = item.parameters[DISTRIBUTIONS[item.distribution].needed[0]]
        values[key] = value[0] if item.distribution == "choice" else value
    values.pop(LAYER_COUNT, None)
    trial = Trial(tables, values, folder)
    lines: list[str] = []
    with _noted(lines, f"{source}: base"):
        first = trial.model({})
    if lines:
        raise InputError(lines)
    axes = []
    for i, axis in enumerate(model.axes):
        with _noted(lines, f"{source}: axes[{i}]"):
            listed = _listed(axis)
            if axis.zip is None and axis.values is None:
                rows = [(value,) for value in _range(axis, trial)]
            else:
                by_case = zip(*listed.values(), strict=True)
                rows = [trial.si(dict(zip(listed, row, strict=True))) for row in by_case]
            axes.append(Axis(tuple(listed), tuple(rows)))
    if model.samples is not None:
        with _noted(lines, f"{source}: samples.of"):
            samples = model.samples
            distributions = [_distribution(key, table, trial) for key, table in samples.of.items()]
            drawn = draw(distributions, samples.count, samples.method, samples.seed)
            axes.append(Axis(tuple(samples.of), tuple(drawn)))
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
        raise InputError(f"{source}: {twice[0]}: varies twice; put keys that vary together into one zip")
    for key in keys:
        try:
            parse(key)
        except InputError as error:
            raise InputError(f"{source}: axes: {error}") from None


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


# --------------------------------------------------------------------------------------------------
# What a sweep can tell of a case: the numbers of the summary that ``jkr transform`` writes, by the same names.

Value = float | int | str
POINT = ("P_N", "delta_m", "a_m")
ERROR = ("P_err_N", "delta_err_m")


def _of_both(keys: Sequence[str]) -> Iterator[str]:
    """The names of the ``keys`` under control of load and of displacement."""
    return (f"{control}.{key}" for control in ("load", "displacement") for key in keys)


RATIOS = ("h_over_R", "a_over_h_at_pull_off", "w_R2_over_Estar_h3")
STRAINS = "validity.large_strains"  # beside every pull-off force, asked for or not: it is a doubt of the row
SECTIONS: dict[str, tuple[str, ...]] = {
    "solved_by": ("method", "slopes"),
    "contact": ("E_star_Pa",),
    "end": ("points", "a_m", "delta_H_m", "P_H_N"),
    "pull_off": (*_of_both(POINT), "load.over_pi_w_R"),
    "pull_off_errors": (*_of_both(ERROR), "level"),
    "stability": ("energy_lost_J", "work_of_separation_J", *(f"jump_in.{key}" for key in POINT)),
    "validity": ("tabor", "a_over_R", "a_over_R_pull_off", "delta_over_h", "a_over_h", "a_over_L", "large_strains"),
    "ratios": RATIOS,
    "errors": ("discretisation", "truncation", "radius", "smoothing", "total"),
    "comparison": ("pull_off",),
}


def told_of(result: Analysis, section: str) -> dict[str, Any]:
    """The numbers of one of the ``SECTIONS``, by its names, or why there are none."""
    problem, R = result.problem, result.problem.indenter.tip_radius
    match section:
        case "solved_by":
            return {"method": result.solution.method, "slopes": result.curve.slopes.method}
        case "contact":
            return {"E_star_Pa": problem.E_star}
        case "end":
            series = result.curve.series
            return {"points": len(series)} | dict(zip(("a_m", "delta_H_m", "P_H_N"), series.end, strict=True))
        case "pull_off":
            # the pull-off force under load control as -P/(pi w R): 3/2 on a half-space
            ratio: Any = (at := result.pull_off["load"])
            if not isinstance(at, Unknown):
                ratio = Unknown("the indenter has no tip radius") if R is None else -at.P / (math.pi * result.w * R)
            load, displacement = (_point(name, result.pull_off[name]) for name in ("load", "displacement"))
            return load | displacement | {"load.over_pi_w_R": ratio}
        case "pull_off_errors":  # half-widths of P and delta of each point
            errors: dict[str, Any] = {"level": LEVEL}
            for name, point in result.pull_off.items():
                error = point if isinstance(point, Unknown) else result.pull_off_errors[name]
                for key, quantity in zip(ERROR, ("P", "delta"), strict=True):
                    errors[f"{name}.{key}"] = error if isinstance(error, Unknown) else error[quantity]
            return errors
        case "stability":
            pulled = stability_under(result.curve, DISPLACEMENT_CONTROL)
            energies = {"energy_lost_J": pulled.energy_lost, "work_of_separation_J": pulled.separation}
            return energies | _point("jump_in", pulled.jump_in)
        case "validity":  # of large strains the largest change of a pull-off force, 0 where negligible
            points = [point for point in result.pull_off.values() if isinstance(point, CriticalPoint)]
            change = max(map(result.large_strains, points), key=strain_size, default=None)
            told = Unknown(strain_words(change)) if isinstance(change, Unknown) else strain_size(change)
            return tables.validity(result) | {"large_strains": told if points else Unknown("")}
        case "ratios":  # h/R, a/h at pull-off under load control, w R^2/(E* h^3), h of the thinner layer that touches
            h, at = problem.top_thickness, result.pull_off["load"]
            if not math.isfinite(h) or R is None:
                return dict.fromkeys(RATIOS, Unknown("there is no layer, or no tip radius"))
            a = at if isinstance(at, Unknown) else at.a / h
            return dict(zip(RATIOS, (h / R, a, result.w * R**2 / (problem.E_star * h**3)), strict=True))
        case "errors":
            return result.budget.as_dict()
        case "comparison":
            return {"pull_off": result.comparison.pull_off if result.comparison else Unknown("")}
    raise ValueError(section)


def _point(name: str, state: Equilibrium | Unknown) -> dict[str, Any]:
    columns = tables.point(state)
    return {f"{name}.{key}": Unknown(columns["reason"]) if columns[key] is None else columns[key] for key in POINT}


NAMES = tuple(f"{section}.{key}" for section, keys in SECTIONS.items() for key in keys)
NEED_W = ("pull_off", "pull_off_errors", "stability")
# Absent by the kind of body, the same in every case: no reason is given
OF_THE_KIND = ("validity.", "comparison.", "ratios.")
ALONG = ("P_N", "delta_m", "P_H_N", "delta_H_m", "S_N_per_m", "dS_da_N_per_m2")


@dataclass(frozen=True)
class Wanted:
    """The columns of a sweep's table: ``names`` among ``NAMES``; all of ``ALONG`` at each of ``radii`` [m]; the
    pull-off by devices of each ``stiffness`` [N/m]. ``slopes``: how S and S' are found."""

    names: tuple[str, ...]
    radii: tuple[float, ...] = ()
    stiffness: tuple[float, ...] = ()
    slopes: str = "auto"
    columns: tuple[str, ...] = field(init=False)

    def __post_init__(self) -> None:
        devices = [f"pull_off.{k:g}_N_per_m.{key}" for k in self.stiffness for key in POINT]
        along = [f"at_{a:g}_m.{key}" for a in self.radii for key in ALONG]
        object.__setattr__(self, "columns", (*self.names, *devices, *along))

    def values(self, result: Analysis) -> list[Value | Unknown]:
        """One value per column."""
        result = with_solved_points(result, *self.stiffness) if self.stiffness else result
        told: dict[str, Any] = {}
        for section in dict.fromkeys(name.split(".")[0] for name in self.names):
            told |= {f"{section}.{key}": value for key, value in told_of(result, section).items()}
        values = list[Value | Unknown]()
        for name in self.names:
            value = told[name]
            if isinstance(value, Unknown):  # the reason, but for what bodies of this kind never have
                value = Unknown("") if name.startswith(OF_THE_KIND) and name != STRAINS else value
            elif not isinstance(value, int | str):
                value = float(value) if math.isfinite(value) else Unknown(f"{name} is not finite")
            values.append(value)
        for k in self.stiffness:
            values += _point("device", result.curve.pull_off(result.curve.series.control_of_force(k))).values()
        # ``ALONG`` of the curve at each of the contact radii [m]; index H: without adhesion
        curve, a = result.jkr, np.array(self.radii)
        beyond = curve.beyond(a)
        delta, P = curve.at(a[~beyond])
        delta_H, P_H, S, dS, _ = curve.nonadhesive.parts(a[~beyond])
        rows = iter(np.stack([P, delta, P_H, delta_H, S, dS], axis=1).tolist())
        for place, out in zip(self.radii, beyond.tolist(), strict=True):
            values += [Unknown(curve.beyond_words(place))] * len(ALONG) if out else next(rows)
        return values


def names_of(words: Sequence[str], source: str) -> tuple[str, ...]:
    """All names that the ``words`` mean, those of groups ("pull_off", "pull_off.load") each; InputError for others."""
    names: dict[str, None] = {}
    for word in words:
        meant = [name for name in NAMES if name == word or name.startswith(f"{word}.")]
        if not meant:
            hint = did_you_mean(word, [*SECTIONS, *NAMES])
            raise InputError(
                f'{source}: outputs.quantities: unknown quantity "{word}"{hint} (groups: {", ".join(SECTIONS)}; '
                f"single ones: {', '.join(NAMES)})"
            )
        names |= dict.fromkeys(meant)
    return tuple(names)


FIRM = ("radius", "thickness", "nu")  # how keys end whose values tell bodies apart
PHYSICS = {"title", "indenter", "specimen", "loading", "adhesion"}
OK, FAILED = "ok", "failed"
Cases: TypeAlias = Sequence[tuple[int, Mapping[str, Any]]]  # by their numbers and values, which share one solve

# How solves are distinguished and which are kept.
SHARING_DIGITS = 13  # of numbers at unit modulus, theory: of the 16 of a double quotients lose the last ones
SHARING_WORTH_KEEPING = 0.1  # choice: CPU seconds; reading a file takes a tenth of it


@dataclass(frozen=True)
class CaseTemplate:
    """What a worker needs to know to make a case of given values: the base case's ``tables``, what is wanted."""

    tables: Tables
    wanted: Wanted
    folder: Path

    def model(self, values: Mapping[str, Any]) -> CaseModel:
        """The case with the given values, validated; InputError where they make none."""
        model = model_of(with_values(self.tables, values), "", self.folder)
        if len(model.adhesion.w) > 1:
            raise InputError(f"{W}: a case of a sweep takes one value, got {list(model.adhesion.w)}")
        if ranged := [name for name in ("range", "stress", "capillary") if getattr(model.adhesion, name) is not None]:
            raise InputError(f"adhesion.{ranged[0]}: sweep has no adhesion of finite range: leave it out")
        return model


@dataclass(frozen=True)
class Plan:
    """All cases of a sweep: the product of its ``axes``, the last one running fastest; ``over``: the quantity over
    which its picture is drawn, "" where that is the longest axis."""

    source: str
    title: str
    recipe: CaseTemplate
    axes: tuple[Axis, ...]
    over: str = ""

    @property
    def keys(self) -> tuple[str, ...]:
        """All keys that vary."""
        return tuple(key for axis in self.axes for key in axis.keys)

    @property
    def key_columns(self) -> tuple[str, ...]:
        """The names of their columns: the key and its SI unit."""
        tables, folder = self.recipe.tables, self.recipe.folder
        return tuple(f"{key}_{unit_of(tables, key, x, folder)}".removesuffix("_") for key, x in self.values(0).items())

    @property
    def count(self) -> int:
        return math.prod(len(axis.rows) for axis in self.axes)

    def values(self, number: int) -> dict[str, Any]:
        """The values of case ``number`` (from 0) by key, in SI."""
        rows = []
        for axis in reversed(self.axes):
            number, i = divmod(number, len(axis.rows))
            rows.append(zip(axis.keys, axis.rows[i], strict=True))
        return dict(itertools.chain.from_iterable(reversed(rows)))

    @property
    def least_solves(self) -> int:
        """Solves that all cases together need at least: values that may cancel (w, moduli, a load over them) or be cut
        off with their layer count as none."""
        cut = LAYER_COUNT in self.keys
        # Of each axis, how many differ in what makes another body, whatever the moduli and the number of layers are.
        solves = 1
        for axis in self.axes:
            firm = [i for i, key in enumerate(axis.keys) if key.endswith(FIRM) and not (cut and "layers" in key)]
            solves *= len({repr([row[i] for i in firm]) for row in axis.rows})
        return solves

    def identity(self, number: int) -> str:
        """A hash of everything that the row of a case depends on: what journals know it by."""
        digest = self._head.copy()
        digest.update(f"\n{self.values(number)!r}".encode())
        return digest.hexdigest()[:20]

    @cached_property
    def _head(self) -> Any:
        return hashlib.sha256(f"{__version__}\n{self.recipe.tables!r}\n{self.recipe.wanted!r}".encode())

    def command(self, number: int) -> str:
        """What solves one case alone and prints its row."""
        return shlex.join(["jkr", "sweep", self.source, "--only", str(number)])

    def case(self, number: int) -> Case:
        """Case ``number`` as a case of its own."""
        return Case(self.recipe.model(self.values(number)), f"{self.source}: case {number}")

    def groups(self, numbers: Iterable[int], most: int = 1000) -> tuple[list[Cases], list[tuple[int, str]]]:
        """The cases ``numbers`` by shared solves, and those that are none, each with its reason.

        Cases share a solve where they differ in the work of adhesion, or by one factor of all moduli, alone; at most
        ``most`` make one piece of work.
        """
        shared: dict[Any, list[tuple[int, dict[str, Any]]]] = {}
        wrong = []
        for number in numbers:
            values = self.values(number)
            try:
                model = self.recipe.model(values)
                body = at_unit_modulus(model.problem())[0]
            except InputError as error:
                wrong.append((number, "; ".join(line.removeprefix(": ") for line in error.lines)))
                continue
            solve = f"{body.key}{model.model_dump(exclude=PHYSICS)!r}"  # the body and how it is to be solved
            shared.setdefault(hashlib.sha256(solve.encode()).digest(), []).append((number, values))
        pieces = (cases[first : first + most] for cases in shared.values() for first in range(0, len(cases), most))
        return list(pieces), wrong


def at_unit_modulus(problem: Problem) -> tuple[Problem, float]:
    """The problem with all moduli (and a load, where one is prescribed) over the surface's E, and that E [Pa]."""
    factor = problem.specimen.surface.E
    return _rounded(problem.scaled(1 / factor)), factor


def _rounded(value: Any) -> Any:
    """``value`` rounded throughout (to ``SHARING_DIGITS``): quotients that are equal on paper become equal."""
    if isinstance(value, float):
        return float(f"{value:.{SHARING_DIGITS - 1}e}")
    if isinstance(value, tuple):
        return tuple(_rounded(item) for item in value)
    if is_dataclass(value) and not isinstance(value, type):
        return replace(value, **{item.name: _rounded(getattr(value, item.name)) for item in fields(value) if item.init})
    return value


def load_plan(path: Path) -> Plan:
    """The plan of the sweep file at ``path``; InputError with a line per mistake."""
    model, tables, folder = load_sweep(path)
    source = str(path)
    wanted = _wanted(model, source)
    axes, first = resolve(model, tables, folder, source)
    of_w = wanted.stiffness or any(name.split(".")[0] in NEED_W for name in wanted.names)
    if of_w and not any(first.adhesion.w):
        raise InputError(
            f"{source}: the requested quantities need a work of adhesion: vary adhesion.w, or set it in the base case"
        )
    # The base case with a profile's points in place of the name of their file, so that workers need no file
    indenter = tables.get("indenter", {})
    if "file" not in indenter or any(key == "indenter.file" for axis in axes for key in axis.keys):
        self_contained = tables
    else:
        points = {key: first.model_dump()["indenter"][key] for key in ("r", "f")}
        rest = {key: value for key, value in indenter.items() if key != "file"}
        self_contained = {**tables, "indenter": rest | points}
    # Where the body of the base case tells that no case has the quantity over which the picture is drawn
    problem, over, lost = first.problem(), model.outputs.over, ""
    varied, ratio = {key for axis in axes for key in axis.keys}, over.startswith("ratios.")
    of_shape = {key for key in varied if key.startswith("indenter.")} - {"indenter.radius", "indenter.half_angle"}
    layered = math.isfinite(problem.top_thickness) or any("layers" in key for key in varied)
    if (ratio or over.endswith(".over_pi_w_R")) and problem.indenter.tip_radius is None and not of_shape:
        lost = f'the shape "{first.indenter.shape}" has no tip radius'
    elif ratio and not layered:
        lost = "there is no layer"
    if lost:
        raise InputError(f"{source}: outputs.over: {over} is no number of these cases: {lost}; leave it out")
    plan = Plan(source, model.title, CaseTemplate(self_contained, wanted, folder), axes, over)
    if plan.count > MOST_CASES:
        raise InputError(f"{source}: makes {plan.count:,} cases, at most {MOST_CASES:,} are allowed in one sweep")
    if (cells := plan.count * len(wanted.columns)) > MOST_CELLS:
        raise InputError(
            f"{source}: makes {plan.count:,} cases of {len(wanted.columns):,} columns, {cells:,} cells, at most "
            f"{MOST_CELLS:,} are written; use fewer cases, quantities, radii or devices"
        )
    return plan


def _wanted(model: SweepModel, source: str) -> Wanted:
    outputs = model.outputs
    columns = len(ALONG) * len(outputs.radii) + len(POINT) * len(outputs.stiffness)
    if columns > MOST_COLUMNS:
        raise InputError(
            f"{source}: outputs.radii and outputs.stiffness make {columns:,} columns, at most {MOST_COLUMNS:,} are "
            "written; use fewer"
        )
    rule = checked_rule(outputs.slopes, f"{source}: outputs.slopes")
    names = names_of(outputs.quantities, source)
    if outputs.over and outputs.over not in NAMES:
        hint = did_you_mean(outputs.over, NAMES)
        raise InputError(f'{source}: outputs.over: must be one quantity, such as ratios.h_over_R, got "{outputs.over}"'
                         f"{hint}")  # fmt: skip
    names = tuple(dict.fromkeys((*names, *filter(None, [outputs.over]))))
    # Beside pull-off points their half-widths, and beside pull-off forces what large strains change of them
    controls = dict.fromkeys(name.split(".")[1] for name in names if name.startswith("pull_off."))
    if outputs.stiffness or controls:
        errors = (f"pull_off_errors.{control}.{key}" for control in controls for key in ERROR)
        names = tuple(dict.fromkeys((*names, STRAINS, *errors)))
    return Wanted(names, outputs.radii, outputs.stiffness, rule)


# ---------------------------------------------------------------------- the work that goes to a worker
@dataclass(frozen=True)
class Row:
    """One row of the table: ``values`` per column, None where there is none; ``reason``: why it failed, or why values
    are missing; ``seconds``: CPU time of the case, its share of a common solve included."""

    number: int
    status: str
    reason: str
    values: tuple[Value | None, ...]
    seconds: float


def solve_group(recipe: CaseTemplate, folder: Path | None, cases: Cases) -> list[Row]:
    """Solve what ``cases`` share, and read off each what is wanted; failures become rows.

    ``folder``: of expensive solves of earlier runs.
    """
    start = time.process_time()
    try:
        model = recipe.model(cases[0][1])
        solution = _solved(at_unit_modulus(model.problem())[0], model, folder)
        body = nonadhesive(solution, recipe.wanted.slopes)
    except Exception as error:
        share = (time.process_time() - start) / len(cases)
        return [failed(recipe, number, error, share) for number, _ in cases]
    share = (time.process_time() - start) / len(cases)
    return [_row(recipe, solution, body, number, values, share) for number, values in cases]


def _solved(body: Problem, model: CaseModel, folder: Path | None) -> Solution:
    """The solution by the case's method; where "auto" has the choice and a method fails, by the next one."""
    build = partial(method_of, model)
    choice: Choice | None = cheapest_method(body, model)
    while choice is not None:
        try:
            return solved_once(body, choice.method, folder)
        except JkrError as error:
            if model.method != "auto":
                raise
            failure, options = error, choice.options or choose_method(body, "auto", build).options
            choice = replace(choice, options=options).after_failure(error, build)
    raise failure


def solved_once(problem: Problem, method: Method, folder: Path | None = None) -> Solution:
    """The solution of ``problem`` by ``method``: from ``folder`` where it is kept there, else solved, and kept there
    where that was expensive (``SHARING_WORTH_KEEPING``)."""
    # A hash of all that a solve depends on: the physics, the method with its options, the release.
    key = hashlib.sha256(f"{problem.key}\n{method!r}\n{__version__}".encode()).hexdigest()[:24]
    path = None if folder is None else folder / f"{key}.h5"
    if path is not None and path.exists():
        with contextlib.suppress(InputError):  # a damaged file is solved again, as one that holds another solve
            stored = read_solution(path, problem)
            if stored.record.command_line == _made_by(key):
                return stored
    start = time.process_time()
    solution = replace(method(problem), record=Record(path=Path("series")))
    expensive = time.process_time() - start > SHARING_WORTH_KEEPING
    if path is not None and expensive and solution.raw is None and path.parent.is_dir():
        with contextlib.suppress(JkrError):  # no room, or a shape that no case can say: it is solved every time
            check_target(path, force=True)  # also what is damaged
            write_solution(path, solution, _made_by(key))
    return solution


def _made_by(key: str) -> str:
    """The command line of a kept solution, by which its origin is checked."""
    return f"jkr sweep, solve {key}"


def cheapest_method(body: Problem, model: CaseModel) -> Choice:
    """What ``choose`` chooses, without asking the methods behind the first that will do: that would cost more."""
    build = partial(method_of, model)
    for name in least_first() if model.method == "auto" else ():
        (option,) = survey(body, build, [name])
        if option.is_accurate and option.is_quick:
            return Choice(name, build(name), "the simplest method for this body")
    return choose_method(body, model.method, build)


def _row(
    recipe: CaseTemplate, solution: Solution, body: Nonadhesive, number: int, values: Mapping[str, Any], share: float
) -> Row:
    """What is wanted of one case; ``solution``, ``body``: at unit modulus, which all cases of the group share."""
    start = time.process_time()
    try:
        model = recipe.model(values)
        works, z0 = model.adhesion.w, model.adhesion.z0
        factor = at_unit_modulus(model.problem())[1]
        solution = replace(solution, record=replace(solution.record, z0=z0))
        result = adhesive(solution, body, works[0] if works else 0.0, factor)
        wanted = recipe.wanted.values(result)
    except Exception as error:
        return failed(recipe, number, error, share + time.process_time() - start)
    reasons = dict.fromkeys(value.reason for value in wanted if isinstance(value, Unknown) and value.reason)
    cells = tuple(None if isinstance(value, Unknown) else value for value in wanted)
    return Row(number, OK, "; ".join(reasons), cells, share + time.process_time() - start)


def failed(recipe: CaseTemplate, number: int, why: str | Exception, seconds: float = 0.0) -> Row:
    """The row of a case without a result; errors that are no message for users are bugs: their type tells so."""
    if isinstance(why, Exception) and not isinstance(why, JkrError):
        why = f"unexpected {type(why).__name__}: {why}"
    return Row(number, FAILED, " ".join(str(why).split()), (None,) * len(recipe.wanted.columns), seconds)
