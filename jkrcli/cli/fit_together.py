"""``jkr fit`` of all records together: what they share, a law of w over the edge's speed, a surface tension."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

from ..base import InputError, SolveError
from ..report import Files, Output
from .fit_idle import TENSION
from .output import give

if TYPE_CHECKING:
    from ..data import Curve, Reading
    from ..identification.fit import FittedBody, Settings
    from ..report import Result

Beside = TypeVar("Beside")


@dataclass(frozen=True, eq=False)
class Asked:
    """What is fitted to what, how the files are read, and where it goes; ``names``: of what is free beside the usual;
    ``told``: the ``body`` in words; ``options``: of the fit, by name."""

    body: FittedBody
    measured: Sequence[Path]
    reading: Reading
    names: Sequence[str]
    options: dict[str, Any]
    targets: Files
    told: str
    output: Output

    def curves(self, beside: Sequence[Beside]) -> tuple[list[Curve], list[Beside]]:
        """The curves in all files, each with what stands ``beside`` its file; InputError where one cannot be read."""
        from ..data import each

        found = [(item, one) for path, one in zip(self.measured, beside, strict=True)
                 for item in each(path, self.reading)]  # fmt: skip
        for item, _ in found:
            if isinstance(item, InputError):
                raise item
        return [item for item, _ in found if not isinstance(item, InputError)], [one for _, one in found]

    def conclude(self, fit: Callable[[], Result]) -> None:
        """One fit of all curves, its table, summary and, where it has one, picture."""
        from ..base import one_thread

        try:
            with one_thread():
                found = fit()
        except SolveError as error:
            raise InputError(f"{self.measured[0]}: {error}") from None
        self.targets.write(found.columns, found.summary(), self.targets.draw(found.figure))
        give(found, self.output.json, f"  written {self.targets}")


def fit_joint(asked: Asked, settings: Settings) -> None:
    """What all records have in common, from all of them together."""
    from ..identification.fit import joint_fit, shared_of, with_radii
    from ..report import JointFitted, as_result

    shared, own = ([name for group in asked.options[kind] for name in group] for kind in ("shared", "own"))
    names = shared_of(shared, own, settings)
    curves, bodies = asked.curves(with_radii(asked.body, asked.options["tip_radius"], len(asked.measured)))
    told = {"body": asked.told, "level": settings.level}
    asked.conclude(lambda: as_result(JointFitted, joint_fit(bodies, curves, settings, names), **told))


def fit_law(asked: Asked) -> None:
    """w0, the law's parameters, E* and zeros from records at one or several speeds."""
    from ..identification.rate.fitting import rate_fit, rate_settings
    from ..report import LawFit, as_result

    law, fix, start = (asked.options[name] for name in ("law", "fix", "start"))
    told = {name: asked.options[name] for name in ("level", "segment", "confidence")}
    settings = rate_settings(asked.body, law, asked.names, fix, start, **told)
    curves, _ = asked.curves(asked.measured)
    asked.conclude(lambda: as_result(LawFit, rate_fit(asked.body, curves, settings), body=asked.told))


def is_asked(asked: Asked) -> bool:
    """Whether surface tension has a part in the fit."""
    named = TENSION in asked.names or TENSION in dict(asked.options["fix"])
    return named or asked.body.problem.specimen.surface_tension > 0


def fit_tension(asked: Asked) -> None:
    """The surface tension, E*, w and zeros from records by tips of several radii."""
    from ..identification.tension import known_values, radii_of, tension_fit
    from ..report import TensionFitted, as_result

    problem, level = asked.body.problem, asked.options["level"]
    fixed = known_values(problem, asked.names, asked.options["fix"])
    curves, tips = asked.curves(radii_of(problem, asked.options["tip_radius"], len(asked.measured)))
    told = {"body": asked.told, "level": level}
    asked.conclude(lambda: as_result(TensionFitted, tension_fit(problem, curves, tips, fixed, level), **told))
