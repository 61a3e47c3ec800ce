"""A viscoelastic specimen that adheres among the alternatives of a raw record: records of other equations
(``adhesive_curves.py``) with their free rows, read as anyone reads them, without a word on relaxation."""

import pickle
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from adhesive_curves import Made, cycle, sampled, solid

import jkrcli as jkr
from jkrcli.measured.curve import Curve
from jkrcli.measured.forward_model import FittedBody, body_of
from jkrcli.measured.procedure import fit
from jkrcli.measured.report import alternatives_table, verdict_words
from jkrcli.measured.result import Fit
from jkrcli.measured.settings import settings_of
from jkrcli.viscoelastic.relaxing_alternative import RELAXING

R, E_STAR = 5e-6, 100e3
W, STRESS, STIFFNESS, TIME = 0.002, 0.1, 1.0, 1.0  # over R and E*
CORNERS = ((0.0, -0.03), (0.5, 0.02), (1.7, -0.1))


@cache
def made(ratio: float) -> Made:
    found: Made = cycle(W, STRESS, solid(ratio, TIME), CORNERS, STIFFNESS)
    return found


def curve(ratio: float, noise: float = 0.01, time: bool = True) -> Curve:
    """A record with free rows as long as its contact on both sides, an offset, and noise over the pull-off force."""
    whole = made(ratio)
    lasting = whole.lost - whole.begun
    t = whole.begun + lasting * (np.arange(-600, 1200) + 0.5) / 600
    ends, places = np.array(CORNERS).T
    slopes = np.diff(places) / np.diff(ends)
    z = np.interp(t, ends, places) + np.minimum(t - ends[0], 0) * slopes[0] + np.maximum(t - ends[-1], 0) * slopes[-1]
    size = noise * -float(whole.P.min())
    P = sampled(whole, t) + size * (5 + np.random.default_rng(1).standard_normal(t.size))
    delta = (z - P / STIFFNESS) * R
    P, k = P * E_STAR * R**2, STIFFNESS * E_STAR * R
    return Curve("made", t=t - t[0] if time else None, delta=delta, P=P, stiffness=k)


@cache
def body() -> FittedBody:
    specimen = jkr.Specimen((), jkr.HalfSpace(jkr.Elastic(0.75 * E_STAR, 0.5)))
    problem = jkr.Problem(jkr.Paraboloid(R), specimen, jkr.Loading("depth", 0.05 * R))
    return replace(body_of(jkr.solve(problem)), moduli_known=False)


def fitted(one: Curve, **how: object) -> Fit:
    return fit(body(), one, settings_of(body(), **how))  # type: ignore[arg-type]


def test_a_relaxing_record_that_adheres_is_named_first() -> None:
    """By one modulus E* or w is off by more than its statistical error; the cause is named with what it would give."""
    plain = fitted(curve(0.4))
    assert plain.verdict.alternatives.named[0].name == RELAXING
    off = {name: abs(plain.value(name) / true - 1) for name, true in (("E_star", E_STAR), ("w", W * E_STAR * R))}
    assert max(off.values()) > 0.05
    sentence = next(line for line in plain.warnings if line.startswith(RELAXING))
    assert "--relaxation sls --free w" in sentence
    for name, true in (("E_star", E_STAR), ("w", W * E_STAR * R)):
        low, high = plain.estimate(name).whole
        assert low < true < high
    assert RELAXING in "\n".join(alternatives_table(plain))


@pytest.mark.slow
def test_the_model_of_the_answer_is_the_viscoelastic_one() -> None:
    auto = fitted(curve(0.4), model="auto")
    assert auto.verdict.tied[0].name == RELAXING
    assert auto.value("E_star") == pytest.approx(E_STAR, rel=0.03)
    assert auto.value("E:base") == pytest.approx(0.75 * auto.value("E_star"))
    assert auto.value("w") == pytest.approx(W * E_STAR * R, rel=0.03)
    assert auto.value("ratio") == pytest.approx(0.4, abs=0.05)
    assert f"by {RELAXING}" in "\n".join(verdict_words(auto))
    assert pickle.loads(pickle.dumps(auto)).verdict.tied == auto.verdict.tied  # from other processes
    # what it leaves is noise, but where a jump lies between two rows
    size = 0.01 * -float(made(0.4).P.min()) * E_STAR * R**2
    assert float(np.median(np.abs(auto.residuals))) * auto.scales["P"] == pytest.approx(0.6745 * size, rel=0.1)


def test_records_to_which_relaxation_is_no_alternative() -> None:
    auto = fitted(curve(1.0), model="auto")
    assert RELAXING not in {one.name for one in (*auto.verdict.alternatives.scores, *auto.verdict.fitted)}
    plain = fitted(curve(0.4, time=False))
    assert RELAXING not in {one.name for one in plain.verdict.alternatives.scores}
