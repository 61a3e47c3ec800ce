"""A sweep carried out: what it will cost, the cases solved and journaled as they come, the table at the end."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

from ...base import (
    SILENCE,
    InputError,
    JkrError,
    Progress,
    check_target,
    completed,
    duration,
    executor,
    make_folder,
    remove_file,
    silent,
    together,
    write_csv,
)
from .journal import Journal, opened
from .plan import Cases, Plan, at_unit_modulus, failed, least, solve_group
from .result import STEM, Swept, SweptCase, endings, table, write

JOURNAL, FAILED_TABLE, SOLVES = "journal.jsonl", "failed.csv", "solves"
Say = Callable[[str], None]


@dataclass(frozen=True)
class SweepTuning:
    """What a sweep is expected to cost, and in what portions it is handed out."""

    per_case: float = 0.012  # CPU seconds of a case besides its solve; tuned on the shipped sweeps, by `make sweep`
    per_cell: float = 5e-6  # and per column of its row; tuned on 1,000 radii, by `make guards`
    per_column: float = 6e-4  # CPU seconds of each in the files; tuned on 1,000 radii, by `make guards`
    look: float = 0.0004  # CPU seconds to look at a case; tuned on the shipped sweeps, by `make sweep`
    looked_at: int = 12  # choice: groups whose forecasts stand for all
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


def sweep(plan: Plan, folder: Path, means: Means, force: bool, say: Say) -> Swept:
    """Carry out ``plan`` with the results in ``folder``; a sweep that was interrupted there goes on.

    ``say`` reports what goes on in the meantime. Errors: InputError where more than ``means.hours`` are forecast or
    the folder holds what is not ours, JkrError where every case failed.
    """
    make_folder(folder)
    for name in (*(f"{STEM}{ending}" for ending in endings()), FAILED_TABLE):
        check_target(folder / name, force)
    look = TUNING.look * plan.count
    if look > SILENCE:
        say(
            f"{plan.count:,} cases: looking through them takes about {duration(look)} of CPU time before the first is "
            "solved"
        )
    with opened(folder / JOURNAL) as journal:
        _say_damage(journal, say)
        if means.retry and (forgotten := journal.forget_failed()):
            say(f"{forgotten} failed cases are tried again")
        if look > SILENCE:
            _guard_early(plan, journal, means.hours, say)
        groups = _left(plan, journal, say)
        seconds = forecast(plan, groups)
        _guard(f"{sum(map(len, groups)):,} cases with {len(groups):,} solves", seconds, means.hours)
        if groups:
            _solve(plan, groups, seconds, folder, journal, means, say)
        swept = Swept(plan, table(plan, journal))
    with together():
        paths = [*write(folder, swept.columns), *_write_failed(folder, swept)]
    if len(swept.failed) == plan.count:
        raise JkrError(f"{plan.source}: every case failed, the first because: {swept.failed[0][1]}")
    return replace(swept, files=paths)


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


def _say_damage(journal: Journal, say: Say) -> None:
    """Say which lines are not believed, a few of them by number."""
    if journal.damaged:
        lines = ", ".join(map(str, journal.damaged[:5])) + (", ..." if len(journal.damaged) > 5 else "")
        say(f"{journal.path}: {len(journal.damaged):,} damaged lines ({lines}): their cases are solved again")


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
        say(f"{done:,} of {plan.count:,} cases are there from an earlier run")
    groups, wrong = plan.groups(new.values())
    for number, reason in wrong:
        journal.append(plan.identity(number), failed(plan.recipe, number, reason))
    if groups:
        say(f"{sum(map(len, groups)):,} cases to do with {len(groups):,} solves")
    return groups


def forecast(plan: Plan, groups: Sequence[Cases]) -> float:
    """CPU seconds that the groups will take, from the methods' own forecasts for some of them."""
    some = groups[:: max(1, len(groups) // TUNING.looked_at)]
    seconds = [_solve_seconds(plan, group) for group in some]
    return _beside(plan, sum(map(len, groups))) + len(groups) * sum(seconds) / max(len(seconds), 1)


def _beside(plan: Plan, cases: int) -> float:
    """CPU seconds of ``cases`` besides their solves."""
    columns = len(plan.recipe.wanted.columns)
    return TUNING.per_column * columns + (TUNING.per_case + TUNING.per_cell * columns) * cases


def _solve_seconds(plan: Plan, group: Cases) -> float:
    """Forecast of the solve of a group; 0 where it is refused at once."""
    model = plan.recipe.model(group[0][1])
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
        chunk = max(1, min(round(by_time), math.ceil(len(groups) / (TUNING.shares * pool.workers))))
        try:
            function = partial(solve_group, plan.recipe, solves)
            for index, rows in completed(pool, function, groups, plan.title or "sweep", chunk):
                if isinstance(rows, Exception):
                    rows = [failed(plan.recipe, number, str(rows)) for number, _ in groups[index]]
                for row in rows:
                    journal.append(plan.identity(row.number), row)
        except KeyboardInterrupt:
            say(f"{len(journal.rows):,} cases are kept; the same command goes on from there")
            raise


def _write_failed(folder: Path, swept: Swept) -> list[Path]:
    """A table of the failed cases with the command that runs each alone; none where none failed."""
    path = folder / FAILED_TABLE
    if not swept.failed:
        remove_file(path)
        return []
    numbers, reasons = zip(*swept.failed, strict=True)
    write_csv(path, {"case": numbers, "reason": reasons, "command": list(map(swept.plan.command, numbers))})
    return [path]


def alone(plan: Plan, number: int) -> SweptCase:
    """One case, solved here and now; nothing is read or written."""
    groups, wrong = plan.groups([number])
    row = failed(plan.recipe, number, wrong[0][1]) if wrong else solve_group(plan.recipe, None, groups[0])[0]
    return SweptCase(plan, row)
