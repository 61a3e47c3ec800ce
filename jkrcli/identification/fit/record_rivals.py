"""The rivals of a raw record: what the model leaves out, each as the change of all loads that a little of it makes.

``RIVALS`` is the list: an entry is a name, its family, what its amount is, its effect, and how much of it is likely
before the data. The effect is a change of the model, or a column alone: the derivative of the loads [N] by the amount,
at fixed positions of the device. The data are asked for each by its score (``record_scores``).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np

from ...base import Array, JkrError
from ...bodies import PowerRelaxation, StandardSolid
from .fitted_record import FittedRecord
from .positions import creep, hysteresis
from .record_change import AMOUNT, ANY, Change
from .record_rival_adhesion import POWER, finite_range, likely_range, long_range, work_over_radius, work_over_speed
from .record_rival_body import (
    exponent,
    graded,
    layer_below,
    likely_strains,
    likely_tension,
    no_slip,
    poisson,
    quartic,
    strains,
    tension,
    thickness,
)
from .record_rival_device import another_modulus, drift, misplaced_back, slope_at_rest, stiffness
from .record_rival_relaxation import TIME, relaxing


@dataclass(frozen=True)
class RecordRivalTuning:
    """What is known of rivals before the data."""

    cone: float = 3.0  # choice: three times what a cone's exponent differs from a paraboloid's by: one step overshoots
    strains: float = 2.0  # choice: of the effect of large strains on rubber, that of other materials
    device: float = 1.0  # choice: relative, by which a stiffness that someone measured may be off
    shape: float = 0.003  # choice: exponent of the profile within which a tip is what it is called: by as much its
    # radius of curvature changes over a factor e of the contact radius


TUNING = RecordRivalTuning()
BODY, TIP, ADHESION, DEVICE, MEMORY = "layer or base", "shape of the tip", "adhesion", "device", "relaxation or flow"
# What the unknowns of rivals mean, by dimension:
OF_RIVALS = {
    AMOUNT: "number", "thickness": "length", "nu": "number", "exponent": "number", "range": "length",
    "surface_tension": "tension", "stiffness": "stiffness", "fall": "number", TIME: "time", POWER: "number",
    "creep": "number", "hysteresis": "number",
}  # fmt: skip


@dataclass(frozen=True)
class Rival:
    """One thing that the model leaves out. ``family``: what cannot be distinguished from it as a rule; ``amount``: what
    a column is the derivative by, in words; ``effect``: what a fit makes of it: a change, which can be fitted in full,
    or a column alone, of first order; None where the rival has no meaning for this record.

    ``likely``: amount in either direction that is expected unless the user or the data say otherwise: 0 of what the
    description of the body rules out; ``limits``: least and largest amounts that any body, tip or device has.
    ``of_directions``: whether it sets one direction against the other.
    """

    name: str
    family: str
    amount: str
    effect: Callable[[FittedRecord], Change | Array | None]
    likely: float | Callable[[FittedRecord], float] = 0.0
    limits: tuple[float, float] = ANY
    of_directions: bool = False

    def likely_in(self, record: FittedRecord) -> float:
        """The amount in either direction that is likely in a record."""
        return self.likely(record) if callable(self.likely) else self.likely


POSITIVE = (0.0, math.inf)
RANGE = Rival("adhesion of finite range", ADHESION, "square of the range over that of a narrow ring", finite_range,
              likely_range, POSITIVE)  # fmt: skip
LONG = Rival("adhesion of long range (DMT)", ADHESION, "from JKR to DMT", long_range, limits=(0.0, 1.0))
TENSION = Rival("surface tension", BODY, "2 tension/E* over the contact radius", tension, likely_tension, POSITIVE)
RIVALS: tuple[Rival, ...] = (
    Rival("w over the contact radius", ADHESION, "relative rise towards pull-off", work_over_radius),
    Rival("w over the speed of the edge", ADHESION, "relative rise per factor e of the speed", work_over_speed),
    RANGE,
    LONG,
    Rival("a rigid base below", BODY, "contact radius over depth", layer_below),
    Rival("thickness of the layer", BODY, "relative change", thickness),
    Rival("nu of the layer", BODY, "relative change", poisson),
    Rival("moduli that change with the contact radius", BODY, "relative rise", graded),
    Rival("exponent of the tip", TIP, "change of the exponent", exponent, TUNING.shape, (-TUNING.cone, TUNING.cone)),
    Rival("sphere or paraboloid", TIP, "share of the sphere's quartic term", quartic, limits=(-1.0, 1.0)),
    Rival("no slip", BODY, "from none to full", no_slip, 1.0, POSITIVE),
    TENSION,
    Rival("large strains", BODY, "of what is known of them", strains, likely_strains, (0.0, TUNING.strains)),
    Rival("relaxation over a factor of time", MEMORY, "fall per factor e", partial(
        relaxing,
        memory=lambda t: np.log1p(100 * t),
        law=lambda values, duration: PowerRelaxation(duration, values[AMOUNT]),
        search=Change(((0.1,), (0.3,)), limits={AMOUNT: (1e-4, 0.9)}),
    )),
    Rival("relaxation of one time", MEMORY, "fall", partial(
        relaxing,
        memory=lambda t: 1 - np.exp(-4 * t),
        law=lambda values, duration: StandardSolid(1 - values[AMOUNT], duration * values[TIME]),
        search=Change(((0.3, 0.03), (0.3, 0.2), (0.6, 0.5)), (AMOUNT, TIME),
                      {AMOUNT: (1e-4, 0.999), TIME: (1e-3, 10.0)}),
    )),
    Rival("residual depth", MEMORY, "of the depth of contact",
          misplaced_back(lambda record, part: np.full(part.z.size, -record.reach)), of_directions=True),
    Rival("another modulus on the way back", MEMORY, "relative change", another_modulus, of_directions=True),
    Rival("another slope at rest", MEMORY, "relative change", slope_at_rest, of_directions=True),
    Rival("stiffness of the device", DEVICE, "relative change", stiffness, limits=(-TUNING.device, TUNING.device)),
    Rival("creep of the position", DEVICE, "of the travel, per decade of time",
          misplaced_back(lambda record, part: part.travel * creep(record.time(part)), "creep"), of_directions=True),
    Rival("hysteresis of the position", DEVICE, "of the travel, at most",
          misplaced_back(lambda _, part: part.travel * hysteresis(part.way), "hysteresis"), of_directions=True),
    Rival("scale of the position", DEVICE, "retraction against approach",
          misplaced_back(lambda record, part: record.reach * part.way), of_directions=True),
    Rival("drift of the depth", DEVICE, "of the depth over the record", drift, of_directions=True),
)  # fmt: skip


def columns(record: FittedRecord, rivals: Sequence[Rival] = RIVALS) -> dict[Rival, Array]:
    """The columns of all rivals that mean anything for a record, by rival."""
    by_rival = {}
    for rival in rivals:
        try:
            effect = rival.effect(record)
            column = record.column(effect) if isinstance(effect, Change) else effect
        except (JkrError, FloatingPointError):
            continue  # a neighbouring body that cannot be solved is no rival, and takes no fit with it
        if column is not None and np.isfinite(column).all() and column.any():
            by_rival[rival] = column
    return by_rival
