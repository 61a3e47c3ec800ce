"""Dirty tables as instruments write them: encodings, archives, foreign names with signs, pairs of columns, volts."""

import math
import tracemalloc
import zipfile
from collections.abc import Callable
from itertools import zip_longest
from pathlib import Path

import numpy as np
import pytest

from jkrcli.base.errors import InputError
from jkrcli.measured import files as measured
from jkrcli.measured.curve import AS_DEPTH, Curve, Reading
from jkrcli.tables.text import read_table

Z = np.array([0.0, 1.0, 2.0, 3.0, 2.0, 1.0]) * 1e-6  # toward the specimen
LOAD = np.array([0.0, 0.0, 2.0, 9.0, 1.0, -3.0]) * 1e-9
GERMAN = "Prüfung vom 3.2.\r\nWeg [µm];Kraft [mN]\r\n" + "".join(
    f"{z * 1e6:.3f};{P * 1e3:.9f}\r\n".replace(".", ",") for z, P in zip(Z, LOAD, strict=True)
)
ENCODINGS = {
    "utf-8": GERMAN.encode(),
    "utf-8 with a mark": GERMAN.encode("utf-8-sig"),
    "utf-16 little with a mark": b"\xff\xfe" + GERMAN.encode("utf-16-le"),
    "utf-16 big with a mark": b"\xfe\xff" + GERMAN.encode("utf-16-be"),
    "utf-16 little": GERMAN.encode("utf-16-le"),
    "windows-1252": GERMAN.encode("cp1252"),
    "latin-1": GERMAN.replace("Prüfung", "Pr\x81fung").encode("latin-1"),
}


def table(*columns: tuple[str, np.ndarray], head: str = "") -> str:
    lines = [",".join(name for name, _ in columns)]
    lines += [",".join(map(repr, map(float, row))) for row in zip(*(values for _, values in columns), strict=True)]
    return head + "\n".join(lines) + "\n"


def written(tmp_path: Path, content: str | bytes, name: str = "m.csv") -> Path:
    path = tmp_path / name
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    return path


def one(path: Path, reading: Reading | None = None) -> Curve:
    (curve,) = measured.read(path, reading)
    return curve


@pytest.mark.parametrize("encoding", ENCODINGS)
def test_the_same_table_in_every_encoding(tmp_path: Path, encoding: str) -> None:
    curve = one(written(tmp_path, ENCODINGS[encoding]))
    np.testing.assert_allclose(curve.delta, Z, rtol=1e-12)
    np.testing.assert_allclose(curve.P, LOAD, rtol=1e-12)
    assert curve.flags[0] == 'displacement from column 1 "Weg [µm]", sign unchanged'
    assert curve.flags[1].endswith("is not subtracted: give --stiffness")


def test_what_is_subtracted_from_a_displacement(tmp_path: Path) -> None:
    head = "Federkonstante: 0,3 N/m\n"
    told, found = (
        one(written(tmp_path, head + table(("Weg [m]", Z), ("Kraft [N]", LOAD))), reading)
        for reading in (Reading(stiffness=math.inf), None)
    )
    np.testing.assert_array_equal(told.delta, Z)
    np.testing.assert_allclose(found.delta, Z - LOAD / 0.3, rtol=1e-12)
    assert told.flags[1] == "stiffness rigid as specified, the header of the file says 0.3 N/m"
    bent = written(tmp_path, table(("Height (um)", Z), ("Deflection_nm", LOAD)))
    with pytest.raises(InputError, match=r"a deflection in nm, and a rigid instrument has none: give its stiffness$"):
        measured.read(bent, Reading(stiffness=math.inf))
    path = written(tmp_path, table(("Piezo [m]", Z + LOAD / 5), ("Indentation [m]", Z), ("Force [N]", LOAD)))
    for reading in (Reading(stiffness=math.inf), Reading(stiffness=5.0), None):
        np.testing.assert_allclose(one(path, reading).delta, Z, rtol=1e-12, atol=1e-20)


def test_segments_are_named_where_they_begin(tmp_path: Path) -> None:
    # A row whose last cell is empty ended in a traceback, then was a segment of its own.
    words = ["approach", *[""] * (Z.size // 2 - 1), "retract", *[""] * (Z.size - Z.size // 2 - 1)]
    rows = [f"{z!r},{load!r},{word}" for z, load, word in zip(Z.tolist(), LOAD.tolist(), words, strict=True)]
    held = one(written(tmp_path, "\n".join(["delta_m,P_N,segment", *rows]))).segment
    assert held.tolist() == ["approach"] * (Z.size // 2) + ["retract"] * (Z.size - Z.size // 2)
    head, *rows = table(("delta_m", Z), ("P_N", LOAD)).splitlines()
    curve = one(written(tmp_path, "\n".join([head, "Loading", *rows[:2], "Hold", *rows[2:4], "Unloading", *rows[4:]])))
    assert curve.segment.tolist() == ["approach"] * 2 + ["hold"] * 2 + ["retract"] * 2


def test_which_position_a_displacement_is(tmp_path: Path) -> None:
    # A piezo's way, named by hand, was taken for the depth of the tip without a word: E* half of what it is.
    head = "Federkonstante: 0,3 N/m\n"
    for name, asked in (("Verfahrung", True), ("Displacement", True), ("Indentation", False), ("Piezoweg", False)):
        path = written(tmp_path, head + table((f"{name} (m)", Z), ("Deflection (m)", LOAD / 0.3)))
        curve = one(path, Reading(columns={"delta": name}))
        assert (AS_DEPTH in curve.flags) == asked, name
        np.testing.assert_allclose(curve.delta, Z - LOAD / 0.3 if name == "Piezoweg" else Z, atol=1e-18)
    columns = (("Load (nN)", LOAD * 1e9), ("Indentation (nm)", Z * 1e9 - 5), ("Piezo (nm)", Z * 1e9))
    curve = one(written(tmp_path, table(*columns)))
    np.testing.assert_allclose(curve.delta, Z - 5e-9, rtol=1e-12)
    assert 'not column 3 "Piezo (nm)": the stiffness of the instrument is not known' in curve.flags[0]
    curve = one(written(tmp_path, table(*columns, head="k (N/m)\t0.019\n\n")))
    np.testing.assert_allclose(curve.delta, Z - LOAD / 0.019, rtol=1e-12, atol=1e-20)
    assert 'z was taken, not column 2 "Indentation (nm)": its stiffness is known' in curve.flags[1]
    assert curve.flags[2].startswith("stiffness 0.019 N/m from the header of the file")


@pytest.mark.parametrize("mark", [",", "\t"])
def test_tables_as_wide_as_a_scan_are_read(tmp_path: Path, mark: str) -> None:
    """Names of several words used to count as so many cells, long comments and prose above as rows."""
    width = 4000
    names = [f"Height of curve {i} (um){mark}Force of curve {i} (nN)" for i in range(width // 2)]
    rows = [mark.join(f"{i + 1}.5" for i in range(width)) + mark for _ in range(3)]
    prose = "words of an operator " * 4000
    path = written(tmp_path, "\n".join(["# " + prose, prose, mark.join(names), *rows]))
    held = read_table(path, least=2)
    assert held.values.shape == (3, width)
    assert held.names[-1] == f"Force of curve {width // 2 - 1} (nN)"
    path.write_text("# " + mark.join(names) + "\n" + "\n".join(rows))
    assert read_table(path, least=2).names[0] == "Height of curve 0 (um)"


# ---------------------------------------------------------------------- names and signs
SIGNS = {
    "Height (nm)": (-1, True), "Tip-Sample Separation (nm)": (-1, False), "Weg (nm)": (1, True),
    "Eindringtiefe (nm)": (1, False), "Z sensor (nm)": (1, True), "piezo (nm)": (1, True), "z_nm": (1, True),
    "Extension [nm]": (1, True), "Height (measured) [nm]": (-1, True), "Raw Height Sensor [nm]": (-1, True),
    "ZSnsr (nm)": (-1, True), "height (measured) / nm": (-1, True),
}  # fmt: skip


@pytest.mark.parametrize("title", SIGNS)
def test_positions_come_with_the_sign_of_their_name(tmp_path: Path, title: str) -> None:
    sign, device = SIGNS[title]
    curve = one(written(tmp_path, table((title, sign * Z * 1e9), ("Force (nN)", LOAD * 1e9))), Reading(stiffness=0.1))
    assert curve.stiffness == (0.1 if device else None)
    np.testing.assert_allclose(curve.device, Z, rtol=1e-12, atol=1e-20)
    assert ("sign changed" in curve.flags[0]) == (sign < 0)


def test_the_sign_of_a_z(tmp_path: Path) -> None:
    path = written(tmp_path, table(("Z (nm)", -Z * 1e9), ("Force (nN)", LOAD * 1e9)))
    curve = one(path)
    np.testing.assert_allclose(curve.delta, Z, rtol=1e-12)
    assert "sign changed: a position of the piezo, at whose lower end the load is largest" in curve.flags[0]
    np.testing.assert_allclose(one(path, Reading(factors={"delta": -1.0})).delta, -Z, rtol=1e-12)
    np.testing.assert_allclose(one(path, Reading(flip=frozenset({"delta"}))).delta, Z, rtol=1e-12)
    # Of a sticky gel the free rows hold the largest loads, those at the turn the least.
    z = np.concatenate([np.linspace(0, 10, 60), np.linspace(10, 0, 60)]) * 1e-6
    load = np.where(z > 8e-6, -(z - 8e-6) * 1e-3, 0.0) + 1e-10 * np.cos(np.arange(120.0) ** 2)
    for sign in (1, -1):
        curve = one(written(tmp_path, table(("Z (nm)", sign * z * 1e9), ("Force (nN)", load * 1e9))))
        np.testing.assert_allclose(curve.delta, z, rtol=1e-12)


def test_names_and_units_of_comment_heads_and_units_within_names(tmp_path: Path) -> None:
    rows = "".join(f"{-z!r} {P!r} 0.0\n" for z, P in zip(Z.tolist(), LOAD.tolist(), strict=True))
    head = "# index: 0\n# columns: measuredHeight vDeflection hDeflection\n# units: m N V\n#\n"
    curve = one(written(tmp_path, head + rows, "m.txt"))
    np.testing.assert_allclose(curve.delta, Z, rtol=1e-12)
    np.testing.assert_allclose(curve.P, LOAD, rtol=1e-12)
    names = ("Calc_Ramp_Ex_nm", "Calc_Ramp_Rt_nm", "Defl_V_Ex", "Defl_V_Rt", "Defl_pN_Ex", "Defl_pN_Rt")
    z, P = Z * 1e9, LOAD * 1e12
    content = table(*zip(names, (z[:3], z[3:], P[:3] * 7, P[3:] * 7, P[:3], P[3:]), strict=True))
    curve = one(written(tmp_path, content, "m.tab"))
    np.testing.assert_allclose(curve.P, LOAD, rtol=1e-12)
    assert list(curve.segments()) == ["approach", "retract"]


@pytest.mark.parametrize(("separator", "short"), [("\t", 0), (",", 1), (";", 1)])
def test_pairs_of_columns_of_unequal_length(tmp_path: Path, separator: str, short: int) -> None:
    """The shorter pair ends in empty cells, be it the last or the first."""
    there, back = [(f"{z * 1e9}", f"{P * 1e9}") for z, P in zip(Z, LOAD, strict=True)], [("-9", "-1"), ("-8", "-2")]
    pairs = [there, back][:: 1 - 2 * (short == 0)]
    rows = [[*one, *other] for one, other in zip_longest(*pairs, fillvalue=("", ""))]
    names = ["Extend Z-Sense(nm)", "Extend Force(nN)", "Retract Z-Sense(nm)", "Retract Force(nN)"]
    curve = one(written(tmp_path, "\n".join(separator.join(row) for row in [names, *rows, ["", "", "", ""]]) + "\n"))
    assert curve.segment.tolist() == ["approach"] * len(pairs[0]) + ["retract"] * len(pairs[1])
    np.testing.assert_allclose(curve.P * 1e9, [float(P) for pair in pairs for _, P in pair], rtol=1e-12)


@pytest.mark.parametrize(("rows", "separator"), [
    (("999.5", "1,234.5", "12,345.25"), "\t"), (("999,5", "1.234,5", "12.345,25"), ";"),
    (("999,5", "1'234,5", "12'345,25"), ";"), (("999.5", '"1,234.5"', '"12,345.25"'), ","),
])  # fmt: skip
def test_marks_of_thousands(tmp_path: Path, rows: tuple[str, ...], separator: str) -> None:
    """They are told from decimal marks where both occur."""
    lines = [f"{i}{separator}{row}" for i, row in enumerate(rows)]
    curve = one(written(tmp_path, "\n".join([f"delta_nm{separator}P_nN", *lines]) + "\n"))
    np.testing.assert_allclose(curve.P, np.array([999.5, 1234.5, 12345.25]) * 1e-9, rtol=1e-12)


def test_a_mark_of_thousands_far_down_a_long_table(tmp_path: Path) -> None:
    loads = np.linspace(0.5, 1500.5, 3001)
    lines = [f"{i}\t{P:,.1f}" for i, P in enumerate(loads)]
    curve = one(written(tmp_path, "\n".join(["delta_nm\tP_nN", *lines]) + "\n"))
    np.testing.assert_allclose(curve.P, loads * 1e-9, rtol=1e-12)


def test_deflections_become_loads(tmp_path: Path) -> None:
    volts = written(tmp_path, table(("Height (um)", -Z * 1e6), ("Deflection (mV)", LOAD / 0.1 / 5e-8 * 1e3)))
    curve = one(volts, Reading(stiffness=0.1, sensitivity=5e-8))
    np.testing.assert_allclose(curve.P, LOAD, rtol=1e-12)
    np.testing.assert_allclose(curve.delta, Z - LOAD / 0.1, rtol=1e-12, atol=1e-20)
    assert curve.flags[1].endswith("a deflection in mV, with sensitivity 5e-08 m/V, stiffness 0.1 N/m")
    metres = written(tmp_path, table(("Height (um)", -Z * 1e6), ("Deflection (nm)", LOAD / 0.1 * 1e9)))
    np.testing.assert_allclose(one(metres, Reading(stiffness=0.1)).P, LOAD, rtol=1e-12)
    assert one(metres, Reading(incomplete=True)).flags[1].endswith("loads in arbitrary units, give --stiffness")
    path = written(tmp_path, "\n".join(f"{z * 1e9} {d}" for z, d in zip(Z, LOAD / 0.1 / 5e-8, strict=True)), "m.txt")
    told = {"columns": {"delta": "1", "P": "2"}, "stiffness": 0.1}
    volts = one(path, Reading(units={"delta": "nm", "P": "V"}, sensitivity=5e-8, **told))
    metres = one(path, Reading(units={"delta": "nm", "P": "nm"}, factors={"P": 50.0}, **told))
    for curve in (volts, metres):
        np.testing.assert_allclose(curve.P, LOAD, rtol=1e-12)


# ---------------------------------------------------------------------- the user wins
def test_unit_and_factor_overrule_the_header(tmp_path: Path) -> None:
    path = written(tmp_path, table(("delta_nm", Z * 1e9), ("P_nN", LOAD * 1e9)))
    curve = one(path, Reading(units={"P": "uN"}, factors={"P": 2.0, "delta": 0.5}))
    np.testing.assert_allclose(curve.P, 2e3 * LOAD, rtol=1e-12)
    np.testing.assert_allclose(curve.delta, Z / 2, rtol=1e-12)
    assert curve.flags == ('column 2 "P_nN" read in uN as specified, its header says nN',)
    z, P = np.linspace(0, 1.8e-6, 50), np.linspace(0, 60e-9, 50) ** 1.0
    head = "# springConstant: 0.3\n"
    wrong = written(tmp_path, head + table(("piezo (nm)", z * 1e6), ("force (nN)", P * 1e9)))
    with pytest.raises(InputError, match=r"bend the instrument \(0.3 N/m\) by 200 nm while it moves by 1.8 nm.*--unit"):
        one(wrong)
    curve = one(wrong, Reading(units={"delta": "um"}))
    np.testing.assert_allclose(curve.device, z, atol=1e-15)


@pytest.mark.parametrize("names", [("piezo", "deflection"), ("1", "2"), ("delta", "P")])
def test_units_are_told_of_columns_by_name_number_or_quantity(tmp_path: Path, names: tuple[str, str]) -> None:
    path = written(tmp_path, table(("piezo", Z * 1e9), ("deflection", LOAD / 0.1 * 1e6)))
    curve = one(path, Reading(units=dict(zip(names, ("nm", "um"), strict=True)), stiffness=0.1))
    np.testing.assert_allclose(curve.device, Z, rtol=1e-12, atol=1e-20)
    np.testing.assert_allclose(curve.P, LOAD, rtol=1e-12)


SPELT = ("Weg in mm;Kraft in N", "Weg mm;Kraft N", "Weg (Millimeter);Kraft (Newton)", "Déplacement [mm];Effort [N]",
         "Weg (mm);Kraft [newtons]", "Depth (mm);Load (N)", "Pos Z [mm];Force [N]", "h (mm);P (N)", "Pd (mm);Fn (N)",
         "MEMS displ.[mm];MEMS force[N]", "Weg (mm);vDeflection (N)", "Weg (mm);Vertical deflection / N")  # fmt: skip


@pytest.mark.parametrize("head", SPELT)
def test_names_and_units_as_people_and_indenters_write_them(tmp_path: Path, head: str) -> None:
    rows = [f"{z * 1e3:.6f};{P:.12f}".replace(".", ",") for z, P in zip(Z, LOAD, strict=True)]
    curve = one(written(tmp_path, "\n".join([head, *rows])))
    np.testing.assert_allclose(curve.delta, Z, rtol=1e-12)
    np.testing.assert_allclose(curve.P, LOAD, rtol=1e-12)


def test_columns_that_are_no_measurement_are_passed_over(tmp_path: Path) -> None:
    rows = [f"12:00:{i:02d};{z};{P};{'ok' if i == 4 else ''}" for i, (z, P) in enumerate(zip(Z, LOAD, strict=True))]
    curve = one(written(tmp_path, "\n".join(["clock;delta_m;P_N;remark", *rows])))
    np.testing.assert_allclose(curve.P, LOAD, rtol=1e-12)
    assert curve.t is None
    zeros = np.zeros(Z.size)
    text = table(("Weg (m)", Z), ("Kraft (N)", LOAD), ("Contact Area (um^2)", zeros), ("Time (s)", zeros))
    curve = one(written(tmp_path, text))
    assert curve.measured == ("delta", "P")
    assert sum("zeros alone" in flag for flag in curve.flags) == 2
    curve = one(written(tmp_path, table(("h (nm)", 0 * Z + 50), ("delta (nm)", Z * 1e9), ("P (nN)", LOAD * 1e9))))
    np.testing.assert_allclose(curve.delta, Z, rtol=1e-12)
    phases = np.array([20.0, 21.0, 20.0, 22.0, 21.0, 20.0])
    assert one(written(tmp_path, table(("Weg (m)", Z), ("Kraft (N)", LOAD), ("Phase (deg)", phases)))).segment is None


def test_rows_that_are_no_measurement_are_left_out_and_said(tmp_path: Path) -> None:
    curve = one(written(tmp_path, table(("delta_m", Z), ("P_N", LOAD)) + "\nLargest load,9e-9\nEnd of test\n"))
    assert len(curve) == Z.size
    assert curve.flags == ('lines 9 to 10 are behind the last row and left out: "Largest load,9e-9"',)
    # A blank cell, a word in a cell, a row of its time alone; the numbers of the others as they are.
    rows = [f"{i / 10};{i * 0.5};{2 * i};" for i in range(40)]
    rows[7], rows[19], rows[30] = "0,7;n.a.;14;", "1,9;9,5;;door", "3;;;"
    text = "Zeit;Eindringtiefe;Kraft;Bemerkung\ns;µm;µN;\n" + "\n".join(row.replace(".5", ",5") for row in rows)
    curve = one(written(tmp_path, text.replace(".", ",").replace("n,a,", "n.a.")))
    kept = np.delete(np.arange(40), [7, 19, 30])
    np.testing.assert_allclose(curve.delta, 0.5e-6 * kept, rtol=1e-12)
    np.testing.assert_allclose(curve.P, 2e-6 * kept, rtol=1e-12)
    assert "3 of 40 rows without a number left out (lines 10, 22, 33)" in curve.flags


ENDS = {
    "a column of remarks without any": "delta_m;P_N;remark\n{0};\n{1};\n{2};\n",
    "units of all columns but the last": "delta;P;remark\nm;N;\n{0};\n{1};ok\n{2};\n",
    "empty columns of a sheet": "delta_m;P_N;\n{0};\n{1};\n{2};\n",
    "two empty columns of a sheet": "delta_m;P_N;;\n{0};;\n{1};;\n{2};;\n",
}


@pytest.mark.parametrize("kind", ENDS)
def test_rows_that_end_in_an_empty_cell(tmp_path: Path, kind: str) -> None:
    curve = one(written(tmp_path, ENDS[kind].format("1e-9;0", "2e-9;1e-9", "3e-9;3e-9")))
    np.testing.assert_allclose(curve.delta, np.array([1e-9, 2e-9, 3e-9]), rtol=1e-12)
    np.testing.assert_allclose(curve.P, np.array([0, 1e-9, 3e-9]), rtol=1e-12)


LINES = {
    "words": "Approach|Retract",
    "brackets": "[Approach]|[Retract]",
    "comments": "# segment: extend|# segment: retract",
    "German": "Belastung:|Entlastung:",
    "numbers": "Segment 1: loading|Segment 2: unloading",
}


@pytest.mark.parametrize("kind", LINES)
def test_segments_named_on_lines_of_their_own(tmp_path: Path, kind: str) -> None:
    """The header stands above all, or again in every block."""
    head, *rows = table(("delta_m", Z), ("P_N", LOAD)).splitlines()
    first, second = LINES[kind].split("|")
    for again in ([], [head]):
        curve = one(written(tmp_path, "\n".join([first, head, *rows[:3], "", second, *again, *rows[3:]])))
        assert curve.segment.tolist() == ["approach"] * 3 + ["retract"] * 3
        np.testing.assert_allclose(curve.P, LOAD, rtol=1e-12)


# ---------------------------------------------------------------------- archives
def archive(path: Path, members: dict[str, bytes], packed: int = zipfile.ZIP_DEFLATED) -> Path:
    with zipfile.ZipFile(path, "w", packed) as file:
        for name, content in members.items():
            file.writestr(name, content)
    return path


def test_archives_hold_a_curve_per_table_and_no_more_than_they_say(tmp_path: Path) -> None:
    path = archive(tmp_path / "m.zip", {
        "run/one.txt": ENCODINGS["windows-1252"], "run/two.txt": b"x\n", "run/three.csv": ENCODINGS["utf-16 little"],
        "__MACOSX/one.txt": b"\0", "run/picture.png": b"\x89PNG",
    })  # fmt: skip
    first, second, third = measured.each(path)
    assert [first.where, third.where] == [f'{path}: curve "one"', f'{path}: curve "three"']
    np.testing.assert_allclose(first.P, third.P, rtol=1e-12)
    assert str(second).startswith(f"{path}/two: holds no row of at least 2 numbers")
    assert one(archive(tmp_path / "s.zip", {"s.txt": ENCODINGS["utf-8"]})).where == str(tmp_path / "s.zip")
    # A member of 64 MiB that says it were 1000 bytes.
    path = archive(tmp_path / "m.zip", {"a.txt": bytes(64 << 20)})
    content = path.read_bytes()
    told, size = (64 << 20).to_bytes(4, "little"), (1000).to_bytes(4, "little")
    assert content.count(told) == 2
    path.write_bytes(content.replace(told, size))
    tracemalloc.start()
    with pytest.raises(InputError, match=r"m.zip: a.txt cannot be unpacked \(Bad CRC-32"):
        measured.read(path)
    most = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert most < 4 << 20


WRONG: list[tuple[Callable[[Path], Path], str]] = [
    (
        lambda path: written(path, table(("Height (um)", Z), ("T-B(V)", LOAD))),
        "no force: give --sensitivity and --stiff",
    ),
    (
        lambda path: written(path, table(("Height (um)", Z), ("Deflection_nm", LOAD))),
        "in nm, no force: give --stiffness",
    ),
    (lambda path: written(path, b"PK no", "m.zip"), "cannot be read as a zip archive (File is not a zip file)"),
    (lambda path: path / "none.zip", "zip archive not found"),
    (
        lambda path: archive(path / "m.zip", {"a.txt": b"0" * 2000}, zipfile.ZIP_BZIP2),
        "a.txt cannot be unpacked (neither",
    ),
    (lambda path: written(path, b"delta_m,P_N\n" + b"1," * 10_001 + b"1\n"), "line 2 holds more than 10,000 cells"),
    (lambda path: written(path, (",".join(map(str, range(1500))) + "\n").encode() * 3), "19, 20 and 1,480 more)"),
]


@pytest.mark.parametrize(("make", "said"), WRONG)
def test_mistakes_are_told_in_one_line(tmp_path: Path, make: Callable[[Path], Path], said: str, tuned) -> None:
    tuned("jkrcli.base.process.TEXT", 100_000)
    with pytest.raises(InputError) as caught:
        measured.read(path := make(tmp_path))
    assert str(caught.value).startswith(f"{path}: ")
    assert said in str(caught.value)


def intervals(counts: tuple[int, ...]) -> str:
    """A rheometer's export, a head before each of its intervals."""
    lines, t = ["Project:,Own,,,", ",,,,"], 0.0
    for count, (start, end) in zip(counts, ((1.0, -0.3), (-0.3, -0.3), (-0.3, 1.0)), strict=True):
        lines += [f"Interval and data points:,{count},50,,", "Interval data:,Point No.,Normal Force,Gap,Time", ",,,,",
                  ",,[N],[mm],[s]"]  # fmt: skip
        for i, gap in enumerate(np.linspace(start, end, 50)):
            t += 0.05
            lines.append(f",{i + 1},{0.1 * max(-gap, 0) ** 1.5:.6f},{gap:.5f},{t:.3f}")
        lines.append(",,,,")
    return "\n".join(lines)


def test_heads_of_further_intervals_are_no_rows(tmp_path: Path) -> None:
    curve = one(written(tmp_path, intervals((1, 2, 3))))
    assert len(curve) == 150
    assert curve.depth[0] == pytest.approx(-1e-3)
    assert not any("without a number" in flag for flag in curve.flags)
    with pytest.raises(InputError, match="line 58 must hold 5 numbers"):  # no intervals that are counted
        one(written(tmp_path, intervals((1, 1, 1))))


@pytest.mark.parametrize("head", [
    "# columns: z (um), F (nN)\nz,F", "# columns: z [um] F [nN]\nz,F", "# columns: z_um F_nN\n# z,F",
    "# units: um, nN\nz,F", "# columns: z F\n# units: um nN\nz,F", "# columns: z F\nz (um),F (nN)",
    "# columns: z F\nz,F\n(um),(nN)",
])  # fmt: skip
def test_units_stand_in_a_line_of_comments_above_a_header_without(tmp_path: Path, head: str) -> None:
    path = tmp_path / "curve.csv"
    path.write_text(head + "".join(f"\n{i},{2 * i}" for i in range(9)))
    (curve,) = measured.read(path, Reading())
    np.testing.assert_allclose(curve.depth, 1e-6 * np.arange(9))
    np.testing.assert_allclose(curve.load, 2e-9 * np.arange(9))


# ---------------------------------------------------------------------- columns beside each other
WAY = np.array([0.0, 1.0, 2.0, 3.0, 3.0, 2.0, 1.0, 0.5]) * 1e-3  # m, toward the specimen and back
PULL = np.array([0.0, 0.5, 2.0, 9.0, 8.0, 1.0, -3.0, 0.5])
SIDES = slice(0, 4), slice(4, 8)


def sheet(head: str, *columns: np.ndarray) -> str:
    rows = [";".join(f"{value:.6f}" for value in row).replace(".", ",") for row in zip(*columns, strict=True)]
    return "\n".join([head, *rows]) + "\n"


def pairs() -> list[np.ndarray]:
    return [values for side in SIDES for values in (WAY[side] * 1e3, PULL[side])]


def read_text(tmp_path: Path, text: str, reading: Reading | None = None) -> list[measured.Curve]:
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
    (curve,) = read_text(tmp_path, sheet(HEADS[name], *pairs()))
    assert curve.segment.tolist() == ["approach"] * 4 + ["retract"] * 4
    np.testing.assert_allclose(curve.delta, WAY, rtol=1e-12)
    np.testing.assert_allclose(curve.P, PULL, rtol=1e-12)
    assert "segments of one force curve beside each other, put one under the other: approach, retract" in curve.flags


def test_the_order_of_the_rows_of_a_retraction(tmp_path: Path) -> None:
    z, there, back = WAY[:4] * 1e3, PULL[:4], PULL[4:]
    (curve,) = read_text(tmp_path, sheet("Weg (mm);Kraft hin (N);Kraft zurück (N)", z, there, back))
    np.testing.assert_allclose(curve.delta, np.append(z, z[::-1]) / 1e3, rtol=1e-12)
    np.testing.assert_allclose(curve.P, np.append(there, back[::-1]), rtol=1e-12)
    assert curve.flags[2] == "the rows of the retraction turned: they stand in the order of the position"
    t = np.arange(4.0)
    head = "Zeit hin (s);Weg hin (mm);Kraft hin (N);Zeit zurück (s);Weg zurück (mm);Kraft zurück (N)"
    (curve,) = read_text(tmp_path, sheet(head, t, WAY[:4] * 1e3, PULL[:4], t + 4, WAY[:4] * 1e3, PULL[:4]))
    np.testing.assert_allclose(curve.P, np.tile(PULL[:4], 2), rtol=1e-12)
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
    curves = read_text(tmp_path, sheet(head, WAY * 1e3, PULL, WAY * 2e3, PULL * 3))
    assert [curve.name for curve in curves] == names
    np.testing.assert_allclose(curves[1].delta, 2 * WAY, rtol=1e-12)
    np.testing.assert_allclose(curves[1].P, 3 * PULL, rtol=1e-12)
    assert f"curves beside each other, put one under the other: {', '.join(names)}" in curves[0].flags


def test_curves_and_halves_of_two_directions(tmp_path: Path) -> None:
    # The second pair of directions used to be dropped without a word.
    head = ";".join([HEADS["German"]] * 2)
    curves = read_text(tmp_path, sheet(head, *pairs(), *(2 * column for column in pairs())))
    assert [curve.name for curve in curves] == ["1", "2"]
    for i, curve in enumerate(curves):
        np.testing.assert_allclose(curve.P, PULL * (i + 1), rtol=1e-12)
        assert list(curve.segments()) == ["approach", "retract"]
    text = sheet("Weg hin (mm);Kraft hin (N);Weg zurück (mm)", *pairs()[:3])
    with pytest.raises(
        InputError, match=r'only the approach has a column "Kraft \[N\]": --column delta=1 --column P=2'
    ):
        read_text(tmp_path, text)
    (curve,) = read_text(tmp_path, text, Reading(columns={"delta": "1", "P": "2"}))
    np.testing.assert_allclose(curve.P, PULL[:4], rtol=1e-12)
    assert curve.segment is None
    text = sheet("Weg hin (mm);Kraft hin (N);Weg zurück (mm);Kraft zurück (N);Zeit zurück (s)", *pairs(), WAY[:4])
    with pytest.raises(InputError, match=r'differ, only the retract has a column "Zeit \[s\]": --column delta=1 --col'):
        read_text(tmp_path, text)


@pytest.mark.parametrize("head", ["t1 (s);F1 (N);t2 (s);F2 (N)", "Weg (mm);F1 (N);F2 (N);x"])
def test_what_makes_no_curves_is_questioned(tmp_path: Path, head: str) -> None:
    with pytest.raises(InputError, match=r"--column P=NAME \(columns: 1 "):
        read_text(tmp_path, sheet(head, *pairs()))
