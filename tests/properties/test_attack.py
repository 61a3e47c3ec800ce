"""What an attacker found, each kept as a test: foreign names, numbers beyond sense, interrupts, words for terminals."""

from __future__ import annotations

import csv
import os
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from series_files import edit

from jkrcli.base.errors import InputError
from jkrcli.base.table import write_csv
from jkrcli.case import parse_case

ROOT = Path(__file__).parents[2]
HALF_SPACE = ROOT / "cases" / "halfspace.toml"
CASE = """
title = "{title}"
method = "closed-form"
indenter = {{ shape = "paraboloid", radius = "1 mm" }}
specimen.half_space = {{ E = "1 MPa", nu = 0.3 }}
loading = {{ radius = "0.1 mm", points = 20 }}
adhesion = {{ w = "50 mJ/m^2" }}
"""
SWEEP = """
[base]
method = "closed-form"
indenter = { shape = "paraboloid", radius = "1 mm" }
specimen.half_space = { E = "1 MPa", nu = 0.3 }
loading = { radius = "0.1 mm" }
adhesion = { w = "50 mJ/m^2" }
[[axes]]
key = "specimen.half_space.nu"
from = 0.1
to = 0.4
count = 400
"""


@pytest.fixture(name="series")
def _series(jkr, tmp_path: Path) -> Path:
    """A solved case beside its file."""
    (tmp_path / "s.toml").write_text(CASE.format(title="plain"))
    assert jkr("run", "s.toml").code == 0
    return tmp_path / "s.h5"


# ---------------------------------------------------------------------- numbers
@pytest.mark.parametrize("sizes", ["[[1]]", "[[]]", "[{}]"])
def test_a_list_in_place_of_a_size_is_refused(sizes: str) -> None:
    text = CASE.format(title="") + f'mesh = {{ layout = "zones", zone_sizes = {sizes} }}\n'
    with pytest.raises(InputError, match=r"mesh\.zone_sizes"):
        parse_case(text.encode(), "x.toml")


@pytest.mark.parametrize("w", ["1e300", "1e150", "1.1e30", "1e-31"])
def test_works_beyond_sense_are_refused(jkr, series: Path, w: str) -> None:
    for words in (("transform",), ("pull-off",), ("explore",), ("profile", "--a", "50 um")):
        done = jkr(words[0], series.name, *words[1:], "--w", w)
        assert (done.code, done.err.count("\n")) == (2, 1)
        assert "must lie within 1e-30 and 1e+30" in done.err


def test_more_workers_than_any_machine_has_are_refused(jkr, series: Path) -> None:
    (series.parent / "many.toml").write_text(SWEEP)
    for words in (("sweep", "many.toml"), ("work", series.name, "x.csv"), ("fit", series.name, "x.csv")):
        done = jkr(*words, "--workers", "9" * 400)
        assert (done.code, "--workers" in done.err) == (2, True)


def test_a_time_that_is_no_number_is_shown(jkr, series: Path) -> None:
    edit(series, lambda file: file["timings_s"].attrs.__setitem__("solve", float("nan")))
    assert "time      solve: nan s CPU" in jkr("show", series).out


# ---------------------------------------------------------------------- names
def test_an_empty_name_is_refused(jkr) -> None:
    for verb in ("explore", "transform", "run", "show", "bench", "check"):
        done = jkr(verb, "")
        assert (done.code, done.err.count("\n")) == (2, 1), verb


def test_names_that_are_no_text_work(jkr, series: Path) -> None:
    name = os.fsdecode(b"x\xff")
    shutil.copy("s.toml", f"{name}.toml")
    rows = [f"{a}e-5,{a**3}e-6" for a in range(1, 9)]
    Path(f"{name}.csv").write_text("\n".join(["a_m,P_N", *rows]) + "\n")
    lines = (("run", f"{name}.toml"), ("explore", f"{name}.h5"), ("fit", f"{name}.h5", f"{name}.csv"),
             ("work", f"{name}.h5", f"{name}.csv"), ("show", f"{name}.h5"), ("transform", f"{name}.h5"),
             ("bench", f"{name}.toml", "--repeat", "1"))  # fmt: skip
    for line in lines:
        done = jkr(*line)
        assert done.code == 0, done.err
    assert jkr("show", f"{name}.h5").out.count("jkr run 'x\\udcff.toml'") == 1


def test_a_name_that_looks_like_an_option_is_benched(jkr, series: Path) -> None:
    shutil.copy("s.toml", "-x.toml")
    assert jkr("bench", "./-x.toml", "--repeat", "1").code == 0


def test_make_run_takes_spaces_and_apostrophes(tmp_path: Path) -> None:
    venv = tmp_path / "venv"
    (venv / "bin").mkdir(parents=True)
    (venv / ".ready").touch()
    script = venv / "bin" / "jkr"
    script.write_text(f'#!/bin/sh\nfor word in "$@"; do echo "<$word>" >> {tmp_path}/words; done\n')
    script.chmod(0o755)
    results = tmp_path / "Anna's new results"
    words = ("run", f"VENV={venv}", "CASE=Bob's case.toml", f"RESULTS={results}", "W=50")
    subprocess.run(["make", "-s", "-C", ROOT, "-o", f"{venv}/.ready", *words], check=True, capture_output=True)
    target = f"<{results}/Bob's case.h5>"
    assert (tmp_path / "words").read_text().splitlines() == [
        "<run>", "<Bob's case.toml>", "<-o>", target, "<transform>", target, "<--w>", "<50>", "<-o>", f"<{results}>",
    ]  # fmt: skip
    assert results.is_dir()


# ---------------------------------------------------------------------- words
def test_no_word_of_a_foreign_file_steers_the_terminal(jkr, series: Path) -> None:
    escape = "\x1b]0;owned\x07\x9b31m"
    for group in ("facts", "versions", "timings_s", "warnings"):
        edit(series, lambda file, group=group: file[group].attrs.__setitem__("x", escape))
    edit(series, lambda file: file.attrs.__setitem__("command_line", escape))
    for verb in ("show", "transform"):
        done = jkr(verb, series)
        assert done.code == 0
        assert all(line.isprintable() for line in (done.out + done.err).splitlines())


def test_no_word_in_a_table_is_a_formula(tmp_path: Path) -> None:
    words = ["=1+1", "+1", "-1", "@x", "\t=1", "plain"]
    write_csv(tmp_path / "x.csv", {"word": words, "number": [-1.0, 2, 3, 4, 5, 6]})
    with (tmp_path / "x.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    assert [row["word"] for row in rows] == [*(f"'{word}" for word in words[:-1]), "plain"]
    assert [row["number"] for row in rows] == ["-1.0", "2", "3", "4", "5", "6"]


def test_completion_without_a_shell_is_answered_in_words(jkr) -> None:
    done = jkr("completion")
    assert done.err == (
        "jkr: error: missing argument '{bash|zsh|fish}'. Choose from: bash, zsh, fish; see jkr completion --help\n"
    )


def test_a_complex_number_in_a_series_is_damage(jkr, series: Path) -> None:
    edit(series, lambda file: file["series"].attrs.__setitem__("a0_m", 1 + 2j))
    done = jkr("show", series)
    assert (done.code, done.err) == (
        2,
        f"jkr: error: {series}: the HDF5 file is damaged and cannot be read; run the case again\n",
    )


# ---------------------------------------------------------------------- guards
def test_a_file_of_keys_is_refused_before_it_is_read(jkr, tmp_path: Path) -> None:
    (tmp_path / "keys.toml").write_text("".join(f"k{i}=1\n" for i in range(1_500_000)))
    start = time.process_time()
    done = jkr("check", "keys.toml")
    assert time.process_time() - start < 2
    assert (done.code, done.err) == (
        2,
        "jkr: error: keys.toml: holds about 1,500,000 keys, at most 10,000 are read\n",
    )


def test_a_long_sweep_is_announced_before_its_cases_are_looked_at(
    jkr, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def looked(*_: object) -> str:
        raise KeyboardInterrupt

    monkeypatch.setattr("jkrcli.many.sweep.plan.Plan.identity", looked)
    more = '[[axes]]\nkey = "adhesion.w"\nfrom = 0.01\nto = 0.1\ncount = 2000\n'
    (tmp_path / "big.toml").write_text(SWEEP.replace("count = 400", "count = 1000") + more)
    start = time.process_time()
    done = jkr("sweep", "big.toml", "-o", "r")
    assert time.process_time() - start < 4, "2 s, on a machine that is not slowed down by others"
    assert done.code == 130
    assert done.err.startswith("jkr: 2,000,000 cases: looking through them takes about 13 min of CPU time before ")


# ---------------------------------------------------------------------- interrupts
def interrupted(folder: Path, words: tuple[str, ...], seconds: float) -> tuple[int, str]:
    """Exit code and stderr of a command that is sent Ctrl-C so many ``seconds`` after jkrcli began to be imported."""
    ready = "import os, sys; os.write(1, b'.'); from jkrcli.__main__ import main; sys.argv[0] = 'jkr'; main()"
    process = subprocess.Popen(
        [sys.executable, "-c", ready, *words], cwd=folder, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )
    assert process.stdout is not None
    process.stdout.read(1)
    time.sleep(seconds)
    process.send_signal(signal.SIGINT)
    _, err = process.communicate(timeout=60)
    return process.returncode, err


VERBS = {
    "run": ("run", str(HALF_SPACE), "-o", "r.h5"),
    "transform": ("transform", "s.h5"),
    "sweep": ("sweep", "many.toml", "-o", "r", "--workers", "2"),
    "check": ("check", "s.toml"),
}


@pytest.mark.parametrize("verb", VERBS)
def test_interrupts_at_any_moment_are_one_line(series: Path, verb: str) -> None:
    """From 0.1 s after the first import (the interpreter's own is not ours) to the end."""
    (series.parent / "many.toml").write_text(SWEEP)
    for i in range(10):
        code, err = interrupted(series.parent, VERBS[verb], 0.1 + 0.19 * i)
        last = err.splitlines()[-1:]
        assert "Traceback" not in err, err
        assert "KeyboardInterrupt" not in err, err
        if code not in (0, -signal.SIGINT):  # the latter: after everything, while the interpreter itself ends
            assert (code, last) == (130, ["jkr: error: interrupted; nothing half-written was left"]), err
