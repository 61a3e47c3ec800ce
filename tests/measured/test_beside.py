"""Segments and curves whose columns stand beside each other in one table."""

from pathlib import Path

import numpy as np
import pytest

from jkrcli.base.errors import InputError
from jkrcli.measured import files as measured
from jkrcli.measured.curve import Reading

Z = np.array([0.0, 1.0, 2.0, 3.0, 3.0, 2.0, 1.0, 0.5]) * 1e-3  # m, toward the specimen and back
LOAD = np.array([0.0, 0.5, 2.0, 9.0, 8.0, 1.0, -3.0, 0.5])
SIDES = slice(0, 4), slice(4, 8)


def sheet(head: str, *columns: np.ndarray) -> str:
    rows = [";".join(f"{value:.6f}" for value in row).replace(".", ",") for row in zip(*columns, strict=True)]
    return "\n".join([head, *rows]) + "\n"


def pairs() -> list[np.ndarray]:
    return [values for side in SIDES for values in (Z[side] * 1e3, LOAD[side])]


def read(tmp_path: Path, text: str, reading: Reading | None = None) -> list[measured.Curve]:
    path = tmp_path / "m.csv"
    path.write_text(text, encoding="utf-8")
    return measured.read(path, reading)


HEADS = {
    "German": "Weg hin (mm);Kraft hin (N);Weg zurück (mm);Kraft zurück (N)",
    "a line of units": "Weg hin;Kraft hin;Weg zurück;Kraft zurück\nmm;N;mm;N",
    "French": "Déplacement aller [mm];Force aller [N];Déplacement retour [mm];Force retour [N]",
    "loading": "Loading Depth in mm;Loading Load in N;Unloading Depth in mm;Unloading Load in N",
    "a line above": "Approach;;Retract;\nDepth (mm);Load (N);Depth (mm);Load (N)",
}


@pytest.mark.parametrize("name", HEADS)
def test_directions_beside_each_other_are_two_segments_of_one_record(tmp_path: Path, name: str) -> None:
    (curve,) = read(tmp_path, sheet(HEADS[name], *pairs()))
    assert curve.segment.tolist() == ["approach"] * 4 + ["retract"] * 4
    np.testing.assert_allclose(curve.delta, Z, rtol=1e-12)
    np.testing.assert_allclose(curve.P, LOAD, rtol=1e-12)
    assert "segments of one force curve beside each other, put one under the other: approach, retract" in curve.flags


def test_the_order_of_the_rows_of_a_retraction(tmp_path: Path) -> None:
    z, there, back = Z[:4] * 1e3, LOAD[:4], LOAD[4:]
    (curve,) = read(tmp_path, sheet("Weg (mm);Kraft hin (N);Kraft zurück (N)", z, there, back))
    np.testing.assert_allclose(curve.delta, np.append(z, z[::-1]) / 1e3, rtol=1e-12)
    np.testing.assert_allclose(curve.P, np.append(there, back[::-1]), rtol=1e-12)
    assert curve.flags[2] == "the rows of the retraction turned: they stand in the order of the position"
    t = np.arange(4.0)
    head = "Zeit hin (s);Weg hin (mm);Kraft hin (N);Zeit zurück (s);Weg zurück (mm);Kraft zurück (N)"
    (curve,) = read(tmp_path, sheet(head, t, Z[:4] * 1e3, LOAD[:4], t + 4, Z[:4] * 1e3, LOAD[:4]))
    np.testing.assert_allclose(curve.P, np.tile(LOAD[:4], 2), rtol=1e-12)
    np.testing.assert_allclose(curve.t, np.arange(8.0), rtol=1e-12)


CURVES = {
    "numbers": ("d1 (mm);F1 (N);d2 (mm);F2 (N)", ["1", "2"]),
    "a line above": ("gel A;;gel B;\nWeg (mm);Kraft (N);Weg (mm);Kraft (N)", ["gel A", "gel B"]),
    "the same names": ("Weg (mm);Kraft (N);Weg (mm);Kraft (N)", ["1", "2"]),
    "a data frame's names": ("Weg (mm);Kraft (N);Weg (mm).1;Kraft (N).1", ["1", "2"]),
}


@pytest.mark.parametrize("name", CURVES)
def test_numbered_and_repeated_columns_are_curves(tmp_path: Path, name: str) -> None:
    head, names = CURVES[name]
    curves = read(tmp_path, sheet(head, Z * 1e3, LOAD, Z * 2e3, LOAD * 3))
    assert [curve.name for curve in curves] == names
    np.testing.assert_allclose(curves[1].delta, 2 * Z, rtol=1e-12)
    np.testing.assert_allclose(curves[1].P, 3 * LOAD, rtol=1e-12)
    assert f"curves beside each other, put one under the other: {', '.join(names)}" in curves[0].flags


def test_curves_of_two_directions_each(tmp_path: Path) -> None:
    """The second pair of directions used to be dropped without a word."""
    head = ";".join([HEADS["German"]] * 2)
    curves = read(tmp_path, sheet(head, *pairs(), *(2 * column for column in pairs())))
    assert [curve.name for curve in curves] == ["1", "2"]
    for i, curve in enumerate(curves):
        np.testing.assert_allclose(curve.P, LOAD * (i + 1), rtol=1e-12)
        assert list(curve.segments()) == ["approach", "retract"]


def test_half_a_retraction_is_questioned_and_the_remedy_works(tmp_path: Path) -> None:
    text = sheet("Weg hin (mm);Kraft hin (N);Weg zurück (mm)", *pairs()[:3])
    with pytest.raises(
        InputError, match=r'only the approach has a column "Kraft \[N\]": --column delta=1 --column P=2'
    ):
        read(tmp_path, text)
    (curve,) = read(tmp_path, text, Reading(columns={"delta": "1", "P": "2"}))
    np.testing.assert_allclose(curve.P, LOAD[:4], rtol=1e-12)
    assert curve.segment is None
    text = sheet("Weg hin (mm);Kraft hin (N);Weg zurück (mm);Kraft zurück (N);Zeit zurück (s)", *pairs(), Z[:4])
    with pytest.raises(InputError, match=r'differ, only the retract has a column "Zeit \[s\]": --column delta=1 --col'):
        read(tmp_path, text)


@pytest.mark.parametrize("head", ["t1 (s);F1 (N);t2 (s);F2 (N)", "Weg (mm);F1 (N);F2 (N);x"])
def test_what_makes_no_curves_is_questioned(tmp_path: Path, head: str) -> None:
    with pytest.raises(InputError, match=r"--column P=NAME \(columns: 1 "):
        read(tmp_path, sheet(head, *pairs()))
