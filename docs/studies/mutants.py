"""Whether the fast tests notice slips in what is computed: one is made at a time, in a copy, where a test must fail."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
import tempfile
import tomllib
from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from importlib.util import cache_from_source
from pathlib import Path

from jkrcli.base.errors import InputError, SolveError
from jkrcli.base.executors import completed
from jkrcli.base.process import ONE_THREAD

from .command import call, parser_of, pool_of

LIST = Path(__file__).with_suffix(".toml")
ROOT = LIST.parents[2]
COPIED = ("jkrcli", "tests", "cases", "docs/studies", "pyproject.toml")

# What a slip takes.
MUTANTS_SECONDS = 6.0  # choice: CPU seconds, for the number of processes; most take 3 to 10
MUTANTS_LONGEST = 1200.0  # choice: seconds after which tests have no end; ten times those of all


@dataclass(frozen=True)
class Slip:
    """``what`` goes wrong where the text ``old``, once in a ``file`` of the package, becomes ``new``; ``tests``: words
    of pytest below the folder of the tests."""

    file: str
    what: str
    old: str
    new: str
    tests: tuple[str, ...]

    def made(self, tree: Path) -> tuple[Path, str]:
        """The file in a ``tree`` and its text with the slip; InputError where ``old`` does not stand there once."""
        path = tree / "jkrcli" / self.file
        text = path.read_text(encoding="utf-8") if path.is_file() else ""
        if (count := text.count(self.old)) != 1:
            raise InputError(f"mutants: jkrcli/{self.file} must hold once, and holds {count} times: {self.old}")
        return path, text.replace(self.old, self.new)


def slips() -> list[Slip]:
    """The list beside this file."""
    listed = tomllib.loads(LIST.read_text(encoding="utf-8"))["slips"]
    return [Slip(**item | {"tests": tuple(item["tests"])}) for item in listed]


def main(words: Sequence[str] | None = None) -> int:
    """Make the slips of mutants.toml one at a time in a copy of the package, and run the fast tests that each
    names, which have to fail.

    Prints a table and how many were noticed; the exit code is 1 where any was not. A slip whose text is no longer
    there, or whose tests do not run, is an error.
    """
    parser = parser_of(str(main.__doc__))
    parser.add_argument("files", nargs="*", help="parts of names of files, such as coloured [default: all]")
    given = parser.parse_args(words)
    asked = [slip for slip in slips() if not given.files or any(part in slip.file for part in given.files)]
    if not asked:
        raise InputError(f"mutants: no slip is in a file called {' or '.join(given.files)}")
    for slip in asked:
        slip.made(ROOT)
    print(f"{len(asked)} slips; first the tests that they name, without any", flush=True)
    with tempfile.TemporaryDirectory() as folder, pool_of(given, MUTANTS_SECONDS * len(asked)) as pool:
        base = copied(ROOT, Path(folder))
        refuse_failing(base, asked)
        print("\n| file | slip | noticed by |\n|---|---|---|", flush=True)
        noticed = 0
        for index, found in completed(pool, partial(noticed_by, base), asked, "mutants"):
            if isinstance(found, Exception):
                raise found
            noticed += bool(found)
            print(f"| {asked[index].file} | {asked[index].what} | {found or 'NOTHING'} |", flush=True)
    print(f"\n{noticed} of {len(asked)} noticed")
    return int(noticed < len(asked))


def copied(root: Path, folder: Path) -> Path:
    """What the tests need of the tree ``root``, in a new folder within ``folder``."""
    base = Path(tempfile.mkdtemp(dir=folder))
    for part in COPIED:
        if (root / part).is_dir():
            shutil.copytree(root / part, base / part)
        elif (root / part).exists():
            shutil.copy2(root / part, base / part)
    return base


def refuse_failing(base: Path, asked: Sequence[Slip]) -> None:
    """SolveError where tests that are named fail without any slip; they leave the tree ``base`` compiled."""
    code, said = tested(base, sorted({test for slip in asked for test in slip.tests}))
    if code:
        raise SolveError(f"mutants: the tests fail before anything is changed: {said}")


def noticed_by(base: Path, slip: Slip) -> str:
    """The first test that fails on a copy of ``base`` with a ``slip``, empty where none does; SolveError where they
    do not run."""
    with tempfile.TemporaryDirectory() as folder:
        tree = copied(base, Path(folder))
        path, text = slip.made(tree)
        path.write_text(text, encoding="utf-8")
        Path(cache_from_source(str(path))).unlink(missing_ok=True)
        code, said = tested(tree, slip.tests)
    if code not in (0, 1):
        raise SolveError(f"mutants: {slip.file}, {slip.what}: its tests do not run (exit code {code}): {said}")
    return said if code else ""


def tested(tree: Path, tests: Sequence[str]) -> tuple[int, str]:
    """Exit code of pytest on fast ``tests`` of a ``tree``, and the first that fails, or its last words."""
    words = ["-x", "-q", "-n", "0", "-m", "not slow", *(f"tests/{test}" for test in tests)]
    kept = {name: value for name, value in os.environ.items() if name != "PYTHONDONTWRITEBYTECODE"}
    try:
        done = subprocess.run(
            [sys.executable, "-m", "pytest", *words], cwd=tree, env=kept | ONE_THREAD | {"PYTHONPATH": str(tree)},
            stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, timeout=MUTANTS_LONGEST,
        )  # fmt: skip
    except subprocess.TimeoutExpired:
        raise SolveError(f"mutants: {', '.join(tests)}: no end after {MUTANTS_LONGEST:g} s") from None
    failed = re.search(r"^(?:FAILED|ERROR) tests/(.+?)(?: - |$)", done.stdout, re.MULTILINE)
    return done.returncode, failed[1] if failed else " / ".join(done.stdout.strip().splitlines()[-2:])


if __name__ == "__main__":
    sys.exit(call(main))
