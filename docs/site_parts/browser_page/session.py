"""One command of jkr in the Python of a browser (Pyodide): what it prints, and the files that it writes.

No threads, processes, locks and limits of a system are needed: ``tests/test_browser.py`` takes them all away.
"""

from __future__ import annotations

import contextlib
import io
import shlex
from pathlib import Path
from typing import Any

from jkrcli.base.errors import InputError
from jkrcli.cli import call


def words_of(command: str) -> list[str]:
    """Split a ``command`` as a shell does, without its leading "jkr"; InputError for a quotation without its end."""
    try:
        words = shlex.split(command)
    except ValueError as error:
        raise InputError(f"{command}: {error}") from None
    return words[1:] if words[:1] == ["jkr"] else words


def run(command: str) -> dict[str, Any]:
    """Run a ``command`` in the current folder.

    Returns
    -------
    dict
        "code", the exit code; "text", stdout and stderr in their order; "files", the paths that are new or changed.
    """
    before, text = _files(), io.StringIO()
    with contextlib.redirect_stdout(text), contextlib.redirect_stderr(text):
        try:
            code = call(words_of(command))
        except InputError as error:
            print(f"jkr: error: {error}")
            code = 2
        except SystemExit as error:
            code = error.code if isinstance(error.code, int) else 1
    files = sorted(str(path) for path, state in _files().items() if before.get(path) != state)
    return {"code": code, "text": text.getvalue(), "files": files}


def _files() -> dict[Path, tuple[int, int]]:
    """All files of the folder with their times and sizes."""
    states = {path: path.stat() for path in Path().rglob("*") if path.is_file()}
    return {path: (state.st_mtime_ns, state.st_size) for path, state in states.items()}
