"""The cycle of a device whose specimen relaxes: its trace, in words and as JSON."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

from ..adhesion import Program, RelaxedHistory, RelaxingContact, control
from ..base import ROWS, UNSEEN, Array, InputError, Unknown, show
from ..bodies import RELAXATIONS, Relaxation, limits_of
from .result import Figure, Result, Several, as_result
from .tables import device, energies, state_words, timed, with_unit

NEGLECTED = (
    "one relaxation function for all layers, and for the half-space below them, at constant Poisson's ratios; no "
    "adhesion, inertia or friction"
)


def law_summary(law: Relaxation) -> dict[str, Any]:
    """The law and its parameters, times in s."""
    keys = RELAXATIONS.keys_in_file(law).items()
    return {with_unit(key, "time") if key.startswith("time") else key: value for key, value in keys}


@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
class CycledRelaxing(RelaxedHistory, Result):
    """A history as a result; ``points``: rows of a piece."""

    file: Path
    points: int = ROWS

    @classmethod
    def of(cls, contact: RelaxingContact, program: Program, file: Path, points: int = ROWS) -> CycledRelaxing:
        """What happens to ``contact`` under ``program``."""
        try:
            history = contact.history(program)
            whole = as_result(cls, history, file=file, points=points)
            whole.summary()  # may find that the contact is loaded again
        except InputError as error:
            raise InputError([f"{file}: {line}" for line in error.lines]) from None
        return whole

    @cached_property
    def columns(self) -> dict[str, Array]:  # type: ignore[override]
        return self.table(self.points)

    def figure(self) -> Figure:
        from .plots.rate import history_figure

        return history_figure(self.columns, [], f"{control(self.contact.stiffness)}, {self.contact.law}")

    def summary(self) -> dict[str, Any]:
        return {
            "file": str(self.file),
            **device(self.contact.stiffness),
            "relaxation": law_summary(self.contact.law),
            "largest_load": timed(self.peak),
            "turn_t_s": self.turn,
            "corners": list(map(timed, self.corners)),
            "contact_lost": self.lost is not None,
            "lost_t_s": self.lost,
            **energies(energy_lost=self.energy_lost),
            "load_relative_error": self.error,
            "neglected": NEGLECTED,
            "warnings": self.warnings,
        }

    def words(self) -> list[str]:
        peak, lost = self.peak, self.lost
        lines = [
            f"largest load {show(peak.P, 'load')} at {state_words(peak, 't delta a')}: {self.file}",
            f"  {control(self.contact.stiffness)}, no adhesion; {self.contact.law}",
            *(f"  at {state_words(one, 't')} {state_words(one)}" for one in self.corners if one.t > peak.t),
        ]
        ends = "contact is not lost" if lost is None else f"contact is lost at t = {show(lost, 'time')}"
        energy = "" if isinstance(self.energy_lost, Unknown) else f"; energy lost per cycle {self.energy_lost:.4g} J"
        grown = f"it stopped growing at t = {show(self.turn, 'time')}{', at the end of the series' * self.whole}"
        return [*lines, f"  {ends}; {grown}{energy}"]

    @property
    def warnings(self) -> list[str]:
        """What a reader should know, each with its number."""
        return [f"the loads err by about {self.error:.1g} of the largest"] if self.error > UNSEEN else []


@dataclass(frozen=True, eq=False)
class CycledInLimits(Several):
    """The cycles of a body that relaxes and adheres in the limits that are known: by the name of each its share of the
    moduli and its result."""

    file: Path
    limits: Mapping[str, tuple[float, Result]]

    @classmethod
    def of(cls, file: Path, law: Relaxation, cycle: Callable[[float], Result]) -> CycledInLimits:
        """In each limit of the ``law`` the ``cycle`` of the body whose moduli are a share of those at t = 0."""
        return cls(file, {name: (share, cycle(share)) for name, share in limits_of(law).items()})

    def summary(self) -> dict[str, Any]:
        limits = {name: {"moduli": share} | result.summary() for name, (share, result) in self.limits.items()}
        return {"file": str(self.file), "limits": limits}

    @property
    def parts(self) -> Sequence[Sequence[str]]:
        return [
            [f"limit of {name} cycles, the moduli times {share:.4g}: {result.words()[0]}", *result.words()[1:]]
            for name, (share, result) in self.limits.items()
        ]

    @property
    def warnings(self) -> list[str]:
        return list(dict.fromkeys(line for _, result in self.limits.values() for line in result.warnings))
