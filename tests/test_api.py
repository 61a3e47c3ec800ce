"""The Python interface gives the command line's numbers."""

import doctest
import runpy
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest

import jkrcli as jkr_python
from jkrcli import api
from jkrcli.viscoelastic import functions

CASES = Path(__file__).parent.parent / "cases"
PACKAGE = Path(jkr_python.__file__).parent
PROBE = CASES / "measured" / "gel-probe.csv"
EXAMPLES = Path(__file__).parent.parent / "docs" / "examples"


@pytest.mark.parametrize("module", [api, functions])
def test_the_documented_examples_run(module: ModuleType) -> None:
    tried = doctest.testmod(module)
    assert (tried.failed, tried.attempted > 5) == (0, True)


def test_every_name_of_the_interface_is_documented() -> None:
    for name in jkr_python.__all__:
        assert getattr(jkr_python, name).__doc__, name
        assert name in dir(jkr_python)
        assert not (PACKAGE / name).exists(), "a part of that name would take its place once it is imported"
        assert not (PACKAGE / f"{name}.py").exists()


RELAXING = {"body": CASES / "relaxing-gel.toml", "measured": CASES / "measured" / "relaxing-fast.csv"}
DEPRECATED: dict[str, tuple[dict[str, Any], dict[str, Any]]] = {  # arguments of each, and those of fit
    "identify": ({}, {}),
    "identify_joint": ({"measured": [PROBE, PROBE]}, {"measured": [PROBE, PROBE], "shared": ["E_star", "w"]}),
    "identify_tension": (
        {"measured": [PROBE], "fix": {"surface_tension": 1e-3}},
        {"measured": [PROBE], "fix": {"surface_tension": 1e-3}},
    ),
    "identify_law": ({"law": "log", "fix": {"v0": 1e-6, "b": 0.1}}, {"law": "log", "fix": {"v0": 1e-6, "b": 0.1}}),
    "identify_relaxation": ({**RELAXING, "law": "sls"}, {**RELAXING, "relaxation": "sls"}),
}


@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=[pytest.mark.slow] * (i > 1)) for i, name in enumerate(DEPRECATED)]
)
def test_deprecated_doubles_of_fit_warn_where_they_are_called_and_do_the_same(name: str) -> None:
    def tried(function: Callable[..., Any], more: dict[str, Any]) -> Any:
        return dict(function(**{"body": body, "measured": PROBE, **more}).summary())

    body = jkr_python.load_case(CASES / "gel.toml")
    theirs, ours = DEPRECATED[name]
    with pytest.warns(DeprecationWarning, match=f"^{name} is deprecated: call fit") as caught:
        found = tried(getattr(jkr_python, name), theirs)
    assert caught[0].filename == __file__
    assert found == tried(jkr_python.fit, ours)


def test_a_problem_is_solved_as_its_case_is(tmp_path: Path) -> None:
    """A problem made in Python, by a method of its own, gives the curve of the case to the last bit; its file too."""
    case = jkr_python.load_case(CASES / "coating.toml")
    problem = case.model.problem()
    by_case = jkr_python.transform(case, w=0.05, method="layered")
    by_problem = jkr_python.transform(problem, w=0.05, method=jkr_python.Layered())
    saved = jkr_python.save(jkr_python.solve(problem, "layered"), tmp_path / "x.h5")
    for other in (by_problem, jkr_python.transform(saved, w=0.05)):
        np.testing.assert_array_equal(other.curve.P, by_case.curve.P)
        assert other.problem == problem
    with pytest.raises(jkr_python.Refusal, match="method closed-form: solves homogeneous half-spaces"):
        jkr_python.solve(problem, jkr_python.ClosedForm())


def test_what_is_fixed_may_be_a_number() -> None:
    solved = jkr_python.solve(CASES / "gel.toml")
    curve = jkr_python.transform(solved, 0.04).curve
    columns = {"delta": curve.delta[20:80:4], "P": curve.P[20:80:4]}
    by_number, by_text = (jkr_python.fit(solved, **columns, fix={"w": w}) for w in (0.04, "40 mJ/m^2"))
    assert by_number.value("E_star") == by_text.value("E_star")


def test_importing_the_package_costs_nothing() -> None:
    code = "import sys, jkrcli; print(sorted({'numpy', 'scipy', 'gmsh', 'h5py', 'pydantic'} & set(sys.modules)))"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


def test_save_replaces_nothing_that_jkr_did_not_write(tmp_path: Path) -> None:
    solved = jkr_python.solve(CASES / "coating.toml", method="layered")
    target = tmp_path / "notes.h5"
    target.write_text("mine")
    with pytest.raises(jkr_python.InputError, match="exists and was not written by jkr"):
        jkr_python.save(solved, target)
    assert target.read_text() == "mine"


@pytest.mark.first(3)
@pytest.mark.parametrize("script", sorted(EXAMPLES.glob("*.py")), ids=lambda path: path.stem)
def test_the_example_scripts_run(script, tmp_path, monkeypatch, capsys) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "argv", [str(script)])
    runpy.run_path(str(script), run_name="__main__")
    assert capsys.readouterr().out.strip()


def test_the_shipped_record_is_what_its_script_makes(tmp_path: Path) -> None:
    subprocess.run([sys.executable, EXAMPLES / "raw_force_curve.py", "made.txt"], cwd=tmp_path, timeout=120, check=True)
    assert (tmp_path / "made.txt").read_bytes() == (CASES / "measured" / "raw-force-curve.txt").read_bytes()


def test_what_is_printed_is_one_line() -> None:
    solved = jkr_python.solve(CASES / "coating.toml")
    curve = jkr_python.transform(solved, w=0.05)
    assert repr(solved) == "<Solution solved: 100 rows by method layered, a to 8e-06 m>"
    assert repr(curve) == "<Analysis of solved: w = 0.05 J/m^2, 100 points>"
