"""Series that other programs computed: from their tables to the columns a, delta, P in SI with compression positive."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from ..adhesion.contact_shape import DISC
from ..base.errors import InputError, Unknown, counted
from ..base.numerics import Array, cubic_spline
from ..base.units import LARGEST_SI
from ..bodies.indenters import Indenter, Sphere
from ..bodies.problem import Loading, Problem
from ..series import ErrorBudget, RawSeries, Series, Solution, filter_plateaus, is_series
from ..series.vocabulary import VOCABULARIES, check_chosen, factors_of, is_within_noise, near_first_touch, with_units
from ..tables import split_name, unit_power
from ..tables.text import TextTable, read_table, some

if TYPE_CHECKING:
    from .node_radii import Compared


LEAST_ROWS = 5  # theory: of a series; leaving one of fewer out leaves no cubic for its slopes
MOST_ROWS = 100_000  # theory: as many points as a case may ask for
NODE_OFF = 0.2  # choice: of an element, by which radii may miss nodes: they are rounded, or those of an area
UNKNOWN = Unknown("unknown: imported data")
NAMES = VOCABULARIES["computed"]


@dataclass(frozen=True)
class SeriesReading:
    """Conventions of a foreign table; keys of the mappings are "a", "area", "delta" and "P".

    ``columns``: names or numbers (from 1), where the header names none; ``units``: in the header's place;
    ``factors``: on top of the units (P = 180 for CalculiX, which prints the force on its wedge of 2 degrees).
    ``zero``: displacement [m] and load [N] at first touch, after the sign, subtracted. ``sign``: "auto" turns a
    displacement or load that is negative throughout, "as-is" leaves them. ``sort``: order the rows by displacement.
    ``area``: "surface" of the indenter in contact (Abaqus; Eq. A3), its "projected" area pi a^2, or "auto": the
    surface unless the exact solution of the bodies says that it is the projected one. ``compare``: whether the exact
    solution of the bodies, where there is one, tells where the edge is between nodes, the shape, and what an area is.
    ``nodes``: a table of the radii of all nodes of the mesh at the contact, where the contact radii are those of nodes.
    ``contact_shape``: "any" or "ellipse=R1/R2" where the contact is no disc: an area is its projected one, its radius
    sqrt(A/pi), and nothing is compared with discs.
    """

    columns: Mapping[str, str] = field(default_factory=dict)
    units: Mapping[str, str] = field(default_factory=dict)
    factors: Mapping[str, float] = field(default_factory=dict)
    zero: Mapping[str, float] = field(default_factory=dict)
    sign: Literal["auto", "as-is"] = "auto"
    sort: bool = False
    area: Literal["auto", "surface", "projected"] = "auto"
    compare: bool = True
    nodes: Path | None = None
    separator: str | None = None
    decimal: str | None = None
    contact_shape: str = DISC

    def __post_init__(self) -> None:
        if self.contact_shape != DISC:
            if self.area == "surface" or self.nodes is not None:
                raise InputError("import: --area surface and --nodes are of contacts that are discs: leave them out")
            object.__setattr__(self, "area", "projected")
            object.__setattr__(self, "compare", False)
        object.__setattr__(self, "factors", factors_of(self.factors))


def read_series(path: Path, problem: Problem, reading: SeriesReading) -> Solution:
    """The series in the table at ``path``, made by the bodies of ``problem``; its loading is that of the table.

    InputError names lines and columns.
    """
    from .node_radii import check_against_solution, compared

    indenter = problem.indenter
    if indenter.rim < math.inf:
        raise InputError("import: a flat punch with a sharp edge needs none, its P = S delta is solved: jkr run CASE")
    table = read_table(path, reading.separator, reading.decimal, 3 if reading.contact_shape == DISC else 2)
    table, units, unit_flags = with_units(table, reading.units, NAMES.quantities)
    reading = replace(reading, units=units)
    # Index of the column for each key: the one of `reading`, else by its name; the radius goes before the area.
    named = {key: table.called(name, key) for key, name in reading.columns.items()}
    by_area = "area" in named or bool(NAMES.named(table, "area") and not NAMES.named(table, "a"))
    wanted = ("delta", "P", "area" if by_area and "a" not in named else "a")
    chosen = {key: named[key] if key in named else NAMES.guess(table, key) for key in wanted}
    check_chosen(table, named | chosen)
    if "a" in chosen and reading.area != "auto" and reading.contact_shape == DISC:
        raise InputError(f"{path}: --area is what a contact area means, and the table has contact radii: leave it out")
    lines, values = table.lines, dict[str, Array]()
    for key, index in chosen.items():  # in SI: unit, factor, sign and zero applied
        column = NAMES.in_si(table, key, index, reading.units.get(key)) * reading.factors.get(key, 1.0)
        if key in ("delta", "P") and reading.sign == "auto" and column.min() < 0 and -column.min() > column.max():
            column = -column
        values[key] = column - reading.zero[key] if key in reading.zero else column
    if beyond := [key for key, column in values.items() if np.abs(column).max() > LARGEST_SI]:
        meaning = NAMES.meaning(beyond[0])
        raise InputError(f"{path}: {meaning} must be at most {LARGEST_SI:g} in SI units: is its unit right?")
    if lines.size > MOST_ROWS:
        raise InputError(f"{path}: holds {lines.size:,} rows, at most {MOST_ROWS:,} are imported: leave some out")
    if reading.sort:
        order = np.argsort(values["delta"], kind="stable")
        values, lines = {key: column[order] for key, column in values.items()}, lines[order]
    size = "a" if "a" in values else "area"
    touching = values[size] > 0
    wrong = _wrong(path, values, lines, touching)
    noisy = bool(wrong) and is_within_noise(*(values[name][touching] for name in (size, "delta", "P")))
    if wrong and not noisy:
        raise InputError(wrong)
    if "area" in values:
        values["a"], meaning = _radii(path, values, lines, problem, reading)
        reading = replace(reading, area=meaning)
    raw = RawSeries(values["a"], values["delta"], values["P"], lines)
    if reading.nodes is not None:
        raw = _on_nodes(path, raw, reading.nodes, reading.units.get("a"))
    if noisy:
        beside, series, words = _by_fit(path, raw, problem, reading)
        raw = beside.raw
        dropped = int(lines.size - raw.a.size)
    else:
        kept, dropped = filter_plateaus(raw)
        _check_kept(path, kept, dropped, indenter)
        beside = compared(problem, raw, reading.compare, reading.contact_shape == DISC)
        series, words = _series(kept, indenter), ()
    loads = beside.loads()
    doubts = () if loads is None else loads.doubts(problem)
    # What the bodies say of radii and loads
    said = "not compared with these bodies" if loads is None else loads.words
    if doubts:
        said = doubts[0].removeprefix("the loads are ") if said in doubts[0] else f"{said}; {doubts[0]}"
    facts = _facts(table, chosen, reading, dropped) | {"order": "by the fit" if noisy else "of the rows"}
    rows = "those of the rows" if "a" in chosen else f"of the contact area ({reading.area}: --area)"
    facts |= {"loads": said, "radii": beside.of_nodes or rows}
    if reading.contact_shape != DISC:
        facts["contact_shape"] = reading.contact_shape
    if loads is not None:
        facts |= {"loads_factor": loads.factor, "loads_factor_error": loads.error * loads.factor}
    return Solution(
        problem=replace(problem, loading=Loading("depth", float(raw.delta.max()), raw.delta.size, "depth")),
        series=series,
        raw=raw,
        budget=ErrorBudget(UNKNOWN, UNKNOWN, UNKNOWN),
        method="import",
        facts=facts,
        warnings=(*doubts, *unit_flags, *table.left_out, *words, *(() if doubts else check_against_solution(beside))),
    )


def _series(rows: RawSeries, indenter: Indenter) -> Series:
    """The rows as a series; S at first touch is known where the contact begins in a point."""
    return Series(rows.a, rows.delta, rows.P, a0=indenter.a0, S0=None if indenter.a0 > 0 else 0.0)


def _by_fit(
    path: Path, raw: RawSeries, problem: Problem, reading: SeriesReading
) -> tuple[Compared, Series, tuple[str, ...]]:
    """Rows in contact that are noisy beside their bodies, their fitted series, and what is wrong with them.

    Rows near first touch at which noise hides the contact (delta or P <= 0) are left out, and so are outliers beyond.
    """
    from ..adhesion.slopes import smoothed
    from .node_radii import compared

    assert raw.rows is not None
    indenter = problem.indenter
    hidden = (raw.a <= indenter.a0) | (raw.delta <= 0) | (raw.P <= 0)
    touched = int(np.argmax(raw.a > indenter.a0))
    first = touched + near_first_touch(hidden[touched:])
    used = ~hidden & (np.arange(hidden.size) >= first)
    kept = raw.only(used)
    _check_kept(path, kept, int(np.sum(~used)), indenter)
    S0 = None if indenter.a0 > 0 else 0.0
    beside = compared(problem, kept, reading.compare, reading.contact_shape == DISC)
    series, slopes = smoothed(kept, indenter.a0, S0, beside.own, beside.ahead)
    if is_series(kept):  # their scatter is read off the rows themselves, not off what was fitted to them
        inside = (kept.a >= series.a[0]) & (kept.a <= series.a[-1])
        series = _series(RawSeries(kept.a[inside], kept.delta[inside], kept.P[inside]), indenter)
    lost = int(np.sum(raw.a[:first] > indenter.a0))
    are = "is" if lost == 1 else "are"
    words = [f"{counted(lost, 'row')} near first touch, where noise hides the contact, {are} left out"] if lost else []
    if alone := [str(row) for row in raw.rows[first:][hidden[first:]]]:
        what = f"{len(alone)} of {raw.a.size} rows left out, whose radius, displacement or load is not positive"
        words.append(f"{what}: {', '.join(some(alone))}")
    return beside, series, (*words, *slopes.flags)


# ---------------------------------------------------------------------- rows
def _wrong(path: Path, values: Mapping[str, Array], lines: Array, touching: Array) -> list[str]:
    """What is wrong with the order of the rows in contact: displacement and load rise, radius or area does not fall.

    Refused where too few are in contact.
    """
    if touching.sum() < LEAST_ROWS:
        there = f" (lines {', '.join(map(str, lines[touching]))})" if touching.any() else ""
        raise InputError(
            f"{path}: holds {counted(int(touching.sum()), 'row')} in contact{there}, at least {LEAST_ROWS} are needed"
        )
    wrong = []
    for key, rule in (("delta", "rise"), ("P", "rise"), ("a" if "a" in values else "area", "not fall")):
        column, rows, meaning = values[key][touching], lines[touching], NAMES.meaning(key)
        if column[0] <= 0:
            wrong.append((rows[0], f"{meaning} must be positive in contact, got {column[0]:.6g} (SI)"))
        steps = np.diff(column)
        for i in np.flatnonzero(steps <= 0 if rule == "rise" else steps < 0):
            change = "stays at" if steps[i] == 0 else f"falls from {column[i]:.6g} to"
            wrong.append((rows[i + 1], f"{meaning} must {rule} from row to row, it {change} {column[i + 1]:.6g} (SI)"))
    if not wrong:
        return []
    messages = [f"{path}: line {line}: {message}" for line, message in sorted(wrong)]
    return [*some(messages), f"{path}: {_remedy(values['delta'][touching])}"]


def _remedy(delta: Array) -> str:
    steps = np.diff(delta)
    peak = int(np.argmax(delta))
    if (steps > 0).all():
        return "remove or mend those rows; repeated contact radii are normal, falling ones are not a growing contact"
    if (steps >= 0).all():
        return "remove the rows that repeat a displacement"
    if peak > 0 and (steps[:peak] > 0).all() and (steps[peak:] < 0).all():
        return "the rows after the largest displacement are unloading: remove them"
    return "the rows are not in the order of loading: --sort orders them by displacement"


def _check_kept(path: Path, kept: RawSeries, dropped: int, indenter: Indenter) -> None:
    assert kept.rows is not None
    if kept.a.size < LEAST_ROWS:
        lines = ", ".join(map(str, kept.rows))
        raise InputError(
            f"{path}: holds {kept.a.size} different contact radii (lines {lines}; {dropped} rows repeat them), "
            f"at least {LEAST_ROWS} are needed: refine the mesh or load to a larger depth"
        )
    for line, a in zip(kept.rows, kept.a, strict=True):
        if a >= indenter.r_max:
            raise InputError(f"{path}: line {line}: contact radius {a:.6g} m lies beyond the end of the indenter's "
                             f"profile, {indenter.r_max:.6g} m; is the unit right?")  # fmt: skip
        if a <= indenter.a0:
            raise InputError(f"{path}: line {line}: contact radius {a:.6g} m must be > {indenter.a0:.6g} m, where "
                             "contact with this indenter begins")  # fmt: skip


def _on_nodes(path: Path, raw: RawSeries, file: Path, unit: str | None) -> RawSeries:
    """The rows with their radii at the nodes of the mesh, whose radii the ``file`` holds, and the elements outside
    these; InputError where a radius is that of no node."""
    table = read_table(file, least=1)
    if table.values.shape[1] != 1:
        raise InputError(f"{file}: must hold one column, radii of nodes, got {table.values.shape[1]}")
    nodes = NAMES.in_si(table, "a", 0, None if table.names and split_name(table.names[0])[1] else unit)
    nodes = np.unique(nodes)
    if nodes.size < LEAST_ROWS or nodes[0] < 0:
        got = f"{nodes.size} different ones" if nodes[0] >= 0 else f"{nodes[0]:.6g} m"
        raise InputError(f"{file}: must hold at least {LEAST_ROWS} radii of nodes, none below 0, got {got}")
    middles = (nodes[1:] + nodes[:-1]) / 2
    nearest = np.searchsorted(middles, raw.a)
    element = np.diff(nodes)[np.minimum(nearest, nodes.size - 2)]
    off = np.abs(raw.a - nodes[nearest]) > NODE_OFF * element
    if (wrong := off & (raw.a > 0)).any():
        i = int(np.argmax(wrong))
        raise InputError(
            f"{path}: line {raw.rows[i]}: contact radius {raw.a[i]:.6g} m is that of no node in {file}, of which the "
            f"nearest has {nodes[nearest[i]]:.6g} m: is the unit right, and are these the nodes of this mesh?"
        )
    return replace(raw, a=np.where(raw.a > 0, nodes[nearest], raw.a), element=element)


def _facts(table: TextTable, chosen: Mapping[str, int], reading: SeriesReading, dropped: int) -> dict[str, Any]:
    return {
        "compared": "yes" if reading.compare else "no",
        "nodes": "from the series" if reading.nodes is None else reading.nodes.name,
        "source": table.path.name,
        "columns": table.listed(chosen),
        "factors": ", ".join(f"{key} = {value:g}" for key, value in reading.factors.items()) or "none",
        "zero_m": reading.zero.get("delta", 0.0),
        "zero_N": reading.zero.get("P", 0.0),
        "radius_from": "column" if "a" in chosen else f"contact area ({reading.area})",
        "separator": table.dialect.separator,
        "rows": int(table.lines.size),
        "dropped": dropped,
    }


# ---------------------------------------------------------------------- contact area
# When an area is the projected one, by the radii that the bodies have at the displacements of the rows.
AREA_APART = 1e-3  # choice: of radii, below which both meanings are the same
AREA_FEWEST = 8  # choice: rows
AREA_LOADS = 0.02  # choice: of loads at equal displacement, up to which the bodies are the right ones
AREA_NEAR = 0.25  # choice: of the difference of both meanings, four standard errors and more on either side


def _radii(
    path: Path, values: dict[str, Array], lines: Array, problem: Problem, reading: SeriesReading
) -> tuple[Array, Literal["surface", "projected"]]:
    """Contact radii [m] from the contact areas [m^2] of the ``values``, and what the areas are; InputError with the
    line where the indenter has no such area."""
    indenter, area = problem.indenter, values.pop("area")
    projected = np.sqrt(np.maximum(area, 0) / math.pi)
    if reading.area == "projected":
        return projected, "projected"
    ends = math.isfinite(indenter.r_max)
    limit = float(surface_area(np.array(indenter.r_max * (1 - 1e-12)), indenter)) if ends else math.inf
    beyond = area > limit
    if beyond.any():
        raise InputError(f"{path}: line {lines[beyond][0]}: contact area {area[beyond][0]:.6g} m^2 is larger than the "
                         f"indenter's surface, {limit:.6g} m^2; is the unit right?")  # fmt: skip
    surface = radius_from_area(np.maximum(area, 0), indenter)
    if reading.area == "auto" and reading.compare and _is_projected(problem, projected, surface, values):
        return projected, "projected"
    return surface, "surface"


def _is_projected(problem: Problem, projected: Array, surface: Array, values: Mapping[str, Array]) -> bool:
    """Whether the radii are the bodies' own at the displacements of the rows if the areas are ``projected``, and not if
    they are those of the ``surface``; nothing is told by bodies that have other loads at these displacements.

    ln(a/a_surface) = share ln(a_projected/a_surface) + lag/a: a mesh reports radii that lag by part of an element.
    """
    from .resolve import own_solution

    delta, P = values["delta"], values["P"]
    rows = (projected > problem.indenter.a0) & (projected < problem.indenter.r_max) & (delta > 0) & (P > 0)
    if rows.sum() < AREA_FEWEST or np.log(projected[rows] / surface[rows]).max() < AREA_APART:
        return False
    own = own_solution(problem, projected[rows])
    if own is None:
        return False
    rows &= (delta > own.delta[0]) & (delta <= own.delta[-1])
    if rows.sum() < AREA_FEWEST:
        return False
    a, x = surface[rows], np.log(delta[rows])
    log_a, log_P = cubic_spline(np.log(own.delta), np.log(np.stack([own.a - own.a0, own.P], axis=1)))(x).T
    if np.median(np.abs(log_P - np.log(P[rows]))) > AREA_LOADS:
        return False

    columns = np.stack([np.log(projected[rows] / a), a[-1] / a], axis=1)
    gap = np.log((own.a0 + np.exp(log_a)) / a)
    (share, lag), *_ = np.linalg.lstsq(columns, gap, rcond=None)
    variance = np.sum((gap - columns @ [share, lag]) ** 2) / (gap.size - 2) * np.linalg.inv(columns.T @ columns)[0, 0]
    return bool(abs(share - 1) < AREA_NEAR and 4 * math.sqrt(variance) < AREA_NEAR)


def surface_area(a: Array, indenter: Indenter) -> Array:
    """Area [m^2] of the indenter's surface within radius ``a`` [m]: 2 pi int_0^a r sqrt(1 + f'^2) dr.

    Closed for the sphere (Eq. A2); else Gauss quadrature over r^2, in which the integrand is smooth.
    """
    a = np.asarray(a, dtype=float)
    if isinstance(indenter, Sphere):
        return 2 * math.pi * a**2 / (1 + np.sqrt(1 - (a / indenter.R) ** 2))
    x, weights = np.polynomial.legendre.leggauss(64)
    square = a[..., None] ** 2 * (x + 1) / 2
    return math.pi * a**2 / 2 * np.sum(weights * np.sqrt(1 + indenter.slope(np.sqrt(square)) ** 2), axis=-1)


def radius_from_area(area: Array, indenter: Indenter) -> Array:
    """Contact radius [m] within which the indenter's surface has the ``area`` [m^2] (sphere: Eq. A3)."""
    area = np.asarray(area, dtype=float)
    if isinstance(indenter, Sphere):
        return np.sqrt((4 * math.pi * indenter.R**2 - area) * area) / (2 * math.pi * indenter.R)
    square = area / math.pi
    for _ in range(100):
        a = np.sqrt(np.minimum(square, indenter.r_max**2))
        change = (surface_area(a, indenter) - area) / (math.pi * np.sqrt(1 + indenter.slope(a) ** 2))
        square = np.maximum(a**2 - change, 0)
        if (np.abs(change) <= 1e-14 * a**2).all():
            break
    return np.sqrt(square)


# --------------------------------------------------------------------------------------------------
# What a device does over time, from a table of two columns.


def read_program(path: Path, dimension: str) -> tuple[Array, Array]:
    """Times [s] and positions [m], or loads [N] where ``dimension`` is "load", of the table at ``path``.

    Its first column is the time, its second what the device holds; names may carry units ("t_ms,x_um"), else SI.
    """
    table = read_table(path, least=2)
    if table.values.shape[1] != 2:
        raise InputError(f"{path}: a program has two columns, time and position, got {table.values.shape[1]}")
    columns = []
    for index, wanted in enumerate(("time", dimension)):
        unit = split_name(table.names[index])[1] if table.names else None
        power = (wanted, 0) if not unit else unit_power(unit)
        if power is None or power[0] != wanted:
            raise InputError(f'{path}: column {index + 1} is to be a {wanted}, got the unit "{unit}"')
        columns.append(table.values[:, index] * 10.0 ** power[1])
    return columns[0], columns[1]
