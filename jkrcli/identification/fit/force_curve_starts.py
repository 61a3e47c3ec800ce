"""Where the search for the unknowns of a force curve begins: shapes and contact points tried, the rest linear."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from ...base import ROWS, Array, SolveError
from .device_path import on_grid
from .force_curve import ForceCurveModel
from .force_curve_readings import DirectionReadings


@dataclass(frozen=True)
class StartsTuning:
    """How many starts are tried."""

    # choice: of a retraction alone, the share of its way in contact that tells a start, and ``turn`` to begin with:
    alone: tuple[tuple[float, float], ...] = ((0.5, 0.1), (0.5, 0.6), (1.0, 1.0))
    shapes: int = 25  # choice: ratios w/s tried
    points: int = 41  # choice: contact points tried


TUNING = StartsTuning()


def starts_of(model: ForceCurveModel) -> Iterator[Array]:
    """Unknowns to begin with, as each stretch suggests."""
    if "turn" not in model.names:
        yield from (_start(model, part, 1.0, 0.0) for part in model.stretches)
        return
    yield from (_start(model, model.stretches[0], share, turn) for share, turn in TUNING.alone)


def _start(model: ForceCurveModel, part: DirectionReadings, share: float, turn: float) -> Array:
    """Unknowns to begin with, as a ``share`` of the way in contact of one stretch suggests: shapes w/s and contact
    points are tried; for each of them the rest is linear."""
    s, zero, r = _tried(model, part, share)
    values = {"ln_s": math.log(s), "z0": zero, "turn": turn, **dict.fromkeys(model.positions, 0.0)}
    values |= by_base_lines(model)
    for other in model.stretches:
        q = r**2 if other is part else _of_tension(model, s, other.tension)
        values |= {f"q:{other.kind}": q, f"r:{other.kind}": math.sqrt(q)}
        if other.wave is not None:
            values["ln_period"] = math.log(other.wave.period)
            values |= {f"cos:{other.kind}": other.wave.cos, f"sin:{other.kind}": other.wave.sin}
    return model.unknowns(values)


def by_base_lines(model: ForceCurveModel) -> dict[str, float]:
    """Offsets and tilts as the free rows have them."""
    offsets = {f"offset:{part.kind}": float(part.line(part.z[0])) for part in model.stretches}
    return offsets | {f"tilt:{part.kind}": part.line.tilt for part in model.stretches}


def _of_tension(model: ForceCurveModel, s: float, tension: float) -> float:
    """q of moduli times ``s`` that a contact is pulled off at a ``tension`` [N] with."""
    (D, T, H, V), _, _ = on_grid(model.family)
    r = _shapes(D, T)[:, None]
    folds = np.argmin(D - r * T + s * (H - r * V) / model.k, axis=1)
    tensions = s * (r[:, 0] * V[folds] - H[folds])
    return float(np.interp(tension, np.maximum.accumulate(tensions), r[:, 0])) ** 2


def _tried(model: ForceCurveModel, part: DirectionReadings, share: float) -> tuple[float, float, float]:
    """s, z0 and sqrt(q) that a stretch is best described with, by the base line of its free rows, up to a ``share``
    of the way in contact."""
    rows = _some_rows(part)
    rows = rows[part.z[rows] <= part.z.max() - (1 - share) * part.reach] if share < 1 else rows
    net = part.P[rows] - part.line(part.z[rows])
    if part.wave is not None:
        net -= part.wave(part.z[rows])
    delta = part.z[rows] - net / model.k
    (D, T, H, V), _, _ = on_grid(model.family)
    modulus, work = model.known.get("ln_s"), model.works.get(part.kind)
    best = (math.inf, 0.0, 0.0, 0.0)
    points = _contact_points(part, delta, rows)
    for r in _shapes(D, T) if part.jumped and work != 0 else (0.0,):
        path, load = D - r * T, H - r * V
        fold = int(np.argmin(path))
        zeros = points - float(path[fold]) if part.jumped else points
        basis = np.interp(delta - zeros[:, None], path[fold:], load[fold:], left=0.0 if not part.jumped else None)
        if part.jumped:
            basis = np.where(part.touching[rows], basis, 0.0)
        size = np.sum(basis**2, axis=1)
        factors = basis @ net / np.where(size > 0, size, np.inf)
        if modulus is not None or work:
            factors[:] = math.exp(modulus) if modulus is not None else (work or 0.0) / r**2 if r else 0.0
        costs = np.sum((net - factors[:, None] * basis) ** 2, axis=1)
        at = int(np.argmin(np.where(factors > 0, costs, np.inf)))
        if factors[at] > 0 and costs[at] < best[0]:
            best = (float(costs[at]), float(factors[at]), float(zeros[at]), float(r))
    if best[1] == 0:
        raise SolveError("no curve of this body resembles the record")
    return best[1:]


def _some_rows(part: DirectionReadings) -> Array:
    """Rows spread evenly, half of them where contact may be."""
    n = part.z.size
    if n <= ROWS:
        return np.arange(n)
    near = int(np.argmax(part.touching)) if part.jumped else n // 2
    halves = [np.linspace(first, n - 1, ROWS // 2) for first in (0, near)]
    return np.unique(np.concatenate(halves).astype(int))


def _shapes(D: Array, T: Array) -> Array:
    """Ratios sqrt(w/s): of almost no adhesion, and so that the shift is the displacement at radii across the series."""
    ratio = np.unique(D / T)
    return np.concatenate([[0.0], np.geomspace(ratio[0], ratio[-1], TUNING.shapes)])


def _contact_points(part: DirectionReadings, delta: Array, rows: Array) -> Array:
    """Displacements tried as zero; with a jump, as the fold, about its first row in contact."""
    span = float(np.ptp(delta))
    if not part.jumped:
        return np.linspace(delta.min(), delta.max() - 0.01 * span, TUNING.points)
    first = float(delta[part.touching[rows]][0])
    steps = span * np.geomspace(1e-4, 0.5, TUNING.points // 3)
    return first + np.concatenate([-steps, [0.0], steps])
