"""Every refusal names a remedy, and who follows it gets a solution; a new kind of refusal without a test is noticed."""

import ast
import json
import re
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import tomli_w
from refusals import BASE, CLOSE, COARSE, GRADED, KINDS, LAYERED, THIN, ZONES, Tree, fem, layer, merged
from sources import nodes

from jkrcli import parse_case
from jkrcli.adhesion.rules import RULES
from jkrcli.base.errors import Refusal
from jkrcli.bodies.indenters import Paraboloid
from jkrcli.bodies.problem import Elastic, HalfSpace, Layer, Loading, Problem, Rigid, Specimen, without_side_walls
from jkrcli.fem.solver import FEM
from jkrcli.hybrid.solver import Hybrid
from jkrcli.methods.layered.solver import Layered

PACKAGE = Path(__file__).parents[2] / "jkrcli"


SLOW = {
    *("fem: " + name for name in ("tolerance with radii of vertices", "tolerance under a cut", "refined zone",
      "below the first vertex", "displacements", "spacing beside a tolerance")),
    *("hybrid: " + name for name in ("no such tolerance", "cost", "rows",
      "accuracy", "side, by radius")),
}  # fmt: skip


@pytest.mark.parametrize("name", [pytest.param(n, marks=pytest.mark.slow) if n in SLOW else n for n in KINDS])
def test_who_follows_a_refusal_gets_a_solution(jkr, tuned, name: str) -> None:
    kind = KINDS[name]
    for constant, value in kind.limits.items():
        tuned(constant, value)
    refused = merged(BASE, kind.case)
    outcome = run(jkr, refused)
    assert outcome.code == 2
    values = said(kind.says, outcome.err.splitlines()[-1].removeprefix("jkr: error: "))
    for remedy in kind.remedies:
        mended = merged(refused, remedy(values) if callable(remedy) else remedy)
        outcome = run(jkr, mended)
        assert outcome.code == 0, outcome.err
        if kind.near is not None:
            agrees(mended, json.loads(outcome.out), kind.near)


def run(jkr, tables: Tree, *words: object):
    Path("x.toml").write_text(tomli_w.dumps(tables), encoding="utf-8")
    return jkr("run", "x.toml", "--json", *words)


def said(says: str, message: str) -> tuple[str, ...]:
    """The values that stand in ``message`` where ``says`` has {}."""
    found = re.fullmatch(pattern(says), message)
    assert found, f"{message!r} is not {says!r}"
    return found.groups()


def pattern(says: str) -> str:
    return re.escape(says).replace(re.escape("{}"), "(.*?)")


def agrees(tables: Tree, found: Tree, near: float) -> None:
    """The last load against that of ``layered``, for bodies so wide that sides do not matter."""
    wide = without_side_walls(parse_case(tomli_w.dumps(tables)).model.problem())
    exact = Layered(1e-4)(Problem(wide.indenter, wide.specimen, Loading("radius", found["a_m"], 1))).series
    beyond = (found["delta_m"] - exact.delta[-1]) * exact.S[-1]
    assert found["P_N"] == pytest.approx(exact.P[-1] + beyond, rel=near, abs=0)


OTHERS = {
    "fields": "fields: under an elastic indenter the displacement of the body's surface must be given",
    "memory": "{} would need about {} GiB of memory and {} of CPU time, the limit is {} GiB: use fewer points, "
    "larger elements or a cheaper method, or raise the limit by --limit-memory {}",
    "memory of the machine": "--limit-memory {} if the machine has that much",
    "time": "{} would need about {} GiB of memory and {} of CPU time, the limit is {} h: use fewer points, larger "
    "elements or a cheaper method, or raise the limit by --limit-time {}",
    "half-space of finite radius": "a body of finite radius needs a rigid substrate: give the depth as a layer's "
    "thickness",
    "exact slopes": "slopes: this solution carries no exact S and dS/da; use the slopes 'integral' or 'loocv', or a "
    "method that gives them (closed-form, layered, hybrid; fem with edge correction and error estimate)",
    "loocv": "slopes 'loocv': needs at least 5 points with different contact radii, got {}; give more increments, or "
    "refine the mesh where radii repeat",
    "scaled": "slopes 'loocv': takes the contact radii of increments as they are, those of nodes, and the nodes of the "
    'layout "scaled" stand apart in proportion to the radius: dS/da would be that of the mesh ({}); set mesh.layout = '
    '"zones", the paper\'s uniform mesh, or contact.algorithm = "nested", or take the slopes "integral"',
    "locking": "slopes 'loocv': these first-order elements lock at nu = {} > {}, where dS/da errs several times more "
    'than the load; set mesh.order = 2, mesh.integration = "reduced" (as CAX4R), or take the slopes "integral"',
    "integral": "slopes 'integral': needs at least 5 points with different contact radii, delta > 0 and P > 0, got {}; "
    "give more increments, or refine the mesh where radii repeat",
    "profile": "profile: under a modulus that varies right below the contact phi is not smooth at the edge, and its "
    "pressures are not implemented; cut the top layer into a few homogeneous ones",
}
LINEAR = {
    "method": "fem",
    "specimen": {"layers": [layer(nu=0.499)]},
    "mesh": {**ZONES, "element": "quadrilateral", "order": 1, "element_size": "1 um"},
    "contact": {"algorithm": "incremental"},
    "loading": {"points": 20},
}
COSTLY = {"method": "layered", "loading": {"points": 500}}


@pytest.mark.parametrize("limit", ["memory", "time"])
def test_a_limit_can_be_raised_or_kept(jkr, limit: str) -> None:
    tables, option = merged(BASE, COSTLY), f"--limit-{limit}"
    least = {"memory": 0.01, "time": 6e-6}[limit]
    *_, enough = said("jkr: error: " + OTHERS[limit] + "\n", run(jkr, tables, option, least).err)
    assert run(jkr, tables, option, enough).code == 0
    assert run(jkr, merged(tables, {"loading": {"points": 10}}), option, least).code == 0


@pytest.mark.parametrize("verb", ["run", "mesh", "fit", "bench"])
def test_a_remedy_names_options_that_the_verb_has(jkr, monkeypatch: pytest.MonkeyPatch, verb: str) -> None:
    monkeypatch.setattr("jkrcli.methods.protocol.SHARE", 1e-9)
    Path("x.toml").write_text(tomli_w.dumps(merged(BASE, COSTLY)), encoding="utf-8")
    Path("m.csv").write_text("delta_m,P_N\n" + "1e-6,1e-6\n" * 9, encoding="utf-8")
    outcome = jkr(verb, "x.toml", *(["m.csv"] if verb == "fit" else []))
    assert outcome.code == 2
    options = re.findall(r"--[a-z-]+", outcome.err)
    known = jkr(verb, "--help").out
    assert [option for option in options if option not in known] == []


def test_a_cylinder_without_a_base() -> None:
    methods: tuple[Any, ...] = (FEM(**COARSE), Hybrid())
    elastic, loading = Elastic(1.0, 0.3), Loading("radius", 0.1, 10)
    finite = Problem(Paraboloid(10.0), Specimen((), HalfSpace(elastic), 2.0, "free"), loading)
    deep = replace(finite, specimen=Specimen((Layer(elastic, 4.0),), Rigid(), 2.0, "free"))
    loads = []
    for method in methods:
        with pytest.raises(Refusal) as refused:
            method(finite)
        said(OTHERS["half-space of finite radius"], str(refused.value))
        found = method(deep).series
        loads.append(np.interp(0.9e-3, found.delta, found.P))
    assert loads[0] == pytest.approx(loads[1], rel=0.01, abs=0)


@pytest.mark.first(4)
@pytest.mark.parametrize(("slopes", "case", "remedies"), [
    ("loocv", {"method": "layered", "loading": {"points": 4}}, (("loocv", {"loading": {"points": 40}}),)),
    ("integral", {"method": "layered", "loading": {"points": 4}}, (("integral", {"loading": {"points": 40}}),)),
    ("scaled", fem(contact={"algorithm": "incremental"}),
     (("loocv", {"mesh": {"layout": "zones"}}), ("loocv", {"contact": {"algorithm": "nested"}}), ("integral", {}))),
    ("locking", LINEAR,
     (("loocv", {"mesh": {"order": 2}}), ("loocv", {"mesh": {"integration": "reduced"}}), ("integral", {}))),
    ("exact", fem({"edge_correction": False}), (("integral", {}), ("loocv", {}), ("exact", {"method": "layered"}),
     ("exact", {"mesh": {"edge_correction": True, "estimate_error": True}}))),
    ("integral", fem({"edge_correction": False}, contact={"algorithm": "incremental"},
                     loading={"radius": CLOSE, "points": None}),
     (("integral", {"mesh": {"spacing": 0.02}}), ("integral", {"mesh": {"edge_correction": True}}))),
], ids=["loocv", "integral", "scaled", "locking", "exact", "radii repeat"])  # fmt: skip
def test_slopes(jkr, slopes: str, case: Tree, remedies: tuple[tuple[str, Tree], ...]) -> None:
    tables = merged(BASE, case)
    assert run(jkr, tables).code == 0
    words = ("transform", "x.h5", "--w", "10 mJ/m^2", "--slopes")
    key = "exact slopes" if slopes == "exact" else slopes
    rule = slopes if slopes in RULES else "loocv"
    said("jkr: error: x.h5: " + OTHERS[key], jkr(*words, rule).err.splitlines()[-1])
    for name, change in remedies:
        assert run(jkr, merged(tables, change), "--force").code == 0
        assert jkr(*words, name).code == 0


def test_a_profile_under_a_graded_layer(jkr) -> None:
    tables = merged(BASE, {"method": "layered", "specimen": {"layers": [GRADED]}})
    words = ("profile", "x.h5", "--a", "5 um", "--w", "0")
    assert run(jkr, tables).code == 0
    said("jkr: error: " + OTHERS["profile"] + "\n", jkr(*words).err)
    cut = [layer("2.5 um", f"{1.125 + i / 4} MPa") for i in range(4)]
    assert run(jkr, merged(tables, {"specimen": {"layers": cut}})).code == 0
    assert jkr(*words).code == 0


def test_a_profile_that_is_not_accurate_enough(jkr) -> None:
    """Its tolerance is its own: that of the case does not matter."""
    tables = {**LAYERED, "specimen": THIN, "loading": {"radius": "100 um"}, "layered": {"tolerance": 1e-6}}
    assert run(jkr, merged(BASE, tables)).code == 0
    words = ("profile", "x.h5", "--w", "0", "--a")
    refused = jkr(*words, "100 um")
    assert refused.code == 2
    assert "use a smaller contact radius" in refused.err
    assert "layered.tolerance" not in refused.err
    assert jkr(*words, "10 um").code == 0


REFUSALS = {"Refusal", "InaccurateError"}
REASONS = {"refusal", "_unable", "_too_much", "_no_radius", "unsmooth", "_formula", "_thin_layer"}
PASSED_ON = {  # what such functions return, and refusals that another one holds
    "reason", "found", "error.fixed", "_no_radius(problem, reach)", "_too_much(problem)",
    "[*_unreached(tolerance, reached, solved).lines, *refusal.lines]", "self._too_far(a)", "self.no_range",
}  # fmt: skip
BEHIND = (  # never seen, as something else is told before, or seen as no refusal
    "mesh: {} x {} lines make too many quadrilaterals",  # their number is estimated first
    "nu: 0.5 needs the mixed form",  # fem says so before it builds anything
    "needs a contact beyond the profile: load less, or give a larger profile",  # found on the wide body first
    "method {}: {}",  # of jkrcli.methods.protocol: leads the reasons above
    "the coarse solution would take about {}",  # of jkr check, which goes on without
    "no exact method represents these bodies",  # the reason of the last one is told
)

BY_OTHER_VERBS = (  # refused to transform, or at sizes that take long: tests of finite range and of surfaces that stick
    "adhesion of finite range",
    "no formula is known for no slip",
    "the contact is not a growing disc of nodes (violation {}), so that it is not known where points stuck",
    "the correction is for frictionless contact",
    "equations without slip (limit {})",
    "surface tension",  # and tests of it
    # and tests of adhesion on bodies that relax
    "cycle: the edge of the contact takes more than {} steps, as its cohesive zone is ",
    "narrow: give a smaller --stress (a longer --range)",
    "cycle: the contact edge cannot be followed beyond t = {}: a jump there would ",
    "gain energy; give a smaller --stress",
    "cycle: the attraction of the surfaces extends without limit",
    "roughness: ",  # and tests of roughness
    "profile: method fem, which alone gives it here",  # and those of the core without its wing
)


def texts(node: ast.AST) -> Iterator[str]:
    if isinstance(node, ast.JoinedStr):
        yield "".join(str(part.value) if isinstance(part, ast.Constant) else "{}" for part in node.values)
    elif isinstance(node, ast.Constant) and isinstance(node.value, str):
        yield node.value
    else:
        for child in ast.iter_child_nodes(node):
            yield from texts(child)


def sites() -> Iterator[tuple[str, ast.AST]]:
    for path in sorted(PACKAGE.rglob("*.py")):
        text = path.read_text(encoding="utf-8")
        for node in nodes(path) if re.search(f"Refusal|def ({'|'.join(REASONS)})", text) else ():
            where = f"{path.relative_to(PACKAGE)}:{getattr(node, 'lineno', 0)}"
            if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id in REFUSALS:
                yield where, node.args[0]
            elif isinstance(node, ast.FunctionDef) and node.name in REASONS:
                returned = (part.value for part in ast.walk(node) if isinstance(part, ast.Return) and part.value)
                yield from ((where, value) for value in returned if any(texts(value)))


def test_every_refusal_has_a_test_of_its_remedy() -> None:
    tested = [*(kind.says for kind in KINDS.values()), *OTHERS.values()]
    untested, found = [], list(sites())
    for where, node in found:
        for text in (text for text in texts(node) if re.search("[a-z]", text)):
            shape = re.compile(pattern(text))
            covered = any(text in says or shape.search(says) for says in tested)
            if not covered and not any(part in text for part in BEHIND + BY_OTHER_VERBS):
                untested.append(f"{where}: {text}")
    assert untested == []
    assert {ast.unparse(node) for _, node in found if not any(texts(node))} - PASSED_ON == set()
