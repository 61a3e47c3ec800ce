"""``jkr check``: what a case needs and what to expect, without solving it."""

from __future__ import annotations

from pathlib import Path

from ..case.reading import load_case
from ..methods.protocol import long_look
from ..report.check import Check
from ..resolve.neglected import seconds_of_works
from .options import json_option
from .output import announce, give, note
from .verb import verb


@verb("case")
@json_option
def check(case: Path, as_json: bool) -> None:
    """Check CASE before it is solved: the method that it needs, what each would cost, the pull-off force to expect, and
    how large the neglected effects are.

    Computed from a coarse solution of the laterally unbounded specimen; nothing is written.

    \b
    jkr check cases/thin-layer.toml
    jkr check my.toml -v                    all neglected effects, all methods
    """
    loaded = load_case(case)
    if words := long_look(loaded.model.problem()):
        note(words)
    works = loaded.model.adhesion.w
    announce(f"check for {len(works):,} works of adhesion", seconds_of_works(works))
    give(Check.of(case, loaded), as_json)
