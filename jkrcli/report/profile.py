"""Contact pressure and surface shape at one state as a result."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ..base import Array, lists, show
from .result import Figure, Result


@dataclass(frozen=True, eq=False)
class Profile(Result):
    """Pressure, displacement and gap over r around a contact of radius ``a`` [m] with ``w`` [J/m^2]."""

    path: Path
    a: float
    w: float
    columns: Mapping[str, Array]

    def summary(self) -> dict[str, Any]:
        return {"file": str(self.path), "a_m": self.a, "w_J_per_m2": self.w, **lists(self.columns)}

    def words(self) -> list[str]:
        return [f"a = {show(self.a, 'length')}, w = {show(self.w, 'work')}: {self.path}"]

    def figure(self) -> Figure:
        from .plots.body import profile_figure

        return profile_figure(self.columns, self.a, self.w)
