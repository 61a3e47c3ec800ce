"""The extra ``fem``: what works without gmsh, scikit-fem and meshio, and what is told where they are asked for."""

import json
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
WITHOUT = """
import contextlib, io, json, sys
from importlib import machinery, metadata

class Finder(machinery.PathFinder):
    @classmethod
    def find_spec(cls, name, *rest):
        return None if name in ("gmsh", "skfem", "meshio") else super().find_spec(name, *rest)

def version(name, real=metadata.version):
    if name in ("gmsh", "scikit-fem", "meshio"):
        raise metadata.PackageNotFoundError(name)
    return real(name)

sys.meta_path[sys.meta_path.index(machinery.PathFinder)] = Finder
metadata.version = version
from jkrcli.cli import call
done = []
for line in json.load(sys.stdin):
    out, err = io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        code = call(line)
    done.append((code, out.getvalue(), err.getvalue()))
json.dump(done, sys.stdout)
"""
LAYER = """
indenter = { shape = "paraboloid", radius = "50 um" }
specimen = { base = "bonded", layers = [{ E = "1 MPa", nu = 0.45, thickness = "10 um" }] }
loading = { radius = "8 um", points = 40 }
adhesion = { w = "5 mJ/m^2" }
"""
CYLINDER = LAYER.replace("specimen = {", 'specimen = { radius = "60 um", side = "free",')


def without_fem(folder: Path, *lines: str) -> list[tuple[int, str, str]]:
    """Exit code, output and errors of each command line where the packages of finite elements are missing."""
    words = json.dumps([line.split() for line in lines])
    done = subprocess.run([sys.executable, "-c", WITHOUT], input=words, capture_output=True, text=True, cwd=folder)
    assert done.returncode == 0, done.stderr
    return [(code, out, err) for code, out, err in json.loads(done.stdout)]


@pytest.fixture(name="folder")
def _folder(tmp_path: Path) -> Path:
    (tmp_path / "layer.toml").write_text(LAYER)
    (tmp_path / "cylinder.toml").write_text(CYLINDER)
    return tmp_path


WORKS = (
    "check layer.toml", "run layer.toml -o layer.h5", "transform layer.h5 --no-plots", "pull-off layer.h5",
    "fit layer.h5 layer-w0.005.csv --no-plots", "export layer.h5 --dem", "cycle layer.h5", "explore layer.h5",
    "look layer-w0.005.csv", "run cylinder.toml --method hybrid -o cylinder.h5", "profile cylinder.h5 --a 5um",
    "doctor",
)  # fmt: skip


@pytest.mark.parametrize("lines", [WORKS[:5], pytest.param(WORKS, marks=pytest.mark.slow)], ids=["five", "all"])
def test_everything_else_works(folder: Path, lines: tuple[str, ...]) -> None:
    for line, (code, _, errors) in zip(lines, without_fem(folder, *lines), strict=True):
        assert code == 0 or "optional package plotly" in errors, (line, errors)


ASKED = (
    "run layer.toml --method fem",
    "mesh layer.toml",
    "study converge layer.toml",
    "fields layer.h5 --a 5um",
    "bench layer.toml --method fem",
)


def test_one_line_names_the_packages_and_the_doctor_and_the_automatic_choice_do_without(folder: Path) -> None:
    done = without_fem(folder, "run layer.toml -o layer.h5", *ASKED, "doctor --json", "run cylinder.toml")
    (code, *_), *asked, (doctor, told, _), (solved, chosen, _) = done
    assert (code, doctor, solved) == (0, 0, 0)
    for line, (code, _, errors) in zip(ASKED, asked, strict=True):
        assert (code, errors.count("\n")) == (2, 1), (line, errors)
        assert "finite elements need packages that are not installed (gmsh, scikit-fem, meshio)" in errors, line
        assert "-m pip install" in errors, line
    assert {path.name for path in folder.iterdir()} == {"layer.toml", "cylinder.toml", "layer.h5", "cylinder.h5"}
    found = {finding["part"]: finding for finding in json.loads(told)["findings"]}
    for package in ("gmsh", "scikit-fem", "meshio"):
        assert found[package]["state"] == "optional"
        assert "-m pip install" in found[package]["remedy"]
    assert "method    hybrid" in chosen


def test_finite_elements_are_required_by_default_and_left_out_in_one_job() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    assert {"gmsh", "scikit-fem", "meshio"} < {line.partition(">")[0] for line in project["dependencies"]}
    makefile = (ROOT / "Makefile").read_text(encoding="utf-8")
    assert "pip uninstall --quiet --yes gmsh scikit-fem meshio" in makefile
