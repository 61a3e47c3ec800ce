"""Calibration: the sensitivity from a rigid specimen, and errors of constants that headers name."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from force_curves import Instrument, record
from raw_records import export

from jkrcli.base.errors import InputError
from jkrcli.measured.functions import look
from jkrcli.measured.instruments import constant_errors, constants
from jkrcli.measured.rigid import Sensitivity, mean

S, K = 45.2e-9, 0.3
SPECIMEN = ("--radius", "5 um", "--nu", "0.5", "--shape", "paraboloid")


def glass(path: Path, seed: int, drag: float = 0.0, bend: float = 0.0) -> Path:
    """Volts over the position of the piezo on glass; relative: ``drag`` between approach and retraction, ``bend`` by
    which the slope grows along the contact."""
    rng = np.random.default_rng(seed)
    z = np.linspace(-500e-9, 150e-9, 600)
    bent = np.concatenate([np.maximum(z, 0) * (1 + drag), (np.where(z > -10e-9, z, 0) * (1 - drag))[::-1]])
    bent *= 1 + bend * bent / (2 * z[-1])
    volts = bent / S + 0.002 * rng.normal(size=bent.size) + 0.3
    rows = "".join(f"{x * 1e9:.4f},{v:.6f}\n" for x, v in zip(np.concatenate([z, z[::-1]]), volts, strict=True))
    path.write_text(f"# spring constant: {K} N/m\npiezo (nm),deflection (V)\n{rows}")
    return path


def gel(path: Path, head: str) -> Path:
    return export(path, record(2e5, 5e-6, 2e-4, 1e-3, Instrument(K, 200, 1.5e-6, 40e-9, 1e-10), 1), head)


def test_the_slope_on_glass_is_the_sensitivity_whatever_was_assumed(tmp_path: Path) -> None:
    path = glass(tmp_path / "glass.csv", 1)
    for known in ({}, {"sensitivity": "40 nm/V"}, {"sensitivity": 60e-9, "stiffness": 1.0}):
        found = look(path, rigid=True, **known).rigid
        assert found.value == pytest.approx(S, rel=2e-3)
        assert abs(found.value / S - 1) < 4 * found.error / found.factor
        assert found.straight


def test_drag_is_part_of_the_error_and_directions_that_differ_are_said(tmp_path: Path) -> None:
    found = look(glass(tmp_path / "glass.csv", 1, 0.01), rigid=True).rigid
    assert found.error / found.factor == pytest.approx(0.01, rel=0.1)
    assert look(glass(tmp_path / "glass.csv", 1, 0.03), rigid=True).rigid.straight is False
    assert look(glass(tmp_path / "glass.csv", 1, bend=0.2), rigid=True).rigid.straight is False


def test_files_on_glass_tell_one_sensitivity_and_a_gel_is_no_glass(jkr: Callable, tmp_path: Path) -> None:
    (tmp_path / "glass").mkdir()
    for seed in range(4):
        glass(tmp_path / f"glass/{seed}.csv", seed)
    done = jkr("look", "glass", "--rigid", "--no-plots")
    assert done.out.startswith('rigid specimen: --sensitivity "45.')
    told = jkr("look", "glass", "--rigid", "--no-plots", "--json").told["files"][0]["rigid"]
    assert told["value"] == pytest.approx(S, rel=1e-3)
    done = jkr("look", gel(tmp_path / "gel.csv", f"# springConstant: {K}"), "--rigid", "--no-plots")
    assert "the contact is curved: the specimen is not rigid" in done.out
    assert "--factor P=" in done.out  # of loads, not of volts


def test_files_by_different_assumed_sensitivities_have_one_mean_and_its_scatter() -> None:
    """Whichever is the first: the mean is of sensitivities, not of the factors to what each file assumed."""
    found = [Sensitivity(factor, 0.001 * factor, factor * assumed, True)
             for factor, assumed in ((1.1, 40e-9), (0.75, 60e-9), (46e-9, 1.0))]  # fmt: skip
    for order in (found, found[::-1]):
        one = mean(order)
        assert one.value == pytest.approx(45e-9)
        assert one.error / one.factor == pytest.approx(1 / 45)
    with pytest.raises(InputError, match="3 of 4 force curves hold volts"):
        mean([*found, Sensitivity(1.0, 0.01, None, True)])


@pytest.mark.parametrize(
    "head",
    ["# springConstant: 0.3 ± 0.03 N/m", "# k: 0.30 +- 0.03 N/m", "# k: 0.30 +/- 10 % N/m",
     "# spring constant: 0.3 N/m\n# spring constant error: 10 %",
     "# spring constant: 0.3 N/m\n# Spring constant uncertainty: 30 mN/m"],
)  # fmt: skip
def test_an_error_in_the_header_is_read(head: str) -> None:
    lines = head.splitlines()
    assert constants(lines) == {"stiffness": pytest.approx(K)}
    assert constant_errors(lines) == {"stiffness": pytest.approx(0.1)}


def test_an_error_in_the_header_is_a_part_of_the_calibration(jkr: Callable, tmp_path: Path) -> None:
    path = gel(tmp_path / "gel.csv", "# springConstant: 0.3 ± 0.03 N/m")
    for more, share in (((), 0.196), (("--uncertain", "stiffness=2%"), 0.0392)):  # 1.96 times 10 %: E* goes with k
        told = jkr("fit", path, *SPECIMEN, "--no-plots", "--json", *more).told["curves"][0]["estimates"]["E_star"]
        assert told["calibration"] == pytest.approx(share * told["value"], rel=0.02)
