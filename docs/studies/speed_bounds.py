"""Intervals of joint fits of force curves at three speeds against the truth: ``make speed-bounds``.

Triples of one specimen each by equations that share no code with what is fitted (``tests/adhesive_curves.py``): a
standard solid of the time 1 on a half-space, w over the speed of the edge by w0 (1 + (v/v0)^n). The speeds of the
device are 5 to 10 times apart, the middle one 0.1 to 3; ratio 0.2 to 0.8, cohesive stress 0.15 to 1, n 0.25 to 0.6, v0
0.4 to 7 times the middle speed, lever 0.3 to 5 E* R, half of the curves with a hold, noise of 0.5 to 2 % of the
pull-off force, contact points, offsets and base lines of their own. How many of the 95 % intervals of each parameter
hold, and which triples are silent: off by more than three half-widths without a doubt.
``SEED COUNT``: of the first triple, and how many.
"""

from __future__ import annotations

import math
import pickle
import sys
import time
from pathlib import Path

import described_body  # type: ignore[import-not-found]
import numpy as np
from adhesive_curves import cycle, sampled, solid  # type: ignore[import-not-found]

import jkrcli as jkr
from jkrcli.base.errors import SolveError
from jkrcli.measured.curve import Curve
from jkrcli.measured.forward_model import body_of
from jkrcli.viscoelastic.shared_speeds import shared_speeds_fit
from jkrcli.viscoelastic.timed_record import relaxation_settings

W, ROWS, FREE, BACK = 0.01, 400, 0.15, 2.5  # choice: over E* R, rows in contact, ways before and behind over R
FINE = 0.25  # choice: of the usual steps and points of made curves


def log_uniform(rng: np.random.Generator, low: float, high: float) -> float:
    """Draw from ``low`` to ``high``, evenly over the logs."""
    return math.exp(rng.uniform(math.log(low), math.log(high)))


def drawn(rng: np.random.Generator) -> tuple[dict[str, float], list[Curve]]:
    """The truth and the three curves; ValueError where one of them cannot be made."""
    ratio, stress = rng.uniform(0.2, 0.8), log_uniform(rng, 0.15, 1)
    middle, apart = log_uniform(rng, 0.1, 3), log_uniform(rng, 5, 10)
    n, v0 = rng.uniform(0.25, 0.6), middle * math.exp(rng.uniform(-1, 2))
    k, noise, curves = log_uniform(rng, 0.3, 5), rng.uniform(0.005, 0.02), list[Curve]()
    for speed in (middle / apart, middle, middle * apart):
        hold = rng.uniform(0, 2) * (rng.random() < 0.5)
        depth = rng.uniform(0.05, 0.12)
        corners = [(0.0, -FREE), ((FREE + depth) / speed, depth)]
        corners += [(corners[-1][0] + hold, depth)] if hold else []
        corners += [(corners[-1][0] + (BACK + depth) / speed, -BACK)]
        made = cycle(W, stress, solid(ratio, 1.0), corners, k, fine=FINE, rate=(v0, n))
        if not math.isfinite(made.lost):
            raise ValueError("contact is not lost")
        lasting = made.lost - made.begun
        before, behind = rng.uniform(0.2, 1.0, 2)
        before = min(before, 0.12 / speed / lasting)
        t = made.begun + lasting / ROWS * (np.arange(-int(before * ROWS), ROWS + int(behind * ROWS)) + 0.5)
        z = np.interp(t, *np.array(corners).T)
        P = sampled(made, t) + noise * -made.P.min() * rng.standard_normal(t.size)
        curves.append(Curve(f"{speed:.3g} R/s", t=t - t[0], delta=z - P / k + 0.03, P=P, stiffness=k))
    return {"E_star": 1.0, "ratio": ratio, "time": 1.0, "w": W, "stress": stress, "v0": v0, "n": n}, curves


def kept(seed: int) -> tuple[dict[str, float], list[Curve]]:
    """A triple, made once; where one of its curves cannot be made the next one that is drawn."""
    path = Path(f"build/speeds/{seed}.pickle")
    path.parent.mkdir(parents=True, exist_ok=True)
    rng = np.random.default_rng(seed)
    while not path.exists():
        try:
            path.write_bytes(pickle.dumps(drawn(rng)))
        except ValueError as error:
            print(f"triple {seed}: drawn again, {error}", flush=True)
    found: tuple[dict[str, float], list[Curve]] = pickle.loads(path.read_bytes())
    return found


def main(seed: int, count: int) -> None:
    """Fit ``count`` triples and tell how the intervals hold."""
    body = body_of(jkr.parse_case(described_body.UNIT.format(depth=0.15)))
    inside, silent, seconds = dict[str, int](), list[int](), list[float]()
    for i in range(seed, seed + count):
        truth, curves = kept(i)
        begin = time.process_time()
        try:
            fit = shared_speeds_fit(body, curves, relaxation_settings("sls", rate="power"))
        except SolveError as error:
            print(f"triple {i}: {error}", flush=True)
            continue
        seconds.append(time.process_time() - begin)
        off = dict[str, float]()
        for name, true in truth.items():
            item = fit.estimate(name)
            inside[name] = inside.get(name, 0) + (item.low is not None and item.low <= true <= (item.high or math.inf))
            off[name] = (item.value - true) / (item.error or math.inf)
        silent += [i] * (max(map(abs, off.values())) > 3 * 1.96 and not fit.warnings)
        words = " ".join(f"{name} {fit.value(name):.4g} ({value:+.1f})" for name, value in off.items())
        print(f"triple {i}: {seconds[-1]:.0f} s, scatter {fit.scatter:.2f}, {words} {fit.warnings or ''}", flush=True)
    print({name: f"{many}/{count}" for name, many in inside.items()}, f"median {np.median(seconds):.0f} s, {silent = }")


if __name__ == "__main__":
    main(int(sys.argv[1]), int(sys.argv[2]))
