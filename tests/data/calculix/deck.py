"""Input deck for CalculiX 2.20 of a paraboloid on a half-space, and the table that its results give.

    python deck.py 200 > run.inp && ccx run && python deck.py 200 run.dat > table.csv

Units: um, uN, MPa. R is a hundred times that of the paper's half-space and R delta the same: CalculiX measures gaps at
displaced radii, which at the smaller R would stiffen the contact by a per cent. The argument is the number of surface
nodes per largest contact radius. Contact radius of an increment: that of the outermost node with a closed gap.
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np

E, NU, R, DEPTH, INCREMENTS = 5000.0, 0.4, 10_000.0, 0.03, 100
A_MAX = (R * DEPTH) ** 0.5
FAR, GROWTH = 400 * A_MAX, 1.12  # where the half-space is cut, growth of the elements away from the contact
STIFFNESS, TENSION = 3e6, 1e-3  # of the contact: MPa/um (50 E over the finest element), MPa


def graded(uniform: int, size: float) -> np.ndarray:
    """``uniform`` intervals of ``size`` from 0, then growing ones out to FAR."""
    x = list(size * np.arange(uniform + 1))
    while x[-1] < FAR:
        x.append(x[-1] + (x[-1] - x[-2]) * GROWTH)
    return np.array(x)


class Mesh:
    """Body: columns at ``r``, rows at ``z``; the indenter is one row of elements above the first ``m`` columns."""

    def __init__(self, nodes_per_radius: int):
        size = A_MAX / nodes_per_radius
        self.m = int(1.2 * nodes_per_radius)
        self.r, self.z = graded(self.m, size), -graded(1, size)
        self.top = 1  # number of the first surface node; rows downwards
        self.tool = self.r.size * self.z.size + 1  # number of the first node of the indenter

    def node(self, i: int, j: int) -> int:
        return 1 + j * self.r.size + i

    def tool_node(self, i: int, j: int) -> int:
        return self.tool + j * (self.m + 1) + i


def deck(mesh: Mesh) -> str:
    r, z, m = mesh.r, mesh.z, mesh.m
    lines = ["*NODE, NSET=NALL"]
    lines += [f"{mesh.node(i, j)},{r[i]:.12g},{z[j]:.12g},0" for j in range(z.size) for i in range(r.size)]
    lines += [
        f"{mesh.tool_node(i, j)},{r[i]:.12g},{r[i] ** 2 / (2 * R) + j:.12g},0" for j in (0, 1) for i in range(m + 1)
    ]
    lines.append("*ELEMENT, TYPE=CAX4, ELSET=BODY")
    corners = ((0, 1), (1, 1), (1, 0), (0, 0))
    number, surface = 0, []
    for j in range(z.size - 1):
        for i in range(r.size - 1):
            number += 1
            lines.append(f"{number}," + ",".join(str(mesh.node(i + a, j + b)) for a, b in corners))
            surface += [number] if j == 0 and i < m else []
    lines.append("*ELEMENT, TYPE=CAX4, ELSET=TOOL")
    first = number + 1
    for i in range(m):
        number += 1
        lines.append(
            f"{number}," + ",".join(str(mesh.tool_node(i + a, b)) for a, b in ((0, 0), (1, 0), (1, 1), (0, 1)))
        )
    lines += ["*NSET, NSET=AXIS", *(f"{mesh.node(0, j)}," for j in range(z.size))]
    lines += ["*NSET, NSET=BASE", *(f"{mesh.node(i, z.size - 1)}," for i in range(r.size))]
    lines += ["*NSET, NSET=TOP", *(f"{mesh.node(i, 0)}," for i in range(m + 1))]
    lines += ["*NSET, NSET=TOOL", *(f"{mesh.tool_node(i, j)}," for j in (0, 1) for i in range(m + 1))]
    lines += ["*SURFACE, NAME=SLAVE, TYPE=NODE", "TOP"]
    lines += ["*SURFACE, NAME=MASTER", *(f"{n},S1" for n in range(first, number + 1))]
    steps = [f"{k / INCREMENTS:g},{k / INCREMENTS:g}" for k in range(INCREMENTS + 1)]
    lines += [
        "*MATERIAL, NAME=M", "*ELASTIC", f"{E},{NU}", "*SOLID SECTION, ELSET=BODY, MATERIAL=M", "1.",
        "*SOLID SECTION, ELSET=TOOL, MATERIAL=M", "1.",
        "*SURFACE INTERACTION, NAME=C", "*SURFACE BEHAVIOR, PRESSURE-OVERCLOSURE=LINEAR", f"{STIFFNESS},{TENSION}",
        "*CONTACT PAIR, INTERACTION=C, TYPE=NODE TO SURFACE", "SLAVE,MASTER",
        "*AMPLITUDE, NAME=RAMP", *steps,
        f"*STEP, INC={2 * INCREMENTS}", "*STATIC, DIRECT", f"{1 / INCREMENTS},1.",
        "*BOUNDARY", "AXIS,1,1", "BASE,1,2", "TOOL,1,1",
        "*BOUNDARY, AMPLITUDE=RAMP", f"TOOL,2,2,{-DEPTH}",
        "*NODE PRINT, NSET=TOP", "U", "*NODE PRINT, NSET=TOOL, TOTALS=ONLY", "RF", "*END STEP",
    ]  # fmt: skip
    return "\n".join(lines) + "\n"


def table(mesh: Mesh, results: str) -> str:
    """Time, displacement, reaction and contact radius of every increment in a .dat file."""
    rows, time, heights, radius = ["time,u2 (um),RF2 (uN),contact radius (um)"], 0.0, [], 0.0
    block = ""
    for line in results.splitlines():
        words = line.split()
        if "displacements" in line:
            block, time, heights = "U", float(words[-1]), []
        elif "total force" in line:
            block = "RF"
            gap = mesh.r[: mesh.m + 1] ** 2 / (2 * R) - DEPTH * time - np.array(heights)
            radius = float(np.max(mesh.r[: mesh.m + 1][gap < 0], initial=0.0))
        elif block == "U" and len(words) == 4:
            heights.append(float(words[2]))
        elif block == "RF" and len(words) == 3:
            rows.append(f"{time:g},{-DEPTH * time:.6E},{float(words[1]):.6E},{radius:.6E}")
            block = ""
    return "\n".join(rows) + "\n"


if __name__ == "__main__":
    mesh = Mesh(int(sys.argv[1]))
    sys.stdout.write(table(mesh, Path(sys.argv[2]).read_text()) if len(sys.argv) > 2 else deck(mesh))
