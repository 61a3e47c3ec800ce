"""Remedies that a misread force curve is refused or warned with, each followed on the record that brought it."""

from pathlib import Path
from typing import Any

import pytest
from force_curves import Instrument, record
from raw_records import BODY, R, usual

from jkrcli.base.errors import JkrError
from jkrcli.measured.curve import Reading
from jkrcli.measured.files import read
from jkrcli.measured.procedure import fit
from jkrcli.measured.result import Fit

E_STAR, W = 20e3, 2.5e-4
DEVICE = Instrument(0.05, 400, far=1e-6, largest=8e-9, noise=1e-11, offset=0.0)


@pytest.mark.parametrize(
    ("head", "by", "remedy", "told"),
    [
        ("piezo (um),force (nN)", (1, -1), "--flip P", {"flip": frozenset({"P"})}),
        ("piezo (um),force (nN)\nnm,nN", (1, 1), "--unit", {"units": {"delta": "um"}}),
        ("piezo,force (nN)", (1, 1), "--unit delta=um", {"units": {"delta": "um"}}),
        ("piezo (um),channel", (1, 1), "--column P=", {"columns": {"P": "2"}, "units": {"P": "nN"}}),
    ],
)
def test_a_remedy_of_a_misread_curve_leads_to_its_fit(
    tmp_path: Path, head: str, by: tuple[int, int], remedy: str, told: dict[str, Any]
) -> None:
    made = record(E_STAR, R, W, W, DEVICE, 5)
    lines = [f"{by[0] * z * 1e6:.7f},{by[1] * P * 1e9:.6f}" for z, P in zip(made["z"], made["P"], strict=True)]
    (file := tmp_path / "curve.csv").write_text("\n".join([head, *lines]) + "\n")

    def fitted(**reading: Any) -> Fit:
        (curve,) = read(file, Reading(stiffness=DEVICE.k, **reading))
        return fit(BODY, curve, usual())

    try:
        found = fitted()
        words = " ".join([*found.flags, *found.warnings])
    except JkrError as error:
        words = " ".join(getattr(error, "lines", [str(error)]))
    assert remedy in words
    assert fitted(**told).estimate("E_star").value == pytest.approx(E_STAR, rel=0.05)
