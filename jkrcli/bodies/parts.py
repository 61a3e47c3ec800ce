"""The layers of a body by name, and the body with other values in some of them, or without sides."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any, cast

from ..base import InputError, did_you_mean
from .materials import Coated, Elastic, Layer, Solid
from .problem import HalfSpace, Problem, Specimen

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
        changes = {"thickness": value} if quantity == "h" else {"material": _with(parts[i].material, quantity, value)}
        parts[i] = replace(parts[i], **changes)
    return replace(problem, specimen=replace(specimen, layers=tuple(parts[:-1]), base=parts[-1]))


def unbounded(problem: Problem) -> Problem:
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


def _with(material: Any, quantity: str, value: float) -> Any:
    """The material with another modulus [Pa] (that of its top, all moduli in proportion) or Poisson's ratio."""
    if quantity == "nu":
        return replace(material, nu=value)
    return replace(material, E=value) if isinstance(material, Elastic) else material.scaled(value / material.surface.E)


def checked_names(names: Sequence[str], allowed: Sequence[str], verb: str = "fit") -> None:
    """Refuse a name that is none of ``allowed``, with the nearest that is; the message begins with the ``verb``."""
    for name in names:
        if name not in allowed:
            hint = did_you_mean(name, allowed, 0.4)
            raise InputError(f'{verb}: unknown parameter "{name}"{hint} (allowed: {", ".join(allowed)})')
