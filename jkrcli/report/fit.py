"""Fits as a table, as a summary, and in words."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass
from functools import cached_property
from typing import Any

import numpy as np
from scipy.special import ndtri

from ..base import SI, scale, show
from ..identification.fit import Failure, Fit, FittedValue, JKRBeside, record_rivals, record_scores, rivals
from . import archive
from .result import SHOWN, Figure, Result, Several
from .tables import DIMENSIONS, by_columns, quantities, with_unit

ALWAYS = ("file", "curve", "status", "reason", "points")
SYMBOLS = {"E_star": "E*", "modulus": "moduli over the case's"}
ZERO_POINTS = ("delta0", "P0", "tilt")  # told last
FITTED, DOUBTFUL, UNUSABLE = "fitted", "doubtful", "unusable"
VAGUE = "not determined"  # how flags end of what rivals may change by much
NOTICEABLE = 0.01  # of an error, theory: it is shown to two digits, and a smaller part lies below the second


@dataclass(frozen=True, eq=False)
class Fits(Several):
    """Curves that were fitted or could not be; ``body``: what they were taken to be of, in words; ``remarks`` on all of
    them together."""

    outcomes: Sequence[Fit | Failure]
    body: str
    remarks: Sequence[str] = ()

    @property
    def columns(self) -> dict[str, list[Any]]:  # type: ignore[override]
        return columns(self.outcomes)

    @cached_property
    def fits(self) -> list[Fit]:
        return [item for item in self.outcomes if isinstance(item, Fit)]

    def summary(self) -> dict[str, Any]:
        return summary(self.outcomes, self.body)

    @property
    def parts(self) -> list[list[str]]:
        if len(self.fits) == 1:
            return [words(self.fits[0])]
        each = [[f"{item.where}: {verdict}", *rest] for item in self.fits[:SHOWN]
                for verdict, *rest in [words(item, once=True)]]  # fmt: skip
        return [[self._together()], *each] if len(self.fits) > 2 and len(_surfaces(self.fits)) == 1 else each

    def _together(self) -> str:
        """How many curves were fitted, and the median and the ends of E* and w over them."""
        doubtful = sum(_status(item) == DOUBTFUL for item in self.fits)
        parts = []
        for name in ("E_star", "w"):
            estimates = [one for item in self.fits for one in item.estimates if one.name == name]
            if not estimates:
                continue
            sizes, dimension = [one.value for one in estimates], estimates[0].dimension
            middle, low, high = (show(float(size), dimension, 4) for size in np.percentile(sizes, (50, 0, 100)))
            parts.append(f"{SYMBOLS.get(name, name)} = {middle} (median; {low} to {high})")
        return f"{', '.join(parts)}: {len(self.fits):,} of {len(self.outcomes):,} curves fitted, {doubtful:,} doubtful"

    @property
    def warnings(self) -> list[str]:
        both = len(_surfaces(self.fits)) > 1
        named = [(f"{item.where}{f', {item.surface}' if both else ''}", item.warnings) for item in self.fits[:SHOWN]]
        return [*(f"{where}: {line}" for where, lines in named for line in lines), *self.remarks]


@dataclass(frozen=True, eq=False)
class Fitted(Fit, Result):
    """A fitted curve as a result; ``body``: what was fitted, in words."""

    body: str = ""

    @property
    def columns(self) -> dict[str, list[Any]]:  # type: ignore[override]
        return columns([self])

    def summary(self) -> dict[str, Any]:
        return summary([self], self.body)

    def words(self) -> list[str]:
        return words(self)

    def figure(self) -> Figure:
        from .plots.fit import fit_figure

        return fit_figure(self)


def _surfaces(fits: Sequence[Fit]) -> set[str]:
    return {item.surface for item in fits}


def columns(outcomes: Sequence[Fit | Failure]) -> dict[str, list[Any]]:
    """The table of all curves, a row for each in their order, by columns; None where there is no value."""
    return by_columns([_row(item) for item in outcomes])


def _row(item: Fit | Failure) -> dict[str, Any]:
    if isinstance(item, Failure):
        cells = (str(item.curve.origin or ""), item.curve.name, UNUSABLE, " ".join(item.lines), None)
        more = {"quality": 0.0, "flags": "; ".join(item.flags)}
        return dict(zip(ALWAYS, cells, strict=True)) | _placed(item) | more
    row: dict[str, Any] = dict(zip(ALWAYS, (item.file, item.name, _status(item), "", item.a.size), strict=True))
    row |= _placed(item) | {"surface": item.surface}
    for estimate in item.estimates:
        parts: dict[str, float | None] = {"": estimate.value}
        if estimate.free:
            parts |= {"err": estimate.error, "low": estimate.low, "high": estimate.high}
        if estimate.model:
            parts["model"] = math.hypot(*estimate.model.values())
        row |= {_title(estimate.name, part, estimate.dimension): value for part, value in parts.items()}
    row |= {"scatter": item.scatter, "lag1": item.structure.lag1}
    row |= {"correlation_modulus_w": item.correlated("modulus", "w")}
    if item.quality is not None:
        row |= {"adhesion_force_N": item.adhesion, "quality": item.quality["quality"], "flags": "; ".join(item.flags)}
    return row | {"warnings": "; ".join(item.warnings)}


def _placed(item: Fit | Failure) -> dict[str, Any]:
    """Column, row and position of a curve of a map; nothing of others."""
    at = item.pixel
    return {} if at is None else {"map_column": at.column, "map_row": at.row, "x_m": at.x, "y_m": at.y}


def _title(name: str, part: str, dimension: str) -> str:
    """The title of a column: ``E_film_err_Pa``."""
    stem = "modulus_factor" if name == "modulus" else name.replace(":", "_").replace(" ", "_")
    title = "_".join(filter(None, [stem, part]))
    return f"{title}_m_per_N" if name == "compliance" else with_unit(title, dimension)


def summary(outcomes: Sequence[Fit | Failure], body: str) -> dict[str, Any]:
    """What stands in the JSON file: per curve everything but the rows themselves."""
    return identity(archive.FITS, body) | {"curves": [_summary(item) for item in outcomes]}


def identity(format: str, body: str) -> dict[str, Any]:
    """How the summary of a fit to a ``body`` in words begins."""
    return {"format": format, "version": 1, "body": body}


def _summary(item: Fit | Failure) -> dict[str, Any]:
    if isinstance(item, Failure):
        return {
            "file": str(item.curve.origin or ""), "curve": item.curve.name, "status": UNUSABLE,
            "reason": list(item.lines), "quality": {"quality": 0.0}, "flags": list(item.flags),
        }  # fmt: skip
    structure = item.structure
    return {
        "file": item.file,
        "curve": item.name,
        "surface": item.surface,
        "status": _status(item),
        "estimates": {estimate.name: estimate_summary(estimate) for estimate in item.estimates},
        **{name: getattr(item.settings, name) for name in ("level", "confidence", "loss")},
        "free": list(item.free),
        "covariance": None if item.covariance is None else item.covariance.tolist(),
        "correlation": None if item.correlation is None else item.correlation.tolist(),
        "points": item.a.size,
        "left_out": list(item.left_out),
        "a_m": [float(item.a.min()), float(item.a.max())],
        "scales": dict(item.scales),
        "scatter": item.scatter,
        "degrees_of_freedom": item.dof,
        "residuals": {
            "lag1_autocorrelation": structure.lag1,
            "runs": structure.runs,
            "runs_expected": structure.expected,
            "probability": structure.probability,
        },
        **({} if item.range_left is None else {"range_left_m": item.range_left}),
        **_beside(item),
        **_verdict(item),
        **({"plan": [asdict(one) for one in item.plan]} if item.plan else {}),
        **({} if item.quality is None else {"quality": dict(item.quality), "flags": list(item.flags)}),
        "warnings": list(item.warnings),
    }


def _beside(item: Fit) -> dict[str, Any]:
    """JKR beside a fit with a range, by what its misfit is larger."""
    jkr = item.jkr
    if not isinstance(jkr, JKRBeside):
        return {} if jkr is None else {"jkr": {"reason": str(jkr)}}
    return {"jkr": quantities(jkr, "E_star w") | {"misfit": jkr.rms / jkr.rms_of_range}}


def _status(item: Fit) -> str:
    return DOUBTFUL if item.flags else FITTED


def estimate_summary(item: FittedValue) -> dict[str, Any]:
    unit = "m/N" if item.name == "compliance" else SI[item.dimension]
    numbers: dict[str, Any] = {"value": item.value, "unit": unit, "free": item.free}
    if item.free:
        numbers |= {"standard_error": item.error, "low": item.low, "high": item.high}
    if item.systematic:
        numbers["systematic"] = dict(item.systematic)
    if item.model:
        numbers["model"] = dict(item.model)
    return numbers


def words(item: Fit, once: bool = False) -> list[str]:
    """A fit as lines of text: the verdict (``once``: as ``brief``), what was free, and what follows from it."""
    out = f" ({', '.join(item.left_out)} left out)" if item.left_out else ""
    status = f"{_status(item)}, " if item.quality is not None or item.flags else ""
    ways = f", {item.directions}" if item.directions else ""
    stuck = ", no slip" if item.surface == "sticking" else ""
    lines = [*verdict_words(item, once), *_range_words(item)]
    lines += [f"  {item.where}: {status}{item.a.size} rows of {', '.join(item.data)}{ways}{out}{stuck}"]
    lines += [f"  {'tip':<12} {item.tip}"] * bool(item.tip)
    lines += estimate_lines(sorted(item.estimates, key=lambda one: one.name in ZERO_POINTS), item.settings.level)
    correlation = item.correlated("modulus", "w")
    more = [] if correlation is None else [f"correlation of E* and w {correlation:.2f}"]
    lines.append(f"  {'scatter':<12} {', '.join([*_scatter(item), *more])}")
    if item.quality is not None:
        parts = ", ".join(f"{name} {value:.2f}" for name, value in item.quality.items() if name != "quality")
        lines.append(f"  {'quality':<12} {item.quality['quality']:.2f} ({parts})")
    return lines


def verdict_words(item: Fit, once: bool = False) -> list[str]:
    """E* and w with the parts of their errors; of raw records also whether the model is rejected, what a formula would
    give, and which rivals the parts by the model are from."""
    shown, formula = [item.estimate("E_star"), item.work], list[str]()
    doubts = [flag for flag in item.flags if not flag.endswith(VAGUE)]
    verdict = brief(shown, item.settings.level, once)
    verdict += f"; doubtful: {', '.join(doubts)}" if doubts else ""
    if item.verdict is None:
        return [verdict]
    if item.verdict.E_star is not None:
        by = item.verdict.E_star
        change = by / item.value("E_star") - 1
        formula = [f"{item.verdict.formula} at the deepest row would give {show(by, 'modulus', 3)} ({change:+.0%})"]
    others = item.verdict.rivals
    rejected = f"; rejected for {' or '.join(others.families)}" if others.named else ""
    judged = [] if others.named else ["the data ask for no other model"]
    if tied := item.verdict.tied:
        rejected = f"; by {tied[0].name} ({parameter_words(tied[0])})"
        judged = ["JKR as described is rejected", *(f"{one.name} cannot be told from it" for one in tied[1:])]
    judged += [flag for flag in item.flags if flag.endswith(VAGUE)]
    parts = dict.fromkeys(name for one in shown for name in one.model or {})
    judged += [f"(model) is what the data leave of {', '.join(parts)}"] if parts else []
    return [verdict + rejected, *(f"  {'; '.join(lines)}" for lines in (formula, judged) if lines)]


def brief(items: Sequence[FittedValue], level: float, once: bool = False) -> str:
    """Values with their statistical part, that of inputs, and that of the model, all half-widths at one ``level``;
    ``once``: the kinds of several parts behind all values, where all have the same."""
    parts = [_parts(item, level) for item in items]
    kinds = list(parts[0]) if once and len(parts[0]) > 1 and len(set(map(tuple, parts))) == 1 else []
    shown = ([f"± {size}" + f" ({kind})" * (not kinds) for kind, size in each.items()] for each in parts)
    values = ", ".join(" ".join([_value(item), *errors]) for item, errors in zip(items, shown, strict=True))
    values += f" ({', '.join(kinds)})" * bool(kinds)
    return values + f", at {100 * level:g} %" * any(item.error is not None for item in items)


def _value(item: FittedValue) -> str:
    none = item.error is None or item.low is item.high is None  # an error beyond any interval tells nothing
    why = "" if not none else " (not determined by the data)" if item.free else " (held)"
    return f"{SYMBOLS.get(item.name, item.name)} = {show(item.value, item.dimension, 4)}{why}"


def _parts(item: FittedValue, level: float) -> dict[str, str]:
    """The parts of the error by their kinds, in the unit of the value, those that are noticeable."""
    if item.error is None or item.low is item.high is None:
        return {}
    half = item.error * float(ndtri((1 + level) / 2))
    if item.low is not None and item.high is not None:
        half = (item.high - item.low) / 2
    calibration = half * min(math.hypot(*(item.systematic or {}).values()) / (item.error or 1.0), 1.0)
    own = math.sqrt(half**2 - calibration**2)
    parts = {"statistical": own, "calibration": calibration, "model": math.hypot(*(item.model or {}).values())}
    unit, _ = scale(item.value, item.dimension)
    return {kind: f"{float(f'{size / unit:.2g}'):g}" for kind, size in parts.items() if size > NOTICEABLE * own}


def parameter_words(one: record_scores.FittedRival) -> str:
    """What else a rival in full tells, in words."""
    values = (f"{name} {show(value, record_rivals.OF_RIVALS[name], 3)}" for name, value in one.quantities.items())
    return ", ".join([*values, f"chi^2 {-one.falls:.3g}"])


def rivals_table(item: Fit) -> list[str]:
    """A line per rival of a raw record: what the data say, how much of it they ask for, and how E* and w would move."""
    if item.verdict is None:
        return []
    head = f"  {'rival':<44}{'the data':<23}{'p':>9}{'E*':>8}{'w':>8}{'chi^2':>10}"
    return [head, *(
        f"  {one.name:<44}{one.word:<23}{one.chance:>9.1g}{one.change(one.E_star):>+8.1%}{one.change(one.w):>+8.1%}"
        f"{-one.taken:>10.3g}" for one in item.verdict.rivals.scores
    ), *(
        f"  in full: {one.name}: {'taken' if one.taken else f'not taken, p = {one.chance:.1g}'}, "
        f"E* {show(one.E_star, 'modulus', 4)}, w {show(one.w, 'work', 4)}, {parameter_words(one)}"
        for one in item.verdict.fitted
    )]  # fmt: skip


def plan_table(item: Fit) -> list[str]:
    """What further measurements would tell, the best for E* and for w marked."""
    best = [min((getattr(one, name) for one in item.plan), default=0.0) for name in ("E_star", "w")]
    head = [f"  {'a further measurement':<32}{'E* within':>12}{'w within':>12}"] * bool(item.plan)
    return head + [
        f"  {one.words:<32}"
        + "".join(f"{value:>11.2%}{'*' if value == least else ' '}"
                  for value, least in zip((one.E_star, one.w), best, strict=True))
        for one in item.plan
    ]  # fmt: skip


def _verdict(item: Fit) -> dict[str, Any]:
    """Rivals of a raw record, each with its score, and what a formula makes of the deepest row."""
    if item.verdict is None:
        return {}
    verdict = item.verdict
    return {"verdict": {
        "model": verdict.tied[0].name if verdict.tied else "jkr",
        "named": [one.name for one in verdict.rivals.named], "families": list(verdict.families),
        "in_full": [_tried_summary(one) for one in verdict.fitted],
        "misfit": verdict.rivals.misfit / verdict.rivals.dof, "free_rows_tell_the_noise": verdict.rivals.loose > 0,
        "formula": {"name": verdict.formula, "E_star_Pa": verdict.E_star} if verdict.E_star is not None else None,
        "rivals": [_score_summary(one) for one in verdict.rivals.scores],
    }}  # fmt: skip


def _tried_summary(one: record_scores.FittedRival) -> dict[str, Any]:
    """A rival in full: how much of the misfit it takes, what it makes of E* and w, and what else it tells."""
    parameters = {with_unit(name, record_rivals.OF_RIVALS[name]): value for name, value in one.quantities.items()}
    return {
        "name": one.name, "family": one.family, "taken": one.taken, "chi2_falls": one.falls, "p": one.chance,
        **quantities(one, "E_star w"), **parameters,
    }  # fmt: skip


def _score_summary(one: record_scores.Score) -> dict[str, Any]:
    """A rival: its amount, what the data say, and the relative moves of E* and w with what was found of it."""
    error = one.error if math.isfinite(one.error) else None
    return {
        "name": one.name, "family": one.family, "word": one.word, "amount_is": one.amount_is, "amount": one.amount,
        "standard_error": error, "p": one.chance, "share_of_misfit": one.share,
        "E_star_moves": one.change(one.E_star), "w_moves": one.change(one.w),
        "E_star_may_move": one.moved(one.E_star), "w_may_move": one.moved(one.w),
    }  # fmt: skip


def _range_words(item: Fit) -> list[str]:
    """A line on the longest range that the rows leave, where w rests on it more than on the noise."""
    w, left = item.work, item.range_left
    part = (w.model or {}).get(rivals.RANGE, 0.0)
    if left is None or w.low is None or w.high is None or part < w.high - w.low:
        return []
    moved = f"the data allow up to {show(left, 'length', 2)}, which would change w by {show(part, 'work', 2)}"
    return [f"  {'range':<12} {moved}; if it is known to be shorter: --bound range=..LENGTH"]


def estimate_lines(items: Iterable[FittedValue], level: float, names: Mapping[str, str] = SYMBOLS) -> list[str]:
    """A line for each free parameter but the factor of all moduli, by its name or that in ``names``."""
    shown = (item for item in items if item.free and item.name != "modulus")
    return [f"  {names.get(item.name, item.name):<12} {estimate_words(item, level)}" for item in shown]


def estimate_words(estimate: FittedValue, level: float) -> str:
    dimension = estimate.dimension
    text = f"{show(estimate.value, dimension, 5):<14}"
    if estimate.error is None:
        text += " (not determined by the data)"
        if estimate.low is None and estimate.high is None:
            return text
    else:
        text += f" ± {show(estimate.error, dimension, 2):<12}"
    ends = [None if end is None else show(end, dimension, 5) for end in (estimate.low, estimate.high)]
    text += f" {level:.0%}: {ends[0] or 'no lower limit'} to {ends[1] or 'no upper limit'}"
    named = (estimate.systematic or {}).items()
    least = NOTICEABLE * (estimate.error or 0.0)
    parts = [f"{name} {show(value, dimension, 2)}" for name, value in named if value > least]
    text += f" (of which {', '.join(parts)})" if parts else ""
    if estimate.model:
        text += f"; systematic (model) ± {show(math.hypot(*estimate.model.values()), dimension, 2)}"
    return text


def _scatter(item: Fit) -> list[str]:
    """Standard deviation of the readings as the residuals have it."""
    return [f"{show(item.scatter * scale, DIMENSIONS[name], 2)} in {name}" for name, scale in item.scales.items()]
