"""The body that is meshed: a rectangle of layers with supports, cut out of the specimen where that is unbounded."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...base.errors import Refusal
from ...bodies.materials import Elastic, Material, TransverselyIsotropic
from ...bodies.problem import HalfSpace, Problem, Rigid, Side, Specimen

FAR = 500.0  # size of the cut-out of a half-space, in lengths over which its field changes
WIDE, SLIDING_WIDE = 40.0, 1000.0  # width beyond the contact of a stack on a bonded or sliding base, in such lengths


@dataclass(frozen=True)
class Body:
    """Layers from the surface down, each ``thicknesses[i]`` m of ``materials[i]``, out to radius ``width`` [m].

    ``bonded``: the base holds the body, else it only supports it; ``cut_below``: the lowest layer stands for a
    half-space; ``cut_beside``: the specimen is wider than the body; ``completed``: the displacement that a cut-out
    half-space lacks is added.
    """

    thicknesses: tuple[float, ...]
    materials: tuple[Material, ...]
    width: float
    bonded: bool
    side: Side
    cut_below: bool
    cut_beside: bool
    completed: bool = False

    @property
    def depth(self) -> float:
        return float(sum(self.thicknesses))

    @property
    def interfaces(self) -> np.ndarray:
        """Depths of the layer boundaries inside the body, increasing [m]."""
        return np.cumsum(self.thicknesses)[:-1]

    @property
    def layers(self) -> list[tuple[float, float]]:
        """(top depth, thickness) of the layers whose lower side is a boundary of the specimen."""
        tops = np.concatenate([[0.0], self.interfaces])
        pairs = list(zip(tops.tolist(), self.thicknesses, strict=True))
        return pairs[:-1] if self.cut_below else pairs


def cut_out(problem: Problem, reach: float, depth: float | None, width: float | None) -> Body:
    """The body to mesh for contact radii up to ``reach``; ``depth`` and ``width``: the user's truncation, or None."""
    specimen = _with_equivalent_modulus(problem)
    decay = _decay_length(specimen, reach)
    base = specimen.base
    thicknesses = [layer.thickness for layer in specimen.layers]
    materials = [layer.material for layer in specimen.layers]
    if isinstance(base, HalfSpace):
        H = depth if depth is not None else FAR * decay
        if 2 * (sum(thicknesses) + reach) >= H:
            raise Refusal(
                f"mesh.depth: {H:g} m leaves too little of the half-space below contact and layers; "
                f"give more than {2 * (sum(thicknesses) + reach):.3g} m or leave it out"
            )
        thicknesses.append(H - sum(thicknesses))
        materials.append(base.material)
        bonded, L = True, FAR * decay
    else:
        if depth is not None:
            raise Refusal(
                f"mesh.depth: the specimen ends at its rigid base, {specimen.thickness:g} m deep: leave it out"
            )
        assert isinstance(base, Rigid)
        bonded, L = base.bonded, reach + (WIDE if base.bonded else SLIDING_WIDE) * decay
    finite = specimen.radius is not None
    return Body(
        thicknesses=tuple(thicknesses),
        materials=tuple(materials),
        width=_width(specimen, reach, width, L),
        bonded=bonded,
        side=(specimen.side or "free") if finite else "free",
        cut_below=isinstance(base, HalfSpace),
        cut_beside=not finite,
        completed=isinstance(base, HalfSpace) and depth is None and width is None,
    )


def half_space_like(body: Body, size: float) -> Body:
    """A homogeneous half-space of the uppermost material at the surface, cut at depth and width ``size`` [m]."""
    top = body.materials[0]
    material = top if isinstance(top, TransverselyIsotropic) else top.surface
    return Body((size,), (material,), size, True, "free", True, True, completed=True)


def _width(specimen: Specimen, reach: float, width: float | None, automatic: float) -> float:
    if specimen.radius is not None:
        if width is not None:
            raise Refusal(f"mesh.width: the specimen ends at its radius, {specimen.radius:g} m: leave it out")
        return specimen.radius
    if width is None:
        return automatic
    if width <= 1.5 * reach:
        raise Refusal(
            f"mesh.width: {width:g} m, needs more than 1.5 times the refined zone, {1.5 * reach:.4g} m, or leave it out"
        )
    return width


def _decay_length(specimen: Specimen, reach: float) -> float:
    """Length over which the field changes far from the contact: layers' thickness, longer under a stiff plate."""
    moduli = [modulus for layer in specimen.layers for modulus in layer.moduli]
    total = sum(layer.thickness for layer in specimen.layers)
    if isinstance(specimen.base, HalfSpace):
        E = specimen.base.material.surface.E
        contrast = max([*moduli, E]) / E
        return max(reach, total * contrast ** (1 / 3))
    return total * (max(moduli) / min(moduli)) ** (1 / 4)


def _with_equivalent_modulus(problem: Problem) -> Specimen:
    """An elastic indenter on a homogeneous half-space acts through E* alone (Eq. 4): give it all to the half-space."""
    specimen = problem.specimen
    if problem.indenter.material is None:
        return specimen
    nu = specimen.surface.nu
    return Specimen((), HalfSpace(Elastic(problem.E_star * (1 - nu**2), nu)))
