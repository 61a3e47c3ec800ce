"""Which options have an effect on which kind of fit: one table; whatever is given besides is refused."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import click
from click.core import ParameterSource

from ..base import InputError
from .verb import flag

EACH, LAW, RELAXATION, SHARED, TENSION = "each", "--law", "--relaxation", "--shared", "surface_tension"
EFFECT: Mapping[str, tuple[str, ...]] = {  # others have one on every kind
    "law": (LAW,), "relaxation": (RELAXATION,), "terms": (RELAXATION,), "shared": (SHARED,), "own": (SHARED,),
    "tip_radius": (SHARED, TENSION), "start": (EACH, SHARED, LAW), "bound": (EACH, SHARED),
    "segment": (EACH, SHARED, LAW, RELAXATION), "base_line": (EACH, SHARED), "branch": (EACH, SHARED),
    "noise": (EACH, SHARED), "loss": (EACH,), "confidence": (EACH, SHARED, LAW, RELAXATION), "samples": (EACH,),
    "seed": (EACH,), "rivals": (EACH,), "model": (EACH,), "plan": (EACH,), "surface": (EACH,), "uncertain": (EACH,),
    "contact": (EACH, SHARED, LAW, RELAXATION), "slopes": (EACH, SHARED, LAW),
}  # fmt: skip
NOT = {("contact", "fitted"): (LAW, RELAXATION), ("confidence", "bootstrap"): (SHARED, LAW, RELAXATION)}
GOES_WITH = {
    "terms": "--relaxation prony", "own": "--shared", "tip_radius": "--shared or --free surface_tension",
    "samples": "--confidence bootstrap", "seed": "--confidence bootstrap",
}  # fmt: skip


def typed_options() -> dict[str, Any]:
    """The options that the user gave, by their names, with their values."""
    context = click.get_current_context()
    names = (name for name in context.params if context.get_parameter_source(name) is ParameterSource.COMMANDLINE)
    return {name: context.params[name] for name in names}


def refuse_idle(kind: str, options: Mapping[str, Any]) -> None:
    """InputError where one of the ``options`` that were given has no effect on this ``kind`` of fit."""
    idle = [name for name in options if kind not in EFFECT.get(name, (kind,))]
    if options.get("confidence") != "bootstrap":
        idle += [name for name in ("samples", "seed") if name in options]
    if kind == RELAXATION and options["relaxation"] != "prony":
        idle += [name for name in ("terms",) if name in options]
    idle += [name for (name, value), kinds in NOT.items() if kind in kinds and options.get(name) == value]
    if "slopes" in options and options.get("tip_radius") and kind == SHARED:
        raise InputError("fit: --slopes does not go with --tip-radius, whose bodies have exact ones: leave it out")
    for name in idle:
        value = f" {options[name]}" if isinstance(options[name], str) else ""
        if name in GOES_WITH and (kind == EACH or kind in EFFECT[name]):
            raise InputError(f"fit: {flag(name)}: goes with {GOES_WITH[name]}: leave it out")
        by = "" if kind == EACH else f"{kind} does not take {flag(name)}{value}: leave it out"
        raise InputError(f"fit: {by}")
