"""Force curves with the dirt of real instruments, written as the text files that instruments write; ``make dirt`` has
more kinds.

The mechanics are closed forms of their own: a paraboloid on a half-space (Johnson, Kendall and Roberts), the contact
line pinned after the reversal until G has come to w, jumps at the folds of a cantilever, attraction before contact
with the deflection that it makes. Shares no code with what reads them, nor with the other generators.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

Array = np.ndarray
Rng = np.random.Generator


@dataclass(frozen=True)
class Drawn:
    """A random specimen, tip and cantilever [SI]; ``noise`` [N] of a row, ``rows`` of a direction, ``far``: the free
    way over the way in contact."""

    E: float
    R: float
    w: float
    w_in: float
    k: float
    top: float
    noise: float
    rows: int
    far: float

    @classmethod
    def of(cls, rng: Rng, noise: tuple[float, float] = (-3.0, -2.0)) -> Drawn:
        R, E = 10 ** rng.uniform(-6.5, -4.5), 10 ** rng.uniform(2.5, 6.5)
        radius = R * rng.uniform(0.04, 0.15)  # at pull-off under load
        w = 8 * E * radius**3 / (9 * math.pi * R**2)
        force = 1.5 * math.pi * w * R
        w_in = w * 10 ** rng.uniform(-1.3, 0)
        k = 2 * E * radius * 10 ** rng.uniform(-0.7, 1)
        rows = int(rng.integers(500, 2500))
        return cls(E, R, w, w_in, k, force * rng.uniform(1.5, 6), force * 10 ** rng.uniform(*noise), rows,
                   rng.uniform(0.6, 2.5))  # fmt: skip

    @property
    def force(self) -> float:
        return 1.5 * math.pi * self.w * self.R

    @property
    def truth(self) -> dict[str, float]:
        return {"E_star": self.E, "w": self.w, "w_approach": self.w_in}

    def jkr(self, a: Array | float, w: float) -> tuple[Array, Array]:
        """Displacement [m] and load [N] at contact radii."""
        a = np.asarray(a)
        delta = a**2 / self.R - np.sqrt(2 * math.pi * w * a / self.E)
        return delta, 4 * self.E * a**3 / (3 * self.R) - np.sqrt(8 * math.pi * w * self.E * a**3)


@dataclass(frozen=True)
class Attracted:
    """An attraction of ``size`` [N] at contact over ``reach`` [m], exponential or by a power of the distance."""

    size: float = 0.0
    reach: float = 1.0
    power: bool = False

    def __call__(self, gap: Array) -> Array:
        x = np.maximum(gap, 0.0) / self.reach
        return -self.size * ((1 + x) ** -2 if self.power else np.exp(-x))


@dataclass(eq=False)
class Ramp:
    """Positions ``z`` [m] of the cantilever's base over the rows of both directions, in time, with loads ``P`` [N];
    ``into``: rows of the approach; ``lost``: the first row after pull-off; ``joined``: the first in contact."""

    z: Array
    P: Array
    into: int
    joined: int
    lost: int

    @property
    def free(self) -> Array:
        rows = np.arange(self.z.size)
        return (rows < self.joined) | (rows >= self.lost)


def branches(at: Drawn, drawn: Attracted) -> tuple[tuple[Array, Array], tuple[Array, Array]]:
    """Position and load on the way in, and on the way out, of a contact to the load ``top``: each from its fold on."""
    a = np.geomspace(1e-3, 1, 30000) * (
        3 * at.R * (at.top + 4 * at.force + 2 * math.sqrt(at.top * at.force)) / 4 / at.E
    ) ** (1 / 3)
    delta, P = at.jkr(a, at.w_in)
    end = int(np.searchsorted(P, at.top))
    delta, P, a_turn = delta[:end], P[:end], a[end - 1]
    z = delta + (P - drawn.size) / at.k
    fold = int(np.argmin(z))
    into = z[fold:], (P - drawn.size)[fold:]

    # Pinned: a constant, a straight line in delta until the punch's G = E (delta_H - delta)^2/(2 pi a) is w.
    S, release = 2 * at.E * a_turn, at.jkr(a_turn, at.w)[0]
    pinned = np.linspace(float(delta[-1]), min(float(release), float(delta[-1])), 2000)
    loads = P[-1] + S * (pinned - delta[-1])
    less = a[a <= a_turn]
    back, tension = at.jkr(less, at.w)
    delta = np.concatenate([back, pinned[::-1]])
    P = np.concatenate([tension, loads[::-1]]) - drawn.size
    z = delta + P / at.k
    fold = int(np.argmin(z))
    return into, (z[fold:], P[fold:])


def free_loads(at: Drawn, drawn: Attracted, z: Array) -> tuple[Array, float]:
    """Loads at positions before contact, deflected by the attraction, and the position at which it draws the tip in."""
    if drawn.size == 0:
        return np.zeros(z.size), 0.0
    gap = np.concatenate([np.linspace(0, 5, 20000), np.geomspace(5.001, 1e5, 4000)]) * drawn.reach
    P = drawn(gap)
    position = -gap + P / at.k
    # stable from the fold outwards: the position rises as the gap closes
    fold = int(np.argmax(position))
    outward, loads = position[fold:], P[fold:]
    return np.interp(z, outward[::-1], loads[::-1]), float(position[fold])


def path(at: Drawn, drawn: Attracted = Attracted()) -> Ramp:
    """A whole record without noise: evenly in, and evenly out."""
    into, out = branches(at, drawn)
    turn = float(into[0][-1])
    first = min(float(into[0][0]), float(out[0][0]))
    start = first - at.far * (turn - first) - 3 * drawn.size / at.k
    way = np.linspace(start, turn, at.rows)
    free, touch = free_loads(at, drawn, way)
    contact = way >= touch
    P_in = np.where(contact, np.interp(way, *into), free)
    held = way >= out[0][0]
    P_out = np.where(held, np.interp(way, *out), free)
    lost = at.rows + int(np.count_nonzero(held))
    return Ramp(np.concatenate([way, way[::-1]]), np.concatenate([P_in, P_out[::-1]]), at.rows,
                int(np.argmax(contact)), lost)  # fmt: skip


@dataclass(eq=False)
class Dirty:
    """A record as it is written: ``header`` lines, ``columns`` by their title, what the reader is told (``R``, k in the
    header), the ``truth`` of what it determines, and ``reasons``: words of which one is right where it is not
    "fitted"; ``options`` of the fit. ``rigid``: a device whose depth is measured; ``determined``: whether E* and w
    are, without further options."""

    at: Drawn
    columns: dict[str, Array]
    truth: dict[str, float]
    header: list[str]
    reasons: tuple[str, ...] = ()
    options: dict[str, object] = field(default_factory=dict)
    rigid: bool = False
    determined: bool = True

    def write(self, file: Path) -> None:
        rows = zip(*self.columns.values(), strict=True)
        lines = [*self.header, "\t".join(self.columns), *("\t".join(f"{value:.9g}" for value in row) for row in rows)]
        file.write_text("\n".join(lines) + "\n")


def recorded(rng: Rng, at: Drawn, way: Ramp, P: Array, z: Array | None = None, **more: object) -> Dirty:
    """The record of loads ``P`` with offset, tilt and white noise, at positions ``z`` as they are read."""
    z = way.z if z is None else z
    span = float(np.ptp(z))
    P = P + at.force * (rng.uniform(-3, 3) + rng.uniform(-0.1, 0.1) * z / span) + at.noise * rng.normal(size=z.size)
    return written(at, z, P, **more)


def written(at: Drawn, z: Array, P: Array, truth: dict[str, float] | None = None, **more: object) -> Dirty:
    t = np.arange(z.size) / at.rows
    columns = {"Time (s)": t, "Z Piezo (nm)": 1e9 * z + 2345.6, "Deflection (nm)": 1e9 * P / at.k}
    header = ["# instrument: Force Microscope", f"# spring constant: {at.k:.9g} N/m"]
    return Dirty(at, columns, at.truth if truth is None else truth, header, **more)  # type: ignore[arg-type]


# ---------------------------------------------------------------------- the kinds
def plain(rng: Rng) -> Dirty:
    at = Drawn.of(rng)
    way = path(at)
    return recorded(rng, at, way, way.P)


def levelled(rng: Rng, count: int) -> Dirty:
    """Levels that hold after pull-off and let go at once, each of 1 to 20 % of the pull-off force."""
    at = Drawn.of(rng)
    way = path(at)
    P, free = way.P.copy(), way.z.size - way.lost
    for share in rng.uniform(0.1, 0.9, count):
        P[way.lost : way.lost + round(share * free)] -= at.force * 10 ** rng.uniform(-2, math.log10(0.2)) / count
    return recorded(rng, at, way, P, reasons=("level", "tether", "several contacts", "step"))


def tether(rng: Rng) -> Dirty:
    return levelled(rng, 1)


def _attracted(rng: Rng, power: bool) -> Dirty:
    """2 to 30 % of the pull-off force over 0.05 to 0.5 of the free way."""
    at = Drawn.of(rng)
    bare = path(at)
    free = abs(float(bare.z[bare.joined] - bare.z[0]))
    drawn = Attracted(
        at.force * 10 ** rng.uniform(math.log10(0.02), math.log10(0.3)), free * rng.uniform(0.05, 0.5), power
    )
    way = path(at, drawn)
    return recorded(rng, at, way, way.P, reasons=("attraction", "before contact", "base line"))


def attraction(rng: Rng) -> Dirty:
    return _attracted(rng, False)


def van_der_waals(rng: Rng) -> Dirty:
    return _attracted(rng, True)


def saturated(rng: Rng) -> Dirty:
    """A detector's limit in the uppermost 1 to 60 % of the depth."""
    at = Drawn.of(rng)
    way = path(at)
    share = 10 ** rng.uniform(-2, math.log10(0.6))
    depth = (1 - share) * way.z.max() + share * way.z[way.joined]
    dirty = recorded(rng, at, way, way.P, reasons=("saturated",), determined=False)
    limit = float(np.interp(depth, way.z[: way.into], dirty.columns["Deflection (nm)"][: way.into]))
    dirty.columns["Deflection (nm)"] = np.minimum(dirty.columns["Deflection (nm)"], limit)
    return dirty


def saturated_tension(rng: Rng) -> Dirty:
    """A detector's limit in the tension: of 10 to 70 % of it."""
    at = Drawn.of(rng)
    way = path(at)
    dirty = recorded(rng, at, way, way.P, reasons=("saturated",), determined=False)
    read = dirty.columns["Deflection (nm)"]
    base = float(np.median(read[-20:]))
    dirty.columns["Deflection (nm)"] = np.maximum(read, base + rng.uniform(0.3, 0.9) * (read.min() - base))
    return dirty


def ringing(rng: Rng) -> Dirty:
    """The cantilever rings after its jumps, by the jump itself at first, over 10 to 80 rows."""
    at = Drawn.of(rng)
    way = path(at)
    P, rows = way.P.copy(), np.arange(way.z.size)
    for row in (way.joined, way.lost):
        jump, quality, period = P[row - 1] - P[row], rng.uniform(10, 80), rng.uniform(3, 12)
        later = rows[row:] - row
        P[row:] += rng.uniform(0.2, 0.9) * jump * np.exp(-later / quality) * np.cos(2 * math.pi * later / period)
    return recorded(rng, at, way, P, reasons=("ring", "noisy"))


def converter(rng: Rng) -> Dirty:
    """A converter of 20 to 300 steps over the pull-off force."""
    at = Drawn.of(rng)
    way = path(at)
    dirty = recorded(rng, at, way, way.P)
    step = 1e9 * at.force / at.k / 10 ** rng.uniform(math.log10(20), math.log10(300))
    dirty.columns["Deflection (nm)"] = np.round(dirty.columns["Deflection (nm)"] / step) * step
    return dirty


def second_contact(rng: Rng) -> Dirty:
    """A weak second contact, by a spring that is stretched on after pull-off and then lets go."""
    at = Drawn.of(rng)
    way = path(at)
    rows = np.arange(way.z.size) - way.lost
    length = rng.uniform(0.1, 0.6) * (way.z.size - way.lost)
    size = at.force * 10 ** rng.uniform(math.log10(0.02), math.log10(0.3))
    P = way.P - np.where((rows >= 0) & (rows < length), size * (0.3 + 0.7 * rows / length), 0.0)
    return recorded(rng, at, way, P, reasons=("several contacts", "step", "level", "tether", "second contact"))


def sparse(rng: Rng) -> Dirty:
    """60 to 200 rows a direction: jumps between two of them."""
    at = replace(Drawn.of(rng), rows=int(rng.integers(60, 200)))
    way = path(at)
    return recorded(rng, at, way, way.P)


def noisy(rng: Rng) -> Dirty:
    """Noise of 10 to 30 % of the pull-off force."""
    at = Drawn.of(rng, noise=(-1.0, -0.5))
    way = path(at)
    return recorded(rng, at, way, way.P, reasons=("noisy", "vague"))


KINDS: dict[str, Callable[[Rng], Dirty]] = {
    "tether": tether,
    "attraction": attraction,
    "van der Waals tail": van_der_waals,
    "saturated": saturated,
    "saturated tension": saturated_tension,
    "ringing": ringing,
    "coarse converter": converter,
    "second contact": second_contact,
    "sparse": sparse,
    "large noise": noisy,
}
