"""Titles, names of files, layers, columns, curves and segments that steer a terminal, or are TeX: printed as escapes by
every verb, drawn as they stand."""

import contextlib
import io
import json
from pathlib import Path
from xml.dom import minidom

import numpy as np
import pytest

from jkrcli.cli import call
from jkrcli.report.plots import drawing, save

NAME = "a\x9b31m\u202e$\\frac{$"  # C1, a change of direction, TeX that is none
WORD = "$\\frac$\x9b31m\u202e\x1b]0;x\x07"
TITLE = json.dumps(NAME + "\x1b")
BODIES = {
    "": ("closed-form", 'half_space = { E = "1 MPa", nu = 0.3 }'),
    "l": ("layered", f'layers = [{{ name = {TITLE}, thickness = "0.2 mm", E = "1 MPa", nu = 0.3 }}]'),
    "f": ("fem", f'layers = [{{ name = {TITLE}, thickness = "0.2 mm", E = "1 MPa", nu = 0.3 }}]'),
}
CASE = """
title = {title}
method = "{method}"
indenter = {{ shape = "paraboloid", radius = "1 mm" }}
specimen.{body}
loading = {{ radius = "0.1 mm", points = 12 }}
adhesion = {{ w = "50 mJ/m^2" }}
"""
SWEEP = f'base = {json.dumps(NAME + ".toml")}\n[[axes]]\nkey = "specimen.half_space.nu"\nvalues = [0.1, 0.4]\n'
H5, LAYER, CSV, SEGMENTS = f"{NAME}.h5", f"{NAME}l.h5", f"{NAME}.csv", f"{NAME}s.csv"
FAST = (
    ("check", f"{NAME}l.toml"), ("run", f"{NAME}l.toml", "-v", "-o", f"{NAME}2.h5"), ("pull-off", H5),
    ("show", H5, LAYER),
    ("import", f"{NAME}h.csv", "--case", f"{NAME}.toml", "-o", f"{NAME}i.h5"), ("explore", H5, CSV),
    ("look", CSV, "--no-plots"), ("look", CSV, "--column", f"P={WORD}"), ("transform", H5, "-v", "--no-plots"),
    ("cycle", H5, "--no-plots"), ("compare", H5, LAYER), ("sweep", f"{NAME}many.toml", "--show-case", "0"),
    ("pull-off", LAYER, "--load", "0.2 mN", "--uncertain", f"E:{NAME}=5%"), ("new", f"{NAME}n.toml"), ("doctor",),
    ("work", H5, CSV, "--no-plots"),
)  # fmt: skip
SLOW = (
    ("mesh", f"{NAME}f.toml"), ("transform", H5), ("profile", H5, "--a", "50 um"), ("fields", H5, "--a", "50 um"),
    ("look", SEGMENTS), ("fit", H5, CSV), ("fit", f"{NAME}l.toml", CSV, "--free", f"E:{NAME}\x1b"), ("work", H5, CSV),
    ("work", H5, SEGMENTS, "--segment", WORD), ("cycle", H5), ("study", "converge", f"{NAME}f.toml", "--levels", "2"),
    ("sweep", f"{NAME}many.toml", "-o", NAME, "--workers", "1"), ("bench", f"{NAME}l.toml", "--repeat", "1"),
)  # fmt: skip


@pytest.fixture(name="folder")
def _folder(jkr, tmp_path: Path) -> Path:
    for end, (method, body) in BODIES.items():
        Path(f"{NAME}{end}.toml").write_text(CASE.format(title=TITLE, method=method, body=body), encoding="utf-8")
    for end in ("", "l"):
        assert jkr("run", f"{NAME}{end}.toml").code == 0
    Path(f"{NAME}many.toml").write_text(SWEEP, encoding="utf-8")
    a, E = np.linspace(9e-5, 1e-5, 30), 1e6 / (1 - 0.3**2)
    root = np.sqrt(2 * np.pi * 0.05 * a / E)
    delta, P = a**2 / 1e-3, 4 * E * a**3 / 3e-3
    pulled = a, delta - root, P - 2 * E * a * root, np.arange(30), a
    for path, head, rows, words in (
        (f"{NAME}h.csv", "a_m,delta_m,P_N", zip(a[::-1], delta[::-1], P[::-1], strict=True), ("",) * 30),
        (CSV, f"a_m,delta_m,P_N,t_s,{WORD},curve", zip(*pulled, strict=True), (WORD,) * 30),
        (SEGMENTS, "a_m,delta_m,P_N,t_s,x,segment", zip(*pulled, strict=True), ("approach",) * 15 + (WORD,) * 15),
    ):
        lines = (",".join([*(f"{x:.9g}" for x in row), *[word][: len(word)]]) for row, word in zip(rows, words))  # noqa: B905
        Path(path).write_text("\n".join([head, *lines]) + "\n", encoding="utf-8")
    return tmp_path


@pytest.mark.parametrize("words", [*FAST, *(pytest.param(words, marks=pytest.mark.slow) for words in SLOW)],
                         ids=lambda words: words[0])  # fmt: skip
def test_no_verb_prints_what_steers_a_terminal(folder: Path, words: tuple[str, ...]) -> None:
    given = set(folder.rglob("*"))
    out, err = io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        code = call(list(words))
    assert code in (0, 2), err.getvalue()
    assert all(map(str.isprintable, out.getvalue().split("\n")))
    assert all(line.startswith("jkr: ") and line.isprintable() for line in err.getvalue().splitlines())
    for path in folder.rglob("*.svg"):
        minidom.parse(str(path))
    for path in {*folder.rglob("*.csv"), *folder.rglob("*.json")} - given:
        assert all(map(str.isprintable, path.read_text(encoding="utf-8").split("\n"))), path.name


@pytest.mark.parametrize("word", [NAME, WORD, "$x$", "a$", "\x00", "接着"])
def test_foreign_words_are_drawn_as_they_stand(tmp_path: Path, word: str, capfd: pytest.CaptureFixture[str]) -> None:
    with drawing(2, 2) as figure:
        figure.subplots().set_title(word)
        save(figure, [tmp_path / "x.svg", tmp_path / "x.png"])
    minidom.parse(str(tmp_path / "x.svg"))
    assert capfd.readouterr().err == ""
