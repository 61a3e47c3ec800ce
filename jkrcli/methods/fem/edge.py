"""Contact radii finer than a node spacing: node-based radii calibrated on a half-space with the same surface mesh.

The vertex that just touches is not the edge of the contact: it lies beyond it by a fraction of the local node spacing
that depends on the mesh near the surface, not on the body below. On a half-space the edge is known, delta = F(a), so
one solve with the same surface vertices and elements gives the factor a / r for every vertex.
"""

from __future__ import annotations

from typing import cast

import numpy as np

from ...base.clock import StageClock
from ...bodies.indenters import Indenter, Paraboloid
from .contact import SurfaceContact, nested_events
from .domain import half_space_like
from .model import Model

Array = np.ndarray
CUT = 100.0  # size of the calibration's half-space in candidate radii; what it lacks is added


def radius_factors(model: Model, indenter: Indenter) -> Array:
    """Contact radius over vertex radius for the candidate vertices beyond the flat radius, by increasing radius."""
    profile = indenter if indenter.a0 > 0 else cast(Indenter, Paraboloid(model.recipe.reach))
    body = model.body
    half_space = model
    if not (body.cut_below and len(body.materials) == 1):
        cut = half_space_like(body, CUT * model.recipe.reach)
        half_space = model.recipe.on_half_space(cut).build(StageClock())
    surface = half_space.completed()
    events = nested_events(SurfaceContact(surface, profile.f(surface.radii)), profile.a0, "radius", np.inf)
    return _edges(profile, events.delta, events.a) / events.a


def _edges(profile: Indenter, delta: Array, guess: Array) -> Array:
    """Radii with F(a) = delta: Newton's method from the vertex radii."""
    a0 = profile.a0
    u = np.log(guess - a0)
    for _ in range(50):
        a = a0 + np.exp(u)
        step = 1e-6
        value, ahead = np.log(profile.abel(a)), np.log(profile.abel(a0 + np.exp(u + step)))
        change = (value - np.log(delta)) * step / (ahead - value)
        u = u - change
        if np.abs(change).max() < 1e-13:
            break
    return a0 + np.exp(u)
