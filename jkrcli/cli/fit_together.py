"""``jkr fit`` of records together: what they share, a law of w over the edge's speed, a surface tension; and of laws of
relaxation."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeVar

from .. import data, report
from ..base import InputError, SolveError, one_thread
from ..identification import fit as fits
from .fit_idle import TENSION
from .voice import give, warn

Beside = TypeVar("Beside")


@dataclass(frozen=True, eq=False)
class FitRequest:
    """What is fitted to what, how the files are read, and where it goes; ``names``: of what is free beside the usual;
    ``body_words``: the ``body`` in words; ``options``: of the fit, by name; ``inputs``: files not to write over."""

    body: fits.FittedBody
    measured: Sequence[Path]
    reading: data.Reading
    names: Sequence[str]
    options: dict[str, Any]
    targets: report.Files
    body_words: str
    output: report.Output
    inputs: Sequence[Path]

    def curves(self, beside: Sequence[Beside]) -> tuple[list[data.Curve], list[Beside]]:
        """The curves in all files, each with what stands ``beside`` its file; InputError where one cannot be read."""
        pairs = [(item, one) for path, one in zip(self.measured, beside, strict=True)
                 for item in data.each(path, self.reading)]  # fmt: skip
        for item, _ in pairs:
            if isinstance(item, InputError):
                raise item
        return [item for item, _ in pairs if not isinstance(item, InputError)], [one for _, one in pairs]

    def conclude(self, kind: type[report.Result], fit: Callable[[], Any], **more: Any) -> None:
        """One fit of all curves as a result of a ``kind``, with what is ``more``: its table, summary and, where it has
        one, picture."""
        try:
            with one_thread():
                result = report.as_result(kind, fit(), body=self.body_words, **more)
        except SolveError as error:
            raise InputError(f"{self.measured[0]}: {error}") from None
        self.write(result)

    def write(self, result: report.Result) -> None:
        """The files of a ``result``, and what is said of it."""
        self.targets.write(result.columns, result.summary(), self.targets.draw(result.figure))
        give(result, self.output.json, f"  written {self.targets}")


def fit_joint(request: FitRequest, settings: fits.Settings) -> None:
    """What all records have in common, from all of them together."""
    shared, own = ([name for group in request.options[kind] for name in group] for kind in ("shared", "own"))
    names = fits.shared_of(shared, own, settings)
    curves, bodies = request.curves(fits.with_radii(request.body, request.options["tip_radius"], len(request.measured)))
    request.conclude(report.JointFitted, lambda: fits.joint_fit(bodies, curves, settings, names), level=settings.level)


def fit_law(request: FitRequest) -> None:
    """w0, the law's parameters, E* and zeros from records at one or several speeds."""
    from ..identification.rate.fitting import rate_fit, rate_settings

    law, fix, start = (request.options[name] for name in ("law", "fix", "start"))
    how = {name: request.options[name] for name in ("level", "segment", "confidence")}
    settings = rate_settings(request.body, law, request.names, fix, start, **how)
    curves, _ = request.curves(request.measured)
    request.conclude(report.LawFit, lambda: rate_fit(request.body, curves, settings))


def has_tension(request: FitRequest) -> bool:
    """Whether surface tension has a part in the fit."""
    named = TENSION in request.names or TENSION in dict(request.options["fix"])
    return named or request.body.problem.specimen.surface_tension > 0


def fit_tension(request: FitRequest) -> None:
    """The surface tension, E*, w and zeros from records by tips of several radii."""
    from ..identification.tension import known_values, radii_of, tension_fit

    problem, level = request.body.problem, request.options["level"]
    fixed = known_values(problem, request.names, request.options["fix"])
    curves, tips = request.curves(radii_of(problem, request.options["tip_radius"], len(request.measured)))
    request.conclude(report.TensionFitted, lambda: tension_fit(problem, curves, tips, fixed, level), level=level)


def fit_relaxation(request: FitRequest) -> None:
    """The modulus, a law of relaxation and zeros from records over time, each for itself; curves that cannot be used
    are skipped and said."""
    from ..identification.relaxation import relaxation_fit, relaxation_settings

    body, options = request.body, request.options
    terms = {} if options["terms"] is None else {"terms": options["terms"]}
    how = {name: options[name] for name in ("level", "confidence")} | terms
    settings = relaxation_settings(options["relaxation"], options["fix"], request.names, body.problem.E_star, **how)
    curves, skipped = data.usable(request.measured, request.reading)
    done = []
    for curve in curves:
        try:
            part = curve if options["segment"] in (None, "both") else curve.only(options["segment"])
            with one_thread():
                done.append(relaxation_fit(body, part, settings))
        except InputError as error:
            skipped += error.lines
    if not done:
        raise InputError(data.some(skipped))
    for line in skipped:
        warn(f"skipped: {line}")
    request.write(report.RelaxationFits(done, request.body_words))
