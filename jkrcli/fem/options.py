"""The method ``fem`` as it is known before its solver is imported: its options and its place among the others."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Literal, TypeAlias

from ..base.arguments import read_fields
from ..base.errors import InputError
from ..base.units import Length, Ranged
from ..methods.protocol import Descriptor, InTable, register

Solver: TypeAlias = Literal["auto", "superlu", "cholmod"]
GROWTH = {"scaled": {1: 0.05, 2: 0.15}, "zones": {1: 0.08, 2: 0.25}}  # chosen for equal errors by either order
DOUBLED = 2.0  # element sizes of the mesh for the error estimate; theory: estimates are of what doubling changes
Number: TypeAlias = Annotated[float, Ranged("number", above=0)]


@dataclass(frozen=True)
class FEMOptions:
    """The finite-element mesh and how contact is found on it; None: chosen from the problem.

    ``layout``: "scaled": element size proportional to the distance from the first contact; "zones": the paper's.
    ``element``, ``order``: triangles (free) or quadrilaterals (structured), first or second order.
    ``integration``: "full", or "reduced": at the centre of each linear quadrilateral with hourglass control (as
    Abaqus' CAX4R), which does not lock near incompressibility.
    ``formulation``: "auto": a pressure unknown for layers with nu > 0.49 (second order); "displacement"; "mixed".
    ``element_size`` [m]: over the contact in the layout "zones" (default 0.0005 R; 0.02 of a thin body's depth).
    ``zone_sizes``: largest element sizes in the zones I, II, III, in units of R, layout "zones"
    (triangles of second order: twice that, as their nodes are half as far apart).
    ``depth``, ``width`` [m]: where an unbounded specimen is cut (default: so far that it does not matter).
    ``contact_radius`` [m]: largest contact radius to provide for (default: found from the loading).
    ``spacing``: distance of surface vertices over the distance from the first contact, layout "scaled".
    ``smallest``: contact radius down to which that holds, as a fraction of the largest; the mesh generator and the
    graded lines resolve no more than its lower limit.
    ``growth``: increase of the element size per distance from the contact (default 0.15, first order 0.05; layout
    "zones" 0.25 and 0.08).
    ``margin``: candidates beyond the expected largest contact radius, as a factor of it.
    ``edge_correction``: contact radii calibrated on a half-space with the same surface mesh (``fem.model``).
    ``estimate_error``: solve a mesh with doubled sizes too, for the error budget.
    ``tolerance``: of the series; spacing and growth then follow from it, mesh after mesh (layout "scaled").
    ``solver``: of the sparse factor: "auto" takes CHOLMOD for large meshes where the package cvxopt is installed.
    ``contact``: "nested": every vertex as contact radius of a growing disc, up to the loading's end (or its given
    values, interpolated); "incremental": the loading's increments.
    """

    layout: Literal["scaled", "zones"] = "scaled"
    element: Literal["triangle", "quadrilateral"] = "triangle"
    order: Literal[1, 2] = 2
    integration: Literal["full", "reduced"] = "full"
    formulation: Literal["auto", "displacement", "mixed"] = "auto"
    element_size: Length | None = None
    zone_sizes: tuple[Number, Number, Number] = (0.02, 0.05, 0.5)
    depth: Length | None = None
    width: Length | None = None
    contact_radius: Length | None = None
    spacing: Annotated[float, Ranged("number", above=0, below=0.5)] = 0.04
    smallest: Annotated[float, Ranged("number", above=1e-7, below=1)] = 0.05
    growth: Annotated[float, Ranged("number", above=0, below=0.6)] | None = None
    margin: Annotated[float, Ranged("number", above=1, below=10)] = 1.1
    edge_correction: bool = True
    estimate_error: bool = True
    tolerance: Annotated[float, Ranged("number", least=1e-6, most=0.1)] | None = None
    solver: Solver = "auto"
    contact: Annotated[Literal["nested", "incremental"], InTable("contact", "algorithm")] = "nested"

    def __post_init__(self) -> None:
        read_fields(self, "mesh")
        if self.element_size is not None and self.layout == "scaled":
            raise InputError('mesh: element_size belongs to layout "zones"; the layout "scaled" takes spacing')
        if self.zone_sizes != FEMOptions.zone_sizes and self.layout == "scaled":
            raise InputError('mesh: zone_sizes belong to layout "zones"; the layout "scaled" takes spacing')
        if self.integration == "reduced" and (self.element, self.order) != ("quadrilateral", 1):
            raise InputError(
                'mesh: integration = "reduced" is for linear quadrilaterals: set element = "quadrilateral" and '
                "order = 1"
            )
        if self.tolerance is not None and (self.layout == "zones" or not self.estimate_error):
            raise InputError('mesh: tolerance needs the layout "scaled" and estimate_error = true')

    @property
    def growth_of_sizes(self) -> float:
        """``growth``, or its default."""
        return self.growth if self.growth is not None else GROWTH[self.layout][self.order]


register(
    Descriptor(
        "fem", "Finite elements for stacks of isotropic layers, wide or of finite radius.", "jkrcli.fem.solver:FEM", 40,
        FEMOptions, "mesh", tension=True,
    )
)  # fmt: skip
