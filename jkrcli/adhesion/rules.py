"""The rules by which slopes of a series are found, by name.

A rule gives the place of its function, which is imported when it is called; a rule of one's own registers itself in
any module that has been imported.
"""

from __future__ import annotations

import importlib
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from ..base.errors import InputError, did_you_mean

SLOPES = "jkrcli.adhesion.slopes"


@dataclass(frozen=True)
class Rule:
    """A way to find slopes, known before anything heavy is imported.

    ``sentence``: what it does. ``function``: of a series, or "module:function", imported when called. ``optimistic``:
    whether its own error estimate misses what "integral" shows, and is raised to that. ``quantised``: whether it takes
    radii as they are, so that those of nodes must be evenly spaced.
    """

    name: str
    sentence: str
    function: Callable[[Any], Any] | str
    optimistic: bool = False
    quantised: bool = False

    def __call__(self, series: Any) -> Any:
        """The slopes of a ``Series``, as ``Slopes``."""
        if not isinstance(self.function, str):
            return self.function(series)
        module, attribute = self.function.split(":")
        return getattr(importlib.import_module(module), attribute)(series)


def checked_rule(name: Any, where: str = "slopes") -> str:
    """``name`` if it is "auto" or that of a rule; InputError that begins with ``where`` otherwise."""
    known = ["auto", *RULES]
    if name not in known:
        raise InputError(f'{where}: must be one of {", ".join(known)}, got "{name}"{did_you_mean(name, known)}')
    return str(name)


def slopes_function(name: str) -> Rule:
    """The rule called ``name``."""
    return RULES[name] if name in RULES else RULES[checked_rule(name)]


# By name, in the order in which messages name them. "loocv", the paper's, and "gcv", the same with another measure of
# the smoothing; of both S is re-evaluated by the smoothing spline, or kept from the cubic spline P(delta).
RULES = {
    "exact": Rule("exact", "The slopes that the solution carries; nothing is smoothed.", f"{SLOPES}:exact"),
    "integral": Rule(
        "integral", "S' and d(delta_H)/da fitted through their integrals; nothing is differentiated.",
        f"{SLOPES}.integral:integral",
    ),
}  # fmt: skip
for _name, _left_out in (("loocv", "leave-one-out"), ("gcv", "generalised")):
    _place = f"{SLOPES}.loocv:{_name}"
    _sentence = f"Derivative of a spline P(delta), smoothed over a by {_left_out} cross-validation."
    RULES[_name] = Rule(_name, _sentence, _place, optimistic=True, quantised=True)
    _sentence = f"As {_name}, with S kept from the spline P(delta): the paper's examples."
    RULES[f"{_name}-kept"] = Rule(f"{_name}-kept", _sentence, f"{_place}_kept", optimistic=True, quantised=True)
RULES["loocv-smoothed"] = Rule(
    "loocv-smoothed", "As loocv, with S' smoothed by a spline of its own.", f"{SLOPES}.loocv:loocv_smoothed",
    optimistic=True, quantised=True,
)  # fmt: skip


def register(rule: Rule) -> None:
    """Make a rule known by its name."""
    RULES[rule.name] = rule
