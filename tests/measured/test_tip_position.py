"""Records whose displacement is that of the tip, z - P/k, with the noise of the load: k and the contact are found."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from force_curves import Instrument, equilibrium, record
from raw_records import BODY, R, body, usual

from jkrcli.base.errors import JkrError
from jkrcli.measured.curve import Curve, Reading
from jkrcli.measured.files import from_columns
from jkrcli.measured.files import read as read_file
from jkrcli.measured.procedure import fit
from jkrcli.measured.result import Fit
from jkrcli.measured.segmentation import SUBTRACTED_TWICE

E_STAR, W = 1e5, 2e-4
S = 2 * E_STAR * 1e-6  # of the contact, about [N/m]


def made(k: float, noise: float = 2e-3, rows: int = 2000) -> dict[str, np.ndarray]:
    """Columns z [m] and P [N] of a record by a spring ``k`` [N/m] with ``noise`` in units of the largest load."""
    largest = 4 * E_STAR * (1e-6) ** 3 / (3 * R)
    span = float(np.ptp(equilibrium(E_STAR, R, W, k, largest)[0]))
    device = Instrument(k, rows, far=2 * span, largest=largest, noise=noise * largest, offset=largest)
    return record(E_STAR, R, W / 2, W, device, 1)


def read(columns: dict[str, np.ndarray], delta: np.ndarray, stiffness: float | None = None) -> Curve:
    return from_columns({"delta_m": delta, "P_N": columns["P"]}, Reading(stiffness=stiffness))


@pytest.mark.parametrize(("ratio", "stiffness"), [(0.05, None), (0.5, np.inf), (5.0, None)])
def test_the_noise_tells_the_stiffness_and_the_fit_holds_the_truth(ratio: float, stiffness: float | None) -> None:
    """With the spring half and a twentieth as stiff as the contact E* was 0.5 and 98 % off, or nothing was fitted."""
    columns = made(ratio * S)
    curve = read(columns, columns["z"] - columns["P"] / (ratio * S), stiffness)
    assert curve.stiffness == pytest.approx(ratio * S, rel=1e-3)  # measured: 1e-4, by the turn
    found = fit(body(E_STAR, 2e-6), curve, usual())
    assert not found.flags
    for name, true in (("E_star", E_STAR), ("w", W)):
        item = found.estimate(name)
        assert abs(item.value - true) < 3 * item.error
        assert item.error < 0.03 * true


def test_whether_a_stiffness_is_told() -> None:
    k, rng = 0.3 * S, np.random.default_rng(2)
    columns = made(k)
    scatter = 2e-3 * 4 * E_STAR * (1e-6) ** 3 / (3 * R) / k
    for size, told in ((0.5, True), (2.0, False)):
        delta = columns["z"] - columns["P"] / k + size * scatter * rng.normal(size=columns["z"].size)
        found = read(columns, delta).stiffness
        assert (found is not None) == told
        assert found is None or found == pytest.approx(k, rel=0.05)  # standard error 0.01
    columns = made(0.3 * S)
    assert read(columns, columns["z"]).stiffness is None
    exact = made(0.3 * S, noise=0.0)
    _, delta, P = equilibrium(E_STAR, R, W, 0.3 * S, 1e-7)
    assert read({"P": P[::20]}, delta[::20]).stiffness is None
    assert read(exact, exact["z"]).stiffness is None
    columns = made(0.5 * S)
    assert SUBTRACTED_TWICE in read(columns, columns["z"] - columns["P"] / (0.5 * S), 0.5 * S).flags
    assert SUBTRACTED_TWICE not in read(columns, columns["z"], 0.5 * S).flags


# ---------------------------------------------------------------------- remedies of misread curves
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
    made = record(20e3, R, 2.5e-4, 2.5e-4, DEVICE, 5)
    lines = [f"{by[0] * z * 1e6:.7f},{by[1] * P * 1e9:.6f}" for z, P in zip(made["z"], made["P"], strict=True)]
    (file := tmp_path / "curve.csv").write_text("\n".join([head, *lines]) + "\n")

    def fitted(**reading: Any) -> Fit:
        (curve,) = read_file(file, Reading(stiffness=DEVICE.k, **reading))
        return fit(BODY, curve, usual())

    try:
        found = fitted()
        words = " ".join([*found.flags, *found.warnings])
    except JkrError as error:
        words = " ".join(getattr(error, "lines", [str(error)]))
    assert remedy in words
    assert fitted(**told).estimate("E_star").value == pytest.approx(20e3, rel=0.05)
