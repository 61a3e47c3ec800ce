"""Archives of fits, tables of sweeps and kept solves: damage is refused, or every number and string is the same."""

import contextlib
import json
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest
from conftest import write_table
from fit_data import adhesive
from series_files import CASE, one_byte_changed
from sweep_files import HALF_SPACE

from jkrcli.base import hdf5
from jkrcli.base.errors import InputError
from jkrcli.case import store
from jkrcli.case.models import load_case
from jkrcli.case.store import solve
from jkrcli.cli import call
from jkrcli.many import sweep_plan as plan
from jkrcli.report import archive

SWEEP = (
    HALF_SPACE
    + """[samples]
count = 8
[samples.of]
"specimen.half_space.nu" = { distribution = "normal", mean = 0.5, sd = 0.1 }
"""
)
KINDS = ("fits", "table")
TRIALS = pytest.mark.parametrize("trials", [100, pytest.param(2000, marks=pytest.mark.slow)])


@pytest.fixture(name="made", scope="module")
def _made(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("archives")
    (folder / "s.toml").write_text(CASE)
    (folder / "many.toml").write_text(SWEEP)
    a = np.linspace(2e-5, 9e-5, 40)
    P = adhesive(a, 1e6 / (1 - 0.3**2), 0.05, 1e-3)[1] * (1 + 1e-3 * np.random.default_rng(0).standard_normal(a.size))
    write_table(folder / "probe.csv", "a_m,P_N", a, P)
    with contextlib.chdir(folder):
        assert call(["fit", "s.toml", "probe.csv", "--no-plots"]) == 0
        assert call(["sweep", "many.toml", "-o", "r", "--workers", "1", "--no-plots"]) == 0
    return folder


@pytest.fixture(name="archives")
def _archives(made: Path, tmp_path: Path) -> dict[str, Path]:
    shutil.copytree(made, tmp_path, dirs_exist_ok=True)
    return {"fits": tmp_path / "s-fit.h5", "table": tmp_path / "r" / "table.h5"}


def flat(group: hdf5.Group, where: str = "") -> dict[str, Any]:
    found: dict[str, Any] = {f"{where}@{key}": _plain(value) for key, value in group.attributes.items()}
    for name, member in group.members.items():
        if isinstance(member, hdf5.Dataset):
            found[f"{where}/{name}"] = _plain(member.values)
            member = hdf5.Group(member.attributes)
        found |= flat(member, f"{where}/{name}")
    return found


def _plain(value: Any) -> Any:
    return (value.dtype.str, value.shape, value.tobytes()) if isinstance(value, np.ndarray) else value


@TRIALS
def test_a_changed_byte_of_a_kept_solve_is_not_believed(tmp_path: Path, trials: int) -> None:
    path = tmp_path / "solve.h5"
    (tmp_path / "s.toml").write_text(CASE)
    _, solution = solve(load_case(tmp_path / "s.toml"))
    store.write_solution(path, solution, plan._made_by("key"))
    before = flat(hdf5.tree_of(path, path.read_bytes()))

    def not_believed_or_same() -> None:
        found = store.read_solution(path, solution.problem)
        if found.record.command_line != plan._made_by("key"):
            raise InputError("made by another")
        assert flat(hdf5.tree_of(path, path.read_bytes())) == before

    assert one_byte_changed(path, trials, not_believed_or_same) > trials / 10


def change_unsealed(path: Path, change: Callable[[h5py.File], object]) -> None:
    with h5py.File(path, "r+") as file:
        change(file)


CHANGES = {
    "fits": lambda file: file["curves/data/foot_a"].__setitem__(0, 1.0),
    "table": lambda file: file["table/status"].__setitem__(0, b"no"),
}


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("version", [1, 3])
def test_what_is_not_as_written_is_refused_by_name(jkr, archives: dict[str, Path], kind: str, version: int) -> None:
    path = archives[kind]
    change_unsealed(path, CHANGES[kind])
    change_unsealed(path, lambda file: file.attrs.__setitem__("version", version))
    jkr("show", path).refused(f"{path}: the HDF5 file is damaged", "run the command that wrote it again")


@pytest.mark.parametrize("kind", KINDS)
def test_an_earlier_version_reads_and_is_said_to_be_without_protection(jkr, archives, kind) -> None:
    path = archives[kind]
    wanted = jkr("show", "--json", path).told["files"][0]
    assert wanted["warnings"] == []

    def older(file: h5py.File) -> None:
        file.attrs["version"] = 1
        del file.attrs[hdf5.SEAL]

    change_unsealed(path, older)
    done = jkr("show", "--json", path)
    assert (done.code, done.err) == (0, f"jkr: warning: {path}: {archive.DOUBT}\n")
    assert json.loads(done.out)["files"] == [{**wanted, "version": 1, "warnings": [archive.DOUBT]}]


def test_a_group_for_each_curve_is_read(tmp_path: Path) -> None:
    """As versions 1 and 2 had them."""
    told = {"file": "m.csv", "curve": "m", "status": "fitted"}
    curves = hdf5.Group({}, {"000000": hdf5.Group({"summary": json.dumps(told)})})
    identity = {"format": archive.FITS, "version": 2, "jkr": "0", "body": "x"}
    (tmp_path / "old.h5").write_bytes(hdf5.image(hdf5.Group(identity, {"curves": curves})))
    assert archive.archive_summary(archive.read(tmp_path / "old.h5"))["curves"] == [told]


WRONG = {
    "its digest": (lambda file: file.attrs.__delitem__(hdf5.SEAL), "it does not hold what was written"),
    "its release": (lambda file: file.attrs.__setitem__("version", 4),
                    "version must be 3, got 4; this file needs another release of jkr"),
}  # fmt: skip


@pytest.mark.parametrize("lost", WRONG)
def test_an_archive_without_its_digest_or_of_a_later_release_is_refused(jkr, archives: dict, lost: str) -> None:
    change, said = WRONG[lost]
    change_unsealed(archives["table"], change)
    jkr("show", archives["table"]).refused(said)


def test_an_archive_that_lacks_its_part_is_refused(jkr) -> None:
    Path("x.h5").write_bytes(hdf5.image(hdf5.Group({"format": archive.SWEEP_TABLE, "version": 2, "jkr": "0"})))
    jkr("show", "x.h5").refused("x.h5: lacks parts of an archive of format jkr-sweep-table")


def test_archives_are_told(jkr, archives: dict[str, Path]) -> None:
    fits, table = jkr("show", *archives.values(), "-v").out.split("\n8 cases of a sweep: ")
    assert fits.startswith(f"1 curve fitted to s.toml: {archives['fits']} (format jkr-fit 3, ")
    assert "  probe.csv, probe: fitted" in fits
    assert table.startswith(f"{archives['table']} (format jkr-sweep-table 3, ")
    assert "  status                                   failed, ok" in table
    told = jkr("show", "--json", *archives.values()).told["files"]
    assert told[0]["curves"] == json.loads(Path("s-fit.json").read_text())["curves"]
    assert (told[1]["rows"], told[1]["columns"]["case"]) == (8, [0, 7])
