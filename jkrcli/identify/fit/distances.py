"""Foot points of measured points on the curve of readings, and the signed distances that are minimised.

Every measured point has its own unknown contact radius. At its foot point the distance vector is normal to the curve,
so that these unknowns drop out of the problem (variable projection): a change of the parameters moves the distance by
the normal part of the change of the readings alone. With two columns that derivative is exact; with three it leaves
out the turning of the normal plane, which does not enter the gradient.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from ...series import Array
from .model import Readings

VERTICES = 400  # of the polyline on which the nearest vertex of each point starts its foot point
BEYOND_LAST = 0.4  # of log a, beyond the series, for curves on their way to the solution
BELOW_FOLD = 0.5  # of log a, below the radius where the displacement is stationary: far enough for noise at the fold
STEPS = 8
CLOSE = 1e-6  # of log a; errors of the distance are its square


@dataclass(frozen=True, eq=False)
class Distances:
    """Distances of n points: ``u`` log of the foot points' radii, ``residuals`` (k, n), scaled.

    Two columns: k = 1, the signed normal distance; three: k = 3, the distance vector; ``normal``: the unit normals
    (2, n), or None. ``curvature``: of the curve at the foot, towards the normal, in scaled coordinates (two columns).
    """

    readings: Readings
    u: Array
    residuals: Array
    tangent: Array
    curvature: Array | None

    @property
    def normal(self) -> Array:
        return np.stack([-self.tangent[1], self.tangent[0]])

    def jacobian(self) -> Array:
        """Derivatives of the residuals by the unknowns of all parameters, shape (parameters, k, n)."""
        rates = self.readings.by_parameters(self.u)
        if len(self.readings.columns) == 2:
            return -np.einsum("cn,pcn->pn", self.normal, rates)[:, None]
        along = np.einsum("cn,pcn->pn", self.tangent, rates)
        return -(rates - along[:, None] * self.tangent)


def distances(readings: Readings, points: Array) -> Distances:
    """Nearest points of the curve to the scaled measured ``points`` (columns, n)."""
    u = _nearest_vertices(readings, points)
    for _ in range(STEPS):
        X, first, second = readings.along(u)
        gap = points - X
        length2 = np.einsum("cn,cn->n", first, first)
        slope = np.einsum("cn,cn->n", first, gap)
        bend = length2 - np.einsum("cn,cn->n", second, gap)
        step = np.clip(slope / np.maximum(bend, 0.2 * length2), -0.1, 0.1)
        u = u + step
        if np.max(np.abs(step)) < CLOSE:
            break
    X, first, second = readings.along(u)
    length = np.sqrt(np.einsum("cn,cn->n", first, first))
    tangent, gap = first / length, points - X
    if len(readings.columns) != 2:
        return Distances(readings, u, gap, tangent, None)
    normal = np.stack([-tangent[1], tangent[0]])
    curvature = np.einsum("cn,cn->n", normal, second) / length**2
    return Distances(readings, u, np.einsum("cn,cn->n", normal, gap)[None], tangent, curvature)


def arc(readings: Readings) -> Array:
    """log a of the vertices of the part of the curve on which points are looked for."""
    family = readings.family
    whole = np.linspace(family.low - BELOW_FOLD, family.high, VERTICES // 2)
    s, w = readings.value("modulus"), readings.value("w")
    (D, T, _, _), _, _ = family.at(whole)
    fold = whole[np.argmin(D - np.sqrt(w / s) * T)]
    return np.linspace(max(fold - BELOW_FOLD, whole[0]), family.high + BEYOND_LAST, VERTICES)


def _nearest_vertices(readings: Readings, points: Array) -> Array:
    u = arc(readings)
    vertices = readings.along(u)[0]
    return u[cKDTree(vertices.T).query(points.T)[1]]
