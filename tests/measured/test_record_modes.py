"""The shipped raw record by every way to fit it: E* 200 kPa, w 1 mJ/m^2 on the way out and 0.2 mJ/m^2 on the way in."""

import json
from collections.abc import Callable
from pathlib import Path

import described_body
import pytest

import jkrcli as python
from jkrcli.measured.curve import Curve
from jkrcli.measured.files import read
from jkrcli.measured.forward_model import FittedBody, body_of
from jkrcli.measured.procedure import fit
from jkrcli.measured.result import Fit
from jkrcli.measured.settings import settings_of

RAW = Path(__file__).parents[2] / "cases" / "measured" / "raw-force-curve.txt"
TRUTH = {"E_star": 200e3, "w": 1e-3, "w_approach": 0.2e-3}
CASE = described_body.CASE.format(shape="sphere")


@pytest.fixture(scope="module", name="body")
def _body() -> FittedBody:
    return body_of(python.parse_case(CASE))


@pytest.fixture(scope="module", name="record")
def _record() -> Curve:
    return read(RAW)[0]


Widths = tuple[float, float, float]


def holds(found: Fit, narrow: Widths) -> None:
    """Each interval holds the truth, and is narrower than so much of it: 1.1 to 1.4 times what it had."""
    for (name, value), width in zip(TRUTH.items(), narrow, strict=True):
        item = found.estimate(name)
        assert item.low <= value <= item.high, name
        assert item.high - item.low < width * value, name


@pytest.mark.parametrize("options", [{"confidence": "profile"}, {"confidence": "bootstrap", "samples": 60}])
def test_every_confidence(body: FittedBody, record: Curve, options: dict[str, object]) -> None:
    """The model is all but linear within the noise: three ways to one interval."""
    found, plain = (fit(body, record, settings_of(body, **words)) for words in (options, {}))
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
def test_every_unknown(body: FittedBody, record: Curve, options: dict[str, object], narrow: Widths) -> None:
    holds(fit(body, record, settings_of(body, **options)), narrow)


@pytest.mark.first(1)
@pytest.mark.parametrize("contact", ["estimate", "as-is"])
def test_python_and_the_command_agree_to_the_last_digit(jkr: Callable, contact: str) -> None:
    Path("gel.toml").write_text(CASE)
    done = jkr("fit", "gel.toml", str(RAW), "--contact", contact, "--json", "--no-plots")
    for words in ({"contact": contact}, {"reading": python.Reading(contact=contact)}):
        if contact == "as-is":  # as it stands it is no curve of this body
            with pytest.raises(python.InputError) as error:
                python.fit("gel.toml", RAW, **words)
            assert str(error.value) in done.err
            continue
        (told,) = json.loads(done.out)["curves"]
        for item in python.fit("gel.toml", RAW, **words).estimates:
            assert told["estimates"][item.name]["value"] == item.value
