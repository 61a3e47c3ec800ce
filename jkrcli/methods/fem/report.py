"""What is returned of a finite-element run: series with errors, facts, and warnings with numbers."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from ...base import ROUNDED, StageClock
from ...bodies.materials import INCOMPRESSIBLE
from ...series import Series, Solution
from .budget import Assessment
from .model import Model, Run, nodal_forces, pressures
from .options import FEMOptions


def finished(options: FEMOptions, run: Run, judged: Assessment, clock: StageClock) -> Solution:
    """The solution: series, pressures, facts and warnings."""
    level = run.level
    with clock("contact"):
        if run.raw is None:
            forces = nodal_forces(level.contact, level.touches, run.columns[1])
        else:
            forces = np.array([step.p for step in run.increments])
        series, pressure = _series(run, judged), pressures(level.model.surface, forces)
    facts, warnings = _facts(options, run, judged.judged_from), tuple(_warnings(options, run))
    solution = Solution(
        run.problem, series, judged.budget, "fem", run.raw, pressure,
        facts=facts, timings=clock.seconds, warnings=warnings,
    )  # fmt: skip
    return solution.widened()


def _series(run: Run, judged: Assessment) -> Series:
    """The nonadhesive series with the errors that are known; S and dS/da only where theirs are."""
    a, delta, P = run.columns
    a0, contact = run.problem.indenter.a0, run.level.contact
    flat = int(np.count_nonzero(contact.surface.radii <= a0 * (1 + ROUNDED)))
    S0 = float(contact.S[flat - 1]) if a0 > 0 else 0.0
    S, dS = (run.level.slopes(a) if "dS" in judged.errors else None) or (None, None)
    values = {"a": a, "P": P, "S": S, "dS": dS}
    errors = {name: error * values[name] for name, error in judged.errors.items()}
    return Series(a, delta, P, S, dS, errors=errors, a0=a0, S0=S0, coarser=judged.coarser)


def _facts(options: FEMOptions, run: Run, judged_from: float | None) -> dict[str, Any]:
    """Plain numbers and words about mesh, solver and checks; ``judged_from``: least depth of the error budget [m]."""
    model, events, increments = run.level.model, run.level.touches, run.increments
    system, surface = model.system, model.surface
    grid, quality = system.grid, system.grid.quality()
    last = increments[-1] if increments else None
    p, P = (last.p, last.P) if last is not None else (events.p[-1], float(events.P[-1]))
    violation = max((step.violation for step in increments), default=events.violation)
    return {
        "layout": options.layout,
        "element": grid.element,
        "order": options.order,
        "integration": options.integration,
        "elements": len(grid.cells),
        "vertices": len(grid.points),
        "unknowns": int(system.free.size),
        "candidates": int(surface.radii.size),
        "quality_min": float(quality.min()),
        "quality_median": float(np.median(quality)),
        "depth_m": grid.depth,
        "width_m": grid.width,
        "formulation": _formulation(model),
        "contact": "nested" if last is None else "incremental",
        "contact_reason": _contact_reason(options, run),
        "edge_correction": run.level.correct,
        "solver": f"{model.factor.factor.name}, nested dissection, contact nodes last",
        "factor_entries": model.factor.factor.entries,
        "residual": surface.residual,
        "asymmetry": surface.asymmetry,
        "balance": abs(system.vertical_reaction(model.field(p)) / P - 1),
        "complementarity": max(violation, 0.0),
        "increments": len(increments),
        "dropped": run.dropped,
        "events": int(events.a.size),
        "radii": _radii(run),
    } | ({} if judged_from is None else {"judged_from_m": judged_from})


def _radii(run: Run) -> str:
    """Where the contact radii of the series come from."""
    if run.increments:
        where = "where the outermost one just touches" if run.level.correct else "not corrected"
        return f"vertices in contact after each increment of the loading, {where}"
    if run.problem.loading.spacing == "given":
        return "at the given values, interpolated between the vertices' first touches"
    return "nested contact has its own: first touches of vertices, and the loading's end; no use of points and spacing"


def _formulation(model: Model) -> str:
    mixed = model.system.mixed
    if not mixed:
        return "displacement"
    nu = max(model.body.materials[i].surface.nu for i in mixed)
    return f"displacement and pressure in layers {', '.join(str(i + 1) for i in mixed)} (nu = {nu:g})"


def _contact_reason(options: FEMOptions, run: Run) -> str:
    if run.increments and options.contact == "nested":
        violation = run.level.touches.violation
        return f"the contact is not a growing disc of nodes (violation {violation:.1e}): solved by increments"
    return "as asked"


def _warnings(options: FEMOptions, run: Run) -> Iterator[str]:
    """Sentences on what may spoil the result."""
    problem, events, increments = run.problem, run.level.touches, run.increments
    nu = max(material.surface.nu for material in problem.specimen.materials)
    if options.order == 1 and options.integration == "full" and nu > INCOMPRESSIBLE:
        quads = ', or mesh.integration = "reduced"' if options.element == "quadrilateral" else ""
        yield (
            f"first-order elements lock near incompressibility: nu = {nu:g} > {INCOMPRESSIBLE:g}, the load may be "
            f"several per cent too large; take mesh.order = 2{quads}"
        )
    if options.contact == "nested" and not events.valid:
        yield (
            "nested contact does not hold here (a force or gap is negative by "
            f"{events.violation:.1e}, relative): increments were solved instead"
        )
    broken = sum(not step.is_disc for step in increments)
    if broken:
        yield (
            f"in {broken} of {len(increments)} increments the contact is no full disc: its middle lifts off, or the "
            "surfaces touch again beyond the edge; the radius is that of the outermost vertex, and the adhesive curve "
            "is right only where adhesion holds the disc together: load less"
        )
    if run.dropped and (problem.loading.spacing in ("given", "log") or 2 * run.dropped > len(increments)):
        yield (
            f"{run.dropped} of {len(increments)} requested values share a node with another or lie below the first "
            "node and are not in the series: take a finer mesh (mesh.spacing, mesh.smallest, mesh.element_size), or "
            "fewer values"
        )
