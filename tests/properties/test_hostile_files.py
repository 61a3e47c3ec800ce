"""Files of others, damaged or made to do harm: the same numbers as the sound ones or one line, soon and in little
memory. The fast tests try some of each kind, the slow ones thousands."""

import contextlib
import random
import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest
import vendors
from conftest import Outcome
from fuzzing import address_space, bounded, outcome
from hostile import harm_hdf5, harm_jpk, harm_zip
from series_files import edit

from jkrcli.base import hdf5
from jkrcli.base.errors import InputError
from jkrcli.base.files import SHORTEST, beside
from jkrcli.base.process import LINE_ENDS
from jkrcli.measured import files as measured
from jkrcli.measured.afm_formats import estimate_rows
from jkrcli.measured.curve import Curve, Reading
from jkrcli.report import archive

Run = Callable[..., Outcome]
SECONDS = 10.0  # of CPU time for any one file
TABLE = b"delta_m,P_N\n" + b"".join(b"%de-9,%de-9\n" % (i, i * i) for i in range(1, 30))


@pytest.fixture(name="afm")
def _afm() -> None:
    pytest.importorskip("afmformats")


def jpk(path: Path, change: Callable[[dict[str, bytes]], object], curves: int = 0) -> Path:
    members = vendors.jpk_members(curves)
    change(members)
    return vendors.zipped(path, members)


def without(part: str) -> Callable[[dict[str, bytes]], None]:
    def change(members: dict[str, bytes]) -> None:
        for name in [name for name in members if part in name]:
            del members[name]

    return change


def replaced(old: str, new: str) -> Callable[[dict[str, bytes]], None]:
    def change(members: dict[str, bytes]) -> None:
        members |= {name: content.replace(old.encode(), new.encode()) for name, content in members.items()}

    return change


def with_grid(members: dict[str, bytes]) -> None:
    members["header.properties"] += b"force-scan-map.position-pattern.grid.ilength=1000000000000\n"


JPK = {
    "no deflection": (without("vDeflection"), "No data found for: ['vDeflection']"),
    "no shared data": (without("shared-data"), "Could not find property: 'vDeflection multiplier"),
    "points": (replaced("num-points=40", "num-points=41"), "segment 0: is damaged or cut off: holds 40 points of 41"),
    "many points": (replaced("num-points=40", "num-points=900000000000"), "holds 40 points of 900,000,000,000"),
    "a circle": (replaced("distance.base-calibration-slot=volts", "distance.base-calibration-slot=force"),
                 "is damaged: its scale channel.vDeflection.conversion-set.conversion.distance is based on itself"),
    "pixels": (with_grid, "takes 4,000,000,000,000,000 bytes or more to read, at most 1,073,741,824 are read"),
}  # fmt: skip


@pytest.mark.usefixtures("afm")
@pytest.mark.parametrize("name", JPK)
def test_a_jpk_file_that_lacks_or_invents_something_is_refused_in_one_line(jkr: Run, name: str) -> None:
    """Tracebacks, a terabyte of memory, a loop without end."""
    change, words = JPK[name]
    jpk(Path("x.jpk-force"), change)
    with address_space(), bounded(SECONDS):
        jkr("look", "x.jpk-force", "--no-plots").refused(words)


@pytest.mark.usefixtures("afm")
def test_a_jpk_file_of_measured_heights_alone_is_read(tmp_path: Path) -> None:
    """The height of the piezo, which nobody asked for, was missed in a traceback."""
    whole = jpk(tmp_path / "whole.jpk-force", lambda members: None)
    (curve,), (lame,) = (measured.read(path) for path in (whole, jpk(tmp_path / "x.jpk-force", without("/height.dat"))))
    assert np.array_equal(curve.delta, lame.delta)


@pytest.mark.usefixtures("afm")
@pytest.mark.parametrize("part", [b"measuredHeight.dat", b"segments/0/channels/PK"])
def test_a_bit_of_a_jpk_file_is_found_before_another_channel_is_taken_for_the_damaged_one(jkr, part) -> None:
    content = bytearray(jpk(Path("x.jpk-force"), lambda members: None).read_bytes())
    at = content.find(part) + len(part) + 4 if part.endswith(b".dat") else content.rfind(b"segments/0/channels/PK")
    content[at] ^= 1
    Path("x.jpk-force").write_bytes(content)
    jkr("look", "x.jpk-force", "--no-plots").refused("cannot be unpacked (")


@pytest.mark.usefixtures("afm")
def test_a_member_lost_from_the_list_is_missed(jkr: Run) -> None:
    """As the comment of the one before it: the height of the piezo was taken for the measured one."""
    content = bytearray(jpk(Path("x.jpk-force"), lambda members: None).read_bytes())
    at = content.rfind(b"PK\1\2", 0, content.rfind(b"PK\1\2"))
    content[at + 33] ^= 0x80
    Path("x.jpk-force").write_bytes(content)
    jkr("look", "x.jpk-force", "--no-plots").refused("is damaged: its list holds 15 members of 16")


@pytest.mark.usefixtures("afm")
@pytest.mark.parametrize("ending", ["jpk-force", "zip"])
def test_what_unpacks_to_much_is_refused_before_it_is_unpacked(jkr: Run, tuned, ending: str) -> None:
    """7 MB of a JPK file became 6 GB."""
    tuned("jkrcli.base.process.SIZE", 1 << 20)
    tuned("jkrcli.base.process.TEXT", 1 << 20)
    vendors.zipped(Path(f"x.{ending}"), vendors.jpk_members() | {"more.csv": bytes(2 << 20)})
    assert Path(f"x.{ending}").stat().st_size < 1 << 15
    jkr("look", f"x.{ending}", "--no-plots").refused(" bytes or more to read, at most 1,048,576 are read of one file")


@pytest.mark.usefixtures("afm")
def test_what_igor_declares_is_compared_with_what_is_there(jkr: Run) -> None:
    whole = vendors.ibw(Path("x.ibw")).read_bytes()
    Path("x.ibw").write_bytes(whole[:-1])
    jkr("look", "x.ibw", "--no-plots").refused(f"is cut off: holds {len(whole) - 1:,} bytes of {len(whole):,}")
    Path("x.ibw").write_bytes(whole[:80] + b"\1" + whole[81:])
    jkr("look", "x.ibw", "--no-plots").refused("the checksum of its header is wrong")


@pytest.mark.usefixtures("afm")
@pytest.mark.parametrize(("cut", "words"), [
    (lambda lines: [*lines[:-1], lines[-1][:-1]], "its last line does not end"),
    (lambda lines: [*lines[:-1], lines[-1][:8] + b"\r\n"], "cells, not 5 as the first"),
    (lambda lines: lines[:-1], "is damaged or cut off: holds 79 points of 80"),
], ids=["letter", "cells", "row"])  # fmt: skip
def test_a_cut_export_is_refused(jkr: Run, cut: Callable[[list[bytes]], list[bytes]], words: str) -> None:
    lines = vendors.exported(Path("x.tab")).read_bytes().splitlines(keepends=True)
    Path("x.tab").write_bytes(b"".join(cut(lines)))
    jkr("look", "x.tab", "--no-plots").refused(words)


@pytest.mark.usefixtures("afm")
def test_a_file_that_was_replaced_is_read_anew(tmp_path: Path) -> None:
    """An archive was kept open under its name: the old numbers, without a word."""
    path = tmp_path / "x.jpk-force"
    (old,) = measured.read(jpk(path, lambda members: None))
    path.unlink()
    (new,) = measured.read(jpk(path, replaced(f"multiplier={vendors.K}", "multiplier=0.5")))
    np.testing.assert_allclose(new.P, 10 * old.P)


TAKEN_AS = {
    "workshop": Reading(format="afm"),
    "workshop map": Reading(format="afm"),
    "ntmdt": Reading(format="afm", stiffness=vendors.K, sensitivity=vendors.SENSITIVITY),
    "chiaro": Reading(format="afm"),
}
CHECKED = ("jpk", "jpk map", "workshop map")  # checksums over all that counts
# where every cut is seen
DECLARED = (*CHECKED, "ibw", "tab", "hdf5", "nanoscope", "nanoscope map", "nanoscope capture")


def numbers(path: Path, reading: Reading) -> list[Any]:
    """All that was read of each curve; None for one that was refused."""
    found = [curve if isinstance(curve, Curve) else None for curve in measured.each(path, reading)]
    return [curve and (curve.delta.tobytes(), curve.P.tobytes(), curve.t is None or curve.t.tobytes(),
                       str(curve.segment), curve.stiffness, curve.pixel) for curve in found]  # fmt: skip


@pytest.mark.usefixtures("afm")
@pytest.mark.parametrize("trials", [12, pytest.param(1000, marks=pytest.mark.slow)])
@pytest.mark.parametrize("kind", vendors.KINDS)
def test_damaged_files_of_microscopes(tmp_path: Path, kind: str, trials: int, seed: int) -> None:
    """Bits and cuts: with checksums the same numbers or a refusal, else no traceback; cuts are seen where they can."""
    path, reading, chance = vendors.KINDS[kind](tmp_path), TAKEN_AS.get(kind, Reading()), random.Random(seed)
    whole, sound = path.read_bytes(), numbers(path, reading)
    assert None not in sound
    found = {"same": 0, "refused": 0, "different": 0}
    for trial in range(trials):
        content, is_cut = bytearray(whole), trial % 4 == 3
        content[chance.randrange(len(content))] ^= 1 << chance.randrange(8)
        damaged = tmp_path / f"{trial}{''.join(path.suffixes)}"
        damaged.write_bytes(whole[: chance.randrange(1, len(whole))] if is_cut else content)
        held: list[Any] = [None]
        with bounded(SECONDS), address_space(), contextlib.suppress(InputError):
            held = numbers(damaged, reading)
        damaged.unlink()
        what = "refused" if None in held else "same" if held == sound else "different"
        found[what] += 1
        assert what == "refused" or not is_cut or kind not in DECLARED, trial
        assert what != "different" or kind not in CHECKED, trial
    print(kind, found)
    assert found["refused"]


def bomb(file: h5py.File) -> None:
    for i in range(3):
        file.create_dataset(f"zz/{i}", (10**6,), "f8", chunks=(10**5,))


def virtual(file: h5py.File) -> None:
    layout = h5py.VirtualLayout(shape=(3,), dtype="f8")
    layout[:] = h5py.VirtualSource("elsewhere.h5", "x", shape=(3,))
    file.create_virtual_dataset("zz", layout)


def doubled(file: h5py.File) -> None:
    above = file.create_group("zz")
    for name in "abc":
        above[name] = file["series"]


BYTES, NEITHER = "bytes or more to read, at most", '"zz" holds neither numbers nor texts of fixed length'
HDF5: dict[str, tuple[Callable[[h5py.File], object], str]] = {
    "data sets": (bomb, BYTES),
    "hard links": (doubled, '"zz/a" is a link, not data of this file'),
    "a list": (lambda file: file.create_dataset("zz", (1,), h5py.vlen_dtype("i4")), NEITHER),
    "soft link": (lambda file: file.__setitem__("zz", h5py.SoftLink("/series")), '"zz" is a link'),
    "external link": (lambda file: file.__setitem__("zz", h5py.ExternalLink("/etc/passwd", "/")), '"zz" is a link'),
    "external data": (
        lambda file: file.create_dataset("zz", (9,), "i1", external=[("/etc/passwd", 0, 9)]),
        '"zz" lies in another file',
    ),
    "virtual data": (virtual, '"zz" lies in another file'),
    "one text": (lambda file: file.create_dataset("zz", (), "S1000000000"), BYTES),
    "texts": (lambda file: file.create_dataset("zz", (1 + 10**7,), "S1", chunks=(10**6,)), BYTES),
    "free texts": (lambda file: file.create_dataset("zz", (10**8,), h5py.string_dtype(), chunks=(10**6,)), NEITHER),
    "chunks": (lambda file: file.create_dataset("zz", (10**7,), "i1", chunks=(1,)), BYTES),
    "a chunk": (lambda file: file.create_dataset("zz", (1,), "f8", chunks=(10**8,), maxshape=(None,)), BYTES),
}


@pytest.mark.parametrize("name", HDF5)
def test_a_small_hdf5_file_that_becomes_large_is_refused_soon(jkr: Run, series: Path, tuned, name: str) -> None:
    """No end, or all memory, and then it was called damaged."""
    tuned("jkrcli.base.process.SIZE", 1 << 24)
    change, words = HDF5[name]
    edit(series, change)
    with bounded(SECONDS), address_space():
        jkr("show", series).refused(words)


def test_every_verb_refuses_it(jkr: Run, series: Path, tuned) -> None:
    Path("x.h5").write_bytes(series.read_bytes())
    edit(Path("x.h5"), bomb)
    Path("m.csv").write_bytes(TABLE)
    tuned("jkrcli.base.process.SIZE", 1 << 24)
    for words in (
        ("transform", "x.h5"), ("fit", "s.h5", "x.h5"), ("import", "x.h5", "--case", "s.toml"), ("look", "x.h5"),
        ("compare", "x.h5", "s.h5"), ("explore", "x.h5"), ("work", "x.h5", "m.csv"),
    ):  # fmt: skip
        done = jkr(*words)
        assert (done.code, done.err.count("\n"), "damaged" in done.err) == (2, 1, False), done.err


def test_a_free_text_is_refused_before_the_library_reads_it(jkr: Run, series: Path) -> None:
    """Damage to the heaps in which such texts lie ends the process, or never ends."""
    with h5py.File(series, "r+") as file:
        file.attrs["zz"] = "x"
    jkr("show", series).refused('"zz" holds neither numbers nor texts of fixed length')


def test_what_takes_more_memory_than_is_free_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, tuned) -> None:
    with h5py.File(tmp_path / "x.h5", "w") as file:
        file.create_dataset("zz", (10**7,), "f8", chunks=(10**6,))
    (tmp_path / "x.csv").write_bytes(b"1,2\n" * 100_000)
    tuned("jkrcli.base.process.LITTLE", 1 << 20)
    monkeypatch.setattr("jkrcli.base.process.free_memory", lambda: 10.0)
    words = r"takes 0\.0\d+ GiB of memory or more to read, 0\.0078 GiB may be taken: split"
    with pytest.raises(InputError, match=words):
        hdf5.tree_of(tmp_path / "x.h5", (tmp_path / "x.h5").read_bytes())
    with pytest.raises(InputError, match=words):
        measured.read(tmp_path / "x.csv")


def series_of(*columns: Any) -> hdf5.Group:
    return hdf5.Group({}, {f"c{i}": hdf5.Dataset(column) for i, column in enumerate(columns)})


def fits_of(summary: str) -> dict[str, hdf5.Group]:
    return {"curves": hdf5.Group({}, {"000000": hdf5.Group({"summary": summary})})}


WRONG: dict[str, tuple[dict[str, Any], dict[str, hdf5.Group]]] = {
    "no release": ({"format": archive.SWEEP_TABLE, "version": 2}, {"table": series_of(np.ones(3))}),
    "first format, no release": ({"format": archive.FITS, "version": 1, "body": "x"}, fits_of("{}")),
    "an empty fit": ({"format": archive.FITS, "version": 2, "body": "x", "jkr": "1"}, fits_of("{}")),
    "a fit that is none": ({"format": archive.FITS, "version": 2, "body": "x", "jkr": "1"}, fits_of("[1]")),
    "complex numbers": ({"format": archive.SWEEP_TABLE, "version": 2, "jkr": "1"},
                        {"table": series_of(np.ones(3, dtype=complex))}),
    "a list of releases": ({"format": archive.SWEEP_TABLE, "version": 2, "jkr": np.arange(3)},
                           {"table": series_of(np.ones(3))}),
    "a list of versions": ({"format": archive.FITS, "version": np.array([2, 2]), "body": "x", "jkr": "1"}, {}),
}  # fmt: skip


@pytest.mark.parametrize("name", WRONG)
def test_an_archive_that_does_not_hold_what_it_says_is_refused(jkr: Run, name: str) -> None:
    attributes, members = WRONG[name]
    Path("x.h5").write_bytes(hdf5.image(hdf5.Group(attributes, members)))
    for as_json in ((), ("--json",)):
        done = jkr("show", "x.h5", *as_json)
        assert (done.code, done.err.count("jkr: error: x.h5: "), done.err.count("\n") < 3) == (2, 1, True), done.err


@pytest.mark.parametrize("part", ["series", "errors", "facts", "timings_s", "versions", "warnings", "case"])
def test_a_series_of_the_first_format_without_one_of_its_parts(jkr: Run, series: Path, part: str) -> None:
    def older(file: h5py.File) -> None:
        del file[part]
        file.attrs["version"] = 1

    edit(series, older)
    done = jkr("show", series)
    assert done.code == (2 if part in ("series", "errors", "case") else 0), done.err
    assert all(line.startswith("jkr: ") for line in done.err.splitlines())


@pytest.mark.parametrize("end", ["\n", "\r\n", LINE_ENDS[-1]], ids=ascii)
def test_more_rows_than_are_read_are_counted_before_they_are_taken_apart(tmp_path: Path, tuned, end: str) -> None:
    tuned("jkrcli.base.process.ROWS", 1000)
    (tmp_path / "x.csv").write_bytes(f"1,2{end}".encode() * 1001)
    with pytest.raises(InputError, match=r"x\.csv: holds 1,001 rows or more, at most 1,000 are read of one file"):
        measured.read(tmp_path / "x.csv")


def test_more_members_than_are_read_are_counted_before_they_are_listed(tmp_path: Path, tuned) -> None:
    tuned("jkrcli.base.process.SIZE", 400_000)
    vendors.zipped(tmp_path / "x.zip", {f"{i}.csv": TABLE for i in range(101)})
    with pytest.raises(InputError, match=r"x\.zip: takes 404,000 bytes or more to read, at most 400,000 are read"):
        measured.read(tmp_path / "x.zip")


def test_an_archive_of_very_many_members_is_read(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(zipfile, "ZIP_FILECOUNT_LIMIT", 1)
    path = vendors.zipped(tmp_path / "x.zip", {"a.csv": TABLE, "b.csv": TABLE})
    assert path.read_bytes().count(b"PK\6\6") == 1
    assert len(measured.read(path)) == 2


def test_names_that_others_gave_become_different_names_of_files(tmp_path: Path) -> None:
    names = ["a" * 300, "a" * 299 + "b", "x y", "x/y", "X?y", "x", "\udcff", ".."]
    for stem in ("s", "s" * 230):
        found = beside(tmp_path / stem, names)
        assert len({path.name.lower() for path in found}) == len(names)
        for path in found:
            path.with_name(path.name + ".svg").touch()
    assert [path.name for path in beside(tmp_path / "s", ["x", "gel 1"])] == ["s-x", "s-gel-1"]


def test_a_body_whose_name_leaves_no_room_for_its_pictures_is_refused_before_work(jkr, series, monkeypatch) -> None:
    monkeypatch.setattr("jkrcli.measured.fits.fitted_body", lambda *_: pytest.fail("work was begun"))
    Path("m.csv").write_bytes(TABLE)
    body = series.rename("b" * (255 - len("-fit-.png") - SHORTEST + 1) + ".h5")
    jkr("fit", body, "m.csv").refused("cannot be written (File name too long)")


FIT = '{"file": "m.csv", "curve": "m", "status": "fitted", "estimates": {"w": {"value": 0.05, "unit": "J/m^2"}}}'
HARM = {"h5": harm_hdf5, "zip": harm_zip, "jpk-force": harm_jpk}


@pytest.mark.usefixtures("afm")
@pytest.mark.parametrize("trials", [15, pytest.param(3_400, marks=pytest.mark.slow)])
@pytest.mark.parametrize("ending", HARM)
def test_hostile_files(series: Path, ending: str, trials: int, seed: int) -> None:
    """Ten seconds and a gigabyte for each, on top of what the tests take; the slow ones are ten thousand together."""
    chance, told = random.Random(f"{ending} {seed}"), {"format": archive.FITS, "version": 2, "body": "x", "jkr": "1"}
    sound = [
        series.read_bytes(),
        hdf5.image(hdf5.Group(told, fits_of(FIT))),
        vendors.exported(Path("e.h5")).read_bytes(),
    ]
    for trial in range(trials):
        path = Path(f"{trial}.{ending}")
        path.write_bytes(chance.choice(sound))
        HARM[ending](path, chance)
        with bounded(SECONDS), address_space():
            if ending == "h5" and outcome("show", path, "--json", json_out=True) == 0:
                outcome("transform", path, "--w", "0.05", "--no-plots", "--force", "--json", json_out=True)
            estimate_rows(path)
            with contextlib.suppress(InputError):
                for _ in measured.each(path, Reading(incomplete=True)):
                    pass
        path.unlink()
