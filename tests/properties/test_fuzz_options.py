"""Any options of any verb, and raw records changed: a result, or exit code 2 with one line per mistake, as in
``test_fuzz``; among them adhesion of finite range, programs of speed and laws of rate."""

import random
from pathlib import Path

import click
import hypothesis.strategies as st
import numpy as np
import pytest
from fuzzing import NASTY, bytes_changed, chances, fuzz, outcome, some

from jkrcli import cli

RAW = Path(__file__).parents[2] / "cases" / "measured" / "raw-force-curve.txt"
CASE = """
title = "x"
method = "{method}"
indenter = {{ shape = "paraboloid", radius = "1 mm" }}
specimen.{body}
loading = {{ radius = "0.1 mm", points = 20 }}
adhesion = {{ w = "50 mJ/m^2" }}
"""
HALF_SPACE = 'half_space = { E = "1 MPa", nu = 0.3 }'
LAYER = 'layers = [{ name = "skin", thickness = "0.2 mm", E = "1 MPa", nu = 0.3 }]'
SWEEP = 'base = "s.toml"\n[[axes]]\nkey = "specimen.half_space.nu"\nfrom = 0.1\nto = 0.4\ncount = 3\n'

# Arguments of the verbs; the dearer ones come once, the others three times.
CHEAP = (
    ("check", "s.toml"), ("run", "s.toml", "-o", "r.h5", "--force"), ("run", "l.toml", "-o", "r.h5"),
    ("import", "h.csv", "-o", "i.h5", "--radius", "1 mm", "--E", "1 MPa", "--nu", "0.3"), ("transform", "s.h5"),
    ("transform", "l.h5"), ("pull-off", "s.h5"), ("pull-off", "l.h5"), ("cycle", "s.h5"), ("cycle", "l.h5"),
    ("cycle", "s.h5", "--rate", "v0=1 um/s,n=0.6", "--speed", "10 um/s"), ("explore", "s.h5", "m.csv"),
    ("look", "raw.txt"), ("look", "m.csv"), ("fit", "s.h5", "m.csv"), ("work", "s.h5", "m.csv"),
    ("compare", "s.h5", "l.h5"), ("sweep", "many.toml", "--show-case", "0"), ("show", "s.h5"),
)  # fmt: skip
DEAR = (
    ("profile", "s.h5"), ("profile", "l.h5"), ("fit", "s.h5", "m.csv", "--law", "power"),
    ("fit", "raw.txt", "--radius", "5 um", "--nu", "0.5", "--shape", "paraboloid"),
    ("sweep", "many.toml", "-o", "sweep", "--workers", "1"), ("bench", "s.toml", "--repeat", "1"),
    ("study", "pull-off-map", "--q", "1", "--nu", "0.3"), ("study", "transition-map", "--q", "1", "--mu", "1"),
    ("study", "rate-map", "--speed", "0.1", "--stiffness", "rigid"), ("study", "sticking-map", "--nu", "0.3", "--ratio",
    "1"),
)  # fmt: skip
LEFT_OUT = {  # would start other processes, look for other machines, or take long as they should
    "--scheduler", "--workers", "--limit-time", "--limit-memory", "--hours", "--levels", "--repeat", "--samples",
    "--confidence",
}  # fmt: skip
GOOD = {  # values of options, by the name of their type
    "WORK": ("50 mJ/m^2", "0.05", "0", "1 J/m^2"), "STRESS": ("10 kPa", "1 MPa"),
    "LENGTH": ("50 um", "5 um", "-1 um", "1 nm"), "STIFFNESS": ("10 N/m", "rigid", "load"),
    "LOAD": ("-50 uN", "0.1 mN", "1 N"), "FACTOR": ("2", "1e-3"), "KEY=NAME": ("P=2", "a=a_m", "t=4"),
    "KEY=UNIT": ("P=mN", "a=um", "t=ms"), "KEY=NUMBER": ("P=180", "delta=-1"),
    "KEY=VALUE": ('a="1 um"', "delta=1 um", "P=1 uN", "delta=1 nm"),
    "NAME=VALUE": ("w=50 mJ/m^2", "load=5%", "R=1%", "w=1 mJ/m^2..1 J/m^2", "range=1 nm..1 um", "delta0=0",
    "E:skin=5%", "nu=0.01"),
    "KEY=VALUE,...": ("v0=1 um/s,n=0.6", "law=log,v0=1 um/s,b=5 mJ/m^2", "n=0.6", "v0=1 um/s,n=-1"),
    "NAME,...": ("w", "P0,compliance", "E:skin", "w0,v0,n", "range", "stress"), "text": ("1 mm", "10 um/s", "2 s",
    "0.3", "retract"),
    "SENSITIVITY": ("50 nm/V",), "float": ("0.3", "0.5", "1"), "float range": ("0.3", "0.01"), "integer": ("3", "11"),
    "integer range": ("2", "30"),
    "path": ("made.h5", "made.png", "p.csv"), "directory": ("made", ".", "no/where"),
}  # fmt: skip
TEXTS = [word for word in NASTY if isinstance(word, str)]
BAD = [*TEXTS, "1e308", "1e999", "-1", "nan", "-inf", "9" * 400, "=", "a=", "P=nan", "w=..", "law=x", "\udcff", "5 %"]
PLACES = ("", " ", "a\nb", "\x1b[31mred", "s.h5", "s.toml", "\udcff.h5", "x" * 500)  # names that nothing is lost by


def options_of(words: tuple[str, ...]) -> list[click.Option]:
    """The options that are tried on a verb."""
    command = cli.jkr.get_command(click.Context(cli.jkr), words[0])
    if isinstance(command, click.Group):
        command = command.get_command(click.Context(command), words[1])
    return [item for item in command.params if isinstance(item, click.Option) and item.opts[-1] not in LEFT_OUT]


def valued(option: click.Option, chance: random.Random) -> list[str]:
    """An option with a value that is mostly one of its kind."""
    if option.is_flag:
        return [option.opts[-1]]
    kind = option.type
    good = tuple(map(str, kind.choices)) if isinstance(kind, click.Choice) else GOOD[kind.name]
    bad = PLACES if kind.name in ("path", "directory") else BAD
    return [option.opts[-1], chance.choice(good if chance.random() < 0.75 else bad)]


def line_of(chance: random.Random) -> list[str]:
    """A command line with up to four options, without pictures where it can do without."""
    words = chance.choice(DEAR if chance.random() < 0.05 else CHEAP)
    options = options_of(words)
    plain = ["--no-plots"] if any("--no-plots" in option.opts for option in options) else []
    told = [word for option in chance.choices(options, k=chance.randrange(5)) for word in valued(option, chance)]
    return [*words, *plain, *told]


@pytest.fixture(name="folder")
def _folder(jkr, tmp_path: Path) -> Path:
    """What the verbs read."""
    for name, method, body in (("s", "closed-form", HALF_SPACE), ("l", "layered", LAYER)):
        Path(f"{name}.toml").write_text(CASE.format(method=method, body=body))
        assert jkr("run", f"{name}.toml").code == 0
    Path("many.toml").write_text(SWEEP)
    lines = RAW.read_bytes().splitlines()
    Path("raw.txt").write_bytes(b"\n".join(lines[:5] + lines[5::12]) + b"\n")
    a = np.linspace(1e-5, 9e-5, 30)
    E_star = 1e6 / (1 - 0.3**2)
    root = np.sqrt(2 * np.pi * 0.05 * a / E_star)
    delta, P = a**2 / 1e-3, 4 * E_star * a**3 / 3e-3
    for name, columns in (("h", (a, delta, P)), ("m", (a, delta - root, P - 2 * E_star * a * root))):
        table = np.column_stack([*columns, np.arange(30)])[:: -1 if name == "m" else 1]
        np.savetxt(f"{name}.csv", table, delimiter=",", header="a_m,delta_m,P_N,t_s", comments="")
    Path("p.csv").write_text("t_s,x_um\n0,0\n1,5\n2,-5\n")
    return tmp_path


def judge_line(chance: random.Random) -> None:
    words = line_of(chance)
    outcome(*words, json_out="--json" in words and "--show-case" not in words)  # that is a case


@some(12)
def test_options(seed: int, folder: Path, count: int) -> None:
    fuzz(chances(), judge_line, count, seed)


# ---------------------------------------------------------------------- raw records
def records(content: bytes) -> st.SearchStrategy[bytes]:
    """A raw record with some of its cells, lines and bytes changed."""

    def changed(chance: random.Random) -> bytes:
        lines = content.split(b"\n")
        for _ in range(chance.choice((0, 1, 2, 5))):
            at = chance.randrange(len(lines) if chance.random() < 0.5 else min(len(lines), 8))
            cells = lines[at].split(b";")
            match chance.randrange(5):
                case 0:
                    cells[chance.randrange(len(cells))] = chance.choice(TEXTS).encode("latin-1", "replace")
                case 1:
                    cells[chance.randrange(len(cells))] = b"%.4g" % 10.0 ** chance.uniform(-30, 30)
                case 2:
                    cells = cells[1:]
                case 3:
                    cells.append(chance.choice((b"0,1", b"Deflection [V]", b"trace", b"")))
                case 4:
                    lines[at:] = lines[at : at + chance.randrange(1, 60)]
            lines[at : at + 1] = [b";".join(cells)] * chance.choice((1, 1, 1, 2))
        found = b"\n".join(lines)
        return bytes_changed(found, chance) if chance.random() < 0.3 else found

    return chances().map(changed)


def judge_record(content: bytes) -> None:
    Path("r.txt").write_bytes(content)
    if outcome("look", "r.txt", "--no-plots", "--json", json_out=True) == 0 and len(content) % 10 == 0:
        body = ("--radius", "5 um", "--nu", "0.5", "--shape", "paraboloid")
        outcome("fit", "r.txt", *body, "--no-plots", "--force", "--json", json_out=True)


@some(20)
def test_raw_records(seed: int, folder: Path, count: int) -> None:
    fuzz(records(Path("raw.txt").read_bytes()), judge_record, count, seed)
