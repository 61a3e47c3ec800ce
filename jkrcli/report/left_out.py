"""What a case leaves out, in words: the worst in one line, all of it as a table."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from ..base import NOTICEABLE, Estimate, Unknown
from ..beside.left_out import LeftOut


@dataclass(frozen=True)
class ShownTuning:
    """How much is printed of it."""

    worst: int = 3  # choice: things in the one line
    digits: tuple[float, ...] = (0.1, 0.01)  # choice: changes below which one more digit follows the point


TUNING = ShownTuning()


def worst(rows: Sequence[LeftOut]) -> Iterator[str]:
    """The things left out that change most, with what of."""
    known = [(one.name, one.largest) for one in rows if not one.included and one.largest is not None]
    said = [f"{name} ({quantity} {percent(change)})" for name, (quantity, change) in known
            if abs(change) >= NOTICEABLE][: TUNING.worst]  # fmt: skip
    if known:
        yield f"  left out  {', '.join(said) or f'nothing that changes a result by {NOTICEABLE:.1%}'}"


def table(rows: Sequence[LeftOut]) -> Iterator[str]:
    """Every thing with its changes, and its key or why nothing is known of it."""
    if rows:
        yield f"  {'what each thing left out would change':<37}     load        S  pull-off  included by"
    for one in rows:
        cells = "".join(f"{percent(change):>9}" for change in one.changes.values())
        why = "" if one.largest else f"({one.load})"
        yield f"    {one.name:<35}{cells}   {why or one.key}".rstrip()


def percent(change: Estimate) -> str:
    """``+63%``, ``-4.4%``, ``+0.02%``; a dash where it is not known."""
    if isinstance(change, Unknown):
        return "-"
    if not round(change, 4):
        return "0"
    digits = sum(abs(change) < limit for limit in TUNING.digits)
    return f"{change:+.{digits}%}"
