"""Fits of exact and of noisy synthetic curves: what goes in comes out, with honest intervals."""

from collections import Counter
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import described_body
import numpy as np
import odrpack
import pytest
from fit_data import (
    A_C,
    A_END,
    DELTA_C,
    E_STAR,
    P_C,
    R,
    W,
    adhesive,
    body_of,
    coating,
    free,
    half_space,
    measured,
    sphere,
    thin_layer,
    usual,
)

from jkrcli.adhesion.curve import transform
from jkrcli.base.errors import InputError
from jkrcli.bodies.indenters import Paraboloid
from jkrcli.bodies.problem import Elastic, HalfSpace, Loading, Problem, Specimen
from jkrcli.case.models import parse_case
from jkrcli.measured import forward_model, rows
from jkrcli.measured.curve import NOT_SUBTRACTED, Curve
from jkrcli.measured.forward_model import body_of as body_of_case
from jkrcli.measured.parameters import Parameter
from jkrcli.measured.procedure import fit
from jkrcli.measured.rows import points_of
from jkrcli.measured.settings import Settings
from jkrcli.methods.layered.solver import Layered

EXACT = 1e-6  # the accuracy asked for without noise; the series' own points and tolerance leave about 2e-7


def starts(seed: int, **truth: float) -> dict[str, float]:
    """Random starts: positive quantities within a factor of ten, zero points within three times their value."""
    random = np.random.default_rng(seed)
    return {
        name: value * (random.uniform(-3, 3) if name == "delta0" else 10 ** random.uniform(-1, 1))
        for name, value in truth.items()
    }


@pytest.fixture(name="counted")
def _counted(monkeypatch: pytest.MonkeyPatch) -> Counter[str]:
    """What a fit costs, the same on every machine: "solves" of bodies and "evaluations" of all distances."""
    counts: Counter[str] = Counter()

    def counting(name: str, function: Callable[..., Any]) -> Callable[..., Any]:
        def call(*arguments: Any) -> Any:
            counts[name] += 1
            return function(*arguments)

        return call

    monkeypatch.setattr(forward_model, "Layered", lambda tolerance: counting("solves", Layered(tolerance)))
    monkeypatch.setattr(rows, "foot_points", counting("evaluations", rows.foot_points))
    forward_model.solved.cache_clear()
    return counts


def check(found, **truth: float) -> None:
    for name, value in truth.items():
        assert found.value(name) == pytest.approx(value, rel=EXACT), name


@pytest.mark.parametrize("seed", range(3))
def test_curves_without_noise_from_random_starts(seed: int) -> None:
    """Of the half-space and of a thin nearly incompressible layer."""
    truth = {"modulus": 0.5, "w": W, "delta0": 0.3 * DELTA_C}
    settings = Settings(free(*truth, **starts(seed, **truth)))
    check(fit(half_space(), sphere(shift=0.3), settings), **truth, E_star=E_STAR)
    truth = {"modulus": 1.7, "w": 0.04, "delta0": 3e-6}
    settings = Settings(free(*truth, **starts(seed, **truth)))
    check(fit(body_of(thin_layer()), measured(thin_layer(), 0.04, 1.7, 3e-6, 1.0), settings), **truth)


@pytest.mark.parametrize("confidence", ["covariance", "profile", "bootstrap"])
def test_a_search_that_is_given_up_tells_no_interval(tuned: Callable, confidence: str) -> None:
    """Where it would have ended is a matter of round-off, on records that do not determine what is sought."""
    tuned("jkrcli.measured.rows.SEARCH_EVALUATIONS", 2)
    found = fit(half_space(), sphere(noise=0.01), usual(confidence=confidence, samples=20))
    assert found.covariance is None
    for name in ("modulus", "w", "delta0", "E_star"):
        assert (found.estimate(name).error, found.estimate(name).low, found.estimate(name).high) == (None, None, None)
    assert "not determined" in found.flags
    assert "stopped after 2 steps, the data do not determine E*, w, delta0: give" in found.warnings[0]


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(4))
def test_coating_of_unknown_modulus_without_noise_from_random_starts(seed: int, counted: Counter[str]) -> None:
    truth = {"E:skin": 20e6, "w": 0.05, "delta0": 2e-8}
    nominal = 20e6 * 10 ** np.random.default_rng(100 + seed).uniform(-1, 1)
    settings = Settings(free(*truth, **starts(seed, **truth)))
    body, curve = body_of(coating(nominal)), measured(coating(), 0.05, delta0=2e-8)
    counted.clear()
    found = fit(body, curve, settings)
    assert counted["solves"] <= 40  # 19 to 34 measured
    assert counted["evaluations"] <= 200  # 114 to 156 measured
    check(found, **truth)
    assert found.value("E:base") == pytest.approx(1.5e6, rel=1e-14)


def test_radii_beyond_and_below_those_of_the_case() -> None:
    problem = thin_layer()
    small = replace(problem, loading=replace(problem.loading, maximum=0.05 * problem.loading.maximum))
    body = body_of(problem)
    made = transform(body.series, body.slopes, 0.04)
    curve = Curve("optical", a=made.a[20:], delta=made.delta[20:], P=made.P[20:])
    check(fit(replace(body_of(small), extensible=True), curve, usual()), w=0.04)
    with pytest.raises(
        InputError, match=r"data reach contact radii of .*, the solution ends at .*: increase \[loading"
    ):
        fit(body_of(small), curve, usual())
    # The body is solved to the least radii of the data, too: of a case "begin at smaller radii" was said.
    delta = np.array([1e-6, 3e-6, 1e-4, *np.linspace(0.01, 0.2, 20)])
    case = described_body.UNIT.format(depth=0.2).replace("depth", "radius")
    known = (Parameter("w", False, 0.0), Parameter("delta0", False, 0.0))
    found = fit(
        body_of_case(parse_case(case.encode(), "gel")),
        Curve("c", delta=delta, P=4 / 3 * delta**1.5),
        Settings((*free("modulus"), *known)),
    )
    assert found.value("E_star") == pytest.approx(1.0, rel=1e-4)


@pytest.mark.slow
def test_thickness_of_a_layer_is_found() -> None:
    problem = thin_layer(0.4)
    wrong = replace(problem.specimen.layers[0], thickness=0.5e-3)
    body = body_of(replace(problem, specimen=replace(problem.specimen, layers=(wrong,))))
    found = fit(body, measured(problem, 0.04), Settings(free("h:gel", "w", "delta0")))
    check(found, **{"h:gel": 0.36e-3}, w=0.04)
    assert abs(found.value("delta0")) < EXACT * found.data["delta"].max()


def test_curves_with_radii() -> None:
    a = np.linspace(A_C, A_END, 50)
    delta, P = adhesive(a)
    found = fit(half_space(), Curve("microscope", a=a, P=P), usual())
    check(found, E_star=E_STAR, w=W)
    assert found.free == ("modulus", "w")
    both = Curve("all", a=a, delta=delta + 1e-7, P=P + 2e-6)
    found = fit(half_space(), both, Settings(free("modulus", "w", "delta0", "P0")))
    check(found, E_star=E_STAR, w=W, delta0=1e-7, P0=2e-6)
    a = np.linspace(A_C, A_END, 50)
    found = fit(half_space(), Curve("a", a=a, delta=adhesive(a)[0]), usual())
    assert found.value("w") / found.value("E_star") == pytest.approx(W / E_STAR, rel=1e-12)  # 1e-15 measured
    assert found.warnings[0].startswith("a and delta alone determine w/E* only")


def test_compliance_and_uncertain_inputs() -> None:
    delta, P = adhesive(np.linspace(0.6 * A_C, A_END, 100))
    curve = Curve("soft", delta=delta + 0.004 * P, P=P)
    found = fit(half_space(), curve, Settings(free("modulus", "w", "delta0", "compliance")))
    check(found, E_star=E_STAR, w=W, compliance=0.004)
    held = (Parameter("modulus", True), Parameter("w", True, None, 0.2, 0.3), Parameter("delta0", True))
    assert "w ends on its bound 200 mJ/m^2" in fit(half_space(), sphere(), Settings(held)).warnings
    # E of a half-space is E* (1 - nu^2): at nu = 0.5 a standard deviation of 0.02 is one of 2 nu 0.02/(1 - nu^2).
    body, curve = half_space(), sphere(noise=0.01, seed=2)
    plain = fit(body, curve, usual())
    wide = fit(body, curve, usual(uncertain={"nu:base": 0.02}))
    E = wide.estimate("E:base")
    assert E.systematic["nu:base"] == pytest.approx(-E.value * 0.02 * (0.5 + 0.48) / 0.75, rel=1e-7)  # one-sided; 8e-9
    assert E.error == pytest.approx(np.hypot(plain.estimate("E:base").error, E.systematic["nu:base"]), rel=1e-12)
    assert wide.estimate("w").error == pytest.approx(plain.estimate("w").error, rel=1e-10)  # E* and w feel no nu


@pytest.mark.parametrize(
    ("confidence", "points", "width"),
    [("profile", 200, 0.002), ("bootstrap", 60, 0.4)],  # 6e-4 and 0.28 measured
)
def test_other_intervals_agree_with_those_of_the_covariance(confidence: str, points: int, width: float) -> None:
    """At 1 % noise the problem is nearly linear; 40 bootstrap samples scatter."""
    curve, told = sphere(points, noise=0.01, seed=4), {"noise": {"delta": 0.01 * DELTA_C, "P": 0.01 * P_C}}
    plain = fit(half_space(), curve, usual(**told))
    other = fit(half_space(), curve, usual(confidence=confidence, samples=40, **told))
    for name in ("E_star", "w", "delta0"):
        one, two = plain.estimate(name), other.estimate(name)
        assert two.high - two.low == pytest.approx(one.high - one.low, rel=width)


def test_parts_of_a_curve() -> None:
    curve, random = sphere(noise=0.01, seed=1), np.random.default_rng(0)
    flat = np.linspace(-6, -1.3, 40) * DELTA_C
    whole = Curve(
        "whole",
        delta=np.concatenate([curve.delta, curve.delta[::-1], flat]),
        P=np.concatenate([curve.P + P_C, curve.P[::-1], 0.01 * P_C * random.standard_normal(40)]),
        segment=np.repeat(["approach", "retract"], [200, 240]),
    )
    found = fit(half_space(), whole, usual(segment="retract"))
    assert found.left_out == ("200 rows of other segments", "40 rows out of contact")
    assert found.rows[0] == 200
    assert found.value("w") == pytest.approx(W, rel=0.01)  # 1 % noise: five standard errors
    curve = sphere(noise=0.01, seed=5)
    compressive = fit(half_space(), curve, usual(branch="compressive"))
    assert compressive.left_out == ("108 rows of the adhesive part",)
    assert any(text.startswith("no pull-off in the data") for text in compressive.warnings)
    item = compressive.estimate("w")
    assert item.low < W < item.high
    assert item.error > 5 * fit(half_space(), curve, usual()).estimate("w").error
    adhesive = fit(half_space(), curve.rows(curve.P < 0), usual())
    assert adhesive.value("w") == pytest.approx(W, rel=0.02)


def test_what_is_said_of_odd_curves() -> None:
    a, random = np.linspace(0.5 * A_C, A_END, 200), np.random.default_rng(0)
    delta, P = adhesive(a, w=0.0)
    noise = 0.01 * random.standard_normal((2, 200))
    found = fit(half_space(), Curve("dry", delta=delta + noise[0] * DELTA_C, P=P + noise[1] * P_C), usual())
    item = found.estimate("w")
    assert item.low == 0
    assert item.high < 0.05 * W
    assert found.warnings[0].startswith("w is not significantly above 0: it is at most ")
    assert found.value("E_star") == pytest.approx(E_STAR, rel=0.005)
    curve = sphere(noise=0.0)
    found = fit(half_space(), replace(curve, P=1000 * curve.P), usual())
    assert any("check the units of the data" in text for text in found.warnings)
    assert not any("check the units" in text for text in fit(half_space(), curve, usual()).warnings)
    delta = np.linspace(0.0, 1e-6, 50)
    with pytest.raises(
        InputError, match=r"wrong sign; .*--flip delta, --flip P\); the deflection .*: give --stiffness"
    ):
        fit(half_space(), Curve("way", delta=delta, P=-delta, flags=(NOT_SUBTRACTED,)), usual())


def test_change_of_units_changes_nothing() -> None:
    length, force = 1e3, 1e-4
    body, curve = half_space(), sphere(noise=0.01, seed=3, shift=0.2)
    specimen = Specimen((), HalfSpace(Elastic(1.5e6 * force / length**2, 0.5)))
    loading = Loading("radius", body.problem.loading.maximum * length, 100)
    other = Problem(Paraboloid(R * length), specimen, loading)
    one = fit(body, curve, usual())
    two = fit(body_of(other), Curve("odd", delta=curve.delta * length, P=curve.P * force), usual())
    for name, scale in (("E_star", force / length**2), ("w", force / length), ("delta0", length)):
        assert two.value(name) == pytest.approx(one.value(name) * scale, rel=5e-9)  # 4e-10 measured
        assert two.estimate(name).error == pytest.approx(one.estimate(name).error * scale, rel=2e-9)  # 1e-10


def test_odrpack_finds_the_same() -> None:
    """ODRPACK95 on P(delta) of the half-space, a single-valued function there: the same minimum and standard errors.

    It takes the curve as a line through 4000 radii: parameters to 1e-4; errors to 1e-3.
    """
    curve, radii = sphere(500, 0.01, 3, 0.2), np.linspace(0.55 * A_C, 1.3 * A_END, 4000)

    def load(x, beta):
        delta, P = adhesive(radii, beta[0] * E_STAR, beta[1] * W)
        fold = np.argmin(delta)
        return np.interp((x - beta[2]) * DELTA_C, delta[fold:], P[fold:]) / P_C

    theirs = odrpack.odr_fit(load, curve.delta / DELTA_C, curve.P / P_C, np.array([1.1, 0.9, 0.0]))
    ours = fit(half_space(), curve, usual(noise={"delta": DELTA_C, "P": P_C}))
    units = {"E_star": E_STAR, "w": W, "delta0": DELTA_C}
    assert [ours.value(name) / unit for name, unit in units.items()] == pytest.approx(list(theirs.beta), rel=1e-4)
    errors = [ours.estimate(name).error / unit for name, unit in units.items()]
    assert errors == pytest.approx(list(theirs.sd_beta), rel=1e-3)  # 1e-4 measured


def test_a_scaling_fit_is_quick(counted: Counter[str]) -> None:
    fit(half_space(), sphere(500, 0.01), usual())
    assert counted["solves"] == 0
    assert counted["evaluations"] <= 45  # 41 measured, 12 of them for its alternatives


def test_the_end_of_a_curve_on_a_thin_layer_is_no_base_line() -> None:
    """A stiff device follows the contact to loads near zero there; with radii read, rows with a > 0 are in contact."""
    a, delta = np.linspace(5.0, 0.5, 60), np.linspace(20.0, -8.0, 60)
    P = np.concatenate([np.linspace(4, -1, 30), np.linspace(-1, -0.05, 30)])
    for radii in (a, None):
        assert len(points_of(Curve("c", radii, delta, P, None, None), None, "all", 3, None)) >= 59
    line = np.concatenate([np.linspace(4, -1, 30), np.zeros(30)])
    assert len(points_of(Curve("c", None, delta, line, None, None), None, "all", 3, None)) == 30


@pytest.mark.parametrize(("line", "power"), [(7, 1.0), (9, 1.5), (30, 3.0)])
def test_a_base_line_of_few_rows_is_one(line: int, power: float) -> None:
    """Up to ten rows of it were fitted as contact: "the best fit leaves 140 % of the signal unexplained"."""
    depth = np.linspace(0.02, 1.0, 22)
    delta = np.concatenate([0.03 * np.arange(-line, 0), depth])
    for noise in (0.0, 1e-4):
        P = np.where(delta > 0, np.abs(delta) ** power, 0.0)
        P += noise * np.random.default_rng(1).standard_normal(P.size)
        found = points_of(Curve("c", None, delta, P, None, None), None, "all", 3, None)
        assert 20 <= len(found) <= 22
        alone = points_of(Curve("c", None, depth, P[line:], None, None), None, "all", 3, None)
        assert len(alone) == 22  # a curve that begins gently is none
