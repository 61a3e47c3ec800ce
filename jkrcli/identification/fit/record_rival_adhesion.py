"""Rivals of adhesion in a raw record: w over the contact radius or over the speed of the edge, and adhesion of a range.

With r = sqrt(w/s) the contact has delta = D - r T and P = s (H - r V): a change of w is one of the logs of T and V.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np
from scipy.interpolate import CubicSpline

from ...base import MOST_STEPS, Array
from .device_path import grid, on_grid, rest
from .family import Family
from .fitted_record import FittedRecord
from .force_curve import ForceCurveModel
from .force_curve_readings import DirectionReadings
from .record_change import AMOUNT, LITTLE, Change, Values, change_of_body
from .record_change import TUNING as CHANGES
from .slow_edge import TUNING as SLOW_EDGE
from .slow_edge import load_at, receding


@dataclass(frozen=True)
class AdhesionRivalTuning:
    """Which ranges and laws of w are searched."""

    longest: float = 10e-9  # choice: [m], range of adhesion that is likely; of molecules a nanometre, of hairs more
    # choice: Tabor numbers, to begin with: chi^2 has two valleys over the range, the longer one about a factor 1.4 wide
    tabor: tuple[float, ...] = (3.0, 1.4, 1.0, 0.7, 0.5, 0.35, 0.25, 0.18, 0.12, 0.06, 0.03)
    endless: float = 400.0  # choice: of how far adhesion deforms the body, a range from which on no longer one differs
    narrow: float = 0.5  # choice: of the contact radius, a ring between narrow and wide
    every: int = 7  # choice: of the nodes of a grid, at which rings are solved: splines between are good to 1e-5
    settled: float = 1e-4  # theory: such a step by Newton's method, whose errors are squared: the next is below 1e-9
    # choice: rise of w at the usual speed of the edge and power of the speed, to begin with
    speeds: tuple[tuple[float, float], ...] = ((0.3, 0.3), (0.3, 0.8), (1.0, 0.3), (1.0, 0.8))
    powers: tuple[float, float] = (0.1, 1.5)  # choice: of the speed of the edge, that are searched; measured 0.1 to 1


TUNING = AdhesionRivalTuning()
POWER = "n"


def work_over_radius(record: FittedRecord) -> Change | None:
    """ln w of the last direction rises by the amount times (a_max - a)/(a_max - a_min): T and V by half of it. The w of
    the record is then that at a_min, at pull-off."""
    a = record.radii[-1][0]
    if not record.work or not (a > 0).any():
        return None
    a_max, a_min = record.a_max, float(a[a > 0].min())

    def changes(family: Family, amount: float) -> Array:
        place = (a_max - np.exp(grid(family))) / max(a_max - a_min, LITTLE * a_max)
        half, zero = amount / 2 * np.maximum(place, -1.0), np.zeros_like(place)
        return np.stack([zero, half, zero, half])

    name, most = f"q:{record.model.stretches[-1].kind}", CHANGES.largest
    quantities = lambda values: {"w": values[name] * math.exp(values["ln_s"] + values[AMOUNT])}  # noqa: E731
    return replace(change_of_body(changes, (-most, most), last=True), quantities=quantities)


def work_over_speed(record: FittedRecord) -> Change | None:
    """w of the retraction over the speed v of its edge. The column is that of w (v/v_m)^amount, dP/d(ln w) ln(v/v_m)
    with v_m the median; in full w = w0 (1 + amount (v/v_m)^n)."""
    part = record.retraction
    name = "" if part is None else f"q:{part.kind}"
    if part is None or name not in record.fit.names:
        return None
    a, rests = record.radii_of(part)
    moves = (a > 0) & ~rests
    if (speeds := _log_speeds(part.z[moves], a[moves])) is None:
        return None
    median, logs = speeds
    log = np.zeros(record.a.size)
    log[record.rows(part, moves)] = logs
    return replace(_gent_schultz(math.exp(median)), column=record.by_unknown(name) * record.values[name] * log)


def _log_speeds(z: Array, a: Array) -> tuple[float, Array] | None:
    """Logs of the speed of the edge over that of the device, da/dz as the device moves evenly: their median, and those
    of all rows less it; None where no position has a neighbour on either side."""
    positions, rows = np.unique(z, return_index=True)  # readings of a position repeat
    if positions.size < 3:
        return None
    log = np.log(np.maximum(np.abs(np.gradient(a[rows], positions)), 1e-9))
    median = float(np.median(log))
    return median, np.interp(z, positions, log - median)


def _gent_schultz(typical: float) -> Change:
    """w = w0 (1 + amount (v/v_m)^n) of the retraction, v_m the ``typical`` speed of its edge over the device's."""

    def loads(model: ForceCurveModel, part: DirectionReadings, values: Values) -> Array:
        s, q = math.exp(values["ln_s"]), max(values[f"q:{part.kind}"], LITTLE**3 * model.most)
        turn, n = part.turn - values["z0"], values[POWER]
        resting = rest(model.family, s, root_of(values, model.stretches[0].kind), math.sqrt(q), model.k, turn)
        law = max(values[AMOUNT], LITTLE**2) * typical**-n, n
        path = receding(model.family, s, q, model.k, law, resting, turn)
        return np.where(part.touching, load_at(path, resting, turn, model.depth(part, values)), 0.0)

    return Change(
        TUNING.speeds, (AMOUNT, POWER), {AMOUNT: (0.0, 1e3), POWER: TUNING.powers}, loads_back=loads, coupled=True,
        quantities=lambda values: {name: values[name] for name in (AMOUNT, POWER)},
    )  # fmt: skip


def root_of(values: Values, kind: str) -> float:
    """r = sqrt(w/s) of a direction."""
    return values.get(f"r:{kind}", math.sqrt(max(values[f"q:{kind}"], 0.0)))


def finite_range(record: FittedRecord) -> Change | None:
    """Adhesion of the range z0: the amount is z0^2 over that of the range whose ring of attraction is narrow (Maugis,
    J. Colloid Interface Sci. 150 (1992) 243, of a half-space; of other bodies near the edge only)."""
    if not record.work:
        return None
    E_star = record.body.problem.E_star

    def log_changes(plain: ForceCurveModel, part: DirectionReadings, values: Values) -> Array | None:
        s = math.exp(values["ln_s"])
        w, z0 = values[f"q:{part.kind}"] * s, range_of(record, values[AMOUNT])
        return None if w <= 0 or z0 == 0 else _maugis(plain.family, s * E_star, w, z0)

    starts = tuple((amount_of_range(record, neck(record) / mu),) for mu in TUNING.tabor)
    most = amount_of_range(record, TUNING.endless * neck(record))
    return Change(
        starts, limits={AMOUNT: (0.0, most)}, log_changes=log_changes, coupled=True,
        quantities=lambda values: {"range": range_of(record, values[AMOUNT])},
    )  # fmt: skip


def likely_range(record: FittedRecord) -> float:
    """The amount of the longest range that is known, or usual."""
    longest = record.known.range if math.isfinite(record.known.range) else TUNING.longest
    return amount_of_range(record, longest) if record.work else 0.0


def neck(record: FittedRecord) -> float:
    """(w^2 R/E*^2)^(1/3) [m], about how far adhesion deforms the body at pull-off: the range is that over Tabor's
    number."""
    R = record.body.problem.indenter.tip_radius or record.a_max
    return float((record.work**2 * R / record.E_star**2) ** (1 / 3))


def narrow_range(record: FittedRecord) -> float:
    """The range z0 [m] of which the ring is ``CHANGES.small`` a_max wide there: d = pi E* z0^2/(4 w)."""
    E_star = record.body.problem.E_star
    return math.sqrt(4 * CHANGES.small * record.a_max * record.work / (math.pi * record.modulus * E_star))


def amount_of_range(record: FittedRecord, z0: float) -> float:
    """The amount of a range [m]: in proportion to its square while it is short, and finite where it is endless."""
    size = (z0 / narrow_range(record)) ** 2
    return size / (1 + size / (neck(record) / narrow_range(record)) ** 2)


def range_of(record: FittedRecord, amount: float) -> float:
    """The range [m] of an amount."""
    return narrow_range(record) * math.sqrt(amount / (1 - amount / (neck(record) / narrow_range(record)) ** 2))


def _maugis(family: Family, E: float, w: float, z0: float) -> Array:
    """Changes of the logs (4, n) of a body of E* ``E`` [Pa] whose adhesion ``w`` [J/m^2] has the range ``z0`` [m]: the
    stress sigma = w/z0 on a ring from a to m a shifts the displacement by 2 sigma a sqrt(m^2 - 1)/E* and the load by 2
    sigma a^2 (sqrt(m^2 - 1) + m^2 arccos(1/m)), JKR by sqrt(2 pi a w/E*) and sqrt(8 pi w E* a^3)."""
    sigma, some = w / z0, slice(None, None, TUNING.every)
    a, D = np.exp(grid(family)[some]), on_grid(family)[0][0, some]
    m = _rim(a, D, E, w, sigma)
    root, angle = np.sqrt(m**2 - 1), np.arccos(1 / m)
    shift = 2 * sigma * a * root / E / np.sqrt(2 * math.pi * a * w / E)
    pull = 2 * sigma * a**2 * (root + m**2 * angle) / np.sqrt(8 * math.pi * w * E * a**3)
    zero = np.zeros_like(a)
    changes: Array = np.stack([zero, np.log(shift), zero, np.log(pull)]) @ _splines(grid(family).size)
    return changes


@lru_cache
def _splines(size: int) -> Array:
    """Values at ``size`` even nodes of the cubic splines through 1 at one of every ``TUNING.every`` nodes and 0 at the
    others of these, (some, size)."""
    nodes = np.arange(size)
    some = nodes[:: TUNING.every]
    splines: Array = CubicSpline(some, np.eye(some.size))(nodes).T
    return splines


def _rim(a: Array, D: Array, E: float, w: float, sigma: float) -> Array:
    """Ratio m of outer to inner radius of the ring whose stress ``sigma`` releases ``w``. With t = sqrt(m^2 - 1) and c
    = arccos(1/m), 1 = 4 sigma^2 a/(pi E* w) (t c - m + 1) + sigma D/(pi w) (t + (m^2 - 2) c); by Newton's method for
    the log of the right-hand side over that of m - 1, nearly straight; from its limits, of narrow rings and
    of wide ones."""
    own, pressed = 4 * sigma**2 / (math.pi * E * w) * a, sigma / (math.pi * w) * D
    near = 1 / (own + (math.sqrt(128) / 3 * pressed) ** (2 / 3))
    far = 2 / ((math.pi / 2 - 1) * own + np.sqrt(((math.pi / 2 - 1) * own) ** 2 + 2 * math.pi * pressed))
    x = np.where(near < TUNING.narrow, near, np.maximum(far, TUNING.narrow))
    for _ in range(MOST_STEPS):
        m = 1 + x
        root = np.sqrt(x * (2 + x))
        angle = np.arctan(root)
        released = own * (root * angle - x) + pressed * (root + (m**2 - 2) * angle)
        rate = own * (m * angle / root + 1 / m - 1) + pressed * (m / root + 2 * m * angle + (m - 2 / m) / root)
        step = -released / (x * rate) * np.log(released)
        x *= np.exp(np.clip(step, -SLOW_EDGE.widest, SLOW_EDGE.widest))
        if float(np.abs(step).max()) < TUNING.settled:
            break
    return 1 + x


def long_range(record: FittedRecord) -> Array | None:
    """From JKR to adhesion that pulls from so far that it deforms nothing (Derjaguin, Muller and Toporov, J. Colloid
    Interface Sci. 53 (1975) 314), at equal w: P = P_H(delta) - 2 pi w R. In full it is a finite range."""
    R, k = record.body.problem.indenter.tip_radius, record.model.k
    if R is None or not record.work:
        return None
    D, _, H, _ = on_grid(record.model.family)[0]
    qs = [np.full(part.P.size, max(record.values[f"q:{part.kind}"], 0.0)) for part in record.model.stretches]
    P_H = np.interp(record.depth - record.loads / k, D, H, left=0.0)
    change = record.modulus * (P_H - 2 * math.pi * R * np.concatenate(qs)) - record.loads
    column: Array = np.where(record.a > 0, change * record.at_fixed_position, 0.0)
    return column
