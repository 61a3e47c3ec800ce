"""Intervals of fits of whole adhesive force curves on relaxing bodies against the truth: ``make adhesion-bounds``.

Records by equations that share no code with what is fitted (``tests/adhesive_curves.py``): 40 of each law of
relaxation (standard solid, two terms of Prony's series, a power law from a short time on), speed times relaxation time
over the radius 0.01 to 100, ratio of the moduli 0.1 to 0.9 (of a power law at the end of the contact, which lasts 10 to
1000 short times), Maugis' lambda of the relaxed modulus 2 to 50, lever 0.1 to 10 times the contact, half of them with a
hold, base lines of 0.2 to 3 times the way in contact, noise of 0.5 to 5 % of the pull-off force, half-space and bonded
layer. The cohesive stress is not told; it is w over 0.2 to 1 nm. How many of the 95 % intervals of w and of E*(t) at
five times within the record hold, and which are silent: off by more than three half-widths. ``SEED FIRST LAST`` run a
part.
"""

from __future__ import annotations

import math
import pickle
import sys
import time
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from adhesive_curves import Law, Made, cycle, power, sampled, solid  # type: ignore[import-not-found]

import jkrcli as jkr
from jkrcli.measured.curve import Curve
from jkrcli.measured.forward_model import FittedBody, body_of
from jkrcli.viscoelastic.relaxation_fit import relaxation_fit
from jkrcli.viscoelastic.timed_record import relaxation_settings

LAWS = ("sls", "prony", "power")
ROWS = 1000  # choice: in contact
TIMES = 5  # choice: within the record
RANGE = (0.2e-9, 1e-9)  # of dry contact [m]


@dataclass(frozen=True)
class Drawn:
    """A record: its law by name and as it is, w, stress, stiffness, layer, corners, base lines, noise; over R and
    E*."""

    name: str
    law: Law
    w: float
    stress: float
    stiffness: float
    h: float | None
    corners: tuple[tuple[float, float], ...]
    lines: tuple[float, float]
    noise: float
    ratio: float
    R: float
    words: str

    @property
    def body(self) -> FittedBody:
        """The body of E* = 1 Pa under a tip of the radius ``R`` [m], with which forces act over ``RANGE``."""
        specimen = jkr.Specimen((), jkr.HalfSpace(jkr.Elastic(1.0, 0.0)))
        if self.h is not None:
            specimen = jkr.Specimen((jkr.Layer(jkr.Elastic(0.75, 0.5), self.h * self.R),), jkr.Rigid(True))
        loading = jkr.Loading("depth", 0.05 * self.R)
        return body_of(jkr.solve(jkr.Problem(jkr.Paraboloid(self.R), specimen, loading)))


def drawn(i: int, seed: int) -> Drawn:
    """The ``i``-th record."""
    rng = np.random.default_rng([seed, i])
    name = LAWS[i % 3]
    speed, ratio = 10 ** rng.uniform(-2, 2), rng.uniform(0.1, 0.9)
    lam, soft, hold = 10 ** rng.uniform(math.log10(2), math.log10(50)), 10 ** rng.uniform(-1, 1), rng.random() < 0.5
    w = ratio * 10 ** rng.uniform(-4.5, -3)
    a0 = (w / ratio) ** (1 / 3)
    depth = a0**2 * rng.uniform(0.5, 5)
    rise = depth / speed
    held = rise * rng.uniform(0.3, 4) if hold else 0.0
    back = (depth + 6 * a0**2 * 3) / speed
    if name == "sls":
        law = solid(ratio, 1.0)
    elif name == "power":  # from a short time on, in units of which the contact lasts; the ratio is what is left then
        lasting = 10 ** rng.uniform(1, 3)
        law = power(-math.log(ratio) / math.log1p(lasting), 1.0, 20 * lasting)
        slower = lasting / (2 * rise + held)
        speed, rise, held, back = speed / slower, rise * slower, held * slower, back * slower
    else:
        part, more = rng.uniform(0.3, 0.7), rng.uniform(4, 20)
        law = Law(ratio, (1 - ratio) * np.array([part, 1 - part]), 1 / np.array([1.0, more]))
    stress = lam / 2 * (math.pi * w * (4 * ratio / 3) ** 2) ** (1 / 3)
    h = None if rng.random() < 0.5 else rng.uniform(0.5, 3) * math.sqrt(depth + a0**2)
    contact = 2 * math.sqrt(depth + a0**2) * (1.0 if h is None else 1 + (math.sqrt(depth + a0**2) / h) ** 2)
    stiffness = contact * soft
    reach = depth * (1 + 1 / soft)  # of the device, whose lever bends
    far = back * speed * (1 + 2 / soft)
    lines = rng.uniform(0.2, 3, 2)
    t = np.cumsum([0.0, (w / stress + reach) / speed + 1e-3 * rise, held, (reach + far) / speed])
    z = (-w / stress - 1e-3 * depth, reach, reach, -far)
    corners = tuple(c for k, c in enumerate(zip(t.tolist(), z, strict=True)) if k != 2 or held)
    words = (f"{name} V tau/R {speed:.3g} ratio {ratio:.2f} lambda {lam:.3g} lever {soft:.2g} "
             f"{'hold ' if held else ''}h {h if h is None else round(h / math.sqrt(depth + a0**2), 2)}")  # fmt: skip
    return Drawn(name, law, w, stress, stiffness, h, corners, (float(lines[0]), float(lines[1])),
                 10 ** rng.uniform(math.log10(0.005), math.log10(0.05)), ratio,
                 math.exp(rng.uniform(*np.log(RANGE))) * stress / w, words)  # fmt: skip


def made(one: Drawn) -> Made:
    """The cycle of a record without noise."""
    layer = (None, 1.0) if one.h is None else (0.5, one.h)
    found: Made = cycle(one.w, one.stress, one.law, one.corners, one.stiffness, *layer)
    return found


def record(one: Drawn, clean: Made, seed: int, lines: tuple[float, float] | None = None) -> Curve:
    """The readings with base lines (lengths over the way in contact) and noise."""
    before, behind = lines or one.lines
    rng = np.random.default_rng(seed)
    lasting = clean.lost - clean.begun
    dt = lasting / ROWS
    (t0, z0), (t1, z1), last = one.corners[0], one.corners[1], clean.lost
    speed = (z1 - z0) / (t1 - t0)
    way = speed * lasting / 2
    t = clean.begun + dt * np.arange(-int(before * way / speed / dt), ROWS + int(behind * way / speed / dt)) + dt / 3
    times, places = np.array(one.corners).T
    times = np.r_[times[0] - lasting * 9, times]
    places = np.r_[places[0] - speed * lasting * 9, places]
    times, places = np.r_[times, times[-1] + lasting * 9], np.r_[places, places[-1] - speed * lasting * 9]
    z = np.interp(t, times, places)
    P = sampled(clean, t)
    P = P + one.noise * -P.min() * rng.standard_normal(t.size)
    # the same noise in the rows of contact whatever the base lines
    inside = (t >= clean.begun) & (t <= last)
    P[inside] = sampled(clean, t)[inside] + one.noise * -sampled(clean, t).min() * np.random.default_rng(
        seed + 1).standard_normal(int(inside.sum()))  # fmt: skip
    delta, P, k = one.R * (z - P / one.stiffness), one.R**2 * P, one.R * one.stiffness
    return Curve("made", t=t - t[0], delta=delta, P=P, stiffness=k)


def kept(i: int, seed: int) -> tuple[Drawn, Made | str]:
    """The record without noise, made once."""
    folder = Path("build/adhesion")
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / f"{seed}-{i}.pickle"
    one = drawn(i, seed)
    if not path.exists():
        try:
            found: Made | str = made(one)
        except ValueError as error:
            found = str(error)
        path.write_bytes(pickle.dumps(found))
    return one, pickle.loads(path.read_bytes())


def main(seed: int, first: int, last: int) -> None:
    """Fit the records ``first`` to ``last`` and tell how the intervals hold."""
    inside, seconds, silent = dict.fromkeys(("w", "E(t)", "ratio", "time"), 0), [], []
    counted = dict.fromkeys(inside, 0)
    for i in range(first, last):
        one, clean = kept(i, seed)
        if isinstance(clean, str) or not math.isfinite(clean.lost):
            print(f"record {i}: not made: {clean if isinstance(clean, str) else 'not lost'}; {one.words}", flush=True)
            continue
        curve = record(one, clean, seed + 1000 + i)
        body = one.body
        begin = time.process_time()
        try:
            fit = relaxation_fit(body, curve, relaxation_settings(one.name, [], ["w"], 1.0))
        except Exception as error:
            print(f"record {i}: {type(error).__name__} {error}; {one.words}", flush=True)
            counted["w"] += 1
            counted["E(t)"] += TIMES
            continue
        seconds.append(time.process_time() - begin)
        t = np.geomspace(1 / 30, 0.9, TIMES) * (clean.lost - clean.begun)
        E, true = fit.modulus(t), one.law(t)
        w = fit.estimate("w")
        held = int(np.sum((E[:, 1] <= true) & (true <= E[:, 2])))
        inside["E(t)"] += held
        counted["E(t)"] += TIMES
        known = {"w": one.w * one.R} | ({"ratio": one.ratio, "time": 1.0} if one.name == "sls" else {})
        z = {}
        for name, value in known.items():
            item = fit.estimate(name)
            counted[name] += 1
            inside[name] += item.low is not None and item.high is not None and item.low <= value <= item.high
            z[name] = (item.value - value) / (item.error or math.inf)
        off = np.log(E[:, 0] / true) / np.maximum(np.log(E[:, 2] / E[:, 1]) / 3.92, 1e-12)
        silent += [i] * bool(max(abs(z["w"]), np.abs(off).max()) > 3 * 1.96)
        words = ", ".join(f"{name} {value:+.1f}" for name, value in z.items())
        at = " ".join(f"{value:+.1f}" for value in off)
        print(
            f"record {i}: {seconds[-1]:.1f} s, rows {len(curve)}, scatter {fit.scatter:.2f}, w off "
            f"{w.value / known['w'] - 1:+.1%}, z {words} E(t) {at}; {one.words} noise {one.noise:.3f}",
            flush=True,
        )
    counts = {name: f"{inside[name]}/{counted[name]}" for name in inside}
    print(counts, f"median {np.median(seconds):.1f} s, silent {silent}", flush=True)


if __name__ == "__main__":
    main(*map(int, sys.argv[1:4]))
