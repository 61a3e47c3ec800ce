"""From a body and the user's wishes to a grid: the layouts ``scaled`` and ``zones``, in triangles or quadrilaterals."""

from __future__ import annotations

import itertools
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from ...base.errors import Refusal
from .blocks import ringed_quads, tensor_quads
from .domain import Body
from .grid import Grid, make_grid
from .mesh import triangles
from .sizes import SizeLaw, expected_triangles, graded_points
from .strip import SHARE, Strip, strip_below

Array = np.ndarray
MAX_CELLS = 3_000_000
TOP_LAYER, DEEP_LAYER = 1.0, 2.0  # layer limits in units of growth * thickness
FAR_GROWTH, STEEPEST = 0.2, 0.6  # growth where the field is smooth, at most; and any
ZONE_III = 20.0  # units: depth of the paper's body; beyond it elements grow on
CORNER = 0.02  # size at a corner singularity, of growth times the body's smaller extent
LONGEST = 100.0  # cells in a layer far from the contact, in thicknesses
BEYOND = 4.0  # sizes at the reach: so far the strip below the surface goes on
BELOW, FAR_BELOW = 5 / 3, 4.0  # growth of a calibration's elements below the strip, in that of the body's
DIGITS = 12  # dimensionless lengths are rounded to this: the mesh does not depend on the unit of length


@dataclass(frozen=True)
class Layout:
    """A size law over a body, in units of ``unit`` [m]: what is needed to make a grid, and to coarsen it.

    ``sides``: (extent, size) along both sides of quadrilateral zones; ``fixed``: radii of the first surface vertices
    and ``thickest``: how deep the strip below them may be, both taken from another layout.
    """

    body: Body
    law: SizeLaw
    unit: float
    element: str
    sides: tuple[tuple[float, float], ...] = ()
    fixed: tuple[float, ...] = ()
    thickest: float | None = None

    def coarser(self, factor: float) -> Layout:
        """The same layout with every element ``factor`` times as large."""
        law = self.law
        return replace(
            self,
            law=replace(
                law,
                growth=min(law.growth * factor, STEEPEST),
                far_growth=min(law.far_growth * factor, STEEPEST),
                slope=law.slope * factor,
                floor=law.floor * factor,
                zones=tuple((extent, size * factor) for extent, size in law.zones),
                layers=tuple((top, t, min(size * factor, t), longest) for top, t, size, longest in law.layers),
                corners=tuple((r, depth, size * factor) for r, depth, size in law.corners),
            ),
            sides=tuple((extent, size * factor) for extent, size in self.sides),
        )

    def on(self, body: Body) -> Layout:
        """The same surface vertices in the contact, and strip below them, on another body without layers."""
        growth, far = (min(factor * self.law.growth, STEEPEST) for factor in (BELOW, FAR_BELOW))
        law = replace(self.law, layers=(), zones=(), corners=(), growth=growth, far_growth=far)
        surface = self._surface_points(self.body.width / self.unit)
        fixed = surface[: self._strip_width(surface)]
        return replace(self, body=body, law=law, sides=(), fixed=tuple(fixed.tolist()), thickest=self._thickest)

    def expected_cells(self) -> float:
        """About how many elements ``grid`` will make, without making them."""
        width, depth = self.body.width / self.unit, self.body.depth / self.unit
        if self.element == "triangle":
            return expected_triangles(self.law, width, depth)
        across = _expected_points(self._along_surface, width)
        corner = self._ring_start(width, depth, self.body.interfaces)
        if corner is None:
            return across * _expected_points(self._down, depth)
        inner = _expected_points(self._along_surface, corner)
        return inner * (2 * across - inner)

    def grid(self) -> Grid:
        """Mesh the body."""
        width, depth, interfaces = (
            _rounded(x / self.unit) for x in (self.body.width, self.body.depth, self.body.interfaces)
        )
        surface = self._surface_points(float(width))
        if self.element == "triangle":
            strip = self._strip(surface)
            return triangles(surface, float(depth), interfaces, self.law.text(), strip).scaled(self.unit)
        return self._quadrilaterals(surface, float(depth), interfaces).scaled(self.unit)

    def _along_surface(self, r: Array) -> Array:
        if self.sides:
            return np.interp(r, *_columns(self.sides))
        return self.law(r, np.zeros_like(r))

    def _surface_points(self, width: float) -> Array:
        """Radii of the surface vertices; the edge of a flat end, the reach, the end of the strip and the corners of
        the zones are among them, so that the vertices within the reach do not depend on the width."""
        knots = [self.law.a0, self.law.reach, self._strip_end, *(extent for extent, _ in self.sides)]
        start = self.fixed[-1] if self.fixed else 0.0
        stops = np.unique([start, *(x for x in knots if start < x < width * (1 - 1e-9)), width])
        parts = [graded_points(p, q, self._along_surface) for p, q in itertools.pairwise(stops)]
        return np.unique(np.concatenate([self.fixed, *parts]))

    @property
    def _strip_end(self) -> float:
        law = self.law
        return law.reach + BEYOND * float(self._along_surface(np.array([law.reach]))[0])

    def _strip_width(self, surface: Array) -> int:
        """Number of surface vertices of the strip; all where it would nearly reach the end of the body."""
        if self.fixed:
            return len(self.fixed)
        n = int(np.searchsorted(surface, self._strip_end * (1 + 1e-9)))
        return n if n + 1 < surface.size else surface.size

    @property
    def _thickest(self) -> float:
        """Most that the strip may take of the body or its top layer."""
        if self.thickest is not None:
            return self.thickest
        layers = self.body.layers or [(0.0, self.body.depth)]
        return SHARE * layers[0][1] / self.unit

    def _strip(self, surface: Array) -> Strip:
        return strip_below(surface[: self._strip_width(surface)], float(_rounded(self._thickest)))

    def _quadrilaterals(self, surface: Array, depth: float, interfaces: Array) -> Grid:
        corner = self._ring_start(surface[-1], depth, interfaces)
        if corner is None:
            stops = [0.0, *interfaces, depth]
            lines = [graded_points(p, q, self._down) for p, q in itertools.pairwise(stops)]
            return _structured(*tensor_quads(surface, _limited(surface, np.unique(np.concatenate(lines)))), interfaces)
        inner = surface[surface <= corner * (1 + 1e-9)]
        rings = surface[surface > corner * (1 + 1e-9)]
        across = np.log(rings / corner) / np.log(rings[-1] / corner)
        heights = corner * (depth / corner) ** across
        heights[-1] = depth
        return _structured(*ringed_quads(inner, _limited(surface, inner), rings, heights), interfaces)

    def _ring_start(self, width: float, depth: float, interfaces: Array) -> float | None:
        """Side of the inner square that rings surround: of homogeneous large bodies touched at a point, else None (and
        where the surface is that of another layout)."""
        law = self.law
        if self.fixed or interfaces.size or law.a0 > 0 or min(width, depth) < 5 * law.reach:
            return None
        return self.sides[2][0] if self.sides else law.inner

    def _down(self, z: Array) -> Array:
        """Size along the depth at the finest part of the contact."""
        if self.sides:
            return np.interp(z, *_columns(self.sides))
        return self.law(np.full_like(z, min(self.law.a0 + self.law.inner, self.law.reach)), -z)


def _expected_points(size: Callable[[Array], Array], stop: float) -> float:
    """About how many points spaced by ``size`` there are between 0 and ``stop``."""
    x = np.unique(np.concatenate([np.linspace(0, stop, 1000), stop * np.geomspace(1e-10, 1, 1000)]))
    return float(np.trapezoid(1 / size(x), x))


def _columns(pairs: tuple[tuple[float, float], ...]) -> tuple[Array, Array]:
    table = np.array(pairs)
    return table[:, 0], table[:, 1]


def _rounded(x: float | Array) -> Array:
    """Rounded to DIGITS significant digits."""
    x = np.asarray(x, dtype=float)
    scale = 10.0 ** (DIGITS - np.ceil(np.log10(np.where(x == 0, 1.0, x))))
    return np.round(x * scale) / scale


def _limited(surface: Array, lines: Array) -> Array:
    if surface.size * lines.size > MAX_CELLS:
        raise Refusal(
            f"mesh: {surface.size} x {lines.size} lines make too many quadrilaterals (at most {MAX_CELLS}): "
            "take larger elements, or triangles"
        )
    return lines


def _structured(points: Array, cells: Array, interfaces: Array) -> Grid:
    return make_grid(points, cells, interfaces)


def scaled_layout(
    body: Body, element: str, reach: float, a0: float, smallest: float, spacing: float, growth: float
) -> Layout:
    """Element size ``spacing`` times the distance from the first contact beyond ``smallest`` [m], then growing."""
    unit = reach
    law = SizeLaw(
        reach=1.0,
        growth=growth,
        far_growth=_far_growth(growth),
        corners=_corners(body, unit, growth),
        a0=float(_rounded(a0 / unit)),
        inner=float(_rounded(smallest / unit)),
        slope=spacing,
        layers=_layer_limits(body, unit, growth),
    )
    return Layout(body, law, unit, element)


def zones_layout(
    body: Body,
    element: str,
    reach: float,
    a0: float,
    element_size: float | None,
    R: float,
    sizes: tuple[float, ...],
    growth: float,
) -> Layout:
    """The paper's zones (Sec. 4.1): uniform ``element_size`` over the contact, then up to ``sizes[k]`` (in units of
    ``R``) within zone I (square R), II (square 2R), III. On a body thinner than R the unit is its depth instead."""
    thin = not body.cut_below and body.depth < R
    unit = body.depth if thin else R
    size = element_size if element_size is not None else (0.02 if thin else 0.0005) * unit
    extent = float(_rounded(reach / unit))
    e = float(_rounded(size / unit))
    first, second = max(1.0, 1.25 * extent), max(2.0, 2.5 * extent)
    limits = tuple(max(s, e) for s in sizes)
    third = max(ZONE_III, 2 * second)
    zones = () if thin else ((first, limits[0]), (second, limits[1]), (third, limits[2]))
    law = SizeLaw(
        reach=extent,
        growth=growth,
        far_growth=_far_growth(growth),
        a0=float(_rounded(a0 / unit)),
        floor=e,
        zones=zones,
        layers=_layer_limits(body, unit, growth),
        corners=_corners(body, unit, growth),
    )
    sides: tuple[tuple[float, float], ...] = ()
    if element == "quadrilateral":
        far = max(body.width, body.depth, 2 * third * unit) / unit
        sides = ((0.0, e), (extent, e), (first, limits[0]), (second, limits[1]), (third, limits[2]))
        sides = (*sides, (far, limits[2] + law.far_growth * (far - third)))
    return Layout(body, law, unit, element, sides)


def _far_growth(growth: float) -> float:
    return max(growth, min(2 * growth, FAR_GROWTH))


def _corners(body: Body, unit: float, growth: float) -> tuple[tuple[float, float, float], ...]:
    """Where the side's support meets another one: a free side on a bonded base, a clamped side at the free surface."""
    if body.cut_beside:
        return ()
    size = CORNER * growth * min(body.depth, body.width) / unit
    depths = ([body.depth] if body.side == "free" and body.bonded else []) + ([0.0] if body.side == "clamped" else [])
    return tuple((float(_rounded(body.width / unit)), float(_rounded(d / unit)), float(_rounded(size))) for d in depths)


def _layer_limits(body: Body, unit: float, growth: float) -> tuple[tuple[float, float, float, float], ...]:
    """Elements across the layers: ``1/growth`` through the uppermost one, half as many through deeper ones."""
    limits = []
    for i, (top, thickness) in enumerate(body.layers):
        share = (TOP_LAYER if i == 0 else DEEP_LAYER) * growth
        t = float(_rounded(thickness / unit))
        limits.append((float(_rounded(top / unit)), t, min(share, 0.5) * t, LONGEST * t))
    return tuple(limits)
