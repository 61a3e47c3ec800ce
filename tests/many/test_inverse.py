"""Which value of a number of a case gives a wanted pull-off force."""

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import jkrcli as python
from jkrcli.base.errors import InputError
from jkrcli.many import inverse

HALF_SPACE = """
indenter = { shape = "paraboloid", radius = "20 um" }
specimen.half_space = { E = "1 MPa", nu = 0.4 }
loading.radius = "1 um"
adhesion.w = "30 mJ/m^2"
"""
SKIN = """
indenter = {{ shape = "paraboloid", radius = "{R}" }}
specimen.layers = [{{ thickness = "{h}", E = "{E}", nu = {nu} }}]
{base}
loading.radius = "1 um"
adhesion.w = "{w}"
"""
SOFT = 'specimen.half_space = { E = "1.5 MPa", nu = 0.49 }'


@pytest.fixture(name="few")
def _few(tuned) -> None:
    tuned("jkrcli.many.inverse.FIND_SCAN", 8)


@pytest.fixture(name="half_space")
def _half_space(tmp_path: Path) -> Path:
    (path := tmp_path / "half.toml").write_text(HALF_SPACE)
    return path


@pytest.mark.usefixtures("few")
def test_jkr_is_turned_around(half_space: Path) -> None:
    """On a half-space F = 1.5 pi w R, whatever its modulus."""
    found = python.find_value(half_space, "adhesion.w", "5 uN")
    assert [root.value for root in found.roots] == pytest.approx([5e-6 / (1.5 * math.pi * 20e-6)], rel=1e-8)


@pytest.mark.usefixtures("few")
def test_no_modulus_of_a_half_space_changes_the_force(half_space: Path) -> None:
    with pytest.raises(InputError, match=r"no specimen.half_space.E gives a pull-off force of 5 uN.*2\.827 uN to 2\.8"):
        python.find_value(half_space, "specimen.half_space.E", 5e-6)


@pytest.mark.usefixtures("few")
def test_all_solutions_are_named(tmp_path: Path) -> None:
    """A stiff skin lowers the pull-off force where it is about as thick as the contact is wide."""
    path = tmp_path / "skin.toml"
    path.write_text(SKIN.format(R="50 um", h="0.5 um", E="20 MPa", nu=0.45, w="50 mJ/m^2", base=SOFT))
    found = python.find_value(path, "specimen.layers[0].thickness", "9 uN", ("0.5 um", "10 um"))
    assert len(found.roots) == 2
    assert found.words()[0].startswith("2 solutions: ")
    for root in found.roots:
        text = SKIN.format(R="50 um", h=f"{root.value!r} m", E="20 MPa", nu=0.45, w="50 mJ/m^2", base=SOFT)
        case = python.parse_case(text.replace('"1 um"', '"8 um"'))
        (control, *_) = python.pull_off(python.solve(case), 0.05).summary()["controls"]
        assert -control["pull_off"]["P_N"] == pytest.approx(9e-6, rel=1e-8)


def drawn(i: int) -> tuple[str, str, float]:
    rng = np.random.default_rng([5, i])
    R, h = 10 ** rng.uniform(-6, -4), 10 ** rng.uniform(-7, -5)
    E, nu, w = 10 ** rng.uniform(4, 7), rng.uniform(0.2, 0.49), 10 ** rng.uniform(-3, -1)
    base = "" if i % 2 else f"specimen.half_space = {{ E = {E * 10 ** rng.uniform(-1, 1)!r}, nu = 0.4 }}"
    key = ("indenter.radius", "specimen.layers[0].thickness", "specimen.layers[0].E", "adhesion.w")[i // 2 % 4]
    value = {"indenter.radius": R, "specimen.layers[0].thickness": h, "specimen.layers[0].E": E, "adhesion.w": w}[key]
    text = SKIN.format(R=f"{R!r} m", h=f"{h!r} m", E=f"{E!r} Pa", nu=nu, w=f"{w!r} J/m^2", base=base)
    return text, key, float(value)


@pytest.mark.slow
@pytest.mark.parametrize("i", range(16))
def test_the_number_that_made_a_force_is_found_again(i: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """To 1e-8, by at most 25 bodies over the bounds and 12 for each solution."""
    text, key, true = drawn(i)
    (path := tmp_path / "case.toml").write_text(text)
    solves = list[Any]()
    solved_for = inverse.solved_for
    monkeypatch.setattr(inverse, "solved_for", lambda *args: solves.append(args) or solved_for(*args))
    case = python.load_case(path)
    w = case.model.adhesion.w[0]
    force = -python.pull_off(solved_for(case.model.problem(), [w]), w).summary()["controls"][0]["pull_off"]["P_N"]
    found = python.find_value(path, key, force, (true / 3.1, true * 2.3))
    assert min(abs(root.value / true - 1) for root in found.roots) < 1e-8
    assert len(solves) <= 25 + 12 * len(found.roots)


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["--find", "indenter.radius"], "needs the pull-off force that is wanted"),
        (["--load", "5 uN", "--find", "indenter.shape"], "is no number of"),
        (
            ["--load", "5 uN", "--find", "indenter.siz"],
            'did you mean "indenter.radius"?; allowed are R, w, E, nu, E:base',
        ),
        (["--load", "5 uN", "--find", "indenter radius"], "--find: indenter radius is no number of"),
        (["--load", "5 uN", "--find", "indenter.radius=1um"], "must be KEY or KEY=LOW..HIGH"),
        (["--load", "5 uN", "--find", "indenter.radius=1um..1nm"], "bounds LOW..HIGH that rise"),
        (["--load", "5 uN", "--find", "indenter.radius", "--w", "1"], "takes w from the case"),
    ],
)
def test_refusals(jkr, half_space: Path, words: list[str], message: str) -> None:
    jkr("pull-off", half_space, *words).refused(message)


def test_numbers_of_a_case_have_the_short_names_of_fits(tmp_path: Path) -> None:
    text = SKIN.format(R="50 um", h="1 um", E="20 MPa", nu=0.4, w="50 mJ/m^2", base=SOFT)
    (path := tmp_path / "case.toml").write_text(text.replace("{ thickness", '{ name = "skin", thickness'))
    names = inverse.short_names(python.load_case(path).model)
    assert names["h:skin"] == "specimen.layers[0].thickness"
    assert names["E:base"] == "specimen.half_space.E"
    assert (names["R"], names["w"], "h:base" in names, "h" in names) == ("indenter.radius", "adhesion.w", False, False)
    path.write_text(text.replace(SOFT, ""))
    assert inverse.short_names(python.load_case(path).model)["h"] == names["h:skin"]


PUNCH = SKIN.replace('"paraboloid"', '"flat"').replace('"1 um"', '"{R}"')


def test_what_would_take_long_is_refused_at_once(jkr, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A flat punch is solved to its rim: 30 mm on 50 um take far longer than 33 um, from where values begin."""
    solves = list[Any]()
    monkeypatch.setattr(inverse, "solved_for", lambda *args: solves.append(args))
    (tmp_path / "punch.toml").write_text(PUNCH.format(R="1 mm", h="50 um", E="1 MPa", nu=0.49, w=0.05, base=""))
    words = ["--load", "400 mN", "--find", "indenter.radius", "--limit-time", 0.01]
    outcome = jkr("pull-off", tmp_path / "punch.toml", *words)
    said = " ".join(outcome.err.split())
    assert (outcome.code, outcome.out, solves) == (2, "", [])
    assert "pull-off of 25 values of indenter.radius would need" in said
    assert "the limit is 0.01 h: use narrower bounds, KEY=LOW..HIGH, or raise the limit by --limit-time" in said


def test_the_verb_tells_the_value_and_where_it_looked(jkr, half_space: Path) -> None:
    outcome = jkr("pull-off", half_space, "--load", "5 uN", "--find", "indenter.radius=10um..90um").ok
    text = " ".join(outcome.out.split())
    assert text.startswith("indenter.radius = 35.3678 um")
    assert "25 values from 10 um to 90 um give 1.414 uN to 12.72 uN" in text
