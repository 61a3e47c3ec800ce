"""Every option of every verb alone and random pairs, on shipped inputs: none ends in a message of arithmetic, lasts
unannounced, or is taken without an effect; the same words through Python meet the same refusals."""

import random
import re
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import click
import pytest
from every_verb import BASES, EXEMPT, HERE, WORDS, commands, left, options_of, typed, verb_of, write_inputs

from jkrcli.base.errors import InputError, SolveError
from jkrcli.cli import jkr as program

PAIRS = 300
PATIENCE = 10.0  # CPU seconds

TIMES = {  # what of the output they are, where they are no numbers with a unit
    "bench": r"\d+\.\d+", "study converge": r"(?m)[\d.]+ *$|CPU seconds .*"}  # fmt: skip
# What does not show in what is said and written: a fit ends in the same place wherever it begins.
SILENT = EXEMPT | {"--start", "--limit-memory", "--limit-time", "--retry-failed"}
JOURNAL = "sweep-results/journal.jsonl"  # holds times
NO_ERRORS = {"compare": (0, 1, 2), "doctor": (0, 1)}  # exit codes, of others 0 and 2


def _timeless(name: str, text: bytes) -> bytes:
    """What a file holds, but for times, which series and pictures hold too."""
    timed = "convergence" in name
    if name.endswith(".h5") or (timed and name.endswith((".svg", ".png"))):
        return b""
    return re.sub(rb"(?m),[\d.]+$|.*(cpu|time).*", b"", text) if timed else text


class Runner:
    """The verbs in one folder with shipped inputs; what is asked twice is run once."""

    def __init__(self, jkr: Callable[..., Any], folder: Path):
        self.jkr, self.folder, self.known = jkr, folder, dict[tuple[str, ...], tuple[int, str, Any]]()
        write_inputs(folder, jkr)
        self.before = left(folder)

    def _clear(self) -> None:
        for name in set(left(self.folder)) - set(self.before):
            (self.folder / name).unlink()
        for name, content in self.before.items():
            if (self.folder / name).read_bytes() != content:
                (self.folder / name).write_bytes(content)

    def __call__(self, base: str, *words: str) -> tuple[int, str, Any]:
        """Exit code, what is said but for times, what is left; no message of arithmetic, nothing long unannounced."""
        key = (base, *words)
        if key not in self.known:
            self._clear()
            begin, verb = time.process_time(), verb_of(base)
            done = self.jkr(*verb.split(), *BASES[base], *words)
            spent = time.process_time() - begin
            line = " ".join((*key, done.err[-300:]))
            assert done.code in NO_ERRORS.get(verb, (0, 2)), line
            assert not re.search("range of arithmetic|Traceback|divide by zero|overflow", done.err), line
            assert spent < PATIENCE or "of CPU time" in done.err, f"{spent:.0f} s: {line}"
            held = {name: _timeless(name, text) for name, text in left(self.folder).items() if name != JOURNAL}
            times = TIMES.get(verb, r"[\d.]+ m?s\b")
            self.known[key] = done.code, re.sub(times, "", done.out + done.err), held
        return self.known[key]


@pytest.fixture(name="run")
def _run(jkr: Callable[..., Any], tmp_path: Path) -> Runner:
    return Runner(jkr, tmp_path)


def test_every_option_of_every_verb_is_tried() -> None:
    assert {" ".join(path) for path, _ in commands(program)} == {*map(verb_of, BASES), "completion"}
    for base in BASES:
        names = {each.opts[-1] for each in options_of(base) if not each.is_flag}
        assert names <= {*WORDS, *(name for owner, name in HERE if owner in (base, verb_of(base)))}, base


@pytest.mark.slow
@pytest.mark.parametrize("base", BASES)
def test_every_option_alone(run: Runner, base: str) -> None:
    plain, without = run(base), []
    for option in options_of(base):
        if option.opts[-1] in BASES[base]:
            continue
        if run(base, *typed(base, option)) == plain and option.opts[-1] not in SILENT:
            without.append(option.opts[-1])
    assert not without, f"{base}: {' '.join(without)}"


def _pairs() -> Iterator[tuple[str, click.Option, click.Option]]:
    rng = random.Random(65)
    weights = [len(options_of(base)) for base in BASES]
    for _ in range(PAIRS):
        base = rng.choices(list(BASES), weights)[0]
        free = [one for one in options_of(base) if one.opts[-1] not in BASES[base]]
        if len(free) > 1:
            yield base, *rng.sample(free, 2)


# Pairs of which one shows by nothing beside the other, and may: the record has no wave for a sine, of which a fit of
# rows says nothing; readings as they are are what a law of relaxation is fitted to; JSON holds all alternatives.
MAY = {frozenset(pair) for pair in (("--base-line", "--branch"), ("--contact", "--relaxation"), ("--rivals", "--json"))}


@pytest.mark.slow
def test_random_pairs(run: Runner) -> None:
    """An option that has an effect alone has one beside another, too, or is refused."""
    without = []
    for base, one, two in _pairs():
        both = run(base, *typed(base, one), *typed(base, two))
        if both[0] != 0:
            continue
        for first, second in ((one, two), (two, one)):
            alone, other = run(base, *typed(base, first)), run(base, *typed(base, second))
            names = first.opts[-1], second.opts[-1]
            if other != run(base) and both == alone and names[1] not in SILENT and frozenset(names) not in MAY:
                without.append(f"{base}: {names[1]} beside {names[0]}")
    assert not without, "\n".join(without)


IDLE = {  # commands with an option that had no effect, and what is said of it
    "profile gel.h5 --a 6e-4 --limit-memory 1e-12": "the limit is 1e-12 GiB",
    "profile gel.h5 --a 6e-4 --limit-time 1e-12": "the limit is 1e-12 h",
    "show --case --json gel.h5": "--case prints a case file: leave --json out",
    "sweep sweep.toml --only 1 -o there": "--only writes nothing, --output has no effect",
    "sweep sweep.toml --show-case 1 --only 2": "--show-case writes nothing, --only has no effect",
    "transform gel.h5 --together --no-plots": "--together has no effect with --no-plots",
    "look probe.csv -o there --no-plots": "--output has no effect with --no-plots",
    "look table.csv --no-plots --contact as-is": "look: --contact as-is has no effect",
    "look table.csv --no-plots --contact fitted": "look: --contact fitted has no effect",
    "fields x.h5 --a 5um --no-plots --component rr": "--component has no effect with --no-plots",
    "explore gel.h5 --unit P=mN": "options of reading need measured DATA",
    "import radii.csv --case gel.toml --area surface": "--area is what a contact area means",
    "cycle relaxing.h5 --w-approach 0 --speed 1e-5 --rate-advance v0=1,n=1": "--rate-advance needs --rate",
    "work gel.h5 probe.csv --use a,P --noise delta=1e-6": "--noise delta: w follows from a and P",
}


def test_options_without_an_effect_are_refused(jkr: Callable[..., Any], tmp_path: Path) -> None:
    write_inputs(tmp_path, jkr)
    (tmp_path / "radii.csv").write_text("a_m,delta_m,P_N\n1e-4,1e-6,1e-6\n2e-4,4e-6,8e-6\n3e-4,9e-6,3e-5\n")
    before = left(tmp_path)
    for command, said in IDLE.items():
        done = jkr(*command.split())
        assert (done.code, done.err.count("\n")) == (2, 1), (command, done.err)
        assert said in done.err, command
        assert (done.out, left(tmp_path)) == ("", before), command


def test_what_ended_in_an_error_of_python(jkr: Callable[..., Any], tmp_path: Path) -> None:
    """A load that never turns has no lowest point between two nodes."""
    write_inputs(tmp_path, jkr)
    dwell = jkr("cycle", *BASES["cycle:rate"], "--dwell", "5 um", "--dwell-time", "1 s", "--no-plots").ok
    assert "contact is not lost" in dwell.out


def test_long_fits_and_states_are_announced(jkr, tmp_path, tuned, monkeypatch) -> None:
    """A law that does not match its records took 35 s, a contact without slip 10 to 22 s, without a word."""
    write_inputs(tmp_path, jkr)

    def begun(*_: object) -> Any:
        raise InputError("begun")

    def unmatched(*_: object) -> Any:
        assert sum(range(1_000_000))  # some CPU time
        raise SolveError("no start matches")

    tuned("jkrcli.base.process.SILENCE", 0.0)
    monkeypatch.setattr("jkrcli.viscoelastic.rate_fit._Problem.starts", lambda _: [None, None])
    monkeypatch.setattr("jkrcli.viscoelastic.rate_fit._Problem.minimise", unmatched)
    done = jkr("fit", "gel.h5", "probe.csv", "--law", "power", "--no-plots")
    assert re.search(r"fit of a law to \d+ readings from 2 starts: about .* of CPU time", done.err), done.err
    monkeypatch.setattr("jkrcli.resolve.analysis.profile_columns", begun)
    gel = (tmp_path / "gel.toml").read_text().replace("points = 100", "points = 12")
    (tmp_path / "stuck.toml").write_text(gel.replace("[specimen]", '[specimen]\nsurface = "sticking"'))
    assert jkr("run", "stuck.toml", "-q").code == 0
    done = jkr("profile", "stuck.h5", "--a", "0.6 mm")
    assert re.search(r"profile of .* 15 s of CPU time\n.*begun", done.err), done.err
