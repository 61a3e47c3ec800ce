"""Files are interfaces: read with one clear error, written whole or not at all, never over what is not ours."""

from __future__ import annotations

import contextlib
import os
import tempfile
from collections.abc import Iterator
from pathlib import Path

from .errors import InputError, JkrError

MARK = b"jkr"
CSV_HEADS = (  # our tables carry no mark but their own header
    b"a_m,delta_m,P_N,delta_H_m,P_H_N,S_N_per_m",
    b"r_m,pressure_Pa,displacement_m,gap_m",
    b"a_m,delta_m,P_N,device_m,phase",
    b"nu,base,w_R2_over_Estar_h3",
    b"size_m,elements,unknowns,a_m",
    b"body,points,noise,method,median",
)
HDF5 = b"\x89HDF\r\n\x1a\n"


def read_bytes(path: Path, what: str, limit: int = 1 << 30) -> bytes:
    """The content of ``path``; InputError where it is missing, a folder, unreadable or beyond ``limit`` bytes."""
    try:
        if path.stat().st_size > limit:
            raise InputError(f"{path}: {what} is larger than {limit >> 20} MiB, got {path.stat().st_size >> 20} MiB")
        return path.read_bytes()
    except FileNotFoundError:
        raise InputError(f"{path}: {what} not found{_nearby(path)}") from None
    except IsADirectoryError:
        raise InputError(f"{path}: is a folder, not a {what}") from None
    except OSError as error:
        raise InputError(f"{path}: {what} cannot be read ({error.strerror})") from None


def _nearby(path: Path) -> str:
    import difflib

    with contextlib.suppress(OSError):
        names = [p.name for p in path.parent.iterdir() if p.suffix == path.suffix]
        close = difflib.get_close_matches(path.name, names, 1, 0.6)
        if close:
            return f', did you mean "{path.parent / close[0]}"?'
    return ""


def is_ours(path: Path) -> bool:
    """Whether ``jkr`` wrote this file: its mark stands at the head or the end (HDF5: the format)."""
    with contextlib.suppress(OSError), path.open("rb") as file:
        head = file.read(4096)
        if head.startswith(HDF5):
            return _hdf5_is_ours(path)
        file.seek(max(0, path.stat().st_size - 256))
        return MARK in head + file.read() or head.startswith(CSV_HEADS)
    return False


def _hdf5_is_ours(path: Path) -> bool:
    import h5py

    with contextlib.suppress(OSError), h5py.File(path, "r") as file:
        kind = file.attrs.get("format", b"")
        return isinstance(kind, bytes) and kind.startswith(b"jkr-")
    return False


def check_target(path: Path, force: bool = False) -> None:
    """Refuse, before any work, to write where it cannot be done or would destroy what is not ours."""
    if path.is_dir():
        raise InputError(f"{path}: is a folder, cannot be written as a file")
    if not path.parent.is_dir():
        raise InputError(f"{path}: the folder {path.parent} does not exist")
    if not os.access(path.parent, os.W_OK):
        raise InputError(f"{path}: the folder {path.parent} is not writable")
    if path.exists() and not force and not is_ours(path):
        raise InputError(f"{path}: exists and was not written by jkr; give --force to replace it, or another name")


@contextlib.contextmanager
def atomic(path: Path) -> Iterator[Path]:
    """A temporary name beside ``path``, renamed to it when the block ends well, removed when it does not."""
    try:
        handle, name = tempfile.mkstemp(prefix=f".{path.stem}.", suffix=path.suffix, dir=path.parent)
    except OSError as error:
        raise InputError(f"{path}: cannot be written ({error.strerror})") from None
    os.close(handle)
    temporary = Path(name)
    try:
        yield temporary
        with temporary.open("rb") as file:
            os.fsync(file.fileno())
        temporary.chmod(0o666 & ~_umask())
        temporary.replace(path)
    except OSError as error:
        raise JkrError(f"{path}: cannot be written ({error.strerror or error})") from None
    finally:
        temporary.unlink(missing_ok=True)


def _umask() -> int:
    mask = os.umask(0)
    os.umask(mask)
    return mask


def write_text(path: Path, text: str) -> None:
    """Write ``text`` atomically."""
    with atomic(path) as temporary:
        temporary.write_text(text, encoding="utf-8")
