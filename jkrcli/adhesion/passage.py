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
from .curve import AdhesiveCurve, CriticalPoint
from .device import position

GAUSS_X, GAUSS_W = np.polynomial.legendre.leggauss(8)


@dataclass(frozen=True)
class Stretch:
    """Stable states passed from contact radius ``first`` to ``last`` [m] without a jump; equal: none is stable."""

    first: float
    last: float


@dataclass(frozen=True, eq=False)
class Passage:
    """The stretches of ``curve`` that a device of ``stiffness`` [N/m] passes through, in order, jumps between them.

    ``ends``: "series" at the end of the data, "lost" where contact is lost, "jump" where it jumps out of the data.
    """

    curve: AdhesiveCurve
    stiffness: float
    stretches: tuple[Stretch, ...]
    ends: str

    @property
    def last(self) -> float:
        """Contact radius [m] at the end of the path."""
        return self.stretches[-1].last

    def holds(self, a: float) -> bool:
        """Whether the contact radius ``a`` [m] is passed through."""
        return any(min(s.first, s.last) <= a <= max(s.first, s.last) for s in self.stretches)

    def up_to(self, a: float) -> Passage:
        """The path that ends at the contact radius ``a`` [m] on one of its stretches."""
        return Passage(self.curve, self.stiffness, _cut(self.stretches, a), "series")

    def beyond(self, a: float) -> Passage:
        """The path that begins at the contact radius ``a`` [m] on one of its stretches."""
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


def grow(curve: AdhesiveCurve, stiffness: float) -> Passage | Unknown:
    """The states passed on approach, from where the undeformed gap closes (D = delta = 0) to the end of the series.

    JKR forces have no range: nothing happens before, and there the contact spreads to the first stable radius. At
    w = 0 contact begins at a point and the path at the first radius of the series.
    """
    begin = float(curve.a[0]) if curve.w == 0 else _first_contact(curve, stiffness)
    if isinstance(begin, Unknown):
        return begin
    critical = curve.critical(stiffness)
    stretches = []
    while True:
        top = next((point for point in critical if point.kind == "maximum" and point.a > begin), None)
        stretches.append(Stretch(begin, float(curve.a[-1]) if top is None else top.a))
        if top is None:
            return Passage(curve, stiffness, tuple(stretches), "series")
        valley = next((point.a for point in critical if point.a > top.a), np.inf)
        landings = [a for a in _same_position(curve, stiffness, top.a) if a > valley]
        if not landings:
            return Passage(curve, stiffness, tuple(stretches), "jump")
        begin = landings[0]


def shrink(curve: AdhesiveCurve, stiffness: float, begin: float) -> Passage:
    """The states passed on retraction from the contact radius ``begin`` [m] on, stable there or not.

    Contact is lost at D <= 0 only: above, the free bodies would overlap, so a smaller contact outside the data remains.
    """
    critical = curve.critical(stiffness)
    stretches = []
    while True:
        bottom = _bottom(curve, stiffness, critical, begin)
        stretches.append(Stretch(begin, float(curve.a[0]) if bottom is None else bottom))
        if bottom is None:
            return Passage(curve, stiffness, tuple(stretches), "series")
        hill = max((point.a for point in critical if point.a < bottom), default=0.0)
        landings = [a for a in _same_position(curve, stiffness, bottom) if a < hill]
        if not landings:
            released = position(*curve.at(np.array(bottom)), stiffness) <= 0
            return Passage(curve, stiffness, tuple(stretches), "lost" if released else "jump")
        begin = landings[-1]


def largest_stable(curve: AdhesiveCurve, stiffness: float) -> float | None:
    """The largest radius [m] of the series from which a device can retract; None where no branch in it is stable."""
    if _rate(curve, stiffness, float(curve.a[-1])) > 0:
        return float(curve.a[-1])
    maxima = [point.a for point in curve.critical(stiffness) if point.kind == "maximum"]
    return max(maxima, default=None)


def work(curve: AdhesiveCurve, first: float, last: float) -> float:
    """Work int P d(delta) [J] along the curve between two contact radii [m]: Gauss in log a between the data."""
    low, high = min(first, last), max(first, last)
    edges = np.log(np.concatenate([[low], curve.a[(curve.a > low) & (curve.a < high)], [high]]))
    half = np.diff(edges)[:, None] / 2
    a = np.clip(np.exp(edges[:-1, None] + half * (1 + GAUSS_X)), low, high)
    total = float(np.sum(half * GAUSS_W * a * curve.at(a)[1] * curve.rates(a)[0]))
    return total if last >= first else -total


def spring(curve: AdhesiveCurve, stiffness: float, first: float, last: float) -> float:
    """Energy [J] that the device's own spring takes up between two contact radii [m]; none in a rigid one."""
    if np.isinf(stiffness):
        return 0.0
    P = curve.at(np.array([first, last]))[1]
    return float(P[1] ** 2 - P[0] ** 2) / (2 * stiffness)


def _cut(stretches: tuple[Stretch, ...], a: float) -> tuple[Stretch, ...]:
    for i, s in enumerate(stretches):
        if min(s.first, s.last) <= a <= max(s.first, s.last):
            return (*stretches[:i], Stretch(s.first, a))
    raise InputError(f"cycle: the turn at a = {show(a, 'length')} is not passed by stable contact on approach")


def _first_contact(curve: AdhesiveCurve, stiffness: float) -> float | Unknown:
    if position(*curve.at(curve.a[:1]), stiffness)[0] > 0:
        return Unknown(
            f"contact at delta = 0 settles below the smallest radius of the series, a = {curve.a[0]:.4g} m: "
            "the series would have to begin at a smaller radius"
        )
    radii = curve.radii_at(0.0, stiffness)
    if not radii:
        return Unknown(
            f"contact at delta = 0 spreads beyond the largest radius of the series, a = {curve.a[-1]:.4g} m: "
            "the series would have to reach a larger radius: load further"
        )
    return radii[0]


def _bottom(curve: AdhesiveCurve, stiffness: float, critical: tuple[CriticalPoint, ...], begin: float) -> float | None:
    """Where the stable branch that ``begin`` lies on ends below; ``begin`` itself where it is not stable."""
    below = [point for point in critical if point.a <= begin]
    if any(point.a == begin and point.kind == "minimum" for point in below):
        return begin
    if not any(point.a == begin for point in below) and _rate(curve, stiffness, begin) <= 0:
        return begin
    return max((point.a for point in below if point.kind == "minimum"), default=None)


def _same_position(curve: AdhesiveCurve, stiffness: float, a: float) -> tuple[float, ...]:
    return curve.radii_at(float(position(*curve.at(np.array(a)), stiffness)), stiffness)


def _rate(curve: AdhesiveCurve, stiffness: float, a: float) -> float:
    return float(position(*curve.rates(np.array(a)), stiffness))
