"""Maps of fitted curves: images by pixel, as numbers in a file and as a picture."""

from __future__ import annotations

import csv
import json
from pathlib import Path

import numpy as np
import pytest
from force_curves import Instrument, record

from jkrcli.report.map import IMAGES

R, E_STAR, K = 5e-6, 20e3, 0.05
W = {(0, 0): 5e-5, (3, 0): 1e-4, (0, 2): 2e-4, (3, 2): None}  # by column and row; None: no contact there


def scan(path: Path) -> Path:
    """A microscope's file of a scan whose works of adhesion are ``W``."""
    afmformats, h5py = pytest.importorskip("afmformats"), pytest.importorskip("h5py")
    with h5py.File(path, "w") as file:
        for enum, ((column, row), w) in enumerate(W.items()):
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
            afmformats.AFMForceDistance(columns, about).export_data(file, fmt="hdf5")
    return path


@pytest.mark.slow
def test_a_scan_becomes_images_one_row_per_pixel(jkr, tmp_path: Path) -> None:
    h5py = pytest.importorskip("h5py")
    scan(tmp_path / "scan.h5")
    outcome = jkr(
        "fit", "--shape", "paraboloid", "--radius", "5 um", "--nu", "0.5", tmp_path / "scan.h5", "-o", tmp_path / "out"
    )
    assert outcome.code == 0, outcome.err
    assert "the map in " in outcome.out
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
    assert (tmp_path / "out/scan-fit-map.png").stat().st_size > 1000
    assert json.loads((tmp_path / "out/scan-fit.json").read_text())["curves"][3]["flags"] == ["no contact"]
