"""Maps as images over their pixels, and fits in HDF5."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ..base.hdf5 import Dataset, Group, unit_column
from ..base.numerics import Array
from ..base.units import SI
from ..report.archive import FITS, write
from .procedure import Failure
from .result import Fit

IMAGES = {  # name: dimension
    "E_star": "modulus",
    "w": "work",
    "contact_point": "length",
    "adhesion_force": "load",
    "quality": "number",
    "status": "number",
}
FITTED, DOUBTFUL, UNUSABLE = "fitted", "doubtful", "unusable"
STATUSES = (UNUSABLE, DOUBTFUL, FITTED)  # by their numbers in an image
LEAST_CURVES = 3  # choice: from which on curves without a grid are drawn together, as they are summed up in a line


def status_of(item: Fit | Failure) -> str:
    """Whether a curve was fitted, and is to be believed."""
    if isinstance(item, Failure):
        return UNUSABLE
    return FITTED if (not item.flags if item.grade is None else item.grade.believed) else DOUBTFUL


@dataclass(frozen=True, eq=False)
class Map:
    """``images`` (rows, columns) by their names in ``IMAGES``, SI, NaN where nothing was found; ``x, y`` [m] of their
    columns and rows, the rows and columns that hold no curve left out; their numbers where no ``positions`` are
    known."""

    x: Array
    y: Array
    images: Mapping[str, Array]
    positions: bool = True

    @property
    def words(self) -> str:
        """How many columns and rows."""
        return f"{self.x.size} x {self.y.size}"


def map_of(outcomes: Sequence[Fit | Failure]) -> Map | None:
    """The map that the curves make; None where they were not taken on a grid, or several share a pixel."""
    pixels = [item.pixel for item in outcomes if item.pixel is not None]
    if len(pixels) < 2 or len(pixels) != len(outcomes) or len({(at.column, at.row) for at in pixels}) != len(outcomes):
        return None
    columns, column = np.unique([at.column for at in pixels], return_inverse=True)
    rows, row = np.unique([at.row for at in pixels], return_inverse=True)
    placed = all(at.x is not None and at.y is not None for at in pixels)
    x, y = np.array([(at.x, at.y) if placed else (at.column, at.row) for at in pixels], dtype=float).T
    images = {name: np.full((rows.size, columns.size), np.nan) for name in IMAGES}
    values = [_values(item) for item in outcomes]
    for name, image in images.items():
        image[row, column] = [value[name] for value in values]
    return Map(
        np.array([np.mean(x[column == i]) for i in range(columns.size)]),
        np.array([np.mean(y[row == i]) for i in range(rows.size)]),
        images,
        placed,
    )


def _values(item: Fit | Failure) -> dict[str, float]:
    """The pixel of one curve in each image."""
    if isinstance(item, Failure):
        return dict.fromkeys(IMAGES, np.nan) | {"quality": 0.0, "status": 0.0}
    estimates = {estimate.name: estimate.value for estimate in item.estimates}
    return {
        "E_star": estimates.get("E_star", np.nan),
        "w": estimates.get("w", np.nan),
        "contact_point": estimates.get("delta0", np.nan),
        "adhesion_force": np.nan if item.adhesion is None else item.adhesion,
        "quality": np.nan if item.grade is None else item.grade.quality,
        "status": float(STATUSES.index(status_of(item))),
    }


def images_of(scan: Map) -> Group:
    """A map in HDF5: each image with its unit, and the positions of columns and rows."""
    status = ", ".join(f"{number} {word}" for number, word in enumerate(STATUSES))
    images = {name: unit_column(image, SI[IMAGES[name]], status if name == "status" else "")
              for name, image in scan.images.items()}  # fmt: skip
    length = "m" if scan.positions else "1"
    return Group({}, {"x": unit_column(scan.x, length), "y": unit_column(scan.y, length), **images})


# --------------------------------------------------------------------------------------------------
# Fits in HDF5: one table each of the rows, the fitted curves and the samples of all curves together, and summaries.

UNITS = {"a": "m", "delta": "m", "P": "N", "foot_a": "m", "row": "1", "curve": "1"}


def write_fits(path: Path, outcomes: Sequence[Fit | Failure], body: str, summaries: Sequence[str]) -> None:
    """Write all fits to ``path`` with the ``summaries`` of the curves, JSON each: a curve has its number from 0 in
    order. ``body``: what they were fitted to, in words."""
    fits = [(number, item) for number, item in enumerate(outcomes) if isinstance(item, Fit)]
    tables: dict[str, list[tuple[int, dict[str, Array]]]] = {"data": [], "fitted": [], "bootstrap": []}
    for number, item in fits:
        # Readings, the numbers of their rows from 1, contact radii, and residuals in units of the scatter
        names = ["residuals"] if len(item.residuals) == 1 else [f"residuals_{name}" for name in item.scales]
        residuals = dict(zip(names, item.residuals, strict=True))
        tables["data"].append((number, {**item.data, "row": item.rows + 1, "foot_a": item.a, **residuals}))
        tables["fitted"].append((number, dict(item.line)))
        if item.samples is not None:
            tables["bootstrap"].append((number, dict(zip(item.free, item.samples.T, strict=True))))
    curves: dict[str, Group | Dataset] = {name: _joined(table) for name, table in tables.items() if table}
    curves["summary"] = Dataset(summaries)
    images = {"map": images_of(scan)} if (scan := map_of(outcomes)) else {}
    write(path, FITS, {"body": body}, {"curves": Group({}, curves), **images})


def _joined(tables: Sequence[tuple[int, Mapping[str, Array]]]) -> Group:
    """Tables of several curves as one, with a column of their numbers; NaN where a curve has no such column."""
    sizes = [next(iter(table.values())).size for _, table in tables]
    members = {"curve": unit_column(np.repeat([number for number, _ in tables], sizes), UNITS["curve"])}
    for name in dict.fromkeys(name for _, table in tables for name in table):
        parts = (table[name] if name in table else np.full(size, np.nan)
                 for (_, table), size in zip(tables, sizes, strict=True))  # fmt: skip
        members[name] = unit_column(np.concatenate([*parts]), UNITS.get(name, "1" if "residuals" in name else "SI"))
    return Group({}, members)
