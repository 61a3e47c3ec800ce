"""One mesh, one factorisation: the contact problem of a body condensed onto its surface."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ...base import ROUNDED, Array, StageClock
from ...bodies import Graded, Indenter, Material
from .body import MeshedBody, at_surface, half_space_like
from .edge import edge_rows
from .elasticity import ElasticSystem, assemble
from .far_field import missing_displacement
from .layout import Layout
from .nested import StuckContact, SurfaceContact
from .options import Solver
from .surface import StiffnessFactor, Surface, condense, factorise


@dataclass(frozen=True)
class LockingTuning:
    """Poisson's ratios beyond which displacements alone lock."""

    sliding: float = 0.49  # tuned on the gel of Sec. 4.3 and its like, by `make tuning`
    # tuned on bodies, by `make constants`: the edge of the shear locks before the layer does; at 0.45 and a/h = 10/3
    # radii err by 3e-4, mixed by 5e-5
    sticking: float = 0.4


TUNING = LockingTuning()


def pressure_layers(materials: Sequence[Material], sticks: bool, above: float | None = None) -> tuple[int, ...]:
    """Layers that get a pressure unknown: those of a Poisson's ratio ``above`` this one (None: where displacements of
    surfaces that slide, or stick, lock)."""
    if above is None:
        above = TUNING.sticking if sticks else TUNING.sliding
    return tuple(i for i, material in enumerate(materials) if material.surface.nu > above)


@dataclass(frozen=True)
class Discretisation:
    """What a model is made from: ``layout`` on its body, element ``order``, ``mixed``: layers with a pressure unknown,
    ``reach``: radius out to which surface nodes are candidates [m]; ``solver``: of the sparse factor; ``sticks``:
    whether contact forces are also radial."""

    layout: Layout
    order: int
    mixed: tuple[int, ...]
    reach: float
    solver: Solver = "auto"
    sticks: bool = False

    def coarser(self, factor: float) -> Discretisation:
        return replace(self, layout=self.layout.coarser(factor))

    def on_half_space(self, body: MeshedBody) -> Discretisation:
        """The same surface vertices on a homogeneous ``body``."""
        mixed = tuple(i for i in self.mixed if i == 0)
        return replace(self, layout=self.layout.on(body), mixed=mixed)

    def build(self, clock: StageClock) -> Model:
        """Mesh, assemble, factorise and condense."""
        with clock("mesh"):
            grid = self.layout.grid()
        with clock("assembly"):
            system = assemble(grid, self.layout.body, self.order, self.mixed)
        return self.condensed(system, clock)

    def condensed(self, system: ElasticSystem, clock: StageClock) -> Model:
        """Factorise and condense the assembled ``system``."""
        candidates = int(np.searchsorted(system.radii, self.reach * (1 + ROUNDED)))
        with clock("factorisation"):
            last = system.both(candidates) if self.sticks else system.normal[:candidates]
            factor = factorise(system, last, self.solver)
        with clock("surface solves"):
            surface = condense(system, factor)
            w = self._missing_displacement(system, factor, surface) if self.layout.body.cut_below else 0.0
        if self.layout.body.completed:
            surface = surface.shifted(w)
        return Model(self, system, factor, surface, w)

    def _missing_displacement(self, system: ElasticSystem, factor: StiffnessFactor, surface: Surface) -> float:
        """What the cut-out half-space lacks, under a uniform pressure on the candidates' disc [m/N]."""
        below = self.layout.body.materials[-1]
        assert not isinstance(below, Graded)  # it stands for a half-space, which is homogeneous
        forces = np.zeros(len(surface.C))
        forces[surface.normal] = -surface.areas / surface.areas.sum()
        loads = factor.loads(forces)
        return missing_displacement(system, below, factor.solve(loads))


@dataclass(frozen=True, eq=False)
class Model:
    """Elastic system, factor and condensed surface of one body; ``missing``: displacement per load that a cut-out
    half-space lacks [m/N], contained in the surface compliance where the body is ``completed``."""

    discretisation: Discretisation
    system: ElasticSystem
    factor: StiffnessFactor
    surface: Surface
    missing: float

    @property
    def body(self) -> MeshedBody:
        return self.discretisation.layout.body

    def contact(self, indenter: Indenter) -> SurfaceContact:
        """The contact problem with ``indenter``."""
        heights = indenter.f(self.surface.radii)
        if not self.surface.sticks:
            return SurfaceContact(self.surface, heights)
        rows = edge_rows(self.half_space, at_surface(self.body.materials[0]))
        return StuckContact(self.surface, heights, rows, indenter.a0)

    def with_roller(self) -> Model:
        """The same body with its side fixed in radial direction; the mesh and the stiffness stay."""
        rim = self.system.basis.get_dofs("side").all()
        system = replace(self.system, free=np.setdiff1d(self.system.free, rim))
        return self.discretisation.condensed(system, StageClock())

    @property
    def half_space(self) -> Surface:
        """Surface of a half-space of the uppermost material with the same vertices: this one where it is one."""
        if self.body.cut_below and len(self.body.materials) == 1:
            return self.completed()
        body = half_space_like(self.body, self.discretisation.reach)
        return self.discretisation.on_half_space(body).build(StageClock()).completed()

    def completed(self) -> Surface:
        """The surface of the whole half-space, whether or not the model is completed itself."""
        return self.surface if self.body.completed else self.surface.shifted(self.missing)

    def field(self, p: Array) -> Array:
        """Displacements (and pressures) of all unknowns under the contact forces ``p`` (m,) on the surface [N]."""
        return self.factor.solve(self.factor.loads(self.surface.direction * p))
