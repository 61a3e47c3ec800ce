"""Cases from problems made in Python: the inverse of the tables' ``build``."""

from __future__ import annotations

from typing import Any

from ..bodies import (
    LAWS,
    RELAXATIONS,
    Coated,
    Graded,
    HalfSpace,
    Layer,
    Loading,
    Material,
    Problem,
    Solid,
    Specimen,
)
from .reading import Case, model_of


def case_of(problem: Problem) -> Case:
    """A case of ``problem``, with defaults for all else; InputError where no case can say it."""
    tree = {
        "indenter": problem.indenter.keys | _indenter(problem.indenter.material),
        "specimen": _specimen(problem.specimen) | ({"surface": "sticking"} if problem.sticks else {}),
        "loading": _loading(problem.loading),
    }
    return Case(model_of(tree, "problem"), "problem")


def _indenter(material: Solid | None) -> dict[str, Any]:
    if isinstance(material, Coated):
        return _material(material.core) | {"layers": [_layer(layer) for layer in material.layers]}
    return _material(material)


def _material(material: Material | None) -> dict[str, Any]:
    if isinstance(material, Graded):
        return {"E": LAWS.keys_in_file(material.law), "nu": material.nu}
    return {} if material is None else dict(vars(material))


def _specimen(specimen: Specimen) -> dict[str, Any]:
    tree: dict[str, Any] = {"layers": [_layer(layer) for layer in specimen.layers]}
    if isinstance(specimen.base, HalfSpace):
        tree["half_space"] = _material(specimen.base.material)
    else:
        tree["base"] = "bonded" if specimen.base.bonded else "frictionless"
    if specimen.radius is not None:
        tree |= {"radius": specimen.radius, "side": specimen.side}
    if specimen.surface_tension:
        tree["surface_tension"] = specimen.surface_tension
    if specimen.relaxation is not None:
        tree["relaxation"] = RELAXATIONS.keys_in_file(specimen.relaxation)
    return tree


def _layer(layer: Layer) -> dict[str, Any]:
    return _material(layer.material) | {"thickness": layer.thickness, "name": layer.name}


def _loading(loading: Loading) -> dict[str, Any]:
    if loading.spacing != "given":
        return {loading.to: loading.maximum, "points": loading.points, "spacing": loading.spacing}
    return {loading.to: loading.values} if len(loading.values) > 1 else {loading.to: loading.maximum, "points": 1}
