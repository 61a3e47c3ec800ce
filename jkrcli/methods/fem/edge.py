"""Contact radii finer than a node spacing: node-based radii calibrated on a half-space with the same surface mesh.

The vertex that just touches is not the edge of the contact: it lies beyond it by a fraction of the local node spacing
that depends on the mesh near the surface, not on the body below. On a half-space the edge is known, delta = F(a), so
one solve with the same surface vertices and elements gives the factor a / r for every vertex.
"""

from __future__ import annotations

import numpy as np

from ...base.arrays import Array
from ...bodies.indenters import Indenter, Paraboloid
from .contact import SurfaceContact, nested_events
from .model import Model


def edge_correction(model: Model, indenter: Indenter) -> Array:
    """Edge correction of surfaces that slide: contact radius over vertex radius for the candidate vertices beyond the
    flat radius, by increasing radius."""
    reach = model.discretisation.reach
    profile: Indenter = indenter if indenter.a0 > 0 else Paraboloid(reach)
    surface = model.half_space
    events = nested_events(SurfaceContact(surface, profile.f(surface.radii)), profile.a0, "radius", np.inf)
    return _edges(profile, events.delta, events.a) / events.a


def _edges(profile: Indenter, delta: Array, guess: Array) -> Array:
    """Radii with F(a) = delta: Newton's method in logarithms from the vertex radii."""
    a0, step = profile.a0, 1e-6
    u = np.log(guess - a0)
    for _ in range(50):
        value, ahead = (np.log(profile.abel(a0 + np.exp(at))) for at in (u, u + step))
        change = (value - np.log(delta)) * step / (ahead - value)
        u = u - change
        if np.abs(change).max() < 1e-13:
            break
    return a0 + np.exp(u)
