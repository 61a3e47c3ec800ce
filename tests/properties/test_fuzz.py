"""Any bytes for a file and any options of any verb: a result, or exit code 2 with one line per mistake. Never a
traceback, a hang, a memory hog.

The fast tests try some inputs of each kind, the slow ones 10,000, from a fixed seed; ``make fuzz SEED=...`` tries
others.
"""

import contextlib
import random
import tomllib
from collections.abc import Callable
from functools import partial
from itertools import chain
from pathlib import Path
from typing import Any

import click
import hypothesis.strategies as st
import numpy as np
import pytest
import tomli_w
from every_verb import BASES, options_of, typed, verb_of, write_inputs
from fuzzing import NASTY, bounded, bytes_changed, chances, fuzz, mutate, outcome, some

from jkrcli.base.errors import JkrError
from jkrcli.case.models import load_case, method_of
from jkrcli.methods.protocol import survey

CASES = Path(__file__).parents[2] / "cases"
QUICK = 0.1  # CPU seconds of a solve that is tried as well

SMALL = {
    "paraboloid": {"shape": "paraboloid", "radius": "6 mm", "counter_radius": "1 m"},
    "power": {"shape": "power", "coefficient": 2e3, "exponent": 2.5},
    "cone": {"shape": "cone", "half_angle": "80 deg"},
    "flat": {"shape": "flat", "flat_radius": "10 um", "edge_radius": "1 mm"},
    "table": {"shape": "table", "r": [0.0, 1e-5, 2e-5, 4e-5], "f": [0.0, 1e-7, 4e-7, 16e-7]},
    "elastic": {"shape": "sphere", "radius": "100 um", "E": "70 GPa", "nu": 0.2},
}
ADHESIVE: list[dict[str, Any]] = [  # what tables of adhesion hold, and surfaces
    {"adhesion": {"w": "50 mJ/m^2", "stress": "1 MPa"}},
    {"adhesion": {"w": ["35 mJ/m^2", 0.04], "range": "2 nm", "z0": "0.3 nm"}},
    {"adhesion": {"capillary": {"surface_tension": "72 mN/m", "humidity": 0.5, "contact_angles": [20.0, 40.0]}}},
    {"adhesion": {"capillary": {"surface_tension": 0.072, "kelvin_radius": "1 nm", "contact_angles": 10.0}}},
    {"method": "fem", "specimen": {"half_space": {"E": "5 MPa", "nu": 0.4}, "surface": "sticking"}},
    {"specimen": {"layers": [{"thickness": "10 um", "E": "5 MPa", "nu": 0.45}], "surface": "sticking"}},
]
HALF_SPACE = {"specimen": {"half_space": {"E": "5 MPa", "nu": 0.4}}, "loading": {"radius": "20 um", "points": 20}}


def trees() -> list[dict[str, Any]]:
    shipped = [tomllib.loads(path.read_text(encoding="utf-8")) for path in sorted(CASES.glob("*.toml"))]
    shapes = [{"indenter": indenter, **HALF_SPACE} for indenter in SMALL.values()]
    return [*shipped, *shapes, *({**shapes[0], **tables} for tables in ADHESIVE)]


def sweeps() -> list[dict[str, Any]]:
    found = []
    for path in sorted((CASES / "sweeps").glob("*.toml")):
        tree = tomllib.loads(path.read_text(encoding="utf-8"))
        if isinstance(tree["base"], str):
            tree["base"] = tomllib.loads((path.parent / tree["base"]).read_text(encoding="utf-8"))
        found.append(tree)
    return found


def toml_of(tree: dict[str, Any], chance: random.Random) -> bytes:
    content = tomli_w.dumps(mutate(tree, chance)).encode()
    return bytes_changed(content, chance) if chance.random() < 0.3 else content


def files_like(valid: list[dict[str, Any]]) -> st.SearchStrategy[bytes]:
    return chances().map(lambda chance: toml_of(chance.choice(valid), chance)) | st.binary(max_size=200)


@pytest.fixture(name="write")
def _write(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Callable[[str, bytes], Path]:
    monkeypatch.chdir(tmp_path)

    def write(name: str, content: bytes) -> Path:
        path = tmp_path / name
        path.write_bytes(content)
        return path

    return write


Judge = Callable[[bytes], None]


@pytest.fixture(name="judge_case")
def _judge_case(write: Callable[[str, bytes], Path]) -> Judge:
    """Validation, all refusals and forecasts; where that promises to be quick, the coarse expectation as well."""

    def judge(content: bytes) -> None:
        path = write("x.toml", content)
        with bounded(), contextlib.suppress(JkrError):
            model = load_case(path).model
            layered = survey(model.problem(), partial(method_of, model))[1].forecast
            if layered is not None and layered.seconds > QUICK:
                return
        outcome("check", path, "--json", json_out=True)

    return judge


@some(25)
def test_cases(seed: int, judge_case: Judge, count: int) -> None:
    fuzz(files_like(trees()), judge_case, count, seed)


def hertz() -> list[list[float]]:
    a = np.linspace(1e-6, 2e-5, 12)
    return np.column_stack([a, a**2 / 6e-3, 4 * 6e6 * a**3 / (3 * 6e-3)]).tolist()


def adhesive() -> list[list[float]]:
    a = np.linspace(1e-6, 2e-5, 12)
    root = np.sqrt(2 * np.pi * 0.05 * a / 6e6)
    return np.column_stack([a, a**2 / 6e-3 - root, 4 * 6e6 * a**3 / (3 * 6e-3) - 2 * 6e6 * a * root]).tolist()


HEADS = [
    ["a_m", "delta_m", "P_N"], ["a (m)", "delta (m)", "P (N)"], ["contact radius [m]", "U2 [m]", "RF2 [N]"],
    ["a", "delta", "P"], ["A_m^2", "delta_m", "P_N"], ["a_um", "delta_um", "P_mN"], ["t_s", "delta_m", "P_N"],
    ["a_m", "P_N", "segment"], ["curve", "delta_m", "P_N"], ["Weg hin (m)", "Kraft hin (N)", "Kraft zurück (N)"],
    ["Weg in m", "Kraft in N", "12:00:01"],
]  # fmt: skip
CELLS = ["", "nan", "inf", "-inf", "1e999", "x", "1,5", "1.5", "-1", "0", "1e-400", "9" * 400, '"', "0x10", "١", "1d-6",
         "retract", "approach", "#", "1e-6 m", "[Retract]", "12:00", "\0", "\x1b[0m", "é"]  # fmt: skip


def table_of(rows: list[list[float]], chance: random.Random) -> bytes:
    head = chance.choice(HEADS[:3] if chance.random() < 0.7 else HEADS)
    text = [list(head), *([f"{value:.9g}" for value in row] for row in rows)]
    for _ in range(chance.choice((0, 1, 2, 5))):
        row = chance.choice(text)
        match chance.randrange(6):
            case 0 if row:
                row[chance.randrange(len(row))] = chance.choice(CELLS)
            case 1 if row:
                row.pop()
            case 2:
                row.append(chance.choice(CELLS))
            case 3:
                chance.shuffle(text)
            case 4:
                text.insert(chance.randrange(len(text)), list(row))
            case 5 if row[-1:] and row[0][:1].isdigit():
                row[chance.randrange(len(row))] = f"{10.0 ** chance.uniform(-320, 300):.6g}"
    if chance.random() < 0.1:  # curves or segments beside each other
        text = [row + row for row in text]
        text[0] = chance.choice((text[0], [f"{cell} {'hin' if i < 3 else 'rt'}" for i, cell in enumerate(text[0])]))
        text[:0] = chance.choice(([], [["Approach", "", "", "Retract"]], [["A", "", "", "B"]]))
    mark, end = chance.choice((",", ";", "\t", "  ")), chance.choice(("\n", "\r\n", "\r"))
    content = end.join(mark.join(row) for row in text)
    if chance.random() < 0.2:
        content = content.replace(".", ",")
    data = content.encode(chance.choice(("utf-8", "utf-8", "utf-8-sig", "utf-16")), errors="replace")
    return bytes_changed(data, chance) if chance.random() < 0.3 else data


def tables_like(rows: list[list[float]]) -> st.SearchStrategy[bytes]:
    return (
        chances().map(lambda chance: table_of(rows, chance))
        | st.binary(max_size=200)
        | st.text(max_size=200).map(lambda text: text.encode("utf-8", errors="surrogatepass"))
    )


@pytest.fixture(name="judge_import")
def _judge_import(write: Callable[[str, bytes], Path]) -> Judge:
    body = ("--shape", "paraboloid", "--radius", "6 mm", "--E", "5 MPa", "--nu", "0.4", "-o", "x.h5", "--json")

    def judge(content: bytes) -> None:
        if outcome("import", write("x.csv", content), *body, json_out=True) == 0:
            outcome("transform", "x.h5", "--w", "0.05", "--no-plots", "--force", "--json", json_out=True)

    return judge


@some(20)
def test_imports(seed: int, judge_import: Judge, count: int) -> None:
    fuzz(tables_like(hertz()), judge_import, count, seed)


@pytest.fixture(name="judge_measured")
def _judge_measured(write: Callable[[str, bytes], Path]) -> Judge:
    body = tomli_w.dumps({"indenter": SMALL["paraboloid"], **HALF_SPACE}).encode()
    assert outcome("run", write("body.toml", body), "-o", "body.h5") == 0

    def judge(content: bytes) -> None:
        if outcome("work", "body.h5", write("x.csv", content), "--no-plots", "--force", "--json", json_out=True) == 0:
            outcome("fit", "body.h5", "x.csv", "--no-plots", "--force", "--json", json_out=True)

    return judge


@some(15)
def test_measured_curves(seed: int, judge_measured: Judge, count: int) -> None:
    fuzz(tables_like(adhesive()), judge_measured, count, seed)


@pytest.fixture(name="judge_sweep")
def _judge_sweep(write: Callable[[str, bytes], Path]) -> Judge:
    def judge(content: bytes) -> None:
        outcome("sweep", write("x.toml", content), "--show-case", 0)

    return judge


@some(30)
def test_sweeps(seed: int, judge_sweep: Judge, count: int) -> None:
    fuzz(files_like(sweeps()), judge_sweep, count, seed)


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
