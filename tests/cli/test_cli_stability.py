"""``jkr pull-off``, ``jkr cycle``, ``jkr study``, and what they add to the transform's table and summary."""

import json
import math
import shutil
from pathlib import Path

import numpy as np
import pytest
from conftest import CASES

from jkrcli.adhesion.device_path import GRIPPED, STABLE, UNSTABLE
from jkrcli.base.units import show
from jkrcli.cli import call
from jkrcli.report.tables import read_curve

PARABOLOID = (
    '[indenter]\nshape="paraboloid"\nradius="100 um"\n[specimen.half_space]\nE="5 GPa"\nnu=0.4\n'
    '[loading]\nradius="17.3 um"\npoints=60\n[adhesion]\nw=50.0\n'
)
PULL_OFF = math.pi * 50 * 1e-4


@pytest.fixture(name="solved", scope="module")
def _solved(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("solved")
    (folder / "p.toml").write_text(PARABOLOID)
    assert call(["run", str(folder / "p.toml"), "--method", "closed-form", "-o", str(folder / "p.h5")]) == 0
    return folder / "p.h5"


@pytest.fixture(name="body")
def _body(solved: Path, tmp_path: Path) -> Path:
    shutil.copy(solved, tmp_path)
    return tmp_path


def rows(path: Path) -> list[dict[str, str]]:
    header, *lines = path.read_text().splitlines()
    return [dict(zip(header.split(","), line.split(","), strict=True)) for line in lines]


def test_pull_off_in_words(jkr, body: Path) -> None:
    outcome = jkr("pull-off", "p.h5", "--stiffness", "load", "--stiffness", "rigid", "-v")
    assert (outcome.code, outcome.err) == (0, "")
    unit = (50**5 * 1e-16 / (5e9 / 0.84) ** 2) ** (1 / 3)
    force, rigid = (show(part * PULL_OFF, "load") for part in (1.5, 5 / 6))
    E_star = 5e9 / 0.84
    lines = outcome.out.splitlines()
    assert lines[0].startswith(f"pull-off force {force} (load), {rigid} (displacement) at w = 50 J/m^2; 1.5 pi w R = ")
    named = zip(lines[4:6] + lines[7:9], ("pull-off", "jump-in, delta = 0") * 2, (3 / 2, 6, 1 / 6, 8 / 3), strict=True)
    for line, name, cube in named:  # Eq. 18 at a_bar^3 = cube
        a = (3 * math.pi * 50 * 1e-8 / (4 * E_star) * cube) ** (1 / 3)
        assert line.startswith(f"    {name}  ")
        assert line.endswith(f"a = {show(a, 'length')}")
    assert f"energy lost         {show(7.0922 * unit, 'energy')} (error < 0.01 %)" in lines[9]


def test_many_files_and_works(jkr, body: Path) -> None:
    jkr("run", CASES / "coating.toml")
    out = jkr("pull-off", "p.h5", "coating.h5", "--w", "10 mJ/m^2", "--w", "20 mJ/m^2").out
    heads = [line for line in out.splitlines() if not line.startswith(" ")]
    ends = [line.partition(" at ")[2] for line in heads]
    asked = [(f"w = {w} mJ/m^2; 1.5 pi w R = ", f": {name}") for name in ("p.h5", "coating.h5") for w in (10, 20)]
    assert all(text.startswith(a) and text.endswith(b) for text, (a, b) in zip(ends, asked, strict=True))


def test_the_classical_formula_says_under_which_control_it_holds(jkr, body: Path) -> None:
    said = " ".join(jkr("pull-off", "p.h5", "--load", "12 mN", "--stiffness", "rigid").out.split())
    assert "under load control would have given 25.46 J/m^2, 0.556 times that of this specimen" in said  # 5/6 over 3/2


def test_transform_marks_the_branches(jkr, body: Path) -> None:
    assert jkr("transform", "p.h5").code == 0
    table = rows(body / "p-w50.csv")
    assert {"branch", "level"} <= set(table[0])
    a0 = (3 * math.pi * 50 * 1e-8 / (4 * 5e9 / 0.84)) ** (1 / 3)
    for row in table:
        cube = (float(row["a_m"]) / a0) ** 3
        assert row["branch"] == (STABLE if cube > 1.5 else GRIPPED if cube > 1 / 6 else UNSTABLE)
    assert "branch" not in read_curve(body / "p-w50.csv")  # the numbers alone
    summary = json.loads((body / "p-w50.json").read_text())
    assert set(summary["stability"]) == {"load", "displacement"}
    assert summary["stability"]["displacement"]["energy_lost_J"] == pytest.approx(
        6.801e-9, rel=1e-4, abs=0
    )  # 7.09 units
    assert summary["stability"]["load"]["energy_lost_J"] is None
    point = summary["stability"]["load"]["pull_off"]
    assert point == {name: summary["pull_off"]["load"][name] for name in point}
    assert jkr("compare", "p-w50.csv", "p-w50.csv").code == 0


def test_cycle_writes_what_the_device_records(jkr, body: Path) -> None:
    words = ("cycle", "p.h5", "--w-approach", "20 J/m^2", "--w-retract", "80 J/m^2", "--stiffness", "0.1 N/um",
             "--to-load", "40 mN")  # fmt: skip
    outcome = jkr(*words)
    assert (outcome.code, outcome.err) == (0, "")
    works = "w = 20 J/m^2 on approach, 80 J/m^2 on retraction"
    assert outcome.out.splitlines()[1] == f"  instrument stiffness 100 kN/m, {works}"
    stem = "p-cycle-w-approach20-w-retract80-stiffness100000-to-load0.04"
    assert sorted(path.name for path in body.glob("p-cycle*")) == [f"{stem}{end}" for end in (".csv", ".png", ".svg")]
    table = rows(body / f"{stem}.csv")
    assert list(table[0]) == ["a_m", "delta_m", "P_N", "device_m", "phase", "part"]
    P = np.array([float(row["P_N"]) for row in table])
    D = np.array([float(row["device_m"]) for row in table])
    assert P.max() == pytest.approx(40e-3, rel=1e-12, abs=0)  # measured 4e-15
    area = float(np.sum((P[1:] + P[:-1]) / 2 * np.diff(D)))
    printed = jkr(*words, "--json", "--no-plots").told
    assert printed["energy_lost_J"] == pytest.approx(area, rel=1e-3, abs=0)  # 200 rows per stretch
    assert printed["contact_lost"] is True
    assert printed["jumps_on_retraction"][-1]["to"] is None


def test_study_writes_the_map(jkr, tmp_path: Path) -> None:
    words = ("study", "pull-off-map", "--nu", "0.3", "--q", "1", "--q", "0.1", "-o", "map")
    assert jkr(*words).out.splitlines() == [
        "bonded layer on a rigid substrate, paraboloid: pull-off force in pi w R",
        "      nu   beta  w R^2/(E* h^3)    force       a/h",
        "     0.3      0             0.1   1.6267    0.7181",
        "     0.3      0               1   1.7936     1.439",
        "  written map/pull-off-map{.csv,.png,.svg}",
    ]
    table = rows(tmp_path / "map" / "pull-off-map.csv")
    assert [float(row["minus_P_over_pi_w_R"]) for row in table] == pytest.approx([1.6267, 1.7936], abs=5e-5)
    assert jkr(*words).code == 0  # replaces its own files
    found = jkr(*words, "--json", "--no-plots").told
    assert found["base"] == ["bonded"] * 2


REFUSALS = [
    ("pull-off p.h5 --load 1uN --w 1", "pull-off: give either --w or --load, not both"),
    ("pull-off p.h5 --load 0N", "pull-off: --load must not be 0; give the measured pull-off force"),
    ("pull-off p.h5 --load 1N", "p.h5: load: a pull-off force of 1 N lies outside the solution, which covers forces"),
    ("pull-off p.h5 --load 1e20N", "from 1.902 uN to 410.9 mN: increase [loading] radius"),  # rounded to 0 N once
    ("pull-off p.h5 --load 1mN --uncertain R=1m", "p.h5: the uncertainty of R is 1e+04 times its value: give less"),
    ("pull-off p.h5 --stiffness soft", 'must be a stiffness, such as "0.2 N/m", got "soft"; see jkr pull-off --help'),
    ("pull-off p.h5 --stiffness 0", 'must be > 0 or "load" or "rigid", got 0; see jkr pull-off --help'),
    ("cycle p.h5 --w-retract 10J/m^2", "w on retraction must be >= w on approach, got 10 J/m^2 and 50 J/m^2"),
    ("cycle p.h5 --to-load 1N --to-depth 1um", "cycle: give at most one of --to-load and --to-depth"),
    ("cycle p.h5 --w-approach 5000J/m^2", "p.h5: contact at delta = 0 spreads beyond the largest radius of the"),
    ("study pull-off-map --q 1e9", "pull-off map: q must be >= 1e-06 and <= 1e+07, got 1000000000.0"),
]  # fmt: skip


@pytest.mark.parametrize(("words", "line"), REFUSALS)
def test_refusals_are_one_line_with_exit_code_2(jkr, body: Path, words: str, line: str) -> None:
    before = sorted(path.name for path in body.iterdir())
    jkr(*words.split()).refused(line)
    assert sorted(path.name for path in body.iterdir()) == before
