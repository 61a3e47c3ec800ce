"""Eq. 13 solved for w at every measured point."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from ...adhesion.curve import TUNING, Nonadhesive, Parts
from ...base.errors import InputError
from ...base.units import show
from ...data.measured import Curve
from ...data.measured.speed import check_window, rate, runs
from ...series import Array
from .propagation import errors
from .radius import ABOVE, BELOW, NONE, OK, contact_radius

PAIRS = (("a", "P"), ("a", "delta"), ("delta", "P"))  # the first needs no zero of the displacement


@dataclass(frozen=True, eq=False)
class WorkAlong:
    """The work of adhesion ``w`` [J/m^2] at each row of a measured ``curve`` and the contact radius ``a`` [m] there.

    Rows whose ``state`` is not "ok" have none: 0 stands there. ``used``: the two quantities that w follows from.
    ``w_err, a_err``: 90 % half-widths by the noise and the slopes' errors, None where neither is known;
    ``shares``: those of w by "noise" and "slopes" alone. ``speed, speed_err`` [m/s]: da/dt, positive where the contact
    advances, over ``window`` rows; only where ``timed``.
    """

    curve: Curve
    used: tuple[str, str]
    a: Array
    w: Array
    state: Array
    w_err: Array | None = None
    a_err: Array | None = None
    shares: Mapping[str, Array] = field(default_factory=dict)
    speed: Array | None = None
    speed_err: Array | None = None
    timed: Array | None = None
    window: int = 0

    @property
    def ok(self) -> Array:
        """The rows that have a work of adhesion."""
        return self.state == OK


def work_along(
    body: Nonadhesive,
    curve: Curve,
    use: tuple[str, str] | None = None,
    noise: Mapping[str, float] | None = None,
    window: int = 11,
) -> WorkAlong:
    """The work of adhesion at each row of ``curve`` on ``body``.

    ``use``: the pair of ``PAIRS`` to take [default: the first that was measured]. ``noise``: standard deviations of
    "a" [m], "delta" [m], "P" [N], independent from row to row. InputError where no row gives a work of adhesion.
    """
    used = _pair(curve, use)
    values = {name: getattr(curve, name) for name in used}
    a, state = _radii(body, values)
    rows = state == OK
    here = body.parts(a[rows])
    lag = _lag(here, {name: column[rows] for name, column in values.items()})
    state[np.flatnonzero(rows)[lag <= 0]] = NONE
    shift, lag, rows = here.t[lag > 0], lag[lag > 0], state == OK
    _refuse_none(body, curve, state)
    w = np.zeros_like(a)
    w[rows] = (lag / shift) ** 2
    a = np.where(rows, a, 0.0)
    sigma = {name: (noise or {}).get(name, 0.0) for name in used}
    found = errors(body, used, a[rows], w[rows], lag, sigma)
    spread = {name: _spread(rows, column) for name, column in found.items()}
    return WorkAlong(
        curve, used, a, w, state, spread.pop("w", None), spread.pop("a", None), spread, *_speed(curve, a, rows, window)
    )


def typical(found: Sequence[WorkAlong]) -> float:
    """The median of w [J/m^2] over all rows of all curves."""
    return float(np.median(np.concatenate([item.w[item.ok] for item in found])))


@dataclass(frozen=True, eq=False)
class Evaluation:
    """``work_along`` of any curve, or of its rows of one ``segment``, with everything else settled; can be sent."""

    body: Nonadhesive
    use: tuple[str, str] | None = None
    noise: Mapping[str, float] = field(default_factory=dict)
    window: int = 11
    segment: str | None = None

    def __call__(self, curve: Curve) -> WorkAlong:
        part = curve if self.segment is None else curve.only(self.segment)
        return work_along(self.body, part, self.use, self.noise, self.window)


def _pair(curve: Curve, use: tuple[str, str] | None) -> tuple[str, str]:
    possible = [pair for pair in PAIRS if set(pair) <= set(curve.measured)]
    wanted = [pair for pair in possible if use is None or set(pair) == set(use)]
    if not wanted:
        need = "two of a, delta, P" if use is None else f"{use[0]} and {use[1]}"
        raise InputError(f"{curve.where}: w follows from {need}, it holds {', '.join(curve.measured)}")
    return wanted[0]


def _radii(body: Nonadhesive, values: Mapping[str, Array]) -> tuple[Array, Array]:
    """Contact radii and states: as measured, or of displacement and load."""
    if "a" not in values:
        return contact_radius(body, values["delta"], values["P"])
    a, ends = values["a"], body.a[[0, -1]]
    return a.copy(), np.select([a < ends[0] * (1 - TUNING.end), a > ends[1] * (1 + TUNING.end)], [BELOW, ABOVE], OK)


def _lag(here: Parts, values: Mapping[str, Array]) -> Array:
    """delta_H - delta [m] at the rows' radii."""
    return here.delta_H - values["delta"] if "delta" in values else (here.P_H - values["P"]) / here.S


def _refuse_none(body: Nonadhesive, curve: Curve, state: Array) -> None:
    """At least one row must have a work of adhesion."""
    if (state == OK).any():
        return
    ends = [show(float(a), "length") for a in body.a[[0, -1]]]
    why = {
        NONE: "at or above the nonadhesive load",
        BELOW: f"at contact radii below {ends[0]}, where the series begins",
        ABOVE: f"at contact radii above {ends[1]}, where it ends",
    }
    found = [f"{count} {why[word]}" for word in why if (count := int((state == word).sum()))]
    raise InputError(
        f"{curve.where}: none of its {len(curve)} rows gives a work of adhesion: {', '.join(found)}; are the zero "
        "points (--zero), signs (--flip), units and the modulus right?"
    )


def _spread(rows: Array, values: Array) -> Array:
    """``values`` of the chosen rows among all rows, 0 elsewhere."""
    found = np.zeros(rows.size)
    found[rows] = values
    return found


def _speed(curve: Curve, a: Array, ok: Array, window: int) -> tuple[Array | None, Array | None, Array | None, int]:
    """da/dt [m/s], its half-width, the rows that have them, and the window; Nones without a time."""
    if curve.t is None:
        return None, None, None, 0
    check_window(window)
    whole = ok[1:] & ok[:-1] & (np.diff(curve.t) > 0)
    if curve.segment is not None:
        whole &= curve.segment[1:] == curve.segment[:-1]
    speed, error, timed = np.zeros_like(a), np.zeros_like(a), np.zeros(a.size, dtype=bool)
    for run in runs(whole):
        if run.stop - run.start >= window:
            speed[run], error[run] = rate(curve.t[run], a[run], window)
            timed[run] = True
    return speed, error, timed, window
