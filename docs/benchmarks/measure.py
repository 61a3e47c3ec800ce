"""`make benchmarks`: whole processes of the commands that users feel, and a line for each in the history.

Runs of the versions compared alternate, so that what else goes on at the machine hits both; the least of all counts.
`--against` names another checkout or a commit of this one; the ratio is that of the least CPU seconds, which other
work at the machine changes least.
"""

from __future__ import annotations

import argparse
import compileall
import csv
import os
import platform
import resource
import statistics
import subprocess
import sys
import tempfile
from datetime import UTC, datetime
from pathlib import Path

ROOT = Path(__file__).parents[2]
HISTORY = Path(__file__).parent / "history.csv"
COMMANDS = {  # what is timed; the gel's series is there already
    "help": ["--help"],
    "check": ["check", "cases/gel.toml"],
    "run": ["run", "cases/gel.toml", "-o", "new.h5"],
    "transform": ["transform", "gel.h5", "--w", "0.035", "--w", "0.04", "--w", "0.045"],
    "pull-off": ["pull-off", "gel.h5", "--load", "1.2 mN"],
    "fit": ["fit", "cases/gel.toml", "cases/measured/gel-probe.csv", "-o", "fitted"],
}
COLUMNS = ("date", "commit", "machine", "command", "runs", "least_s", "median_s", "least_cpu_s", "against", "ratio")


def timed(words: list[str], package: Path, folder: Path) -> tuple[float, float]:
    """Wall and CPU seconds of one process with the package at ``package``."""
    environment = os.environ | {"PYTHONPATH": str(package), "OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"}
    before, start = resource.getrusage(resource.RUSAGE_CHILDREN), datetime.now(UTC)
    subprocess.run(
        [sys.executable, "-m", "jkrcli", *words], cwd=folder, env=environment, check=True, capture_output=True
    )
    after, wall = resource.getrusage(resource.RUSAGE_CHILDREN), (datetime.now(UTC) - start).total_seconds()
    return wall, after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def commit(folder: Path) -> str:
    words = ["git", "-C", str(folder), "describe", "--always", "--dirty"]
    return subprocess.run(words, capture_output=True, text=True, check=False).stdout.strip() or folder.name


def checkout(against: str, folder: Path) -> Path:
    """The folder called ``against``, else the package of that commit, unpacked into ``folder``, which gets its name."""
    if (Path(against) / "jkrcli").is_dir():
        return Path(against).resolve()
    words = ["git", "-C", str(ROOT), "archive", against, "jkrcli"]
    packed = subprocess.run(words, capture_output=True, check=False)
    if packed.returncode:
        raise SystemExit(f"--against {against}: neither a folder that holds jkrcli nor a commit of this checkout")
    (folder / against).mkdir()
    subprocess.run(["tar", "-x", "-C", str(folder / against)], input=packed.stdout, check=True)
    return folder / against


def measure(runs: int, against: Path | None) -> list[dict[str, object]]:
    """A row for each command."""
    packages = [ROOT] if against is None else [ROOT, against]
    for package in packages:  # or the one that is compiled already is the faster by what that takes
        compileall.compile_dir(package / "jkrcli", quiet=1)
    rows = []
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        (folder / "cases").symlink_to(ROOT / "cases")
        timed(["run", "cases/gel.toml", "-o", "gel.h5"], packages[-1], folder)
        for command, words in COMMANDS.items():
            found: list[list[tuple[float, float]]] = [[] for _ in packages]
            for _ in range(runs):
                for times, package in zip(found, packages, strict=True):
                    times.append(timed(words, package, folder))
            least = [min(cpu for _, cpu in times) for times in found]
            walls = [wall for wall, _ in found[0]]
            rows.append({
                "date": f"{datetime.now(UTC):%Y-%m-%d}", "commit": commit(ROOT),
                "machine": f"{platform.machine()}, {os.cpu_count()} cores, Python {platform.python_version()}",
                "command": command, "runs": runs, "least_s": f"{min(walls):.3f}",
                "median_s": f"{statistics.median(walls):.3f}", "least_cpu_s": f"{least[0]:.3f}",
                "against": "" if against is None else commit(against),
                "ratio": "" if against is None else f"{least[0] / least[1]:.3f}",
            })  # fmt: skip
            print(*rows[-1].values(), sep="  ", flush=True)
    return rows


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--runs", type=int, default=20)
    parser.add_argument("--against", help="Another checkout of jkr, or a commit of this one, for ratios.")
    parser.add_argument("--keep", action="store_true", help="Append to docs/benchmarks/history.csv.")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as name:
        rows = measure(options.runs, options.against and checkout(options.against, Path(name)))
    if options.keep:
        new = not HISTORY.exists()
        with HISTORY.open("a", newline="", encoding="utf-8") as file:
            writer = csv.DictWriter(file, COLUMNS, lineterminator="\n")
            if new:
                writer.writeheader()
            writer.writerows(rows)


if __name__ == "__main__":
    main()
