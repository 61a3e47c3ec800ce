"""What a sweep can tell of a case: the numbers of the summary that ``jkr transform`` writes, by the same names."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from ...adhesion import DISPLACEMENT_CONTROL, AdhesiveCurve, Equilibrium, behaviour
from ...base import InputError, Unknown, did_you_mean
from ...beside import Analysis, with_solved_points
from ...report import tables

Value = float | int | str
Section = Callable[[Analysis], Mapping[str, Any]]
POINT = ("P_N", "delta_m", "a_m")
ERROR = ("P_err_N", "delta_err_m")


def _solved_by(result: Analysis) -> dict[str, Any]:
    return {"method": result.solution.method, "slopes": result.curve.slopes.method}


def _at_end(result: Analysis) -> dict[str, Any]:
    series = result.curve.series
    return {"points": len(series), "a_m": series.a[-1], "delta_H_m": series.delta[-1], "P_H_N": series.P[-1]}


def _pull_off(result: Analysis) -> dict[str, Any]:
    load, displacement = (_point(name, result.pull_off[name]) for name in ("load", "displacement"))
    return load | displacement | {"load.over_pi_w_R": _ratio(result)}


def _ratio(result: Analysis) -> float | Unknown:
    """The pull-off force under load control as -P/(pi w R): 3/2 on a half-space."""
    point, R = result.pull_off["load"], result.problem.indenter.tip_radius
    if isinstance(point, Unknown):
        return point
    return Unknown("the indenter has no tip radius") if R is None else -point.P / (math.pi * result.w * R)


def _point(name: str, state: Equilibrium | Unknown) -> dict[str, Any]:
    columns = tables.point(state)
    return {f"{name}.{key}": Unknown(columns["reason"]) if columns[key] is None else columns[key] for key in POINT}


def _point_errors(result: Analysis) -> dict[str, Any]:
    """Half-widths of P and delta of each pull-off point, or why there are none."""
    errors: dict[str, Any] = {}
    for name, point in result.pull_off.items():
        error = point if isinstance(point, Unknown) else result.pull_off_errors[name]
        for key, quantity in zip(ERROR, ("P", "delta"), strict=True):
            errors[f"{name}.{key}"] = error if isinstance(error, Unknown) else error[quantity]
    return errors


def _stability(result: Analysis) -> dict[str, Any]:
    pulled = behaviour(result.curve, DISPLACEMENT_CONTROL)
    energies = {"energy_lost_J": pulled.energy_lost, "work_of_separation_J": pulled.separation}
    return energies | _point("jump_in", pulled.jump_in)


def _errors(result: Analysis) -> dict[str, Any]:
    return result.budget.as_dict()


def _comparison(result: Analysis) -> dict[str, Any]:
    return {"pull_off": result.comparison.pull_off if result.comparison else Unknown("")}


def _of_both(keys: Sequence[str]) -> Iterator[str]:
    """The names of the ``keys`` under control of load and of displacement."""
    return (f"{control}.{key}" for control in ("load", "displacement") for key in keys)


VALIDITY = ("tabor", "a_over_R", "a_over_R_pull_off", "delta_over_h", "a_over_h", "a_over_L")
SECTIONS: dict[str, tuple[Section, tuple[str, ...]]] = {
    "solved_by": (_solved_by, ("method", "slopes")),
    "contact": (lambda result: {"E_star_Pa": result.problem.E_star}, ("E_star_Pa",)),
    "end": (_at_end, ("points", "a_m", "delta_H_m", "P_H_N")),
    "pull_off": (_pull_off, (*_of_both(POINT), "load.over_pi_w_R")),
    "pull_off_errors": (_point_errors, tuple(_of_both(ERROR))),
    "stability": (_stability, ("energy_lost_J", "work_of_separation_J", *(f"jump_in.{key}" for key in POINT))),
    "validity": (tables.validity, VALIDITY),
    "errors": (_errors, ("discretisation", "truncation", "radius", "smoothing", "total")),
    "comparison": (_comparison, ("pull_off",)),
}
NAMES = tuple(f"{section}.{key}" for section, (_, keys) in SECTIONS.items() for key in keys)
NEED_W = ("pull_off", "pull_off_errors", "stability")
OF_THE_KIND = ("validity.", "comparison.")  # absent by the kind of body, the same in every case: no reason is given
ALONG = ("P_N", "delta_m", "P_H_N", "delta_H_m", "S_N_per_m", "dS_da_N_per_m2")


@dataclass(frozen=True)
class Wanted:
    """The columns of a sweep's table: ``names`` among ``NAMES``; all of ``ALONG`` at each of ``radii`` [m]; the
    pull-off by devices of each ``stiffness`` [N/m]. ``slopes``: how S and S' are found."""

    names: tuple[str, ...]
    radii: tuple[float, ...] = ()
    stiffness: tuple[float, ...] = ()
    slopes: str = "auto"
    columns: tuple[str, ...] = field(init=False)

    def __post_init__(self) -> None:
        devices = [f"pull_off.{k:g}_N_per_m.{key}" for k in self.stiffness for key in POINT]
        along = [f"at_{a:g}_m.{key}" for a in self.radii for key in ALONG]
        object.__setattr__(self, "columns", (*self.names, *devices, *along))

    @property
    def needs_w(self) -> bool:
        """Whether any column means nothing without a work of adhesion."""
        return bool(self.stiffness) or any(name.split(".")[0] in NEED_W for name in self.names)

    def values(self, result: Analysis) -> list[Value | Unknown]:
        """One value per column."""
        result = with_solved_points(result, *self.stiffness) if self.stiffness else result
        told: dict[str, Any] = {}
        for section in dict.fromkeys(name.split(".")[0] for name in self.names):
            told |= {f"{section}.{key}": value for key, value in SECTIONS[section][0](result).items()}
        values = [_value(name, told[name]) for name in self.names]
        for k in self.stiffness:
            values += _point("device", result.curve.pull_off(k)).values()
        return [*values, *_along(result.jkr, self.radii)]


def _value(name: str, value: Any) -> Value | Unknown:
    """A number or word, or why there is none."""
    if isinstance(value, Unknown):
        return Unknown("") if name.startswith(OF_THE_KIND) else value
    if isinstance(value, int | str):
        return value
    return float(value) if math.isfinite(value) else Unknown(f"{name} is not finite")


def _along(curve: AdhesiveCurve, radii: Sequence[float]) -> Iterator[Value | Unknown]:
    """``ALONG`` of the curve at each of the contact radii [m]; index H: without adhesion."""
    a = np.array(radii)
    beyond = curve.beyond(a)
    delta, P = curve.at(a[~beyond])
    delta_H, P_H, S, dS, _ = curve.nonadhesive.parts(a[~beyond])
    rows = iter(np.stack([P, delta, P_H, delta_H, S, dS], axis=1).tolist())
    for place, out in zip(radii, beyond.tolist(), strict=True):
        yield from [Unknown(curve.beyond_words(place))] * len(ALONG) if out else next(rows)


def names_of(words: Sequence[str], source: str) -> tuple[str, ...]:
    """All names that the ``words`` mean, those of groups ("pull_off", "pull_off.load") each; InputError for others."""
    names: dict[str, None] = {}
    for word in words:
        meant = [name for name in NAMES if name == word or name.startswith(f"{word}.")]
        if not meant:
            hint = did_you_mean(word, [*SECTIONS, *NAMES])
            raise InputError(
                f'{source}: outputs.quantities: unknown quantity "{word}"{hint} (groups: {", ".join(SECTIONS)}; '
                f"single ones: {', '.join(NAMES)})"
            )
        names |= dict.fromkeys(meant)
    return tuple(names)
