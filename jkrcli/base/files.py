"""Files are interfaces: read with one clear error, written whole or not at all, never over what is not ours."""

import contextlib
import functools
import gzip
import hashlib
import io
import json
import math
import os
import platform
import re
import time
import zlib
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextvars import ContextVar
from operator import attrgetter
from pathlib import Path
from typing import Any, BinaryIO, TypeAlias, cast

from . import process
from .errors import InputError, JkrError, nearest, printable, writable

# choice: least and most letters that a name keeps of what a file is called after
SHORTEST, LONGEST = 20, 80
RECORDS = 20  # choice: of a list in JSON, beyond which each has a line of its own
DAY = 86_400  # choice: s, after which nobody is taken to be writing a hidden file any more
TABLES = (  # how the first line of a table of ours begins: CSV has no place for any other mark
    b"a_m,delta_m,P_N,delta_H_m,",
    b"a_m,delta_m,P_N,device_m,phase",
    b"a_m,delta_m,P_N,phase",  # under load control
    b"t_s,a_m,delta_m,P_N,",
    b"r_m,pressure_Pa,",
    b"line,depth_m,r_m,",
    b"fraction,delta_m,P_N,a_m",
    b"file,curve,status,",
    b"sample,curves,fitted,",
    b"curve,t_s,P_N,P_fit_N,",
    b"curve,delta_m,P_N,P_fit_N",
    b"curve,law,",
    b"curve,segment,state,",
    b"nu,base,w_R2_over_Estar_h3",
    b"R_m,w_R2_over_Estar_h3,branch,",
    b"nu,a_over_h,S_ratio,",
    b"h_over_R,k_over_Estar_R,",
    b"h_m,E_Pa,rms_m,",
    b"size_m,elements,unknowns,",
    b"case,status,reason,",
    b"case,reason,command",
)
HEADS = {  # how a file begins, and what then stands near its head
    b"\x89PNG": b"Software\0jkr ",
    b"<?xml": b"<dc:title>jkr ",
    b"{": b'"format": "jkr-',
    b"/* Written by jkr: ": b"#ifndef JKR_",
    b'"""Written by jkr ': b", a fit model for nanite and PyJibe.",
}
TAILS = (b"$Comments\njkr ", b"<!-- jkr ")  # of meshes
PARQUET, PARQUET_MARK = b"PAR1", b"jkr-sweep-table"
SERIES_ENDINGS = (".h5", ".hdf5")
ASIDE = ".jkr-"  # how the hidden files begin that are written beside their places
Staged: TypeAlias = dict[Path, Path | None]  # where each new file lies until it goes to its place; None: it is to go


def read_bytes(path: Path, what: str, limit: int | None = None) -> bytes:
    """The content of ``path``; InputError where it is missing, a folder, unreadable or beyond ``limit`` bytes (None:
    what is allowed of any file)."""
    limit = process.SIZE if limit is None else limit
    with opened(path, what) as file:
        if os.fstat(file.fileno()).st_size <= limit:
            content = file.read(limit + 1) if packed(path) else file.read()
            if len(content) <= limit:
                return content
        raise InputError(f"{path}: {what} is larger than {limit >> 20} MiB")


def packed(path: Path) -> bool:
    """Whether a file is named as one that gzip packed: it is read unpacked."""
    return path.suffix.lower() == ".gz"


@contextlib.contextmanager
def opened(path: Path, what: str) -> Iterator[BinaryIO]:
    """The file at ``path`` to read, unpacked where gzip packed it; InputError where it is missing, a folder, a device,
    a pipe or unreadable."""
    try:
        if path.exists() and not (path.is_file() or path.is_dir()):
            raise InputError(f"{path}: is a device or a pipe, not a {what}")
        with path.open("rb") as file:
            yield cast(BinaryIO, gzip.GzipFile(fileobj=file)) if packed(path) else file
    except FileNotFoundError:
        close = None
        with contextlib.suppress(OSError):
            close = nearest(path.name, [p.name for p in path.parent.iterdir() if p.suffix == path.suffix], 0.6)
        beside = "" if close is None else f', did you mean "{path.parent / close}"?'
        raise InputError(f"{path}: {what} not found{beside}") from None
    except IsADirectoryError:
        raise InputError(f"{path}: is a folder, not a {what}") from None
    except OSError as error:
        raise InputError(f"{path}: {what} cannot be read ({error.strerror or error})") from None
    except (EOFError, zlib.error) as error:
        raise InputError(f"{path}: {what} cannot be unpacked ({error})") from None
    except ValueError as error:  # a null character in the name
        raise InputError(f"{path}: {what} cannot be read ({error})") from None


class Piped(type(Path())):  # type: ignore[misc]  # of this system
    """A file that came through a pipe, under a name in this folder; it is read where it is kept until the end."""

    kept: Any = None

    def __fspath__(self) -> str:
        return str(self) if self.kept is None else str(self.kept.name)


HANDED = re.compile(r"/dev/(stdin|fd/\d+)|/proc/[^/]+/fd/\d+")  # how a shell hands over what is no file of its own
BEGINS = {b"\x89HDF": ".h5", b"PK\3\4": ".zip", b"\x1f\x8b": ".gz"}  # how the file of an ending begins
CASE = re.compile(rb"^[\[ \t]*(indenter|base)\b[^,;\n]*$", re.MULTILINE)  # what a case or a sweep has, and no table


def received(path: Path) -> Path:
    """A path to read as often as need be: of a pipe, or what else the shell hands over (/dev/stdin, /dev/fd/63), a
    copy called stdin or pipe63, with the ending of what it is."""
    if not HANDED.fullmatch(str(path)) or not (path.is_fifo() or path.is_file()):
        return path
    import tempfile

    piped = Piped(f"pipe{path.name}" if path.name.isdigit() else path.name)
    try:
        piped.kept = tempfile.NamedTemporaryFile(prefix=ASIDE)  # noqa: SIM115 - as long as the path
        with path.open("rb") as file:
            while piece := file.read(1 << 20):
                piped.kept.write(piece)
                process.check_size(path, piped.kept.tell())
        piped.kept.flush()
        with piped.open("rb") as file:
            head = file.read(1 << 16)
    except OSError as error:
        raise InputError(f"{path}: cannot be read ({error.strerror or error})") from None
    ending = next((ending for begin, ending in BEGINS.items() if head.startswith(begin)), "")
    named = Piped(str(piped) + (ending or ".toml" * bool(CASE.search(head))))
    named.kept = piped.kept
    return named


def is_ours(path: Path) -> bool:
    """Whether ``jkr`` wrote this file, by the exact mark that each kind of file carries; a mention of jkr is none."""
    with contextlib.suppress(OSError), path.open("rb") as file:
        head = file.read(4096)
        if head.startswith(b"\x89HDF"):
            from .hdf5 import format_of

            return format_of(path).startswith("jkr-")
        if head.startswith(PARQUET):
            # Whether the footer of a Parquet file (its length and a magic word are the last 8 bytes) names our
            # format.
            size = file.seek(-8, os.SEEK_END) + 8
            length = int.from_bytes(file.read(4), "little")
            file.seek(max(0, size - 8 - length))
            return PARQUET_MARK in file.read(min(length, 1 << 24))
        file.seek(max(0, path.stat().st_size - 256))
        tail = file.read()
        marked = any(head.startswith(start) and mark in head for start, mark in HEADS.items())
        return marked or head.startswith(TABLES) or any(mark in tail for mark in TAILS)
    return False


def beside(stem: Path, names: Sequence[str]) -> list[Path]:
    """What files are called after ``stem`` and each of the ``names``, which others gave: plain letters, no more than a
    name may have with its ending, all different."""
    most = max(SHORTEST, min(LONGEST, 250 - len(os.fsencode(stem.name))))
    plain = [re.sub(r"[^-_.a-zA-Z0-9]+", "-", name) for name in names]
    alike, paths = Counter(map(str.lower, plain)), []
    for i, name in enumerate(plain):
        mark = hashlib.sha256(writable(f"{i} {names[i]}").encode()).hexdigest()[:8]
        is_fit = len(name) <= most and alike[name.lower()] == 1
        paths.append(stem.with_name(f"{stem.name}-{name if is_fit else f'{name[: most - 9]}-{mark}'}"))
    return paths


def check_target(path: Path, force: bool = False, inputs: Iterable[Path] = ()) -> None:
    """Refuse, before any work, to write where it cannot be done, over an input, or over what is not ours."""
    try:
        if path.is_dir():
            raise InputError(f"{path}: is a folder, cannot be written as a file")
        if path.exists() and not path.is_file():
            raise InputError(f"{path}: is a device or a pipe, cannot be written as a file")
        if not path.parent.is_dir():
            raise InputError(f"{path}: the folder {path.parent} does not exist")
        if not os.access(path.parent, os.W_OK):
            raise InputError(f"{path}: the folder {path.parent} is not writable")
        _tidy(real_path(path.parent))
        if path.exists() and any(source.exists() and path.samefile(source) for source in inputs):
            raise InputError(f"{path}: is read by this command, cannot be written too; give another name")
        (_forced.add if force else _forced.discard)(path.absolute())
        _check_ours(path)
    except OSError as error:  # a name that is too long
        raise InputError(f"{path}: cannot be written ({error.strerror})") from None


_forced: set[Path] = set()  # targets that were checked with --force: what appears there later may go too


def _check_ours(path: Path) -> None:
    """InputError where a file stands that jkr did not write, and --force was not given."""
    if path.exists() and path.absolute() not in _forced and not is_ours(path):
        raise InputError(f"{path}: exists and was not written by jkr; give --force to replace it, or another name")


def check_series_target(path: Path, force: bool = False, inputs: Iterable[Path] = ()) -> None:
    """Refuse a target as ``check_target`` does, and for a series a name that promises another format."""
    check_target(path, force, inputs)
    if path.suffix.lower() not in SERIES_ENDINGS:
        raise InputError(f"{path}: a solution is written as HDF5, its name must end in .h5")


def real_path(path: Path) -> Path:
    """The absolute path without links; where they go round in a circle as far as it is known."""
    return Path(os.path.realpath(path))


def make_folder(path: Path) -> None:
    """Create a folder for results, with its parents, where there is none."""
    try:
        path.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(f"{path}: cannot be made a folder ({error.strerror})") from None
    _tidy(real_path(path))


@contextlib.contextmanager
def together() -> Iterator[Staged]:
    """Files that are written within the block take the places of the old ones at its end, one right after the other:
    none of them where it ends badly, within another such block at the end of that.

    Each is written whole to a hidden file beside its place first. JkrError, which names what is new and what is as
    before, where one cannot be put there in the end; KeyboardInterrupt with the same words.
    """
    outer = _staged.get()
    if outer is not None:
        yield outer
        return
    staged: Staged = {}
    token = _staged.set(staged)
    try:
        yield staged
        _put_in_place(staged)
    finally:
        _staged.reset(token)
        for aside in filter(None, staged.values()):
            _remove(aside)


_staged: ContextVar[Staged | None] = ContextVar("_staged", default=None)


@contextlib.contextmanager
def atomic(path: Path) -> Iterator[Path]:
    """A name to write ``path`` under: it is there when the block ends well, as it was before when it does not."""
    with together() as staged:
        aside = path.with_name(f"{ASIDE}{_here()}-{os.getpid()}-{os.urandom(4).hex()}{path.suffix}")
        try:
            yield aside
            with aside.open("r+b") as file:
                os.fsync(file.fileno())
            _stage(staged, path, aside)
        except OSError as error:
            raise JkrError(f"{path}: cannot be written ({error.strerror or error}); nothing was replaced") from None
        finally:
            if staged.get(path) != aside:
                _remove(aside)


def remove_file(path: Path) -> None:
    """Let the file at ``path`` go as ``atomic`` lets one come."""
    with together() as staged:
        _stage(staged, path, None)


def _stage(staged: Staged, path: Path, aside: Path | None) -> None:
    if (earlier := staged.pop(path, None)) is not None:
        _remove(earlier)
    staged[path] = aside


def _put_in_place(staged: Staged) -> None:
    """Give each new file its name; InputError, before the first, where one is in the way that is not to go."""
    for path in staged:
        _check_ours(path)
    try:
        for path, aside in staged.items():
            path.unlink(missing_ok=True) if aside is None else os.replace(aside, path)  # noqa: PTH105 - its name says it
    except (OSError, KeyboardInterrupt) as error:
        is_new = {path: not (path if aside is None else aside).exists() for path, aside in staged.items()}
        new, old = (", ".join(str(path) for path in staged if is_new[path] is here) or "none" for here in (True, False))
        which = f"new: {new}; as before: {old}"
        if isinstance(error, KeyboardInterrupt):
            raise KeyboardInterrupt(which) from None
        raise JkrError(f"{path}: cannot be replaced ({error.strerror or error}); {which}") from None


def _remove(path: Path) -> None:
    with contextlib.suppress(OSError):
        path.unlink()


@functools.cache
def _tidy(folder: Path) -> None:
    """Remove what killed processes left of what they wrote, once for every folder written to: what is old, or of a
    process here that is no more."""
    for path in folder.glob(f"{ASIDE}*"):
        with contextlib.suppress(OSError):
            begun = re.match(rf"{re.escape(ASIDE)}{_here()}-(\d+)-", path.name)
            if time.time() - path.lstat().st_mtime > DAY or (begun and process.has_ended(int(begun[1]))):
                path.unlink()


@functools.cache
def _here() -> str:
    """A name of the processes that see each other: of this machine, or of this container on it."""
    space = Path("/proc/self/ns/pid")
    seen = f"{platform.node()} {space.stat().st_ino if space.exists() else ''}"
    return hashlib.sha256(writable(seen).encode()).hexdigest()[:8]


def write_text(path: Path, text: str) -> None:
    """Write ``text`` atomically."""
    write_bytes(path, text.encode("utf-8", "backslashreplace"))


def write_bytes(path: Path, content: bytes) -> None:
    """Write ``content`` atomically."""
    with atomic(path) as temporary:
        temporary.write_bytes(content)


# --------------------------------------------------------------------------------------------------
# The one form of all tables (CSV) and summaries (JSON) that are written.

FORMULA = ("=", "+", "-", "@")  # how a cell begins that spreadsheets carry out


def write_csv(path: Path, columns: Mapping[str, Iterable[Any]]) -> None:
    """Write columns of one length: a line of their names, then a line per row.

    Numbers have full precision; cells without a value (None, NaN, infinite) are empty; words with commas are quoted;
    words that a spreadsheet would take for a formula are led by an apostrophe, control characters are escapes.
    """
    import csv

    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(map(_cell, columns))
    writer.writerows(zip(*(map(_cell, _plain(values)) for values in columns.values()), strict=True))
    write_text(path, text.getvalue())


def _plain(values: Any) -> Iterable[Any]:
    """The numbers of an array as Python's own, which are written alike everywhere."""
    return values.tolist() if hasattr(values, "tolist") else values


def lists(columns: Mapping[str, Iterable[Any]]) -> dict[str, list[Any]]:
    """Columns for JSON: None where a number is NaN or infinite."""
    return {name: [_finite(value) for value in _plain(values)] for name, values in columns.items()}


def _finite(value: Any) -> Any:
    return None if isinstance(value, float) and not math.isfinite(value) else value


def _cell(value: Any) -> Any:
    if isinstance(value, str):
        return "'" * value.startswith(FORMULA) + printable(value)
    return _finite(value)


# JSON with no NaN or infinity in it, ever; a reason where a number is unknown.
_ENCODING: Mapping[str, Any] = {"allow_nan": False, "default": attrgetter("reason")}
json_line = json.JSONEncoder(**_ENCODING).encode


def as_json(data: Mapping[str, Any], lines: Sequence[str] = ()) -> str:
    """JSON without NaN, over several lines. Of a list of many records, as of the curves of a map, each stands in one
    line; ``lines``: these of its one such list, by ``json_line``, where they are known."""

    def of(value: Any) -> str:
        if isinstance(value, list) and len(value) > RECORDS and isinstance(value[0], dict):
            return "[\n    " + ",\n    ".join(lines or map(json_line, value)) + "\n  ]"
        return json.dumps(value, indent=2, **_ENCODING).replace("\n", "\n  ")

    return "{\n" + ",\n".join(f"  {json_line(name)}: {of(value)}" for name, value in data.items()) + "\n}\n"
