"""The transition map: the pull-off force of a paraboloid on a layer from JKR to DMT, over how strongly and how far it
adheres.

-P_min/(pi w R) under load control depends on Poisson's ratio, the base, q = w R^2/(E* h^3) and mu = sigma (R/(E*^2
w))^(1/3) alone: the adhesion map of Johnson and Greenwood (J. Colloid Interface Sci. 192 (1997) 326) for a layer. Its
limits are JKR's force on that layer for large mu, and 2 for small; thin incompressible layers rise above both.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from itertools import product

import numpy as np

from ...adhesion import LOAD_CONTROL, CriticalPoint, FiniteRangeBody, Range, transform
from ...base import JkrError, SolveError, Unknown
from ...bodies import Loading, Paraboloid, Problem
from ...methods import AttractedBody, Layered
from ...report import Figure
from .maps import BASE, POISSON, SHOWN_NU, SHOWN_Q, Axis, Columns, Map, Q, Values, Work, layer, rows, within


@dataclass(frozen=True)
class TransitionTuning:
    """Which part of the map there is, how finely it is solved, and what that takes."""

    points: int = 60  # tuned on maps, by `make constants`: contact radii of a curve; more are added where it bends
    room: float = 1.5  # tuned on maps, by `make constants`: of the largest radius over that of pull-off without a range
    per_point: float = 0.06  # CPU seconds; tuned on maps of 17 and 100 ranges, by `make guards`


TUNING = TransitionTuning()


def _work(values: Values) -> Work:
    return partial(_row, values["base"], values["mu"]), list(product(values["nu"], values["q"]))


def _row(base: str, mus: Sequence[float], cell: tuple[float, float]) -> Columns:
    """All ranges of one layer and one work of adhesion, in units of h = R = 1 m, E* = 1 Pa."""
    nu, q = cell
    thick, thin = (9 * math.pi * q / 8) ** (1 / 3), max((8 * q) ** (1 / 4), (384 * q) ** (1 / 6))
    a = TUNING.room * max(thick, min(thin, 2 * thick))
    problem = Problem(Paraboloid(1.0), layer(nu, base == "bonded"), Loading("radius", a, TUNING.points))
    solution = Layered()(problem)
    sharp = transform(solution.series, "exact", q).pull_off(LOAD_CONTROL)
    if isinstance(sharp, Unknown):
        raise SolveError(f"transition map: nu = {nu:g}, q = {q:g}: {sharp.reason}")
    body = FiniteRangeBody(problem, solution.series, AttractedBody(problem))
    P, a_h, c_h, reason = zip(*(_point(body, f"nu = {nu:g}, q = {q:g}, mu = {mu:g}", q, mu) for mu in mus), strict=True)
    unit = -math.pi * q
    return rows(nu=nu, base=base, w_R2_over_Estar_h3=q, mu=np.array(mus), minus_P_over_pi_w_R=np.array(P) / unit,
                jkr_minus_P_over_pi_w_R=sharp.P / unit, a_over_h=a_h, c_over_h=c_h, reason=reason)  # fmt: skip


def _point(body: FiniteRangeBody, where: str, q: float, mu: float) -> tuple[float, float, float, str]:
    """Load, a and c at pull-off for one range on a ``body``; NaN where there is none, and the reason."""
    try:
        point = body.curve(Range.of(q, stress=mu * q ** (1 / 3))).pull_off(LOAD_CONTROL)
    except JkrError as error:
        point = Unknown(str(error))
    if isinstance(point, CriticalPoint) and point.c is not None:
        return point.P, point.a, point.c, ""
    reason = point.reason if isinstance(point, Unknown) else "no pull-off"
    return math.nan, math.nan, math.nan, f"{where}: {reason}"


def _figure(columns: Columns) -> Figure:
    """Filled where there are values enough on both axes, else as lines."""
    from ...report import MU, MapPanel, filled_figure, is_filled, lines_figure

    if is_filled(columns):
        return filled_figure(columns)
    title = f"layer on a rigid base, {columns['base'][0]}; dashed: JKR, dotted: long range"
    panel = MapPanel(
        "minus_P_over_pi_w_R", r"pull-off force / $\pi w R$", title, {2.0: ""}, dashed="jkr_minus_P_over_pi_w_R"
    )
    over = ("mu", MU)
    return lines_figure(columns, over, [panel], {Q: r"$w R^2/(E^* h^3)$ = {:g}".format, "nu": r"$\nu$ = {:g}".format})


MAP = Map(
    "transition",
    """Map the pull-off force of a paraboloid on a layer on a rigid base, in pi w R, over the range of adhesion.

    mu is the Tabor number of that range; the limits are JKR's force on the same layer, and 2 of a long range. Writes
    transition-map.csv, .png and .svg: filled over both axes where there are four values or more of each, else as lines.

    \b
    jkr study transition-map --nu 0.3 --q 1 --mu 0.3 --mu 3 -o map
    """,
    {
        "nu": Axis((0.499,), "Repeatable.", POISSON, family=True),
        "base": BASE,
        "q": Axis(tuple(np.geomspace(1e-2, 1e2, 13).tolist()), "Values of w R^2/(E* h^3)",
                      within(1e-4, 1e4), "13 from 0.01 to 100"),
        "mu": Axis(tuple(np.geomspace(0.1, 30, 17).tolist()), "Values of stress (R/(E*^2 w))^(1/3)",
                   within(0.05, 50.0), "17 from 0.1 to 30"),
    },
    _work,
    lambda values: TUNING.per_point * math.prod(len(values[name]) for name in ("nu", "q", "mu")),
    "{base} layer on a rigid base, paraboloid: pull-off force in pi w R",
    [SHOWN_NU, SHOWN_Q, ("mu", "mu", "6g"), ("minus_P_over_pi_w_R", "force", "8.4f"),
     ("jkr_minus_P_over_pi_w_R", "JKR", "8.4f"), ("a_over_h", "a/h", "9.4g"), ("c_over_h", "c/h", "9.4g")],
    _figure,
)  # fmt: skip
