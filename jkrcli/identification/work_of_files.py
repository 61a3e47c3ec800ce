"""The work of adhesion along the curves of measured files, on one solved body."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from ..adhesion import Nonadhesive
from ..base import TOGETHER, InputError, Pool, completed
from ..data import Reading, each, some
from ..series import Solution
from .fit import body_of, settings_of
from .work import Evaluation, WorkAlong, check_window


def evaluation_of(
    solution: Solution, unit: Nonadhesive, reading: Reading, modulus_factor: float = 1.0, use: str | None = None,
    segment: str | None = None, noise: Mapping[str, float] | None = None, window: int = 11,
) -> Evaluation:  # fmt: skip
    """What gives w along any curve: on a ``solution`` with its functions ``unit``, moduli times ``modulus_factor``, by
    the pair of quantities ``use`` ("a,P"); of raw records base line, zero points and rows are fitted first."""
    check_window(window)
    body, contact = body_of(solution), "as-is" if reading.zero else reading.contact
    settings = settings_of(body, fix=[("modulus", f"{modulus_factor!r}")], contact=contact, segment=segment)
    own = segment in (None, "approach", "retract")
    pair: Any = None if use is None else tuple(use.split(","))
    return Evaluation(
        unit.scaled(modulus_factor), pair, noise or {}, window, segment, body if own else None, settings
    )  # fmt: skip


def along_file(path: Path, reading: Reading, evaluation: Evaluation, pool: Pool) -> tuple[list[WorkAlong], list[str]]:
    """The curves of a file that have a work of adhesion, in its order, and why the others have none."""
    outcomes: list[Any] = list(each(path, reading))
    rows = [i for i, item in enumerate(outcomes) if not isinstance(item, InputError)]
    for i, outcome in completed(pool, evaluation, [outcomes[row] for row in rows], path.name, TOGETHER):
        outcomes[rows[i]] = outcome
    for outcome in outcomes:
        if isinstance(outcome, Exception) and not isinstance(outcome, InputError):
            raise outcome
    skipped = [line for outcome in outcomes if isinstance(outcome, InputError) for line in outcome.lines]
    works = [outcome for outcome in outcomes if not isinstance(outcome, Exception)]
    if not works:
        raise InputError(some(skipped))
    return works, skipped
