"""Contact by ContactMechanics: constrained conjugate gradients on a square grid, for a bonded layer.

    python contactmechanics.py thin-layer 256 1.25 > result.json

Arguments: body, points per side, half the side in largest contact radii. The layer repeats periodically beside itself.
On the half-space (FreeFFTElasticHalfSpace) version 1.8.3 stalls at some of the depths, started warm or cold.
"""

from __future__ import annotations

import json
import sys
import time

import ContactMechanics
import numpy as np
from bodies import BODIES
from SurfaceTopography import Topography


def main(name: str, points: int, half: float) -> None:
    start, body = time.process_time(), BODIES[name]
    side = 2 * half * body.a_max
    grid, sides = (points, points), (side, side)
    substrate = ContactMechanics.PeriodicFFTElasticHalfSpace(
        grid, body.E, sides, thickness=body.thickness, poisson=body.nu
    )
    x = (np.arange(points) - points // 2) * side / points
    squares = x[:, None] ** 2 + x**2
    system = ContactMechanics.Systems.NonSmoothContactSystem(substrate, Topography(-squares / (2 * body.R), sides))
    loads, radii, known = [], [], {}
    for depth in body.depths:
        tolerance = 1e-5 * body.E * depth / body.a_max * (side / points) ** 2
        found = system.minimize_proxy(offset=depth, pentol=1e-6 * depth, forcetol=tolerance, maxiter=2000, **known)
        if not found.success:
            raise SystemExit(f"no convergence at a depth of {depth:g} m: {found.message}")
        known = {"initial_displacements": found.x.copy()}
        loads.append(float(found.jac.sum()))
        radii.append(float(np.sqrt(np.count_nonzero(found.jac > 0) / np.pi) * side / points))
    seconds = time.process_time() - start
    result = {"delta_m": list(body.depths), "P_N": loads, "a_m": radii, "unknowns": points**2}
    json.dump(result | {"after_imports_cpu_s": seconds}, sys.stdout)


if __name__ == "__main__":
    main(sys.argv[1], int(sys.argv[2]), float(sys.argv[3]))
