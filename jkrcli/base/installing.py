"""What to type to install an optional part: in a checkout from there, with the Python that runs, else its packages."""

from __future__ import annotations

import shlex
import sys
from importlib import metadata
from pathlib import Path


def installs(extra: str) -> str:
    """The command that installs the optional part ``extra``, or what is required where it is empty."""
    root = Path(__file__).parents[2]
    if (root / "pyproject.toml").is_file():
        words = ["-e", f"{root}[{extra}]" if extra else str(root)]
    else:
        words = _packages(extra)
    return shlex.join([sys.executable or "python3", "-m", "pip", "install", *words])


def _packages(extra: str) -> list[str]:
    """The packages of a part as the installed metadata name them: this one may be on no index."""
    try:
        required = metadata.requires("jkrcli") or []
    except metadata.PackageNotFoundError:
        required = []
    parts = (line.partition(";") for line in required)
    return [name.strip() for name, _, when in parts if (f'"{extra}"' in when if extra else not when)]
