"""Where curves were taken: grids from the instrument, from positions in headers, from names, or as specified."""

from __future__ import annotations

import itertools
import math
import re
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np

from ..base.errors import InputError
from ..base.numerics import Array
from .curve import Curve, Pixel
from .files import files_in

# "r03c07", "row3_col7"; "c7r3"; "x7y3"; the last two numbers, "map_0_1"
OF_NAME = (
    (re.compile(r"(?<![a-z])r(?:ow)?[ _-]?(\d+)[ _-]?c(?:ol(?:umn)?)?[ _-]?(\d+)", re.IGNORECASE), 2, 1, "row, column"),
    (re.compile(r"(?<![a-z])c(?:ol(?:umn)?)?[ _-]?(\d+)[ _-]?r(?:ow)?[ _-]?(\d+)", re.IGNORECASE), 1, 2, "column, row"),
    (re.compile(r"(?<![a-z])x[ _-]?(\d+)[ _-]?y[ _-]?(\d+)", re.IGNORECASE), 1, 2, "column, row"),
    (re.compile(r"(\d+)[_-](\d+)\D*\Z"), 2, 1, "row, column"),
)  # fmt: skip
LEAST_PLACES = 4  # choice: curves that make a map
FILLED = 0.5  # choice: share of the places of a grid that hold a curve, so that two numbers in names are places
SAME_PLACE = 0.5  # choice: of the pitch, by which positions in one line of a grid may differ


def placed(path: Path, curves: list[Curve], shape: tuple[int, int] | None) -> tuple[list[Curve], str]:
    """The curves of one path on their grid, row by row, and by what; as they are, and "", where they have no places.

    ``shape``: columns and rows of a grid on which the files lie row by row, those that cannot be read included.
    """
    if shape is not None:
        names = [str(file) for file in files_in(path)] if path.is_dir() else [one.where for one in curves]
        if len(names) != shape[0] * shape[1]:
            raise InputError(
                f"{path}: holds {len(names)} curves, --grid {shape[0]}x{shape[1]} has {shape[0] * shape[1]} places"
            )
        ranks = [names.index(str(one.origin) if path.is_dir() else one.where) for one in curves]
        return [
            replace(one, pixel=Pixel(rank % shape[0], rank // shape[0]))
            for one, rank in zip(curves, ranks, strict=True)
        ], "row by row as specified"
    pixels = [one.pixel for one in curves if one.pixel is not None]
    if pixels and len({(at.column, at.row) for at in pixels}) == len(curves):
        return curves, "places by the instrument"
    if len(curves) < LEAST_PLACES or (pixels and len(pixels) < len(curves)):
        return curves, ""

    def candidates() -> Iterator[tuple[list[Pixel], str]]:
        """Places by lines along x and y, the fewest first, where headers hold positions, else by all names."""
        if pixels:
            lines = (_lines(np.array([getattr(at, axis) for at in pixels])) for axis in "xy")
            for pair in sorted(
                itertools.product(*lines), key=lambda pair: math.prod(np.unique(one).size for one in pair)
            ):
                places = [replace(at, column=int(i), row=int(j)) for at, i, j in zip(pixels, *pair, strict=True)]
                yield places, "positions in headers"
            return
        for pattern, column, row, words in OF_NAME:
            matches = [pattern.search(one.name) for one in curves]
            if all(matches):
                yield [Pixel(int(match[column]), int(match[row])) for match in matches if match], f"{words} in names"

    for places, words in candidates():
        # a grid: all places differ and fill most of several columns and rows
        columns, rows = ({getattr(at, name) for at in places} for name in ("column", "row"))
        alone = len({(at.column, at.row) for at in places}) == len(places)
        if alone and min(len(columns), len(rows)) > 1 and len(places) >= FILLED * len(columns) * len(rows):
            order = sorted(range(len(curves)), key=lambda i: (places[i].row, places[i].column))
            return [replace(curves[i], pixel=places[i]) for i in order], words
    return curves, ""


def _lines(values: Array) -> Iterator[Array]:
    """Numbers of the lines of a grid on which values may lie, those of lines without a value left free: where these are
    apart by more than twice what values on one of them are."""
    order, lines = np.argsort(values), np.zeros(values.size, dtype=int)
    ordered = values[order]
    gaps = np.diff(ordered)
    for least in np.unique(gaps[gaps > 0])[::-1]:
        starts = np.concatenate([[0], np.flatnonzero(gaps >= least) + 1])
        wide = np.maximum.reduceat(ordered, starts) - ordered[starts]
        distances = np.diff(np.add.reduceat(ordered, starts) / np.diff(np.append(starts, values.size)))
        if wide.max() <= SAME_PLACE * distances.min():
            pitch = float(np.median(distances[distances < 1.5 * distances.min()]))
            numbers = np.concatenate([[0], np.cumsum(np.round(distances / pitch).astype(int))])
            lines[order] = np.repeat(numbers, np.diff(np.append(starts, values.size)))
            yield lines.copy()
