"""Options of the finite-element method: what the tables [mesh] and [contact] of a case say, their defaults and ranges.

Nothing heavy hangs on this module.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

from ...base.errors import InputError

Solver = Literal["auto", "superlu", "cholmod"]
FINEST = 1e-7  # of ``smallest``: the mesh generator and the graded lines resolve no more
GROWTH = {"scaled": {1: 0.05, 2: 0.15}, "zones": {1: 0.08, 2: 0.25}}  # chosen for equal errors by either order


@dataclass(frozen=True)
class FEMOptions:
    """Options of the method ``fem``.

    ``layout``: "scaled": element size proportional to the distance from the first contact; "zones": the paper's.
    ``element``, ``order``: triangles (free) or quadrilaterals (structured), first or second order.
    ``contact``: "nested": every vertex as contact radius of a growing disc, up to the loading's end (or its given
    values, interpolated); "incremental": the loading's increments.
    ``element_size`` [m]: over the contact in the layout "zones" (default 0.0005 R; 0.02 of a thin body's depth).
    ``depth``, ``width`` [m]: where an unbounded specimen is cut (default: so far that it does not matter).
    ``contact_radius`` [m]: largest contact radius to provide for (default: found from the loading).
    ``spacing``: distance of surface vertices over the distance from the first contact, layout "scaled".
    ``smallest``: contact radius down to which that holds, as a fraction of the largest.
    ``growth``: increase of the element size per distance from the contact (default 0.15, first order 0.05; layout
    "zones" 0.25 and 0.08).
    ``zone_sizes``: largest element sizes in the zones I, II, III, in units of R, layout "zones"
    (triangles of second order: twice that, as their nodes are half as far apart).
    ``margin``: candidates beyond the expected largest contact radius, as a factor of it.
    ``formulation``: "auto": a pressure unknown for layers with nu > 0.49 (second order); "displacement"; "mixed".
    ``edge_correction``: contact radii of "nested" calibrated on a half-space with the same surface mesh (``fem.edge``).
    ``estimate_error``: solve a mesh with doubled sizes too, for the error budget.
    ``tolerance``: of the series; spacing and growth then follow from it, mesh after mesh (layout "scaled").
    ``solver``: of the sparse factor: "auto" takes CHOLMOD for large meshes where the package cvxopt is installed.
    """

    layout: Literal["scaled", "zones"] = "scaled"
    element: Literal["triangle", "quadrilateral"] = "triangle"
    order: Literal[1, 2] = 2
    contact: Literal["nested", "incremental"] = "nested"
    element_size: float | None = None
    depth: float | None = None
    width: float | None = None
    contact_radius: float | None = None
    spacing: float = 0.04
    smallest: float = 0.05
    growth: float | None = None
    zone_sizes: tuple[float, float, float] = (0.02, 0.05, 0.5)
    margin: float = 1.1
    formulation: Literal["auto", "displacement", "mixed"] = "auto"
    edge_correction: bool = True
    estimate_error: bool = True
    tolerance: float | None = None
    solver: Solver = "auto"

    def __post_init__(self) -> None:
        for name, low, high in (
            ("element_size", 0.0, math.inf),
            ("depth", 0.0, math.inf),
            ("width", 0.0, math.inf),
            ("contact_radius", 0.0, math.inf),
            ("spacing", 0.0, 0.5),
            ("smallest", FINEST, 1.0),
            ("growth", 0.0, 0.6),
            ("margin", 1.0, 10.0),
            ("tolerance", 0.0, 0.1),
        ):
            value = getattr(self, name)
            if value is not None and not low < value < high:
                raise InputError(f"mesh.{name}: must be > {low:g}" + f" and < {high:g}, got {value:g}")
        if self.element_size is not None and self.layout == "scaled":
            raise InputError('mesh.element_size: belongs to layout "zones"; the layout "scaled" takes spacing')
        if self.tolerance is not None and (self.layout == "zones" or not self.estimate_error):
            raise InputError('mesh.tolerance: needs the layout "scaled" and estimate_error = true')

    @property
    def growth_of_sizes(self) -> float:
        """``growth``, or its default."""
        return self.growth if self.growth is not None else GROWTH[self.layout][self.order]
