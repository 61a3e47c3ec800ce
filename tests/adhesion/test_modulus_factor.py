"""``--modulus-factor``: bodies whose moduli are all that many times the case's, without a new solve."""

import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from jkrcli.case import store
from jkrcli.resolve.analysis import analyse

CASE = (
    '[indenter]\nshape = "paraboloid"\nradius = "50 um"\n'
    '[[specimen.layers]]\nthickness = "2 um"\nE = {film}\nnu = 0.45\n[specimen.half_space]\nE = {base}\nnu = 0.3\n'
    "[loading]\n{loading}\npoints = 40\n[adhesion]\nw = 0.05\n"
)
FACTOR = 3.0


@pytest.fixture(name="pair")
def _pair(jkr: Callable) -> tuple[Path, Path]:
    for name, factor in (("soft", 1.0), ("stiff", FACTOR)):
        text = CASE.format(film=2e6 * factor, base=5e6 * factor, loading='depth = "300 nm"')
        Path(f"{name}.toml").write_text(text)
        assert jkr("run", f"{name}.toml").code == 0
    return Path("soft.h5"), Path("stiff.h5")


@pytest.mark.parametrize("slopes", ["auto", "loocv"])
def test_equals_a_new_solve(pair: tuple[Path, Path], slopes: str) -> None:
    ours = analyse(store.read_solution(pair[0]), [0.05], slopes, FACTOR)[0]
    theirs = analyse(store.read_solution(pair[1]), [0.05], slopes)[0]
    # exact slopes: the solver's 1e-8 on radii; the fits choose their smoothing, to 1e-6 of the curve
    tolerance = 1e-8 if slopes == "auto" else 1e-6
    for name in ("a", "delta", "P"):
        values = getattr(theirs.curve, name)
        np.testing.assert_allclose(getattr(ours.curve, name), values, rtol=0, atol=tolerance * np.abs(values).max())
    for name, band in theirs.curve.errors.items():
        np.testing.assert_allclose(ours.curve.errors[name], band, rtol=1e-3)  # goes with the smoothing's square
    assert ours.validity.tabor == pytest.approx(theirs.validity.tabor, rel=1e-12)
    assert ours.problem.E_star == pytest.approx(theirs.problem.E_star, rel=1e-15)


def test_elastic_indenter_and_prescribed_load_scale_too(jkr: Callable) -> None:
    text = CASE.format(film=2e6, base=5e6, loading='load = "2 uN"').replace("[[", 'E = "3 MPa"\nnu = 0.4\n[[')
    Path("soft.toml").write_text(text)
    assert jkr("run", "soft.toml").code == 0
    problem = analyse(store.read_solution(Path("soft.h5")), [0.05], "auto", FACTOR)[0].problem
    assert problem.indenter.material.E == 9e6
    assert problem.loading.maximum == pytest.approx(6e-6, rel=1e-15)
    assert problem.E_star == pytest.approx(
        FACTOR * analyse(store.read_solution(Path("soft.h5")), [0.05])[0].problem.E_star
    )


def test_verbs_take_it(jkr: Callable, pair: tuple[Path, Path]) -> None:
    words = ["--modulus-factor", "3", "--json"]
    ours = jkr("pull-off", "soft.h5", *words).told["results"][0]
    theirs = jkr("pull-off", "stiff.h5", "--json").told["results"][0]
    assert (ours["modulus_factor"], theirs["modulus_factor"]) == (3.0, 1.0)
    for one, other in zip(ours["controls"], theirs["controls"], strict=True):
        for key in ("P_N", "delta_m", "a_m"):
            assert one["pull_off"][key] == pytest.approx(other["pull_off"][key], rel=1e-6)
    cycles = [jkr("cycle", *call).told for call in (["soft.h5", *words], ["stiff.h5", "--json"])]
    assert cycles[0]["energy_lost_J"] == pytest.approx(cycles[1]["energy_lost_J"], rel=1e-6)
    assert jkr("transform", "soft.h5", *words[:2], "--no-plots").code == 0
    assert json.loads(Path("soft-w0.05-modulus3.json").read_text())["modulus_factor"] == 3.0


@pytest.mark.parametrize(("text", "said"), [
    ("0", "must be >= 1e-12 and <= 1e+12, got 0"),
    ("-2", "must be >= 1e-12 and <= 1e+12, got -2"),
    ("nan", 'must be a plain number, such as "0.3", got "nan"'),
])  # fmt: skip
def test_wrong_factors_are_one_line(jkr: Callable, text: str, said: str) -> None:
    jkr("transform", "soft.h5", "--modulus-factor", text).refused(
        f"invalid value for '--modulus-factor': {said}; see jkr transform --help"
    )
