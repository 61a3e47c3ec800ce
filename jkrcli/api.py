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
>>> list(jkr.table(curve))[:3]
['a_m', 'delta_m', 'P_N']

The same without TOML, by a method of one's choice:

>>> gel = jkr.Specimen((jkr.Layer(jkr.Elastic(E=1e6, nu=0.499), thickness=5e-6),), jkr.Rigid(bonded=True))
>>> problem = jkr.Problem(jkr.Paraboloid(R=10e-6), gel, jkr.Loading("radius", 8e-6))
>>> curve = jkr.transform(jkr.solve(problem, jkr.Layered(tolerance=1e-9)), w="50 mJ/m^2")
>>> f"{curve.pull_off['load'].P * 1e6:.4f} uN"
'-2.4906 uN'
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from .adhesion.analysis import Analysis, analyse
from .adhesion.law import AskedRange
from .base.arrays import Array
from .base.errors import InputError
from .base.files import check_series_target
from .base.installing import installs
from .base.threads import one_thread
from .base.units import parse
from .bodies.problem import Problem
from .case import Case, load_case, store
from .case import parse_case as _parse_case
from .case.solving import solve as _solve
from .data.measured import Curve, Reading
from .data.measured import read as read_curves
from .methods import Method
from .methods.guards import Limits
from .report import tables
from .series import Solution

if TYPE_CHECKING:
    from pandas import DataFrame

    from .identification.fit import Fit
    from .report.plots import Figure

__all__ = [
    "identify",
    "load_case",
    "measured_curves",
    "parse_case",
    "plot",
    "read",
    "save",
    "solve",
    "summary",
    "table",
    "to_pandas",
    "transform",
]


def parse_case(text: str, folder: str | Path = ".") -> Case:
    """A case from TOML text; ``folder`` is where names of profile tables are looked up.

    Raises InputError (exit code 2 of the command line) with a line per mistake.
    """
    return _parse_case(text.encode(), "case", Path(folder))


def solve(
    problem: Case | Problem | str | Path, method: str | Method | None = None, limits: Limits | None = None
) -> Solution:
    """The nonadhesive series of a problem, a case or the case file at a path, as its series file gives it back.

    ``method``: a name or a configured method, FEM(tolerance=1e-3), instead of the case's own; ``limits``: most memory
    and time to begin with, Limits(memory=8, hours=2). Raises InputError where the case is wrong, no method can
    represent it, or it would cost too much.
    """
    _, solution = _solve(load_case(problem) if isinstance(problem, str | Path) else problem, method, limits)
    return solution


def read(path: str | Path) -> Solution:
    """What the series file (HDF5) at ``path`` holds, contact pressures included."""
    return store.read(path, with_pressure=True)


def save(solved: Solution, path: str | Path, force: bool = False) -> Path:
    """Write a series file, whole or not at all; a file that jkr did not write is replaced only with ``force``."""
    target = Path(path)
    check_series_target(target, force)
    store.write(target, solved, "import jkrcli")
    return target


@one_thread()
def transform(
    solved: Solution | Case | Problem | str | Path,
    w: float | str,
    slopes: str = "auto",
    modulus_factor: float = 1.0,
    method: str | Method | None = None,
    *,
    stress: float | None = None,
    length: float | None = None,
) -> Analysis:
    """The adhesive curve for the work of adhesion ``w`` [J/m^2], with pull-off, errors, validity and warnings.

    ``solved``: a solution or its file; a case, its file or a problem is solved first, by ``method``. ``w``: a number,
    or text with a unit, "40 mJ/m^2"; ``slopes``: "auto", "exact", "integral", "loocv" or "gcv"; ``modulus_factor``:
    all moduli times this. ``stress`` [Pa] or ``length`` [m]: adhesion of finite range by its tension or its range,
    else what the case says.
    """
    if isinstance(solved, Case | Problem) or (not isinstance(solved, Solution) and Path(solved).suffix == ".toml"):
        solved = solve(solved, method)
    solution = solved if isinstance(solved, Solution) else store.read(solved)
    asked = AskedRange.of(solution.record, stress, length)
    return analyse(solution, [_work(w) if isinstance(w, str) else w], slopes, modulus_factor, asked)[0]


def _work(text: str) -> float:
    try:
        return parse(text, "work")
    except ValueError as error:
        raise InputError(f"w: {error}") from None


def identify(
    body: Case | Solution | str | Path,
    measured: Curve | str | Path,
    free: Iterable[str] = (),
    fix: Mapping[str, str] | None = None,
    slopes: str = "auto",
    **options: Any,
) -> Fit:
    """E*, w and the zero points that bring the adhesive curve of ``body`` nearest to one ``measured`` curve.

    ``body``: a case (solved to the radii that the data ask for), a solved series, or the file of either. ``free``: more
    parameters ("P0", "E:film"); ``fix``: known ones, {"w": "50 mJ/m^2"}; ``options``: see
    jkrcli.identification.fit.Settings. Raises InputError where the data cannot be fitted.
    """
    from .identification.fit import fit
    from .identification.fit.body import body_of
    from .identification.fit.settings import settings_of

    source = body_of(Path(body) if isinstance(body, str) else body, slopes)
    curve = measured if isinstance(measured, Curve) else _only_curve(Path(measured))
    return one_thread()(fit)(source, curve, settings_of(source, free, (fix or {}).items(), **options))


def _only_curve(path: Path) -> Curve:
    curves = measured_curves(path)
    if len(curves) > 1:
        raise InputError(f"{path}: holds {len(curves)} curves, one is wanted: give one of measured_curves(path)")
    return curves[0]


def measured_curves(path: str | Path, **reading: Any) -> list[Curve]:
    """The measured curves in a file; ``reading``: how to read it, see jkrcli.data.measured.Reading."""
    return read_curves(Path(path), Reading(**reading))


def table(curve: Analysis) -> dict[str, Array]:
    """The columns of the curve's CSV file: names with units, one value per contact radius."""
    return tables.curve_columns(curve.curve)


def to_pandas(curve: Analysis) -> DataFrame:
    """The columns as a data frame (needs the optional package pandas)."""
    try:
        from pandas import DataFrame
    except ModuleNotFoundError:
        raise InputError(f"to_pandas needs the optional package pandas: {installs('pandas')}") from None
    return DataFrame(table(curve))


def plot(curve: Analysis, path: str | Path | None = None) -> Figure:
    """Load over displacement and contact radius over load; also written to ``path`` (.png, .svg, .pdf) where given."""
    from .report import plots
    from .report.plots import curve as plots_curve

    figure = plots_curve.curve_figure(curve, plots_curve.physical_units(curve.curve))
    if path is not None:
        plots.save(figure, [Path(path)])
    return figure


def summary(curve: Analysis) -> dict[str, Any]:
    """What the curve's JSON file says."""
    return tables.summary(curve)
