"""Whole records of what is not in the model that reads them: layers, adhesion of range or of speed, relaxation, yield,
cones, creep of the device (``wrong_kinds`` of the studies has more). Shares no code with what reads them."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np
from force_curves import Instrument, equilibrium, record
from layer_contact import BondedLayer
from maugis import Maugis

ROWS = 1000
R = 5e-6


@dataclass(frozen=True, eq=False)
class Wrong:
    """Columns of a record and what the reader is told: stiffness ``k`` [N/m], tip radius ``R`` [m], nu of a layer
    ``h`` [m] or of a half-space; ``truth`` of E* and, where there is adhesion, w."""

    columns: dict[str, np.ndarray]
    k: float
    truth: dict[str, float]
    R: float = R
    h: float | None = None
    nu: float = 0.5
    families: tuple[str, ...] = field(default=())


@dataclass(frozen=True)
class Drawn:
    """A random half-space and device: contact of the widest ``radius`` [m] with less than 5 % of the load by adhesion
    up to half of it; noise [N] relative to the largest load."""

    E: float
    w: float
    radius: float
    k: float
    largest: float
    noise: float
    seed: int

    @classmethod
    def of(cls, rng: np.random.Generator, louder: float) -> Drawn:
        E, radius = 10 ** rng.uniform(3, 6), R * rng.uniform(0.15, 0.35)
        hertz = 4 * E * radius**3 / (3 * R)
        w = hertz * 10 ** rng.uniform(-1.5, -0.5) / (1.5 * math.pi * R)
        k = 2 * E * radius * 10 ** rng.uniform(-0.3, 1)
        noise = louder * hertz * 10 ** rng.uniform(-3.5, -3)
        return cls(E, w, radius, k, hertz, noise, int(rng.integers(1 << 30)))

    @property
    def device(self) -> Instrument:
        depth = self.radius**2 / R + self.largest / self.k
        return Instrument(self.k, ROWS, far=1.5 * depth, largest=self.largest, noise=self.noise,
                          offset=3 * self.noise, tilt=0.02 * self.largest / depth)  # fmt: skip

    @property
    def truth(self) -> dict[str, float]:
        return {"E_star": self.E, "w": self.w}


def read(
    at: Drawn, way: np.ndarray, into: np.ndarray, out: np.ndarray, moved: np.ndarray | float = 0.0
) -> dict[str, np.ndarray]:
    """A record of loads on the same positions ``way`` in and out, in order of the way in, with noise; the positions
    that are read on the way out are ``moved`` [m]."""
    rng, device = np.random.default_rng(at.seed), at.device
    z, P = np.concatenate([way, way[::-1]]), np.concatenate([into, out[::-1]])
    read_z = np.concatenate([way, (way + moved)[::-1]])
    P = P + device.offset + device.tilt * z + at.noise * rng.normal(size=z.size)
    return {"z": read_z, "P": P, "t": np.arange(z.size) / way.size}


def positions(at: Drawn, end: float) -> np.ndarray:
    return np.linspace(-at.device.far, end, ROWS)


def behind(at: Drawn, way: np.ndarray, delta: np.ndarray, P: np.ndarray) -> np.ndarray:
    """Loads at positions ``way`` of states (delta, P) along increasing z = delta + P/k behind the fold; 0 before."""
    z = delta + P / at.k
    fold = int(np.argmin(z))
    return np.where(way >= z[fold], np.interp(way, z[fold:], P[fold:]), 0.0)


def touched(at: Drawn, way: np.ndarray, delta: np.ndarray, P: np.ndarray) -> np.ndarray:
    """The same on the way in: contact from delta = 0 on."""
    return np.where(way >= 0, behind(at, way, delta, P), 0.0)


def right(at: Drawn) -> Wrong:
    w_in = at.w * np.random.default_rng(at.seed + 1).choice([0.0, 0.3, 1.0])
    return Wrong(record(at.E, R, w_in, at.w, at.device, at.seed), at.k, at.truth)


def layer(at: Drawn) -> Wrong:
    h = at.radius * np.random.default_rng(at.seed + 1).uniform(0.7, 3)
    return Wrong(record(at.E, R, at.w, at.w, at.device, at.seed, BondedLayer(h, 0.5)), at.k, at.truth,
                 families=("layer or substrate",))  # fmt: skip


def cone(at: Drawn) -> Wrong:
    """As deep at its widest contact radius as the paraboloid that it is read as, and there not pulled."""
    slope = 2 * at.radius / (math.pi * R)
    at = replace(at, w=min(at.w, at.E * at.radius**3 / (8 * math.pi * R**2)))
    pulled = 2 * at.radius * math.sqrt(2 * math.pi * at.w * at.radius * at.E)
    at = replace(at, largest=at.E * at.radius**3 / R - pulled)

    def body(a: np.ndarray, _: float) -> tuple[np.ndarray, ...]:
        return math.pi / 2 * slope * a, math.pi / 2 * slope * a**2, 2 * a, np.full(a.size, 2.0)

    return Wrong(record(at.E, R, at.w, at.w, at.device, at.seed, body), at.k, at.truth, families=("shape of the tip",))


def dmt(at: Drawn) -> Wrong:
    a = np.geomspace(1e-4, 1, 4000) * at.radius
    delta, P = a**2 / R, 4 * at.E * a**3 / (3 * R) - 2 * math.pi * at.w * R
    way = positions(at, float(delta[-1] + P[-1] / at.k))
    return Wrong(read(at, way, touched(at, way, delta, P), behind(at, way, delta, P)), at.k, at.truth,
                 families=("adhesion",))  # fmt: skip


def maugis(at: Drawn, tabor: float = 0.3) -> Wrong:
    """Adhesion of a range by Tabor's number."""
    exact = Maugis(R, at.E, at.w, 1.157 * tabor, 1 + np.geomspace(1e5, 1e-9, 20000))
    a = np.geomspace(1e-3, 1, 3000) * at.radius
    delta, P = (np.interp(a, exact.a, column) for column in (exact.delta, exact.P))
    way = positions(at, float(delta[-1] + P[-1] / at.k))
    return Wrong(read(at, way, touched(at, way, delta, P), behind(at, way, delta, P)), at.k, at.truth,
                 families=("adhesion",))  # fmt: skip


def rising_work(at: Drawn) -> Wrong:
    """w of the retraction rises to four times its first value as the contact shrinks; w is that in the middle."""
    a = np.linspace(1e-3, 1, 4000) * at.radius
    w = at.w * 4 ** (1 - a / at.radius) / 2
    both = []
    for work in (np.full(a.size, at.w / 2), w):
        delta = a**2 / R - np.sqrt(2 * math.pi * work * a / at.E)
        both.append((delta, 4 * at.E * a**3 / (3 * R) - np.sqrt(8 * math.pi * work * at.E * a**3)))
    (delta, P), back = both
    way = positions(at, float(delta[-1] + P[-1] / at.k))
    return Wrong(read(at, way, touched(at, way, delta, P), behind(at, way, *back)), at.k, {"E_star": at.E},
                 families=("adhesion",))  # fmt: skip


def hertzian(at: Drawn, radius: float) -> tuple[np.ndarray, np.ndarray]:
    """Depth and load without adhesion up to a radius."""
    a = np.geomspace(1e-5, 1, 6000) * radius
    delta = np.append(0.0, a**2 / R)
    return delta, np.append(0.0, 4 * at.E * a**3 / (3 * R))


def relaxing(at: Drawn, lost: float = 0.5, tau: float = 0.3) -> Wrong:
    """A standard linear solid under a stiff device that moves its depth, ``lost`` of its modulus after ``tau`` times
    the approach; E* at t = 0."""
    n = ROWS
    depth = at.radius**2 / R
    way = np.linspace(-1.5 * depth, depth, n)
    t = np.arange(n) / n
    delta = np.maximum(way, 0.0)
    law = 4 / 3 * at.E * math.sqrt(R)
    into = np.zeros(n)
    first = int(np.argmax(way > 0))
    times, depths = t[first:], delta[first:]
    dP = np.diff(law * depths**1.5, prepend=0.0)
    middle = np.append(times[0], (times[1:] + times[:-1]) / 2)

    def r(s: np.ndarray) -> np.ndarray:
        return 1 - lost + lost * np.exp(-s / tau)

    into[first:] = [float(r(now - middle[: i + 1]) @ dP[: i + 1]) for i, now in enumerate(times)]
    back_depths = depths[::-1]
    steps = np.concatenate([np.diff(depths, prepend=0.0), np.diff(back_depths, prepend=back_depths[0])])
    moments = np.concatenate([middle, times[-1] + np.arange(times.size) / n - 0.5 / n])
    out = np.zeros(times.size)
    for i in range(times.size):
        now = times[-1] + i / n
        sums = np.cumsum((r(now - moments) * steps * (moments <= now))[::-1])[::-1]
        before = np.flatnonzero(sums[: times.size] > 0)  # steps of the way in from which on the sum is above 0
        if i and not before.size:
            break
        last = int(before[-1]) if i else times.size - 1
        part = sums[last] / (sums[last] - sums[last + 1]) if i else 1.0
        share = np.append(np.ones(last), part)
        out[i] = float(r(now - middle[: last + 1]) @ (share * dP[: last + 1]))
    loads = np.zeros(n)
    loads[first:] = out[::-1]
    stiff = Drawn(at.E, 0.0, at.radius, 1e6 * at.E * at.radius, at.largest, at.noise, at.seed)
    columns = read(stiff, way, into, loads) | {"t": np.concatenate([t, t[-1] + t])}
    return Wrong(columns, stiff.k, {"E_star": at.E}, families=("relaxation or flow",))


def plastic(at: Drawn) -> Wrong:
    """Loading by Hertz, unloading from the same load to a residual depth; E* of the loading."""
    delta, P = hertzian(at, at.radius)
    rest = np.random.default_rng(at.seed + 1).uniform(0.1, 0.4) * delta[-1]
    back = P[-1] * np.maximum((delta - rest) / (delta[-1] - rest), 0.0) ** 1.5
    way = positions(at, float(delta[-1] + P[-1] / at.k))
    into, out = (np.interp(way, delta + one / at.k, one, left=0.0) for one in (P, back))
    return Wrong(read(at, way, into, out), at.k, {"E_star": at.E}, families=("relaxation or flow",))


def creep(at: Drawn) -> Wrong:
    """Over the time since the turn, and so over the way that was gone evenly."""
    return misplaced(at, lambda way, _: 0.01 * np.log1p(100 * way / 2))


def misplaced(at: Drawn, error: Callable[[np.ndarray, float], np.ndarray]) -> Wrong:
    """Positions of the way out in error, in units of the depth in contact: over the shares of the travel from the turn
    and that depth over the travel."""
    position, delta, P = equilibrium(at.E, R, at.w, at.k, at.largest)
    way = positions(at, float(position[-1]))
    travel = np.ptp(way)
    moved = position[-1] * error((way[-1] - way) / travel, float(position[-1] / travel))
    columns = read(at, way, touched(at, way, delta, P), behind(at, way, delta, P), moved)
    return Wrong(columns, at.k, at.truth, families=("instrument",))


WRONG: dict[str, Callable[[Drawn], Wrong]] = {
    "layer as half-space": layer, "DMT": dmt, "Maugis mu 0.3": maugis, "w rising to four times": rising_work,
    "relaxation": relaxing, "plastic": plastic, "cone": cone, "creep": creep,
}  # fmt: skip


def over_speed(at: Drawn, n: float = 0.4) -> Wrong:
    """w of the retraction by Gent and Schultz's law, w0 (1 + (v/v0)^n): da/dt by the energy release rate of JKR, one
    explicit step of the radius after the other at a device that moves back evenly."""
    a = np.linspace(1e-3, 1, 4000) * at.radius
    delta = a**2 / R - np.sqrt(2 * math.pi * at.w * a / at.E)
    P = 4 * at.E * a**3 / (3 * R) - np.sqrt(8 * math.pi * at.w * at.E * a**3)
    way = positions(at, float(delta[-1] + P[-1] / at.k))
    v0 = at.radius * 2.0  # over the time of one direction: w doubles at the usual speed of the edge
    fine = np.linspace(way[-1], way[0], 20 * ROWS)
    now, dt, loads = at.radius, 1 / fine.size, np.zeros(fine.size)
    for i, z in enumerate(fine):
        hertz, S = 4 * at.E * now**3 / (3 * R), 2 * at.E * now
        back = (now**2 / R - z + hertz / at.k) / (1 + S / at.k)
        loads[i] = hertz - S * back
        excess = at.E * back**2 / (2 * math.pi * now) / at.w - 1 if back > 0 else 0.0
        now -= dt * v0 * max(excess, 0.0) ** (1 / n)
        if now < 1e-2 * at.radius:
            loads[i:] = 0.0
            break
    columns = read(at, way, touched(at, way, delta, P), np.interp(way, fine[::-1], loads[::-1]))
    return Wrong(columns, at.k, at.truth, families=("adhesion",))


SPEED: dict[str, Callable[[Drawn], Wrong]] = {"w over the speed": over_speed}
