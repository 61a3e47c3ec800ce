"""The finite-element mesh of a case as a result: its size and quality, its picture."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ..base import show
from ..methods.fem.grid import Grid
from .result import Figure, Result


@dataclass(frozen=True, eq=False)
class Meshed(Result):
    """The ``mesh`` of the case in ``file``, fine within the ``reach`` [m] of the expected contact."""

    file: Path
    mesh: Grid
    reach: float

    def summary(self) -> dict[str, Any]:
        mesh, quality = self.mesh, self.mesh.quality()
        return {
            "file": str(self.file),
            "element": mesh.element,
            "elements": len(mesh.cells),
            "vertices": len(mesh.points),
            "r_m": mesh.width,
            "depth_m": mesh.depth,
            "reach_m": self.reach,
            "vertices_within_reach": int(np.sum(mesh.surface_radii() <= self.reach)),
            "quality": {
                "least": float(quality.min()),
                "median": float(np.median(quality)),
                "greatest": float(quality.max()),
            },
        }

    def words(self) -> list[str]:
        summary = self.summary()
        low, middle, high = (summary["quality"][name] for name in ("least", "median", "greatest"))
        return [
            f"{summary['elements']} {summary['element']}s, {summary['vertices']} vertices: {self.file}",
            f"  body      r <= {show(summary['r_m'], 'length')}, depth {show(summary['depth_m'], 'length')}; "
            f"{summary['vertices_within_reach']} surface vertices within the expected contact of "
            f"{show(self.reach, 'length')}",
            f"  quality   {low:.3f} to {high:.3f}, median {middle:.3f} (1 is best)",
        ]

    def figure(self) -> Figure:
        from .plots.body import mesh_figure

        return mesh_figure(self.mesh, self.reach)
