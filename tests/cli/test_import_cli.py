"""``jkr import`` and every verb after it; the finite-element runs of another program to the pull-off."""

from pathlib import Path

import numpy as np
import pytest

from jkrcli.case import store
from jkrcli.case.models import parse_case
from jkrcli.formulas import hertz

E_STAR = 2e6 / (1 - 0.25**2)
CASE = """
indenter = { shape = "paraboloid", radius = "1 mm" }
specimen.half_space = { E = "2 MPa", nu = 0.25 }
adhesion.w = "50 mJ/m^2"
"""
BODY = ("--shape", "paraboloid", "--radius", "1 mm", "--E", "2 MPa", "--nu", 0.25)


@pytest.fixture(name="table")
def _table(tmp_path: Path) -> Path:
    a = np.linspace(0, 1.2e-4, 61)[1:]
    delta, P = hertz(a, E_STAR, 1e-3)
    rows = "\n".join(
        f"{x!r};{d!r};{p!r}" for x, d, p in zip(*(v.tolist() for v in (a * 1e6, -delta * 1e6, -P * 1e3)), strict=True)
    )
    (tmp_path / "t.txt").write_text(f"contact radius (um);U2 (um);RF2 (mN)\n{rows}\n")
    (tmp_path / "my.toml").write_text(CASE)
    return tmp_path / "t.txt"


def test_after_import_every_verb_works_as_on_our_own(jkr, table: Path, tmp_path: Path) -> None:
    outcome = jkr("import", "t.txt", "--case", "my.toml")
    assert (outcome.code, outcome.err) == (0, "")
    assert outcome.out.splitlines()[:5] == [
        "a = 120 um, delta = 14.4 um, P = 4.915 mN; 60 rows, 60 different contact radii; ± at 95 %",
        "  loads     1.000 ± 0.0001 times the exact loads of these bodies at equal displacement",
        "  radii     those of the rows",
        "  body      paraboloid R = 1 mm on a half-space (E = 2 MPa, nu = 0.25) to a depth of 14.4 um",
        '  columns   P = column 3 "RF2 (mN)", a = column 1 "contact radius (um)", delta = column 2 "U2 (um)"; '
        "separated by: semicolon",
    ]
    summary = jkr("transform", "t.h5", "--no-plots", "--json").told["results"][0]
    assert summary["method"] == "import"
    # Exact data on 60 points: the slopes are polynomials, which their splines hold; 1e-12 measured.
    assert summary["pull_off"]["load"]["P_N"] == pytest.approx(-1.5 * np.pi * 0.05 * 1e-3, rel=1e-11)
    assert summary["errors"]["total"] == "unknown: imported data"
    assert "numerical error unknown: imported data: t.h5" in jkr("show", "t.h5").out
    (tmp_path / "again.toml").write_text(jkr("show", "--case", "t.h5").out)
    assert jkr("run", "again.toml", "--method", "closed-form", "-o", "own.h5").code == 0
    assert jkr("compare", "t.h5", "own.h5", "--rtol", 1e-5).code == 0
    assert jkr("profile", "t.h5", "--load", "-0.1 mN").code == 0


def test_zero_is_told_as_elsewhere_or_as_a_length_alone(jkr, table: Path) -> None:
    jkr("import", table, *BODY, "--zero", "-1 um", "-o", "a.h5")
    jkr("import", table, *BODY, "--zero", "delta=-1 um", "--zero", "P=-1 uN", "-o", "b.h5")
    one, other = store.read_solution("a.h5"), store.read_solution("b.h5")
    assert other.raw.delta.tolist() == one.raw.delta.tolist()
    np.testing.assert_allclose(other.raw.P - one.raw.P, 1e-6, rtol=1e-9)  # the loads are 1 mN: 1e-13 / 1e-6
    assert (one.facts["zero_m"], one.facts["zero_N"], other.facts["zero_N"]) == (-1e-6, 0, -1e-6)


def test_bodies_by_flags(jkr, table: Path) -> None:
    jkr("import", table, "--case", "my.toml", "-o", "case.h5")
    assert jkr("import", table, *BODY, "-o", "flags.h5").code == 0
    assert store.read_solution("flags.h5").problem.key == store.read_solution("case.h5").problem.key
    found = jkr("import", table, *BODY, "--thickness", "1 mm", "--base", "frictionless", "--json").told
    assert (found["file"], found["points"], found["method"]) == ("t.h5", 60, "import")
    model = parse_case(store.read_solution("t.h5").record.toml.encode(), "t").model
    assert (model.specimen.base, model.specimen.layers[0].thickness) == ("frictionless", 1e-3)


WRONG = {
    "no bodies": (("t.txt",), "import: needs --case, or the specimen from options: --radius, --E, --nu missing"),
    "both": (("t.txt", "--case", "my.toml", "--nu", "0.3"), "--nu belongs to an import without --case; my.toml says"),
    "base alone": (("t.txt", *BODY, "--base", "bonded"), "import: --base needs --thickness: a half-space has no base"),
    "wrong base": (("t.txt", *BODY, "--thickness", "1 mm", "--base", "glued"), "--base: must be one of bonded, "),
    "wrong nu": (("t.txt", *BODY[:-1], 0.6), "import: --nu: must be > -1 and <= 0.5, got 0.6"),
    "no file": (("u.txt", *BODY), 'u.txt: table not found, did you mean "t.txt"?'),
    "no unit": (("t.txt", "--unit", "N"), "'--unit': must be KEY=UNIT with a quantity or a column, such as P=nN, got"),
    "wrong key": (("t.txt", "--column", "F=1"), "'--column': must be KEY=VALUE with a key of a, area, delta, P, got"),
    "wrong factor": (("t.txt", "--factor", "P=0"), "'--factor': must be KEY=NUMBER, finite and not 0, got \"P=0\";"),
    "another's file": (("t.txt", *BODY, "-o", "my.toml"), "my.toml: exists and was not written by jkr; give --force"),
    "case is no TOML": (("t.txt", "--case", "t.txt"), "error: t.txt: is not valid TOML: "),
}  # fmt: skip


@pytest.mark.parametrize(("words", "line"), WRONG.values(), ids=WRONG.keys())
def test_wrong_input_is_one_line_and_exit_code_2(jkr, table: Path, words: tuple, line: str) -> None:
    jkr("import", *words).refused(line)
    assert not Path("t.h5").exists()
