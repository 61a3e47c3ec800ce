"""One statistical model of a whole force curve: base line, contact point, modulus and work of adhesion together.

At device position z a spring of stiffness k carries the load P of the contact, delta = z - z0 - P/k, and reads it over
a straight base line; all scatter is in the load:

    reading(z) = offset + tilt (z - z_touch) + P(z - z0; s, w, k)

P is the stable branch of Eq. 13 for all moduli times s, P = s (H - r V), delta = D - r T, r = sqrt(w/s), where the rows
are in contact, and 0 where they are free. Each direction has its own base line (drag, drift of the load), on request
with a wave c cos + s sin of 2 pi (z - at)/period (``interference``), and its own w. On request z0 drifts at a constant
speed, z0 + v t with t = 0 at the turning point: of one direction alone that cannot be told from another modulus.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np
from scipy.optimize import least_squares

from ...base.arrays import Array
from ...base.errors import SolveError
from ...base.unknown import Unknown
from ...data.measured.curve import APPROACH
from ...data.record import BaseLine, Direction, ForceCurve
from .coloured import spread as covariance
from .family import Family
from .interference import Wave, parts
from .settings import Loss
from .statistics import TURNS, influence, robust_scale


@dataclass(frozen=True)
class ForceCurveTuning:
    """How finely branches are tabulated and starts are tried."""

    nodes: int = 400  # choice: of a branch; loads between them are good to 1e-7 of the largest
    zooms: int = 3  # choice: grids on which a fold is sought, each of ``zoomed`` points within a step of the one before
    zoomed: int = 33  # choice: see ``zooms``; the position at the fold, flat there, is then good to 1e-16
    below: float = 4.0  # choice: of log a below the series, where its limit by power laws holds
    beyond: float = 0.5  # choice: of log a above the series, tried while starting values are looked for
    shapes: int = 25  # choice: ratios w/s tried
    points: int = 41  # choice: contact points tried
    rows: int = 200  # choice: rows used while trying
    turning: float = 0.01  # choice: of the rows in contact, those next to the turning point that are left out
    blunt: tuple[float, ...] = (1e-2, 1e-3, 1e-5)  # choice: of the depth of contact, for a blunt fold while searching
    moduli: float = 10.0  # choice: of ln s about its start, where the search may go
    periods: float = 0.3  # choice: the same of the log of a wave's period
    converged: float = 1e-11  # choice: relative change of cost and parameters
    about: float = 1e-6  # choice: the same while the fold is blunter than it will be, or no more can be had
    evaluations: int = 80  # choice: steps after which the search gives up


TUNING = ForceCurveTuning()


@dataclass(frozen=True, eq=False)
class DirectionReadings:
    """The ``rows`` of one direction, from the far end inwards: device position ``z`` [m], reading ``P`` [N].

    ``touching``: whether a row may be in contact; where ``jumped``, all those rows are, and the others are free.
    ``line``: the base line that was found from the free rows alone, ``wave``: on top of it. ``t``: time since the
    turning point [s], 0 where it is not known.
    """

    kind: str
    rows: Array
    line: BaseLine
    z: Array
    P: Array
    touching: Array
    jumped: bool
    t: Array
    wave: Wave | None = None

    @cached_property
    def spacing(self) -> float:
        """Usual distance of neighbouring rows [m]."""
        return float(np.median(np.abs(np.diff(self.z))))

    @cached_property
    def reach(self) -> float:
        """How far the device moves in contact [m], about."""
        return float(np.ptp(self.z[self.touching])) if self.jumped else 0.1 * float(np.ptp(self.z))


@dataclass(frozen=True, eq=False)
class DeviceBranch:
    """The stable branch of one body at a device: load over zeta = sqrt(z - fold), where it is smooth.

    ``rates``: derivatives of the load at fixed z by ln s and q = w/s, times zeta, (2, n). ``fold`` [m]: where it ends;
    ``u, z``: log of the contact radius and position [m] along it.
    """

    fold: float
    u: Array
    z: Array
    zeta: Array
    P: Array
    slope: Array
    rates: Array

    def at(self, z: Array, blunt: float) -> tuple[Array, Array]:
        """Load at positions ``z`` [m], and its derivatives by ln s, q and z, (3, n).

        From ``blunt`` [m] before the fold on the tangent there goes on: a load for every position, and a search that
        sees where the fold should be.
        """
        zeta = np.sqrt(np.maximum(z - self.fold, blunt))
        i = np.clip(np.searchsorted(self.zeta, zeta) - 1, 0, self.zeta.size - 2)
        width = self.zeta[i + 1] - self.zeta[i]
        x = (zeta - self.zeta[i]) / width
        left, right, dl, dr = self.P[i], self.P[i + 1], self.slope[i] * width, self.slope[i + 1] * width
        a, b = 2 * (left - right) + dl + dr, 3 * (right - left) - 2 * dl - dr
        by_z = (dl + x * (2 * b + 3 * x * a)) / width / (2 * zeta)
        P = left + x * (dl + x * (b + x * a)) + by_z * (z - self.fold - zeta**2)
        rates = (self.rates[:, i] * (1 - x) + self.rates[:, i + 1] * x) / zeta
        return P, np.concatenate([rates, by_z[None]])


def branch(family: Family, s: float, q: float, k: float) -> DeviceBranch:
    """The stable branch for moduli times ``s`` and work of adhesion ``q`` s, by a device of stiffness ``k``."""
    u = np.linspace(family.low - TUNING.below, family.high + TUNING.beyond, TUNING.nodes)
    r = math.sqrt(q)

    def path(u: Array) -> Array:
        """Position and load, and their derivatives by u."""
        (D, T, H, V), (dD, dT, dH, dV), _ = family.at(u)
        P, dP = s * (H - r * V), s * (dH - r * dV)
        return np.stack([D - r * T + P / k, P, dD - r * dT + dP / k, dP])

    start = _fold(lambda u: path(u)[2], u)
    u = start + (u[-1] - start) * np.linspace(0, 1, TUNING.nodes) ** 2
    z, P, dz, dP = path(u)
    zeta = np.sqrt(np.maximum.accumulate(z - z[0]))
    _, T, _, V = family.at(u)[0]
    slope = np.append(0.0, dP[1:] / dz[1:] * 2 * zeta[1:])
    by_q = -s * V / (2 * r) if r > 0 else np.zeros_like(P)
    by = np.stack([P, by_q]), np.stack([P / k, (-T / (2 * r) if r > 0 else 0.0) + by_q / k])
    rates = np.zeros_like(by[0])
    rates[:, 1:] = zeta[1:] * (by[0] - dP / np.where(dz > 0, dz, np.inf) * by[1])[:, 1:]
    slope[0], rates[:, 0] = slope[1], rates[:, 1]
    rising = np.append(True, np.diff(zeta) > 0)
    return DeviceBranch(float(z[0]), u[rising], z[rising], zeta[rising], P[rising], slope[rising], rates[:, rising])


def _fold(rate: Callable[[Array], Array], u: Array) -> float:
    """Where ``rate`` turns positive for good on ``u``, by ever finer grids and a secant; the first u where it never
    does within them."""
    for _ in range(TUNING.zooms):
        rates = rate(u)
        falling = np.flatnonzero(rates <= 0)
        if not falling.size or falling[-1] == u.size - 1:
            return float(u[0])
        i = falling[-1]
        share = rates[i] / (rates[i] - rates[i + 1])
        found, u = float(u[i] + share * (u[i + 1] - u[i])), np.linspace(u[i], u[i + 1], TUNING.zoomed)
    return found


@dataclass(frozen=True, eq=False)
class ForceCurveModel:
    """The readings of some stretches on one body at a device of stiffness ``k`` [N/m], as a function of the unknowns.

    These are ln s, z0, its speed where it is ``drifting`` [m/s], the log of the period where there are waves, and for
    each stretch its offset, tilt, cosine and sine of its wave, and q = w/s unless ``adhesive`` says that it has no
    adhesion. ``known``: those that are not fitted, by name. ``works``: w [J/m^2] where it is known, by kind.
    ``moduli``: least and largest s.
    """

    family: Family
    k: float
    stretches: tuple[DirectionReadings, ...]
    adhesive: tuple[bool, ...]
    known: Mapping[str, float] = field(default_factory=dict)
    works: Mapping[str, float] = field(default_factory=dict)
    moduli: tuple[float, float] = (0.0, math.inf)
    drifting: bool = False

    @cached_property
    def names(self) -> tuple[str, ...]:
        """The unknowns in order; those of a stretch carry its kind."""
        names = (
            ["ln_s", "z0"]
            + ["drift"] * self.drifting
            + ["ln_period"] * any(stretch.wave is not None for stretch in self.stretches)
        )
        for stretch, adhesive in zip(self.stretches, self.adhesive, strict=True):
            names += [f"offset:{stretch.kind}", f"tilt:{stretch.kind}"]
            names += [f"cos:{stretch.kind}", f"sin:{stretch.kind}"] * (stretch.wave is not None)
            names += [f"q:{stretch.kind}"] * (adhesive and stretch.kind not in self.works)
        return tuple(name for name in names if name not in self.known)

    @cached_property
    def ends(self) -> tuple[float, float]:
        """Least and largest q: of next to no adhesion, and of a curve that is pulled off at the end of the series."""
        u = np.array([self.family.low - TUNING.below, self.family.high + TUNING.beyond])
        (D, T, _, _), (_, _, dH, dV), _ = self.family.at(u)
        return float(D[0] / T[0]) ** 2, 0.9 * float(dH[1] / dV[1]) ** 2

    def values(self, x: Array) -> dict[str, float]:
        """All unknowns by name, the known ones too."""
        found = {**self.known, **dict(zip(self.names, map(float, x), strict=True))}
        return found | {f"q:{kind}": w / math.exp(found["ln_s"]) for kind, w in self.works.items()}

    def depth(self, part: DirectionReadings, values: Mapping[str, float]) -> Array:
        """Position of the device beyond its zero [m], at all rows of a stretch."""
        depth: Array = part.z - values["z0"] - values.get("drift", 0.0) * part.t
        return depth

    def residuals(self, x: Array, blunt: float) -> tuple[Array, Array]:
        """Model minus reading [N] of all rows, and its derivatives by the unknowns, (rows, unknowns).

        ``blunt``: share of the depth of contact over which the fold is blunt; 0: half the distance of two rows.
        """
        values = self.values(x)
        parts = []
        rates = np.zeros((sum(part.P.size for part in self.stretches), x.size))
        first = 0
        for stretch in self.stretches:
            rows = slice(first, first + stretch.P.size)
            first = rows.stop
            off, by = self._stretch(stretch, values, blunt)
            parts.append(off)
            for name, column in by.items():
                if name in self.names:
                    rates[rows, self.names.index(name)] = column
        return np.concatenate(parts), rates

    def _stretch(
        self, part: DirectionReadings, values: Mapping[str, float], blunt: float
    ) -> tuple[Array, dict[str, Array]]:
        """Residuals of one stretch of the record, derivatives by name."""
        q = values.get(f"q:{part.kind}", 0.0)
        held = branch(self.family, math.exp(values["ln_s"]), q, self.k)
        depth = self.depth(part, values)
        touching = part.touching if part.jumped else depth > held.fold
        P, by = np.zeros(depth.size), np.zeros((3, depth.size))
        P[touching], by[:, touching] = held.at(depth[touching], blunt * part.reach if blunt else part.spacing / 2)
        by_s, by_q, by_z = by
        along = part.z - part.z[0]
        off = values[f"offset:{part.kind}"] + values[f"tilt:{part.kind}"] * along + P - part.P
        waves = {}
        if part.wave is not None:
            way, period = part.z - part.wave.at, math.exp(values["ln_period"])
            c, s = values[f"cos:{part.kind}"], values[f"sin:{part.kind}"]
            cos, sin = parts(way, period).T
            off += c * cos + s * sin
            waves = {"ln_period": 2 * math.pi * way / period * (c * sin - s * cos), f"cos:{part.kind}": cos,
                     f"sin:{part.kind}": sin}  # fmt: skip
        return off, waves | {
            "ln_s": by_s - q * by_q if part.kind in self.works else by_s,
            "z0": -by_z,
            "drift": -by_z * part.t,
            f"q:{part.kind}": by_q,
            f"offset:{part.kind}": np.ones_like(P),
            f"tilt:{part.kind}": along,
        }


@dataclass(frozen=True, eq=False)
class ForceCurveFit:
    """The model that fits best: ``values`` and standard errors by name; ``off`` residuals [N] of all rows.

    ``sigma``: standard deviation of a reading about the model [N]; ``tau``: how many rows count as one, because their
    residuals follow each other; ``covariance`` with both in it.
    """

    model: ForceCurveModel
    names: tuple[str, ...]
    x: Array
    covariance: Array
    off: Array
    sigma: float
    tau: float
    evaluations: int

    def value(self, name: str) -> float:
        return float(self.x[self.names.index(name)])

    def error(self, name: str) -> float:
        i = self.names.index(name)
        return math.sqrt(self.covariance[i, i])


def stretches(
    record: ForceCurve, kinds: Sequence[str], waves: Mapping[str, Wave] | None = None
) -> tuple[DirectionReadings, ...]:
    """The directions ``kinds`` of a record as the model takes them: rows within a jump belong to neither side and are
    left out. ``waves``: what was taken off the loads of the record and is to be fitted with the rest."""
    sides = [side for kind in kinds if (side := record.direction(kind)) is not None]
    return tuple(_stretch(record, side, (waves or {}).get(side.segment.kind)) for side in sides)


def _stretch(record: ForceCurve, side: Direction, wave: Wave | None) -> DirectionReadings:
    curve, rows = record.curve, np.arange(side.segment.first, side.segment.last + 1)
    assert curve.P is not None
    if side.segment.kind != APPROACH:
        rows = rows[::-1]
    jumped = bool(side.jumps) or (side.segment.kind != APPROACH and not isinstance(side.adhesion, Unknown))
    touching = np.zeros(rows.size, dtype=bool)
    keep = np.ones(rows.size, dtype=bool)
    if jumped:
        first, last = side.border
        touching[last:] = True
        keep[first + 1 : last] = False
    keep[rows.size - round(TUNING.turning * (rows.size - side.border[1])) :] = False
    z = curve.device[rows]
    P = curve.P[rows] if wave is None else curve.P[rows] + wave(z)
    t = np.zeros(len(curve)) if curve.t is None else curve.t - curve.t[int(np.argmax(curve.device))]
    return DirectionReadings(
        side.segment.kind, rows[keep], side.base, z[keep], P[keep], touching[keep], jumped, t[rows[keep]], wave
    )


def _scale(model: ForceCurveModel) -> Array:
    """The range of the load of its stretch [N], for every row."""
    return np.concatenate([np.full(part.P.size, float(np.ptp(part.P))) for part in model.stretches])


def _search(
    model: ForceCurveModel, x: Array, bounds: tuple[Array, Array], blunt: float, enough: float, loss: Loss = "linear",
    width: float = 1.0,
) -> Any:  # fmt: skip
    """SciPy's least squares of the loads over the range of their stretch, from ``x`` on, or the least sum of a robust
    ``loss`` that turns at ``width`` of that range."""
    scale = _scale(model)
    held: list[tuple[Array, Array, Array]] = []

    def at(x: Array) -> tuple[Array, Array]:
        if not (held and np.array_equal(held[0][0], x)):
            held[:] = [(x.copy(), *model.residuals(x, blunt))]
        return held[0][1] / scale, held[0][2] / scale[:, None]

    return least_squares(
        lambda x: at(x)[0], x, lambda x: at(x)[1], bounds=bounds, x_scale="jac", loss=loss, f_scale=width,
        ftol=enough, xtol=enough, gtol=enough, max_nfev=TUNING.evaluations,
    )  # fmt: skip


def fit(model: ForceCurveModel, start: Array, near: bool = False, loss: Loss = "linear") -> ForceCurveFit:
    """The unknowns that leave least, first with a blunt fold unless ``start`` is ``near``, then as it is; SolveError
    where no search converges."""
    bounds = _bounds(model, start)
    x, sharp = np.clip(start, *bounds), TUNING.blunt[-1]
    for blunt in () if near else TUNING.blunt[:-1]:
        x = _search(model, x, bounds, blunt, TUNING.about).x
    found = _search(model, x, bounds, sharp, TUNING.converged)
    if found.status <= 0:  # of few rows at the fold each makes a kink, between which a search runs to and fro
        found = _search(model, found.x, bounds, sharp, TUNING.about)
    scale, width = _scale(model), 1.0
    for _ in range(2 * (loss != "linear")):
        width = TURNS[loss] * robust_scale(model.residuals(found.x, sharp)[0] / scale)
        found = _search(model, found.x, bounds, sharp, TUNING.about, loss, width)
    if found.status <= 0:
        raise SolveError(f"the fit did not converge in {TUNING.evaluations} steps")
    x = found.x
    off = model.residuals(x, sharp)[0]
    J = model.residuals(x, 0.0)[1]  # where the fold lies between two rows, the data do not tell
    psi, slope = influence(off / (scale * width), loss)
    pull = psi * scale * width / max(float(np.mean(slope)), 0.1)  # what a row pulls with (Huber 1981, Sec. 7.6)
    sigma = math.sqrt(float(pull @ pull) / max(off.size - x.size, 1))
    spread = covariance(pull, J, [part.P.size for part in model.stretches])
    return ForceCurveFit(model, model.names, x, spread.covariance, off, sigma, spread.tau, int(found.nfev))


def unasked_drift(found: ForceCurveFit) -> tuple[float, float, float]:
    """Speed of a drift of z0 [m/s] that was not fitted, its standard error, and the change of ln s that it would bring:
    one step of a search that knows it."""
    model = replace(found.model, drifting=True)
    values = found.model.values(found.x) | {"drift": 0.0}
    x = np.array([values[name] for name in model.names])
    off, J = model.residuals(x, 0.0)
    scale = _scale(model)
    step = -np.linalg.lstsq(J / scale[:, None], off / scale, rcond=None)[0]
    spread = covariance(off + J @ step, J, [part.P.size for part in model.stretches])
    i = model.names.index("drift")
    change = float(step[model.names.index("ln_s")]) if "ln_s" in model.names else 0.0
    return float(step[i]), math.sqrt(max(float(spread.covariance[i, i]), 0.0)), change


def _bounds(model: ForceCurveModel, start: Array) -> tuple[Array, Array]:
    """Least and largest unknowns of a search from ``start`` on."""
    least, most = (math.log(s) if s > 0 else -math.inf for s in model.moduli)
    low, high = model.ends
    names = np.array(model.names, dtype=str)
    adhesive = np.char.startswith(names, "q:")
    reach = np.select([names == "ln_s", names == "ln_period"], [TUNING.moduli, TUNING.periods], np.inf)
    lowest, highest = np.where(adhesive, low, start - reach), np.where(adhesive, high, start + reach)
    of_s = names == "ln_s"
    return np.where(of_s, np.maximum(lowest, least), lowest), np.where(of_s, np.minimum(highest, most), highest)


def start(model: ForceCurveModel) -> Array:
    """Unknowns to begin with: shapes w/s and contact points are tried; for each of them the rest is linear."""
    i = int(np.argmax(model.adhesive))
    part = model.stretches[i]
    rows = _some_rows(part)
    net = part.P[rows] - part.line(part.z[rows])
    if part.wave is not None:
        net -= part.wave(part.z[rows])
    delta = part.z[rows] - net / model.k
    u = np.linspace(model.family.low - TUNING.below, model.family.high + TUNING.beyond, TUNING.nodes)
    (D, T, H, V), _, _ = model.family.at(u)
    known, work = model.known.get("ln_s"), model.works.get(part.kind)
    best = (math.inf, 0.0, 0.0, 0.0)
    for r in _shapes(D, T) if model.adhesive[i] else (0.0,):
        path, load = D - r * T, H - r * V
        fold = int(np.argmin(path))
        zeros = _contact_points(part, delta, rows, float(path[fold]))
        basis = np.interp(delta - zeros[:, None], path[fold:], load[fold:], left=0.0 if not part.jumped else None)
        if part.jumped:
            basis = np.where(part.touching[rows], basis, 0.0)
        size = np.sum(basis**2, axis=1)
        factors = basis @ net / np.where(size > 0, size, np.inf)
        if known is not None or work is not None:
            factors[:] = math.exp(known) if known is not None else work / r**2 if work and r else 0.0
        costs = np.sum((net - factors[:, None] * basis) ** 2, axis=1)
        at = int(np.argmin(np.where(factors > 0, costs, np.inf)))
        if factors[at] > 0 and costs[at] < best[0]:
            best = (float(costs[at]), float(factors[at]), float(zeros[at]), float(r))
    _, s, zero, r = best
    if s == 0:
        raise SolveError("no curve of this body resembles the record")
    values = {"ln_s": math.log(s), "z0": zero, "drift": 0.0}
    for other in model.stretches:
        values[f"offset:{other.kind}"] = float(other.line(other.z[0]))
        values[f"tilt:{other.kind}"] = other.line.tilt
        values[f"q:{other.kind}"] = r**2
        if other.wave is not None:
            values["ln_period"] = math.log(other.wave.period)
            values |= {f"cos:{other.kind}": other.wave.cos, f"sin:{other.kind}": other.wave.sin}
    return np.array([values[name] for name in model.names])


def _some_rows(part: DirectionReadings) -> Array:
    """Rows spread evenly, half of them where contact may be."""
    n = part.z.size
    if n <= TUNING.rows:
        return np.arange(n)
    near = int(np.argmax(part.touching)) if part.jumped else n // 2
    halves = [np.linspace(first, n - 1, TUNING.rows // 2) for first in (0, near)]
    return np.unique(np.concatenate(halves).astype(int))


def _shapes(D: Array, T: Array) -> Array:
    """Ratios sqrt(w/s): of almost no adhesion, and so that the shift is the displacement at radii across the series."""
    ratio = np.unique(D / T)
    return np.concatenate([[0.0], np.geomspace(ratio[0], ratio[-1], TUNING.shapes)])


def _contact_points(part: DirectionReadings, delta: Array, rows: Array, fold: float) -> Array:
    """Displacements tried as zero; with a jump about that for which its first row in contact lies at the fold."""
    span = float(np.ptp(delta))
    if not part.jumped:
        return np.linspace(delta.min(), delta.max() - 0.01 * span, TUNING.points)
    first = float(delta[part.touching[rows]][0])
    steps = span * np.geomspace(1e-4, 0.5, TUNING.points // 3)
    return first - fold + np.concatenate([-steps, [0.0], steps])
