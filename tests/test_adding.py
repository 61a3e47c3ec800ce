"""Adding an indenter, a method, a slopes rule or a law is one file: each is used in a process of its own."""

import csv
import dataclasses
import json
import os
import re
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Annotated

import numpy as np
import pytest
from conftest import Outcome

from jkrcli.base.arguments import read_fields
from jkrcli.base.errors import InputError
from jkrcli.base.numerics import Array
from jkrcli.base.units import Ranged
from jkrcli.case import store
from jkrcli.case.models import method_of, options_of, parse_case
from jkrcli.formulas import foundation_modulus, thin_layer
from jkrcli.methods.layered.solver import Layered
from jkrcli.methods.protocol import METHODS

CASE = """
method = "{method}"
[indenter]
shape = "{shape}"
radius = "1 mm"
{keys}
[[specimen.layers]]
E = "1 MPa"
nu = 0.3
thickness = "{thickness}"
[loading]
radius = "100 um"
points = 40
[adhesion]
w = "10 mJ/m^2"
"""


@dataclasses.dataclass(frozen=True)
class BadDefault:
    tolerance: Annotated[float, Ranged("number", least=1e-8, most=1e-2)] = 1.0

    def __post_init__(self) -> None:
        read_fields(self, "bad")


RUN = """
import contextlib, io, json, sys
import {}
from jkrcli.cli import call
for words in json.loads(sys.argv[1]):
    out, err = io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        code = call(words)
    print(json.dumps((code, out.getvalue(), err.getvalue())), flush=True)
"""


def jkr(module: str, *commands: Sequence[object]) -> list[Outcome]:
    """What the ``commands`` of ``jkr`` leave behind, in one process that has imported ``module``."""
    tests = Path(__file__).parent
    env = os.environ | {"PYTHONPATH": os.pathsep.join([str(tests.parent), str(tests)])}
    words = [sys.executable, "-c", RUN.format(module), json.dumps([[*map(str, command)] for command in commands])]
    done = subprocess.run(words, capture_output=True, text=True, env=env, check=True)
    return [Outcome(*json.loads(line)) for line in done.stdout.splitlines()]


def curve(module: str, folder: Path, text: str) -> dict[str, Array]:
    (folder / "my.toml").write_text(text)
    for done in jkr(
        module,
        ("run", folder / "my.toml", "-o", folder / "my.h5"),
        ("transform", folder / "my.h5", "-o", folder / "out", "--no-plots"),
    ):
        assert done.code == 0, done.err
    with next((folder / "out").glob("*.csv")).open() as file:
        rows = list(csv.DictReader(file))
    return {name: np.array([float(row[name]) for row in rows]) for name in ("a_m", "delta_H_m", "P_H_N", "P_N")}


@pytest.mark.first(1)
@pytest.mark.parametrize("method", ["layered", "closed-form", "fem"])
def test_an_indenter_of_ones_own(method: str, tmp_path: Path) -> None:
    text = CASE.format(method=method, shape="aspheric", keys="k = 1e11", thickness="1 km")
    text = text if method == "layered" else text[: text.index("[[")] + (
        '[specimen.half_space]\nE = "1 MPa"\nnu = 0.3\n' + text[text.index("[loading]") :]
    )  # fmt: skip
    found = curve("aspheric", tmp_path, text)
    a, E_star = found["a_m"], 1e6 / (1 - 0.3**2)
    P = E_star * (4 * a**3 / (3 * 1e-3) + 64 / 15 * 1e11 * a**5)
    delta = a**2 / 1e-3 + 8 / 3 * 1e11 * a**4
    tolerance = 2e-3 if method == "fem" else 2e-6  # a thick layer is not quite a half-space
    np.testing.assert_allclose(found["P_H_N"], P, atol=tolerance * P[-1], rtol=0)
    np.testing.assert_allclose(found["delta_H_m"], delta, atol=tolerance * delta[-1], rtol=0)
    shift = np.sqrt(2 * np.pi * 0.01 * a / E_star)
    np.testing.assert_allclose(found["P_N"], P - 2 * E_star * a * shift, atol=2 * tolerance * P[-1], rtol=0)


def test_keys_of_an_indenter_of_ones_own_are_checked(tmp_path: Path) -> None:
    (tmp_path / "my.toml").write_text(CASE.format(method="auto", shape="aspheric", keys="kk = 1", thickness="1 mm"))
    (tmp_path / "no.toml").write_text(CASE.format(method="auto", shape="asferic", keys="k = -1", thickness="1 mm"))
    key, shape = jkr("aspheric", ("check", tmp_path / "my.toml"), ("check", tmp_path / "no.toml"))
    assert key.err == (
        f"jkr: error: {tmp_path}/my.toml: indenter.kk: unknown key, did you mean \"k\"? "
        "(allowed: E, nu, layers, shape, radius, k)\n"
    )  # fmt: skip
    assert re.search(r'one of sphere, .*, aspheric, got "asferic", did you mean "aspheric"\?$', shape.err)


def test_a_method_of_ones_own(tmp_path: Path) -> None:
    text = CASE.format(method="winkler", shape="paraboloid", keys="", thickness="1 um")
    found = curve("winkler", tmp_path, text + "[winkler]\nstiffening = 2\n")
    delta, P = thin_layer(found["a_m"], 2 * foundation_modulus(1e6, 0.3, 1e-6), 1e-3)
    np.testing.assert_allclose(found["delta_H_m"], delta, rtol=1e-9)  # as the CSV is written
    np.testing.assert_allclose(found["P_H_N"], P, rtol=1e-9)


def test_a_file_needs_no_method_that_it_was_not_made_with(tmp_path: Path) -> None:
    (tmp_path / "my.toml").write_text(CASE.format(method="winkler", shape="paraboloid", keys="", thickness="1 um"))
    words = (tmp_path / "my.toml", "--method", "layered", "-o", tmp_path / "my.h5")
    (done,) = jkr("winkler", ("run", *words))
    assert done.code == 0, done.err
    text = (tmp_path / "my.h5").read_bytes()
    assert b"winkler" not in text
    assert b"[mesh]" not in text
    assert store.read_solution(tmp_path / "my.h5").method == "layered"


def test_a_bad_default_is_told_when_its_method_is_used(monkeypatch: pytest.MonkeyPatch) -> None:
    bad = dataclasses.replace(METHODS["hybrid"], name="bad", options=BadDefault, table="")
    monkeypatch.setitem(METHODS, "bad", bad)
    case = parse_case(CASE.format(method="layered", shape="paraboloid", keys="", thickness="1 um").encode(), "case")
    assert method_of(case.model, "layered") == Layered()
    with pytest.raises(InputError, match=r"bad\.tolerance: must be"):
        BadDefault(**options_of(case.model, "bad"))


@pytest.mark.slow
def test_options_of_a_method_of_ones_own_are_checked(tmp_path: Path) -> None:
    case = tmp_path / "my.toml"
    case.write_text(CASE.format(method="winkle", shape="sphere", keys="", thickness="1 um") + "[winkler]\nstiffening=0")
    refused, automatic = jkr("winkler", ("check", case), ("check", "cases/thin-layer.toml"))
    assert refused.err.splitlines() == [
        f"jkr: error: {case}: method: must be one of auto, closed-form, winkler, layered, hybrid, fem, "
        'got "winkle", did you mean "winkler"?',
        f"jkr: error: {case}: winkler.stiffening: must be > 0 and <= 10, got 0",
    ]
    assert automatic.code == 0
    assert "winkler" not in automatic.out  # auto may not choose it


def test_a_slopes_rule_of_ones_own(tmp_path: Path) -> None:
    (tmp_path / "my.toml").write_text(CASE.format(method="layered", shape="paraboloid", keys="", thickness="1 km"))
    series, out, wrong = tmp_path / "my.h5", tmp_path / "out", tmp_path / "wrong.toml"
    axis = '[[axes]]\nkey = "adhesion.w"\nvalues = [0.01, 0.02]\n'
    wrong.write_text(f'base = "my.toml"\n{axis}[outputs]\nslopes = "difference"\n')
    run, done, asked, refused = jkr(
        "differences",
        ("run", tmp_path / "my.toml", "-o", series),
        ("transform", series, "--slopes", "differences", "-o", out, "--no-plots"),
        ("transform", "--help"),
        ("sweep", wrong, "-o", tmp_path / "swept"),
    )
    assert (run.code, done.code) == (0, 0), done.err
    assert "slopes differences (requested)" in done.out
    with next(out.glob("*.csv")).open() as file:
        rows = list(csv.DictReader(file))
    S, a = (np.array([float(row[name]) for row in rows]) for name in ("S_N_per_m", "a_m"))
    np.testing.assert_allclose(S, 2 * 1e6 / (1 - 0.3**2) * a, rtol=1e-5)  # a thick layer: Hertz
    assert "|loocv-smoothed|differences]" in asked.out
    assert refused.err.startswith(f"jkr: error: {wrong}: outputs.slopes: must be one of auto, exact, integral, loocv")
    assert refused.err.endswith(', differences, got "difference", did you mean "differences"?\n')


@pytest.mark.slow
def test_a_law_of_speed_of_ones_own(tmp_path: Path) -> None:
    """The power law at n = 1 under another name: the same pull-off force."""
    series = tmp_path / "my.h5"
    (tmp_path / "my.toml").write_text(CASE.format(method="layered", shape="paraboloid", keys="", thickness="1 mm"))
    rest = "--speed", "1 um/s", "-o", tmp_path / "out", "--no-plots", "--json"
    run, ours, power, asked = jkr(
        "linear_rate",
        ("run", tmp_path / "my.toml", "-o", series),
        ("cycle", series, "--rate", "law=linear,v0=1 um/s", *rest),
        ("cycle", series, "--rate", "law=power,v0=1 um/s,n=1", *rest),
        ("fit", "--help-all"),
    )
    assert (run.code, ours.code, power.code) == (0, 0, 0), run.err + ours.err + power.err
    loads = [json.loads(done.out)["pull_off"]["P_N"] for done in (ours, power)]
    assert loads[0] == pytest.approx(loads[1], rel=1e-6)
    assert "[power|log|linear]" in asked.out


def test_a_run_imports_no_solver_that_it_does_not_use(tmp_path: Path) -> None:
    case = tmp_path / "my.toml"
    case.write_text(CASE.format(method="layered", shape="sphere", keys="", thickness="1 mm"))
    code = (
        "import sys\nfrom jkrcli.cli import call\nassert call(sys.argv[1:]) == 0\n"
        "others = (f'jkrcli.{name}' for name in ('methods.closed_form', 'fem.solver', 'hybrid.solver'))\n"
        "print('UNUSED', *(other in sys.modules for other in others))"
    )
    words = [sys.executable, "-c", code, "run", case, "-o", tmp_path / "my.h5"]
    done = subprocess.run(words, capture_output=True, text=True, check=True)
    assert done.stdout.splitlines()[-1] == "UNUSED False False False"


@pytest.mark.slow
def test_a_relaxation_of_ones_own(tmp_path: Path) -> None:
    text = CASE.format(method="layered", shape="paraboloid", keys="", thickness="1 mm")
    relaxation = '[specimen]\nrelaxation = {{ law = "{}", time = "1 s"{} }}\n[[specimen.layers]]'
    found = []
    for law, more in (("maxwell", ""), ("sls", ", ratio = 0.0")):
        (tmp_path / f"{law}.toml").write_text(text.replace("[[specimen.layers]]", relaxation.format(law, more)))
        series = tmp_path / f"{law}.h5"
        cycle = ("cycle", series, "--w-approach", 0, "--speed", "1 um/s", "--no-plots", "--json")
        run, done = jkr("maxwell", ("run", tmp_path / f"{law}.toml", "-o", series), cycle)
        assert run.code == done.code == 0, run.err + done.err
        found.append(json.loads(done.out)["largest_load"])
    assert found[0] == found[1]
