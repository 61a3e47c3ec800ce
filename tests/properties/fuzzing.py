"""What every input must come to, and how wrong inputs are made from valid ones."""

import contextlib
import copy
import datetime
import io
import json
import random
import re
import resource
import signal
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import hypothesis.strategies as st
import pytest
from hypothesis import HealthCheck, Phase, given, seed, settings

from jkrcli.cli import call

CPU_SECONDS = 100.0  # for one input: a hang ends as a failure; usual are milliseconds, the largest stacks take 30 s
MEMORY = 1 << 30  # bytes of address space that a whole kind of inputs may add


class HangError(BaseException):
    """Not an Exception, so that nothing below takes it for a mistake of the user."""


@contextlib.contextmanager
def bounded(seconds: float = CPU_SECONDS) -> Iterator[None]:
    """CPU time of the block limited; works in the main thread, where pytest runs tests."""

    def hang(*_: object) -> None:
        raise HangError(f"one input took more than {seconds:g} CPU seconds")

    before = signal.signal(signal.SIGVTALRM, hang)
    signal.setitimer(signal.ITIMER_VIRTUAL, seconds)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_VIRTUAL, 0)
        signal.signal(signal.SIGVTALRM, before)


@contextlib.contextmanager
def address_space() -> Iterator[None]:
    """Memory of the block limited: what asks for more meets a MemoryError."""
    soft, hard = resource.getrlimit(resource.RLIMIT_AS)
    pages = int(Path("/proc/self/statm").read_text(encoding="ascii").split()[0])
    resource.setrlimit(resource.RLIMIT_AS, (pages * resource.getpagesize() + MEMORY, hard))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_AS, (soft, hard))


def outcome(*words: object, json_out: bool = False) -> int:
    """Run ``jkr`` in this process and demand a result, or one line per mistake; returns the exit code."""
    out, err = io.StringIO(), io.StringIO()
    with bounded(), contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        code = call([str(word) for word in words])
    said = err.getvalue()
    lines = said.split("\n")[:-1] if said else []
    assert code in (0, 1, 2), said
    assert all(line.startswith("jkr: ") and line.isprintable() for line in lines), said
    differ = words[0] == "compare" and code == 1  # as its help says: no mistake
    assert (code != 0) == any(line.startswith("jkr: error: ") for line in lines) or differ, said
    assert "out of memory" not in said, said
    if code == 0 and json_out:
        json.loads(out.getvalue(), parse_constant=_no_constant)
    return code


def _no_constant(name: str) -> None:
    raise AssertionError(f"{name} in the output")


def fuzz(inputs: st.SearchStrategy[Any], judge: Callable[[Any], None], examples: int, start: int) -> None:
    sys.stdout.write(f"seed {start}\n")  # pytest shows it with a failure

    @seed(start)
    @settings(
        max_examples=examples,
        deadline=None,
        database=None,
        phases=[Phase.generate, Phase.shrink],
        suppress_health_check=list(HealthCheck),
    )
    @given(inputs)
    def every(value: Any) -> None:
        judge(value)

    with address_space():
        every()


NASTY: list[Any] = [
    0, -1, 1, 1e308, 5e-324, -0.0, 1e-300, float("nan"), float("inf"), 10**400, 2**63, True, "", " ", "1 m", "1e999 m",
    "-3 Pa", "100 um", "1,5 um", "0.3", "٣ um", "nan m", "x" * 500, "a\nb", "\x1b[31mred", "\u2028", "{message}", "%s",
    "../../../etc/passwd", "/dev/zero", "/proc/self/mem", "", ".", [], [1e-6, 2e-6], [2e-6, 1e-6], [[]], {}, {"a": {}},
    [0] * 50, datetime.date(2024, 2, 29), datetime.datetime(2024, 2, 29, tzinfo=datetime.UTC), datetime.time(1),
    "bonded", "sphere", "fem", "layered", "auto", 0.5, 0.49999999999, -0.99999999, 100_000, 7, "1e-3 N", "5 GPa",
]  # fmt: skip
NAMES = ["E", "nu", "radius", "x", "a\nb", "", "r", "f", "file", "points", "depth", "law", "top", "E_p", "shape", "key"]


def mutate(tree: dict[str, Any], chance: random.Random) -> dict[str, Any]:
    changed = copy.deepcopy(tree)
    sizes_only = chance.random() < 0.5  # mostly valid bodies of odd sizes; else mostly wrong files
    for _ in range(chance.choice((1, 1, 2, 4))):
        places = [place for place in _places(changed) if not sizes_only or _is_size(place[0][place[1]])]
        if not places:
            break
        (_resize if sizes_only else _change)(*chance.choice(places), chance)
    return changed


SIZE = re.compile(r"(\d[\d.]*(?:e[+-]?\d+)?) (.+)")  # a number and its unit


def _is_size(value: Any) -> bool:
    return isinstance(value, float) or (isinstance(value, str) and SIZE.fullmatch(value) is not None)


def _resize(holder: Any, key: Any, chance: random.Random) -> None:
    value = holder[key]
    factor = 10.0 ** chance.choice((chance.uniform(-2, 2), chance.uniform(-9, 9)))
    if isinstance(value, float):
        holder[key] = value * factor
    else:
        number, unit = SIZE.fullmatch(value).groups()
        holder[key] = f"{float(number) * factor:.6g} {unit}"


def _places(node: Any) -> Iterator[tuple[Any, Any]]:
    items = node.items() if isinstance(node, dict) else enumerate(node) if isinstance(node, list) else ()
    for key, value in list(items):
        yield node, key
        yield from _places(value)


def _change(holder: Any, key: Any, chance: random.Random) -> None:
    value = holder[key]
    match chance.randrange(7):
        case 0:
            del holder[key]
        case 1 if isinstance(holder, dict):
            holder[chance.choice(NAMES)] = holder.pop(key)
        case 2 if isinstance(holder, dict):
            holder[chance.choice(NAMES)] = chance.choice(NASTY)
        case 3:
            holder[key] = [value] * chance.choice((1, 2, 3))
        case 4 | 5 if _is_size(value):
            _resize(holder, key, chance)
        case _:
            holder[key] = copy.deepcopy(chance.choice(NASTY))


def bytes_changed(content: bytes, chance: random.Random) -> bytes:
    data = bytearray(content)
    for _ in range(chance.choice((1, 1, 2, 4))):
        if not data:
            break
        at, size = chance.randrange(len(data)), chance.choice((1, 1, 2, 4, 8, 16, 100))
        match chance.randrange(7):
            case 0 | 1:
                data[at] ^= 1 << chance.randrange(8)
            case 2:
                data[at : at + size] = chance.randbytes(size)
            case 3:
                del data[at : at + size]
            case 4:
                data[at:at] = data[at : at + size] * chance.choice((1, 2, 50))
            case 5:
                del data[at:]
            case 6:
                data[at : at + size] = chance.choice((b"\xff", b"\0", b"\n", b",", b'"', b"[", b".", b"9")) * size
    return bytes(data)


def some(count: int) -> pytest.MarkDecorator:
    """So many inputs in the fast tests, 10,000 in the slow ones."""
    return pytest.mark.parametrize("count", [count, pytest.param(10_000, marks=pytest.mark.slow)])


def chances() -> st.SearchStrategy[random.Random]:
    return st.integers(0, 2**63 - 1).map(random.Random)
