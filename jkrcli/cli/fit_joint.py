"""``jkr fit --shared``: what all records have in common, from all of them together."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from ..base import InputError, SolveError
from .fit_law import Asked
from .output import give

if TYPE_CHECKING:
    from ..identification.fit import Settings


def fit_joint(
    asked: Asked, radii: Sequence[float], settings: Settings, shared: Sequence[str], own: Sequence[str]
) -> None:
    """One fit of all curves in all files, its table, summary and picture."""
    from ..base import one_thread
    from ..data.measured import each
    from ..identification.fit.joint import joint_fit, shared_of, with_radii
    from ..report.joint_fit import JointFitted
    from ..report.result import as_result

    names, curves, bodies = shared_of(shared, own, settings), [], []
    for path, one in zip(asked.measured, with_radii(asked.body, radii, len(asked.measured)), strict=True):
        for item in each(path, asked.reading):
            if isinstance(item, InputError):
                raise item
            curves.append(item)
            bodies.append(one)
    try:
        with one_thread():
            found = as_result(
                JointFitted, joint_fit(bodies, curves, settings, names), body=asked.told, level=settings.level
            )
    except SolveError as error:
        raise InputError(f"{asked.measured[0]}: {error}") from None
    asked.targets.write(found.columns, found.summary(), asked.targets.draw(found.figure))
    give(found, asked.output, f"  written {asked.targets}")
