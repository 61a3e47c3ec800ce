"""One indenter that sticks to one layered specimen: its spectra, and contact at any radii.

The minors of the stack hold the whole surface compliance, F_rr and F_rz beside F_zz. An elastic indenter adds its own,
a half-space's or that of its layers, with F_rz of the opposite sign: both bodies squeeze towards the same side.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property, partial

import numpy as np

from ...base.errors import Refusal
from ...base.numerics import Array
from ...bodies.indenters import Indenter
from ...bodies.materials import AnyGraded, AnyTransverse, Coated, Material
from ...bodies.problem import Specimen, stacks
from ..integral.fredholm import EXACT, ContactResult, Panels, Quadrature
from ..integral.no_slip import Growth, Pieces, StuckDisc, StuckKernel
from .contact import LAYERED_MOST_FLOPS, LAYERED_MOST_NODES, IndenterOnLayers
from .spectrum import LayeredSpectrum, LayerMedium, minors_of, resolved, shear_moduli

# How the growing contact is discretised for an accuracy.
# widest, over the kernel's scale; tuned on bodies, by `make constants`: with half of it the same accuracy takes
# twice as long
STUCK_PIECE = 1.4
# Points on each piece: at the accuracy 1, and more for each decade:
# tuned on bodies, by `make constants`: with ``per_decade`` paraboloids on bonded layers err by less than a tenth of
# the accuracy
STUCK_POINTS = 4
# tuned on bodies, by `make constants`: with half as many they err by ten times the accuracy 1e-6
STUCK_PER_DECADE = 1.0
STUCK_MOST_POINTS = 16  # tuned on bodies, by `make constants`: beyond, narrower pieces are as cheap
STUCK_NARROWER = 0.9  # pieces of the second discretisation; choice: other nodes


@dataclass(frozen=True)
class StuckPlan:
    """``quadrature`` of the densities and of integrals over dF, ``widest`` piece [m] and ``points`` on each of the
    growth, ``order``: Gauss nodes on every panel in k."""

    quadrature: Quadrature
    widest: float
    points: int
    order: int = 24

    @property
    def nodes(self) -> int:
        """Rows of the system."""
        return 2 * self.quadrature.nodes

    def finer(self) -> StuckPlan:
        """A plan that is more accurate in every part and shares no node with this one."""
        widest, order = self.widest * STUCK_NARROWER, 20 if self.order == 24 else 24
        return StuckPlan(self.quadrature.finer(), widest, self.points + 1, order)


@dataclass(frozen=True, eq=False)
class StuckSpectrum(LayeredSpectrum):
    """Spectra g_zz - 1, g_zr - beta, g_rr - 1 of one pair of bodies that stick to each other."""

    def __call__(self, k: Array) -> Array:
        """The largest of the three, by size."""
        return np.max(np.abs(self.deviations(k)), axis=0)

    @property
    def tail(self) -> None:
        """None: these spectra decay exponentially."""
        return None

    @property
    def beta(self) -> float:
        """Dundurs's constant of the materials that touch, g_zr for k -> infinity."""
        zz, zr, rr = self._half_spaces
        return zr / math.sqrt(zz * rr)

    @cached_property
    def _half_spaces(self) -> tuple[float, float, float]:
        """Compliances F_zz, F_zr, F_rr of the half-spaces of both materials that touch [1/Pa]."""
        zz, zr, rr = half_space_compliances(self.specimen.materials[0])
        if self.indenter is not None:
            outermost = self.indenter.layers[0].material if isinstance(self.indenter, Coated) else self.indenter
            own_zz, own_zr, own_rr = half_space_compliances(outermost)
            zz, zr, rr = zz + own_zz, zr - own_zr, rr + own_rr
        return zz, zr, rr

    def deviations(self, k: Array) -> Array:
        """g_zz - 1, g_zr - beta, g_rr - 1 (3, k) at the wave numbers ``k`` [1/m]."""
        total = np.zeros((3, k.size))
        for body in stacks(self.specimen, self.indenter):
            layer = body.layers[0]
            m = minors_of(body, np.maximum(k, 1e-30 / layer.thickness))
            own = m[[2, 3, 1]] / m[0] / shear_moduli(layer)[0]
            own -= np.array(half_space_compliances(layer.material))[:, None]
            total += own if body is self.specimen else own * np.array([[1], [-1], [1]])
        zz, _, rr = self._half_spaces
        return total / np.array([[zz], [math.sqrt(zz * rr)], [rr]])

    @cached_property
    def panels(self) -> tuple[Array, Array, Array]:
        """Ends lo, hi [1/m] of panels that resolve all three, and the largest value on each (panels, 1)."""
        ends = [resolved(partial(self._acting, row), *self.octaves)[:2] for row in range(3)]
        edges = np.unique(np.concatenate([np.ravel(pair) for pair in ends]))
        return edges[:-1], edges[1:], self((edges[1:] + edges[:-1]) / 2)[:, None]

    def _acting(self, row: int, k: Array) -> Array:
        """A positive compliance less 1: g_zz, g_rr, or what acts on pressure and shear together.

        F_rr over a sliding base goes like 1/k, and acts times k^2 for small k.
        """
        zz, zr, rr = self.deviations(k) + np.array([[1.0], [self.beta], [1.0]])
        y = k * min((body.top_thickness for body in stacks(self.specimen, self.indenter)), default=math.inf)
        share = y / np.sqrt(1 + y**2)
        return (zz, zz + 2 * share * zr + share**2 * rr, share**2 * rr)[row] - 1

    def stuck_kernel(self, reach: float, order: int) -> StuckKernel:
        """Kernel for all x, t with x + t <= ``reach`` [m], from ``order`` Gauss nodes in k on every panel."""
        k, w, _ = self.nodes(reach, order)
        return StuckKernel(k, w * self.deviations(k), self.beta)


def half_space_compliances(material: Material) -> tuple[float, float, float]:
    """Compliances F_zz, F_zr, F_rr of a half-space [1/Pa] of the material at the top."""
    if isinstance(material, AnyTransverse):
        medium, G = LayerMedium.transverse(material), material.top.G_z
    else:
        medium, G = LayerMedium.isotropic(material.nu), material.surface.G
    _, rr, zz, zr, _ = medium.half_space
    return zz / G, zr / G, rr / G


@dataclass(frozen=True, eq=False)
class StuckLayeredContact(IndenterOnLayers):
    """An indenter that sticks to a layered specimen, solved at given radii."""

    what = " of contact without slip"

    @cached_property
    def spectrum(self) -> StuckSpectrum:
        return StuckSpectrum(self.specimen, self.indenter.material)

    def plan(self, radii: Array, tolerance: float) -> StuckPlan:
        """The plan expected to be accurate to ``tolerance`` up to the last of the ``radii`` [m]."""
        points = STUCK_POINTS + math.ceil(-STUCK_PER_DECADE * math.log10(tolerance))
        points, widest = min(points, STUCK_MOST_POINTS), STUCK_PIECE * self.scale
        count = points * math.ceil(float(radii[-1]) / widest) if math.isfinite(widest) else points
        if count > LAYERED_MOST_NODES:  # more than is solved: counted, not laid out
            return StuckPlan(Quadrature(points, widest, count), widest, points)
        nodes = self._pieces(float(radii[-1]), widest, points).nodes
        quadrature = Quadrature.cheapest(nodes, self.indenter.a0, self.scale, tolerance)
        return StuckPlan(replace(quadrature, inner=EXACT), widest, points)

    def _pieces(self, largest: float, widest: float, points: int) -> Pieces:
        return Pieces.of(self.indenter, largest, min(widest, largest), points)

    def flops(self, radii: Array, plan: StuckPlan) -> float:
        """Floating-point operations of one solve, about."""
        waves = 200 + 0.7 * self.spectrum.bandwidth(self.spectrum.floor) * 2 * radii[-1]
        rows = plan.nodes + 2 * plan.points * math.ceil(radii[-1] / min(plan.widest, radii[-1]))
        waves *= 1 if self.spectrum.beta == 0 else 4
        return float(rows**2 * waves + rows**3)

    def guard(self, radii: Array, plan: StuckPlan) -> None:
        """Refuse what would take minutes or gigabytes."""
        if plan.nodes > LAYERED_MOST_NODES or self.flops(radii, plan) > LAYERED_MOST_FLOPS:
            raise Refusal(
                f"layered: a = {radii[-1]:g} m is {radii[-1] / self.scale:.4g} times the length over which the layers "
                f"act and needs {plan.nodes} equations without slip (limit {LAYERED_MOST_NODES}); use a "
                f"smaller contact{' or use method fem' if self.indenter.material is None else ''}"
            )

    def solved(self, radii: Array, plan: StuckPlan) -> ContactResult:
        """Contact at the increasing ``radii`` [m]."""
        self.guard(radii, plan)
        a0, factor = self.indenter.a0, 2 * self.E_star
        beyond = radii > a0 * (1 + 1e-12)
        pieces = self._pieces(float(radii[-1]), plan.widest, plan.points) if beyond.all() else None
        ends = radii if pieces is None else pieces.nodes
        panels = Panels.through(ends, plan.quadrature, a0)
        disc = StuckDisc.of(self.spectrum.stuck_kernel(2 * float(radii[-1]), plan.order), panels)
        if pieces is None:  # the flat end itself
            nothing = np.zeros_like(radii)
            return ContactResult(panels, nothing, nothing, factor * disc.S, factor * disc.dS, disc.rounding)
        growth = Growth(self.indenter, disc, pieces, plan.quadrature.inner)
        S, dS = growth.stiffness(radii)
        worst = np.full_like(radii, disc.rounding.max())
        columns = growth.displacement(radii), factor * growth.load(radii), factor * S, factor * dS
        return ContactResult(replace(panels, radii=radii), *columns, worst)


def why_unsupported(indenter: Indenter, specimen: Specimen) -> str | None:
    """Why surfaces that stick are not solved for the two bodies; None where they are."""
    if isinstance(specimen.materials[0], AnyGraded):
        return (
            "under a modulus that varies right below the contact the spectra of no slip decay slowly, "
            "which is not implemented: use method fem, or cut the top layer into a few homogeneous ones"
        )
    if indenter.a0 > 0 and StuckSpectrum(specimen, indenter.material).beta != 0:
        return (
            "round a flat end that sticks to a compressible body the surface oscillates, so that the growth of the "
            "contact is not smooth there: use method fem, or a profile that is round at its tip"
        )
    return None
