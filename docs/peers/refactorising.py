"""Contact by plain scikit-fem: bilinear axisymmetric elements, an active set that factorises anew in every iteration.

    python refactorising.py halfspace 40 1.08 0 > result.json

Arguments: body, nodes per contact radius, growth of the elements outside, rows in a layer.
"""

from __future__ import annotations

import json
import sys
import time

import numpy as np
from bodies import BODIES, axes
from scipy.sparse.linalg import spsolve
from skfem import Basis, BilinearForm, ElementQuad1, ElementVector, MeshQuad
from skfem.helpers import ddot, eye, sym_grad, trace


def stiffness(basis: Basis, E: float, nu: float):
    lame, shear = E * nu / ((1 + nu) * (1 - 2 * nu)), E / (2 * (1 + nu))

    @BilinearForm
    def form(u, v, w):
        r = w.x[0]
        hoop_u, hoop_v = u[0] / r, v[0] / r
        stress = 2 * shear * sym_grad(u) + lame * eye(trace(sym_grad(u)) + hoop_u, 2)
        hoop = 2 * shear * hoop_u + lame * (trace(sym_grad(u)) + hoop_u)
        return 2 * np.pi * r * (ddot(stress, sym_grad(v)) + hoop * hoop_v)

    return form.assemble(basis).tocsc()


def main(name: str, nodes: int, growth: float, rows: int) -> None:
    start, body = time.process_time(), BODIES[name]
    r, z, touching = axes(body, nodes, growth, rows)
    mesh = MeshQuad.init_tensor(r, -z[::-1])
    basis = Basis(mesh, ElementVector(ElementQuad1()))
    K = stiffness(basis, body.E, body.nu)
    x, y = mesh.p
    radial, axial = basis.nodal_dofs
    fixed = np.concatenate([radial[x == 0], radial[y == -z[-1]], axial[y == -z[-1]]])
    top = np.flatnonzero((y == 0) & (x <= r[touching]))
    top = top[np.argsort(x[top])]
    profile = x[top] ** 2 / (2 * body.R)
    u, active, loads, radii, solves = np.zeros(basis.N), np.zeros(top.size, dtype=bool), [], [], 0
    active[0] = True
    for depth in body.depths:
        while True:
            held = np.concatenate([fixed, axial[top[active]]])
            u[:] = 0
            u[axial[top[active]]] = profile[active] - depth
            free = np.setdiff1d(np.arange(basis.N), held)
            u[free] = spsolve(K[free][:, free], -(K @ u)[free])
            solves += 1
            force = -(K @ u)[axial[top]]
            penetrating = ~active & (profile - depth - u[axial[top]] < -1e-12 * depth)
            pulling = active & (force < 0)
            if not (penetrating | pulling).any():
                break
            active = (active | penetrating) & ~pulling
        loads.append(float(force[active].sum()))
        radii.append(float(x[top[active]].max()))
    seconds = time.process_time() - start
    result = {"delta_m": list(body.depths), "P_N": loads, "a_m": radii, "unknowns": int(basis.N), "solves": solves}
    json.dump(result | {"after_imports_cpu_s": seconds}, sys.stdout)


if __name__ == "__main__":
    main(sys.argv[1], int(sys.argv[2]), float(sys.argv[3]), int(sys.argv[4]))
