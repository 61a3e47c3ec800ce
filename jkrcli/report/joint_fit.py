"""Records fitted together as a table, as a summary and in words."""

from __future__ import annotations

from typing import Any

from ..base.units import show
from ..identification.fit.joint import JointFit
from . import fit as each
from .fit import estimate_summary, estimate_words


def columns(found: JointFit) -> dict[str, list[Any]]:
    """A row for each record: what all share, and its own."""
    return each.columns(found.fits)


def summary(found: JointFit, body: str) -> dict[str, Any]:
    """What stands in the JSON file."""
    return {
        "format": "jkr-joint-fit",
        "version": 1,
        "body": body,
        "shared": {item.name: estimate_summary(item) for item in found.shared},
        "correlation": found.correlation.tolist(),
        "chance": found.chance,
        "alone": [dict(values) for values in found.alone],
        "curves": each.summary(found.fits, body)["curves"],
        "warnings": list(found.warnings),
    }


def words(found: JointFit, level: float) -> list[str]:
    """The fit as lines of text: what is shared, then what each record says alone, and its own."""
    lines = [f"{len(found.fits)} records together (p = {found.chance:.2g} that such records differ as much)"]
    lines += [f"  {item.name:<12} {estimate_words(item, level)}" for item in found.shared if item.name != "modulus"]
    told = {item.name: item.dimension for item in found.shared}
    for one, values in zip(found.fits, found.alone, strict=True):
        own = [item for item in one.estimates if item.free and item.name not in told and item.dimension != "modulus"]
        parts = [f"{name} = {show(value, told[name], 4)}" for name, value in values.items()]
        kept = ", ".join(f"{item.name} = {show(item.value, item.dimension, 4)}" for item in own)
        lines.append(f"  {one.name}: alone {', '.join(parts)}; its own {kept or 'none'}")
    return lines
