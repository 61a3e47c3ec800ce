"""One statistical model of a whole force curve: base line, contact point, modulus and work of adhesion together.

The reading at device position z is that of a contact on its path (``device_path``) over a straight base line; all
scatter is in the load:

    reading(z) = offset + tilt (z - z_touch) + P(z - z0; s, w, k)

P is 0 where a row is free. On approach the edge advances with its own w; from the turning point on it rests, then
recedes with the w of the retraction. Where the retraction is alone, the root of the w of its approach is a share
``turn`` of its own. Each direction has its own base line (drag, drift of the load), on request with a wave c cos + s
sin of 2 pi (z - at)/period (``interference``). On request positions err by a drift, hysteresis or creep, 0 at the
turning point (``positions``): in one direction alone they cannot be separated from another modulus.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from ...base import Array
from ...data import APPROACH
from .coloured import Spectrum, in_time
from .device_path import Changes, DeviceBranch, Rest, branch, on_grid, rest
from .family import Family
from .force_curve_readings import DirectionReadings
from .interference import parts
from .positions import creep, hysteresis


@dataclass(frozen=True)
class ForceCurveTuning:
    """Which rows tell the noise, and what is remembered."""

    # tuned on raw records, by `make constants`: of the rows of a base line, those that tell the noise: contact begins
    # gently
    surely: float = 0.9
    remembered: int = 2  # theory: residuals at the same unknowns, with the fold as the search sees it and as it is


TUNING = ForceCurveTuning()


@dataclass(frozen=True, eq=False)
class ForceCurveModel:
    """The readings of some stretches on one body at a device of stiffness ``k`` [N/m], as a function of the unknowns.

    These are ln s, z0, the errors of ``positions``, the log of the period where there are waves, for each
    stretch its offset, tilt, cosine and sine of its wave, and q = w/s unless its w is one of ``works`` [J/m^2]; of an
    approach before a retraction that adheres its signed root instead, which the resting edge is smooth in; of a
    retraction alone the share ``turn``. ``known``: those that are not fitted, by name. ``moduli``: least and largest s.
    """

    family: Family
    k: float
    stretches: tuple[DirectionReadings, ...]
    known: Mapping[str, float] = field(default_factory=dict)
    works: Mapping[str, float] = field(default_factory=dict)
    moduli: tuple[float, float] = (0.0, math.inf)
    positions: tuple[str, ...] = ()

    @cached_property
    def rows(self) -> Array:
        """The rows of the record in all stretches."""
        return np.concatenate([part.rows for part in self.stretches])

    def ordered(self, columns: Array, noise: Spectrum) -> Array:
        """Columns of all rows as they were taken, where the order matters to the ``noise``."""
        return in_time(columns, self.rows, noise) if noise.slow else columns

    def whitened(self, columns: Array, noise: Spectrum) -> Array:
        """Columns of all rows so that a noise has unit variance and no colour."""
        return noise.whitened(self.ordered(columns, noise))

    @cached_property
    def names(self) -> tuple[str, ...]:
        """The unknowns in order; those of a stretch carry its kind."""
        names = (
            ["ln_s", "z0"]
            + list(self.positions)
            + ["ln_period"] * any(stretch.wave is not None for stretch in self.stretches)
        )
        for stretch in self.stretches:
            names += [f"offset:{stretch.kind}", f"tilt:{stretch.kind}"]
            names += [f"cos:{stretch.kind}", f"sin:{stretch.kind}"] * (stretch.wave is not None)
            names += [self.adhesion_of(stretch)] * (stretch.kind not in self.works)
            names += ["turn"] * (len(self.stretches) == 1 and stretch.kind != APPROACH and stretch.tension > 0)
        return tuple(name for name in names if name not in self.known)

    def adhesion_of(self, stretch: DirectionReadings) -> str:
        """The name of the unknown that w of a stretch comes from."""
        rests = stretch is not self.stretches[-1] and self.stretches[-1].tension > 0
        return f"r:{stretch.kind}" if rests else f"q:{stretch.kind}"

    @cached_property
    def most(self) -> float:
        """Largest q: of a curve that is pulled off at the end of the series."""
        _, (_, _, dH, dV), _ = on_grid(self.family)
        return 0.9 * float(dH[-1] / dV[-1]) ** 2

    @property
    def limits(self) -> Mapping[str, tuple[float, float]]:
        """Least and largest values of unknowns by name."""
        least, most = (math.log(s) if s > 0 else -math.inf for s in self.moduli)
        return {"ln_s": (least, most)}

    def further(self, values: Mapping[str, float]) -> dict[str, float]:
        """What other unknowns mean, SI, by name."""
        return {}

    def values(self, x: Array) -> dict[str, float]:
        """All unknowns by name, the known ones too, and q of each stretch."""
        values = {**self.known, **dict(zip(self.names, map(float, x), strict=True))}
        values |= {f"q:{kind}": w / math.exp(values["ln_s"]) for kind, w in self.works.items()}
        roots = {name: r for name, r in values.items() if name.startswith("r:")}
        return values | {f"q{name[1:]}": r * abs(r) for name, r in roots.items()}

    def unknowns(self, values: Mapping[str, float]) -> Array:
        """Those of some ``values`` by name, in order."""
        return np.array([values[name] for name in self.names])

    @cached_property
    def noise(self) -> float:
        """The largest noise of a base line [N]."""
        return max(part.line.noise for part in self.stretches)

    def depth(self, part: DirectionReadings, values: Mapping[str, float]) -> Array:
        """Position of the device beyond its zero [m], at all rows of a stretch."""
        depth: Array = part.z - values["z0"]
        for name, by in self.misplaced(part).items():
            depth += values[name] * by
        return depth

    def misplaced(self, part: DirectionReadings) -> dict[str, Array]:
        """How much deeper the rows of a stretch stand than they say, per amount of each error of positions [m]."""
        back = part.travel * (part.kind != APPROACH)
        shifts = {}
        for name in self.positions:
            if name == "drift":
                shifts[name] = -part.t
            elif name == "hysteresis":
                shifts[name] = back * hysteresis(part.way)
            else:
                shifts[name] = back * creep(np.maximum(part.t, 0.0) / part.lasting)
        return shifts

    def deepened(self, part: DirectionReadings, values: Mapping[str, float]) -> float:
        """How much deeper the device creeps while it waits before the way back, per amount [m]."""
        crept = part.waits > 0 and values.get("creep", 0.0) > 0
        return part.travel * float(creep(np.array(part.waits / part.lasting))) if crept else 0.0

    def branch(self, part: DirectionReadings, values: Mapping[str, float]) -> DeviceBranch:
        """The branch on which the edge of a stretch moves."""
        return branch(self.family, math.exp(values["ln_s"]), values[f"q:{part.kind}"], self.k)

    def rest(self, part: DirectionReadings, values: Mapping[str, float]) -> Rest | None:
        """The resting edge with which a stretch begins at the turning point."""
        root = math.sqrt(max(values[f"q:{part.kind}"], 0.0))
        first = self.stretches[0]
        if first is not part:
            before = values.get(f"r:{first.kind}", math.sqrt(max(values[f"q:{first.kind}"], 0.0)))
        elif "turn" in values:
            before = values["turn"] * root
        else:
            return None
        depth = part.turn - values["z0"] + values.get("creep", 0.0) * self.deepened(part, values)
        return rest(self.family, math.exp(values["ln_s"]), before, root, self.k, depth) if before < root else None

    def touching(self, part: DirectionReadings, values: Mapping[str, float], fold: float) -> Array:
        """Which rows of a stretch are in contact: those known to be, else those beyond first touch, or on the
        branch down to its ``fold`` [m]."""
        return part.touching if part.jumped else self.depth(part, values) > (0.0 if part.kind == APPROACH else fold)

    def contact_radii(self, part: DirectionReadings, values: Mapping[str, float]) -> tuple[Array, Array]:
        """Contact radius [m] at all rows of a stretch, 0 where they are free, and which of them are at rest."""
        moving, resting, z = self.branch(part, values), self.rest(part, values), self.depth(part, values)
        touching = self.touching(part, values, moving.fold)
        still = np.zeros_like(touching) if resting is None else touching & (z > resting.end)
        a = np.where(still, math.exp(resting.u), moving.radii(z)) if resting is not None else moving.radii(z)
        return np.where(touching, a, 0.0), still

    def calibrated(self, factor: float, of_stiffness: bool) -> ForceCurveModel:
        """The same of a device whose loads are ``factor`` times as large: by its stiffness, at the same deflections, or
        by its sensitivity, which its deflections follow."""
        parts = tuple(replace(part, P=factor * part.P, tension=factor * part.tension) for part in self.stretches)
        return replace(self, stretches=parts, k=factor * self.k if of_stiffness else self.k)

    def free(self, columns: Array) -> list[Array]:
        """Of columns of all rows, those of each stretch that surely are free, whatever the model says."""
        ends = np.cumsum([part.rows.size for part in self.stretches])[:-1]
        parts = zip(self.stretches, np.split(columns, ends), strict=True)
        return [column[: round(TUNING.surely * part.line.rows)] for part, column in parts]

    @cached_property
    def _residuals(self) -> dict[tuple[bytes, float], tuple[Array, Array]]:
        return {}

    def residuals(self, x: Array, blunt: float) -> tuple[Array, Array]:
        """Model minus reading [N] of all rows, and its derivatives by the unknowns, (rows, unknowns), both remembered.

        ``blunt``: share of the depth of contact over which the fold is blunt; 0: half the distance of two rows.
        """
        cache, key = self._residuals, (x.tobytes(), blunt)
        if key not in cache:
            if len(cache) >= TUNING.remembered:
                del cache[next(iter(cache))]
            cache[key] = self.evaluated(x, blunt)
        return cache[key]

    def evaluated(self, x: Array, blunt: float) -> tuple[Array, Array]:
        """The same anew."""
        values, names = self.values(x), {name: i for i, name in enumerate(self.names)}
        ends = np.cumsum([0] + [part.P.size for part in self.stretches])
        off, rates = np.empty(ends[-1]), np.zeros((x.size, ends[-1]))
        for part, first, last in zip(self.stretches, ends[:-1], ends[1:], strict=True):
            load, by = self._contact(part, values, blunt)
            line, by_line = base_line(part, values)
            off[first:last] = line + load - part.P
            for name, column in {**by, **by_line}.items():
                if name in names:
                    rates[names[name], first:last] = column
        return off, rates.T

    def off(self, x: Array, blunt: float) -> Array:
        """Model minus reading [N] of all rows."""
        values = self.values(x)
        parts = (base_line(part, values)[0] + self._load(part, values, blunt) - part.P for part in self.stretches)
        return np.concatenate([*parts])

    def by_position(self, x: Array) -> Array:
        """Derivative of the loads of all rows by their positions [N/m], the turn and the base lines where they are."""
        values = self.values(x)
        return np.concatenate([self._contact(part, values, 0.0)[1]["z"] for part in self.stretches])

    def _load(self, part: DirectionReadings, values: Mapping[str, float], blunt: float) -> Array:
        """Load of the contact at all rows of a stretch."""
        moving, resting, depth, rows, still = self._edges(part, values)
        P = np.zeros(depth.size)
        P[rows] = moving.load(depth[rows], blunt * part.reach if blunt else part.spacing / 2)
        if resting is not None:
            P[still] = resting.load(depth[still])
        return P

    def _edges(
        self, part: DirectionReadings, values: Mapping[str, float]
    ) -> tuple[DeviceBranch, Rest | None, Array, Array, Array]:
        """The branch and the resting edge of a stretch, the depth [m] of all rows, and the numbers of those at which
        the edge moves, and of those at which it rests."""
        moving, resting, depth = self.branch(part, values), self.rest(part, values), self.depth(part, values)
        rows = np.flatnonzero(self.touching(part, values, moving.fold))
        if resting is None:
            return moving, None, depth, rows, rows[:0]
        rests = depth[rows] > resting.end
        return moving, resting, depth, rows[~rests], rows[rests]

    def _contact(
        self, part: DirectionReadings, values: Mapping[str, float], blunt: float
    ) -> tuple[Array, dict[str, Array]]:
        """Load of the contact at all rows of a stretch, and its derivatives by name."""
        moving, resting, depth, rows, still = self._edges(part, values)
        own, q = f"q:{part.kind}", values[f"q:{part.kind}"]
        P, by = np.zeros(depth.size), np.zeros((3, depth.size))  # by ln s, own q, z
        P[rows], by[:, rows] = moving.at(depth[rows], blunt * part.reach if blunt else part.spacing / 2)
        by_s, by_q, by_z = by
        more: dict[str, Array] = {}
        if resting is not None:
            by_before, by_turn = np.zeros((2, depth.size))  # the root of q before, the turn
            P[still], (by_s[still], by_before[still], by_z[still], by_turn[still]) = resting.at(depth[still])
            root = math.sqrt(max(q, 1e-300))
            by_q += by_before * (values.get("turn", 0.0) / (2 * root))
            more = {"turn": by_before * root, **_by_advance(self.stretches[0], part, values, by_before)}
        elif part is self.stretches[0] and (name := f"r:{part.kind}") in values:
            more = {name: 2 * abs(values[name]) * by_q}
        by_z0 = -by_z if resting is None else -by_z - by_turn
        for name, misplaced in self.misplaced(part).items():
            more[name] = by_z * misplaced
            if name == "creep" and resting is not None:
                more[name] += by_turn * self.deepened(part, values)
        return P, {
            "ln_s": by_s - q * by_q if part.kind in self.works else by_s,
            "z": by_z,
            "z0": by_z0,
            own: by_q,
        } | more

    def by_body(self, x: Array, changes: Sequence[Changes | None]) -> Array:
        """Derivative of the loads of all rows by an amount of ``changes`` of the body, those of each stretch."""
        values, columns = self.values(x), []
        for part, change in zip(self.stretches, changes, strict=True):
            columns.append(column := np.zeros(part.z.size))
            if change is None:
                continue
            moving, resting, depth = self.branch(part, values), self.rest(part, values), self.depth(part, values)
            moves = self.touching(part, values, moving.fold)
            if resting is not None:
                still = moves & (depth > resting.end)
                column[still], moves = resting.by_body(depth[still], change), moves & ~still
            column[moves] = moving.by_body(depth[moves], part.spacing / 2, change)
        return np.concatenate(columns)


def _by_advance(
    first: DirectionReadings, part: DirectionReadings, values: Mapping[str, float], by_before: Array
) -> dict[str, Array]:
    """Derivatives of the load of a stretch at rest by q of the ``first`` one or its root, with which it came to the
    turn."""
    q = values[f"q:{first.kind}"]
    if part is first:
        return {}
    if f"r:{first.kind}" in values:
        return {f"r:{first.kind}": by_before}
    return {f"q:{first.kind}": by_before / (2 * math.sqrt(q))} if q > 0 else {}


def base_line(part: DirectionReadings, values: Mapping[str, float]) -> tuple[Array, dict[str, Array]]:
    """Load of the base line of a stretch at all its rows, and its derivatives by name."""
    along = part.z - part.z[0]
    line = values[f"offset:{part.kind}"] + values[f"tilt:{part.kind}"] * along
    by = {f"offset:{part.kind}": np.ones_like(along), f"tilt:{part.kind}": along}
    if part.wave is None:
        return line, by
    way, period = part.z - part.wave.at, math.exp(values["ln_period"])
    c, s = values[f"cos:{part.kind}"], values[f"sin:{part.kind}"]
    cos, sin = parts(way, period).T
    waves = {"ln_period": 2 * math.pi * way / period * (c * sin - s * cos), f"cos:{part.kind}": cos,
             f"sin:{part.kind}": sin}  # fmt: skip
    return line + c * cos + s * sin, by | waves
