"""Which further measurement would narrow E* and w, against the errors of the records that it proposes."""

import math
from dataclasses import replace

import described_body
import numpy as np
import pytest
from force_curves import Instrument, record
from raw_records import read

import jkrcli as python
from jkrcli.base.errors import InputError
from jkrcli.measured.curve import Curve
from jkrcli.measured.forward_model import FittedBody, body_of
from jkrcli.measured.joint import joint_fit, with_radii
from jkrcli.measured.procedure import fit, further
from jkrcli.measured.settings import settings_of

E_STAR, W, K, LOAD = 2e5, 1e-3, 0.3, 60e-9
CASE = described_body.CASE.format(shape="paraboloid")


@pytest.fixture(scope="module", name="body")
def _body() -> FittedBody:
    return body_of(python.parse_case(CASE))


def made(R: float, seed: int, largest: float = LOAD, w: float = W) -> Curve:
    device = Instrument(K, 400, far=2e-6, largest=largest, noise=0.4e-9, offset=1e-8)
    return replace(read(record(E_STAR, R, 0.2 * w, w, device, seed), K, "segment"), name=f"{R}")


def test_what_is_said_of_another_tip_comes_true(body: FittedBody) -> None:
    """The errors of both records together: within a third, and in the order that was said."""
    R = 20e-6
    one, other = with_radii(body, [5e-6, R], 2)
    curve, settings = made(5e-6, 1), settings_of(body)
    told = {item.words: item for item in further(one, fit(one, curve, settings))}
    words = f"tip radius {R * 1e6:g} um"
    both = joint_fit([one, other], [curve, made(R, 2)], settings, ["modulus", "w"])
    for name in ("E_star", "w"):
        item = both.estimate(name)
        said = getattr(told[words], name)
        assert (item.error or 0) / item.value == pytest.approx(said, rel=0.36)
        assert said < getattr(told["now"], name)
    assert told[words].w < 0.5 * told["the same again"].w
    assert told["the same again"].E_star == pytest.approx(told["now"].E_star / math.sqrt(2))


def test_nothing_is_said_where_w_is_not_told(body: FittedBody) -> None:
    found = fit(body, made(5e-6, 1), settings_of(body, fix=[("w", "1 mJ/m^2")]))
    with pytest.raises(InputError, match="plan: needs E\\* and w free"):
        python.plan(python.parse_case(CASE), found)


def test_a_layer_is_asked_for_in_other_thicknesses() -> None:
    layer = '[[specimen.layers]]\nname = "film"\nthickness = "5 um"\nE = "100 kPa"\nnu = 0.5\n[specimen.half_space]'
    film = body_of(python.parse_case(CASE.replace("[specimen.half_space]", layer)))
    a, s, rng = np.linspace(0.35e-6, 1.2e-6, 60), 2.0, np.random.default_rng(1)
    D, T, H, V = film.family.at(np.log(a))[0]
    delta, P = D - math.sqrt(W / s) * T, s * H - math.sqrt(W * s) * V
    delta, P = (column + 0.005 * np.ptp(column) * rng.normal(size=a.size) for column in (delta, P))
    told = further(film, fit(film, Curve("film", delta=delta, P=P), settings_of(film, bound=[("range", "..1 nm")])))
    assert sum(item.words.startswith("thickness") for item in told) == 2
    assert all(0 < item.E_star <= told[0].E_star and 0 < item.w <= told[0].w for item in told)
