"""Hysteresis and creep of a piezo that are fitted with the rest: records by formulae of their own."""

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from force_curves import back_at, equilibrium, load_at
from raw_records import BODY, R, usual

from jkrcli.base.errors import InputError
from jkrcli.measured.curve import Curve
from jkrcli.measured.joint import joint_fit
from jkrcli.measured.procedure import fit

E_STAR, W_IN, W_OUT, K, ROWS = 20e3, 3e-5, 1e-4, 0.05, 1000
FORCE = 1.5 * math.pi * W_OUT * R
TRUE = {"E_star": E_STAR, "w": W_OUT, "w_approach": W_IN}


def bowed(amount: float) -> Callable[[np.ndarray], np.ndarray]:
    """Of the travel, over its share from the turn on: at most ``amount`` in its middle."""
    return lambda share: amount * (1 - (2 * share - 1) ** 2)


def crept(amount: float) -> Callable[[np.ndarray], np.ndarray]:
    """Per decade of the time since the last row of the approach, from a hundredth of the record on, which lasts two
    ways less a row."""
    return lambda share: amount * np.log1p((share * (1 - 1 / ROWS) + 1 / ROWS) / (0.02 - 1e-2 / ROWS)) / np.log(10)


def made(error: Callable[[np.ndarray], np.ndarray], seed: int = 1, noise: float = 0.005, pause: int = 0) -> Curve:
    """A record whose device stands deeper on the way back than it says, by an ``error`` of the travel; the contact
    grows meanwhile, where it waits for a ``pause`` of so many rows."""
    top = float(equilibrium(E_STAR, R, W_IN, K, 4 * FORCE)[0][-1])
    way, rng = np.linspace(-3e-6, top, ROWS), np.random.default_rng(seed)
    moved = error((top - way) / np.ptp(way)) * np.ptp(way)
    deepest = top + (moved[-1] if pause else 0.0)
    out = back_at(way + moved, E_STAR, R, (W_IN, W_OUT), K, 6 * FORCE, deepest)
    into = load_at(way, E_STAR, R, W_IN, K, 6 * FORCE)
    P = np.concatenate([into + 0.05 * FORCE, np.full(pause, into[-1]), out[::-1] - 0.05 * FORCE])
    z = np.concatenate([way, np.full(pause, top), way[::-1]])
    P += FORCE * (1 + 0.1 * z / 1e-6 + noise * rng.normal(size=z.size))
    return Curve("made", delta=z - P / K, P=P, t=np.arange(z.size) / ROWS, stiffness=K)


@pytest.mark.first(2)
@pytest.mark.parametrize(("name", "error"), [("hysteresis", bowed), ("creep", crept)])
@pytest.mark.parametrize("amount", [-0.003, 0.0])
def test_an_error_of_positions_is_fitted_where_it_is_asked_for(name: str, error: Callable, amount: float) -> None:
    """1 % of the travel moves E* by 6 to 8 %, a hundred of its standard errors."""
    curve = made(error(amount))
    found, plain = (fit(BODY, curve, usual(free=free)) for free in ([name], []))
    for key, true in {**TRUE, name: amount}.items():
        item = found.estimate(key)
        assert abs(item.value - true) < 4 * item.error
    assert found.estimate(name).error < 0.1 * max(abs(amount), 0.002)
    assert not found.flags
    if amount:
        item = plain.estimate("E_star")
        assert abs(item.value - E_STAR) > 10 * (item.error or 0.0) or plain.flags
    known = fit(BODY, curve, usual(fix=[(name, str(amount))]))
    assert not known.estimate(name).free
    item = known.estimate("E_star")
    assert abs(item.value - E_STAR) < 4 * item.error
    assert item.error < found.estimate("E_star").error


def test_a_device_creeps_while_it_waits() -> None:
    wait = 500
    last = (2 * ROWS + wait - 1) / 100 / ROWS

    def error(share: np.ndarray) -> np.ndarray:
        return 0.01 * np.log10(1 + (share * (1 - 1 / ROWS) + (wait + 1) / ROWS) / last)

    found = fit(BODY, made(error, pause=wait), usual(free=["creep"]))
    for key, true in {**TRUE, "creep": 0.01}.items():
        item = found.estimate(key)
        assert abs(item.value - true) < 4 * item.error
    assert not found.flags


def test_what_hysteresis_and_creep_need() -> None:
    curve = made(bowed(0.01))
    one, other = (fit(BODY, each, usual(free=["hysteresis"])) for each in (curve, replace(curve, t=None)))
    assert other.value("hysteresis") == pytest.approx(one.value("hysteresis"))
    curve = made(bowed(0.0))
    with pytest.raises(InputError, match=r"^made: creep needs a column of time, there is none: leave creep out$"):
        fit(BODY, replace(curve, t=None), usual(free=["creep"]))
    with pytest.raises(InputError, match=r"^made: hysteresis is fitted to whole force curves only, without compliance"):
        fit(BODY, curve, usual(free=["hysteresis"], branch="compressive"))


def test_records_of_one_device_share_it() -> None:
    curves = [made(bowed(0.01), seed) for seed in range(3)]
    settings = usual(free=["hysteresis"])
    together = joint_fit([BODY] * 3, curves, settings, ("modulus", "hysteresis"))
    alone = fit(BODY, curves[0], settings).estimate("hysteresis")
    item = together.estimate("hysteresis")
    assert abs(item.value - 0.01) < 4 * item.error
    assert item.error == pytest.approx(alone.error / math.sqrt(3), rel=0.3)
    assert together.chance > 1e-3
    own = joint_fit([BODY] * 3, curves, settings, ("modulus",))
    assert [one.value("hysteresis") for one in own.fits] == pytest.approx([0.01] * 3, rel=0.1)


@pytest.mark.parametrize(("name", "value"), [("hysteresis", "1"), ("creep", "-1e9")])
def test_more_than_the_travel_is_refused(name: str, value: str) -> None:
    with pytest.raises(InputError, match=f"^fit: {name} is a fraction of the travel, must be > -1 and < 1, got"):
        usual(fix=[(name, value)])
