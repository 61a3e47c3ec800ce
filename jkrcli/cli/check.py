"""``jkr check``: what a case needs and what to expect, without solving it."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path
from typing import Any

import click

from ..adhesion import validity
from ..adhesion.curve import CriticalPoint
from ..adhesion.expectation import Expectation, expect
from ..adhesion.finite_range import unable
from ..adhesion.sticking import StickingEffect, as_told, sticking_effect, sticking_warnings
from ..base.errors import Refusal
from ..base.units import show
from ..base.unknown import Estimate, Unknown
from ..case import load_case
from ..case.models import CaseModel
from ..case.numerics import method_of
from ..methods.choose import Option, choose, long_look, survey
from ..report import tables
from .output import answer, json_option
from .series import reached
from .verb import Verb
from .voice import note, say, warn


@click.command(cls=Verb)
@click.argument("case", type=click.Path(path_type=Path))
@json_option
def check(case: Path, as_json: bool) -> None:
    """Validate CASE and say which method it needs and why, what each would cost, and what to expect.

    The expectation is a coarse solution of the laterally unbounded body; nothing is written.

    \b
    jkr check cases/thin-layer.toml
    """
    loaded = load_case(case)
    model = loaded.model
    problem = model.problem()
    if words := long_look(problem):
        note(words)
    choice = choose(problem, model.method, lambda name: method_of(model, name))
    options = choice.options or survey(problem, lambda name: method_of(model, name))
    expected = _expected(model)
    effect = _effect(model, expected)
    if as_json:
        data = {"case": str(case), "problem": problem.words, "method": choice.name, "reason": choice.reason}
        law = problem.specimen.relaxation
        data |= {
            "relaxation": "" if law is None else str(law),
            "surface": problem.surface,
            "sticking": as_told(effect),
        }
        answer(data | {"options": [asdict(o) for o in options]} | _as_dict(expected))
        return
    say(problem.words)
    say(f"  method    {choice.name}: {choice.brief}")
    for option in options:
        say(f"            {option.name:<12} {_option(option)}")
    range_ = _range(model, choice.name)
    _print(expected, range_)
    if (law := problem.specimen.relaxation) is not None:
        loads = "t = 0" if law.relaxed is not None else "the law's time"
        say(f"  relaxes   {law}; loads here are those of {loads}")
    if not isinstance(effect, Unknown):
        say(f"  sticking  against sliding makes {effect.words} as large")
    refused = [f"jkr transform will refuse: {range_}"] if isinstance(range_, Unknown) else []
    for warning in (*refused, *loaded.remarks, *sticking_warnings(problem, effect)):
        warn(warning)


def _range(model: CaseModel, method: str) -> str | Unknown:
    """What is said of the range of adhesion that a case asks for, empty where it asks for none; or why it has no
    curve."""
    adhesion = model.adhesion
    if not (adhesion.range or adhesion.stress or adhesion.capillary):
        return ""
    reason = unable(model.problem(), method)
    return Unknown(reason) if reason else "its range will be solved; the force here is that of JKR"


def _effect(model: CaseModel, expected: Expectation | Unknown) -> StickingEffect | Unknown:
    """What it matters whether the surfaces stick, at the largest radius expected."""
    if isinstance(expected, Unknown):
        return expected
    return sticking_effect(model.problem(), expected.a, model.adhesion.w)


def _expected(model: CaseModel) -> Expectation | Unknown:
    """What to expect, or why that is not known."""
    try:
        return expect(model.problem(), model.adhesion.w, model.adhesion.z0)
    except Refusal as error:
        return Unknown(str(error))


def _option(option: Option) -> str:
    if option.forecast is None:
        return f"cannot: {option.refusal}"
    note = f" ({option.forecast.note})" if option.forecast.note else ""
    against = f"; {words}" if (words := option.objection) else ""
    return f"about {option.cost}, {option.forecast.memory_mib:.0f} MiB{note}{against}"


def _as_dict(expected: Expectation | Unknown) -> dict[str, Any]:
    if isinstance(expected, Unknown):
        return {"expectation": expected}
    return {
        "a_m": expected.a,
        "delta_m": expected.delta,
        "P_N": expected.P,
        "half_space_error": expected.half_space_error,
        "adhesion": [
            {"w_J_per_m2": w, "pull_off": tables.point(p), "validity": vars(v)} for w, p, v in expected.adhesion
        ],
    }


def _print(expected: Expectation | Unknown, range_: str | Unknown) -> None:
    if isinstance(expected, Unknown):
        say(f"  reaches   unknown: {expected}")
        return
    say(f"  reaches   {reached(expected.a, expected.delta, expected.P)}")
    if expected.half_space_error is not None:
        ratio = 1 + expected.half_space_error
        say(f"  layers    make the load at this depth {ratio:.4g} times that of a half-space of the top material")
    for w, point, judged in expected.adhesion:
        say(f"  w = {show(w, 'work')}: pull-off (load control): {_pull_off(point)}")
        regime = f": {judged.regime}" if not isinstance(judged.tabor, Unknown) else ""
        regime = regime if range_ == "" else "" if isinstance(range_, Unknown) else f"; {range_}"
        say(f"            Tabor number {_ratio(judged.tabor)}{regime}")
        sizes = {"a/R": judged.a_over_R, "a/h": judged.a_over_h, "delta/h": judged.delta_over_h}
        known = [f"{name} = {value:.3g}" for name, value in sizes.items() if not isinstance(value, Unknown)]
        if known:
            say(f"            {', '.join(known)}")
    for warning in dict.fromkeys(text for _, _, judged in expected.adhesion for text in validity.check(judged)):
        warn(warning)


def _pull_off(point: CriticalPoint | Unknown) -> str:
    if isinstance(point, Unknown):
        return point.reason
    return f"P = {show(point.P, 'load')} at a = {show(point.a, 'length')}"


def _ratio(value: Estimate) -> str:
    return f"none ({value})" if isinstance(value, Unknown) else f"{value:.3g}"
