"""Archives and HDF5 files made to harm those who read them, from a source of chance each."""

import contextlib
import random
import struct
import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import h5py
import numpy as np
from fuzzing import bytes_changed
from series_files import edit
from vendors import jpk_members, zipped

HUGE = (10**6, 3 * 10**7, 9 * 10**7, 10**9, 10**12)  # values in a data set that a few bytes declare
NAMES = ("series", "curves", "0", "x" * 300, "\x1b[31m", "é", "a/b", "..", " ", "table", "sha256", "\u202e")
TYPES = ("f8", "f4", "i1", "i8", "c16", "S1", "S9", "S100000", "b", [("a", "f8"), ("b", "S3")])


def harm_hdf5(path: Path, chance: random.Random) -> None:
    """Make one to three changes to the HDF5 file at ``path``, now and then sealed again, and to its bytes."""

    def change(file: h5py.File) -> None:
        for _ in range(chance.choice((1, 1, 2, 3))):
            with contextlib.suppress(
                ValueError, TypeError, RuntimeError, OSError, LookupError, ArithmeticError, AttributeError
            ):
                chance.choice(CHANGES)(_some_group(file, chance), chance)  # not of a name that is there already

    if chance.random() < 0.5:
        edit(path, change)
    else:
        with h5py.File(path, "r+") as file:
            change(file)
    if chance.random() < 0.2:
        path.write_bytes(bytes_changed(path.read_bytes(), chance))


def _some_group(file: h5py.File, chance: random.Random) -> h5py.Group:
    found = [file]
    file.visititems(lambda _, item: found.append(item) if isinstance(item, h5py.Group) and len(found) < 50 else None)
    return chance.choice(found)


def _huge(group: h5py.Group, chance: random.Random) -> None:
    """Data sets of which only the size is stored."""
    for i in range(chance.choice((1, 1, 30))):
        chunks = (chance.choice((1, 100, 10**5, 10**6)),)
        group.create_dataset(f"huge{i}", shape=(chance.choice(HUGE),), chunks=chunks, dtype=chance.choice(TYPES))


def _wide_chunk(group: h5py.Group, chance: random.Random) -> None:
    data = group.create_dataset("wide", (1,), "f8", maxshape=(None,), chunks=(chance.choice((10**5, 10**7, 10**8)),))
    if data.chunks[0] < 10**6:
        data[0] = 1.0


def _links(group: h5py.Group, chance: random.Random) -> None:
    many, below = chance.choice((2, 50)), group.create_group("last")
    below["x"] = 1.0
    for depth in range(chance.choice((1, 3, 6))):
        above = group.create_group(f"level{depth}")
        for i in range(many):
            above[f"x{i}"] = below
        below = above
    if chance.random() < 0.3:
        below["circle"] = group


def _texts(group: h5py.Group, chance: random.Random) -> None:
    text = chance.choice(("", "x" * 1000, "x" * 10**6, "\x1b[31m"))
    many = chance.choice((1, 1000, 20_000 if len(text) < 10**4 else 10))
    kind = chance.choice((h5py.string_dtype(), h5py.vlen_dtype("i4"), h5py.ref_dtype, f"S{max(len(text), 1)}"))
    if kind == h5py.ref_dtype:
        group.create_dataset("texts", (many,), kind)[0] = group.ref
    elif h5py.check_vlen_dtype(kind) is not None and h5py.check_string_dtype(kind) is None:
        group.create_dataset("texts", (many,), kind)[0] = np.arange(5)
    else:
        group.create_dataset("texts", data=np.array([text] * many, dtype=object).astype(kind), dtype=kind)


def _attributes(group: h5py.Group, chance: random.Random) -> None:
    odd = (np.zeros(7000), np.arange(3), np.nan, 1 + 2j, True, "x" * 60_000, h5py.Empty("f8"), group.ref, b"\xff",
           np.array(["a"] * 3000, dtype=h5py.string_dtype()), "\x1b[31m", "NaN", "[" * 50_000, '{"a": 1}')  # fmt: skip
    names = [*group.attrs, "format", "version", "summary", "jkr", "body", "unit", "point count", "grid shape x"]
    group.attrs[chance.choice(names)] = chance.choice((*odd, 0, -1, 1, 2, 10**9, 1e300))


def _many(group: h5py.Group, chance: random.Random) -> None:
    for i in range(chance.choice((10, 300))):
        group.create_dataset(f"many{i}", data=float(i)) if i % 2 else group.create_group(f"many{i}")


def _elsewhere(group: h5py.Group, chance: random.Random) -> None:
    name = chance.choice(NAMES)
    if name in group:
        del group[name]
    group[name] = chance.choice(
        (h5py.ExternalLink("/etc/passwd", "/"), h5py.SoftLink("/"), np.dtype("f8"), np.zeros((3, 0)), "text")
    )


def _gone(group: h5py.Group, chance: random.Random) -> None:
    name = chance.choice([*group, "x"])
    values = chance.choice((None, 1.0, np.zeros(3), "x", np.zeros((2, 2, 2)), np.zeros(4, dtype="c16")))
    del group[name]
    if values is not None:
        group[name] = values


def _cell(group: h5py.Group, chance: random.Random) -> None:
    column = group[chance.choice([*group, "x"])]
    column[chance.randrange(column.size)] = chance.choice((np.nan, -np.inf, 0.0, -1.0, 1e308, 5e-324, 1e30, 1e-30))


def _deep(group: h5py.Group, chance: random.Random) -> None:
    for name in ["deep"] * chance.choice((3, 6, 100)):
        group = group.create_group(name)


CHANGES: tuple[Callable[[h5py.Group, random.Random], None], ...] = (
    _huge, _wide_chunk, _links, _texts, _attributes, _many, _elsewhere, _gone, _cell, _deep
)  # fmt: skip


TABLE = b"delta_m,P_N\n" + b"".join(b"%de-9,%de-9\n" % (i, i * i) for i in range(1, 30))
TABLES = (TABLE, b"", b"\n" * 100_000, b"1,2\n" * 50_000, b"1\x1e2\x1e" * 1000, b"1," * 30_000, b"a" * 10**6,
          bytes(10**6), TABLE.replace(b"\n", b"\r"), TABLE.decode().encode("utf-16"), b"\xff" * 100)  # fmt: skip
MEMBERS = ("a.csv", "../../a.csv", "/a.csv", "a" * 300 + ".csv", "\x1b[31m.csv", "é.txt", "a\0b.csv", "c.txt/",
           "x/.csv", "b.csv", "x.bin", "A.CSV", "__MACOSX/a.csv", "inner.zip", "\u202e.csv", "n\nm.csv")  # fmt: skip


def harm_zip(path: Path, chance: random.Random) -> None:
    with zipfile.ZipFile(path, "w", chance.choice((0, 8, 8, 8, 12, 14))) as file:
        for name in chance.sample(MEMBERS, chance.choice((1, 2, 5))):
            file.writestr(zipfile.ZipInfo(name), chance.choice(TABLES), chance.choice((0, 8, 8)))
        for i in range(chance.choice((0, 0, 0, 3, 300))):
            file.writestr(f"many/{i}.csv", chance.choice((b"", TABLE[:40])))
        file.comment = chance.choice((b"", b"PK\5\6" * 9, b"PK\1\2" * 100))
    _harm_list(path, chance)


def _harm_list(path: Path, chance: random.Random) -> None:
    """Change what the list of members says of them: sizes, flags, places; and now and then any byte."""
    content = bytearray(path.read_bytes())
    at = content.find(b"PK\1\2")
    if chance.random() < 0.5:
        place, size = chance.choice(((8, 2), (10, 2), (16, 4), (20, 4), (24, 4), (28, 2), (30, 2), (32, 2), (42, 4)))
        odd = (0, 1, 255, 2**31 - 1, 2**32 - 1, chance.randrange(2**32))
        content[at + place : at + place + size] = struct.pack("<I", chance.choice(odd))[:size]
    path.write_bytes(bytes_changed(bytes(content), chance) if chance.random() < 0.3 else content)


VALUES = ("", "0", "-1", "1e12", "1e300", "nan", "inf", "force", "volts", "distance", "9" * 5000, "\\u0000", "1,5")


def harm_jpk(path: Path, chance: random.Random) -> None:
    """An archive of a force microscope whose properties, members and numbers do not belong together."""
    members = jpk_members(chance.choice((0, 0, 1, 3)))
    for _ in range(chance.choice((1, 1, 2, 4))):
        name = chance.choice(list(members))
        match chance.randrange(7):
            case 0:
                del members[name]
            case 1:
                members[name] = chance.choice((b"", bytes(3), bytes(4000), chance.randbytes(400), bytes(10**6)))
            case 2:
                members[name.replace(chance.choice("01s"), chance.choice(("7", "x", "..", "0")))] = members[name]
            case 3:
                members |= {f"segments/{i}/": b"" for i in range(2, chance.choice((3, 30)))}
                members |= {f"index/{i}/": b"" for i in range(chance.choice((0, 30)))}
            case _:
                headers = [name for name in members if name.endswith(".properties")] or [name]
                name = chance.choice(headers)
                members[name] = _properties_changed(members[name], chance)
    zipped(path, members)
    if chance.random() < 0.2:
        _harm_list(path, chance)


def _properties_changed(content: bytes, chance: random.Random) -> bytes:
    lines = content.decode("latin-1").splitlines() or ["x=1"]
    at = chance.randrange(len(lines))
    key = lines[at].partition("=")[0]
    odd: tuple[Any, ...] = (f"{key}={chance.choice(VALUES)}", "", key, f"{key}=1\n{key}=2", "\\" * 9, f"x{key}=1")
    lines[at] = chance.choice(odd)
    if chance.random() < 0.2:
        lines.append(f"force-scan-map.position-pattern.grid.{chance.choice('ij')}length={chance.choice(VALUES)}")
    return "\n".join(lines).encode("latin-1")
