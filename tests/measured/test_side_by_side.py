"""Curves of a map know nothing of each other."""

import math
from dataclasses import replace

import numpy as np
from force_curves import Instrument, record
from raw_records import BODY, R, read, usual

from jkrcli.base.executors import executor
from jkrcli.measured.curve import Curve
from jkrcli.measured.procedure import Failure, fit, fit_all
from jkrcli.measured.result import Fit


def cycle(seed: int) -> Curve:
    force, E_star = 1.5 * math.pi * 1e-4 * R, 1e4 * (1 + seed)
    columns = record(E_star, R, 3e-5, 1e-4, Instrument(0.05, 250, 1e-6, 3 * force, 0.01 * force), seed)
    return replace(read(columns, 0.05, "segment"), name=str(seed))


def numbers(found: Fit | Failure) -> list[object]:
    return [(item.name, item.value, item.error, item.low, item.high) for item in found.estimates]


def fitted(curves: list[Curve], workers: int = 1) -> dict[str, Fit | Failure]:
    with executor(workers) as pool:
        return dict(zip([one.name for one in curves], fit_all(BODY, curves, usual(), pool), strict=True))


def test_neither_order_nor_neighbours_change_a_fit() -> None:
    curves = [cycle(seed) for seed in range(3)]
    forth, back = fitted(curves), fitted(curves[::-1])
    for curve in curves:
        assert numbers(forth[curve.name]) == numbers(back[curve.name])
    assert numbers(forth["1"]) == numbers(fit(BODY, curves[1], usual()))


def test_a_poisoned_curve_changes_no_other() -> None:
    curves = [cycle(seed) for seed in range(2)]
    plain = fitted(curves)
    P = curves[0].load
    spoilt = [np.full(P.size, P[0]), np.minimum(P, P.min() + 0.01 * np.ptp(P)), 1e150 * P]
    poisoned = [replace(curves[0], name=f"spoilt {i}", P=bad) for i, bad in enumerate(spoilt)]
    with np.errstate(all="ignore"):
        beside = fitted([poisoned[0], curves[0], *poisoned[1:], curves[1]])
    for curve in curves:
        assert numbers(beside[curve.name]) == numbers(plain[curve.name])
    assert isinstance(beside["spoilt 0"], Failure)
