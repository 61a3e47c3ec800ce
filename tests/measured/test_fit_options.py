"""No option of ``jkr fit`` is without effect: on each kind of record it changes what is found, or is refused."""

import json
import math
import re
from collections.abc import Callable
from pathlib import Path

import click
import numpy as np
import pytest
from fit_data import adhesive
from force_curves import Instrument
from force_curves import record as cycle
from rate_records import retraction
from test_tension import LARGE, SMALL
from test_tension import record as tense

from jkrcli.case import store
from jkrcli.measured.verbs import fit
from jkrcli.resolve.analysis import nonadhesive

CASE = """
indenter = { shape = "paraboloid", radius = "1 mm" }
specimen.half_space = { E = "1 MPa", nu = 0.3 }
loading = { radius = "0.1 mm", points = 40, spacing = "log" }
"""
KINDS: dict[str, tuple[str, ...]] = {
    "raw": ("raw.csv", "--radius", "5 um", "--nu", "0.5", "--stiffness", "0.3 N/m"),
    "raw case": ("soft.toml", "raw.csv", "--stiffness", "0.3 N/m"),
    "table": ("lens.toml", "probe.csv"),
    "table flags": ("probe.csv", "--radius", "1 mm", "--nu", "0.3"),
    "joint": ("lens.toml", "probe.csv", "second.csv", "--shared", "E_star", "--tip-radius", "1 mm",
              "--tip-radius", "2 mm"),
    "tension": ("soft.toml", "small.csv", "large.csv", "--free", "surface_tension", "--tip-radius", "3 um",
                "--tip-radius", "30 um"),
    "relaxation": ("lens.toml", "held.csv", "--relaxation", "sls"),
    "law": ("lens.h5", "slow.csv", "fast.csv", "--law", "power", "--fix", "delta0=0"),
}  # fmt: skip
VALUES: dict[str, tuple[str, ...]] = {
    "--shape": ("cone",), "--radius": ("2 mm",), "--half-angle": ("80 deg",), "--cap": ("parabola",),
    "--E": ("2 MPa",), "--nu": ("0.4",),
    "--thickness": ("50 um",), "--base": ("frictionless",), "--free": ("compliance",), "--fix": ("E_star=1 MPa",),
    "--bound": ("w=60 mJ/m^2..1 J/m^2",), "--law": ("log",), "--relaxation": ("prony",), "--terms": ("1",),
    "--segment": ("approach",), "--base-line": ("sine",), "--branch": ("compressive",), "--noise": ("P=30 uN",),
    "--loss": ("cauchy",), "--confidence": ("bootstrap",), "--model": ("auto",), "--level": ("0.5",),
    "--samples": ("30",), "--seed": ("7",), "--shared": ("w",), "--own": ("w",), "--tip-radius": ("3 mm",),
    "--surface": ("sticking",), "--uncertain": ("radius=20%",), "--slopes": ("integral",), "--column": ("P=a_um",),
    "--unit": ("P=mN",), "--factor": ("P=2",), "--flip": ("P",), "--zero": ("delta=0.1 um",),
    "--contact": ("estimate",),
    "--stiffness": ("5 N/m",), "--sensitivity": ("45 nm/V",), "--format": ("afm",), "--separator": ("tab",),
    "--decimal": (",",), "--rows": ("5..60",), "--where": ("segment=approach",), "--limit-memory": ("1e-12",),
    "--limit-time": ("1e-12",), "--output": ("there",),
}  # fmt: skip
# Estimated zeros are those of a whole record where there is one; nothing asks for other models of a right one.
OWN: dict[str, dict[str, tuple[str, ...]]] = {
    "raw": {"--contact": ("as-is",)}, "raw case": {"--contact": ("as-is",), "--model": ("jkr", "--rivals")}
}  # fmt: skip
ANYWAY = {"tension": ["--no-plots"]}  # no picture is drawn of it
# A place to begin does not change the end; how much is said, and where it is computed, changes nothing.
# Options that make a kind of their own have its tests.
EXEMPT = {"--law", "--relaxation", "--shared", "--start", "--force", "--quiet", "--verbose", "--workers", "--scheduler"}
ASKED = {"level", "settings", "versions", "command"}
OPTIONS = [
    each for each in fit.params if isinstance(each, click.Option) and not each.is_eager and each.opts[-1] not in EXEMPT
]


def _write(path: Path, header: str, *columns: object) -> None:
    rows = "\n".join(",".join(map(str, row)) for row in zip(*columns, strict=True))
    path.write_text(f"{header}\n{rows}\n")


def _pulled(path: Path, R: float, rng: np.random.Generator) -> None:
    """Rows of a contact that is pressed a little and pulled off, with noise: JKR of ``CASE``."""
    E_star, w = 1e6 / 0.91, 0.05
    least = (9 * math.pi * w * R**2 / (8 * E_star)) ** (1 / 3)
    a = least * np.concatenate([np.linspace(1.1, 1.6, 20), np.linspace(1.6, 1.02, 50)])
    delta, P = adhesive(a, E_star, w, R)
    segment = np.repeat(["approach", "retract"], [20, 50])
    _write(path, "t_s,a_um,delta_um,P_uN,segment", np.arange(70.0), a * 1e6, delta * 1e6 + rng.normal(0, 0.01, 70),
           P * 1e6 + rng.normal(0, 3, 70), segment)  # fmt: skip


@pytest.fixture(name="folder")
def _folder(jkr: Callable, tmp_path: Path) -> Path:
    """Bodies, and records of every kind."""
    rng = np.random.default_rng(1)
    (tmp_path / "lens.toml").write_text(CASE)
    (tmp_path / "soft.toml").write_text(CASE.replace("1 mm", "5 um").replace("0.1 mm", "2 um").replace("0.3", "0.5"))
    for name, R in (("probe", 1e-3), ("second", 2e-3)):
        _pulled(tmp_path / f"{name}.csv", R, rng)
    for name, R in (("small", SMALL), ("large", LARGE)):
        curve = tense(R, 0.01, 1)
        _write(tmp_path / f"{name}.csv", "delta_um,P_nN", curve.delta * 1e6, curve.P * 1e9)
    raw = cycle(2e5, 5e-6, 2e-4, 1e-3, Instrument(0.3, 120, 2e-6, 6e-8, 1e-10), 1)
    _write(tmp_path / "raw.csv", "t_s,delta_um,P_nN,segment", raw["t"], raw["z"] * 1e6, raw["P"] * 1e9,
           raw["segment"])  # fmt: skip
    assert jkr("run", "lens.toml", "-q").code == 0
    body = nonadhesive(store.read_solution(tmp_path / "lens.h5"))
    for name, V in (("slow", 2e-7), ("fast", 2e-6)):
        t, delta, P, _ = retraction(body, 0.05, 1e-6, 0.5, V, 8e-5, math.inf, 80)
        delta, P = (column + 0.01 * np.ptp(column) * rng.normal(size=t.size) for column in (delta, P))
        _write(tmp_path / f"{name}.csv", "t_s,delta_um,P_uN", t, delta * 1e6, P * 1e6)
    t = np.linspace(0.0, 8.0, 8001)  # pressed within a second, then held: a standard solid, step by step
    rise = np.gradient(5e-6**1.5 * np.minimum(t, 1.0) ** 1.5, t)
    relaxing = np.zeros_like(t)
    for i in range(1, t.size):
        relaxing[i] = relaxing[i - 1] + (t[1] - t[0]) * (rise[i] - relaxing[i - 1])
    P = 4 / 3 * 1.1e6 * math.sqrt(1e-3) * (0.25 * 5e-6**1.5 * np.minimum(t, 1.0) ** 1.5 + 0.75 * relaxing)
    P, delta = (c + 0.005 * np.ptp(c) * rng.normal(size=t.size) for c in (P, 5e-6 * np.minimum(t, 1.0)))
    _write(tmp_path / "held.csv", "t_s,delta_um,P_uN", t[::40], delta[::40] * 1e6, P[::40] * 1e6)
    return tmp_path


def _found(path: Path) -> str:
    """What a file tells of what was found, and not of what was asked."""
    if path.suffix != ".json":
        return path.read_text() if path.suffix == ".csv" else ""
    return json.dumps({key: told for key, told in json.loads(path.read_text()).items() if key not in ASKED})


@pytest.mark.slow
@pytest.mark.parametrize("kind", KINDS)
def test_every_option_changes_what_is_found_or_is_refused(jkr: Callable, folder: Path, kind: str) -> None:
    before = {path.name for path in folder.iterdir()}

    def tried(*words: str) -> tuple[int, str, dict[str, str]]:
        """Exit code, output, tables and estimates, and which files are left."""
        for path in set(folder.rglob("*")) - {folder / name for name in before}:
            if path.is_file():
                path.unlink()
        done = jkr("fit", *words)
        left = {str(path.relative_to(folder)): _found(path) for path in sorted(folder.rglob("*")) if path.is_file()}
        return done.code, re.sub(r"[\d.]+ m?s\b", "", done.out + done.err), left

    values = VALUES | OWN.get(kind, {})
    plain = tried(*KINDS[kind])
    assert plain[0] == 0, plain[1]
    without = []
    for option in OPTIONS:
        name = option.opts[-1]
        words = () if option.is_flag else values[name]
        found = tried(*KINDS[kind], name, *words)
        if found == plain:
            without.append(name)
        assert found[0] == 0 or "jkr: error: " in found[1]
    assert without == ANYWAY.get(kind, []), " ".join(without)
