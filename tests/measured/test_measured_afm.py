"""Files of force microscopes through the optional package afmformats: real files, written and read back."""

import math
import re
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest

from jkrcli.base import hdf5
from jkrcli.base.errors import InputError, installs
from jkrcli.measured import files as measured
from jkrcli.measured.curve import Curve, Reading
from jkrcli.measured.segmentation import segment_force_curve

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


def test_one_bad_curve_of_a_map_is_told_and_the_others_follow(tmp_path: Path) -> None:
    lame = CONTENT | {"force": np.append(FORCE[:4], np.nan)}
    path = written(tmp_path / "map.h5", data(0, spring_constant=K), data(1, lame, spring_constant=K), data(2))
    found = list(measured.each(path))
    assert [str(item) for item in found[1:]] == [
        f'{path}: curve "1": row 5 of its force is not finite',
        f'{path}: curve "2": names no spring constant: give --stiffness',
    ]
    (_, _, last) = measured.each(path, Reading(stiffness=K))
    np.testing.assert_allclose(last.delta, -HEIGHT - FORCE / K, rtol=1e-14)


WRONG: dict[str, tuple[Callable[[Path], Path], Reading, str]] = {
    "another spring constant than the file's": (
        lambda path: written(path / "m.h5", data(spring_constant=K)), Reading(stiffness=0.05),
        "names a spring constant of 0.04 N/m, with which its loads were computed: leave out --stiffness 0.05"),
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


@pytest.mark.parametrize("mistake", WRONG)
def test_mistakes_are_told_in_one_line(tmp_path: Path, mistake: str) -> None:
    pytest.importorskip("afmformats")
    make, reading, said = WRONG[mistake]
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
