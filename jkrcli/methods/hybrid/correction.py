"""What the body changes against the half-space, as the kernel K(x, t) of the contact equation at a few x and t.

The field on the body is u_t + w_t: the half-space's and a correction, smooth where the body ends or changes away from
the contact. Both obey the same weak form with the loads F_t(v): the half-space's traction on free sides and the stress
(C - C_contact) eps(u_t) where the moduli differ; w_t = -u_t where the body is held. Betti's theorem turns the work
of the pressure of x in w_t into

    pi E* K(x, t) = D(x, t) - F_t(w_x) - F_x(w_t) - A(w_t, w_x)
    D(x, t) = int_held T_x . u_t - int_free T_t . u_x - int (C - C_contact) eps(u_t) : eps(u_x),       T: tractions

which is stationary in w: an error e of the discrete fields enters as A(e, e) only. No surface values are read off, and
nothing is taken near the contact.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from .halfspace import RingField, point_force
from .region import Region
from .sizes import Resolution, extended, lines
from .system import Mesh
from .volume import Patch

Array = np.ndarray


@dataclass(frozen=True, eq=False)
class Correction:
    """K(t_i, t_j) [1/unit of length]; ``asymmetry`` relative to its largest entry; the size of the system solved."""

    K: Array
    asymmetry: float
    unknowns: int
    elements: int


def correction(region: Region, t: Array, resolution: Resolution) -> Correction:
    """K at the parameters ``t`` from one factorisation with as many right-hand sides."""
    return _solved(Mesh(region, *lines(region, resolution)), t)


def side_correction(region: Region, wide: Region, t: Array, resolution: Resolution) -> Correction:
    """What the side of a body whose modulus changes from the contact on adds to K of the ``wide`` body.

    There the correction is not smooth at the contact, but its change by the side is: the wide body has the same mesh up
    to the side, so that errors near the contact cancel, and the integral of both over the top layer in the difference
    begins at the side.
    """
    mesh = Mesh(region, *lines(region, resolution))
    body = _solved(mesh, t, region.width)
    other = _solved(Mesh(wide, extended(mesh.r, wide, resolution), mesh.z), t, region.width)
    return replace(body, K=body.K - other.K, unknowns=body.unknowns + other.unknowns)


def _solved(mesh: Mesh, t: Array, inner: float = 0.0) -> Correction:
    """K; ``inner``: radius inside which D leaves out the top layer."""
    region = mesh.region
    loads = _Loads(mesh, t, inner)
    data = loads.over_layers() + loads.on_base() + loads.on_side()
    prescribed, far = loads.prescribed()
    F = loads.vector
    U = mesh.solve(-F, prescribed)
    AU = mesh.stiffness @ U
    energy = F.T @ U
    reactions = (AU + F).T @ far
    J = data - energy - energy.T - U.T @ AU + reactions[:, None]
    K = J / (np.pi / (1 - region.reference.nu**2))
    asymmetry = float(np.abs(K - K.T).max() / np.abs(K).max())
    return Correction((K + K.T) / 2, asymmetry, int(mesh.free.size), mesh.r.degrees.size * mesh.z.degrees.size)


class _Loads:
    """Gathers the vector F (unknowns, t) and returns the contributions to D (t, t) part by part."""

    def __init__(self, mesh: Mesh, t: Array, inner: float):
        self.mesh, self.t, self.inner = mesh, t, inner
        self.nu = mesh.region.reference.nu
        self.vector = np.zeros((mesh.stiffness.shape[0], t.size))

    def _field(self, r: Array, z: Array) -> RingField:
        return RingField.at(r, z, self.t, self.nu)

    def _add(self, component: int, values: Array) -> None:
        """Add nodal loads (t, z, r) of one component."""
        n = self.mesh.nodes
        self.vector[component * n : (component + 1) * n] += values.reshape(self.t.size, n).T

    def prescribed(self) -> tuple[Array, Array]:
        """Displacements w_t (n, t) of all unknowns, used where held, and the far field (n,) of the whole body there."""
        mesh = self.mesh
        r, z = np.meshgrid(mesh.r.nodes, mesh.z.nodes)
        held = mesh.held
        outer = held.any(axis=0) & (r > 0) | ((r == 0) & (z == z.max()))
        field = self._field(r[outer], z[outer])
        far = np.zeros((2, *mesh.shape))
        far[:, outer] = self._far(r[outer], z[outer])
        w = np.zeros((2, self.t.size, *mesh.shape))
        w[:, :, outer] = far[:, None, outer] - np.stack([field.u_r, field.u_z])
        w *= held[:, None]
        far *= held
        values = np.zeros((mesh.stiffness.shape[0], self.t.size))
        values[: 2 * mesh.nodes] = np.moveaxis(w, 1, -1).reshape(2 * mesh.nodes, -1)
        values[: mesh.nodes].reshape(*mesh.shape, -1)[:, 0] = 0.0
        flat = np.zeros(values.shape[0])
        flat[: 2 * mesh.nodes] = far.ravel()
        return values, flat

    def _far(self, r: Array, z: Array) -> Array:
        """Displacement (2, points) of the outer boundary under the total force pi E* of any pressure; 0 if held."""
        region = self.mesh.region
        if region.far is None:
            return np.zeros((2, r.size))
        E = region.far.E / region.reference.E
        force = np.pi / (1 - self.nu**2)
        return force * np.stack(point_force(r, z, E, region.far.nu))

    def on_base(self) -> Array:
        """Tractions and displacements of the half-space on the base."""
        r, w = self.mesh.r.rule
        z = np.full_like(r, self.mesh.region.depth)
        held = (self.mesh.region.supports.base_r, self.mesh.region.supports.base_z)
        return self._on(r, z, w, held, ("s_rz", "s_zz"), self.mesh.r.basis[0], np.s_[:, -1, :])

    def on_side(self) -> Array:
        """The same on the side."""
        z, w = self.mesh.z.rule
        r = np.full_like(z, self.mesh.region.width)
        held = (self.mesh.region.supports.side_r, self.mesh.region.supports.side_z)
        return self._on(r, z, w, held, ("s_rr", "s_rz"), self.mesh.z.basis[0], np.s_[:, :, -1])

    def _on(
        self,
        r: Array,
        z: Array,
        w: Array,
        held: tuple[bool, bool],
        tractions: tuple[str, str],
        basis: Array,
        nodes: tuple[slice | int, ...],
    ) -> Array:
        """A boundary at the points (r, z) with weights w: where a component is held, its displacement in the tractions;
        where it is free, loads on the ``nodes`` and the tractions in the displacement."""
        field, far = self._field(r, z), self._far(r, z)
        total = np.zeros((self.t.size, self.t.size))
        for i, u in enumerate((field.u_r, field.u_z)):
            traction = 2 * np.pi * w * r * getattr(field, tractions[i])
            if held[i]:
                total += (u - far[i]) @ traction.T
                continue
            loads = np.zeros((self.t.size, *self.mesh.shape))
            loads[nodes] = traction @ basis
            self._add(i, loads)
            total -= traction @ u.T
        return total

    def over_layers(self) -> Array:
        """The stress of the half-space's strains in other materials; of a modulus that changes from the contact on,
        inside ``inner``, its loads only: its work there is singular and in the kernel of the wide body."""
        mesh = self.mesh
        total = np.zeros((self.t.size, self.t.size))
        for slab in Patch.regular(mesh, self.inner).slabs(self.t.size):
            *loads, work = slab.integrals(self.t, self.nu)
            self._add_volume(np.arange(self.t.size), loads)
            total -= work
        if self.inner:
            for j in range(self.t.size):
                *loads, _ = Patch.around(mesh, self.inner, float(self.t[j])).integrals(self.t[j : j + 1], self.nu)
                self._add_volume(np.array([j]), loads)
        return total

    def _add_volume(self, columns: Array, loads: list[Array]) -> None:
        self.vector[:, columns] += np.concatenate([part.reshape(columns.size, -1).T for part in loads])
