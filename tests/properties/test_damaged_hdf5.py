"""HDF5 files with flipped bits: the right record or one line, never a crash of the library, nor for ever."""

import random
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import vendors

from jkrcli.case.models import load_case
from jkrcli.case.store import solve, write_solution

SECONDS = 10  # of one file; whole ones take some hundredths

# The alarm ends the process wherever it is, in the library too. Each flip is told before it is tried.
READER = f"""
import signal, sys
from pathlib import Path
from jkrcli.base.errors import InputError
from jkrcli.case.store import read_solution
from jkrcli.measured import files as measured
path, whole = Path(sys.argv[1]), Path(sys.argv[1]).read_bytes()
read = read_solution if sys.argv[2] == "solution" else lambda path: list(measured.each(path))
for line in sys.stdin:
    at, bits = map(int, line.split())
    print(at, bits, flush=True)
    path.write_bytes(whole[:at] + bytes([whole[at] ^ bits]) + whole[at + 1:])
    signal.alarm({SECONDS})
    try:
        read(path)
    except InputError as error:
        assert len(error.lines) == 1, error.lines
    signal.alarm(0)
"""


def exported(path: Path) -> Path:
    afmformats = pytest.importorskip("afmformats")
    import h5py

    columns = {"force": vendors.FORCE, "height (measured)": vendors.HEIGHT, "time": vendors.TIME}
    metadata = {"imaging mode": "force-distance", "path": "x.h5", "point count": vendors.FORCE.size,
                "spring constant": vendors.K}  # fmt: skip
    with h5py.File(path, "w") as file:
        for enum in range(2):
            afmformats.AFMForceDistance(columns, metadata | {"enum": enum}).export_data(file, fmt="hdf5")
    return path


def solved(path: Path) -> Path:
    _, solution = solve(load_case(Path(__file__).parents[2] / "cases" / "gel.toml"))
    write_solution(path, solution)
    return path


FILES: dict[str, Callable[[Path], Path]] = {
    "nanosurf": lambda folder: vendors.nanosurf(folder / "map.nhf", 2),
    "afmformats": lambda folder: exported(folder / "map.h5"),
    "solution": lambda folder: solved(folder / "gel.h5"),
}  # fmt: skip


def test_readers_meet_what_they_read(tmp_path: Path) -> None:
    """A few flips of the head: of the signature, the sizes of addresses, and the end of the file."""
    follow(FILES["nanosurf"](tmp_path), "nanosurf", [(1, 1), (13, 8), (40, 255), (41, 16)])


@pytest.mark.slow
@pytest.mark.parametrize("kind", FILES)
def test_flips_anywhere(tmp_path: Path, kind: str) -> None:
    """Half of them where something stands, zeros of empty tables being most of a file of others."""
    path = FILES[kind](tmp_path)
    chance, content = random.Random(20), np.frombuffer(path.read_bytes(), np.uint8)
    places = [*chance.sample(range(content.size), 200), *chance.sample(np.flatnonzero(content).tolist(), 200)]
    follow(path, kind, [(at, chance.choice([1 << chance.randrange(8), chance.randrange(1, 256)])) for at in places])


def follow(path: Path, kind: str, flips: list[tuple[int, int]]) -> None:
    told = "".join(f"{at} {bits}\n" for at, bits in flips)
    words = [sys.executable, "-c", READER, str(path), kind]
    done = subprocess.run(words, input=told, capture_output=True, text=True, check=False)
    assert done.returncode == 0, f"{done.returncode} at {done.stdout.splitlines()[-1:]}: {done.stderr[-500:]}"
    assert len(done.stdout.splitlines()) == len(flips)
