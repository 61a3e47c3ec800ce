"""Input deck for CalculiX of a paraboloid on a half-space or a layer, and the table that its results give.

    python calculix.py halfspace 87 1.07 0 > run.inp && ccx run && python calculix.py halfspace 87 1.07 0 run.dat

Arguments: body, nodes per largest contact radius, growth of the elements outside, rows in a layer, results. Units: um,
uN, MPa. R is a hundred times the body's and R delta the same: CalculiX measures gaps at displaced radii, which would
stiffen the contact by a per cent at the smaller R. It models a sector of two degrees: 180 of its forces make the load.
Contact radius of an increment: that of the outermost node with a closed gap.
"""

from __future__ import annotations

import sys
from pathlib import Path

from bodies import BODIES, STEPS, Body, axes

FLATTER = 100
SECTORS = 180
TENSION = 1e-3  # of the contact [MPa]
STIFF = (50, 2e4)  # of the contact: times E over the finest element, times E over the thickness [MPa/um]


class Mesh:
    """Body: columns at ``r``, rows at ``z`` [um]; the indenter is one row of elements above the first ``m`` columns."""

    def __init__(self, body: Body, nodes: int, growth: float, rows: int):
        self.body = body = body.flatter(FLATTER)
        r, depths, self.m = axes(body, nodes, growth, rows)
        self.r, self.z = 1e6 * r, -1e6 * depths
        self.E, self.R, self.depth = 1e-6 * body.E, 1e6 * body.R, 1e6 * body.depth
        thin = STIFF[1] * self.E / (1e6 * body.thickness) if body.thickness is not None else 0.0
        self.stiffness = max(STIFF[0] * self.E / self.r[1], thin)
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
        f"{mesh.tool_node(i, j)},{r[i]:.12g},{r[i] ** 2 / (2 * mesh.R) + j:.12g},0"
        for j in (0, 1)
        for i in range(m + 1)
    ]
    lines.append("*ELEMENT, TYPE=CAX4, ELSET=BODY")
    corners = ((0, 1), (1, 1), (1, 0), (0, 0))
    number = 0
    for j in range(z.size - 1):
        for i in range(r.size - 1):
            number += 1
            lines.append(f"{number}," + ",".join(str(mesh.node(i + a, j + b)) for a, b in corners))
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
    steps = [f"{k / STEPS:g},{k / STEPS:g}" for k in range(STEPS + 1)]
    lines += [
        "*MATERIAL, NAME=M", "*ELASTIC", f"{mesh.E},{mesh.body.nu}", "*SOLID SECTION, ELSET=BODY, MATERIAL=M", "1.",
        "*SOLID SECTION, ELSET=TOOL, MATERIAL=M", "1.",
        "*SURFACE INTERACTION, NAME=C", "*SURFACE BEHAVIOR, PRESSURE-OVERCLOSURE=LINEAR",
        f"{mesh.stiffness:.6g},{TENSION}",
        "*CONTACT PAIR, INTERACTION=C, TYPE=NODE TO SURFACE", "SLAVE,MASTER",
        "*AMPLITUDE, NAME=RAMP", *steps,
        f"*STEP, INC={2 * STEPS}", "*STATIC, DIRECT", f"{1 / STEPS},1.",
        "*BOUNDARY", "AXIS,1,1", "BASE,1,2", "TOOL,1,1",
        "*BOUNDARY, AMPLITUDE=RAMP", f"TOOL,2,2,{-mesh.depth:.12g}",
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
            pairs = zip(mesh.r[: mesh.m + 1], heights, strict=True)
            closed = [r for r, u in pairs if r**2 / (2 * mesh.R) - mesh.depth * time < u]
            radius = float(max(closed, default=0.0))
        elif block == "U" and len(words) == 4:
            heights.append(float(words[2]))
        elif block == "RF" and len(words) == 3:
            rows.append(f"{time:g},{-mesh.depth * time:.6E},{float(words[1]):.6E},{radius:.6E}")
            block = ""
    return "\n".join(rows) + "\n"


if __name__ == "__main__":
    name, nodes, growth, rows, *results = sys.argv[1:]
    mesh = Mesh(BODIES[name], int(nodes), float(growth), int(rows))
    sys.stdout.write(table(mesh, Path(results[0]).read_text()) if results else deck(mesh))
