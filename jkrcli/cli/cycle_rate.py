"""``jkr cycle --rate``: what a device records over time while adhesion depends on the speed of the contact's edge."""

from __future__ import annotations

import functools
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from ..adhesion import LOAD_CONTROL
from ..base import InputError, parse
from .options import ParamType

if TYPE_CHECKING:
    from ..adhesion import Program, RateContact, RelaxingContact
    from ..beside.analysis import Analysis
    from ..report.rate import CycledAtSpeed


class PairsType(ParamType):
    """KEY=VALUE,KEY=VALUE ..."""

    name = "KEY=VALUE,..."

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> dict[str, str]:
        if isinstance(value, dict):
            return value
        found: dict[str, str] = {}
        for pair in str(value).split(","):
            key, mark, text = (part.strip() for part in pair.partition("="))
            if not (key and mark and text):
                self.fail(f'must be KEY=VALUE,..., such as v0="1 um/s",n=0.6, got "{value}"', param, ctx)
            if key in found:
                self.fail(f"{key} is given twice", param, ctx)
            found[key] = text
        return found


@dataclass(frozen=True)
class RateOptions:
    """What the command line says about rates, as text where it depends on the control; None: not given."""

    rate: Mapping[str, str] | None
    rate_advance: Mapping[str, str] | None
    speed: str | None
    speed_approach: str | None
    hold: str | None
    dwell: str | None
    dwell_time: str | None
    program: Path | None
    stress: float | None = None

    def __post_init__(self) -> None:
        if self.rate is not None and (self.speed is None) == (self.program is None):
            raise InputError('cycle: --rate needs what the device does: --speed "10 um/s", or --program TABLE')
        if self.program is not None and (beside := [name for name in self.given if name in ALONE]):
            raise InputError(f"cycle: give either {flag(beside[0])} or --program")
        if (self.dwell is None) != (self.dwell_time is None):
            raise InputError("cycle: --dwell and --dwell-time go together")

    @property
    def given(self) -> list[str]:
        """The fields that were given, but the rate."""
        return [name for name, value in vars(self).items() if value is not None and name != "rate"]

    def refuse_without_time(self) -> None:
        """InputError where options of time are given for what does not depend on it."""
        if self.rate is None and (given := [name for name in self.given if name != "program"]):
            raise InputError(f"cycle: {flag(given[0])} needs --rate: without it nothing depends on time")


ALONE = ("speed", "speed_approach", "hold", "dwell", "dwell_time")


def flag(name: str) -> str:
    """The option of a field."""
    return "--" + name.replace("_", "-")


def rate_options(command: Callable[..., Any]) -> Callable[..., Any]:
    """The options of speed and time, as one argument ``rates``."""
    options = (
        click.option("--rate", type=PairsType(), help='w0 (1 + (v/v0)^n) as the edge recedes: v0="1 um/s",n=0.6; '
                     'law=log,v0=...,b="5 mJ/m^2": w0 + b log(1 + v/v0). w0 is --w-retract.'),
        click.option("--rate-advance", type=PairsType(), help="The same of an edge that advances [default: at once]."),
        click.option("--speed", help='Of the device, "10 um/s"; of the load under load control, "1 mN/s".'),
        click.option("--speed-approach", help="The same on approach [default: --speed]."),
        click.option("--hold", help='Time to wait at the turn, "10 s".'),
        click.option("--dwell", help="Go back as far as this position (load under load control) and stay there."),
        click.option("--dwell-time", help="How long to stay."),
        click.option("--program", type=click.Path(path_type=Path), help="Table t, x of the device instead: times [s] "
                     "and positions (loads) between which it moves evenly; equal times are steps."),
    )  # fmt: skip

    @functools.wraps(command)
    def with_rates(*words: Any, **others: Any) -> Any:
        names = [name for name in RateOptions.__dataclass_fields__ if name != "stress"]
        rates = RateOptions(**{name: others.pop(name) for name in names})
        return command(*words, rates=rates, **others)

    decorated = with_rates
    for option in reversed(options):
        decorated = option(decorated)
    return decorated


@dataclass(frozen=True, eq=False)
class Turn:
    """Where the approach ends: at a load [N], at a depth [m], or, both None, at the end of the series."""

    load: float | None
    depth: float | None


def run(
    curves: Sequence[Analysis], stiffness: float, turn: Turn, points: int, rates: RateOptions
) -> CycledAtSpeed:  # fmt: skip
    """What happens over time; ``curves``: those of approach and of retraction."""
    from ..adhesion import RateContact, rate_law_of
    from ..report.rate import CycledAtSpeed

    inwards, outwards = curves
    law = rate_law_of(rates.rate or {}, "--rate")
    advance = None if rates.rate_advance is None else rate_law_of(rates.rate_advance, "--rate-advance")
    contact = RateContact(outwards.jkr.nonadhesive, law, outwards.w, inwards.w, stiffness, advance)
    return CycledAtSpeed.of(contact, program_of(contact, rates, turn), outwards, stress=rates.stress, points=points)


def program_of(contact: RateContact | RelaxingContact, rates: RateOptions, turn: Turn) -> Program:
    """What the device does, of the speeds or of the table."""
    from ..adhesion import there_and_back
    from ..adhesion.program import dwell

    loaded, least = contact.stiffness == LOAD_CONTROL, contact.least
    length, speed = ("load", "load rate") if loaded else ("length", "speed")
    if rates.program is not None:
        return read_program(rates.program, contact.stiffness)
    back = _quantity("--speed", rates.speed, speed)
    there = _quantity("--speed-approach", rates.speed_approach, speed) if rates.speed_approach else back
    hold = 0.0 if rates.hold is None else _quantity("--hold", rates.hold, "time", least=0.0)
    x = contact.turning(turn.load, turn.depth, there)
    if rates.dwell is None:
        return there_and_back(x, there, back, hold, least)
    held = _quantity("--dwell", rates.dwell, length, least=-math.inf)
    lasts = _quantity("--dwell-time", rates.dwell_time, "time")
    return dwell(x, there, back, held, lasts, hold, least)


def read_program(path: Path, stiffness: float) -> Program:
    """What the table at ``path`` says that a device of ``stiffness`` [N/m] does."""
    from ..adhesion import Program
    from ..data import device_program

    return Program(*device_program.read_program(path, "load" if stiffness == LOAD_CONTROL else "length"))


def _quantity(option: str, text: str | None, dimension: str, least: float | None = None) -> float:
    """The number that an option gives; > 0 where no ``least`` is told."""
    try:
        value = parse(text or "", dimension)
    except ValueError as error:
        raise InputError(f"{option}: {error}") from None
    wrong = value <= 0 if least is None else value < least
    if wrong or not math.isfinite(value):
        raise InputError(f"{option}: must be {'> 0' if least is None else f'>= {least:g}'}, got {text}")
    return value
