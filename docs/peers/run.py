"""Run other programs on the chart's bodies and store what they cost and how far they are off.

    python run.py --python ENVIRONMENT/bin/python -o timings.json [--only CalculiX]

This script runs in the environment of jkr, the peers' drivers in their own; CalculiX is the command ccx. Expensive:
half an hour. A peer that is not installed is left out. Every run is a whole process on one thread; errors as in
make chart, against the exact solution of the same paraboloid; the pull-off force is that of the peer's increments
with the slopes "integral".
"""

from __future__ import annotations

import argparse
import json
import os
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from datetime import date
from pathlib import Path

import calculix
import numpy as np
from bodies import BODIES, Body

from jkrcli.adhesion.curve import transform
from jkrcli.adhesion.slopes import smoothed
from jkrcli.base.errors import JkrError
from jkrcli.base.files import as_json, check_target, write_text
from jkrcli.bodies.indenters import Paraboloid
from jkrcli.bodies.problem import Elastic, HalfSpace, Layer, Loading, Problem, Rigid, Specimen
from jkrcli.many.studies import Cost, process_cost
from jkrcli.series import RawSeries
from studies.chart_measure import machine, yardstick
from studies.chart_reference import Errors, reference_of

HERE = Path(__file__).resolve().parent
WORKS = {"halfspace": 50.0, "thin-layer": 10.0}  # J/m^2, of the pull-off force


@dataclass(frozen=True)
class Run:
    """One peer on one body; ``settings``: arguments of its driver, ``words``: the same in words."""

    peer: str
    body: str
    settings: tuple[str, ...]
    words: str


def structured(peer: str) -> list[Run]:
    """The two finite-element peers share their meshes: a coarse one, and one that is good to 1e-3."""
    return [
        Run(peer, "halfspace", ("20", "1.12", "0"), "20 nodes per radius, growth 1.12"),
        Run(peer, "halfspace", ("40", "1.07", "0"), "40 nodes per radius, growth 1.07"),
        Run(peer, "thin-layer", ("40", "1.05", "6"), "40 nodes per radius, 6 rows"),
        Run(peer, "thin-layer", ("87", "1.05", "10"), "87 nodes per radius, 10 rows"),
    ]


RUNS = [  # ContactMechanics stalls on the free half-space at some of the depths: layers only
    Run("tamaas", "halfspace", ("64", "1.15"), "64 x 64 points"),
    Run("tamaas", "halfspace", ("128", "1.15"), "128 x 128 points"),
    Run("ContactMechanics", "thin-layer", ("64", "1.2"), "64 x 64 points"),
    Run("ContactMechanics", "thin-layer", ("128", "1.3"), "128 x 128 points"),
    *structured("scikit-fem, refactorising"),
    *structured("CalculiX"),
]
DRIVERS = {
    "tamaas": ("tamaas_contact.py", "tamaas"),
    "ContactMechanics": ("contactmechanics.py", "ContactMechanics"),
    "scikit-fem, refactorising": ("refactorising.py", "scikit-fem"),
}


def version(peer: str, python: str) -> str | None:
    """The installed version of a peer, None where there is none."""
    if peer == "CalculiX":
        if shutil.which("ccx") is None:
            return None
        return subprocess.run(["ccx", "-v"], capture_output=True, text=True).stdout.split()[-1]
    code = f"import importlib.metadata as m; print(m.version({DRIVERS[peer][1]!r}))"
    done = subprocess.run([python, "-c", code], capture_output=True, text=True)
    return done.stdout.strip() if done.returncode == 0 else None


def solve(run: Run, python: str, folder: Path) -> tuple[Cost, dict]:
    """Cost of the whole process, and its increments in SI units."""
    if run.peer == "CalculiX":
        return calculix_solve(run, folder)
    output = folder / "result.json"
    cost = process_cost([python, str(HERE / DRIVERS[run.peer][0]), run.body, *run.settings], folder, output)
    return cost, json.loads(output.read_text())


def calculix_solve(run: Run, folder: Path) -> tuple[Cost, dict]:
    nodes, growth, rows = run.settings
    mesh = calculix.Mesh(BODIES[run.body], int(nodes), float(growth), int(rows))
    (folder / "run.inp").write_text(calculix.deck(mesh))
    cost = process_cost(["ccx", "run"], folder, folder / "log.txt")
    table = calculix.table(mesh, (folder / "run.dat").read_text()).splitlines()[1:]
    _, u, force, a = np.array([[float(cell) for cell in row.split(",")] for row in table]).T
    unflatter = calculix.FLATTER
    return cost, {
        "delta_m": list(-1e-6 * u * unflatter),
        "P_N": list(-1e-6 * force * calculix.SECTORS * unflatter),
        "a_m": list(1e-6 * a),
        "unknowns": 2 * mesh.r.size * mesh.z.size,
        "after_imports_cpu_s": None,
    }


def problem_of(body: Body) -> Problem:
    material = Elastic(body.E, body.nu)
    if body.thickness is None:
        specimen = Specimen((), HalfSpace(material))
    else:
        specimen = Specimen((Layer(material, body.thickness),), Rigid())
    return Problem(Paraboloid(body.R), specimen, Loading("depth", body.depth))


def errors(run: Run, result: dict) -> Errors:
    w = WORKS[run.body]
    reference = reference_of(problem_of(BODIES[run.body]), w)
    raw = RawSeries(*(np.array(result[name]) for name in ("a_m", "delta_m", "P_N")))
    try:
        return reference.errors(transform(*smoothed(raw), w))
    except JkrError:
        return Errors(reference.load_error(raw.delta, raw.P))


def record(run: Run, python: str) -> dict | None:
    """Everything about one run as JSON; None where the peer is not installed."""
    found = version(run.peer, python)
    if found is None:
        print(f"{run.peer}: not installed, left out", file=sys.stderr)
        return None
    with tempfile.TemporaryDirectory() as folder:
        cost, result = solve(run, python, Path(folder))
    entry = {
        "peer": run.peer, "version": found, "body": run.body, "settings": run.words, "unknowns": result["unknowns"],
        **asdict(cost), "after_imports_cpu_s": result["after_imports_cpu_s"], "errors": asdict(errors(run, result)),
    }  # fmt: skip
    print(f"{run.peer}, {run.body}, {run.words}: {cost.cpu_s:.1f} s, error of P {entry['errors']['load']:.1e}")
    return entry


def main(arguments: Sequence[str] | None = None) -> None:
    parser = argparse.ArgumentParser(description="Run the peers of the chart.")
    parser.add_argument(
        "--python", type=os.path.abspath, default=sys.executable, help="Python of the peers' environment"
    )  # by its whole path: runs have folders of their own
    parser.add_argument("--only", action="append", help="this peer alone")
    parser.add_argument("--longest", type=float, help="leave out what took longer in timings.json [CPU s]")
    parser.add_argument("-o", "--output", type=Path, default=HERE / "timings.json")
    given = parser.parse_args(arguments)
    stored = json.loads((HERE / "timings.json").read_text())["runs"] if given.longest is not None else []
    long = {(run["peer"], run["body"], run["settings"]) for run in stored if run["cpu_s"] > (given.longest or 0.0)}
    check_target(given.output)
    os.environ.update(dict.fromkeys(("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"), "1"))
    before = yardstick()
    wanted = [run for run in RUNS if given.only is None or run.peer in given.only]
    entries = [record(run, given.python) for run in wanted if (run.peer, run.body, run.words) not in long]
    data = {
        "format": "jkr-peers",
        "version": 1,
        "date": date.today().isoformat(),
        "machine": machine(),
        "yardstick_cpu_s": [before, yardstick()],
        "runs": [entry for entry in entries if entry is not None],
    }
    write_text(given.output, as_json(data))


if __name__ == "__main__":
    main()
