"""Every option of every verb alone and random pairs, on shipped inputs: none ends in a message of arithmetic, lasts
unannounced, or is taken without an effect; the same words through Python meet the same refusals."""

import math
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

import jkrcli
from jkrcli.base.errors import InputError, SolveError
from jkrcli.cli import jkr as program

CASES = Path(__file__).parents[2] / "cases"
PAIRS = 300
PATIENCE = 10.0  # CPU seconds
INPUTS = {  # what is shipped, by the names that it has here
    "gel.toml": "gel.toml", "relaxing.toml": "relaxing-gel.toml", "probe.csv": "measured/gel-probe.csv",
    "raw.txt": "measured/raw-force-curve.txt",
}  # fmt: skip
SWEEP = """
base = "gel.toml"
outputs.quantities = ["pull_off"]
[[axes]]
key = "specimen.layers[0].thickness"
values = ["0.3 mm", "0.6 mm"]
"""
BASES: dict[str, tuple[str, ...]] = {  # verbs on shipped inputs; what follows the colon tells those of one verb apart
    "new": ("mine.toml",), "check": ("gel.toml",), "run": ("gel.toml",), "mesh": ("gel.toml",),
    "import": ("table.csv", "--case", "gel.toml", "--sort"), "transform": ("gel.h5",),
    "pull-off": ("gel.h5", "--json"), "pull-off:load": ("gel.h5", "--load", "1 mN"),
    "pull-off:options": ("--radius", "5 um", "--E", "1 MPa", "--nu", "0.5", "--w", "0.01"),
    "pull-off:relaxing": ("relaxing.h5", "--w", "20 mJ/m^2"),
    "cycle": ("gel.h5", "--w-approach", "20 mJ/m^2"),
    "cycle:rate": ("gel.h5", "--rate", "v0=1 um/s,n=0.6", "--speed", "10 um/s", "--to-load", "1 mN"),
    "cycle:relaxing": ("relaxing.h5", "--w-approach", "0", "--speed", "10 um/s", "--to-depth", "50 um"),
    "profile": ("gel.h5", "--a", "0.6 mm"), "profile:load": ("gel.h5", "--load", "1 mN"),
    "fields": ("gel.h5", "--a", "0.6 mm"),
    "export": ("gel.h5", "--dem"), "export:nanite": ("gel.h5", "--nanite"), "explore": ("gel.h5", "probe.csv"),
    "look": ("raw.txt",), "work": ("gel.h5", "probe.csv"), "compare": ("gel.h5", "less.h5"),
    "compare:curves": ("gel-w0.04.csv", "less-w0.04.csv"), "sweep": ("sweep.toml",), "show": ("gel.h5",),
    "study pull-off-map": ("--nu", "0.3", "--q", "1"), "study sticking-map": ("--nu", "0.3", "--ratio", "1"),
    "study transition-map": ("--nu", "0.3", "--q", "1", "--mu", "1"),
    "study adhesion-map": ("--nu", "0.3", "--q", "1", "--mu", "1", "--load", "1"),
    "study rate-map": ("--speed", "1", "--stiffness", "rigid", "--thickness", "0.3"),
    "study roughness-map": ("--rms", "10 nm", "--rms", "20 nm", "--modulus", "1 MPa"),
    "study converge": ("gel.toml", "--levels", "2"), "bench": ("gel.toml", "--repeat", "1"), "doctor": (),
    "fit": ("gel.toml", "probe.csv"), "fit:raw": ("raw.txt", "--radius", "5 um", "--nu", "0.5"),
}  # fmt: skip
WORDS: dict[str, tuple[str, ...]] = {  # what another value of an option is
    "--w": ("30 mJ/m^2",), "--stress": ("1 kPa",), "--range": ("2 um",), "--slopes": ("integral",),
    "--modulus-factor": ("2",), "--stiffness": ("1 N/m",), "--load": ("1 mN",), "--method": ("fem",),
    "--tolerance": ("1e-4",), "--output": ("there",), "--dimensionless": ("half-space",),
    "--scale": ("a=1 um", "--scale", "delta=1 um", "--scale", "P=1 uN"), "--a": ("0.5 mm",),
    "--w-approach": ("10 mJ/m^2",), "--w-retract": ("70 mJ/m^2",), "--to-load": ("0.5 mN",), "--to-depth": ("10 um",),
    "--rest-load": ("0.1 mN",), "--rest-depth": ("1 um",), "--points": ("9",), "--uncertain": ("E=5%",),
    "--rtol": ("0.9",), "--find": ("indenter.radius",), "--column": ("a=3",), "--overlap": ("0.9",),
    "--plot": ("there.png",), "--limit-time": ("1e-12",), "--limit-memory": ("1e-12",), "--rate": ("v0=1 um/s,n=0.6",),
    "--rate-advance": ("v0=1 um/s,n=0.6",), "--speed": ("1 um/s",), "--speed-approach": ("1 um/s",), "--hold": ("1 s",),
    "--dwell": ("1 mN",), "--dwell-time": ("1 s",), "--program": ("no.csv",), "--nodes": ("no.csv",),
    "--relaxation": ("sls",), "--case": ("gel.toml",), "--shape": ("cone",), "--radius": ("2 mm",),
    "--half-angle": ("80 deg",), "--cap": ("parabola",), "--E": ("2 MPa",), "--nu": ("0.4",),
    "--thickness": ("0.1 mm",), "--base": ("frictionless",), "--unit": ("P=uN",), "--factor": ("P=2",),
    "--zero": ("delta=0.1 um",), "--sign": ("as-is",), "--area": ("projected",), "--separator": ("tab",),
    "--decimal": (",",), "--component": ("rr",), "--flip": ("P",), "--contact": ("estimate",),
    "--sensitivity": ("45 nm/V",), "--format": ("afm",), "--rows": ("5..60",), "--where": ("segment=retract",),
    "--segment": ("approach",), "--noise": ("P=50 uN",), "--use": ("delta,P",), "--window": ("7",), "--only": ("1",),
    "--show-case": ("1",), "--hours": ("0",), "--contact-shape": ("any",),
    "--roughness": ("rms=9nm,longest=1um,shortest=100nm,hurst=0.8",), "--surface-energy": ("20 mJ/m^2",),
    "--sizes": ("0.8 mm..1.2 mm",), "--rms": ("50 nm",), "--modulus": ("2 MPa",), "--longest": ("9 um",),
    "--shortest": ("50 nm",), "--hurst": ("0.7",), "--q": ("3",), "--beta": ("0.1",), "--ratio": ("3",), "--mu": ("3",),
    "--free": ("P0",), "--fix": ("w=40 mJ/m^2",), "--start": ("w=30 mJ/m^2",), "--bound": ("w=60 mJ/m^2..1 J/m^2",),
    "--law": ("power",), "--terms": ("1",), "--base-line": ("sine",), "--branch": ("compressive",),
    "--loss": ("cauchy",), "--confidence": ("profile",), "--model": ("auto",), "--level": ("0.5",),
    "--samples": ("30",), "--seed": ("7",), "--shared": ("w",), "--own": ("w",), "--tip-radius": ("3 mm",),
    "--surface": ("sticking",), "--name": ("other",), "--grid": ("6x5",), "--sample": ("gel-(.*)",),
}  # fmt: skip
HERE: dict[tuple[str, str], tuple[str, ...]] = {  # and where it is not: by verb, or by one of its bases
    ("compare", "--column"): ("a",), ("new", "--example"): ("gel",), ("study rate-map", "--rate"): ("n=0.5",),
    ("study rate-map", "--speed"): ("2",), ("study rate-map", "--stiffness"): ("1",),
    ("study rate-map", "--thickness"): ("0.5",), ("study adhesion-map", "--load"): ("2",),
    ("import", "--area"): ("surface",), ("import", "--column"): ("a=delta_m",), ("look", "--column"): ("P=a_um",),
    ("work", "--column"): ("P=a_um",), ("explore", "--column"): ("P=a_um",), ("bench", "--repeat"): ("2",),
    ("study converge", "--levels"): ("3",), ("study converge", "--contact"): ("incremental",),
    ("export", "--name"): ("other",), ("pull-off", "--slopes"): ("integral",), ("fit", "--stiffness"): ("5 kN/m",),
    ("import", "--unit"): ("P=mN",), ("import", "--case"): ("soft.toml",), ("import", "--zero"): ("P=-1 uN",),
    ("compare", "--overlap"): ("0.99",), ("compare", "--rtol"): ("1e-9",), ("pull-off", "--stiffness"): ("10 N/m",),
    ("pull-off:load", "--uncertain"): ("R=2%",), ("look", "--decimal"): (".",), ("look", "--contact"): ("estimate",),
    ("look", "--where"): ("curve=other",), ("fit", "--uncertain"): ("radius=3%",),
    ("fit:raw", "--free"): ("compliance",), ("fit:raw", "--decimal"): (".",), ("fit:raw", "--fix"): ("w=1 mJ/m^2",),
    ("fit:raw", "--start"): ("w=2 mJ/m^2",), ("fit:raw", "--bound"): ("w=2 mJ/m^2..1 J/m^2",),
    ("fit:raw", "--noise"): ("P=1 nN",), ("fit:raw", "--contact"): ("as-is",), ("fit:raw", "--tip-radius"): ("3 um",),
    ("fit:raw", "--unit"): ("P=pN",), ("fit:raw", "--thickness"): ("20 um",), ("fit:raw", "--rows"): ("5..1800",),
    ("pull-off:options", "--thickness"): ("20 um",), ("cycle:rate", "--hold"): ("1 s",),
    ("cycle:rate", "--dwell"): ("5 um", "--dwell-time", "1 s"),
    ("cycle:relaxing", "--dwell"): ("20 um", "--dwell-time", "1 s"), ("sweep", "--show-case"): ("1",),
    ("study converge", "--w"): ("30 mJ/m^2",), ("bench", "--method"): ("closed-form",),
}  # fmt: skip
TIMES = {  # what of the output they are, where they are no numbers with a unit
    "bench": r"\d+\.\d+", "study converge": r"(?m)[\d.]+ *$|CPU seconds .*"}  # fmt: skip
# How much is said, whether a file of another's is replaced, where it is computed: none changes what is.
EXEMPT = {"--force", "--quiet", "--verbose", "--workers", "--scheduler"}
# What does not show in what is said and written: a fit ends in the same place wherever it begins.
SILENT = EXEMPT | {"--start", "--limit-memory", "--limit-time", "--retry-failed"}
JOURNAL = "sweep-results/journal.jsonl"  # holds times
NO_ERRORS = {"compare": (0, 1, 2), "doctor": (0, 1)}  # exit codes, of others 0 and 2


def _commands(group: click.Group, path: tuple[str, ...] = ()) -> Iterator[tuple[tuple[str, ...], click.Command]]:
    context = click.Context(group)
    for name in group.list_commands(context):
        command = group.get_command(context, name)
        assert command is not None
        if isinstance(command, click.Group):
            yield from _commands(command, (*path, name))
        else:
            yield (*path, name), command


def _timeless(name: str, text: bytes) -> bytes:
    """What a file holds, but for times, which series and pictures hold too."""
    timed = "convergence" in name
    if name.endswith(".h5") or (timed and name.endswith((".svg", ".png"))):
        return b""
    return re.sub(rb"(?m),[\d.]+$|.*(cpu|time).*", b"", text) if timed else text


def _left(folder: Path) -> dict[str, bytes]:
    return {str(path.relative_to(folder)): path.read_bytes() for path in sorted(folder.rglob("*")) if path.is_file()}


def _verb(base: str) -> str:
    return base.partition(":")[0]


@cache
def _options(base: str) -> list[click.Option]:
    command = dict(_commands(program))[tuple(_verb(base).split())]
    return [each for each in command.params
            if isinstance(each, click.Option) and not each.is_eager and each.opts[-1] not in EXEMPT]  # fmt: skip


def _typed(base: str, option: click.Option) -> tuple[str, ...]:
    name = (option.secondary_opts or option.opts if option.default is True else option.opts)[-1]
    if option.is_flag:
        return (name,)
    return (name, *(HERE.get((base, name)) or HERE.get((_verb(base), name)) or WORDS[name]))


def _write_inputs(folder: Path, jkr: Callable[..., Any]) -> None:
    """Shipped cases and records, what is solved of them, and the same as another program would write it."""
    for name, source in INPUTS.items():
        shutil.copy(CASES / source, folder / name)
    gel = (folder / "gel.toml").read_text()
    (folder / "soft.toml").write_text(gel.replace('"15 kPa"', '"12 kPa"'))
    (folder / "less.toml").write_text(gel.replace('"1.2 mm"', '"1.18 mm"').replace("points = 100", "points = 60"))
    (folder / "sweep.toml").write_text(SWEEP)
    for name in ("gel", "less", "relaxing"):
        assert jkr("run", f"{name}.toml", "-q").code == 0
    series = jkrcli.read("gel.h5").series
    rows = zip((math.pi * series.a**2).tolist(), series.delta.tolist(), (-series.P).tolist(), strict=True)
    lines = [",".join(map(repr, row)) for row in rows]
    (folder / "table.csv").write_text("\n".join(["area_m2,delta_m,P_N", *lines[::-1], ""]))
    assert jkr("transform", "gel.h5", "less.h5", "--w", "0.04", "--no-plots").code == 0


class Runner:
    """The verbs in one folder with shipped inputs; what is asked twice is run once."""

    def __init__(self, jkr: Callable[..., Any], folder: Path):
        self.jkr, self.folder, self.known = jkr, folder, dict[tuple[str, ...], tuple[int, str, Any]]()
        _write_inputs(folder, jkr)
        self.before = _left(folder)

    def _clear(self) -> None:
        """What a command left goes, what it replaced comes back."""
        for name in set(_left(self.folder)) - set(self.before):
            (self.folder / name).unlink()
        for name, content in self.before.items():
            if (self.folder / name).read_bytes() != content:
                (self.folder / name).write_bytes(content)

    def __call__(self, base: str, *words: str) -> tuple[int, str, Any]:
        """Exit code, what is said but for times, what is left; no message of arithmetic, nothing long unannounced."""
        key = (base, *words)
        if key not in self.known:
            self._clear()
            begin, verb = time.process_time(), _verb(base)
            done = self.jkr(*verb.split(), *BASES[base], *words)
            spent = time.process_time() - begin
            line = " ".join((*key, done.err[-300:]))
            assert done.code in NO_ERRORS.get(verb, (0, 2)), line
            assert not re.search("range of arithmetic|Traceback|divide by zero|overflow", done.err), line
            assert spent < PATIENCE or "of CPU time" in done.err, f"{spent:.0f} s: {line}"
            left = {name: _timeless(name, text) for name, text in _left(self.folder).items() if name != JOURNAL}
            times = TIMES.get(verb, r"[\d.]+ m?s\b")
            self.known[key] = done.code, re.sub(times, "", done.out + done.err), left
        return self.known[key]


@pytest.fixture(name="run")
def _run(jkr: Callable[..., Any], tmp_path: Path) -> Runner:
    return Runner(jkr, tmp_path)


def test_every_option_of_every_verb_is_tried() -> None:
    assert {" ".join(path) for path, _ in _commands(program)} == {*map(_verb, BASES), "completion"}
    for base in BASES:
        names = {each.opts[-1] for each in _options(base) if not each.is_flag}
        assert names <= {*WORDS, *(name for owner, name in HERE if owner in (base, _verb(base)))}, base


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
    weights = [len(_options(base)) for base in BASES]
    for _ in range(PAIRS):
        base = rng.choices(list(BASES), weights)[0]
        free = [one for one in _options(base) if one.opts[-1] not in BASES[base]]
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
        both = run(base, *_typed(base, one), *_typed(base, two))
        if both[0] != 0:
            continue
        for first, second in ((one, two), (two, one)):
            alone, other = run(base, *_typed(base, first)), run(base, *_typed(base, second))
            names = first.opts[-1], second.opts[-1]
            if other != run(base) and both == alone and names[1] not in SILENT and frozenset(names) not in MAY:
                without.append(f"{base}: {names[1]} beside {names[0]}")
    assert not without, "\n".join(without)


# ---------------------------------------------------------------------- what the matrix found
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
    _write_inputs(tmp_path, jkr)
    (tmp_path / "radii.csv").write_text("a_m,delta_m,P_N\n1e-4,1e-6,1e-6\n2e-4,4e-6,8e-6\n3e-4,9e-6,3e-5\n")
    before = _left(tmp_path)
    for command, said in IDLE.items():
        done = jkr(*command.split())
        assert (done.code, done.err.count("\n")) == (2, 1), (command, done.err)
        assert said in done.err, command
        assert (done.out, _left(tmp_path)) == ("", before), command


def test_what_ended_in_an_error_of_python(jkr: Callable[..., Any], tmp_path: Path) -> None:
    """A load that never turns has no lowest point between two nodes."""
    _write_inputs(tmp_path, jkr)
    dwell = jkr("cycle", *BASES["cycle:rate"], "--dwell", "5 um", "--dwell-time", "1 s", "--no-plots").ok
    assert "contact is not lost" in dwell.out


def test_long_fits_and_states_are_announced(
    jkr: Callable[..., Any], tmp_path: Path, tuned: Callable[[str, object], None], monkeypatch: pytest.MonkeyPatch
) -> None:
    """A law that does not match its records took 35 s, a contact without slip 10 to 22 s, without a word."""
    _write_inputs(tmp_path, jkr)

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
