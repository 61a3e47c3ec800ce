"""Nothing after a fit costs the fit: each later step is drawn and broken, and the result comes out with its name."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from fit_data import adhesive
from force_curves import Instrument, record
from raw_records import R, body, read

from jkrcli.measured import procedure
from jkrcli.measured.curve import Curve
from jkrcli.measured.least_squares import Intervals
from jkrcli.measured.settings import settings_of

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


BODY = body(1e5)
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
    found = procedure.fit(BODY, curve, settings_of(BODY, **asked))
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
