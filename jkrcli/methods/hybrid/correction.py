"""What the body changes against the half-space, as the kernel K(x, t) of the contact equation at a few x and t.

The field on the body is u_t + w_t: the half-space's and a correction, smooth where the body ends or changes away from
the contact. Both obey the same weak form with the loads F_t(v): the half-space's traction on free sides and the stress
(C - C_contact) eps(u_t) where the moduli differ; w_t = -u_t where the body is constrained. Betti's theorem turns the
work of the pressure of x in w_t into

    pi E* K(x, t) = D(x, t) - F_t(w_x) - F_x(w_t) - A(w_t, w_x)
    D(x, t) = int_held T_x . u_t - int_free T_t . u_x - int (C - C_contact) eps(u_t) : eps(u_x),       T: tractions

which is stationary in w: an error e of the discrete fields enters as A(e, e) only. No surface values are read off, and
nothing is taken near the contact. ``RingField`` is the half-space's field u_t, of the pressure of one t.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from ...base import AT_ONCE, Array
from ...formulas.boussinesq import point_force
from ..integral import rule
from .lines import LineElements, extended, lines
from .region import Moduli, Region
from .system import Mesh


@dataclass(frozen=True)
class CorrectionTuning:
    """Quadrature towards a ring where the modulus changes from the contact on, and how much is in memory at a time."""

    towards: float = 0.15  # ratio of successive panels; tuned on graded cylinders, by `make tuning`
    panels: int = 7  # tuned on graded cylinders, by `make tuning`
    points: int = 8  # on each; tuned on graded cylinders, by `make tuning`
    # Of the sum of all entries of the energy without their signs, times eps:
    rounding: float = 0.3  # tuned on a layer on one 2,783 times as stiff, by `make failures`


TUNING = CorrectionTuning()


# ---------------------------------------------------------------------- the half-space
@dataclass(frozen=True, eq=False)
class RingField:
    """Fields of a half-space under the pressures of the contact equation, one per parameter t: (t.size, points).

    The pressure with the Hankel transform p_hat(k) = (E*/2) cos(k t) has, with z downwards, zeta = z + i t and
    rho = sqrt(r^2 + zeta^2), Re rho > 0, a field of elementary functions, as int_0^inf e^(-k zeta) J0(k r) dk = 1/rho.
    All lengths are in one unit, all stresses in units of E of the half-space.

    ``u_r, u_z`` [1/length]; stresses ``s_rr, s_tt, s_zz, s_rz`` and the pressure ``p`` = -lambda div u, finite at
    nu = 1/2 too [E/length^2]. ``u_z`` and z point into the half-space.
    """

    u_r: Array
    u_z: Array
    s_rr: Array
    s_tt: Array
    s_zz: Array
    s_rz: Array
    p: Array
    nu: float

    @classmethod
    def at(cls, r: Array, z: Array, t: Array, nu: float) -> RingField:
        """The fields of the parameters ``t`` at the points (``r``, ``z``) of equal shape, away from r = t, z = 0."""
        zeta = z + 1j * t[:, None]
        rho = np.sqrt(r**2 + zeta**2)
        cube = 1 / rho**3
        sheared = z * cube / rho**2
        narrow = (1 - 2 * nu) / (rho * (rho + zeta))
        loaded, twisted = (zeta * cube).real, ((2 * zeta**2 - r**2) * sheared).real
        half = 0.5 / (1 - nu**2)  # E*/2
        s_zz = -half * (loaded + twisted)
        s_rr = -half * (loaded - twisted + (z * cube - narrow).real)
        s_tt = -4 * half * (1 + nu) / 2 * loaded - s_rr - s_zz
        s_rz = -half * (3 * r * zeta * sheared).real
        u_r = -0.5 / (1 - nu) * r * (narrow - z * cube).real
        u_z = 0.5 / (1 - nu) * (2 * (1 - nu) / rho + z * zeta * cube).real
        return cls(u_r, u_z, s_rr, s_tt, s_zz, s_rz, 2 * nu * half * loaded, nu)

    @property
    def strains(self) -> tuple[Array, Array, Array, Array]:
        """Strains rr, tt, zz and 2 rz [1/length^2], by Hooke's law for E = 1."""
        nu = self.nu
        shear = 0.5 / (1 + nu)
        trace = nu / (1 + nu) * (self.s_rr + self.s_tt + self.s_zz)
        rr, tt, zz = ((s - trace) / (2 * shear) for s in (self.s_rr, self.s_tt, self.s_zz))
        return rr, tt, zz, self.s_rz / shear


# ---------------------------------------------------------------------- the correction
@dataclass(frozen=True, eq=False)
class Correction:
    """Kernel ``K`` (t_i, t_j) [1/unit of length] and its error by ``rounding``; its ``asymmetry`` relative to its
    largest entry; the size of the system solved."""

    K: Array
    rounding: Array
    asymmetry: float
    unknowns: int
    elements: int


def correction(region: Region, t: Array, degree: int) -> Correction:
    """Correction at the parameters ``t`` from one factorisation with as many right-hand sides."""
    return _solved(Mesh(region, *lines(region, degree)), t)


def side_correction(region: Region, wide: Region, t: Array, degree: int) -> Correction:
    """What the side of a body whose modulus changes from the contact on adds to K of the ``wide`` body.

    There the correction is not smooth at the contact, but its change by the side is: the wide body has the same mesh up
    to the side, so that errors near the contact cancel, and the integral of both over the top layer in the difference
    begins at the side.
    """
    mesh = Mesh(region, *lines(region, degree))
    body = _solved(mesh, t, region.width)
    other = _solved(Mesh(wide, extended(mesh.r, wide, degree), mesh.z), t, region.width)
    rounding, unknowns = body.rounding + other.rounding, body.unknowns + other.unknowns
    return replace(body, K=body.K - other.K, rounding=rounding, unknowns=unknowns)


def _solved(mesh: Mesh, t: Array, inner: float = 0.0) -> Correction:
    """Correction on one mesh; ``inner``: radius inside which D leaves out the top layer."""
    region = mesh.region
    loads = _Loads(mesh, t, inner)
    data = sum(loads.on_boundaries(), loads.over_layers())
    prescribed, far = loads.prescribed()
    F = loads.vector
    U = mesh.solve(-F, prescribed)
    energy, (work, moved) = F.T @ U, mesh.work(U)
    J = data - energy - energy.T - work
    if far.any():
        J += ((mesh.stiffness @ U + F).T @ far)[:, None]
    pi_E_star = np.pi / (1 - region.reference.nu**2)
    K = J / pi_E_star
    size = np.abs(F).T @ np.abs(U)
    rounding = TUNING.rounding * (moved + np.finfo(float).eps * (size + size.T)) / pi_E_star
    asymmetry, elements = float(np.abs(K - K.T).max() / np.abs(K).max()), mesh.r.degrees.size * mesh.z.degrees.size
    return Correction((K + K.T) / 2, rounding, asymmetry, int(mesh.free.size), elements)


class _Loads:
    """Loads of the half-space's fields: gathers the vector F (unknowns, t), returns the parts of D (t, t) one by
    one."""

    def __init__(self, mesh: Mesh, t: Array, inner: float):
        self.mesh, self.t, self.inner = mesh, t, inner
        self.nu = mesh.region.reference.nu
        self.vector = np.zeros((mesh.stiffness.shape[0], t.size))

    def _field(self, r: Array, z: Array) -> RingField:
        return RingField.at(r, z, self.t, self.nu)

    def prescribed(self) -> tuple[Array, Array]:
        """Displacements w_t (n, t) of all unknowns, used where constrained, and the far field (n,) of the whole body
        there."""
        mesh = self.mesh
        r, z = np.meshgrid(mesh.r.nodes, mesh.z.nodes)
        constrained = mesh.constrained
        outer = constrained.any(axis=0) & (r > 0) | ((r == 0) & (z == z.max()))
        field = self._field(r[outer], z[outer])
        far = np.zeros((2, *mesh.shape))
        far[:, outer] = self._far(r[outer], z[outer])
        w = np.zeros((2, *mesh.shape, self.t.size))
        w[:, outer] = far[:, outer, None] - np.stack([field.u_r.T, field.u_z.T])
        w *= constrained[..., None]
        w[0, :, 0] = 0.0
        rest = mesh.stiffness.shape[0] - 2 * mesh.nodes
        flat = np.append((far * constrained).ravel(), np.zeros(rest))
        return np.vstack([w.reshape(2 * mesh.nodes, -1), np.zeros((rest, self.t.size))]), flat

    def _far(self, r: Array, z: Array) -> Array:
        """Displacement (2, points) of the outer boundary under the total force pi E* of any pressure; 0 if fixed."""
        region = self.mesh.region
        if region.far is None:
            return np.zeros((2, r.size))
        E = region.far.E / region.reference.E
        force = np.pi / (1 - self.nu**2)
        return force * np.stack(point_force(r, z, E, region.far.nu))

    def on_boundaries(self) -> Iterator[Array]:
        """Parts of D on the base and on the side: where a component is fixed, its displacement in the tractions; where
        it is free, loads on the nodes there and the tractions in the displacement."""
        mesh, region = self.mesh, self.mesh.region
        (r, w_r), (z, w_z) = mesh.r.rule, mesh.z.rule
        base = (r, np.full_like(r, region.depth), w_r), region.base, ("s_rz", "s_zz"), mesh.r, np.s_[:, -1, :]
        side = (np.full_like(z, region.width), z, w_z), region.side, ("s_rr", "s_rz"), mesh.z, np.s_[:, :, -1]
        for (x, y, w), held, tractions, line, nodes in (base, side):
            field, far, total = self._field(x, y), self._far(x, y), np.zeros((self.t.size, self.t.size))
            for i, u in enumerate((field.u_r, field.u_z)):
                traction = 2 * np.pi * w * x * getattr(field, tractions[i])
                if held[i]:
                    total += (u - far[i]) @ traction.T
                    continue
                loads = np.zeros((self.t.size, *mesh.shape))
                loads[nodes] = traction @ line.basis[0]
                self.vector[i * mesh.nodes : (i + 1) * mesh.nodes] += loads.reshape(self.t.size, mesh.nodes).T
                total -= traction @ u.T
            yield total

    def over_layers(self) -> Array:
        """Part of D by the stress of the half-space's strains in other materials; of a modulus that changes from the
        contact on, inside ``inner``, its loads only: its work there is singular and in the kernel of the wide body."""
        mesh = self.mesh
        total = np.zeros((self.t.size, self.t.size))
        for slab in Patch.regular(mesh, self.inner).slabs(self.t.size):
            total -= self._loaded_by(slab, np.arange(self.t.size))
        if self.inner:
            for j, t in enumerate(self.t.tolist()):
                self._loaded_by(Patch.around(mesh, self.inner, t), np.array([j]))
        return total

    def _loaded_by(self, patch: Patch, which: Array) -> Array:
        """Add the loads of some of the t on a patch; the work there."""
        *loads, work = patch.integrals(self.t[which], self.nu)
        self.vector[:, which] += np.concatenate([part.reshape(which.size, -1).T for part in loads])
        return work


@dataclass(frozen=True, eq=False)
class Patch:
    """A part of a layer of another material, as products of quadrature points along ``r`` and ``z``: weights (z, r),
    2 pi r included, shape functions, their derivatives and pressure functions along each, and moduli over z."""

    r: Array
    z: Array
    weights: Array
    along_r: tuple[Array, Array, Array]
    along_z: tuple[Array, Array, Array]
    moduli: Moduli

    @classmethod
    def regular(cls, mesh: Mesh, inner: float) -> Patch:
        """Patch of the Gauss points of all other materials; not of the top layer inside the radius ``inner``."""
        (r, w_r), (z, w_z) = mesh.r.rule, mesh.z.rule
        rows = np.flatnonzero(mesh.region.differs(z))
        near = (r < inner) & (mesh.region.layer_at(z[rows]) == 0)[:, None]
        weights = 2 * np.pi * w_z[rows][:, None] * (w_r * r) * ~near
        V_z, D_z = mesh.z.basis
        along_z = (V_z[rows], D_z[rows], mesh.pressure[1][rows])
        return cls(r, z[rows], weights, (*mesh.r.basis, mesh.pressure[0]), along_z, mesh.moduli.at(rows))

    @classmethod
    def around(cls, mesh: Mesh, inner: float, t: float) -> Patch:
        """Patch in the top layer inside ``inner``, of points that crowd towards the ring r = t, z = 0, where stresses
        are singular."""
        r, w_r = _crowded(mesh.r, inner, t)
        z, w_z = _crowded(mesh.z, mesh.region.first, 0.0)
        weights = 2 * np.pi * w_z[:, None] * (w_r * r)
        (V, D, Q), (V_z, D_z, Q_z) = mesh.r.at(r, mesh.joined[0]), mesh.z.at(z, mesh.joined[1])
        return cls(r, z, weights, (V, D, Q), (V_z, D_z, Q_z[:, mesh.used]), mesh.region.moduli(z))

    def slabs(self, count: int) -> Iterator[Patch]:
        """Patches that are slices of z, for ``count`` parameters t at a time within the memory allowed."""
        rows = max(1, AT_ONCE // (count * self.r.size))
        for start in range(0, self.z.size, rows):
            part = slice(start, start + rows)
            V_z, D_z, Q_z = self.along_z
            along_z = (V_z[part], D_z[part], Q_z[part])
            yield Patch(self.r, self.z[part], self.weights[part], self.along_r, along_z, self.moduli.at(part))

    def integrals(self, t: Array, nu: float) -> tuple[Array, Array, Array, Array]:
        """Integrals of the stress (C - C_contact) eps(u_t): loads (t, z, r) of u_r, u_z and of the pressures, and its
        work (t, t) in the strains of every u_t."""
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


def _crowded(line: LineElements, stop: float, centre: float) -> tuple[Array, Array]:
    """Gauss points and weights between 0 and ``stop``, panels ending at the line's edges and crowding at ``centre``."""
    away = stop * TUNING.towards ** np.arange(TUNING.panels)
    edges = np.concatenate([line.edges, centre - away, centre + away, [centre, 0.0, stop]])
    edges = np.unique(edges[(edges >= 0) & (edges <= stop)])
    nodes, weights = rule(TUNING.points)
    half = np.diff(edges)[:, None] / 2
    return np.ravel(edges[:-1, None] + half * (1 + nodes)), np.ravel(half * weights)
