"""Where contact is lost under every control, its points solved again, and nothing at radii below atoms."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TypeAlias

from ..adhesion import DISPLACEMENT_CONTROL, LOAD_CONTROL, Behaviour, Errors, RangeRequest, behaviours, resolved
from ..base import Unknown
from ..series import Solution
from .analysis import Analysis, analyse, error_of_point, with_solved_points

TINY = Unknown("it would be one of a contact smaller than atoms")
Lost: TypeAlias = tuple[Behaviour, Errors | Unknown | None]  # read off under one control; half-widths of its pull-off


def where_lost(
    solution: Solution, works: Sequence[float], stiffnesses: Sequence[float], slopes: str, modulus_factor: float,
    request: RangeRequest,
) -> list[tuple[Analysis, list[Lost]]]:  # fmt: skip
    """For each of the ``works`` [J/m^2] the curve, and what is read off under each control: by a device of one of the
    ``stiffnesses`` [N/m], else of load and displacement."""
    controls = stiffnesses or (LOAD_CONTROL, DISPLACEMENT_CONTROL)
    results = [
        with_solved_points(result, *stiffnesses) for result in analyse(solution, works, slopes, modulus_factor, request)
    ]
    return [(result, [_lost(result, each) for each in behaviours(result.curve, controls)]) for result in results]


def _lost(result: Analysis, behaviour: Behaviour) -> Lost:
    """What is read off a curve under one control; half-widths of its pull-off point, None where there is none."""
    above_atoms = _above_atoms(behaviour, result)
    if isinstance(above_atoms.pull_off, Unknown):
        return above_atoms, None
    return above_atoms, error_of_point(result.curve, above_atoms.pull_off, above_atoms.stiffness)


def _above_atoms(behaviour: Behaviour, result: Analysis) -> Behaviour:
    """The behaviour without what would happen at radii below atoms."""
    point = resolved(behaviour.pull_off, result.curve, behaviour.stiffness, result.solution.record.z0)
    if point is behaviour.pull_off or not isinstance(point, Unknown):
        return behaviour
    return replace(behaviour, critical=(), pull_off=point, jump_in=TINY, energy_lost=TINY, separation=TINY)
