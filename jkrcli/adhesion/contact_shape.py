"""Contacts that are no discs: what Eq. 13 with a = sqrt(A/pi) leaves out.

For any contact that only grows, with the nonadhesive load P_1(d_1) and area A(d_1),

    delta = d_1 - sqrt(2 w A'/P_1''),    P = P_1 - P_1' (d_1 - delta)          (Ciavarella, arXiv 1712.05844),

which is Eq. 13: A' = 2 pi a a', P_1'' = S' a'. It is the energy's stationary point among the shapes that the contact
without adhesion goes through. Of elliptic paraboloids on a half-space the pull-off force under load control is too
small by what ``ELLIPSES`` says, beside the least energy over all ellipses (as by Giudici, Vella and Griffiths, arXiv
2407.00378; ``tests/ellipses.py`` computes it); of other shapes neither sign nor size are known: two spots of unequal
height come out 1 to 14 % too large.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..base.errors import InputError, Unknown
from .curve import CONTROLS

# theory: R1/R2 of the radii of curvature; what the least energy over all ellipses changes of the pull-off force, under
# load and under displacement control
ELLIPSES = np.array([
    (1.0, 0.0, 0.0), (1.25, 0.00030, 0.00003), (1.5, 0.00099, 0.00010), (2.0, 0.00284, 0.00024),
    (3.0, 0.00688, 0.00031), (4.0, 0.01057, 0.00005), (6.0, 0.01662, -0.00107), (10.0, 0.02513, -0.00425),
    (17.0, 0.03441, -0.01003), (30.0, 0.04433, -0.01902), (55.0, 0.05459, -0.03131), (100.0, 0.06427, -0.04530),
])  # fmt: skip
BETWEEN = 3e-4  # theory: of the pull-off force, by which lines between these ratios err at most
DISC, ANY, ELLIPSE = "disc", "any", "ellipse="


@dataclass(frozen=True)
class ContactShape:
    """A contact that is no disc: the ellipse of tips of ``ratio`` R1/R2, None for any other; ``half_space``: on one."""

    ratio: float | None
    half_space: bool

    @classmethod
    def of(cls, facts: Mapping[str, Any], half_space: bool) -> ContactShape | None:
        """That of a solution by its ``facts``; None for a disc."""
        name = facts.get("contact_shape", DISC)
        return None if name == DISC else cls(ratio_of(name), half_space)

    def change(self, stiffness: float) -> tuple[float, float] | Unknown:
        """What other shapes of the contact change of the pull-off force under a device of a ``stiffness`` [N/m]: the
        least and the largest relative change; of a spring as far as under either control."""
        if self.ratio is None:
            return Unknown("sign and size not known, as of every contact that is neither a disc nor an ellipse")
        if not self.half_space:
            return Unknown("not known: it is known of ellipses on a half-space")
        x = np.log(ELLIPSES[:, 0])
        both = [float(np.interp(math.log(self.ratio), x, column)) for column in ELLIPSES[:, 1:].T]
        ends = both[:1] if stiffness == 0 else both[1:] if math.isinf(stiffness) else both
        margin = BETWEEN if self.ratio > 1 else 0.0
        return min(0.0, *ends) - margin, max(0.0, *ends) + margin

    def words(self, controls: Mapping[str, float] = CONTROLS) -> str:
        """What is known, by the names of ``controls`` with their stiffnesses [N/m]."""
        found = {name: self.change(stiffness) for name, stiffness in controls.items()}
        known = [f"{100 * one[0]:+.2g} to {100 * one[1]:+.2g} % ({name})" for name, one in found.items()
                 if not isinstance(one, Unknown)]  # fmt: skip
        what = "any" if self.ratio is None else f"ellipse, R1/R2 = {self.ratio:g}"
        shapes = f"contact shape {what}: what other shapes change of the pull-off force"
        return f"{shapes}: {', '.join(known) or self.change(0.0)}"

    def summary(self) -> dict[str, Any]:
        """The shape, and what is not known of it."""
        found = {name: self.change(stiffness) for name, stiffness in CONTROLS.items()}
        return {
            "shape": "any" if self.ratio is None else "ellipse",
            "radii_ratio": self.ratio,
            "pull_off_change": {name: None if isinstance(one, Unknown) else list(one) for name, one in found.items()},
            "reason": str(found["load"]) if isinstance(found["load"], Unknown) else "",
        }


def ratio_of(name: str) -> float | None:
    """R1/R2 of "ellipse=4"; None for "any"; ValueError with what it must be."""
    if name in (DISC, ANY):
        return None
    try:
        ratio = float(name.removeprefix(ELLIPSE)) if name.startswith(ELLIPSE) else math.nan
    except ValueError:
        ratio = math.nan
    if not 1 <= ratio <= ELLIPSES[-1, 0]:
        raise ValueError(f'must be disc, any or ellipse=R1/R2 with a ratio from 1 to {ELLIPSES[-1, 0]:g}, got "{name}"')
    return ratio


def refuse_no_disc(facts: Mapping[str, Any], what: str) -> None:
    """InputError where the contact is no disc, of ``what`` is solved for discs alone."""
    if facts.get("contact_shape", DISC) != DISC:
        raise InputError(f"{what}: is solved for contacts that are discs, this one is {facts['contact_shape']}")
