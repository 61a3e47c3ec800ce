"""What of jkr works on this machine: packages, the mesher's libraries, threads, memory, temporary files."""

from __future__ import annotations

import importlib
import math
import os
import platform
import shutil
import tempfile
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass
from importlib.metadata import PackageNotFoundError, version
from typing import Any, Literal

from .. import __version__
from ..base.errors import installs
from ..base.process import free_memory
from ..base.result import Result

REQUIRED = ("numpy", "scipy", "h5py", "click", "pydantic", "tomli-w", "matplotlib", "threadpoolctl")
OPTIONAL = {  # package: extra, use
    "scikit-fem": ("fem", "finite elements"),
    "meshio": ("fem", "meshes and fields for ParaView"),
    "cvxopt": ("fast", "a faster sparse factorisation"),
    "afmformats": ("afm", "AFM vendors' files"),
    "distributed": ("cluster", "sweeps on a Dask cluster"),
    "pandas": ("pandas", "curves as data frames"),
    "plotly": ("explore", "the explorer page"),
}
LIBRARIES = "libgl1 libglu1-mesa libxcursor1 libxft2 libxinerama1 libgomp1"
MARKS = {"ok": "ok      ", "optional": "optional", "missing": "MISSING "}


@dataclass(frozen=True)
class Finding:
    """One thing looked at; ``remedy``: what to type where it is not ok."""

    part: str
    state: Literal["ok", "optional", "missing"]
    found: str
    remedy: str = ""


@dataclass(frozen=True)
class Machine(Result):
    """What was looked at; it ``is_sound`` where everything required works."""

    findings: Sequence[Finding]

    @classmethod
    def examined(cls) -> Machine:
        """This machine."""
        return cls(list(examine()))

    @property
    def is_sound(self) -> bool:
        return all(finding.state != "missing" for finding in self.findings)

    def summary(self) -> dict[str, Any]:
        return {"jkr": __version__, "sound": self.is_sound, "findings": [asdict(finding) for finding in self.findings]}

    def words(self) -> list[str]:
        works = sum(finding.state == "ok" for finding in self.findings)
        sound = "is sound" if self.is_sound else "is NOT sound"
        lines = [f"{works} of {len(self.findings)} parts work; jkr {__version__} {sound}"]
        for finding in sorted(self.findings, key=lambda finding: finding.state == "ok"):  # what lacks first
            remedy = f"; type: {finding.remedy}" if finding.remedy else ""
            lines.append(f"  {MARKS[finding.state]}  {finding.part:<16} {finding.found}{remedy}")
        return lines


def examine() -> Iterator[Finding]:
    """Everything that is worth looking at, in the order of a report."""
    yield Finding("Python", "ok", f"{platform.python_version()} on {platform.platform(terse=True)}")
    yield from map(_package, REQUIRED)
    yield _mesher()
    extras = {package: _package(package, extra, f" ({use})") for package, (extra, use) in OPTIONAL.items()}
    yield from extras.values()
    cholmod = "CHOLMOD (cvxopt), SuperLU (SciPy) for mixed elements"
    yield Finding("sparse factor", "ok", cholmod if extras["cvxopt"].state == "ok" else "SuperLU (SciPy)")
    yield _threads()
    yield _memory()
    yield _scratch()


def _package(package: str, extra: str = "", use: str = "") -> Finding:
    """A package; one of an ``extra`` is optional, with its ``use``."""
    try:
        return Finding(package, "ok", f"{version(package)}{use}")
    except PackageNotFoundError:
        return Finding(package, "optional" if extra else "missing", f"not installed{use}", installs(extra))


def _mesher() -> Finding:
    """gmsh is installed as a package but needs libraries of the system, which only loading it tells."""
    try:
        importlib.import_module("gmsh")
        return Finding("gmsh", "ok", version("gmsh"))
    except PackageNotFoundError:
        return Finding("gmsh", "ok", "from the system")
    except ImportError:
        return Finding("gmsh", "optional", "not installed (finite elements)", installs("fem"))
    except OSError as error:
        remedy = f"sudo apt-get install --no-install-recommends {LIBRARIES}"
        return Finding("gmsh", "missing", f"cannot load: {error}; methods without a mesh work", remedy)


def _threads() -> Finding:
    from threadpoolctl import threadpool_info

    importlib.import_module("scipy.linalg")
    pools = [f"{pool['internal_api']} {pool['num_threads']}" for pool in threadpool_info()]
    return Finding("BLAS threads", "ok", f"{', '.join(pools) or 'unknown'} (jkr uses one, of {os.cpu_count()} cores)")


def _memory() -> Finding:
    """What is free for a solve, one GiB of it asked for."""
    free = free_memory() / 1024
    words = "unknown" if math.isinf(free) else f"{free:.1f} GiB available"
    remedy = "large finite-element meshes will not fit: coarser meshes or another method"
    return Finding("memory", "ok", words) if free >= 1 else Finding("memory", "optional", words, remedy)


def _scratch() -> Finding:
    """The folder of temporary files, half a GiB asked for."""
    try:
        with tempfile.TemporaryFile():
            folder = tempfile.gettempdir()
            free = shutil.disk_usage(folder).free / 2**30
    except OSError as error:
        reason = error.strerror or str(error)
        return Finding("temporary files", "missing", reason, "set TMPDIR to a folder that can be written")
    lacking = () if free >= 0.5 else ("free some space",)
    return Finding("temporary files", "optional" if lacking else "ok", f"{folder}, {free:.1f} GiB free", *lacking)
