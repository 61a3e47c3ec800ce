"""Records of bodies that relax, made by rings stepped through time, with noise on what is held and what that makes."""

from collections.abc import Callable

import numpy as np
from relaxing_rings import stepped

from jkrcli.base.numerics import Array
from jkrcli.measured.curve import Curve

RINGS, STEPS = 400, 1500


def record(
    loads: Callable[[Array], Array], deepest: float, modes: tuple[float, tuple[float, ...], tuple[float, ...]],
    corners: tuple[Array, Array], rows: int = 300, noise: float = 0.01, seed: int = 0, stiffness: float = np.inf,
    zero: float = 0.0, clean: dict | None = None,
) -> Curve:  # fmt: skip
    """t, delta, P of a device that moves between ``corners`` (t, x); ``noise`` over the range of each; ``clean``: keeps
    what the noise is added to, by the arguments of its making."""
    t, x = corners
    times = np.linspace(t[0], t[-1], STEPS + 1)
    key = (id(loads), deepest, modes, tuple(t), tuple(x), stiffness)
    held = {} if clean is None else clean
    if key not in held:
        held[key] = stepped(loads, deepest, modes, lambda s: np.interp(s, t, x), times, stiffness, RINGS)
    _, tip, P = held[key]
    at, rng = np.linspace(t[0], t[-1], rows), np.random.default_rng(seed)
    delta, load = (np.interp(at, times, column) for column in (tip, P))
    delta, load = (c + noise * np.ptp(c) * rng.standard_normal(rows) for c in (delta, load))
    return Curve("made", t=at, delta=delta + zero, P=load, stiffness=stiffness if 0 < stiffness < np.inf else None)
