"""Measured curves: the same curve in many guises, conventions, zero points, and whole lines for what is wrong."""

import math
import re
import sys
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from jkrcli.base import hdf5
from jkrcli.base.errors import InputError, installs
from jkrcli.measured import files as measured
from jkrcli.measured.curve import Curve, Reading
from jkrcli.measured.segmentation import segment_force_curve, with_zero_points

MEND = ": correct it, or put # before it"
A = np.array([1.0, 2.0, 3.0, 2.5]) * 1e-5
DELTA = np.array([-5e-7, 1e-6, 3e-6, 2e-6])
P = np.array([-1e-6, 2e-6, 8e-6, 3e-6])
T = np.array([0.0, 0.5, 1.0, 2.0])
WORDS = ("approach", "approach", "retract", "retract")


def rows(*columns: np.ndarray | tuple[str, ...], mark: str = ",", decimal: str = ".") -> str:
    def cell(value: object) -> str:
        return value if isinstance(value, str) else format(value, ".17e").replace(".", decimal)

    return "".join(mark.join(map(cell, row)) + "\n" for row in zip(*columns, strict=True))


GUISES = {
    "names and units of our own": ("t_s,a_m,delta_m,P_N,segment\n" + rows(T, A, DELTA, P, WORDS), Reading()),
    "semicolons, decimal comma, comments, a line of units, byte order mark": (
        "\ufeff# made by a machine\nTime;Radius;Indentation;Force;Phase\nms;µm;nm;uN;-\n"
        + rows(T * 1e3, A * 1e6, DELTA * 1e9, P * 1e6, ("Loading", "extend", "unloading", "Retrace"), mark=";",
               decimal=","),
        Reading(),
    ),
    "tabs, no header: columns and units by flags": (
        rows(P * 1e9, WORDS, DELTA * 1e6, A, T, mark="\t"),
        Reading(columns={"P": "1", "segment": "2", "delta": "3", "a": "4", "t": "5"},
                units={"P": "nN", "delta": "um", "a": "m", "t": "s"}),
    ),
    "blanks, names of another tongue, codes for segments, projected area": (
        "# Zeit (s)  Kraft (mN)  Weg (mm)  Fl (um^2)  Ast\n"
        + rows(T, P * 1e3, DELTA * 1e3, np.pi * A**2 * 1e12, ("0", "0", "1", "1"), mark="  "),
        Reading(columns={"t": "Zeit", "P": "Kraft", "delta": "Weg", "area": "Fl", "segment": "Ast"}),
    ),
    "contact diameter, minus signs of a typesetter": (
        ("time_s,diameter (um),delta_um,P_mN,phase\n" + rows(T, 2 * A * 1e6, DELTA * 1e6, P * 1e3, WORDS))
        .replace(",-", ",\u2212").replace("e-", "e\u2212"),
        Reading(),
    ),
    "signs turned, zero points elsewhere, an instrument that gives way": (
        "t (s),height (um),P (N),a (m),segment\n" + rows(T, -(DELTA + P / 5.0 + 7e-6) * 1e6, -P + 1e-3, A, WORDS),
        Reading(columns={"delta": "height"}, flip=frozenset({"P", "delta"}), zero={"delta": 7e-6, "P": -1e-3},
                stiffness=5.0),
    ),
}  # fmt: skip


@pytest.mark.parametrize("guise", GUISES)
def test_one_curve_in_many_guises(tmp_path: Path, guise: str) -> None:
    text, reading = GUISES[guise]
    path = tmp_path / "m.csv"
    path.write_text(text, encoding="utf-8")
    (curve,) = measured.read(path, reading)
    assert (curve.name, curve.where, curve.measured) == ("m", str(path), ("a", "delta", "P", "t"))
    assert tuple(curve.segment) == WORDS
    for name, expected in (("a", A), ("delta", DELTA), ("P", P), ("t", T)):
        # Zero points of 1 mN under loads of 1 uN cost three digits.
        np.testing.assert_allclose(getattr(curve, name), expected, rtol=5e-13, atol=0)  # 8e-14 measured


def test_columns_of_curves_and_of_an_indenter(tmp_path: Path) -> None:
    path = tmp_path / "map.tsv"
    path.write_text("curve\tdelta_nm\tP_nN\n" + "".join(f"{'cab'[i % 3]}\t{i}\t{10 * i}\n" for i in range(12)))
    curves = measured.read(path)
    assert [curve.name for curve in curves] == ["c", "a", "b"]
    np.testing.assert_allclose(curves[1].P, np.array([10, 40, 70, 100]) * 1e-9, rtol=1e-14)
    assert curves[1].where == f'{path}: curve "a"'
    assert curves[1].segment is None
    path = tmp_path / "m.csv"
    path.write_text("delta_um,P_nN,diameter_mm\n1,1,5\n2,3,5\n3,5,5\n")
    assert measured.read(path)[0].measured == ("delta", "P")


def test_a_bad_curve_does_not_cost_the_others(tmp_path: Path) -> None:
    path = tmp_path / "m.csv"
    table = [f"{name},{i},{i}" for name in ("one", "two", "three") for i in range(4)]
    table[5] = "two,nan,1"
    path.write_text("curve,delta_nm,P_nN\n" + "\n".join([*table, "four,1,1"]) + "\n")
    found = list(measured.each(path))
    assert [item.name for item in found if isinstance(item, Curve)] == ["one", "three"]
    with pytest.raises(InputError) as caught:
        measured.read(path)
    assert list(caught.value.lines) == [str(item) for item in found if isinstance(item, InputError)] == [
        f'{path}: curve "two": line 7: displacement must be finite, got nan (SI)',
        f'{path}: curve "four": holds 1 row (line 14), at least 3 are needed',
    ]  # fmt: skip


@settings(deadline=None, max_examples=40)
@given(
    table=st.lists(st.tuples(*[st.floats(-1e3, 1e3, allow_subnormal=False)] * 3), min_size=3, max_size=8),
    decimal=st.sampled_from([".", ","]),
)
def test_numbers_come_back_to_the_last_bit(
    tmp_path_factory: pytest.TempPathFactory, table: list[tuple[float, ...]], decimal: str
) -> None:
    """With a decimal point by numpy's reader, with a comma by our own: the same numbers."""
    path = tmp_path_factory.mktemp("t") / "m.csv"
    text = "".join(";".join(map(repr, row)) + "\n" for row in table).replace(".", decimal)
    path.write_text("delta_m;P_N;other\n" + text)
    (curve,) = measured.read(path, Reading(separator="semicolon", decimal=decimal))
    assert curve.delta.tolist() == [row[0] for row in table]
    assert curve.P.tolist() == [row[1] for row in table]


# ---------------------------------------------------------------------- what is wrong
GOOD = "delta_nm,P_nN\n1,1\n2,2\n3,3\n"
WRONG = [
    (
        GOOD,
        Reading(columns={"P": "P_n"}),
        'no single column "P_n" for P, did you mean "P"? (columns: 1 "delta_nm", 2 "P',
    ),
    ("x,y\n1,1\n2,2\n3,3\n", Reading(), "are needed, recognised: none; say which columns they are"),
    ("delta_nm,P_nN,P_nN\n1,1,1\n2,2,3\n3,3,3\n", Reading(), "2 columns are recognised as the load: say which"),
    ("delta,P_nN\n1,1\n2,2\n3,3\n", Reading(), '"delta" (displacement) names no unit: give --unit delta=um'),
    ("delta_nm,P (Pa)\n1,1\n2,2\n3,3\n", Reading(), 'the unit must be one of load, such as mN, got "Pa"'),
    (GOOD, Reading(units={"Load": "nN"}), 'no single column "Load" for --unit Load=nN'),
    ("piezo (nm),deflection\n1,1\n2,2\n3,3\n", Reading(stiffness=0.1), 'no unit: give --unit "deflection=nm", or V'),
    ("1 1 1\n2 2 2\n3 3 3\n", Reading(), "(columns: 1, 2, 3); or --format afm"),
    (
        "delta_nm;P_nN;x\n1;1;1\n1;1;1\n2;N/A;1\n2;N/A;1\n3;1;1\n",
        Reading(),
        'line 5 must hold 3 numbers, got "2;N/A;1"',
    ),
    ("delta_nm;P_nN;x\n" + "1;none;1\n" * 3, Reading(), 'holds text, not numbers: line 2 has "none"'),
    (GOOD + "Block 2\n4,4\n", Reading(), 'line 5 must hold 2 numbers, got "Block 2": remove it'),
    (GOOD + "delta_nm,P_nN\n4,4\n", Reading(), 'line 5 must hold 2 numbers, got "delta_nm,P_nN"' + MEND),
    (GOOD, Reading(units={"t": "s"}), "--unit t=s has no column to belong to: give --column t=NAME"),
    (GOOD, Reading(columns={"P": "1"}, units={}), "one column cannot be two quantities, got P = column 1"),
    ("delta_nm,P_nN\n1,1\n2,2\n", Reading(), "holds 2 rows (lines 2, 3), at least 3 are needed"),
    ("delta_nm,P_nN\n", Reading(), "holds no row of at least 2 numbers; give --separator and --decimal"),
    (GOOD + "4,nan\n", Reading(), "line 5: load must be finite, got nan (SI)"),
    (GOOD + "4\n", Reading(), 'line 5 must hold 2 numbers, got "4"' + MEND),
    ("delta_nm,P_nN,segment\n1,1,up\n2,2,up\n3,?,up\n", Reading(), "line 4 must hold 2 numbers and 1 words"),
    ("a_um,P_nN\n1,1\n-2,2\n3,3\n", Reading(), "line 3: contact radius must be finite and >= 0, got -2e-06 (SI)"),
    ("t_s,delta_nm,P_nN\n0,1,1\n2,2,2\n1,3,3\n", Reading(), "time must not run back, it falls from 2 to 1 s"),
    ("a_um,P_nN\n1,1\n2,2\n3,3\n", Reading(flip=frozenset({"delta"})), "holds no delta to flip or to set to zero"),
    ("a_um,delta_nm\n1,1\n2,2\n3,3\n", Reading(stiffness=1.0), "holds no load: the instrument's deflection"),
]


@pytest.mark.parametrize(("text", "reading", "said"), WRONG)
def test_mistakes_are_told_in_one_line(tmp_path: Path, text: str, reading: Reading, said: str) -> None:
    (path := tmp_path / "m.csv").write_text(text)
    with pytest.raises(InputError) as caught:
        measured.read(path, reading)
    assert said in str(caught.value)
    assert all(line.startswith(f"{path}: ") for line in caught.value.lines)


@pytest.mark.parametrize(("columns", "message"), [
    ({"t": T}, "c: holds none of a, delta, P"), ({"P": np.array([1.0, np.inf])}, "c: P[1] is not finite"),
    ({"a": A, "P": P[1:]}, "c: all columns must have the same length, got {'a': 4, 'P': 3}"),
    ({"a": A[None]}, "c: a: must be one-dimensional, got shape (1, 4)"),
])  # fmt: skip
def test_a_curve_is_checked_when_it_is_made(columns: dict[str, np.ndarray], message: str) -> None:
    with pytest.raises(InputError) as caught:
        Curve("c", **columns)
    assert str(caught.value) == message


# ---------------------------------------------------------------------- zero points
def recorded(noise: float = 0.0, seed: int = 0) -> Curve:
    """An approach with a jump into contact of -3 nN at 5.0 um, stiffening to 40 nN at 6 um, and back."""
    z = np.linspace(0, 6e-6, 1201)
    depth = np.maximum(z - 5e-6, 0)
    load = np.where(depth > 0, -3e-9 + 4.3e-8 * (depth / 1e-6) ** 1.5, 0.0)
    drift = 2e-9 + 1e-3 * z
    P = load + drift + np.random.default_rng(seed).normal(0, noise, z.size) if noise else load + drift
    return Curve("c", delta=np.append(z, z[::-1]), P=np.append(P, P[::-1]))


@pytest.mark.parametrize("noise", [0.0, 2e-10])
def test_baseline_tilt_and_first_touch_are_found(noise: float) -> None:
    raw = recorded(noise)
    found = with_zero_points(raw)
    # Steps are 5 nm wide: half of one where noise is below the jump.
    np.testing.assert_allclose(raw.delta - found.delta, 5e-6, atol=2.6e-9)  # m
    # The line's error at its far end, of 1000 rows of noise: 2 sigma/sqrt(1000)
    np.testing.assert_allclose(found.P.max(), 4e-8, atol=4 * noise + 1e-15)  # N
    assert found.flags[0].startswith("contact point and force offset estimated from 99")
    tilt = float(found.flags[0].removesuffix(" N/m").rsplit(" ", 1)[1])
    np.testing.assert_allclose(tilt, 1e-3, atol=3 * noise / 1.4e-6 / 1000**0.5)  # N/m: 3 sigma, z spreads by 1.4 um


def test_zero_points_need_a_free_approach() -> None:
    raw = recorded()
    for curve, said in (
        (Curve("c", P=raw.P), "a force curve needs displacement and load, the file has P"),
        (raw.rows(slice(0, 900)), "the load of the approach never leaves its baseline: no contact was made"),
        (raw.rows(slice(990, 1400)), "the approach has no free part to estimate contact point"),
        (raw.rows(slice(1201, None)), "has no approach: contact point and force offset cannot be estimated"),
        (replace(raw.rows(slice(0, 1201)), segment=np.full(1201, "up")), r"has no approach \(segments: up\)"),
    ):
        with pytest.raises(InputError, match=f"^c: {said}"):
            with_zero_points(curve)
    both = with_zero_points(replace(raw, segment=np.full(len(raw), "up")))  # what turns back holds both directions
    assert both.flags == with_zero_points(raw).flags


# ---------------------------------------------------------------------- files of force microscopes through afmformats
HEIGHT = np.array([9.0, 5.0, 1.0, 3.0, 8.0]) * 1e-6  # grows away from the specimen
FORCE = np.array([0.0, 1.0, 40.0, 10.0, -3.0]) * 1e-9
K = 0.04
CONTENT = {"force": FORCE, "height (measured)": HEIGHT, "time": np.arange(5.0), "segment": np.repeat([0, 1], [3, 2])}


def data(index: int = 0, columns: dict[str, np.ndarray] | None = None, **meta: Any) -> Any:
    afmformats = pytest.importorskip("afmformats")
    metadata = {"imaging mode": "force-distance", "path": "x.h5", "enum": index, "point count": 5} | {
        key.replace("_", " "): value for key, value in meta.items()
    }
    return afmformats.AFMForceDistance(columns or CONTENT, metadata)


def written(path: Path, *sets: Any) -> Path:
    with h5py.File(path, "w") as file:
        for one in sets:
            one.export_data(file, fmt="hdf5")
    return path


def test_indentation_is_minus_height_minus_deflection(tmp_path: Path) -> None:
    path = tmp_path / "one.tab"
    data(spring_constant=K).export_data(path)
    (curve,) = measured.read(path)
    assert curve.where == str(path)
    assert curve.measured == ("delta", "P", "t")
    assert curve.segment.tolist() == ["approach"] * 3 + ["retract"] * 2
    assert curve.flags == ("displacement from the height (measured)",)
    np.testing.assert_allclose(curve.P, FORCE, rtol=1e-14)  # the file holds eight digits, these numbers have two
    np.testing.assert_allclose(curve.delta, -HEIGHT - FORCE / K, rtol=1e-14)
    columns = CONTENT | {"tip position": HEIGHT * 0.9}
    (curve,) = measured.read(written(tmp_path / "m.h5", data(columns=columns)))
    np.testing.assert_allclose(curve.delta, -HEIGHT * 0.9, rtol=1e-14)


@pytest.fixture
def columns_read(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """The names of the columns whose values are read from HDF5 files, in their order."""
    loaded: list[str] = []
    whole, name = hdf5.values_of, h5py.h5i.get_name
    monkeypatch.setattr(hdf5, "values_of", lambda data, *of: loaded.append(name(data).decode()) or whole(data, *of))
    return loaded


def test_curves_of_a_map_are_read_one_by_one(tmp_path: Path, columns_read: list[str]) -> None:
    path = written(tmp_path / "map.h5", *(data(i, spring_constant=K) for i in range(12)))
    curves = measured.each(path, Reading(zero={"delta": -5e-6}))
    first = next(curves)
    assert sorted(columns_read) == [f"/0/{name}" for name in sorted(CONTENT)]  # each once
    names = [first.name, *(item.name for item in curves if isinstance(item, Curve))]
    assert names == [str(i) for i in range(12)]  # in the order of their numbers, not of their texts
    np.testing.assert_allclose(first.delta, 5e-6 - HEIGHT - FORCE / K, rtol=1e-14)
    # Others are not read, and what is wrong with them is not said; their names are known.
    lame = CONTENT | {"force": np.append(FORCE[:4], np.nan), "height (piezo)": HEIGHT}
    columns_read.clear()
    path = written(
        tmp_path / "lame.h5", data(0, lame, spring_constant=K), *(data(i, spring_constant=K) for i in (1, 2))
    )
    assert [type(one) for one in measured.each(path, Reading(where={"curve": "2"}))] == [Curve]
    assert {name.split("/")[1] for name in columns_read} == {"2"}
    with pytest.raises(InputError, match=r'holds no curve "20".*0, 1, 2'):
        list(measured.each(path, Reading(where={"curve": "20"})))
    measured.read(written(tmp_path / "m.h5", data(columns=CONTENT | {"height (piezo)": HEIGHT}, spring_constant=K)))
    assert not [name for name in columns_read if "piezo" in name]


def test_what_is_wrong_with_one_curve_costs_no_other(tmp_path: Path) -> None:
    path = written(tmp_path / "map.h5", *(data(i, spring_constant=K) for i in range(3)))
    with h5py.File(path) as file:
        place = file["1/force"].id.get_chunk_info(0)
    content = bytearray(path.read_bytes())
    content[place.byte_offset + place.size // 2] ^= 0xFF
    path.write_bytes(content)
    first, second, third = measured.each(path)
    assert [type(first), type(third)] == [Curve] * 2
    assert str(second).startswith(f'{path}: curve "1": ')
    path = written(tmp_path / "map.h5", *(data(i, spring_constant=K) for i in range(2)))
    with h5py.File(path, "a") as file:
        del file["1"]
        file["1"] = h5py.SoftLink("/0")
    first, second = measured.each(path)
    assert isinstance(first, Curve)
    assert 'curve "1"' in str(second) or '"1" is a link' in str(second)
    lame = CONTENT | {"force": np.append(FORCE[:4], np.nan)}
    path = written(tmp_path / "lame.h5", data(0, spring_constant=K), data(1, lame, spring_constant=K), data(2))
    found = list(measured.each(path))
    assert [str(item) for item in found[1:]] == [
        f'{path}: curve "1": row 5 of its force is not finite',
        f'{path}: curve "2": names no spring constant: give --stiffness',
    ]
    (_, _, last) = measured.each(path, Reading(stiffness=K))
    np.testing.assert_allclose(last.delta, -HEIGHT - FORCE / K, rtol=1e-14)


WRONG_FILES: dict[str, tuple[Callable[[Path], Path], Reading, str]] = {
    "another spring constant than the file's": (
        lambda path: written(path / "m.h5", data(spring_constant=K)), Reading(stiffness=0.05),
        "names a spring constant of 0.04 N/m, with which its loads were computed: leave out --stiffness 0.05"),
    "no stiffness at all": (lambda path: written(path / "m.h5", data(spring_constant=0.0)), Reading(),
                            "names no spring constant: give --stiffness"),
    "a lever that does not bend": (lambda path: written(path / "m.h5", data()), Reading(stiffness=math.inf),
                                   "whose cantilever bends: give its stiffness, not rigid"),
    "columns of a file that knows its own": (
        lambda path: written(path / "m.h5", data(spring_constant=K)), Reading(columns={"P": "force"}),
        "are known: leave out --column and --unit, or read it as text"),
    "no height": (
        lambda path: written(path / "m.h5", data(columns={"force": FORCE, "time": np.arange(5.0)}, spring_constant=K)),
        Reading(), "holds no height or no force (columns: force, time)"),
    "not there": (lambda path: path / "none.jpk-force", Reading(), "file of force curves not found"),
}  # fmt: skip


@pytest.mark.parametrize("mistake", WRONG_FILES)
def test_mistakes_of_files_are_told_in_one_line(tmp_path: Path, mistake: str) -> None:
    pytest.importorskip("afmformats")
    make, reading, said = WRONG_FILES[mistake]
    with pytest.raises(InputError) as caught:
        measured.read(path := make(tmp_path), reading)
    assert str(caught.value).startswith(f"{path}: ")
    assert said in str(caught.value)


JUNK = {
    ".jpk-force": "cannot be read as a zip archive (File is not a zip file)",
    ".ibw": "is no binary wave of version 5, or cut off: export it again",
    ".h5": "the HDF5 file is damaged and cannot be read; export it again",
    ".tab": "is no file of force curves that afmformats reads (",
}


@pytest.mark.parametrize("ending", JUNK)
def test_what_is_no_such_file_is_refused_quietly(tmp_path: Path, ending: str, capfd) -> None:
    pytest.importorskip("afmformats")
    path = tmp_path / f"junk{ending}"
    path.write_bytes(b"\x89HDF\r\n\x1a\n no file of force curves \x00\x01")
    with pytest.raises(InputError) as caught:
        measured.read(path)
    assert caught.value.lines[0].startswith(f"{path}: {JUNK[ending]}")
    assert capfd.readouterr().err == ""


def test_without_the_package_one_line_says_how_to_get_it(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "afmformats", None)
    with pytest.raises(InputError, match=f"needs the optional package afmformats: {re.escape(installs('afm'))}"):
        measured.read(tmp_path / "m.jpk-force")


def test_a_table_of_names_is_not_taken_for_three_columns_without(tmp_path: Path) -> None:
    """afmformats' reader of NT-MDT's exports takes any three columns of numbers in a .txt: it made four directions of
    two, with loads of 1e-28 N."""
    pytest.importorskip("afmformats")
    rows = "".join(f"{1e-5 - i * 1e-9:.4e} {i * 1e-11:.3e} {i * 1e-3:.3f}\n" for i in range(50))
    path = tmp_path / "probe.txt"
    path.write_text("# segment: extend\n# columns: way1 vDeflection time\n# units: m N s\n" + rows)
    said = r'are needed, recognised: P = column 2 "vDeflection \[N\]", t = column 3 .* \(columns: 1 "way1 \[m\]", 2 '
    with pytest.raises(InputError, match=said):
        measured.read(path)


def test_creep_and_relaxation_are_read_by_their_motion(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """JPK numbers their waits as a segment between the directions: 1 was a retraction, and they were refused."""
    afmformats = pytest.importorskip("afmformats")
    z = np.concatenate([np.linspace(1e-6, 0.0, 30), np.full(40, 0.0), np.linspace(0.0, 1e-6, 30)])
    columns = {"force": np.maximum(2e-7 - z, 0.0) * 1e-3, "height (measured)": z, "time": np.arange(100.0),
               "segment": np.repeat([0, 1, 2], [30, 40, 30])}  # fmt: skip
    for modality in ("creep-compliance", "stress-relaxation"):
        kind = afmformats.AFMCreepCompliance if modality.startswith("creep") else afmformats.AFMStressRelaxation
        made = kind(columns, {"imaging mode": modality, "path": "x.h5", "enum": 0, "point count": 100,
                              "spring constant": K})  # fmt: skip
        path = tmp_path / f"{modality}.tab"
        data(spring_constant=K).export_data(path)
        held = [made]
        monkeypatch.setattr(afmformats, "load_data", lambda path, modality=None, held=held, **_: (
            held if modality in (None, held[0].modality) else []))  # fmt: skip
        (curve,) = measured.read(path)
        assert curve.segment is None
        assert curve.t is not None
        assert [part.kind for part in segment_force_curve(curve).segments] == ["approach", "dwell", "retract"]
