"""The work of adhesion along a measured curve, with its errors."""

from __future__ import annotations

import itertools
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

from ..adhesion.curve import Nonadhesive
from ..base.errors import LEVEL, InputError
from ..base.executors import Pool, completed
from ..base.numerics import HALF_WIDTH, ROUNDED, SETTLED, TOGETHER, Array, zeros_between
from ..base.units import show
from ..series import Solution
from ..tables.text import some
from .choices import Use, Values
from .curve import Curve, Reading
from .files import each
from .forward_model import FittedBody, body_of
from .record import receding_rows
from .segmentation import segment_force_curve
from .settings import Settings, settings_of

# --------------------------------------------------------------------------------------------------
# The work of adhesion along measured data: Eq. 13 solved for w at every measured point.
#
# w = S'(a) (delta_H(a) - delta)^2/(4 pi a) is the energy release rate G of the contact's edge, whatever the specimen;
# in equilibrium it is the work of adhesion, and along a curve recorded at speed its dependence on the edge's speed
# shows the rate-dependent adhesion (Maugis and Barquins, J. Phys. D 11 (1978) 1989).

PAIRS = (("a", "P"), ("a", "delta"), ("delta", "P"))  # the first needs no zero of the displacement
# What a measured row is: usable, or why it is not.
OK, NONE, BELOW, ABOVE = "ok", "no adhesion", "below the solution", "above the solution"
PINNED = "pinned at the rim"  # of a full end: there G <= w only
PINNED_NEAR = 0.01  # choice: of the rim's radius, within which an edge may be pinned there

# Limits of the search for contact radii, and of speeds.
WORK_LEAST_WINDOW = 5  # theory: rows, a parabola and two more for its error
# tuned on fits, by `make constants`: chance with which a cubic is not taken where a parabola does
WORK_SURE = 0.995


@dataclass(frozen=True, eq=False)
class WorkAlong:
    """The work of adhesion ``w`` [J/m^2] at each row of a measured ``curve`` and the contact radius ``a`` [m] there.

    Rows whose ``state`` is not "ok" have none: 0 stands there. ``used``: the two quantities that w follows from.
    ``w_err, a_err``: half-widths by the noise and the slopes' errors, None where the noise is not known;
    ``shares``: those of w by "noise" and "slopes" alone, as far as they are known. ``speed, speed_err`` [m/s]: da/dt,
    positive where the contact advances, over ``window`` rows; only where ``timed``. ``least``: the largest G [J/m^2] of
    an edge that is pinned: w is no smaller.
    """

    curve: Curve
    used: tuple[str, str]
    a: Array
    w: Array
    state: Array
    w_err: Array | None = None
    a_err: Array | None = None
    shares: Mapping[str, Array] = field(default_factory=dict)
    least: float | None = None
    speed: Array | None = None
    speed_err: Array | None = None
    timed: Array | None = None
    window: int = 0

    @property
    def ok(self) -> Array:
        """The rows that have a work of adhesion."""
        return self.state == OK


def work_along(
    body: Nonadhesive, curve: Curve, use: tuple[str, str] | None = None, noise: Values | None = None,
    window: int = 11,
) -> WorkAlong:  # fmt: skip
    """The work of adhesion at each row of ``curve`` on ``body``.

    ``use``: the pair of ``PAIRS`` to take [default: the first that was measured]. ``noise``: standard deviations of
    "a" [m], "delta" [m], "P" [N], independent from row to row; where the deflection of a device was subtracted, "delta"
    is that of its position, and the noise of P is in the displacement too. InputError where no row gives a work of
    adhesion.
    """
    possible = [pair for pair in PAIRS if set(pair) <= set(curve.measured)]
    wanted = [pair for pair in possible if use is None or set(pair) == set(use)]
    if not wanted:
        need = "two of a, delta, P" if use is None else f"{use[0]} and {use[1]}"
        raise InputError(f"{curve.where}: w follows from {need}, it holds {', '.join(curve.measured)}")
    used = wanted[0]
    values = {name: getattr(curve, name) for name in used}
    if "a" in values:
        a, ends = values["a"].copy(), body.a[[0, -1]]
        state = np.select([a < ends[0] * (1 - ROUNDED), a > ends[1] * (1 + ROUNDED)], [BELOW, ABOVE], OK)
    else:
        a, state = contact_radius(body, values["delta"], values["P"])
    least = None
    if (rim := body.series.rim) < math.inf:
        pinned = (a >= rim * (1 - PINNED_NEAR)) | (state == ABOVE)
        full = body.parts(np.where(state == OK, a, rim)[pinned])
        pulled = -values["P"][pinned] / full.S if "P" in values else -values["delta"][pinned]
        least = float(np.max(pulled / full.t, initial=0.0)) ** 2
        state[pinned] = PINNED
    rows = state == OK
    here, read = body.parts(a[rows]), {name: column[rows] for name, column in values.items()}
    lag = here.delta_H - read["delta"] if "delta" in read else (here.P_H - read["P"]) / here.S  # delta_H - delta [m]
    state[np.flatnonzero(rows)[lag <= 0]] = NONE
    shift, lag, rows = here.t[lag > 0], lag[lag > 0], state == OK
    _refuse_none(body, curve, state, least or 0.0)
    w = np.zeros_like(a)
    w[rows] = (lag / shift) ** 2
    a = np.where(rows, a, 0.0)
    compliance = 1 / curve.stiffness if curve.stiffness and "delta" in used else 0.0
    if noise and not set(noise) & {*used, *["P"] * (compliance > 0)}:
        idle = next(iter(noise))
        raise InputError(f"{curve.where}: --noise {idle}: w follows from {used[0]} and {used[1]}: leave it out")
    spread = {}
    for name, column in errors(body, used, a[rows], w[rows], lag, noise or {}, compliance).items():
        spread[name] = np.zeros(rows.size)
        spread[name][rows] = column
    return WorkAlong(
        curve,
        used,
        a,
        w,
        state,
        spread.pop("w", None),
        spread.pop("a", None),
        spread,
        least,
        *_speed(curve, a, rows, window),
    )


def typical(works: Sequence[WorkAlong]) -> float:
    """The median of w [J/m^2] over all rows of all curves."""
    return float(np.median(np.concatenate([item.w[item.ok] for item in works])))


@dataclass(frozen=True, eq=False)
class Evaluation:
    """``work_along`` of any curve, or of its rows of one ``segment``, with everything else settled; can be sent.

    ``fitted, settings``: by which raw records get their contact points, base lines and rows in contact; the noise of
    their load is that of the base line, where ``noise`` says nothing else.
    """

    body: Nonadhesive
    use: tuple[str, str] | None = None
    noise: Values = field(default_factory=dict)
    window: int = 11
    segment: str | None = None
    fitted: FittedBody | None = None
    settings: Settings | None = None

    def __call__(self, curve: Curve) -> WorkAlong:
        part, noise = curve, self.noise
        if self.fitted is not None and self.settings is not None:
            part = receding_rows(self.fitted, curve, self.settings)
        if part is not curve:
            part = replace(part, stiffness=curve.stiffness)
            if lines := [item.base for item in segment_force_curve(curve).directions if item.begins_free]:
                noise = {"P": math.hypot(lines[-1].noise, lines[-1].waviness), **noise}
        elif self.segment is not None:
            part = curve.only(self.segment)
        return work_along(self.body, part, self.use, noise, self.window)


def evaluation_of(
    solution: Solution, unit: Nonadhesive, reading: Reading, modulus_factor: float = 1.0, use: Use | None = None,
    segment: str | None = None, noise: Values | None = None, window: int = 11,
) -> Evaluation:  # fmt: skip
    """What gives w along any curve: on a ``solution`` with its functions ``unit``, moduli times ``modulus_factor``, by
    the pair of quantities ``use`` ("a,P"); of raw records base line, contact points and rows are fitted first."""
    check_window(window)
    body, contact = body_of(solution), "as-is" if reading.zero else reading.contact
    own = segment in (None, "approach", "retract")
    rows: dict[str, Any] = {"segment": segment} if own else {}
    settings = settings_of(body, fix={"modulus": modulus_factor}, contact=contact, **rows)
    pair: Any = None if use is None else tuple(use.split(","))
    own_body = body if own else None
    return Evaluation(unit.scaled(modulus_factor), pair, noise or {}, window, segment, own_body, settings)


def along_file(path: Path, reading: Reading, evaluation: Evaluation, pool: Pool) -> tuple[list[WorkAlong], list[str]]:
    """The curves of a file that have a work of adhesion, in its order, and why the others have none."""
    outcomes: list[Any] = list(each(path, reading))
    rows = [i for i, item in enumerate(outcomes) if not isinstance(item, InputError)]
    for i, outcome in completed(pool, evaluation, [outcomes[row] for row in rows], path.name, TOGETHER):
        outcomes[rows[i]] = outcome
    for outcome in outcomes:
        if isinstance(outcome, Exception) and not isinstance(outcome, InputError):
            raise outcome
    skipped = [line for outcome in outcomes if isinstance(outcome, InputError) for line in outcome.lines]
    works = [outcome for outcome in outcomes if not isinstance(outcome, Exception)]
    if not works:
        raise InputError(some(skipped))
    return works, skipped


def _refuse_none(body: Nonadhesive, curve: Curve, state: Array, least: float) -> None:
    """Refuse a curve of which no row has a work of adhesion."""
    if (state == OK).any():
        return
    ends = [show(float(a), "length") for a in body.a[[0, -1]]]
    why = {
        NONE: "at or above the nonadhesive load",
        BELOW: f"at contact radii below {ends[0]}, the smallest of the solution",
        ABOVE: f"at contact radii above {ends[1]}, where it ends",
        PINNED: f"{PINNED}: G <= w, at least {show(least, 'work')}",
    }
    counts = [f"{count} {why[word]}" for word in why if (count := int((state == word).sum()))]
    if not len(curve):
        raise InputError(
            f"{curve.where}: on the body of the solution the contact's edge moves on none of its rows: does the "
            f"modulus belong to the force curve? jkr fit finds E* (--modulus-factor){curve.likely}"
        )
    raise InputError(
        f"{curve.where}: none of its {len(curve)} rows gives a work of adhesion: {', '.join(counts)}; are contact "
        f"point and force offset (--zero), signs (--flip), units and modulus right?{curve.likely}"
    )


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


# ---------------------------------------------------------------------- the contact radius
def contact_radius(body: Nonadhesive, delta: Array, P: Array) -> tuple[Array, Array]:
    """Contact radius [m] at each displacement [m] and load [N], and the state of each row (radius 0 where not OK).

    The radius solves F(a) = P_H - P - S (delta_H - delta) = 0. As P_H' = S delta_H', F' = -S' (delta_H - delta): F
    rises up to the nonadhesive contact at ``delta`` and falls beyond, where delta_H > delta. So there is one
    adhesive radius or none: one, if the load is below the nonadhesive load at the same displacement.
    """
    nodes, end = body.a, body.a.size - 1

    # The last node with delta_H <= delta, and the last with F > 0 beyond that, or that one (-1: none): by bisection, as
    # F falls there
    delta_H, P_H, S, _, _ = body.parts(nodes)
    before = np.searchsorted(delta_H, delta, side="right") - 1
    last, beyond = before, np.full(delta.size, nodes.size)
    while (beyond - last > 1).any():
        middle = np.maximum((last + beyond) // 2, 0)
        positive = P_H[middle] - P - S[middle] * (delta_H[middle] - delta) > 0
        open_ = beyond - last > 1
        last, beyond = np.where(open_ & positive, middle, last), np.where(open_ & ~positive, middle, beyond)

    # Between that and the next
    low, high = nodes[np.maximum(last, 0)].copy(), nodes[np.minimum(last + 1, end)]
    top = (last == before) & (0 <= before) & (before < end)  # F may rise above 0 between two nodes
    low[top] = zeros_between(lambda a: body.parts(a).delta_H - delta[top], low[top], high[top], SETTLED * low[top])
    none = top & (_excess(body, low, delta, P)[0] < 0)
    below, above = last < 0, last == end
    for out, rows, node in ((below, below.copy(), nodes[0]), (above, above & (before < end), nodes[-1])):
        excess, fall = _excess(body, np.full(rows.sum(), node), delta[rows], P[rows])
        out[rows] = np.abs(excess) > ROUNDED * node * fall
    state = np.select([none, below, above], [NONE, BELOW, ABOVE], OK)
    a = low  # the very ends, but for round-off
    between = (state == OK) & (0 <= last) & (last < end)
    inside = low[between], high[between]
    a[between] = zeros_between(lambda a: _excess(body, a, delta[between], P[between])[0], *inside, SETTLED * inside[0])
    return np.where(state == OK, a, 0.0), state


def _excess(body: Nonadhesive, a: Array, delta: Array, P: Array) -> tuple[Array, Array]:
    """F(a) [N] and -F'(a) [N/m]."""
    delta_H, P_H, S, dS, _ = body.parts(a)
    return P_H - P - S * (delta_H - delta), dS * (delta_H - delta)


# ---------------------------------------------------------------------- errors, to first order
def errors(
    body: Nonadhesive, used: tuple[str, str], a: Array, w: Array, lag: Array, sigma: Values,
    compliance: float = 0.0,
) -> dict[str, Array]:  # fmt: skip
    """Half-widths of "w" and "a" where the noise is known, and of w by "noise" and by "slopes" alone, as far as
    they are. ``compliance`` [m/N]: of the device whose deflection by P was subtracted from delta."""
    # Derivatives of log w and of a: by the measured quantities, and by (delta_H, P_H, S, S') as arrays (4, n)
    (_, _, S, dS, t), rates = body.with_rates(a)
    zero, below = np.zeros_like(a), S * lag  # P_H - P
    if "delta" in used:  # d(log w)/da at constant readings; by one of them; by the functions
        along, name, at_once = 2 * (rates.delta_H / lag - rates.t / t), "delta", -2 / lag
        direct = np.stack([2 / lag, zero, zero, 1 / dS])
    else:
        along, name, at_once = 2 * (rates.P_H / below - rates.S / S - rates.t / t), "P", -2 / below
        direct = np.stack([zero, 2 / below, -2 / S, 1 / dS])
    by_noise: dict[str, dict[str, Array]] = {"w": {"a": along, name: at_once}, "a": {}}
    by_slopes: dict[str, Array | None] = {"w": direct, "a": None}
    if "a" not in used:
        slope = dS * lag  # -F': a moves by (S d(delta) - dP)/slope
        of_a = {"delta": S / slope, "P": -1 / slope}
        by_noise = {"w": {"delta": along * of_a["delta"] + at_once, "P": along * of_a["P"]}, "a": of_a}
        by_fields = np.stack([-S / slope, 1 / slope, -lag / slope, zero])
        by_slopes = {"w": along * by_fields + direct, "a": by_fields}
    at_nodes = body.slopes.covariance
    covariance = None if at_nodes is None else body.between(at_nodes, a)
    parts: dict[str, dict[str, Array]] = {"w": {}, "a": {}}
    for target, unit in (("w", w), ("a", np.ones_like(a))):
        gradients = dict(by_noise[target])
        if compliance and gradients:
            gradients["P"] = gradients.get("P", 0.0) - compliance * gradients["delta"]
        if squares := [(gradient * sigma[name]) ** 2 for name, gradient in gradients.items() if sigma.get(name)]:
            parts[target]["noise"] = HALF_WIDTH * unit * np.sqrt(np.sum(squares, axis=0))
        gradient = by_slopes[target]
        if covariance is not None and gradient is not None:
            variance = np.einsum("in,nij,jn->n", gradient, covariance, gradient)
            parts[target]["slopes"] = body.slopes.quantile * unit * np.sqrt(variance)
    totals = {name: np.hypot.reduce(list(part.values())) for name, part in parts.items() if "noise" in part}
    return totals | parts["w"]


# ---------------------------------------------------------------------- the speed of the edge
def check_window(window: int) -> None:
    """Refuse a window without a middle row, or too short for a parabola with an error."""
    if window < WORK_LEAST_WINDOW or window % 2 == 0:
        raise InputError(f"--window: must be an odd number of rows, at least {WORK_LEAST_WINDOW}, got {window}")


def rate(t: Array, y: Array, window: int) -> tuple[Array, Array]:
    """dy/dt and its half-width at each row, from the parabola through the ``window`` rows around it, or from the
    cubic where that differs by more than the scatter lets it.

    ``t`` strictly increasing, of at least ``window`` (odd) rows, spaced as they are; near the ends the first or last
    window is evaluated off its middle. The half-width is of the scatter about the curve, and where the cubic is taken
    of what it changed, as what it leaves is less. (Savitzky and Golay's first derivative, Anal. Chem. 36 (1964) 1627,
    for any spacing.)
    """
    from scipy.special import stdtrit

    starts = np.clip(np.arange(t.size) - window // 2, 0, t.size - window)
    times, values = (np.lib.stride_tricks.sliding_window_view(column, window)[starts] for column in (t, y))
    half = (times[:, -1] - times[:, 0]) / 2
    x, off = (times - t[:, None]) / half[:, None], values - values[:, window // 2, None]
    (slope, variance, by), (bent, least, by_bent) = (_slope(x, off, degree) for degree in (2, 3))
    added, change = np.maximum(by_bent - by, 0.0), np.abs(bent - slope)
    cubic = change > stdtrit(window - 4, WORK_SURE) * np.sqrt(least * added)
    spread = stdtrit(window - 3, (1 + LEVEL) / 2) * np.sqrt(variance * by)
    left = np.hypot(stdtrit(window - 4, (1 + LEVEL) / 2) * np.sqrt(least * by_bent), change)
    return np.where(cubic, bent, slope) / half, np.where(cubic, left, spread) / half


def _slope(x: Array, y: Array, degree: int) -> tuple[Array, Array, Array]:
    """Slopes at 0 of the polynomials of a ``degree`` through the windows (n, rows), the variance about them, and that
    of the slopes in units of it."""
    powers = x[:, :, None] ** np.arange(degree + 1)
    normal = np.einsum("nik,nil->nkl", powers, powers)
    coefficients = np.linalg.solve(normal, np.einsum("nik,ni->nk", powers, y)[..., None])
    residuals = y - (powers @ coefficients)[..., 0]
    variance = np.sum(residuals**2, axis=1) / (x.shape[1] - degree - 1)
    return coefficients[:, 1, 0], variance, np.linalg.inv(normal)[:, 1, 1]


def runs(whole: Array) -> list[slice]:
    """The longest stretches of rows in which every step to the next row is ``whole`` (a mask, one shorter)."""
    ends = [0, *(np.flatnonzero(~whole) + 1), whole.size + 1]
    return [slice(int(first), int(last)) for first, last in itertools.pairwise(ends)]
