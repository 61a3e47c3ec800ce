"""HDF5 files as plain trees of groups, each sealed by a digest of all that it holds: the one door to h5py."""

from __future__ import annotations

import hashlib
from collections.abc import Container, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from .arrays import Array
from .errors import InputError, writable
from .locks import taken

SIGNATURE = b"\x89HDF\r\n\x1a\n"
SEAL = "sha256"  # attribute of a group: the digest of everything else in it
FILE_FORMAT = ("v110", "v110")  # its metadata carry checksums: damage is found, not followed
DEEPEST = 4  # choice: groups within groups, so that a group that holds itself ends
MOST_BYTES = 800_000_000  # choice: of one dataset
RUN_AGAIN = "run the case again"
UNREADABLE = (OSError, RuntimeError, KeyError, ValueError, TypeError, OverflowError, MemoryError)  # h5py's, of damage


@dataclass(frozen=True, eq=False)
class Dataset:
    """Numbers, a text or a list of texts under one name; ``values`` is None where a file holds more than fits."""

    values: Array | str | Sequence[str] | None
    attributes: Mapping[str, Any] = field(default_factory=dict)
    shape: tuple[int, ...] = ()
    dtype: np.dtype[Any] = field(default_factory=lambda: np.dtype(float))


@dataclass(frozen=True, eq=False)
class Group:
    """Attributes (numbers and texts) and members by name, in order; the root group is the file."""

    attributes: Mapping[str, Any] = field(default_factory=dict)
    members: Mapping[str, Group | Dataset] = field(default_factory=dict)


def column(values: Array, unit: str, description: str = "") -> Dataset:
    """A dataset of numbers that states its unit."""
    attributes = {"unit": unit} | ({"description": description} if description else {})
    return Dataset(np.asarray(values), attributes)


# ---------------------------------------------------------------------- the seal
def sealed(group: Group) -> Group:
    """``group`` with its digest among its attributes: the last thing to be added."""
    return replace(group, attributes={**group.attributes, SEAL: digest(group)})


def is_sound(group: Group) -> bool:
    """Whether the group holds what it held when it was sealed, and so do all sealed members that were read."""
    parts = [part for part in group.members.values() if isinstance(part, Group) and SEAL in part.attributes]
    return group.attributes.get(SEAL) == digest(group) and all(map(is_sound, parts))


def digest(group: Group) -> str:
    """SHA-256 over names, attributes, shapes and values, sorted by name; without members that have their own seal."""
    found = hashlib.sha256()
    for key, value in sorted(group.attributes.items()):
        if key != SEAL:
            found.update(_canonical(key, value))
    for name, member in sorted(group.members.items()):
        if isinstance(member, Dataset):
            found.update(_canonical(name, member.values))
            member = Group(member.attributes)
        if SEAL not in member.attributes:
            found.update(_canonical(name, digest(member)))
    return found.hexdigest()


def _canonical(name: str, value: Any) -> bytes:
    """A name with its value as bytes that differ wherever one of them does."""
    value = _plain(value)
    if isinstance(value, np.ndarray) and value.dtype.kind != "O":
        content = repr((value.dtype.str, value.shape)).encode() + np.ascontiguousarray(value).tobytes()
    else:
        value = [_plain(item) for item in value] if isinstance(value, list | tuple) else value
        content = repr(list(value) if isinstance(value, np.ndarray | Sequence) else value).encode()
    return b"%d %s %d " % (len(name.encode()), name.encode(), len(content)) + content


def _plain(value: Any) -> Any:
    """The Python number or text for what h5py and NumPy make of it; arrays and oddities as they are."""
    value = value.item() if isinstance(value, np.generic) and value.dtype.kind in "biufSU" else value
    if isinstance(value, str):
        return writable(value)
    return value.decode("utf-8") if isinstance(value, bytes) else value


# ---------------------------------------------------------------------- writing
def image(root: Group) -> bytes:
    """The bytes of the file that holds ``root``, sealed.

    Texts have a fixed length, so that they lie in checksummed metadata or chunks and damage to them leads the library
    nowhere. Built in memory: HDF5 itself neither says clearly that a disk is full nor gets over it.
    """
    with h5py.File("image", "w", driver="core", backing_store=False, libver=FILE_FORMAT, track_order=True) as file:
        _fill(file, sealed(root))
        file.flush()
        return bytes(file.id.get_file_image())


def _fill(target: h5py.Group, group: Group) -> None:
    for name, member in group.members.items():
        if isinstance(member, Group):
            _fill(target.create_group(name, track_order=True), member)
        else:
            _describe(_dataset(target, name, member.values), member.attributes)
    _describe(target, group.attributes)


def _dataset(target: h5py.Group, name: str, values: Any) -> h5py.Dataset:
    if isinstance(values, str):
        return target.create_dataset(name, data=_fixed(values))
    values = values if isinstance(values, np.ndarray) else _all_fixed(values)
    packed = {"chunks": True, "fletcher32": True, "compression": "gzip", "shuffle": True} if values.size else {}
    return target.create_dataset(name, data=values, **packed)


def _describe(target: h5py.Group | h5py.Dataset, attributes: Mapping[str, Any]) -> None:
    for name, value in attributes.items():
        target.attrs[name] = _fixed(value) if isinstance(value, str) else value


def _fixed(text: str) -> Array:
    content = writable(text).encode()
    return np.array(content, dtype=h5py.string_dtype("utf-8", max(len(content), 1)))


def _all_fixed(texts: Sequence[str]) -> Array:
    contents = [writable(text).encode() for text in texts]
    return np.array(contents, dtype=h5py.string_dtype("utf-8", max(map(len, contents), default=1) or 1))


# ---------------------------------------------------------------------- reading
def kind(path: Path) -> str:
    """The attribute "format" of the file at ``path``; "" where there is none, or the file is damaged."""
    try:
        with h5py.File(path, "r") as file:
            return str(_plain(file.attrs.get("format", "")))
    except UNREADABLE:
        return ""


def parse(path: Path, content: bytes, without: Container[str] = (), remedy: str = RUN_AGAIN) -> Group:
    """The tree in the ``content`` of the file at ``path``, members of the root named in ``without`` left out.

    InputError in one line where it is truncated, damaged, being written by another program, or leads to other files.
    """
    try:
        with h5py.File(h5py.h5f.open_file_image(content)) as file:
            return _group(path, file, without)
    except InputError:
        raise
    except UNREADABLE:
        raise unreadable(path, content, remedy=remedy) from None


def unreadable(path: Path, content: bytes, why: str = "", remedy: str = RUN_AGAIN) -> InputError:
    """What is said of a file that cannot be read; ``why``: more on its damage."""
    if _is_being_written(path):
        return InputError(f"{path}: the HDF5 file is open in another program, which is writing it; try again later")
    whole = int.from_bytes(content[28:36], "little")  # as the superblock says (HDF5 file format, II.A, version 3)
    reason = "truncated" if content[8:9] == b"\3" and len(content) < whole else "damaged"
    return InputError(f"{path}: the HDF5 file is {reason}{why} and cannot be read; {remedy}")


def _is_being_written(path: Path) -> bool:
    """Whether another program holds the lock that HDF5 takes to write."""
    try:
        with path.open("rb") as file:
            return taken(file, shared=True) is False
    except OSError:
        return False


def _group(path: Path, group: h5py.Group, without: Container[str] = (), depth: int = 0) -> Group:
    if depth > DEEPEST:
        raise ValueError("groups within groups")
    members: dict[str, Group | Dataset] = {}
    for name in group:
        if name in without:
            continue
        where = f"{group.name.strip('/')}/{name}".strip("/")
        if not isinstance(group.get(name, getlink=True), h5py.HardLink):
            raise InputError(f'{path}: "{where}" is a link, not data of this file')
        item = group[name]
        members[name] = (
            _values(path, where, item) if isinstance(item, h5py.Dataset) else _group(path, item, depth=depth + 1)
        )
    return Group(_attributes(group), members)


def _values(path: Path, where: str, data: h5py.Dataset) -> Dataset:
    if data.external or data.is_virtual:
        raise InputError(f'{path}: "{where}" lies in another file')
    fits = (data.size or 0) * data.dtype.itemsize <= MOST_BYTES
    values = _plain(data[()]) if fits else None
    if isinstance(values, np.ndarray) and values.dtype.kind in "OS":
        values = [_plain(item) for item in values.tolist()]
    return Dataset(values, _attributes(data), data.shape or (), data.dtype)


def _attributes(item: h5py.Group | h5py.Dataset) -> dict[str, Any]:
    return {str(key): _plain(value) for key, value in item.attrs.items()}
