"""From what a user types to what a fit is asked: names, values with units, bounds."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import Any

from ...base.errors import InputError
from ...base.units import parse
from .body import Body
from .parameters import DIMENSIONS, Parameter, checked_names
from .settings import Settings

ALIAS = "E_star"  # the common modulus by its value rather than as a factor
USUALLY_FREE = ("modulus", "w", "delta0")
BETWEEN = ".."


def settings_of(
    body: Body,
    free: Iterable[str] = (),
    fix: Iterable[tuple[str, str]] = (),
    start: Iterable[tuple[str, str]] = (),
    bound: Iterable[tuple[str, str]] = (),
    **options: Any,
) -> Settings:
    """The settings for ``body``; texts such as ("w", "50 mJ/m^2"), ("E:film", "1 MPa..1 GPa"); InputError names them.

    Free are the common modulus, w and delta0, but for those that ``fix`` names, and what ``free`` adds. Where that is
    a quantity of a layer, the common modulus stays as in the case unless it is named too.
    """
    fixed, starts, bounds = (_by_name(body, pairs) for pairs in (fix, start, bound))
    wanted = list(dict.fromkeys(_own_name(body, name) for name in free))
    of_layers = any(":" in name for name in wanted)
    usual = [name for name in USUALLY_FREE if not (name == "modulus" and of_layers)]
    names = [name for name in DIMENSIONS if name in (*usual, *wanted)] + [name for name in wanted if ":" in name]
    if both := sorted(set(wanted) & set(fixed)):
        raise InputError(f"fit: {both[0]} is both free and fixed")
    names = [name for name in names if name not in fixed]
    if idle := sorted({*starts, *bounds} - set(names)):
        raise InputError(f"fit: {idle[0]} is not free: a start or a bound has no meaning (free: {', '.join(names)})")
    found = []
    for name in names:
        low, high = _bounds(body, name, bounds[name]) if name in bounds else (-math.inf, math.inf)
        value = _value(body, name, *starts[name]) if name in starts else None
        found.append(Parameter(name, True, value, low, high))
    found += [Parameter(name, False, _value(body, name, *text)) for name, text in fixed.items()]
    return Settings(tuple(found), **options)


def uncertain_of(body: Body, pairs: Iterable[tuple[str, str]], settings: Settings) -> dict[str, float]:
    """Standard deviations of inputs by name: "nu" and "thickness" of the layer at the contact, or "nu:film", "h:film",
    "E:base", absolute ("0.02", "50 nm") or relative ("5%")."""
    found = {}
    for name, text in pairs:
        whole = {"nu": f"nu:{body.layer_names[0]}", "thickness": f"h:{body.layer_names[0]}"}.get(name, name)
        allowed = (*body.own_parameters, *(f"nu:{layer}" for layer in body.layer_names if body.own_parameters))
        checked_names([whole], allowed)
        fitted = settings.parameter(whole)
        if fitted is not None:
            raise InputError(f"fit: {whole} is {'free' if fitted.free else 'fixed'}, it cannot be uncertain as well")
        value = _share(text, body.nominal(whole)) if text.endswith("%") else _parsed(name, text, _dimension(whole))
        if not (math.isfinite(value) and value > 0):
            raise InputError(f"fit: the uncertainty of {name} must be > 0, got {text}")
        found[whole] = value
    return found


def _share(text: str, value: float) -> float:
    return _parsed("uncertain", text[:-1], "number") / 100 * abs(value)


def _by_name(body: Body, pairs: Iterable[tuple[str, str]]) -> dict[str, tuple[str, str]]:
    """Parameter -> (name as the user wrote it, text)."""
    found: dict[str, tuple[str, str]] = {}
    for name, text in pairs:
        own = _own_name(body, name)
        if own in found:
            raise InputError(f"fit: {name} is given twice")
        found[own] = (name, text)
    return found


def _own_name(body: Body, name: str) -> str:
    if name == ALIAS:
        return "modulus"
    checked_names([name], (*DIMENSIONS, ALIAS, *body.own_parameters))
    return name


def _value(body: Body, name: str, written: str, text: str) -> float:
    value = _parsed(written, text, "modulus" if written == ALIAS else _dimension(name))
    return value / body.problem.E_star if written == ALIAS else value


def _bounds(body: Body, name: str, pair: tuple[str, str]) -> tuple[float, float]:
    written, text = pair
    low, mark, high = text.partition(BETWEEN)
    if not mark:
        raise InputError(f'fit: the bounds of {written} must be LOW{BETWEEN}HIGH, one may be left out, got "{text}"')
    ends = [_value(body, name, written, part.strip()) if part.strip() else None for part in (low, high)]
    return -math.inf if ends[0] is None else ends[0], math.inf if ends[1] is None else ends[1]


def _dimension(name: str) -> str:
    return Parameter(name, True).dimension


def _parsed(name: str, text: str, dimension: str) -> float:
    try:
        return parse(text, dimension)
    except ValueError as error:
        raise InputError(f"fit: {name}: {error}") from None
