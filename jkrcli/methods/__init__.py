"""Methods behind one interface: each is a frozen dataclass that is called with a problem and returns a solution."""

from __future__ import annotations

import importlib
from dataclasses import dataclass
from typing import Any, Protocol

from ..bodies.problem import Problem
from ..series import Solution

METHODS = {
    "closed-form": "jkrcli.methods.closed_form:ClosedForm",
    "layered": "jkrcli.methods.layered.layered:Layered",
    "hybrid": "jkrcli.methods.hybrid.method:Hybrid",
    "fem": "jkrcli.methods.fem.method:FEM",
}


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


def method_class(name: str) -> Any:
    """The class of the method called ``name``; imports its module, and only that."""
    module, attribute = METHODS[name].split(":")
    return getattr(importlib.import_module(module), attribute)
