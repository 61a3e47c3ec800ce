"""HDF5 files as plain trees of groups, each sealed by a digest of all that it holds: the one door to h5py."""

from __future__ import annotations

import contextlib
import hashlib
import importlib.util
import io
import math
import sys
from collections.abc import Callable, Container, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cache, partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from . import process
from .errors import InputError, writable
from .numerics import Array

if TYPE_CHECKING:
    import h5py
elif "h5py" in sys.modules:
    h5py = sys.modules["h5py"]
else:  # it runs when something of it is first used: many commands open no HDF5 file
    _spec = importlib.util.find_spec("h5py")
    _spec.loader = importlib.util.LazyLoader(_spec.loader)
    h5py = sys.modules["h5py"] = importlib.util.module_from_spec(_spec)
    _spec.loader.exec_module(h5py)

SIGNATURE = b"\x89HDF\r\n\x1a\n"
# theory: HDF5's flags of an image that is read where it lies, neither copied nor freed (H5LT_FILE_IMAGE_DONT_...)
IN_PLACE = 2 | 4
HEAP = b"GCOL\1\0\0\0"
SEAL = "sha256"  # attribute of a group: the digest of everything else in it
FILE_FORMAT = ("v110", "v110")  # its metadata carry checksums: damage is found, not followed

KINDS = INTEGER, FLOAT, STRING, ENUM = 0, 1, 3, 8  # theory: HDF5's numbers of classes; the last: truth values
LETTERS, WORD = 4, 60  # choice: bytes of memory of a byte of a text while it is read, and of each text beside them
CHUNK = 1 << 18  # choice: bytes that are written at once, which stay in the cache of a core
WIDEST, REFERENCE = 16, 16  # theory: bytes of the widest number, and of the place of a text of any length in a file
LOOK = 1 << 20  # choice: bytes that are read between two looks at free memory, which cost as much as a column
MOST_VALUES = 100  # choice: of an attribute that others wrote; positions and ranges are two or three
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
    sha.update(b"%d %s %d " % (len(name.encode()), name.encode(), len(content) + len(numbers)))
    sha.update(content)
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
    memory = io.BytesIO()
    with h5py.File(memory, "w", libver=FILE_FORMAT, track_order=True) as file:
        _fill(file, sealed(root))
    return memory.getvalue()


def _fill(target: h5py.Group, group: Group) -> None:
    for name, member in group.members.items():
        if isinstance(member, Group):
            _fill(target.create_group(name, track_order=True), member)
        else:
            given = member.values
            values = given if isinstance(given, np.ndarray) else _fixed(given)
            if isinstance(given, str) or not values.size:
                dataset = target.create_dataset(name, data=values)
            else:  # digits of measured numbers are noise, two thirds of them remain; texts are no longer when shuffled
                fastest = {"compression": "gzip", "compression_opts": 1, "shuffle": values.dtype.kind != "S"}
                packed = {} if values.dtype.kind == "f" else fastest
                pieces = -(-values.nbytes // CHUNK)
                chunks = (-(-len(values) // pieces), *values.shape[1:])  # of one length, or the last is filled up
                dataset = target.create_dataset(name, data=values, chunks=chunks, fletcher32=True, **packed)
            _describe(dataset, member.attributes)
    _describe(target, group.attributes)


def _describe(target: h5py.Group | h5py.Dataset, attributes: Mapping[str, Any]) -> None:
    for name, value in attributes.items():
        target.attrs[name] = _fixed(value) if isinstance(value, str) else value


def _fixed(texts: str | Sequence[str]) -> Array:
    """A text, or a column of them, of the length of the longest."""
    contents = [writable(text).encode() for text in ([texts] if isinstance(texts, str) else texts)]
    dtype = h5py.string_dtype("utf-8", max(map(len, contents), default=0) or 1)
    return np.array(contents[0] if isinstance(texts, str) else contents, dtype=dtype)


# ---------------------------------------------------------------------- reading
def format_of(path: Path) -> str:
    """The attribute "format" of the file at ``path``; "" where there is none of fixed length or it is damaged."""
    try:
        with h5py.File(path, "r") as file:
            return "" if file.attrs.get_id("format").dtype.hasobject else str(_plain(file.attrs["format"]))
    except UNREADABLE:
        return ""


def names_in(path: Path) -> frozenset[str]:
    """Names of attributes and members of the root of the file at ``path``; none where it is damaged or no HDF5 file."""
    try:
        with h5py.File(path, "r") as file:
            return frozenset(name for name in (*file.attrs, *file) if isinstance(name, str))  # bytes: no UTF-8, damage
    except UNREADABLE:
        return frozenset()


def tree_of(path: Path, content: bytes, without: Container[str] = (), remedy: str = RUN_AGAIN) -> Group:
    """The tree in the ``content`` of the file at ``path``, members of the root named in ``without`` left out.

    InputError in one line where it is truncated, damaged, being written by another program, or holds what no file of
    ours does: links, parts of other files, types beside numbers and texts of fixed length, more than may be read.
    """
    with _opened(path, content, remedy) as file:
        Members(path).check(file, without)
        return _group(file, without)


@contextlib.contextmanager
def members_of(path: Path, content: bytes, remedy: str) -> Iterator[tuple[h5py.File, Members]]:
    """Open a file that others wrote once; with it what gives a member of a group by its name, checked as ``tree_of``
    does, but for attributes, which may be of any type. Values are read when they are asked for."""
    if not _has_sound_heaps(content):
        raise unreadable(path, content, remedy=remedy)
    with _opened(path, content, remedy) as file:
        yield file, Members(path, of_ours=False)


@contextlib.contextmanager
def _opened(path: Path, content: bytes, remedy: str) -> Iterator[h5py.File]:
    try:
        with h5py.File(h5py.h5f.open_file_image(content, IN_PLACE)) as file:
            yield file
    except InputError:
        raise
    except UNREADABLE:
        raise unreadable(path, content, remedy=remedy) from None


def _has_sound_heaps(content: bytes) -> bool:
    """Whether the heaps of texts of any length hold objects that end where the heap does (HDF5 file format, III.E):
    they have no checksum, and the library goes around for ever at a free space of no size."""
    at = content.find(HEAP)
    while at >= 0:
        end = at + int.from_bytes(content[at + 8 : at + 16], "little")
        here, at = at + 16, content.find(HEAP, at + 1)
        while here + 16 <= end <= len(content):
            number, size = (int.from_bytes(content[here + i : here + i + n], "little") for i, n in ((0, 2), (8, 8)))
            step = 16 + -(-size // 8) * 8 if number else size  # the size of what is free counts its head
            here += step or len(content)
        if end > len(content) or here > end:
            return False
    return True


def unreadable(path: Path, content: bytes, why: str = "", remedy: str = RUN_AGAIN) -> InputError:
    """The error of a file that cannot be read; ``why``: more on its damage."""
    with contextlib.suppress(OSError), path.open("rb") as file:
        if process.taken(file, shared=True) is False:  # another program holds the lock that HDF5 takes to write
            return InputError(f"{path}: the HDF5 file is open in another program, which is writing it; try again later")
    whole = int.from_bytes(content[28:36], "little")  # as the superblock says (HDF5 file format, II.A, version 3)
    reason = "truncated" if content[8:9] == b"\3" and len(content) < whole else "damaged"
    return InputError(f"{path}: the HDF5 file is {reason}{why} and cannot be read; {remedy}")


@dataclass
class Members:
    """Members of groups by their names, of which it refuses what no file ``of_ours`` holds, before any value of the
    file at ``path`` is read; ``taken``: bytes that reading takes, ``allowed``: that it may take before memory is looked
    at again; ``seen``: addresses in the file."""

    path: Path
    of_ours: bool = True
    taken: int = 0
    allowed: int = 0
    seen: set[int] = field(default_factory=set)

    def check(self, group: h5py.Group, without: Container[str] = ()) -> None:
        """InputError where a group holds, itself or in a group within it, what it is not to hold."""
        self._check_attributes(group)
        for name in group:
            if name not in without and isinstance(item := self.member(group, name), h5py.Group):
                self.check(item)

    def member(self, group: h5py.Group, name: str) -> h5py.Group | h5py.Dataset:
        """One member, itself checked, of a group not yet what it holds."""
        opened = self._opened(group, name)
        if isinstance(opened, h5py.h5g.GroupID):
            return h5py.Group(opened)
        if not isinstance(opened, h5py.h5d.DatasetID):
            return group[name]
        self._check_dataset(group, name, opened)
        return h5py.Dataset(opened, readonly=True)

    def values(self, group: h5py.Group, name: str) -> Any:
        """What one member, a dataset, holds."""
        opened = self._opened(group, name)
        return values_of(opened, *self._check_dataset(group, name, opened))

    def _opened(self, group: h5py.Group, name: str) -> Any:
        """The identifier of one member, which may be anything's but a link's."""
        if isinstance(name, bytes):  # which is no UTF-8
            raise InputError(f"{self.path}: the HDF5 file is damaged: it has a member whose name is no text")
        stored = name.encode("utf-8", "surrogateescape")
        link = group.id.links.get_info(stored)
        if link.type != h5py.h5l.TYPE_HARD or link.u in self.seen:  # so a small file becomes a huge tree
            raise InputError(f'{self.path}: "{_place(group, name)}" is a link, not data of this file')
        self.seen.add(link.u)
        return h5py.h5o.open(group.id, stored)

    def _check_dataset(
        self, group: h5py.Group, name: str, data: h5py.h5d.DatasetID
    ) -> tuple[tuple[int, ...] | None, h5py.h5t.TypeID]:
        """InputError where a dataset is not to be read; its shape, None without a value, and the type in the file."""
        where = partial(_place, group, name)
        shape, kind, stored = data.shape, data.get_type(), data.get_create_plist()
        layout = stored.get_layout()
        if stored.get_external_count() or layout == h5py.h5d.VIRTUAL:
            raise InputError(f'{self.path}: "{where()}" lies in another file')
        chunks = stored.get_chunk() if layout == h5py.h5d.CHUNKED else shape or ()
        pieces = math.prod(-(-size // of) for size, of in zip(shape or (), chunks, strict=True) if of)
        count = 0 if shape is None else math.prod(shape)
        self._check_values(where, kind, max(count, math.prod(chunks)), pieces)
        if self.of_ours:
            self._check_attributes(h5py.Dataset(data, readonly=True))
        return shape, kind

    def _check_attributes(self, item: h5py.Group | h5py.Dataset) -> None:
        for name in item.attrs if self.of_ours else ():
            stored = item.attrs.get_id(name)
            count = stored.get_space().get_simple_extent_npoints()
            self._check_values(partial(str, name), stored.get_type(), count)

    def _check_values(self, where: Callable[[], str], kind: h5py.h5t.TypeID, count: int, pieces: int = 1) -> None:
        is_text = kind.get_class() == STRING
        if kind.get_class() not in KINDS or (is_text and kind.is_variable_str()):
            raise InputError(f'{self.path}: "{where()}" holds neither numbers nor texts of fixed length')
        each = LETTERS * kind.get_size() + WORD if is_text else kind.get_size()
        self.taken += count * each + process.PART * pieces
        if self.taken > self.allowed:
            process.check_size(self.path, self.taken)
            self.allowed = min(self.taken + LOOK, process.SIZE)


def _place(group: h5py.Group, name: str) -> str:
    """Where a member is, for messages."""
    return f"{group.name.strip('/')}/{name}".strip("/")


def _group(group: h5py.Group, without: Container[str] = ()) -> Group:
    members: dict[str, Group | Dataset] = {}
    for name in group:
        if name not in without:
            item = group[name]
            if isinstance(item, h5py.Dataset):
                values = _plain(item[()])
                if isinstance(values, np.ndarray) and values.dtype.kind == "S":
                    values = [_plain(text) for text in values.tolist()]
                members[name] = Dataset(values, attributes_of(item), item.shape or (), item.dtype)
            else:
                members[name] = _group(item)
    return Group(attributes_of(group), members)


def attributes_of(item: h5py.Group | h5py.Dataset) -> dict[str, Any]:
    """Attributes of a group or dataset by name: numbers, texts and arrays."""
    return {str(name): _plain(value) for name, value in item.attrs.items()}


def attributes_among(item: h5py.Group | h5py.Dataset, names: Sequence[str]) -> dict[str, Any]:
    """Those of the attributes ``names`` that a group or dataset of others' has: numbers, texts and short arrays.

    Others are not touched: where a file without checksums is damaged, the library follows what it reads for minutes or
    out of its memory. ValueError where one is of another type or size, or takes another place than it says.
    """
    found, holder = {}, item.id
    for name in names:
        if h5py.h5a.exists(holder, encoded := name.encode()):
            stored = h5py.h5a.open(holder, encoded)
            kind, count = stored.get_type(), stored.get_space().get_simple_extent_npoints()
            sort = kind.get_class()
            is_text = sort == STRING
            each = REFERENCE if is_text and kind.is_variable_str() else kind.get_size()
            fits = each <= (process.TEXT if is_text else WIDEST) and 0 < count <= MOST_VALUES
            if sort not in KINDS or not fits or stored.get_storage_size() != count * each:
                raise ValueError(f"the attribute {name} is damaged")
            found[name] = _plain(item.attrs[name])
    return found


def names_of(group: h5py.Group) -> list[str]:
    """Names of the members of a group, sorted; UnicodeDecodeError where one is no UTF-8."""
    names: list[bytes] = []
    group.id.links.iterate(names.append)
    return sorted(name.decode() for name in names)


def values_of(data: h5py.h5d.DatasetID, shape: tuple[int, ...] | None, kind: h5py.h5t.TypeID) -> Any:
    """What a dataset of a ``shape`` and ``kind`` holds: the same as the ``[()]`` of h5py's, by one call of the library
    where there are values."""
    if shape is None or 0 in shape:
        return h5py.Dataset(data)[()]
    # of most numbers Python's type, which h5py takes long to find; of texts and enumerations NumPy compares no details
    values = np.empty(shape, float if kind == h5py.h5t.IEEE_F64LE else kind.dtype)
    held = h5py.h5t.py_create(values.dtype) if values.dtype.metadata else _of_numbers(values.dtype)
    # HDF5 converts: what a file holds need not be as wide as NumPy's type (truth values, short floats)
    data.read(h5py.h5s.ALL, h5py.h5s.ALL, values, held)
    return values


@cache
def _of_numbers(dtype: np.dtype[Any]) -> h5py.h5t.TypeID:
    """HDF5's type of numbers as NumPy holds them."""
    return h5py.h5t.py_create(dtype)
