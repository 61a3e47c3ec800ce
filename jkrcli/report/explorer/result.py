"""What was written of an explorer page, in words and as JSON."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ..result import Result


@dataclass(frozen=True)
class Explored(Result):
    """The ``page`` of the series in ``file``, of so many ``rows``, that begins with ``w`` [J/m^2], and what was laid
    over it."""

    file: Path
    page: Path
    w: float
    rows: int
    curves: int
    measured_rows: int

    @property
    def size(self) -> int:
        """Bytes of the page."""
        return self.page.stat().st_size

    def summary(self) -> dict[str, Any]:
        written = {"file": str(self.file), "page": str(self.page), "bytes": self.size, "w_J_per_m2": self.w}
        return written | {"measured_curves": self.curves, "measured_points": self.measured_rows}

    def words(self) -> list[str]:
        overlaid = f", {self.measured_rows} measured points in {self.curves} curves" if self.curves else ""
        return [
            f"{self.rows} points{overlaid}: {self.file}",
            f"  written {self.page} ({self.size / 1e6:.1f} MB): open it in a browser",
        ]
