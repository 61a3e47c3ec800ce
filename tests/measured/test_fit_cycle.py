"""Tables with both branches: one E*, a work of adhesion for each, rows at rest between them."""

import json
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from lens_tables import NU, H, R, lens

from jkrcli.adhesion.slopes import slopes
from jkrcli.bodies.indenters import Paraboloid
from jkrcli.bodies.problem import Elastic, Layer, Loading, Problem, Rigid, Specimen
from jkrcli.measured.curve import Curve
from jkrcli.measured.forward_model import FittedBody
from jkrcli.measured.procedure import fit
from jkrcli.measured.result import Fit
from jkrcli.measured.rows import orient
from jkrcli.measured.settings import settings_of
from jkrcli.methods.layered.solver import Layered

WORDS = ("approach", "retract")


@cache
def body() -> FittedBody:
    """The layer with half of the modulus that the tables are made with."""
    specimen = Specimen((Layer(Elastic(0.75e6, NU), H),), Rigid())
    series = Layered()(problem := Problem(Paraboloid(R), specimen, Loading("radius", 1e-3, 80))).series
    return FittedBody.of(problem, series, slopes(series), extensible=True)


def fitted(curve: Curve, **options) -> Fit:
    """With what is known of the range of adhesion, so that no range is looked for."""
    return fit(body(), curve, settings_of(body(), bound=[("range", "..1 nm")], **options))


def holds(found: Fit, truth: dict[str, float], errors: float = 3.5) -> None:
    """Each estimate within so many of its standard errors, and told to a part in ten."""
    for name, value in truth.items():
        item = found.estimate(name)
        assert abs(item.value - value) < errors * item.error, name
        assert item.error < (0.03 if name == "E_star" else 0.35) * value, name


@pytest.mark.slow
@pytest.mark.parametrize("rest", [True, False])
@pytest.mark.parametrize("columns", ["a,P", "delta,P", "a,delta,P"])
def test_both_branches_have_one_modulus_and_a_work_of_adhesion_each(columns: str, rest: bool) -> None:
    made = lens(np.random.default_rng(1), columns, rest, WORDS)
    found = fitted(made.curve)
    holds(found, made.truth)
    assert found.estimate("w").low > found.estimate("w_approach").high
    if rest:
        assert found.value("a_turn") == pytest.approx(made.turn, rel=0.01)
        alone = fitted(made.curve, segment="retract")
        holds(alone, {name: made.truth[name] for name in ("E_star", "w")})
        assert "w_approach" not in alone.free


def hertzian(seed: int, held: int) -> tuple[np.ndarray, np.ndarray]:
    """Depths [nm] and loads [mN] of a sphere of 20 um on an elastic body of E* = 3 GPa: pressed, held, unloaded,
    lifted."""
    up = np.linspace(0, 2e-7, 300)
    depth = np.concatenate([up, np.full(held, up[-1]), up[::-1], np.linspace(0, -3e-7, 150)])
    load = 4 / 3 * 3e9 * np.sqrt(20e-6) * np.maximum(depth, 0) ** 1.5
    return depth * 1e9, (load + 2e-6 * np.random.default_rng(seed).normal(size=depth.size)) * 1e3


@pytest.mark.slow
def test_a_hold_at_the_turn_is_of_neither_direction(jkr, tmp_path: Path) -> None:
    """Held rows tell nothing of an edge that rests, which does not adhere: with them the search had no end."""
    for seed, held in ((2, 100), (3, 100), (2, 0)):
        depth, load = hertzian(seed, held)
        rows = "".join(f"{h:.6g},{P:.6g}\n" for h, P in zip(depth, load, strict=True))
        (tmp_path / "table.csv").write_text(f"h (nm),P (mN)\n{rows}")
        words = orient(Curve("held", delta=depth, P=load)).segment
        assert abs(int(np.count_nonzero(words == "dwell")) - held) < 8
        done = jkr("fit", "table.csv", "--radius", "20 um", "--nu", "0.3", "--shape", "paraboloid", "--no-plots",
                   "--json", "--force")  # fmt: skip
        (told,) = json.loads(done.out)["curves"]
        assert told["status"] == "fitted"
        E_star, w = (told["estimates"][name] for name in ("E_star", "w"))
        assert E_star["low"] < 3e9 < E_star["high"]
        assert (w["low"], w["high"] < 0.05) == (0, True)


def cycles(count: int, noise: float) -> tuple[Curve, np.ndarray]:
    """So many cycles of radius and load, whose radius rests at first while the load falls; and their words."""
    up = np.linspace(50e-6, 240e-6, 15)
    a = np.tile(np.concatenate([up, np.full(3, 240e-6), up[::-1]]), count)
    P = np.tile(np.concatenate([(up / 240e-6) ** 3, [0.95, 0.9, 0.85], 0.8 * (up[::-1] / 240e-6) ** 3]), count)
    rng = np.random.default_rng(2)
    curve = Curve("c", a=a + noise * 190e-6 * rng.normal(size=a.size), P=P * 0.02)
    return curve, np.tile(np.repeat(WORDS, (15, 18)), count)


@pytest.mark.parametrize("noise", [0.0, 0.02])
@pytest.mark.parametrize("count", [1, 2, 3])
def test_the_order_of_rows_tells_the_branches_of_several_cycles(count: int, noise: float) -> None:
    curve, words = cycles(count, noise)
    told = orient(curve)
    assert np.count_nonzero(told.segment != words) <= count - 1  # rows where contact is lost and made anew
    assert [line.split(" by ")[0] for line in told.flags] == [f"{2 * count} branches"] * (count > 1)


def test_rows_in_no_order_and_single_branches_are_no_cycles() -> None:
    rng = np.random.default_rng(5)
    curve, _ = cycles(3, 0.0)
    for rows in (rng.permutation(len(curve)), np.arange(15), np.arange(15, 33)):
        assert orient(curve.rows(rows)).segment is None
    noisy = np.linspace(0, 1, 100) + 0.1 * rng.normal(size=100)
    assert orient(Curve("c", a=noisy + 1, P=noisy)).flags == ()


def test_loading_alone_and_an_edge_that_rests_throughout() -> None:
    made = lens(np.random.default_rng(1), "a,P", True, WORDS)
    found = fitted(made.curve, segment="approach")
    holds(found, {name: made.truth[name] for name in ("E_star", "w_approach")})
    assert "w" not in {item.name for item in found.estimates}
    made = lens(np.random.default_rng(3), "a,delta,P", True, WORDS)
    found = fitted(made.curve.rows(np.arange(100)))
    item = found.estimate("w")
    assert item.error is None
    assert item.high is None
    assert made.truth["w_approach"] < item.low < 1.05 * made.truth["w"]
    assert any(line.startswith("w: the contact line is pinned in all rows") for line in found.warnings)


def test_directions_that_no_modulus_describes_stand_side_by_side() -> None:
    made = lens(np.random.default_rng(4), "a,delta,P", False, WORDS, stiffer=1.4)
    found = fitted(made.curve)
    assert "directions differ" in found.flags
    assert found.value("E_star") == pytest.approx(1.4 * made.truth["E_star"], rel=0.05)
    assert found.value("E_star_approach") == pytest.approx(made.truth["E_star"], rel=0.05)


@pytest.mark.first(1)
@pytest.mark.parametrize("change", [{"loss": "huber"}, {"confidence": "profile"}])
def test_what_one_branch_can_be_asked_a_cycle_can(change: dict) -> None:
    made = lens(np.random.default_rng(5), "a,P", True, WORDS)
    holds(fitted(made.curve, **change), made.truth)
