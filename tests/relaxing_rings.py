"""The unilateral problem of a body that relaxes, stepped through time: rings with internal variables.

The pressure is a sum of flat ends, ring k between two depths of the nonadhesive contact. Its displacement is the ring's
share of the depth while it touches, and follows from no load where it does not; its load relaxes by its own internal
variables. Nothing here knows when the contact turns or which time it remembers.
"""

from collections.abc import Callable, Sequence

import numpy as np

from jkrcli.base.numerics import Array


def stepped(
    loads: Callable[[Array], Array], deepest: float, modes: tuple[float, Sequence[float], Sequence[float]],
    hold: Callable[[Array], Array], times: Array, stiffness: float = np.inf, rings: int = 2000,
) -> tuple[Array, Array, Array]:  # fmt: skip
    """Depth of the contact, of the tip, and load at ``times``, even and many; ``loads``: P_H at depths up to
    ``deepest``; ``modes``: relaxed share, weights, rates; ``hold``: what the device of ``stiffness`` holds, 0 for a
    load."""
    relaxed, weights, rates = modes[0], np.array(modes[1])[:, None], np.array(modes[2])[:, None]
    edges = deepest * np.linspace(0, 1, rings + 1) ** 1.5
    shape, S = np.diff(edges), np.diff(loads(edges)) / np.diff(edges)
    h, inner, found = np.zeros(rings), np.zeros((rates.size, rings)), []
    for dt, x in zip(np.diff(times, prepend=times[0]), hold(times), strict=True):
        decay = np.exp(-rates * dt)
        gain = np.ones_like(rates) if dt == 0 else (1 - decay) / (rates * dt)
        past, now = np.sum(weights * (decay * inner - gain * h), 0), relaxed + np.sum(weights * gain, 0)
        free = np.minimum(-past / now, shape)  # the displacement of no load
        touching = S * (now * shape + past)  # the load of a ring that touches
        depth = np.append(0, np.cumsum(shape)) + np.append(np.cumsum(free[::-1])[::-1], 0)
        load = np.append(0, np.cumsum(touching))
        held = load if stiffness == 0 else depth + load / stiffness
        n = min(max(int(np.searchsorted(held, x)) - 1, 0), rings - 1)
        part = min(max((x - held[n]) / (held[n + 1] - held[n]), 0.0), 1.0)
        share = np.where(np.arange(rings) < n, 1.0, 0.0)
        share[n] = part
        new = free + share * (shape - free)
        inner, h = decay * inner + gain * (new - h), new
        tip = depth[n] + part * (depth[n + 1] - depth[n])
        touches = part > 0 or n > 0
        found.append(
            (edges[n] + part * shape[n], tip if touches or stiffness == 0 else x, load[n] + part * touching[n])
        )
    contact, tip, P = np.array(found).T
    return contact, tip, P
