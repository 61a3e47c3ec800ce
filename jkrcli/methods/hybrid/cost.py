"""What one correction costs, before it is computed: operations counted, with rates measured on one core."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .lines import EXTRA, Line
from .region import Region
from .sizes import Resolution, lines

BEGIN = 5e-3  # s
PER_ENTRY = 1e-7  # s, to integrate and factorise, per entry of the stiffness
PER_ENTRY_AND_SIDE = 1.2e-9  # s, to solve, per entry and right-hand side
PER_POINT = 2e-7  # s, for the half-space's field, per Gauss point and parameter t
PER_POINT_AND_PAIR = 2e-9  # s, for their works in one another, per Gauss point and pair of parameters
AROUND = 8e-3  # s, for the field towards its ring, per parameter t, where the modulus changes from the contact on
FILL, OPERATIONS = 4.5, 1.2e10  # entries of the factor beside elements graded to a corner, per unknown; per s
BYTES_PER_ENTRY, BYTES_PER_VALUE = 40.0, 100.0  # of the stiffness and its factor; of the unknowns of one parameter t


@dataclass(frozen=True)
class Cost:
    """CPU ``seconds``, peak ``memory_mib`` [MiB] and ``unknowns`` of one correction."""

    seconds: float
    memory_mib: float
    unknowns: int

    def __add__(self, other: Cost) -> Cost:
        """One after the other."""
        memory, unknowns = max(self.memory_mib, other.memory_mib), max(self.unknowns, other.unknowns)
        return Cost(self.seconds + other.seconds, memory, unknowns)


def cost_of(region: Region, count: int, resolution: Resolution) -> Cost:
    """Of the correction for ``count`` parameters t."""
    r, z = lines(region, resolution)
    pressures = 1 + any(region.mixed) / 3
    unknowns = 2 * pressures * (r.degrees.sum() + 1.0) * (z.degrees.sum() + 1.0)
    entries = 4 * pressures**2 * _pairs(r) * _pairs(z)
    points = float((r.degrees + EXTRA).sum() * (z.degrees + EXTRA).sum())
    fill = 0.0
    if region.corners or region.free_edges:
        fill = FILL * unknowns * 2 * pressures * min(r.degrees.sum(), z.degrees.sum())
    seconds = BEGIN + PER_ENTRY * entries + PER_ENTRY_AND_SIDE * count * (entries + fill)
    seconds += fill * (fill + 2 * entries) / unknowns / OPERATIONS
    seconds += (PER_POINT + PER_POINT_AND_PAIR * count) * points * count + AROUND * count * region.changing
    memory = (BYTES_PER_ENTRY * (entries + fill / 2) + BYTES_PER_VALUE * unknowns * count) / 2**20
    return Cost(float(seconds), float(memory), int(unknowns))


def _pairs(line: Line) -> float:
    """How many pairs of functions overlap."""
    return float(np.sum((line.degrees + 1.0) ** 2))
