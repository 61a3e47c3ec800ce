"""The adhesion map of Johnson and Greenwood (J. Colloid Interface Sci. 192 (1997) 326) for a layer: which model holds.

Over mu = sigma (R/(E*^2 w))^(1/3) and the load in pi w R, by the contact that carries the load with adhesion of finite
range, of radius a: delta_a = delta_H(a) - delta is what adhesion adds to the elastic displacement, and (P_H(a) - P)/P_H
what it adds to the load. Hertz: that part is small; rigid (Bradley): elastic displacements are small against the range;
DMT: those of adhesion are; JKR: they are many times the range; else Maugis' transition.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from functools import partial

import numpy as np

from ...adhesion import FiniteRangeBody, FiniteRangeCurve, Range, transform
from ...base import MOST_STEPS, Array, JkrError, Ranged, SolveError
from ...bodies import Loading, Paraboloid, Problem, Specimen
from ...methods import AttractedBody, Layered
from ...report import Figure
from ...series import Series
from .maps import BASE, POISSON, Axis, Columns, Map, Values, Work, layer, rows, within


@dataclass(frozen=True)
class ZoneTuning:
    """Where one model ends, which part of the map there is, and what it takes."""

    little: float = 0.05  # theory: Johnson and Greenwood (1997): what is left out of a model
    many: float = 20.0  # theory: the same, of delta_a over the range, above which JKR holds
    points: int = 80  # tuned on maps, by `make constants`: contact radii of a curve; more are added where it bends
    beyond: float = 1.2  # tuned on maps, by `make constants`: of the largest load, to which the body is solved
    further: float = 1.6  # tuned on maps, by `make constants`: of the load without adhesion from one solve to the next
    per_mu: float = 0.065  # CPU seconds; tuned on maps of 29 and 200 ranges, by `make guards`


TUNING = ZoneTuning()
ZONES = ("Hertz", "JKR", "Maugis", "DMT", "rigid")


def _work(values: Values) -> Work:
    """One body serves all ranges, in units of h = R = 1 m, E* = 1 Pa."""
    q = values["q"]
    problem, series = _reaching(
        layer(values["nu"], values["base"] == "bonded"), q, TUNING.beyond * values["load"][-1] * math.pi * q
    )
    body = FiniteRangeBody(problem, series, AttractedBody(problem))
    return partial(_row, body, values), values["mu"]


def _row(body: FiniteRangeBody, values: Values, mu: float) -> Columns:
    """The contacts of one range on a ``body`` that carry the loads: a over h, ``adhesive`` = delta_a and ``elastic`` =
    delta_H, both over the range, ``share`` = (P_H - P)/P_H, and which model holds."""
    nu, q, loads = values["nu"], values["q"], np.array(values["load"])
    try:
        a, adhesive, elastic, share = _carried(body.curve(Range.of(q, stress=mu * q ** (1 / 3))), loads * math.pi * q)
    except JkrError as error:
        raise SolveError(f"adhesion map: nu = {nu:g}, q = {q:g}, mu = {mu:g}: {error}") from None
    return rows(nu=nu, base=values["base"], w_R2_over_Estar_h3=q, mu=mu, load_over_pi_w_R=loads, a_over_h=a,
                adhesive_over_range=adhesive, elastic_over_range=elastic, adhesive_share=share,
                zone=np.array(ZONES)[_zone(adhesive, elastic, share)])  # fmt: skip


def _zone(adhesive: Array, elastic: Array, share: Array) -> Array:
    """Which of ``ZONES`` a contact lies in (Johnson and Greenwood)."""
    small, rigid = adhesive <= TUNING.little, np.maximum(elastic, adhesive) <= TUNING.little
    inside = np.where(adhesive >= TUNING.many, 1, np.where(rigid, 4, np.where(small, 3, 2)))
    return np.where(share <= TUNING.little, 0, inside)


def _reaching(specimen: Specimen, w: float, load: float) -> tuple[Problem, Series]:
    """The series without adhesion to the radius at which JKR carries the ``load`` [N]."""
    plain = load
    for _ in range(MOST_STEPS):
        problem = Problem(Paraboloid(1.0), specimen, Loading("load", plain, TUNING.points))
        series = Layered()(problem).series
        if transform(series, "exact", w).P[-1] > load:
            break
        plain *= TUNING.further
    return problem, series


def _carried(curve: FiniteRangeCurve, loads: Array) -> Array:
    """Contact radius, delta_a and delta_H over the range, and the adhesive share, of the contacts that carry ``loads``
    [N], (4, loads); stable ones under load control, whose load rises with the radius."""
    touching, parts = curve.touching, curve.parts
    stable = slice(int(np.argmin(touching.P)), None)
    delta_H, P_H = parts.delta_H[stable], parts.P_H[stable]
    added, share = delta_H - touching.delta[stable], P_H - touching.P[stable]
    columns = (touching.a[stable], added / curve.law.length, delta_H / curve.law.length, share, P_H)
    a, adhesive, elastic, lost, plain = (np.interp(loads, touching.P[stable], column) for column in columns)
    return np.stack([a, adhesive, elastic, lost / plain])


def _shown(columns: Columns) -> Iterator[str]:
    """A line for each load, a letter for each range."""
    yield "  load over pi w R | mu: " + ", ".join(f"{mu:.3g}" for mu in np.unique(columns["mu"]))
    for load in np.unique(columns["load_over_pi_w_R"])[::-1]:
        row = columns["zone"][columns["load_over_pi_w_R"] == load]
        yield f"  {load:>16.3g} | {''.join(zone[0] for zone in row)}"
    yield "  " + ", ".join(f"{zone[0]}: {zone}" for zone in ZONES)


def _figure(columns: Columns) -> Figure:
    from ...report import zones_figure

    return zones_figure(columns, ZONES)


MAP = Map(
    "adhesion",
    """Map which model of adhesion holds for a paraboloid on a layer on a rigid base: Hertz, JKR, DMT, rigid bodies, or
    the transition that needs a finite range.

    After Johnson and Greenwood: 5 % is little, 20 times the range is far. Writes adhesion-map.csv, .png and .svg.

    \b
    jkr study adhesion-map --nu 0.499 --q 100 -o map
    """,
    {
        "nu": Axis(0.499, "", POISSON, several=False),
        "base": BASE,
        "q": Axis(1.0, "w R^2/(E* h^3); 1e-4: a half-space.", Ranged("number", above=0), several=False),
        "mu": Axis(tuple(np.geomspace(0.02, 50, 29).tolist()), "Values of stress (R/(E*^2 w))^(1/3)",
                   within(0.01, 100.0), "29 from 0.02 to 50"),
        "load": Axis(tuple(np.geomspace(0.1, 100, 31).tolist()), "Loads over pi w R",
                      within(1e-3, 1e3), "31 from 0.1 to 100"),
    },
    _work,
    lambda values: TUNING.per_mu * len(values["mu"]),
    "{base} layer on a rigid base, paraboloid, nu = {nu:g}, w R^2/(E* h^3) = {q:g}: what holds",
    _shown,
    _figure,
    order="load_over_pi_w_R",
)  # fmt: skip
