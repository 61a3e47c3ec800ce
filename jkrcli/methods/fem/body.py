"""The body that is meshed: a rectangle of layers with supports, cut out of the specimen where that is unbounded."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from ...base import Array, Refusal
from ...bodies import Elastic, HalfSpace, Material, Problem, Side, Specimen, TransverselyIsotropic


@dataclass(frozen=True)
class CutTuning:
    """Where an unbounded specimen is cut, in lengths over which its field changes far from the contact."""

    half_space: float = 500.0  # size of the cut-out; tuned on the bodies of `make tuning`, by `make tuning`
    bonded: float = 40.0  # width beyond the contact on a bonded base; tuned on the same, by `make tuning`
    sliding: float = 1000.0  # width beyond the contact on a sliding base; tuned on the same, by `make tuning`
    calibration: float = 100.0  # candidate radii to its half-space's end; theory: the rest of what it lacks ~ its ^-3


TUNING = CutTuning()


@dataclass(frozen=True)
class MeshedBody:
    """Layers from the surface down, each ``thicknesses[i]`` m of ``materials[i]``, out to radius ``width`` [m].

    ``bonded``: the base holds the body, else it only supports it; ``cut_below``: the lowest layer stands for a
    half-space; ``cut_beside``: the specimen is wider than the body; ``completed``: the displacement that a cut-out
    half-space lacks is added; ``tension`` of the whole surface [N/m].
    """

    thicknesses: tuple[float, ...]
    materials: tuple[Material, ...]
    width: float
    bonded: bool
    side: Side
    cut_below: bool
    cut_beside: bool
    completed: bool = False
    tension: float = 0.0

    @property
    def depth(self) -> float:
        return float(sum(self.thicknesses))

    @property
    def interfaces(self) -> Array:
        """Depths of the layer boundaries inside the body, increasing [m]."""
        return np.cumsum(self.thicknesses)[:-1]

    @property
    def layers(self) -> list[tuple[float, float]]:
        """Top depth and thickness [m] of the layers whose lower side is a boundary of the specimen."""
        tops = np.concatenate([[0.0], self.interfaces])
        pairs = list(zip(tops.tolist(), self.thicknesses, strict=True))
        return pairs[:-1] if self.cut_below else pairs


def cut_out(problem: Problem, reach: float, depth: float | None, width: float | None) -> MeshedBody:
    """The body to mesh for contact radii up to ``reach``; ``depth`` and ``width``: the user's truncation, or None."""
    specimen = _with_equivalent_modulus(problem)
    base, decay = specimen.base, _decay_length(specimen, reach)
    thicknesses = [layer.thickness for layer in specimen.layers]
    if isinstance(base, HalfSpace):
        far = TUNING.half_space * decay
        thicknesses.append(_cut_below(sum(thicknesses), reach, far if depth is None else depth))
        bonded = True
    else:
        bonded, far = base.bonded, reach + (TUNING.bonded if base.bonded else TUNING.sliding) * decay
        if depth is not None:
            raise Refusal(
                f"mesh.depth: the specimen ends at its rigid base, {specimen.thickness:g} m deep: leave it out"
            )
    cut_below, cut_beside = isinstance(base, HalfSpace), specimen.radius is None
    completed = cut_below and depth is None and width is None
    side: Side = "free" if cut_beside else specimen.side or "free"
    own = tuple(thicknesses), specimen.materials, _width(specimen, reach, width, far), bonded, side
    return MeshedBody(*own, cut_below, cut_beside, completed=completed, tension=specimen.surface_tension)


def half_space_like(body: MeshedBody, reach: float) -> MeshedBody:
    """A homogeneous half-space of the uppermost material at the surface, for contact radii up to ``reach`` [m]."""
    top = at_surface(body.materials[0])
    size = TUNING.calibration * max(reach, 2 * body.tension / top.surface.E_star)
    return MeshedBody((size,), (top,), size, True, "free", True, True, completed=True, tension=body.tension)


def at_surface(material: Material) -> Elastic | TransverselyIsotropic:
    """The homogeneous material that the first touch of ``material`` feels."""
    return material if isinstance(material, TransverselyIsotropic) else material.surface


def _cut_below(layers: float, reach: float, depth: float) -> float:
    """Thickness of a half-space cut at ``depth`` below ``layers`` of this thickness together [m]."""
    if 2 * (layers + reach) >= depth:
        raise Refusal(
            f"mesh.depth: {depth:g} m leaves too little of the half-space below contact and layers; "
            f"give more than {2 * (layers + reach):.3g} m or leave it out"
        )
    return depth - layers


def _width(specimen: Specimen, reach: float, width: float | None, far: float) -> float:
    """Radius of the body [m]: the specimen's own, the user's ``width``, or ``far``."""
    if specimen.radius is not None:
        if width is not None:
            raise Refusal(f"mesh.width: the specimen ends at its radius, {specimen.radius:g} m: leave it out")
        return specimen.radius
    if width is not None and width <= 1.5 * reach:
        raise Refusal(
            f"mesh.width: {width:g} m, needs more than 1.5 times the refined zone, {1.5 * reach:.4g} m, or leave it out"
        )
    return far if width is None else width


def _decay_length(specimen: Specimen, reach: float) -> float:
    """Length over which the field changes far from the contact [m]: the layers' thickness, longer under a stiff plate
    (of moduli E1 on E2 like (E1/E2)^(1/3) on a half-space, and like (E1/E2)^(1/4) on a layer, as Winkler's) or under
    a tension, that carries over kappa = 2 Ups/E* on a half-space, and sqrt(kappa h) on a layer."""
    kappa = specimen.tension_length
    moduli = [modulus for layer in specimen.layers for modulus in layer.moduli]
    total = sum(layer.thickness for layer in specimen.layers)
    if isinstance(specimen.base, HalfSpace):
        E = specimen.base.material.surface.E
        contrast = max([*moduli, E]) / E
        return max(reach, total * contrast ** (1 / 3), kappa)
    return max(total * (max(moduli) / min(moduli)) ** (1 / 4), math.sqrt(kappa * total))


def _with_equivalent_modulus(problem: Problem) -> Specimen:
    """An elastic indenter on a homogeneous half-space acts through E* alone (Eq. 4): give it all to the half-space."""
    specimen = problem.specimen
    if problem.indenter.material is None:
        return specimen
    nu = specimen.surface.nu
    return Specimen((), HalfSpace(Elastic(problem.E_star * (1 - nu**2), nu)))
