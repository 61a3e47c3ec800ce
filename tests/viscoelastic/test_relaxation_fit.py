"""Fits of relaxation to records of another generator: rings stepped through time."""

from collections.abc import Callable

import described_body
import numpy as np
import pytest
from relaxation_records import record
from scipy.special import beta, betainc

import jkrcli as jkr
from jkrcli.adhesion.curve import Nonadhesive
from jkrcli.adhesion.device_path import Program
from jkrcli.base.errors import InputError, JkrError
from jkrcli.base.numerics import Array
from jkrcli.measured.curve import NOT_SUBTRACTED, Curve
from jkrcli.measured.forward_model import FittedBody, body_of
from jkrcli.viscoelastic.law_fits import RelaxationFits
from jkrcli.viscoelastic.relaxation import Depths, RelaxedHistory, RelaxingContact
from jkrcli.viscoelastic.relaxation_fit import relaxation_fit
from jkrcli.viscoelastic.timed_record import RelaxationFit, corners, relaxation_settings

SOLID = 0.25, (0.75,), (1.0,)
HELD = np.array([0.0, 0.3, 4.0, 5.0]), np.array([0.0, 1.0, 1.0, 0.0])
CASE = described_body.UNIT.format(depth=1.5)


@pytest.fixture(scope="module", name="body")
def _body() -> FittedBody:
    return body_of(jkr.parse_case(CASE))


def loads(body: FittedBody) -> Callable[[Array], Array]:
    return Depths(Nonadhesive(body.series, body.slopes)).loads


def history_of(body: FittedBody, t: Array, x: Array) -> RelaxedHistory:
    law = jkr.StandardSolid(0.25, 1.0)
    return RelaxingContact(Nonadhesive(body.series, body.slopes), law).history(Program(t, x))


def off(fit: RelaxationFit, **true: float) -> dict[str, float]:
    """Distances from the truth in standard errors."""
    return {name: (fit.estimate(name).value - value) / (fit.estimate(name).error or 0) for name, value in true.items()}


@pytest.mark.slow
def test_profiles_are_near_the_covariance(body: FittedBody) -> None:
    """Where the model is about linear within its errors; none of the bootstrap, as no rows are drawn again."""
    made = record(loads(body), 1.4, SOLID, HELD, rows=60, zero=0.2, seed=4)
    plain, profiled = (relaxation_fit(body, made, relaxation_settings("sls", confidence=how))
                       for how in ("covariance", "profile"))  # fmt: skip
    for name in ("E_star", "ratio", "time", "delta0"):
        one, other = plain.estimate(name), profiled.estimate(name)
        assert (other.low, other.high) == pytest.approx((one.low, one.high), abs=0.2 * one.error)
        assert other.low != one.low
    with pytest.raises(InputError, match="confidence: must be one of covariance, profile"):
        relaxation_fit(body, made, relaxation_settings("sls", confidence="bootstrap"))


def test_a_quick_press_of_a_long_record(body: FittedBody) -> None:
    """Four of 300 rows, which lie between those that starts are compared by."""
    motion = np.array([0.0, 0.4, 29.6, 30.0]), HELD[1]
    made = record(loads(body), 1.2, SOLID, motion, rows=300, zero=0.1, seed=1)
    fit = relaxation_fit(body, made, relaxation_settings("sls"))
    assert max(map(abs, off(fit, E_star=1.0, ratio=0.25, time=1.0, delta0=0.1).values())) < 3.5


def test_a_power_law_of_a_clean_record(body: FittedBody) -> None:
    """Its modulus is that at its time, which is given; another law shows itself."""
    modes = jkr.PowerRelaxation(1.0, 0.2).modes(4.0)
    spectrum = modes.relaxed, tuple(modes.weights), tuple(modes.rates)
    made = record(loads(body), 1.4, spectrum, (np.array([0.0, 0.4, 4.0]), HELD[1][:3]), rows=41, noise=0.0)
    fit = relaxation_fit(body, made, relaxation_settings("power", [("delta0", "0")]))
    assert fit.estimate("exponent").value == pytest.approx(0.2, rel=2e-3)  # 5e-4, of the rings and steps
    assert fit.estimate("E_star").value == pytest.approx(1.0, rel=2e-3)


@pytest.mark.slow
def test_creep_is_known_by_its_load(body: FittedBody) -> None:
    made = record(loads(body), 1.4, SOLID, (np.array([0.0, 0.2, 4.0]), np.array([0.0, 0.3, 0.3])), 80, stiffness=0.0)
    fit = relaxation_fit(body, made, relaxation_settings("sls", [("delta0", "0")]))
    assert fit.record.loaded
    assert max(map(abs, off(fit, E_star=1.0, ratio=0.25, time=1.0).values())) < 3.5


def test_corners_of_a_motion() -> None:
    t, rng = np.linspace(0, 10, 400), np.random.default_rng(1)
    found, places = corners(t, np.interp(t, [0, 2, 7, 10], [0, 1, 1, -1]) + 0.01 * rng.standard_normal(400), 0.01)
    assert found == pytest.approx([0, 2, 7, 10], abs=0.08)  # 1.5 times the distance of rows over the noise
    assert places == pytest.approx([0, 1, 1, -1], abs=0.02)
    t = np.linspace(0, 2, 400)  # 1 lies in the middle between two
    found, places = corners(t, 1 - np.abs(t - 1), 1e-12)
    assert found == pytest.approx([0, 1, 2])
    assert places == pytest.approx([0, 1, 0], abs=1e-12)
    stepped, _ = corners(t, np.where(t < 1, 0.0, 1.0), 1e-12)  # a step stays one
    assert {t[199], t[200]} <= set(stepped)


def test_what_cannot_be_fitted(body: FittedBody) -> None:
    t = np.linspace(0, 1, 30)
    for columns, line in (
        ({"delta": t, "P": t}, "a fit of relaxation needs t, delta and P, it lacks t"),
        ({"t": t[:10], "delta": t[:10], "P": t[:10]}, "10 rows, at least 20 are needed"),
        ({"t": t[::-1], "delta": t, "P": t}, "time must rise from row to row, it does not in row 2"),
    ):
        with pytest.raises(InputError, match=line):
            relaxation_fit(body, Curve("made", **columns), relaxation_settings("sls"))
    for fixed, line in (
        ([("ratoi", "0.3")], 'unknown parameter "ratoi", did you mean "ratio"'),
        ([("time", "-1")], "time: must be > 0, got -1"),
        ([("E_star", "1"), ("modulus", "2")], "E_star and modulus are one parameter, which is given twice"),
    ):
        with pytest.raises(InputError, match=line):
            relaxation_settings("sls", fixed)


def test_a_retraction_that_adheres_and_a_base_line(body: FittedBody) -> None:
    """The press and the wait alone are fitted, with what the rows before contact show; many rows by their means."""
    t, x = np.array([0.0, 1.0, 1.3, 4.0, 5.0]), np.array([-0.6, 0.0, 1.0, 1.0, -2.0])
    history = history_of(body, t, x)
    at, rng = np.linspace(0, 5, 6001), np.random.default_rng(3)
    load = history.states(at)[2] + 0.2 + 0.05 * np.interp(at, t, x) - np.where(at > 4.3, 0.3, 0.0)
    delta, P = (column + 0.01 * rng.standard_normal(at.size) for column in (np.interp(at, t, x), load))
    fit = relaxation_fit(body, Curve("made", t=at, delta=delta, P=P), relaxation_settings("sls"))
    assert fit.free[-2:] == ("P0", "tilt")
    assert fit.record.t.size < 1500
    assert "adhesion pulls with" in fit.warnings[0]
    assert max(map(abs, off(fit, E_star=1.0, ratio=0.25, time=1.0, delta0=0.0, tilt=0.05).values())) < 3.5


def test_a_motion_that_is_not_straight_is_followed(body: FittedBody) -> None:
    t = np.linspace(0, 4, 400)
    x = np.sin(np.minimum(t, 1.0) * np.pi / 2) + 0.2 * np.sqrt(np.maximum(t - 1, 0)) - 0.1
    history = history_of(body, t, x)
    load = history.states(t)[2]
    load += 0.003 * np.ptp(load) * np.random.default_rng(1).standard_normal(t.size)
    curve = Curve("made", t=t, delta=x + 1e-5 * np.sin(1e3 * t), P=load, flags=(NOT_SUBTRACTED,))
    fit = relaxation_fit(body, curve, relaxation_settings("sls"))
    assert fit.record.read
    assert fit.warnings[0].startswith("E* is that of contact and instrument in series")
    assert "the displacement of the tip is used as read" in fit.warnings[1]
    for law, free in (("sls", []), ("sls", ["w"])):
        with pytest.raises(JkrError, match=NOT_SUBTRACTED):
            relaxation_fit(body, curve.rows(np.arange(4)), relaxation_settings(law, free=free))
    assert max(map(abs, off(fit, E_star=1.0, ratio=0.25, time=1.0, delta0=0.0).values())) < 3.5


@pytest.mark.slow
def test_terms_that_a_record_does_not_tell(body: FittedBody) -> None:
    for modes, untold in ((SOLID, True), ((0.2, (0.4, 0.4), (3.0, 0.3)), False)):
        made = record(loads(body), 1.4, modes, (np.array([0.0, 0.2, 9.0, 9.3]), HELD[1]), rows=150, seed=2, noise=0.003)
        fit = relaxation_fit(body, made, relaxation_settings("prony", [("delta0", "0")]))
        said = [line for line in fit.warnings if "1 terms fit as well as 2 (BIC better by" in line]
        assert bool(said) == untold, (fit.estimates, fit.warnings)


# ---------------------------------------------------------------------- a lever, and a power law
def ting_loads(t: Array, speed: float, turn: float, E_star: float, exponent: float, R: float) -> Array:
    """Loads [N] at times [s] since contact of a tip that goes in and, from ``turn`` [s] on, out at one ``speed`` [m/s];
    E* is that at 1 s.

    P = 2 E* sqrt(R) v^(3/2) int_0^t1 (t - s)^-al sqrt(s) ds, t1 = t, behind the turn t - 2^(1/(1 - al)) (t - tm).
    """
    t1 = np.where(t <= turn, t, t - 2 ** (1 / (1 - exponent)) * (t - turn))
    t1 = np.maximum(t1, 0.0)
    whole = beta(1.5, 1 - exponent) * np.maximum(t, 1e-300) ** (1.5 - exponent)
    share = betainc(1.5, 1 - exponent, np.clip(t1 / np.maximum(t, 1e-300), 0.0, 1.0))
    return np.where(t > 0, 2 * E_star * np.sqrt(R) * speed**1.5 * whole * share, 0.0)


def ting_record(
    rng: np.random.Generator, noise: float, lever: float, rows: int, exact: bool = False
) -> tuple[Array, float]:
    """Times, positions of the device and loads (rows, 3), and the stiffness of the device [N/m]: ``lever`` times that
    of the contact at the turn; ``noise`` of the loads over their largest; in the positions it is too, but for ``exact``
    ones. E* = 4/3 kPa, exponent 0.2, R = 5 um."""
    deepest, speed, free = 1e-6, 1e-5, 7.5
    turn = deepest / speed
    first = -free * turn
    t = np.linspace(first, 2 * turn - first, rows)
    tip = np.where(t <= turn, speed * t, deepest - speed * (t - turn))
    P = ting_loads(t, speed, turn, 4e3 / 3, 0.2, 5e-6)
    ends = ting_loads(turn * np.array([1 - 1e-6, 1.0]), speed, turn, 4e3 / 3, 0.2, 5e-6)
    k = lever * float(np.ptp(ends)) / (deepest * 1e-6)
    read = P + noise * P.max() * rng.standard_normal(rows)
    x = tip + (P if exact else read) / k
    return np.stack([t - first, x, read], axis=1), k


@pytest.fixture(scope="module", name="probed")
def _probed() -> FittedBody:
    """A paraboloid of 5 um on a half-space of E* 4/3 kPa."""
    sizes = (("radius = 1.0", 'radius = "5 um"'), ("E = 1.0", "E = 1e3"), ("nu = 0.0", "nu = 0.5"),
             ("depth = 1.5", 'depth = "1 um"'))  # fmt: skip
    text = CASE
    for one, other in sizes:
        text = text.replace(one, other)
    return body_of(jkr.parse_case(text))


def by_power(body: FittedBody, made: tuple[Array, float], zero: float = 0.0) -> RelaxationFit:
    (t, x, P), k = made[0].T, made[1]
    curve = Curve("made", t=t, delta=x + zero - P / k, P=P, stiffness=k)
    return relaxation_fit(body, curve, relaxation_settings("power", E_star=body.problem.E_star))


def test_a_tip_at_constant_speed_on_a_lever(probed: FittedBody) -> None:
    """Ting's curve of a power law in closed form: the device, by which it is read, does not move in straight pieces."""
    for seed, exact, lever, noise in ((1, False, 28.0, 0.024), (2, True, 0.2, 0.05)):
        made = ting_record(np.random.default_rng(seed), noise, lever, rows=300, exact=exact)
        fit = by_power(probed, made, zero=2e-7)
        assert fit.record.control == "tip"
        assert max(map(abs, off(fit, E_star=4e3 / 3, exponent=0.2, delta0=2e-7).values())) < 3.5
        assert fit.warnings == ()
        assert fit.doubts == []


def test_errors_are_those_of_the_load_alone_where_a_position_is_exact(probed: FittedBody) -> None:
    """A position without noise takes none of the errors away: they are the bound of Cramer and Rao by Ting's formula,
    but for the scatter of the rows in contact."""
    made, k = ting_record(np.random.default_rng(5), 0.02, 5.0, rows=400)
    fit = by_power(probed, (made, k))
    t, true, steps = made[:, 0] - 0.75, np.array([0.0, np.log(4e3 / 3), 0.2]), np.array([1e-5, 1e-5, 1e-5])

    def loads(begin: float, log_E: float, exponent: float) -> Array:
        return ting_loads(t - begin, 1e-5, 0.1 - begin, float(np.exp(log_E)), exponent, 5e-6)

    rates = np.stack([(loads(*(true + h)) - loads(*(true - h))) / (2 * h.sum()) for h in np.diag(steps)], axis=1)
    noise = 0.02 * loads(*true).max()
    bound = noise * np.sqrt(np.diag(np.linalg.inv(rates.T @ rates)))
    scale = float(np.mean((fit.record.response - fit.response)[loads(*true) > 0] ** 2)) ** 0.5 / noise
    found = [fit.estimate("E_star").error / fit.value("E_star"), fit.estimate("exponent").error]
    assert found == pytest.approx(scale * bound[1:], rel=0.25)  # 0.71 of it where the exact column counted as rows


def test_what_a_record_does_not_determine_is_said_first(probed: FittedBody) -> None:
    fit = by_power(probed, ting_record(np.random.default_rng(3), 0.1, 1.0, rows=60))
    ((first, *_),) = RelaxationFits([fit], "a body").parts
    assert "doubtful: E* is uncertain by" in first
    with pytest.raises(InputError, match="no contact shows: the load stays within its noise"):
        by_power(probed, ting_record(np.random.default_rng(3), 0.4, 1.0, rows=120))
