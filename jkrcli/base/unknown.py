"""A number, or why there is none."""

from __future__ import annotations

import math
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


def accuracy(error: Estimate) -> str:
    """A relative numerical error in words: where it is small, a power of ten above it."""
    if isinstance(error, Unknown):
        return f"numerical error {error}"
    if error >= 1e-4:
        return f"numerical error {float(f'{100 * error:.2g}'):g} %"
    return f"numerical error below {10.0 ** math.ceil(math.log10(max(error, 1e-15))):.0e}".replace("e-0", "e-")


def known(value: Estimate) -> float | None:
    """The number, or None where it is not known."""
    return None if isinstance(value, Unknown) else value
