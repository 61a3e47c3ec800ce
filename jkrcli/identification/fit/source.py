"""Where the body of a fit comes from: a case, which is solved on the way, or a series that was solved before."""

from __future__ import annotations

from pathlib import Path

from ...adhesion.analysis import Fitted, specification
from ...adhesion.slopes.choice import slopes as slopes_of
from ...case import Case, load_case, store
from ...case.solving import solve
from ...case.store import Stored
from ...methods.guards import Limits
from .body import FittedBody


def body_of(source: Case | Stored | Path, slopes: str = "auto", limits: Limits | None = None) -> FittedBody:
    """The body of a case, of what a series file holds, or of either's file. A case may be solved anew to the radii that
    the data ask for, a series ends where it ends."""
    if isinstance(source, Path):
        source = load_case(source) if source.suffix == ".toml" else store.read(source)
    if isinstance(source, Case):
        problem = source.model.problem()
        _, solution = solve(source, limits=limits)
        found = slopes_of(solution.series, slopes)
        return FittedBody.of(problem, solution.series, found, problem.specimen.radius is None)
    fitted = Fitted.of(source, specification(source), slopes)
    return FittedBody.of(fitted.case.problem, fitted.series, fitted.slopes)
