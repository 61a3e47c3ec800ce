"""Solves that are not repeated: bodies that differ by one factor of all moduli share one, kept by what it depends on.

P, S and S' scale with the moduli and delta(a) does not, so that every problem is solved at unit modulus: E = 1 Pa at
its surface. The result depends on the problem alone, never on which of several cases asked for it first.
"""

from __future__ import annotations

import contextlib
import hashlib
import time
from dataclasses import dataclass, fields, is_dataclass, replace
from pathlib import Path
from typing import Any

from .. import __version__
from ..base import InputError, JkrError, check_target
from ..bodies import Problem
from ..case import store
from ..methods import Method
from ..series import Record, Solution


@dataclass(frozen=True)
class CacheTuning:
    """How solves are distinguished and which are kept."""

    digits: int = 13  # of numbers at unit modulus, theory: of the 16 of a double quotients lose the last ones
    worth_keeping: float = 0.1  # choice: CPU seconds; reading a file takes a tenth of it


TUNING = CacheTuning()


def at_unit_modulus(problem: Problem) -> tuple[Problem, float]:
    """The problem with all moduli (and a load, where one is prescribed) over the surface's E, and that E [Pa]."""
    factor = problem.specimen.surface.E
    return _rounded(problem.scaled(1 / factor)), factor


def _rounded(value: Any) -> Any:
    """``value`` rounded throughout (``CacheTuning.digits``): quotients that are equal on paper become equal."""
    if isinstance(value, float):
        return float(f"{value:.{TUNING.digits - 1}e}")
    if isinstance(value, tuple):
        return tuple(_rounded(item) for item in value)
    if is_dataclass(value) and not isinstance(value, type):
        return replace(value, **{item.name: _rounded(getattr(value, item.name)) for item in fields(value) if item.init})
    return value


def solve_key(problem: Problem, method: Method) -> str:
    """A hash of all that a solve depends on: the physics, the method with its options, the release."""
    return hashlib.sha256(f"{problem.key}\n{method!r}\n{__version__}".encode()).hexdigest()[:24]


def solved(problem: Problem, method: Method, folder: Path | None = None) -> Solution:
    """The solution of ``problem`` by ``method``: from ``folder`` where it is kept there, else solved, and kept there
    where that was expensive (``CacheTuning``)."""
    key = solve_key(problem, method)
    path = None if folder is None else folder / f"{key}.h5"
    if path is not None and (stored := _read(path, problem, key)) is not None:
        return stored
    start = time.process_time()
    solution = replace(method(problem), record=Record(path=Path("series")))
    expensive = time.process_time() - start > TUNING.worth_keeping
    if path is not None and expensive and solution.raw is None and path.parent.is_dir():
        with contextlib.suppress(JkrError):  # no room, or a shape that no case can say: it is solved every time
            check_target(path, force=True)  # also what is damaged
            store.write(path, solution, _made_by(key))
    return solution


def _made_by(key: str) -> str:
    """What a kept file says of its origin: its name alone proves nothing."""
    return f"jkr sweep, solve {key}"


def _read(path: Path, problem: Problem, key: str) -> Solution | None:
    """A solution that was kept; None where there is none, its file is damaged, or it holds another solve."""
    try:
        solution = store.read(path, problem) if path.exists() else None
    except InputError:
        return None
    return solution if solution is not None and solution.record.command_line == _made_by(key) else None
