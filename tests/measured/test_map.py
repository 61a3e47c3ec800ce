"""Maps of fitted curves: images by pixel, as numbers in a file and as a picture."""

import csv
import json
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import described_body
import h5py
import numpy as np
import pytest
from conftest import write_table
from force_curves import Instrument, record
from matplotlib.collections import QuadMesh
from raw_records import export

from jkrcli.base.errors import InputError
from jkrcli.base.executors import executor
from jkrcli.bodies.indenters import Paraboloid
from jkrcli.bodies.problem import Elastic, HalfSpace, Loading, Problem, Specimen
from jkrcli.measured import files as measured
from jkrcli.measured.archive import IMAGES, Map, map_of
from jkrcli.measured.batch import read_batch
from jkrcli.measured.curve import Curve, Pixel, Reading
from jkrcli.measured.figures import map_figure
from jkrcli.measured.forward_model import body_of
from jkrcli.measured.grids import placed
from jkrcli.measured.instruments import position_in
from jkrcli.measured.procedure import Failure, fit_all
from jkrcli.measured.report import Fits
from jkrcli.measured.segmentation import segment_force_curve
from jkrcli.measured.settings import settings_of
from jkrcli.report import plots

R, E_STAR, K = 5e-6, 20e3, 0.05
W = {(0, 0): 5e-5, (3, 0): 1e-4, (0, 2): 2e-4, (3, 2): None}  # by column and row; None: no contact there


BY_FLAGS = ("fit", "--shape", "paraboloid", "--radius", "5 um", "--nu", "0.5")
POSITIONS = ("position x", "position y")


def scan(path: Path, without: Sequence[str] = (), points: Sequence[tuple[int, int]] = tuple(W)) -> Path:
    """A microscope's file of a scan whose works of adhesion are ``W``, ``points`` in their order, ``without`` some
    entries."""
    afmformats = pytest.importorskip("afmformats")
    with h5py.File(path, "w") as file:
        for enum, (column, row) in enumerate(points):
            w = W[column, row]
            force = 1.5 * np.pi * (w or 1e-4) * R
            made = record(E_STAR, R, 0.0, w or 1e-4, Instrument(K, 400, 3e-6, 4 * force, 0.005 * force), enum)
            P = made["P"] if w else 0.005 * force * np.random.default_rng(1).normal(size=800)
            columns = {
                "force": P,
                "height (measured)": -made["z"],
                "segment": (made["segment"] == "retract").astype(int),
            }
            about = {"imaging mode": "force-distance", "path": "x.h5", "enum": enum, "point count": 800}
            about |= {"spring constant": K, "grid index x": column, "grid index y": row, "grid shape x": 4,
                      "grid shape y": 3, "position x": 1e-6 * column, "position y": 2e-6 * row}  # fmt: skip
            about = {name: value for name, value in about.items() if name not in without}
            afmformats.AFMForceDistance(columns, about).export_data(file, fmt="hdf5")
    return path


def test_a_map_without_positions_is_one_over_its_columns_and_rows(jkr, tmp_path: Path) -> None:
    """Named after its file, not after the case."""
    (case := tmp_path / "tip.toml").write_text(described_body.CASE.format(shape="paraboloid"))
    backwards = [(0, 0), (0, 2), (3, 0), (3, 2)]  # as it was recorded; the table follows the grid
    scan(tmp_path / "scan.h5", POSITIONS, backwards)
    assert jkr("fit", case, tmp_path / "scan.h5", "--no-plots", "-o", tmp_path / "out").ok
    rows = list(csv.DictReader((tmp_path / "out/scan-fit.csv").open()))
    assert [(int(row["map_column"]), int(row["map_row"])) for row in rows] == list(W)
    assert ([row["status"] for row in rows], rows[3]["flags"]) == (["fitted"] * 3 + ["unusable"], "no contact")
    with h5py.File(tmp_path / "out/scan-fit.h5") as file:
        np.testing.assert_array_equal(file["map/x"], [0, 3])
        assert [file[f"map/{name}"].attrs["unit"].decode() for name in ("x", "w")] == ["1", "J/m^2"]
        np.testing.assert_allclose(file["map/w"], [[5e-5, 1e-4], [2e-4, np.nan]], rtol=0.05)
        np.testing.assert_allclose(file["map/E_star"][0], E_STAR, rtol=0.1)
        assert (file["map/quality"][1, 1], file["map/status"][()].tolist()) == (0, [[2, 2], [2, 0]])


def test_a_folder_of_files_is_a_map(jkr, tmp_path: Path) -> None:
    """Named after the folder, its files by their numbers; one that cannot be read is counted and changes no other."""
    folder = tmp_path / "site.A"
    folder.mkdir()
    for number, w in {2: 1e-4, 10: 2e-4, 1: 5e-5}.items():
        force = 1.5 * np.pi * w * R
        made = record(E_STAR, R, 0.0, w, Instrument(K, 300, 3e-6, 4 * force, 0.005 * force), number)
        write_table(folder / f"curve{number}.csv", "piezo (um),force (nN)", made["z"] * 1e6, made["P"] * 1e9)
    (folder / "curve3.csv").write_text("no table\n")
    (folder / "photo.png").write_bytes(b"no table")
    outcome = jkr(*BY_FLAGS, "--stiffness", f"{K} N/m", folder, "--no-plots", "-o", tmp_path / "out").ok
    rows = list(csv.DictReader((tmp_path / "out/site.A-fit.csv").open()))
    assert [row["curve"] for row in rows] == ["curve1", "curve2", "curve10", "curve3"]
    np.testing.assert_allclose([float(row["w_J_per_m2"]) for row in rows[:3]], [5e-5, 1e-4, 2e-4], rtol=0.05)
    assert (rows[3]["status"], rows[3]["grade"]) == ("unusable", "not usable")
    assert rows[3]["reason"].startswith("not read: ")
    told = json.loads((tmp_path / "out/site.A-fit.json").read_text())["curves"][3]
    assert (told["file"], told["grade_reason"]) == (str(folder / "curve3.csv"), rows[3]["reason"])
    with h5py.File(tmp_path / "out/site.A-fit.h5") as file:
        assert json.loads(file["curves/summary"][3]) == told
    assert "3 of 4 curves fitted, 0 doubtful, 1 unusable (1 not read)" in " ".join(outcome.out.split())
    assert "curve3.csv" in outcome.err
    assert jkr(
        *BY_FLAGS, "--stiffness", f"{K} N/m", folder, "--where", "curve=curve10", "--no-plots", "-o", tmp_path
    ).ok
    assert [row["curve"] for row in csv.DictReader((tmp_path / "site.A-fit.csv").open())] == ["curve10", "curve3"]


def test_curves_without_a_grid_are_drawn_over_their_numbers(tmp_path: Path) -> None:
    from jkrcli.measured.figures import curves_figure

    problem = Problem(Paraboloid(R), Specimen((), HalfSpace(Elastic(15e3, 0.5))), Loading("radius", 4e-6, 40))
    body = body_of(problem)
    curves = measured.read(scan(tmp_path / "scan.h5", ("grid index x", *POSITIONS)))
    with executor(1) as pool:
        outcomes = fit_all(body, curves, settings_of(body, (), ()), pool)
    warned = [replace(one, warnings=(f"a/R = 0.3{i} is above 0.3",)) for i, one in enumerate(outcomes[:3])]
    (warning,) = Fits(warned, "").warnings  # one line for the same of many curves
    assert warning.endswith("a/R = 0.30 is above 0.3 (2 more curves with this warning)")
    assert len(Fits(warned[:2], "").warnings) == 2
    figure = curves_figure([*outcomes[:3], *outcomes[:1]])  # none unusable
    plots.save(figure, [tmp_path / "curves.png"])
    assert all(axes.get_position().height > 0.25 for axes in figure.axes)
    modulus, work = curves_figure(outcomes).axes
    for axes, size in ((modulus, E_STAR / 1e3), (work, 5e-5 / 1e-6)):
        fitted, doubtful, unusable = (np.array(line.get_xydata()) for line in axes.lines)
        assert fitted[:, 0].tolist() == [1, 2, 3]
        assert fitted[0, 1] == pytest.approx(size, rel=0.1)
        assert len(doubtful) == 0
        assert unusable[:, 0].tolist() == [4]


# ---------------------------------------------------------------------- where curves were taken
NOWHERE = Path("day")
MADE = record(2e5, 5e-6, 2e-4, 1e-3, Instrument(0.3, 150, 1.5e-6, 40e-9, 1e-10), 1)


def curves(names: Sequence[str], pixels: Sequence[Pixel] = ()) -> list[Curve]:
    z = np.linspace(0, 1, 9)
    return [Curve(name, delta=z, P=z, pixel=pixels[i] if pixels else None) for i, name in enumerate(names)]


def places(found: Sequence[Curve]) -> list[tuple[str, int, int]]:
    return [(one.name, one.pixel.column, one.pixel.row) for one in found if one.pixel is not None]


@pytest.mark.parametrize(
    ("head", "x", "y"),
    [
        (("# x: 1.5 um", "# y: -2 um"), 1.5e-6, -2e-6),
        (("# xPosition: 1.2e-06", "# yPosition: 0"), 1.2e-6, 0.0),
        (("X Position [nm] = 30", "Y Position [nm] = 4e2"), 3e-8, 4e-7),
    ],
)
def test_positions_in_headers(head: tuple[str, ...], x: float, y: float) -> None:
    found = position_in(head)
    assert (found.x, found.y) == pytest.approx((x, y), rel=1e-12)


@pytest.mark.parametrize(
    "head", [("# x: 1.5 um",), ("# x: 3", "# y: 4"), ("x: 1 um, y: 2 um",), ("max: 3 um", "y: 2 um")]
)
def test_half_a_position_or_one_without_a_unit_is_none(head: tuple[str, ...]) -> None:
    assert position_in(head) is None


def test_positions_that_scatter_about_a_grid_are_its_lines() -> None:
    rng, order = np.random.default_rng(3), np.random.default_rng(4).permutation(12)
    pixels = [Pixel(0, 0, 5e-6 * (i % 4) + 3e-7 * rng.normal(), 7e-6 * (i // 4) + 3e-7 * rng.normal()) for i in order]
    found, words = placed(NOWHERE, curves([str(i) for i in order], pixels), None)
    assert words == "positions in headers"
    assert places(found) == [(str(i), i % 4, i // 4) for i in range(12)]


@pytest.mark.parametrize("jitter", [0.0, 0.06])
def test_lines_of_a_grid_without_a_curve_are_places_too(jitter: float) -> None:
    rng = np.random.default_rng(8)
    columns, rows = (0, 1, 6, 7), (0, 3, 4)
    pixels = [Pixel(0, 0, *(2e-6 * (at + jitter * rng.normal()) for at in (i, j))) for j in rows for i in columns]
    found, words = placed(NOWHERE, curves([f"{at.x}" for at in pixels], pixels), None)
    assert words == "positions in headers"
    assert [place[1:] for place in places(found)] == [(i, j) for j in rows for i in columns]


@pytest.mark.parametrize(
    ("name", "words"),
    [("r{row:02}c{column:02}", "row, column in names"), ("x{column}_y{row}", "column, row in names"),
     ("c{column}r{row}_a", "column, row in names"), ("map_{row}_{column}", "row, column in names")],
)  # fmt: skip
def test_places_in_names(name: str, words: str) -> None:
    names = [name.format(row=row, column=column) for row in range(3) for column in range(5)]
    found, said = placed(NOWHERE, curves(names[::-1]), None)
    assert said == words
    assert places(found) == [(one, i % 5, i // 5) for i, one in enumerate(names)]


@pytest.mark.parametrize(
    "names", [["a1", "a2", "a3", "a4"], ["s_2024_11", "s_2024_12", "s_2024_13", "s_2024_14"],
              ["f_1_9", "f_22_3", "f_4_51", "f_60_8"], ["r1c1", "r1c2", "r2c1", "other"]],
)  # fmt: skip
def test_numbers_that_fill_no_grid_are_no_places(names: list[str]) -> None:
    assert placed(NOWHERE, curves(names), None)[1] == ""


def write_grid(folder: Path, names: Sequence[str], heads: Sequence[str] = ()) -> None:
    folder.mkdir()
    for i, name in enumerate(names):
        export(folder / name, MADE, "# springConstant: 0.3" + (f"\n{heads[i].rstrip()}" if heads else ""))


def test_folders_that_hold_nothing_or_too_little(tmp_path: Path, jkr) -> None:
    write_grid(tmp_path / "map", [f"f{i}.txt" for i in range(6)])
    (tmp_path / "map/f2.txt").write_text("no table\n")
    batch = read_batch([tmp_path / "map"], Reading(), (3, 2))
    assert batch.places == ("row by row as specified",)
    assert places(batch.read[0][0]) == [("f0", 0, 0), ("f1", 1, 0), ("f3", 0, 1), ("f4", 1, 1), ("f5", 2, 1)]
    with pytest.raises(InputError, match="holds 6 curves, --grid 4x2 has 8 places"):
        read_batch([tmp_path / "map"], Reading(), (4, 2))
    (tmp_path / "empty").mkdir()
    jkr(*BY_FLAGS, tmp_path / "empty").refused("empty: the folder holds no measured curves")


def test_a_fit_says_which_places_it_took(jkr: Callable, tmp_path: Path) -> None:
    heads = [f"# x: {5 * (i % 2)} um\n# y: {3 * (i // 2)} um\n" for i in range(4)]
    write_grid(tmp_path / "scan", [f"f{i}.txt" for i in range(4)], heads)
    write_grid(tmp_path / "row", [f"f{i}.txt" for i in range(4)])
    words = ("fit", "--radius", "5 um", "--nu", "0.5", "--shape", "paraboloid", "-o", "out")
    for folder, said in (("scan", "the map (2 x 2, positions in headers) in out/scan-fit-map{.png,.svg}"),
                         ("row", "curves in their order in out/row-fit-curves{.png,.svg}")):  # fmt: skip
        done = jkr(*words, folder).ok
        assert said in " ".join(done.out.split())
    rows = list(csv.DictReader((tmp_path / "out/scan-fit.csv").read_text().splitlines()))
    assert [(row["map_column"], row["map_row"]) for row in rows] == [("0", "0"), ("1", "0"), ("0", "1"), ("1", "1")]
    assert [float(rows[3][name]) for name in ("x_m", "y_m")] == pytest.approx([5e-6, 3e-6])


def test_a_sparse_map_has_its_cells_at_their_places() -> None:
    # Columns 10 µm apart of which two hold no curve, rows numbered by twos: cells are squares, none is stretched.
    pixels = [Pixel(i, 2 * j, 1e-5 * i, 1e-5 * j) for j in range(3) for i in (0, 1, 4)]
    unread = Failure(None, ("scan/notes.txt: is no table",))
    scan = map_of([*(Failure(one, ("no contact",)) for one in curves([str(at) for at in pixels], pixels)), unread])
    np.testing.assert_allclose(scan.x, 1e-5 * np.arange(5))
    np.testing.assert_allclose(scan.y, 1e-5 * np.arange(3))
    np.testing.assert_array_equal(np.isnan(scan.images["status"]), [[False, False, True, True, False]] * 3)
    (mesh,) = (one for one in map_figure(scan).axes[0].collections if isinstance(one, QuadMesh))
    corners = mesh.get_coordinates()
    np.testing.assert_allclose(np.diff(corners[..., 0], axis=1), 1e-5, rtol=1e-9)
    np.testing.assert_allclose(np.diff(corners[..., 1], axis=0), 1e-5, rtol=1e-9)
    x = np.arange(8) * 2.5e-6
    image = np.arange(64.0).reshape(8, 8)
    image[2, 3] = np.nan
    figure = map_figure(Map(x, x, dict.fromkeys(IMAGES, image)))
    panel = figure.axes[0]
    assert panel.get_facecolor()[:3] == pytest.approx((0.8, 0.8, 0.8))
    bar, *_ = panel.get_lines()
    assert float(np.ptp(bar.get_xdata())) == pytest.approx(10e-6)  # of 20 µm, a quarter or more, round
    assert [text.get_text() for text in panel.texts] == ["10 µm"]


@pytest.mark.slow
def test_each_sample_with_places_is_a_map_of_its_own(jkr: Callable, tmp_path: Path) -> None:
    heads = [f"# x: {5 * (i % 2)} um\n# y: {3 * (i // 2)} um\n" for i in range(4)]
    for name in ("ctrl", "drug A"):
        write_grid(tmp_path / name, [f"f{i}.txt" for i in range(4)], heads)
    done = jkr("fit", "--radius", "5 um", "--nu", "0.5", "--shape", "paraboloid", "ctrl", "drug A", "-o", "out").ok
    assert "the map of drug A (2 x 2, positions in headers) in out/fit-map-drug-A{.png,.svg}" in " ".join(
        done.out.split()
    )
    assert sorted(path.name for path in Path("out").glob("*-map*.png")) == ["fit-map-ctrl.png", "fit-map-drug-A.png"]
    with h5py.File("out/fit.h5") as file:
        assert file["maps/drug A/E_star"].shape == (2, 2)


def test_a_map_with_positions_shows_E_star_along_its_middle_row_and_column() -> None:
    x, y = np.arange(5) * 2e-6 + 1e-3, np.arange(7) * 3e-6
    image = 1e3 * (10 * np.arange(7.0)[:, None] + np.arange(5.0))
    image[3, 1] = np.nan
    names = dict.fromkeys(IMAGES, image)
    panels = {axes.get_title(): axes for axes in map_figure(Map(x, y, names)).axes}
    (row,), (column,) = (panels[f"along the middle {line}"].get_lines() for line in ("row", "column"))
    np.testing.assert_allclose(row.get_xdata(), [0, 2, 4, 6, 8])
    np.testing.assert_allclose(row.get_ydata(), [30, np.nan, 32, 33, 34])
    np.testing.assert_allclose(column.get_xdata(), 3.0 * np.arange(7))
    np.testing.assert_allclose(column.get_ydata(), 10.0 * np.arange(7) + 2)
    _, *lines = map_figure(Map(x, y, names)).axes[0].get_lines()
    assert [len({*line.get_ydata()}) for line in lines] == [1, 2]
    image[3], image[:, 2] = np.nan, np.nan  # lines beside these hold values
    titles = {axes.get_title() for axes in map_figure(Map(x, y, names)).axes}
    assert {"along row 3", "along column 2"} <= titles
    unplaced = map_figure(Map(np.arange(5.0), np.arange(7.0), names, positions=False))
    assert not any("along" in axes.get_title() for axes in unplaced.axes)


# ---------------------------------------------------------------------- files together settle sign, constants, units
STIFF, TIP = 0.3, 5e-6
ONE = record(2e5, TIP, 2e-4, 1e-3, Instrument(STIFF, 200, 1.5e-6, 40e-9, 1e-10), 1)


@dataclass(frozen=True)
class File:
    """One file of a folder: ``sign`` of its column of positions, what it holds, its unit as it is labelled."""

    sign: int
    holds: str = "contact"
    unit: str = "um"
    stiffness: bool = True

    def write(self, path: Path, title: str, seed: int) -> None:
        rng = np.random.default_rng(seed)
        z, P = ONE["z"], ONE["P"] + 1e-10 * rng.normal(size=ONE["z"].size)
        P = P if self.holds != "noise" else 1e-10 * rng.normal(size=z.size)
        rows = slice(0, 30 if self.holds == "cut" else None)
        lines = [f"# springConstant: {STIFF}"] * self.stiffness + [f"{title} ({self.unit}),force (nN),segment"]
        lines += [f"{self.sign * x * 1e6:.7g},{p * 1e9:.7g},{word}"
                  for x, p, word in zip(z[rows], P[rows], ONE["segment"][rows], strict=True)]  # fmt: skip
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
        assert curve.stiffness == STIFF
        truth = ONE["z"] if file.sign == most else -ONE["z"]  # with the sign of the others
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
    (tmp_path / "2.txt").write_text((tmp_path / "2.txt").read_text().replace(str(STIFF), "0.7"))
    with pytest.raises(InputError, match=r"1 file lacks the stiffness .*3\.txt.*, the others name 0\.3, 0\.7: give"):
        read_batch([tmp_path], Reading())
    flipped = read_batch([tmp_path], Reading(stiffness=STIFF, flip=frozenset({"delta"})))
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
