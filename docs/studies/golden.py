"""`make golden AGAINST=commit`: what users get of every command, beside that of another commit, to the byte.

A redesign changes no number and no word. Every shipped case runs by every method (a refusal is a result, too) through
``run``, ``transform``, ``pull-off``, ``cycle`` and ``profile``; ``check``, ten fits with their alternative models,
sweeps, maps and the help of every verb stand beside. Exit codes, stdout, stderr, CSV and JSON are compared after what
changes from run to run (times, memory, dates, versions) is masked. A difference that is meant is listed in
``golden.toml`` with its reason; any other makes the exit code 1.
"""

from __future__ import annotations

import argparse
import fnmatch
import json
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
    """Of a process that takes the package from a checkout, computes with one thread and writes 100 columns."""
    return os.environ | {
        "PYTHONPATH": str(package),
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


def checkout(commit: str, folder: Path) -> Path:
    """The package of a ``commit``, unpacked into ``folder``."""
    packed = subprocess.run(["git", "-C", str(ROOT), "archive", commit, "jkrcli"], capture_output=True, check=False)
    if packed.returncode:
        raise SystemExit(f"--against {commit}: no commit of this checkout")
    folder.mkdir(parents=True, exist_ok=True)
    subprocess.run(["tar", "-x", "-C", str(folder)], input=packed.stdout, check=True)
    return folder


def reference(commit: str, names: Sequence[str], workers: int) -> dict[str, str]:
    """Return what a ``commit`` gives; it is kept below ``build/golden`` for the next comparison with it."""
    words = ["git", "-C", str(ROOT), "rev-parse", "--short=12", f"{commit}^{{commit}}"]
    short = subprocess.run(words, capture_output=True, text=True, check=True).stdout.strip()
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


def difference(before: str | None, now: str | None) -> str | None:
    """Describe where two texts first differ, and by how much their numbers do at most; None where they are equal."""
    if before == now:
        return None
    if before is None or now is None:
        return "is new" if before is None else "is gone"
    old, new = before.splitlines(), now.splitlines()
    first = next(
        (i for i, pair in enumerate(zip(old, new, strict=False)) if pair[0] != pair[1]), min(len(old), len(new))
    )
    pairs = [(float(a), float(b)) for a, b in zip(NUMBER.findall(before), NUMBER.findall(now), strict=False)]
    words_alike = NUMBER.sub("#", before) == NUMBER.sub("#", now)
    most = max((abs(a - b) / max(abs(a), abs(b)) for a, b in pairs if a != b), default=0.0)
    size = f"numbers alone, by {most:.1e} at most" if words_alike else "in words"
    a, b = (lines[first] if first < len(lines) else "<end>" for lines in (old, new))
    return f"{size}; line {first + 1}:\n    - {a[:200]}\n    + {b[:200]}"


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--against", required=True, help="the commit to compare with")
    parser.add_argument("--only", default="*", help="scenes of these names, such as 'gel-*' or 'fit-*'")
    parser.add_argument("--workers", type=int, default=os.cpu_count() or 1)
    given = parser.parse_args()

    names = [scene.name for scene in scenes() if fnmatch.fnmatch(scene.name, given.only)]
    before = reference(given.against, names, given.workers)
    with tempfile.TemporaryDirectory() as folder:
        now = golden(ROOT, Path(folder), names, given.workers)

    meant = tomllib.loads(MEANT.read_text(encoding="utf-8")) if MEANT.exists() else {}
    unmeant = 0
    for path in sorted(before.keys() | now.keys()):
        what = difference(before.get(path), now.get(path))
        if what:
            reason = next((why for like, why in meant.items() if fnmatch.fnmatch(path, like)), None)
            unmeant += reason is None
            print(f"{path}: {what}" + (f"\n    meant: {reason}" if reason else ""))
    print(f"{len(now)} texts of {len(names)} scenes: {unmeant} differ from {given.against} without a reason")
    return 1 if unmeant else 0


if __name__ == "__main__":
    sys.exit(main())
