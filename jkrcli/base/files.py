"""Files are interfaces: read with one clear error, written whole or not at all, never over what is not ours."""

from __future__ import annotations

import contextlib
import functools
import hashlib
import os
import re
import secrets
from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from contextvars import ContextVar
from pathlib import Path
from typing import BinaryIO

from . import allowance
from .errors import InputError, JkrError, nearest, writable
from .interrupts import Waiting

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
    b"curve,t_s,P_N,P_fit_N,a_fit_m",
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
    b"curve,segment,state,a_m,w_J_per_m2",
    b"file,curve,status,reason,points",
)
HEADS = {  # how a file begins, and what then stands near its head
    b"\x89PNG": b"Software\0jkr ",
    b"<?xml": b"<dc:title>jkr ",
    b"{": b'"format": "jkr-',
}
TAILS = (b"$Comments\njkr ", b"<!-- jkr ")  # of meshes
PARQUET, PARQUET_MARK = b"PAR1", b"jkr-sweep-table"
SHORTEST, LONGEST = 20, 80  # choice: letters of what a file is called after that others gave a name
SERIES_ENDINGS = (".h5", ".hdf5")


def read_bytes(path: Path, what: str, limit: int | None = None) -> bytes:
    """The content of ``path``; InputError where it is missing, a folder, unreadable or beyond ``limit`` bytes (None:
    what is allowed of any file)."""
    limit = allowance.TUNING.size if limit is None else limit
    with allowance.reading(path), opened(path, what) as file:
        if os.fstat(file.fileno()).st_size > limit:
            raise InputError(f"{path}: {what} is larger than {limit >> 20} MiB")
        return file.read()


@contextlib.contextmanager
def opened(path: Path, what: str) -> Iterator[BinaryIO]:
    """The file at ``path`` to read; InputError where it is missing, a folder, a device, a pipe or unreadable."""
    try:
        if path.exists() and not (path.is_file() or path.is_dir()):
            raise InputError(f"{path}: is a device or a pipe, not a {what}")
        with path.open("rb") as file:
            yield file
    except FileNotFoundError:
        raise InputError(f"{path}: {what} not found{_nearby(path)}") from None
    except IsADirectoryError:
        raise InputError(f"{path}: is a folder, not a {what}") from None
    except OSError as error:
        raise InputError(f"{path}: {what} cannot be read ({error.strerror})") from None
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
            from .hdf5 import kind

            return kind(path).startswith("jkr-")
        if head.startswith(PARQUET):
            return _parquet_mark(file)
        file.seek(max(0, path.stat().st_size - 256))
        tail = file.read()
        marked = any(head.startswith(start) and mark in head for start, mark in HEADS.items())
        return marked or head.startswith(CSV_HEADS) or any(mark in tail for mark in TAILS)
    return False


def _parquet_mark(file: BinaryIO) -> bool:
    """Whether the footer of a Parquet file (its length and a magic word are the last 8 bytes) names our format."""
    size = file.seek(-8, os.SEEK_END) + 8
    length = int.from_bytes(file.read(4), "little")
    file.seek(max(0, size - 8 - length))
    return PARQUET_MARK in file.read(min(length, 1 << 24))


def beside(stem: Path, names: Sequence[str]) -> list[Path]:
    """What files are called after ``stem`` and each of the ``names``, which others gave: plain letters, no more than a
    name may have with its ending, all different."""
    most = max(SHORTEST, min(LONGEST, 250 - len(os.fsencode(stem.name))))
    plain = [re.sub(r"[^-_.a-zA-Z0-9]+", "-", name) for name in names]
    alike, found = Counter(map(str.lower, plain)), []
    for i, name in enumerate(plain):
        mark = hashlib.sha256(writable(f"{i} {names[i]}").encode()).hexdigest()[:8]
        is_fit = len(name) <= most and alike[name.lower()] == 1
        found.append(stem.with_name(f"{stem.name}-{name if is_fit else f'{name[: most - 9]}-{mark}'}"))
    return found


def check_target(path: Path, force: bool = False, inputs: Iterable[Path] = ()) -> None:
    """Refuse, before any work, to write where it cannot be done, over an input, or over what is not ours."""
    try:
        _check_target(path, force, inputs)
    except OSError as error:  # a name that is too long
        raise InputError(f"{path}: cannot be written ({error.strerror})") from None


def _check_target(path: Path, force: bool, inputs: Iterable[Path]) -> None:
    if path.is_dir():
        raise InputError(f"{path}: is a folder, cannot be written as a file")
    if path.exists() and not path.is_file():
        raise InputError(f"{path}: is a device or a pipe, cannot be written as a file")
    if not path.parent.is_dir():
        raise InputError(f"{path}: the folder {path.parent} does not exist")
    if not os.access(path.parent, os.W_OK):
        raise InputError(f"{path}: the folder {path.parent} is not writable")
    _tidy(real(path.parent))
    if not path.exists():
        return
    if any(source.exists() and path.samefile(source) for source in inputs):
        raise InputError(f"{path}: is read by this command, cannot be written too; give another name")
    if not force and not is_ours(path):
        raise InputError(f"{path}: exists and was not written by jkr; give --force to replace it, or another name")


def check_series_target(path: Path, force: bool = False, inputs: Iterable[Path] = ()) -> None:
    """Refuse a target as ``check_target`` does, and for a series a name that promises another format."""
    check_target(path, force, inputs)
    if path.suffix.lower() not in SERIES_ENDINGS:
        raise InputError(f"{path}: a series is written as HDF5, its name must end in .h5")


def real(path: Path) -> Path:
    """The absolute path without links; where they go round in a circle as far as it can be told."""
    return Path(os.path.realpath(path))


def make_folder(path: Path) -> None:
    """Create a folder for results, with its parents, where there is none."""
    try:
        path.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(f"{path}: cannot be made a folder ({error.strerror})") from None
    _tidy(real(path))


@contextlib.contextmanager
def atomic(path: Path) -> Iterator[Path]:
    """A temporary name beside ``path``, renamed to it when the block ends well, removed when it does not.

    A process that is killed leaves its temporary file; the next one that writes into the folder removes it.
    """
    temporary = path.with_name(f"{_mark()}{os.getpid()}-{secrets.token_hex(4)}{path.suffix}")
    with together() as written:
        written[temporary] = None  # known before it is there: Ctrl-C leaves none behind
        try:
            try:
                temporary.open("xb").close()
            except OSError as error:
                raise InputError(f"{path}: cannot be written ({error.strerror})") from None
            yield temporary
            with temporary.open("rb") as file:
                os.fsync(file.fileno())
            written[temporary] = path
        except OSError as error:
            raise JkrError(f"{path}: cannot be written ({error.strerror or error})") from None
        finally:
            if written[temporary] is None:
                _remove(temporary)


@contextlib.contextmanager
def together() -> Iterator[dict[Path, Path | None]]:
    """Files that are written within the block replace the old ones at its end, all of them or, where it ends badly,
    none; within another such block at the end of that. What it gives: targets by their temporary names, None until a
    file is whole."""
    outer = _written.get()
    if outer is not None:
        yield outer
        return
    written: dict[Path, Path | None] = {}
    token = _written.set(written)
    try:
        yield written
        with Waiting():  # so that Ctrl-C finds all of them replaced
            for temporary, path in written.items():
                if path is not None:
                    _replace(temporary, path)
    finally:
        _written.reset(token)
        for temporary in written:
            _remove(temporary)


_written: ContextVar[dict[Path, Path | None] | None] = ContextVar("_written", default=None)


def _replace(temporary: Path, path: Path) -> None:
    try:
        temporary.replace(path)
    except OSError as error:
        raise JkrError(f"{path}: cannot be written ({error.strerror})") from None


def _remove(temporary: Path) -> None:
    with contextlib.suppress(OSError):
        temporary.unlink(missing_ok=True)


def _mark() -> str:
    """How the names of this machine's temporary files begin; the number of their process follows."""
    return f".jkr-{re.sub(r'[^A-Za-z0-9]', '', os.uname().nodename)}-"


@functools.cache
def _tidy(folder: Path) -> None:
    """Remove temporary files of processes of this machine that were killed, once for every folder written to."""
    with contextlib.suppress(OSError):
        for path in folder.glob(f"{_mark()}*"):
            number = path.name.removeprefix(_mark()).split("-")[0]
            if number.isdigit() and not _is_running(int(number)):
                path.unlink(missing_ok=True)


def _is_running(process: int) -> bool:
    try:
        os.kill(process, 0)
    except ProcessLookupError:
        return False
    except (PermissionError, OverflowError):
        return True
    return True


def write_text(path: Path, text: str) -> None:
    """Write ``text`` atomically."""
    write_bytes(path, text.encode("utf-8", "backslashreplace"))


def write_bytes(path: Path, content: bytes) -> None:
    """Write ``content`` atomically."""
    with atomic(path) as temporary:
        temporary.write_bytes(content)
