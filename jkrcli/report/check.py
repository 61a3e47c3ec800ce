"""What a case needs and what to expect of it, without solving it; and what of jkr works on this machine."""

from __future__ import annotations

import platform
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any, Literal

from .. import __version__
from ..adhesion.finite_range import unable
from ..adhesion.roughness import Roughness, RoughWork, works_on
from ..adhesion.validity import large_strains
from ..base.errors import Refusal, Unknown, installs
from ..base.process import memory_words
from ..base.registry import Result
from ..base.units import reached, show
from ..base.wings import offered
from ..bodies.problem import Problem
from ..case.models import Case, method_of
from ..methods.protocol import Choice, Option, choose_method, survey
from ..resolve.neglected import EffectsPreview, NeglectedEffect, neglected_effects, preview_effects
from . import tables

LARGEST = 3  # choice: neglected effects that are printed first
SIZES = {"a/R": "a_over_R", "a/h": "a_over_h", "delta/h": "delta_over_h"}


@dataclass(frozen=True, eq=False)
class Check(Result):
    """Which method a case needs and why, what each would cost, and what to expect: a coarse solution of the laterally
    unbounded body, and neglected effects and their size."""

    first_lines = 16

    path: Path
    problem: Problem
    choice: Choice
    options: Sequence[Option]
    expected: EffectsPreview | Unknown
    left_out: Sequence[NeglectedEffect]
    range_: str | Unknown
    remarks: Sequence[str]
    rough: Sequence[RoughWork | None] = ()  # of each work of adhesion

    @classmethod
    def of(cls, path: Path, case: Case, roughness: Roughness | None = None) -> Check:
        """What is to be said of a ``case``, its surfaces with this ``roughness``."""
        model = case.model
        problem = model.problem()
        choice = choose_method(problem, model.method, lambda name: method_of(model, name))
        options = choice.options or survey(problem, lambda name: method_of(model, name))
        adhesion, left = model.adhesion, list[NeglectedEffect]()
        ranged = adhesion.range or adhesion.stress or adhesion.capillary
        works, rough = works_on(roughness, problem, adhesion.w, bool(ranged))
        expected: EffectsPreview | Unknown
        try:
            expected = preview_effects(problem, tuple(works), adhesion.z0)
        except Refusal as error:
            expected = Unknown(str(error))
        else:  # what the case leaves out, at the depth expected
            left = neglected_effects(problem, expected, tuple(works), None if ranged else adhesion.z0)
        # Words on the range of adhesion that a case asks for, or why it has no curve
        range_: str | Unknown = "jkr transform includes its range; the force here is that of JKR" if ranged else ""
        if ranged and (reason := unable(problem, choice.name)):
            range_ = Unknown(reason)
        return cls(path, problem, choice, options, expected, left, range_, case.remarks, rough)

    def summary(self) -> dict[str, Any]:
        data: dict[str, Any] = {"case": str(self.path), "problem": self.problem.words, "method": self.choice.name}
        law = self.problem.specimen.relaxation
        data |= {"reason": self.choice.reason, "relaxation": "" if law is None else str(law)}
        data |= {"surface": self.problem.surface, "left_out": [one.as_dict for one in self.left_out]}
        if isinstance(self.expected, Unknown):
            expected: dict[str, Any] = {"expectation": self.expected}
        else:
            adhesion = [
                {"w_J_per_m2": w, "pull_off": tables.point(p), "validity": vars(v)}
                | ({} if by is None else by.summary())
                for (w, p, v), by in zip(self.expected.adhesion, self.rough, strict=True)
            ]
            sizes = tables.quantities(self.expected, "a delta P")
            errors = {"half_space_error": self.expected.half_space_error, "profile_error": self.expected.profile_error}
            expected = sizes | errors | {"adhesion": adhesion}
        return data | {"options": [asdict(option) for option in self.options]} | expected

    def words(self) -> list[str]:
        options = []
        for option in sorted(self.options, key=lambda option: option.forecast is None):  # what is applicable first
            told = f"not applicable: {option.refusal}"
            if option.forecast is not None:
                note = f" ({option.forecast.note})" if option.forecast.note else ""
                against = f"; {words}" if (words := option.objection) else ""
                told = f"about {option.cost}, {memory_words(option.forecast.memory_mib)}{note}{against}"
            options.append(f"            {option.name:<12} {told}")
        first = [one for one in self.left_out if not one.included and one.largest is not None][:LARGEST]
        rest = [one for one in self.left_out if one not in first]
        law, moduli = self.problem.specimen.relaxation, list[str]()
        if law is not None:
            when = "t = 0" if law.relaxed is not None else "its own time"
            moduli = [f"  moduli    {law}; loads here are those at {when}"]
        return [
            f"method {self.choice.name}: {self.choice.brief}",
            f"  body      {self.problem.words}",
            *self._reaches(),
            *moduli,
            *_table(first, "neglected effects and their size"),
            *["  S: punch stiffness dP/d(delta) at fixed contact radius; load and S at equal depth"] * bool(first),
            "  methods   cost and numerical error of each:",
            *options,
            *_table(rest, "other effects, and simpler formulas"),
        ]

    @property
    def warnings(self) -> list[str]:
        adhesion = () if isinstance(self.expected, Unknown) else self.expected.adhesion
        judged = dict.fromkeys(text for _, _, judged in adhesion for text in judged.warnings)
        refused = [f"jkr transform will refuse: {self.range_}"] if isinstance(self.range_, Unknown) else []
        for (_, point, _), by in zip(adhesion, self.rough, strict=False):
            judged |= dict.fromkeys(() if by is None else by.contact.warnings(getattr(point, "a", None)))
        return [*judged, *refused, *self.remarks]

    def _reaches(self) -> Iterator[str]:
        expected, range_ = self.expected, self.range_
        if isinstance(expected, Unknown):
            yield f"  reaches   unknown: {expected}"
            return
        beside = ""
        if expected.half_space_error is not None:
            beside = f" (a half-space formula: {show(expected.P / (1 + expected.half_space_error), 'load')})"
        yield f"  reaches   {reached(expected.a, expected.delta, expected.P)}{beside}"
        if expected.profile_error:
            error = tables.percent(expected.profile_error)
            yield f"  profile   {error} of the load is uncertain by the points of its table, whatever the method"
        for w, point, judged in expected.adhesion:
            number = f"none ({judged.tabor})" if isinstance(judged.tabor, Unknown) else f"{judged.tabor:.3g}"
            tabor = judged.verdict or f"Tabor number {number}"
            if range_ != "":
                tabor = f"Tabor number {number}{'' if isinstance(range_, Unknown) else f'; {range_}'}"
            if isinstance(point, Unknown):
                lost = point.reason
            else:
                digits = tables.digits(point.P, large_strains(self.problem, w, point, loaded=True))
                lost = f"P = {show(point.P, 'load', digits)} at {tables.format_state(point, 'a')}"
            yield f"  w = {show(w, 'work')}: pull-off (load control) {lost}; {tabor}"
        yield from (f"    {line}" for by in self.rough if by is not None for line in by.words())
        for *_, judged in expected.adhesion[-1:]:
            if known := tables.size_words(judged, SIZES):
                yield f"  sizes     {', '.join(known)} at the largest contact radius"


def _table(rows: Sequence[NeglectedEffect], title: str) -> Iterator[str]:
    """Effects with their changes, and the key that includes each or why nothing is known of it."""
    name = max(len(title) - 2, *(len(one.name) for one in rows), 0) if rows else 0
    if rows:
        yield f"  {title:<{name + 2}}    load       S pull-off  included by"
    for one in rows:
        cells = []
        for change in one.changes.values():  # ``+63%``, ``-4.4%``, ``+0.02%``; a dash where it is not known
            if isinstance(change, Unknown) or not round(change, 4):
                cells.append("-" if isinstance(change, Unknown) else "0")
            else:
                digits = sum(abs(change) < limit for limit in (0.1, 0.01))  # two of them are shown
                cells.append(f"{change:+.{digits}%}")
        load, S, pull_off = cells
        why = "" if one.largest else f"({one.load})"
        yield f"    {one.name:<{name}}{load:>8}{S:>8}{pull_off:>9}  {why or one.key}".rstrip()


# --------------------------------------------------------------------------------------------------
# What of jkr works on this machine: packages and the mesher's libraries.

REQUIRED = ("numpy", "scipy", "h5py", "click", "pydantic", "tomli-w", "matplotlib", "threadpoolctl", "psutil")
OPTIONAL = {  # package: extra, use
    "scikit-fem": ("", "finite elements"),
    "meshio": ("", "meshes and fields for ParaView"),
    "cvxopt": ("fast", "a faster sparse factorisation"),
    "afmformats": ("afm", "AFM vendors' files"),
    "distributed": ("cluster", "sweeps on a Dask cluster"),
    "pandas": ("pandas", "curves as data frames"),
    "plotly": ("explore", "the explorer page"),
}
MARKS = {"ok": "ok      ", "optional": "optional", "missing": "MISSING "}


@dataclass(frozen=True)
class Finding:
    """One thing looked at; ``remedy``: what to type where it is not ok."""

    part: str
    state: Literal["ok", "optional", "missing"]
    found: str
    remedy: str = ""


@dataclass(frozen=True)
class Machine(Result):
    """What was looked at; it ``is_sound`` where everything required works."""

    findings: Sequence[Finding]

    @classmethod
    def examined(cls) -> Machine:
        """This machine: everything that is worth looking at, in the order of a report."""
        python = Finding("Python", "ok", f"{platform.python_version()} on {platform.platform(terse=True)}")
        mesher = offered("the mesher")
        optional = (_package(package, extra, f" ({use})") for package, (extra, use) in OPTIONAL.items())
        return cls([python, *map(_package, REQUIRED), *([] if mesher is None else [mesher()]), *optional])

    @property
    def is_sound(self) -> bool:
        return all(finding.state != "missing" for finding in self.findings)

    def summary(self) -> dict[str, Any]:
        return {"jkr": __version__, "sound": self.is_sound, "findings": [asdict(finding) for finding in self.findings]}

    def words(self) -> list[str]:
        works = sum(finding.state == "ok" for finding in self.findings)
        sound = "is sound" if self.is_sound else "is NOT sound"
        lines = [f"{works} of {len(self.findings)} parts work; jkr {__version__} {sound}"]
        for finding in sorted(self.findings, key=lambda finding: finding.state == "ok"):  # what lacks first
            remedy = f"; type: {finding.remedy}" if finding.remedy else ""
            lines.append(f"  {MARKS[finding.state]}  {finding.part:<16} {finding.found}{remedy}")
        return lines


def _package(package: str, extra: str = "", use: str = "") -> Finding:
    """A package, of an ``extra``; one with a ``use`` is optional."""
    try:
        return Finding(package, "ok", f"{version(package)}{use}")
    except PackageNotFoundError:
        return Finding(package, "optional" if use else "missing", f"not installed{use}", installs(extra))
