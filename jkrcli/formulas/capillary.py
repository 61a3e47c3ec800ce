"""The capillary bridge of a wetting liquid at fixed humidity: a constant tension over a fixed height.

Maugis and Gauthier-Manuel (J. Adhesion Sci. Technol. 8 (1994) 1311): the Laplace pressure gamma/r_K acts wherever the
gap is narrower than the height r_K (cos theta_1 + cos theta_2) of the meniscus, r_K the Kelvin radius; their product,
the work of adhesion, does not depend on the humidity. Valid where the meniscus is much wider than high.
"""

from __future__ import annotations

import math

GAS_CONSTANT = 8.31446261815324  # theory: J/(mol K), exact in the SI
WATER = 18.05e-6  # theory: m^3/mol, the molar volume of water at 20 degrees Celsius
ROOM = 293.15  # theory: K, the 20 degrees Celsius of ``WATER``


def kelvin_radius(surface_tension: float, humidity: float) -> float:
    """The Kelvin radius [m] of water at 20 degrees Celsius for a ``surface_tension`` [N/m] and a relative ``humidity``
    between 0 and 1 (Thomson 1871)."""
    return -surface_tension * WATER / (GAS_CONSTANT * ROOM * math.log(humidity))


def capillary(surface_tension: float, radius: float, angles: tuple[float, float]) -> tuple[float, float]:
    """Tension [Pa] and work of adhesion [J/m^2] of a bridge of the Kelvin ``radius`` [m] and two contact ``angles``
    [rad]."""
    wetting = math.cos(angles[0]) + math.cos(angles[1])
    return surface_tension / radius, surface_tension * wetting
