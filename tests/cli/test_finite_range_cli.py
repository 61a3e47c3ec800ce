"""Adhesion of finite range on the command line: files, names, refusals, and what JKR says of itself."""

import json
from pathlib import Path

import numpy as np
import pytest

from jkrcli.report.tables import read_curve

TIP = """
indenter = { shape = "paraboloid", radius = "30 nm" }
[[specimen.layers]]
thickness = "20 nm"
E = "1 GPa"
nu = 0.4
[specimen.half_space]
E = "100 GPa"
nu = 0.25
[loading]
radius = "9 nm"
points = 40
[adhesion]
w = "50 mJ/m^2"
"""


@pytest.fixture
def tip(jkr) -> Path:
    Path("tip.toml").write_text(TIP)
    assert jkr("run", "tip.toml", "-q").code == 0
    return Path("tip.h5")


def test_transform_writes_beside_jkr_and_adds_a_column(jkr, tip: Path) -> None:
    assert jkr("transform", "tip.h5", "--no-plots", "-q").code == 0
    assert jkr("transform", "tip.h5", "--stress", "100 MPa", "--no-plots", "-q").code == 0
    assert jkr("transform", "tip.h5", "--range", "0.5 nm", "--no-plots", "-q").code == 0
    without, by_stress, by_range = (
        json.loads(Path(f"tip-w0.05{name}.json").read_text()) for name in ("", "-stress1e+08", "-range5e-10")
    )
    assert set(without) < set(by_stress)
    assert by_stress["range_m"] == pytest.approx(5e-10)
    assert by_stress["pull_off"]["load"]["P_N"] == pytest.approx(by_range["pull_off"]["load"]["P_N"], rel=1e-12)
    assert by_stress["pull_off"]["load"]["c_m"] > by_stress["pull_off"]["load"]["a_m"]
    found, plain = read_curve(Path("tip-w0.05-range5e-10.csv")), read_curve(Path("tip-w0.05.csv"))
    assert [*found] == [*list(plain)[:-1], "c_m", "level"]
    touching = found["a_m"] > 0
    rows = np.searchsorted(found["a_m"][touching], plain["a_m"] * (1 - 1e-12))
    np.testing.assert_allclose(found["delta_H_m"][touching][rows], plain["delta_H_m"], rtol=1e-7)
    np.testing.assert_allclose(found["P_H_N"][touching][rows], plain["P_H_N"], rtol=1e-7)
    assert found["delta_m"][0] == -5e-10


def test_what_a_range_changes_is_told_where_it_matters(jkr, tip: Path) -> None:
    said = jkr("check", "tip.toml").ok
    assert "JKR is doubtful: attraction over the range z0 makes the pull-off force 4.1 % larger" in said.out
    assert "4.1 % larger (Tabor number 1.25): give --range or --stress" in said.err
    done = jkr("transform", "tip.h5", "--w", "5 J/m^2", "--no-plots", "--json").ok
    assert "range" not in done.err  # short enough a range: nothing is said


def test_capillary_bridge_is_a_tension_and_a_work(jkr, tip: Path) -> None:
    bridge = 'capillary = { surface_tension = "72.8 mN/m", humidity = 0.5, contact_angles = [0, 60] }'
    Path("wet.toml").write_text(TIP.replace('w = "50 mJ/m^2"', bridge))
    assert jkr("run", "wet.toml", "-q").code == 0
    found = jkr("transform", "wet.h5", "--no-plots", "--json").told["results"][0]
    assert found["w_J_per_m2"] == pytest.approx(72.8e-3 * 1.5, rel=1e-12)
    assert found["range_m"] == pytest.approx(1.5 * 0.778e-9, rel=2e-3)  # r_K = 0.54 nm/ln 2 of water at 20 degrees


def test_pull_off_and_cycle(jkr, tip: Path) -> None:
    words = ("tip.h5", "--range", "0.5 nm", "--stiffness", "0.5 N/m", "--json")
    found = jkr("pull-off", *words).told["results"][0]["controls"][0]
    around = jkr("cycle", *words, "--no-plots").told
    assert around["jumps_on_retraction"][-1]["from"]["P_N"] == pytest.approx(found["pull_off"]["P_N"], rel=1e-9)
    assert around["energy_lost_J"] == pytest.approx(found["energy_lost_J"], rel=1e-12)
    assert around["jump_in"] == found["jump_in"]
    [table] = Path().glob("tip-cycle*.csv")
    assert "stiffness0.5" in table.name
    assert "range5e-10" in table.name
    assert "c_m" in table.read_text().splitlines()[0]


@pytest.mark.parametrize(
    ("lines", "message"),
    [
        ("range = 1e-9\nstress = 1e8", "adhesion: give at most one of range, stress and capillary, got range and"),
        ("range = 0", "adhesion.range: must be > 0"),
        ("stress = -1", "adhesion.stress: must be > 0"),
        ("capillary = { surface_tension = 0.07, humidity = 0.5, contact_angles = 0 }", "adhesion: capillary: gives"),
        ("rnage = 1e-9", 'adhesion.rnage: unknown key, did you mean "range"?'),
    ],
)
def test_mistakes_in_case_files(jkr, lines: str, message: str) -> None:
    Path("wrong.toml").write_text(TIP + lines)
    jkr("check", "wrong.toml").refused(message)


WITHOUT_W = TIP.replace('w = "50 mJ/m^2"', "")
RANGE, PLAIN = TIP + 'range = "0.5 nm"', TIP
STICKING = TIP.replace("[loading]", '[specimen]\nsurface = "sticking"\n[loading]')
RATE = ["--rate", "v0=1 um/s,n=0.6", "--speed", "1 um/s", "--no-plots"]
SWEEP = 'base = "own.toml"\n[[axes]]\nkey = "indenter.radius"\nvalues = ["30 nm", "40 nm"]\n'
CYLINDER = TIP.replace('[specimen.half_space]\nE = "100 GPa"\nnu = 0.25', '[specimen]\nradius = "20 nm"\nside = "free"')
FOLLOWED = {  # case and words that are refused, what is said, and case and words that follow it
    "pull-off of a load": (RANGE, "pull-off own.h5 --load 2nN", "pull-off: --load: has no adhesion of finite range",
                           PLAIN, "pull-off own.h5 --load 2nN"),
    "explore": (RANGE, "explore own.h5", "leave adhesion.range, stress and capillary out", PLAIN, "explore own.h5"),
    "work": (RANGE, "work own.h5 data.csv --no-plots", "work: has no adhesion of finite range, which the case",
             PLAIN, "work own.h5 data.csv --no-plots"),
    "two works": (RANGE, "cycle own.h5 --w-retract 0.1 --no-plots", "give one work of adhesion",
                  RANGE, "cycle own.h5 --no-plots"),
    "speed": (RANGE, ["cycle", "own.h5", *RATE], "leave --range and the case's out", PLAIN, ["cycle", "own.h5", *RATE]),
    "slopes": (RANGE, "transform own.h5 --slopes loocv --no-plots", "loocv has no effect with adhesion of finite range",
               RANGE, "transform own.h5 --slopes exact --no-plots"),
    "sticking": (STICKING, "transform own.h5 --range 0.5nm --no-plots", 'specimen.surface = "sliding"',
                 TIP, "transform own.h5 --range 0.5nm --no-plots"),
    "finite elements": ('method = "fem"' + TIP, "transform own.h5 --range 0.5nm --no-plots",
                        "solve the case with the method layered",
                        'method = "layered"' + TIP, "transform own.h5 --range 0.5nm --no-plots"),
    "beyond the side": (CYLINDER, "transform own.h5 --range 30nm --no-plots", "give a larger stress (a shorter range)",
                        CYLINDER, "transform own.h5 --range 0.5nm --no-plots"),
    "a sweep": (RANGE, "sweep sweep.toml", "adhesion.range: sweep has no adhesion of finite range: leave it out",
                PLAIN, "sweep sweep.toml"),
    "both": (PLAIN, "transform own.h5 --stress 1e8 --range 1nm", "give either --stress or --range, got both",
             PLAIN, "transform own.h5 --stress 1e8 --no-plots"),
    "no w": (WITHOUT_W, "transform own.h5 --range 1nm", "names no work of adhesion: give --w",
             WITHOUT_W, "transform own.h5 --range 1nm --w 0.05 --no-plots"),
    "fields": (RANGE, "fields own.h5 --a 4nm --no-plots", "leave adhesion.range, stress and capillary out",
               PLAIN, "fields own.h5 --a 4nm --no-plots"),
}  # fmt: skip


@pytest.mark.first(6)
@pytest.mark.parametrize("name", FOLLOWED)
def test_who_follows_a_refusal_gets_an_answer(jkr, name: str) -> None:
    refused, words, says, mended, better = FOLLOWED[name]
    Path("sweep.toml").write_text(SWEEP)
    Path("data.csv").write_text("delta_nm,P_nN\n0.2,-5\n0.5,-3\n0.8,0\n1.1,4\n1.4,9\n1.7,15\n")
    for case, line, fine in ((refused, words, False), (mended, better, True)):
        Path("own.toml").write_text(case)
        assert jkr("run", "own.toml", "-q", "--force").code == 0
        done = jkr(*(line.split() if isinstance(line, str) else line))
        assert (done.code == 0) == fine
        said = [line for line in done.err.splitlines() if "error:" in line]
        assert len(said) == (not fine)
        assert fine or says in said[0]


@pytest.mark.parametrize(
    ("case", "says"),
    [
        ('method = "fem"' + TIP, "jkr transform will refuse: adhesion of finite range needs the kernel"),
        (STICKING, "jkr transform will refuse: adhesion of finite range is implemented for frictionless contact only"),
        ('method = "layered"' + TIP, ""),
    ],
)
def test_check_says_what_transform_will_refuse(jkr, case: str, says: str) -> None:
    """And not that JKR holds, which was not asked."""
    text = case if "range" in case else case.replace("[adhesion]", "[adhesion]\nrange = '0.5 nm'")
    Path("my.toml").write_text(text)
    found = jkr("check", "my.toml").ok
    assert "JKR holds" not in found.out
    assert says in found.err
    assert ("jkr transform includes its range" in found.out) == (not says)
