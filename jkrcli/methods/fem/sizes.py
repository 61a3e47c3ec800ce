"""Where a mesh is fine: one law of element size over the body, and graded points along a line.

The law is a formula written once: it is evaluated on numbers, or written out as text for the mesh generator.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any, ClassVar

import numpy as np
from numpy.lib.mixins import NDArrayOperatorsMixin

from ...base import AT_ONCE, ROUNDED, Array, Refusal, SolveError


@dataclass(frozen=True)
class CountTuning:
    """Where a law of sizes is looked at to count elements before they are made."""

    near: int = 150  # points towards a place of small sizes; choice: the count is then good to a few per cent
    points: int = 15_000  # of them together over all layers; choice: a thousand layers in a tenth of a second
    least_near: int = 40  # of them, however many layers; choice: the count is then good to a fifth
    least_across: int = 2  # points towards either side of a layer; choice: likewise


TUNING = CountTuning()


class Expression(NDArrayOperatorsMixin):
    """Text of an arithmetic expression, as which NumPy writes down the functions that are applied to it."""

    FORMS: ClassVar[dict[np.ufunc, str]] = {
        np.add: "({}+{})",
        np.subtract: "({}-{})",
        np.multiply: "({}*{})",
        np.maximum: "Max({},{})",
        np.minimum: "Min({},{})",
        np.hypot: "Sqrt({0}*{0}+{1}*{1})",
    }

    def __init__(self, text: str):
        self.text = text

    def __array_ufunc__(self, function: np.ufunc, method: str, *values: Any) -> Expression:
        texts = (value.text if isinstance(value, Expression) else f"({float(value)!r})" for value in values)
        return Expression(self.FORMS[function].format(*texts))


@dataclass(frozen=True)
class SizeLaw:
    """Element size [m] at (r, z): fine along the contact 0 <= r <= reach, growing by ``growth`` per distance from it
    (``far_growth`` from ``far`` reaches on, where the field is smooth).

    Along the contact the size is ``slope * max(|r - a0|, inner)``, or ``floor`` where that is larger.
    ``zones``: (extent, size) of squares around the origin, inside which the size stays below ``size`` [m].
    ``layers``: (top depth, thickness, size, largest size far from the contact) of layers with their own limit.
    ``corners``: (r, depth, size) of points where the field is singular: the size grows from there by ``growth``.
    """

    reach: float
    growth: float
    far_growth: float
    far: float
    a0: float = 0.0
    inner: float = 0.0
    slope: float = 0.0
    floor: float = 0.0
    zones: tuple[tuple[float, float], ...] = ()
    layers: tuple[tuple[float, float, float, float], ...] = ()
    corners: tuple[tuple[float, float, float], ...] = ()

    def __call__(self, r: Any, z: Any) -> Any:
        """Size at radius ``r`` and height ``z <= 0`` (numbers, arrays, or formulas)."""
        near = np.minimum(r, self.reach)
        offset = near - self.a0
        along = self.slope * np.maximum(np.maximum(offset, 0.0 - offset), self.inner)
        distance = np.hypot(r - near, z)
        faster = (self.far_growth - self.growth) * np.maximum(distance - self.far * self.reach, 0.0)
        size = np.maximum(along, self.floor) + self.growth * distance + faster
        for limit in self._limits(r, z):
            size = np.minimum(size, limit)
        return size

    def _limits(self, r: Any, z: Any) -> Iterator[Any]:
        """Upper limits of the size from zones (inside square k, growing outwards from it), layers and corners."""
        for extent, size in self.zones:
            yield size + self.growth * np.maximum(np.maximum(r, 0.0 - z) - extent, 0.0)
        for layer in self.layers:
            yield self._layer_limit(layer, r, z)
        for radius, depth, size in self.corners:
            yield size + self.growth * np.hypot(r - radius, z + depth)

    def _layer_limit(self, layer: tuple[float, float, float, float], r: Any, z: Any) -> Any:
        """The layer's size inside it, growing with the distance from it and from the contact."""
        top, thickness, size, longest = layer
        above = np.maximum((0.0 - z) - (top + thickness), top + z)
        beyond = np.maximum(r - (self.reach + 2 * (top + thickness)), 0.0)
        sideways = np.minimum(size + self.growth * beyond, longest)
        return sideways + self.growth * np.maximum(above, 0.0)

    def on_grid(self, r: Array, depth: Array) -> Array:
        """Sizes at all radii ``r`` (m,) and depths (n,), shape (m, n)."""
        rest = replace(self, layers=())(r[:, None], -depth)
        return np.minimum(rest, self._least_of_layers(r, depth)) if self.layers else rest

    def _least_of_layers(self, r: Array, depth: Array) -> Array:
        """The least of all layers' limits: they grow by one rate away from each layer, so that one pass downwards and
        one upwards carry the least along."""
        top, thickness, size, longest = np.array(self.layers).T
        bottom = top + thickness
        beyond = np.maximum(r[:, None] - (self.reach + 2 * bottom), 0.0)
        sideways = np.minimum(size + self.growth * beyond, longest)
        none = np.full((r.size, 1), np.inf)
        above = np.minimum.accumulate(np.hstack([none, sideways - self.growth * bottom]), axis=1)
        below = np.minimum.accumulate(np.hstack([sideways + self.growth * top, none])[:, ::-1], axis=1)[:, ::-1]
        i = np.searchsorted(top, depth, side="right") - 1
        under = depth > bottom[i]  # all layers
        own = np.where(under, np.inf, sideways[:, i])
        passed = np.minimum(above[:, i + under] + self.growth * depth, below[:, i + 1] - self.growth * depth)
        return np.minimum(own, passed)

    def coarser(self, factor: float, steepest: float) -> SizeLaw:
        """Every size ``factor`` times as large, but no growth above ``steepest``."""
        return replace(
            self,
            growth=min(self.growth * factor, steepest),
            far_growth=min(self.far_growth * factor, steepest),
            slope=self.slope * factor,
            floor=self.floor * factor,
            zones=tuple((extent, size * factor) for extent, size in self.zones),
            layers=tuple((top, t, min(size * factor, t), longest) for top, t, size, longest in self.layers),
            corners=tuple((r, depth, size * factor) for r, depth, size in self.corners),
        )

    def text(self) -> str:
        """The law as a formula in x = r and y = z."""
        return self(Expression("x"), Expression("y")).text


def graded_points(start: float, stop: float, size: Callable[[Array], Array]) -> Array:
    """Points from ``start`` to ``stop`` (both included) spaced by ``size`` to within rounding of their count.

    The point density 1/size is integrated exactly for a size that is linear between samples.
    """
    towards = np.geomspace(1e-7, 1, 201)  # either end
    x = np.unique(start + (stop - start) * np.concatenate([np.linspace(0, 1, 201), towards, 1 - towards]).clip(0, 1))
    h = size(x)
    if not (h > 0).all():
        raise SolveError(f"mesh: element size {h.min():g} m between {start:g} and {stop:g} m")
    step, rate = np.diff(x), np.diff(h) / np.diff(x)
    flat = np.abs(np.diff(h)) < ROUNDED * h[:-1]
    safe = np.where(flat, 1.0, rate)
    counts = np.where(flat, step / h[:-1], np.log(h[1:] / h[:-1]) / safe)
    total = np.concatenate([[0.0], np.cumsum(counts)])
    n = max(1, round(total[-1]))
    if n > AT_ONCE:
        raise Refusal(
            f"mesh: {n:,} points between {start:g} and {stop:g} of the contact's size, at most {AT_ONCE:,}: "
            "take a larger mesh.spacing or mesh.smallest, or a smaller mesh.width or specimen"
        )
    wanted = np.arange(1, n) * (total[-1] / n)
    i = np.clip(np.searchsorted(total, wanted, side="right") - 1, 0, step.size - 1)
    ahead = wanted - total[i]
    growth = np.where(flat[i], 0.0, safe[i] * ahead)  # a long flat stretch would overflow the other branch
    inner = x[i] + h[i] * np.where(flat[i], ahead, np.expm1(growth) / safe[i])
    return np.concatenate([[start], inner, [stop]])


@lru_cache(maxsize=32)  # every look at a method asks for it several times
def expected_triangles(law: SizeLaw, width: float, depth: float) -> float:
    """About how many triangles of the sizes of ``law`` fill the rectangle 0 <= r <= width, -depth <= z <= 0
    (the generator makes an eighth more than equilateral ones). Takes time linear in the number of layers.

    Between two points the size h is linear: the integral of 1/h^2 is their distance over the product of both sizes.
    """
    r, z = _looked_at(law, width, depth)
    rows = max(1, AT_ONCE // z.size)
    lines = np.concatenate([_along(law.on_grid(part, z), z) for part in np.split(r, range(rows, r.size, rows))])
    return float(1.12 * 4 / np.sqrt(3) * _along(1 / np.sqrt(lines), r))


def _along(size: Array, x: Array) -> Array:
    """Integral of 1/size^2 over ``x`` (n,), ``size`` (..., n)."""
    return np.sum(np.diff(x) / (size[..., 1:] * size[..., :-1]), axis=-1)


def _looked_at(law: SizeLaw, width: float, depth: float) -> tuple[Array, Array]:
    """Radii and depths at which a law is looked at to count elements: dense where its sizes may be small."""
    many = len(law.layers)
    near = np.geomspace(1e-9, 1, max(TUNING.least_near, min(TUNING.near, TUNING.points // max(many, 1))))
    near *= max(width, depth)
    knots = [0.0, law.a0, law.reach, *(radius for radius, *_ in law.corners)]
    r = np.concatenate([k + sign * near for k in knots for sign in (-1, 1)] + [knots])
    share = np.geomspace(1e-6, 0.5, max(TUNING.least_across, TUNING.near // max(many, 1)))
    tops, across = np.array(law.layers)[:, :2].T if many else np.zeros((2, 0))
    inside = tops + across * np.concatenate([[0.0], share, 1 - share])[:, None]
    ends = [0.0, *(tops + across)[-1:]]
    upwards = [corner - near for _, corner, _ in law.corners]
    z = np.concatenate([inside.ravel(), *(end + near for end in ends), *upwards, ends, [depth]])
    return np.unique(np.clip(r, 0, width)), np.unique(np.clip(z, 0, depth))
