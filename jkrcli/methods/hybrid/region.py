"""The rectangle in which the correction is computed: layers with supports, in units of the largest contact radius."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from ...base import ROUNDED, Array
from ...bodies import Elastic, Graded, HalfSpace, Material, Rigid, Specimen, TransverselyIsotropic


@dataclass(frozen=True)
class RegionTuning:
    """Which layers get a pressure, and where an unbounded body is cut."""

    nearly_incompressible: float = 0.49  # above it a layer gets a pressure; tuned on reference bodies, by `make tuning`
    # of a second cut, which shows what the first one costs; tuned on bodies, by `make constants`: as cheap as it can be
    shrink: float = 3.0
    # degree of the elements that show it, at least: with 4 those between both cuts err by more
    least: int = 6  # tuned on reference bodies, by `make tuning`
    decays: float = 40.0  # lengths, where the field falls exponentially; tuned on reference bodies, by `make tuning`
    # Left by extrapolation over its change, times size/length:
    next_order: float = 12.0  # tuned on random bodies, by `make bounds`
    # Poisson's ratio of a half-space, from which on it does not move sideways where it is pulled from far:
    vanishing: float = 0.45  # tuned on random bodies, by `make bounds`
    # Relative error left elsewhere, times (size/length)^3:
    cut: float = 2.0  # tuned on reference bodies, by `make tuning`


TUNING = RegionTuning()


@dataclass(frozen=True)
class Region:
    """Layers from the surface down, 0 <= r <= ``width``, 0 <= z <= sum of ``thicknesses``, in units of ``unit`` [m].

    ``base, side``: whether u_r and whether u_z are prescribed there; what is not is free. ``far``: the half-space that
    begins with the lowest layer, where there is one; base and side then move as under a point force on it. ``length``:
    over which the field decays far away. ``cut_again``: whether this is
    what the second cut of an unbounded body leaves.
    """

    thicknesses: tuple[float, ...]
    materials: tuple[Material, ...]
    width: float
    base: tuple[bool, bool]
    side: tuple[bool, bool]
    far: Elastic | None
    unit: float
    cut_beside: bool
    length: float
    cut_again: bool = False

    @classmethod
    def of(cls, specimen: Specimen, reach: float, error: float) -> Region:
        """The region for contact radii up to ``reach`` [m]; where a body is unbounded, cut off with about ``error``."""
        thick = [layer.thickness / reach for layer in specimen.layers]
        length, size = _size(specimen, thick, error)
        far = None
        if isinstance(specimen.base, HalfSpace):
            assert isinstance(specimen.base.material, Elastic)
            far = specimen.base.material
            thick.append(size - sum(thick))
            base = side = True, True
        else:
            bonded = specimen.base.bonded
            support = specimen.side if specimen.radius is not None else "clamped"
            base, side = (bonded, True), (support != "free", support == "clamped")
        if specimen.radius is not None:
            size = specimen.radius / reach
        return cls(tuple(thick), specimen.materials, size, base, side, far, reach, specimen.radius is None, length)

    @property
    def depth(self) -> float:
        return sum(self.thicknesses)

    @property
    def first(self) -> float:
        """Depth of the first interface, or of the base."""
        return self.thicknesses[0]

    @property
    def changing(self) -> bool:
        """Whether the modulus changes from the contact on."""
        return isinstance(self.materials[0], Graded)

    @property
    def tops(self) -> tuple[float, ...]:
        """Depth of the upper side of every layer."""
        return (0.0, *np.cumsum(self.thicknesses)[:-1].tolist())

    @property
    def reference(self) -> Elastic:
        """The half-space that is the exact part: the material at the contact."""
        return self.materials[0].surface

    @property
    def algebraic(self) -> bool:
        """Whether what the cut costs falls with a power of its distance only."""
        return self.cut_beside and not (self.far is None and self.base[0])

    @property
    def next_order(self) -> float:
        """Part of the change by extrapolating the cut that is left as its error, about."""
        return min(TUNING.next_order * self.length / self.width, 1.0)

    @property
    def higher_order(self) -> bool:
        """Whether the leading term of the far field on a half-space nearly vanishes, which extrapolation rests on."""
        return self.far is not None and self.far.nu > TUNING.vanishing

    @property
    def cuts(self) -> tuple[float, ...]:
        """Where the second cut of an unbounded body goes, along r, and along z if it is unbounded there too.

        What it leaves has no such line of its own: its elements are those of the whole body up to there, and their
        errors drop out of the difference.
        """
        if not self.cut_beside or self.cut_again:
            return ()
        inner = 0.0 if self.algebraic else 1.0
        return (inner + (self.width - inner) / TUNING.shrink,)

    @property
    def corners(self) -> tuple[float, ...]:
        """Depths at which the side meets the surface or the base in a singular corner: one of them fixed, one free."""
        if self.cut_beside:
            return ()
        return (0.0,) * self.side[1] + (self.depth,) * (self.base[0] and not self.side[0])

    @property
    def free_edges(self) -> tuple[float, ...]:
        """Depths at which an interface meets the side in a weaker singularity; none at a roller."""
        return () if self.cut_beside or self.side[0] != self.side[1] else self.tops[1:]

    def nearer(self) -> Region:
        """The same body after the second cut."""
        (width,) = self.cuts
        last = self.thicknesses[-1] - (self.width - width if self.far is not None else 0.0)
        return replace(self, width=width, thicknesses=(*self.thicknesses[:-1], last), cut_again=True)

    @property
    def kinks(self) -> list[float]:
        """Depths inside the layers at which the modulus has a kink."""
        kinks = []
        for top, thickness, material in zip(self.tops, self.thicknesses, self.materials, strict=True):
            if isinstance(material, Graded):
                kinks += [top + z / self.unit for z in material.law.kinks if z / self.unit < thickness * (1 - ROUNDED)]
        return kinks

    def layer_at(self, z: Array) -> Array:
        """The layer of every depth ``z``."""
        return np.searchsorted(np.array(self.tops[1:]), z, side="right")

    @cached_property
    def mixed(self) -> tuple[bool, ...]:
        """Which layers have a pressure unknown."""
        limit = TUNING.nearly_incompressible
        return tuple(not isinstance(m, TransverselyIsotropic) and m.nu > limit for m in self.materials)

    def moduli(self, z: Array) -> Moduli:
        """Stiffnesses at the depths ``z``, in units of E of the reference."""
        layer = self.layer_at(z)
        C, inverse = np.zeros((5, z.size)), np.zeros(z.size)
        for i, (top, material) in enumerate(zip(self.tops, self.materials, strict=True)):
            at = layer == i
            if isinstance(material, TransverselyIsotropic):
                C[:, at] = np.array(material.stiffness)[:, None]
                continue
            E, nu = material.at((z[at] - top) * self.unit), material.nu
            G = E / (2 * (1 + nu))
            bulk = 0.0 * E if self.mixed[i] else E * nu / ((1 + nu) * (1 - 2 * nu))
            inverse[at] = (1 + nu) * (1 - 2 * nu) / (E * nu) if self.mixed[i] else 0.0
            C[:, at] = [bulk + 2 * G, bulk, bulk, bulk + 2 * G, G]
        E0 = self.reference.E
        return Moduli(C / E0, inverse * E0, np.array(self.mixed)[layer])

    def differs(self, z: Array) -> Array:
        """Whether the material at each depth ``z`` is another than the reference."""
        return np.array([material != self.reference for material in self.materials])[self.layer_at(z)]


@dataclass(frozen=True, eq=False)
class Moduli:
    """Rows C11, C12, C13, C33, C44 over depth (without lambda where ``mixed``) and 1/lambda where ``mixed``."""

    C: Array
    inverse_lame: Array
    mixed: Array

    def at(self, rows: Array | slice) -> Moduli:
        """Moduli at some depths."""
        return Moduli(self.C[:, rows], self.inverse_lame[rows], self.mixed[rows])


def _size(specimen: Specimen, thick: list[float], error: float) -> tuple[float, float]:
    """Length over which the field decays, and radius (and depth, of a half-space) at which an unbounded body is cut.

    A stack on a rigid base, if bonded, has a field that decays exponentially, the slower the stiffer its stiffest
    layer.
    On a half-space or a sliding base the layers' own far field, less that of the point force, dies with a power of
    (length over distance); the length is the thickness, of stiff layers on a half-space as a membrane.
    """
    stiffest = max(layer.moduli[1] for layer in specimen.layers)
    softest = min(layer.moduli[0] for layer in specimen.layers)
    if isinstance(specimen.base, Rigid):
        length = sum(thick)
        if specimen.base.bonded:
            length *= (stiffest / softest) ** 0.25
            return length, 1.0 + TUNING.decays * length
    else:
        assert isinstance(specimen.base.material, Elastic)
        soft = specimen.base.material.E
        length = sum(t * max(layer.moduli[1] / soft, 1.0) for t, layer in zip(thick, specimen.layers, strict=True))
    length = max(1.0, 2 * length)
    return length, length * (TUNING.cut / error) ** (1 / 3)


def nearest(region: Region) -> float:
    """Distance from the contact to the nearest place where the body ends or changes."""
    return min(region.first, math.inf if region.cut_beside else region.width - 1.0)
