"""Results of measured curves as tables, summaries, words and figures: fits, work along a curve, what a file holds."""

from __future__ import annotations

import math
import re
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from ..adhesion.curve import Nonadhesive
from ..base.errors import AT_LEVEL, LEVEL, InputError, Unknown, counted
from ..base.numerics import HALF_WIDTH, Array
from ..base.registry import FIGURES, SUMMARIES, TABLES, WORDS, Result
from ..base.units import SI, deviation, scale, show
from ..base.wings import offered
from ..bodies.indenters import Indenter
from ..report import archive
from ..report.result import SHOWN, Figure, Several
from ..report.tables import DIMENSIONS, quantities, stacked, transpose_rows, with_unit
from ..resolve.analysis import Analysis, adhesive
from ..resolve.reach import Rough, rough
from ..series import Solution
from ..tables.text import some
from . import files as measured
from . import range_alternative, text_formats
from .archive import DOUBTFUL, FITTED, LEAST_CURVES, UNUSABLE, reason_of, status_of
from .batch import read_batch
from .curve import ARBITRARY, NOT_SUBTRACTED, Curve
from .grade import GOOD, GRADES, LEFT_OUT, LOOK, UNEXPLAINED, UNFIT, change_words, kind_of, size_words
from .joint import JointFit
from .model_changes import OF_ALTERNATIVES
from .parameters import FittedValue, show_within
from .procedure import Failure
from .result import Fit, JKRBeside
from .rigid import Sensitivity, mean, sensitivity_of
from .score_tests import FittedAlternative
from .segmentation import Direction, ForceCurve, saturation, saturation_words, segment_force_curves
from .surface_tension import TensionFit
from .work import ABOVE, BELOW, NONE, OK, PINNED, WorkAlong, typical

ALWAYS = ("file", "curve", "status", "reason", "points")
SYMBOLS = {"E_star": "E*", "modulus": "moduli over the case's"}
NUMBER = re.compile(r"[-+]?\d[\d.,e+-]*")  # in a line of text
ZERO_POINTS = ("delta0", "P0", "tilt")  # told last
REASONS_SHOWN, LONGEST_REASON = 6, 60  # choice: of a line; letters of one
LOPSIDED = 0.05  # choice: of an interval, by which its middle may miss the value before its ends are printed
VAGUE = "not determined"  # how flags end of what alternatives may change by much
OWN_OF_A_CURVE = (LEFT_OUT, UNEXPLAINED)  # parts of the model's error whose sign nobody knows
NOTICEABLE = 0.01  # of an error, theory: it is shown to two digits, and a smaller part lies below the second


@dataclass(frozen=True, eq=False)
class Fits(Several):
    """Curves that were fitted or could not be; ``body``: what they were taken to be of, in words; ``remarks`` on all of
    them together; ``sample`` of each curve, where there are samples; ``own``: inputs of which
    each has one of its own, as its tip."""

    outcomes: Sequence[Fit | Failure]
    body: str
    remarks: Sequence[str] = ()
    sample: Sequence[str] = ()
    own: Sequence[str] = ()

    @property
    def columns(self) -> dict[str, list[Any]]:  # type: ignore[override]
        table = columns(self.outcomes)
        if not self.sample:
            return table
        return {name: table[name] for name in ALWAYS} | {"sample": [*self.sample]} | table

    @cached_property
    def samples(self) -> Any:
        """What is said of samples (``many/samples.py``); None where there are none."""
        summed_up = offered("samples of a fit") if self.sample else None
        kinds = {"kind": [kind_of(reason_of(item)) for item in self.outcomes]}
        parts = [_causes(item) for item in self.outcomes]
        return summed_up and summed_up({**self.columns, **kinds}, parts, {*self.own, *OWN_OF_A_CURVE})

    @property
    def fits(self) -> list[Fit]:
        return [item for item in self.outcomes if isinstance(item, Fit)]

    def summary(self) -> dict[str, Any]:
        whole = summary(self.outcomes, self.body)
        for curve, name in zip(whole["curves"], self.sample, strict=False):
            curve["sample"] = name
        return whole | ({"samples": self.samples.summary()} if self.samples else {})

    @property
    def parts(self) -> list[list[str]]:
        if self.samples:
            return [self.samples.words()]
        if len(self.fits) == 1:
            return [fit_words(self.fits[0])]
        each = [[f"{item.where}: {verdict}", *rest] for item in self.fits[:SHOWN]
                for verdict, *rest in [fit_words(item)]]  # fmt: skip
        if len(self.outcomes) < LEAST_CURVES or len({item.surface for item in self.fits}) != 1:
            return each
        # The median and the ends of E* and w over all curves, how many were fitted, and of the others why not
        parts = []
        for name in ("E_star", "w"):
            estimates = [one for item in self.fits for one in item.estimates if one.name == name]
            if not estimates:
                continue
            sizes, dimension = [one.value for one in estimates], estimates[0].dimension
            middle, low, high = (show(float(size), dimension, 4) for size in np.percentile(sizes, (50, 0, 100)))
            parts.append(f"{SYMBOLS.get(name, name)} = {middle} (median; least {low}, largest {high})")
        why = {word: Counter(kind_of(reason_of(item))[:LONGEST_REASON] for item in self.outcomes
                             if status_of(item) == word) for word in (DOUBTFUL, UNUSABLE)}  # fmt: skip
        counts = [f"{len(self.fits):,} of {counted(len(self.outcomes), 'curve')} fitted"]
        counts += [f"{reasons.total():,} {word}{_counted(reasons)}" for word, reasons in why.items()
                   if reasons or word == DOUBTFUL]  # fmt: skip
        return [[f"{', '.join(parts)}: {', '.join(counts)}"], *each]

    @property
    def warnings(self) -> list[str]:
        both = len({item.surface for item in self.fits}) > 1
        alike: dict[str, list[str]] = {}  # by what is left without the numbers, in a map; else each for itself
        for item in self.fits:
            where = f"{item.where}{f', {item.surface}' if both else ''}"
            for line in item.warnings:
                kind = NUMBER.sub("", line) if len(self.fits) >= LEAST_CURVES else f"{where}: {line}"
                alike.setdefault(kind, []).append(f"{where}: {line}")
        each = [lines[0] + f" ({counted(len(lines) - 1, 'more curve')} with this warning)" * (len(lines) > 1)
                for lines in alike.values()]  # fmt: skip
        return [*each, *self.remarks]


@TABLES.register(Fit)
def fit_table(fit: Fit) -> dict[str, list[Any]]:
    """The row of one curve, by columns."""
    return columns([fit])


@SUMMARIES.register(Fit)
def fit_summary(fit: Fit) -> dict[str, Any]:
    """What stands in the JSON file of one curve."""
    return summary([fit], fit.body)


@FIGURES.register(Fit)
def draw_fit(fit: Fit) -> Figure:
    """The picture of a fitted curve."""
    from .figures import fit_figure

    return fit_figure(fit)


def _counted(reasons: Counter[str]) -> str:
    """How many curves have each of the reasons, the most frequent first."""
    shown = [f"{count:,} {reason}" for reason, count in reasons.most_common(REASONS_SHOWN)]
    more = len(reasons) - len(shown)
    return f" ({', '.join([*shown, *[f'{more} other reasons'] * bool(more)])})" if shown else ""


def columns(outcomes: Sequence[Fit | Failure]) -> dict[str, list[Any]]:
    """The table of all curves, a row for each in their order, by columns; None where there is no value."""
    return transpose_rows([_row(item) for item in outcomes])


def _row(item: Fit | Failure) -> dict[str, Any]:
    if isinstance(item, Failure):
        unread = (item.file, item.name, UNUSABLE, item.reason, None)
        more = {"grade": UNFIT, "grade_reason": item.reason, "quality": 0.0, "flags": "; ".join(item.flags)}
        return dict(zip(ALWAYS, unread, strict=True)) | _placed(item) | more
    cells = (item.file, item.name, status_of(item), reason_of(item), item.a.size)
    row: dict[str, Any] = dict(zip(ALWAYS, cells, strict=True))
    row |= _placed(item) | {"surface": item.surface}
    for estimate in item.estimates:
        parts = {"": estimate.value} | (_interval(estimate, item.settings.level) if estimate.free else {})
        stem = "modulus_factor" if estimate.name == "modulus" else estimate.name.replace(":", "_").replace(" ", "_")
        for part, value in parts.items():  # titles such as ``E_film_err_Pa``
            title = "_".join(filter(None, [stem, part]))
            unit = f"{title}_m_per_N" if estimate.name == "compliance" else with_unit(title, estimate.dimension)
            row[unit] = value
    row |= {"scatter": item.scatter, "lag1": item.structure.lag1}
    row |= {"correlation_modulus_w": item.correlated("modulus", "w")}
    if item.grade is not None:
        row |= {"adhesion_force_N": item.adhesion, "grade": item.grade.word, "grade_reason": item.grade.reason}
        row |= {"quality": item.grade.quality, "flags": "; ".join(item.flags)}
    return row | {"warnings": "; ".join(item.warnings), "level": item.settings.level}


def _interval(item: FittedValue, level: float) -> dict[str, float | None]:
    """The half-width of an estimate, the ends of its interval, and the half-widths of the parts of both."""
    (low, high), parts = item.whole, item.parts(level)
    ends = {"err": math.hypot(*parts.values()) if parts else item.half_width(level), "low": low, "high": high}
    return ends | {kind: parts.get(kind) for kind in ("statistical", "calibration", "model")}


def _causes(item: Fit | Failure) -> dict[tuple[str, str, str], float]:
    """By how much inputs and models may change each quantity, relative, at the level of the intervals and with the sign
    where it is known: by quantity, part of the error, cause."""
    if isinstance(item, Failure):
        return {}
    changes = dict[tuple[str, str, str], float]()
    for one in (one for one in item.estimates if one.value > 0):
        by = one.systematic or {}
        half = one.parts(item.settings.level).get("calibration", 0.0) / (math.hypot(*by.values()) or 1.0)
        changes |= {(one.name, "calibration", cause): half * size / one.value for cause, size in by.items()}
        changes |= {(one.name, "model", cause): (-1 if cause in one.lowers else 1) * size / one.value
                    for cause, size in (one.model or {}).items()}  # fmt: skip
    return changes


def _placed(item: Fit | Failure) -> dict[str, Any]:
    """Column, row and position of a curve of a map; nothing of others."""
    at = item.pixel
    return {} if at is None else {"map_column": at.column, "map_row": at.row, "x_m": at.x, "y_m": at.y}


def summary(outcomes: Sequence[Fit | Failure], body: str) -> dict[str, Any]:
    """What stands in the JSON file: per curve everything but the rows themselves."""
    return identity(archive.FITS, body) | {"curves": [_summary(item) for item in outcomes]}


def identity(format: str, body: str) -> dict[str, Any]:
    """How the summary of a fit to a ``body`` in words begins."""
    return {"format": format, "version": 2, "body": body}


def _summary(item: Fit | Failure) -> dict[str, Any]:
    if isinstance(item, Failure):
        return {
            "file": item.file, "curve": item.name, "status": UNUSABLE, "reason": list(item.lines), "grade": UNFIT,
            "grade_reason": item.reason, "quality": 0.0, "flags": list(item.flags),
        }  # fmt: skip
    structure, jkr, beside, graded = item.structure, item.jkr, dict[str, Any](), dict[str, Any]()
    # JKR beside a fit with a range, by what its misfit is larger
    if isinstance(jkr, JKRBeside):
        beside = {"jkr": quantities(jkr, "E_star w") | {"misfit": jkr.rms / jkr.rms_of_range}}
    elif jkr is not None:
        beside = {"jkr": {"reason": str(jkr)}}
    if (grade := item.grade) is not None:
        graded = {"grade": grade.word, "grade_reason": grade.reason, "sizes": dict(grade.sizes),
                  "quality": grade.quality, "flags": list(item.flags)}  # fmt: skip
    return {
        "file": item.file,
        "curve": item.name,
        "surface": item.surface,
        "status": status_of(item),
        "estimates": {one.name: estimate_summary(one, item.settings.level) for one in item.estimates},
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
        **beside,
        **_verdict(item),
        **({"plan": [asdict(one) for one in item.plan]} if item.plan else {}),
        **graded,
        **({"free_rows": list(item.held)} if item.held else {}),
        "warnings": list(item.warnings),
    }


def estimate_summary(item: FittedValue, level: float = LEVEL) -> dict[str, Any]:
    """An estimate with its interval at ``level`` and the parts of that, as in the table; ``model``: by their causes."""
    unit = "m/N" if item.name == "compliance" else SI[item.dimension]
    numbers: dict[str, Any] = {"value": item.value, "unit": unit, "free": item.free}
    if item.free:
        numbers |= {"standard_error": item.error, **_interval(item, level), "model": dict(item.model or {})}
    if item.systematic:
        numbers["systematic"] = {name: abs(size) for name, size in item.systematic.items()}
    return numbers


@WORDS.register(Fit)
def fit_words(item: Fit) -> list[str]:
    """A fit as lines of text: the verdict, what was free, and what follows from it."""
    out = f" ({', '.join(item.left_out)} left out)" if item.left_out else ""
    status = f"{', '.join([status_of(item), *item.flags])}, " if item.grade is not None or item.flags else ""
    ways = f", {item.directions}" if item.directions else ""
    stuck = ", no slip" if item.surface == "sticking" else ""
    # A line on the longest range that the rows leave, where w rests on it more than on the noise
    w, left = item.work, item.range_left
    part = (w.model or {}).get(range_alternative.RANGE, 0.0)
    if left is None or w.low is None or w.high is None or part < w.high - w.low:
        range_words = []
    else:
        longest = show(min(left, item.settings.longest_range), "length", 2)
        moved = f"of adhesion up to {longest} would change w by {show(part, 'work', 2)}"
        range_words = [f"  {'range':<12} {moved}; if it is known to be shorter: --uncertain range=LENGTH"]
    held = [f"  {'' if i else 'free rows':<12} {words}" for i, words in enumerate(item.held)]
    lines = [*verdict_words(item), *held, *range_words]
    lines += [f"  {item.where}: {status}{item.a.size} rows of {', '.join(item.data)}{ways}{out}{stuck}"]
    lines += [f"  {'tip':<12} {item.tip}"] * bool(item.tip)
    lines += [f"  {'not included':<12} {item.not_included}"] * bool(item.not_included)
    lines += estimate_lines(sorted(item.estimates, key=lambda one: one.name in ZERO_POINTS), item.settings.level)
    correlation = item.correlated("modulus", "w")
    # Standard deviation of the readings as the residuals have it
    told = [f"{show(item.scatter * scale, DIMENSIONS[name], 2)} in {name}" for name, scale in item.scales.items()]
    told += [] if correlation is None else [f"correlation of E* and w {correlation:.2f}"]
    lines.append(f"  {'scatter':<12} {', '.join(told)}")
    if item.grade is not None:
        lines.append(f"  {'quality':<12} {item.grade.quality:.2f}: {', '.join(size_words(item.grade.sizes))}")
    return lines


def verdict_words(item: Fit) -> list[str]:
    """E* and w with the parts of their errors; of raw records also the grade with its reason, what would explain a
    misfit, what a formula would give, and which alternatives the parts by the model are from."""
    shown, formula = [item.estimate("E_star"), item.work], list[str]()
    verdict, grade = brief(shown, item.settings.level), item.grade
    if grade is not None:
        verdict += f": {grade.word}" + (f" ({grade.reason})" if grade.word != GOOD else "")
    elif doubts := [flag for flag in item.flags if not flag.endswith(VAGUE)]:
        verdict += f"; doubtful: {', '.join(doubts)}"
    if item.verdict is None:
        return [verdict]
    if item.verdict.E_star is not None:
        by = item.verdict.E_star
        words = f"{show(by, 'modulus', 3)} ({deviation(by / item.value('E_star') - 1)})"
        formula = [f"{item.verdict.formula} fit at maximum load would give {words}"]
    # What may cause a misfit, and how much the likeliest of each family would change
    others = item.verdict.alternatives
    likeliest = {one.family: one for one in reversed(others.named)}
    moved = ((family, *(change_words(likeliest[family].change(name)) for name in ("E_star", "w")))
             for family in others.families)  # fmt: skip
    changes = [f"{family} would change E* by {E}, w by {w}" for family, E, w in moved]
    cause = f"cause{' not identifiable' * (len(changes) > 1)}: {'; '.join(changes)}"
    judged = [cause if others.named else "no alternative model is favoured"]
    if tied := item.verdict.tied:
        verdict += f"; by {tied[0].name} ({parameter_words(tied[0])})"
        judged = ["JKR as described is rejected", *(f"{one.name} is not distinguishable from it" for one in tied[1:])]
    parts = dict.fromkeys(name for one in shown for name in one.model or {})
    judged += [f"model uncertainty from {', '.join(parts)}"] if parts else []
    return [verdict, *(f"  {'; '.join(lines)}" for lines in (formula, judged) if lines)]


def brief(items: Sequence[FittedValue], level: float) -> str:
    """Values with their statistical part, that of inputs, and that of the model, all half-widths at one ``level``;
    the kinds of several parts stand behind all values, where all have the same."""
    parts = [_parts(item, level) for item in items]
    kinds = list(parts[0]) if len(parts[0]) > 1 and len(set(map(tuple, parts))) == 1 else []
    told = []
    for item, each in zip(items, parts, strict=True):
        symbol = SYMBOLS.get(item.name, item.name)
        none = item.error is None or item.low is item.high is None  # an error beyond any interval tells nothing
        why = "" if not none else " (not determined by the data)" if item.free else " (fixed)"
        told.append(f"{symbol} > {show(item.value, item.dimension, 3)} (lower bound)" if _is_least(item) else
                    f"{symbol} = {with_errors(item, each, not kinds)}{why}")  # fmt: skip
    values = ", ".join(told) + f" ({', '.join(kinds)})" * bool(kinds)
    return values + f", at {100 * level:g} %" * any(item.error is not None for item in items)


def _is_least(item: FittedValue) -> bool:
    """Whether the value is a lower bound: nothing but its own low end is known."""
    return item.error is None and item.high is None and item.low == item.value


def with_errors(item: FittedValue, parts: Mapping[str, float], named: bool) -> str:
    """A value with half-widths, by their kinds where ``named``, in one unit, that of the largest of them: to the second
    digit of the whole error; a part that is smaller than that to its first."""
    if not parts or not all(0 < size < math.inf for size in parts.values()):
        return show(item.value, item.dimension, 4)
    if _is_spread(item):
        return " to ".join(show(end or 0.0, item.dimension, 2) for end in (item.low, item.high))
    factor, unit = scale(max(abs(item.value), *parts.values()), item.dimension)
    places = max(1 - math.floor(math.log10(math.hypot(*parts.values()) / factor)), 0)
    errors = (f"± {size / factor:.{max(places, -math.floor(math.log10(size / factor)))}f}" + f" ({kind})" * named
              for kind, size in parts.items())  # fmt: skip
    return " ".join([f"{round(item.value / factor, places) + 0.0:.{places}f}", *errors, unit]).strip()


def _is_spread(item: FittedValue) -> bool:
    """Whether a value that cannot be negative has an interval wider than twice itself: nothing else tells it."""
    low, high = item.low or 0.0, item.high or 0.0
    return low > 0 and high - low > 2 * item.value


def _parts(item: FittedValue, level: float) -> dict[str, float]:
    """The half-widths [SI] of the parts of the error by their kinds, those that are noticeable."""
    parts = item.parts(level)
    return {kind: size for kind, size in parts.items() if size > NOTICEABLE * parts["statistical"]}


def parameter_words(one: FittedAlternative) -> str:
    """What else an alternative in full tells, in words."""
    values = (f"{name} {show(value, OF_ALTERNATIVES[name], 3)}" for name, value in one.quantities.items())
    return ", ".join([*values, f"chi^2 {-one.falls:.3g}"])


def alternatives_table(item: Fit) -> list[str]:
    """A line per alternative of a raw record: what the data say, how much of it they ask for, and how E* and w would
    move."""
    if item.verdict is None:
        return []
    head = f"  {'alternative model':<43}{'the data':<21}{'p':>8}{'E*':>8}{'w':>8}{'chi^2':>10}"
    return [head, *(
        f"  {one.name:<43}{one.word:<21}{one.chance:>8.1g}{one.change('E_star'):>+8.1%}{one.change('w'):>+8.1%}"
        f"{-one.taken:>10.3g}" for one in item.verdict.alternatives.scores
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
    """Alternatives of a raw record, each with its score, and what a formula makes of the deepest row."""
    if item.verdict is None:
        return {}
    verdict = item.verdict
    return {"verdict": {
        "model": verdict.tied[0].name if verdict.tied else "jkr",
        "named": [one.name for one in verdict.alternatives.named], "families": list(verdict.families),
        "in_full": [{
            "name": one.name, "family": one.family, "taken": one.taken, "chi2_falls": one.falls, "p": one.chance,
            **quantities(one, "E_star w"),
            **{with_unit(name, OF_ALTERNATIVES[name]): value for name, value in one.quantities.items()},
        } for one in verdict.fitted],
        "misfit": verdict.alternatives.misfit / verdict.alternatives.dof,
        "free_rows_tell_the_noise": verdict.alternatives.loose > 0,
        "formula": {"name": verdict.formula, "E_star_Pa": verdict.E_star} if verdict.E_star is not None else None,
        "rivals": [{
            "name": one.name, "family": one.family, "word": one.word, "amount_is": one.amount_is, "amount": one.amount,
            "standard_error": one.error if math.isfinite(one.error) else None, "p": one.chance,
            "share_of_misfit": one.share,
            # the relative moves of E* and w with what was found of it
            "E_star_moves": one.change("E_star"), "w_moves": one.change("w"),
            "E_star_may_move": abs(one.moved("E_star")), "w_may_move": abs(one.moved("w")),
        } for one in verdict.alternatives.scores],
    }}  # fmt: skip


def estimate_lines(items: Iterable[FittedValue], level: float, names: Mapping[str, str] = SYMBOLS) -> list[str]:
    """A line for each free parameter but the factor of all moduli, by its name or that in ``names``."""
    shown = (item for item in items if item.free and item.name != "modulus")
    return [f"  {names.get(item.name, item.name):<12} {estimate_words(item, level)}" for item in shown]


def estimate_words(estimate: FittedValue, level: float) -> str:
    """A value with the half-widths of its error at ``level``; its interval where that has one end or is lopsided."""
    dimension, parts = estimate.dimension, _parts(estimate, level)
    if _is_least(estimate):
        return f"more than {show(estimate.value, dimension, 3)}"
    text = with_errors(estimate, parts, len(parts) > 1)
    if estimate.error is None:
        text += " (not determined by the data)"
    low, high = estimate.low, estimate.high
    if low is None and high is None:
        return text
    lopsided = low is None or high is None or abs(high + low - 2 * estimate.value) > LOPSIDED * (high - low)
    if lopsided and not _is_spread(estimate):
        ends = [None if end is None else show(end, dimension, 4) for end in (low, high)]
        text += f", {100 * level:g} %: {ends[0] or 'no lower limit'} to {ends[1] or 'no upper limit'}"
    least = NOTICEABLE * (estimate.error or 0.0)
    inputs = [f"{name} {abs(value) / estimate.error:.0%}" for name, value in (estimate.systematic or {}).items()
              if estimate.error and abs(value) > least]  # fmt: skip
    return text + (f" (share of the error: {', '.join(inputs)})" if inputs else "")


# --------------------------------------------------------------------------------------------------
# Records fitted together as a table, as a summary and in words: what they share, a surface tension, or a law of w
# over the speed of the contact's edge.


@TABLES.register(JointFit)
def joint_table(joint: JointFit) -> dict[str, list[Any]]:
    """A row for each record: what all share, and its own."""
    return columns(joint.fits)


@SUMMARIES.register(JointFit)
def joint_summary(joint: JointFit) -> dict[str, Any]:
    """What is shared and what each record says."""
    return identity("jkr-joint-fit", joint.body) | {
        "shared": {item.name: estimate_summary(item, joint.level) for item in joint.shared},
        "correlation": np.asarray(joint.correlation).tolist(),
        "chance": joint.chance,
        "status": DOUBTFUL if joint.flags else FITTED,
        "flags": list(joint.flags),
        "alone": [dict(values) for values in joint.alone],
        "curves": [_summary(item) for item in joint.fits],
        "warnings": list(joint.warnings),
    }


@WORDS.register(JointFit)
def joint_words(joint: JointFit) -> list[str]:
    """What is shared, then what each record says alone, and its own."""
    shared = [item for item in joint.shared if item.name != "modulus"]
    doubts = f"; {DOUBTFUL}: {', '.join(joint.flags)}" if joint.flags else ""
    lines = [
        brief(shared, joint.level) + doubts,
        f"  {len(joint.fits)} force curves together (p = {joint.chance:.2g} for differences as large as theirs)",
    ]
    lines += estimate_lines(shared, joint.level, {})
    dimensions = {item.name: item.dimension for item in joint.shared}
    for one, values in zip(joint.fits, joint.alone, strict=True):
        own = [item for item in one.estimates if item.free and item.name not in dimensions]
        parts = [f"{name} = {show(value, dimensions[name], 4)}" for name, value in values.items()]
        rest = ", ".join(f"{i.name} = {show(i.value, i.dimension, 4)}" for i in own if i.dimension != "modulus")
        lines.append(f"  {one.name}: alone {', '.join(parts)}; its own {rest or 'none'}")
    return lines


@FIGURES.register(JointFit)
def draw_joint(joint: JointFit) -> Figure:
    """The picture of what all records share."""
    from .figures import joint_figure

    return joint_figure(joint)


@TABLES.register(TensionFit)
def tension_table(tension: TensionFit) -> dict[str, list[Any]]:
    """All rows of all records: readings and the fitted load."""
    return stacked([
        {"curve": [record.name] * loads.size, "delta_m": record.depth, "P_N": record.load, "P_fit_N": loads}
        for record, loads in zip(tension.records, tension.loads, strict=True)
    ])  # fmt: skip


@SUMMARIES.register(TensionFit)
def tension_summary(tension: TensionFit) -> dict[str, Any]:
    """Tension, E* and w, with their correlations."""
    return identity("jkr-tension-fit", tension.body) | {
        "level": tension.level,
        "estimates": {item.name: estimate_summary(item, tension.level) for item in tension.estimates},
        "free": list(tension.free),
        "correlation": np.asarray(tension.correlation).tolist(),
        "scatter_N": tension.scatter,
        "warnings": list(tension.warnings),
    }


@WORDS.register(TensionFit)
def tension_words(tension: TensionFit) -> list[str]:
    """What was found of all records together, then each value."""
    rows = sum(map(len, tension.records))
    together = "1 force curve" if len(tension.records) == 1 else f"{len(tension.records)} force curves together"
    free = [item for item in tension.estimates if item.free]
    mixed = f"; one radius does not separate the tension from {' and '.join(tension.mixed)}" if tension.mixed else ""
    lines = [
        brief(free, tension.level) + mixed,
        f"  {together}, {rows} rows, scatter of the load {show(tension.scatter, 'load', 2)}",
    ]
    known = [f"{item.name} = {show(item.value, item.dimension)}" for item in tension.estimates if not item.free]
    lines += [f"  {item.name:<24} {estimate_words(item, tension.level)}" for item in free]
    return lines + ([f"  fixed: {', '.join(known)}"] if known else [])


# --------------------------------------------------------------------------------------------------
# The work of adhesion along measured curves as a table, as a summary, and in words.

FORMAT, WORK_VERSION = "jkr-work", 1  # choice: type and version of the JSON
QUARTILES = (0.25, 0.5, 0.75)  # theory: shares of the rows below each
MANY = 0.1  # choice: of the rows, as many without a work of adhesion are worth a warning


@dataclass(frozen=True, eq=False)
class Work(Result):
    """The work of adhesion along the ``curves`` in the file at ``path`` on a ``body``; the ``law`` over the speed of
    the edge through them, where there is one, and why others were ``skipped``."""

    path: Path
    curves: Sequence[WorkAlong]
    skipped: Sequence[str]
    body: Analysis
    law: Any

    @classmethod
    def of(
        cls, path: Path, curves: list[WorkAlong], skipped: Sequence[str], solution: Solution, unit: Nonadhesive,
        modulus_factor: float,
    ) -> Work:  # fmt: skip
        """The ``curves`` on a ``solution`` with its functions ``unit``."""
        law_along = offered("law over speed")
        law = None if law_along is None else law_along(curves)
        return cls(path, curves, skipped, adhesive(solution, unit, typical(curves), modulus_factor), law)

    @property
    def columns(self) -> dict[str, list[Any]]:  # type: ignore[override]
        """All rows of all curves, a curve at a time; None where there is no value. Quantities that no curve has make
        no column, but for the error of w: that is empty where the noise is not known."""
        names = {name for item in self.curves for name, (values, _) in _numbers(item).items() if values is not None}
        names.add("w_err_J_per_m2")
        tables = []
        for item in self.curves:
            curve, size = item.curve, len(item.curve)
            segments = [None] * size if curve.segment is None else curve.segment.tolist()  # which may be empty
            columns: dict[str, list[Any]] = {"curve": [curve.name] * size, "segment": segments}
            columns["state"] = item.state.tolist()
            for name, (values, rows) in _numbers(item).items():
                if name in names:
                    columns[name] = [None] * size if values is None else np.where(rows, values, np.nan).tolist()
            columns["level"] = [LEVEL] * size
            tables.append(columns)
        return stacked(tables)

    def summary(self) -> dict[str, Any]:
        """Per curve and for the body."""
        body, through = self.body, offered("summary of a law over speed")
        return {
            "format": FORMAT,
            "version": WORK_VERSION,
            "file": str(self.path),
            "series": str(body.path),
            "title": body.solution.record.title,
            "level": LEVEL,
            "modulus_factor": body.modulus_factor,
            "slopes": body.curve.slopes.method,
            "errors": body.budget.as_dict(),
            "curves": [curve_summary(item) for item in self.curves],
            "skipped": list(self.skipped),
            "warnings": self._body_warnings,
            "rate_law": None if self.law is None else through(self.law),
        }

    def words(self) -> list[str]:
        lines = [line for item in self.curves[:SHOWN] for line in work_words(item)]
        if len(self.curves) > SHOWN:
            lines.append(f"  ... and {counted(len(self.curves) - SHOWN, 'more curve')}")
        if self.law is not None:
            lines.append(f"  {offered('words of a law over speed')(self.law)}")
        return lines

    @property
    def warnings(self) -> list[str]:
        lines = [f"skipped: {line}" for line in some(list(self.skipped))]
        lines += [f"{item.curve.where}: {flag}" for item in self.curves[:SHOWN] for flag in flags(item)]
        return lines + [f"{self.path}: {warning}" for warning in self._body_warnings]

    @property
    def _body_warnings(self) -> list[str]:
        """What holds for every curve on this body: of its series, slopes and validity."""
        body = self.body
        return [*body.solution.warnings, *body.curve.slopes.flags, *body.validity.warnings]

    def figure(self) -> Figure:
        from .figures import work_figure

        return work_figure(self.curves, None if isinstance(self.law, Unknown) else self.law)


def _numbers(item: WorkAlong) -> dict[str, tuple[Array | None, Array]]:
    """The columns of numbers, each with the rows that have them."""
    curve, ok = item.curve, item.ok
    every = np.ones(ok.size, dtype=bool)
    timed = ~every if item.timed is None else item.timed
    return {
        "a_m": (curve.a, every) if "a" in item.used else (item.a, ok),
        "w_J_per_m2": (item.w, ok),
        "w_err_J_per_m2": (item.w_err, ok),
        "delta_m": (curve.delta, every),
        "P_N": (curve.P, every),
        "a_err_m": (item.a_err, ok),
        "t_s": (curve.t, every),
        "speed_m_per_s": (item.speed, timed),
        "speed_err_m_per_s": (item.speed_err, timed),
    }


def curve_summary(item: WorkAlong) -> dict[str, Any]:
    """Counts, quartiles of w over all usable rows and by the sense of the edge's motion, where its speed is more than
    its error in as many rows as a speed is taken from, and what to mind."""
    groups = {"all": item.ok}
    if item.timed is not None and item.speed is not None:
        moving = item.timed if item.speed_err is None else item.timed & (np.abs(item.speed) > item.speed_err)
        senses = {"advancing": moving & (item.speed > 0), "receding": moving & (item.speed < 0)}
        groups |= {name: rows & (np.count_nonzero(rows) >= item.window) for name, rows in senses.items()}
    words = (OK, NONE, BELOW, ABOVE) if item.least is None else (OK, NONE, BELOW, PINNED)
    return {
        "curve": item.curve.name,
        "from": list(item.used),
        "rows": {word: int((item.state == word).sum()) for word in words},
        **({} if item.least is None else {"w_least_J_per_m2": item.least}),
        "w": {name: _spread(item, rows) for name, rows in groups.items()},
        "window": item.window or None,
        "flags": [*item.curve.flags, *flags(item)],
    }


def _spread(item: WorkAlong, rows: Array) -> dict[str, Any] | None:
    """Quartiles of w and the median of its error over some rows; None where there are none."""
    if not rows.any():
        return None
    low, middle, high = (float(value) for value in np.quantile(item.w[rows], QUARTILES))
    spread: dict[str, Any] = {"rows": int(rows.sum()), "median_J_per_m2": middle, "quartiles_J_per_m2": [low, high]}
    errors = {"err": item.w_err, **{f"err_by_{name}": share for name, share in item.shares.items()}}
    for name, values in errors.items():
        spread[f"{name}_J_per_m2"] = None if values is None else float(np.median(values[rows]))
    if item.speed is not None and item.timed is not None and (timed := rows & item.timed).any():
        spread["speed_m_per_s"] = [float(value) for value in np.quantile(item.speed[timed], (0, 1))]
    return spread


def flags(item: WorkAlong) -> list[str]:
    """What a reader of the numbers should know about one curve."""
    size = len(item.curve)
    lines = list(saturation_words(item.curve, saturation(item.curve)))
    for word, remedy in ((BELOW, "begin the solution at smaller radii"), (ABOVE, "increase [loading] radius")):
        if (count := int((item.state == word).sum())) > MANY * size:
            lines.append(f"{count} of {size} rows lie {word}: they have no w; {remedy}, or they are not in contact")
    if item.least is not None and (count := int((item.state == PINNED).sum())):
        lines.append(f"{count} of {size} rows are {PINNED}: G <= w; w is at least {show(item.least, 'work')}")
    if (count := int((item.state == NONE).sum())) > MANY * size:
        lines.append(
            f"{count} of {size} rows lie at or above the nonadhesive load: check contact point, force "
            "offset and modulus; if noise put them there, the w of the others is too large on average"
        )
    if item.w_err is not None and (unsure := int((item.w_err > item.w)[item.ok].sum())) > MANY * size:
        lines.append(f"at {unsure} of {size} rows the error of w is larger than w")
    if item.timed is not None and not item.timed.any():
        lines.append(f"no {item.window} usable rows follow one another with rising time: no speed")
    return lines


def work_words(item: WorkAlong) -> list[str]:
    """One curve: the work of adhesion along all rows, then of advancing and receding edges."""
    parts = [f"{int(item.ok.sum())} of {counted(len(item.curve), 'row')}: {item.curve.where}"]
    for name, spread in curve_summary(item)["w"].items():
        if spread is None:
            continue
        low, high = (show(value, "work") for value in spread["quartiles_J_per_m2"])
        label = "w" if name == "all" else f"{name} w"
        median = spread["median_J_per_m2"]
        known = "err_by_noise_J_per_m2" in spread
        value = show_within(median, spread["err_J_per_m2"], "work", 4, 4) if known else show(median, "work")
        value += f", at {AT_LEVEL}," * (known and name == "all")
        parts.append(f"{label} = {value} (half of the rows: {low} to {high})")
    unknown = ["no error of w: the noise is not known, give --noise"] if item.w_err is None else []
    return [", ".join([*parts[1:2], parts[0]]), *(f"    {part}" for part in (*parts[2:], *unknown, *item.curve.flags))]


# --------------------------------------------------------------------------------------------------
# What a measured file holds, in words and as JSON: reading, segments, base lines, touch, jumps, adhesion, flags.

LOOK_FORMAT, LOOK_VERSION = "jkr-look", 1  # choice: type and version of the JSON
NO_BASE_LINE = Unknown("there is no base line")
HOPELESS = ("no contact", "wrong way", "no force curve")  # flags of records of which no fit is taken


@dataclass(frozen=True, eq=False)
class Look(Result):
    """What a measured file holds: its curves taken apart, and a line on each that is ``unusable``; ``tip``: of which a
    rough modulus is computed; ``notes`` on what the files of a folder settled together; ``rigid``: on a rigid
    specimen, the sensitivity that follows."""

    path: Path
    records: Sequence[ForceCurve]
    unusable: Sequence[str]
    tip: Indenter | None = None
    notes: Sequence[str] = ()
    rigid: Sensitivity | None = None

    @classmethod
    def at(cls, path: Path, reading: measured.Reading, tip: Indenter | None = None, rigid: bool = False) -> Look:
        """What the file at ``path`` holds, read by ``reading``; where spring constant or sensitivity are missing, 1
        stands in for them."""
        reading.refuse_contact("look")
        reading, curves, notes = replace(reading, incomplete=True), list[Curve | InputError](), tuple[str, ...]()
        try:
            if path.is_dir():
                batch = read_batch(measured.folders_of(path), reading)
                lines = [line for _, unread in batch.read for line in unread]
                curves += [*(one for found, _ in batch.read for one in found), *map(InputError, lines)]
                notes = batch.notes
            else:
                for curve in measured.each(path, reading):
                    curves.append(curve)  # those before an error stay
        except InputError as error:
            curves.append(error)
        read = [curve for curve in curves if isinstance(curve, Curve)]
        taken_apart = iter(segment_force_curves(read, quick=len(read) > SHOWN))
        records: list[ForceCurve] = []
        unusable: list[str] = []
        for curve in curves:
            found = next(taken_apart) if isinstance(curve, Curve) else curve
            if isinstance(found, ForceCurve):
                records.append(found)
            elif isinstance(found, InputError):
                unusable += found.lines
            else:
                raise found
        pressed = [record for record in records if look_grade(record)[0] != UNFIT] or records
        of_rigid = mean([sensitivity_of(record) for record in pressed]) if rigid and records else None
        return cls(path, records, unusable, tip, notes, of_rigid)

    def summary(self) -> dict[str, Any]:
        curves = []
        for record in self.records:  # with its rough numbers, where there is a tip
            glance = None if self.tip is None else at_a_glance(record, self.tip)
            rough: dict[str, Any] = {}
            if isinstance(glance, Unknown):
                rough = _known("rough", glance)
            elif glance is not None:
                rough = {"rough": quantities(glance, "E_star a") | _known("w_J_per_m2", glance.w)}
            curves.append(as_dict(record) | rough)
        whole = {"format": LOOK_FORMAT, "version": LOOK_VERSION, "file": str(self.path), "level": LEVEL,
                 "curves": curves, "unusable": list(self.unusable)}  # fmt: skip
        return whole | ({"rigid": asdict(self.rigid)} if self.rigid else {})

    def words(self) -> list[str]:
        lines = [self.rigid.words()] if self.rigid else []
        lines += [line for record in self.records[:SHOWN] for line in look_words(record, self.tip)]
        if (count := len(self.records)) > 1:
            grades = Counter(look_grade(record)[0] for record in self.records)
            reasons = Counter(reason for record in self.records if (reason := look_grade(record)[1]))
            told = ", ".join(f"{grades[word]} {word}" for word in GRADES if grades[word])
            head = [f"{counted(count, 'curve')}: {told}{_counted(reasons)}: {self.path}"]
            lines = [
                *lines[: bool(self.rigid)],
                *head,
                *(f"  {look_words(record)[0]}" for record in self.records[:SHOWN]),
                *lines[bool(self.rigid) :],
            ]
        return lines + [f"  ... and {counted(count - SHOWN, 'more curve')} (all with --json)"] * (count > SHOWN)

    @property
    def warnings(self) -> Sequence[str]:
        return [*self.unusable, *self.notes]

    def figure(self) -> Figure:
        from .figures import record_figure

        return record_figure(self.records)


def look_grade(record: ForceCurve) -> tuple[str, str]:
    """Whether a record can be fitted as it is, by its flags, and the flag that says why not."""
    hopeless = next((flag for flag in record.flags if flag in HOPELESS), "")
    return (UNFIT, hopeless) if hopeless else (LOOK, next(iter(record.flags))) if record.flags else (GOOD, "")


def as_dict(record: ForceCurve) -> dict[str, Any]:
    """One curve as plain values, SI; a number that is not known is null, with its reason under ``..._unknown``."""
    curve = record.curve
    return {
        "curve": curve.name,
        "rows": len(curve),
        "columns": list(curve.measured),
        "read": list(curve.flags),
        "rows_of_no_segment": record.rest,
        "segments": [{"kind": s.kind, "first_row": s.first + 1, "last_row": s.last + 1} for s in record.segments],
        **{item.segment.kind: _direction(item) for item in record.directions},
        "flags": dict(record.flags),
    }


def _direction(item: Direction) -> dict[str, Any]:
    touch, adhesion = (item.touch, item.adhesion) if item.based else (NO_BASE_LINE, NO_BASE_LINE)
    return {
        "rows": len(item.segment),
        **_known("touch_m", touch),
        "touch_err_m": None if isinstance(touch, Unknown) else item.touch_err,
        "base_line": quantities(item.base, "offset tilt at rows noise waviness") if item.based else None,
        **_known("largest_load_N", item.largest if item.based else NO_BASE_LINE),
        **_known("adhesion_force_N", adhesion),
        **({} if isinstance(adhesion, Unknown) else {"adhesion_force_err_N": HALF_WIDTH * item.adhesion_err}),
        "adhesion_at_m": None if isinstance(adhesion, Unknown) else item.adhesion_at,
        "jumps": [{"row": jump.row + 1} | quantities(jump, "position step") for jump in item.jumps],
    }


def _known(name: str, value: float | Unknown) -> dict[str, Any]:
    return {name: None, f"{name}_unknown": value.reason} if isinstance(value, Unknown) else {name: value}


def at_a_glance(record: ForceCurve, tip: Indenter) -> Rough | Unknown:
    """What the formulas of a half-space make of the direction that is nearest to no adhesion, the approach."""
    if any(ARBITRARY in flag for flag in record.curve.flags):
        return Unknown("loads are in arbitrary units")
    item = record.direction("approach") or record.direction("retract")
    if item is None or not item.based or isinstance(item.touch, Unknown):
        return Unknown("no base line and first touch")
    back = record.direction("retract")
    adhesion = back.adhesion if back is not None and back.based else Unknown("no retraction with a base line")
    depth = item.depth - (0.0 if record.curve.stiffness is None else item.largest / record.curve.stiffness)
    return rough(tip, item.largest, depth, adhesion)


def look_words(record: ForceCurve, tip: Indenter | None = None) -> list[str]:
    """Lines for a reader: what the record is, then a line per direction and per flag; a rough modulus by a ``tip``."""
    curve = record.curve
    columns = ", ".join(map(text_formats.NAMES.meaning, curve.measured))
    parts = ", ".join(f"{segment.kind} {len(segment)}" for segment in record.segments)
    parts += f", {record.rest} of neither" if record.rest else ""
    # The adhesion force and the largest load, where the base line gives them
    forces = {}
    for item in record.directions if all(item.based for item in record.directions) else ():
        if item.segment.kind != "approach" and not isinstance(item.adhesion, Unknown):
            forces["adhesion force"] = item.adhesion
        forces["largest load"] = max(item.largest, forces.get("largest load", item.largest))
    words = [f"{name} {show(forces[name], 'load', 3)}" for name in ("adhesion force", "largest load") if name in forces]
    look_verdict = ", ".join(words) or "adhesion force unknown, no base line"
    doubts = [flag for flag in curve.flags if ARBITRARY in flag or flag == NOT_SUBTRACTED]  # of units, told first
    if any(ARBITRARY in flag for flag in doubts):
        look_verdict = "adhesion force unknown, loads in arbitrary units"
    known = any(item.based and not isinstance(item.touch, Unknown) for item in record.directions)
    errors = f"; ± at {AT_LEVEL}" * known
    head = [f"{look_verdict}: {curve.where}", f"  {len(curve)} rows of {columns}; {parts}{errors}"]
    rough = []
    glance = Unknown("") if tip is None else at_a_glance(record, tip)
    if tip is not None and isinstance(glance, Unknown):
        rough = [f"  no rough modulus: {glance.reason}"]
    elif not isinstance(glance, Unknown):
        w = "" if isinstance(glance.w, Unknown) else f", w = {show(glance.w, 'work', 2)} (adhesion force)"
        E_star, a = show(glance.E_star, "modulus", 2), show(glance.a, "length", 2)
        rough = [f"  rough: E* = {E_star} (half-space without adhesion, largest load, a = {a}){w}"]
    if curve.a is not None and not words:  # readings of a contact, of which none need be free: no base line is sought
        ranges = [
            f"{text_formats.NAMES.meaning(name)} {show(float(values.min()), kind, 4)} to "
            f"{show(float(values.max()), kind, 4)}"
            for name, kind in (("a", "length"), ("delta", "length"), ("P", "load"))
            if (values := getattr(curve, name)) is not None
        ]
        head[0] = f"a loading-unloading table of a contact, not a force curve: {curve.where}"
        rough = ["  no rough modulus of a table without a base line: jkr fit"] * bool(rough)
        return [*head, f"  {', '.join(ranges)}", *rough, *(f"  {flag}" for flag in curve.flags)]
    return [
        *head,
        *(f"  {flag}" for flag in doubts),
        *rough,
        *(f"  {name}: {sentence}" for name, sentence in record.flags.items()),
        *(f"  {item.segment.kind:8}  {line}" for item in record.directions for line in _direction_words(item)),
        *(f"  {flag}" for flag in curve.flags if flag not in doubts),
    ]


def _direction_words(item: Direction) -> list[str]:
    approach = item.segment.kind == "approach"
    base = item.base
    wavy = f", waviness {show(base.waviness, 'load', 3)}" if base.waviness else ""
    noise, tilt = show(base.noise, "load", 3), show(base.tilt, "stiffness", 3)
    line = f"base line of {base.rows} rows: noise {noise}, tilt {tilt}{wavy}"
    if isinstance(item.touch, Unknown):
        return [item.touch.reason, line]
    if not item.based:
        where = "begins and the largest load" if approach else "ends and the adhesion force"
        return [f"no straight base line: where contact {where} are unknown"]
    touch = show_within(item.touch, item.touch_err, "length")
    count = len(item.jumps)
    if approach:
        jump = f"jump into contact by {show(-item.jumps[0].step, 'load', 3)}" if count else "no jump into contact"
        return [f"contact from {touch} on, up to {show(item.largest, 'load', 3)}, {jump}", line]
    if isinstance(item.adhesion, Unknown):
        tension = f"unknown, {item.adhesion.reason}"
    else:
        force = show_within(item.adhesion, HALF_WIDTH * item.adhesion_err, "load", 3, 2)
        tension = f"{force} at {show(item.adhesion_at, 'length')}"
    places = ", ".join(show(jump.position, "length") for jump in item.jumps)
    jumps = {0: "without a jump", 1: f"by one jump at {places}"}.get(count, f"by {count} jumps at {places}")
    return [f"adhesion force {tension}; out of contact from {touch} on, {jumps}", line]
