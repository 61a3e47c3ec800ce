"""The core alone: a copy of the project without the folders of its wings and their tests.

The shipped cases go through the verbs of the core in both, and what is said and written is the same to the byte, but
for times and what is said of the methods of wings; then the tests of the core's rooms that need no wing run in the
copy, in the arithmetic of most laptops.
"""

from __future__ import annotations

import argparse
import os
import re
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from jkrcli.base.wings import PACKAGE, wings

from .command import call
from .processors import arithmetic, settings

ABOUT = "The core without its wings: shipped cases beside those of the whole, and its tests (six minutes)"
ROOT = PACKAGE.parent
ROOMS = ("base", "tables", "formulas", "bodies", "series", "methods", "case", "adhesion", "resolve")
KEPT = (
    "jkrcli", "cases", "tests", "docs/studies", "docs/examples", "pyproject.toml", "Makefile", "LICENSE-EXCEPTION.md",
)  # fmt: skip
SLOW = ("rough", "fem")  # cases of minutes, by a part of their names
VERBS = (
    "check {case} -v", "run {case} -o s.h5", "transform s.h5 --no-plots --json -o .", "pull-off s.h5 --json",
    "cycle s.h5 --no-plots --json -o .", "show --json s.h5",
)  # fmt: skip


def copied(folder: Path) -> Path:
    """The project without its wings, in a ``folder``."""
    names = [wing.name for wing in wings()]
    for kept in KEPT:
        source, target = ROOT / kept, folder / kept
        target.parent.mkdir(parents=True, exist_ok=True)
        if source.is_file():
            shutil.copy(source, target)
        else:
            shutil.copytree(source, target, ignore=shutil.ignore_patterns("__pycache__", ".hypothesis"))
    # What the copy lacks is not looked for in the editable installation either
    strict = 'import sys\nsys.meta_path[:] = [f for f in sys.meta_path if "editable" not in f.__module__]\n'
    (folder / "sitecustomize.py").write_text(strict, encoding="utf-8")
    for name in names:
        shutil.rmtree(folder / "jkrcli" / name)
        shutil.rmtree(folder / "tests" / name, ignore_errors=True)
    return folder


def said(project: Path, folder: Path, words: str) -> tuple[int, str, dict[str, bytes]]:
    """What a command of the program in ``project`` says, in lines that are not folded, but for times and the methods of
    wings, and writes beside the series."""
    environment = {**os.environ, "PYTHONPATH": str(project), "OPENBLAS_NUM_THREADS": "1", "COLUMNS": "10000"}
    done = subprocess.run(
        [sys.executable, "-m", "jkrcli", *words.split()], cwd=folder, env=environment, capture_output=True, text=True
    )
    text = re.sub(r"[\d.e+-]+ s\b|\"timings_s\": \{[^}]*\}", "", done.stdout + done.stderr)
    methods = "|".join(method for wing in wings() for method in wing.methods)
    text = re.sub(rf"^ +({methods}) .*\n|; ({methods}) [^;\n]*| or ({methods})\b", "", text, flags=re.M)
    left = {path.name: path.read_bytes() for path in sorted(folder.glob("*.csv"))}
    return done.returncode, text, left


def _of_core(case: Path) -> None:
    """Rewrite a copy of a case to the simplest of the core's methods, without a mesh."""
    text = re.sub(r"^\[(mesh|contact)\].*?(?=^\[|\Z)", "", case.read_text(encoding="utf-8"), flags=re.M | re.S)
    methods = "|".join(method for wing in wings() for method in wing.methods)
    case.write_text(re.sub(rf'^method = "({methods})"', 'method = "auto"', text, flags=re.M), encoding="utf-8")


def differing(core: Path, cases: Sequence[Path]) -> Iterator[str]:
    """Commands that fail, or of which the ``core`` says or writes something else than the whole."""

    def all_of(case: Path, project: Path) -> list[tuple[int, str, dict[str, bytes]]]:
        with tempfile.TemporaryDirectory() as folder:
            place = Path(folder)
            shutil.copytree(ROOT / "cases", place / "cases")
            _of_core(place / "cases" / case.name)
            return [said(project, place, words.format(case=f"cases/{case.name}")) for words in VERBS]

    with ThreadPoolExecutor(os.cpu_count()) as pool:
        found = [[pool.submit(all_of, case, project) for project in (ROOT, core)] for case in cases]
    for case, both in zip(cases, found, strict=True):
        for words, whole, alone in zip(VERBS, *(each.result() for each in both), strict=True):
            of_wing = "contact of a viscoelastic specimen over time needs" in alone[1]
            if whole != alone and not of_wing:
                yield f"{words.format(case=case.name)}: the core says {alone[1]!r}, the whole {whole[1]!r}"


def needs_wing(tests: Path, path: Path, names: Sequence[str], known: dict[Path, bool]) -> bool:
    """Whether a test or a helper of tests imports from a wing, or a helper that does."""
    if path not in known:
        known[path] = False
        text = path.read_text(encoding="utf-8")
        helpers = [tests / f"{name}.py" for name in re.findall(r"^\s*(?:from|import) (\w+)", text, re.M)]
        functions = "|".join(function for wing in wings() for function in wing.functions)
        verbs = "|".join(verb for wing in wings() for verb, more in wing.verbs.items() if not more.of_core)
        by_name = rf"^from jkrcli import .*\b({functions})\b|jkr(?:cli)?\.({functions})\b|[\"']({verbs}) "
        known[path] = (
            re.search(by_name, text, re.M) is not None
            or any(f"jkrcli.{name}" in text for name in names)
            or any(needs_wing(tests, helper, names, known) for helper in helpers if helper.exists())
        )
    return known[path]


def tested(core: Path, names: Sequence[str]) -> int:
    """The exit code of the tests of the core's rooms that need no wing, in the copy."""
    known: dict[Path, bool] = {}
    found = [path for room in ROOMS for path in sorted((core / "tests" / room).rglob("test_*.py"))]
    files = [path for path in found if not needs_wing(core / "tests", path, names, known)]
    left = ", ".join(path.stem for path in found if path not in files)
    print(f"{len(files)} files of tests; left out, as they use wings: {left}", flush=True)
    other = next(iter(settings(own := arithmetic({})))).environment(own)
    environment: Mapping[str, str] = {**os.environ, "OPENBLAS_NUM_THREADS": "1", **other, "PYTHONPATH": str(core)}
    words = [sys.executable, "-m", "pytest", "-n", "auto", "-q", "-m", "not slow", *map(str, files)]
    return subprocess.run(words, cwd=core, env=environment).returncode


def main(words: Sequence[str] | None = None) -> int:
    """The study; 1 where the core says something else alone, or a test of it fails."""
    parser = argparse.ArgumentParser(description=ABOUT)
    parser.add_argument("--no-tests", action="store_true", help="the shipped cases alone")
    given = parser.parse_args(words)
    cases = [path for path in sorted((ROOT / "cases").glob("*.toml")) if not any(part in path.stem for part in SLOW)]
    with tempfile.TemporaryDirectory() as folder:
        core = copied(Path(folder))
        if wrong := list(differing(core, cases)):
            print("\n".join(wrong))
            return 1
        print(f"{len(cases)} cases: the core alone says and writes what the whole does")
        return 0 if given.no_tests else tested(core, [wing.name for wing in wings()])


if __name__ == "__main__":
    sys.exit(call(main))
