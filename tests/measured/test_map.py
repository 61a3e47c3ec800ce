"""Maps of fitted curves: images by pixel, as numbers in a file and as a picture."""

import csv
import json
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import described_body
import numpy as np
import pytest
from conftest import write_table
from force_curves import Instrument, record

from jkrcli.base.executors import executor
from jkrcli.bodies.indenters import Paraboloid
from jkrcli.bodies.problem import Elastic, HalfSpace, Loading, Problem, Specimen
from jkrcli.measured import files as measured
from jkrcli.measured.archive import IMAGES
from jkrcli.measured.forward_model import body_of
from jkrcli.measured.procedure import fit_all
from jkrcli.measured.report import Fits
from jkrcli.measured.settings import settings_of
from jkrcli.report import plots

R, E_STAR, K = 5e-6, 20e3, 0.05
W = {(0, 0): 5e-5, (3, 0): 1e-4, (0, 2): 2e-4, (3, 2): None}  # by column and row; None: no contact there


BY_FLAGS = ("fit", "--shape", "paraboloid", "--radius", "5 um", "--nu", "0.5")
POSITIONS = ("position x", "position y")


def scan(path: Path, without: Sequence[str] = (), points: Sequence[tuple[int, int]] = tuple(W)) -> Path:
    """A microscope's file of a scan whose works of adhesion are ``W``, ``points`` in their order, ``without`` some
    entries."""
    afmformats, h5py = pytest.importorskip("afmformats"), pytest.importorskip("h5py")
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


@pytest.mark.slow
def test_a_scan_becomes_images_one_row_per_pixel(jkr, tmp_path: Path) -> None:
    h5py = pytest.importorskip("h5py")
    scan(tmp_path / "scan.h5")
    outcome = jkr(*BY_FLAGS, tmp_path / "scan.h5", "-o", tmp_path / "out")
    assert outcome.code == 0, outcome.err
    assert "the map (2 x 2, places by the instrument) in " in " ".join(outcome.out.split())
    rows = list(csv.DictReader((tmp_path / "out/scan-fit.csv").open()))
    assert [(int(row["map_column"]), int(row["map_row"])) for row in rows] == list(W)
    assert [row["status"] for row in rows] == ["fitted"] * 3 + ["unusable"]
    assert rows[3]["flags"] == "no contact"
    assert float(rows[1]["adhesion_force_N"]) == pytest.approx(1.5 * np.pi * 1e-4 * R, rel=0.1)
    with h5py.File(tmp_path / "out/scan-fit.h5") as file:
        images = {name: file["map"][name][:] for name in IMAGES}
        assert file["map/w"].attrs["unit"].decode() == "J/m^2"
        np.testing.assert_allclose(file["map/x"], [0, 3e-6])
        np.testing.assert_allclose(file["map/y"], [0, 4e-6])
    np.testing.assert_allclose(images["w"], [[5e-5, 1e-4], [2e-4, np.nan]], rtol=0.05)
    np.testing.assert_allclose(images["E_star"][0], E_STAR, rtol=0.1)
    assert images["quality"][1, 1] == 0
    assert images["status"].tolist() == [[2, 2], [2, 0]]
    assert "3 of 4 curves fitted, 0 doubtful, 1 unusable (1 no contact)" in " ".join(outcome.out.split())
    assert (tmp_path / "out/scan-fit-map.png").stat().st_size > 1000
    assert json.loads((tmp_path / "out/scan-fit.json").read_text())["curves"][3]["flags"] == ["no contact"]


def test_a_map_without_positions_is_one_over_its_columns_and_rows(jkr, tmp_path: Path) -> None:
    h5py = pytest.importorskip("h5py")
    backwards = [(0, 0), (0, 2), (3, 0), (3, 2)]  # as it was recorded; the table follows the grid
    scan(tmp_path / "scan.h5", POSITIONS, backwards)
    outcome = jkr(*BY_FLAGS, tmp_path / "scan.h5", "--no-plots", "-o", tmp_path / "out")
    assert outcome.code == 0, outcome.err
    rows = list(csv.DictReader((tmp_path / "out/scan-fit.csv").open()))
    assert [(int(row["map_column"]), int(row["map_row"])) for row in rows] == list(W)
    with h5py.File(tmp_path / "out/scan-fit.h5") as file:
        np.testing.assert_array_equal(file["map/x"], [0, 3])
        assert file["map/x"].attrs["unit"].decode() == "1"


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
    outcome = jkr(*BY_FLAGS, "--stiffness", f"{K} N/m", folder, "--no-plots", "-o", tmp_path / "out")
    assert outcome.code == 0, outcome.err
    rows = list(csv.DictReader((tmp_path / "out/site.A-fit.csv").open()))
    assert [row["curve"] for row in rows] == ["curve1", "curve2", "curve10", "curve3"]
    np.testing.assert_allclose([float(row["w_J_per_m2"]) for row in rows[:3]], [5e-5, 1e-4, 2e-4], rtol=0.05)
    assert (rows[3]["status"], rows[3]["grade"]) == ("unusable", "not usable")
    assert rows[3]["reason"].startswith("not read: ")
    told = json.loads((tmp_path / "out/site.A-fit.json").read_text())["curves"][3]
    assert (told["file"], told["grade_reason"]) == (str(folder / "curve3.csv"), rows[3]["reason"])
    with pytest.importorskip("h5py").File(tmp_path / "out/site.A-fit.h5") as file:
        assert json.loads(file["curves/summary"][3]) == told
    assert "3 of 4 curves fitted, 0 doubtful, 1 unusable (1 not read)" in " ".join(outcome.out.split())
    assert "curve3.csv" in outcome.err
    one = jkr(*BY_FLAGS, "--stiffness", f"{K} N/m", folder, "--where", "curve=curve10", "--no-plots", "-o", tmp_path)
    assert one.code == 0, one.err
    assert [row["curve"] for row in csv.DictReader((tmp_path / "site.A-fit.csv").open())] == ["curve10", "curve3"]


def test_an_empty_folder_is_refused(jkr, tmp_path: Path) -> None:
    (tmp_path / "empty").mkdir()
    jkr(*BY_FLAGS, tmp_path / "empty").refused("empty: the folder holds no measured curves")


def test_a_map_is_named_after_its_file_not_after_the_case(jkr, tmp_path: Path) -> None:
    case = tmp_path / "tip.toml"
    case.write_text(described_body.CASE.format(shape="paraboloid"))
    scan(tmp_path / "scan.h5", ("grid index x", *POSITIONS), [(0, 0), (3, 0)])
    outcome = jkr("fit", case, tmp_path / "scan.h5", "--no-plots", "-o", tmp_path / "out")
    assert outcome.code == 0, outcome.err
    assert (tmp_path / "out/scan-fit.csv").exists()


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
