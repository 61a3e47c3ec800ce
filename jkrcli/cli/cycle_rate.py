"""``jkr cycle`` over time: what the device does, while adhesion depends on the edge's speed or the body relaxes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import click

from .. import adhesion, beside, bodies, report
from ..base import InputError
from .options import LENGTH, LOAD, PAIRS
from .verb import as_one, flag, typed

ALONE = ("speed", "speed_approach", "hold", "dwell", "dwell_time")  # what a program says by itself


@dataclass(frozen=True)
class RateOptions:
    """What the command line says the device does, as text where it depends on the control; None: not given."""

    to_load: float | None = typed(
        LOAD, "Turn at this load [default: at the end of the series, what creeps on included]."
    )
    to_depth: float | None = typed(LENGTH, "Turn at this displacement delta.")
    rate: Mapping[str, str] | None = typed(
        PAIRS, 'w0 (1 + (v/v0)^n) as the edge recedes: v0="1 um/s",n=0.6; law=log,v0=...,b="5 mJ/m^2": '
        "w0 + b log(1 + v/v0). w0 is --w-retract.")  # fmt: skip
    rate_advance: Mapping[str, str] | None = typed(PAIRS, "The same of an edge that advances [default: at once].")
    speed: str | None = typed(str, 'Of the device, "10 um/s"; of the load under load control, "1 mN/s".')
    speed_approach: str | None = typed(str, "The same on approach [default: --speed].")
    hold: str | None = typed(str, 'Time to wait at the turn, "10 s".')
    dwell: str | None = typed(str, "Go back as far as this position (load under load control) and stay there.")
    dwell_time: str | None = typed(str, "How long to stay.")
    program: Path | None = typed(  # noqa: RUF009  # a field
        click.Path(path_type=Path), "Table t, x of the device instead: times [s] and positions (loads) between which "
        "it moves evenly; equal times are steps.")  # fmt: skip
    stress: float | None = None

    def __post_init__(self) -> None:
        if self.rate is not None and (self.speed is None) == (self.program is None):
            raise InputError('cycle: --rate needs what the device does: --speed "10 um/s", or --program TABLE')
        if self.program is not None and (beside := [name for name in self.named if name in ALONE]):
            raise InputError(f"cycle: give either {flag(beside[0])} or --program")
        if (self.dwell is None) != (self.dwell_time is None):
            raise InputError("cycle: --dwell and --dwell-time go together")
        if self.program is not None and not self.to_load is self.to_depth is None:
            raise InputError("cycle: give either --program or a turn (--to-load, --to-depth)")
        if self.to_load is not None and self.to_depth is not None:
            raise InputError("cycle: give at most one of --to-load and --to-depth")

    @property
    def named(self) -> list[str]:
        """The fields that were given, but the rate and the turn."""
        beside = ("rate", "to_load", "to_depth")
        return [name for name, value in vars(self).items() if value is not None and name not in beside]

    def refuse_without_time(self) -> None:
        """InputError where options of time are given for what does not depend on it."""
        if self.rate is None and (timed := [name for name in self.named if name != "program"]):
            raise InputError(f"cycle: {flag(timed[0])} needs --rate: without it nothing depends on time")

    def refuse_in_limits(self) -> None:
        """InputError where they say what a body does over time that relaxes and adheres."""
        if self.rate is None and self.named:
            raise InputError(
                f"cycle: {flag(self.named[0])}: adhesion on a specimen that relaxes is known of very fast, of very "
                "slow cycles and from rest alone, which do not depend on time: leave it out, or give --w-approach 0"
            )

    def program_of(self, contact: adhesion.RateContact | adhesion.RelaxingContact) -> adhesion.Program:
        """What the device does, of the table or of the speeds."""
        if self.program is not None:
            return read_program(self.program, contact.stiffness)
        return self._course.program(contact, flag)

    def refuse_wrong(self, stiffness: float) -> None:
        """InputError where a speed, time or place is none, before anything is solved."""
        if self.speed is not None:
            self._course.moves(stiffness == adhesion.LOAD_CONTROL, flag)

    def suffix(self, stiffness: float) -> str:
        """What distinguishes names of files, of the options that were given: ``-to-load0.0005-speed1e-05``, SI."""
        si: dict[str, float | None] = {"to_load": self.to_load, "to_depth": self.to_depth}
        parts = list[str]()
        for name, pairs in (("rate", self.rate), ("rate_advance", self.rate_advance)):
            if pairs is not None:
                law, values = adhesion.parameters_of(adhesion.rate_law_of(pairs, flag(name)))
                parts.append("-".join([f"{flag(name)[1:]}-{law}", *(f"{value:g}" for value in values.values())]))
        if self.speed is not None:
            moves = self._course.moves(stiffness == adhesion.LOAD_CONTROL, flag)
            told = (moves.back, moves.there, moves.hold, moves.dwell, moves.dwell_time)
            si |= {name: x for name, x in zip(ALONE, told, strict=True) if getattr(self, name) is not None}
        parts += [f"{flag(name)[1:]}{x:g}" for name, x in si.items() if x is not None]
        return "".join([*parts, "" if self.program is None else f"-program-{self.program.stem}"])

    @property
    def _course(self) -> adhesion.Course:
        return adhesion.Course(**{name: getattr(self, name) for name in ("to_load", "to_depth", *ALONE)})


rate_options = as_one("rates", RateOptions)


def run(
    curves: Sequence[beside.Analysis], stiffness: float, points: int, rates: RateOptions, history: str = ""
) -> report.CycledAtSpeed:
    """What happens over time; ``curves``: those of approach and of retraction; ``history``: of a viscoelastic
    specimen, in words."""
    inwards, outwards = curves
    law = adhesion.rate_law_of(rates.rate or {}, "--rate")
    advance = None if rates.rate_advance is None else adhesion.rate_law_of(rates.rate_advance, "--rate-advance")
    contact = adhesion.RateContact(outwards.jkr.nonadhesive, law, outwards.w, inwards.w, stiffness, advance)
    program = rates.program_of(contact)
    return report.CycledAtSpeed.of(contact, program, outwards, stress=rates.stress, points=points, history=history)


def run_relaxing(
    body: beside.Analysis, law: bodies.Relaxation, stiffness: float, points: int, rates: RateOptions
) -> report.CycledRelaxing:
    """What happens over time to a body that relaxes, without adhesion."""
    if rates.rate is not None:
        raise InputError("cycle: --rate needs adhesion: give --w-approach, or leave it out")
    if rates.speed is None and rates.program is None:
        raise InputError('cycle: the specimen relaxes: say what the device does, --speed "10 um/s" or --program TABLE')
    contact = adhesion.RelaxingContact(body.jkr.nonadhesive, law, stiffness)
    return report.CycledRelaxing.of(contact, rates.program_of(contact), body.path, points)


def read_program(path: Path, stiffness: float) -> adhesion.Program:
    """What the table at ``path`` says that a device of ``stiffness`` [N/m] does."""
    from ..data import device_program

    dimension = "load" if stiffness == adhesion.LOAD_CONTROL else "length"
    return adhesion.Program(*device_program.read_program(path, dimension))
