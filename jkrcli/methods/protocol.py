"""The one interface of all methods, and the register in which they make themselves known."""

from __future__ import annotations

import importlib
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Protocol, TypeAlias, cast, runtime_checkable

from ..base.arguments import Checked
from ..base.errors import NOTICEABLE, InputError, Refusal, counted
from ..base.process import SHARE, SILENCE, duration, free_memory, memory_words
from ..base.units import Ranged
from ..base.wings import absent, wings

if TYPE_CHECKING:
    from ..bodies.problem import Problem, Specimen
    from ..series import Solution


@dataclass(frozen=True)
class Forecast:
    """What a solve would cost: CPU seconds, peak memory [MiB], expected relative error, and a word on each."""

    seconds: float
    memory_mib: float
    error: float
    note: str = ""


@runtime_checkable
class Method(Protocol):
    """Solve a problem without adhesion: a frozen dataclass whose fields are the options.

    Its docstring states where it is valid; methods share the result type, not a base class. A ``Descriptor`` in
    ``methods/protocol.py`` makes it known.

    Methods
    -------
    __call__(problem)
        Return the Solution: series a, delta, P, S, dS/da, each (n,) in SI, with its error budget.
    refusal(problem)
        Why this method cannot represent the problem, with the remedy; None where it can.
    forecast(problem)
        CPU seconds, memory [MiB] and relative error to be expected.
    """

    def __call__(self, problem: Problem) -> Solution: ...

    def refusal(self, problem: Problem) -> str | None:
        """Why this method cannot represent the problem, and the remedy; None where it can."""
        ...

    def forecast(self, problem: Problem) -> Forecast: ...


@dataclass(frozen=True)
class InTable:
    """Annotation of an option that stands in a table of its own in a case file: ``table.key``."""

    table: str
    key: str


@dataclass(frozen=True)
class Descriptor:
    """What is known of a method before its solver is imported.

    ``sentence``: what it does. ``solver``: its class, or "module:class", imported when called. ``effort``: the least
    model that represents a body is tried first. ``options``: a dataclass of the method's options, with a default each
    and ranges in the annotations, which stand in the case file's table ``table`` (its name where empty; or
    ``InTable``). ``automatic``: whether "auto" may choose it. ``exact``: to round-off or its tolerance, at next to no
    cost; ``kernel``: its bodies have the kernel of the contact equation (see ``integral.finite_range``); ``tension``:
    whether it represents surface tension; ``coating``: layers of the indenter.
    """

    name: str
    sentence: str
    solver: type | str
    effort: float
    options: type | None = None
    table: str = ""
    automatic: bool = True
    exact: bool = False
    kernel: bool = False
    tension: bool = False
    coating: bool = False


def method_class(name: str) -> Any:
    """The class of the method called ``name``; imports its module, and only that. InputError where there is none."""
    if name not in METHODS:
        raise InputError(f"method {name} {absent(f'method {name}') or 'is not known'}")
    solver = METHODS[name].solver
    if isinstance(solver, type):
        return solver
    module, attribute = solver.split(":")
    return getattr(importlib.import_module(module), attribute)


def refusal_of(name: str, method: Method, problem: Problem) -> str | None:
    """Why the ``method`` called ``name`` cannot represent the problem, and the remedy; None where it can."""
    own = METHODS.get(name, Descriptor(name, "", type(method), math.inf))
    missing = (None if own.tension else without_tension(problem)) or (None if own.coating else without_coating(problem))
    return missing or method.refusal(problem)


def without_tension(problem: Problem) -> str | None:
    """Why a method that knows no surface tension refuses the problem; None where it has none."""
    if not problem.specimen.surface_tension:
        return None
    wide = problem.specimen.radius is None
    able = [method.name for method in METHODS.values() if method.tension and (wide or method.name != "layered")]
    return f"does not represent surface tension: use method {' or '.join(able)}, or leave specimen.surface_tension out"


def without_coating(problem: Problem) -> str | None:
    """Why a method that knows no layers of the indenter refuses the problem; None where it has none."""
    if not problem.coatings:
        return None
    other = by_equation(problem.specimen)
    return f"does not represent layers of the indenter: use method {other}, or leave indenter.layers out"


def by_equation(specimen: Specimen) -> str:
    """The method of the contact equation on a body, as a remedy; that of bodies with side walls is of a wing."""
    name = "layered" if specimen.radius is None else "hybrid"
    return name if name in METHODS else f"{name} (install the whole of jkrcli)"


def least_first() -> tuple[str, ...]:
    """Names of the methods that "auto" may choose, in the order in which it asks them."""
    return tuple(method.name for method in METHODS.values() if method.automatic)


# --------------------------------------------------------------------------------------------------
# What a solve may cost: told before it begins where it is much, refused beyond limits that the user can raise.

LARGE = 2048.0  # choice: MiB from which on the memory is announced
LESS = "fewer points, larger elements or a cheaper method"  # what makes a solve cheaper


Limit: TypeAlias = Annotated[float, Ranged("number", above=0, words=(("inf", math.inf),))]


@dataclass(frozen=True)
class Limits(Checked):
    """Limits of a solve that is begun: most ``memory`` [GiB] (None: ``SHARE`` of what is free) and CPU ``hours``."""

    where: ClassVar[str] = "limits"
    memory: Limit | None = None
    hours: Limit = 1.0


def check_cost(what: str, forecast: Forecast, limits: Limits, less: str = LESS) -> str | None:
    """A sentence on what ``what`` will cost, None where that is little; Refusal beyond the limits, with the advice to
    ask for ``less``."""
    memory, hours = forecast.memory_mib / 1024, forecast.seconds / 3600
    most = free_memory() * SHARE / 1024 if limits.memory is None else limits.memory
    size = memory_words(forecast.memory_mib) if memory >= 1 else f"{memory:.3g} GiB"
    needs = f"{what} would need about {size} of memory and {duration(forecast.seconds)} of CPU time"
    remedy = f"use {less}, or raise the limit by"
    if not memory <= most:
        raise Refusal(
            f"{needs}, the limit is {most:.3g} GiB: {remedy} --limit-memory {_raised(memory)}"
            + (" if the machine has that much" if limits.memory is None else "")
        )
    if not hours <= limits.hours:
        raise Refusal(f"{needs}, the limit is {limits.hours:g} h: {remedy} --limit-time {_raised(hours)}")
    if forecast.seconds <= SILENCE and forecast.memory_mib < LARGE:
        return None
    unknown = "; how much memory is free is not known" if math.isinf(most) and limits.memory is None else ""
    memory_too = f" and {size} of memory{unknown}" if forecast.memory_mib >= LARGE else ""
    return f"{what} takes about {duration(forecast.seconds)} of CPU time{memory_too}"


def _raised(value: float) -> str:
    """A limit that leaves some room above ``value``."""
    return f"{float(f'{1.3 * value:.1e}'):g}"


# --------------------------------------------------------------------------------------------------
# Model no more than a scene needs: the least method that can represent a problem, and why.
#
# The rule of "auto", from the charts of speed against accuracy (``make chart``, which checks it): of the methods in
# the order of ``least_first`` the first that represents the body with an unnoticeable expected error within a user's
# patience (``AUTO_PATIENCE``). Each runs with its default mesh or tolerance, the point of its own front beyond which
# more time buys an accuracy that no measurement sees. Slopes: exact where the series carries them, else the surer of
# "integral" and "loocv" (``jkrcli.adhesion.slopes``). The choice lies on the Pareto front of whole-process time and
# error of P or next to it: nothing as exact is quicker by more than a half.

# When a simpler model gives way to a more general one.
AUTO_PATIENCE = 10.0  # tuned on the cases, by `make chart`: CPU seconds that a simpler model may take
AUTO_LOOKS = 3  # at a spectrum, where the largest radius has to be found; choice: for messages


@dataclass(frozen=True)
class Option:
    """One method's answer: what it would cost, or why it cannot do it."""

    name: str
    forecast: Forecast | None
    refusal: str | None

    @property
    def is_quick(self) -> bool:
        """Whether it is possible within a user's patience."""
        return self.forecast is not None and self.forecast.seconds <= AUTO_PATIENCE

    @property
    def is_accurate(self) -> bool:
        """Whether it is possible with an error that is known and too small to be noticed."""
        return self.forecast is not None and self.forecast.error <= NOTICEABLE

    @property
    def objection(self) -> str | None:
        """What speaks against a possible method, so that "auto" takes another that is better; None: nothing."""
        if not self.is_quick:
            return f"would take longer than {AUTO_PATIENCE:g} s"
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
        from .integral.fredholm import InaccurateError

        names = [option.name for option in self.options if option.forecast is not None]
        later = names[names.index(self.name) + 1 :] if self.name in names else []
        failures = (*self.failures, (self.name, str(error)))
        because = "because " + " and ".join(f"{name} failed ({why})" for name, why in dict(failures).items())
        would_do = error.would_do if isinstance(error, InaccurateError) else math.inf  # the tolerance that is reached
        if self.name in names and self.name not in dict(self.failures) and would_do <= NOTICEABLE:
            coarser, method = would_do, replace(cast(Any, self.method), tolerance=would_do)
            return Choice(self.name, method, f"to a tolerance of {coarser:.1e}, {because}", self.options, failures)
        return Choice(later[0], build(later[0]), because, self.options, failures) if later else None


def long_look(problem: Problem) -> str | None:
    """A sentence on what it takes to find out what each method would cost, None where that is a matter of a moment."""
    from .layered.spectrum import spectrum_seconds

    specimen, looks = problem.specimen, 1 if problem.loading.to == "radius" else AUTO_LOOKS
    seconds = looks * spectrum_seconds(problem)
    if seconds < SILENCE:
        return None
    pieces = f" with {counted(specimen.pieces, 'piece')} of E over depth" if specimen.is_graded else ""
    layers = "a layer" if len(problem.layers) == 1 else f"{len(problem.layers):,} layers"
    return f"{layers}{pieces}: estimating the cost of each method takes about {duration(seconds)} of CPU time"


def choose_method(problem: Problem, wanted: str | Method, build: Callable[[str], Method]) -> Choice:
    """The method ``wanted``, by name or itself; for "auto" the first of ``least_first`` that is accurate enough."""
    if wanted != "auto":
        method = build(wanted) if isinstance(wanted, str) else wanted
        kind = type(method)
        made = kind, f"{kind.__module__}:{kind.__name__}"
        name = next((each.name for each in METHODS.values() if each.solver in made), kind.__name__)
        if reason := refusal_of(name, method, problem):
            raise Refusal(f"method {name}: {reason}")
        return Choice(name, method, "set in the case")
    options = survey(problem, build)
    possible = [option for option in options if option.forecast is not None]
    if not possible:
        reasons = [str(option.refusal) for option in options]
        of_loading = [text for text in reasons if text.startswith("loading: ") and reasons.count(text) > 1]
        raise InputError(of_loading[:1] or [f"method {option.name}: {option.refusal}" for option in options])
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


# --------------------------------------------------------------------------------------------------
# The options of the method ``layered``.


@dataclass(frozen=True)
class LayeredOptions(Checked):
    """Options: ``tolerance``, the relative error of delta, P, S and S' at every radius."""

    where: ClassVar[str] = "layered"
    tolerance: Annotated[float, Ranged("number", least=1e-12, most=1e-2)] = 1e-8


# --------------------------------------------------------------------------------------------------
# What is known of each method before it is imported.

_METHODS = (
    Descriptor(
        "closed-form", "Formulae for the half-space and for one thin layer, where they hold.",
        "jkrcli.methods.closed_form:ClosedForm", 10, exact=True, kernel=True,
    ),
    Descriptor(
        "layered", "The exact contact equation of any stack of layers much wider than the contact; no mesh.",
        "jkrcli.methods.layered.solver:Layered", 20, LayeredOptions, exact=True, kernel=True, tension=True,
        coating=True,
    ),
)  # fmt: skip
METHODS = {method.name: method for method in _METHODS}  # by name, least effort first


def register(descriptor: Descriptor) -> None:
    """Make a method known by its name, among those that need less and more effort."""
    by_effort = sorted([*METHODS.values(), descriptor], key=lambda method: method.effort)
    METHODS.clear()
    METHODS.update({method.name: method for method in by_effort})


for _wing in wings():
    for _module in _wing.methods.values():
        importlib.import_module(f"jkrcli.{_module}")  # which registers the method
