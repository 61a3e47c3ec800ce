"""Where a device that presses bodies together turns: at a load, at a depth, or at the end of the series."""

from __future__ import annotations

import numpy as np

from ...base.errors import InputError
from ...base.units import show
from ...base.unknown import Unknown
from ..device import position
from ..passage import grow
from ..stability import turning_radius
from .history import RateContact
from .program import Program


def held_at_turn(contact: RateContact, load: float | None, depth: float | None, speed: float) -> float:
    """What the device holds where the approach comes to ``load`` [N] or ``depth`` [m]; both None: to the end of the
    series. ``speed`` of the approach [m/s, under load control N/s], on which it depends where the edge advances by a
    law. InputError where it does not come there."""
    if load is not None and depth is not None:
        raise InputError("cycle: the turn is at a load or at a depth, not at both")
    if contact.law_advance is not None:
        return _of_history(contact, load, depth, speed)
    curve, k = contact.advancing, contact.stiffness
    inwards = grow(curve, k)
    if isinstance(inwards, Unknown):
        raise InputError(f"cycle: {inwards.reason}")
    whole = load is None and depth is None
    point = curve.point(inwards.last if whole else turning_radius(curve, k, load=load, depth=depth))
    return float(position(point.delta, point.P, k))


def _of_history(contact: RateContact, load: float | None, depth: float | None, speed: float) -> float:
    """The position of the device [m] (load [N] under load control) at the turn, where the edge advances by a law of its
    own: read off an approach at ``speed`` at which the ``load`` [N] or the ``depth`` [m] is first held."""
    quantity, value = ("P", load) if depth is None else ("delta", depth)
    if value is None:
        raise InputError("cycle: an edge that advances by a law needs a turn: --to-load or --to-depth")
    approach = contact.history(Program(np.zeros(1), np.array([contact.least]), speed))
    held = approach.first_held(quantity, value)
    if held is None:
        told = show(value, "load" if quantity == "P" else "length")
        raise InputError(f"cycle: the turn at {quantity} = {told} is not passed on approach within the series")
    return held
