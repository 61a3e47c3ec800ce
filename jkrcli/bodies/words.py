"""A problem in one line of words."""

from __future__ import annotations

from ..base.units import show
from .indenters import Indenter, Paraboloid, PowerLaw, RoundedFlat, Sphere, TableProfile
from .materials import Elastic, Graded, Material, TransverselyIsotropic
from .problem import HalfSpace, Problem, Specimen


def describe(problem: Problem) -> str:
    """``sphere R = 100 um on a half-space (E = 5 GPa, nu = 0.4) to a depth of 3 um``."""
    loading = problem.loading
    dimension = "load" if loading.to == "load" else "length"
    goal = {"depth": "a depth", "load": "a load", "radius": "a contact radius"}[loading.to]
    return (
        f"{describe_indenter(problem.indenter)} on {describe_specimen(problem.specimen)} "
        f"to {goal} of {show(loading.maximum, dimension)}"
    )


def describe_indenter(indenter: Indenter) -> str:
    match indenter:
        case Sphere(R=R):
            name = f"sphere R = {show(R, 'length')}"
        case Paraboloid(R=R):
            name = f"paraboloid R = {show(R, 'length')}"
        case PowerLaw(B=B, d=1):
            name = f"cone of slope {B:.4g}"
        case PowerLaw(B=B, d=d):
            name = f"profile {B:.4g} r^{d:g}"
        case RoundedFlat(b=b, edge_radius=edge_radius):
            name = f"flat end b = {show(b, 'length')} with edge radius {show(edge_radius, 'length')}"
        case TableProfile(r=r):
            name = f"profile of {len(r)} points"
        case _:
            name = type(indenter).__name__
    return name if indenter.material is None else f"elastic {name}"


def describe_material(material: Material, with_nu: bool = True) -> str:
    match material:
        case Elastic(E=E, nu=nu):
            return f"E = {show(E, 'modulus')}" + (f", nu = {nu:g}" if with_nu else "")
        case Graded(law=law, nu=nu):
            name = type(law).__name__.lower()
            return f"E graded from {show(material.surface.E, 'modulus')} at the top, {name}, nu = {nu:g}"
        case TransverselyIsotropic(E_p=E_p, E_z=E_z):
            return f"transversely isotropic, E = {show(E_p, 'modulus')} in the plane, {show(E_z, 'modulus')} along z"


def describe_specimen(specimen: Specimen) -> str:
    surface = describe_material(specimen.materials[0])
    if specimen.is_half_space:
        return f"a half-space ({surface})"
    count = len(specimen.layers)
    layers = "a layer" if count == 1 else f"{count} layers"
    top = f"{surface}, h = {show(specimen.top_thickness, 'length')}" + (" on top" if count > 1 else "")
    if isinstance(specimen.base, HalfSpace):
        base = f"an elastic half-space ({describe_material(specimen.base.material, with_nu=False)})"
    else:
        base = "a rigid base" if specimen.base.bonded else "a rigid frictionless base"
    shape = (
        ""
        if specimen.radius is None
        else f", cylinder of radius {show(specimen.radius, 'length')}, side {specimen.side}"
    )
    return f"{layers} ({top}{shape}) on {base}"
