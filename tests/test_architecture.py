"""Imports point one way, heavy libraries have one door each, and help costs nothing."""

from __future__ import annotations

import ast
import subprocess
import sys
from pathlib import Path

import pytest

PACKAGE = Path(__file__).parent.parent / "jkrcli"
DOORS = {
    "gmsh": {"fem/mesh.py", "fem/export.py"},
    "cvxopt": {"fem/factor.py"},
    "skfem": {"fem/elasticity.py", "fem/stress.py"},
    "h5py": {"store.py", "files.py", "sweep/table.py", "fit/archive.py"},
    "matplotlib": {
        "plots.py",
        "plots_curve.py",
        "plots_study.py",
        "plots_stability.py",
        "plots_noise.py",
        "plots_chart.py",
        "plots_failures.py",
        "plots_fields.py",
        "plots_work.py",
        "plots_fit.py",
        "plots_contact_zone.py",
    },
    "meshio": {"fem/export.py"},
    "pydantic": {
        "case/__init__.py",
        "case/fields.py",
        "case/models.py",
        "case/indenter.py",
        "case/materials.py",
        "case/sweep.py",
    },
    "plotly": {"explorer/page.py"},
    "click": {"cli"},
    "distributed": {"executors.py"},
    "pyarrow": {"sweep/table.py"},
    "afmformats": {"measured/afm.py"},
}
# Each part may import from itself and from those before it.
ORDER = [
    "errors", "doctor", "grading", "materials", "units", "files", "clock", "threads", "progress", "executors",
    "indenters", "problem", "words", "series", "closed_form", "methods", "guards", "radii", "integral", "formulas",
    "fem", "hybrid", "choose", "case", "solving", "store", "cache", "text_table", "columns", "foreign", "measured",
    "slopes", "adhesion", "critical", "validity", "states", "stability_path", "stability", "stability_inverse",
    "comparison", "differences", "expectation", "analysis", "scaling", "tables", "fit", "work", "sweep", "plots",
    "plots_curve", "plots_fields", "plots_study", "plots_contact_zone", "plots_stability", "plots_work", "plots_fit",
    "study", "plots_noise", "plots_chart", "plots_failures", "explorer", "api", "cli", "__main__",
]  # fmt: skip


def parts() -> list[Path]:
    return sorted(PACKAGE.rglob("*.py"))


def imports_of(path: Path) -> list[str]:
    """Absolute names of all modules that ``path`` imports anywhere."""
    names = []
    here = ("jkrcli", *path.relative_to(PACKAGE).with_suffix("").parts)
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.Import):
            names += [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            base = ".".join(here[: len(here) - node.level]) if node.level else ""
            module = ".".join(filter(None, [base, node.module]))
            names += [f"{module}.{alias.name}" for alias in node.names]
    return names


@pytest.mark.parametrize("path", parts(), ids=lambda path: str(path.relative_to(PACKAGE)))
def test_imports_point_one_way(path: Path) -> None:
    own = path.relative_to(PACKAGE).parts[0].removesuffix(".py")
    if own == "__init__":
        return
    assert own in ORDER, f"place {own} in the order of imports"
    for name in imports_of(path):
        top, *rest = name.split(".")
        if top == "jkrcli" and rest and rest[0] in ORDER:
            assert ORDER.index(rest[0]) <= ORDER.index(own), f"{own} imports {rest[0]}, which comes after it"


@pytest.mark.parametrize("path", parts(), ids=lambda path: str(path.relative_to(PACKAGE)))
def test_each_heavy_library_has_one_door(path: Path) -> None:
    relative = str(path.relative_to(PACKAGE))
    for name in imports_of(path):
        allowed = DOORS.get(name.split(".")[0])
        assert allowed is None or relative in allowed or relative.split("/")[0] in allowed, f"{relative} imports {name}"


def test_help_imports_no_heavy_module() -> None:
    code = (
        "import sys\nfrom jkrcli.cli import call\ncall(['--help'])\n"
        "heavy = {'numpy', 'scipy', 'gmsh', 'skfem', 'meshio', 'h5py', 'matplotlib', 'pydantic', 'tomli_w'}\n"
        "print('HEAVY', sorted(heavy & set(sys.modules)))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.splitlines()[-1] == "HEAVY []"
