"""Errors of the work of adhesion and of the contact radius, to first order."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ...adhesion.curve import Nonadhesive
from ...adhesion.slopes.result import TWO_SIDED_90
from ...series import Array


def errors(
    body: Nonadhesive, used: tuple[str, str], a: Array, w: Array, lag: Array, sigma: Mapping[str, float]
) -> dict[str, Array]:
    """90 % half-widths of "w" and "a", and of w by "noise" and by "slopes" alone, as far as they are known."""
    by_noise, by_slopes = _gradients(body, used, a, lag)
    held = body.slopes.covariance
    covariance = None if held is None else body.between(held, a)
    found: dict[str, dict[str, Array]] = {"w": {}, "a": {}}
    for target, unit in (("w", w), ("a", np.ones_like(a))):
        if any(sigma.values()) and by_noise[target]:
            squares = [(gradient * sigma[name]) ** 2 for name, gradient in by_noise[target].items()]
            found[target]["noise"] = TWO_SIDED_90 * unit * np.sqrt(np.sum(squares, axis=0))
        gradient = by_slopes[target]
        if covariance is not None and gradient is not None:
            variance = np.einsum("in,nij,jn->n", gradient, covariance, gradient)
            found[target]["slopes"] = body.slopes.quantile * unit * np.sqrt(variance)
    totals = {name: np.hypot.reduce(list(parts.values())) for name, parts in found.items() if parts}
    return totals | found["w"]


def _gradients(
    body: Nonadhesive, used: tuple[str, str], a: Array, lag: Array
) -> tuple[dict[str, dict[str, Array]], dict[str, Array | None]]:
    """Derivatives of log w and of a: by the measured quantities, and by (delta_H, P_H, S, S') as arrays (4, n)."""
    (_, _, S, dS, t), rates = body.with_rates(a)
    zero = np.zeros_like(a)
    if used == ("a", "P"):
        below = S * lag  # P_H - P
        noise = {"a": 2 * (rates.P_H / below - rates.S / S - rates.t / t), "P": -2 / below}
        return {"w": noise, "a": {}}, {"w": np.stack([zero, 2 / below, -2 / S, 1 / dS]), "a": None}
    along = 2 * (rates.delta_H / lag - rates.t / t)  # d(log w)/da at constant delta
    if used == ("a", "delta"):
        return {"w": {"a": along, "delta": -2 / lag}, "a": {}}, {
            "w": np.stack([2 / lag, zero, zero, 1 / dS]),
            "a": None,
        }
    slope = dS * lag  # -F': a moves by (S d(delta) - dP)/slope
    of_a = {"delta": S / slope, "P": -1 / slope}
    noise = {"delta": along * of_a["delta"] - 2 / lag, "P": along * of_a["P"]}
    by_fields = np.stack([-S / slope, 1 / slope, -lag / slope, zero])
    of_w = along * by_fields + np.stack([2 / lag, zero, zero, 1 / dS])
    return {"w": noise, "a": of_a}, {"w": of_w, "a": by_fields}
