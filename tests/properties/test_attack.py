"""What an attacker found, each kept as a test: foreign names, numbers beyond sense, interrupts, words for terminals."""

import csv
import os
import re
import subprocess
import sys
from pathlib import Path
from unittest.mock import Mock

import h5py
import pytest
import sweep_files
from series_files import CASE, edit, lengthened
from stopwatch import takes_less_than

from jkrcli.base.files import write_csv
from jkrcli.case.models import parse_case, plain_toml
from jkrcli.many.sweep_plan import load_plan

SWEEP = (
    sweep_files.HALF_SPACE
    + """[[axes]]
key = "specimen.half_space.nu"
from = 0.1
to = 0.4
count = 400
"""
)


WORKS = [(*words, "--w", w) for w in ("1e300", "1.1e30", "1e-31") for words in (
    ("transform", "s.h5"), ("pull-off", "s.h5"), ("explore", "s.h5"), ("profile", "s.h5", "--a", "50 um"))]  # fmt: skip
WORKERS = [(*words, "--workers", "9" * 400) for words in (
    ("sweep", "many.toml"), ("work", "s.h5", "m.csv"), ("fit", "s.h5", "m.csv"))]  # fmt: skip
LIMITS = [  # with one that is no number every comparison is wrong: nothing was too much, and nothing agreed
    ("transform", "s.h5", "--limit-time"), ("compare", "s.h5", "s.h5", "--rtol"), ("sweep", "many.toml", "--hours"),
]  # fmt: skip
LONG = "9" * 400 + ".h5"
REFUSED: dict[str, list[tuple[tuple[str, ...], str]]] = {
    "works beyond sense": [(words, "must lie between 1e-30 and 1e+30") for words in WORKS],
    "a fixed work beyond sense": [(("fit", "s.h5", "m.csv", "--fix", "w=1e300"), "fit: w: must lie between 1e-30 and")],
    "more workers than any machine has": [(words, "--workers") for words in WORKERS],
    "limits that are no numbers": [((*words, "nan"), f"'{words[-1]}': nan is not in the range") for words in LIMITS],
    "empty names": [((verb, ""), "") for verb in ("explore", "transform", "run", "show", "bench", "check")],
    "a circle of links": [((*words, "-o", "loop"), "") for words in (
        ("transform", "s.h5"), ("profile", "s.h5", "--a", "50 um"))],
    "a name that no file can have": [((*words, "-o", LONG), f"{LONG}: cannot be written (File name too long)")
                                     for words in (("run", "s.toml"), ("explore", "s.h5"))],
}  # fmt: skip


@pytest.mark.parametrize("what", REFUSED)
def test_what_no_verb_takes_is_refused_in_one_line(jkr, series: Path, what: str) -> None:
    Path("many.toml").write_text(SWEEP)
    Path("m.csv").write_text("delta_m,P_N\n" + "".join(f"{i}e-7,{i**1.5:.6g}e-6\n" for i in range(1, 40)))
    Path("loop").symlink_to("loop")
    for words, said in REFUSED[what]:
        jkr(*words).refused(said)


STEERING = "\x9b31m\u202e"


def test_a_case_that_is_shown_steers_no_terminal_and_reads_back(jkr, series: Path) -> None:
    """TOML allows C1 controls and changes of direction as they are; escaped they are the same values."""
    before = parse_case(read_text(series), "x").model
    text = "# \x85\n" + read_text(series).decode().replace('"plain"', f"'{STEERING}'")
    edit(series, lambda file: _replace(file, "case", text))
    done = jkr("show", "--case", series).ok
    assert all(map(str.isprintable, done.out.split("\n")))
    again = parse_case(done.out.encode(), "x").model
    assert again.title == STEERING
    assert again.problem().key == before.problem().key
    assert plain_toml(done.out) == done.out


def read_text(series: Path) -> bytes:
    with h5py.File(series) as file:
        return bytes(file["case"][()])


def _replace(file: h5py.File, name: str, text: str) -> None:
    del file[name]
    file[name] = text


def test_no_word_in_a_table_is_a_formula(tmp_path: Path) -> None:
    words = ["=1+1", "+1", "-1", "@x", "plain"]
    write_csv(tmp_path / "x.csv", {"word": words, "number": [-1.0, 2, 3, 4, 5]})
    with (tmp_path / "x.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    assert [row["word"] for row in rows] == [*(f"'{word}" for word in words[:-1]), "plain"]
    assert [row["number"] for row in rows] == ["-1.0", "2", "3", "4", "5"]


def bombs(most: int) -> dict[str, str]:
    return {
        "keys": "".join(f"k{i}=1\n" for i in range(most // 10)),
        "tables": "".join(f"[k{i}]\n" for i in range(most // 10)),
        "values": "x = [" + "1," * (most // 2 - 9) + "]",
        "layers": "[[specimen.layers]]\n" * (most // 20),
        "parts": "".join(f"a{i}" + ".a" * 40 + "=1\n" for i in range(most // 100)),
        "one key": "a" + ".a" * (most // 2 - 9) + " = 1",
        "no quotes": "".join(f"k{i} = 5 um\n" for i in range(most // 16)),
        "brackets": "x = " + "[" * (most - 9),
        "digits": "x = " + "9" * (most - 9),
    }


@pytest.mark.first(4)
@pytest.mark.parametrize("name", bombs(0))
def test_a_file_of_as_much_as_can_be_is_refused_soon(jkr, name: str, tuned) -> None:
    """An eighth of what is read, in an eighth of the time; each mistake is told, of very many the first."""
    tuned("jkrcli.case.models.MOST_BYTES", 1 << 18)
    Path("x.toml").write_text(bombs(1 << 18)[name])
    with takes_less_than(2):
        done = jkr("check", "x.toml")
    assert done.code == 2
    assert done.err.count("\n") <= 202
    assert all(line.startswith("jkr: error: x.toml: ") for line in done.err.splitlines())


def test_a_long_sweep_is_announced_before_its_cases_are_looked_at(jkr, tmp_path, monkeypatch) -> None:
    def looked(*_: object) -> str:
        raise KeyboardInterrupt

    monkeypatch.setattr("jkrcli.many.sweep_plan.Plan.identity", looked)
    more = '[[axes]]\nkey = "adhesion.w"\nfrom = 0.01\nto = 0.1\ncount = 2000\n'
    (tmp_path / "big.toml").write_text(SWEEP.replace("count = 400", "count = 1000") + more)
    with takes_less_than(2):
        done = jkr("sweep", "big.toml", "-o", "r")
    assert done.code == 130
    assert done.err.startswith("jkr: 2,000,000 cases: checking them takes about 13 min of CPU time before ")


def test_works_and_moduli_count_as_no_solves_of_their_own(tmp_path: Path) -> None:
    """They may share a solve, so that a sweep over them is not refused for what it does not cost."""
    axes = [("specimen.half_space.nu", 4), ("specimen.half_space.E", 5), ("adhesion.w", 6)]
    text = SWEEP.split("[[axes]]")[0]
    text += "".join(f'[[axes]]\nkey = "{key}"\nfrom = 0.1\nto = 0.4\ncount = {count}\n' for key, count in axes)
    (tmp_path / "shared.toml").write_text(text)
    plan = load_plan(tmp_path / "shared.toml")
    assert (plan.count, plan.least_solves) == (120, 4)
    assert len(plan.groups(range(0, 120, 6), most=10**6)[0]) == 4


@pytest.mark.first(3)
@pytest.mark.parametrize("verb", [
    ("transform",), ("pull-off", "--load", "0.1 mN"), ("profile", "--load", "-50 uN"), ("pull-off",), ("cycle",),
    ("explore",),
], ids=" ".join)  # fmt: skip
def test_a_long_series_is_announced_or_refused_before_it_is_begun(jkr, series: Path, verb: tuple[str, ...]) -> None:
    lengthened(series, 100_000)
    done = jkr(verb[0], series.name, *verb[1:], "--limit-memory", 0.3)
    assert done.code == 2
    assert done.err.startswith(
        f"jkr: error: {verb[0]}{' --load' * (verb[:2] == ('pull-off', '--load'))} of 100,000 rows"
    )
    needs = re.search(r" would need about ([\d.]+) GiB of memory and ", done.err)
    assert 0.39 < float(needs[1]) < 1.5  # by the verb's rows and curves


def test_many_works_of_adhesion_are_refused_before_they_begin(jkr, series: Path) -> None:
    words = [word for i in range(20_000) for word in ("--w", str(0.01 + 1e-6 * i))]
    jkr("transform", series.name, *words).refused(
        "works of adhesion would need about 12.3 GiB of memory and 3.51 h of CPU time, the limit is"
    )


def test_a_huge_profile_is_refused_before_it_is_read(jkr, series: Path) -> None:
    with Path("big.csv").open("wb") as file:
        file.truncate(900 << 20)
    text = CASE.replace('shape = "paraboloid", radius = "1 mm"', 'shape = "table", file = "big.csv"')
    Path("big.toml").write_text(text)
    jkr("check", "big.toml").refused("big.toml: indenter: big.csv: profile file is larger than 4 MiB")
    assert "big.csv: table is larger than 256 MiB" in jkr("look", "big.csv").err


@pytest.mark.parametrize("count", ["[1, 1]", "nan", "true", "1.5"])
def test_a_count_of_layers_that_is_no_number_is_refused(jkr, tmp_path: Path, count: str) -> None:
    layers = '[[base.specimen.layers]]\nthickness = "1 um"\nE = "1 MPa"\nnu = 0.3\n'
    text = SWEEP.replace('specimen.half_space = { E = "1 MPa", nu = 0.3 }\n', "").split("[[axes]]")[0] + layers
    axis = f'[[axes]]\nkey = "specimen.layers.count"\nvalues = [1, {count}]\n'
    (tmp_path / "count.toml").write_text(text.replace("closed-form", "layered") + axis)
    done = jkr("sweep", "count.toml", "--show-case", 0)
    assert done.code == 2
    assert all(line.startswith("jkr: error: ") for line in done.err.splitlines())


@pytest.mark.skipif(sys.platform != "linux", reason="limits of the address space are Linux's")
def test_little_address_space_ends_in_one_line(series: Path) -> None:
    limited = 'ulimit -v 300000; exec "$@"'
    words = ("sh", "-c", limited, "sh", sys.executable, "-m", "jkrcli", "run", "s.toml", "--method", "layered")
    done = subprocess.run([*words, "-o", "r.h5"], cwd=series.parent, capture_output=True, text=True, timeout=60)
    assert (done.returncode == 0) == (series.parent / "r.h5").exists()
    assert done.stderr.startswith("jkr: warning: the address space is limited to 292 MiB: libraries may not load")
    assert "Traceback" not in done.stderr


def test_a_library_that_finds_no_room_is_out_of_memory_and_one_that_is_not_there_is_not(
    jkr, series: Path, monkeypatch
) -> None:
    errors = map(ImportError, ("x.so: failed to map segment from shared object", "std::bad_alloc", "no module"))
    monkeypatch.setattr("jkrcli.cli.file_verbs.read_series", Mock(side_effect=errors))
    for _ in range(2):
        done = jkr("show", series)
        assert (done.code, done.err.startswith("jkr: error: out of memory: ")) == (1, True)
    with pytest.raises(ImportError, match="no module"):
        jkr("show", series)


def test_a_mesh_goes_into_a_folder_whose_name_is_no_text(jkr, series: Path) -> None:
    folder = os.fsdecode(b"x\xff")
    (series.parent / "f.toml").write_text(CASE.replace("closed-form", "fem"))
    assert jkr("mesh", "f.toml", "-o", folder).code == 0
    assert Path(folder, "f-mesh.msh").read_bytes().startswith(b"$MeshFormat\n")


def test_a_cycle_without_adhesion_has_no_loop_to_enlarge(jkr, series: Path) -> None:
    done = jkr("cycle", series.name, "--w-approach", "0")
    assert (done.code, done.err) == (0, "")


def program(*words: str, **environment: str) -> subprocess.CompletedProcess[str]:
    """The console script in the folder at hand, where ``python -m`` would look for modules too."""
    starts = [sys.executable, "-P", "-c", "from jkrcli.__main__ import main; main()"]
    return subprocess.run([*starts, *words], capture_output=True, text=True, check=False, env=os.environ | environment)


@pytest.mark.slow
def test_modules_in_the_folder_at_hand_are_not_imported(series: Path) -> None:
    for name in ("numpy", "json", "multiprocessing", "tomllib", "sitecustomize"):
        Path(f"{name}.py").write_text("raise SystemExit(77)\n")
    Path("sweep.toml").write_text(SWEEP.replace("count = 400", "count = 2"))
    for words in (("sweep", "sweep.toml", "--workers", "2"), ("bench", "s.toml", "--repeat", "1")):
        done = program(*words)
        assert done.returncode == 0, done.stderr


def test_a_current_folder_that_is_gone_is_named(series: Path) -> None:
    gone = series.parent / "gone"
    gone.mkdir()
    jkr = f"{sys.executable} -m jkrcli study sticking-map --nu 0.3 --ratio 1"
    done = subprocess.run(
        ["sh", "-c", f"cd {gone} && rmdir {gone} && {jkr}"], capture_output=True, text=True, check=False
    )
    assert (done.returncode, done.stderr) == (1, "jkr: error: the current folder: No such file or directory\n")


@pytest.mark.slow
def test_figures_do_not_depend_on_the_surroundings(series: Path) -> None:
    Path("matplotlibrc").write_text("backend: garbage\nfont.size: -3\nnonsense\n")
    words = ("transform", "s.h5", "-q")
    done = program(*words, MPLBACKEND="garbage", MPLCONFIGDIR="/proc/nothing")
    assert (done.returncode, done.stderr) == (0, "")
    Path("matplotlibrc").write_bytes(b"\xff\xfe")
    done = program(*words)
    assert (done.returncode, done.stderr) == (
        2,
        "jkr: error: matplotlibrc: matplotlib cannot read it ('utf-8' codec can't decode byte 0xff in position 0: "
        "invalid start byte); mend or remove the one in this folder, or that of MATPLOTLIBRC\n",
    )
