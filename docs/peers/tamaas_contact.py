"""Contact by tamaas: Polonsky and Keer's conjugate gradients on a square grid, free half-space.

    python tamaas_contact.py halfspace 128 1.15 > result.json

Arguments: body, points per side, half the side in largest contact radii. It has no layers.
"""

from __future__ import annotations

import json
import sys
import time

import numpy as np
import tamaas as tm
from bodies import BODIES


def main(name: str, points: int, half: float) -> None:
    start, body = time.process_time(), BODIES[name]
    tm.set_log_level(tm.LogLevel.warning)
    side = 2 * half * body.a_max
    model = tm.ModelFactory.createModel(tm.model_type.basic_2d, [side, side], [points, points])
    model.E, model.nu = body.E, body.nu
    tm.ModelFactory.registerNonPeriodic(model, "free")
    x = (np.arange(points) - points // 2) * side / points
    surface = -(x[:, None] ** 2 + x**2) / (2 * body.R)
    solver = tm.PolonskyKeerRey(model, surface, 1e-9)
    solver.setIntegralOperator("free")
    raised = np.zeros_like(surface)
    cell, loads, radii, displacements = (side / points) ** 2, [], [], []
    for P in hertz(body):
        solver.solve(P / side**2)
        pressure = np.asarray(model.traction)
        touching = pressure > 0
        model.operators["free"](model.traction, raised)
        displacements.append(float(np.mean((raised - surface)[touching])))
        loads.append(float(pressure.sum() * cell))
        radii.append(float(np.sqrt(np.count_nonzero(touching) * cell / np.pi)))
    seconds = time.process_time() - start
    result = {"delta_m": displacements, "P_N": loads, "a_m": radii, "unknowns": points**2}
    json.dump(result | {"after_imports_cpu_s": seconds}, sys.stdout)


def hertz(body) -> np.ndarray:
    """Loads to ask for [N]: it is controlled by the load."""
    return 4 / 3 * body.E / (1 - body.nu**2) * np.sqrt(body.R * body.depths**3)


if __name__ == "__main__":
    main(sys.argv[1], int(sys.argv[2]), float(sys.argv[3]))
