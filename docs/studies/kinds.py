"""Count what fits make of force curves of 26 kinds, and of clean ones: ``make kinds SEED=7``.

Records by ``kinds_records``, which shares no code with what reads them, written to files and fitted with default
options by the body that their user knows. Per kind: how many are *fitted* (graded good or usable) and refused; of
which E*, w and w_approach lie within half of the 95 % interval and the model's part together; *silent*: fitted, and off
by more than three such half-widths; the model's part over the value in the median, large strains apart; CPU seconds a
record. E* is not asked for where it cannot be known (permanent set, sensitivity, hysteresis, hold), nor w without a
pull-off. Of clean ones those that are not fitted are *accused*.
"""

from __future__ import annotations

import argparse
import json
import math
import os
import tempfile
import time
from collections import defaultdict
from collections.abc import Mapping
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, field, replace
from multiprocessing import get_context
from pathlib import Path
from typing import Any
from zlib import crc32

import numpy as np

from jkrcli.adhesion.slopes import slopes
from jkrcli.base.errors import InputError, JkrError
from jkrcli.bodies.indenters import Paraboloid, Sphere
from jkrcli.bodies.problem import Elastic, HalfSpace, Layer, Loading, Problem, Rigid, Specimen
from jkrcli.measured import priors
from jkrcli.measured.archive import FITTED, status_of
from jkrcli.measured.curve import Reading
from jkrcli.measured.files import read
from jkrcli.measured.forward_model import FittedBody
from jkrcli.measured.procedure import fit
from jkrcli.measured.settings import settings_of
from jkrcli.methods.layered.solver import Layered

from .kinds_records import KINDS, Made, clean, identities

THIRD = 1 / 3  # of a half-width, that other widths of priors may move a result by
FAR = 3.0  # half-widths beyond which an answer without a flag is silently wrong
CLEAN, MORE = "clean, wide", 10  # the kind that is judged as clean, as many for each of another kind unless told
RIGHT = (CLEAN, "clean")  # kinds without dirt, where a flag accuses
STRAINS = "large strains"  # a part of the model that depends on the depth, not on what is in a record
ASKED = ("E_star", "w", "w_approach")
LONGEST = 400  # characters shown of what a fit says


@dataclass(frozen=True)
class Told:
    """What a fit says of a quantity [SI]: its value, ``half`` of the interval, ``model``: the model's parts, and of
    these ``varied`` without large strains; the ``truth``."""

    value: float
    half: float
    model: float
    varied: float
    truth: float

    @property
    def off(self) -> float:
        """The error in half-widths."""
        return abs(self.value - self.truth) / max(self.half + self.model, 1e-300)

    @property
    def varied_share(self) -> float:
        """The model's parts over the value, large strains apart."""
        return self.varied / max(abs(self.value), 1e-300)

    def __str__(self) -> str:
        return (f"{self.value:.4g} for {self.truth:.4g} ({self.value / self.truth - 1:+.2%}) ± {self.half:.2g} ± "
                f"{self.model:.2g}, {self.off:.1f} half-widths")  # fmt: skip


@dataclass(frozen=True)
class Answer:
    """What came of a record, ``about`` which: ``status`` "fitted", "flagged" or "refused", all that was said in
    ``words``, what was ``told`` of each quantity that was asked for, those ``missing``, CPU ``seconds``."""

    status: str
    words: str
    seconds: float
    about: str = ""
    told: Mapping[str, Told] = field(default_factory=dict)
    missing: tuple[str, ...] = ()

    @property
    def silent(self) -> bool:
        return self.status == "fitted" and any(one.off > FAR for one in self.told.values())


def body(made: Made) -> FittedBody:
    """Build what the user of a record knows: tip, thickness and Poisson's ratio; E* is looked for."""
    contact = made.at.contact
    material = Elastic((1 - contact.nu**2) * 1e4, contact.nu)
    specimen = Specimen((), HalfSpace(material))
    if contact.h is not None:
        specimen = Specimen((Layer(material, contact.h),), Rigid())
    R = contact.tip.R
    problem = Problem(Sphere(R) if contact.tip.sphere else Paraboloid(R), specimen, Loading("radius", 0.2 * R, 60))
    series = Layered()(problem).series
    return replace(FittedBody.of(problem, series, slopes(series), extensible=True), moduli_known=False)


def drawn(kind: str, seed: int, i: int) -> Made:
    """Make record ``i`` of a kind."""
    make = {CLEAN: clean, **KINDS}[kind]
    return make(np.random.default_rng((seed, crc32(kind.encode()), i)))


def judged(made: Made, file: Path) -> Answer:
    """Write a record to ``file``, fit it, and compare with its truth."""
    made.write(file)
    held = body(made)
    begin = time.process_time()
    try:
        (curve,) = read(file, Reading(contact="as-is"))
        options: dict[str, Any] = dict(made.options)
        found = fit(held, curve, settings_of(held, **options))
    except JkrError as error:
        lines = error.lines if isinstance(error, InputError) else (str(error),)
        return Answer("refused", " ".join(lines), time.process_time() - begin, made.at.words)
    seconds = time.process_time() - begin
    told, estimates = dict[str, Told](), {item.name: item for item in found.estimates}
    for name, truth in made.truth.items():
        item = estimates.get(name)
        if item is not None and item.low is not None and item.high is not None:
            parts = dict(item.model or {})
            varied = math.hypot(*(part for key, part in parts.items() if key != STRAINS))
            told[name] = Told(item.value, (item.high - item.low) / 2, math.hypot(*parts.values()), varied, truth)
    words = " | ".join([*found.flags, *found.warnings, *found.held])
    missing = tuple(name for name in made.truth if name not in told)
    return Answer("fitted" if status_of(found) == FITTED else "flagged", words, seconds, made.at.words, told, missing)


def answer(kind: str, seed: int, i: int) -> Answer:
    """Judge record ``i`` of a kind, in a folder that does not remain."""
    with tempfile.TemporaryDirectory() as folder:
        return judged(drawn(kind, seed, i), Path(folder) / "record.txt")


def moved(kind: str, seed: int, i: int, widths: float) -> dict[str, float]:
    """Tell by how much what is told of record ``i`` moves, over its half-width, with all widths of priors ``widths``
    times as large."""
    found = []
    for priors.WIDTHS in (widths, 1.0):
        found.append(answer(kind, seed, i).told)
    other, told = found
    return {name: abs(other[name].value - one.value) / (one.half + one.model)
            for name, one in told.items() if name in other}  # fmt: skip


# --------------------------------------------------------------------------------------------------
# What is printed.


def inside(answers: list[Answer], name: str, alone: bool = False) -> list[bool]:
    """Tell of each answer that states a quantity whether the truth is within its half-width; ``alone``: without the
    model's part."""
    told = [one.told[name] for one in answers if name in one.told]
    return [(abs(one.value - one.truth) <= one.half) if alone else one.off <= 1 for one in told]


def coverage(answers: list[Answer], alone: bool = False) -> str:
    shares = {name: inside(answers, name, alone) for name in ASKED}
    return " ".join(f"{name} {f'{sum(held)}/{len(held)}' if held else '-':<7}" for name, held in shares.items())


def line(kind: str, answers: list[Answer]) -> str:
    """Summarise a kind."""
    many = {status: sum(one.status == status for one in answers) for status in ("fitted", "flagged", "refused")}
    parts = []
    for name in ASKED[:2]:
        told = [one.told[name] for one in answers if name in one.told]
        parts.append(f"{np.median([one.varied_share for one in told]):6.2%}" if told else f"{'-':>6}")
    missing, silent = sum(len(one.missing) for one in answers), sum(one.silent for one in answers)
    return (f"{kind:<23} fitted {many['fitted']:3d} flagged {many['flagged']:3d} refused {many['refused']:2d} of "
            f"{len(answers):3d}; inside {coverage(answers)} not told {missing}; silent {silent}; model part E* "
            f"{parts[0]} w {parts[1]}; {np.mean([one.seconds for one in answers]):.2f} s")  # fmt: skip


def remarks(answers: list[Answer], right: bool = False) -> list[str]:
    """Describe each record that is silent, has a quantity outside, or is refused, of ``right`` ones with a flag too."""
    lines = []
    for i, one in enumerate(answers):
        outside = any(told.off > 1 for told in one.told.values())
        if one.silent or outside or one.status == "refused" or (right and one.status == "flagged"):
            what = "SILENT" if one.silent else f"{one.status}{', outside' * outside}"
            told = "; ".join(f"{name} {item}" for name, item in one.told.items())
            lines.append(f"    {i} {what}: {told}; {one.about}: {one.words[:LONGEST]}")
    return lines


def moves(kind: str, each: list[dict[str, float]]) -> str:
    """Summarise by how much a kind moves, and which records do by more than a third."""
    parts = [f"{kind:<23}"]
    for name in ASKED:
        shares = {i: one[name] for i, one in enumerate(each) if name in one}
        if shares:
            beyond = ", ".join(f"{i}: {share:.2f}" for i, share in shares.items() if share > THIRD)
            parts.append(
                f"{name} at most {max(shares.values()):.3f} of {len(shares)}{f' ({beyond})' if beyond else ''}"
            )
    return " ".join(parts)


def totals(found: Mapping[str, list[Answer]]) -> list[str]:
    """Summarise all kinds, and the clean ones apart."""
    dirty = {kind: answers for kind, answers in found.items() if kind != CLEAN}
    lines = []
    for title, kinds in (("the kinds", dirty), (CLEAN, {CLEAN: found.get(CLEAN, [])})):
        answers = [one for several in kinds.values() for one in several]
        if answers:
            silent = sum(one.silent for one in answers)
            lines.append(f"{title}: {len(answers)} records, inside {coverage(answers)}; silent {silent}")
            fitted = [one for one in answers if one.status == "fitted"]
            lines.append(
                f"    fitted: {len(fitted)}, inside {coverage(fitted)}; by the interval alone {coverage(fitted, True)}"
            )
    lowest = []
    for name in ASKED:
        shares = {kind: float(np.mean(inside(several, name))) for kind, several in dirty.items()
                  if inside(several, name)}  # fmt: skip
        if shares:
            kind = min(shares, key=lambda one: shares[one])
            lowest.append(f"{name} {shares[kind]:.0%} of {kind}")
    accused = [one.status != "fitted" for kind in RIGHT for one in found.get(kind, [])]
    lines += [f"lowest: {', '.join(lowest)}"] if lowest else []
    lines += [f"accused: {sum(accused)} of {len(accused)} clean ones"] if accused else []
    answers = [one for several in found.values() for one in several]
    spent = sum(one.seconds for one in answers)
    return [*lines, f"CPU seconds {spent:.0f}, {spent / max(len(answers), 1):.2f} a record"]


# --------------------------------------------------------------------------------------------------
# What is run.


def write(folder: Path, counts: Mapping[str, int], seed: int) -> None:
    """Write the records, and in meta.json what is typed after ``jkr fit FILE`` and what is true."""
    folder.mkdir(parents=True, exist_ok=True)
    entries = []
    for kind, count in counts.items():
        for i in range(count):
            made = drawn(kind, seed, i)
            name = "".join(c if c.isalnum() else "-" for c in kind)
            file = folder / f"{name}-{i:03d}.txt"
            made.write(file)
            entries.append({"file": file.name, "kind": kind, "options": made.typed, "truth": made.truth})
    (folder / "meta.json").write_text(json.dumps(entries, indent=1) + "\n", encoding="utf-8")


def verify() -> bool:
    """Print identities of the mechanics; whether all hold."""
    all_hold = True
    for name, found, expected, allowed in identities():
        holds = abs(found / expected - 1) < allowed
        all_hold &= holds
        print(f"{name:<50} {found:12.6g} {expected:12.6g} {found / expected - 1:+.1e}{'' if holds else '  WRONG'}")
    return all_hold


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("seed", type=int, nargs="?", default=1)
    parser.add_argument("count", type=int, nargs="?", default=20, help="records of each kind")
    parser.add_argument("--clean", type=int, help=f"clean records of a wide range [default: {MORE} times count]")
    parser.add_argument("--only", default="", help="kinds that contain this")
    parser.add_argument("--write", type=Path, help="write records and meta.json into this folder, fit none")
    parser.add_argument("--verify", action="store_true", help="check identities of the mechanics, fit none")
    parser.add_argument("--widths", type=float, help="tell instead what widths of priors so many times as large move")
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("-v", "--verbose", action="store_true", help="also a line for each that is off or refused")
    asked = parser.parse_args()
    if asked.verify:
        raise SystemExit(0 if verify() else 1)
    many = MORE * asked.count if asked.clean is None else asked.clean
    counts = {kind: many if kind == CLEAN else asked.count for kind in (CLEAN, *KINDS) if asked.only in kind}
    if asked.write:
        write(asked.write, counts, asked.seed)
        return
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    found = {}
    with ProcessPoolExecutor(asked.workers, get_context("forkserver")) as pool:
        for kind, count in counts.items() if asked.widths else ():
            several = [pool.submit(moved, kind, asked.seed, i, asked.widths) for i in range(count)]
            print(moves(kind, [one.result() for one in several]), flush=True)
        if asked.widths:
            return
        waiting = defaultdict(list)
        for kind, count in counts.items():
            waiting[kind] = [pool.submit(answer, kind, asked.seed, i) for i in range(count)]
        for kind, futures in waiting.items():
            found[kind] = [one.result() for one in futures]
            lines = [line(kind, found[kind])] if found[kind] else []
            print("\n".join([*lines, *(remarks(found[kind], kind in RIGHT) if asked.verbose else [])]), flush=True)
    print("\n".join(totals(found)))


if __name__ == "__main__":
    main()
