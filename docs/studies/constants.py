"""The study of chosen numbers: which results move when one of them is halved or doubled.

Every algorithm keeps its numbers in one frozen dataclass, a module's constant whose name ends in TUNING; numbers that
several share stand alone. Each whose comment says what is asked for ("choice" where nothing is) is varied, one at a
time: fields for the results that read them, numbers that stand alone for the cheapest of all results.
A number of a result moves where it changes by more than a tenth of its stated error, or by 1e-9 where none is stated.
"""

from __future__ import annotations

import contextlib
import functools
import gc
import importlib
import inspect
import itertools
import math
import pkgutil
import re
import sys
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import jkrcli
from jkrcli.base.executors import completed

from .command import call, output_of, parser_of, pool_of
from .constants_results import RESULTS, Numbers
from .tuning import Knob, knobs
from .watchdog import TooSlowError, cpu_limit

WITHOUT = ("__main__",)  # rooms that hold no numbers
VERDICTS = ("moves", "refuses", "nothing moves", "not read")


@dataclass(frozen=True)
class ConstantsTuning:
    """When a number counts as moved."""

    share: float = 0.1  # choice: of the stated error
    rounding: float = 1e-9  # choice: relative, where no error is stated
    longest: float = 60.0  # choice: CPU seconds of a result with a number varied
    all: float = 1.0  # choice: CPU seconds of the results that are looked at, the cheapest that read it
    alone: float = 5.0  # choice: the same of a number that stands alone, which any may read
    seconds: float = 3.0  # choice: CPU seconds of a varied number, for the number of processes


TUNING = ConstantsTuning()


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
    """Numbers, CPU seconds and the tunings that are read, of all results with the numbers as shipped."""

    numbers: dict[str, Numbers] = field(default_factory=dict)
    seconds: dict[str, float] = field(default_factory=dict)
    read: dict[str, set[tuple[str, str]]] = field(default_factory=dict)


def shipped() -> Shipped:
    """Each result once, in this process, with the tunings that it reads; nothing computed before is used."""
    global SHIPPED
    if SHIPPED is None:
        SHIPPED = _shipped()
    return SHIPPED


def _shipped() -> Shipped:
    found = Shipped()
    for name, make in RESULTS.items():
        forget()
        with _watched() as seen:
            start = time.process_time()
            found.numbers[name] = make()
            found.seconds[name] = time.process_time() - start
        found.read[name] = seen
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
                    with cpu_limit(TUNING.longest):
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
    alone, most = (True, TUNING.alone) if knob.name == knob.field else (False, TUNING.all)
    names = [name for name, seen in usual.read.items() if alone or (knob.module, knob.field) in seen]
    names.sort(key=lambda name: usual.seconds[name])
    spent = itertools.accumulate(usual.seconds[name] for name in names)
    return tuple(name for i, (name, so_far) in enumerate(zip(names, spent, strict=True)) if not i or so_far < most)


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
    allowed = max(TUNING.share * error, TUNING.rounding * abs(x))
    return abs(y - x) / allowed if allowed and math.isfinite(x) and math.isfinite(y) else math.inf


def forget() -> None:
    """Clear every memory of what was computed."""
    for item in _memories():
        item.cache_clear()


SHIPPED: Shipped | None = None  # of this process


@functools.cache
def _memories() -> list[Any]:
    """The caches of all modules, each of which is loaded for it."""
    for module in pkgutil.walk_packages(jkrcli.__path__, "jkrcli."):
        if not module.name.endswith("__main__"):
            importlib.import_module(module.name)
    caches = [item for item in gc.get_objects() if isinstance(item, functools._lru_cache_wrapper)]
    return [item for item in caches if item.__module__ != __name__]


@contextlib.contextmanager
def varied(knob: Knob, value: float) -> Iterator[None]:
    """The tuning itself with ``value`` at ``knob``; nothing computed before, or with it, is used."""
    for holder in (holders := _holders(knob)):
        object.__setattr__(holder, knob.field, value)
    forget()
    try:
        yield
    finally:
        for holder in holders:
            object.__setattr__(holder, knob.field, knob.shipped)
        forget()


def _holders(knob: Knob) -> list[Any]:
    """The set of tunings of a field; of a number that stands alone all modules that know it."""
    module = importlib.import_module(knob.module)
    if knob.name != knob.field:
        return [getattr(module, knob.name)]
    loaded = [item for name, item in list(sys.modules.items()) if name.startswith("jkrcli.")]
    return [item for item in loaded if vars(item).get(knob.name) == knob.shipped]


def alone(asked: Sequence[str], says: str) -> list[Knob]:
    """All numbers that stand alone in modules, as ``knobs`` has those in sets."""
    found = []
    for item in pkgutil.walk_packages(jkrcli.__path__, "jkrcli."):
        if item.name.split(".")[1] in WITHOUT or (
            asked and not any(word.replace("-", "_") in item.name for word in asked)
        ):
            continue
        module = importlib.import_module(item.name)
        told = re.findall(r"^([A-Z][A-Z_]*) = [^#\n]*#(.*)$", inspect.getsource(module), re.MULTILINE)
        found += [Knob(item.name, name, name, getattr(module, name)) for name, words in told if re.search(says, words)]
    return [knob for knob in found if type(knob.shipped) in (int, float)]


@contextlib.contextmanager
def _watched() -> Iterator[set[tuple[str, str]]]:
    """The modules and fields of tunings that are read meanwhile."""
    seen: set[tuple[str, str]] = set()
    loaded = [vars(module) for name, module in list(sys.modules.items()) if name.startswith("jkrcli.")]
    held = {id(item): item for names in loaded for name, item in names.items() if name.endswith("TUNING")}
    usual = [(item, type(item)) for item in held.values()]
    for item, cls in usual:
        object.__setattr__(item, "__class__", type(cls.__name__, (cls,), {"__getattribute__": _telling(cls, seen)}))
    try:
        yield seen
    finally:
        for item, cls in usual:
            object.__setattr__(item, "__class__", cls)


def _telling(cls: type, seen: set[tuple[str, str]]) -> Callable[[Any, str], Any]:
    def told(self: Any, name: str) -> Any:
        seen.add((cls.__module__, name))
        return object.__getattribute__(self, name)

    return told


def table(found: Sequence[Moved]) -> dict[str, list[Any]]:
    """A row per number."""
    rows: list[Mapping[str, Any]] = [
        {
            "algorithm": item.knob.module.removeprefix("jkrcli."),
            "field": item.knob.field,
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
    every = [*knobs(given.algorithms, given.says, WITHOUT), *alone(given.algorithms, given.says)]
    found: list[Moved] = []
    with pool_of(given, TUNING.seconds * len(every)) as pool:
        for _, item in completed(pool, moved, every, "constants"):
            if isinstance(item, Exception):
                raise item
            found.append(item)
            name = f"{item.knob.module.removeprefix('jkrcli.')}.{item.knob.field}"
            print(
                f"{name:<52}{item.knob.shipped!s:>10}  {item.verdict:<14}{item.change:>10.2g}  {item.where}", flush=True
            )
    files.write(table(found))
    print(", ".join(f"{verdict}: {sum(item.verdict == verdict for item in found)}" for verdict in VERDICTS))
    return 0


if __name__ == "__main__":
    sys.exit(call(main))
