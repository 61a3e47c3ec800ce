"""A map of what no slip changes: S and load of a bonded layer without slip over those without friction, over a/h."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np

from ... import __version__
from ...methods import Layered
from ...report import Figure
from .maps import POISSON, SHOWN_NU, Axis, Columns, Map, Values, Work, layer, rows, series_at, within


@dataclass(frozen=True)
class StickingMapTuning:
    """Which part of the map there is, how finely its series are solved, and what that takes."""

    per_decade: int = 20  # choice: of the contact radius, between which loads are interpolated to 1e-4
    # of the largest a/h; tuned on maps, by `make constants`: a stuck contact is wider at equal depth by less
    beyond: float = 1.2
    # tuned on maps, by `make constants`: relative, of the series; ratios are printed to four digits
    tolerance: float = 1e-4
    per_nu: float = 0.25  # CPU seconds; tuned on maps of 6 and 40 ratios of Poisson, by `make guards`
    per_point: float = 5e-4  # CPU seconds of an a/h; tuned on maps of 1000, by `make guards`


TUNING = StickingMapTuning()


def _rows(ratios: Sequence[float], nu: float) -> Columns:
    """For each a/h the ratio of S at that radius and that of the load at the depth where the sliding contact has that
    radius, in units of h = R = 1 m, E* = 1 Pa."""
    from scipy.interpolate import PchipInterpolator

    wanted = np.array(ratios)
    decades = np.log10(TUNING.beyond * wanted[-1] / wanted[0])
    radii = np.geomspace(wanted[0], TUNING.beyond * wanted[-1], max(int(TUNING.per_decade * decades), 8))
    radii = np.unique(np.concatenate([radii, wanted]))
    sliding, sticking = (series_at(radii, layer(nu), Layered(TUNING.tolerance), sticks) for sticks in (False, True))
    at = np.searchsorted(radii, wanted)
    assert sliding.S is not None
    assert sticking.S is not None
    logs = PchipInterpolator(np.log(sticking.delta), np.log(sticking.P), extrapolate=True)
    load = np.exp(logs(np.log(sliding.delta[at]))) / sliding.P[at]
    return rows(nu=nu, a_over_h=wanted, S_ratio=sticking.S[at] / sliding.S[at], load_ratio=load,
                solved_by=f"jkr {__version__} layered")  # fmt: skip


def _figure(columns: Columns) -> Figure:
    from ...report import MapPanel, lines_figure

    titles = {"S_ratio": "$S$ at equal radius", "load_ratio": "load at equal depth"}
    panels = [MapPanel(name, "no slip / frictionless", title) for name, title in titles.items()]
    return lines_figure(columns, ("a_over_h", "$a / h$"), panels, {"nu": r"$\nu$ = {:g}".format})


def _work(values: Values) -> Work:
    return partial(_rows, values["ratio"]), values["nu"]


MAP = Map(
    "sticking",
    """Map what no slip changes under a paraboloid on a layer that is bonded to a rigid base, over a/h.

    S at equal contact radius, and the load at the depth where the frictionless contact has that radius; no slip
    over frictionless. Writes sticking-map.csv, .png and .svg.

    \b
    jkr study sticking-map -o map
    jkr study sticking-map --nu 0.499 --ratio 3.333
    """,
    {
        "nu": Axis((0.0, 0.3, 0.45, 0.49, 0.499, 0.5), "Repeatable.", POISSON, family=True),
        "ratio": Axis((0.05, 0.1, 0.2, 0.5, 1.0, 2.0, 10 / 3, 5.0, 10.0), "Values of a/h",
                      within(1e-2, 12.0), "0.05 to 10"),
    },
    _work,
    lambda values: len(values["nu"]) * (TUNING.per_nu + TUNING.per_point * len(values["ratio"])),
    "paraboloid on a bonded layer: no slip over frictionless",
    [SHOWN_NU, ("a_over_h", "a/h", "8.4g"), ("S_ratio", "S", "8.4f"), ("load_ratio", "load at equal depth", "20.4f")],
    _figure,
)  # fmt: skip
