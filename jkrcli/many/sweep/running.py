"""A sweep carried out: what it will cost, the cases solved and journaled as they come, the table at the end."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from ...base import (
    InputError,
    JkrError,
    Progress,
    check_target,
    completed,
    duration,
    executor,
    make_folder,
    remove,
    silent,
    together,
    write_csv,
)
from ..cache import at_unit_modulus
from .journal import Journal, opened
from .plan import Group, Plan
from .result import Swept, SweptCase
from .solving import Row, failed, least, solve_group
from .table import STEM, SweepTable, endings, write

JOURNAL, FAILED_TABLE, SOLVES = "journal.jsonl", "failed.csv", "solves"
Say = Callable[[str], None]


@dataclass(frozen=True)
class SweepTuning:
    """What a sweep is expected to cost, and in what portions it is handed out."""

    per_case: float = 0.012  # CPU seconds of a case besides its solve; tuned on the shipped sweeps, by `make sweep`
    per_cell: float = 5e-6  # and per column of its row; tuned on 1,000 radii, by `make guards`
    per_column: float = 6e-4  # CPU seconds of each in the files; tuned on 1,000 radii, by `make guards`
    look: float = 0.0004  # CPU seconds to look at a case; tuned on the shipped sweeps, by `make sweep`
    many: int = 2000  # choice: cases beyond which the look is announced: about a second
    looked_at: int = 12  # choice: groups whose forecasts stand for all
    task: float = 2.0  # choice: CPU seconds of one task: much more than handing it out, little to lose
    shares: int = 8  # choice: tasks per worker at least, so that the last ones end together


TUNING = SweepTuning()


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


@dataclass(frozen=True)
class Work:
    """What is left to do: ``groups`` that share a solve, and its forecast in CPU ``seconds``."""

    groups: list[Group]
    seconds: float

    @property
    def cases(self) -> int:
        return sum(len(group.cases) for group in self.groups)

    def chunk(self, workers: int) -> int:
        """The number of groups that make one task."""
        by_time = TUNING.task * len(self.groups) / max(self.seconds, 1e-9)
        return max(1, min(round(by_time), math.ceil(len(self.groups) / (TUNING.shares * workers))))


def sweep(plan: Plan, folder: Path, means: Means, force: bool, say: Say) -> Swept:
    """Carry out ``plan`` with the results in ``folder``; a sweep that was interrupted there goes on.

    ``say`` reports what goes on in the meantime. Errors: InputError where more than ``means.hours`` are forecast or
    the folder holds what is not ours, JkrError where every case failed.
    """
    make_folder(folder)
    _check_targets(folder, force)
    if plan.count > TUNING.many:
        say(
            f"{plan.count:,} cases: looking through them takes about {duration(TUNING.look * plan.count)} of CPU time "
            "before the first is solved"
        )
    with opened(folder / JOURNAL) as journal:
        _say_damage(journal, say)
        if means.retry and (forgotten := journal.forget_failed()):
            say(f"{forgotten} failed cases are tried again")
        if plan.count > TUNING.many:
            _guard_early(plan, journal, means.hours, say)
        work = _left(plan, journal, say)
        _guard(f"{work.cases:,} cases with {len(work.groups):,} solves", work.seconds, means.hours)
        if work.groups:
            _solve(plan, work, folder, journal, means, say)
        table = SweepTable.of(plan, journal)
    with together():
        paths = [*write(folder, table), *_write_failed(plan, folder, table)]
    if len(table.failed) == plan.count:
        raise JkrError(f"{plan.source}: every case failed, the first because: {table.failed[0][1]}")
    return Swept(plan, table, paths)


def _guard_early(plan: Plan, journal: Journal, hours: float, say: Say) -> None:
    """Announce at most, and refuse at least, what all cases cost, told from the first before the others are looked at.

    The journal's rows count as done, whether or not they are of this plan; what is sure comes after the look.
    """
    groups, _ = plan.groups([0])
    solve = _solve_seconds(plan, groups[0]) if groups else 0.0
    left = max(0.0, 1 - len(journal.rows) / plan.count)
    most, least = (left * (_beside(plan, plan.count) + count * solve) for count in (plan.count, plan.least_solves))
    say(f"all cases: at most about {duration(most)} of CPU time, were each solved on its own as the first")
    _guard(f"{plan.count:,} cases with at least {plan.least_solves:,} solves", least, hours, ", as the first case does")


def _check_targets(folder: Path, force: bool) -> None:
    for name in (*(f"{STEM}{ending}" for ending in endings()), FAILED_TABLE):
        check_target(folder / name, force)


def _say_damage(journal: Journal, say: Say) -> None:
    """Say which lines are not believed, a few of them by number."""
    if journal.damaged:
        lines = ", ".join(map(str, journal.damaged[:5])) + (", ..." if len(journal.damaged) > 5 else "")
        say(f"{journal.path}: {len(journal.damaged):,} damaged lines ({lines}): their cases are solved again")


def _left(plan: Plan, journal: Journal, say: Say) -> Work:
    """The cases that the journal does not hold; those that make no case are journaled as failed at once."""
    numbers = _missing(plan, journal)
    done = plan.count - len(numbers)
    if done:
        say(f"{done:,} of {plan.count:,} cases are there from an earlier run")
    groups, wrong = plan.groups(numbers)
    for number, reason in wrong:
        journal.append(plan.identity(number), failed(plan.recipe, number, reason))
    work = Work(groups, forecast(plan, groups))
    if groups:
        say(f"{work.cases:,} cases to do with {len(groups):,} solves")
    return work


def _missing(plan: Plan, journal: Journal) -> list[int]:
    """Numbers of the cases that are not in the journal, equal cases once."""
    new: dict[str, int] = {}
    width = len(plan.recipe.wanted.columns)
    for number in range(plan.count):
        identity = plan.identity(number)
        row = journal.rows.get(identity)
        if row is None or len(row.values) != width:
            journal.rows.pop(identity, None)
            new.setdefault(identity, number)
    return list(new.values())


def forecast(plan: Plan, groups: list[Group]) -> float:
    """CPU seconds that the groups will take, from the methods' own forecasts for some of them."""
    some = groups[:: max(1, len(groups) // TUNING.looked_at)]
    seconds = [_solve_seconds(plan, group) for group in some]
    cases = sum(len(group.cases) for group in groups)
    return _beside(plan, cases) + len(groups) * sum(seconds) / max(len(seconds), 1)


def _beside(plan: Plan, cases: int) -> float:
    """CPU seconds of ``cases`` besides their solves."""
    columns = len(plan.recipe.wanted.columns)
    return TUNING.per_column * columns + (TUNING.per_case + TUNING.per_cell * columns) * cases


def _solve_seconds(plan: Plan, group: Group) -> float:
    """Forecast of the solve of a group; 0 where it is refused at once."""
    model = plan.recipe.model(group.cases[0][1])
    body, _ = at_unit_modulus(model.problem())
    try:
        return least(body, model).method.forecast(body).seconds
    except JkrError:
        return 0.0


def _guard(what: str, seconds: float, hours: float, likewise: str = "") -> None:
    """Refuse to begin what takes more than so many core ``hours`` by its forecast."""
    if seconds > 3600 * hours:
        raise InputError(
            f"--hours: {what} would take about {seconds / 3600:.3g} core hours{likewise}, more than the limit of "
            f"{hours:g}; raise it by --hours {math.ceil(1.5 * seconds / 3600)}, or ask for fewer cases, fewer points "
            "or a cheaper method"
        )


def _solve(plan: Plan, work: Work, folder: Path, journal: Journal, means: Means, say: Say) -> None:
    """Hand out the groups and journal their cases as they come in."""
    solves = folder.resolve() / SOLVES
    make_folder(solves)
    with executor(means.workers, means.scheduler, means.progress, work.seconds) as pool:
        if pool.dashboard:
            say(f"dashboard {pool.dashboard}")
        function, chunk = partial(solve_group, plan.recipe, solves), work.chunk(pool.workers)
        try:
            for index, result in completed(pool, function, work.groups, plan.title or "sweep", chunk):
                for row in _rows(plan, work.groups[index], result):
                    journal.append(plan.identity(row.number), row)
        except KeyboardInterrupt:
            say(f"{len(journal.rows):,} cases are kept; the same command goes on from there")
            raise


def _rows(plan: Plan, group: Group, result: list[Row] | Exception) -> Iterable[Row]:
    if isinstance(result, Exception):
        return [failed(plan.recipe, number, str(result)) for number, _ in group.cases]
    return result


def _write_failed(plan: Plan, folder: Path, table: SweepTable) -> list[Path]:
    """A table of the failed cases with the command that runs each alone; none where none failed."""
    path = folder / FAILED_TABLE
    if not table.failed:
        remove(path)
        return []
    numbers, reasons = zip(*table.failed, strict=True)
    write_csv(path, {"case": numbers, "reason": reasons, "command": [plan.command(number) for number in numbers]})
    return [path]


def alone(plan: Plan, number: int) -> SweptCase:
    """One case, solved here and now; nothing is read or written."""
    groups, wrong = plan.groups([number])
    row = failed(plan.recipe, number, wrong[0][1]) if wrong else solve_group(plan.recipe, None, groups[0])[0]
    return SweptCase(plan, row)
