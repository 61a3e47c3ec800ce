"""A map of what sticking changes: S and load of a bonded layer that sticks over those of one that slides, over a/h."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np

from ... import __version__
from ...base.arrays import Array
from ...base.errors import InputError
from ...base.executors import Pool, in_order
from ...bodies.indenters import Paraboloid
from ...bodies.materials import Elastic
from ...bodies.problem import Layer, Loading, Problem, Rigid, Specimen
from ...methods.layered.layered import Layered
from ...series import Series


@dataclass(frozen=True)
class StickingMapTuning:
    """Which part of the map there is, how finely its series are solved, and what that takes."""

    per_decade: int = 20  # choice: of the contact radius, between which loads are interpolated to 1e-4
    beyond: float = 1.2  # of the largest a/h; choice: a stuck contact is wider at equal depth by less
    tolerance: float = 1e-4  # choice: relative, of the series; ratios are told to four digits
    least: float = 1e-2  # choice: a/h where the layer is a half-space
    largest: float = 12.0  # choice: a/h that takes seconds
    per_nu: float = 0.25  # CPU seconds; tuned on maps of 6 and 40 ratios of Poisson, by `make guards`
    per_point: float = 5e-4  # CPU seconds of an a/h; tuned on maps of 1000, by `make guards`


TUNING = StickingMapTuning()


def sticking_map(nus: Iterable[float], ratios: Sequence[float], pool: Pool | None = None) -> dict[str, Array]:
    """Columns of the map: for each Poisson's ratio and each a/h the ratio of S at that radius and that of the load at
    the depth where the sliding contact has that radius. ``pool`` works on the Poisson's ratios (default: this process).

    Errors: InputError for an a/h outside the range.
    """
    wanted = np.array(sorted(set(ratios)))
    if not wanted.size or not TUNING.least <= wanted[0] <= wanted[-1] <= TUNING.largest:
        shown = ", ".join(f"{ratio:g}" for ratio in ratios)
        raise InputError(f"a/h: must be between {TUNING.least:g} and {TUNING.largest:g}, got {shown}")
    each = list(dict.fromkeys(nus))
    rows = np.concatenate(in_order(pool, partial(_rows, wanted), each, "sticking map"), axis=1)
    columns = dict(zip(("nu", "a_over_h", "S_ratio", "load_ratio"), rows, strict=True))
    return columns | {"solved_by": np.full(rows.shape[1], f"jkr {__version__} layered")}


def forecast(nus: Sequence[float], ratios: Sequence[float]) -> float:
    """CPU seconds that the map takes."""
    return len(nus) * (TUNING.per_nu + TUNING.per_point * len(ratios))


def _rows(wanted: Array, nu: float) -> Array:
    """nu, a/h, and both ratios of one Poisson's ratio (4, n), in units of h = R = 1 m, E = 1 Pa."""
    decades = np.log10(TUNING.beyond * wanted[-1] / wanted[0])
    radii = np.geomspace(wanted[0], TUNING.beyond * wanted[-1], max(int(TUNING.per_decade * decades), 8))
    radii = np.unique(np.concatenate([radii, wanted]))
    sliding, sticking = (_series(nu, radii, sticks) for sticks in (False, True))
    at = np.searchsorted(radii, wanted)
    assert sliding.S is not None
    assert sticking.S is not None
    load = _load_at(sticking, sliding.delta[at]) / sliding.P[at]
    return np.array([np.full(wanted.size, nu), wanted, sticking.S[at] / sliding.S[at], load])


def _series(nu: float, radii: Array, sticks: bool) -> Series:
    specimen = Specimen((Layer(Elastic(1.0, nu), 1.0),), Rigid())
    problem = Problem(Paraboloid(1.0), specimen, Loading.given("radius", tuple(radii)), sticks)
    return Layered(TUNING.tolerance)(problem).series


def _load_at(series: Series, depth: Array) -> Array:
    from scipy.interpolate import PchipInterpolator

    ends = np.log(series.delta), np.log(series.P)
    return np.exp(PchipInterpolator(*ends, extrapolate=True)(np.log(depth)))
