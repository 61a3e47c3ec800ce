"""The page that runs jkr in the browser: its files, the wheel, and the runtime of the folder PYODIDE, where that is."""

from __future__ import annotations

import json
import os
import re
import shutil
import subprocess
import sys
from importlib import metadata
from pathlib import Path

from sphinx.application import Sphinx
from sphinx.errors import ConfigError

import jkrcli

PARTS, ROOT = Path(__file__).with_name("browser_page"), Path(__file__).resolve().parents[2]
ELSEWHERE = {"gmsh", "scikit-fem", "meshio", "psutil"}  # not built for browsers: finite elements, free memory


def packages() -> list[str]:
    """What jkr needs in a browser, by its own dependencies."""
    needed = [line for line in metadata.requires("jkrcli") or [] if "extra ==" not in line]
    return sorted({re.split(r"[^\w-]", line)[0] for line in needed} - ELSEWHERE)


def write(folder: Path, runtime: Path | None) -> None:
    """Write the page into ``folder``, with the ``runtime`` if there is one; ConfigError if that is no such folder."""
    shutil.rmtree(folder, ignore_errors=True)
    shutil.copytree(PARTS, folder, ignore=shutil.ignore_patterns("__pycache__"))
    options = ("--quiet", "--no-deps", "--no-build-isolation", "--no-index")
    subprocess.run([sys.executable, "-m", "pip", "wheel", *options, "-w", folder, ROOT], check=True)
    if runtime is not None:
        if not (runtime / "pyodide.mjs").is_file():
            raise ConfigError(f"PYODIDE: {runtime} holds no pyodide.mjs: give the folder of a release of Pyodide")
        shutil.copytree(runtime, folder / "pyodide")
    wheel = next(folder.glob("*.whl")).name
    setup = {"version": jkrcli.__version__, "wheel": wheel, "packages": packages(), "runtime": runtime is not None}
    (folder / "setup.json").write_text(json.dumps(setup), encoding="utf-8")


def _finish(app: Sphinx, error: Exception | None) -> None:
    if error is None and app.builder.format == "html":
        given = os.environ.get("PYODIDE")
        write(Path(app.outdir, "browser"), Path(given) if given else None)


def setup(app: Sphinx) -> dict[str, bool]:
    app.connect("build-finished", _finish)
    return {"parallel_read_safe": True}
