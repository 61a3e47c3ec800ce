"""A format of files of one's own registers itself, from outside, and is read wherever measured curves are."""

import json
import struct
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest

import jkrcli
from jkrcli.measured import formats
from jkrcli.measured.curve import AsRead, Curve, Reading

MARK = b"MINE"


def curves(path: Path, reading: Reading) -> Iterator[AsRead]:
    """Displacements [m] and loads [N], as doubles behind the mark."""
    numbers = np.frombuffer(path.read_bytes()[len(MARK) :]).reshape(2, -1)
    yield Curve("one", delta=numbers[0], P=numbers[1], origin=path), None


@pytest.fixture
def mine(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(formats, "FORMATS", dict(formats.FORMATS))
    formats.register(formats.Format("mine", lambda path: path.read_bytes().startswith(MARK), curves, maps=(".mine",)))


@pytest.mark.usefixtures("mine")
def test_a_format_of_ones_own_is_read_by_every_verb(jkr: Callable, tmp_path: Path) -> None:
    delta = np.linspace(1e-8, 4e-7, 60)
    P = 16 / 9 * 1e4 * np.sqrt(5e-6) * delta**1.5  # Hertz: E = 1e4 Pa, nu = 1/2, R = 5 um
    path = tmp_path / "record.mine"
    path.write_bytes(MARK + struct.pack(f"{2 * delta.size}d", *delta, *P))

    (read,) = jkrcli.measured_curves(path)
    assert np.array_equal(read.P, P)
    assert "60 rows" in jkr("look", path, "--no-plots").out

    done = jkr("fit", path, "--shape", "paraboloid", "--radius", "5 um", "--nu", "0.5", "--fix", "w=0", "--no-plots",
               "--json", "-o", ".")  # fmt: skip
    estimates = json.loads(done.out)["curves"][0]["estimates"]
    assert estimates["E_star"]["value"] == pytest.approx(1e4 / 0.75, rel=1e-3)
