"""What a case leaves out, in words: the worst in one line, all of it as a table."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from ..base import NOTICEABLE, Estimate, Unknown
from ..beside.left_out import LeftOut


def worst(rows: Sequence[LeftOut]) -> Iterator[str]:
    """The three things left out that change most, with what of."""
    known = [(one.name, one.largest) for one in rows if not one.included and one.largest is not None]
    changes = [f"{name} ({quantity} {percent(change)})" for name, (quantity, change) in known
            if abs(change) >= NOTICEABLE][:3]  # fmt: skip
    if known:
        yield f"  left out  {', '.join(changes) or f'nothing that changes a result by {NOTICEABLE:.1%}'}"


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
    digits = sum(abs(change) < limit for limit in (0.1, 0.01))  # two of them are shown
    return f"{change:+.{digits}%}"
