"""Every option of every verb alone and random pairs, on shipped inputs: none ends in a message of arithmetic, lasts
unannounced, or is taken without an effect; the same words through Python meet the same refusals."""

from __future__ import annotations

import random
import re
import shutil
import time
from collections.abc import Callable, Iterator
from functools import cache
from pathlib import Path
from typing import Any

import click
import pytest
from test_options_have_effect import EXEMPT, OWN, VALUES, _commands, _left, _timeless

import jkrcli
from jkrcli.cli import jkr as program
from jkrcli.cli.options import QuantityType

CASES = Path(__file__).parents[2] / "cases"
PAIRS = 300
PATIENCE = 10.0  # CPU seconds
RAW = ("raw.txt", "--radius", "5 um", "--nu", "0.5")
BASES: dict[str, tuple[str, ...]] = {  # verbs on shipped inputs
    "new": ("mine.toml",), "check": ("gel.toml",), "run": ("gel.toml",), "mesh": ("gel.toml",),
    "transform": ("gel.h5",), "pull-off": ("gel.h5",), "cycle": ("gel.h5", "--w-approach", "20 mJ/m^2"),
    "profile": ("gel.h5", "--a", "0.6 mm"), "export": ("gel.h5", "--dem"), "explore": ("gel.h5", "probe.csv"),
    "look": ("raw.txt",), "work": ("gel.h5", "probe.csv"), "show": ("gel.h5",),
    "study pull-off-map": ("--nu", "0.3", "--q", "1"), "fit": ("gel.toml", "probe.csv"), "fit raw": RAW,
}  # fmt: skip
WORDS = VALUES | {  # what another value of an option is on these
    "--a": ("0.5 mm",), "--load": ("1 mN",), "--method": ("closed-form",), "--to-load": ("1 mN",),
    "--to-depth": ("10 um",), "--case": ("gel.toml",), "--free": ("P0",), "--fix": ("w=40 mJ/m^2",),
    "--start": ("w=30 mJ/m^2",), "--bound": ("w=1 mJ/m^2..1 J/m^2",), "--law": ("power",), "--relaxation": ("sls",),
    "--terms": ("1",), "--segment": ("approach",), "--base-line": ("sine",), "--branch": ("compressive",),
    "--loss": ("cauchy",), "--confidence": ("profile",), "--model": ("auto",), "--level": ("0.5",),
    "--samples": ("30",), "--seed": ("7",), "--shared": ("w",), "--own": ("w",), "--tip-radius": ("3 mm",),
    "--surface": ("sliding",), "--uncertain": ("E=5%",), "--stiffness": ("5 N/m",), "--noise": ("P=3 uN",),
}  # fmt: skip
# What does not show in what is said and written, or only where something else does.
SILENT = EXEMPT | {"--start", "--limit-memory", "--limit-time", "--output"}


def _verb(base: str) -> str:
    return base.removesuffix(" raw")


@cache
def _options(base: str) -> list[click.Option]:
    command = dict(_commands(program))[tuple(_verb(base).split())]
    return [each for each in command.params
            if isinstance(each, click.Option) and not each.is_eager and each.opts[-1] not in EXEMPT]  # fmt: skip


def _typed(base: str, option: click.Option) -> tuple[str, ...]:
    name = (option.secondary_opts or option.opts if option.default is True else option.opts)[-1]
    if option.is_flag:
        return (name,)
    if base.startswith("fit") and name == "--uncertain":
        return (name, "radius=3%")
    return (name, *(OWN.get((_verb(base), name)) or WORDS[name]))


class Runner:
    """The verbs in one folder with shipped inputs; what is asked twice is run once."""

    def __init__(self, jkr: Callable[..., Any], folder: Path):
        self.jkr, self.folder, self.known = jkr, folder, dict[tuple[str, ...], tuple[int, str, Any]]()
        shutil.copy(CASES / "gel.toml", folder / "gel.toml")
        shutil.copy(CASES / "measured" / "gel-probe.csv", folder / "probe.csv")
        shutil.copy(CASES / "measured" / "raw-force-curve.txt", folder / "raw.txt")
        assert self.jkr("run", "gel.toml").code == 0
        self.before = set(_left(folder))

    def __call__(self, base: str, *words: str) -> tuple[int, str, Any]:
        """Exit code, what is said but for times, what is left; no message of arithmetic, nothing long unannounced."""
        key = (base, *words)
        if key not in self.known:
            for name in set(_left(self.folder)) - self.before:
                (self.folder / name).unlink()
            begin = time.process_time()
            done = self.jkr(*_verb(base).split(), *BASES[base], *words)
            spent = time.process_time() - begin
            line = " ".join((*key, done.err[-300:]))
            assert done.code in (0, 2), line
            assert not re.search("range of arithmetic|Traceback|divide by zero|overflow", done.err), line
            announced = re.search(r"needs about .* CPU time|takes about", done.err)
            assert spent < PATIENCE or announced, f"{spent:.0f} s: {line}"
            left = {name: _timeless(name, text) for name, text in _left(self.folder).items()}
            self.known[key] = done.code, re.sub(r"[\d.]+ m?s\b", "", done.out + done.err), left
        return self.known[key]


@pytest.fixture(name="run")
def _run(jkr: Callable[..., Any], tmp_path: Path) -> Runner:
    return Runner(jkr, tmp_path)


@pytest.mark.slow
@pytest.mark.parametrize("base", BASES)
def test_every_option_alone(run: Runner, base: str) -> None:
    plain, without = run(base), []
    for option in _options(base):
        if option.opts[-1] in BASES[base]:
            continue
        if run(base, *_typed(base, option)) == plain and option.opts[-1] not in SILENT:
            without.append(option.opts[-1])
    assert not without, f"{base}: {' '.join(without)}"


def _pairs() -> Iterator[tuple[str, click.Option, click.Option]]:
    """Verbs with two of their options, as often as they have pairs of them."""
    rng = random.Random(65)
    weights = [len(_options(base)) ** 2 for base in BASES]
    for _ in range(PAIRS):
        base = rng.choices(list(BASES), weights)[0]
        free = [one for one in _options(base) if one.opts[-1] not in BASES[base]]
        if len(free) > 1:
            yield base, *rng.sample(free, 2)


# Pairs of which one shows by nothing beside the other, and may.
MAY: set[frozenset[str]] = set()


@pytest.mark.slow
def test_random_pairs(run: Runner) -> None:
    """An option that has an effect alone has one beside another, too, or is refused."""
    without = []
    for base, one, two in _pairs():
        both = run(base, *_typed(base, one), *_typed(base, two))
        if both[0] != 0:
            continue
        for first, second in ((one, two), (two, one)):
            alone, other = run(base, *_typed(base, first)), run(base, *_typed(base, second))
            names = first.opts[-1], second.opts[-1]
            if other != run(base) and both == alone and names[1] not in SILENT and frozenset(names) not in MAY:
                without.append(f"{base}: {names[1]} beside {names[0]}")
    assert not without, "\n".join(without)


# ---------------------------------------------------------------------- the same words through Python
READING = ("columns", "units", "factors", "flip", "zero", "contact", "stiffness", "sensitivity", "format", "separator",
           "decimal", "rows", "where")  # fmt: skip
PYTHON: dict[str, tuple[Callable[..., Any], tuple[str, ...], dict[str, str]]] = {  # functions, their names
    "transform": (jkrcli.transform, ("stress", "length", "slopes", "modulus_factor"), {"works": "w"}),
    "pull-off": (jkrcli.pull_off, ("rest_load", "rest_depth", "stress", "length", "slopes", "modulus_factor"),
                 {"works": "w", "stiffnesses": "stiffness", "force": "load", "uncertain": "uncertain"}),
    "profile": (jkrcli.profile, ("load", "stress", "length"), {"work": "w"}),
    "cycle": (jkrcli.cycle, ("w_approach", "stiffness", "to_load", "to_depth", "rest_load", "rest_depth", "stress",
                             "length", "slopes", "modulus_factor"), {"w_retract": "w"}),
    "work": (jkrcli.work, ("use", "segment", "noise", "window", "modulus_factor", "slopes"), {}),
    "fit": (jkrcli.fit, ("free", "fix", "start", "bound", "segment", "base_line", "branch", "noise", "loss",
                         "confidence", "model", "level", "samples", "seed", "uncertain", "slopes"), {}),
}  # fmt: skip
ARGUMENTS: dict[str, dict[str, Any]] = {
    "transform": {"solved": "gel.h5", "w": 0.04}, "pull-off": {"solved": "gel.h5", "w": 0.04},
    "profile": {"solved": "gel.h5", "a": 6e-4}, "cycle": {"solved": "gel.h5", "w": 0.04, "w_approach": 0.02},
    "work": {"solved": "gel.h5", "measured": "probe.csv"}, "fit": {"body": "gel.toml", "measured": "probe.csv"},
}  # fmt: skip


def _python(base: str, given: dict[str, str]) -> bool:
    """Whether the function of a verb refuses options, whose texts are ``given``."""
    function, same, others = PYTHON[base]
    words, reading = dict(ARGUMENTS[base]), dict[str, Any]()
    if "force" in given:
        del words["w"]
    if base == "profile" and "load" in given:
        del words["a"]
    for option in _options(base):
        name = option.name or ""
        if name in given:
            value: Any = given[name]
            if getattr(option.type, "keyed", False):
                value = dict([value.split("=", 1)]) if "=" in value else value
            elif name in ("rows",) and ".." in value:
                value = tuple(map(int, value.split("..")))
            if name in same or name in others:
                words[others.get(name, name)] = [value] if name in ("stiffnesses", "free") else value
            elif name in READING:
                reading[name] = value
    try:
        if reading:
            words["reading"] = jkrcli.Reading(**reading)
        function(**words)
    except jkrcli.JkrError:
        return True
    return False


def _mapped(base: str) -> list[click.Option]:
    _, same, others = PYTHON[base]
    names = {*same, *others, *(READING if base in ("work", "fit") else ())} - set(ARGUMENTS[base]) | {"w_retract"}
    return [one for one in _options(base) if one.name in names and one.opts[-1] not in BASES[base]]


def _wrong(option: click.Option) -> list[str]:
    """Texts that an option does not take, by its own declaration."""
    kind = option.type
    if isinstance(kind, QuantityType):
        return ["12 parrots", *(["-1"] if kind.ranged.above == 0 or kind.ranged.least == 0 else [])]
    if isinstance(kind, click.Choice):
        return [f"{kind.choices[-1]}x"]
    if isinstance(kind, click.IntRange):
        ends = [*([kind.min - 1] if kind.min is not None else []), *([kind.max + 1] if kind.max is not None else [])]
        return ["one", *map(str, ends)]
    if kind is click.FLOAT:
        return ["some"]
    return ["nonesuch=3"] if getattr(kind, "keyed", False) else []


@pytest.mark.slow
@pytest.mark.parametrize("base", PYTHON)
def test_wrong_words_are_refused_by_both(run: Runner, base: str) -> None:
    for option in _mapped(base):
        for text in _wrong(option):
            assert run(base, option.opts[-1], text)[0] == 2, (option.name, text)
            assert _python(base, {option.name or "": text}), f"{base}: {option.name} = {text} is taken by Python"


@pytest.mark.slow
def test_pairs_are_refused_by_both(run: Runner) -> None:
    rng, apart = random.Random(66), []
    for _ in range(PAIRS // 4):
        base = rng.choices(list(PYTHON), [len(_mapped(base)) ** 2 for base in PYTHON])[0]
        pair = rng.sample([one for one in _mapped(base) if not one.is_flag], 2)
        texts = {one.name or "": _typed(base, one)[1] for one in pair}
        words = [word for one in pair for word in _typed(base, one)]
        if (run(base, *words)[0] == 2) != _python(base, texts):
            apart.append(f"{base} {' '.join(words)}: {run(base, *words)[1][:200]}")
    assert not apart, "\n".join(apart)
