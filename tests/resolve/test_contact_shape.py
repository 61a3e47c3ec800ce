"""Contacts that are no discs, imported: ellipses against the least energy over all ellipses, other shapes not known."""

import math
import subprocess
import sys
from pathlib import Path
from typing import Any

import ellipses
import numpy as np
import pytest

from jkrcli.adhesion.contact_shape import BETWEEN, ELLIPSES, ContactShape

BODY = ("--shape", "paraboloid", "--radius", "10 um", "--E", "1 MPa", "--nu", "0.5")
R, E_STAR, W = 1e-5, 1e6 / 0.75, 0.01
ON_A_LAYER = ("--thickness", "2e-6", "--nu", "0.45")
EXAMPLE = Path(__file__).parents[2] / "docs" / "examples" / "ellipse_by_fft.py"


def write_table(path: Path, delta: Any, P: Any, area: Any) -> None:
    rows = zip(np.array(delta).tolist(), np.array(P).tolist(), np.array(area).tolist(), strict=True)
    path.write_text("delta_m,P_N,area_m2\n" + "".join(f"{d!r},{p!r},{A!r}\n" for d, p, A in rows))


def ellipse_table(path: Path, ratio: float, rows: int = 40) -> None:
    areas = math.pi * np.linspace(0.02, 0.3, rows) ** 2
    delta, P = ellipses.hertz(ratio, areas)
    write_table(path, delta * R, P * E_STAR * R**2, areas * R**2)


def pull_off_of(jkr: Any, table: str, shape: str, *words: Any) -> dict[str, Any]:
    assert jkr("import", table, "--contact-shape", shape, *(words or BODY), "-o", "shape.h5", "--force").code == 0
    found: dict[str, Any] = jkr("pull-off", "shape.h5", "--w", "10 mJ/m^2", "--json").told["results"][0]
    return found


@pytest.mark.first(1)
@pytest.mark.parametrize(
    ("ratio", "exact", "hertz"),
    [(4, 1.4788, 1.4633), (1.5, 1.4981, 1.4966), (2, 1.4945, 1.4902), (10, 1.4468, 1.4113), (30, 1.4001, 1.3407)],
)
def test_the_least_energy_over_all_ellipses(ratio: float, exact: float, hertz: float) -> None:
    """-P/(pi w sqrt(R1 R2)) under load control, every digit; at ratio 1 JKR's."""
    assert round(ellipses.pull_off(ratio)[0], 4) == exact
    assert round(ellipses.restricted(ratio)[0], 4) == hertz
    assert ellipses.pull_off(1.0) == pytest.approx((1.5, 5 / 6), rel=1e-7)  # a minimum is found to the root of rounding
    assert ellipses.pull_off(ratio, w=1e-3) == pytest.approx(ellipses.pull_off(ratio), rel=1e-7)


@pytest.mark.first(3)
@pytest.mark.parametrize("row", range(len(ELLIPSES))[::-1])
def test_the_table_over_the_radii_is_that_of_the_energy(row: int) -> None:
    ratio, *stated = ELLIPSES[row].tolist()
    energy, restricted = ellipses.pull_off(ratio), ellipses.restricted(ratio)
    assert stated == pytest.approx([a / b - 1 for a, b in zip(energy, restricted, strict=True)], abs=6e-6)


@pytest.mark.first(3)
@pytest.mark.parametrize("ratio", [1.4, 3.5, 40.0, 1.1, 1.8, 2.5, 5.0, 8.0, 13.0, 75.0])
def test_ten_ellipses_lie_within_the_stated_error_of_the_energy(jkr: Any, tmp_path: Path, ratio: float) -> None:
    """Under both controls the energy's force lies in the stated range, whose width it needs but for ``BETWEEN``."""
    ellipse_table(tmp_path / "table.csv", ratio)
    found = pull_off_of(jkr, "table.csv", f"ellipse={ratio}")
    for name, control, exact in zip(("load", "displacement"), found["controls"], ellipses.pull_off(ratio), strict=True):
        force, error = -control["pull_off"]["P_N"], control["pull_off"]["P_err_N"]
        low, high = found["contact_shape"]["pull_off_change"][name]
        true = exact * math.pi * W * R
        assert force * (1 + low) - error <= true <= force * (1 + high) + error
        assert max(-low, high) - abs(true / force - 1) <= 2.2 * BETWEEN


def test_a_disc_of_any_shape_is_todays_disc(jkr: Any, tmp_path: Path) -> None:
    a = np.linspace(0.02, 0.3, 60) * R
    write_table(tmp_path / "area.csv", a**2 / R, 4 * E_STAR * a**3 / (3 * R), math.pi * a**2)
    shaped = pull_off_of(jkr, "area.csv", "any")
    assert jkr("import", "area.csv", *BODY, "--area", "projected", "-o", "disc.h5").code == 0
    disc = jkr("pull-off", "disc.h5", "--w", "10 mJ/m^2", "--json").told["results"][0]
    for one, other in zip(shaped["controls"], disc["controls"], strict=True):
        assert one["pull_off"]["P_N"] == pytest.approx(other["pull_off"]["P_N"], rel=1e-7)
    assert -shaped["controls"][0]["pull_off"]["P_N"] == pytest.approx(1.5 * math.pi * W * R, rel=1e-6)
    assert "contact_shape" not in disc


def test_nothing_is_compared_with_discs_and_what_is_not_known_is_said(jkr: Any, tmp_path: Path) -> None:
    ellipse_table(tmp_path / "table.csv", 4.0)
    imported = jkr("import", "table.csv", "--contact-shape", "any", *BODY)
    assert imported.err == ""
    assert "contact any: compared with no disc" in " ".join(imported.out.split())
    said = " ".join(jkr("pull-off", "table.h5", "--w", "10 mJ/m^2", "-v").out.split())
    assert "contact shape any: what other shapes change of the pull-off force: sign and size not known" in said
    measured = " ".join(jkr("pull-off", "table.h5", "--load", "500 nN").out.split())
    assert "sign and size not known" in measured
    assert "large strains" not in measured.split("at the largest contact radius")[0]
    layer = pull_off_of(jkr, "table.csv", "ellipse=4", *BODY, "--thickness", "1 mm")["contact_shape"]
    assert layer["pull_off_change"] == {"load": None, "displacement": None}
    assert "known of ellipses on a half-space" in layer["reason"]


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (("profile", "shape.h5", "--a", "1 um"), "profile: is solved for contacts that are discs"),
        (("fields", "shape.h5", "--a", "1 um"), "fields: is solved for contacts that are discs"),
        (("import", "table.csv", "--contact-shape", "ellipse=0.5", *BODY), "ellipse=R1/R2 with a ratio from 1 to 100"),
        (("import", "table.csv", "--contact-shape", "square", *BODY), "must be disc, any or ellipse"),
        (
            ("import", "table.csv", "--contact-shape", "any", "--area", "surface", *BODY),
            "are of contacts that are discs",
        ),
        (("import", "two.csv", "--contact-shape", "any", *BODY), "no column is recognised as the contact radius"),
    ],
)
def test_refusals_in_one_line(jkr: Any, tmp_path: Path, words: tuple[str, ...], message: str) -> None:
    ellipse_table(tmp_path / "table.csv", 4.0)
    (tmp_path / "two.csv").write_text("delta_m,P_N\n" + "".join(f"{i}e-9,{i**1.5}e-9\n" for i in range(1, 20)))
    assert jkr("import", "table.csv", "--contact-shape", "any", *BODY, "-o", "shape.h5").code == 0
    outcome = jkr(*words)
    assert (outcome.code, outcome.out) == (2, "")
    assert message in " ".join(outcome.err.split())


def test_verbs_that_state_no_change_by_other_shapes_warn_of_it(jkr: Any, tmp_path: Path) -> None:
    ellipse_table(tmp_path / "table.csv", 4.0)
    assert jkr("import", "table.csv", "--contact-shape", "ellipse=4", *BODY, "-o", "shape.h5").code == 0
    for verb, *words in (("cycle", "--w-approach", "10 mJ/m^2"), ("export", "--dem", "--w", "10 mJ/m^2"), ("show",)):
        said = " ".join(jkr(verb, "shape.h5", *words).ok.err.split())
        assert "R1/R2 = 4: what other shapes change of the pull-off force: -0.03 to +1.1 % (load)" in said
        assert "no error here includes it" in said
    rows = np.loadtxt(tmp_path / "shape-dem.csv", delimiter=",", skiprows=1)
    assert -rows[0, 2] == pytest.approx(ellipses.restricted(4.0)[1] * math.pi * W * R, rel=1e-4)
    outcome = jkr("transform", "shape.h5", "--w", "10 mJ/m^2", "--no-plots")
    assert "other shapes" not in outcome.err  # it is part of the result


def test_a_spring_may_be_as_far_off_as_either_control() -> None:
    shape = ContactShape(30.0, half_space=True)
    low, high = shape.change(1.0)
    assert (low, high) == (shape.change(math.inf)[0], shape.change(0.0)[1])


@pytest.mark.slow
@pytest.mark.parametrize(
    ("words", "shape", "radius", "nu", "more"),
    [
        ((), "ellipse=4", "10 um", "0.5", ()),
        (("--R1", "10e-6", "--R2", "10e-6", *ON_A_LAYER), "any", "10 um", "0.45", ("--thickness", "2 um")),
        (("--R1", "20e-6", "--R2", "8e-6", *ON_A_LAYER), "any", "12.65 um", "0.45", ("--thickness", "2 um")),
    ],
    ids=["ellipse", "disc on a layer", "crossed cylinders on a layer"],
)
def test_tables_by_fft(jkr: Any, tmp_path: Path, words: Any, shape: str, radius: str, nu: str, more: Any) -> None:
    """A three-dimensional solution of the guide: the ellipse beside the energy, a disc on a layer beside its exact
    solution; equal crossed cylinders are that disc, of other radii the force lies within 3 % of one of sqrt(R1 R2)."""
    subprocess.run([sys.executable, str(EXAMPLE), "table.csv", *words], check=True, cwd=tmp_path)
    body = ("--shape", "paraboloid", "--radius", radius, "--E", "1 MPa", "--nu", nu, *more)
    pull_off = pull_off_of(jkr, "table.csv", shape, *body)["controls"][0]["pull_off"]
    force = -pull_off["P_N"]
    if shape == "any":
        exact = jkr("pull-off", *body, "--w", "10 mJ/m^2", "--json").told["results"][0]
        true = -exact["controls"][0]["pull_off"]["P_N"]
        assert force == pytest.approx(true, rel=2e-3 if radius == "10 um" else 0.03)
    else:
        true = ellipses.restricted(4.0)[0] * math.pi * W * R  # among the shapes of the contact without adhesion
        assert abs(force - true) < pull_off["P_err_N"] < 1e-3 * true
