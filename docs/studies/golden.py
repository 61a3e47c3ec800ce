"""`make golden AGAINST=commit`: what users get of every command, beside that of another commit, to the byte.

A redesign changes no number and no word. Every shipped case runs by every method (a refusal is a result, too) through
``run``, ``transform``, ``pull-off``, ``cycle`` and ``profile``; ``check``, ten fits with their alternative models,
sweeps, maps and the help of every verb stand beside. Exit codes, stdout, stderr, CSV and JSON are compared after what
changes from run to run (times, memory, dates, versions) is masked.

Words and numbers are compared apart: every column of a CSV file and every number of a JSON text by its name, relative
to the largest of that name, so that another word hides no other number. A difference that is meant is listed in
``golden.toml`` with its reason, one of numbers with its size; any other makes the exit code 1.
"""

from __future__ import annotations

import argparse
import csv
import fnmatch
import json
import math
import os
import re
import subprocess
import sys
import tempfile
import tomllib
from collections.abc import Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import jkrcli.cli

ROOT = Path(__file__).parents[2]
MEANT = Path(__file__).with_name("golden.toml")
STORE = ROOT / "build" / "golden"
METHODS = ("closed-form", "layered", "hybrid", "fem")
RADII = {"gel": "1mm", "relaxing-gel": "0.3mm", "soft-gel": "2um"}  # of the state that ``profile`` shows, else 5 um
SUFFIXES = (".csv", ".json", ".toml", ".h", ".txt")

# What differs between two runs of one program: times, rates, memory, dates, versions, sums over files that hold times.
VARYING = "seconds|cpu_s|timings_s|wall|memory|created|version|digest|sha256|checksum"
MASKS = (
    (re.compile(r"\b[\d.]+(e[+-]?\d+)? ?(ms|s|min|h|GiB|MiB|MB|GB)\b(?!/)"), "<cost>"),
    (re.compile(rf'("[a-z_]*({VARYING})[a-z_]*": )[^\n{{]+'), r"\1<cost>"),
    (re.compile(r"\b\d{4}-\d\d-\d\d[T ][\d:.+Z]+"), "<date>"),
    (re.compile(r"\b[0-9a-f]{40,64}\b"), "<digest>"),
)  # fmt: skip


@dataclass(frozen=True)
class Scene:
    """Commands that are run one after the other in a folder of their own.

    Parameters
    ----------
    name: unique, the folder's name
    commands: the words of each behind ``jkr``; paths below ``cases`` are those of the checkout that is judged
    """

    name: str
    commands: tuple[str, ...]


def scenes() -> Iterator[Scene]:
    """Yield all scenes."""
    cases = [path.stem for path in sorted((ROOT / "cases").glob("*.toml"))]
    for case in cases:
        for method in METHODS:
            series, w = f"{case}.h5", "--w 20mJ/m^2" if case == "relaxing-gel" else ""
            yield Scene(f"{case}-{method}", (
                f"run cases/{case}.toml --method {method} -o {series}",
                f"transform {series} {w} --no-plots --dimensionless half-space",
                f"pull-off {series} {w} --stiffness load --stiffness rigid --stiffness 100N/m --json",
                f"pull-off {series} {w} -v",
                f"cycle {series} {w.replace('--w', '--w-approach')} --no-plots --points 40",
                f"profile {series} {w} --a {RADII.get(case, '5um')}",
                f"show {series}",
            ))  # fmt: skip
        yield Scene(f"{case}-check", (f"check cases/{case}.toml -v", f"check cases/{case}.toml --json"))
    yield from FITS
    yield from STUDIES
    yield Scene("help", tuple(f"{verb} --help" for verb in ("", *jkrcli.cli.VERBS)))


RAW = "fit cases/measured/raw-force-curve.txt --radius 10um --nu 0.5 --no-plots"
PROBE = "cases/gel.toml cases/measured/gel-probe.csv --no-plots"
FITS = tuple(
    Scene(f"fit-{number}", (f"{words} -o out", *more))
    for number, (words, *more) in enumerate((
        (f"{RAW} --rivals", "look cases/measured/raw-force-curve.txt -v --no-plots"),
        (f"{RAW} --rivals --segment approach",),
        (f"{RAW} --rivals --segment retract --shape paraboloid",),
        (f"{RAW} --rivals --model auto",),
        (f"{RAW} --rivals --free drift",),
        (f"{RAW} --rivals --thickness 30um",),
        (f"fit {PROBE}",),
        (f"fit {PROBE} --uncertain nu=0.005",),
        (f"fit {PROBE} --fix w=40mJ/m^2",),
        (f"fit {PROBE} --branch compressive", f"work {PROBE} -o out"),
    ), 1)
)  # fmt: skip
STUDIES = (
    Scene("sweep", ("sweep cases/sweeps/gel.toml -o out --workers 1 --no-plots",)),
    *(
        Scene(name, (f"study {name} {words} --no-plots -o out",))
        for name, words in (
            ("pull-off-map", "--nu 0.3 --nu 0.499"),
            ("sticking-map", "--nu 0.3"),
            ("transition-map", "--nu 0.3 --q 1 --q 10 --mu 0.3 --mu 3"),
            ("adhesion-map", "--nu 0.3 --mu 0.3 --mu 3"),
            ("rate-map", "--speed 0.01 --speed 1"),
        )
    ),
)


def environment(package: Path) -> dict[str, str]:
    """Of a process that takes the package from a checkout, computes with one thread and writes 100 columns; what is
    compiled of the package is kept, away from the checkout."""
    kept = {name: value for name, value in os.environ.items() if name != "PYTHONDONTWRITEBYTECODE"}
    return kept | {
        "PYTHONPATH": str(package),
        "PYTHONPYCACHEPREFIX": str(STORE / "compiled"),
        "OPENBLAS_NUM_THREADS": "1",
        "OMP_NUM_THREADS": "1",
        "COLUMNS": "100",
    }


def play(scene: Scene, package: Path, folder: Path) -> None:
    """Run the commands of a ``scene`` and leave what they print beside what they write."""
    place = folder / scene.name
    place.mkdir(parents=True)
    (place / "cases").symlink_to(ROOT / "cases")
    for number, command in enumerate(scene.commands, 1):
        words = [sys.executable, "-m", "jkrcli", *command.split()]
        done = subprocess.run(words, cwd=place, env=environment(package), capture_output=True, text=True, check=False)
        said = f"$ jkr {command}\nexit code {done.returncode}\n{done.stdout}\n-- stderr\n{done.stderr}"
        (place / f"{number}-{command.split()[0].strip('-')}.txt").write_text(said, encoding="utf-8")
    (place / "cases").unlink()


def golden(package: Path, folder: Path, names: Sequence[str], workers: int) -> dict[str, str]:
    """Return the masked text of every file that the scenes of these ``names`` leave, by its path."""
    chosen = [scene for scene in scenes() if scene.name in names]
    with ThreadPoolExecutor(workers) as pool:
        list(pool.map(lambda scene: play(scene, package, folder), chosen))
    texts = {}
    for path in sorted(folder.rglob("*")):
        if path.suffix in SUFFIXES:
            text = path.read_text(encoding="utf-8").replace(str(folder), "<folder>").replace(str(package), "<package>")
            for mask, instead in MASKS:
                text = mask.sub(instead, text)
            texts[str(path.relative_to(folder))] = text
    return texts


def commit_of(name: str) -> str:
    """The first twelve digits of a commit."""
    words = ["git", "-C", str(ROOT), "rev-parse", "--short=12", f"{name}^{{commit}}"]
    done = subprocess.run(words, capture_output=True, text=True, check=False)
    if done.returncode:
        raise SystemExit(f"--against {name}: no commit of this checkout")
    return done.stdout.strip()


def checkout(commit: str, folder: Path) -> Path:
    """The package of a ``commit``, unpacked into ``folder``."""
    packed = subprocess.run(["git", "-C", str(ROOT), "archive", commit, "jkrcli"], capture_output=True, check=True)
    folder.mkdir(parents=True, exist_ok=True)
    subprocess.run(["tar", "-x", "-C", str(folder)], input=packed.stdout, check=True)
    return folder


def reference(commit: str, names: Sequence[str], workers: int) -> dict[str, str]:
    """Return what a ``commit`` gives; it is kept below ``build/golden`` for the next comparison with it."""
    short = commit_of(commit)
    kept = STORE / f"{short}.json"
    texts: dict[str, str] = json.loads(kept.read_text(encoding="utf-8")) if kept.exists() else {}
    missing = [name for name in names if not any(path.startswith(f"{name}/") for path in texts)]
    if missing:
        with tempfile.TemporaryDirectory() as folder:
            package = checkout(short, Path(folder) / "package")
            texts |= golden(package, Path(folder) / "out", missing, workers)
        STORE.mkdir(parents=True, exist_ok=True)
        kept.write_text(json.dumps(texts), encoding="utf-8")
    return {path: text for path, text in texts.items() if path.split("/")[0] in names}


NUMBER = re.compile(r"[-+]?\d+\.?\d*(?:[eE][-+]?\d+)?")
PRINTED = re.compile(r"exit code (\d+)\n(.*)\n-- stderr\n", re.DOTALL)
COSTS = ((re.compile(r"<cost>,?(?=\s*[}\]])"), "0"), (re.compile(r"<cost>,?(?=\s*\n)"), "0,"))  # JSON again

Numbers = dict[str, list[Any]]


def numbers(path: str, text: str) -> Numbers:
    """The cells of each column of a CSV file, numbers and words; the numbers of each name of a JSON text; of what was
    printed the exit code, and its JSON if it is."""
    found: Numbers = {}
    if path.endswith(".csv"):
        head, *rows = csv.reader(line for line in text.splitlines() if not line.startswith("#"))
        for row in rows:
            for name, cell in zip(head, row, strict=False):
                found.setdefault(name, []).append(float(cell) if NUMBER.fullmatch(cell) else cell)
        return found

    def gather(name: str, value: Any) -> None:
        if isinstance(value, dict):
            for key, one in value.items():
                gather(f"{name}.{key}".strip("."), one)
        elif isinstance(value, list):
            for one in value:
                gather(name, one)
        elif isinstance(value, int | float):
            found.setdefault(name, []).append(float(value))

    body = text
    if path.endswith(".txt") and (printed := PRINTED.search(text)):
        found["exit code"], body = [int(printed[1])], printed[2]
    if body.lstrip()[:1] in ("{", "["):
        for cost, instead in COSTS:
            body = cost.sub(instead, body)
        gather("", json.loads(body))
    return found


def deviations(before: Numbers, now: Numbers) -> dict[str, float]:
    """Of each name whose numbers differ by how much at most, relative to the largest of them; infinity where a name or
    a number is new or gone, or a word of a cell another one."""
    found = {}
    for name in before.keys() | now.keys():
        old, new = before.get(name, []), now.get(name, [])
        if old == new:
            continue
        pairs = list(zip(old, new, strict=False))
        words = any(a != b for a, b in pairs if isinstance(a, str) or isinstance(b, str))
        sizes = [(abs(a), abs(b), abs(a - b)) for a, b in pairs if not isinstance(a, str) and not isinstance(b, str)]
        largest = max((max(a, b) for a, b, _ in sizes), default=0.0)
        lost = words or len(old) != len(new)
        found[name] = math.inf if lost else max(apart for *_, apart in sizes) / largest
    return found


def differences(path: str, before: str | None, now: str | None, meant: Meant) -> Iterator[tuple[str, str | None]]:
    """What differs between two texts of one ``path``, in words, each with the reason that is listed for it, or None."""
    if before is None or now is None:
        yield "is new" if before is None else "is gone", meant.reason("files", path)
    elif before != now:
        for name, size in sorted(deviations(numbers(path, before), numbers(path, now)).items()):
            yield f"{name} differs by {size:.1e}", meant.of_number(path, name, size)
        if path.endswith(".csv"):  # all cells are judged above
            return
        if NUMBER.sub("#", before) != NUMBER.sub("#", now):
            pairs = zip(before.splitlines(), now.splitlines(), strict=False)
            first = next(([a, b] for a, b in pairs if NUMBER.sub("#", a) != NUMBER.sub("#", b)), ["<end>", "<more>"])
            shown = "".join(f"\n    {sign} {line[:200]}" for sign, line in zip("-+", first, strict=True))
            yield f"other words{shown}", meant.reason("words", path)
        elif not path.endswith(".json"):  # numbers in sentences
            yield "other numbers in the same sentences", meant.reason("words", path)


@dataclass(frozen=True)
class Meant:
    """What is listed of one comparison: reasons of ``words`` and ``files`` by patterns of paths, and of ``numbers`` by
    patterns of paths and names, each with the deviation ``within`` which it holds."""

    listed: dict[str, Any]

    @classmethod
    def against(cls, commit: str) -> Meant:
        """The list that was made for the ``commit``; empty for others."""
        listed = tomllib.loads(MEANT.read_text(encoding="utf-8"))
        return cls(listed if commit.startswith(listed["against"]) else {})

    def reason(self, kind: str, path: str) -> str | None:
        entries = self.listed.get(kind, {}).items()
        return next((why for like, why in entries if fnmatch.fnmatch(path, like)), None)

    def of_number(self, path: str, name: str, size: float) -> str | None:
        for entry in self.listed.get("numbers", []):
            fits = any(fnmatch.fnmatch(path, like) for like in entry["files"])
            if fits and any(fnmatch.fnmatchcase(name, like) for like in entry["names"]) and size <= entry["within"]:
                return str(entry["reason"])
        return None


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--against", required=True, help="the commit to compare with")
    parser.add_argument("--keep", type=Path, help="a JSON file of all texts: read where it exists, else written")
    parser.add_argument("--only", default="*", help="scenes of these names, such as 'gel-*' or 'fit-*'")
    parser.add_argument("--workers", type=int, default=os.cpu_count() or 1)
    given = parser.parse_args()

    names = [scene.name for scene in scenes() if fnmatch.fnmatch(scene.name, given.only)]
    before = reference(given.against, names, given.workers)
    if given.keep and given.keep.exists():
        now = json.loads(given.keep.read_text(encoding="utf-8"))
    else:
        with tempfile.TemporaryDirectory() as folder:
            now = golden(ROOT, Path(folder), names, given.workers)
        if given.keep:
            given.keep.write_text(json.dumps(now), encoding="utf-8")

    meant = Meant.against(commit_of(given.against))
    counts: dict[str, int] = {}
    unmeant = 0
    for path in sorted(before.keys() | now.keys()):
        for what, reason in differences(path, before.get(path), now.get(path), meant):
            if reason is None:
                unmeant += 1
                print(f"{path}: {what}")
            else:
                counts[reason] = counts.get(reason, 0) + 1
    for reason, count in counts.items():
        print(f"{count} meant: {reason}")
    print(f"{len(now)} texts of {len(names)} scenes: {unmeant} differences from {given.against} without a reason")
    return 1 if unmeant else 0


if __name__ == "__main__":
    sys.exit(main())
