"""One mesh, one factorisation: the contact problem of a body condensed onto its surface."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ...base.clock import StageClock
from ...bodies.indenters import Indenter
from ...bodies.materials import Graded
from .contact import SurfaceContact
from .domain import Body
from .elasticity import ElasticSystem, assemble
from .grid import Grid
from .layout import Layout
from .options import Solver
from .surface import Factor, Surface, condense, factorise
from .truncation import missing_displacement

Array = np.ndarray


@dataclass(frozen=True)
class Recipe:
    """What a model is made from: ``layout`` on its body, element ``order``, ``mixed``: layers with a pressure unknown,
    ``reach``: radius out to which surface nodes are candidates [m]; ``solver``: of the sparse factor."""

    layout: Layout
    order: int
    mixed: tuple[int, ...]
    reach: float
    solver: Solver = "auto"

    @property
    def body(self) -> Body:
        return self.layout.body

    def coarser(self, factor: float) -> Recipe:
        return replace(self, layout=self.layout.coarser(factor))

    def on_half_space(self, body: Body) -> Recipe:
        """The same surface vertices on a homogeneous ``body``."""
        return replace(self, layout=self.layout.on(body), mixed=tuple(i for i in self.mixed if i == 0))

    def build(self, clock: StageClock) -> Model:
        """Mesh, assemble, factorise and condense."""
        body = self.body
        with clock("mesh"):
            grid = self.layout.grid()
        with clock("assembly"):
            system = assemble(grid, body.materials, self.order, bonded=body.bonded, side=body.side, mixed=self.mixed)
        return self._condensed(grid, system, clock)

    def _condensed(self, grid: Grid, system: ElasticSystem, clock: StageClock) -> Model:
        candidates = int(np.searchsorted(system.radii, self.reach * (1 + 1e-9)))
        with clock("factorisation"):
            factor = factorise(system, candidates, self.solver)
        with clock("surface solves"):
            surface = condense(system, factor)
            w = self._missing_displacement(system, factor, surface) if self.body.cut_below else 0.0
        if self.body.completed:
            surface = replace(surface, C=surface.C + w)
        return Model(self, grid, system, factor, surface, w)

    def _missing_displacement(self, system: ElasticSystem, factor: Factor, surface: Surface) -> float:
        """Of the cut-out half-space, under a uniform pressure on the candidates' disc [m/N]."""
        loads = np.zeros(system.K.shape[0])
        loads[system.normal[: factor.tail]] = -surface.areas / surface.areas.sum()
        below = self.body.materials[-1]
        assert not isinstance(below, Graded)  # it stands for a half-space, which is homogeneous
        return missing_displacement(system, below, factor.solve(loads), 1.0)


@dataclass(frozen=True, eq=False)
class Model:
    """Grid, elastic system, factor and condensed surface of one body; ``missing``: displacement per load that a
    cut-out half-space lacks [m/N], contained in the surface compliance where the body is ``completed``."""

    recipe: Recipe
    grid: Grid
    system: ElasticSystem
    factor: Factor
    surface: Surface
    missing: float

    @property
    def body(self) -> Body:
        return self.recipe.body

    def contact(self, indenter: Indenter) -> SurfaceContact:
        """The contact problem with ``indenter``."""
        return SurfaceContact(self.surface, indenter.f(self.surface.radii))

    def with_roller(self) -> Model:
        """The same body with its side held in radial direction; the mesh and the stiffness stay."""
        rim = self.system.basis.get_dofs("side").all()
        system = replace(self.system, free=np.setdiff1d(self.system.free, rim))
        return self.recipe._condensed(self.grid, system, StageClock())

    def completed(self) -> Surface:
        """The surface of the whole half-space, whether or not the model is completed itself."""
        return self.surface if self.body.completed else replace(self.surface, C=self.surface.C + self.missing)

    def field(self, p: Array) -> Array:
        """Displacements (and pressures) of all unknowns under the nodal contact forces ``p`` [N]."""
        loads = np.zeros(self.system.K.shape[0])
        loads[self.system.normal[: p.size]] = -p
        return self.factor.solve(loads)
