"""What a solve by ``fem`` costs and how accurate it is, before it is begun."""

from __future__ import annotations

from dataclasses import dataclass

from ...bodies import Problem
from ..protocol import Forecast
from .body import half_space_like
from .layout import Layout
from .model import mixed_layers
from .options import DOUBLED, FEMOptions


@dataclass(frozen=True)
class ForecastTuning:
    """Cost and accuracy as measured."""

    start: float = 0.03  # CPU seconds of any model; tuned on the cases of `make bench`, by `make bench`
    per_unknown: float = 2.5e-5  # and per unknown of a small one; tuned on the same, by `make bench`
    large: float = 1e5  # unknowns, from which they grow like the power 3/2; tuned on the same, by `make bench`
    per_row: float = 1.5e-4  # and per depth, load or radius of a list; tuned on lists of 1e5, by `make guards`
    mib_per_row: float = 8e-3  # memory of one; tuned on the same, by `make guards`
    mib: float = 100.0  # memory of any model; tuned on the same, by `make bench`
    mib_per_unknown: float = 5e-3  # tuned on the same, by `make bench`
    load: float = 3e-4  # error of the default spacing, second order; tuned on the bodies of `make chart`, by it
    load_order: float = 2.3  # by which it falls; tuned on the same, by `make chart`
    load_first: float = 1e-2  # error with first-order elements; tuned on the same, by `make chart`
    graded: float = 0.15  # of what a graded top leaves unresolved; tuned on power laws of depth, by `make bounds`
    radius: float = 6e-4  # error of calibrated radii; tuned on the same, by `make chart`


TUNING = ForecastTuning()


def forecast(options: FEMOptions, problem: Problem, layout: Layout) -> Forecast:
    """Cost and error from the expected number of elements of ``layout``."""
    per_cell = _unknowns_per_cell(options, bool(mixed_layers(options, problem)))
    cells = layout.expected_cells()
    seconds = _seconds(options, cells * per_cell)
    elsewhere = options.edge_correction and not problem.specimen.is_half_space
    if elsewhere:  # the edge correction needs a mesh of its own
        half_space = half_space_like(layout.body, layout.law.reach * layout.unit)
        seconds += _seconds(options, layout.on(half_space).expected_cells() * per_cell)
    rows = len(problem.loading.values)
    seconds += TUNING.per_row * rows
    memory = TUNING.mib + cells * per_cell * TUNING.mib_per_unknown + TUNING.mib_per_row * rows
    note = f"about {float(f'{cells:.2g}'):.0f} elements"
    return Forecast(seconds, memory, _error(options, layout, elsewhere), note)


def _seconds(options: FEMOptions, unknowns: float) -> float:
    """CPU seconds to mesh, assemble, factorise and condense a model, and its companion for the error estimate."""
    models = (unknowns, unknowns / DOUBLED**2) if options.estimate_error else (unknowns,)
    return sum(TUNING.start + TUNING.per_unknown * n * (1 + (n / TUNING.large) ** 0.5) for n in models)


def _unknowns_per_cell(options: FEMOptions, mixed: bool) -> float:
    """Unknowns per element of large meshes: a triangle has half a vertex, and two displacements per node."""
    first_order = 1.0 if options.element == "triangle" else 2.0
    return first_order * (1.0 if options.order == 1 else 4.2) * (1.1 if mixed else 1.0)


def _error(options: FEMOptions, layout: Layout, calibrated: bool) -> float:
    """Expected relative error of loads and radii together; zones leave no less than the default's, however small."""
    spacing = layout.law.slope or layout.law.floor / layout.law.reach
    coarseness = spacing / FEMOptions.spacing if options.layout == "scaled" else max(spacing / FEMOptions.spacing, 1.0)
    rates = TUNING
    load = rates.load * coarseness**rates.load_order if options.order == 2 else rates.load_first * coarseness**2
    load += rates.graded * layout.unresolved
    if options.contact == "incremental" or not options.edge_correction:
        return load + spacing
    return load + (TUNING.radius * coarseness if calibrated else 0.0)
