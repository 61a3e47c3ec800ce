"""The zone at a moving edge in which adhesion dissipates: how wide it is, and what follows from that."""

import math
from dataclasses import dataclass

from ..adhesion.validity import LIMITS, NO_LAYER, SMALL
from ..base.errors import Estimate, Unknown
from ..base.units import show

NEGLECTED = (
    "the bulk is taken as elastic: all that is lost is lost at the edge; a bulk that relaxes as slowly as the contact "
    "is held, inertia and the viscosity of the bulk are left out"
)


@dataclass(frozen=True)
class Zone:
    """The dissipating zone at the edge: its ``width`` [m], and over the contact radius and the layer's thickness."""

    width: Estimate
    over_a: Estimate
    over_h: Estimate

    @property
    def words(self) -> str:
        """The width of the zone and its share of contact radius and layer in a line, or why it is unknown."""
        if isinstance(self.width, Unknown):
            return f"unknown: {self.width}"
        shares = ((self.over_a, "the contact radius"), (self.over_h, "the layer's thickness"))
        over_sizes = " and ".join(f"{share:.2g} of {name}" for share, name in shares if isinstance(share, float))
        return f"{show(self.width, 'length', 2)}, {over_sizes}"

    @property
    def warnings(self) -> list[str]:
        """A sentence for each ratio that is too large."""
        return [
            f"the dissipating zone at the edge is {value:.2g} of the {name}, more than {SMALL:g}: the theory "
            "of a sharp edge does not hold"
            for name, value in (("contact radius", self.over_a), ("layer's thickness", self.over_h))
            if isinstance(value, float) and value > SMALL
        ]


def zone(G: float, w0: float, E_star: float, a: float, h: float, stress: float | None, z0: float | None) -> Zone:
    """The zone at energy release rate ``G`` [J/m^2] and radius ``a`` [m]: Dugdale's, pi E* G/(4 sigma^2).

    K^2 = 2 E* G at the edge of a rigid indenter's contact, and the zone pi K^2/(8 sigma^2) (Dugdale, J. Mech. Phys.
    Solids 8 (1960) 100). ``stress``: the cohesive stress sigma [Pa], else that of ``w0`` over the range ``z0`` [m]; a
    lower limit where the zone is one of slow bonds or of a viscous tip. ``h``: thickness [m], infinite for a
    half-space.
    """
    if stress is None and z0 is None:
        none = Unknown("no cohesive stress or range of adhesion is known: --stress")
        return Zone(none, none, none)
    sigma = stress if stress is not None else w0 / (z0 or math.inf)
    width = math.pi * E_star * G / (4 * sigma**2)
    if width < LIMITS.atom:
        small = Unknown(
            f"from the stress of the attraction, {show(sigma, 'modulus')}, its size would be "
            f"{show(width, 'length', 2)}, less than an atom; give the stress of the dissipating zone, --stress"
        )
        return Zone(small, small, small)
    return Zone(width, width / a, NO_LAYER if math.isinf(h) else width / h)
