"""The pull-off map: how far a layer's pull-off force lies from the half-space's, over how strongly it adheres.

For a paraboloid on one layer on a rigid base, -P_min/(pi w R) under load control depends on Poisson's ratio, the base
and q = w R^2/(E* h^3) alone: 3/2 for thick layers (small q), 2 for thin compressible, 3 for thin incompressible ones.
Nearly incompressible layers rise above 2 and come back to it (nu = 0.45: 2.105 at q = 1e3, 2.027 at 1e6).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from ... import __version__
from ...adhesion import LOAD_CONTROL, AdhesiveCurve, Nonadhesive
from ...base import SolveError, Unknown
from ...formulas.surface_tension import wetting_radius
from ...methods import Layered
from ...report import Figure
from ...series import Series
from .maps import BASE, POISSON, SHOWN_NU, SHOWN_Q, Axis, Columns, Map, Q, Values, Work, layer, rows, series_at, within


@dataclass(frozen=True)
class MapTuning:
    """Which part of the map there is, how finely its series are solved, and what that takes."""

    # tuned on maps, by `make constants`: of the contact radius; twice as many change the pull-off force by 4e-8
    per_decade: int = 40
    # tuned on maps, by `make constants`: relative, of the series; a/h near 100 at nu = 1/2 leaves 1e-7
    tolerance: float = 1e-6
    per_nu: float = 4e-3  # CPU seconds; tuned on maps of 30 and 300 ratios of Poisson, by `make guards`
    per_tense: float = 0.3  # CPU seconds of a q under surface tension; tuned on maps of 30, by `make guards`
    per_point: float = 1e-3  # CPU seconds of a q; tuned on maps of 1000, by `make guards`


TUNING = MapTuning()


LIMITS = {1.5: "thick: 3/2", 2.0: "thin, compressible: 2", 3.0: "thin, incompressible: 3"}


def _work(values: Values) -> Work:
    """One unit series per Poisson's ratio serves every q, unless the surface has a tension."""
    qs = values["q"]
    cells = [(nu, beta, group) for nu in values["nu"] for beta in values["beta"]
             for group in ([[q] for q in qs] if beta else [qs])]  # fmt: skip
    return partial(_points, values["base"]), cells


def _points(base: str, cell: tuple[float, float, Sequence[float]]) -> Columns:
    """The points of one Poisson's ratio, in units of h = R = 1 m, E* = 1 Pa.

    The paraboloid's problem is linear in R, so that no small strain is needed.
    """
    nu, beta, qs = cell
    series = _unit_series(nu, base == "bonded", qs, beta * qs[0] ** (1 / 3))
    body = Nonadhesive.of(series, "exact")
    q, P, a, delta = np.transpose([_pull_off(nu, q, AdhesiveCurve(body, q)) for q in qs])
    return rows(nu=nu, base=base, w_R2_over_Estar_h3=q, minus_P_over_pi_w_R=-P / (math.pi * q), a_over_h=a,
                delta_R_over_h2=delta, beta=beta, solved_by=f"jkr {__version__} layered")  # fmt: skip


def _pull_off(nu: float, q: float, curve: AdhesiveCurve) -> tuple[float, float, float, float]:
    point = curve.pull_off(LOAD_CONTROL)
    if isinstance(point, Unknown):
        raise SolveError(f"pull-off map: nu = {nu:g}, q = {q:g}: {point.reason}")
    return q, point.P, point.a, point.delta


def _unit_series(nu: float, bonded: bool, qs: Sequence[float], tension: float) -> Series:
    # From well below to well above a/h at pull-off: (9 pi q/8)^(1/3) for thick layers, for thin ones between
    # (96 q)^(1/6) and (384 q)^(1/6) where they are incompressible, and up to (8 q)^(1/4).
    thick = [(9 * math.pi * q / 8) ** (1 / 3) for q in (qs[0], qs[-1])]
    low, high = 0.4 * min(thick[0], (96 * qs[0]) ** (1 / 6)), 1.5 * min(thick[1], (8 * qs[-1]) ** (1 / 4) + 1)
    if tension:
        low = min(low, 0.5 * wetting_radius(1.0, qs[0], tension))
    count = max(8, math.ceil(TUNING.per_decade * math.log10(high / low)))
    specimen = replace(layer(nu, bonded), surface_tension=tension)
    return series_at(np.geomspace(low, high, count), specimen, Layered(TUNING.tolerance))


def _figure(columns: Columns) -> Figure:
    from ...report import MapPanel, lines_figure

    title = f"layer on a rigid base, {columns['base'][0]}"
    families = {"nu": r"$\nu$ = {:g}".format}
    if columns["beta"].any():
        families["beta"] = r"$\beta$ = {:g}".format
    panel = MapPanel("minus_P_over_pi_w_R", r"pull-off force / $\pi w R$", title, LIMITS, (1.4, 3.15))
    return lines_figure(columns, (Q, r"$w R^2 / (E^* h^3)$"), [panel], families)


MAP = Map(
    "pull-off",
    """Map the pull-off force of a paraboloid on a layer on a rigid base, in pi w R, over w R^2/(E* h^3).

    Exact slopes throughout. Writes pull-off-map.csv, .png and .svg.

    \b
    jkr study pull-off-map --nu 0.3 --nu 0.5 -o map
    jkr study pull-off-map --nu 0.45 --q 0.02 --base frictionless
    jkr study pull-off-map --nu 0.5 --q 1 --q 10 --beta 0 --beta 0.1
    """,
    {
        "nu": Axis((0.3, 0.499), "Repeatable.", POISSON, family=True),
        "base": BASE,
        "q": Axis(tuple((10.0 ** (np.arange(-12, 17) / 4)).tolist()), "Values of w R^2/(E* h^3)",
                  within(1e-6, 1e7), "1e-3 to 1e4"),
        "beta": Axis((0.0,), "Surface tension over E* a0, a0 = (w R^2/E*)^(1/3); repeatable.",
                     within(0.0, 100.0), family=True),
    },
    _work,
    lambda values: len(values["nu"]) * sum(
        TUNING.per_nu + (TUNING.per_tense if beta else TUNING.per_point) * len(values["q"]) for beta in values["beta"]
    ),
    "{base} layer on a rigid base, paraboloid: pull-off force in pi w R",
    [SHOWN_NU, ("beta", "beta", "6g"), SHOWN_Q, ("minus_P_over_pi_w_R", "force", "8.4f"), ("a_over_h", "a/h", "9.4g")],
    _figure,
)  # fmt: skip
