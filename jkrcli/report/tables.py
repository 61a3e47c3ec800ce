"""Adhesive curves as CSV, summaries as JSON and words: the interfaces that scripts rely on."""

import contextlib
import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np

from ..adhesion import device_path
from ..adhesion.curve import CONTROLS, AdhesiveCurve, CriticalPoint, Equilibrium, EquilibriumCurve, control
from ..adhesion.device_path import Jump, Stability, TimedState, branch
from ..adhesion.pull_off_error import Errors
from ..adhesion.validity import LIMITS, Strains, Validity, strain_size, strain_words
from ..base import process
from ..base.errors import AT_LEVEL, LEVEL, Estimate, InputError, Unknown, accuracy, counted, known
from ..base.files import read_bytes
from ..base.numerics import Array
from ..base.process import REMEMBERED, check_text
from ..base.registry import SUMMARIES, TABLES, WORDS
from ..base.units import SI, deviation, show
from ..bodies.problem import Elastic, Problem, Rigid
from ..formulas import foundation_modulus, scales_half_space, scales_thin_layer
from ..resolve.analysis import Analysis, is_solved_at
from ..resolve.sticking import sticking

SUMMARY_FORMAT, SUMMARY_VERSION = "jkr-summary", 1  # type and version of the JSON
PRINTED = 1e-4  # choice: relative error from which each force is printed with its own
SEEN = 0.01  # choice: of the model's error, from which on the numerical one is said beside it
WORD_COLUMNS = ("branch",)  # of a curve; all others are numbers
DIMENSIONS = {  # of quantities by their names
    **dict.fromkeys(("delta", "a", "c", "at", "position"), "length"),
    **dict.fromkeys(("P", "offset", "noise", "waviness", "step"), "load"),
    "t": "time", "w": "work", "E_star": "modulus", "speed": "speed", "tilt": "stiffness", "rows": "number",
}  # fmt: skip


def transpose_rows(rows: Sequence[Mapping[str, Any]]) -> dict[str, list[Any]]:
    """The table of ``rows``, each by the names of its cells, by columns; None where a row has no such cell."""
    return {name: [row.get(name) for row in rows] for name in dict.fromkeys(name for row in rows for name in row)}


def stacked(tables: Sequence[Mapping[str, Iterable[Any]]]) -> dict[str, list[Any]]:
    """Tables with the same columns, lists or arrays, below each other."""
    plain = [{name: cells.tolist() if isinstance(cells, np.ndarray) else cells for name, cells in table.items()}
             for table in tables]  # fmt: skip
    return {name: [cell for table in plain for cell in table[name]] for name in tables[0]}


@lru_cache(maxsize=REMEMBERED)
def with_unit(name: str, dimension: str) -> str:
    """The name of a column or key with its SI unit: ``w_J_per_m2``."""
    return f"{name}_{SI[dimension].replace('/', '_per_').replace('^', '')}".rstrip("_")


def quantities(source: Any, names: str) -> dict[str, Any]:
    """The quantities of a ``source`` that are called ``names`` by their keys: ``P_N``, ``delta_m``, ``a_m``."""
    return {with_unit(name, DIMENSIONS[name]): getattr(source, name) for name in names.split()}


def size_words(judged: Validity, sizes: Mapping[str, str]) -> list[str]:
    """``a/h = 0.3`` of each of the ``sizes``, by their names, that the body has."""
    values = ((name, getattr(judged, key)) for name, key in sizes.items())
    return [f"{name} = {value:.3g}" for name, value in values if isinstance(value, float)]


def format_state(state: Any, names: str = "P delta a") -> str:
    """The numbers of a ``state`` that are called ``names``: ``P = 1 mN, delta = 2 um, a = 3 um``."""
    return ", ".join(f"{name} = {show(getattr(state, name), DIMENSIONS[name])}" for name in names.split())


def curve_columns(curve: EquilibriumCurve) -> dict[str, Array]:
    """The columns of the CSV file by name; later versions may add columns after these."""
    columns = dict(curve.columns)
    attracted = {name: columns.pop(name) for name in ("c_m",) if name in columns}
    if curve.errors:
        columns |= {"P_err_N": curve.errors["P"], "delta_err_m": curve.errors["delta"]}
        attracted["level"] = np.full(curve.P.size, LEVEL)
    return columns | {"branch": branch(curve)} | attracted


def read_curve(path: Path) -> dict[str, Array]:
    """The columns of numbers in the CSV file of a curve; InputError with the line where a row is wrong."""
    text = read_bytes(path, "curve", process.TEXT).decode("utf-8", errors="replace")
    check_text(path, text)
    lines = text.splitlines()
    names = lines[0].split(",") if lines else []
    if names[:1] != ["a_m"]:
        raise InputError(f'{path}: line 1 must be the header "a_m,delta_m,P_N,...", got "{(lines or [""])[0][:40]}"')
    numeric = [name for name in names if name not in WORD_COLUMNS]
    columns = [i for i, name in enumerate(names) if name not in WORD_COLUMNS]
    table = np.empty((0, 0))
    if len(lines) > 1 and all(line.count(",") == len(names) - 1 for line in lines[1:]):
        with contextlib.suppress(ValueError):  # numpy's reader, ten times as fast
            table = np.loadtxt(lines[1:], delimiter=",", comments=None, usecols=columns, ndmin=2, unpack=True)
    if table.shape[1] != len(lines) - 1 or not np.isfinite(table).all():  # a line needs a closer look
        table = np.array([_row(path, number, line, names) for number, line in enumerate(lines[1:], start=2)]).T
    if len(lines) < 3:
        raise InputError(f"{path}: holds {counted(len(lines) - 1, 'row')}, at least 2 are needed")
    along = "c_m" if "c_m" in numeric else "a_m"
    steps = np.diff(table[numeric.index(along)])
    if (steps <= 0).any():
        raise InputError(f"{path}: line {int(np.argmax(steps <= 0)) + 3}: {along} must increase from row to row")
    return dict(zip(numeric, table, strict=True))


def _row(path: Path, number: int, line: str, names: list[str]) -> list[float]:
    """The numbers of a line."""
    with contextlib.suppress(ValueError):
        row = [float(cell) for name, cell in zip(names, line.split(","), strict=True) if name not in WORD_COLUMNS]
        if np.isfinite(row).all():
            return row
    wanted = sum(name not in WORD_COLUMNS for name in names)
    raise InputError(f'{path}: line {number} must hold {wanted} finite numbers, got "{line[:60]}"')


def summary(result: Analysis) -> dict[str, Any]:
    """What stands in the JSON file beside a curve."""
    # The warnings ask for all that is read off the curve
    warnings, path, dropped, surface = result.warnings, result.path, result.dropped, result.problem.surface
    slopes, comparison, judged = result.curve.slopes, result.comparison, validity(result)
    return {
        "format": SUMMARY_FORMAT,
        "version": SUMMARY_VERSION,
        "file": str(path),
        "title": result.solution.record.title,
        "level": LEVEL,
        "w_J_per_m2": result.w,
        **law(result),
        "modulus_factor": result.modulus_factor,
        "method": result.solution.method,
        "surface": surface,
        "slopes": slopes.method,
        "slopes_reason": slopes.reason,
        "smoothing_lambda": slopes.smoothing_lambda,
        "points": {"kept": len(result.curve.series), "dropped": dropped},
        "pull_off": {
            name: point(place) | errors(result.pull_off_errors.get(name)) | strains(result.large_strains(place))
            for name, place in result.pull_off.items()
        },
        "stability": {k: under_control(device_path.stability_under(result.curve, CONTROLS[k])) for k in CONTROLS},
        "tabor": judged["tabor"],
        "validity": judged,
        "errors": result.budget.as_dict() | {"between_rows": result.curve.interpolation_error},
        "comparison": None if comparison is None else {
            "reference": "closed form of the same indenter on a half-space",
            "load": comparison.load,
            "pull_off": known(comparison.pull_off),
            "curve": known(comparison.curve),
            "sphere_against_parabola": comparison.parabola,
        },
        "warnings": warnings,
    }  # fmt: skip


def law(result: Analysis) -> dict[str, Any]:
    """Tension and range of adhesion of finite range, what w is by on rough surfaces, and the shape of a contact that is
    no disc; nothing for smooth JKR of discs."""
    rough = {} if result.rough is None else result.rough.summary()
    if result.shape is not None:
        rough["contact_shape"] = result.shape.summary()
    return rough | ({} if result.law is None else {"stress_Pa": result.law.stress, "range_m": result.law.length})


def law_words(result: Analysis) -> str:
    """Tension and range of adhesion of finite range, to follow w in a sentence; empty for JKR."""
    if result.law is None:
        return ""
    return f", stress {show(result.law.stress, 'modulus')} up to {show(result.law.length, 'length')}"


def digits(value: float, change: Strains, known_to: float = 0.0) -> int:
    """How many digits of a ``value`` are worth showing that large strains ``change``, by a tenth where that is unknown,
    and that is ``known_to`` a relative error: to the second of the larger one."""
    error = abs(value) * max(0.1 if isinstance(change, Unknown) else strain_size(change), known_to)
    return 4 if error == 0 else min(max(math.floor(math.log10(abs(value))) - math.floor(math.log10(error)) + 2, 2), 4)


def error_words(error: Estimate, change: Strains, name: str = "numerical error") -> str:
    """The relative ``error`` called ``name``, and the model's: what large strains ``change``, far larger or not."""
    if change is None:
        return f"{accuracy(error, name)} ({AT_LEVEL} confidence)"
    seen = isinstance(error, Unknown) or error > SEEN * strain_size(change)
    numerical = f"{accuracy(error, name)} ({AT_LEVEL} confidence)" if seen else f"the {name} is far below that"
    return f"{strain_words(change)} (model); {numerical}"


def strains(change: Strains) -> dict[str, Any]:
    """What large strains change of a pull-off force, relative: the least and the largest, or null and the reason."""
    if isinstance(change, Unknown):
        return {"large_strains": None, "large_strains_reason": change.reason}
    return {} if change is None else {"large_strains": list(change)}


def format_pull_off(
    result: Analysis, points: Mapping[str, tuple[Equilibrium | Unknown, Errors | Unknown | None]]
) -> list[str]:
    """The verdict on a curve: its pull-off force under each control, ``points`` with their half-widths; then the
    numerical error of each, of one number where all are far below what is read off; what w is by on rough surfaces,
    and what is known of a contact that is no disc."""
    there = {name: (at, half) for name, (at, half) in points.items() if not isinstance(at, Unknown) and at.P}
    errors = {
        name.removesuffix(" control"): half["P"] / abs(at.P)
        for name, (at, half) in there.items()
        if half and not isinstance(half, Unknown)
    }
    noticed = bool(errors) and max(errors.values()) >= PRINTED
    forces_at = {name.removesuffix(" control"): at for name, (at, _) in there.items()}
    changes = {name: result.large_strains(at) for name, at in forces_at.items()}
    places = {name: digits(at.P, changes[name], errors.get(name, 0.0)) for name, at in forces_at.items()}
    forces = ", ".join(
        f"{show(-at.P, 'load', places[name])}"
        f"{f' ± {percent(errors[name])}' if noticed and name in errors else ''} ({name})"
        for name, at in forces_at.items()
    )
    verdict = f"pull-off force {forces}" if there else "no pull-off in the solution"
    R, loaded, effect = result.problem.indenter.tip_radius, there.get("load control"), result.effect_of_range
    if loaded is not None and not isinstance(effect, Unknown) and abs(effect) >= LIMITS.wrong:
        z0 = result.solution.record.z0
        ranged = show(-loaded[0].P * (1 + effect), "load", 3)
        beside = f" by JKR; {ranged} (load) with a range of {show(z0, 'length')}"
    elif R is not None and loaded is not None:
        classical = 1.5 * math.pi * result.w * R
        # The difference of the numbers that are printed, no finer than they are
        force, at_digits = -loaded[0].P, places["load"]
        step = 10.0 ** (math.floor(math.log10(abs(force))) + 1 - at_digits) / abs(force)
        difference = float(f"{classical:.4g}") / float(f"{force:.{at_digits}g}") - 1
        difference = round(difference, -math.floor(math.log10(step)))
        words = deviation(difference) if abs(difference) > PRINTED else "the same"
        words = f"{1 + difference:.2g} times as large" if difference > 1 else words
        beside = f"; 1.5 pi w R = {show(classical, 'load')} ({words})"
    else:
        beside = ""
    lines = [f"{verdict} at w = {show(result.w, 'work')}{law_words(result)}{beside}: {result.path}"]
    change, name = max(changes.values(), key=strain_size, default=None), result.problem.indenter.error_name
    if noticed and len(errors) > 1:
        each = ", ".join(f"{percent(error)} ({name})" for name, error in errors.items())
        model = "" if change is None else f"{strain_words(change)} (model), "
        lines.append(f"  pull-off: {model}{name} {each} ({AT_LEVEL} confidence)")
    elif noticed or (errors and change is not None):
        lines.append(f"  pull-off: {error_words(max(errors.values()), change, name)}")
    elif unknown := dict.fromkeys(half.reason for _, half in there.values() if isinstance(half, Unknown)):
        lines.append(f"  pull-off: {name} {'; '.join(unknown)}")
    lines += [] if result.rough is None else [f"  {line}" for line in result.rough.words()]
    return lines + ([] if result.shape is None else [f"  {result.shape.words()} (model)"])


def percent(error: float) -> str:
    """A relative error of two digits."""
    return f"{float(f'{100 * error:.2g}'):g} %"


def point(state: Equilibrium | Unknown) -> dict[str, Any]:
    """A critical point or state by its columns; all None with the reason where it lies outside the series."""
    if isinstance(state, Unknown):
        return {"P_N": None, "delta_m": None, "a_m": None, "reason": state.reason}
    return quantities(state, "P delta a" if state.c is None else "P delta a c")


def errors(half_widths: Errors | Unknown | None) -> dict[str, Any]:
    """The half-widths beside a point; None with the reason where they are unknown, nothing where there is no point."""
    if half_widths is None:
        return {}
    if isinstance(half_widths, Unknown):
        return {"P_err_N": None, "delta_err_m": None, "error": half_widths.reason}
    return {"P_err_N": half_widths["P"], "delta_err_m": half_widths["delta"]}


def validity(result: Analysis, *points: CriticalPoint | Unknown) -> dict[str, Any]:
    """The numbers by which the result is judged, with pull-off at ``points``, else under load control."""
    return vars(result.validity_at(*points) if points else result.validity)


def is_refined(curve: EquilibriumCurve, point: Equilibrium) -> bool:
    """Whether the ``point`` was solved at its own radius, and is not one between rows; each of finite range was."""
    at_rim = point.a == curve.series.rim
    return not isinstance(curve, AdhesiveCurve) or at_rim or is_solved_at(curve.nonadhesive, point.a)


def under_control(behaviour: Stability) -> dict[str, Any]:
    """Everything that is read off a curve under one control; a null with its reason where there is no number."""
    return {
        "critical_points": [{"kind": item.kind, **point(item)} for item in behaviour.critical],
        "pull_off": point(behaviour.pull_off),
        **({} if behaviour.lost is None else {"contact_lost": point(behaviour.lost)}),
        "jump_in": point(behaviour.jump_in),
        "jumps_before_pull_off": [jump(item) for item in behaviour.partial],
        **energies(
            energy_lost=(behaviour.energy_lost, behaviour.energy_lost_error),
            work_of_separation=(behaviour.separation, behaviour.separation_error),
        ),
    }


def jump(event: Jump) -> dict[str, Any]:
    """A jump between two states; "to" is null where contact is lost."""
    return {"from": point(event.start), "to": None if event.end is None else point(event.end)}


def timed(state: TimedState) -> dict[str, Any]:
    """A state and its time."""
    return point(state) | quantities(state, "t")


def timed_jump(event: Jump) -> dict[str, Any]:
    """A jump and its time."""
    return quantities(event, "t") | jump(event)


def device(k: float) -> dict[str, Any]:
    """The control that a device of stiffness ``k`` [N/m] exerts, and its stiffness."""
    return {"control": control(k), "stiffness_N_per_m": stiffness(k)}


def stiffness(k: float) -> float | None:
    """The stiffness of a device [N/m]; None for a rigid one, as JSON has no infinity."""
    return None if k == CONTROLS["displacement"] else k


def energies(**values: tuple[Estimate, Estimate]) -> dict[str, Any]:
    """Energies [J] by their names with their half-widths, each null with its reason where there is none."""
    columns: dict[str, Any] = {}
    for name, (energy, error) in values.items():
        if isinstance(energy, Unknown):
            columns |= {f"{name}_J": None, f"{name}_reason": energy}
            continue
        columns |= {f"{name}_J": energy, f"{name}_err_J": None if isinstance(error, Unknown) else error}
        if isinstance(error, Unknown):
            columns[f"{name}_error"] = error
    return columns


def energy_words(energy: Estimate, error: Estimate) -> str:
    """``12.43 fJ ± 0.2 %``; without the error where it is unknown, its bound where it does not reach four digits."""
    if isinstance(energy, Unknown):
        return f"unknown: {energy}"
    words = show(energy, "energy")
    if isinstance(error, Unknown) or energy == 0:
        return words
    relative = error / abs(energy)
    return words + (f" ± {percent(relative)}" if relative > PRINTED else f" (error < {percent(PRINTED)})")


def cycle_title(how: str, approach: float, retraction: float, *more: str) -> str:
    """Of the picture of a cycle: ``how`` the device goes, the works of adhesion [J/m^2], and below them what is
    ``more``."""
    back = "" if approach == retraction else f" on approach, {show(retraction, 'work')} on retraction"
    second = "; ".join(filter(None, more))
    adhesion = f"w = {show(approach, 'work')}{back}" if max(approach, retraction) > 0 else "no adhesion"
    return f"{how}, {adhesion}" + (f"\n{second}" if second else "")


# --------------------------------------------------------------------------------------------------
# Units of an adhesive curve on axes, and those that make it dimensionless: Eq. 15, Eq. 19, or the user's own.


@dataclass(frozen=True)
class Scales:
    """What P [N], delta [m] and a [m] are divided by, and the labels of (delta, P, a) on axes."""

    name: str
    P: float
    delta: float
    a: float
    labels: tuple[str, str, str]

    def label(self, name: str) -> str:
        """The label of the axis of "delta", "P" or "a"."""
        return self.labels[("delta", "P", "a").index(name)]

    def columns(self, result: Analysis) -> dict[str, Array]:
        """The curve without dimensions, with Eq. 15 as units: Eq. 16."""
        columns = result.curve.columns
        return {
            "a_bar": columns["a_m"] / self.a,
            "delta_bar": columns["delta_m"] / self.delta,
            "P_bar": columns["P_N"] / self.P,
            "delta_H_bar": columns["delta_H_m"] / self.delta,
            "P_H_bar": columns["P_H_N"] / self.P,
        }


def scales_of(problem: Problem, w: float, name: str) -> Scales:
    """The scales of Eq. 15 ("half-space") or Eq. 19 ("thin-layer") for a body and ``w`` [J/m^2]."""
    R = problem.indenter.tip_radius
    if R is None or w == 0:
        raise InputError("--dimensionless: needs an indenter with a tip radius and w > 0")
    if name == "half-space":
        P, delta, a = scales_half_space(R, problem.E_star, w)
        return Scales(name, P, delta, a, (r"$\delta / \delta_0$ (Eq. 15)", r"$P / (\pi w R)$", "$a / a_0$ (Eq. 15)"))
    layers, base = problem.specimen.layers, problem.specimen.base
    material = layers[0].material if len(layers) == 1 and isinstance(base, Rigid) and base.bonded else None
    if not isinstance(material, Elastic) or material.nu >= 0.5:
        raise InputError(
            "--dimensionless thin-layer: needs one homogeneous isotropic layer with nu < 0.5, bonded to a rigid "
            "substrate (Eq. 22)"
        )
    K = foundation_modulus(material.E, material.nu, layers[0].thickness)
    P, delta, a = scales_thin_layer(R, K, w)
    return Scales(name, P, delta, a, (r"$\delta / \sqrt{2 w/K}$", r"$P / (2 \pi w R)$", r"$a / (8 w R^2/K)^{1/4}$"))


def own_scales(values: Mapping[str, float]) -> Scales:
    """The user's own scales: all of a, delta [m] and P [N], each > 0."""
    for key in ("a", "delta", "P"):
        if not (key in values and np.isfinite(values[key]) and values[key] > 0):
            raise InputError(f"--scale: needs a, delta and P, each > 0, got {key} = {values.get(key, 'nothing')}")
    return Scales("own", values["P"], values["delta"], values["a"], (r"$\delta / \delta_0$", "$P / P_0$", "$a / a_0$"))


# --------------------------------------------------------------------------------------------------
# What is said of one adhesive curve: its table, summary and words.


@TABLES.register(Analysis)
def curve_table(curve: Analysis, scales: Scales | None = None, points: int | None = None) -> dict[str, Array]:
    """The columns of an adhesive curve, with those in units of ``scales``, at its radii or at so many ``points``, there
    with the error between the radii; InputError where that is unknown."""
    between = dict[str, Array]()
    if points is not None:
        rows = curve.curve
        if not isinstance(rows, AdhesiveCurve):
            raise InputError(f"{curve.path}: --points is of curves without range: leave it, or stress and range, out")
        curve = replace(curve, curve=AdhesiveCurve(rows.nonadhesive.resampled(points), curve.w))
        if isinstance(errors := rows.interpolation_at(curve.curve.a), Unknown):
            raise InputError(f"{curve.path}: --points: the error between its points is {errors}: solve more of them")
        between = errors
    columns = curve_columns(curve.curve) | ({} if scales is None else scales.columns(curve))
    for name, key in (("P_err_N", "P"), ("delta_err_m", "delta")) if between else ():
        columns[name] = np.hypot(columns[name], between[key])
    if curve.rough is not None:
        works = {"w_J_per_m2": curve.w, "w_smooth_J_per_m2": curve.rough.w}
        columns |= {name: np.full(curve.curve.P.size, w) for name, w in works.items()}
    return columns


@SUMMARIES.register(Analysis)
def curve_summary(curve: Analysis, scales: Scales | None = None) -> dict[str, Any]:
    """Pull-off, errors, validity and warnings of an adhesive curve; ``scales``: of more columns."""
    said = summary(curve) | {"sticking": sticking(curve.sticking)}
    return said | ({} if scales is None else {"scales": {"name": scales.name} | quantities(scales, "P delta a")})


@WORDS.register(Analysis)
def curve_words(curve: Analysis) -> list[str]:
    """Where contact is lost, what the numbers are worth, what an exact solution says."""
    errors = curve.pull_off_errors
    points = {f"{name} control": (point, errors.get(name)) for name, point in curve.pull_off.items()}
    return [*format_pull_off(curve, points), *(f"  {line}" for line in _of_curve(curve))]


def _of_curve(result: Analysis) -> Iterator[str]:
    for name, point in result.pull_off.items():
        if isinstance(point, CriticalPoint):
            between = "" if is_refined(result.curve, point) else "; interpolated"
            P = show(point.P, "load", digits(point.P, result.large_strains(point)))
            yield (
                f"{name + ' control':<21} P = {P:<11} delta = {show(point.delta, 'length'):<12} "
                f"a = {show(point.a, 'length')}{between}"
            )
        elif result.w > 0:
            yield f"{name + ' control':<21} not in the solution (see the warning)"
    if words := result.validity.verdict:
        yield words
    if (comparison := result.comparison) is not None:
        parts = [f"P_H(delta) within {comparison.load:.2e}"]
        if not isinstance(comparison.pull_off, Unknown):
            parts.append(f"pull-off force {comparison.pull_off:+.2e}")
        if not isinstance(comparison.curve, Unknown):
            parts.append(f"adhesive curve within {comparison.curve:.2e}")
        yield f"against the closed form of the same indenter: {', '.join(parts)}"
        if comparison.parabola is not None:
            yield (
                f"the pull-off force of a sphere is {comparison.parabola:.2%} smaller than 1.5 pi w R of the "
                "paraboloid (Eq. 18): physics, no error"
            )
    budget, slopes = result.budget, result.curve.slopes
    largest, name = result.curve.interpolation_error, result.problem.indenter.error_name
    yield f"curve: {accuracy(budget.total, name)}; {accuracy(largest, 'interpolation error')}"
    if slopes.method != "exact" or result.dropped:
        yield (
            f"slopes {slopes.method} ({slopes.reason}), {accuracy(budget.smoothing, 'error')}; "
            f"{counted(len(result.curve.series), 'point')}, {result.dropped} dropped"
        )
