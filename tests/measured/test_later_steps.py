"""Nothing after a fit costs the fit: each later step is drawn and broken, and the result comes out with its name. What
fits of disturbed records cost: evaluations of the model, the same on every machine."""

import time
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from fit_data import adhesive
from force_curves import Instrument, record
from raw_records import BODY, R, body, read, usual

from jkrcli.base.executors import Pool
from jkrcli.measured import fits, force_curve, procedure
from jkrcli.measured.curve import Curve, Pixel
from jkrcli.measured.forward_model import FittedBody
from jkrcli.measured.least_squares import Intervals
from jkrcli.measured.procedure import Failure, fit
from jkrcli.measured.settings import Settings, settings_of

K, E_STAR, W = 0.5, 2e5, 1e-3
BROKEN = {  # later steps of a raw record: where each stands, its name in words, and settings that ask for it
    "measured.procedure.with_inputs": ("inputs that no error holds", {}),
    "measured.procedure.with_shape": ("the faces of the pyramid", {}),
    "measured.procedure.with_strains": ("large strains", {}),
    "measured.procedure.with_other_profile": ("the other profile of the same radius", {}),
    "measured.record.another_modulus": ("each direction by its own modulus", {}),
    "measured.record.attach_verdict": ("alternative models", {}),
    "measured.alternative_fits.score_tests": ("alternative models", {}),
    "measured.alternative_fits.bounds": ("alternative models", {}),
    "measured.record.warnings_of": ("remarks on the fit", {}),
    "measured.record.sentences": ("remarks on the fit", {}),
    "measured.record.replace_by_best_alternative": ("fits of alternative models", {"model": "auto"}),
    "measured.record.bootstrap": ("intervals by bootstrap", {"confidence": "bootstrap", "samples": 20}),
    "measured.record.changes_by": ("uncertain inputs", {"uncertain": {"stiffness": "5%"}}),
}
BROKEN_ROWS = {  # the same of rows of a table
    "measured.procedure.alternatives_of": ("alternative models", {}),
    "measured.procedure.warnings_of": ("remarks on the fit", {}),
    "measured.procedure.with_strains": ("large strains", {}),
    "measured.procedure.bootstrap": ("intervals by bootstrap", {"confidence": "bootstrap", "samples": 20}),
}
ERRORS = [FloatingPointError("underflow"), RuntimeWarning("invalid"), np.linalg.LinAlgError("singular")]


HELD = body(1e5)
COLUMNS = record(E_STAR, R, W / 2, W, Instrument(K, 250, 4e-7, 8e-8, noise=2e-11, offset=1e-9), 3)
RAW = read(COLUMNS, K)
A = np.linspace(5e-7, 1.4e-6, 40)
ROWS = Curve("rows", a=A, P=adhesive(A, E_STAR, W, R)[1])


def breaks(error: Exception) -> Callable:
    def broken(*_: object, **__: object) -> None:
        raise error

    return broken


@pytest.mark.parametrize(("curve", "where", "what", "asked"), [
    *((RAW, where, *of) for where, of in BROKEN.items()), *((ROWS, where, *of) for where, of in BROKEN_ROWS.items())
])  # fmt: skip
def test_a_step_after_the_fit_that_breaks_is_left_out_and_named(
    curve: Curve, where: str, what: str, asked: dict, monkeypatch: pytest.MonkeyPatch
) -> None:
    error = ERRORS[sum(map(ord, where)) % len(ERRORS)]
    monkeypatch.setattr(f"jkrcli.{where}", breaks(error))
    found = procedure.fit(HELD, curve, settings_of(HELD, **asked))
    assert any(what in line and "left out" in line for line in found.warnings)
    assert not any(str(error) in line for line in found.warnings)
    for name, true in (("E_star", E_STAR), ("w", W)):
        item = found.estimate(name)
        assert item.value == pytest.approx(true, rel=0.02)
        assert item.error is not None


def test_an_infinite_variance_is_not_determined() -> None:
    """Such as that of an amount that the rows do not hold: 0 times it is no number, and was an error of arithmetic."""
    intervals = Intervals(
        least=None, quantities=(), meaning=lambda x: {}, covariance=np.full((2, 2), np.inf), t=2.0, level=0.95
    )  # fmt: skip
    vars(intervals)["rates"] = {"one": np.array([1.0, 0.0]), "other": np.array([0.0, 0.0])}
    assert intervals.errors == {"one": None, "other": None}


@pytest.mark.first(2)
@pytest.mark.parametrize(
    "where", ["measured.figures.fit_figure", "measured.fits.friction_warnings", "report.plots.save"]
)
def test_a_picture_or_remark_that_breaks_costs_no_file(
    where: str, jkr: Callable, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    table = np.column_stack([1e6 * COLUMNS["z"], 1e9 * COLUMNS["P"]])
    np.savetxt("raw.csv", table, "%.9g", ",", header="z (um),P (nN)", comments="")
    monkeypatch.setattr(f"jkrcli.{where}", breaks(ValueError("singular")))
    done = jkr("fit", "raw.csv", "--radius", "5 um", "--nu", "0.5", "--stiffness", "0.5 N/m", "-o", "out").ok
    assert "left out, it cannot be computed here (ValueError)" in done.err.replace("\n    ", " ")
    assert Path("out/raw-fit.csv").exists()
    assert Path("out/raw-fit.json").exists()
    assert "E*" in done.out


# ---------------------------------------------------------------------- what fits of disturbed records cost
@pytest.fixture(name="evaluations")
def _evaluations(monkeypatch: pytest.MonkeyPatch) -> list[int]:
    """Rows at which loads are evaluated at once, of all searches that go on side by side, in order."""
    found, of = list[int](), force_curve.at_rows

    def counted(asked: Sequence[force_curve.AtUnknowns], slopes: bool = True) -> list[force_curve.AtRows | Exception]:
        found.append(sum(model.ends[-1] for model, _, _ in asked))
        return of(asked, slopes)

    monkeypatch.setattr(force_curve, "at_rows", counted)
    return found


def pressed(seed: int) -> Curve:
    """A record of a soft half-space, without dirt."""
    device = Instrument(0.05, 700, far=3e-6, largest=5e-9, noise=2e-11, offset=1e-9, tilt=1e-4)
    return read(record(1e3, R, 0.0, 1e-4, device, seed), 0.05, "segment")


def bent(curve: Curve) -> Curve:
    """The same with interference: a sine of three periods over the way, ten times the noise."""
    return replace(curve, P=curve.P + 2e-10 * np.sin(6 * np.pi * np.arange(len(curve)) / len(curve)))


def relaxed(curve: Curve) -> Curve:
    """The same with loads of the retraction a tenth lower in contact, as of a specimen that relaxes."""
    back = (curve.segment == "retract") & (curve.P > 2e-9)
    return replace(curve, P=np.where(back, 0.9 * curve.P, curve.P))


@pytest.mark.first(1)
@pytest.mark.parametrize(("dirty", "most"), [(bent, 6), (relaxed, 3)])
def test_starts_that_lead_to_one_curve_are_searched_once(dirty: Callable, most: float, evaluations: list[int]) -> None:
    """One after the other, and from all starts anew, these took 15 to 19 and 6 to 8 times as many evaluations as the
    record without."""
    fit(BODY, pressed(1), usual())
    clean = len(evaluations)
    evaluations.clear()
    fit(BODY, dirty(pressed(1)), usual())
    assert len(evaluations) < most * clean


@pytest.mark.slow
def test_the_remark_on_the_other_profile_begins_at_the_fit(evaluations: list[int]) -> None:
    """Fitted from the record on it doubled the evaluations; the curves of a map have no such remark."""
    curve = bent(pressed(2))
    fit(BODY, replace(curve, pixel=Pixel(0, 0)), usual())
    alone = len(evaluations)
    evaluations.clear()
    assert fit(BODY, curve, usual()).tip
    assert len(evaluations) < 1.5 * alone


def test_the_time_of_a_folder_is_forecast_from_its_first_curves(jkr, monkeypatch: pytest.MonkeyPatch) -> None:
    """Disturbed curves took ten times and more of what was told of clean ones."""
    told, spent = list[float](), list[float]()

    def fitted(body: FittedBody, curves: Sequence[Curve], settings: Settings, pool: Pool) -> list[Failure]:
        start = time.process_time()
        while time.process_time() < start + 0.05 * len(curves):
            pass
        spent.append(time.process_time() - start)
        return [Failure(curve, ("none",)) for curve in curves]

    monkeypatch.setattr(fits, "fit_all", fitted)
    monkeypatch.setattr(fits, "begin", lambda what, cost, *_: told.append(cost.seconds))
    monkeypatch.setattr(fits, "FORECAST_FEW", 3)
    for seed in range(9):
        Path(f"record-{seed}.csv").write_text("delta_nm,P_nN\n" + "".join(f"{i},{i**1.5}\n" for i in range(30)))
    options = "--shape", "paraboloid", "--radius", "5 um", "--nu", "0.5", "--workers", "1", "--no-plots"
    jkr("fit", ".", *options, "-o", "found")
    assert len(spent) == 3
    assert told[0] < sum(spent)
    assert sum(spent) / 2 < told[-1] < 2 * sum(spent)


def test_a_forecast_that_was_too_low_is_mended(monkeypatch: pytest.MonkeyPatch, capsys) -> None:
    clock, mends = [0.0], {2: [(50, 35)], 3: [(75, 22)]}
    monkeypatch.setattr(time, "monotonic", lambda: clock[0])
    with fits.mended("fitting", 100, 20.0) as step:
        for lot, seconds in enumerate((5.0, 30.0, 30.0, 30.0)):
            clock[0] += seconds
            for _ in range(25):
                step(False)
            lines = capsys.readouterr().err.splitlines()
            assert [line for line in lines if "done" in line] == (
                [f"jkr: fitting: {done} of 100 done, about {left} s to go" for done, left in mends.get(lot, [])]
            )
