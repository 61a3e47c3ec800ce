"""A contact law for particle codes as a C header, and what it says beside the half-space's JKR."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..adhesion.dem import DemLaw
from ..base import Array, InputError, show
from ..beside import Analysis
from ..formulas.half_space import jkr
from .result import Result

CODE = """
/* The state at an overlap delta [m]; touching: whether the two were in contact before. Returns 1 in contact, 0 free,
   -1 beyond the table, where its last row stands in. */
static inline int jkr_contact(double delta, int touching, double *force, double *radius)
{
    const int last = JKR_ROWS - 1;
    double s, w[4];
    int i, k, found = 1;
    *force = *radius = 0.0;
    if (delta < (touching ? JKR_DELTA_TEAR : JKR_DELTA_TOUCH)) return 0;
    s = sqrt(delta > JKR_DELTA_TEAR ? (delta - JKR_DELTA_TEAR) / JKR_SPAN : 0.0) * last;
    if (s > last * (1.0 + 1e-12)) { s = last; found = -1; }
    i = (int)s - 1;
    if (i < 0) i = 0;
    if (i > last - 3) i = last - 3;
    s -= i;
    w[0] = -(s - 1) * (s - 2) * (s - 3) / 6;
    w[1] = s * (s - 2) * (s - 3) / 2;
    w[2] = -s * (s - 1) * (s - 3) / 2;
    w[3] = s * (s - 1) * (s - 2) / 6;
    for (k = 0; k < 4; k++) {
        *force += w[k] * jkr_force[i + k];
        *radius += w[k] * jkr_radius[i + k];
    }
    return found;
}

#ifdef JKR_CHECK /* cc -DJKR_CHECK -x c this-file.h -lm && ./a.out: the law between its rows, and where contact ends */
#include <stdio.h>
int main(void)
{
    double force, radius, worst = 0.0;
    int n;
    for (n = 0; n < JKR_VECTORS; n++) {
        if (jkr_contact(jkr_vector[n][0], 1, &force, &radius) != 1) return 1;
        worst = fmax(worst, fabs(force - jkr_vector[n][1]) / JKR_FORCE_SCALE);
        worst = fmax(worst, fabs(radius - jkr_vector[n][2]) / JKR_RADIUS_SCALE);
    }
    if (jkr_contact(JKR_DELTA_TOUCH - JKR_SPAN * 1e-9, 0, &force, &radius) != 0) return 2;
    if (jkr_contact(JKR_DELTA_TEAR - JKR_SPAN * 1e-9, 1, &force, &radius) != 0) return 3;
    if (jkr_contact(JKR_DELTA_TEAR + JKR_SPAN * 1.1, 1, &force, &radius) != -1) return 4;
    printf("%.3g\\n", worst);
    return worst > 2e-6 ? 5 : 0;
}
#endif
#endif
"""


@dataclass(frozen=True, eq=False)
class Exported(Result):
    """The contact law of an adhesive curve: ``columns`` are its table, ``header`` the C header."""

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
    def header(self) -> str:
        """The C header (C99, no other file) with the table, a function that reads it, test vectors and a check."""
        law, result = self.law, self.result
        numbers = {"DELTA_TOUCH": 0.0, "FORCE_TOUCH": law.jump_in.P, "RADIUS_TOUCH": law.jump_in.a,
                   "DELTA_TEAR": law.tear_off.delta, "FORCE_TEAR": law.tear_off.P, "RADIUS_TEAR": law.tear_off.a,
                   "SPAN": law.delta[-1] - law.delta[0], "FORCE_SCALE": abs(law.P).max(),
                   "RADIUS_SCALE": law.a.max()}  # fmt: skip
        if law.load is not None:
            numbers |= {"DELTA_LOAD": law.load.delta, "FORCE_LOAD": law.load.P, "RADIUS_LOAD": law.load.a}
        vectors = ",\n".join("    { " + ", ".join(f"{float(cell)!r}" for cell in row) + " }" for row in law.vectors)
        return "\n".join([
            f"/* Written by jkr: adhesive contact of {result.problem.words.replace('*/', '* /')};",
            f"   w = {result.w!r} J/m^2. SI units; overlap and compressive force positive; the force of one contact.",
            "   TOUCH: after first contact; TEAR: contact lost under displacement control, as in a particle code whose",
            "   time step resolves it; LOAD: under load control. The interpolation is good to "
            f"{law.error:.1g} of the largest force and radius. */",
            "#ifndef JKR_CONTACT_H", "#define JKR_CONTACT_H", "#include <math.h>",
            f"#define JKR_ROWS {law.delta.size}", f"#define JKR_VECTORS {len(law.vectors)}",
            *(f"#define JKR_{name} ({float(value)!r})" for name, value in numbers.items()),
            *(f"static const double jkr_{name}[JKR_ROWS] = {{\n{_listed(column)} }};"
              for name, column in (("force", law.P), ("radius", law.a))),
            f"static const double jkr_vector[JKR_VECTORS][3] = {{ /* delta, force, radius */\n{vectors} }};",
        ]) + CODE  # fmt: skip

    @property
    def half_space(self) -> dict[str, tuple[float, float]]:
        """Overlap [m] and force [N] at which classical JKR of the uppermost material lets go, by control; empty for a
        tip without a radius."""
        problem, w = self.result.problem, self.result.w
        R, E_star = problem.indenter.tip_radius, problem.E_star
        if R is None:
            return {}
        cubes = {"displacement": 1 / 8, "load": 9 / 8}  # of a, over pi w R^2/E*
        found = {}
        for control, cube in cubes.items():
            delta, P = jkr(np.array((cube * math.pi * w * R**2 / E_star) ** (1 / 3)), E_star, R, w)
            found[control] = (float(delta), float(P))
        return found

    def summary(self) -> dict[str, Any]:
        law, result = self.law, self.result
        named = {"touch": law.jump_in, "tear_off": law.tear_off, "load_control": law.load}
        points = {name: None if at is None else {"delta_m": at.delta, "P_N": at.P, "a_m": at.a}
                  for name, at in named.items()}  # fmt: skip
        classical = {name: dict(zip(("delta_m", "P_N"), pair, strict=True)) for name, pair in self.half_space.items()}
        return {"file": str(result.path), "w_J_per_m2": result.w, "rows": law.delta.size, "error": law.error,
                **points, "half_space": classical}  # fmt: skip

    def words(self) -> list[str]:
        law, result = self.law, self.result
        w, tear_off, end = result.w, law.tear_off, show(law.delta[-1], "length")
        lines = [
            f"tear-off at P = {show(tear_off.P, 'load')}, delta = {show(tear_off.delta, 'length')} "
            f"(displacement control), w = {show(w, 'work')}: {result.path}",
            f"  table      {law.delta.size} rows up to {end}, good to {law.error:.1g} between",
            f"  touch      {_state(0.0, law.jump_in.P)}",
        ]
        if law.load is not None:
            lines.append(f"  pull-off   {_state(law.load.delta, law.load.P)} (load control)")
        if found := self.half_space:
            lines.append(f"  JKR of a half-space of the uppermost material, gamma = w/2 = {show(w / 2, 'work')}:")
            lines += [f"    lets go  {_state(*pair)} ({control} control)" for control, pair in found.items()]
        return lines


def _listed(column: Array) -> str:
    cells = [f"{float(cell)!r}" for cell in column]
    return ",\n".join("    " + ", ".join(cells[i : i + 4]) for i in range(0, len(cells), 4))


def _state(delta: float, P: float) -> str:
    return f"delta = {show(delta, 'length'):<12} P = {show(P, 'load'):<12}".rstrip()
