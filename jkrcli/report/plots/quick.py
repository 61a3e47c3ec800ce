"""matplotlib's import without the tables of properties that it writes into its own docstrings, a third of its time,
and, in the process ``jkr``, without what its surroundings say: no figure depends on it."""

from __future__ import annotations

import contextlib
import logging
import os
from collections.abc import Iterator
from typing import Any

from ...base import InputError, process


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
