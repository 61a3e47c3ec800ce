"""``jkr fit`` of laws over time: of w over the speed of the edge, of relaxation."""

from __future__ import annotations

import itertools
from typing import Any

from ..base.errors import InputError, SolveError, counted
from ..base.process import one_thread
from ..cli.printing import announce, warn
from ..measured.files import usable
from ..measured.fits import FitRequest, mended
from ..tables.text import some
from .law_fits import RelaxationFits
from .rate_fit import rate_fit, rate_settings
from .relaxation_fit import relaxation_fit
from .shared_speeds import shared_speeds_fit
from .timed_record import RelaxationFit, relaxation_settings

SECONDS, POWER_SECONDS = (3.0, 1.2), (8.0, 4.0)  # choice: of the first force curve and of each next one that is alike


def fit_law(request: FitRequest) -> None:
    """w0, the law's parameters, E* and zeros from records at one or several speeds."""
    asked = request.options
    how = {"level": asked.level, "segment": asked.segment, "confidence": asked.confidence}
    assert asked.law is not None
    settings = rate_settings(request.body, asked.law, request.names, asked.fix, asked.start, **how)
    curves, _ = request.curves(request.measured)
    request.conclude(lambda: rate_fit(request.body, curves, settings, announce))


def fit_relaxation(request: FitRequest) -> None:
    """The modulus, a law of relaxation and zeros from records over time, each for itself, or together where they share
    a law of w over speed or what is named; curves that cannot be used are skipped and said."""
    body, asked = request.body, request.options
    terms = {} if asked.terms is None else {"terms": asked.terms}
    shared, own = (list(itertools.chain(*groups)) for groups in (asked.shared, asked.own))
    how: dict[str, Any] = {"level": asked.level, "confidence": asked.confidence, "segment": asked.segment} | terms
    how |= {"rate": asked.law, "shared": shared, "own": own}
    assert asked.relaxation is not None
    settings = relaxation_settings(
        asked.relaxation, asked.fix, request.names, body.problem.E_star, body.range_of_case, **how
    )
    if asked.law or asked.shared:
        together, _ = request.curves(request.measured)
        request.conclude(lambda: shared_speeds_fit(body, together, settings, announce))
        return
    curves, skipped = usable(request.measured, request.reading)
    done: list[RelaxationFit] = []
    first, later = (POWER_SECONDS if settings.law == "power" else SECONDS) if settings.adheres else (0.0, 0.0)
    with mended(f"fits of {counted(len(curves), 'curve')}", len(curves), first + later * (len(curves) - 1)) as step:
        for curve in curves:
            before = len(done)
            try:
                with one_thread():
                    done.append(relaxation_fit(body, curve, settings, done[-1] if done else None))
            except InputError as error:
                skipped += error.lines
            except SolveError as error:  # of one of many it does not cost the others
                if len(curves) == 1:
                    raise
                skipped.append(str(error))
            step(len(done) == before)
    if not done:
        raise InputError(some(skipped))
    for line in skipped:
        warn(f"skipped: {line}")
    request.write(RelaxationFits(done, request.body_words))
