"""Which rows of a record that relaxes are fitted: means of many, and none of a retraction that adheres."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from ..base import ROWS, TINY, Array, show
from ..data import Curve
from .motion import corners, noise_of


@dataclass(frozen=True)
class RowsTuning:
    """Limits on rows."""

    most: int = 1_500  # choice: rows beyond which means of as few as possible are taken
    apart: float = 5.0  # theory: standard deviations by which a load stands out, as that of a contact does
    falls: float = 0.2  # choice: of the largest speed, at which a device goes back
    before: int = 5  # choice: rows before contact that make a base line


TUNING = RowsTuning()


def averaged(curve: Curve) -> Curve:
    """Means of neighbouring rows, where there are very many."""
    each = math.ceil(len(curve) / TUNING.most)
    if each == 1:
        return curve
    whole = slice(len(curve) // each * each)
    means = {name: getattr(curve, name)[whole].reshape(-1, each).mean(axis=1) for name in ("t", "delta", "P")}
    return replace(curve, a=None, segment=None, **means)


def without_adhesion(curve: Curve) -> tuple[Curve, tuple[str, ...]]:
    """The rows up to a retraction that pulls, and a flag on it, if any."""
    t, x = corners(curve.time, curve.device, noise_of(curve.device))
    slopes = np.diff(x) / np.diff(t)
    back = np.logical_and.accumulate(slopes[::-1] < -TUNING.falls * np.abs(slopes).max())
    begin = float(t[-1 - int(back.sum())])
    later = curve.time > begin
    pulls = float(np.min(curve.load[~later]) - np.min(curve.load[later], initial=math.inf))
    if pulls < TUNING.apart * noise_of(curve.load) or later.all():
        return curve, ()
    flag = (
        f"the retraction adheres, it pulls with {show(pulls, 'load')}: fitted without it, up to {show(begin, 'time')}"
    )
    return curve.rows(~later), (flag,)


def base_line(P: Array, x: Array, noise: float) -> tuple[str, ...]:
    """Which of "P0" and "tilt" the loads ``P`` before contact show, at places ``x``."""
    if P.size < TUNING.before:
        return ()
    shown = ["P0"] if abs(float(P.mean())) > TUNING.apart * noise / math.sqrt(P.size) else []
    about = x - x.mean()
    tilt = float(about @ P) / math.sqrt(max(float(about @ about), TINY))
    return (*shown, "tilt") if abs(tilt) > TUNING.apart * noise else tuple(shown)


def followed(t: Array, depth: Array) -> tuple[Array, Array]:
    """A motion by some of its places, that goes in up to its deepest and then out."""
    edges = np.unique(np.linspace(0, t.size, min(t.size, ROWS) + 1).astype(int))
    t, x = (np.add.reduceat(column, edges[:-1]) / np.diff(edges) for column in (t, depth))
    top = int(np.argmax(x))
    x = np.concatenate([np.maximum.accumulate(x[: top + 1]), np.minimum.accumulate(x[top:])[1:]])
    return t, x
