"""What of jkr works on this machine: versions, the mesher's system libraries, optional parts, memory, folders."""

from __future__ import annotations

import importlib
import os
import platform
import shutil
import tempfile
from dataclasses import dataclass
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Literal

REQUIRED = (
    "numpy",
    "scipy",
    "h5py",
    "click",
    "pydantic",
    "tomli-w",
    "matplotlib",
    "scikit-fem",
    "meshio",
    "threadpoolctl",
)
OPTIONAL = {
    "cvxopt": ("fast", "a faster sparse factorisation"),
    "afmformats": ("afm", "AFM vendors' files"),
    "distributed": ("cluster", "sweeps on a Dask cluster"),
    "pandas": ("pandas", "curves as data frames"),
    "plotly": ("explore", "the explorer page"),
}
LIBRARIES = "libgl1 libglu1-mesa libxcursor1 libxft2 libxinerama1 libgomp1"
LEAST_MEMORY, LEAST_DISK = 1.0, 0.5  # GiB

State = Literal["ok", "optional", "missing"]


@dataclass(frozen=True)
class Finding:
    """One thing looked at; ``remedy``: what to type where it is not ok."""

    part: str
    state: State
    found: str
    remedy: str = ""


def examine() -> list[Finding]:
    """Everything that is worth looking at, in the order of a report."""
    return [
        Finding("Python", "ok", f"{platform.python_version()} on {platform.platform(terse=True)}"),
        *map(_required, REQUIRED),
        _mesher(),
        *(_optional(name, extra, use) for name, (extra, use) in OPTIONAL.items()),
        _factorisation(),
        _threads(),
        _memory(),
        _scratch(),
    ]


def _required(package: str) -> Finding:
    try:
        return Finding(package, "ok", version(package))
    except PackageNotFoundError:
        return Finding(package, "missing", "not installed", f"pip install {package}")


def _optional(package: str, extra: str, use: str) -> Finding:
    try:
        return Finding(package, "ok", f"{version(package)} ({use})")
    except PackageNotFoundError:
        return Finding(package, "optional", f"not installed ({use})", f'pip install "jkrcli[{extra}]"')


def _mesher() -> Finding:
    """gmsh is installed as a package but needs libraries of the system, which only loading it tells."""
    try:
        importlib.import_module("gmsh")
        return Finding("gmsh", "ok", version("gmsh"))
    except PackageNotFoundError:
        return Finding("gmsh", "ok", "from the system")
    except ImportError:
        return Finding("gmsh", "missing", "not installed", "pip install gmsh")
    except OSError as error:
        return Finding(
            "gmsh",
            "missing",
            f"cannot load: {error}; methods without a mesh work",
            f"sudo apt-get install --no-install-recommends {LIBRARIES}",
        )


def _factorisation() -> Finding:
    try:
        version("cvxopt")
    except PackageNotFoundError:
        return Finding("sparse factor", "ok", "SuperLU (SciPy)")
    return Finding("sparse factor", "ok", "CHOLMOD (cvxopt), SuperLU (SciPy) for mixed elements")


def _threads() -> Finding:
    from threadpoolctl import threadpool_info

    importlib.import_module("scipy.linalg")
    pools = [f"{pool['internal_api']} {pool['num_threads']}" for pool in threadpool_info()]
    return Finding("BLAS threads", "ok", f"{', '.join(pools) or 'unknown'} (jkr uses one, of {os.cpu_count()} cores)")


def _memory() -> Finding:
    free = available_memory()
    if free is None:
        return Finding("memory", "ok", "unknown")
    state: State = "ok" if free >= LEAST_MEMORY else "optional"
    remedy = "" if state == "ok" else "large finite-element meshes will not fit: coarser meshes or another method"
    return Finding("memory", state, f"{free:.1f} GiB available", remedy)


def available_memory() -> float | None:
    """Memory that can still be taken [GiB]; None where the system does not say."""
    try:
        lines = Path("/proc/meminfo").read_text().splitlines()
    except OSError:
        return None
    pairs = dict(line.split(":", 1) for line in lines if ":" in line)
    return int(pairs["MemAvailable"].split()[0]) / 2**20 if "MemAvailable" in pairs else None


def _scratch() -> Finding:
    folder = tempfile.gettempdir()
    try:
        with tempfile.TemporaryFile():
            free = shutil.disk_usage(folder).free / 2**30
    except OSError as error:
        return Finding("temporary files", "missing", f"{folder}: {error}", "set TMPDIR to a folder that can be written")
    state: State = "ok" if free >= LEAST_DISK else "optional"
    return Finding(
        "temporary files", state, f"{folder}, {free:.1f} GiB free", "" if state == "ok" else "free some space"
    )
