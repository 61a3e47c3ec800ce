"""What a fit may vary: names, units, and how a value becomes a well-scaled unknown of the optimiser."""

from __future__ import annotations

import difflib
import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

from ...base.errors import InputError

Kind = Literal["log", "positive", "linear"]
DIMENSIONS = {"modulus": "number", "w": "work", "delta0": "length", "P0": "load", "compliance": "number"}
KINDS: dict[str, Kind] = {"modulus": "log", "w": "positive", "delta0": "linear", "P0": "linear", "compliance": "linear"}
OF_A_LAYER = {"E": "modulus", "h": "length", "nu": "number"}


@dataclass(frozen=True)
class Parameter:
    """One quantity of the model, SI: free between ``low`` and ``high``, or fixed at ``value``.

    ``value = None``: free, and the start is found from the data. Names: those of ``DIMENSIONS``, "E:layer" and
    "h:layer" for modulus and thickness of a named layer.
    """

    name: str
    free: bool
    value: float | None = None
    low: float = -math.inf
    high: float = math.inf

    def __post_init__(self) -> None:
        if not self.free and self.value is None:
            raise InputError(f"{self.name}: is fixed and needs a value")
        least = -math.inf if self.kind == "linear" else 0.0
        if self.value is not None:
            self._check(self.value)
        if not max(self.low, least) < self.high:
            raise InputError(f"{self.name}: bounds must increase and leave room, got {self.low:g} to {self.high:g}")

    def _check(self, value: float) -> None:
        above = value > 0 if self.kind == "log" else value >= 0 or self.kind == "linear"
        if not (math.isfinite(value) and above):
            allowed = {"log": "> 0", "positive": "finite and >= 0", "linear": "finite"}[self.kind]
            raise InputError(f"{self.name}: must be {allowed}, got {value:g}")
        if self.free and not self.low <= value <= self.high:
            raise InputError(f"{self.name}: the start {value:g} is outside its bounds {self.low:g} to {self.high:g}")

    @property
    def kind(self) -> Kind:
        """The scale on which it is fitted: "log", or as it is, "positive" where it cannot be less than 0.

        w as it is: its effect on a curve without adhesion is of first order in w (the shift by its root is along it).
        """
        return KINDS.get(self.name, "log")

    @property
    def dimension(self) -> str:
        return DIMENSIONS.get(self.name) or OF_A_LAYER[self.name.partition(":")[0]]

    @property
    def of_body(self) -> bool:
        """Whether the body must be solved anew when it changes."""
        return self.name not in DIMENSIONS

    def inner(self, value: float) -> float:
        """The optimiser's unknown for ``value``."""
        if self.kind == "log":
            return math.log(value) if value > 0 else -math.inf
        return max(value, 0.0) if self.kind == "positive" else value

    def outer(self, x: float) -> float:
        """The value of the optimiser's unknown ``x``."""
        if self.kind == "log":
            return math.exp(x)
        return max(x, 0.0) if self.kind == "positive" else x

    def derivative(self, x: float) -> float:
        """d(value)/dx."""
        return math.exp(x) if self.kind == "log" else 1.0


def checked_names(names: Sequence[str], allowed: Sequence[str]) -> None:
    """Refuse a name that is none of ``allowed``, with the nearest that is."""
    for name in names:
        if name not in allowed:
            close = difflib.get_close_matches(name, allowed, 1, 0.4)
            hint = f', did you mean "{close[0]}"?' if close else ""
            raise InputError(f'fit: unknown parameter "{name}"{hint} (allowed: {", ".join(allowed)})')
