"""``jkr fit --free surface_tension``: the tension, E*, w and zeros from records by tips of several radii together."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..base.errors import InputError, SolveError
from ..base.units import parse
from ..report.output import Files, Output
from .fit_law import refuse_unused
from .output import answer
from .voice import say, warn

if TYPE_CHECKING:
    from ..bodies.problem import Problem
    from ..data.measured import Reading
    from ..identification.fit import FittedBody

NAME = "surface_tension"
DIMENSIONS = {"E_star": "modulus", NAME: "tension", "w": "work"}


def is_asked(body: FittedBody, names: Sequence[str], fix: Sequence[tuple[str, str]]) -> bool:
    """Whether surface tension has a part in the fit."""
    return NAME in names or NAME in dict(fix) or body.problem.specimen.surface_tension > 0


def fit_tension(
    body: FittedBody, measured: Sequence[Path], radii: Sequence[float], reading: Reading, names: Sequence[str],
    fix: Sequence[tuple[str, str]], start: Sequence[tuple[str, str]], options: dict[str, Any], targets: Files,
    told: str, output: Output,
) -> None:  # fmt: skip
    """One fit of all curves in all files, its table and summary."""
    from ..data.measured import each
    from ..identification.tension import tension_fit
    from ..report import tension_fit as report

    fixed = _fixed(body.problem, names, fix, start)
    refuse_unused(options, by="surface_tension")
    curves, tips = [], []
    for path, R in zip(measured, _radii(body.problem, radii, len(measured)), strict=True):
        for item in each(path, replace(reading, contact="as-is")):
            if isinstance(item, InputError):
                raise item
            curves.append(item)
            tips.append(R)
    try:
        found = tension_fit(body.problem, curves, tips, fixed, options["level"])
    except SolveError as error:
        raise InputError(f"{measured[0]}: {error}") from None
    targets.write(report.columns(found), report.summary(found, told))
    if output.json:
        answer(report.summary(found, told))
    else:
        say("\n".join(report.words(found, options["level"])))
        say(f"written {targets}")
    for line in found.warnings:
        warn(line)


def _radii(problem: Problem, radii: Sequence[float], count: int) -> Sequence[float]:
    """The tip radius [m] of each file."""
    own = problem.indenter.tip_radius
    if not hasattr(problem.indenter, "R") or own is None:
        raise InputError("fit: surface_tension: needs a sphere or a paraboloid: give indenter.shape one of these")
    if len(radii) not in (0, 1, count):
        raise InputError(f"fit: --tip-radius: give one for each of the {count} files, or one for all, got {len(radii)}")
    return list(radii) if len(radii) == count else [radii[0] if radii else own] * count


def _fixed(
    problem: Problem, names: Sequence[str], fix: Sequence[tuple[str, str]], start: Sequence[tuple[str, str]]
) -> dict[str, float]:
    """Known values by the fit's names; the tension is the body's where it is neither free nor fixed."""
    if problem.specimen.radius is not None:
        raise InputError("fit: surface_tension: a finite cylinder is not solved anew: leave specimen.radius out")
    if start:
        raise InputError(f"fit: surface_tension: starts are looked for, leave out --start {start[0][0]}")
    if other := [name for name in (*names, *dict(fix)) if name not in (*DIMENSIONS, "modulus", "delta0")]:
        raise InputError(f"fit: surface_tension: {other[0]} cannot be free or fixed beside it: leave it out")
    found = {}
    for name, text in fix:
        if name not in DIMENSIONS:
            raise InputError(f"fit: surface_tension: {name} cannot be fixed (allowed: {', '.join(DIMENSIONS)})")
        try:
            found[name.replace("E_star", "modulus")] = parse(text, DIMENSIONS[name])
        except ValueError as error:
            raise InputError(f"fit: {name}: {error}") from None
    if NAME not in names and NAME not in found:
        found[NAME] = problem.specimen.surface_tension
    if not (found.get(NAME, 1.0) > 0 and found.get("modulus", 1.0) > 0 and found.get("w", 0.0) >= 0):
        raise InputError("fit: surface_tension and E_star must be fixed at values > 0, w at one >= 0")
    return found
