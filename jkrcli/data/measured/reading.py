"""How measured curves are to be read: columns, units, signs, zero points."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal

KEYS = ("a", "area", "delta", "P", "t", "segment", "curve")


@dataclass(frozen=True)
class Reading:
    """Conventions of a measurement; by default those of the project: SI, indentation and compression positive.

    ``columns``: names or numbers (from 1) where the header does not tell, keys among ``KEYS``; "area" is the projected
    contact area. ``units``: where the header names none. ``flip``: of "delta" and "P", those that are to change sign:
    a height or separation grows away from the specimen, some instruments count adhesive forces positive.
    ``stiffness`` [N/m]: the displacement is the device's, its deflection P/stiffness is subtracted; of a microscope's
    file its spring constant, where the file lacks it. ``sensitivity`` [m/V]: likewise.
    ``zero``: displacement [m] and load [N] at the zero points, subtracted after the change of sign.
    ``contact``: "as-is", or "estimate": zero points by ``contact.with_zero_points``.
    ``format``: "text", "afm" (read by afmformats) or "auto", by the ending of the name.
    """

    columns: Mapping[str, str] = field(default_factory=dict)
    units: Mapping[str, str] = field(default_factory=dict)
    flip: frozenset[str] = frozenset()
    stiffness: float | None = None
    sensitivity: float | None = None
    zero: Mapping[str, float] = field(default_factory=dict)
    contact: Literal["as-is", "estimate"] = "as-is"
    format: Literal["auto", "text", "afm"] = "auto"
    separator: str | None = None
    decimal: str | None = None
