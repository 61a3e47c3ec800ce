"""The rate map: pull-off force and energy lost over the speed of the device, its stiffness and the body.

Units: R = 1 m, E* = w0 = 1 of a paraboloid, v0 = 1 m/s; a layer of thickness h on a rigid base beside the half-space.
The device goes back from equilibrium at no load.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import partial
from itertools import product
from typing import Any

import numpy as np

from ...adhesion import AdhesiveCurve, Nonadhesive, Program, RateContact, rate_law_of
from ...base import Ranged, SolveError, known
from ...bodies import Elastic, HalfSpace, Specimen
from ...methods import ClosedForm, Layered
from ...report import Figure
from .maps import POISSON, Axis, Columns, Map, Values, Work, layer, rows, series_at


@dataclass(frozen=True)
class RateMapTuning:
    """How finely and how far its series go, and what they take."""

    # tuned on maps, by `make constants`: of the contact radius; twice as many change the forces by less than 1e-7
    per_decade: int = 40
    # tuned on maps, by `make constants`: radius in units of that at no load, where contact is as good as lost
    smallest: float = 1e-3
    largest: float = 1.3  # tuned on maps, by `make constants`: the same, beyond which no path goes
    tolerance: float = 1e-7  # tuned on maps, by `make constants`: relative, of the layer's series
    per_point: float = 0.075  # CPU seconds; tuned on maps of 13 and 100 speeds, by `make guards`


TUNING = RateMapTuning()
POSITIVE = Ranged("number", above=0)


def _work(values: Values) -> Work:
    return partial(_points, values), list(dict.fromkeys([math.inf, *values["thickness"]]))


def _points(values: Values, thickness: float) -> Columns:
    """The points of one body, a layer of this ``thickness`` in radii (infinite: the half-space), over stiffness [E* R]
    and speed [v0] of the device: energy dissipated at the edge over w0 times the area at no load, relative error of the
    force."""
    body, a = _body(thickness, values["nu"])
    devices = list(product(values["stiffness"], values["speed"]))
    k, V = np.transpose(devices)
    force, energy, error = np.transpose([_point(body, a, values["rate"], *device) for device in devices])
    return rows(h_over_R=thickness, k_over_Estar_R=k, V_over_v0=V, minus_P_over_pi_w0_R=force,
                dissipated_over_w0_pi_a2=energy, P_relative_error=error)  # fmt: skip


def _point(body: Nonadhesive, a: float, law: Any, stiffness: float, speed: float) -> tuple[float, float, float]:
    contact = RateContact(body, law, 1.0, 1.0, stiffness)
    x = float(contact.edge.position_at(np.array(a), 1.0))
    history = contact.history(Program.on(x, -speed), a)
    return -history.pull_off.P / math.pi, history.dissipated / (math.pi * a**2), known(history.error["P"]) or 0.0


def _body(thickness: float, nu: float) -> tuple[Nonadhesive, float]:
    """The body in units of R = E* = 1, and the radius at no load with w = 1."""
    a = (4.5 * math.pi) ** (1 / 3)  # of the half-space; that of a layer is smaller
    whole = math.isinf(thickness)
    specimen = Specimen((), HalfSpace(Elastic(1 - nu**2, nu))) if whole else layer(nu, thickness=thickness)
    low, high = TUNING.smallest * a, TUNING.largest * a
    count = math.ceil(TUNING.per_decade * math.log10(high / low))
    method = ClosedForm() if whole else Layered(TUNING.tolerance)
    body = Nonadhesive.of(series_at(np.geomspace(low, high, count), specimen, method), "exact")
    radii = AdhesiveCurve(body, 1.0).radii(P=0.0)
    if not radii:
        raise SolveError(f"rate map: no equilibrium without load on a layer of h = {thickness:g} R")
    return body, radii[-1]


def _stiffness(text: Any) -> float:
    try:
        return math.inf if text == "rigid" else POSITIVE.read(text)
    except ValueError:
        raise ValueError(f'must be a number > 0 in E* R, or "rigid", got "{text}"') from None


def _figure(columns: Columns) -> Figure:
    from ...report import MapPanel, lines_figure

    panels = [MapPanel("minus_P_over_pi_w0_R", r"pull-off force / $\pi w_0 R$", logs="xy"),
              MapPanel("dissipated_over_w0_pi_a2", r"energy lost at the edge / $\pi w_0 a^2$", logs="xy")]  # fmt: skip
    return lines_figure(columns, ("V_over_v0", "speed of the device $V/v_0$"), panels, {
        "h_over_R": lambda h: "half-space" if math.isinf(h) else f"$h$ = {h:g} $R$",
        "k_over_Estar_R": lambda k: "rigid" if math.isinf(k) else f"$k$ = {k:g} $E^* R$",
    })  # fmt: skip


MAP = Map(
    "rate",
    """Map pull-off force and energy lost over the device's speed, its stiffness and the body.

    A paraboloid with E* = R = w0 = v0 = 1 goes back from equilibrium at no load: on a half-space, and beside it on
    bonded layers of the given thickness (in R). Writes rate-map.csv, .png and .svg.

    \b
    jkr study rate-map --rate n=0.6 --thickness 0.3 -o map
    jkr study rate-map --rate law=log,b=0.3 --stiffness rigid --speed 1
    """,
    {
        "rate": Axis({"n": "0.6"}, "The law in units of w0 and v0: n=0.6; law=log,b=0.3.", several=False,
                     read=lambda keys: rate_law_of({"v0": 1.0} | keys, "--rate")),
        "thickness": Axis((0.3,), "Of a bonded layer on a rigid base, in R; repeatable.", POSITIVE, family=True),
        "nu": Axis(0.3, "Poisson's ratio of the layers.", POISSON, several=False),
        "stiffness": Axis(("rigid", "1"), 'Of the device, in E* R; "rigid"; repeatable.', family=True, read=_stiffness),
        "speed": Axis(tuple(10.0 ** (i / 2) for i in range(-8, 5)), "Of the device, in v0", POSITIVE, "1e-4 to 100"),
    },
    _work,
    lambda values: TUNING.per_point * (1 + len(values["thickness"])) * len(values["stiffness"]) * len(values["speed"]),
    "paraboloid, E* = R = w0 = v0 = 1: pull-off force in pi w0 R, energy in w0 pi a^2 at no load",
    [("h_over_R", "h/R", "8.3g"), ("k_over_Estar_R", "k/(E* R)", "9.3g"), ("V_over_v0", "V/v0", "10.4g"),
     ("minus_P_over_pi_w0_R", "force", "9.4f"), ("dissipated_over_w0_pi_a2", "energy", "9.4g")],
    _figure,
)  # fmt: skip
