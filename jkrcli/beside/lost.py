"""Where contact is lost under every control, its points solved again, and nothing at radii below atoms."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TypeAlias

from ..adhesion import DISPLACEMENT_CONTROL, LOAD_CONTROL, AskedRange, Behaviour, Errors, behaviours, resolved
from ..base import Unknown
from ..series import Solution
from .analysis import Analysis, analyse, error_of_point, with_solved_points

TINY = Unknown("it would be one of a contact smaller than atoms")
Lost: TypeAlias = tuple[Behaviour, Errors | Unknown | None]  # read off under one control; half-widths of its pull-off


def where_lost(
    solution: Solution, works: Sequence[float], stiffnesses: Sequence[float], slopes: str, modulus_factor: float,
    asked: AskedRange,
) -> list[tuple[Analysis, list[Lost]]]:  # fmt: skip
    """For each of the ``works`` [J/m^2] the curve, and what is read off under each control: by a device of one of the
    ``stiffnesses`` [N/m], else of load and displacement."""
    controls = stiffnesses or (LOAD_CONTROL, DISPLACEMENT_CONTROL)
    found = analyse(solution, works, slopes, modulus_factor, asked)
    curves = [with_solved_points(curve, *stiffnesses) for curve in found]
    return [(curve, [_lost(curve, found) for found in behaviours(curve.curve, controls)]) for curve in curves]


def _lost(result: Analysis, behaviour: Behaviour) -> Lost:
    """What is read off a curve under one control; half-widths of its pull-off point, None where there is none."""
    found = _above_atoms(behaviour, result)
    if isinstance(found.pull_off, Unknown):
        return found, None
    return found, error_of_point(result.curve, found.pull_off, found.stiffness)


def _above_atoms(found: Behaviour, result: Analysis) -> Behaviour:
    """What was read off without what would happen at radii below atoms."""
    point = resolved(found.pull_off, result.curve, found.stiffness, result.solution.record.z0)
    if point is found.pull_off or not isinstance(point, Unknown):
        return found
    return replace(found, critical=(), pull_off=point, jump_in=TINY, energy_lost=TINY, separation=TINY)
