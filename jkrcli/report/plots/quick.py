"""matplotlib's import without the tables of properties that it writes into its own docstrings, a third of its time."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator

from matplotlib import artist as properties

from ...base import program


@contextlib.contextmanager
def without_tables() -> Iterator[None]:
    """What is imported here has none in the program ``jkr``, which shows none; elsewhere nothing is changed."""
    tables = properties.kwdoc
    if program.runs():
        properties.kwdoc = lambda artist: ""
    try:
        yield
    finally:
        properties.kwdoc = tables
