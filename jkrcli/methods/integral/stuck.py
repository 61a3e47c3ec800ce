"""The contact equation of a disc that sticks: two densities, for the pressure and for the shear.

With the Hankel transforms p_hat of the pressure and q_hat of the shear on the surface, the displacements are

    u_z^ = 2/(E* k) (g_zz p_hat + g_zr q_hat),     u_r^ = 2/(E* k) (g_zr p_hat + g_rr q_hat),

and deep inside the top material g_zz = g_rr = 1, g_zr = beta (Dundurs's constant; 0 at nu = 1/2). Where beta = 0 let
p_hat = (E*/2) int phi cos(kt) dt, q_hat = (E*/2) int psi sin(kt) dt over (0, a). Else the half-space's own equation is
singular and its solution oscillates at the edge; it is solved in closed form by Coulomb waves F(eta, kt) in place of
sine and cosine, with tanh(pi eta) = beta and X+- = (F'(-+eta) , +-F(-+eta))/sqrt(1 +- beta) for (phi, psi):

    p_hat = (E*/2) int (C phi_1 + C psi_2),  C = (X+ + X-)/2,       q_hat likewise with Q = (X+ - X-)/2.

These fields of rings do no work on each other in a half-space (they stick inside their ring, and the outer ring's
displacements vanish there), so that for any body, with d_zz = g_zz - 1, d_zr = g_zr - beta, d_rr = g_rr - 1 that decay,

    xi + (2/pi) int K xi dt = (2/pi) (Lambda, 0),     K = int (d_zz C C^T + d_zr (C Q^T + Q C^T) + d_rr Q Q^T) dk

for a unit displacement, Lambda^2 = pi eta coth(pi eta). S = pi E* Lambda int xi_1, S' = (pi^2 E*/2) |xi(a)|^2. The
matrices are nested as those of ``equation``, with two rows for each node.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import TypeAlias

import numpy as np

from ...base import Array
from .coulomb import coulomb_waves
from .equation import forward_substitution, nested_factor, rounding_error
from .quadrature import Panels

Pair: TypeAlias = tuple[Array, Array]


@dataclass(frozen=True, eq=False)
class StuckKernel:
    """The no-slip kernel, of both densities: ``weights`` (3, k) are those of quadrature at the wave numbers ``k`` [1/m]
    times d_zz, d_zr, d_rr; ``beta``: Dundurs's constant."""

    k: Array
    weights: Array
    beta: float

    @property
    def eta(self) -> float:
        """Oscillation index of the edge."""
        return math.atanh(self.beta) / math.pi

    @property
    def Lambda(self) -> float:
        """Root of the half-space's stiffness over that of the sliding one."""
        return math.sqrt(math.pi * self.eta / math.tanh(math.pi * self.eta)) if self.eta else 1.0

    def square(self, x: Array) -> Array:
        """K (2n, 2n) at the nodes ``x`` (n,) [m]: both densities of the first node, both of the second, ..."""
        n, K = x.size, np.zeros((2, 2, x.size, x.size))
        zz, zr, rr = self.weights
        if self.eta == 0:
            sine, cosine = coulomb_waves(0.0, np.outer(x, self.k))
            K[0, 0], K[1, 1] = (cosine * zz) @ cosine.T, (sine * rr) @ sine.T
            K[0, 1] = (cosine * zr) @ sine.T
            K[1, 0] = K[0, 1].T
        elif self.k.size:
            rho = np.outer(x, self.k)
            C, Q = ring_transforms(self.beta, coulomb_waves(-self.eta, rho), coulomb_waves(self.eta, rho))
            for i in range(2):
                left = C[i] * zz + Q[i] * zr, C[i] * zr + Q[i] * rr
                for j in range(2):
                    K[i, j] = left[0] @ C[j].T + left[1] @ Q[j].T
        return K.transpose(2, 0, 3, 1).reshape(2 * n, 2 * n)


def ring_transforms(beta: float, minus: Pair, plus: Pair) -> tuple[Pair, Pair]:
    """C and Q of either density from F and F' of -eta and of +eta."""
    (Fm, sm), (Fp, sp) = minus, plus
    first, second = 0.5 / math.sqrt(1 + beta), 0.5 / math.sqrt(1 - beta)
    C = first * sm + second * sp, first * Fm - second * Fp
    Q = first * sm - second * sp, first * Fm + second * Fp
    return C, Q


@dataclass(frozen=True, eq=False)
class StuckDisc:
    """Flat ends that stick, pressed by a unit displacement, of all radii of the ``panels``.

    ``S`` [m], ``dS`` [-]: S and S' over 2 E*; ``residual`` (radii b, radii x, 2): what the displacements of the end of
    radius b lack at x to the unit one, as the equation has them (0 inside b in the first place; the formula goes on).
    """

    panels: Panels
    Lambda: float
    eta: float
    S: Array
    residual: Array
    largest: float

    @classmethod
    def of(cls, kernel: StuckKernel, panels: Panels) -> StuckDisc:
        """Solve; SolveError where the panels do not resolve the kernel."""
        n, root = 2 * panels.x.size, np.repeat(np.sqrt(panels.w), 2)
        K = 2 / math.pi * kernel.square(panels.places)
        factor = nested_factor(K[:n, :n], root, panels, "the kernel of contact without slip")
        unit = np.zeros(n)
        unit[::2] = kernel.Lambda
        right = np.column_stack([root * unit, root[:, None] * K[:n, n:]])
        forward = forward_substitution(factor, right)
        y, last = forward[:, 0], 2 * panels.stops - 1
        sums = np.cumsum(y[:, None] * forward[:, 1:], axis=0)[last].reshape(last.size, last.size, 2)
        residual = np.array([kernel.Lambda, 0.0]) - sums
        largest = float(np.max(np.abs(np.diag(K)), initial=0.0))
        return cls(panels, kernel.Lambda, kernel.eta, np.cumsum(y**2)[last], residual, largest)

    @cached_property
    def dS(self) -> Array:
        each = np.arange(self.S.size)
        return np.sum(self.residual[each, each] ** 2, axis=1)

    @property
    def rounding(self) -> Array:
        """Relative error that the rounding of K lets expect at each radius, as that of ``EquationResult``."""
        return rounding_error(self.panels, self.largest, self.S)
