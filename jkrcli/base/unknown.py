"""A number, or why there is none."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeAlias


@dataclass(frozen=True)
class Unknown:
    """Stands where a number is not known; ``reason``: a phrase for the reader, without a full stop."""

    reason: str

    def __str__(self) -> str:
        return self.reason

    def __bool__(self) -> bool:
        """Never true, so that ``value or otherwise`` reads as it should."""
        return False


Estimate: TypeAlias = float | Unknown  # mostly a relative error


def known(value: Estimate) -> float | None:
    """The number, or None where it is not known."""
    return None if isinstance(value, Unknown) else value
