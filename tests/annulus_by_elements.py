"""Contact of a paraboloid with a layer, with a tension of finite range around it, by finite elements with that tension
as a load: no kernel, no density, no condition at the edge. Shares no code with what it stands against.

With the tension on the whole disc r < c as a load, the further pressure q between the surfaces obeys the ordinary
conditions of contact, q >= 0, gap >= 0, q gap = 0, so that the node at the edge has q = 0. c is where the gap is the
range.
"""

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import skfem
from scipy.optimize import brentq
from scipy.sparse.linalg import splu
from skfem.helpers import ddot, eye, sym_grad, trace

Array = np.ndarray


@skfem.BilinearForm
def stiffness(u, v, w):
    """Elasticity of a body of revolution per radian, (u_r, u_z)."""
    r, e, hoop = w.x[0], sym_grad(u), u[0] / w.x[0]
    volume = trace(e) + hoop
    stress = 2 * w["mu"] * e + w["lam"] * eye(volume, 2)
    return (ddot(stress, sym_grad(v)) + (2 * w["mu"] * hoop + w["lam"] * volume) * v[0] / r) * r


@dataclass(frozen=True)
class ElementLayer:
    """A layer of thickness 1 m bonded to a rigid base, E* = 1 Pa, in second-order squares of the side 1/``rows`` [m]
    at the surface out to the radius ``fine``, and wider ones out to ``width`` [m]; the indenter's radius ``R`` [m]."""

    nu: float
    R: float
    rows: int
    fine: float = 4.0
    width: float = 16.0

    @cached_property
    def solved(self) -> tuple[Array, Array]:
        """Radii of the surface's nodes, vertices and middles in turn, and downward displacements there under unit
        downward forces there [m/N]."""
        r = np.linspace(0, self.fine, round(self.fine * self.rows) + 1)
        while r[-1] < self.width:
            r = np.append(r, r[-1] + 1.2 * (r[-1] - r[-2]))
        mesh = skfem.MeshQuad.init_tensor(r, np.linspace(-1, 0, self.rows + 1))
        basis = skfem.Basis(mesh, skfem.ElementVector(skfem.ElementQuad2()), intorder=5)
        E = 1 - self.nu**2
        K = stiffness.assemble(basis, mu=E / 2 / (1 + self.nu), lam=E * self.nu / (1 + self.nu) / (1 - 2 * self.nu))
        x, y = basis.doflocs
        radial, vertical = basis.split_indices()
        free = np.setdiff1d(np.arange(x.size), np.concatenate([np.flatnonzero(y == -1), radial[x[radial] == 0]]))
        top = vertical[(y[vertical] == 0) & (x[vertical] <= self.fine)]
        top = top[np.argsort(x[top])]
        loads = np.zeros((x.size, top.size))
        loads[top, np.arange(top.size)] = 1 / (2 * math.pi)
        factor = splu(K[free][:, free].tocsc())
        return x[top], factor.solve(loads[free])[np.searchsorted(free, top)]

    def tension(self, c: float) -> Array:
        """Forces [N] on the nodes that stand for the unit pressure on the disc r < c."""
        r, _ = self.solved
        forces = np.zeros(r.size)
        nodes, weights = np.polynomial.legendre.leggauss(4)
        for i in range(0, r.size - 2, 2):
            lo, hi = r[i], r[i + 2]
            if c <= lo:
                break
            x = lo + (min(c, hi) - lo) * (nodes + 1) / 2
            parts = self._shapes((x - lo) / (hi - lo)) * 2 * math.pi * x * weights * (min(c, hi) - lo) / 2
            forces[i : i + 3] += parts.sum(axis=1)
        return forces

    @staticmethod
    def _shapes(t: Array) -> Array:
        return np.array([(1 - t) * (1 - 2 * t), 4 * t * (1 - t), t * (2 * t - 1)])

    def state(self, k: int, stress: float, length: float) -> tuple[float, float, float]:
        """delta [m], P [N] and c [m] where the surfaces touch up to the vertex k and attract up to ``length`` [m]."""
        r, C = self.solved
        n = 2 * k
        matrix = np.zeros((n + 1, n + 1))
        matrix[:, :n], matrix[:, n] = C[: n + 1, :n], -1
        inverse = np.linalg.inv(matrix)

        def at(c: float) -> tuple[float, float, float]:
            pulled = -stress * self.tension(c)
            free = C @ pulled
            found = inverse @ (-(r[: n + 1] ** 2) / 2 / self.R - free[: n + 1])
            forces, delta = found[:n], found[n]
            gap = r**2 / 2 / self.R - delta + free + C[:, :n] @ forces
            i = 2 * min(int(np.searchsorted(r[::2], c)) - 1, r.size // 2 - 1)
            there = self._shapes(np.array([(c - r[i]) / (r[i + 2] - r[i])]))[:, 0] @ gap[i : i + 3]
            return there, delta, float(np.sum(forces) + np.sum(pulled))

        c = float(brentq(lambda c: at(c)[0] - length, r[n] * (1 + 1e-9), r[-1], xtol=1e-12))
        return at(c)[1], at(c)[2], c
