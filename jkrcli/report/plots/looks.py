"""What figures share: widths, colours, and the words and units of axes."""

from __future__ import annotations

import contextlib
import logging
import os
import re
from collections.abc import Iterator
from typing import Any

import numpy as np

from ...base import process
from ...base.errors import InputError
from ...base.numerics import Array
from ...base.units import scale
from ..tables import DIMENSIONS

WIDE, MIDDLE, NARROW = 7.0, 4.8, 3.4  # two columns of a journal, one and a half, one [inch]: printed unscaled
LARGER = 0.3  # choice: of the way of a record, below which its contact is drawn once more, larger
# Okabe and Ito's palette: told apart by colour-blind readers, and by line style or marker in grey.
BLUE, ORANGE, GREEN, BLACK = "#0072B2", "#D55E00", "#009E73", "#000000"
PURPLE, SKY = "#CC79A7", "#56B4E9"
LABELS = {
    "delta": r"displacement $\delta$", "P": "load $P$", "a": "contact radius $a$", "t": "time $t$",
    "w": "work of adhesion $w$", "E_star": "$E^*$", "speed": "speed of the contact's edge $|da/dt|$",
}  # fmt: skip
COLORS = (BLUE, ORANGE, GREEN, PURPLE, SKY, BLACK)


def pretty(text: str) -> str:
    """Units as they are typeset."""
    return re.sub(r"\bu(?=[mNJ]\b)", "µ", text.replace("^2", "²"))


def unit_of(dimension: str, *values: Array | float) -> tuple[float, str]:
    """The unit that the largest of ``values`` [SI] asks for, in SI and as it is typeset."""
    factor, unit = scale(max(float(np.max(np.abs(each))) for each in values), dimension)
    return factor, pretty(unit)


def axis_of(name: str, *values: Array | float) -> tuple[float, str]:
    """The unit of an axis of the quantity ``name``, as ``unit_of``, and the axis' label."""
    factor, unit = unit_of(DIMENSIONS[name], *values)
    return factor, f"{LABELS[name]} ({unit})"


# --------------------------------------------------------------------------------------------------
# matplotlib's import without the tables of properties that it writes into its own docstrings, a third of its time,
# and, in the process ``jkr``, without what its surroundings say: no figure depends on it.


def _properties() -> Any:
    """matplotlib.artist; InputError where a matplotlibrc is in the way."""
    if process.runs():
        os.environ.pop("MPLBACKEND", None)  # one that is unknown is an error
        logging.getLogger("matplotlib").setLevel(logging.ERROR)  # of lines in a matplotlibrc, folders for caches
    try:
        from matplotlib import artist
    except UnicodeDecodeError as error:
        raise InputError(
            f"matplotlibrc: matplotlib cannot read it ({error}); mend or remove the one in this folder, or that of "
            "MATPLOTLIBRC"
        ) from None
    return artist


properties = _properties()


@contextlib.contextmanager
def without_tables() -> Iterator[None]:
    """What is imported here has none in the process ``jkr``, which shows none; elsewhere nothing is changed."""
    tables = properties.kwdoc
    if process.runs():
        properties.kwdoc = lambda artist: ""
    try:
        yield
    finally:
        properties.kwdoc = tables
