"""One self-contained page to click through the curves of a map or a folder, as they were looked at or fitted."""

import base64
import contextlib
import html
import itertools
import json
from collections.abc import Sequence
from importlib import resources
from string import Template
from typing import Any

import numpy as np

from .. import __version__
from ..base.errors import InputError, Unknown
from ..base.numerics import Array
from ..base.units import show
from . import report as inverse
from .archive import UNUSABLE, status_of
from .grade import UNFIT, kind_of
from .procedure import Failure
from .report import SYMBOLS
from .result import Fit
from .segmentation import ForceCurve, segment_force_curve

PAGE = Template(resources.files(__package__).joinpath("curve_page.html").read_text(encoding="utf-8"))
PAGE_POINTS = 740_000  # choice: points of all curves together; 4,000 curves with their words make 9 MB
PAGE_MOST, PAGE_FEWEST = 800, 100  # choice: of one curve, as many as a screen shows; enough to see a jump and a fit
SIXTEEN_BITS = 65535  # theory: the largest number of 16 bits, finer than a screen
NAMES = {"delta": ("displacement", "m"), "P": ("load", "N"), "a": ("contact radius", "m")}


def page(curves: Sequence[ForceCurve | Fit | Failure], title: str, overview: bool = False) -> str:
    """Return the page of the ``curves``, thinned so that 4,000 make about 9 MB; it begins with the first of them, or
    with an ``overview``: all of them, small, and a table."""
    points = int(np.clip(PAGE_POINTS // max(len(curves), 1), PAGE_FEWEST, PAGE_MOST))
    shown = [_fitted(item, points) if isinstance(item, Fit) else _looked_at(item, points) for item in curves]
    text = json.dumps(shown, ensure_ascii=False, separators=(",", ":")).replace("<", "\\u003c")
    return PAGE.substitute(title=html.escape(title), curves=text, version=__version__, overview="true" * overview)


def _fitted(fit: Fit, points: int) -> dict[str, Any]:
    """A fit as its picture shows it: rows and fitted line, with the zeros that were found."""
    x, y = ("delta", "P") if {"delta", "P"} <= set(fit.data) else tuple(fit.data)[:2]
    near = np.flatnonzero(fit.line["a"] <= 1.02 * fit.a.max())
    jumps = np.flatnonzero(np.diff((fit.line["a"][near] > 0).astype(int))) + 1  # where contact begins or ends
    pieces = [rows for rows in np.split(near, jumps) if rows.size]
    estimates = {item.name: item.value for item in fit.estimates}
    zero = [estimates.get(name, 0.0) for name in ("delta0", "P0")] if {x, y} == {"delta", "P"} else []
    return {
        "name": fit.name or fit.file,
        "status": status_of(fit),
        "grade": [fit.grade.word, fit.grade.reason] if fit.grade else [status_of(fit), ", ".join(fit.flags)],
        "cells": {
            SYMBOLS.get(one.name, one.name): show(one.value, one.dimension, 3)
            for one in (fit.estimate("E_star"), fit.work)
        },
        "words": inverse.fit_words(fit),
        **_axes(x, y),
        "lines": [
            _line("measured", fit.data[x], fit.data[y], points * 2 // 3),
            *(_line("fitted", fit.line[x][rows], fit.line[y][rows], points // 3 // len(pieces)) for rows in pieces),
        ],
        "base": [[None, zero[1], None, zero[1]]] if zero else [],
        "contact": [zero] if zero else [],
    }


def _looked_at(item: ForceCurve | Failure, points: int) -> dict[str, Any]:
    """A record taken apart; of one that cannot be, or was not fitted, why."""
    reasons, record, grade = list[str](), item, [UNFIT, ""]
    if isinstance(item, Failure):
        name, reasons, grade[1] = item.name, list(item.lines), kind_of(item.reason)
        with contextlib.suppress(InputError):
            record = item if item.curve is None else segment_force_curve(item.curve)
        if isinstance(record, Failure):
            return {"name": name, "status": UNUSABLE, "grade": grade, "cells": {}, "words": reasons,
                    **_axes("delta", "P"), "lines": [], "base": [], "contact": []}  # fmt: skip
    else:
        name, record, grade = item.curve.name, item, [*inverse.look_grade(item)]
    z, P = record.curve.device, record.curve.P
    assert P is not None
    based = [side for side in record.directions if side.based]
    ends = [(side, z[side.segment.rows].min(), z[side.segment.rows].max()) for side in based]
    status = UNUSABLE if isinstance(item, Failure) else ", ".join(record.flags) or "no remark"
    what = "displacement" if record.curve.stiffness is None else "position z of the instrument"
    forces = {side.segment.kind: side.adhesion for side in based if not isinstance(side.adhesion, Unknown)}
    return {
        "name": name,
        "status": status,
        "grade": grade,
        "cells": {"adhesion force": show(forces["retract"], "load", 3)} if "retract" in forces else {},
        "words": reasons + inverse.look_words(record),
        **_axes("delta", "P"),
        "x": what,
        "lines": [
            _line(part.kind, z[part.rows], P[part.rows], points // max(len(record.segments), 1))
            for part in record.segments
        ],
        "base": [[float(at) for low in (a, b) for at in (low, side.base(np.array(low)))] for side, a, b in ends],
        "contact": [
            [side.touch, float(side.base(np.array(side.touch)))]
            for side in based
            if not isinstance(side.touch, Unknown)
        ],
    }


def _axes(x: str, y: str) -> dict[str, str]:
    return {"x": NAMES[x][0], "ux": NAMES[x][1], "y": NAMES[y][0], "uy": NAMES[y][1]}


def _line(kind: str, x: Array, y: Array, most: int) -> dict[str, Any]:
    """A line of at most ``most`` points: of each run of rows the lowest and the highest, so that jumps stay."""
    if x.size > most:
        edges = np.linspace(0, x.size, max(most // 2, 1) + 1).astype(int)
        runs = [(i, y[i:j]) for i, j in itertools.pairwise(edges)]
        rows = [i + at for i, run in runs for at in sorted({int(run.argmin()), int(run.argmax())})]
        x, y = x[rows], y[rows]
    return {"kind": kind, "x": _packed(x), "y": _packed(y)}


def _packed(values: Array) -> tuple[float, float, str]:
    """Least value, step and 16-bit numbers in base 64."""
    least, most = float(values.min()), float(values.max())
    step = (most - least) / SIXTEEN_BITS or 1.0
    return least, step, base64.b64encode(((values - least) / step).round().astype("<u2").tobytes()).decode()
