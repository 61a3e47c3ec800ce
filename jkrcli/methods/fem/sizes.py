"""Where a mesh is fine: one law of element size over the body, and graded points along a line.

The law is a formula written once: it is evaluated on numbers, or written out as text for the mesh generator.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from ...base.errors import SolveError

Array = np.ndarray
FAR = 5.0  # reaches from the contact, beyond which the field is smooth


class Formula:
    """Text of an arithmetic expression in x and y that grows by the usual operators."""

    def __init__(self, text: str):
        self.text = text

    def __add__(self, other: Any) -> Formula:
        return Formula(f"({self.text}+{_text(other)})")

    def __sub__(self, other: Any) -> Formula:
        return Formula(f"({self.text}-{_text(other)})")

    def __rsub__(self, other: Any) -> Formula:
        return Formula(f"({_text(other)}-{self.text})")

    def __mul__(self, other: Any) -> Formula:
        return Formula(f"({self.text}*{_text(other)})")

    __radd__ = __add__
    __rmul__ = __mul__


def _text(value: Any) -> str:
    return value.text if isinstance(value, Formula) else f"({float(value)!r})"


def _largest(a: Any, b: Any) -> Any:
    if isinstance(a, Formula) or isinstance(b, Formula):
        return Formula(f"Max({_text(a)},{_text(b)})")
    return np.maximum(a, b)


def _smallest(a: Any, b: Any) -> Any:
    if isinstance(a, Formula) or isinstance(b, Formula):
        return Formula(f"Min({_text(a)},{_text(b)})")
    return np.minimum(a, b)


def _length(x: Any, y: Any) -> Any:
    if isinstance(x, Formula) or isinstance(y, Formula):
        return Formula(f"Sqrt({_text(x)}*{_text(x)}+{_text(y)}*{_text(y)})")
    return np.hypot(x, y)


@dataclass(frozen=True)
class SizeLaw:
    """Element size [m] at (r, z): fine along the contact 0 <= r <= reach, growing by ``growth`` per distance from it
    (``far_growth`` beyond ``FAR`` reaches, where the field is smooth).

    Along the contact the size is ``slope * max(|r - a0|, inner)``, or ``floor`` where that is larger.
    ``zones``: (extent, size) of squares around the origin, inside which the size stays below ``size`` [m].
    ``layers``: (top depth, thickness, size, largest size far from the contact) of layers with their own limit.
    ``corners``: (r, depth, size) of points where the field is singular: the size grows from there by ``growth``.
    """

    reach: float
    growth: float
    far_growth: float
    a0: float = 0.0
    inner: float = 0.0
    slope: float = 0.0
    floor: float = 0.0
    zones: tuple[tuple[float, float], ...] = ()
    layers: tuple[tuple[float, float, float, float], ...] = ()
    corners: tuple[tuple[float, float, float], ...] = ()

    def __call__(self, r: Any, z: Any) -> Any:
        """Size at radius ``r`` and height ``z <= 0`` (numbers, arrays, or formulas)."""
        near = _smallest(r, self.reach)
        offset = near - self.a0
        along = self.slope * _largest(_largest(offset, 0.0 - offset), self.inner)
        distance = _length(r - near, z)
        faster = (self.far_growth - self.growth) * _largest(distance - FAR * self.reach, 0.0)
        size = _largest(along, self.floor) + self.growth * distance + faster
        for limit in self._zone_limits(r, z):
            size = _smallest(size, limit)
        for layer in self.layers:
            size = _smallest(size, self._layer_limit(layer, r, z))
        for radius, depth, least in self.corners:
            size = _smallest(size, least + self.growth * _length(r - radius, z + depth))
        return size

    def _zone_limits(self, r: Any, z: Any) -> list[Any]:
        """Limit k holds inside square k and grows outwards from it."""
        outside = _largest(r, 0.0 - z)
        return [size + self.growth * _largest(outside - extent, 0.0) for extent, size in self.zones]

    def _layer_limit(self, layer: tuple[float, float, float, float], r: Any, z: Any) -> Any:
        """The layer's size inside it, growing with the distance from it and from the contact."""
        top, thickness, size, longest = layer
        above = _largest((0.0 - z) - (top + thickness), top + z)
        beyond = _largest(r - (self.reach + 2 * (top + thickness)), 0.0)
        sideways = _smallest(size + self.growth * beyond, longest)
        return sideways + self.growth * _largest(above, 0.0)

    def text(self) -> str:
        """The law as a formula in x = r and y = z."""
        return self(Formula("x"), Formula("y")).text


def graded_points(start: float, stop: float, size: Callable[[Array], Array]) -> Array:
    """Points from ``start`` to ``stop`` (both included) spaced by ``size`` to within rounding of their count.

    The point density 1/size is integrated exactly for a size that is linear between samples.
    """
    x = _samples(start, stop, size)
    h = size(x)
    if not (h > 0).all():
        raise SolveError(f"mesh: element size {h.min():g} m between {start:g} and {stop:g} m")
    step, rate = np.diff(x), np.diff(h) / np.diff(x)
    flat = np.abs(np.diff(h)) < 1e-9 * h[:-1]
    safe = np.where(flat, 1.0, rate)
    counts = np.where(flat, step / h[:-1], np.log(h[1:] / h[:-1]) / safe)
    total = np.concatenate([[0.0], np.cumsum(counts)])
    n = max(1, round(total[-1]))
    wanted = np.arange(1, n) * (total[-1] / n)
    i = np.clip(np.searchsorted(total, wanted, side="right") - 1, 0, step.size - 1)
    ahead = wanted - total[i]
    growth = np.where(flat[i], 0.0, safe[i] * ahead)  # a long flat stretch would overflow the other branch
    inner = x[i] + h[i] * np.where(flat[i], ahead, np.expm1(growth) / safe[i])
    return np.concatenate([[start], inner, [stop]])


def _samples(start: float, stop: float, size: Callable[[Array], Array]) -> Array:
    """Where the size law is looked at: evenly, and evenly in the logarithm from either end."""
    span = stop - start
    fractions = np.concatenate([np.linspace(0, 1, 201), np.geomspace(1e-7, 1, 201), 1 - np.geomspace(1e-7, 1, 201)])
    return np.unique(start + span * np.clip(fractions, 0, 1))


def expected_triangles(law: SizeLaw, width: float, depth: float) -> float:
    """About how many triangles of the sizes of ``law`` fill the rectangle 0 <= r <= width, -depth <= z <= 0
    (the generator makes an eighth more than equilateral ones)."""
    near = np.geomspace(1e-9, 1, 150) * max(width, depth)
    knots = [0.0, law.a0, law.reach, *(radius for radius, *_ in law.corners)]
    r = np.unique(np.clip(np.concatenate([k + sign * near for k in knots for sign in (-1, 1)] + [knots]), 0, width))
    downwards = [top + near for top in (0.0, *(top for top, *_ in law.layers))]
    upwards = [corner - near for _, corner, _ in law.corners]
    z = np.unique(np.clip(np.concatenate([*downwards, *upwards, [0.0, depth]]), 0, depth))
    density = 1 / law(r[:, None], -z[None, :]) ** 2
    return float(1.12 * 4 / np.sqrt(3) * np.trapezoid(np.trapezoid(density, z, axis=1), r))
