"""HDF5 files as plain trees of groups, each sealed by a digest of all that it holds: the one door to h5py."""

from __future__ import annotations

import hashlib
import math
import re
from collections.abc import Container, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from . import process as allowance
from . import process as locks
from .errors import InputError, writable
from .numerics import Array

SIGNATURE = b"\x89HDF\r\n\x1a\n"
SEAL = "sha256"  # attribute of a group: the digest of everything else in it
FILE_FORMAT = ("v110", "v110")  # its metadata carry checksums: damage is found, not followed

KINDS = (h5py.h5t.INTEGER, h5py.h5t.FLOAT, h5py.h5t.STRING, h5py.h5t.ENUM)  # the last: truth values
HEAP = re.compile(b"GCOL\1\0\0\0(.{8})", re.DOTALL)  # how a heap of texts begins, and its size
RUN_AGAIN = "run the case again"
UNREADABLE = (OSError, RuntimeError, KeyError, ValueError, TypeError, OverflowError)  # h5py's, of damage


@dataclass(frozen=True, eq=False)
class Dataset:
    """Numbers, a text or a list of texts under one name."""

    values: Array | str | Sequence[str]
    attributes: Mapping[str, Any] = field(default_factory=dict)
    shape: tuple[int, ...] = ()
    dtype: np.dtype[Any] = field(default_factory=lambda: np.dtype(float))


@dataclass(frozen=True, eq=False)
class Group:
    """Attributes (numbers and texts) and members by name, in order; the root group is the file."""

    attributes: Mapping[str, Any] = field(default_factory=dict)
    members: Mapping[str, Group | Dataset] = field(default_factory=dict)


def unit_column(values: Array, unit: str, description: str = "") -> Dataset:
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
    sha = hashlib.sha256()
    for key, value in sorted(group.attributes.items()):
        if key != SEAL:
            _update(sha, key, value)
    for name, member in sorted(group.members.items()):
        if isinstance(member, Dataset):
            _update(sha, name, member.values)
            member = Group(member.attributes)
        if SEAL not in member.attributes:
            _update(sha, name, digest(member))
    return sha.hexdigest()


def _update(sha: Any, name: str, value: Any) -> None:
    """Take a name with its value into the digest ``sha``, as bytes that differ wherever one of them does."""
    value, numbers = _plain(value), memoryview(b"")
    if isinstance(value, np.ndarray) and value.dtype.kind != "O":
        content = repr((value.dtype.str, value.shape)).encode()
        numbers = np.ascontiguousarray(value).reshape(-1).view(np.uint8).data
    else:
        value = [_plain(item) for item in value] if isinstance(value, list | tuple) else value
        content = repr(list(value) if isinstance(value, np.ndarray | Sequence) else value).encode()
    sha.update(b"%d %s %d " % (len(name.encode()), name.encode(), len(content) + len(numbers)) + content)
    sha.update(numbers)


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
    is_text = isinstance(values, str)
    values = values if isinstance(values, np.ndarray) else _fixed(values)
    if is_text or not values.size:
        return target.create_dataset(name, data=values)
    fastest = {"compression": "gzip", "compression_opts": 1, "shuffle": True}
    packed = {} if values.dtype.kind == "f" else fastest  # digits of measured numbers are noise, two thirds remain
    chunks = (min(len(values), allowance.TUNING.rows), *values.shape[1:])
    return target.create_dataset(name, data=values, chunks=chunks, fletcher32=True, **packed)


def _describe(target: h5py.Group | h5py.Dataset, attributes: Mapping[str, Any]) -> None:
    for name, value in attributes.items():
        target.attrs[name] = _fixed(value) if isinstance(value, str) else value


def _fixed(texts: str | Sequence[str]) -> Array:
    """A text, or a column of them, of the length of the longest."""
    contents = writable(texts).encode() if isinstance(texts, str) else [writable(text).encode() for text in texts]
    return np.array(contents, dtype=h5py.string_dtype("utf-8", max(np.array(contents, dtype=bytes).itemsize, 1)))


# ---------------------------------------------------------------------- reading
def format_of(path: Path) -> str:
    """The attribute "format" of the file at ``path``; "" where there is none of fixed length or it is damaged."""
    try:
        with allowance.allowance_of(path) as allowed, h5py.File(path, "r") as file:
            is_free = file.attrs.get_id("format").dtype.hasobject
            return "" if is_free else str(_Reader(path, path.stat().st_size, allowed).attribute(file, "format"))
    except (InputError, *UNREADABLE):
        return ""


def tree_of(path: Path, content: bytes, without: Container[str] = (), remedy: str = RUN_AGAIN) -> Group:
    """The tree in the ``content`` of the file at ``path``, members of the root named in ``without`` left out.

    InputError in one line where it is truncated, damaged, being written by another program, leads to other files, or
    takes more than is allowed.
    """
    try:
        with allowance.allowance_of(path) as allowed:
            _check_heaps(content, allowed)
            with h5py.File(h5py.h5f.open_file_image(content)) as file:
                return _Reader(path, len(content), allowed).group(file, without)
    except InputError:
        raise
    except UNREADABLE:
        raise unreadable(path, content, remedy=remedy) from None


def _check_heaps(content: bytes, allowed: allowance.Allowance) -> None:
    """ValueError where a heap of texts of variable length holds free space of no length, over which the library would
    go on without end (HDF5 file format, III.E)."""
    for heap in HEAP.finditer(content):
        at, rows = heap.end(), 0
        end = min(heap.start() + int.from_bytes(heap[1], "little"), len(content))
        while at + 16 <= end:
            size, rows = int.from_bytes(content[at + 8 : at + 16], "little"), rows + 1
            step = 16 + -(-size // 8) * 8 if any(content[at : at + 2]) else size
            if step < 16:
                raise ValueError("free space of no length")
            at += step
        allowed.take(rows=rows)


def unreadable(path: Path, content: bytes, why: str = "", remedy: str = RUN_AGAIN) -> InputError:
    """The error of a file that cannot be read; ``why``: more on its damage."""
    if _is_being_written(path):
        return InputError(f"{path}: the HDF5 file is open in another program, which is writing it; try again later")
    whole = int.from_bytes(content[28:36], "little")  # as the superblock says (HDF5 file format, II.A, version 3)
    reason = "truncated" if content[8:9] == b"\3" and len(content) < whole else "damaged"
    return InputError(f"{path}: the HDF5 file is {reason}{why} and cannot be read; {remedy}")


def _is_being_written(path: Path) -> bool:
    """Whether another program holds the lock that HDF5 takes to write."""
    try:
        with path.open("rb") as file:
            return locks.taken(file, shared=True) is False
    except OSError:
        return False


@dataclass(frozen=True)
class _Reader:
    """Reads the file at ``path``, of ``whole`` bytes, and counts what that takes; ``seen``: addresses in the file."""

    path: Path
    whole: int
    allowed: allowance.Allowance
    seen: set[int] = field(default_factory=set)

    def group(self, group: h5py.Group, without: Container[str] = ()) -> Group:
        members: dict[str, Group | Dataset] = {}
        for name in group:
            if name in without:
                continue
            where = f"{group.name.strip('/')}/{name}".strip("/")
            self.enter(where, group.id.links.get_info(name.encode("utf-8", "surrogateescape")))
            item = group[name]
            is_data = isinstance(item, h5py.Dataset)
            members[name] = self.dataset(where, item) if is_data else self.group(item)
        return Group(self.attributes(group), members)

    def enter(self, where: str, link: h5py.h5l.LinkInfo) -> None:
        """Count a member; refuse what leads elsewhere, or to what was read: so a small file becomes a huge tree."""
        self.allowed.take(parts=1)
        if link.type != h5py.h5l.TYPE_HARD or link.u in self.seen:
            raise InputError(f'{self.path}: "{where}" is a link, not data of this file')
        self.seen.add(link.u)

    def dataset(self, where: str, data: h5py.Dataset) -> Dataset:
        if data.external or data.is_virtual:
            raise InputError(f'{self.path}: "{where}" lies in another file')
        chunks = data.chunks or data.shape or ()
        pieces = math.prod(-(-size // of) for size, of in zip(data.shape or (), chunks, strict=True) if of)
        self.allowed.take(parts=max(pieces - 1, 0), memory=allowance.TUNING.chunk * pieces)
        self.count(where, max(data.size or 0, math.prod(chunks)), data.id.get_type())
        values = self.texts(data) if data.dtype.hasobject and data.shape else _plain(data[()])
        if isinstance(values, np.ndarray) and values.dtype.kind in "OS":
            values = [_plain(item) for item in values.tolist()]
        return Dataset(values, self.attributes(data), data.shape or (), data.dtype)

    def count(self, where: str, count: int, kind: h5py.h5t.TypeID) -> None:
        """Count so many values of a type; what texts of variable length take is known when they are read. Types that
        no file of ours holds are refused: the library itself falls over damaged ones."""
        size, is_text = count * kind.get_size(), kind.get_class() == h5py.h5t.STRING
        if kind.get_class() not in KINDS:
            raise InputError(f'{self.path}: "{where}" holds neither numbers nor texts')
        self.allowed.take(size, rows=count * is_text, memory=allowance.TUNING.copies * size * is_text)

    def texts(self, data: h5py.Dataset) -> list[Any]:
        """A column of texts of variable length, in pieces that cannot take more than is allowed: each of its texts may
        be all that the file holds."""
        if data.ndim != 1:
            raise TypeError("a table of texts")
        texts: list[Any] = []
        step = max(1, allowance.TUNING.size // self.whole)
        for first in range(0, data.size, step):
            piece = [_plain(text) for text in data[first : first + step]]
            self.allowed.take(size := sum(map(len, piece)), memory=allowance.TUNING.copies * size)
            texts += piece
        return texts

    def attributes(self, item: h5py.Group | h5py.Dataset) -> dict[str, Any]:
        return {str(name): self.attribute(item, name) for name in item.attrs}

    def attribute(self, item: h5py.Group | h5py.Dataset, name: str) -> Any:
        stored = item.attrs.get_id(name)
        count = stored.get_space().get_simple_extent_npoints()
        self.allowed.take(parts=1)
        self.count(name, count, stored.get_type())
        if count > 1 and stored.dtype.hasobject:
            self.allowed.take(count * self.whole)
        value = _plain(item.attrs[name])
        self.allowed.take(len(value) if isinstance(value, str) else 0)
        return value
