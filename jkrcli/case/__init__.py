"""Case files, series files, sweep files: tables and models, from there to problems, methods and solutions, and back."""

from __future__ import annotations

from ..base.lazy import lazily

TYPE_CHECKING = False
if TYPE_CHECKING:
    from .models import CaseModel, LoadingTable, case_model, fem_of, method_of, other_tables
    from .reading import Case, load_case, model_of, parse_case, parse_toml, plain_toml, shown, validated
    from .store import NO_DIGEST, SERIES, read_solution, record_of, solve, write_solution
    from .sweep import MOST_CASES, AxisTable, DistributionTable, SamplesTable, SweepModel, load_sweep

__getattr__ = lazily(__name__, __file__)
