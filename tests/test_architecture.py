"""Imports go down from room to room and never in circles, heavy libraries have one door each, help costs nothing."""

from __future__ import annotations

import ast
import subprocess
import sys
from collections.abc import Iterator, Mapping
from pathlib import Path

import pytest
from force_curves import Instrument, record
from sources import nodes

from jkrcli import api

PACKAGE = Path(__file__).parent.parent / "jkrcli"
# The rooms, each above those that may import from it; what stands at the top of the package may import from all. The
# last are wings, which register (``base/wings.py``): nothing imports from them.
ROOMS = (
    "base", "tables", "formulas", "bodies", "series", "methods", "case", "adhesion", "resolve", "report", "cli",
    "fem", "hybrid", "measured", "viscoelastic", "many",
)  # fmt: skip
MOST_AT_TOP = 4
WINGS = ("fem", "hybrid", "measured", "viscoelastic", "many")
# Libraries and the folders or modules that may import each.
DOORS = {
    "afmformats": "measured/afm_formats.py",
    "click": (
        "cli", "fem/verbs.py", "measured/verbs.py", "measured/readings.py", "viscoelastic/cycle.py",
        "viscoelastic/options.py", "many/verbs.py",
    ),
    "cvxopt": "fem/elasticity.py",
    "distributed": "base/executors.py",
    "h5py": "base/hdf5.py",
    "gmsh": "fem/mesh.py",
    "matplotlib": (
        "report/plots", "fem/figures.py", "measured/figures.py", "viscoelastic/figures.py", "many/figures.py",
    ),
    "meshio": "fem/mesh.py",
    "plotly": "many/explorer/__init__.py",
    "psutil": "base/process.py",
    "pydantic": ("case", "many/sweep_file.py"),
    "skfem": "fem/elasticity.py",
}  # fmt: skip


def modules(package: Path) -> dict[str, Path]:
    """Dotted name below the package of every module; a folder's ``__init__`` has the folder's name."""
    found = {}
    for path in sorted(package.rglob("*.py")):
        parts = path.relative_to(package).with_suffix("").parts
        found[".".join(parts[:-1] if parts[-1] == "__init__" else parts)] = path
    return found


def imported(name: str, path: Path) -> Iterator[str]:
    """Absolute names of everything that module ``name`` imports: at the top, in functions, for types alone."""
    parent = ["jkrcli", *filter(None, name.split("."))]
    if path.name != "__init__.py":
        parent.pop()
    for node in nodes(path):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            base = parent[: len(parent) - node.level + 1] if node.level else []
            module = ".".join([*base, *([node.module] if node.module else [])])
            yield from (f"{module}.{alias.name}" for alias in node.names)


def arrows(package: Path) -> dict[str, set[str]]:
    """For each module those of the package that it imports; a name taken from a folder counts as the folder."""
    known = modules(package)
    graph: dict[str, set[str]] = {name: set() for name in known}
    for name, path in known.items():
        for target in imported(name, path):
            head, *rest = target.split(".")
            if head != "jkrcli":
                continue
            while ".".join(rest) not in known:
                rest.pop()
            if rest and ".".join(rest) != name:
                graph[name].add(".".join(rest))
    return graph


def backward(graph: Mapping[str, set[str]]) -> list[str]:
    room = {name: ROOMS.index(name.split(".")[0]) for name in graph if name.split(".")[0] in ROOMS}
    return [
        f"{name} imports {target}"
        for name, targets in graph.items()
        for target in sorted(targets)
        if name in room
        and (target not in room or room[target] > room[name])
        and not (target == "api" and name.endswith("functions"))  # what a wing adds to it
    ]


def circles(graph: Mapping[str, set[str]]) -> list[str]:
    found, state = [], dict.fromkeys(graph, 0)

    def visit(name: str, way: list[str]) -> None:
        state[name] = 1
        for target in sorted(graph[name]):
            if state[target] == 1:
                found.append(" -> ".join([*way[way.index(target) :], target]))
            elif state[target] == 0:
                visit(target, [*way, target])
        state[name] = 2

    for name in graph:
        if state[name] == 0:
            visit(name, [name])
    return found


def test_every_room_has_its_place() -> None:
    assert {path.parent.name for path in PACKAGE.glob("*/*.py")} == set(ROOMS)
    at_top = sorted(path.name for path in PACKAGE.glob("*.py"))
    assert len(at_top) <= MOST_AT_TOP, at_top


def test_imports_go_down_from_room_to_room() -> None:
    assert backward(arrows(PACKAGE)) == []


def test_no_module_of_the_core_imports_a_wing_and_no_wing_another_but_the_fits_of_bodies_that_relax() -> None:
    names = {target: target.split(".")[0] for target in arrows(PACKAGE)}
    crossed = {(names[name] if names[name] in WINGS else "core", names[target], name)
               for name, targets in arrows(PACKAGE).items() for target in targets
               if names[target] in WINGS and names[target] != names[name]}  # fmt: skip
    assert {pair for pair in crossed if pair[:2] != ("viscoelastic", "measured")} == {("core", "many", "")} | {
        ("core", wing, "") for wing in WINGS
    }  # the package itself, for a checker of types


def test_no_module_imports_itself_through_others() -> None:
    assert circles(arrows(PACKAGE)) == []


@pytest.mark.parametrize(
    ("lines", "back", "circle"),
    [
        ({"base/a.py": "from ..cli import b", "cli/b.py": ""}, ["base.a imports cli.b"], []),
        ({"base/a.py": "def f():\n    from ..case.b import c", "case/b.py": ""}, ["base.a imports case.b"], []),
        (
            {"base/a.py": "from . import b", "base/b.py": "if TYPE_CHECKING:\n    from .a import A"},
            [],
            ["base.a -> base.b -> base.a"],
        ),
        ({"base/a.py": "import jkrcli.many.b", "many/b.py": "from ..base import a"}, ["base.a imports many.b"], True),
        ({"base/a.py": "", "case/b.py": "from ..base.a import f", "cli/c.py": "from ..case import b"}, [], []),
    ],
)
def test_the_check_sees_what_points_back(tmp_path, lines, back, circle) -> None:
    for name, text in lines.items():
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_text(text)
        (tmp_path / name).with_name("__init__.py").touch()
    graph = arrows(tmp_path)
    assert backward(graph) == back
    assert circles(graph) == circle if isinstance(circle, list) else circles(graph)


def test_each_heavy_library_has_one_door() -> None:
    for name, path in modules(PACKAGE).items():
        relative = path.relative_to(PACKAGE)
        for target in imported(name, path):
            doors = DOORS.get(target.split(".")[0], ".")
            doors = (doors,) if isinstance(doors, str) else doors
            assert any(map(relative.is_relative_to, doors)), f"{relative} imports {target}"


def test_the_package_offers_the_names_of_the_python_interface() -> None:
    """They are loaded when the first is asked for, so that neither a checker of types nor an import tells."""
    import jkrcli

    assert set(api.__all__) < set(dir(jkrcli))
    assert all(getattr(jkrcli, name) is getattr(api, name) for name in api.__all__)
    with pytest.raises(AttributeError, match="module jkrcli has no attribute nothing"):
        _ = jkrcli.nothing


def test_help_of_every_verb_imports_no_heavy_module_and_names_all_that_is_registered() -> None:
    code = (
        "import sys, click\nfrom jkrcli.cli import VERBS, call, jkr\n"
        "assert not any(call([*verb, '--help']) for verb in ([], *zip(VERBS)))\n"
        "heavy = {'numpy', 'scipy', 'gmsh', 'skfem', 'meshio', 'h5py', 'matplotlib', 'pydantic', 'tomli_w'}\n"
        "print('HEAVY', sorted(heavy & set(sys.modules)))\n"
        "kinds = [one.type for verb in VERBS for one in jkr.get_command(click.Context(jkr), verb).params]\n"
        "print(*(kind.choices == kind.known(True) for kind in kinds if hasattr(kind, 'known')))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.endswith("HEAVY []\nTrue True\n")


@pytest.mark.fem  # the method of the checked case
def test_what_needs_no_fit_imports_nothing_of_scipy(tmp_path: Path) -> None:
    """A run by layers, its curves with pull-off, and a check of a half-space and of layers, for which what they neglect
    is solved, tension too: SciPy takes as long as all of them."""
    cases, series = PACKAGE.parent / "cases", str(tmp_path / "gel.h5")
    commands = [
        ["run", str(cases / "gel.toml"), "-o", series], ["check", str(cases / "halfspace.toml")],
        ["check", str(cases / "gel.toml")], ["pull-off", series, "--load", "-1 mN"],
        ["transform", series, "--no-plots", "-o", str(tmp_path)], ["pull-off", series],
    ]  # fmt: skip
    code = (
        f"import sys\nfrom jkrcli.cli import call\nassert not call({commands[0]!r})\n"
        "masked = 'numpy.ma' in sys.modules\n"
        f"assert not any(map(call, {commands[1:]!r}))\n"
        "heavy = {f'scipy.{name}' for name in ('linalg', 'special', 'optimize', 'interpolate', 'sparse')}\n"
        "print('HEAVY', sorted(heavy & set(sys.modules)), masked)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.splitlines()[-1] == "HEAVY [] False"


def test_a_plain_fit_imports_nothing_of_scipy(tmp_path: Path) -> None:
    columns = record(20e3, 5e-6, 5e-5, 1e-4, Instrument(0.05, 500, 3e-6, 1e-8, 1e-11), 1)
    rows = zip(columns["t"], columns["z"], columns["P"], strict=True)
    lines = ["t_s,delta_nm,P_nN", *(f"{t:.6f},{z * 1e9:.4f},{P * 1e9:.6f}" for t, z, P in rows)]
    (tmp_path / "one.csv").write_text("\n".join(lines) + "\n")
    command = ["fit", str(tmp_path / "one.csv"), "--stiffness", "0.05 N/m", "--shape", "paraboloid", "--radius", "5 um",
               "--nu", "0.5", "--no-plots", "-o", str(tmp_path / "out")]  # fmt: skip
    code = (
        f"import sys\nfrom jkrcli.cli import call\nassert not call({command!r})\n"
        "print('HEAVY', sorted(name for name in sys.modules if name.startswith('scipy.')))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert done.stdout.splitlines()[-1:] == ["HEAVY []"], done.stdout + done.stderr


NOT_EVERYWHERE = ("fcntl", "grp", "pwd", "resource", "syslog", "termios", "tty", "msvcrt", "winreg")


def test_one_module_asks_for_what_some_systems_lack() -> None:
    for name, path in modules(PACKAGE).items():
        assert name == "base.process" or not {*imported(name, path)} & {*NOT_EVERYWHERE}, name
