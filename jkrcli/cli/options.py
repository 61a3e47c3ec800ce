"""Options that several verbs share."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TypeAlias

import click

from ..adhesion import RangeRequest
from ..adhesion.slopes import RULES
from ..base import InputError
from ..methods import LESS, Forecast, Limits, admit
from ..series import Solution
from .option_types import FACTOR, LENGTH, LENGTH_ABOVE_0, LOAD, POSITIVE, STRESS, WORK, WORKERS
from .verb import as_one
from .voice import forewarn

ANY = Limits(math.inf, math.inf)  # of verbs that have none


limits_options = as_one(
    "limits",
    lambda limit_memory, limit_time: Limits(limit_memory, limit_time),
    click.option("--limit-memory", type=POSITIVE, metavar="GIB",
                 help="Refuse runs that need more memory [default: 80 % of what is free]."),
    click.option("--limit-time", type=POSITIVE, default=Limits().hours, show_default=True, metavar="HOURS",
                 help="Refuse runs that need more CPU time."),
)  # fmt: skip


def begin(what: str, cost: Forecast, limits: Limits = ANY, less: str = LESS) -> None:
    """Say what ``what`` will cost, where that is much; Refusal beyond the ``limits``, with the advice to ask for
    ``less``."""
    if words := admit(what, cost, limits, less):
        forewarn(words, cost.seconds)


slopes_option = click.option("--slopes", type=click.Choice(["auto", *RULES]), default="auto", show_default=True,
                             help="How S and S' are found.")  # fmt: skip


Parallel: TypeAlias = tuple[int | None, str | None]  # local processes, and the address of a Dask scheduler
parallel_options = as_one(
    "parallel",
    lambda workers, scheduler: (workers, scheduler),
    click.option("--workers", type=WORKERS, help="Local processes [default: one per core, if they pay]."),
    click.option("--scheduler", metavar="ADDRESS", help="Dask scheduler that you run, such as tcp://node1:8786."),
)


@dataclass(frozen=True)
class RangeOptions:
    """Adhesion of finite range: its tension [Pa] or its length [m]; None where it is the case's."""

    stress: float | None
    length: float | None

    def of(self, solution: Solution) -> RangeRequest:
        """The range for a ``solution``."""
        return RangeRequest.of(solution.record, self.stress, self.length)


@dataclass(frozen=True)
class CurveOptions(RangeOptions):
    """How curves are made of a solution: adhesion of finite range, the rule for slopes, a factor of all moduli."""

    slopes: str
    modulus_factor: float


@dataclass(frozen=True)
class State:
    """One state of a contact, by its ``radius`` [m] or ``load`` [N], and the ``work`` of adhesion [J/m^2]."""

    radius: float | None
    load: float | None
    work: float | None

    def refuse_wrong(self, verb: str) -> None:
        """InputError where not exactly one of radius and load is there."""
        if (self.radius is None) == (self.load is None):
            raise InputError(f"{verb}: give exactly one of --a and --load")


RANGE = (
    click.option("--stress", type=STRESS,
                 help='Adhesion of finite range: its tension, "100 MPa" [default: the case\'s].'),
    click.option("--range", "length", type=LENGTH_ABOVE_0, help='The same by its range, "0.3 nm".'),
)  # fmt: skip
state_options = as_one(
    "state",
    State,
    click.option("--a", "radius", type=LENGTH, help='Contact radius, "2 um".'),
    click.option("--load", type=LOAD, help='Load, "-3 mN" (stable branch), compression positive.'),
    click.option("--w", "work", type=WORK, help="Work of adhesion; 0: nonadhesive [default: the case's first]."),
)
modulus_factor_option = click.option(
    "--modulus-factor", type=FACTOR, default="1", show_default=True,
    help="All moduli, and a surface tension, this many times the case's; nothing is solved anew.",
)  # fmt: skip
range_options = as_one("attraction", RangeOptions, *RANGE)
curve_options = as_one("how", CurveOptions, *RANGE, slopes_option, modulus_factor_option)
