"""Series files as the verbs read them."""

from __future__ import annotations

from pathlib import Path

from ..base.errors import InputError
from ..case import store
from ..series import Solution
from .voice import warn


def read_series(path: Path) -> Solution:
    """What the series file at ``path`` holds; a file that damage could have changed unnoticed is warned of."""
    solution = store.read(path)
    if store.DOUBT in solution.warnings:
        warn(f"{path}: {store.DOUBT}")
    return solution


def works_of(solution: Solution, option: str = "--w") -> tuple[float, ...]:
    """The works of adhesion [J/m^2] that the case names; InputError, with the ``option`` that helps, where none."""
    if not solution.record.w:
        raise InputError(f"{solution.record.path}: its case names no work of adhesion: give {option}")
    return solution.record.w
