"""Where curves of a folder were taken: by headers, names, or a grid as specified; else they are in their order."""

import csv
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
import pytest
from force_curves import Instrument, record
from matplotlib.collections import QuadMesh

from jkrcli.base.errors import InputError
from jkrcli.measured.archive import IMAGES, Map, map_of
from jkrcli.measured.batch import read_batch
from jkrcli.measured.curve import Curve, Pixel, Reading
from jkrcli.measured.figures import map_figure
from jkrcli.measured.grids import placed
from jkrcli.measured.instruments import position_in
from jkrcli.measured.procedure import Failure

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


def write(folder: Path, names: Sequence[str], heads: Sequence[str] = ()) -> None:
    folder.mkdir()
    rows = "".join(f"{z * 1e6:.7g},{P * 1e9:.7g},{word}\n"
                   for z, P, word in zip(MADE["z"], MADE["P"], MADE["segment"], strict=True))  # fmt: skip
    for i, name in enumerate(names):
        head = heads[i] if heads else ""
        (folder / name).write_text(f"# springConstant: 0.3\n{head}piezo (um),force (nN),segment\n{rows}")


def test_a_specified_grid_counts_files_that_cannot_be_read(tmp_path: Path) -> None:
    write(tmp_path / "map", [f"f{i}.txt" for i in range(6)])
    (tmp_path / "map/f2.txt").write_text("no table\n")
    batch = read_batch([tmp_path / "map"], Reading(), (3, 2))
    assert batch.places == ("row by row as specified",)
    assert places(batch.read[0][0]) == [("f0", 0, 0), ("f1", 1, 0), ("f3", 0, 1), ("f4", 1, 1), ("f5", 2, 1)]
    with pytest.raises(InputError, match="holds 6 curves, --grid 4x2 has 8 places"):
        read_batch([tmp_path / "map"], Reading(), (4, 2))


def test_a_fit_says_which_places_it_took(jkr: Callable, tmp_path: Path) -> None:
    heads = [f"# x: {5 * (i % 2)} um\n# y: {3 * (i // 2)} um\n" for i in range(4)]
    write(tmp_path / "scan", [f"f{i}.txt" for i in range(4)], heads)
    write(tmp_path / "row", [f"f{i}.txt" for i in range(4)])
    words = ("fit", "--radius", "5 um", "--nu", "0.5", "--shape", "paraboloid", "-o", "out")
    for folder, said in (("scan", "the map (2 x 2, positions in headers) in out/scan-fit-map{.png,.svg}"),
                         ("row", "curves in their order in out/row-fit-curves{.png,.svg}")):  # fmt: skip
        done = jkr(*words, folder)
        assert done.code == 0, done.err
        assert said in " ".join(done.out.split())
    rows = list(csv.DictReader((tmp_path / "out/scan-fit.csv").read_text().splitlines()))
    assert [(row["map_column"], row["map_row"]) for row in rows] == [("0", "0"), ("1", "0"), ("0", "1"), ("1", "1")]
    assert [float(rows[3][name]) for name in ("x_m", "y_m")] == pytest.approx([5e-6, 3e-6])


def test_a_sparse_map_has_its_cells_at_their_places() -> None:
    """Columns 10 µm apart of which two hold no curve, rows numbered by twos: cells are squares, none is stretched."""
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


@pytest.mark.slow
def test_each_sample_with_places_is_a_map_of_its_own(jkr: Callable, tmp_path: Path) -> None:
    h5py = pytest.importorskip("h5py")
    heads = [f"# x: {5 * (i % 2)} um\n# y: {3 * (i // 2)} um\n" for i in range(4)]
    for name in ("ctrl", "drug A"):
        write(tmp_path / name, [f"f{i}.txt" for i in range(4)], heads)
    done = jkr("fit", "--radius", "5 um", "--nu", "0.5", "--shape", "paraboloid", "ctrl", "drug A", "-o", "out")
    assert done.code == 0, done.err
    assert "the map of drug A (2 x 2, positions in headers) in out/fit-map-drug-A{.png,.svg}" in " ".join(
        done.out.split()
    )
    assert sorted(path.name for path in Path("out").glob("*-map*.png")) == ["fit-map-ctrl.png", "fit-map-drug-A.png"]
    with h5py.File("out/fit.h5") as file:
        assert file["maps/drug A/E_star"].shape == (2, 2)


def test_a_map_has_a_bar_of_its_scale_and_grey_places_without_a_value() -> None:
    x = np.arange(8) * 2.5e-6
    image = np.arange(64.0).reshape(8, 8)
    image[2, 3] = np.nan
    figure = map_figure(Map(x, x, dict.fromkeys(IMAGES, image)))
    panel = figure.axes[0]
    assert panel.get_facecolor()[:3] == pytest.approx((0.8, 0.8, 0.8))
    bar, *_ = panel.get_lines()
    assert float(np.ptp(bar.get_xdata())) == pytest.approx(10e-6)  # of 20 µm, a quarter or more, round
    assert [text.get_text() for text in panel.texts] == ["10 µm"]


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
