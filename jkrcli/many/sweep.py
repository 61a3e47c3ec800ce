"""A sweep carried out: what it will cost, the cases solved and journaled as they come, the table at the end."""

import contextlib
import hashlib
import importlib.util
import io
import json
import math
import os
import re
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np

from .. import __version__
from ..adhesion.validity import strain_words
from ..base import process
from ..base.errors import InputError, JkrError, Unknown, counted, printable
from ..base.executors import Progress, completed, executor, silent
from ..base.files import atomic, check_target, make_folder, remove_file, together, write_csv
from ..base.hdf5 import Dataset, Group
from ..base.numerics import Array
from ..base.process import SILENCE, duration
from ..base.registry import Result
from ..base.units import scale, show
from ..report import archive
from ..report import plots as looks
from ..report.plots import Figure
from ..report.result import Files
from . import figures
from .sweep_plan import FAILED, OK, STRAINS, Cases, Plan, Row, at_unit_modulus, cheapest_method, failed, solve_group

# --------------------------------------------------------------------------------------------------
# The figure of a sweep: its results over the axis with the most values, a line for each value of the next.

PULL_OFF = re.compile(r"pull_off\.(load|displacement)\.(P|delta|a)")
RATIO_WORDS = {
    "pull_off.load.over_pi_w_R": r"pull-off force / $\pi w R$", "ratios.h_over_R": "$h/R$",
    "ratios.a_over_h_at_pull_off": "$a/h$ at pull-off", "ratios.w_R2_over_Estar_h3": r"$w R^2 / (E^* h^3)$",
}  # fmt: skip
MARKS = "os^Dvx"  # of lines in this order: one that covers another shows it
DIMENSIONS = {"_N": "load", "_J_per_m2": "work", "_Pa": "modulus", "_m": "length"}


def sweep_figure(plan: Plan, table: Mapping[str, Sequence[Any]]) -> Figure | None:
    """Forces where there are some, over a quantity of a layer those in pi w R, else the first results, at most two of
    them; other axes at their first value, which the title says. None where no axis or no result is a number."""
    numbers = {name: np.array(values, dtype=float) for name, values in table.items()
               if all(value is None or isinstance(value, int | float) for value in values)}  # fmt: skip
    # The first column of each axis that holds several numbers
    axes, columns = [], iter(plan.key_columns)
    for axis in plan.axes:
        names = [next(columns) for _ in axis.keys]
        axes += [name for name in names if name in numbers and np.unique(numbers[name]).size > 1][:1]
    axes.sort(key=lambda name: -np.unique(numbers[name]).size)
    if not axes or (plan.over and plan.over not in numbers):
        return None
    x, *others = axes
    x = plan.over or x
    first = {name: numbers[name][0] for name in others[1:]}
    rows = np.logical_and.reduce([np.isfinite(numbers[x]), *(numbers[name] == at for name, at in first.items())])
    shown = {name: values[rows] for name, values in numbers.items() if np.isfinite(values[rows]).any()}
    results = [name for name in plan.recipe.wanted.columns if name in shown and "err" not in name]
    results = [name for name in results if name not in (plan.over, STRAINS)] or results
    forces = (".over_pi_w_R", ".P_N") if plan.over else (".P_N", ".over_pi_w_R")
    chosen = ([name for name in results if name.endswith(force)] for force in forces)
    results = (next(filter(None, chosen), None) or results)[:2]
    if not results:
        return None
    joint = any(x in plan.key_columns and len(axis.keys) > 1 for axis in plan.axes)
    panels = [_panel(shown, x, others[:1], name, "" if joint else "-") for name in results]
    return figures.panels_figure(panels, ", ".join(_value(name, at) for name, at in first.items()))


def _panel(columns: Mapping[str, Array], x: str, beside: list[str], y: str, style: str) -> figures.Panel:
    (along, x_label), (up, y_label) = (_scaled(columns, name) for name in (x, y))
    groups = np.unique(columns[beside[0]])[: len(looks.COLORS)] if beside else [None]
    lines = []
    for at, color, mark in zip(groups, looks.COLORS, MARKS, strict=False):
        rows = np.flatnonzero(columns[beside[0]] == at) if beside else np.arange(along.size)
        rows = rows[np.argsort(along[rows], kind="stable")]
        lines.append(figures.Line(along[rows], up[rows], _value(beside[0], at) if beside else "", mark + style, color))
    wide = 0 < 5 * along.min() < along.max()
    title = f"{match[1]} control" if (match := PULL_OFF.match(y)) else ""
    written = all(float(f"{value:.2g}") == float(f"{value:.9g}") for value in np.unique(along))  # 0.3, 2, 50
    return figures.Panel(x_label, y_label, lines, title, logs="x" if wide else "", at_points=written)


def _scaled(columns: Mapping[str, Array], column: str) -> tuple[Array, str]:
    """A column in the unit that people would use, and the label of its axis."""
    stem, dimension = _split(column)
    factor, unit = scale(float(np.nanmax(np.abs(columns[column]))), dimension)
    return columns[column] / factor, f"{_words(stem)} ({looks.pretty(unit)})" if unit else _words(stem)


def _words(stem: str) -> str:
    """What a result or a key is called on an axis: "pull_off.load.P" the load at pull-off; others as they are."""
    if stem in RATIO_WORDS:
        return RATIO_WORDS[stem]
    if match := PULL_OFF.fullmatch(stem):
        return f"{looks.LABELS[match[2]]} at pull-off"
    if match := re.fullmatch(r"specimen\.layers\[(\d+)\]\.(\w+)", stem):
        return f"{match[2]} of layer {int(match[1]) + 1}"
    return stem


def _value(column: str, value: float) -> str:
    stem, dimension = _split(column)
    return f"{stem.rpartition('.')[2]} = {looks.pretty(show(value, dimension))}"


def _split(column: str) -> tuple[str, str]:
    """A column's name without its unit, and its dimension."""
    ending = next((ending for ending in DIMENSIONS if column.endswith(ending)), "")
    return column.removesuffix(ending), DIMENSIONS.get(ending, "number")


# --------------------------------------------------------------------------------------------------
# The journal of a sweep: a line per finished case, appended as results come in and readable after any end.

FORMAT, VERSION = "jkr-sweep-journal", 2  # type and version of the file
HEAD = json.dumps({"format": FORMAT, "version": VERSION, "jkr": __version__}).encode() + b"\n"
ENTRY = [str, str, str, list, float]  # of a line: identity, status, reason, values, CPU seconds; then their digest
MOST_BYTES = 1 << 31  # theory: of all lines, which are read at once: MOST_CELLS numbers of 21 characters


class Journal:
    """Finished cases by their identity (a hash of all that a row depends on), in memory and in the file behind it.

    ``damaged``: numbers of the lines that do not hold what was written; their cases count as not done.
    """

    def __init__(self, path: Path, file: io.FileIO):
        self.path = path
        self.rows: dict[str, Row] = {}
        self.damaged: list[int] = []
        self._file = file
        self._synced = time.monotonic()

    def append(self, identity: str, row: Row) -> None:
        """Keep a finished case; a repeated identity replaces the earlier row."""
        entry = [identity, row.status, row.reason, row.values, round(row.seconds, 6)]
        self._write(_sealed(json.dumps(entry, allow_nan=False).encode()) + b"\n")
        self.rows[identity] = row
        if time.monotonic() - self._synced > 5.0:  # that a power failure may cost; a killed process loses nothing
            self.sync()

    def _write(self, line: bytes) -> None:
        """Append to the file as far as there is room; what is cut off then, the next run takes away."""
        try:
            while line:
                line = line[self._file.write(line) :]
        except OSError as error:
            raise JkrError(f"{self.path}: cannot be written ({error.strerror})") from None

    def sync(self) -> None:
        """Make sure that the file is on the disk."""
        try:
            os.fsync(self._file.fileno())
        except OSError as error:
            raise JkrError(f"{self.path}: cannot be written ({error.strerror})") from None
        self._synced = time.monotonic()

    def forget_failed(self) -> int:
        """Count failed cases as not done; returns how many."""
        wrong = [identity for identity, row in self.rows.items() if row.status == FAILED]
        for identity in wrong:
            del self.rows[identity]
        return len(wrong)

    def read(self) -> None:
        """Take in what earlier runs appended; a last line without its end was being written when they were killed."""
        content = self._file.read()
        if HEAD.startswith(content):
            self._file.seek(0)
            self._write(HEAD)
            return
        whole = content.rfind(b"\n") + 1
        head, *lines = content[:whole].splitlines() or [b""]
        named = _parsed(head)
        if not isinstance(named, dict) or named.get("format") != FORMAT or named.get("version") != VERSION:
            raise InputError(
                f"{self.path}: is no journal of a sweep (line 1 must name the format {FORMAT}, version {VERSION}); "
                "give another folder"
            )
        self._file.truncate(whole)
        self._file.seek(whole)
        for number, line in enumerate(lines, start=2):
            written = line.rpartition(b", ")[0] + b"]"
            entry = _parsed(written) if _sealed(written) == line else None
            is_sound = isinstance(entry, list) and list(map(type, entry)) == ENTRY and entry[1] in (OK, FAILED)
            if entry is None or not is_sound:
                self.damaged.append(number)
                continue
            identity, status, reason, values, seconds = entry
            self.rows[identity] = Row(-1, status, reason, tuple(values), seconds)


def _sealed(entry: bytes) -> bytes:
    """A list in JSON with the digest of its text as its last item."""
    return entry[:-1] + b', "' + hashlib.sha256(entry).hexdigest()[:16].encode() + b'"]'


def _parsed(line: bytes) -> Any:
    try:
        return json.loads(line)
    except (ValueError, RecursionError):
        return None


@contextlib.contextmanager
def opened(path: Path) -> Iterator[Journal]:
    """The journal at ``path``, made where there is none; InputError where another process is writing it, or it is none
    that can be read."""
    if path.exists() and not path.is_file():
        raise InputError(f"{path}: is a folder, a device or a pipe, not a journal; give another folder")
    try:
        file = path.open("r+b" if path.exists() else "w+b", buffering=0)
    except OSError as error:
        raise JkrError(f"{path}: cannot be opened ({error.strerror})") from None
    with file:
        if process.taken(file) is False:
            raise InputError(f"{path}: another jkr sweep is writing there; wait for it, or give another folder")
        if os.fstat(file.fileno()).st_size > MOST_BYTES:
            raise InputError(f"{path}: journal is larger than {MOST_BYTES >> 20} MiB; give another folder")
        journal = Journal(path, file)
        journal.read()
        try:
            yield journal
        finally:
            journal.sync()


# --------------------------------------------------------------------------------------------------
# A sweep, and one case of it, as results; its table, a row per case, as CSV, HDF5 and, with pyarrow, Parquet.

STEM = "table"
MISSING = "NaN: there is no value; the column reason says why"
Columns: TypeAlias = dict[str, list[Any]]  # of one length; None where there is no value


@dataclass(frozen=True, eq=False)
class Swept(Result):
    """All cases of a ``plan`` in a table of ``columns``, a row each, and the ``files`` that hold it."""

    plan: Plan
    columns: Columns
    files: Sequence[Path] = ()

    @property
    def failed(self) -> list[tuple[int, str]]:
        """Numbers and reasons of the cases without a result."""
        rows = zip(*(self.columns[name] for name in ("case", "status", "reason")), strict=True)
        return [(number, reason) for number, status, reason in rows if status == FAILED]

    @property
    def strained(self) -> tuple[int, int]:
        """How many cases have a pull-off force that large strains change, and how many one of which that is unknown."""
        changes, words = self.columns.get(STRAINS, ()), strain_words(Unknown(""))
        unknown = [change is None and words in reason
                   for change, reason in zip(changes, self.columns["reason"], strict=False)]  # fmt: skip
        return sum(change is not None and change > 0 for change in changes), sum(unknown)

    @property
    def warnings(self) -> list[str]:
        failed = self.failed
        return [f"{counted(len(failed), 'case')} failed, the first because: {failed[0][1]}"] if failed else []

    def summary(self) -> dict[str, Any]:
        return {
            "format": "jkr-sweep-summary",
            "cases": self.plan.count,
            FAILED: len(self.failed),
            "large_strains": sum(self.strained),
            "columns": list(self.columns),
            "files": [str(path) for path in self.files],
        }

    def words(self) -> list[str]:
        plan, failed, (strained, unknown) = self.plan, self.failed, self.strained
        doubts = [
            *([f"; large strains change the pull-off force in {strained:,} ({STRAINS})"] if strained else []),
            *([f"; how large strains change the pull-off force is unknown in {unknown:,}"] if unknown else []),
        ]
        return [
            f"{counted(plan.count, 'case')}{f', {len(failed):,} of them failed' if failed else ''}"
            f"{''.join(doubts)}: {plan.title or plan.source}",
            f"  one case  {plan.command(failed[0][0] if failed else 0)}",
        ]

    def figure(self) -> Figure:

        if (figure := sweep_figure(self.plan, self.columns)) is None:
            raise InputError(f"{self.plan.source}: no axis or no result is a number: there is nothing to draw")
        return figure


@dataclass(frozen=True, eq=False)
class SweptCase(Result):
    """The ``row`` of one case of a ``plan``."""

    plan: Plan
    row: Row

    def summary(self) -> dict[str, Any]:
        row, plan = self.row, self.plan
        inputs = dict(zip(plan.key_columns, plan.values(row.number).values(), strict=True))
        outputs = dict(zip(plan.recipe.wanted.columns, row.values, strict=True))
        return {"case": row.number, "status": row.status, "reason": row.reason, **inputs, **outputs}

    def words(self) -> list[str]:
        cells = self.summary().items()
        return [printable(f"{name:<40} {'' if value is None else value}".rstrip()) for name, value in cells]


def table(plan: Plan, journal: Journal) -> Columns:
    """The finished cases of a plan in the order of their numbers."""
    names = ("case", "status", "reason", *plan.key_columns, *plan.recipe.wanted.columns)
    columns: Columns = {name: [] for name in names}
    for number in range(plan.count):
        row = journal.rows.get(plan.identity(number))
        if row is not None:
            inputs = [  # tables and lists as JSON
                json.dumps(value) if isinstance(value, dict | list | tuple) else value
                for value in plan.values(number).values()
            ]
            cells = (number, row.status, row.reason, *inputs, *row.values)
            for column, cell in zip(columns.values(), cells, strict=True):
                column.append(cell)
    return columns


def endings() -> tuple[str, ...]:
    """The kinds of files that can be written here."""
    return (".csv", ".h5", ".parquet") if importlib.util.find_spec("pyarrow") else (".csv", ".h5")


def write(folder: Path, columns: Columns) -> list[Path]:
    """Write the table in every form, each whole or not at all; returns the files."""
    paths = [folder / f"{STEM}{ending}" for ending in endings()]
    for path in paths:
        if path.suffix == ".csv":
            write_csv(path, columns)
        elif path.suffix == ".h5":
            datasets = {name: Dataset(_as_dataset(values, name == "case")) for name, values in columns.items()}
            archive.write(path, archive.SWEEP_TABLE, {"missing": MISSING}, {"table": Group({}, datasets)})
        else:
            import pyarrow
            from pyarrow import parquet

            arrays = [_arrow(values, name == "case") for name, values in columns.items()]
            metadata = {"format": archive.SWEEP_TABLE, "jkr": __version__}
            rows = pyarrow.Table.from_arrays(arrays, names=list(columns), metadata=metadata)
            with atomic(path) as temporary:
                parquet.write_table(rows, temporary)
    return paths


def _as_dataset(values: list[Any], whole: bool) -> Array | list[str]:
    """A column of whole numbers, numbers or words: NaN or an empty text where there is no value."""
    if whole or all(
        value is None or (isinstance(value, int | float) and not isinstance(value, bool)) for value in values
    ):
        return np.array(values, dtype=np.int64 if whole else np.float64)
    return ["" if value is None else str(value) for value in values]


def _arrow(values: list[Any], whole: bool) -> Any:
    """A column of whole numbers, numbers or words, null where there is no value.

    From buffers: pyarrow's other constructors import pandas, which costs more than everything else here.
    """
    import pyarrow

    valid = pyarrow.py_buffer(np.packbits([value is not None for value in values], bitorder="little"))
    column = _as_dataset(values, whole)
    if isinstance(column, np.ndarray):
        kind = pyarrow.int64() if whole else pyarrow.float64()
        return pyarrow.Array.from_buffers(kind, len(values), [valid, pyarrow.py_buffer(column)])
    encoded = [word.encode() for word in column]
    ends = np.concatenate([[0], np.cumsum([len(word) for word in encoded])]).astype(np.int64)
    buffers = [valid, pyarrow.py_buffer(ends), pyarrow.py_buffer(b"".join(encoded))]
    return pyarrow.Array.from_buffers(pyarrow.large_string(), len(values), buffers)


JOURNAL, FAILED_TABLE, SOLVES = "journal.jsonl", "failed.csv", "solves"
Say = Callable[[str], None]

# What a sweep is expected to cost, and in what portions it is handed out.
SWEEP_PER_CASE = 0.012  # CPU seconds of a case besides its solve; tuned on the shipped sweeps, by `make sweep`
SWEEP_PER_CELL = 5e-6  # and per column of its row; tuned on 1,000 radii, by `make guards`
SWEEP_PER_COLUMN = 6e-4  # CPU seconds of each in the files; tuned on 1,000 radii, by `make guards`
SWEEP_LOOK = 0.0004  # CPU seconds to look at a case; tuned on the shipped sweeps, by `make sweep`
SWEEP_LOOKED_AT = 12  # choice: groups whose forecasts stand for all
SWEEP_SHARES = 8  # choice: tasks per worker at least, so that the last ones end together


@dataclass(frozen=True)
class Means:
    """The means by which a sweep is carried out: local ``workers`` (None: as many as serve) or a Dask ``scheduler``;
    ``hours``: core hours beyond which nothing is begun; ``retry``: failed cases of earlier runs are tried again;
    ``progress``: how it is shown."""

    workers: int | None = None
    scheduler: str | None = None
    hours: float = 10.0
    retry: bool = False
    progress: Progress = silent


def sweep(plan: Plan, folder: Path, means: Means, force: bool, say: Say, pictures: Files | None = None) -> Swept:
    """Carry out ``plan`` with the results in ``folder``; a sweep that was interrupted there goes on.

    ``say`` reports what goes on in the meantime; ``pictures``: of the table, if any. Errors: InputError where more than
    ``means.hours`` are forecast or the folder holds what is not ours, JkrError where every case failed.
    """
    make_folder(folder)
    for name in (*(f"{STEM}{ending}" for ending in endings()), FAILED_TABLE):
        check_target(folder / name, force)
    look = SWEEP_LOOK * plan.count
    if look > SILENCE:
        all_cases = counted(plan.count, "case")
        say(f"{all_cases}: checking them takes about {duration(look)} of CPU time before the first is solved")
    with opened(folder / JOURNAL) as journal:
        # Say which lines are not believed, a few of them by number.
        if journal.damaged:
            lines = ", ".join(map(str, journal.damaged[:5])) + (", ..." if len(journal.damaged) > 5 else "")
            say(f"{journal.path}: {len(journal.damaged):,} damaged lines ({lines}): their cases are solved again")
        if means.retry and (forgotten := journal.forget_failed()):
            say(f"{forgotten} failed cases are tried again")
        if look > SILENCE:
            # What all cases cost at most and at least, told from the first before the others are looked at; the
            # journal's rows count as done, whether or not they are of this plan. What is sure comes after the look.
            first, _ = plan.groups([0])
            each = _solve_seconds(plan, first[0]) if first else 0.0
            left = max(0.0, 1 - len(journal.rows) / plan.count)
            most, least = (
                left * (_beside(plan, plan.count) + count * each) for count in (plan.count, plan.least_solves)
            )
            say(f"all cases: at most about {duration(most)} of CPU time, if each is solved separately like the first")
            so_many = f"{counted(plan.count, 'case')} with at least {counted(plan.least_solves, 'solve')}"
            _guard(so_many, least, means.hours, ", as the first case does")
        groups = _left(plan, journal, say)
        seconds = forecast(plan, groups)
        _guard(f"{counted(sum(map(len, groups)), 'case')} with {counted(len(groups), 'solve')}", seconds, means.hours)
        if groups:
            _solve(plan, groups, seconds, folder, journal, means, say)
        swept = Swept(plan, table(plan, journal))
    with together():
        # A table of the failed cases with the command that runs each alone; none where none failed
        path = folder / FAILED_TABLE
        if not swept.failed:
            remove_file(path)
            write_failed = []
        else:
            numbers, reasons = zip(*swept.failed, strict=True)
            write_csv(path, {"case": numbers, "reason": reasons, "command": list(map(swept.plan.command, numbers))})
            write_failed = [path]
        paths = [*write(folder, swept.columns), *write_failed]
    if pictures is not None and pictures.endings and len(swept.failed) < plan.count:
        figure = sweep_figure(plan, swept.columns)
        pictures.write(figure=figure)
        paths += [pictures[ending] for ending in pictures.endings if figure is not None]
    if len(swept.failed) == plan.count:
        raise JkrError(f"{plan.source}: every case failed, the first because: {swept.failed[0][1]}")
    return replace(swept, files=paths)


def _left(plan: Plan, journal: Journal, say: Say) -> list[Cases]:
    """The cases that the journal does not hold, equal ones once, by shared solves; what makes no case is journaled as
    failed at once."""
    new: dict[str, int] = {}
    width = len(plan.recipe.wanted.columns)
    for number in range(plan.count):
        identity = plan.identity(number)
        row = journal.rows.get(identity)
        if row is None or len(row.values) != width:
            journal.rows.pop(identity, None)
            new.setdefault(identity, number)
    if done := plan.count - len(new):
        say(f"{done:,} of {counted(plan.count, 'case')} are there from an earlier run")
    groups, wrong = plan.groups(new.values())
    for number, reason in wrong:
        journal.append(plan.identity(number), failed(plan.recipe, number, reason))
    if groups:
        say(f"{counted(sum(map(len, groups)), 'case')} to compute by {counted(len(groups), 'solve')}")
    return groups


def forecast(plan: Plan, groups: Sequence[Cases]) -> float:
    """CPU seconds that the groups will take, from the methods' own forecasts for some of them."""
    some = groups[:: max(1, len(groups) // SWEEP_LOOKED_AT)]
    seconds = [_solve_seconds(plan, group) for group in some]
    return _beside(plan, sum(map(len, groups))) + len(groups) * sum(seconds) / max(len(seconds), 1)


def _beside(plan: Plan, cases: int) -> float:
    """CPU seconds of ``cases`` besides their solves."""
    columns = len(plan.recipe.wanted.columns)
    return SWEEP_PER_COLUMN * columns + (SWEEP_PER_CASE + SWEEP_PER_CELL * columns) * cases


def _solve_seconds(plan: Plan, group: Cases) -> float:
    """Forecast of the solve of a group; 0 where it is refused at once."""
    model = plan.recipe.model(group[0][1])
    body, _ = at_unit_modulus(model.problem())
    try:
        return cheapest_method(body, model).method.forecast(body).seconds
    except JkrError:
        return 0.0


def _guard(what: str, seconds: float, hours: float, likewise: str = "") -> None:
    """Refuse to begin what takes more than so many core ``hours`` by its forecast."""
    if seconds > 3600 * hours:
        raise InputError(
            f"--hours: {what} would take about {seconds / 3600:.3g} core hours{likewise}, more than the limit of "
            f"{hours:g}; raise it with --hours {math.ceil(1.5 * seconds / 3600)}, or use fewer cases, fewer points "
            "or a cheaper method"
        )


def _solve(
    plan: Plan, groups: list[Cases], seconds: float, folder: Path, journal: Journal, means: Means, say: Say
) -> None:
    """Hand out the groups, which take about so many CPU ``seconds``, and journal their cases as they come in."""
    solves = folder.resolve() / SOLVES
    make_folder(solves)
    with executor(means.workers, means.scheduler, means.progress, seconds) as pool:
        if pool.dashboard:
            say(f"dashboard {pool.dashboard}")
        by_time = SILENCE * len(groups) / max(seconds, 1e-9)  # much more than handing out, and the next is seen soon
        chunk = max(1, min(round(by_time), math.ceil(len(groups) / (SWEEP_SHARES * pool.workers))))
        try:
            function = partial(solve_group, plan.recipe, solves)
            for index, rows in completed(pool, function, groups, plan.title or "sweep", chunk):
                if isinstance(rows, Exception):
                    rows = [failed(plan.recipe, number, str(rows)) for number, _ in groups[index]]
                for row in rows:
                    journal.append(plan.identity(row.number), row)
        except KeyboardInterrupt:
            kept = f"{counted(len(journal.rows), 'case')} {'is' if len(journal.rows) == 1 else 'are'} kept"
            say(f"{kept}; the same command goes on from there")
            raise


def alone(plan: Plan, number: int) -> SweptCase:
    """One case, solved here and now; nothing is read or written."""
    groups, wrong = plan.groups([number])
    row = failed(plan.recipe, number, wrong[0][1]) if wrong else solve_group(plan.recipe, None, groups[0])[0]
    return SweptCase(plan, row)
