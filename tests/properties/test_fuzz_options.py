"""Any options of any verb, and raw records changed: a result, or exit code 2 with one line per mistake, as in
``test_fuzz``; among them adhesion of finite range, programs of speed and laws of rate."""

import random
from itertools import chain
from pathlib import Path

import click
import hypothesis.strategies as st
import pytest
from every_verb import BASES, options_of, typed, verb_of, write_inputs
from fuzzing import NASTY, bytes_changed, chances, fuzz, outcome, some

LONG = ("study", "fields", "mesh", "fit", "bench", "profile", "sweep", "explore", "work", "cycle:relaxing")
DEAR = [base for base in BASES if base.startswith(LONG)]  # they come once in twenty
CHEAP = [base for base in BASES if base not in DEAR]
LEFT_OUT = {  # would start other processes, look for other machines, or take long as they should
    "--scheduler", "--workers", "--limit-time", "--limit-memory", "--hours", "--levels", "--repeat", "--samples",
    "--confidence",
}  # fmt: skip
TEXTS = [word for word in NASTY if isinstance(word, str)]
BAD = [*TEXTS, "1e308", "1e999", "-1", "nan", "-inf", "9" * 400, "=", "a=", "P=nan", "w=..", "law=x", "\udcff", "5 %"]
PLACES = ("", " ", "a\nb", "\x1b[31mred", "gel.h5", "gel.toml", "\udcff.h5", "x" * 500)  # names that nothing is lost by


def valued(base: str, option: click.Option, chance: random.Random) -> list[str]:
    if option.is_flag or chance.random() < 0.75:
        return [*typed(base, option)]
    return [option.opts[-1], chance.choice(PLACES if option.type.name in ("path", "directory") else BAD)]


def line_of(chance: random.Random) -> list[str]:
    """A command line with up to four options, without pictures where it can do without."""
    base = chance.choice(DEAR if chance.random() < 0.05 else CHEAP)
    options = [item for item in options_of(base) if item.opts[-1] not in LEFT_OUT]
    plain = ["--no-plots"] if any("--no-plots" in option.opts for option in options) else []
    told = [valued(base, option, chance) for option in chance.choices(options, k=chance.randrange(5) * bool(options))]
    return [*verb_of(base).split(), *BASES[base], *plain, *chain(*told)]


@pytest.fixture(name="folder")
def _folder(jkr, tmp_path: Path) -> None:
    write_inputs(tmp_path, jkr)


def judge_line(chance: random.Random) -> None:
    words = line_of(chance)
    outcome(*words, json_out="--json" in words and "--show-case" not in words)  # that is a case


@some(12)
def test_options(seed: int, folder: Path, count: int) -> None:
    fuzz(chances(), judge_line, count, seed)


def records(content: bytes) -> st.SearchStrategy[bytes]:
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


@some(12)
def test_raw_records(seed: int, folder: Path, count: int) -> None:
    lines = Path("raw.txt").read_bytes().splitlines()
    fuzz(records(b"\n".join(lines[:5] + lines[5::12]) + b"\n"), judge_record, count, seed)
