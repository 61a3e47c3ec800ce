"""Files are interfaces: read with one clear error, written whole or not at all, never over what is not ours."""

from __future__ import annotations

import contextlib
import csv
import errno
import functools
import gzip
import hashlib
import io
import json
import math
import os
import re
import secrets
import shutil
import stat
import time
import zlib
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextvars import ContextVar
from dataclasses import dataclass
from operator import attrgetter
from pathlib import Path
from typing import Any, BinaryIO, TypeAlias, cast

from . import process as allowance
from . import process as locks
from .errors import InputError, JkrError, nearest, printable, writable
from .interrupts import Waiting
from .numerics import MOST_STEPS


@dataclass(frozen=True)
class FilesTuning:
    """Names that others gave."""

    letters: tuple[int, int] = (20, 80)  # choice: least and most that a name keeps of what a file is called after


TUNING = FilesTuning()
CSV_HEADS = (
    b"number,method,column,ratio,stated",  # our tables carry no mark but their own header
    b"a_m,delta_m,P_N,delta_H_m,P_H_N,S_N_per_m",
    b"r_m,pressure_Pa,displacement_m,gap_m",
    b"r_m,pressure_Pa,shear_Pa,displacement_m",
    b"line,depth_m,r_m,sigma_zz_Pa",
    b"a_m,delta_m,P_N,device_m,phase",
    b"a_m,delta_m,P_N,phase",  # under load control
    b"t_s,a_m,delta_m,P_N,device_m,speed_m_per_s",
    b"t_s,a_m,delta_m,P_N,speed_m_per_s",  # the same
    b"t_s,a_m,delta_m,P_N,device_m,phase",  # of a specimen that relaxes
    b"t_s,a_m,delta_m,P_N,phase",  # the same
    b"curve,t_s,P_N,P_fit_N,a_fit_m",
    b"curve,delta_m,P_N,P_fit_N",
    b"curve,law,",
    b"nu,base,w_R2_over_Estar_h3",
    b"nu,a_over_h,S_ratio,load_ratio",
    b"h_over_R,k_over_Estar_R,V_over_v0",
    b"size_m,elements,unknowns,a_m",
    b"body,points,noise,method,median",
    b"case,status,reason,",
    b"case,reason,command",
    b"algorithm,field,shipped",
    b"method,setting,slopes,unknowns",
    b"method,outcome,nu,a_over_h",
    b"fraction,delta_m,P_N,a_m",
    b"curve,segment,state,a_m,w_J_per_m2",
    b"file,curve,status,reason,points",
)
HEADS = {  # how a file begins, and what then stands near its head
    b"\x89PNG": b"Software\0jkr ",
    b"<?xml": b"<dc:title>jkr ",
    b"{": b'"format": "jkr-',
    b"/* Written by jkr: ": b"#ifndef JKR_CONTACT_H",
}
TAILS = (b"$Comments\njkr ", b"<!-- jkr ")  # of meshes
PARQUET, PARQUET_MARK = b"PAR1", b"jkr-sweep-table"
SERIES_ENDINGS = (".h5", ".hdf5")
MARK, LOCK = ".jkr-", ".lock"  # of hidden folders and the files beside them
PENDING = ".jkr-pending"
PART, WHOLE, NEW = "part", "whole", "new"  # folders in a hidden one
Stages: TypeAlias = dict[Path, tuple[Path, BinaryIO]]  # hidden folders and their locks, by the folders written to


def read_bytes(path: Path, what: str, limit: int | None = None) -> bytes:
    """The content of ``path``; InputError where it is missing, a folder, unreadable or beyond ``limit`` bytes (None:
    what is allowed of any file)."""
    limit = allowance.TUNING.size if limit is None else limit
    with allowance.allowance_of(path), opened(path, what) as file:
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
        _finish(path.parent)
        with path.open("rb") as file:
            yield cast(BinaryIO, gzip.GzipFile(fileobj=file)) if packed(path) else file
    except FileNotFoundError:
        raise InputError(f"{path}: {what} not found{_nearby(path)}") from None
    except IsADirectoryError:
        raise InputError(f"{path}: is a folder, not a {what}") from None
    except OSError as error:
        raise InputError(f"{path}: {what} cannot be read ({error.strerror or error})") from None
    except (EOFError, zlib.error) as error:
        raise InputError(f"{path}: {what} cannot be unpacked ({error})") from None
    except ValueError as error:  # a null character in the name
        raise InputError(f"{path}: {what} cannot be read ({error})") from None


def _nearby(path: Path) -> str:
    with contextlib.suppress(OSError):
        close = nearest(path.name, [p.name for p in path.parent.iterdir() if p.suffix == path.suffix], 0.6)
        return "" if close is None else f', did you mean "{path.parent / close}"?'
    return ""


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
        return marked or head.startswith(CSV_HEADS) or any(mark in tail for mark in TAILS)
    return False


def beside(stem: Path, names: Sequence[str]) -> list[Path]:
    """What files are called after ``stem`` and each of the ``names``, which others gave: plain letters, no more than a
    name may have with its ending, all different."""
    shortest, longest = TUNING.letters
    most = max(shortest, min(longest, 250 - len(os.fsencode(stem.name))))
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
        _finish(path.parent)
        _tidy(real_path(path.parent))
        if path.exists() and any(source.exists() and path.samefile(source) for source in inputs):
            raise InputError(f"{path}: is read by this command, cannot be written too; give another name")
        (_forced.add if force else _forced.discard)(path.absolute())
        _goes_by_force(path)
    except OSError as error:  # a name that is too long
        raise InputError(f"{path}: cannot be written ({error.strerror})") from None


_forced: set[Path] = set()  # targets that were checked with --force: what appears there later may go too


def _goes_by_force(path: Path) -> bool:
    """Whether a file that jkr did not write is to go, as --force was given; InputError where it was not."""
    if not path.exists() or is_ours(path):
        return False
    if path.absolute() not in _forced:
        raise InputError(f"{path}: exists and was not written by jkr; give --force to replace it, or another name")
    return True


def check_series_target(path: Path, force: bool = False, inputs: Iterable[Path] = ()) -> None:
    """Refuse a target as ``check_target`` does, and for a series a name that promises another format."""
    check_target(path, force, inputs)
    if path.suffix.lower() not in SERIES_ENDINGS:
        raise InputError(f"{path}: a series is written as HDF5, its name must end in .h5")


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
def atomic(path: Path) -> Iterator[Path]:
    """A name to write ``path`` under: it is there when the block ends well, as it was before when it does not."""
    with together() as stages:
        try:
            stage = _stage(path.parent, stages)
            temporary = stage / PART / path.name
            yield temporary
            with temporary.open("r+b") as file:
                os.fsync(file.fileno())
            temporary.replace(stage / WHOLE / NEW / path.name)
        except OSError as error:
            raise JkrError(f"{path}: cannot be written ({error.strerror or error})") from None


def remove_file(path: Path) -> None:
    """Let the file at ``path`` go as ``atomic`` lets one come; an empty folder stands for it until then."""
    with together() as stages:
        (_stage(path.parent, stages) / WHOLE / NEW / path.name).mkdir()


@contextlib.contextmanager
def together() -> Iterator[Stages]:
    """Files that are written within the block replace the old ones at its end, all of them or, where it ends badly,
    none; within another such block at the end of that.

    They are written into a hidden folder beside them. The renaming of that to ``PENDING`` makes them the result; then
    each goes to its place. What a process leaves that is killed before is removed by the next command that writes
    there; behind that moment the next one that reads or writes there carries on.
    """
    outer = _stages.get()
    if outer is not None:
        yield outer
        return
    stages: Stages = {}
    token = _stages.set(stages)
    try:
        yield stages
        with Waiting():  # so that Ctrl-C finds all of them replaced
            for folder, (stage, _) in stages.items():
                _commit(folder, stage / WHOLE)
            _drop(stages)
    finally:
        _stages.reset(token)
        _drop(stages)


_stages: ContextVar[Stages | None] = ContextVar("_stages", default=None)


def _stage(folder: Path, stages: Stages) -> Path:
    """The hidden folder for files of ``folder``; a lock on the file beside it shows that its process lives."""
    while folder not in stages:
        stage = folder / f"{MARK}{secrets.token_hex(8)}"
        with Waiting():
            lock = stage.with_suffix(LOCK).open("xb")
            if locks.taken(lock) is not False and stage.with_suffix(LOCK).exists():  # else a ``_tidy`` was faster
                stages[folder] = stage, lock
                (stage / WHOLE / NEW).mkdir(parents=True)
                (stage / PART).mkdir()
    return stages[folder][0]


def _drop(stages: Stages) -> None:
    for stage, lock in stages.values():
        shutil.rmtree(stage, ignore_errors=True)
        lock.close()
        with contextlib.suppress(OSError):
            stage.with_suffix(LOCK).unlink()


@functools.cache
def _tidy(folder: Path) -> None:
    """Remove what processes that are no more were writing, once for every folder written to."""
    for path in folder.glob(f"{MARK}*{LOCK}"):
        with contextlib.suppress(OSError), path.open("r+b") as lock:
            is_free = locks.taken(lock)
            day = 86_400  # choice: s, after which, where there are no locks, nobody is taken to be writing
            if is_free or (is_free is None and time.time() - path.stat().st_mtime > day):
                _drop({folder: (path.with_suffix(""), lock)})


def _commit(folder: Path, whole: Path) -> None:
    """Make the files in ``whole`` those of ``folder``; InputError where one appeared there that is not to go."""
    for new in list((whole / NEW).iterdir()):
        if _goes_by_force(folder / new.name):  # which of all files, for whoever has to carry on
            known = whole / str((folder / new.name).stat().st_ino)
            known.mkdir(exist_ok=True)
            new.rename(known / new.name)
    for _ in range(MOST_STEPS):
        _finish(folder)
        with contextlib.suppress(OSError):  # another process may come first
            whole.rename(folder / PENDING)
            break
    else:
        raise JkrError(f"{folder / PENDING}: is in the way of new files; move it away")
    _finish(folder)


def _finish(folder: Path) -> None:
    """Put the files of a complete result in their places, this process's or those of one that was killed meanwhile;
    several may do so at once, because each file can be taken only once. InputError where one cannot be put there."""
    pending = folder / PENDING
    if pending.is_symlink() or not pending.is_dir() or _is_anothers(pending):
        return
    try:
        for new in _left(pending):
            _place(new, folder / new.name)
    except OSError as error:
        names = ", ".join(sorted(new.name for new in _left(pending)))
        raise InputError(
            f"{error.filename2 or error.filename}: cannot be replaced ({error.strerror}), while other files of its "
            f"result are new; move it away and run the command again, or remove {pending} with what is left ({names})"
        ) from None
    with contextlib.suppress(OSError):  # another process did, or put the next result there
        for part in (*pending.glob("*"), pending):
            part.rmdir()


def _left(pending: Path) -> list[Path]:
    """The files that have no place yet; a folder that another process takes away meanwhile holds none."""

    def inside(folder: Path) -> list[Path]:
        with contextlib.suppress(FileNotFoundError, NotADirectoryError):
            return sorted(folder.iterdir())
        return []

    return [new for part in inside(pending) for new in inside(part)]


def _is_anothers(pending: Path) -> bool:
    """Whether it is another user's, in a folder such as /tmp where all may write but nobody over others' files."""
    with contextlib.suppress(FileNotFoundError):
        return bool(pending.parent.stat().st_mode & stat.S_ISVTX) and pending.stat().st_uid != os.geteuid()
    return False


def _place(new: Path, path: Path) -> None:
    """Give ``new`` the name ``path``; OSError where that cannot be, or stands for what is not to be replaced."""
    with contextlib.suppress(FileNotFoundError):  # another process was faster
        try:
            os.link(new, path)  # unlike renaming it never replaces what appeared this very moment
        except OSError:
            is_known = not path.exists() or str(path.stat().st_ino) == new.parent.name
            if not (is_known or is_ours(path) or path.samefile(new)):
                raise FileExistsError(errno.EEXIST, "it was not written by jkr", str(path)) from None
            if new.is_dir():
                path.unlink(missing_ok=True)
                new.rmdir()
            else:
                new.replace(path)
        if new.samefile(path):  # linked; else it is gone, or that of the next result, which another put there
            new.unlink()


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
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(map(_cell, columns))
    writer.writerows(zip(*(map(_cell, _plain(values)) for values in columns.values()), strict=True))
    write_text(path, text.getvalue())


def _plain(values: Any) -> Iterable[Any]:
    """The numbers of an array as Python's own, which are written alike everywhere."""
    plain: Iterable[Any] = values.tolist() if hasattr(values, "tolist") else values
    return plain


def lists(columns: Mapping[str, Iterable[Any]]) -> dict[str, list[Any]]:
    """Columns for JSON: None where a number is NaN or infinite."""
    return {name: [_finite(value) for value in _plain(values)] for name, values in columns.items()}


def _finite(value: Any) -> Any:
    return None if isinstance(value, float) and not math.isfinite(value) else value


def _cell(value: Any) -> Any:
    if isinstance(value, str):
        return "'" * value.startswith(FORMULA) + printable(value)
    return _finite(value)


def as_json(data: Mapping[str, Any]) -> str:
    """JSON with no NaN or infinity in it, ever; a reason where a number is unknown."""
    return json.dumps(data, indent=2, allow_nan=False, default=attrgetter("reason")) + "\n"
