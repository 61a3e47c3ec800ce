"""Speed against accuracy: one case by every method and setting, on the same machine, against one exact solution."""

from __future__ import annotations

import json
import sys
import tempfile
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, cast

from jkrcli.base.errors import Estimate, InputError, JkrError, Unknown
from jkrcli.base.files import read_bytes
from jkrcli.bodies.problem import INCOMPRESSIBLE, Problem
from jkrcli.case import store
from jkrcli.case.models import Case, CaseModel, method_of
from jkrcli.fem.solver import FEM
from jkrcli.many.studies import Cost, process_cost
from jkrcli.methods.layered.solver import largest_radius
from jkrcli.methods.protocol import METHODS, choose_method
from jkrcli.resolve.analysis import Analysis, analyse

from .chart_measure import timed, typical
from .chart_reference import Errors, Reference

NOT_ASKED = Unknown("unknown: not asked for")
SLOPES = ("exact", "integral", "loocv")
RECIPE = "the paper's recipe"  # its mesh, increments and splines


@dataclass(frozen=True)
class Setting:
    """A method with options: ``tables`` of the case file by name, each in place of the case's own."""

    method: str
    words: str
    tables: Mapping[str, Mapping[str, Any]] = field(default_factory=dict)

    @property
    def slopes(self) -> tuple[str, ...]:
        """The rules for slopes that are measured with it."""
        return ("loocv-kept",) if self.words == RECIPE else SLOPES

    def of(self, model: CaseModel) -> CaseModel:
        """The case solved by this setting."""
        if self.words == RECIPE:
            return _recipe(model)
        tables = {name: type(getattr(model, name))(**values) for name, values in self.tables.items()}
        return model.model_copy(update=tables | {"method": self.method})


DEFAULT = "default"


def _recipe(model: CaseModel) -> CaseModel:
    """The case as the paper would solve it: uniform linear quadrilaterals over the contact (integrated at one point
    where they lock), even increments of depth, nothing estimated."""
    problem, mesh = model.problem(), cast(FEM, method_of(model, "fem"))
    size = largest_radius(problem) / 35  # ten times the paper's on its half-space, 0.005 R
    if problem.specimen.layers:
        size = min(size, problem.specimen.layers[0].thickness / 50)  # the paper's 0.02 h
    locks = max(material.surface.nu for material in problem.specimen.materials) > INCOMPRESSIBLE
    tables: dict[str, dict[str, Any]] = {
        "mesh": {
            "layout": "zones", "element": "quadrilateral", "order": 1, "element_size": size, "estimate_error": False,
            "integration": "reduced" if locks else "full", "depth": mesh.depth, "width": mesh.width,
        },
        "contact": {"algorithm": "incremental"},
    }  # fmt: skip
    solved = Setting("fem", "", tables).of(model)
    return solved.model_copy(update={"loading": model.loading.model_copy(update={"spacing": "depth"})})


def _fem(words: str, contact: str = "nested", **mesh: Any) -> Setting:
    return Setting("fem", words, {"mesh": mesh, "contact": {"algorithm": contact}})


SETTINGS = (
    Setting("layered", "tolerance 1e-2", {"layered": {"tolerance": 1e-2}}),
    Setting("layered", DEFAULT, {"layered": {}}),
    _fem("spacing 0.16", spacing=0.16),
    _fem("spacing 0.08", spacing=0.08),
    _fem(DEFAULT),
    _fem("spacing 0.02", spacing=0.02),
    _fem("spacing 0.08, nothing estimated", spacing=0.08, estimate_error=False, edge_correction=False),
    _fem("order 1", order=1),
    _fem("incremental", "incremental"),
    _fem("zones", layout="zones"),
    Setting("fem", RECIPE),
)  # methods without an entry are measured with their defaults


@dataclass(frozen=True)
class Measured:
    """One setting with one way of finding the slopes.

    ``whole``: the process ``jkr run``; ``after_imports``: the solve alone, in a process that has done it once before;
    ``slopes_cpu_s``: slopes and transformation; ``stated``: the error that the result itself claims for P at equal
    displacement (discretisation and truncation: no contact radius enters it), ``stated_pull_off``: for its pull-off
    force under load control.
    """

    setting: Setting
    slopes: str
    unknowns: int | None
    whole: Cost
    after_imports: Cost
    slopes_cpu_s: float
    stated: Estimate
    errors: Errors
    stated_pull_off: Estimate = NOT_ASKED


@dataclass(frozen=True)
class LeftOut:
    """A setting that was not measured, and why."""

    setting: Setting
    reason: str


def settings_of(model: CaseModel, methods: Sequence[str]) -> list[Setting]:
    """All settings of ``methods`` (none: of all); the case's own mesh too, where it is not the default."""
    found = [setting for setting in SETTINGS if not methods or setting.method in methods]
    known = {setting.method for setting in SETTINGS}
    found += [Setting(name, DEFAULT) for name in METHODS if name not in known and (not methods or name in methods)]
    own = replace(cast(FEM, method_of(model, "fem")), contact="nested")
    if own != FEM() and (not methods or "fem" in methods):
        found.append(Setting("fem", "the case's own mesh"))
    return sorted(found, key=lambda setting: list(METHODS).index(setting.method))


def chart(
    case: Case, settings: Iterable[Setting], w: float, reference: Reference, repeat: int, patience: float
) -> Iterator[list[Measured] | LeftOut]:
    """Measure every setting: a point for each way of finding the slopes, or why there is none."""
    problem = case.model.problem()
    for setting in settings:
        model = setting.of(case.model)
        try:
            if reason := _unwanted(model, problem, setting.method, patience):
                yield LeftOut(setting, reason)
            else:
                yield _measured(Case(model, case.source), setting, w, reference, repeat)
        except JkrError as error:
            yield LeftOut(setting, str(error))


def _unwanted(model: CaseModel, problem: Problem, name: str, patience: float) -> str | None:
    method = method_of(model, name)
    if reason := method.refusal(problem):
        return reason
    seconds = method.forecast(problem).seconds
    return f"would take about {seconds:.0f} s, more than {patience:g} s" if seconds > patience else None


def _measured(case: Case, setting: Setting, w: float, reference: Reference, repeat: int) -> list[Measured]:
    method, problem = method_of(case.model, setting.method), case.model.problem()
    solution = method(problem)
    after_imports = typical(lambda: timed(lambda: method(problem))[1], repeat)
    unknowns = solution.facts.get("unknowns", solution.facts.get("nodes"))
    points = []
    with tempfile.TemporaryDirectory() as folder:
        file, target = Path(folder) / "case.toml", Path(folder) / "series.h5"
        file.write_text(case.to_toml(), encoding="utf-8")
        command = [sys.executable, "-m", "jkrcli", "run", str(file), "-o", str(target)]
        whole = typical(lambda: process_cost(command), repeat)
        solved = store.read_solution(target)
        for slopes in setting.slopes:
            try:
                found, cost = timed(lambda name=slopes: analyse(solved, [w], name)[0])  # type: ignore[misc]
            except JkrError:
                continue  # these slopes do not exist for such a series
            costs, errors = (whole, after_imports, cost.cpu_s), reference.errors(found.curve)
            stated = (replace(solution.budget, radius=0.0).series, errors, _stated_pull_off(found))
            points.append(Measured(setting, slopes, unknowns, *costs, *stated))
    return points


def _stated_pull_off(found: Analysis) -> Estimate:
    """The relative error that a result states for its pull-off force under load control."""
    point, errors = found.pull_off["load"], found.pull_off_errors.get("load")
    if isinstance(point, Unknown):
        return point
    if errors is None or isinstance(errors, Unknown):
        return errors or Unknown("unknown: none is stated")
    return float(errors["P"] / abs(point.P))


def front(points: Sequence[tuple[float, float]]) -> list[int]:
    """Indices of the Pareto front of (cost, error), by increasing cost: no other point is cheaper and no less exact."""
    order = sorted(range(len(points)), key=lambda i: points[i])
    best, kept = float("inf"), []
    for i in order:
        if points[i][1] < best:
            best = points[i][1]
            kept.append(i)
    return kept


def beside_front(point: tuple[float, float], points: Sequence[tuple[float, float]], slack: float = 1.5) -> bool:
    """Whether a (cost, error) lies on the front or next to it: nothing as exact is quicker by more than ``slack``."""
    return not any(cost * slack < point[0] and error <= point[1] for cost, error in points)


def automatic(case: Case) -> str:
    """The method that "auto" takes with the case's tables left at their defaults."""
    bare = case.model.model_copy(update={name: type(getattr(case.model, name))() for name in ("mesh", "layered")})
    return choose_method(case.model.problem(), "auto", lambda name: method_of(bare, name)).name


def chosen_points(points: Sequence[Measured], method: str) -> list[Measured]:
    """What was measured of ``method`` at its defaults."""
    return [point for point in points if point.setting.method == method and point.setting.words == DEFAULT]


# ---------------------------------------------------------------------- other programs
@dataclass(frozen=True)
class Peer:
    """One run of another program, its costs as on this machine; ``after_imports_cpu_s``: None where not known;
    ``now``: measured in the same run."""

    name: str
    version: str
    body: str
    settings: str
    unknowns: int
    whole: Cost
    after_imports_cpu_s: float | None
    errors: Errors
    now: bool = False


def read_peers(path: Path, yardstick: float, now: bool = False) -> list[Peer]:
    """The stored runs, their times multiplied by ``yardstick`` [CPU s, of now] over the one of then; ``now``: as they
    are, of the same run."""
    try:
        data = json.loads(read_bytes(path, "file of peers"))
        if (data["format"], data["version"]) != ("jkr-peers", 1):
            raise InputError(f"{path}: must be jkr-peers version 1, got {data['format']} {data['version']}")
        ratio = 1.0 if now else yardstick / min(data["yardstick_cpu_s"])
        return [_peer(run, ratio, now) for run in data["runs"]]
    except (json.JSONDecodeError, KeyError, TypeError, ValueError) as error:
        raise InputError(f"{path}: is not a file of peers' timings ({error!r})") from None


def _peer(run: Mapping[str, Any], ratio: float, now: bool) -> Peer:
    after = run["after_imports_cpu_s"]
    return Peer(
        run["peer"],
        run["version"],
        run["body"],
        run["settings"],
        run["unknowns"],
        Cost(run["cpu_s"] * ratio, run["wall_s"] * ratio, run["memory_mib"]),
        None if after is None else after * ratio,
        Errors(**run["errors"]),
        now,
    )
