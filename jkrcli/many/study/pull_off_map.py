"""The pull-off map: how far a layer's pull-off force lies from the half-space's, over how strongly it adheres.

For a paraboloid on one layer on a rigid base, -P_min/(pi w R) under load control depends on Poisson's ratio, the base
and q = w R^2/(E* h^3) alone: 3/2 for thick layers (small q), 2 for thin compressible, 3 for thin incompressible ones.
Nearly incompressible layers rise above 2 and come back to it (nu = 0.45: 2.105 at q = 1e3, 2.027 at 1e6).
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np

from ... import __version__
from ...adhesion.curve import AdhesiveCurve
from ...adhesion.device import LOAD_CONTROL
from ...adhesion.nonadhesive import Nonadhesive
from ...adhesion.slopes.choice import slopes
from ...base.arrays import Array
from ...base.errors import InputError, SolveError
from ...base.executors import Pool, in_order
from ...base.unknown import Unknown
from ...bodies.indenters import Paraboloid
from ...bodies.materials import Elastic
from ...bodies.problem import Layer, Loading, Problem, Rigid, Specimen
from ...formulas.surface_tension import wetting_radius
from ...methods.layered.layered import Layered
from ...series import Series


@dataclass(frozen=True)
class MapTuning:
    """Which part of the map there is, how finely its series are solved, and what that takes."""

    per_decade: int = 40  # choice: of the contact radius; twice as many change the pull-off force by 4e-8
    tolerance: float = 1e-6  # choice: relative, of the series; a/h near 100 at nu = 1/2 leaves 1e-7
    least: float = 1e-6  # choice: q, where a/h at pull-off is 0.015
    largest: float = 1e7  # choice: q, where a/h at pull-off is 90
    per_nu: float = 4e-3  # CPU seconds; tuned on maps of 30 and 300 ratios of Poisson, by `make guards`
    per_tense: float = 0.3  # CPU seconds of a q under surface tension; tuned on maps of 30, by `make guards`
    most_beta: float = 100.0  # choice: beyond, pull-off is pi w R within 1e-4
    per_point: float = 1e-3  # CPU seconds of a q; tuned on maps of 1000, by `make guards`


TUNING = MapTuning()


@dataclass(frozen=True)
class MapPoint:
    """One point of the map: ``force`` = -P_min/(pi w R), ``a_over_h`` and ``delta_R_over_h2`` at pull-off."""

    nu: float
    base: str
    q: float
    force: float
    a_over_h: float
    delta_R_over_h2: float


def pull_off_map(
    nus: Iterable[float], bonded: bool, qs: Sequence[float], pool: Pool | None = None, beta: float = 0.0
) -> list[MapPoint]:
    """The points of the map for each Poisson's ratio and each q (any order, repeated ones once), by exact slopes.

    One unit series per Poisson's ratio serves every q, unless the surface has the tension Ups = ``beta`` E* a0, a0 =
    (w R^2/E*)^(1/3); ``pool`` works on them (default: this process).
    Errors: InputError for q outside the range or nu not allowed.
    """
    wanted = sorted(set(qs))
    if not wanted or not (wanted[0] >= TUNING.least and wanted[-1] <= TUNING.largest):
        raise InputError(
            f"q: must be between {TUNING.least:g} and {TUNING.largest:g}, got {', '.join(f'{q:g}' for q in qs)}"
        )
    if not 0 <= beta <= TUNING.most_beta:
        raise InputError(f"beta: must be between 0 and {TUNING.most_beta:g}, got {beta:g}")
    columns = in_order(pool, partial(_column, bonded, wanted, beta), list(dict.fromkeys(nus)), "pull-off map")
    return [point for column in columns for point in column]


def forecast(nus: Sequence[float], qs: Sequence[float], beta: float = 0.0) -> float:
    """CPU seconds that the map takes."""
    return len(nus) * (TUNING.per_nu + (TUNING.per_tense if beta else TUNING.per_point) * len(qs))


def map_columns(points: Sequence[MapPoint]) -> dict[str, Array]:
    """The columns of the table by name."""
    return {
        "nu": np.array([point.nu for point in points]),
        "base": np.array([point.base for point in points]),
        "w_R2_over_Estar_h3": np.array([point.q for point in points]),
        "minus_P_over_pi_w_R": np.array([point.force for point in points]),
        "a_over_h": np.array([point.a_over_h for point in points]),
        "delta_R_over_h2": np.array([point.delta_R_over_h2 for point in points]),
        "solved_by": np.full(len(points), f"jkr {__version__} layered"),
    }


def _column(bonded: bool, qs: Sequence[float], beta: float, nu: float) -> list[MapPoint]:
    """The points of one Poisson's ratio, in units of h = R = 1 m, E* = 1 Pa.

    The paraboloid's problem is linear in R, so that no small strain is needed.
    """
    if beta:
        return [point for q in qs for point in _points(nu, bonded, [q], beta * q ** (1 / 3))]
    return _points(nu, bonded, qs, 0.0)


def _points(nu: float, bonded: bool, qs: Sequence[float], tension: float) -> list[MapPoint]:
    series = _unit_series(nu, bonded, qs, tension)
    body = Nonadhesive(series, slopes(series, "exact"))
    return [_point(nu, bonded, q, AdhesiveCurve(body, q)) for q in qs]


def _point(nu: float, bonded: bool, q: float, curve: AdhesiveCurve) -> MapPoint:
    point = curve.pull_off(LOAD_CONTROL)
    if isinstance(point, Unknown):
        raise SolveError(f"pull-off map: nu = {nu:g}, q = {q:g}: {point.reason}")
    base = "bonded" if bonded else "frictionless"
    return MapPoint(nu, base, q, -point.P / (math.pi * q), point.a, point.delta)


def _unit_series(nu: float, bonded: bool, qs: Sequence[float], tension: float) -> Series:
    material = Elastic(1 - nu**2 if -1 < nu <= 0.5 else 1.0, nu)
    # From well below to well above a/h at pull-off: (9 pi q/8)^(1/3) for thick layers, for thin ones between
    # (96 q)^(1/6) and (384 q)^(1/6) where they are incompressible, and up to (8 q)^(1/4).
    thick = [(9 * math.pi * q / 8) ** (1 / 3) for q in (qs[0], qs[-1])]
    low, high = 0.4 * min(thick[0], (96 * qs[0]) ** (1 / 6)), 1.5 * min(thick[1], (8 * qs[-1]) ** (1 / 4) + 1)
    if tension:
        low = min(low, 0.5 * wetting_radius(1.0, qs[0], tension))
    count = max(8, math.ceil(TUNING.per_decade * math.log10(high / low)))
    radii = tuple(float(a) for a in np.geomspace(low, high, count))
    specimen = Specimen((Layer(material, 1.0),), Rigid(bonded), surface_tension=tension)
    return Layered(TUNING.tolerance)(Problem(Paraboloid(1.0), specimen, Loading.given("radius", radii))).series
