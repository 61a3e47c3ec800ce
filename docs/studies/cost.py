"""Time fits of disturbed records beside clean ones: ``make cost SEED=7``.

Records of ``kinds_records``, fitted with default options. The unit is the time of a clean record of as many rows, a + b
rows by ``CLEAN`` ones on half-spaces; per kind the median and the largest of the times in this unit, each the least of
three, and the median time. CPU seconds of one process with one BLAS thread: run it alone.

``--files FOLDER``: whole processes instead, ``jkr fit FILE`` of each file of one curve in a folder, over that of a
clean record of as many rows.
"""

from __future__ import annotations

import argparse
import contextlib
import resource
import subprocess
import sys
import tempfile
import time
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from jkrcli.base.errors import JkrError
from jkrcli.measured.curve import Reading
from jkrcli.measured.files import read
from jkrcli.measured.procedure import fit
from jkrcli.measured.settings import settings_of

from .kinds import body, drawn
from .kinds_records import KINDS, Setup, recorded, way

RUNS = 3  # of each fit, of which the least counts
CLEAN = 20  # records of the kind "clean" that are the unit


def seconds(kind: str, seed: int, i: int) -> tuple[int, float]:
    """Tell the rows of record ``i`` of a kind, and the CPU seconds of its fit."""
    made = drawn(kind, seed, i)
    held, options = body(made), dict[str, Any](made.options)
    with tempfile.TemporaryDirectory() as folder:
        made.write(file := Path(folder) / "record.txt")
        (curve,) = read(file, Reading(contact="as-is"))
    times = []
    for _ in range(RUNS):
        start = time.process_time()
        with contextlib.suppress(JkrError):
            fit(held, curve, settings_of(held, **options))
        times.append(time.process_time() - start)
    return len(curve), min(times)


def process(file: Path, radius: float) -> float | None:
    """Tell the CPU seconds of a whole process that fits the curve of a file; None where it refuses."""
    words = [sys.executable, "-m", "jkrcli", "fit", str(file), "--radius", f"{radius:.9g}", "--nu", "0.5"]
    with tempfile.TemporaryDirectory() as folder:
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        done = subprocess.run([*words, "--shape", "paraboloid", "-o", folder], capture_output=True, check=False)
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
    spent = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    return None if done.returncode else spent


def clean_process(seed: int, rows: int) -> float:
    """Tell the median CPU seconds of five processes that fit clean records of so many ``rows``."""
    each = list[float]()
    with tempfile.TemporaryDirectory() as folder:
        for i in range(5):
            rng = np.random.default_rng([seed, rows, i])
            at = replace(Setup.drawn(rng), rows=rows // 2)
            recorded(rng, at, way(at)).write(file := Path(folder) / f"{i}.txt")
            each += [spent] if (spent := process(file, at.contact.tip.R)) else []
    return float(np.median(each))


def of_files(folder: Path, seed: int) -> None:
    sizes = (500, 2000, 8000, 32000)
    clean, ratios = [clean_process(seed, rows) for rows in sizes], list[float]()
    for rows, one in zip(sizes, clean, strict=True):
        print(f"clean: {one:.2f} s of {rows} rows", flush=True)
    for file in sorted(folder.iterdir()):
        curves = list[Any]()
        with contextlib.suppress(JkrError, OSError):
            curves = read(file, Reading())
        if len(curves) == 1 and (spent := process(file, 5e-6)) is not None:
            ratios.append(spent / float(np.interp(len(curves[0]), sizes, clean)))
            print(f"{ratios[-1]:5.1f} {spent:6.2f} s {len(curves[0]):6d} rows {file.name[:60]}", flush=True)
    print(f"{len(ratios)} files: median {np.median(ratios):.1f}, nine tenths below {np.quantile(ratios, 0.9):.1f}, "
          f"worst {max(ratios):.1f}")  # fmt: skip


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("seed", type=int, nargs="?", default=1)
    parser.add_argument("count", type=int, nargs="?", default=8, help="records of each kind")
    parser.add_argument("--only", default="", help="kinds that contain this")
    parser.add_argument("--files", type=Path, help="whole processes on the files of this folder")
    asked = parser.parse_args()
    if asked.files is not None:
        of_files(asked.files, asked.seed)
        return
    rows, clean = np.array([seconds("clean", asked.seed, 1000 + i) for i in range(CLEAN)]).T
    (a, b), every = np.linalg.lstsq(np.column_stack([np.ones(CLEAN), rows]), clean, rcond=None)[0], list[float]()
    for kind in (kind for kind in KINDS if asked.only in kind):
        found = [seconds(kind, asked.seed, i) for i in range(asked.count)]
        units = [spent / (a + b * size) for size, spent in found]
        every += units
        print(f"{kind:<23} median {np.median(units):5.1f} worst {max(units):5.1f}; "
              f"{np.median([spent for _, spent in found]):.3f} s", flush=True)  # fmt: skip
    print(f"a clean one {1e3 * a:.0f} ms + {1e6 * b:.1f} us a row; all: median {np.median(every):.1f}, nine tenths "
          f"below {np.quantile(every, 0.9):.1f}, worst {max(every):.1f}")  # fmt: skip


if __name__ == "__main__":
    main()
