"""Every verb and every option alone and random pairs, on shipped inputs: none ends in a message of arithmetic, lasts
unannounced, or is taken without an effect; a verdict comes first, a verb replaces its own files alone."""

import ast
import inspect
import random
import re
import textwrap
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import click
import pytest
from conftest import refused_by
from every_verb import BASES, EXEMPT, HERE, WORDS, commands, left, options_of, typed, verb_of, write_inputs

from jkrcli import cli
from jkrcli.base.errors import InputError, SolveError
from jkrcli.case.models import method_of, parse_case, places
from jkrcli.cli import jkr as program
from jkrcli.cli import printing as output
from jkrcli.methods.protocol import METHODS

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


CHEAP = ("new", "check", "run", "transform", "pull-off", "export", "look", "show")
ALL = [*(base for base in BASES if ":" not in base), "pull-off:load", "cycle:rate", "fit:raw"]


def judge(jkr: Callable, words: tuple[object, ...], whole: list[str]) -> None:
    """``whole``: what was said, before it was folded."""
    done = jkr(*words)
    assert done.code == (words[0] == "compare"), done.err
    wide = [line for line in (done.out + done.err).splitlines() if len(line) > 80]
    assert [line for line in wide if len(line.split()) > 1 and max(map(len, line.split())) < 76] == []
    lines = done.out.splitlines()
    assert len(lines) <= (16 if words[0] == "check" else 12), done.out
    verdict = next((line for line in whole if line.strip() and line.startswith(lines[0].rstrip())), lines[0])
    assert any(character.isdigit() for character in verdict) or words[0] in ("new", "check", "study"), verdict
    assert len(verdict) <= 120
    if any(line.endswith(" with -v") for line in lines) and words[0] in ("pull-off", "show"):
        assert len(jkr(*words, "-v").out.splitlines()) > len(lines)


@pytest.mark.parametrize("bases", [CHEAP, pytest.param(ALL, marks=pytest.mark.slow)], ids=["", "all"])
def test_the_verdict_comes_first(jkr, monkeypatch, tmp_path, bases) -> None:
    monkeypatch.setenv("COLUMNS", "80")
    write_inputs(tmp_path, jkr)
    whole: list[str] = []
    fold = output.folded
    monkeypatch.setattr(output, "folded", lambda line, *widest: (whole.append(line), fold(line, *widest))[1])
    for base in bases:
        whole.clear()
        plots = ["--no-plots"] * any("--no-plots" in option.opts for option in options_of(base))
        judge(jkr, (*verb_of(base).split(), *(word for word in BASES[base] if word != "--json"), *plots), whole)


def test_errors_are_one_line_in_a_log(jkr: Callable, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("COLUMNS", "60")
    done = jkr("check", "there-is-no-such-case-file-in-this-empty-folder-of-a-test.toml")
    assert (done.code, len(done.err.splitlines())) == (2, 1)


FAST = ("transform", "cycle", "profile", "fit", "work", "export")
NO_FILES = (
    "new",
    "check",
    "pull-off",
    "show",
    "bench",
    "doctor",
    "compare:curves",
)  # write nothing, or no file that is replaced
WRITING = {
    **{base: words for base, words in BASES.items() if not {base, verb_of(base)} & {*NO_FILES}},
    "transform": ("gel.h5", "--w", "0.03", "--w", "0.04", "--together"),
    "cycle:load control": ("gel.h5", "--stiffness", "load"),
    "compare": ("gel.h5", "gel.h5", "--plot", "same.svg"),
}


@pytest.mark.first(len(FAST))
@pytest.mark.parametrize("base", sorted(WRITING, key=lambda base: base not in FAST))
def test_a_verb_replaces_what_it_wrote(base: str, jkr: Callable, tmp_path: Path) -> None:
    write_inputs(tmp_path, jkr)
    before = left(tmp_path)
    words = (*verb_of(base).split(), *WRITING[base])
    for _ in range(2):
        assert jkr(*words).code == 0
    made = [tmp_path / name for name, content in left(tmp_path).items() if content != before.get(name)]
    assert made
    for path in made:  # and the user's own files are his
        path.write_text("mine\n")
    assert jkr(*words).code == 2
    assert all(path.read_text() == "mine\n" for path in made)


LAYER = """
indenter = { shape = "paraboloid", radius = "1 mm" }
specimen.layers = [{ thickness = "0.2 mm", E = "1 MPa", nu = 0.3 }]
loading.radius = "0.1 mm"
"""
OTHERS = {  # what to write for another value of an option, where that is not half its default
    "layout": 'layout = "zones"', "element": 'element = "quadrilateral"', "order": "order = 1",
    "formulation": 'formulation = "mixed"', "element_size": 'element_size = "5 um"\nlayout = "zones"',
    "zone_sizes": 'zone_sizes = [0.01, 0.02, 0.3]\nlayout = "zones"', "depth": 'depth = "20 mm"',
    "width": 'width = "20 mm"', "contact_radius": 'contact_radius = "0.2 mm"', "growth": "growth = 0.3",
    "margin": "margin = 1.3", "edge_correction": "edge_correction = false", "estimate_error": "estimate_error = false",
    "tolerance": "tolerance = 1e-3", "solver": 'solver = "superlu"', "contact": 'algorithm = "incremental"',
    "integration": 'integration = "reduced"\norder = 1\nelement = "quadrilateral"\nlayout = "zones"',
}  # fmt: skip


@pytest.mark.parametrize("path", [path for path, _ in commands(cli.jkr)], ids=" ".join)
def test_every_parameter_of_a_verb_is_read_by_it(path: tuple[str, ...]) -> None:
    command = dict(commands(cli.jkr))[path]
    assert command.callback is not None
    body = ast.parse(textwrap.dedent(inspect.getsource(inspect.unwrap(command.callback)))).body[0]
    assert isinstance(body, ast.FunctionDef)
    read = {node.id for part in body.body for node in ast.walk(part) if isinstance(node, ast.Name)}
    given = {argument.arg for argument in (*body.args.args, *body.args.kwonlyargs)}
    assert given <= read


@pytest.mark.parametrize(
    ("method", "option"), [(name, option) for name, known in METHODS.items() for option in places(known)]
)
def test_every_option_of_a_method_changes_it(method: str, option: str) -> None:
    place = places(METHODS[method])[option]
    plain = parse_case(LAYER.encode(), "plain.toml").model
    line = OTHERS.get(option) or f"{place.key} = {place.default / 2!r}"
    other = parse_case(f"{LAYER}[{place.table}]\n{line}\n".encode(), "other.toml").model
    assert getattr(method_of(plain, method), option) != getattr(method_of(other, method), option)


def test_sizes_of_another_layout_are_refused() -> None:
    assert refused_by(parse_case, f"{LAYER}[mesh]\nzone_sizes = [0.01, 0.02, 0.3]\n".encode(), "my.toml") == (
        'my.toml: mesh: zone_sizes belong to layout "zones"; the layout "scaled" takes spacing',
    )


@pytest.mark.parametrize("line", ["spacing = 0.05", "growth = 0.3"])
def test_sizes_beside_a_tolerance_are_refused(line: str) -> None:
    problem = parse_case(f"{LAYER}[mesh]\ntolerance = 1e-3\n{line}\n".encode(), "my.toml").model
    reason = method_of(problem, "fem").refusal(problem.problem())
    assert reason is not None
    assert "mesh.spacing and mesh.growth follow from mesh.tolerance: leave them out" in reason


def test_every_option_of_every_verb(jkr: Callable) -> None:
    tried = 0
    for words, command in commands(cli.jkr):
        for option in command.params:
            if not isinstance(option, click.Option) or option.is_flag or option.count:
                continue
            name = max(option.opts, key=len)
            keyed = option.multiple and getattr(option.type, "keyed", False)
            if option.multiple and not keyed:
                continue
            arguments = ["x"] * sum(isinstance(item, click.Argument) for item in command.params)
            given = [name, "P=1", name, "P=2"] if keyed else [name, "1", name, "2"]
            done = jkr(*words, *arguments, *given)
            assert done.code == 2, (words, name)
            said = f"{name}: P is given twice" if keyed else f"{name} is given 2 times"
            assert said in done.err or "must be KEY=" in done.err, (words, name, done.err)
            tried += 1
    assert tried > 150


@pytest.mark.parametrize("flags", [("--json", "--json"), ("-q", "-q"), ("--w", "1", "--w", "2")])
def test_flags_and_options_of_several_values_may_be_repeated(flags: tuple[str, ...], jkr: Callable) -> None:
    assert "is given" not in jkr("transform", "missing.h5", *flags).err
