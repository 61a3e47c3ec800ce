"""The contact radius that a displacement and a load mean on a body, for whatever work of adhesion (Eq. 13)."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from ...adhesion.curve import TUNING, Nonadhesive
from ...base.arrays import Array

STEPS, CONVERGED = 60, 1e-13  # halvings at worst; relative step
# What a measured row is: usable, or why it is not.
OK, NONE, BELOW, ABOVE = "ok", "no adhesion", "below the series", "above the series"


def contact_radius(body: Nonadhesive, delta: Array, P: Array) -> tuple[Array, Array]:
    """Contact radius [m] at each displacement [m] and load [N], and the state of each row (radius 0 where not OK).

    The radius solves F(a) = P_H - P - S (delta_H - delta) = 0. As P_H' = S delta_H', F' = -S' (delta_H - delta): F
    rises up to the nonadhesive contact at ``delta`` and falls beyond, where delta_H > delta. So there is one
    adhesive radius or none: one, if the load is below the nonadhesive load at the same displacement.
    """
    nodes = body.a
    before, last = _last_positive(body, delta, P)
    end = nodes.size - 1
    low, high = nodes[np.maximum(last, 0)].copy(), nodes[np.minimum(last + 1, end)]
    top = (last == before) & (0 <= before) & (before < end)  # F may rise above 0 between two nodes
    low[top] = _root(lambda a: (delta[top] - body.parts(a).delta_H, body.rates(a).delta_H), low[top], high[top])
    none = top & (_excess(body, low, delta, P)[0] < 0)
    below, above = last < 0, last == end
    for out, rows, node in ((below, below.copy(), nodes[0]), (above, above & (before < end), nodes[-1])):
        excess, fall = _excess(body, np.full(rows.sum(), node), delta[rows], P[rows])
        out[rows] = np.abs(excess) > TUNING.end * node * fall
    state = np.select([none, below, above], [NONE, BELOW, ABOVE], OK)
    a = low  # the very ends, but for round-off
    between = (state == OK) & (0 <= last) & (last < end)
    a[between] = _root(lambda a: _excess(body, a, delta[between], P[between]), low[between], high[between])
    return np.where(state == OK, a, 0.0), state


def _last_positive(body: Nonadhesive, delta: Array, P: Array) -> tuple[Array, Array]:
    """Of the nodes of the series the last with delta_H <= ``delta``, and the last with F > 0 beyond that, or that
    one (-1: none): by bisection, as F falls there."""
    delta_H, P_H, S, _, _ = body.parts(body.a)
    before = np.searchsorted(delta_H, delta, side="right") - 1
    low, high = before, np.full(delta.size, delta_H.size)
    while (high - low > 1).any():
        middle = np.maximum((low + high) // 2, 0)
        positive = P_H[middle] - P - S[middle] * (delta_H[middle] - delta) > 0
        open_ = high - low > 1
        low, high = np.where(open_ & positive, middle, low), np.where(open_ & ~positive, middle, high)
    return before, low


def _excess(body: Nonadhesive, a: Array, delta: Array, P: Array) -> tuple[Array, Array]:
    """F(a) [N] and -F'(a) [N/m]."""
    delta_H, P_H, S, dS, _ = body.parts(a)
    return P_H - P - S * (delta_H - delta), dS * (delta_H - delta)


def _root(falling: Callable[[Array], tuple[Array, Array]], low: Array, high: Array) -> Array:
    """The root of a falling function in each bracket: Newton's method, halving where that would leave the bracket.

    ``falling``: the function and minus its derivative.
    """
    a = (low + high) / 2
    for _ in range(STEPS):
        value, fall = falling(a)
        low, high = np.where(value > 0, a, low), np.where(value > 0, high, a)
        step = np.divide(value, fall, out=np.full_like(a, np.inf), where=fall > 0)
        new = np.where((a + step >= low) & (a + step <= high), a + step, (low + high) / 2)
        done = np.abs(new - a) <= CONVERGED * a
        a = new
        if done.all():
            break
    return a
