"""Good and bad records of another kind than ``force_curves`` makes: sampled over time on a rounded ramp, digitised,
with coloured noise and creep at the turning point; and what a microscope writes when something is wrong."""

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from force_curves import Body, back_at, load_at
from layer_contact import half_space

BAD = ("no contact", "saturation", "step", "random", "several contacts")


@dataclass(frozen=True)
class Sample:
    """A paraboloid ``R`` [m] on ``body`` of ``E_star`` [Pa], ``w`` [J/m^2] receding and ``w_in`` advancing, a spring
    ``k`` [N/m], largest load ``top`` [N]."""

    R: float
    E_star: float
    w: float
    w_in: float
    k: float
    top: float
    body: Body = half_space

    @property
    def force(self) -> float:
        """The pull-off force of a half-space [N], a unit of loads."""
        return 1.5 * math.pi * self.w * self.R

    def load(self, z: np.ndarray, approach: bool) -> np.ndarray:
        """Load [N] of one direction at device positions ``z`` [m]."""
        if approach:
            return load_at(z, self.E_star, self.R, self.w_in, self.k, self.top, self.body)
        works = (self.w_in, self.w)
        return back_at(z, self.E_star, self.R, works, self.k, self.top, _position_of(self), self.body)


@dataclass(frozen=True)
class Motion:
    """Device positions ``z`` [m] over time, ``up`` while approaching; ``free`` [m]: where it starts."""

    z: np.ndarray
    up: np.ndarray
    free: float


def sample(rng: np.random.Generator, R: float, bodies: tuple[Body, ...] = (half_space,)) -> Sample:
    """A sample whose contact at pull-off is at most 0.2 R wide."""
    E_star = float(np.exp(rng.uniform(math.log(300), math.log(3e6))))
    radius = R * float(rng.uniform(0.02, 0.2))
    w = 8 * E_star * radius**3 / (9 * math.pi * R**2)
    force = 1.5 * math.pi * w * R
    k = 2 * E_star * radius * float(np.exp(rng.normal(0.0, 1.2)))
    body = bodies[int(rng.integers(len(bodies)))]
    return Sample(R, E_star, w, w * float(rng.uniform(0, 0.3)), k, force * float(rng.uniform(1.5, 8)), body)


def motion(rng: np.random.Generator, held: Sample) -> Motion:
    """Out and back with rounded ends, at times a pause; far enough for a base line on both sides of pull-off."""
    way = np.linspace(-50 * held.force / held.k, 50 * held.force / held.k, 2001)
    probe = held.load(way, False)
    fold = float(way[np.argmax(probe != 0)])
    turn = _position_of(held)
    free = fold - (turn - fold) * float(rng.uniform(0.5, 2.0))
    n = int(rng.integers(300, 6000))
    s = np.linspace(0, 1, n)
    sharp = float(rng.uniform(0.7, 1.0))
    ramp = free + (turn - free) * (sharp * s + (1 - sharp) * (1 - np.cos(math.pi * s)) / 2)
    pause = int(rng.choice([0, n // 8]))
    z = np.concatenate([ramp, np.full(pause, turn), ramp[::-1]])
    return Motion(z, np.arange(z.size) < n + pause, free)


def _position_of(held: Sample) -> float:
    """Device position [m] at the largest load."""
    high = held.top / held.k + (held.top / held.E_star / math.sqrt(held.R)) ** (2 / 3) + held.R * 0.01
    way = np.linspace(0, high, 4001)
    return float(np.interp(held.top, held.load(way, True), way))


def clean(held: Sample, moved: Motion) -> np.ndarray:
    """Loads [N] without dirt."""
    return np.where(moved.up, held.load(moved.z, True), held.load(moved.z, False))


def dirt(rng: np.random.Generator, held: Sample, moved: Motion) -> np.ndarray:
    """Offset, tilt, bent drift, drag, white and slow noise [N]."""
    n = moved.z.size
    t = np.linspace(0, 1, n)
    span = float(np.ptp(moved.z))
    slow = np.cumsum(rng.normal(size=n))
    slow = slow - np.polyval(np.polyfit(t, slow, 1), t)
    noise = held.force * float(np.exp(rng.uniform(math.log(0.002), math.log(0.03))))
    return (
        held.force * (rng.uniform(-20, 20) + rng.uniform(-0.3, 0.3) * moved.z / span)
        + held.force * rng.uniform(-0.05, 0.05) * t
        + held.force * rng.uniform(0, 0.1) * np.where(moved.up, 1, -1)
        + noise * rng.normal(size=n)
        + 0.2 * noise * slow / max(float(np.std(slow)), 1e-300)
    )


def digitised(P: np.ndarray, bits: int) -> np.ndarray:
    """Loads as a converter of ``bits`` over twice their range has them."""
    step = 2 * float(np.ptp(P)) / 2**bits
    return np.round(P / step) * step if step > 0 else P


def good(
    rng: np.random.Generator, R: float, bodies: tuple[Body, ...] = (half_space,)
) -> tuple[Sample, Motion, np.ndarray]:
    """A record that is what it should be: sample, motion, loads [N]."""
    held = sample(rng, R, bodies)
    moved = motion(rng, held)
    P = clean(held, moved) + dirt(rng, held, moved)
    return held, moved, digitised(P, int(rng.integers(13, 17)))


def bad(rng: np.random.Generator, R: float, kind: str) -> tuple[Sample, Motion, np.ndarray]:
    """A record with one thing wrong, a word of ``BAD``."""
    held = sample(rng, R)
    moved = motion(rng, held)
    P = SPOILT[kind](rng, held, moved)
    return held, moved, digitised(P, int(rng.integers(13, 17)))


def _no_contact(rng: np.random.Generator, held: Sample, moved: Motion) -> np.ndarray:
    waves = float(rng.choice([0.0, 0.1])) * held.force
    return dirt(rng, held, moved) + waves * np.sin(moved.z / np.ptp(moved.z) * rng.uniform(3, 20) + rng.uniform(0, 6))


def _saturated(rng: np.random.Generator, held: Sample, moved: Motion) -> np.ndarray:
    P = clean(held, moved) + dirt(rng, held, moved)
    low, high = float(P.min()), float(P.max())
    if rng.random() < 0.3:
        return np.maximum(P, low + rng.uniform(0.3, 0.8) * (float(np.median(P[:50])) - low))
    return np.minimum(P, high - rng.uniform(0.2, 0.6) * (high - float(np.median(P[:50]))))


def _step(rng: np.random.Generator, held: Sample, moved: Motion) -> np.ndarray:
    P = clean(held, moved) + dirt(rng, held, moved)
    first, last = float(moved.z.min()), float(moved.z[clean(held, moved) != 0].min())
    at = first + (last - first) * rng.uniform(0.25, 0.75)
    rows = (
        np.flatnonzero(~moved.up & (moved.z < at)) if rng.random() < 0.7 else np.flatnonzero(moved.up & (moved.z > at))
    )
    P[rows[0] :] += held.force * rng.uniform(0.3, 2) * rng.choice([-1, 1])
    return P


def _random(rng: np.random.Generator, held: Sample, moved: Motion) -> np.ndarray:
    n = moved.z.size
    kinds = (rng.normal(size=n), rng.uniform(size=n), np.cumsum(rng.normal(size=n)), rng.standard_cauchy(size=n))
    return held.force * kinds[int(rng.integers(len(kinds)))]


def _several(rng: np.random.Generator, held: Sample, moved: Motion) -> np.ndarray:
    """A second body beside the first and lower, a tether that breaks late, or a contact that is lost and made again."""
    P = clean(held, moved) + dirt(rng, held, moved)
    turn, which = float(moved.z.max()), rng.integers(3)
    if which == 0:
        lower = rng.uniform(0.2, 0.7) * turn
        size = rng.uniform(0.5, 1.5)
        beside = replace(held, R=held.R * size)
        return P + clean(beside, replace(moved, z=moved.z - lower))
    fold = float(moved.z[~moved.up & (clean(held, moved) != 0)].min())
    if which == 1:
        far = fold - (fold - moved.free) * rng.uniform(0.2, 0.6)
        return P - held.force * rng.uniform(0.3, 1.0) * (~moved.up & (moved.z < fold) & (moved.z > far))
    lost = turn * rng.uniform(0.3, 0.6), turn * rng.uniform(0.6, 0.8)
    return P - np.where(moved.up & (moved.z > lost[0]) & (moved.z < lost[1]), clean(held, moved), 0.0)


SPOILT: dict[str, Callable[[np.random.Generator, Sample, Motion], np.ndarray]] = dict(
    zip(BAD, (_no_contact, _saturated, _step, _random, _several), strict=True)
)
