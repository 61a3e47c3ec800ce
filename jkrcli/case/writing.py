"""From a problem made in Python to a case: the inverse of the tables' ``build``."""

from __future__ import annotations

from typing import Any

from ..base.errors import InputError
from ..bodies import grading
from ..bodies.indenters import Indenter, Paraboloid, PowerLaw, RoundedFlat, Sphere, TableProfile
from ..bodies.materials import Elastic, Graded, Material, TransverselyIsotropic
from ..bodies.problem import HalfSpace, Layer, Loading, Problem, Rigid, Specimen
from . import Case, validated
from .models import case_model


def case_of(problem: Problem) -> Case:
    """A case of ``problem``, with defaults for all else; InputError where no case can say it."""
    tree = {
        "indenter": _indenter(problem.indenter) | _material(problem.indenter.material),
        "specimen": _specimen(problem.specimen),
        "loading": _loading(problem.loading),
    }
    return Case(validated(case_model(), tree, "problem"), "problem")


def _indenter(indenter: Indenter) -> dict[str, Any]:
    match indenter:
        case Sphere(R=R):
            return {"shape": "sphere", "radius": R}
        case Paraboloid(R=R):
            return {"shape": "paraboloid", "radius": R}
        case PowerLaw(B=B, d=d):
            return {"shape": "power", "coefficient": B, "exponent": d}
        case RoundedFlat(b=b, edge_radius=radius):
            return {"shape": "flat", "flat_radius": b, "edge_radius": radius}
        case TableProfile(r=r, heights=f):
            return {"shape": "table", "r": r, "f": f}
    raise InputError(f"indenter: a case has no shape for {type(indenter).__name__}")


def _material(material: Material | None) -> dict[str, Any]:
    match material:
        case None:
            return {}
        case Elastic(E=E, nu=nu):
            return {"E": E, "nu": nu}
        case Graded(law=law, nu=nu):
            return {"E": _law(law), "nu": nu}
        case TransverselyIsotropic():
            return dict(vars(material))


def _law(law: grading.Law) -> dict[str, Any]:
    match law:
        case grading.Linear(top=top, bottom=bottom):
            return {"law": "linear", "top": top, "bottom": bottom}
        case grading.Exponential(top=top, bottom=bottom):
            return {"law": "exponential", "top": top, "bottom": bottom}
        case grading.Power(top=top, length=length, exponent=exponent):
            return {"law": "power", "top": top, "length": length, "exponent": exponent}
        case grading.Tabulated(depths=depths, moduli=moduli):
            return {"law": "table", "depth": depths, "E": moduli}
    raise InputError(f"specimen: a case has no law for {type(law).__name__}")


def _specimen(specimen: Specimen) -> dict[str, Any]:
    tree: dict[str, Any] = {"layers": [_layer(layer) for layer in specimen.layers]}
    match specimen.base:
        case HalfSpace(material=material):
            tree["half_space"] = _material(material)
        case Rigid(bonded=bonded):
            tree["base"] = "bonded" if bonded else "frictionless"
    if specimen.radius is not None:
        tree |= {"radius": specimen.radius, "side": specimen.side}
    return tree


def _layer(layer: Layer) -> dict[str, Any]:
    return _material(layer.material) | {"thickness": layer.thickness, "name": layer.name}


def _loading(loading: Loading) -> dict[str, Any]:
    if loading.spacing == "given" and len(loading.values) > 1:
        return {loading.to: loading.values}
    if loading.spacing == "given":
        return {loading.to: loading.maximum, "points": 1}
    return {loading.to: loading.maximum, "points": loading.points, "spacing": loading.spacing}
