"""Integrals over layers of another material: the stress (C - C_contact) eps(u_t) in test functions, and in itself."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from .halfspace import RingField
from .lines import Line
from .region import Moduli
from .system import Mesh

Array = np.ndarray
TOWARDS, TIMES, POINTS = 0.15, 7, 8  # panels towards a singularity: ratio, number, Gauss points on each
AT_ONCE = 1_000_000  # points times parameters t whose fields are held at a time: about 200 MB


@dataclass(frozen=True, eq=False)
class Patch:
    """Products of quadrature points along ``r`` and ``z`` with weights (2 pi r included), shape functions and their
    derivatives there, pressure functions, and moduli over z; ``weights`` (z, r)."""

    r: Array
    z: Array
    weights: Array
    along_r: tuple[Array, Array, Array]
    along_z: tuple[Array, Array, Array]
    moduli: Moduli

    @classmethod
    def regular(cls, mesh: Mesh, inner: float) -> Patch:
        """At the Gauss points of all other materials; not of the top layer inside the radius ``inner``."""
        (r, w_r), (z, w_z) = mesh.r.rule, mesh.z.rule
        rows = np.flatnonzero(mesh.region.differs(z))
        near = (r < inner) & (mesh.region.layer_at(z[rows]) == 0)[:, None]
        weights = 2 * np.pi * w_z[rows][:, None] * (w_r * r) * ~near
        V_z, D_z = mesh.z.basis
        along_z = (V_z[rows], D_z[rows], mesh.pressure[1][rows])
        moduli = Moduli(mesh.moduli.C[:, rows], mesh.moduli.inverse_lame[rows], mesh.moduli.mixed[rows])
        return cls(r, z[rows], weights, (*mesh.r.basis, mesh.pressure[0]), along_z, moduli)

    @classmethod
    def around(cls, mesh: Mesh, inner: float, t: float) -> Patch:
        """In the top layer inside ``inner``, at points that crowd towards the ring r = t, z = 0, where stresses are
        singular."""
        r, w_r = _crowded(mesh.r, 0.0, inner, t)
        z, w_z = _crowded(mesh.z, 0.0, mesh.region.first, 0.0)
        weights = 2 * np.pi * w_z[:, None] * (w_r * r)
        (V, D, Q), (V_z, D_z, Q_z) = mesh.r.at(r, mesh.joined[0]), mesh.z.at(z, mesh.joined[1])
        return cls(r, z, weights, (V, D, Q), (V_z, D_z, Q_z[:, mesh.used]), mesh.region.moduli(z))

    def slabs(self, count: int) -> Iterator[Patch]:
        """The same in slices of z, for ``count`` parameters t at a time within ``AT_ONCE``."""
        rows = max(1, AT_ONCE // (count * self.r.size))
        for start in range(0, self.z.size, rows):
            part = slice(start, start + rows)
            V_z, D_z, Q_z = self.along_z
            moduli = Moduli(self.moduli.C[:, part], self.moduli.inverse_lame[part], self.moduli.mixed[part])
            along_z = (V_z[part], D_z[part], Q_z[part])
            yield Patch(self.r, self.z[part], self.weights[part], self.along_r, along_z, moduli)

    def integrals(self, t: Array, nu: float) -> tuple[Array, Array, Array, Array]:
        """Loads (t, z, r) of u_r, u_z and of the pressures, and the stresses' work (t, t) in one another's strains."""
        R, Z = np.meshgrid(self.r, self.z)
        field = RingField.at(R.ravel(), Z.ravel(), t, nu)
        grid = (t.size, *R.shape)
        rr, tt, zz, rz = strains = [strain.reshape(grid) for strain in field.strains]
        C11, C12, C13, C33, C44 = self.moduli.C[:, :, None]
        mixed = self.moduli.mixed[:, None]
        p = field.p.reshape(grid)
        own = np.where(mixed, p, 0.0)
        s_rr = (C11 * rr + C12 * tt + C13 * zz - field.s_rr.reshape(grid) - own) * self.weights
        s_tt = (C12 * rr + C11 * tt + C13 * zz - field.s_tt.reshape(grid) - own) * self.weights
        s_zz = (C13 * (rr + tt) + C33 * zz - field.s_zz.reshape(grid) - own) * self.weights
        s_rz = (C44 * rz - field.s_rz.reshape(grid)) * self.weights
        misfit = (np.where(mixed, rr + tt + zz, 0.0) + self.moduli.inverse_lame[:, None] * p) * self.weights
        (V, D, Q), (V_z, D_z, Q_z) = self.along_r, self.along_z
        work = sum(_work(s, e) for s, e in zip((s_rr, s_tt, s_zz, s_rz), strains, strict=True))
        return (
            V_z.T @ (s_rr @ D + (s_tt / self.r) @ V) + D_z.T @ (s_rz @ V),
            D_z.T @ (s_zz @ V) + V_z.T @ (s_rz @ D),
            -Q_z.T @ (misfit @ Q),
            np.asarray(work) - _work(misfit, p),
        )


def _work(stress: Array, strain: Array) -> Array:
    return stress.reshape(len(stress), -1) @ strain.reshape(len(strain), -1).T


def _crowded(line: Line, start: float, stop: float, centre: float) -> tuple[Array, Array]:
    """Gauss points and weights between ``start`` and ``stop``, panels ending at the line's edges and crowding at
    ``centre``."""
    away = (stop - start) * TOWARDS ** np.arange(TIMES)
    edges = np.concatenate([line.edges, centre - away, centre + away, [centre, start, stop]])
    edges = np.unique(edges[(edges >= start) & (edges <= stop)])
    nodes, weights = np.polynomial.legendre.leggauss(POINTS)
    half = np.diff(edges)[:, None] / 2
    return np.ravel(edges[:-1, None] + half * (1 + nodes)), np.ravel(half * weights)
