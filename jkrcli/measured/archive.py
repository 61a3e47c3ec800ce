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
MOST_PLACES = 1_000_000  # choice: of a grid
LEAST_CURVES = 3  # choice: from which on curves without a grid are drawn together, as they are summed up in a line


def status_of(item: Fit | Failure) -> str:
    """Whether a curve was fitted, and is to be believed."""
    if isinstance(item, Failure):
        return UNUSABLE
    return FITTED if (not item.flags if item.grade is None else item.grade.believed) else DOUBTFUL


def reason_of(item: Fit | Failure) -> str:
    """Why a curve is not to be believed: what set its grade; "" where it is."""
    if isinstance(item, Failure):
        return item.reason
    return "" if status_of(item) == FITTED else item.grade.reason if item.grade else item.flags[0]


@dataclass(frozen=True, eq=False)
class Map:
    """``images`` (rows, columns) by their names in ``IMAGES``, SI, NaN where nothing was found; ``x, y`` [m] of all
    columns and rows of the grid; their numbers where no ``positions`` are known."""

    x: Array
    y: Array
    images: Mapping[str, Array]
    positions: bool = True

    @property
    def words(self) -> str:
        """How many columns and rows."""
        return f"{self.x.size} x {self.y.size}"


def maps_of(outcomes: Sequence[Fit | Failure], sample: Sequence[str]) -> dict[str, Map]:
    """The map that the curves make, by the name ""; where they make none, those of each ``sample`` that makes one."""
    if (whole := map_of(outcomes)) is not None:
        return {"": whole}
    parts = {name: [item for item, own in zip(outcomes, sample, strict=True) if own == name]
             for name in dict.fromkeys(sample)}  # fmt: skip
    return {name: scan for name, part in parts.items() if (scan := map_of(part)) is not None}


def map_of(outcomes: Sequence[Fit | Failure]) -> Map | None:
    """The map that the curves make, but for files that could not be read; None where they were not taken on a grid, or
    several share a pixel."""
    read = [item for item in outcomes if isinstance(item, Fit) or item.curve is not None]
    pixels = [item.pixel for item in read if item.pixel is not None]
    if len(pixels) < 2 or len(pixels) != len(read) or len({(at.column, at.row) for at in pixels}) != len(read):
        return None
    placed = all(at.x is not None and at.y is not None for at in pixels)
    at_x, at_y = np.array([(at.x, at.y) if placed else (at.column, at.row) for at in pixels], dtype=float).T
    x, column = _lines([at.column for at in pixels], at_x)
    y, row = _lines([at.row for at in pixels], at_y)
    if x.size * y.size > MOST_PLACES:
        return None
    images = {name: np.full((y.size, x.size), np.nan) for name in IMAGES}
    values = [_values(item) for item in read]
    for name, image in images.items():
        image[row, column] = [value[name] for value in values]
    return Map(x, y, images, placed)


def _lines(numbers: Sequence[int], at: Array) -> tuple[Array, Array]:
    """The places of all columns, or rows, of a grid from the first to the last, as far apart as those of curves with
    these ``numbers``, ``at`` their places, let them be; and the index of each curve's. Between lines that hold curves
    others lie evenly."""
    used, index = np.unique(numbers, return_inverse=True)
    step = int(np.gcd.reduce(np.diff(used))) or 1
    ranks = (used - used[0]) // step
    means = np.bincount(index, at) / np.bincount(index)
    return np.interp(np.arange(ranks[-1] + 1), ranks, means), ranks[index]


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


def write_fits(
    path: Path, outcomes: Sequence[Fit | Failure], body: str, summaries: Sequence[str], maps: Mapping[str, Map]
) -> None:
    """Write all fits to ``path`` with the ``summaries`` of the curves, JSON each: a curve has its number from 0 in
    order. ``body``: what they were fitted to, in words; ``maps``: by their samples."""
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
    # Tables of several curves as one, with a column of their numbers; NaN where a curve has no such column
    curves: dict[str, Group | Dataset] = {}
    for kind, each in ((kind, each) for kind, each in tables.items() if each):
        sizes = [next(iter(table.values())).size for _, table in each]
        members = {"curve": unit_column(np.repeat([number for number, _ in each], sizes), UNITS["curve"])}
        for name in dict.fromkeys(name for _, table in each for name in table):
            parts = (table[name] if name in table else np.full(size, np.nan)
                     for (_, table), size in zip(each, sizes, strict=True))  # fmt: skip
            unit = UNITS.get(name, "1" if "residuals" in name else "SI")
            members[name] = unit_column(np.concatenate([*parts]), unit)
        curves[kind] = Group({}, members)
    curves["summary"] = Dataset(summaries)
    images = {"map": images_of(maps[""])} if "" in maps else {}
    of_samples = {name.replace("/", "_"): images_of(scan) for name, scan in maps.items() if name}
    images |= {"maps": Group({}, of_samples)} if of_samples else {}
    write(path, FITS, {"body": body}, {"curves": Group({}, curves), **images})
