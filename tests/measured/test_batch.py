"""Files that are read together settle sign, constants and units together: right, or refused as a whole."""

import csv
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest
from force_curves import Instrument, record

from jkrcli.base.errors import InputError
from jkrcli.measured.batch import read_batch
from jkrcli.measured.curve import Reading
from jkrcli.measured.segmentation import segment_force_curve

K, R = 0.3, 5e-6
MADE = record(2e5, R, 2e-4, 1e-3, Instrument(K, 200, 1.5e-6, 40e-9, 1e-10), 1)


@dataclass(frozen=True)
class File:
    """One file of a folder: ``sign`` of its column of positions, what it holds, its unit as it is labelled."""

    sign: int
    holds: str = "contact"
    unit: str = "um"
    stiffness: bool = True

    def write(self, path: Path, title: str, seed: int) -> None:
        rng = np.random.default_rng(seed)
        z, P = MADE["z"], MADE["P"] + 1e-10 * rng.normal(size=MADE["z"].size)
        P = P if self.holds != "noise" else 1e-10 * rng.normal(size=z.size)
        rows = slice(0, 30 if self.holds == "cut" else None)
        lines = [f"# springConstant: {K}"] * self.stiffness + [f"{title} ({self.unit}),force (nN),segment"]
        lines += [f"{self.sign * x * 1e6:.7g},{p * 1e9:.7g},{word}"
                  for x, p, word in zip(z[rows], P[rows], MADE["segment"][rows], strict=True)]  # fmt: skip
        path.write_text("\n".join(lines) + "\n")


def folder(number: int) -> tuple[str, list[File], bool]:
    """The title of the positions, the files of a folder, and whether their signs contradict each other."""
    rng = np.random.default_rng(number)
    title, sign = str(rng.choice(["piezo", "height"])), int(rng.choice([1, -1]))
    mirrored = int(rng.choice([0, 0, 1, 4]))
    files = [File(sign)] * 10 + [File(-sign)] * mirrored + [File(sign, "noise")] * int(rng.integers(0, 4))
    files += [File(sign, "cut")] * int(rng.integers(0, 2)) + [File(sign, unit="nm")] * int(rng.integers(0, 2))
    files += [File(sign, stiffness=False)] * int(rng.integers(0, 3))
    return title, [files[i] for i in rng.permutation(len(files))], mirrored > 1


@pytest.mark.first(7)
@pytest.mark.parametrize("number", range(20))
def test_a_folder_of_mixed_files_is_read_right_or_refused_as_a_whole(number: int, tmp_path: Path) -> None:
    title, files, contradict = folder(number)
    for i, file in enumerate(files):
        file.write(tmp_path / f"{i:02}.txt", title, i)
    if contradict:
        with pytest.raises(
            InputError, match=r"increases .* the specimen in \d+ files and .* it in 4 .* a folder of their own"
        ):
            read_batch([tmp_path], Reading())
        return
    batch = read_batch([tmp_path], Reading())
    [(curves, unread)] = batch.read
    most = max((-1, 1), key=lambda sign: sum(file.sign == sign for file in files))
    for i, file in enumerate(files):
        (curve,) = [one for one in curves if one.name == f"{i:02}"] or [None]
        if file.unit == "nm":
            assert curve is None
            assert any(
                line.startswith(f"{tmp_path / f'{i:02}.txt'}: ") and re.search(r"--unit\s+delta", line)
                for line in unread
            )
            continue
        assert curve.stiffness == K
        truth = MADE["z"] if file.sign == most else -MADE["z"]  # with the sign of the others
        np.testing.assert_allclose(curve.device, truth[: len(curve)], atol=1e-12)
        assert ("wrong way" in segment_force_curve(curve).flags) == (file.sign != most)  # which no fit takes
    lacking = [i for i, file in enumerate(files) if not file.stiffness]
    assert any(f"taken for {len(lacking)} file" in note for note in batch.notes) == bool(lacking)


def test_a_way_of_a_thousandth_of_the_others_is_named_where_nothing_bends(tmp_path: Path) -> None:
    for i in range(10):
        File(1, unit="nm" if i == 4 else "um").write(tmp_path / f"{i}.txt", "piezo", i)
    [(curves, [line])] = read_batch([tmp_path], Reading(stiffness="rigid")).read
    assert [one.name for one in curves] == [f"{i}" for i in range(10) if i != 4]
    assert line == f"{tmp_path / '4.txt'}: its delta spans 0.001 times that of the other files: is the unit wrong? " + (
        "Fit it alone with --unit delta=UNIT"
    )


def test_different_constants_are_asked_for_and_a_sign_as_specified_is_kept(tmp_path: Path) -> None:
    for i in range(3):
        File(1).write(tmp_path / f"{i}.txt", "piezo", i)
    File(1, stiffness=False).write(tmp_path / "3.txt", "piezo", 3)
    (tmp_path / "2.txt").write_text((tmp_path / "2.txt").read_text().replace(str(K), "0.7"))
    with pytest.raises(InputError, match=r"1 file lacks the stiffness .*3\.txt.*, the others name 0\.3, 0\.7: give"):
        read_batch([tmp_path], Reading())
    flipped = read_batch([tmp_path], Reading(stiffness=K, flip=frozenset({"delta"})))
    assert flipped.notes == ()
    assert all(one.device[199] < one.device[0] for one in flipped.read[0][0])


def test_a_fit_names_what_the_files_settled(jkr: Callable, tmp_path: Path) -> None:
    (tmp_path / "day").mkdir()
    for i in range(6):
        File(1).write(tmp_path / f"day/{i}.txt", "height", i)  # which grows away from the specimen, by its name
    words = ("--radius", "5 um", "--nu", "0.5", "--shape", "paraboloid", "--no-plots", "-o", "out")
    done = jkr("fit", *words, "day").ok
    assert "the specimen, as 6 files show: sign changed in all" in " ".join(done.err.split())
    rows: list[Mapping[str, str]] = list(csv.DictReader((tmp_path / "out/day-fit.csv").read_text().splitlines()))
    np.testing.assert_allclose([float(row["E_star_Pa"]) for row in rows], 2e5, rtol=0.05)
