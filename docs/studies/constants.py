"""The study of chosen numbers: which results move when one of them is halved or doubled.

Every algorithm keeps its numbers as constants of its module. Each whose comment says what is asked for ("choice" where
nothing is) is varied, one at a time, for the cheapest of the results that read it.
A number of a result moves where it changes by more than a tenth of its stated error, or by 1e-9 where none is stated.
"""

from __future__ import annotations

import itertools
import math
import sys
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from types import CodeType, FrameType
from typing import Any

from jkrcli.base.executors import completed

from .command import call, output_of, parser_of, pool_of
from .constants_results import RESULTS, Numbers
from .tuning import Knob, forget, knobs, varied
from .watchdog import TooSlowError, cpu_limit

WITHOUT = ("__main__",)  # rooms that hold no numbers
VERDICTS = ("moves", "refuses", "nothing moves", "not read")

# When a number counts as moved.
CONSTANTS_SHARE = 0.1  # choice: of the stated error
CONSTANTS_ROUNDING = 1e-9  # choice: relative, where no error is stated
CONSTANTS_LONGEST = 60.0  # choice: CPU seconds of a result with a number varied
CONSTANTS_ALL = 1.0  # choice: CPU seconds of the results that are looked at, the cheapest that read it
CONSTANTS_SECONDS = 3.0  # choice: CPU seconds of a varied number, for the number of processes


@dataclass(frozen=True)
class Moved:
    """What varying ``knob`` does to results: the largest change over what does not count as one, where; which results
    ``refused``; CPU seconds over those of the shipped value."""

    knob: Knob
    read: tuple[str, ...]
    change: float = 0.0
    where: str = ""
    refused: tuple[str, ...] = ()
    cost: tuple[float, ...] = ()

    @property
    def verdict(self) -> str:
        if not self.read:
            return "not read"
        if self.change > 1:
            return "moves"
        return "refuses" if self.refused else "nothing moves"


@dataclass
class Shipped:
    """Numbers, CPU seconds and the names of constants that are read, of all results with the constants as shipped."""

    numbers: dict[str, Numbers] = field(default_factory=dict)
    seconds: dict[str, float] = field(default_factory=dict)
    read: dict[str, set[str]] = field(default_factory=dict)


def shipped() -> Shipped:
    """Each result once, in this process, with the names of the constants that it reads; nothing computed before is
    used."""
    global SHIPPED
    if SHIPPED is None:
        SHIPPED = _shipped()
    return SHIPPED


def _shipped() -> Shipped:
    found = Shipped()
    for name, make in RESULTS.items():
        forget()
        found.read[name] = _names_read(make)
        forget()
        start = time.process_time()
        found.numbers[name] = make()
        found.seconds[name] = time.process_time() - start
    return found


def moved(knob: Knob) -> Moved:
    """What halving and doubling a number does to all results that read it."""
    usual = shipped()
    names = readers(knob)
    largest, where, refused, cost = 0.0, "", [], []
    for value in knob.values:
        spent = 0.0
        for name in names:
            with varied(knob, value):
                start = time.process_time()
                try:
                    with cpu_limit(CONSTANTS_LONGEST):
                        numbers = RESULTS[name]()
                except (Exception, TooSlowError) as error:
                    refused.append(f"{name} with {value:g}: {type(error).__name__} {error}".splitlines()[0])
                    continue
                finally:
                    spent += time.process_time() - start
            change, what = farthest(usual.numbers[name], numbers)
            if change > largest:
                largest, where = change, f"{name}: {what} with {value:g}"
        cost.append(spent / (sum(usual.seconds[name] for name in names) or 1.0))
    return Moved(knob, names, largest, where, tuple(refused), tuple(cost))


def readers(knob: Knob) -> tuple[str, ...]:
    """The results that read a number: the cheapest of them, within a limit of time."""
    usual = shipped()
    names = [name for name, seen in usual.read.items() if knob.name in seen]
    names.sort(key=lambda name: usual.seconds[name])
    spent = itertools.accumulate(usual.seconds[name] for name in names)
    return tuple(
        name for i, (name, so_far) in enumerate(zip(names, spent, strict=True)) if not i or so_far < CONSTANTS_ALL
    )


def farthest(before: Numbers, after: Numbers) -> tuple[float, str]:
    """The largest change of a number over what does not count, and its name; infinite where one comes or goes."""
    if lost := before.keys() ^ after.keys():
        return math.inf, f"{sorted(lost)[0]} comes or goes"
    changes = [(_change(before[name], after[name]), name) for name in before]
    return max(changes, default=(0.0, ""))


def _change(before: tuple[float, float], after: tuple[float, float]) -> float:
    (x, error), (y, _) = before, after
    if x == y or (math.isnan(x) and math.isnan(y)):
        return 0.0
    allowed = max(CONSTANTS_SHARE * error, CONSTANTS_ROUNDING * abs(x))
    return abs(y - x) / allowed if allowed and math.isfinite(x) and math.isfinite(y) else math.inf


SHIPPED: Shipped | None = None  # of this process


def _names_read(make: Callable[[], Any]) -> set[str]:
    """Names in the code of the package that runs meanwhile, those of the constants it reads among them."""
    ran: set[CodeType] = set()

    def called(frame: FrameType, event: str, _: Any) -> None:
        if event == "call" and frame.f_globals.get("__name__", "").startswith("jkrcli."):
            ran.add(frame.f_code)

    usual = sys.getprofile()
    sys.setprofile(called)
    try:
        make()
    finally:
        sys.setprofile(usual)
    return {name for code in ran for name in code.co_names}


def table(found: Sequence[Moved]) -> dict[str, list[Any]]:
    """A row per number."""
    rows: list[Mapping[str, Any]] = [
        {
            "algorithm": item.knob.module.removeprefix("jkrcli."),
            "constant": item.knob.name,
            "shipped": item.knob.shipped,
            "verdict": item.verdict,
            "change_over_allowed": item.change,
            "where": item.where,
            "cost_halved": item.cost[0] if item.cost else "",
            "cost_doubled": item.cost[-1] if item.cost else "",
            "refused": "; ".join(item.refused),
            "read_by": len(item.read),
        }
        for item in found
    ]
    return {name: [row[name] for row in rows] for name in (rows[0] if rows else ("algorithm",))}


def main(words: Sequence[str] | None = None) -> int:
    """Halve and double every chosen number, and tell which results move, and what it costs.

    Writes constants.csv and prints a line per number; ten minutes for all on two cores.
    """
    parser = parser_of(str(main.__doc__))
    parser.add_argument("algorithms", nargs="*", help="parts of modules' names, such as hybrid [default: all]")
    parser.add_argument(
        "--says", default="choice:|make constants", help="pattern of its comment [default: chosen or tuned here]"
    )
    given = parser.parse_args(words)
    files = output_of(given).files(given.output / "constants", (".csv",))
    every = knobs(given.algorithms, given.says, WITHOUT)
    found: list[Moved] = []
    with pool_of(given, CONSTANTS_SECONDS * len(every)) as pool:
        for _, item in completed(pool, moved, every, "constants"):
            if isinstance(item, Exception):
                raise item
            found.append(item)
            name = f"{item.knob.module.removeprefix('jkrcli.')}.{item.knob.name}"
            print(
                f"{name:<52}{item.knob.shipped!s:>10}  {item.verdict:<14}{item.change:>10.2g}  {item.where}", flush=True
            )
    files.write(table(found))
    print(", ".join(f"{verdict}: {sum(item.verdict == verdict for item in found)}" for verdict in VERDICTS))
    return 0


if __name__ == "__main__":
    sys.exit(call(main))
