"""Which states of an adhesive curve a device passes through as its contact grows, and as it shrinks.

A device of stiffness k prescribes D = delta + P/k (load control: P). At fixed D the contact at radius a is stable where
dD/da > 0, the energy release rate then falls as the contact shrinks (Maugis, J. Phys. D 18 (1985) 293). Growing contact
follows a stable branch up to its maximum of D and jumps at that D to the next one; shrinking contact follows it down to
its minimum of D and jumps to the next smaller stable radius, or, where there is none, lets go.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..base.errors import InputError
from ..base.units import show
from ..base.unknown import Unknown
from .curve import CriticalPoint, EquilibriumCurve
from .device import position


@dataclass(frozen=True)
class Stretch:
    """Stable states passed from one place of a curve to another [m] without a jump; equal ones: none is stable."""

    first: float
    last: float


@dataclass(frozen=True, eq=False)
class Passage:
    """The stretches of ``curve`` that a device of ``stiffness`` [N/m] passes through, in order, jumps between them.

    ``ends``: "series" at the end of the data, "lost" where contact is lost, "jump" where it jumps out of the data.
    """

    curve: EquilibriumCurve
    stiffness: float
    stretches: tuple[Stretch, ...]
    ends: str

    @property
    def last(self) -> float:
        """Place [m] at the end of the path."""
        return self.stretches[-1].last

    def holds(self, a: float) -> bool:
        """Whether the place ``a`` [m] is passed through."""
        return any(min(s.first, s.last) <= a <= max(s.first, s.last) for s in self.stretches)

    def up_to(self, a: float) -> Passage:
        """The path that ends at the place ``a`` [m] on one of its stretches."""
        return Passage(self.curve, self.stiffness, _cut(self.stretches, a), "series")

    def beyond(self, a: float) -> Passage:
        """The path that begins at the place ``a`` [m] on one of its stretches."""
        turned = tuple(Stretch(s.last, s.first) for s in reversed(self.stretches))
        kept = tuple(Stretch(s.last, s.first) for s in reversed(_cut(turned, a)))
        return Passage(self.curve, self.stiffness, kept, self.ends)

    @property
    def work(self) -> float:
        """Work int P dD that the device does along the path [J]; at jumps, D standing still, it does none."""
        return sum(
            work(self.curve, s.first, s.last) + spring(self.curve, self.stiffness, s.first, s.last)
            for s in self.stretches
        )


def grow(curve: EquilibriumCurve, stiffness: float) -> Passage | Unknown:
    """The states passed on approach, from where the free bodies begin to attract each other to the end of the series.

    JKR forces have no range: nothing happens before the undeformed gap closes (D = delta = 0), and there the contact
    spreads to the first stable radius. At w = 0 contact begins at a point and the path at the first radius of the
    series.
    """
    begin = float(curve.places[0]) if curve.w == 0 else _first_contact(curve, stiffness)
    if isinstance(begin, Unknown):
        return begin
    critical = curve.critical(stiffness)
    stretches = []
    while True:
        top = next((point for point in critical if point.kind == "maximum" and point.place > begin), None)
        stretches.append(Stretch(begin, float(curve.places[-1]) if top is None else top.place))
        if top is None:
            return Passage(curve, stiffness, tuple(stretches), "series")
        valley = next((point.place for point in critical if point.place > top.place), np.inf)
        landings = [a for a in _same_position(curve, stiffness, top.place) if a > valley]
        if not landings:
            return Passage(curve, stiffness, tuple(stretches), "jump")
        begin = landings[0]


def shrink(curve: EquilibriumCurve, stiffness: float, begin: float) -> Passage:
    """The states passed on retraction from the place ``begin`` [m] on, stable there or not.

    Contact is lost only where the free bodies do not attract each other (without range: overlap, D > 0): else a smaller
    contact outside the data remains.
    """
    critical = curve.critical(stiffness)
    stretches = []
    while True:
        bottom = _bottom(curve, stiffness, critical, begin)
        stretches.append(Stretch(begin, float(curve.places[0]) if bottom is None else bottom))
        if bottom is None:
            return Passage(curve, stiffness, tuple(stretches), "lost" if curve.complete else "series")
        hill = max((point.place for point in critical if point.place < bottom), default=None)
        landings = [] if hill is None else [a for a in _same_position(curve, stiffness, bottom) if a < hill]
        if not landings:
            released = position(*curve.at(np.array(bottom)), stiffness) <= held_by_free(curve, stiffness)
            return Passage(curve, stiffness, tuple(stretches), "lost" if released else "jump")
        begin = landings[-1]


def largest_stable(curve: EquilibriumCurve, stiffness: float) -> float | None:
    """The largest place [m] of the curve from which a device can retract; None where no branch in it is stable."""
    if _rate(curve, stiffness, float(curve.places[-1])) > 0:
        return float(curve.places[-1])
    maxima = [point.place for point in curve.critical(stiffness) if point.kind == "maximum"]
    return max(maxima, default=None)


def work(curve: EquilibriumCurve, first: float, last: float) -> float:
    """Work int P d(delta) [J] along the curve between two of its places [m]."""
    return curve.work(first, last) if last >= first else -curve.work(last, first)


def spring(curve: EquilibriumCurve, stiffness: float, first: float, last: float) -> float:
    """Energy [J] that the device's own spring takes up between two places [m]; none in a rigid one."""
    if np.isinf(stiffness):
        return 0.0
    P = curve.at(np.array([first, last]))[1]
    return float(P[1] ** 2 - P[0] ** 2) / (2 * stiffness)


def _cut(stretches: tuple[Stretch, ...], a: float) -> tuple[Stretch, ...]:
    for i, s in enumerate(stretches):
        if min(s.first, s.last) <= a <= max(s.first, s.last):
            return (*stretches[:i], Stretch(s.first, a))
    raise InputError(f"cycle: the turn at a = {show(a, 'length')} is not passed by stable contact on approach")


def held_by_free(curve: EquilibriumCurve, stiffness: float) -> float:
    """What a device holds as the free bodies begin to attract each other."""
    return float(position(curve.onset, 0.0, stiffness))


def _first_contact(curve: EquilibriumCurve, stiffness: float) -> float | Unknown:
    held = held_by_free(curve, stiffness)
    if not curve.complete and position(*curve.at(curve.places[:1]), stiffness)[0] > held:
        smallest = float(curve.contact_radii(curve.places[:1])[0])
        if curve.ranged:
            return Unknown(f"the surfaces leap together to contact radii below {show(smallest, 'length')}, where the "
                           "curve begins")  # fmt: skip
        return Unknown(
            f"contact at delta = 0 settles below the smallest radius of the series, a = {smallest:.4g} m: "
            "the series would have to begin at a smaller radius"
        )
    radii = curve.radii_at(held, stiffness)
    if curve.complete:  # bodies that only begin to attract each other may fall together
        radii = tuple(place for place in radii if _rate(curve, stiffness, place) > 0)
    if not radii:
        where = f"delta = {curve.onset:.4g}{' m' if curve.onset else ''}"
        largest = curve.contact_radii(curve.places[-1:])[0]
        return Unknown(
            f"contact at {where} spreads beyond the largest radius of the series, a = {largest:.4g} m: "
            "the series would have to reach a larger radius: increase [loading] radius"
        )
    return radii[0]


def _bottom(
    curve: EquilibriumCurve, stiffness: float, critical: tuple[CriticalPoint, ...], begin: float
) -> float | None:
    """Where the stable branch that ``begin`` lies on ends below; ``begin`` itself where it is not stable."""
    below = [point for point in critical if point.place <= begin]
    if any(point.place == begin and point.kind == "minimum" for point in below):
        return begin
    if not any(point.place == begin for point in below) and _rate(curve, stiffness, begin) <= 0:
        return begin
    return max((point.place for point in below if point.kind == "minimum"), default=None)


def _same_position(curve: EquilibriumCurve, stiffness: float, a: float) -> tuple[float, ...]:
    return curve.radii_at(float(position(*curve.at(np.array(a)), stiffness)), stiffness)


def _rate(curve: EquilibriumCurve, stiffness: float, a: float) -> float:
    return float(position(*curve.rates(np.array(a)), stiffness))
