"""The one interface of all methods, and the register in which they make themselves known."""

from __future__ import annotations

import importlib
from dataclasses import dataclass, fields
from functools import cached_property
from typing import Any, Protocol, get_type_hints

from ..bodies import Problem
from ..series import Solution


@dataclass(frozen=True)
class Forecast:
    """What a solve would cost: CPU seconds, peak memory [MiB], expected relative error, and a word on each."""

    seconds: float
    memory_mib: float
    error: float
    note: str = ""


class Method(Protocol):
    """Fields are the options, the docstring states the validity; methods share the result type, not a base class."""

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
class Place:
    """Where an option stands in a case file, its annotation and its default."""

    table: str
    key: str
    annotation: Any
    default: Any


@dataclass(frozen=True)
class Descriptor:
    """What is known of a method before its solver is imported.

    ``sentence``: what it does. ``solver``: its class, or "module:class", imported when called. ``effort``: the least
    model that represents a body is tried first. ``options``: a dataclass of the method's options, with a default each
    and ranges in the annotations, which stand in the case file's table ``table`` (its name where empty; or
    ``InTable``). ``automatic``: whether "auto" may choose it. ``exact``: to round-off or its tolerance, at next to no
    cost; ``kernel``: its bodies have the kernel of the contact equation (see ``methods.attraction``); ``tension``:
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

    @cached_property
    def places(self) -> dict[str, Place]:
        """The options by name."""
        if self.options is None:
            return {}
        hints = get_type_hints(self.options, include_extras=True)
        return {item.name: self._place(item.name, hints[item.name], item.default) for item in fields(self.options)}

    def _place(self, name: str, annotation: Any, default: Any) -> Place:
        elsewhere = [note for note in getattr(annotation, "__metadata__", ()) if isinstance(note, InTable)]
        where = elsewhere[0] if elsewhere else InTable(self.table or self.name, name)
        return Place(where.table, where.key, annotation, default)


METHODS: dict[str, Descriptor] = {}  # by name, least effort first


def register(descriptor: Descriptor) -> None:
    """Make a method known by its name, among those that need less and more effort."""
    by_effort = sorted([*METHODS.values(), descriptor], key=lambda method: method.effort)
    METHODS.clear()
    METHODS.update({method.name: method for method in by_effort})


def method_class(name: str) -> Any:
    """The class of the method called ``name``; imports its module, and only that."""
    solver = METHODS[name].solver
    if isinstance(solver, type):
        return solver
    module, attribute = solver.split(":")
    return getattr(importlib.import_module(module), attribute)


def refusal_of(name: str, method: Method, problem: Problem) -> str | None:
    """Why the ``method`` called ``name`` cannot represent the problem, and the remedy; None where it can."""
    tense = name in METHODS and METHODS[name].tension
    coated = name in METHODS and METHODS[name].coating
    missing = (None if tense else without_tension(problem)) or (None if coated else without_coating(problem))
    return missing or method.refusal(problem)


def without_tension(problem: Problem) -> str | None:
    """Why a method that knows no surface tension refuses the problem; None where it has none."""
    if not problem.specimen.surface_tension:
        return None
    able = [method.name for method in METHODS.values() if method.tension]
    if problem.specimen.radius is not None:
        able.remove("layered")
    return f"does not represent surface tension: use method {' or '.join(able)}, or leave specimen.surface_tension out"


def without_coating(problem: Problem) -> str | None:
    """Why a method that knows no layers of the indenter refuses the problem; None where it has none."""
    if not problem.coatings:
        return None
    able = [method.name for method in METHODS.values() if method.coating and problem.specimen.radius is None]
    use = f"use method {' or '.join(able)}, or " if able else ""
    return f"does not represent layers of the indenter: {use}leave indenter.layers out"


def least_first() -> tuple[str, ...]:
    """Names of the methods that "auto" may choose, in the order in which it asks them."""
    return tuple(method.name for method in METHODS.values() if method.automatic)
