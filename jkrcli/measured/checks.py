"""Warnings about a fit: what a reader should know, each sentence with its numbers and what to do."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

import numpy as np

from ..adhesion.validity import REMEDY, judge
from ..base.errors import Unknown
from ..base.numerics import SAME
from ..base.units import show
from ..series import Record
from .forward_model import Family, FittedBody
from .parameters import POSITIONS, implausible_work, word
from .range_alternative import TableAlternatives, missed_pull_off
from .result import Fit
from .settings import RANGES

# Limits beyond which a reader is warned; nothing else depends on them.
CHECKS_SCATTER = 2.0  # choice: factor from the user's noise to the residuals, either way
CHECKS_SUSPICIOUS = 1e-4  # choice: chance of order in residuals
CHECKS_FAR = 30.0  # choice: factor of the case's moduli that makes wrong units likelier than the case


def warnings_of(
    fit: Fit, body: FittedBody, family: Family, at_bound: Sequence[str] = (),
    alternatives: TableAlternatives | None = None, ended: bool = True,
) -> list[str]:  # fmt: skip
    """Sentences on all that stands against the fit or limits it; ``body`` and its ``family`` with the fitted values,
    ``at_bound``: parameters that end on a bound; ``alternatives``: the nearest other models; ``ended``: the search."""
    return [
        *_of_search(fit, at_bound, ended), *_of_model(fit, alternatives),
        *_of_values(fit, body, at_bound, alternatives), *_of_validity(fit, body, family),
    ]  # fmt: skip


def _of_search(fit: Fit, at_bound: Sequence[str], ended: bool) -> Iterator[str]:
    """Warnings of a search that did not end, or whose parameters are undetermined or strongly correlated."""
    if not ended:
        names = ", ".join(word(name) for name in fit.free)
        yield (
            f"the search stopped after {fit.evaluations} steps, the data do not determine {names}: give starting "
            "values (--start), or fix one of them (--fix)"
        )
        return
    if fit.covariance is None:
        if len(fit.free) > 1 and not at_bound:
            yield f"the data do not determine {', '.join(fit.free)} together: fix one of them (--fix)"
        return
    for one, two, sentence in fit.hardly_apart:
        pair = {one, two}
        if pair <= {"modulus", "w", *RANGES} or pair <= set(POSITIONS) or any(":" in name for name in pair):
            profile = "; --confidence profile follows how unevenly they trade, in ten times the time"
            more = profile if pair & set(RANGES) else ""
            yield f"{sentence}: fix one, or measure up to pull-off and to larger loads{more}"
    for item in map(fit.estimate, fit.free):
        if item.name in RANGES and item.error is None:
            continue  # ``_of_model`` has it
        if item.low == 0 and item.high is not None:
            yield f"{word(item.name)} is not significantly above 0: it is at most {show(item.high, item.dimension)}"
        elif item.dimension in ("work", "modulus") or item.name in ("modulus", "range"):
            yield from fit.vague([item.name])


def _of_model(fit: Fit, alternatives: TableAlternatives | None) -> Iterator[str]:
    """What the residuals say of the model: JKR beside a range, structure, alternatives, a scatter unlike the noise."""
    jkr, law = fit.jkr, fit.settings.range
    if isinstance(jkr, Unknown):
        yield f"no JKR curve resembles the data: {jkr}"
    elif jkr is not None and law is not None:
        ratio = jkr.rms / jkr.rms_of_range
        misfit = (
            f"the best JKR curve, E* = {show(jkr.E_star, 'modulus')} and w = {show(jkr.w, 'work')}, leaves {ratio:.4g} "
            f"times the residuals{'' if round(ratio, 3) >= 1 else ': this fit has not converged'}"
        )
        if law.free and fit.estimate(law.name).error is None:
            item = fit.estimate("range")
            most = "" if item.high is None else f" (it is at most {show(item.high, 'length')})"
            misfit = f"a range is not significant{most}: {misfit}"
        yield misfit

    structured = fit.sizes is None and fit.structure.probability < CHECKS_SUSPICIOUS
    if structured or alternatives is not None:
        # Residuals larger than errors of the series' interpolation, in units of the curve's own size
        size = min(np.ptp(fit.line[name]) / scale for name, scale in fit.scales.items())
        resolved, order = float(np.sqrt(np.mean(fit.residuals**2)) / size) > SAME, fit.structure
        if structured and resolved:
            yield (
                f"the residuals are structured (lag-1 autocorrelation {order.lag1:.2f}, {order.runs} runs where "
                f"{order.expected:.0f} are expected): check body, indenter and rows; intervals are too narrow"
            )
        if alternatives is not None and resolved:
            yield from alternatives.warnings()
    if fit.settings.noise and not 1 / CHECKS_SCATTER <= fit.scatter <= CHECKS_SCATTER:
        more = "more" if fit.scatter > 1 else "less"
        yield f"the data scatter {fit.scatter:.2g} times as much as the given noise, {more} than it explains"


def _of_values(
    fit: Fit, body: FittedBody, at_bound: Sequence[str], alternatives: TableAlternatives | None
) -> Iterator[str]:
    """What is odd about the values, and what of the data would have to tell them."""
    factor = fit.value("modulus")
    if body.moduli_known and "modulus" in fit.free and not 1 / CHECKS_FAR <= factor <= CHECKS_FAR:
        yield f"the moduli are {factor:.3g} times those of the case: check the units of the data and of the case"
    significant = "w" in fit.free and fit.estimate("w").low != 0  # above 0
    if significant and (doubt := implausible_work(fit.value("w"), fit.value("E_star"))):
        yield doubt
    for item in map(fit.estimate, at_bound):
        has_its_own = item.name in RANGES and item.error is None
        if (item.low != 0 or item.value > 0) and not has_its_own:
            yield f"{word(item.name)} ends on its bound {show(item.value, item.dimension)}"
    missed = missed_pull_off(fit.a, fit.line) if "P" in fit.scales and _adhesion(fit) else None
    if missed is not None:
        untested = alternatives.sensitivity if alternatives else ""
        yield (
            f"no pull-off in the data: they end at a = {show(missed[0], 'length')}, contact is lost at "
            f"{show(missed[1], 'length')}; w comes from the shape of the curve alone"
            + (f"; not tested, and not in the errors: {untested}" if untested else "")
        )
    problem = body.problem
    if fit.settings.known("modulus").free and problem.indenter.material is not None and problem.layers:
        yield "the indenter is elastic: its modulus was scaled together with those of the layers"


def _of_validity(fit: Fit, body: FittedBody, family: Family) -> list[str]:
    """Sentences on a/R, delta/h and the Tabor number at the largest radius of the data."""
    specimen, indenter, a = body.problem.specimen, body.problem.indenter, float(np.max(fit.a))
    free = (item.value for item in fit.estimates if item.name.startswith("h:") and item.free)
    h, depth = next(free, specimen.top_thickness), specimen.yielding_depth
    depth = h if depth == specimen.top_thickness else depth
    delta = float(family.at(np.log([a]))[0][0, 0]) if math.isfinite(depth) else 0.0  # over the depth alone
    judged = judge(
        a=a, delta=delta, E_star=fit.value("E_star"), w=fit.work.value if _adhesion(fit) else 0.0,
        R=indenter.tip_radius, h=h, depth=depth, L=specimen.radius, end_is_cut=False,
        z0=Record.z0 if fit.jkr is None else None, tension=specimen.surface_tension, profile=indenter.noun,
    )  # fmt: skip
    return [line.replace(REMEDY, "fit with --free range (or stress)") for line in judged.warnings]


def _adhesion(fit: Fit) -> bool:
    """Whether w is significantly above 0."""
    item = fit.work
    return item.value > 0 and item.low != 0
