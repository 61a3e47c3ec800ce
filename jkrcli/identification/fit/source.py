"""Where the body of a fit comes from: a case, which is solved on the way, or a series that was solved before."""

from __future__ import annotations

from pathlib import Path

from ...adhesion.analysis import nonadhesive
from ...adhesion.slopes.choice import slopes as slopes_of
from ...case import Case, load_case, store
from ...case.solving import solve
from ...methods.guards import Limits
from ...series import Solution
from .body import FittedBody


def body_of(source: Case | Solution | Path, slopes: str = "auto", limits: Limits | None = None) -> FittedBody:
    """The body of a case, of a solution, or of either's file. A case may be solved anew to the radii that the data ask
    for, a solution ends where it ends."""
    if isinstance(source, Path):
        source = load_case(source) if source.suffix == ".toml" else store.read(source)
    if isinstance(source, Solution):
        body = nonadhesive(source, slopes)
        return FittedBody.of(source.problem, body.series, body.slopes)
    _, solution = solve(source, limits=limits)
    problem, series = solution.problem, solution.series
    return FittedBody.of(problem, series, slopes_of(series, slopes), problem.specimen.radius is None)
