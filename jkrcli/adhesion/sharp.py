"""Contacts too small or too hard pressed for the theory: pull-off at radii below atoms, pressures that bodies yield to.

A cone has no length of its own, so that JKR theory goes on to any radius: a stiff one loses contact at picometres.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from ..base import Unknown, show
from ..bodies import Problem
from .curve import CriticalPoint, EquilibriumCurve, position


@dataclass(frozen=True)
class SharpTuning:
    """When a contact is no longer one of an elastic continuum."""

    near: float = 3.0  # choice: distances of atoms z0 within which the end of a series is as good as pull-off itself
    pressure: float = 0.1  # theory: of E*, the order of the ideal strength; hardness is less (Johnson 1985, ch. 6)
    stiff: float = 1e8  # choice: Pa; gels and rubbers below it stretch instead of flowing


TUNING = SharpTuning()


def resolved(
    point: CriticalPoint | Unknown, curve: EquilibriumCurve, stiffness: float, z0: float
) -> CriticalPoint | Unknown:
    """A pull-off point under a device of ``stiffness`` [N/m], or Unknown where it lies at a radius below ``z0`` [m]."""
    if curve.ranged:  # its surfaces may attract each other without contact
        return point
    if isinstance(point, CriticalPoint):
        small = point.a < z0
    else:
        small = curve.a[0] < TUNING.near * z0 and np.argmin(position(curve.delta, curve.P, stiffness)) == 0
    if not small:
        return point
    return Unknown(
        f"contact would shrink below the interatomic spacing, z0 = {show(z0, 'length')}, before it is lost, where "
        'nothing is a continuum: give the radius that every real tip has (shape = "sphere", or a profile as "table"); '
        "of a tip so small that its Tabor number is below 0.1, forces of finite range pull off at about 2 pi w R"
    )


def yielding(problem: Problem, curve: EquilibriumCurve) -> list[str]:
    """A warning where the mean pressure at the largest radius is one at which stiff bodies yield; confined layers,
    whose pressure is hydrostatic, and gels are left out."""
    a, P = float(curve.series.a[-1]), float(curve.series.P[-1])
    mean = P / (math.pi * a**2 * problem.E_star)
    confined = a > (problem.specimen.top_thickness or math.inf)
    if mean <= TUNING.pressure or problem.E_star < TUNING.stiff or confined:
        return []
    return [
        f"mean pressure {mean:.2g} E* at the largest contact radius is above {TUNING.pressure:g} E*: most materials of "
        "that stiffness flow plastically first, and the contact is then larger than an elastic one"
    ]
