"""Option types that several verbs share: numbers with units."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import click

from ..base import units
from ..methods.guards import Limits

limit_memory_option = click.option(
    "--limit-memory",
    type=click.FloatRange(min=0, min_open=True),
    metavar="GIB",
    help="Most memory to begin with [default: 80 % of what is free].",
)
limit_time_option = click.option(
    "--limit-time",
    type=click.FloatRange(min=0, min_open=True),
    default=Limits().hours,
    show_default=True,
    metavar="HOURS",
    help="Most CPU time to begin with.",
)

slopes_option = click.option(
    "--slopes",
    type=click.Choice(["auto", "exact", "integral", "loocv", "gcv"]),
    default="auto",
    show_default=True,
    help="How S and S' are found.",
)


class QuantityOption(click.ParamType):
    """A finite number of a dimension, SI or with a unit."""

    dimension = "number"
    least = -math.inf

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> float:
        if isinstance(value, float):
            return value
        try:
            number = units.parse(str(value), self.dimension)
        except ValueError as error:
            self.fail(str(error), param, ctx)
        if not (math.isfinite(number) and number >= self.least):
            self.fail(f"must be finite and >= {self.least:g}, got {value}", param, ctx)
        return number


class WorkOfAdhesion(QuantityOption):
    name = "WORK"
    dimension = "work"
    least = 0.0


class Length(QuantityOption):
    name = "LENGTH"
    dimension = "length"


class Load(QuantityOption):
    name = "LOAD"
    dimension = "load"


class Factor(QuantityOption):
    """A plain number > 0."""

    name = "FACTOR"
    least = 0.0

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> float:
        found = super().convert(value, param, ctx)
        if found == 0:
            self.fail(f"must be > 0, got {value}", param, ctx)
        return found


modulus_factor_option = click.option(
    "--modulus-factor",
    type=Factor(),
    default="1",
    show_default=True,
    help="All moduli this many times the case's; nothing is solved anew.",
)


class KeyValue(click.ParamType):
    """KEY=TEXT with one of ``keys``; ``what`` names the text in help."""

    def __init__(self, what: str, keys: Sequence[str]):
        self.name = f"KEY={what}"
        self.keys = keys

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> tuple[str, Any]:
        if isinstance(value, tuple):
            return value
        key, mark, text = str(value).partition("=")
        if not mark or key not in self.keys or not text:
            self.fail(f'must be KEY=VALUE with a key of {", ".join(self.keys)}, got "{value}"', param, ctx)
        return key, text


class Scale(click.ParamType):
    """KEY=VALUE with a key of ``keys`` among a, delta, P: a length or a load."""

    name = "KEY=VALUE"

    def __init__(self, keys: Sequence[str] = ("a", "delta", "P")):
        self.keys = keys

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> tuple[str, float]:
        if isinstance(value, tuple):
            return value
        key, mark, text = str(value).partition("=")
        if not mark or key not in self.keys:
            self.fail(f'must be KEY=VALUE with a key of {", ".join(self.keys)}, got "{value}"', param, ctx)
        return key, (Load() if key == "P" else Length()).convert(text, param, ctx)
