"""A contact law for particle codes as a C header, and what it says beside the half-space's JKR."""

from __future__ import annotations

import math
from dataclasses import dataclass
from importlib import resources
from string import Template
from typing import Any

import numpy as np

from ..adhesion.dem import DemLaw
from ..base.errors import InputError
from ..base.numerics import Array
from ..base.result import Result
from ..base.units import show
from ..formulas import jkr
from ..resolve.analysis import Analysis
from .tables import format_state, quantities

CODE = Template(resources.files(__package__).joinpath("dem.c").read_text(encoding="utf-8"))


@dataclass(frozen=True, eq=False)
class Exported(Result):
    """The contact law of an adhesive curve: ``columns`` are its table, ``code`` the C header."""

    law: DemLaw
    result: Analysis

    @classmethod
    def of(cls, result: Analysis) -> Exported:
        try:
            return cls(DemLaw.of(result.curve), result)
        except InputError as error:
            raise InputError(f"{result.path}: {error}") from None

    @property
    def columns(self) -> dict[str, Array]:  # type: ignore[override]
        law = self.law
        return {"fraction": np.linspace(0, 1, law.delta.size), "delta_m": law.delta, "P_N": law.P, "a_m": law.a}

    @property
    def code(self) -> str:
        """The C header (C99, no other file) with the table, a function that reads it, test vectors and a check."""
        law, result = self.law, self.result
        numbers = {"DELTA_TOUCH": 0.0, "FORCE_TOUCH": law.jump_in.P, "RADIUS_TOUCH": law.jump_in.a,
                   "DELTA_TEAR": law.tear_off.delta, "FORCE_TEAR": law.tear_off.P, "RADIUS_TEAR": law.tear_off.a,
                   "SPAN": law.delta[-1] - law.delta[0], "FORCE_SCALE": abs(law.P).max(),
                   "RADIUS_SCALE": law.a.max()}  # fmt: skip
        if law.load is not None:
            numbers |= {"DELTA_LOAD": law.load.delta, "FORCE_LOAD": law.load.P, "RADIUS_LOAD": law.load.a}
        vectors = ",\n".join("    { " + ", ".join(f"{float(cell)!r}" for cell in row) + " }" for row in law.vectors)
        return CODE.substitute(
            body=result.problem.words.replace("*/", "* /"), w=repr(result.w), error=f"{law.error:.1g}",
            rows=law.delta.size, forces=_listed(law.P), radii=_listed(law.a), vectors=len(law.vectors), vector=vectors,
            numbers="\n".join(f"#define JKR_{name} ({float(value)!r})" for name, value in numbers.items()),
        )  # fmt: skip

    @property
    def half_space(self) -> dict[str, tuple[float, float]]:
        """Overlap [m] and force [N] at which classical JKR of the uppermost material lets go, by control; empty for a
        tip without a radius."""
        problem, w = self.result.problem, self.result.w
        R, E_star = problem.indenter.tip_radius, problem.E_star
        if R is None:
            return {}
        cubes = {"displacement": 1 / 8, "load": 9 / 8}  # of a, over pi w R^2/E*
        points = {}
        for control, cube in cubes.items():
            delta, P = jkr(np.array((cube * math.pi * w * R**2 / E_star) ** (1 / 3)), E_star, R, w)
            points[control] = (float(delta), float(P))
        return points

    def summary(self) -> dict[str, Any]:
        law, result = self.law, self.result
        named = {"touch": law.jump_in, "tear_off": law.tear_off, "load_control": law.load}
        points = {name: None if at is None else quantities(at, "delta P a") for name, at in named.items()}
        classical = {name: dict(zip(("delta_m", "P_N"), pair, strict=True)) for name, pair in self.half_space.items()}
        return {"file": str(result.path), "w_J_per_m2": result.w, "rows": law.delta.size, "error": law.error,
                **points, "half_space": classical}  # fmt: skip

    def words(self) -> list[str]:
        law, result = self.law, self.result
        w, end = result.w, show(law.delta[-1], "length")
        lines = [
            f"tear-off at {format_state(law.tear_off, 'P delta')} (displacement control), w = {show(w, 'work')}: "
            f"{result.path}",
            f"  table      {law.delta.size} rows up to {end}, good to {law.error:.1g} between",
            f"  touch      {_state(0.0, law.jump_in.P)}",
        ]
        if law.load is not None:
            lines.append(f"  pull-off   {_state(law.load.delta, law.load.P)} (load control)")
        if classical := self.half_space:
            lines.append(f"  JKR of a half-space of the uppermost material, gamma = w/2 = {show(w / 2, 'work')}:")
            lines += [f"    lets go  {_state(*pair)} ({control} control)" for control, pair in classical.items()]
        return lines


def _listed(column: Array) -> str:
    cells = [f"{float(cell)!r}" for cell in column]
    return ",\n".join("    " + ", ".join(cells[i : i + 4]) for i in range(0, len(cells), 4))


def _state(delta: float, P: float) -> str:
    return f"delta = {show(delta, 'length'):<12} P = {show(P, 'load'):<12}".rstrip()
