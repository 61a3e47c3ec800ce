"""The solution file (HDF5): a solution with its case, written whole under one digest, checked when it is read."""

import math
import platform
import sys
from collections.abc import Callable, Iterator, Sequence
from dataclasses import fields, replace
from pathlib import Path
from typing import Any

import numpy as np
import tomli_w

from .. import __version__
from ..base import hdf5, process
from ..base.errors import LEVEL, Estimate, InputError, JkrError, Unknown
from ..base.files import read_bytes, write_bytes
from ..base.numerics import HALF_WIDTH, MOST_CELLS, Array, half_width
from ..base.process import one_thread
from ..base.units import LARGEST_SI
from ..bodies.problem import Problem
from ..methods.protocol import METHODS, Choice, Limits, Method, check_cost, choose_method, long_look, method_class
from ..series import (
    COLUMNS,
    CoarseSeries,
    ErrorBudget,
    KeptKernel,
    PressureTable,
    RawSeries,
    Record,
    Series,
    Solution,
    first_of_plateaus,
    is_series,
)
from .models import MOST_BYTES, Case, case_of, method_of, parse_case, parse_toml

SERIES, VERSION = "jkr-series", 2  # type and version of the file
COARSER = ("coarser", "coarsest")  # groups of the series by larger and by still larger elements
# What the resolved case of an earlier release left unsaid, by shape: a case of today says it
EARLIER = {"rounded-cone": {"cap": "parabola"}, "pyramid": {"equal": "area"}, "three-sided-pyramid": {"equal": "area"}}
UNPROTECTED = 1  # the format without a digest
EARLIER_LEVEL = 0.9  # of the errors in files that state none
KERNEL = {  # tables of a kernel that is kept: unit, and what they are
    "coefficients": ("1/m", "of even Legendre polynomials, row by row: of the kernel, then of its companions"),
    "weights": ("1", "part of a companion's change of delta, P, S, dS/da that is left as an error"),
    "errors": ("1", "relative, of delta, P, S, dS/da: by elements, by polynomials, by the cut, at the radii"),
}
TOUCHES = "touches"  # group of the series at the moments at which increments reach nodes
ELEMENT = "element"  # of the increments: distance of a node to the next
PACKAGES = {"numpy": "numpy", "scipy": "scipy", "gmsh": "gmsh", "scikit-fem": "skfem", "h5py": "h5py"}  # modules
NO_DIGEST = (
    "the solution file is of format 1, which has no digest: damage to its case or texts may go unnoticed; run the case "
    "again for full protection"
)


def record_of(case: Case, path: Path = Record.path) -> Record:
    """What a solution of ``case`` keeps of it."""
    adhesion = case.model.adhesion
    works, length = adhesion.works, adhesion.range
    return Record(case.model.title, works, adhesion.z0, path, case, stress=adhesion.tension, length=length)


def versions() -> dict[str, str]:
    """Versions of jkr, Python and the packages that a result depends on: those that this process has loaded."""
    loaded = {name: sys.modules[module].__version__ for name, module in PACKAGES.items() if module in sys.modules}
    return {"jkr": __version__, "python": platform.python_version(), **loaded}


# ---------------------------------------------------------------------- writing
def write_solution(path: Path, solution: Solution, command_line: str = "") -> None:
    """Write ``solution`` to ``path``, whole or not at all; ``command_line``: what made it, unless its record has
    that."""
    series, raw, pressure, record = solution.series, solution.raw, solution.pressure, solution.record
    first = {"a0_m": series.a0} | ({} if series.S0 is None else {"S0_N_per_m": series.S0})
    errors, columns, larger = _errors(series), _columns(series), dict(_larger_elements(series))
    made_with = record.versions or versions()
    budget = {
        name: value.reason if isinstance(value, Unknown) else float(value)
        for name, value in solution.budget.as_dict().items()
    } | {"level": LEVEL}
    text, key = (record.case or case_of(solution.problem)).to_toml(solution.method), solution.problem.key
    members: dict[str, hdf5.Group | hdf5.Dataset] = {
        "case": hdf5.Dataset(text),
        "series": hdf5.Group(first, columns),
        "errors": hdf5.Group(budget, errors),
        "facts": hdf5.Group(solution.facts),
        "timings_s": hdf5.sealed(hdf5.Group(solution.timings)),  # by itself: two runs have one digest
        "versions": hdf5.Group(made_with),
        "warnings": hdf5.Group({str(i): text for i, text in enumerate(solution.warnings)}),
    }
    members |= larger
    if raw is not None:
        rows = hdf5.unit_column(np.asarray(raw.rows), "1", "number of the row")
        # The distance of nodes to the next ones, where it is known
        if raw.element is None:
            element = {}
        else:
            element = {ELEMENT: hdf5.unit_column(raw.element, "m", "distance from the node to the next one")}
        members["increments"] = hdf5.Group({}, _columns(raw) | {"row": rows} | element)
    if solution.touches is not None:
        members[TOUCHES] = hdf5.Group({}, _columns(solution.touches))
        members[f"{TOUCHES}_errors"] = hdf5.Group({}, _errors(solution.touches))
        members |= dict(_larger_elements(solution.touches))
    if (kept := solution.kernel) is not None:  # with what is known of its errors: tables, one after another as rows
        facts = {name: getattr(kept, name) for name in ("accuracy", "least")}
        flat = {name: getattr(kept, name).reshape(-1, getattr(kept, name).shape[-1]) for name in KERNEL}
        tables = {name: hdf5.unit_column(flat[name], unit, words) for name, (unit, words) in KERNEL.items()}
        radii = hdf5.unit_column(kept.radii, "m", "radii of the errors")
        numbers = {"reach_m": kept.reach, "scale_m": kept.scale, "of_side": int(kept.of_side)} | facts
        members["kernel"] = hdf5.Group(numbers, {**tables, "radii": radii})
    if pressure is not None:
        r = hdf5.unit_column(pressure.r, "m", "radii of the contact nodes")
        p = hdf5.unit_column(pressure.p, "Pa", "contact pressure, one row per increment")
        members["contact"] = hdf5.sealed(hdf5.Group({}, {"r": r, "pressure": p}))
    identity = {"format": SERIES, "version": VERSION, "method": solution.method, "problem_key": key}
    write_bytes(path, hdf5.image(hdf5.Group(identity | {"command_line": record.command_line or command_line}, members)))


def _larger_elements(series: Series) -> Iterator[tuple[str, hdf5.Group]]:
    """The groups of the series by larger elements."""
    for name in COARSER:
        if series.coarser is None:
            return
        ratio, series = series.coarser.ratio, series.coarser.series
        yield name, hdf5.Group({"ratio": ratio}, _columns(series))


def _errors(series: Series) -> dict[str, hdf5.Group | hdf5.Dataset]:
    """The errors of the columns, each with the quantity that is equal in the comparison with the truth."""
    at_radius = series.errors_at_radius
    equal = {name: "displacement" if at_radius and name in ("a", "delta", "P") else "radius" for name in COLUMNS}
    errors = [(name, "", equal[name], values) for name, values in series.errors.items()]
    errors += [(name, "_at_equal_a", "radius", values) for name, values in at_radius.items()]
    columns: dict[str, hdf5.Group | hdf5.Dataset] = {}
    for key, more, same, values in errors:
        name, unit, *_ = COLUMNS[key]
        columns[name + more] = hdf5.unit_column(values, unit, f"estimated absolute error of {name} at equal {same}")
    return columns


def _columns(rows: Series | RawSeries) -> dict[str, hdf5.Group | hdf5.Dataset]:
    there = {key: values for key in COLUMNS if (values := getattr(rows, key, None)) is not None}
    return {COLUMNS[key].name: hdf5.unit_column(values, *COLUMNS[key][1:3]) for key, values in there.items()}


# ---------------------------------------------------------------------- reading
def read_solution(path: str | Path, problem: Problem | None = None, with_pressure: bool = False) -> Solution:
    """Read and check a solution file; InputError in one line where it is missing, foreign, truncated or damaged.

    ``problem``: what the file is known to be of, else that of its case; ``with_pressure``: the contact pressures too.
    """
    path = path if isinstance(path, Path) else Path(path)
    content = read_bytes(path, "solution file")
    if not content.startswith(hdf5.SIGNATURE):
        of_case, of_table = ", jkr run makes one from a case", "; a table of measurements is for jkr look and jkr fit"
        remedy = {".toml": of_case, ".h5": ""}.get(path.suffix, of_table)
        raise InputError(f"{path}: is not an HDF5 file{remedy}")
    root = hdf5.tree_of(path, content, () if with_pressure else ("contact",))
    try:
        # Refuse what is no solution file of ours, of another release, or not as it was written.
        kind, version = root.attributes.get("format", ""), root.attributes.get("version", 0)
        if kind != SERIES:
            raise InputError(f'{path}: format must be "{SERIES}", got "{kind}"; was this file written by jkr?')
        if version not in (UNPROTECTED, VERSION):
            raise InputError(
                f"{path}: version must be {VERSION}, got {version}; this file needs another release of jkr"
            )
        if not hdf5.is_sound(root) and (version == VERSION or hdf5.SEAL in root.attributes):
            raise hdf5.unreadable(path, content, " (it does not hold what was written)")
        return _Reader(path, root).solution(problem)
    except hdf5.UNREADABLE:  # a list where a number or a text belongs, and the like
        raise hdf5.unreadable(path, content) from None


class _Reader:
    """The parts of the file at ``path``, each checked."""

    def __init__(self, path: Path, root: hdf5.Group):
        self.path, self.root = path, root
        self.sealed = root.attributes["version"] != UNPROTECTED

    def solution(self, problem: Problem | None) -> Solution:
        attributes, record = self.root.attributes, Record(path=self.path)
        name, solver = str(attributes.get("method", "unknown")), None
        if problem is not None and attributes.get("problem_key") != problem.key:
            raise InputError(f"{self.path}: is a solution of another problem")
        if problem is None:
            source, text = f"{self.path}: case", self.case()
            tree = parse_toml(text.encode(), source)
            if isinstance(indenter := tree.get("indenter"), dict):
                # Shapes whose meaning has changed since keep that which they had
                keys = EARLIER.get(str(indenter.get("shape")), {})
                if not keys.keys() <= indenter.keys():
                    text = tomli_w.dumps(tree | {"indenter": keys | indenter})
            case = Case(parse_case(text.encode(), source).model, source, text)
            record, problem = record_of(case, self.path), case.model.problem()
            solver = method_of(case.model, name) if name in METHODS else None
        series, raw = self.rows()
        warnings = tuple(map(str, self.words("warnings").values()))
        return Solution(
            problem,
            series,
            self.budget(),
            name,
            raw,
            self.pressure(),
            self.words("facts"),
            self.words("timings_s"),
            warnings if self.sealed else (*warnings, NO_DIGEST),
            replace(record, command_line=str(attributes.get("command_line", "")), versions=self.words("versions")),
            kernel=self.kernel(),
            touches=self.touches(series),
            solver=solver,
        )

    def case(self) -> str:
        data = self.dataset("", "case")
        if not isinstance(data.values, str) or len(data.values) > MOST_BYTES:
            raise InputError(f"{self.path}: case: must be a text of at most {MOST_BYTES >> 20} MiB")
        return data.values

    def rows(self) -> tuple[Series, RawSeries | None]:
        """The series, and the increments where there are such: the first format holds these in place of the series."""
        columns: dict[str, Any] = self.columns("series")
        errors, raw = self.errors("errors"), None
        a0, S0 = self.at_first_touch("a0_m"), self.at_first_touch("S0_N_per_m")
        other = self.coarser(a0 or 0.0) if TOUCHES not in self.root.members else None
        if "increments" in self.root.members:
            rows = self.numbers("increments", "row", 1)
            known = ELEMENT in self.group("increments").members
            element = self.numbers("increments", ELEMENT, 1) if known else None
            raw = RawSeries(**self.columns("increments"), rows=rows.astype(int), element=element)
        elif not is_series(RawSeries(columns["a"], columns["delta"], columns["P"])):
            raw = RawSeries(columns["a"], columns["delta"], columns["P"])
            keep = first_of_plateaus(raw.a)
            if not keep.any():
                raise InputError(f"{self.path}: series: no increment is in contact (all a <= 0)")
            columns, errors = {name: values[keep] for name, values in columns.items()}, {}
        try:
            return Series(**columns, errors=errors, a0=a0 or 0.0, S0=S0, coarser=other), raw
        except InputError as error:
            raise InputError(f"{self.path}: {error}") from None

    def touches(self, series: Series) -> Series | None:
        """The series at the moments at which increments reach nodes; files of earlier releases have none."""
        if TOUCHES not in self.root.members:
            return None
        columns: dict[str, Any] = self.columns(TOUCHES)
        errors, a0 = self.errors(f"{TOUCHES}_errors"), series.a0
        try:
            return Series(**columns, errors=errors, a0=a0, S0=series.S0, coarser=self.coarser(a0))
        except InputError as error:
            raise InputError(f"{self.path}: {TOUCHES}: {error}") from None

    def coarser(self, a0: float, groups: Sequence[str] = COARSER) -> CoarseSeries | None:
        """The series by larger elements, where there is one; with those by still larger ones, in later ``groups``."""
        if not groups or groups[0] not in self.root.members:
            return None
        name, *larger = groups
        columns: dict[str, Any] = self.columns(name)
        ratio = _real(self.group(name).attributes.get("ratio"))
        if not 1 < ratio < math.inf:
            raise InputError(f"{name}: attribute ratio must be > 1, got {ratio:g}")
        return CoarseSeries(Series(**columns, a0=a0, coarser=self.coarser(a0, larger)), ratio)

    @property
    def widening(self) -> float:
        """The half-widths of errors that are made of those in the file, which states their level, over these."""
        level = _real(self.group("errors").attributes.get("level", EARLIER_LEVEL))
        if not 0 < level < 1:
            raise InputError(f"{self.path}: errors: attribute level must be between 0 and 1, got {level:g}")
        return HALF_WIDTH / half_width(level)

    def errors(self, group: str) -> dict[str, Array]:
        """The errors of columns in a ``group``."""
        return {name: self.widening * values for name, values in self.columns(group, ()).items()}

    def budget(self) -> ErrorBudget:
        attributes, parts = self.group("errors").attributes, list[Estimate]()
        for item in fields(ErrorBudget):
            value = attributes.get(item.name)
            if value is None or isinstance(value, str):
                parts.append(Unknown(value or "not stated in the file"))
            else:
                number = _real(value)
                parts.append(
                    number * self.widening if np.isfinite(number) else Unknown(f"stated as {number} in the file")
                )
        return ErrorBudget(*parts)

    def pressure(self) -> PressureTable | None:
        if "contact" not in self.root.members:
            return None
        r = self.numbers("contact", "r", 1)
        return PressureTable(r, self.numbers("contact", "pressure", 2, r.size))

    def kernel(self) -> KeptKernel | None:
        """The kernel that the solution was found with; files of earlier releases and other methods have none."""
        if "kernel" not in self.root.members:
            return None
        attributes, radii = self.group("kernel").attributes, self.numbers("kernel", "radii", 1)
        numbers = {name: _real(attributes.get(name)) for name in ("reach_m", "scale_m", "of_side", "accuracy", "least")}
        for name, value in numbers.items():
            if not (np.isfinite(value) and (value > 0 or (value == 0 and name in ("of_side", "least")))):
                raise InputError(f"{self.path}: kernel: attribute {name} must be finite and > 0, got {value:g}")
        reach, scale, of_side, accuracy, least = numbers.values()
        size = self.dataset("kernel", "coefficients").shape[-1:]
        coefficients = self.numbers("kernel", "coefficients", 2, *size)
        weights = self.numbers("kernel", "weights", 2, 4)
        errors = self.numbers("kernel", "errors", 2, radii.size)
        count, rows = coefficients.shape[1], (1 + len(weights)) * coefficients.shape[1]
        if coefficients.shape[0] != rows or len(errors) != 12 or np.any(np.diff(radii) <= 0):
            raise InputError(
                f"{self.path}: kernel: must have coefficients of the kernel and {len(weights)} companions, and 12 rows "
                "of errors at increasing radii"
            )
        kernels = coefficients.reshape(-1, count, count)
        return KeptKernel(
            kernels, reach, scale, bool(of_side), weights, accuracy, least, radii, errors.reshape(3, 4, -1)
        )

    def words(self, name: str) -> dict[str, Any]:
        """The numbers and texts of a group; the first format may lack it."""
        if not self.sealed and name not in self.root.members:
            return {}
        words: dict[str, Any] = {}
        for key, value in self.group(name).attributes.items():
            if key == hdf5.SEAL:
                continue
            if not isinstance(value, str | int | float):
                kind = type(value).__name__
                raise InputError(f"{self.path}: attribute {name}.{key} must be a number or a text, got {kind}")
            words[key] = str(value) if isinstance(value, float) and not np.isfinite(value) else value
        return words

    def group(self, name: str) -> hdf5.Group:
        group = self.root.members.get(name)
        if not isinstance(group, hdf5.Group):
            raise InputError(f'{self.path}: group "{name}" is missing')
        return group

    def dataset(self, group: str, name: str) -> hdf5.Dataset:
        dataset = (self.group(group) if group else self.root).members.get(name)
        if not isinstance(dataset, hdf5.Dataset):
            raise InputError(f'{self.path}: dataset "{group}/{name}" is missing'.replace('"/', '"'))
        return dataset

    def columns(self, group: str, required: Sequence[str] = ("a", "delta", "P")) -> dict[str, Array]:
        """The columns of the series in a ``group``, all of one length."""
        there = self.group(group).members
        wanted = [key for key in COLUMNS if key in required or COLUMNS[key].name in there]
        columns = {key: self.column(group, *COLUMNS[key][:2]) for key in wanted}
        sizes = {name: values.size for name, values in columns.items()}
        if len(set(sizes.values())) > 1:
            raise InputError(f"{self.path}: {group}: all columns must have the same length, got {sizes}")
        return columns

    def column(self, group: str, name: str, unit: str) -> Array:
        values = self.numbers(group, name, 1)
        if (found := str(self.dataset(group, name).attributes.get("unit", ""))) != unit:
            raise InputError(f'{self.path}: {group}/{name}: unit must be "{unit}", got "{found}"')
        return values

    def numbers(self, group: str, name: str, ndim: int, width: int = 1) -> Array:
        """A column of finite numbers, or with ``ndim`` = 2 a table of them, ``width`` to a row."""
        data, where = self.dataset(group, name), f"{self.path}: {group}/{name}"
        if len(data.shape) != ndim or data.dtype.kind not in "fiu" or (ndim == 2 and data.shape[1] != width):
            kind = "a column of numbers" if ndim == 1 else f"rows of {width} numbers"
            raise InputError(f"{where}: must be {kind}, got {data.dtype} of shape {data.shape}")
        most = process.ROWS if ndim == 1 else MOST_CELLS // width
        if not 1 <= data.shape[0] <= most:
            raise InputError(f"{where}: must have 1 to {most} rows, got {data.shape[0]}")
        values = np.asarray(data.values, dtype=float)
        wrong = ~(np.abs(values) <= LARGEST_SI**2)
        if wrong.any():
            row, value = np.argwhere(wrong)[0][0], values[wrong][0]
            rule = f"number up to {LARGEST_SI**2:g}" if np.isfinite(value) else "finite number"
            raise InputError(f"{where}: row {row + 1} must be a {rule}, got {value}")
        return values

    def at_first_touch(self, name: str) -> float | None:
        """An attribute of the series: a finite number >= 0."""
        attribute = self.group("series").attributes.get(name)
        if attribute is None:
            return None
        value = _real(attribute)
        if not (np.isfinite(value) and value >= 0):
            raise InputError(f"{self.path}: series: attribute {name} must be finite and >= 0, got {value}")
        return value


def _real(value: Any) -> float:
    """A real number; TypeError, which is damage, for anything else."""
    if not isinstance(value, int | float):
        raise TypeError(f"{type(value).__name__} in place of a number")
    return float(value)


# --------------------------------------------------------------------------------------------------
# A validated case, or a problem made in Python, to a solution, by the method that it names or needs.

Announce = Callable[[str], None]


@one_thread()
def solve(
    source: Case | Problem,
    method: str | Method | None = None,
    limits: Limits | None = None,
    announce: Announce | None = None,
) -> tuple[Choice, Solution]:
    """Solve by ``method`` (None: the case's own, "auto" for a problem); under "auto" the next one where one fails.

    Refusal where it would cost more than ``limits``; ``announce`` gets the forecast of its cost where that is much.
    """

    def build(name: str) -> Method:
        return method_class(name)() if isinstance(source, Problem) else method_of(source.model, name)

    if isinstance(source, Problem):
        problem, record, named = source, Record(), "auto"
    else:
        record, problem, named = record_of(source), source.model.problem(), source.model.method
    if announce and (words := long_look(problem)):
        announce(words)
    choice: Choice | None = choose_method(problem, method or named, build)
    while True:
        assert choice is not None
        cost = check_cost(f"method {choice.name}", choice.forecast(problem), limits or Limits())
        if cost and announce:
            announce(cost)
        try:
            return choice, replace(choice.method(problem), record=record)
        except JkrError as error:
            choice = choice.after_failure(error, build)
            if choice is None:
                raise
