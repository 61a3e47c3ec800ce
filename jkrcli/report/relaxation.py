"""The cycle of a device whose specimen relaxes: its trace, in words and as JSON."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

from ..adhesion import LoadingHistory, Program, RelaxedHistory, RelaxingContact, Rest, control
from ..adhesion.from_rest import AT_MOST, FROM_REST
from ..base import ROWS, UNSEEN, Array, InputError, Unknown, show
from ..beside import checked_histories
from ..bodies import RELAXATIONS, Relaxation
from ..series import Solution
from .result import Figure, Result, Several, as_result
from .tables import cycle_title, device, energies, speed_words, state_words, timed, with_unit

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

        how = f"{self.control}, {speed_words(self.program, self.contact.stiffness)}"
        return history_figure(self.columns, [], cycle_title(how, 0.0, 0.0, str(self.contact.law)))

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
            **energies(energy_lost=(self.energy_lost, Unknown("not estimated for specimens that relax"))),
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
    """The cycles of a viscoelastic specimen with adhesion after each history that is known, by its name."""

    file: Path
    limits: Mapping[str, tuple[LoadingHistory, Result]]

    @classmethod
    def of(
        cls, file: Path, known: Iterable[LoadingHistory], cycle: Callable[[LoadingHistory], Result]
    ) -> CycledInLimits:
        """For each history that is ``known`` the ``cycle`` of it."""
        return cls(file, {one.name: (one, cycle(one)) for one in known})

    def summary(self) -> dict[str, Any]:
        limits = {
            name: {"history": one.words, "moduli": one.moduli, "profile": one.profile} | result.summary()
            for name, (one, result) in self.limits.items()
        }
        return {"file": str(self.file), "limits": limits}

    @property
    def parts(self) -> Sequence[Sequence[str]]:
        return [
            [f"{one.words}: {result.words()[0]}", *result.words()[1:]] for one, result in self.limits.values()
        ]  # fmt: skip

    @property
    def warnings(self) -> list[str]:
        return list(dict.fromkeys(line for _, result in self.limits.values() for line in result.warnings))


def traced_histories(
    solution: Solution, rest: Rest | None, load: float | None = None, depth: float | None = None, rests: bool = True
) -> tuple[LoadingHistory, ...]:  # fmt: skip
    """The histories of a viscoelastic specimen that are traced: at rest at the turn, at a ``load`` [N] or ``depth``
    [m], where there is one, unless ``rest`` says otherwise; not from rest where the trace has no ``rests``."""
    rest = rest or (Rest(load or 0.0) if depth is None else Rest(depth=depth))
    known = checked_histories(solution, rest)
    if isinstance(known, Unknown):
        raise InputError(f"cycle: {known.reason}, or no adhesion, --w-approach 0")
    return tuple(one for one in known or () if one.name != AT_MOST and (rests or one.name != FROM_REST))
