"""The adhesion map of Johnson and Greenwood (J. Colloid Interface Sci. 192 (1997) 326) for a layer: which model holds.

Over mu = sigma (R/(E*^2 w))^(1/3) and the load in pi w R, by the contact that carries the load with adhesion of finite
range, of radius a: delta_a = delta_H(a) - delta is what adhesion adds to the elastic displacement, and (P_H(a) - P)/P_H
what it adds to the load. Hertz: that part is small; rigid (Bradley): elastic displacements are small against the range;
DMT: those of adhesion are; JKR: they are many times the range; else Maugis' transition.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np

from ...adhesion.curve import transform
from ...adhesion.finite_range import FiniteRangeBody, FiniteRangeCurve
from ...adhesion.law import Range
from ...adhesion.slopes.choice import slopes
from ...base.arrays import Array
from ...base.errors import InputError, JkrError, SolveError
from ...base.executors import Pool, in_order
from ...bodies.indenters import Paraboloid
from ...bodies.materials import Elastic
from ...bodies.problem import Layer, Loading, Problem, Rigid, Specimen
from ...methods.attraction import AttractedBody
from ...methods.layered.layered import Layered
from ...series import Series


@dataclass(frozen=True)
class ZoneTuning:
    """Where one model ends, which part of the map there is, and what it takes."""

    little: float = 0.05  # theory: Johnson and Greenwood (1997): what is left out of a model
    many: float = 20.0  # theory: the same, of delta_a over the range, above which JKR holds
    points: int = 80  # choice: contact radii of a curve; more are added where it bends
    beyond: float = 1.2  # choice: of the largest load, to which the body is solved
    further: float = 1.6  # choice: of the load without adhesion from one solve to the next
    attempts: int = 30  # choice: guard
    least_mu: float = 0.01  # choice: below, all is rigid
    largest_mu: float = 100.0  # choice: above, all is JKR or Hertz
    largest_load: float = 1000.0  # choice: over pi w R
    per_mu: float = 0.065  # CPU seconds; tuned on maps of 29 and 200 ranges, by `make guards`


TUNING = ZoneTuning()
ZONES = ("Hertz", "JKR", "Maugis", "DMT", "rigid")


@dataclass(frozen=True, eq=False)
class AdhesionMap:
    """Arrays (loads, mus): ``a`` over h, ``adhesive`` = delta_a and ``elastic`` = delta_H, both over the range,
    ``share`` = (P_H - P)/P_H; ``zone``: index in ``ZONES``."""

    nu: float
    base: str
    q: float
    mus: Array
    loads: Array
    a: Array
    adhesive: Array
    elastic: Array
    share: Array

    @property
    def zone(self) -> Array:
        small, rigid = self.adhesive <= TUNING.little, np.maximum(self.elastic, self.adhesive) <= TUNING.little
        inside = np.where(self.adhesive >= TUNING.many, 1, np.where(rigid, 4, np.where(small, 3, 2)))
        found: Array = np.where(self.share <= TUNING.little, 0, inside)
        return found

    def columns(self) -> dict[str, Array]:
        """The columns of the table by name, a row for each load and range."""
        mu, load = np.meshgrid(self.mus, self.loads)
        same = {"nu": self.nu, "base": self.base, "w_R2_over_Estar_h3": self.q}
        told = {"mu": mu, "load_over_pi_w_R": load, "a_over_h": self.a, "adhesive_over_range": self.adhesive,
                "elastic_over_range": self.elastic, "adhesive_share": self.share}  # fmt: skip
        fixed = {name: np.full(mu.size, value) for name, value in same.items()}
        zone = np.array(ZONES)[self.zone].ravel()
        return fixed | {name: values.ravel() for name, values in told.items()} | {"zone": zone}


def adhesion_map(
    nu: float, bonded: bool, q: float, mus: Sequence[float], loads: Sequence[float], pool: Pool | None = None
) -> AdhesionMap:
    """The map of one layer on a rigid base with q = w R^2/(E* h^3), in units of h = R = 1 m, E* = 1 Pa.

    ``pool`` works on the ranges (default: this process).
    """
    _within("mu", mus, TUNING.least_mu, TUNING.largest_mu)
    _within("load", loads, 1 / TUNING.largest_load, TUNING.largest_load)
    sorted_mus, sorted_loads = np.unique(mus), np.unique(loads)
    specimen = Specimen((Layer(Elastic(1 - nu**2, nu), 1.0),), Rigid(bonded))
    unit = math.pi * q
    problem, series = _reaching(specimen, q, TUNING.beyond * float(sorted_loads[-1]) * unit)
    body = FiniteRangeBody(problem, series, AttractedBody(problem))
    rows = in_order(pool, partial(_row, body, nu, q, sorted_loads * unit), sorted_mus.tolist(), "adhesion map")
    base = "bonded" if bonded else "frictionless"
    return AdhesionMap(nu, base, q, sorted_mus, sorted_loads, *np.moveaxis(np.array(rows), 1, 0).swapaxes(1, 2))


def forecast(mus: Sequence[float]) -> float:
    """CPU seconds that the map takes."""
    return TUNING.per_mu * len(mus)


def _row(body: FiniteRangeBody, nu: float, q: float, loads: Array, mu: float) -> Array:
    """What ``_carried`` finds of one range on a ``body``."""
    try:
        return _carried(body.curve(Range.of(q, stress=mu * q ** (1 / 3))), loads)
    except JkrError as error:
        raise SolveError(f"adhesion map: nu = {nu:g}, q = {q:g}, mu = {mu:g}: {error}") from None


def _reaching(specimen: Specimen, w: float, load: float) -> tuple[Problem, Series]:
    """The series without adhesion to the radius at which JKR carries the ``load`` [N]."""
    plain = load
    for _ in range(TUNING.attempts):
        problem = Problem(Paraboloid(1.0), specimen, Loading("load", plain, TUNING.points))
        series = Layered()(problem).series
        if transform(series, slopes(series, "exact"), w).P[-1] > load:
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


def _within(name: str, values: Sequence[float], low: float, high: float) -> None:
    if not values or not (low <= min(values) and max(values) <= high):
        raise InputError(f"{name}: must be between {low:g} and {high:g}, got {[float(v) for v in values]}")
