"""A paraboloid on a bonded layer, or half-space, that relaxes, with a cohesive stress, by rings of constant pressure:
no transformation, no density, no condition at the edge. Shares no code with what it stands against.

Rings touch (no gap), are pulled (the cohesive stress while the gap is less than the range) or free. The outermost that
touches is under the cohesive stress, the one at the end of the zone has the gap of the range under a part of it: each
number of touching rings has its displacement, between two of which the wanted one lies. E* = 1 at t = 0, r = ratio +
(1 - ratio) exp(-t): the surface u under p of the rings obeys C p = u - (1 - ratio) xi, xi' = u - xi.
"""

import math

import numpy as np
from layer_contact import compliance
from scipy.special import ellipe, ellipk, j0, j1

Array = np.ndarray
MEANS = 6  # circles over a ring


def ring_compliance(edges: Array, nu: float | None) -> Array:
    """Mean displacements of rings between ``edges`` under unit pressures; ``nu``: of a layer of thickness 1; None: a
    half-space."""
    areas = edges[:-1, None] ** 2 + np.diff(edges**2)[:, None] * (np.arange(MEANS) + 0.5) / MEANS
    r, b = np.sqrt(areas).reshape(-1, 1), edges[None, 1:]
    small, large = np.minimum(r / b, 1), np.minimum(b / r, 1)
    outside = r * (ellipe(large**2) - (1 - large**2) * ellipk(np.minimum(large**2, 1 - 1e-15)))
    discs = 4 / math.pi * np.where(r < b, b * ellipe(small**2), outside)
    if nu is not None:
        panels = np.append(0, np.geomspace(1e-3, 40, 40))
        x, w = np.polynomial.legendre.leggauss(16)
        half = np.diff(panels)[:, None] / 2
        k, dk = (panels[:-1, None] + half * (1 + x)).ravel(), (half * w).ravel()
        discs = discs + (j0(r * k) * (2 * (compliance(k, nu) - 1) * dk)) @ (b.T / k * j1(b.T * k)).T
    means = discs.reshape(-1, MEANS, edges.size - 1).mean(axis=1)
    return np.diff(means, axis=1, prepend=0.0)


def withdrawn(
    R: float, stress: float, length: float, ratio: float, t: Array, delta: Array, end: float, rings: int,
    nu: float | None = None,
) -> Array:  # fmt: skip
    """Loads at the times ``t`` of displacements ``delta`` on ``rings`` out to ``end``, up to the loss of contact; the
    first is put on at once."""
    edges = np.linspace(0, end, rings + 1)
    C, squares = ring_compliance(edges, nu), (edges[1:] ** 2 + edges[:-1] ** 2) / 2
    area, u, xi = math.pi * np.diff(edges**2), np.zeros(rings), np.zeros(rings)
    i, ends, loads = int(0.4 * rings), 0, list[float]()
    for h, depth in zip(np.diff(t, prepend=t[0]), delta, strict=True):
        decay, mean = math.exp(-h), -math.expm1(-h) / h if h else 1.0  # u moves evenly: xi = kept + (1 - mean) u
        kept = decay * xi + (mean - decay) * u
        give, dent = 1 / (1 - (1 - ratio) * (1 - mean)), (1 - ratio) * kept
        profile = squares / (2 * R) + give * dent  # what a rigid tip would have on a body without a dent

        def state(i: int, profile: Array = profile, give: float = give) -> tuple[float, Array]:
            """Displacement and pressures with ``i`` touching rings."""
            nonlocal ends
            low = max(i, ends - 4)
            j = low
            while True:
                pulled = np.where((np.arange(rings) >= i - 1) & (np.arange(rings) < j), -stress, 0.0)
                rows = np.append(np.arange(i), j)
                wanted = give * C[rows] @ pulled + profile[rows] - np.where(rows == j, length, 0.0)
                matrix = np.column_stack([give * C[np.ix_(rows, np.append(np.arange(i - 1), j))], -np.ones(i + 1)])
                found = np.linalg.solve(matrix, -wanted)
                pulled[np.append(np.arange(i - 1), j)] = found[:-1]
                if found[-2] <= 0 and j == low > i:
                    low = j = max(i, low - 8)
                    continue
                if found[-2] <= 0:
                    ends = j
                    return float(found[-1]), pulled
                j += 1

        try:
            here = state(i)
            while here[0] > depth and i > 2:
                i, above = i - 1, here
                here = state(i)
            if here[0] > depth:
                break
            while (above := state(i + 1))[0] < depth:
                i, here = i + 1, above
        except IndexError:
            break
        part = (depth - here[0]) / (above[0] - here[0])
        p = here[1] + part * (above[1] - here[1])
        surface = give * (C @ p + dent)
        xi, u = kept + (1 - mean) * surface, surface
        loads.append(area @ p)
    return np.array(loads)
