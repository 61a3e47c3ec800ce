"""Contact radii finer than a node spacing: node-based radii calibrated on a half-space with the same surface mesh.

The vertex that just touches is not the edge of the contact: it lies beyond it by a fraction of the local node spacing
that depends on the mesh near the surface, not on the body below. On a half-space the edge is known, delta = F(a), or
the exact one of the same surface tension, so one solve with the same surface vertices and elements gives the factor
a / r for every vertex.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ...base import MOST_STEPS, SAME, SETTLED, Array
from ...bodies import Elastic, Graded, HalfSpace, Indenter, Paraboloid, Specimen, TransverselyIsotropic
from ..layered.tense import TenseContact
from ..radii import DENSE
from .body import at_surface
from .model import Model
from .nested import SurfaceContact, nested_events


@dataclass(frozen=True)
class EdgeTuning:
    """The exact half-space under surface tension."""

    near: float = 0.8  # of the vertices' radii, beyond which their contact radii do not lie; choice: spare
    accuracy: float = 1e-7  # choice: far below that of elements


TUNING = EdgeTuning()


def edge_correction(model: Model, indenter: Indenter) -> Array:
    """Edge correction of surfaces that slide: contact radius over vertex radius for the candidate vertices beyond the
    flat radius, by increasing radius."""
    reach = model.discretisation.reach
    profile: Indenter = indenter if indenter.a0 > 0 else Paraboloid(reach)
    surface = model.half_space
    events = nested_events(SurfaceContact(surface, profile.f(surface.radii)), profile.a0, "radius", np.inf)
    exact = _under_tension(model, profile, events.a) if model.body.tension else profile.abel
    return _edges(exact, profile.a0, events.delta, events.a) / events.a


def _under_tension(model: Model, profile: Indenter, radii: Array) -> Callable[[Array], Array]:
    """delta_H [m] over the contact radius [m] near the ``radii``, on a half-space with the body's surface tension."""
    from scipy.interpolate import CubicSpline

    specimen = Specimen((), HalfSpace(_homogeneous(model)), surface_tension=model.body.tension)
    contact, a0 = TenseContact(profile, specimen), profile.a0
    beyond = np.geomspace(TUNING.near * (radii[0] - a0), (radii[-1] - a0) / TUNING.near, DENSE)
    result = contact.solved(a0 + beyond, contact.plan(a0 + beyond, TUNING.accuracy))
    spline = CubicSpline(np.log(beyond), np.log(result.delta))
    return lambda a: np.exp(spline(np.log(a - a0)))


def _homogeneous(model: Model) -> Elastic | TransverselyIsotropic:
    material = at_surface(model.body.materials[0])
    assert not isinstance(material, Graded)
    return material


def _edges(exact: Callable[[Array], Array], a0: float, delta: Array, guess: Array) -> Array:
    """Radii where the ``exact`` displacement is delta: Newton's method in logarithms from the vertex radii."""
    u, step = np.log(guess - a0), SAME
    for _ in range(MOST_STEPS):
        value, ahead = (np.log(exact(a0 + np.exp(at))) for at in (u, u + step))
        change = (value - np.log(delta)) * step / (ahead - value)
        u = u - change
        if np.abs(change).max() < SETTLED:
            break
    return a0 + np.exp(u)
