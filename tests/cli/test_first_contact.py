"""The first minutes: a case where a series is meant, mistakes told at once, doubtful numbers remarked."""

import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from conftest import CASES

from jkrcli.case import store
from jkrcli.cli.inputs import tables_of
from jkrcli.measured.parameters import implausible_work

GEL = CASES / "gel.toml"
BARE = """
[indenter]
shape = "paraboloid"
radius = "10 um"
[specimen.half_space]
E = "1 MPa"
nu = 0.4
[loading]
radius = "3 um"
"""


def with_w(w: str, text: str = BARE) -> None:
    Path("my.toml").write_text(f"{text}[adhesion]\nw = {w}\n")


def test_a_case_stands_for_its_series_which_is_kept_and_used_again(jkr: Callable) -> None:
    first = jkr("pull-off", GEL, "--json")
    assert (first.code, first.err) == (0, f"jkr: {GEL}: solved by method layered, written gel.h5\n")
    written = Path("gel.h5").read_bytes()
    second = jkr("pull-off", GEL, "--json")
    assert (second.out, second.err) == (first.out, "")
    assert Path("gel.h5").read_bytes() == written
    assert jkr("pull-off", "gel.h5", "--json").out == first.out


@pytest.mark.first(2)
@pytest.mark.parametrize(
    "words",
    [("transform", "--no-plots"), ("profile", "--a", "0.2 mm"), ("cycle", "--no-plots"), ("explore",)],
    ids=lambda words: words[0],
)
def test_every_verb_of_a_series_takes_a_case(jkr: Callable, words: tuple[str, ...]) -> None:
    if words[0] == "explore":
        pytest.importorskip("plotly")
    verb, *options = words
    assert jkr(verb, GEL, *options).code == 0
    assert len(list(Path().glob("gel*"))) >= 2
    assert jkr("show", GEL).code == 0
    assert jkr("compare", GEL, "gel.h5").code == 0


def test_a_changed_case_is_solved_anew_and_a_changed_w_is_not(jkr: Callable) -> None:
    with_w('"50 mJ/m^2"')
    jkr("pull-off", "my.toml")
    with_w('"20 mJ/m^2"')
    again = jkr("pull-off", "my.toml", "--json", "-v")
    assert "my.toml: solution read from my.h5" in again.err
    assert json.loads(again.out)["results"][0]["w_J_per_m2"] == 0.02
    with_w('"20 mJ/m^2"', BARE.replace("1 MPa", "2 MPa"))
    assert "solved by" in jkr("pull-off", "my.toml").err
    assert store.read_solution("my.h5").problem.specimen.surface.E == 2e6


def test_an_imported_series_of_another_case_is_never_replaced(jkr: Callable) -> None:
    rows = [f"{a},{a**2 / 6e-3},{1e4 * a**3}" for a in (2e-4, 3e-4, 4e-4, 5e-4, 6e-4, 7e-4)]
    Path("table.csv").write_text("\n".join(["a_m,delta_m,P_N", *rows]))
    assert jkr("import", "table.csv", "--case", GEL, "-o", "my.h5").code == 0
    Path("my.toml").write_text(BARE)
    assert jkr("show", "my.toml").err == (
        "jkr: error: my.h5: an imported solution of another case: give my.h5 itself, or move it away\n"
    )


def test_an_imported_series_is_the_solution_of_its_case(jkr: Callable) -> None:
    rows = [f"{a},{a**2 / 3e-3},{1e4 * a**3}" for a in (2e-4, 3e-4, 4e-4, 5e-4, 6e-4, 7e-4)]
    Path("table.csv").write_text("\n".join(["a_m,delta_m,P_N", *rows]))
    with_w('"50 mJ/m^2"')
    assert jkr("import", "table.csv", "--case", "my.toml", "-o", "my.h5").code == 0
    loading = store.read_solution("my.h5").problem.loading
    with_w('"20 mJ/m^2"')
    assert jkr("pull-off", "my.toml", "--json").told["results"][0]["w_J_per_m2"] == 0.02
    assert store.read_solution("my.h5").problem.loading == loading


def test_a_state_without_w_is_said_to_be_without_adhesion(jkr: Callable) -> None:
    Path("my.toml").write_text(BARE)
    jkr("run", "my.toml", "-q")
    said = jkr("profile", "my.h5", "--a", "1 um")
    assert said.err == "jkr: my.h5: its case names no work of adhesion: the contact without adhesion, or give --w\n"
    assert "w = 0 J/m^2" in said.out


def test_units_without_quotes_and_all_else_that_is_wrong_are_told_at_once(jkr: Callable) -> None:
    text = BARE.replace('"10 um"', "10 um # of the tip").replace('"1 MPa"', "3 MPa").replace("0.4", "0.8")
    Path("my.toml").write_text(text + 'name = "0x12 um"\n')
    assert jkr("check", "my.toml").err.splitlines() == [
        f"jkr: error: my.toml: {line}"
        for line in (
            'line 4: text with a unit must stand in quotes: radius = "10 um"',
            'line 6: text with a unit must stand in quotes: E = "3 MPa"',
            "loading.name: unknown key (allowed: depth, load, radius, points, spacing)",
            "specimen.half_space.nu: must be > -1 and <= 0.5, got 0.8",
        )
    ]


@pytest.mark.parametrize(
    ("place", "remedy"),
    [
        ('E = "1 MPa"\n', "give that E and nu here and none in [indenter]"),
        ("[specimen.half_space]\n", "a rigid indenter is one without E and nu: leave both out"),
    ],
    ids=["specimen", "indenter"],
)
def test_rigid_is_answered_with_how_to_say_it(jkr: Callable, place: str, remedy: str) -> None:
    own = 'E = "rigid"\n' if place.startswith("E") else f'E = "rigid"\nnu = 0.3\n{place}'
    Path("my.toml").write_text(BARE.replace(place, own))
    assert remedy in jkr("check", "my.toml").err


def test_a_bare_w_that_no_surface_has_is_remarked_and_one_with_its_unit_is_meant(jkr: Callable) -> None:
    remark = (
        'is 50 J/m^2, and surfaces have a few mJ/m^2 to 1 J/m^2; if it is meant, write "50 J/m^2", if not, perhaps '
        '"50 mJ/m^2"\n'
    )
    with_w("50")
    assert jkr("run", "my.toml").err == f"jkr: warning: my.toml: adhesion.w: 50 without a unit {remark}"
    assert jkr("pull-off", "my.h5", "--w", "50").err == f"jkr: warning: --w: 50 without a unit {remark}"
    assert jkr("pull-off", "my.h5", "--w", "50 J/m^2").err == ""
    assert jkr("pull-off", "my.h5", "--w", "0.05").err == ""


def test_a_file_name_where_a_folder_is_meant_is_answered(jkr: Callable, tmp_path: Path) -> None:
    jkr("mesh", GEL, "-o", "x.msh").refused("must be a folder, got the file name x.msh")
    assert list(tmp_path.iterdir()) == []
    assert jkr("transform", GEL, "--no-plots", "-o", "v1.2").code == 0  # a folder may have a dot


def test_several_w_in_one_picture(jkr: Callable) -> None:
    done = jkr("transform", GEL, "--together")
    assert "all in one picture: gel-all-w{.png,.svg}" in done.out
    tables = [f"gel-w{w}.{end}" for w in ("0.035", "0.04", "0.045") for end in ("csv", "json")]
    assert sorted(path.name for path in Path().glob("gel-*")) == sorted(["gel-all-w.png", "gel-all-w.svg", *tables])
    assert "give --scale instead" in jkr("transform", GEL, "--together", "--dimensionless", "thin-layer").err


def measured(name: str, head: str, scales: tuple[float, float], R: float = 5e-6) -> Path:
    """Retraction of a sphere from a half-space of 1 MPa, w = 50 mJ/m^2: displacement and load times ``scales``."""
    a = np.linspace(0.5, 0.25, 60) * R
    P = 4e6 * a**3 / (3 * R) - np.sqrt(8e6 * np.pi * 0.05 * a**3)
    delta = a**2 / R - np.sqrt(2e-6 * np.pi * 0.05 * a)
    rows = [f"{x:.8g},{y:.8g}" for x, y in zip(scales[0] * delta, scales[1] * P, strict=True)]
    Path(name).write_text("\n".join([head, *rows]) + "\n")
    return Path(name)


BY_FLAGS = ("--radius", "5 um", "--nu", "0.5", "--no-plots")


def test_wrong_units_of_a_measurement_are_asked_about(jkr: Callable) -> None:
    long = jkr("fit", measured("long.csv", "displacement (mm),force (nN)", (1e6, 1e9)), *BY_FLAGS)
    long.refused("beyond the indenter, which ends at 5 um: check the units of displacement and load")
    strong = jkr("fit", measured("strong.csv", "displacement (um),force (mN)", (1e6, 1e9)), *BY_FLAGS).ok
    assert "is implausible, surfaces have a few mJ/m^2 to 1 J/m^2: check units of the data" in strong.err
    right = jkr("fit", measured("right.csv", "displacement (um),force (nN)", (1e6, 1e9)), *BY_FLAGS)
    assert "implausible" not in right.err


def test_the_position_of_a_device_without_its_stiffness_is_no_depth(jkr: Callable) -> None:
    table = measured("z.csv", "Piezo (nm),Force (nN)", (1e9, 1e9))
    said = "E* is that of contact and instrument in series: the deflection of the cantilever is not subtracted"
    assert said in jkr("fit", table, *BY_FLAGS).err
    assert said not in jkr("fit", table, *BY_FLAGS, "--stiffness", "1 kN/m", "--force").err


def test_files_of_another_kind_are_answered_with_where_they_belong(jkr: Callable) -> None:
    table = Path("probe.csv")
    table.write_text("load (mN),contact radius (um)\n" + "".join(f"{i},{10 * i}\n" for i in range(1, 30)))
    assert "; jkr fit takes contact radius and load" in jkr("look", table).err
    assert "; a table of measurements is for jkr look and jkr fit" in jkr("pull-off", table).err
    Path("probe.xlsx").write_bytes(b"PK\x03\x04 no text")
    assert "; save the sheet as CSV" in jkr("fit", "probe.xlsx", *BY_FLAGS).err
    assert "must be a deflection per volt" in jkr("fit", table, *BY_FLAGS, "--sensitivity", "10 nm").err


BODY = {"shape": None, "half_angle": None, "cap": None, "thickness": None, "base": None, "radius": "10 um", "nu": "0.5"}


@pytest.mark.parametrize(("typed", "said"), [("2", "2 Pa"), ("5e13", "50 TPa")])
def test_a_modulus_without_unit_that_no_solid_has_is_remarked(typed, said, capsys) -> None:
    tables_of("fit", BODY | {"modulus": typed}, "", None)
    err = " ".join(capsys.readouterr().err.split())
    assert f"--E: {typed.replace('e', 'e+')} without a unit is {said}" in err
    for meant in ("5e4", "2 Pa", "0.5 MPa"):
        tables_of("fit", BODY | {"modulus": meant}, "", None)
        assert capsys.readouterr().err == ""


def test_symbols_of_the_field_are_answered_with_the_option(jkr: Callable) -> None:
    """--R was answered with --E and --w."""
    for symbol, option in {"R": "radius", "k": "stiffness", "h": "thickness", "alpha": "half-angle"}.items():
        jkr("fit", "x.csv", f"--{symbol}", "1").refused(f", did you mean '--{option}'?")
    assert "--radius" not in jkr("show", "x.h5", "--R", "1").err  # which has none


def test_a_work_of_adhesion_that_surfaces_hardly_have_is_remarked() -> None:
    assert "implausibly small for E* = 1.5 MPa" in implausible_work(61e-6, 1.5e6)
    assert implausible_work(61e-6, 1e4) == ""  # of a cell in a liquid
    assert implausible_work(1e-3, 1e9) == ""
    assert "is implausible" in implausible_work(50.0, 1e4)
