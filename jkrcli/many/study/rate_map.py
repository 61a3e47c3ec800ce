"""The rate map: pull-off force and energy lost over the speed of the device, its stiffness and the body.

Units: R = 1 m, E* = w0 = 1 of a paraboloid, v0 = 1 m/s; a layer of thickness h on a rigid base beside the half-space.
The device goes back from equilibrium at no load.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np

from ...adhesion.curve import AdhesiveCurve
from ...adhesion.nonadhesive import Nonadhesive
from ...adhesion.rate.history import RateContact
from ...adhesion.rate.laws import RateLaw
from ...adhesion.rate.program import Program
from ...adhesion.slopes.choice import slopes
from ...base.arrays import Array
from ...base.errors import InputError, SolveError
from ...base.executors import Pool, in_order
from ...base.unknown import known
from ...bodies.indenters import Paraboloid
from ...bodies.materials import Elastic
from ...bodies.problem import HalfSpace, Layer, Loading, Problem, Rigid, Specimen
from ...methods.closed_form.method import ClosedForm
from ...methods.layered.layered import Layered


@dataclass(frozen=True)
class RateMapTuning:
    """How finely and how far its series go, and what they take."""

    per_decade: int = 40  # choice: of the contact radius; twice as many change the forces by less than 1e-7
    smallest: float = 1e-3  # choice: radius in units of that at no load, where contact is as good as lost
    largest: float = 1.3  # choice: the same, beyond which no path goes
    tolerance: float = 1e-7  # choice: relative, of the layer's series
    per_point: float = 0.075  # CPU seconds; tuned on maps of 13 and 100 speeds, by `make guards`


TUNING = RateMapTuning()


@dataclass(frozen=True)
class RatePoint:
    """One point: ``thickness`` of the layer in radii (infinite: half-space), ``stiffness`` of the device in E* R,
    ``speed`` in v0, ``force`` = -P_min/(pi w0 R), ``energy`` dissipated at the edge over w0 times the area at no load,
    ``error`` relative, of the force."""

    thickness: float
    stiffness: float
    speed: float
    force: float
    energy: float
    error: float


def rate_map(
    law: RateLaw, thicknesses: Sequence[float], nu: float, stiffnesses: Sequence[float], speeds: Sequence[float],
    pool: Pool | None = None,
) -> list[RatePoint]:  # fmt: skip
    """The points for each body, stiffness and speed; InputError where a number is not > 0."""
    for name, values in (("speed", speeds), ("stiffness", stiffnesses), ("thickness", thicknesses)):
        for value in values:
            if not value > 0:
                raise InputError(f"rate map: {name} must be > 0, got {value:g}")
    bodies = list(dict.fromkeys([math.inf, *thicknesses]))
    found = in_order(pool, partial(_body_points, law, nu, stiffnesses, speeds), bodies, "rate map")
    return [point for points in found for point in points]


def forecast(thicknesses: Sequence[float], stiffnesses: Sequence[float], speeds: Sequence[float]) -> float:
    """CPU seconds that the map takes."""
    return TUNING.per_point * (1 + len(thicknesses)) * len(stiffnesses) * len(speeds)


def rate_columns(points: Sequence[RatePoint]) -> dict[str, Array]:
    """The columns of the table by name."""
    return {
        "h_over_R": np.array([point.thickness for point in points]),
        "k_over_Estar_R": np.array([point.stiffness for point in points]),
        "V_over_v0": np.array([point.speed for point in points]),
        "minus_P_over_pi_w0_R": np.array([point.force for point in points]),
        "dissipated_over_w0_pi_a2": np.array([point.energy for point in points]),
        "P_relative_error": np.array([point.error for point in points]),
    }


def _body_points(
    law: RateLaw, nu: float, stiffnesses: Sequence[float], speeds: Sequence[float], thickness: float
) -> list[RatePoint]:
    body, unloaded = _body(thickness, nu)
    return [_point(body, unloaded, law, thickness, k, V) for k in stiffnesses for V in speeds]


def _point(body: Nonadhesive, a: float, law: RateLaw, thickness: float, stiffness: float, speed: float) -> RatePoint:
    contact = RateContact(body, law, 1.0, 1.0, stiffness)
    x = float(contact.edge.held_at(np.array(a), 1.0))
    found = contact.history(Program(np.array([0.0]), np.array([x]), -speed), a)
    error = known(found.error["P"])
    energy = found.dissipated / (math.pi * a**2)
    return RatePoint(thickness, stiffness, speed, -found.pull_off.P / math.pi, energy, error or 0.0)


def _body(thickness: float, nu: float) -> tuple[Nonadhesive, float]:
    """The body in units of R = E* = 1, and the radius at no load with w = 1."""
    a = (4.5 * math.pi) ** (1 / 3)  # of the half-space; that of a layer is smaller
    material = Elastic(1 - nu**2, nu)
    whole = math.isinf(thickness)
    specimen = Specimen((), HalfSpace(material)) if whole else Specimen((Layer(material, thickness),), Rigid(True))
    low, high = TUNING.smallest * a, TUNING.largest * a
    count = math.ceil(TUNING.per_decade * math.log10(high / low))
    loading = Loading.given("radius", tuple(float(r) for r in np.geomspace(low, high, count)))
    method = ClosedForm() if whole else Layered(TUNING.tolerance)
    series = method(Problem(Paraboloid(1.0), specimen, loading)).series
    body = Nonadhesive(series, slopes(series, "exact"))
    radii = AdhesiveCurve(body, 1.0).radii(P=0.0)
    if not radii:
        raise SolveError(f"rate map: no equilibrium without load on a layer of h = {thickness:g} R")
    return body, radii[-1]
