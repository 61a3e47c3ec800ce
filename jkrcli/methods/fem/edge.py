"""What a mesh makes of the edge of the contact, known from a half-space with the same surface vertices.

The vertex that just touches is not the edge of the contact: it lies beyond it by a fraction of the local node spacing
that depends on the mesh near the surface, not on the body below. On a half-space the edge is known, delta = F(a), or
the exact one of the same surface tension, so one solve with the same surface vertices and elements gives the factor
a / r for every vertex.

Where surfaces stick, the rows of L for a node read the field next to the edge of the disc that ends there: with the
densities xi of a stuck disc (``integral.stuck``), whose value at the edge is the amplitude of its singular fields, the
halves in both rows of the node at r are

    y delta - z = M xi(r) + N xi'(r)

up to the second order of the spacing, M and N (2, 2) of the mesh and its uppermost material alone. On the half-space
xi is known in closed form where its surface is displaced by 1, r^2 downwards or r, r^3 outwards. The transform of a
ring's tractions gives the work that they do on such a displacement: with the coefficients C_n, Q_n of rho^n in C, Q,

    xi(r) = (2/pi) (C_0, -4 C_2 r^2, 2 Q_1 r, -16 Q_3 r^3).

A contact that grows has xi = 0 at its edge a, and xi(r) = xi_1 (delta - delta_H(r)) where a disc of radius r would have
xi_1 under a unit displacement: with y = M xi_1, and ramps N xi_1,

    z = delta_H(r) y + delta_H'(r) N xi_1.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.polynomial import polynomial
from scipy.linalg import cholesky, solve_triangular

from ...base import MOST_STEPS, SAME, SETTLED, Array
from ...bodies import HalfSpace, Indenter, Material, Paraboloid, Specimen
from ..integral import ring_transforms
from ..integral.coulomb import coulomb_series
from ..layered.stuck import half_space_compliances
from ..layered.tense import TenseContact
from ..radii import DENSE
from .body import MeshedBody, at_surface
from .nested import SurfaceContact, nested_events
from .surface import Surface


@dataclass(frozen=True)
class EdgeTuning:
    """The exact half-space under surface tension, and node spacings over the radius between which meshes tell where the
    edge is."""

    near: float = 0.8  # of the vertices' radii, beyond which their contact radii do not lie; choice: spare
    accuracy: float = 1e-7  # theory: a thousandth of what the half-space's own mesh errs by, as below
    # theory: a tenth of a spacing is then half the error of the half-space's own mesh, 1e-4 of the radius
    resolved: float = 5e-4
    # Node spacings over the radius, down to which the half-space's own mesh tells the fraction of a spacing; tuned on
    # the thin layer of `make paper`, by `make paper`: below, what that mesh errs by as a whole is read as one
    telling: float = 1e-2
    # Next to the edge the field of a compressible body oscillates with eta times the logarithm of the distance. Where
    # that is turned too far nodes fall out of step. choice: logarithm of where the turn begins, and the turn; on bonded
    # layers of nu = -0.5, -0.8, -0.95 nodes do below spacings of 0.045, 0.1, 0.16
    phase: tuple[float, float] = (3.8, 1.7)


TUNING = EdgeTuning()


def edge_correction(surface: Surface, body: MeshedBody, reach: float, indenter: Indenter) -> Array:
    """Edge correction of surfaces that slide: contact radius over vertex radius for the candidate vertices beyond the
    flat radius, by increasing radius, out to ``reach`` [m], from the ``surface`` of a half-space like that of the
    ``body``."""
    profile: Indenter = indenter if indenter.a0 > 0 else Paraboloid(reach)
    events = nested_events(SurfaceContact(surface, profile.f(surface.radii)), profile.a0, "radius", np.inf)
    exact = _under_tension(body, profile, events.a) if body.tension else profile.abel
    return _in_step(_edges(exact, profile.a0, events.delta, events.a), profile.a0, events.a) / events.a


def _in_step(edges: Array, a0: float, vertices: Array) -> Array:
    """Radii of the edge (n,) at ``vertices`` [m], those where nodes are close by the fraction of a spacing that it lies
    off the vertices before: it is the same at all radii."""
    spacing = np.gradient(vertices)
    told = spacing >= TUNING.telling * (vertices - a0)
    last = told & (spacing < 2 * TUNING.telling * (vertices - a0))
    if told.all() or not last.any():
        return edges
    fraction = float(np.mean((edges - vertices)[last] / spacing[last]))
    return np.where(told, edges, vertices + fraction * spacing)


def _under_tension(body: MeshedBody, profile: Indenter, radii: Array) -> Callable[[Array], Array]:
    """delta_H [m] over the contact radius [m] near the ``radii``, on a half-space with the surface tension of the
    ``body``."""
    from scipy.interpolate import CubicSpline

    specimen = Specimen((), HalfSpace(at_surface(body.materials[0])), surface_tension=body.tension)
    contact, a0 = TenseContact(profile, specimen), profile.a0
    beyond = np.geomspace(TUNING.near * (radii[0] - a0), (radii[-1] - a0) / TUNING.near, DENSE)
    result = contact.solved(a0 + beyond, contact.plan(a0 + beyond, TUNING.accuracy))
    spline = CubicSpline(np.log(beyond), np.log(result.delta))
    return lambda a: np.exp(spline(np.log(a - a0)))


def _edges(exact: Callable[[Array], Array], a0: float, delta: Array, guess: Array) -> Array:
    """Radii where the ``exact`` displacement is delta: Newton's method in logarithms from the vertex radii."""
    u, step = np.log(guess - a0), SAME
    for _ in range(MOST_STEPS):
        value, ahead = (np.log(exact(a0 + np.exp(at))) for at in (u, u + step))
        change = (value - np.log(delta)) * step / (ahead - value)
        u -= change
        if np.abs(change).max() < SETTLED:
            break
    return a0 + np.exp(u)


# ---------------------------------------------------------------------- surfaces that stick
def finest_spacing(material: Material) -> float:
    """Least spacing of surface vertices over the radius that follows a contact that sticks to the ``material``."""
    eta = abs(_oscillation(at_surface(material))[1])
    start, turn = TUNING.phase
    return math.exp(start - turn / eta) if eta else 0.0


def _oscillation(material: Material) -> tuple[float, float]:
    """Dundurs's constant of the material under a rigid indenter, and the oscillation index."""
    zz, zr, rr = half_space_compliances(material)
    beta = zr / math.sqrt(zz * rr)
    return beta, math.atanh(beta) / math.pi


def edge_rows(surface: Surface, material: Material) -> Array:
    """N M^-1 (n, 2, 2) [m] of each node on the ``surface`` of a half-space of the ``material``, which makes the ramps
    N xi_1 of y; zero on the axis, and where nodes are so close that it does not matter."""
    beyond = surface.radii > 0
    r, rows = surface.radii[beyond], np.column_stack([surface.normal, surface.last])[beyond]
    displaced = np.zeros((len(surface.C), 4))
    displaced[surface.normal, :2] = surface.radii[:, None] ** [0, 2]
    displaced[rows[:, 1], 2:] = r[:, None] ** [1, 3]
    halves = solve_triangular(cholesky(surface.C, lower=True), displaced, lower=True)[rows]
    xi, slope = _densities(material, r)
    unit, profile = [0, 2], [1, 3]
    edge = np.linalg.solve(xi[..., unit], xi[..., profile])  # displacements that take profiles' xi off at r
    M = _over(halves[..., unit], xi[..., unit])
    N = _over(halves[..., unit] @ edge - halves[..., profile], slope[..., unit] @ edge - slope[..., profile])
    reading = np.zeros((surface.radii.size, 2, 2))
    close = np.gradient(surface.radii)[beyond] < TUNING.resolved * r
    reading[beyond] = np.where(close[:, None, None], 0.0, _over(N, M))
    return reading


def _densities(material: Material, r: Array) -> tuple[Array, Array]:
    """xi pi/2 (n, 2, 4) at ``r`` (n,) for the displacements 1, r^2 downwards and r, r^3 outwards, and its slope."""
    beta, eta = _oscillation(material)
    zz, _, rr = half_space_compliances(material)
    waves = [(F[:4], polynomial.polyder(F)[:4]) for F in (coulomb_series(-eta), coulomb_series(eta))]
    C, Q = (np.array(pair) for pair in ring_transforms(beta, *waves))
    outward = math.sqrt(zz / rr)
    factors = np.column_stack([C[:, 0], -4 * C[:, 2], 2 * outward * Q[:, 1], -16 * outward * Q[:, 3]])
    powers = np.array([0, 2, 1, 3])
    return factors * r[:, None, None] ** powers, factors * powers * r[:, None, None] ** np.maximum(powers - 1, 0)


def _over(A: Array, B: Array) -> Array:
    """A B^-1 of the pairs of matrices (n, 2, 2)."""
    return np.swapaxes(np.linalg.solve(np.swapaxes(B, 1, 2), np.swapaxes(A, 1, 2)), 1, 2)
