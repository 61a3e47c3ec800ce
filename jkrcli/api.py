"""The Python interface: the objects that the command line works with, from a case to an adhesive curve.

>>> import jkrcli as jkr
>>> case = jkr.parse_case('''
... [indenter]
... shape = "paraboloid"
... radius = "10 um"
... [[specimen.layers]]
... thickness = "5 um"
... E = "1 MPa"
... nu = 0.499
... [loading]
... radius = "8 um"
... ''')
>>> solved = jkr.solve(case)
>>> solved.method
'layered'
>>> curve = jkr.transform(solved, w=0.05)
>>> point = curve.pull_off["load"]
>>> f"{point.P * 1e6:.4f} uN at a = {point.a * 1e6:.3f} um"
'-2.4906 uN at a = 2.418 um'
>>> list(jkr.columns(curve))[:3]
['a_m', 'delta_m', 'P_N']
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

from . import store, tables
from .analysis import Analysis, analyse
from .case import Case, load_case
from .case import parse_case as _parse_case
from .errors import InputError
from .files import check_target
from .series import Array
from .solving import solve as _solve
from .store import Kept, Stored
from .threads import one_thread

if TYPE_CHECKING:
    from pandas import DataFrame

    from .plots import Figure

__all__ = ["columns", "load_case", "parse_case", "plot", "read", "save", "solve", "summary", "to_pandas", "transform"]


def parse_case(text: str, folder: str | Path = ".") -> Case:
    """A case from TOML text; ``folder`` is where names of profile tables are looked up.

    Raises InputError (exit code 2 of the command line) with a line per mistake.
    """
    return _parse_case(text.encode(), "case", Path(folder))


def solve(problem: Case | str | Path, method: str | None = None) -> Kept:
    """The nonadhesive series of a case (or of the case file at a path), as a series file would hold it.

    ``method``: instead of the case's own. Raises InputError where the case is wrong or no method can represent it.
    """
    loaded = problem if isinstance(problem, Case) else load_case(problem)
    _, solution = _solve(loaded, method)
    return store.kept(solution, loaded.to_toml(), loaded.model.problem().key)


def read(path: str | Path) -> Stored:
    """What the series file (HDF5) at ``path`` holds."""
    return store.read(path)


def save(solved: Kept, path: str | Path, force: bool = False) -> Path:
    """Write a series file, whole or not at all; a file that jkr did not write is replaced only with ``force``."""
    target = Path(path)
    check_target(target, force)
    store.write(target, solved.solution, solved.case, solved.key, "import jkrcli")
    return target


@one_thread
def transform(solved: Stored | str | Path, w: float, slopes: str = "auto", modulus_factor: float = 1.0) -> Analysis:
    """The adhesive curve for the work of adhesion ``w`` [J/m^2], with pull-off, errors, validity and warnings.

    ``slopes``: "auto", "exact", "integral", "loocv" or "gcv"; ``modulus_factor``: all moduli times this.
    """
    stored = solved if isinstance(solved, Stored) else read(solved)
    return analyse(stored, [w], slopes, modulus_factor)[0]


def columns(curve: Analysis) -> dict[str, Array]:
    """The columns of the curve's CSV file: names with units, one value per contact radius."""
    return tables.curve_columns(curve.curve)


def to_pandas(curve: Analysis) -> DataFrame:
    """The same as a data frame (needs the optional package pandas)."""
    try:
        from pandas import DataFrame
    except ModuleNotFoundError:
        raise InputError('to_pandas needs the optional package pandas: pip install "jkrcli[pandas]"') from None
    return DataFrame(columns(curve))


def plot(curve: Analysis, path: str | Path | None = None) -> Figure:
    """Load over displacement and contact radius over load; also written to ``path`` (.png, .svg, .pdf) where given."""
    from . import plots

    figure = plots.curve_figure(curve, plots.physical_units(curve.curve))
    if path is not None:
        plots.save(figure, Path(path))
    return figure


def summary(curve: Analysis) -> dict[str, Any]:
    """What the curve's JSON file says."""
    return tables.summary(curve)
