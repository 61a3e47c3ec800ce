"""Model no more than a scene needs: the least method that can represent a problem, and why.

The rule of "auto", from the charts of speed against accuracy (``make chart``, which checks it): of the methods in
the order of ``least_first`` the first that represents the body with an unnoticeable expected error within a user's
patience (``TUNING``). Each runs with its default mesh or tolerance, the point of its own front beyond which more time
buys an accuracy that no measurement sees. Slopes: exact where the series carries them, else the surer of "integral" and
"loocv" (``jkrcli.adhesion.slopes``). The choice lies on the Pareto front of whole-process time and error of P or next
to it: nothing as exact is quicker by more than a half.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any, cast

from ..base import NOTICEABLE, SILENCE, InputError, Refusal, duration
from ..bodies import Problem
from .protocol import Forecast, Method, least_first, refusal_of


@dataclass(frozen=True)
class AutoTuning:
    """When a simpler model gives way to a more general one."""

    patience: float = 10.0  # tuned on the cases, by `make chart`: CPU seconds that a simpler model may take
    looks: int = 3  # at a spectrum, where the largest radius has to be found; choice: for messages


TUNING = AutoTuning()


@dataclass(frozen=True)
class Option:
    """One method's answer: what it would cost, or why it cannot do it."""

    name: str
    forecast: Forecast | None
    refusal: str | None

    @property
    def is_quick(self) -> bool:
        """Whether it is possible within a user's patience."""
        return self.forecast is not None and self.forecast.seconds <= TUNING.patience

    @property
    def is_accurate(self) -> bool:
        """Whether it is possible with an error that is known and too small to be noticed."""
        return self.forecast is not None and self.forecast.error <= NOTICEABLE

    @property
    def objection(self) -> str | None:
        """What speaks against a possible method, so that "auto" takes another that is better; None: nothing."""
        if not self.is_quick:
            return f"would take longer than {TUNING.patience:g} s"
        return None if self.is_accurate else f"would err by more than {NOTICEABLE:g}"

    @property
    def cost(self) -> str:
        """``0.02 s, error 1e-8`` of an option that is possible."""
        assert self.forecast is not None
        return f"{self.forecast.seconds:.1g} s, error {self.forecast.error:.0e}"


@dataclass(frozen=True)
class Choice:
    """The chosen method and the reason in a sentence; ``options`` in order of effort; ``failures``: what was tried
    before, by its name and why it failed."""

    name: str
    method: Method
    reason: str
    options: tuple[Option, ...] = ()
    failures: tuple[tuple[str, str], ...] = ()

    @property
    def brief(self) -> str:
        """The reason without its remarks on other methods."""
        return self.reason.partition("; ")[0]

    def forecast(self, problem: Problem) -> Forecast:
        """What the chosen method will cost."""
        known = next((option.forecast for option in self.options if option.name == self.name), None)
        return known or self.method.forecast(problem)

    def after_failure(self, error: Exception, build: Callable[[str], Method]) -> Choice | None:
        """What "auto" turns to when the chosen method fails: the same one at the tolerance that its failure advises,
        once, where that is unnoticeable; else the next possible one; None where none is left."""
        names = [option.name for option in self.options if option.forecast is not None]
        later = names[names.index(self.name) + 1 :] if self.name in names else []
        failures = (*self.failures, (self.name, str(error)))
        because = "because " + " and ".join(f"{name} failed ({why})" for name, why in dict(failures).items())
        if self.name in names and self.name not in dict(self.failures) and (coarser := _would_do(error)) <= NOTICEABLE:
            method = replace(cast(Any, self.method), tolerance=coarser)
            return Choice(self.name, method, f"to a tolerance of {coarser:.1e}, {because}", self.options, failures)
        return Choice(later[0], build(later[0]), because, self.options, failures) if later else None


def _would_do(error: Exception) -> float:
    """The tolerance to which the method that failed with ``error`` would do; infinite where it tells none."""
    from .integral import InaccurateError

    return error.would_do if isinstance(error, InaccurateError) else math.inf


def long_look(problem: Problem) -> str | None:
    """A sentence on what it takes to find out what each method would cost, None where that is a matter of a moment."""
    from .layered.spectrum import spectrum_seconds

    specimen, looks = problem.specimen, 1 if problem.loading.to == "radius" else TUNING.looks
    seconds = looks * spectrum_seconds(problem)
    if seconds < SILENCE:
        return None
    pieces = f" with {specimen.pieces:,} pieces of E over depth" if specimen.is_graded else ""
    layers = "a layer" if len(problem.layers) == 1 else f"{len(problem.layers):,} layers"
    return f"{layers}{pieces}: estimating the cost of each method takes about {duration(seconds)} of CPU time"


def choose_method(problem: Problem, wanted: str | Method, build: Callable[[str], Method]) -> Choice:
    """The method ``wanted``, by name or itself; for "auto" the first of ``least_first`` that is accurate enough."""
    if wanted != "auto":
        name, method = (wanted, build(wanted)) if isinstance(wanted, str) else (type(wanted).__name__, wanted)
        if reason := refusal_of(name, method, problem):
            raise Refusal(f"method {name}: {reason}")
        return Choice(name, method, "set in the case")
    options = survey(problem, build)
    possible = [option for option in options if option.forecast is not None]
    if not possible:
        raise InputError([f"method {option.name}: {option.refusal}" for option in options])
    accurate = [option for option in possible if option.is_accurate] or possible
    option = next((option for option in accurate if option.is_quick), accurate[0])
    return Choice(option.name, build(option.name), _why(option, options), tuple(options))


def survey(problem: Problem, build: Callable[[str], Method], names: Sequence[str] = ()) -> list[Option]:
    """Cost or refusal of the methods ``names`` (none: those that "auto" may choose); nothing is solved."""
    options = []
    for name in names or least_first():
        method = build(name)
        refusal, forecast = refusal_of(name, method, problem), None
        try:
            forecast = None if refusal else method.forecast(problem)
        except Refusal as error:  # so much that it cannot even be counted
            refusal = str(error)
        options.append(Option(name, forecast, refusal))
    return options


def _why(chosen: Option, options: Sequence[Option]) -> str:
    """One sentence: what was chosen, what simpler methods could not do, what more general ones would cost."""
    parts = [f"the simplest method for this body ({chosen.cost})"]
    for option in options:
        if option.refusal:
            parts.append(f"{option.name} not applicable ({option.refusal})")
        elif option is not chosen and options.index(option) < options.index(chosen) and option.objection:
            parts.append(f"{option.name} {option.objection} ({option.cost})")
        elif option is not chosen:
            parts.append(f"{option.name} would take about {option.cost}")
    return "; ".join(parts)
