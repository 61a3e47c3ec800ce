"""Formats of files of measured curves: each registers itself, with its name, how it is recognised and its reader."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

from .curve import AsRead, Reading


@dataclass(frozen=True)
class Format:
    """A format that files are recognised as by what they hold.

    ``knows``: whether the file at a path is one, by its first bytes; a pipe, which can be read once, is none.
    ``curves``: its reader, which yields each curve, or why it cannot be used, or the name alone of one that the reading
    does not want, with the stiffness [N/m] of the device whose deflection is still to be subtracted from ``delta``.
    ``maps``: endings of names of files that hold many curves.
    """

    name: str
    knows: Callable[[Path], bool]
    curves: Callable[[Path, Reading], Iterator[AsRead]]
    maps: tuple[str, ...] = ()


FORMATS: dict[str, Format] = {}  # by name


def register(format: Format) -> None:
    """Make a format known: its files are read wherever measured ones are."""
    FORMATS[format.name] = format


def format_of(path: Path) -> Format | None:
    """The registered format of the file at ``path``."""
    return next((one for one in reversed(FORMATS.values()) if one.knows(path)), None)
