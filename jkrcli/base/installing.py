"""What to type to install an optional part: in a checkout from there, with the Python that runs, else from an index."""

from __future__ import annotations

import shlex
import sys
from pathlib import Path


def installs(extra: str) -> str:
    """The command that installs the optional part ``extra``, or what is required where it is empty."""
    part = f"[{extra}]" if extra else ""
    root = Path(__file__).parents[2]
    python = shlex.quote(sys.executable or "python3")
    if (root / "pyproject.toml").is_file():
        return f"{python} -m pip install -e {shlex.quote(f'{root}{part}')}"
    return f'{python} -m pip install "jkrcli{part}"'
