"""Series files as the verbs read them, and how far they go, in words."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from ..base.errors import InputError
from ..base.units import show
from ..case import store
from ..series import Series, Solution
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


def end_of(series: Series) -> dict[str, Any]:
    """How far a series goes, for machines."""
    return {"points": len(series), "a_m": float(series.a[-1]), "delta_m": float(series.delta[-1]),
            "P_N": float(series.P[-1])}  # fmt: skip


def reached(a: float, delta: float, P: float) -> str:
    """A state of contact as people read it."""
    return f"a = {show(a, 'length')}, delta = {show(delta, 'length')}, P = {show(P, 'load')}"
