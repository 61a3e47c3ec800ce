"""``jkr fit --relaxation``: the modulus, a law of relaxation and zeros from records over time, each for itself."""

from __future__ import annotations

from ..base import InputError
from .fit_together import FitRequest
from .output import give
from .voice import warn


def fit_relaxation(request: FitRequest) -> None:
    """A fit of each curve in all files, their table, summary and picture; curves that cannot be used are skipped and
    said."""
    from ..base import one_thread
    from ..data import each, some
    from ..identification.relaxation import relaxation_fit, relaxation_settings
    from ..report import RelaxationFits

    body, options, targets = request.body, request.options, request.targets
    terms = {} if options["terms"] is None else {"terms": options["terms"]}
    E_star = body.problem.E_star
    how = {name: options[name] for name in ("level", "confidence")}
    settings = relaxation_settings(options["relaxation"], options["fix"], request.names, E_star, **how, **terms)
    fits, skipped = [], list[str]()
    for path in request.measured:
        for item in each(path, request.reading):
            try:
                if isinstance(item, InputError):
                    raise item
                curve = item if options["segment"] in (None, "both") else item.only(options["segment"])
                with one_thread():
                    fits.append(relaxation_fit(body, curve, settings))
            except InputError as error:
                skipped += error.lines
    if not fits:
        raise InputError(some(skipped))
    result = RelaxationFits(fits, request.body_words)
    targets.write(result.columns, result.summary(), targets.draw(result.figure))
    for line in skipped:
        warn(f"skipped: {line}")
    give(result, request.output.json, f"  written {targets}")
