"""Facts about a finite-element run, and warnings with numbers."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from ...bodies.problem import Problem
from .contact import Events, Increment
from .model import Model
from .options import FEMOptions

LOCKING = 0.45


def facts(
    method: FEMOptions,
    problem: Problem,
    model: Model,
    events: Events,
    increments: Sequence[Increment],
    dropped: int,
    judged_from: float | None,
) -> dict[str, Any]:
    """Plain numbers and words about mesh, solver and checks; ``judged_from``: least depth of the error budget [m]."""
    grid, system, surface = model.grid, model.system, model.surface
    quality = grid.quality()
    last = increments[-1] if increments else None
    p, P = (last.p, last.P) if last is not None else (events.p[-1], float(events.P[-1]))
    solution = model.field(p)
    violation = max((step.violation for step in increments), default=events.violation)
    return {
        "layout": method.layout,
        "element": grid.element,
        "order": method.order,
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
        "contact_reason": _contact_reason(method, events, bool(increments)),
        "edge_correction": not increments and method.edge_correction,
        "solver": f"{model.factor.factor.name}, nested dissection, contact nodes last",
        "factor_entries": model.factor.factor.entries,
        "residual": surface.residual,
        "asymmetry": surface.asymmetry,
        "balance": abs(system.vertical_reaction(solution) / P - 1),
        "complementarity": max(violation, 0.0),
        "increments": len(increments),
        "dropped": dropped,
        "events": int(events.a.size),
        "radii": _radii(problem, bool(increments)),
    } | ({} if judged_from is None else {"judged_from_m": judged_from})


def _radii(problem: Problem, incremental: bool) -> str:
    """Where the contact radii of the series come from."""
    if incremental:
        return "vertices in contact after each increment of the loading"
    if problem.loading.spacing == "given":
        return "at the given values, interpolated between the vertices' first touches"
    return "nested contact has its own: first touches of vertices, and the loading's end; no use of points and spacing"


def _formulation(model: Model) -> str:
    mixed = model.recipe.mixed
    if not mixed:
        return "displacement"
    nu = max(model.body.materials[i].surface.nu for i in mixed)
    return f"displacement and pressure in layers {', '.join(str(i + 1) for i in mixed)} (nu = {nu:g})"


def _contact_reason(method: FEMOptions, events: Events, incremental: bool) -> str:
    if incremental and method.contact == "nested":
        return f"the contact is not a growing disc of nodes (violation {events.violation:.1e}): solved by increments"
    return "as asked"


def warnings(
    method: FEMOptions, problem: Problem, events: Events, increments: Sequence[Increment], dropped: int
) -> Iterator[str]:
    """Sentences on what may spoil the result; ``dropped``: of the ``increments``, those without an own radius."""
    nu = max(material.surface.nu for material in problem.specimen.materials)
    if method.order == 1 and nu > LOCKING:
        yield (
            f"first-order elements lock near incompressibility: nu = {nu:g} > {LOCKING:g}, the load may be several per "
            "cent too large; take mesh.order = 2"
        )
    if method.contact == "nested" and not events.valid:
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
    if dropped and (problem.loading.spacing in ("given", "log") or 2 * dropped > len(increments)):
        yield (
            f"{dropped} of {len(increments)} requested values share a node with another or lie below the first node "
            "and are not in the series: take a finer mesh (mesh.spacing, mesh.smallest, mesh.element_size), or fewer "
            "values"
        )
