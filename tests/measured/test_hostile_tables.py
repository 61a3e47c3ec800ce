"""Tables that contradict themselves, overflow, or come packed and damaged; ten of each kind."""

import gzip
import struct
import zipfile
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import vendors
from conftest import write_table

import jkrcli as jkr_package
from jkrcli.base.errors import InputError
from jkrcli.measured.curve import Reading
from jkrcli.measured.files import read, usable
from jkrcli.measured.instruments import constants
from jkrcli.tables import split_name
from jkrcli.tables.text import read_table

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
