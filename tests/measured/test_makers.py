"""Files as the makers of microscopes, indenters and testing machines write them: the same record comes back."""

import contextlib
import gzip
import re
import struct
import zipfile
from collections.abc import Callable
from pathlib import Path

import h5py
import numpy as np
import pytest
import vendors
from conftest import Outcome, write_table
from vendors import FORCE, HEIGHT, ROWS, K

import jkrcli as jkr_package
from jkrcli.base.errors import InputError
from jkrcli.measured import files as measured
from jkrcli.measured.curve import Curve, Reading
from jkrcli.measured.files import read, usable
from jkrcli.measured.instruments import constants
from jkrcli.measured.segmentation import segment_force_curve
from jkrcli.tables import split_name
from jkrcli.tables.text import read_table

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
    assert (curves[3].pixel.x, curves[3].pixel.y) == (pytest.approx(5e-7), pytest.approx(5e-7))
    for curve in curves:
        np.testing.assert_allclose(curve.P, FORCE, atol=0.51 * COUNT * K, rtol=0)
        steps = np.arange(ROWS) * 2e-6 / ROWS
        np.testing.assert_allclose(curve.device, np.concatenate([-steps[::-1], -steps]), atol=1e-20)
        assert "counts of four bytes, shifted by one, were read as such" in curve.flags


def test_captures_and_constants_of_a_nanoscope_file(tmp_path: Path) -> None:
    curve = read_one(vendors.nanoscope(tmp_path / "x.pfc", capture=True))
    assert curve.device.argmax() == ROWS
    assert np.ptp(curve.device) == pytest.approx(2e-7)
    assert curve.t[-1] == pytest.approx((2 * ROWS - 1) / (2 * ROWS) / 2000)
    assert curve.flags[0] == "displacement from the sine of the drive, 100 nm at 2 kHz"
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
    "length": ({"Data length": "319"}, {}, "319 bytes for 1 curve of 2 x 40 rows, 2 or 4 bytes each"),
    "offset": ({"Data offset": "99999"}, {}, "is cut off: holds 6,320 bytes of 100,159: copy it again"),
    "no rows": ({"Samps/line": "none"}, {}, "names no rows of its curves (Samps/line)"),
    "no scale": ({"@4:Z scale": "V [Sens. DeflSens] (0 V/LSB) 1 V"}, {}, "names no scale of its DeflectionError"),
    "no channel": ({"@4:Image Data": 'S [Phase] "Phase"'}, {}, "holds no deflection (channels: Phase)"),
}  # fmt: skip


@pytest.mark.parametrize("mistake", WRONG)
def test_what_is_wrong_with_a_nanoscope_file_is_said_in_one_line(tmp_path: Path, mistake: str) -> None:
    changed, how, words = WRONG[mistake]
    path = vendors.nanoscope(tmp_path / "x.000", **changed)
    with pytest.raises(InputError, match=re.escape(words)) as caught:
        measured.read(path, Reading(**how))
    assert len(caught.value.lines) == 1


# ---------------------------------------------------------------------- Nanosurf, and JPK's HDF5
@pytest.mark.parametrize("name", ["x.nhf", "named otherwise.dat"])
@pytest.mark.parametrize("unit", ["V", "m", "N"])
def test_a_nanosurf_curve_comes_back_in_each_unit(tmp_path: Path, unit: str, name: str) -> None:
    curve = read_one(vendors.nanosurf(tmp_path / name, unit=unit))
    assert curve.segment.tolist() == WAYS
    np.testing.assert_allclose(curve.P, FORCE, atol=1e-6 * np.ptp(FORCE), rtol=0)
    np.testing.assert_allclose(moved(curve.device), moved(-HEIGHT), atol=1e-6 * np.ptp(HEIGHT), rtol=0)
    np.testing.assert_allclose(curve.t, vendors.TIME, atol=1e-8)
    assert curve.stiffness == K
    assert "stiffness 0.05 N/m of the file" in curve.flags
    assert any("not tried on a real file" in flag for flag in curve.flags)


@pytest.mark.parametrize("unit", ["V", "m", "N"])
def test_constants_told_of_a_nanosurf_file_take_the_place_of_its_own(tmp_path: Path, unit: str) -> None:
    path = vendors.nanosurf(tmp_path / "x.nhf", unit=unit)
    curve = read_one(path, stiffness=2 * K, sensitivity=3 * vendors.SENSITIVITY)
    np.testing.assert_allclose(curve.P, 6 * FORCE, atol=6e-6 * np.ptp(FORCE), rtol=0)
    if unit != "V":  # lengths and forces need no sensitivity
        lame = vendors.nanosurf(tmp_path / "y.nhf", unit=unit, spm_probe_calibration_deflection_sensitivity=None)
        np.testing.assert_allclose(read_one(lame).P, FORCE, atol=1e-6 * np.ptp(FORCE), rtol=0)


def test_rows_and_curves_of_a_nanosurf_map(tmp_path: Path) -> None:
    curves = measured.read(vendors.nanosurf(tmp_path / "map.nhf", 2))
    assert [curve.name for curve in curves] == ["0", "1", "3", "2"]  # row by row of the grid
    assert [(at.column, at.row) for curve in curves if (at := curve.pixel)] == [(0, 0), (1, 0), (0, 1), (1, 1)]
    for curve in curves:
        np.testing.assert_allclose(curve.P, FORCE, atol=1e-6 * np.ptp(FORCE), rtol=0)
    path = vendors.nanosurf(tmp_path / "x.nhf")
    with h5py.File(path, "a") as file:
        file["group_0000/subgroup_0000/dataset_0000"][:3] = -(2**31)
    np.testing.assert_allclose(read_one(path).P, FORCE[3:], atol=1e-6 * np.ptp(FORCE), rtol=0)


LACKS = {
    "no spring constant": ({"spm_probe_calibration_spring_constant": None}, "names no stiffness: give --stiffness"),
    "no sensitivity": ({"spm_probe_calibration_deflection_sensitivity": None}, "no sensitivity: give --sensitivity"),
    "no number": ({"spm_probe_calibration_spring_constant": "soft"}, "is damaged and cannot be read"),
    "no range": ({"Position Z.signal_calibration_max": None}, "its Position Z lacks its calibration"),
    "no unit": ({"Deflection.signal_calibration_unit": None}, 'its Deflection is in "", not a unit of volts'),
    "other unit": ({"Position Z.signal_calibration_unit": "V"}, 'Position Z is in "V", not a unit of length: export'),
    "no deflection": ({"Deflection.signal_name": "Phase"}, 'segment "Advance to Setpoint 1" holds no Deflection'),
    "images": ({"group_type": "image_line_based"}, "without force curves (it holds images)"),
    "version": ({"nsf_file_version_major": 1}, "of version 1, version 2 is read: export it as text"),
}  # fmt: skip


@pytest.mark.parametrize("mistake", LACKS)
def test_what_a_nanosurf_file_lacks_is_said_in_one_line(jkr: Callable, tmp_path: Path, mistake: str) -> None:
    changed, words = LACKS[mistake]
    assert_refused(jkr, vendors.nanosurf(tmp_path / "x.nhf", **changed), words)


def test_damage_to_a_nanosurf_file_is_said_in_one_line(jkr: Callable[..., Outcome], tmp_path: Path) -> None:
    path = vendors.nanosurf(tmp_path / "x.nhf")
    whole = path.read_bytes()
    path.write_bytes(whole[: len(whole) // 2])
    assert_refused(jkr, path, "copy it again from the microscope")
    with h5py.File(vendors.nanosurf(path), "a") as file:
        file["group_0000/subgroup_0002/dataset_0003"][:] = ROWS + 1
    assert_refused(jkr, path, "is cut off: its curves hold more rows than its channels")
    # The sizes in it are followed by the C library, for ever where one leads to a free space of no size.
    path = vendors.nanosurf(tmp_path / "x.nhf")
    whole = path.read_bytes()
    heap = whole.index(b"GCOL") + 16
    for size in (0x0502, 2**40, 0):
        path.write_bytes(whole[: heap + 8] + size.to_bytes(8, "little") + whole[heap + 16 :])
        with pytest.raises(InputError, match="the HDF5 file is damaged and cannot be read"):
            read_one(path)


HEADS = [b"group_type", b"segment_name", b"signal_name", b"dataset_block_size_source", b"signal_calibration_max"]


@pytest.mark.first(5)
@pytest.mark.parametrize("name", HEADS, ids=bytes.decode)
@pytest.mark.parametrize("bits", [0x07, 0x80, 0xD6])
def test_a_flip_in_an_attribute_leads_the_library_nowhere(tmp_path: Path, name: bytes, bits: int) -> None:
    """Type, size and shape of an attribute stand behind its name and are without checksum: read as they are, some lead
    the C library out of its memory. What is left to read is read."""
    path = vendors.nanosurf(tmp_path / "x.nhf")
    whole = path.read_bytes()
    at = whole.index(name + b"\0") + 8 * (len(name) // 8 + 1)
    for place in (at, at + 1, at + 4, at + 8, at + 24):
        path.write_bytes(whole[:place] + bytes([whole[place] ^ bits]) + whole[place + 1 :])
        with contextlib.suppress(InputError):
            assert read_one(path).P.size == FORCE.size


def test_jpk_files_in_hdf5_are_refused_with_the_remedy(jkr: Callable[..., Outcome], tmp_path: Path) -> None:
    for name, group in (("x.h5-jpk", "else"), ("y.h5", "Measurement_000")):
        with h5py.File(tmp_path / name, "w") as file:
            file.create_group(group)
        assert_refused(jkr, tmp_path / name, "is a .h5-jpk file", "export it as .jpk-force or text")


def assert_refused(jkr: Callable[..., Outcome], path: Path, *words: str) -> None:
    """By both verbs; without its constants a file may be looked at."""
    for verb in [("look",), BODY][1 if "give --" in words[0] else 0 :]:
        jkr(*verb, path).refused(str(path), *words)


BODY = ("fit", "--radius", "5 um", "--nu", "0.5", "--shape", "paraboloid")


# ---------------------------------------------------------------------- exports in text
@pytest.mark.parametrize("maker", vendors.EXPORTS)
def test_the_record_comes_back_from_each_export(tmp_path: Path, maker: str) -> None:
    of_machine = maker in ("instron", "zwick")
    curve = read_one(vendors.export(tmp_path / "x.txt", maker), **({"stiffness": K} if of_machine else {}))
    if curve.segment is not None:
        assert curve.segment.tolist() == WAYS
    np.testing.assert_allclose(curve.P, FORCE, rtol=1e-8, atol=1e-20)
    np.testing.assert_allclose(moved(curve.delta), moved(-HEIGHT - FORCE / K), atol=2e-15)  # of 2 um, nine digits
    if maker not in ("nanoscope", "nanoscope volts"):
        np.testing.assert_allclose(curve.t, vendors.TIME, atol=1e-8)


@pytest.mark.parametrize(("title", "in_", "out"), [
    ("segment", "load", "UNLOAD"), ("Ast", "Belasten", "Entlasten"), ("Richtung", "hin", "zurück"),
    ("Phase", "charge", "décharge"), ("Branche", "approche", "retrait"),
])  # fmt: skip
def test_segments_are_spelled_in_three_languages(tmp_path: Path, title: str, in_: str, out: str) -> None:
    rows = [f"{z},{z},{in_ if z < 4 else out}" for z in (1, 2, 3, 4, 5, 6)]
    (tmp_path / "x.csv").write_text("\n".join([f"delta_nm,P_nN,{title}", *rows]), encoding="utf-8")
    curve = read_one(tmp_path / "x.csv")
    assert curve.segment.tolist() == ["approach"] * 3 + ["retract"] * 3
    assert curve.flags == (f'segments from column 3 "{title}": "{in_}" is approach, "{out}" is retract',)


def test_rows_are_selected_by_number_by_segment_and_by_column(tmp_path: Path) -> None:
    rows = [f"{1 + i // 6},{i},{i},{'Belasten' if i % 6 < 3 else 'Entlasten'}" for i in range(12)]
    (path := tmp_path / "x.csv").write_text("\n".join(["step,delta_nm,P_nN,Ast", *rows]))

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
        with pytest.raises(InputError, match=re.escape(words)):
            read_one(path, **how)


def test_waves_know_their_dwells_and_their_pixel(tmp_path: Path) -> None:
    # The piezo creeps on by a tenth of its way while the tip waits in contact, and waits again far away.
    pytest.importorskip("afmformats")
    ways = np.concatenate([np.linspace(0, 1, 200), np.linspace(1, 1.1, 150), np.linspace(1.1, 0, 200), np.zeros(50)])
    force = 4e-9 * np.maximum(ways - 0.6, 0) ** 1.5 + 2e-12 * np.random.default_rng(1).normal(size=ways.size)
    told = {"Indexes": "0,199,349,549,599,", "Direction": "Inf,1,0,-1,0,"}

    def segments(**marks: str) -> list[tuple[str, int]]:
        curve = read_one(vendors.ibw(tmp_path / "x.ibw", marks=marks, record=(3e-6 - 2e-6 * ways, force)))
        return [(part.kind, len(part)) for part in segment_force_curve(curve).segments]

    marked = [("approach", 200), ("dwell", 150), ("retract", 200), ("dwell", 50)]
    assert segments(**told) == segments(**told | {"Direction": " NaN,1,0,-1,0"}) == marked
    by_motion = segments()
    assert by_motion != marked
    for wrong in ({"Indexes": "0,199,349,500,"}, {"Indexes": "0,349,199,549,599"}, {"Direction": "Inf,1,x,-1,0"}):
        assert segments(**told | wrong) == by_motion
    pytest.importorskip("afmformats")
    curve = read_one(vendors.ibw(tmp_path / "x.ibw", (3, 5)))
    assert (curve.pixel.column, curve.pixel.row, curve.pixel.x, curve.pixel.y) == (3, 5, 3e-6, 5e-6)
    assert read_one(vendors.ibw(tmp_path / "y.ibw")).pixel is None


# ---------------------------------------------------------------------- tables that contradict themselves
DELTA = np.linspace(0, 1, 30)
LOAD = np.maximum(DELTA - 0.4, 0) ** 1.5


def table(head: str, rows: list[str]) -> str:
    return "\n".join([head, *rows]) + "\n"


def numbers(separator: str = ",") -> list[str]:
    return [f"{x:.4f}{separator}{P:.4f}" for x, P in zip(DELTA, LOAD, strict=True)]


# ---------------------------------------------------------------------- a row of units
@pytest.mark.parametrize("head", [
    "delta (um),P (uN)\n[nm],[uN]", "delta_um,P_uN\num,nN", "delta / um,P / uN\nmm,uN", "delta in um,P in uN\num,s",
    "# delta (um),P (uN)\n# nm,nN",
])  # fmt: skip
def test_units_that_contradict_the_names(head: str, tmp_path: Path) -> None:
    (tmp_path / "a.csv").write_text(table(head, numbers()))
    with pytest.raises(InputError, match="names one unit and the row of units below another"):
        read(tmp_path / "a.csv")
    (curve,) = read(tmp_path / "a.csv", Reading(units={"delta": "um", "P": "uN"}))
    assert curve.depth.max() == pytest.approx(1e-6)


@pytest.mark.parametrize("head", [
    "delta (um),P (uN)\nµm,µN", "delta (um),P\n,[uN]", "delta (um),P (uN)\n-,-", "delta (um),P (uN),x (V)\num,uN,mV",
    "# delta,P\n# um,uN", "delta (um),P (uN)\nmicrometer,uN",
])  # fmt: skip
def test_units_that_agree(head: str, tmp_path: Path) -> None:
    """And a column that is not read may say what it likes."""
    wide = "x" in head
    (tmp_path / "a.csv").write_text(table(head, [row + ",1" * wide for row in numbers()]))
    (curve,) = read(tmp_path / "a.csv")
    assert (curve.depth.max(), curve.load.max()) == pytest.approx((1e-6, 1e-6 * LOAD.max()), rel=1e-3)


# ---------------------------------------------------------------------- no numbers
@pytest.mark.parametrize(
    ("word", "separator"),
    [("*********", ","), ("**", " "), ("#REF!", "\t"), ("#N/A", ","), ("#BEZUG!", " "), ("####", ",")],
)
def test_rows_of_overflows_and_sheet_errors_are_counted(word: str, separator: str, tmp_path: Path) -> None:
    for column in (0, 1):
        rows = numbers(separator)
        for i in range(1, 30, 2):
            cells = rows[i].split(separator)
            cells[column] = word
            rows[i] = separator.join(cells)
        (tmp_path / "a.txt").write_text(table(separator.join(("delta_um", "P_uN")), rows))
        (curve,) = read(tmp_path / "a.txt")
        assert len(curve) == 15
        assert any("15 of 30 rows without a number left out (lines 3, 5," in flag for flag in curve.flags), curve.flags


@pytest.mark.parametrize(
    "line", ["#", "** 3 runs of the tip", "#REF run 3", "****", "#1 of 2", "% 5", "// 1, 2", "! 1 2"]
)
def test_comments_stay_comments(line: str, tmp_path: Path) -> None:
    rows = numbers()
    (tmp_path / "a.csv").write_text(table("delta_um,P_uN", [*rows[:10], line, *rows[10:]]))
    (curve,) = read(tmp_path / "a.csv")
    assert len(curve) == 30
    assert not any("left out" in flag for flag in curve.flags)


# ---------------------------------------------------------------------- archives
def damaged(path: Path, wrong: list[int], compression: int = zipfile.ZIP_STORED) -> None:
    """A zip of four tables, of which those numbered are damaged."""
    with zipfile.ZipFile(path, "w", compression) as file:
        for i in range(4):
            file.writestr(f"{i}.csv", table("delta_um,P_uN", numbers()))
    whole = bytearray(path.read_bytes())
    with zipfile.ZipFile(path) as file:
        for i in wrong:
            item = file.infolist()[i]
            whole[item.header_offset + 30 + len(item.filename) + 60] ^= 0xFF
    path.write_bytes(bytes(whole))


@pytest.mark.parametrize(("wrong", "compression"), [([0], zipfile.ZIP_STORED), ([1, 3], zipfile.ZIP_DEFLATED)])
def test_a_damaged_member_is_named_and_the_others_are_read(wrong: list[int], compression: int, tmp_path: Path) -> None:
    damaged(tmp_path / "map.zip", wrong, compression)
    curves, lines = usable([tmp_path / "map.zip"], Reading())
    assert [curve.name for curve in curves] == [str(i) for i in range(4) if i not in wrong]
    assert all(f"{i}.csv cannot be unpacked" in line for i, line in zip(wrong, lines, strict=True)), lines


@pytest.mark.parametrize(("curves", "columns", "image"), [(8, 4, 16), (64, 8, 8), (2, 2, 8), (4, 4, 128)])
def test_a_force_volume_of_fewer_curves_than_pixels(curves: int, columns: int, image: int, tmp_path: Path) -> None:
    read_curves = read(vendors.nanoscope(tmp_path / "a.spm", curves, columns=columns, image=image))
    assert [len(curve) for curve in read_curves] == [2 * vendors.ROWS] * curves


# ---------------------------------------------------------------------- gzip
def test_gzip_is_read_by_itself_or_is_one_error(tmp_path: Path, jkr: Callable) -> None:
    text = table("delta_um,P_uN", numbers()).encode()
    for name, content in (
        ("a.csv", text),
        ("a.txt", text),
        ("a.spm", vendors.nanoscope(tmp_path / "a.spm", 4).read_bytes()),
        ("a.000", vendors.nanoscope(tmp_path / "a.000").read_bytes()),
    ):
        (tmp_path / name).write_bytes(content)
        (tmp_path / f"{name}.gz").write_bytes(gzip.compress(content))
        plain, unpacked = read(tmp_path / name), read(tmp_path / f"{name}.gz")
        assert len(plain) == len(unpacked)
        assert all(np.array_equal(one.load, other.load) for one, other in zip(plain, unpacked, strict=True))
    whole = gzip.compress(table("delta_um,P_uN", numbers()).encode())
    wrong = {
        "cut": whole[:-30], "bare": b"delta,P", "empty": b"", "crc": whole[:-8] + struct.pack("<II", 1, 2),
        "head": b"\x1f\x8b" + bytes(20), "turned": whole[:20] + whole[20:40][::-1] + whole[40:],
    }  # fmt: skip
    for name, content in wrong.items():
        (tmp_path / f"{name}.csv.gz").write_bytes(content)
        jkr("look", f"{name}.csv.gz").refused(f"{name}.csv.gz")
    for name in ("a.jpk-force.gz", "a.tar.gz", "a.zip.gz", "a.h5.gz"):
        (tmp_path / name).write_bytes(whole)
        assert "unpack it" in jkr("look", name).err


# ---------------------------------------------------------------------- constants of a device
@pytest.mark.parametrize("line", [
    "# spring constant: 1.0 N/m", "Spring constant (N/m): 1", "spring constant, 1 N/m", "k = 1000 mN/m", "k (N/m)\t1",
    "Force Constant, nN/nm: 1.0", "Federkonstante [N/m]; 1,0",
])  # fmt: skip
def test_a_spring_constant_of_one(line: str) -> None:
    assert constants((line,)).get("stiffness") == pytest.approx(1.0), line
    assert constants(("# springConstant: 1.0", "# sensitivity: 1")) == {}  # JPK's of what is not calibrated


# ---------------------------------------------------------------------- numbers as texts from Python
def test_a_reading_takes_numbers_with_units() -> None:
    assert Reading(stiffness="0.6 N/m").stiffness == pytest.approx(0.6)
    assert Reading(stiffness="rigid").stiffness == np.inf
    assert Reading(sensitivity="45 nm/V").sensitivity == pytest.approx(45e-9)
    assert Reading(zero={"delta": "1.2 um", "P": 1e-9}).zero == pytest.approx({"delta": 1.2e-6, "P": 1e-9})
    assert Reading(flip="delta").flip == frozenset({"delta"})
    for wrong, name in (
        ({"stiffness": "soft"}, "stiffness"), ({"stiffness": -1}, "stiffness"), ({"stiffness": []}, "stiffness"),
        ({"sensitivity": "0.6 N/m"}, "sensitivity"), ({"zero": {"P": "1 um"}}, 'zero: "P"'),
        ({"factors": {"P": "many"}}, 'factors: "P"'), ({"contact": "fited"}, '.*got .fited., did you mean "fitted"'),
        ({"format": "hdf"}, "format: .*text, afm"), ({"flip": ["P", "a"]}, "flip: .*got .a."),
        ({"zero": {"a": 1.0}}, "zero: .*delta, P"), ({"decimal": ";"}, "decimal: "), ({"units": "nN"}, "units: must"),
        ({"rows": 5}, "rows: must be 2 values"), ({"rows": (9, 3)}, "rows: .*got .9, 3"),
    ):  # fmt: skip
        with pytest.raises(InputError, match=name):
            Reading(**wrong)


# ---------------------------------------------------------------------- one direction
def test_a_height_that_grows_into_the_specimen(tmp_path: Path, jkr: Callable) -> None:
    """Of one direction: by its load; turned against that it is refused with the remedy that works."""
    z = np.linspace(0, 2, 60)
    tip = np.maximum(z - 0.8, 0)
    P = 16.9 * tip**1.5 * 0.45
    for name in ("height", "piezo"):
        write_table(tmp_path / f"{name}.csv", f"{name} (um),force (nN)", z, P)
    words = ("--radius", "5 um", "--nu", "0.5", "--stiffness", "0.05 N/m", "--no-plots")
    up, known = (jkr("fit", f"{name}.csv", *words) for name in ("height", "piezo"))
    assert up.code == known.code == 0, up.err
    assert up.out.splitlines()[0] == known.out.splitlines()[0]
    jkr("fit", "height.csv", *words, "--flip", "delta").refused("--factor delta=-1")
    assert jkr("fit", "height.csv", *words, "--flip", "delta", "--factor", "delta=-1").code == 0
    assert jkr_package.measured_curves(tmp_path / "height.csv")[0].depth[-1] > 0


@pytest.mark.parametrize(
    "head",
    ["# k: 0.032\n#z [nm]\t#force [nN]", "# k: 0.032\nz [nm]\t#force [nN]", "#k = 0.032\n#z [nm] #force [nN]",
     "% k: 0.032\n%z (nm)  %force (nN)"],
)  # fmt: skip
def test_names_that_begin_with_the_comment_sign_and_a_bare_spring_constant(tmp_path: Path, head: str) -> None:
    path = tmp_path / "curve.txt"
    path.write_text(head + "\n" + "".join(f"{i}\t{i * i / 90:.3f}\n" for i in range(40)))
    table = read_table(path, least=2)
    assert [split_name(name) for name in table.names] == [("z", "nm"), ("force", "nN")]
    assert constants(tuple(head.split("\n")[:1])) == {"stiffness": 0.032}
