"""One self-contained page to look at the adhesive curve of a series under any w, modulus, device and zero point."""

from __future__ import annotations

import html
import json
import math
import re
import shlex
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from importlib import resources
from operator import attrgetter
from pathlib import Path
from typing import Any

import numpy as np

from ... import __version__
from ...adhesion.curve import CONTROLS, LOAD_CONTROL, AdhesiveCurve, CriticalPoint, Nonadhesive
from ...adhesion.validity import LIMITS, regime, strains_are_known
from ...base.errors import LEVEL, InputError, Unknown, counted, installs
from ...base.numerics import DRAWN, Array
from ...base.registry import Result
from ...base.units import SI, UNITS, decades, scale
from ...formulas import MEASURED, strained_pull_off
from ...resolve import analysis
from ...resolve.analysis import Analysis, nonadhesive

# --------------------------------------------------------------------------------------------------
# What the page is given: the nonadhesive curve at close radii, from which Eq. 13 gives what the command line says.
#
# With all moduli times s, the curve for w is that of unit modulus for w/s, its loads times s (Eq. 13): delta =
# delta_H - q t, P = s (P_H - q S t), t = sqrt(4 pi a/S'), q = sqrt(w/s). The page needs nothing else.

EVERY = 16  # choice: entries of the table per interval of the series
# tuned on the shipped cases: what cubics between entries change of a pull-off force, relative
TABULATED = 1e-8
COST_PAGE_PER_ROW = 2e-4  # of the explorer's page; tuned on series of 2e4 and 6e4 rows, by `make bench`
WORKS = 9  # works of adhesion at which the page knows the errors of its pull-off points


@dataclass(frozen=True)
class Control:
    """One slider: start value and range in SI, the power of ten and name of the unit it is shown in."""

    value: float
    low: float
    high: float
    logarithmic: bool
    unit: str
    power: int

    @classmethod
    def around(cls, value: float, factor: float, dimension: str, most: float = math.inf) -> Control:
        """The slider from ``value``/``factor`` to ``value`` times ``factor`` or ``most``, evenly in the logarithm."""
        unit, power = _unit(value, dimension)
        return cls(value, value / factor, min(value * factor, most), True, unit, power)

    @classmethod
    def shift(cls, extent: float, dimension: str) -> Control:
        """The slider from -``extent`` to ``extent``, 0 at the start."""
        unit, power = _unit(extent, dimension)
        return cls(0.0, -extent, extent, False, unit, power)


def payload(result: Analysis, measured: Sequence[Any], slopes_option: str = "auto") -> dict[str, Any]:
    """Everything the page shows, as plain lists, numbers and words.

    ``result`` gives the work of adhesion to begin with, which must be > 0; its modulus factor must be 1.
    ``slopes_option``: as asked for on the command line that is reproduced.
    """
    curve, problem, tension = result.jkr, result.problem, result.problem.specimen.surface_tension
    if curve.series.rim < math.inf:
        raise InputError(
            f"{result.path}: explore draws no full end, at which the edge of a flat punch is pinned: jkr cycle"
        )
    shown, total = _thinned(measured)

    # What the CSV file needs beside: the nonadhesive columns, as they were solved and as the slopes' fit sees them
    series, fitted = curve.nonadhesive.series, curve.nonadhesive.points
    columns = {
        "a": series.a, "delta_H": series.delta, "P_H": series.P, "S": fitted.S, "dS": fitted.dS,
        "delta": fitted.delta_H, "P": fitted.P_H,
    }  # fmt: skip

    # The Tabor number at the start's w and modulus, and what it means above each limit; it goes with (w/s)^(2/3)
    tabor, number = None, result.validity.tabor
    if not isinstance(number, Unknown):
        limits = (LIMITS.tabor_jkr, LIMITS.tabor_dmt, 0.0)
        words = [regime(2 * limit if limit else LIMITS.tabor_dmt / 2) for limit in limits]
        tabor = {"number": number, "w": result.w, "limits": [list(pair) for pair in zip(limits, words, strict=True)]}

    # What large strains change of the pull-off force under load control over (w/(E* R))^(1/3) at unit factor, and that
    # number at w = 1 J/m^2; None where it is not known
    strains, R = None, problem.indenter.tip_radius
    if R is not None and strains_are_known(problem):
        sphere, knots = problem.indenter.noun == "sphere", np.linspace(0.0, MEASURED, 31).tolist()
        rows = [[wc, *(strained_pull_off(wc, sphere=sphere) or ())] for wc in knots]
        strains = {"unit": (problem.E_star * R) ** (-1 / 3), "rows": rows, "said": LIMITS.strains_said}
    return {
        "version": __version__,
        "file": shlex.quote(str(result.path)),
        "stem": result.path.stem,
        "options": "" if slopes_option == "auto" else f" --slopes {slopes_option}",
        "title": result.solution.record.title,
        "body": problem.words,
        "method": result.solution.method,
        "slopes": curve.slopes.method,
        "error": result.budget.total,
        "point_errors": _point_errors(replace(curve, nonadhesive=nonadhesive(result.solution, slopes_option)), tension),
        "notes": [*result.solution.warnings, *curve.slopes.flags],
        "table": _table(curve.nonadhesive),
        "every": EVERY,
        "columns": {name: values.tolist() for name, values in columns.items()},
        "band": _band(curve.nonadhesive),
        "level": LEVEL,
        "tabor": tabor,
        "relaxed": _relaxed(result),
        "strains": strains,
        "R": R,
        "tension": tension,
        "angle": LIMITS.edge_angle,
        "controls": {
            name: vars(control)
            for name, control in _controls(curve, measured, tension).items()
            if name != "rest" or _relaxed(result) is not None
        },
        "units": {name: decades(name) for name in ("length", "load", "stiffness", "work")},
        "measured": shown,
        "measured_points": total,
    }


def _point_errors(curve: AdhesiveCurve, tension: float) -> dict[str, list[float | None]]:
    """Relative errors of the pull-off force, which the page reads between rows, over works of adhesion at the case's
    moduli, for each control; those of a machine at the stiffness that its slider begins with. None where contact is not
    lost, or the error not known. ``curve``: of the rows of the series alone."""
    span, stiff = _work_control(curve, tension), _stiffness(curve)
    works = np.geomspace(span.low, span.high, WORKS)
    controls = {**CONTROLS, "machine": stiff}
    rows = []
    for w in works:  # one curve for all controls: what tells its errors is found once
        at_w = replace(curve, w=float(w))
        at_w.find_critical(controls.values())
        row = list[float | None]()
        for stiffness in controls.values():
            point, error = at_w.pull_off(stiffness), None
            if isinstance(point, CriticalPoint):
                errors = analysis.error_of_point(at_w, point, stiffness)
                error = None if isinstance(errors, Unknown) else max(errors["P"] / abs(point.P), TABULATED)
            row.append(error)
        rows.append(row)
    return {"w": works.tolist()} | dict(zip(controls, map(list, zip(*rows, strict=True)), strict=True))


def start_work(body: Nonadhesive) -> float:
    """A work of adhesion [J/m^2] whose pull-off under load control lies a third into the series, two digits."""
    here, rate = body.with_rates(body.a[len(body.a) // 3])
    return float(f"{(rate.P_H / (rate.S * here.t + here.S * rate.t)) ** 2:.1e}")


def _table(body: Nonadhesive) -> dict[str, list[float]]:
    """delta_H, P_H, S and the shift t of w = 1 with their derivatives by the radius, at the rows of the series and at
    radii between them, even in the logarithm of a - a0."""
    a = body.spread(EVERY * (len(body.a) - 1) + 1)
    a[::EVERY] = body.a
    here, rates = body.with_rates(a)
    names = {"delta": "delta_H", "P": "P_H", "S": "S", "t": "t"}
    columns = {key: getattr(here, name) for key, name in names.items()}
    by_a = {f"d{key}": getattr(rates, name) for key, name in names.items()}
    return {name: values.tolist() for name, values in ({"a": a} | columns | by_a).items()}


def _band(body: Nonadhesive) -> dict[str, list[list[float]]] | None:
    """Squares of the half-widths of delta and P at unit modulus, as coefficients of 1, q and q^2 in each row."""
    covariance, quantile = body.slopes.covariance, body.slopes.quantile
    if covariance is None:
        return None
    squares = {}
    for name, (g, h) in body.gradients.items():  # linear in q
        square = [_form(g, covariance, g), 2 * _form(g, covariance, h), _form(h, covariance, h)]
        squares[name] = (quantile**2 * np.array(square)).tolist()
    return squares


def _form(left: Array, matrices: Array, right: Array) -> Array:
    return np.einsum("ni,nij,nj->n", left, matrices, right)


def _relaxed(result: Analysis) -> float | None:
    """The relaxed over the instantaneous modulus of a viscoelastic specimen that comes to rest; None for any other."""
    law = result.problem.specimen.relaxation
    return (None if law is None else law.relaxed) or None


def _controls(curve: AdhesiveCurve, measured: Sequence[Any], tension: float) -> dict[str, Control]:
    """The sliders; that of w ends where a surface ``tension`` [N/m] leaves no contact angle."""
    # Distance from the smallest to the largest measured value; 0 where there is none.
    spans = {
        name: max(
            (float(np.ptp(values)) for curve in measured if (values := getattr(curve, name)) is not None), default=0
        )
        or float(np.ptp(getattr(curve, name)))
        for name in ("delta", "P")
    }
    return {
        "w": _work_control(curve, tension),
        "factor": Control.around(1.0, 10, "number"),
        "stiffness": Control.around(_stiffness(curve), 1000, "stiffness"),
        "delta0": Control.shift(spans["delta"] / 2, "length"),
        "P0": Control.shift(spans["P"] / 2, "load"),
        "rest": Control.shift(spans["P"] / 2, "load"),
    }


def _work_control(curve: AdhesiveCurve, tension: float) -> Control:
    return Control.around(curve.w, 30, "work", 2 * tension or math.inf)


def _stiffness(curve: AdhesiveCurve) -> float:
    """The contact's own stiffness [N/m] at pull-off under load, one digit."""
    point = curve.pull_off(LOAD_CONTROL)
    a = point.a if isinstance(point, CriticalPoint) else float(np.median(curve.a))
    return float(f"{np.interp(a, curve.a, curve.slopes.S):.0e}")


def _unit(value: float, dimension: str) -> tuple[str, int]:
    if dimension not in UNITS:
        return SI[dimension], 0
    factor, unit = scale(value, dimension)
    return unit, round(math.log10(factor))


def _thinned(measured: Sequence[Any]) -> tuple[list[dict[str, Any]], int]:
    """The measured curves with every so many rows left out, and how many rows there were."""
    total = sum(map(len, measured))
    every = max(1, math.ceil(total / DRAWN))
    shown = []
    for curve in measured:
        rows = curve.rows(np.arange(0, len(curve), every))
        columns = {
            name: None if (c := getattr(rows, name)) is None else c.tolist() for name in ("a", "delta", "P", "segment")
        }
        shown.append({"name": curve.name, **columns})
    return shown, total


# --------------------------------------------------------------------------------------------------
# The page as one text: template, style, scripts, plotting library and data, with nothing left to load; and what was
# written of it, in words and as JSON.

SCRIPTS = ("curve.js", "controls.js", "plots.js", "page.js")


def page(content: Mapping[str, Any]) -> str:
    """The HTML of ``content`` (see ``payload``); InputError where the plotting library is missing."""
    try:
        from plotly.offline import get_plotlyjs
    except ImportError:
        raise InputError(f"explore: needs the optional package plotly: {installs('explore')}") from None
    # JSON that cannot end the element it stands in.
    parts = {
        "title": html.escape(f"{content['stem']}: {content['body']}"),
        "style": _own("page.css"),
        "library": get_plotlyjs(),
        "content": json.dumps(content, allow_nan=False, separators=(",", ":"), default=attrgetter("reason"))
        .replace("<", "\\u003c")
        .replace("\u2028", "\\u2028")
        .replace("\u2029", "\\u2029"),
        "script": "\n".join(map(_own, SCRIPTS)),
        "mark": f"<!-- jkr {__version__} -->",
    }
    return re.sub(r"\{\{(\w+)\}\}", lambda place: parts[place[1]], _own("page.html"))


def _own(name: str) -> str:
    return resources.files(__package__).joinpath(name).read_text(encoding="utf-8")


@dataclass(frozen=True)
class Explored(Result):
    """The ``page`` of the series in ``file``, of so many ``rows``, that begins with ``w`` [J/m^2], and what was laid
    over it."""

    file: Path
    page: Path
    w: float
    rows: int
    curves: int
    measured_rows: int

    @property
    def size(self) -> int:
        """Bytes of the page."""
        return self.page.stat().st_size

    def summary(self) -> dict[str, Any]:
        written = {"file": str(self.file), "page": str(self.page), "bytes": self.size, "w_J_per_m2": self.w}
        return written | {"measured_curves": self.curves, "measured_points": self.measured_rows}

    def words(self) -> list[str]:
        overlaid = (
            f", {counted(self.measured_rows, 'measured point')} in {counted(self.curves, 'curve')}"
            if self.curves
            else ""
        )
        return [
            f"{self.rows} points{overlaid}: {self.file}",
            f"  written {self.page} ({self.size / 1e6:.1f} MB): open it in a browser",
        ]


__all__ = ["Explored", "page", "payload", "start_work"]
