"""``jkr fit --relaxation``: the modulus, a law of relaxation and zeros from records over time, each for itself."""

from __future__ import annotations

from ..base import InputError
from .fit_together import Asked
from .output import give
from .voice import warn


def fit_relaxation(asked: Asked) -> None:
    """A fit of each curve in all files, their table, summary and picture; curves that cannot be used are skipped and
    said."""
    from ..base import one_thread
    from ..data import each, some
    from ..identification.relaxation import relaxation_fit, relaxation_settings
    from ..report import RelaxationFits

    body, options, targets = asked.body, asked.options, asked.targets
    terms = {} if options["terms"] is None else {"terms": options["terms"]}
    E_star = body.problem.E_star
    told = {name: options[name] for name in ("level", "confidence")}
    settings = relaxation_settings(options["relaxation"], options["fix"], asked.names, E_star, **told, **terms)
    found, skipped = [], list[str]()
    for path in asked.measured:
        for item in each(path, asked.reading):
            try:
                if isinstance(item, InputError):
                    raise item
                curve = item if options["segment"] in (None, "both") else item.only(options["segment"])
                with one_thread():
                    found.append(relaxation_fit(body, curve, settings))
            except InputError as error:
                skipped += error.lines
    if not found:
        raise InputError(some(skipped))
    result = RelaxationFits(found, asked.told)
    targets.write(result.columns, result.summary(), targets.draw(result.figure))
    for line in skipped:
        warn(f"skipped: {line}")
    give(result, asked.output.json, f"  written {targets}")
