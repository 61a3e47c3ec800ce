"""The contact problem: indenter, specimen and loading. Physics only, SI, no mesh and no work of adhesion."""

from __future__ import annotations

import hashlib
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, Literal, cast

from ..base.errors import InputError, did_you_mean, positive
from ..base.units import show
from .indenter import Indenter
from .materials import (
    AnyGraded,
    Coated,
    Elastic,
    Layer,
    Material,
    Relaxation,
    Solid,
    TransverselyIsotropic,
    contact_modulus,
    smooth_parts,
)

Quantity = Literal["depth", "load", "radius"]
Spacing = Literal["radius", "depth", "log", "given"]
Side = Literal["free", "roller", "clamped"]
NO_FINITE_RANGE = (
    "adhesion of finite range is not derived with surface tension: leave range, stress and capillary out, or "
    "specimen.surface_tension"
)
NOT_TOGETHER = {
    ("relaxation", "elastic"): "specimen.relaxation: needs a rigid indenter: an elastic one does not relax with the "
    "specimen; leave out indenter.E and nu, or the relaxation",
    ("relaxation", "sticking"): "specimen.relaxation: is for frictionless contact only: leave out "
    'surface = "sticking" or the relaxation',
    ("relaxation", "tension"): "specimen.relaxation: contact of a viscoelastic specimen is not derived with surface "
    "tension: leave specimen.surface_tension out, or the relaxation",
    ("tension", "sticking"): "specimen.surface_tension: contact without slip is not derived with surface tension: "
    'leave it out, or take specimen.surface = "sliding"',
    ("tension", "elastic"): "specimen.surface_tension: contact of an elastic indenter is not derived with surface "
    "tension: leave it out, or take a rigid indenter (no indenter.E and indenter.nu)",
}
MOST_PIECES = 1000  # of E over depth, in all layers; choice: minutes, each is solved by sublayers of its own


@dataclass(frozen=True)
class Rigid:
    """A rigid base, to which the lowest layer is bonded or on which it slides without friction."""

    bonded: bool = True


@dataclass(frozen=True)
class HalfSpace:
    """A homogeneous elastic half-space below the layers; with no layers it is the whole specimen."""

    material: Elastic | TransverselyIsotropic


@dataclass(frozen=True)
class Specimen:
    """Layers from the contact surface down, and a base; ``radius`` [m] and ``side`` for a really finite body only.

    ``surface_tension`` [N/m]: of the solid, a constant stress of its whole surface. ``relaxation``: of all moduli
    together, which are those at t = 0 (or at the law's own reference time); no part of what is solved.
    """

    layers: tuple[Layer, ...]
    base: Rigid | HalfSpace
    radius: float | None = None
    side: Side | None = None
    surface_tension: float = field(default=0.0, repr=False)
    relaxation: Relaxation | None = field(default=None, compare=False, repr=False)

    def __post_init__(self) -> None:
        if not (math.isfinite(self.surface_tension) and self.surface_tension >= 0):
            raise InputError(f"specimen.surface_tension: must be finite and >= 0, got {self.surface_tension:g} N/m")
        if not self.layers and isinstance(self.base, Rigid):
            raise InputError("specimen: a rigid substrate needs at least one layer on it")
        if self.radius is not None:
            positive("m", **{"specimen.radius": self.radius})
        if self.pieces > MOST_PIECES:
            raise InputError(
                f"E over depth has {self.pieces:,} smooth pieces, at most {MOST_PIECES:,} are taken; "
                "leave out points that lie nearly on the straight line between their neighbours"
            )

    @property
    def is_half_space(self) -> bool:
        """True for a homogeneous, laterally unbounded half-space."""
        return not self.layers and self.radius is None

    @property
    def surface(self) -> Elastic:
        """What first touch feels: the material at the contact, or the isotropic one of the same E*."""
        return self.materials[0].surface

    @property
    def materials(self) -> tuple[Material, ...]:
        """All materials from the surface down."""
        layers = tuple(layer.material for layer in self.layers)
        return (*layers, self.base.material) if isinstance(self.base, HalfSpace) else layers

    @property
    def is_graded(self) -> bool:
        """True where the modulus of any layer varies over depth."""
        return any(isinstance(layer.material, AnyGraded) for layer in self.layers)

    @property
    def pieces(self) -> int:
        """How many smooth pieces the laws of E over depth have, in all layers."""
        return sum(
            len(smooth_parts(layer.material.laws, layer.thickness))
            for layer in self.layers
            if isinstance(layer.material, AnyGraded)
        )

    @property
    def thickness(self) -> float:
        """Total thickness of the layers [m]; infinite on an elastic half-space."""
        if isinstance(self.base, HalfSpace):
            return math.inf
        return sum(layer.thickness for layer in self.layers)

    @property
    def top_thickness(self) -> float:
        """Thickness of the uppermost layer [m], the h of a/h; infinite for a half-space."""
        return self.layers[0].thickness if self.layers else math.inf

    @property
    def tension_length(self) -> float:
        """kappa = 2 Ups/E* of the material at the surface [m], below which its tension carries more than it does."""
        return 2 * self.surface_tension / self.surface.E_star

    @property
    def yielding_depth(self) -> float:
        """Depth [m] down to the first material that is stiffer than the one above it, or the rigid base: what is
        squeezed; infinite where there is none, as below a stiff skin."""
        moduli = [material.surface.E for material in self.materials]
        below = [*moduli, math.inf] if isinstance(self.base, Rigid) else moduli
        stiffer = (i for i, E in enumerate(below[1:]) if E > moduli[i])
        last = next(stiffer, None)
        return math.inf if last is None else sum(layer.thickness for layer in self.layers[: last + 1])

    @property
    def words(self) -> str:
        """``a layer (E = 1 MPa, nu = 0.4, h = 1 um) on a rigid base``."""
        base = "" if self.is_half_space else self._words_of_base
        height = f"h = {show(self.top_thickness, 'length')}" if base else ""
        surface = self.materials[0].words
        if self.surface_tension:
            surface += f", surface tension {show(self.surface_tension, 'tension')}"
        if not base:
            return f"a half-space ({surface})"
        count = len(self.layers)
        layers, top = ("a layer", "") if count == 1 else (f"{count} layers", " on top")
        side = ""
        if self.radius is not None:
            side = f", cylinder of radius {show(self.radius, 'length')}, side {self.side}"
        return f"{layers} ({surface}, {height}{top}{side}) on {base}"

    @property
    def _words_of_base(self) -> str:
        match self.base:
            case HalfSpace(material=Elastic(E=E)):
                return f"an elastic half-space (E = {show(E, 'modulus')})"
            case HalfSpace(material=material):
                return f"an elastic half-space ({material.words})"
            case Rigid(bonded=bonded):
                return "a rigid substrate" if bonded else "a rigid frictionless base"

    def scaled(self, factor: float) -> Specimen:
        """The same specimen with every modulus, and the surface tension, multiplied by ``factor``: the same
        displacements."""
        layers = tuple(replace(layer, material=layer.material.scaled(factor)) for layer in self.layers)
        base = self.base
        if isinstance(base, HalfSpace):
            base = HalfSpace(base.material.scaled(factor))
        return replace(self, layers=layers, base=base, surface_tension=self.surface_tension * factor)


@dataclass(frozen=True)
class Loading:
    """What is prescribed: increments up to ``maximum`` of a quantity [m or N], or the ``values`` themselves.

    ``spacing = "radius"``: ``points`` contact radii, evenly spaced between first touch and the largest one;
    ``"depth"``: evenly spaced displacements (the paper); ``"log"``: radii graded towards first
    contact, sqrt(a^2 - a0^2) in a geometric sequence over four decades; ``"given"``: increasing ``values``.
    """

    to: Quantity
    maximum: float
    points: int = 100
    spacing: Spacing = "radius"
    values: tuple[float, ...] = ()

    def __post_init__(self) -> None:
        if not (math.isfinite(self.maximum) and self.maximum > 0):
            raise InputError(f"loading: the largest {self.to} must be > 0, got {self.maximum:g}")
        if self.points < 1:
            raise InputError(f"loading.points: must be >= 1, got {self.points}")
        if self.spacing == "given":
            steps = [b - a for a, b in zip((0.0, *self.values), self.values, strict=False)]
            if not self.values or min(steps) <= 0:
                raise InputError(f"loading.values: must be positive and increase, got {list(self.values)}")

    @property
    def goal(self) -> str:
        """The largest value with its unit: ``3 um``."""
        return show(self.maximum, "load" if self.to == "load" else "length")

    @classmethod
    def given(cls, to: Quantity, values: tuple[float, ...]) -> Loading:
        """Loading to the given, increasing values of ``to``."""
        return cls(to, max(values, default=0.0), len(values), "given", tuple(values))


@dataclass(frozen=True)
class Problem:
    """An axisymmetric contact problem, geometrically linear (method: any).

    ``sticks``: each point keeps the radial displacement with which it was touched; else the surfaces slide without
    friction.
    """

    indenter: Indenter
    specimen: Specimen
    loading: Loading
    sticks: bool = field(default=False, repr=False)

    def __post_init__(self) -> None:
        specimen = self.specimen
        features = {"elastic": self.indenter.material is not None, "sticking": self.sticks}
        features |= {"relaxation": specimen.relaxation is not None, "tension": specimen.surface_tension > 0}
        for pair, words in NOT_TOGETHER.items():
            if all(features[name] for name in pair):
                raise InputError(words)

    @property
    def E_star(self) -> float:
        """Reduced modulus of the two materials that touch [Pa] (Eq. 4)."""
        return contact_modulus(self.specimen.surface, self.indenter.material)

    @property
    def coatings(self) -> tuple[Layer, ...]:
        """The layers of the indenter from its surface inwards."""
        material = self.indenter.material
        return material.layers if isinstance(material, Coated) else ()

    @property
    def layers(self) -> tuple[Layer, ...]:
        """All layers of both bodies."""
        return (*self.specimen.layers, *self.coatings)

    @property
    def is_half_space(self) -> bool:
        """True where E* is all that counts: a homogeneous half-space under a rigid or homogeneous indenter."""
        return self.specimen.is_half_space and not self.coatings

    @property
    def top_thickness(self) -> float:
        """Thickness of the thinner of the two layers that touch [m]; infinite between half-spaces."""
        return min([self.specimen.top_thickness, *(layer.thickness for layer in self.coatings[:1])])

    @property
    def surface(self) -> str:
        """What the surfaces do that touch: "sliding" without friction, or "sticking"."""
        return "sticking" if self.sticks else "sliding"

    @property
    def words(self) -> str:
        """``sphere R = 100 um on a half-space (E = 5 GPa, nu = 0.4) to a depth of 3 um``."""
        elastic, to = "" if self.indenter.material is None else "elastic ", self.loading.to
        end = f"{'contact radius' if to == 'radius' else to} of {self.loading.goal}"
        stuck = ", no slip," if self.sticks else ""
        more = " on top" if len(self.coatings) > 1 else ""
        coated = f", coated ({self.coatings[0].words}{more})," if self.coatings else ""
        where = f"on {self.specimen.words}{stuck} to a {end}"
        return f"{elastic}{self.indenter.words}{coated} {where}"

    def scaled(self, factor: float) -> Problem:
        """The same problem with every modulus, tension and prescribed load multiplied by ``factor``."""
        indenter, loading = self.indenter, self.loading
        if indenter.material is not None:
            indenter = replace(cast(Any, indenter), material=indenter.material.scaled(factor))
        if loading.to == "load":
            values = tuple(value * factor for value in loading.values)
            loading = replace(loading, maximum=loading.maximum * factor, values=values)
        return Problem(indenter, self.specimen.scaled(factor), loading, self.sticks)

    @property
    def key(self) -> str:
        """A hash of the physics: equal for equal problems, whatever method solves them."""
        words = f"{self!r}, sticks" if self.sticks else repr(self)
        words += f", surface tension {tension!r}" if (tension := self.specimen.surface_tension) else ""
        return hashlib.sha256(words.encode()).hexdigest()[:16]


# --------------------------------------------------------------------------------------------------
# The layers of a body by name, and the body with other values in some of them, or without sides.

BASE = "base"  # name of an elastic half-space below the layers
RADIUS = "radius"  # of the indenter, among the names of inputs


def layer_names(specimen: Specimen) -> tuple[str, ...]:
    """Names of the layers in the case, else their numbers from 1 at the contact; "base": the half-space."""
    names = [layer.name or str(i) for i, layer in enumerate(specimen.layers, start=1)]
    return (*names, *([BASE] if isinstance(specimen.base, HalfSpace) else []))


def nominal(specimen: Specimen, name: str) -> float:
    """The value of "E:layer" [Pa], "h:layer" [m] or "nu:layer"."""
    quantity, _, layer = name.partition(":")
    names = layer_names(specimen)
    checked_names([layer], names)
    part: Any = (*specimen.layers, specimen.base)[_place(layer, names)]
    if quantity != "h":
        return float(getattr(part.material.surface, quantity))
    if not isinstance(part, Layer):
        raise InputError(f"{name}: a half-space has no thickness")
    return part.thickness


def _place(name: str, names: Sequence[str]) -> int:
    """The last that is called so: "base" is the half-space, whatever layers are called."""
    return len(names) - 1 - names[::-1].index(name)


def changed(problem: Problem, values: Mapping[str, float]) -> Problem:
    """The problem with other moduli [Pa], thicknesses [m] and Poisson's ratios by name ("E:film": 2e6, ...), or another
    "radius" of the indenter [m]."""
    specimen, names = problem.specimen, layer_names(problem.specimen)
    parts: list[Any] = [*specimen.layers, specimen.base]
    for name, value in values.items():
        quantity, _, layer = name.partition(":")
        if quantity == RADIUS:
            problem = replace(problem, indenter=replace(cast(Any, problem.indenter), R=value))
            continue
        i = _place(layer, names)
        material = parts[i].material
        if quantity == "h":
            parts[i] = replace(parts[i], thickness=value)
        elif quantity == "nu":
            parts[i] = replace(parts[i], material=replace(material, nu=value))
        elif isinstance(material, Elastic):
            parts[i] = replace(parts[i], material=replace(material, E=value))
        else:  # the modulus of its top, all moduli in proportion
            parts[i] = replace(parts[i], material=material.scaled(value / material.surface.E))
    return replace(problem, specimen=replace(specimen, layers=tuple(parts[:-1]), base=parts[-1]))


def without_side_walls(problem: Problem) -> Problem:
    """The same problem without the sides of the specimen."""
    return replace(problem, specimen=replace(problem.specimen, radius=None, side=None))


def alone(problem: Problem) -> Problem:
    """The same indenter on a half-space of the material at the surface, with its tension, both without layers."""
    specimen, indenter = problem.specimen, problem.indenter
    half_space = Specimen((), HalfSpace(specimen.surface), surface_tension=specimen.surface_tension)
    if problem.coatings:
        indenter = replace(cast(Any, indenter), material=problem.coatings[0].material.surface)
    return replace(problem, specimen=half_space, indenter=indenter)


def stacks(specimen: Specimen, indenter: Solid | None = None) -> tuple[Specimen, ...]:
    """The bodies whose compliance is not that of a half-space: the specimen and the coated indenter, as a flat stack on
    its core."""
    bodies = [specimen]
    if isinstance(indenter, Coated):
        bodies.append(Specimen(indenter.layers, HalfSpace(indenter.core)))
    return tuple(body for body in bodies if body.layers)


def checked_names(names: Sequence[str], allowed: Sequence[str], verb: str = "fit") -> None:
    """Refuse a name that is none of ``allowed``, with the nearest that is; the message begins with the ``verb``."""
    for name in names:
        if name not in allowed:
            hint = did_you_mean(name, allowed, 0.4)
            raise InputError(f'{verb}: unknown parameter "{name}"{hint} (allowed: {", ".join(allowed)})')
