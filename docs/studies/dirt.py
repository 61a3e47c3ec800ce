"""What fits make of force curves with 24 kinds of dirt, and of clean ones: ``make dirt SEED=7``.

Records by a generator of the tests that shares no code with what reads them, written to files and read with default
options. Per kind: how many are refused, *fitted* (without a flag), of which each of E*, w and w_approach lies in its
95 % interval, widened by the model's part; of the others, how many name a right reason; *silent*: fitted, and more than
three half-widths and 1 % off; the half-width with the model's part over the statistical one, in the median.
"""

from __future__ import annotations

import math
import sys
import tempfile
import time
from collections import defaultdict
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from dirty_records import Dirty, plain  # type: ignore[import-not-found]

from jkrcli.adhesion.slopes import slopes
from jkrcli.base.errors import InputError, JkrError
from jkrcli.bodies.indenters import Paraboloid
from jkrcli.bodies.problem import Elastic, HalfSpace, Loading, Problem, Specimen
from jkrcli.measured.archive import FITTED, status_of
from jkrcli.measured.curve import Reading
from jkrcli.measured.files import read
from jkrcli.measured.forward_model import FittedBody
from jkrcli.measured.procedure import fit
from jkrcli.measured.result import Fit
from jkrcli.measured.settings import settings_of
from jkrcli.methods.layered.solver import Layered

from .dirt_records import KINDS

FAR = 3.0  # half-widths, and 1 % of the truth, beyond which an answer without a flag is silently wrong
GOOD = 10  # clean records for each dirty one of a kind


@dataclass(frozen=True)
class Answer:
    """What came of a record: ``off``: (value - truth)/half-width by name, ``silent``, ``ratio`` of half-widths."""

    status: str
    words: str
    inside: dict[str, bool]
    silent: bool
    ratio: float
    off: dict[str, str]


def body(R: float) -> FittedBody:
    problem = Problem(Paraboloid(R), Specimen((), HalfSpace(Elastic(0.75e4, 0.5))), Loading("radius", 0.2 * R, 60))
    series = Layered()(problem).series
    return FittedBody.of(problem, series, slopes(series), extensible=True)


def answer(made: Dirty, folder: Path) -> Answer:
    file = folder / "record.txt"
    made.write(file)
    try:
        (curve,) = read(file, Reading(stiffness=math.inf) if made.rigid else Reading())
        found = fit(body(made.at.R), curve, settings_of(body(made.at.R), **made.options))
    except JkrError as error:
        return Answer("refused", " ".join(error.lines if isinstance(error, InputError) else [str(error)]), {}, False,
                      math.nan, {})  # fmt: skip
    return judged(made, found)


def judged(made: Dirty, found: Fit) -> Answer:
    status = "fitted" if status_of(found) == FITTED else "flagged"
    inside, off, silent, ratios = dict[str, bool](), dict[str, str](), False, []
    for name, true in made.truth.items():
        item = next((one for one in found.estimates if one.name == name), None)
        if item is None or item.low is None or item.high is None or item.error is None:
            continue
        part = math.hypot(*(item.model or {}).values())
        inside[name] = item.low - part <= true <= item.high + part
        half = (item.high - item.low) / 2 + part
        silent |= status == "fitted" and not abs(item.value - true) <= max(FAR * half, 0.01 * true)
        ratios.append(2 * half / max(item.high - item.low, 1e-300))
        off[name] = f"{name} {item.value / true - 1:+.1%} ± {half / true:.1%}"
    words = " | ".join([*found.flags, *found.warnings, *found.held])
    return Answer(status, words, inside, silent, float(np.median(ratios)) if ratios else math.nan, off)


def main(seed: int, count: int, only: str = "", verbose: bool = False) -> None:
    totals: dict[str, list[float]] = defaultdict(list)
    begin = time.process_time()
    with tempfile.TemporaryDirectory() as folder:
        for number, (kind, make) in enumerate({"good": plain, **KINDS}.items()):
            if only and only not in kind:
                continue
            many = GOOD * count if kind == "good" else count
            made = [make(np.random.default_rng((seed, number, i))) for i in range(many)]
            answers = [answer(one, Path(folder)) for one in made]
            _line(kind, made, answers, verbose)
            for one, ends in zip(made, answers, strict=True):
                if kind == "good":
                    totals["accused"].append(ends.status != "fitted")
                    continue
                totals["silent"].append(ends.silent)
                if one.determined:
                    totals["fitted"].append(ends.status == "fitted")
                if ends.status == "fitted":
                    totals["ratio"].append(ends.ratio)
                    for name, value in ends.inside.items():
                        totals[f"{name} inside"].append(value)
    shown = {name: f"{np.sum(values):.0f} of {len(values)}" for name, values in totals.items()}
    shown["ratio"] = f"{np.median(totals['ratio'] or [math.nan]):.2f}"
    print(", ".join(f"{name} {value}" for name, value in shown.items()))
    print(f"CPU seconds {time.process_time() - begin:.0f}")


def _line(kind: str, made: list[Dirty], answers: list[Answer], verbose: bool) -> None:
    fitted = [one for one in answers if one.status == "fitted"]
    inside = defaultdict(list)
    for one in fitted:
        for name, value in one.inside.items():
            inside[name].append(value)
    shares = ", ".join(f"{name} {sum(values)}/{len(values)}" for name, values in inside.items())
    others = [(one, ends) for one, ends in zip(made, answers, strict=True) if ends.status != "fitted"]
    right = sum(any(word in ends.words for word in one.reasons) for one, ends in others)
    refused = sum(one.status == "refused" for one in answers)
    ratio, silent = np.median([one.ratio for one in fitted] or [math.nan]), sum(one.silent for one in answers)
    print(
        f"{kind:<20} fitted {len(fitted):3d} of {len(answers)}, inside {shares or '-'}, ratio {ratio:.2f}; refused "
        f"{refused}, right reason {right} of {len(others)}; silent {silent}", flush=True,
    )  # fmt: skip
    for i, one in enumerate(answers):
        if one.silent or one.status == "refused" or (one.status == "flagged" and verbose):
            what = "SILENT" if one.silent else one.status
            print(f"    {i} {what}: {', '.join(one.off.values())} {one.words[:300]}", flush=True)


if __name__ == "__main__":
    words = [text for text in sys.argv[1:] if text != "-v"]
    main(int(words[0]), int(words[1]), "".join(words[2:3]), "-v" in sys.argv)
