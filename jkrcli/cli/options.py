"""Option types that several verbs share: numbers with units."""

from __future__ import annotations

import math
from typing import Any

import click

from .. import units

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


class Scale(click.ParamType):
    """KEY=VALUE with a key of a, delta, P: what that quantity is divided by."""

    name = "KEY=VALUE"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> tuple[str, float]:
        if isinstance(value, tuple):
            return value
        key, mark, text = str(value).partition("=")
        if not mark or key not in ("a", "delta", "P"):
            self.fail(f'must be KEY=VALUE with a key of a, delta, P, got "{value}"', param, ctx)
        return key, (Load() if key == "P" else Length()).convert(text, param, ctx)
