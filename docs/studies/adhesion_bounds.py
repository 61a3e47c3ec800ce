"""Intervals of fits of adhesive cycles on relaxing bodies against the truth: ``make adhesion-bounds SEED=7``.

Records of a half-space and a bonded layer by equations that share no code with the march that is fitted
(``tests/adhesive_records.py``); 2 % noise on the load. How many of the 95 % intervals of E*, ratio, time and w hold,
and how many records leave one of these undetermined, which the fit then says. ``FIRST LAST`` run a part of them.
"""

from __future__ import annotations

import sys
import time
from collections import defaultdict
from dataclasses import dataclass

import numpy as np
from adhesive_records import clean, record  # type: ignore[import-not-found]

import jkrcli as jkr
from jkrcli.base.errors import JkrError
from jkrcli.measured.forward_model import FittedBody, body_of
from jkrcli.viscoelastic.relaxation_fit import relaxation_fit, relaxation_settings

from .relaxation_bounds import told


@dataclass(frozen=True)
class Cycle:
    """A body and what is done to it: thickness over R of a bonded layer of nu = 1/2 (None: a half-space), w and stress
    over E* R and E*, ratio of the moduli, relaxation time 1, times of press, hold and retraction, noise."""

    h: float | None
    w: float
    stress: float
    ratio: float
    press: float
    hold: float
    back: float
    depth: float = 0.1
    noise: float = 0.02

    @property
    def nu(self) -> float | None:
        return None if self.h is None else 0.5


CYCLES = (  # choice: slow, fast, held long and shortly, soft and stiff edges
    Cycle(None, 0.01, 0.16, 0.3, 0.5, 1.0, 1.0),
    Cycle(0.5, 0.01, 0.35, 0.3, 0.5, 1.0, 1.0),
    Cycle(None, 0.005, 0.16, 0.2, 0.3, 3.0, 0.5),
    Cycle(None, 0.003, 0.2, 0.5, 1.0, 0.5, 2.0),
)


def body(cycle: Cycle) -> FittedBody:
    """The body of E* = 1 and R = 1."""
    specimen = jkr.Specimen((), jkr.HalfSpace(jkr.Elastic(1.0, 0.0)))
    if cycle.h is not None:
        specimen = jkr.Specimen((jkr.Layer(jkr.Elastic(0.75, 0.5), cycle.h),), jkr.Rigid(True))
    return body_of(jkr.solve(jkr.Problem(jkr.Paraboloid(1.0), specimen, jkr.Loading("depth", 0.15))))


def main(seed: int, first: int, last: int) -> None:
    """Fit the records ``first`` to ``last`` and tell how the intervals hold."""
    found, untold, refused = defaultdict[str, list[tuple[bool, float]]](list), 0, 0
    for i in range(first, last):
        cycle = CYCLES[i % len(CYCLES)]
        t = np.cumsum([0.0, cycle.press, cycle.hold, cycle.back])
        corners = tuple(zip(t.tolist(), (-0.15, cycle.depth, cycle.depth, -0.4), strict=True))
        modes = cycle.ratio, (1 - cycle.ratio,), (1.0,)
        made = record(clean(cycle.w, cycle.stress, modes, corners, cycle.nu, cycle.h or 1.0, 1.2), 300, cycle.noise,
                      seed + i, 0.03)  # fmt: skip
        begin = time.process_time()
        try:
            settings = relaxation_settings("sls", [("stress", f"{cycle.stress} Pa")], ["w"])
            fit = relaxation_fit(body(cycle), made, settings)
        except JkrError as error:
            refused += 1
            print(f"record {i}: {error}", flush=True)
            continue
        untold += any("determined" in doubt for doubt in fit.doubts)
        for name, true in {"E_star": 1.0, "ratio": cycle.ratio, "time": 1.0, "w": cycle.w}.items():
            item = fit.estimate(name)
            if item.error is not None and item.low is not None and item.high is not None:
                found[name].append((item.low <= true <= item.high, (item.value - true) / item.error))
        z = ", ".join(f"{name} {pairs[-1][1]:+.1f}" for name, pairs in found.items())
        seconds = time.process_time() - begin
        print(f"record {i}: {seconds:.0f} s, scatter {fit.scatter:.2f}, z {z}; {untold} undetermined, "
              f"{refused} refused", flush=True)  # fmt: skip
        told(found)


if __name__ == "__main__":
    main(*map(int, sys.argv[1:4]))
