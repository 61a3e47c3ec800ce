"""What a sequence of meshes tells: values on each, errors, observed orders, limits."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from ...adhesion import AdhesiveCurve, CriticalPoint
from ...base import Estimate, Unknown
from ...bodies import Problem


@dataclass(frozen=True)
class MeshesTuning:
    """The sequence of meshes, and what differences between them mean something."""

    ratio: float = 2.0  # theory: of element sizes from mesh to mesh, which halve
    coarsest_spacing: float = 0.49  # theory: below the limit of the mesher, half
    steepest_growth: float = 0.59  # theory: below the limit of the mesher, 0.6
    round_off: float = 1e-12  # theory: some thousand times machine epsilon, relative


TUNING = MeshesTuning()
WORDS = {"a": "contact radius", "P": "load", "pull_off": "pull-off force"}
DIMENSIONS = {"a": "length", "P": "load", "pull_off": "load"}


@dataclass(frozen=True, eq=False)
class State:
    """What is compared at the depth of the study: contact radius ``a`` [m], load ``P`` [N], and the pull-off under load
    control on the ``curve``, which is unknown where the series has too few points for slopes."""

    a: float
    P: float
    curve: AdhesiveCurve | Unknown

    @cached_property
    def point(self) -> CriticalPoint | Unknown:
        return self.curve if isinstance(self.curve, Unknown) else self.curve.pull_off(0.0)

    @property
    def values(self) -> dict[str, float | None]:
        """The quantities by name, a [m], P and the pull-off force [N]; None where that lies outside the series."""
        return {"a": self.a, "P": self.P, "pull_off": None if isinstance(self.point, Unknown) else self.point.P}


@dataclass(frozen=True, eq=False)
class Level:
    """One mesh: ``size``: of the elements at the edge of the largest contact [m]; ``seconds``: CPU of the solve."""

    size: float
    state: State
    elements: int
    unknowns: int
    kept: int
    dropped: int
    seconds: float

    @property
    def cells(self) -> dict[str, Any]:
        """What table and summary say alike of the mesh."""
        state = self.state
        return {"size_m": self.size, "elements": self.elements, "unknowns": self.unknowns, "a_m": state.a,
                "P_N": state.P}  # fmt: skip


@dataclass(frozen=True, eq=False)
class Meshes:
    """Meshes from coarse to fine, all judged at ``depth`` [m]; ``exact``: of the wide body, None for a finite one."""

    problem: Problem
    w: float
    depth: float
    levels: tuple[Level, ...]
    exact: State | None

    def values(self, quantity: str) -> list[float | None]:
        return [level.state.values[quantity] for level in self.levels]

    @cached_property
    def extrapolated(self) -> dict[str, tuple[float, float] | Unknown]:
        """Order and limit of Richardson's extrapolation, from the three finest meshes; else the reason."""
        return {quantity: richardson(self.values(quantity)) for quantity in WORDS}

    def order(self, quantity: str) -> Estimate:
        """Observed order: the slope of the errors over the sizes in logarithms, where an exact value is known; else
        the one of Richardson's extrapolation; else the reason why there is none."""
        limit = self.extrapolated[quantity]
        if self.exact is None:
            return limit if isinstance(limit, Unknown) else limit[0]
        pairs = [(level.size, abs(error)) for level, error in zip(self.levels, self.errors(quantity), strict=True)
                 if error is not None and abs(error) > TUNING.round_off]  # fmt: skip
        if len(pairs) < 3:
            return Unknown("needs three meshes with an error above round-off")
        sizes, errors = np.log(np.array(pairs)).T
        return float(np.polyfit(sizes, errors, 1)[0])

    @property
    def time_exponent(self) -> float:
        """Slope of CPU seconds over unknowns in logarithms."""
        unknowns, seconds = np.log([(level.unknowns, level.seconds) for level in self.levels]).T
        return float(np.polyfit(unknowns, seconds, 1)[0])

    def errors(self, quantity: str) -> list[float | None]:
        """Relative differences of each mesh to the exact value, or else to the extrapolated one, or to the finest."""
        values, reference = self.values(quantity), self.reference(quantity)
        return [None if value is None or reference is None else value / reference - 1 for value in values]

    def reference(self, quantity: str) -> float | None:
        if self.exact is not None:
            return self.exact.values[quantity]
        limit = self.extrapolated[quantity]
        return self.values(quantity)[-1] if isinstance(limit, Unknown) else limit[1]


def richardson(values: Sequence[float | None]) -> tuple[float, float] | Unknown:
    """Observed order and limit of values on meshes that halve their sizes, from the last three; else why not."""
    last = values[-3:]
    if len(last) < 3 or any(value is None for value in last):
        return Unknown("needs three meshes with a value")
    first, second = (b - a for a, b in itertools.pairwise(last))  # type: ignore[operator]
    if abs(second) <= TUNING.round_off * abs(last[-1]) or first / second <= 1:  # type: ignore[arg-type]
        return Unknown("the differences do not shrink from mesh to mesh")
    order = math.log(first / second) / math.log(TUNING.ratio)
    return order, last[-1] + second / (TUNING.ratio**order - 1)
