"""Records by tips of two radii on one specimen, raw ones and tables, made by formulae of their own: what they share."""

import json
import math
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import described_body
import numpy as np
import pytest
from conftest import write_table
from fit_data import adhesive
from force_curves import Instrument, record
from raw_records import read

import jkrcli as python
from jkrcli.base.errors import InputError
from jkrcli.measured.curve import Curve
from jkrcli.measured.files import read as read_file
from jkrcli.measured.forward_model import FittedBody, body_of
from jkrcli.measured.joint import JointFit, joint_fit, shared_of, with_radii
from jkrcli.measured.procedure import fit, further
from jkrcli.measured.result import Fit
from jkrcli.measured.settings import settings_of

E_STAR, W, RADII, K = 2e5, 1e-3, (2e-6, 10e-6), 0.3
CASE = described_body.CASE.format(shape="paraboloid")


@pytest.fixture(scope="module", name="body")
def _body() -> FittedBody:
    return body_of(python.parse_case(CASE))


def raw(R: float, seed: int, E_star: float = E_STAR) -> Curve:
    """A force curve with both directions and a base line."""
    force = 1.5 * math.pi * W * R
    device = Instrument(K, 300, far=2e-6, largest=3 * force, noise=0.02 * force, offset=1e-8)
    made = record(E_star, R, 0.2 * W, W, device, seed)
    return replace(read(made, K, "segment"), name=f"{R * 1e6:g}um")


def table(R: float, seed: int) -> Curve:
    """A retraction down to pull-off under load, 1 % noise in both columns, the zero at 100 nm."""
    rng = np.random.default_rng(seed)
    a = np.linspace(1.0, 3.0, 60) * (9 * math.pi * W * R**2 / (8 * E_STAR)) ** (1 / 3)
    delta, P = (c + 0.01 * np.ptp(c) * rng.normal(size=60) for c in adhesive(a, E_STAR, W, R))
    return Curve(f"table of {R * 1e6:g}um", delta=delta + 1e-7, P=P)


def together(body: FittedBody, *curves: Curve, **options: object) -> JointFit:
    settings = settings_of(body, **options)
    return joint_fit(with_radii(body, RADII, 2), curves, settings, shared_of(["E_star", "w"], [], settings))


def off(found: JointFit) -> dict[str, float]:
    """Distances from the truth in standard errors."""
    return {name: (found.estimate(name).value - true) / (found.estimate(name).error or 0)
            for name, true in (("E_star", E_STAR), ("w", W))}  # fmt: skip


@pytest.mark.first(1)
@pytest.mark.parametrize("kinds", [(raw, raw), (raw, table), (table, table)])
def test_two_radii_recover_what_they_share(body: FittedBody, kinds: tuple[Callable[..., Curve], ...]) -> None:
    curves = [make(R, seed) for seed, (make, R) in enumerate(zip(kinds, RADII, strict=True))]
    found = together(body, *curves)
    assert max(map(abs, off(found).values())) < 3.5
    assert found.chance > 1e-3
    assert not any("do not share" in line for line in found.warnings)
    for one, own, curve in zip(found.fits, with_radii(body, RADII, 2), curves, strict=True):
        alone = fit(own, curve, settings_of(own))
        assert found.estimate("E_star").error < 1.02 * (alone.estimate("E_star").error or 0)
        assert one.value("w") == found.estimate("w").value
        zero = 1e-7 if curve.stiffness is None else -1e-8 / K
        assert abs(one.value("delta0") - zero) < 4 * (one.estimate("delta0").error or 0)


@pytest.mark.slow
def test_profiles_of_what_is_shared_are_near_its_covariance(body: FittedBody) -> None:
    """They lean by a fifth of the error of w, as searches with w held there do."""
    curves = [table(R, seed) for seed, R in enumerate(RADII)]
    plain, profiled = (together(body, *curves, confidence=how) for how in ("covariance", "profile"))
    for name in ("E_star", "w"):
        one, other = plain.estimate(name), profiled.estimate(name)
        assert (other.low, other.high) == pytest.approx((one.low, one.high), abs=0.3 * one.error)  # 0.19 measured
        assert other.low != one.low


def test_records_of_two_specimens_do_not_share(body: FittedBody) -> None:
    found = together(body, raw(RADII[0], 0), raw(RADII[1], 1, 1.2 * E_STAR))
    assert found.chance < 1e-6
    assert found.flags[0] == "force curves do not share it"
    assert "they do not share E* and w" in found.warnings[0] or "they do not share w and E*" in found.warnings[0]
    assert [round(one["E_star"] / E_STAR, 1) for one in found.alone] == [1.0, 1.2]


def written(curve: Curve, path: str) -> str:
    return str(write_table(path, "delta (um),P (nN)", curve.device * 1e6, curve.P * 1e9))


def test_the_command_and_python_say_the_same(jkr: Callable) -> None:
    Path("gel.toml").write_text(CASE)
    files = [written(table(R, seed), f"{seed}.csv") for seed, R in enumerate(RADII)]
    radii = ("--tip-radius", "2 um", "--tip-radius", "10 um")
    told = jkr("fit", "gel.toml", *files, "--shared", "E_star,w", "--own", "delta0", *radii, "--json").told
    found = python.fit("gel.toml", files, shared=["E_star", "w"], own=["delta0"], tip_radii=["2 um", "10 um"])
    for item in found.shared:
        assert told["shared"][item.name]["value"] == item.value
    assert {path.suffix for path in Path().glob("gel-fit.*")} == {".csv", ".json", ".png", ".svg"}
    assert len(Path("gel-fit.csv").read_text().splitlines()) == 3


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("--shared", "w0"), "unknown parameter"),
        (("--shared", "w", "--own", "w"), "w is both in --shared and in --own"),
        (("--shared", "w", "--own", "delta0"), "modulus is free too"),
        (("--shared", "w", "--fix", "w=0"), "--shared w: is not free"),
        (("--shared", "w", "--confidence", "bootstrap"), "--shared does not take --confidence bootstrap"),
        (("--shared", "w", "--loss", "huber"), "--shared does not take --loss huber"),
        (("--shared", "w", "--law", "power"), "--law does not take --shared"),
        (("--shared", "w", "--tip-radius", "1 um", "--tip-radius", "2 um", "--tip-radius", "3 um"), "got 3"),
        (("--own", "w"), "--own: applies only with --shared"),
    ],
)  # fmt: skip
def test_what_cannot_be_shared_is_one_line(jkr: Callable, words: tuple[str, ...], said: str) -> None:
    Path("gel.toml").write_text(CASE)
    files = [written(table(RADII[1], seed), f"{seed}.csv") for seed in range(2)]
    jkr("fit", "gel.toml", *files, *words).refused(said)
    assert not list(Path().glob("gel-fit*"))


# ---------------------------------------------------------------------- which further measurement
def pressed(R: float, seed: int) -> Curve:
    device = Instrument(K, 400, far=2e-6, largest=60e-9, noise=0.4e-9, offset=1e-8)
    return replace(read(record(E_STAR, R, 0.2 * W, W, device, seed), K, "segment"), name=f"{R}")


def test_what_is_said_of_another_tip_comes_true(body: FittedBody) -> None:
    """The errors of both records together: within a third, and in the order that was said."""
    R = 20e-6
    one, other = with_radii(body, [5e-6, R], 2)
    curve, settings = pressed(5e-6, 1), settings_of(body)
    told = {item.words: item for item in further(one, fit(one, curve, settings))}
    words = f"tip radius {R * 1e6:g} um"
    both = joint_fit([one, other], [curve, pressed(R, 2)], settings, ["modulus", "w"])
    for name in ("E_star", "w"):
        item = both.estimate(name)
        said = getattr(told[words], name)
        assert (item.error or 0) / item.value == pytest.approx(said, rel=0.36)
        assert said < getattr(told["now"], name)
    assert told[words].w < 0.5 * told["the same again"].w
    assert told["the same again"].E_star == pytest.approx(told["now"].E_star / math.sqrt(2))


def test_which_further_measurement_is_told(body: FittedBody) -> None:
    found = fit(body, pressed(5e-6, 1), settings_of(body, fix=[("w", "1 mJ/m^2")]))
    with pytest.raises(InputError, match="plan: needs E\\* and w free"):
        python.plan(python.parse_case(CASE), found)
    layer = 'specimen.layers = [{ name = "film", thickness = "5 um", E = "100 kPa", nu = 0.5 }]\n'
    film = body_of(python.parse_case(layer + CASE))
    a, s, rng = np.linspace(0.35e-6, 1.2e-6, 60), 2.0, np.random.default_rng(1)
    D, T, H, V = film.family.at(np.log(a))[0]
    delta, P = D - math.sqrt(W / s) * T, s * H - math.sqrt(W * s) * V
    delta, P = (column + 0.005 * np.ptp(column) * rng.normal(size=a.size) for column in (delta, P))
    told = further(film, fit(film, Curve("film", delta=delta, P=P), settings_of(film, bound=[("range", "..1 nm")])))
    assert sum(item.words.startswith("thickness") for item in told) == 2
    assert all(0 < item.E_star <= told[0].E_star and 0 < item.w <= told[0].w for item in told)


# ---------------------------------------------------------------------- the shipped raw record by every way
RAW = Path(__file__).parents[2] / "cases" / "measured" / "raw-force-curve.txt"
TRUTH = {"E_star": 200e3, "w": 1e-3, "w_approach": 0.2e-3}
SPHERE = described_body.CASE.format(shape="sphere")


@pytest.fixture(scope="module", name="tip")
def _tip() -> FittedBody:
    return body_of(python.parse_case(SPHERE))


@pytest.fixture(scope="module", name="record")
def _record() -> Curve:
    return read_file(RAW)[0]


Widths = tuple[float, float, float]


def holds(found: Fit, narrow: Widths) -> None:
    """Each interval holds the truth, and is narrower than so much of it: 1.1 to 1.4 times what it had."""
    for (name, value), width in zip(TRUTH.items(), narrow, strict=True):
        item = found.estimate(name)
        assert item.low <= value <= item.high, name
        assert item.high - item.low < width * value, name


@pytest.mark.parametrize("options", [{"confidence": "profile"}, {"confidence": "bootstrap", "samples": 60}])
def test_every_confidence(tip: FittedBody, record: Curve, options: dict[str, object]) -> None:
    """The model is all but linear within the noise: three ways to one interval."""
    found, plain = (fit(tip, record, settings_of(tip, **words)) for words in (options, {}))
    holds(found, (0.008, 0.0065, 0.06))
    for name in TRUTH:
        wide, usual = ((item.high or 0) - (item.low or 0) for item in (found.estimate(name), plain.estimate(name)))
        assert wide == pytest.approx(usual, rel=0.02 if options.get("confidence") == "profile" else 0.35)
    assert (found.samples is None) == (options.get("confidence") != "bootstrap")


@pytest.mark.slow
@pytest.mark.parametrize(
    ("options", "narrow"),
    [
        ({"free": ["E:base"]}, (0.0065, 0.055, 0.28)),
        ({"free": ["range"]}, (0.0155, 0.1, 0.45)),
        ({"free": ["stress"]}, (0.036, 0.22, 0.5)),
        ({"branch": "compressive"}, (0.036, 0.1, 0.43)),
        ({"free": ["E:base"], "confidence": "profile"}, (0.0065, 0.055, 0.28)),
    ],
)
def test_every_unknown(tip: FittedBody, record: Curve, options: dict[str, object], narrow: Widths) -> None:
    holds(fit(tip, record, settings_of(tip, **options)), narrow)


@pytest.mark.first(1)
@pytest.mark.parametrize("contact", ["estimate", "as-is"])
def test_python_and_the_command_agree_to_the_last_digit(jkr: Callable, contact: str) -> None:
    Path("gel.toml").write_text(SPHERE)
    done = jkr("fit", "gel.toml", str(RAW), "--contact", contact, "--json", "--no-plots")
    for words in ({"contact": contact}, {"reading": python.Reading(contact=contact)}):
        if contact == "as-is":  # as it stands it is no curve of this tip
            with pytest.raises(python.InputError) as error:
                python.fit("gel.toml", RAW, **words)
            assert str(error.value) in done.err
            continue
        (told,) = json.loads(done.out)["curves"]
        for item in python.fit("gel.toml", RAW, **words).estimates:
            assert told["estimates"][item.name]["value"] == item.value
