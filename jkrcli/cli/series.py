"""Series files as the verbs read them, and how far they go, in words."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from .. import __version__
from ..adhesion import RangeRequest
from ..base import InputError, check_series_target
from ..bodies import relaxing
from ..case import NO_DIGEST, Case, load_case, other_tables, read_solution, record_of, write_solution
from ..methods import Forecast, Limits
from ..series import Record, Solution
from .options import begin
from .voice import announce, command_line, note, warn

PER_FILE = 0.012  # CPU seconds to read a series; tuned on 300 files, by `make guards`
IMPORTED = "jkr import"  # how the command line of a series begins that no case gives again


def series_file(path: Path) -> Path:
    """The series file meant by ``path``: itself, or for a case what ``jkr run`` makes of it, ``<case>.h5`` here.

    That is solved now unless it is there already, and says so; a file that jkr did not write is left alone, and so is
    an imported series of another case.
    """
    if path.suffix != ".toml":
        return path
    case, target = load_case(path), Path(f"{path.stem}.h5")
    check_series_target(target, False, [path])
    existing = _solved(target, case)
    if existing is not None:
        note(f"{path}: {target} holds its series already (method {existing.method})")
        if _adhesion(existing.record) != _adhesion(record_of(case)):
            write_solution(target, replace(existing, record=record_of(case)), existing.record.command_line)
        return target
    from ..case import solve

    choice, solution = solve(case, announce=note)
    write_solution(target, solution, command_line())
    note(f"{path}: solved by method {choice.name}, written {target}")
    for remark in case.remarks:
        warn(remark)
    return target


def _adhesion(record: Record) -> tuple[object, ...]:
    return record.w, record.z0, record.stress, record.length


def _solved(target: Path, case: Case) -> Solution | None:
    """What ``target`` holds where that is a series of the same body, loading and method by this release."""
    try:
        solution = read_solution(target, with_pressure=True) if target.exists() else None
    except InputError:
        return None
    if solution is None or not isinstance(solution.record.case, Case):
        return None
    apart = {"title", "adhesion"} | other_tables(solution.method)
    there, wanted = (one.model.model_dump(exclude=apart) for one in (solution.record.case, case))
    if there == wanted and solution.record.versions.get("jkr") == __version__:
        return solution
    if solution.record.command_line.startswith(IMPORTED):
        raise InputError(f"{target}: is an imported series of another case: name it itself, or move it away")
    return None


def read_files(verb: str, paths: Sequence[Path]) -> tuple[tuple[Path, ...], list[Solution]]:
    """The series files that are meant by ``paths``, and what they hold; said beforehand where they are many."""
    announce_files(verb, paths)
    files = tuple(map(series_file, paths))
    return files, [read_series(path) for path in files]


def announce_files(verb: str, paths: Sequence[Path]) -> None:
    """Say what it takes a ``verb`` to read series files, where that is much."""
    announce(f"{verb} of {len(paths):,} files", PER_FILE * len(paths))


def read_series(path: Path) -> Solution:
    """What the series file at ``path`` holds; a file that damage could have changed unnoticed is warned of."""
    solution = read_solution(path)
    if NO_DIGEST in solution.warnings:
        warn(f"{path}: {NO_DIGEST}")
    return solution


def warn_of_constant_moduli(*solutions: Solution) -> None:
    """Say of each specimen that relaxes what the numbers of a verb mean that does not follow its moduli over time."""
    for solution in solutions:
        for text in relaxing(solution.problem.specimen.relaxation):
            warn(f"{solution.record.path}: {text}")


def works_of(solution: Solution, option: str = "--w") -> tuple[float, ...]:
    """The works of adhesion [J/m^2] that the case names; InputError, with the ``option`` that helps, where none."""
    if not solution.record.w:
        raise InputError(f"{solution.record.path}: its case names no work of adhesion: give {option}")
    return solution.record.w


def body_and_work(verb: str, path: Path, work: float | None, ranged: bool = False) -> tuple[Path, Solution, float]:
    """The series file that is meant by ``path``, what it holds, and the ``work`` of adhesion [J/m^2] or the first that
    its case names, 0, with a note, where it names none; Refusal by a ``verb`` that is not ``ranged``, see
    ``without_range``."""
    file = series_file(path)
    solution = read_series(file)
    warn_of_constant_moduli(solution)
    if not ranged:
        without_range(solution.record, verb)
    if work is None and not solution.record.w:
        note(f"{solution.record.path}: its case names no work of adhesion: the contact without adhesion, or give --w")
    return file, solution, (*solution.record.w, 0.0)[0] if work is None else work


def without_range(record: Record, verb: str) -> None:
    """Refusal by a ``verb`` that has no adhesion of finite range, where the case of ``record`` asks for it."""
    if record.stress is not None or record.length is not None:
        raise InputError(
            f"{verb}: has no adhesion of finite range, which the case of {record.path} asks for: leave "
            "adhesion.range, stress and capillary out"
        )


def begin_curves(
    verb: str, solutions: Sequence[Solution], works: Sequence[Sequence[float]], limits: Limits,
    ranges: Sequence[RangeRequest] = (), tables: bool = False, figures: bool = False, devices: int = 0,
    beside: float = 0.0,
) -> None:  # fmt: skip
    """Say what the curves of a ``verb`` will cost together, with the ``ranges`` of adhesion of each solution (default:
    none), read off for so many ``devices``, and what takes so many CPU seconds ``beside``, where that is much; Refusal
    beyond the ``limits``."""
    from ..beside import forecast

    ranges = ranges or [RangeRequest()] * len(solutions)
    costs = [forecast(*each, tables, figures, devices) for each in zip(solutions, works, ranges, strict=True)]
    total = Forecast(beside + sum(cost.seconds for cost in costs), max(cost.memory_mib for cost in costs), 0.0)
    rows = sum(solution.increments.a.size for solution in solutions)
    under = f" under {devices:,} controls" if devices else ""
    what = f"{verb} of {rows:,} rows for {sum(map(len, works)):,} works of adhesion{under}"
    less = f"fewer rows, files{', controls' if devices else ''} or works of adhesion, or leave out the plots"
    begin(what, total, limits, less)
