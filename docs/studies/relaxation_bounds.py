"""Intervals of fits of relaxation against the truth of made records: ``make relaxation-bounds SEED=7``.

Records of a half-space and two bonded layers, by rings stepped through time, which know nothing of the theorem that the
fit rests on; 1 % noise on what is held and on the load, lengths of 3 to 30 relaxation times, with a wait. How many of
the 95 % intervals of E*, ratio and time hold, and the mean square of the errors in standard errors.
"""

from __future__ import annotations

import sys
from collections import defaultdict
from dataclasses import dataclass
from typing import Any

import numpy as np
from relaxation_records import record  # type: ignore[import-not-found]

import jkrcli as jkr
from jkrcli.adhesion.curve import Nonadhesive
from jkrcli.base.errors import JkrError
from jkrcli.measured.forward_model import FittedBody, body_of
from jkrcli.viscoelastic.relaxation import Depths
from jkrcli.viscoelastic.relaxation_fit import relaxation_fit
from jkrcli.viscoelastic.timed_record import relaxation_settings

TRUTH = {"E_star": 1.0, "ratio": 0.25, "time": 1.0}


@dataclass(frozen=True)
class Records:
    """How the records are made; times in relaxation times."""

    lengths: tuple[float, ...] = (3.0, 6.0, 12.0, 30.0)  # choice: what records last
    rise: float = 0.4  # choice: of a press and of a retraction
    shown: int = 20  # choice: records between two reports


RECORDS = Records()


def bodies() -> list[FittedBody]:
    """The half-space, and layers of thickness R/2 and 2 R, of E* = 1 and R = 1."""
    layers = (jkr.Specimen((jkr.Layer(jkr.Elastic(0.75, 0.5), h),), jkr.Rigid(True)) for h in (0.5, 2.0))
    specimens = (jkr.Specimen((), jkr.HalfSpace(jkr.Elastic(1.0, 0.0))), *layers)
    loading = jkr.Loading("depth", 1.3)
    return [body_of(jkr.solve(jkr.Problem(jkr.Paraboloid(1.0), specimen, loading))) for specimen in specimens]


def main(seed: int, count: int) -> None:
    """Fit ``count`` records and tell how the intervals hold."""
    held, clean = bodies(), dict[Any, Any]()
    loads = [Depths(Nonadhesive(body.series, body.slopes)).loads for body in held]
    settings, found = relaxation_settings("sls"), defaultdict[str, list[tuple[bool, float]]](list)
    for i in range(count):
        body, length = i % len(held), RECORDS.lengths[i // len(held) % len(RECORDS.lengths)]
        corners = np.array([0.0, RECORDS.rise, length - RECORDS.rise, length]), np.array([0.0, 1.0, 1.0, 0.0])
        made = record(loads[body], 1.2, (0.25, (0.75,), (1.0,)), corners, seed=seed + i, zero=0.1, clean=clean)
        try:
            fit = relaxation_fit(held[body], made, settings)
        except JkrError as error:
            print(f"record {i}: {error}", flush=True)
            continue
        for name, true in TRUTH.items():
            item = fit.estimate(name)
            assert item.error is not None
            assert item.low is not None
            assert item.high is not None
            found[name].append((item.low <= true <= item.high, (item.value - true) / item.error))
        if (i + 1) % RECORDS.shown == 0:
            told(found)


def told(found: dict[str, list[tuple[bool, float]]]) -> None:
    """A line of what was found."""
    parts = []
    for name, pairs in found.items():
        inside, z = np.array(pairs, dtype=float).T
        parts.append(f"{name} {100 * inside.mean():.1f} % (mean z {z.mean():+.2f}, z^2 {np.mean(z**2):.2f})")
    print(f"{len(next(iter(found.values())))} records: {', '.join(parts)}", flush=True)


if __name__ == "__main__":
    main(int(sys.argv[1]), int(sys.argv[2]))
