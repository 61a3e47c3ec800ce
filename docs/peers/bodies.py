"""The two bodies that every peer solves: a paraboloid pressed in by equal steps of the depth; SI units.

Load over depth does not depend on the scale of the slope: with R larger and the depth smaller by the same factor the
contact radii stay and the loads fall by it. CalculiX, which measures gaps at displaced radii, gets ``flatter(100)``.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

STEPS = 100


@dataclass(frozen=True)
class Body:
    """Elastic body E [Pa], nu under a paraboloid of radius R [m], pressed in by ``depth`` [m].

    ``thickness`` [m] of a layer bonded to a rigid base, None: half-space. ``a_max`` [m]: the largest contact radius;
    ``width`` [m]: where the body is cut.
    """

    name: str
    E: float
    nu: float
    R: float
    depth: float
    thickness: float | None
    a_max: float
    width: float

    def flatter(self, factor: float) -> Body:
        return replace(self, R=self.R * factor, depth=self.depth / factor)

    @property
    def depths(self) -> np.ndarray:
        return self.depth * np.arange(1, STEPS + 1) / STEPS


BODIES = {
    "halfspace": Body("halfspace", 5e9, 0.4, 100e-6, 3e-6, None, 17.3205e-6, 4000 * 17.3205e-6),
    "thin-layer": Body("thin-layer", 5e9, 0.4, 1e-3, 0.15e-6, 1e-6, 17.395e-6, 30e-6),
}


def spaced(uniform: int, size: float, growth: float, end: float) -> np.ndarray:
    """``uniform`` intervals of ``size`` from 0, then each ``growth`` times the one before, to or beyond ``end``."""
    x = list(size * np.arange(uniform + 1))
    while x[-1] < end:
        x.append(x[-1] + (x[-1] - x[-2]) * growth)
    return np.array(x)


def axes(body: Body, nodes: int, growth: float, rows: int) -> tuple[np.ndarray, np.ndarray, int]:
    """Radii [m] of the columns, depths [m] of the rows of a structured mesh, and how many columns may touch.

    ``nodes`` per largest contact radius; a layer has ``rows`` equal elements through its thickness, a half-space rows
    that grow like the columns.
    """
    size, touching = body.a_max / nodes, int(1.2 * nodes)
    r = spaced(touching, size, growth, body.width)
    if body.thickness is None:
        return r, spaced(1, size, growth, body.width), touching
    return r, np.linspace(0, body.thickness, rows + 1), touching
