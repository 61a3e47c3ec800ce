"""What a finite-element solve costs and how accurate it is, as measured: known before anything is meshed."""

from __future__ import annotations

from ...bodies.problem import Problem
from .. import Forecast
from .adapt import COMPANION
from .domain import half_space_like
from .edge import CUT
from .layout import Layout
from .options import FEMOptions


def forecast(method: FEMOptions, problem: Problem, layout: Layout, mixed: bool) -> Forecast:
    """From the expected number of elements of ``layout``; ``mixed``: whether any layer has a pressure unknown."""
    per_cell = _unknowns_per_cell(method, mixed)
    calibrated = _calibrated_elsewhere(method, problem)
    cells = layout.expected_cells()
    unknowns = cells * per_cell
    seconds = _with_companion(method, unknowns)
    if calibrated:
        half_space = half_space_like(layout.body, CUT * layout.law.reach * layout.unit)
        seconds += _with_companion(method, layout.on(half_space).expected_cells() * per_cell)
    note = f"about {float(f'{cells:.2g}'):.0f} elements"
    return Forecast(seconds, 100 + unknowns * 5e-3, _error(method, layout, calibrated), note)


def _with_companion(method: FEMOptions, unknowns: float) -> float:
    """CPU seconds of a model, and of its coarser companion for the error estimate (under a tolerance it is finer)."""
    fewer = 4 if method.tolerance is None else COMPANION**2
    return _seconds(unknowns) + (_seconds(unknowns / fewer) if method.estimate_error else 0.0)


def _seconds(unknowns: float) -> float:
    """CPU seconds to mesh, assemble, factorise and condense a model, as measured."""
    return 0.03 + 2.5e-5 * unknowns * (1 + (unknowns / 1e5) ** 0.5)


def _unknowns_per_cell(method: FEMOptions, mixed: bool) -> float:
    first = 1.0 if method.element == "triangle" else 2.0
    return first * (1.0 if method.order == 1 else 4.2) * (1.1 if mixed else 1.0)


def _calibrated_elsewhere(method: FEMOptions, problem: Problem) -> bool:
    """Whether the edge correction needs a mesh of its own."""
    return method.edge_correction and method.contact == "nested" and not problem.specimen.is_half_space


def _error(method: FEMOptions, layout: Layout, calibrated: bool) -> float:
    """Of loads and radii together, as measured; zones leave no less than the default's, however small."""
    spacing = layout.law.slope or layout.law.floor / layout.law.reach
    coarseness = spacing / 0.04 if method.layout == "scaled" else max(spacing / 0.04, 1.0)
    load = 3e-4 * coarseness**2.3 if method.order == 2 else 1e-2 * coarseness**2
    if method.contact == "incremental" or not method.edge_correction:
        return load + spacing
    return load + (6e-4 * coarseness if calibrated else 0.0)
