"""Files as the makers of microscopes, indenters and testing machines write them: the same record comes back."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import vendors
from vendors import FORCE, HEIGHT, ROWS, K

from jkrcli.base.errors import InputError
from jkrcli.data import measured
from jkrcli.data.curve import Curve, Reading

COUNT = vendors.PER_COUNT * vendors.SENSITIVITY  # m of deflection
WAYS = ["approach"] * ROWS + ["retract"] * ROWS


def read_one(path: Path, **how: object) -> Curve:
    (curve,) = measured.read(path, Reading(**how))  # type: ignore[arg-type]
    return curve


def moved(z: np.ndarray) -> np.ndarray:
    return z - z[0]


# ---------------------------------------------------------------------- Nanoscope
@pytest.mark.parametrize("least", [0, 7])
def test_a_nanoscope_curve_comes_back_without_rows_that_were_not_filled(tmp_path: Path, least: int) -> None:
    curve = read_one(vendors.nanoscope(tmp_path / "x.017", least=least))
    assert curve.segment.tolist() == WAYS
    np.testing.assert_allclose(curve.P, FORCE, atol=0.51 * COUNT * K, rtol=0)
    np.testing.assert_allclose(moved(curve.device), moved(-HEIGHT), atol=0.6e-6 * vendors.PER_COUNT * 2, rtol=0)
    assert curve.stiffness == K
    assert curve.flags == ("displacement from the height sensor", "stiffness 0.05 N/m of the file",
                           "sensitivity 60 nm/V of the file")  # fmt: skip
    np.testing.assert_allclose(np.diff(curve.t), 1 / (ROWS + least), rtol=1e-12)  # 200 V at 200 V/s


def test_a_nanoscope_map_in_four_bytes_over_its_ramp(tmp_path: Path) -> None:
    """The ramp of 2 um stands for the height that was not recorded; the sensitivity names no unit, as some versions."""
    curves = measured.read(vendors.nanoscope(tmp_path / "map.spm", 4))
    assert [curve.name for curve in curves] == ["0", "1", "2", "3"]
    assert [(at.column, at.row) for curve in curves if (at := curve.pixel)] == [(0, 0), (1, 0), (0, 1), (1, 1)]
    assert curves[3].pixel is not None
    assert (curves[3].pixel.x, curves[3].pixel.y) == (pytest.approx(5e-7), pytest.approx(5e-7))
    for curve in curves:
        np.testing.assert_allclose(curve.P, FORCE, atol=0.51 * COUNT * K, rtol=0)
        steps = np.arange(ROWS) * 2e-6 / ROWS
        np.testing.assert_allclose(curve.device, np.concatenate([-steps[::-1], -steps]), atol=1e-20)
        assert "counts of four bytes, shifted by one, were read as such" in curve.flags


def test_a_capture_of_peak_force_moves_as_a_sine(tmp_path: Path) -> None:
    curve = read_one(vendors.nanoscope(tmp_path / "x.pfc", capture=True))
    assert curve.device.argmax() == ROWS
    assert np.ptp(curve.device) == pytest.approx(2e-7)
    assert curve.t[-1] == pytest.approx((2 * ROWS - 1) / (2 * ROWS) / 2000)
    assert curve.flags[0] == "displacement from the sine of the drive, 100 nm at 2 kHz"


def test_what_is_told_takes_the_place_of_the_head(tmp_path: Path) -> None:
    curve = read_one(vendors.nanoscope(tmp_path / "x.000"), stiffness=2 * K, sensitivity=1.2e-7, factors={"P": 3.0})
    np.testing.assert_allclose(curve.P, 12 * FORCE, atol=12 * 0.51 * COUNT * K, rtol=0)
    assert "stiffness 0.1 N/m as specified, the file says 0.05 N/m" in curve.flags
    lame = vendors.nanoscope(tmp_path / "y.000", **{"Spring Constant": "0"})
    assert "the file lacks its stiffness: arbitrary units, give --stiffness" in read_one(lame, incomplete=True).flags[1]


WRONG = {
    "no spring constant": ({"Spring Constant": "0"}, {}, "names no stiffness: give --stiffness"),
    "rigid": ({}, {"stiffness": np.inf}, "whose cantilever bends: give its stiffness, not rigid"),
    "columns": ({}, {"columns": {"P": "x"}}, "the columns of a microscope's file and their units are known"),
    "where": ({}, {"where": {"x": "1"}}, "of which --where takes segment or curve, not \"x\""),
    "length": ({"Data length": "319"}, {}, "319 bytes for 1 curves of 2 x 40 rows, 2 or 4 bytes each"),
    "offset": ({"Data offset": "99999"}, {}, "is cut off: holds 6,320 bytes of 100,159: copy it again"),
    "no rows": ({"Samps/line": "none"}, {}, "names no rows of its curves (Samps/line)"),
    "no scale": ({"@4:Z scale": "V [Sens. DeflSens] (0 V/LSB) 1 V"}, {}, "names no scale of its DeflectionError"),
    "no channel": ({"@4:Image Data": 'S [Phase] "Phase"'}, {}, "holds no deflection (channels: Phase)"),
}  # fmt: skip


@pytest.mark.parametrize("mistake", WRONG)
def test_what_is_wrong_with_a_nanoscope_file_is_said_in_one_line(tmp_path: Path, mistake: str) -> None:
    changed, how, words = WRONG[mistake]
    path = vendors.nanoscope(tmp_path / "x.000", **changed)
    with pytest.raises(InputError) as caught:
        measured.read(path, Reading(**how))
    assert len(caught.value.lines) == 1
    assert words in str(caught.value)


# ---------------------------------------------------------------------- exports in text
@pytest.mark.parametrize("maker", vendors.EXPORTS)
def test_the_record_comes_back_from_each_export(tmp_path: Path, maker: str) -> None:
    of_machine = maker in ("instron", "zwick")
    curve = read_one(vendors.export(tmp_path / "x.txt", maker), **({"stiffness": K} if of_machine else {}))
    if curve.segment is not None:
        assert curve.segment.tolist() == WAYS
    np.testing.assert_allclose(curve.P, FORCE, rtol=1e-8, atol=1e-20)
    np.testing.assert_allclose(moved(curve.delta), moved(-HEIGHT - FORCE / K), atol=2e-15)  # of 2 um, nine digits


SPELLED = {
    "English": ("Branch", "Loading", "Unloading"),
    "English, in short": ("segment", "load", "UNLOAD"),
    "German": ("Ast", "Belasten", "Entlasten"),
    "German, of motion": ("Richtung", "hin", "zurück"),
    "French": ("Phase", "charge", "décharge"),
    "French, of motion": ("Branche", "approche", "retrait"),
}


@pytest.mark.parametrize("tongue", SPELLED)
def test_segments_are_spelled_in_three_languages(tmp_path: Path, tongue: str) -> None:
    title, in_, out = SPELLED[tongue]
    rows = [f"{z},{z},{in_ if z < 4 else out}" for z in (1, 2, 3, 4, 5, 6)]
    (tmp_path / "x.csv").write_text("\n".join([f"delta_nm,P_nN,{title}", *rows]), encoding="utf-8")
    curve = read_one(tmp_path / "x.csv")
    assert curve.segment.tolist() == ["approach"] * 3 + ["retract"] * 3
    assert curve.flags == (f'segments from column 3 "{title}": "{in_}" is approach, "{out}" is retract',)


def test_rows_are_selected_by_number_by_segment_and_by_column(tmp_path: Path) -> None:
    text = "step,delta_nm,P_nN,Ast\n" + "".join(
        f"{1 + i // 6},{i},{i},{'Belasten' if i % 6 < 3 else 'Entlasten'}\n" for i in range(12)
    )
    path = tmp_path / "x.csv"
    path.write_text(text)

    def loads(**how: object) -> list[float]:
        return [round(1e9 * P) for P in read_one(path, **how).P]

    assert loads(rows=(2, 4)) == [1, 2, 3]
    assert loads(where={"segment": "retract"}) == loads(where={"segment": "entlasten"}) == [3, 4, 5, 9, 10, 11]
    assert loads(where={"step": "2"}) == [6, 7, 8, 9, 10, 11]
    assert loads(where={"step": "2", "segment": "approach"}, rows=(1, 3)) == [6, 7, 8]
    for how, words in (
        ({"rows": (2, 13)}, "--rows 2..13 must be 3 or more of its 12 rows"),
        ({"where": {"step": "3"}}, 'no row holds "3" in column 1 "step" (it holds 1, 2 ...)'),
        ({"where": {"curve": "y"}}, 'holds no curve "y" (x)'),
        ({"where": {"segment": "hold"}}, 'has no rows of segment "hold" (segments: approach, retract)'),
    ):
        with pytest.raises(InputError) as caught:
            read_one(path, **how)
        assert words in str(caught.value)


def test_waves_of_a_map_know_their_pixel(tmp_path: Path) -> None:
    pytest.importorskip("afmformats")
    curve = read_one(vendors.ibw(tmp_path / "x.ibw", (3, 5)))
    assert curve.pixel is not None
    assert (curve.pixel.column, curve.pixel.row, curve.pixel.x, curve.pixel.y) == (3, 5, 3e-6, 5e-6)
    assert read_one(vendors.ibw(tmp_path / "y.ibw")).pixel is None
