"""Grids from a body and the user's wishes: the layouts ``scaled`` and ``zones``, in triangles or quadrilaterals."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

import numpy as np

from ...base import ROUNDED, SAME, Array, Refusal
from ...bodies import Graded, Problem
from .body import MeshedBody, cut_out
from .grid import Grid, Strip, make_grid, ringed_quads, tensor_quads
from .mesh import triangles
from .options import FEMOptions
from .sizes import SizeLaw, expected_triangles, graded_points


@dataclass(frozen=True)
class LayoutTuning:
    """Element sizes over a body, dimensionless."""

    far: float = 5.0  # reaches from the contact, beyond which the field is smooth; tuned on the bodies of `make tuning`
    far_growth: float = 0.2  # growth there, at most, twice the near one; tuned on the same, by `make tuning`
    steepest: float = 0.6  # growth of any mesh; tuned on bodies, by `make constants`: beyond it triangles are slender
    top_layer: float = 1.0  # size in the top layer, of growth times thickness; tuned on the same, by `make tuning`
    deep_layer: float = 2.0  # size in deeper ones; tuned on the same, by `make tuning`
    fewest_rows: float = 2.0  # through a layer; tuned on bodies, by `make constants`: one row holds no bending
    longest: float = 100.0  # cell in a layer far from the contact, in thicknesses; tuned on the same, by `make tuning`
    corner: float = 0.02  # size at a corner singularity, of growth times extent; tuned on the same, by `make tuning`
    zone_three: float = 20.0  # units; theory: depth of the paper's body (Sec. 4.1), beyond it elements grow on
    rows: int = 2  # of the strip below the contact; tuned on the same, by `make tuning`
    height: float = 0.8  # of a row, in local distances of the vertices; tuned on the same, by `make tuning`
    # Rows at the surface of a material whose modulus changes much within the first one, each so high over the next:
    thinner: float = 0.3  # tuned on power laws of depth, by `make bounds`
    changed: float = 1.3  # factor of the modulus that one row follows; tuned on power laws of depth, by `make bounds`
    thinnest: int = 5  # of them, at most; choice: the first is then 2e-3 of a row
    share: float = 0.6  # of the top layer that the strip takes, at most; tuned on the same, by `make tuning`
    beyond: float = 4.0  # sizes at the reach: so far the strip goes on; tuned on the same, by `make tuning`
    below: float = 5 / 3  # growth below the strip of a calibration, in the body's; tuned on the same, by `make tuning`
    far_below: float = 4.0  # and far from the contact; tuned on the same, by `make tuning`
    digits: int = 12  # of dimensionless lengths; choice: the mesh does not depend on the unit of length
    most_cells: int = 3_000_000  # choice: more need more memory than machines have


TUNING = LayoutTuning()


@dataclass(frozen=True)
class Layout:
    """A size law over a body, in units of ``unit`` [m]: what is needed to make a grid, and to coarsen it.

    ``sides``: (extent, size) along both sides of quadrilateral zones; ``fixed``: radii of the first surface vertices
    and ``thickest``: how deep the strip below them may be, both taken from another layout; ``thin``: rows into which
    the first one below the surface is divided.
    """

    body: MeshedBody
    law: SizeLaw
    unit: float
    element: str
    sides: tuple[tuple[float, float], ...] = ()
    fixed: tuple[float, ...] = ()
    thickest: float | None = None
    thin: int = 0

    @property
    def shares(self) -> Array:
        """Depths of the rows below the surface in the height of one, as far as they are ``thin``."""
        return np.append(TUNING.thinner ** np.arange(self.thin, 0.0, -1), 1.0)

    def following(self) -> Layout:
        """The layout with as many thin rows as follow how the modulus grows below the surface."""
        material = self.body.materials[0]
        if not isinstance(material, Graded):
            return self
        heights = self._row * TUNING.thinner ** np.arange(TUNING.thinnest)
        moduli = material.at(np.append(heights, 0.0))
        large = np.abs(np.log(moduli[:-1] / moduli[-1])) > np.log(TUNING.changed)
        return replace(self, thin=int(large.sum()))

    @property
    def _row(self) -> float:
        """Height of the largest row below the contact [m], thin ones together."""
        size = float(self._along_surface(np.array([self.law.reach]))[0])
        return min(TUNING.height * size, self._thickest / TUNING.rows) * self.unit

    @property
    def unresolved(self) -> float:
        """What the row at the surface leaves of a modulus that grows like the power k < 1 of the depth there: k times
        the power 1 - k of its height over the reach, in which depth compresses next to a surface that yields."""
        material = self.body.materials[0]
        if not isinstance(material, Graded):
            return 0.0
        first = self._row * float(self.shares[0])
        moduli = material.at(first * (1 + np.array([-SAME, SAME])))
        k = float(np.clip(np.diff(np.log(moduli))[0] / (2 * SAME), 0.0, 1.0))
        return k * (first / (self.law.reach * self.unit)) ** (1 - k)

    def coarser(self, factor: float) -> Layout:
        """The same layout with every element ``factor`` times as large."""
        sides = tuple((extent, size * factor) for extent, size in self.sides)
        return replace(self, law=self.law.coarser(factor, TUNING.steepest), sides=sides)

    def on(self, body: MeshedBody) -> Layout:
        """The same surface vertices in the contact, and strip below them, on another body without layers."""
        growth, far = (min(factor * self.law.growth, TUNING.steepest) for factor in (TUNING.below, TUNING.far_below))
        law = replace(self.law, layers=(), zones=(), corners=(), growth=growth, far_growth=far)
        surface = self._surface_points(self.body.width / self.unit)
        fixed = surface[: self._strip_width(surface)]
        return replace(self, body=body, law=law, sides=(), fixed=tuple(fixed.tolist()), thickest=self._thickest)

    def expected_cells(self) -> float:
        """About how many elements ``grid`` will make, without making them."""
        width, depth = self.body.width / self.unit, self.body.depth / self.unit
        if self.element == "triangle":
            thin = 2 * self.thin * _expected_points(self._along_surface, self._strip_end) if self.thin else 0.0
            return expected_triangles(self.law, width, depth) + thin
        across = _expected_points(self._along_surface, width)
        corner = self._ring_start(width, depth, self.body.interfaces)
        if corner is None:
            return across * (_expected_points(self._down, depth) + self.thin)
        inner = _expected_points(self._along_surface, corner)
        return inner * (2 * across - inner)

    def grid(self) -> Grid:
        """Mesh the body."""
        width, depth = _rounded(self.body.width / self.unit), _rounded(self.body.depth / self.unit)
        interfaces = np.array([_rounded(depth) for depth in self.body.interfaces / self.unit])
        surface = self._surface_points(width)
        if self.element == "triangle":
            below = surface[: self._strip_width(surface)]
            shares = np.append(self.shares, np.arange(2.0, TUNING.rows + 1))
            strip = Strip.below(below, _rounded(self._thickest), shares, TUNING.height)
            made = triangles(surface, depth, interfaces, self.law.text(), strip)
        else:
            made = make_grid(*self._quadrilaterals(surface, depth, interfaces), interfaces)
        return made.scaled(self.unit)

    def _along_surface(self, r: Array) -> Array:
        return self._sizes(r, r, np.zeros_like(r))

    def _down(self, z: Array) -> Array:
        """Size along the depth at the finest part of the contact."""
        return self._sizes(z, np.full_like(z, min(self.law.a0 + self.law.inner, self.law.reach)), -z)

    def _sizes(self, along: Array, r: Array, z: Array) -> Array:
        """Element sizes by the law at (r, z), or those of the ``sides`` where these give them."""
        return np.interp(along, *np.transpose(self.sides)) if self.sides else self.law(r, z)

    def _surface_points(self, width: float) -> Array:
        """Radii of the surface vertices; the edge of a flat end, the reach, the end of the strip and the corners of
        the zones are among them, so that the vertices within the reach do not depend on the width."""
        knots = [self.law.a0, self.law.reach, self._strip_end, *(extent for extent, _ in self.sides)]
        start = self.fixed[-1] if self.fixed else 0.0
        stops = np.unique([start, *(x for x in knots if start < x < width * (1 - ROUNDED)), width])
        parts = [graded_points(p, q, self._along_surface) for p, q in itertools.pairwise(stops)]
        return np.unique(np.concatenate([self.fixed, *parts]))

    @property
    def _strip_end(self) -> float:
        law = self.law
        return law.reach + TUNING.beyond * float(self._along_surface(np.array([law.reach]))[0])

    def _strip_width(self, surface: Array) -> int:
        """Number of surface vertices of the strip; all where it would nearly reach the end of the body."""
        if self.fixed:
            return len(self.fixed)
        n = int(np.searchsorted(surface, self._strip_end * (1 + ROUNDED)))
        return n if n + 1 < surface.size else surface.size

    @property
    def _thickest(self) -> float:
        """Most that the strip may take of the body or its top layer."""
        if self.thickest is not None:
            return self.thickest
        layers = self.body.layers or [(0.0, self.body.depth)]
        return TUNING.share * layers[0][1] / self.unit

    def _quadrilaterals(self, surface: Array, depth: float, interfaces: Array) -> tuple[Array, Array]:
        """Vertices and cells of a tensor grid, or of rings around a smaller one."""
        corner = self._ring_start(surface[-1], depth, interfaces)
        if corner is None:
            stops = [0.0, *interfaces, depth]
            lines = [graded_points(p, q, self._down) for p, q in itertools.pairwise(stops)]
            down = _limited(surface, np.unique(np.concatenate(lines)))
            return tensor_quads(surface, np.union1d(down, down[1] * self.shares))
        inner = surface[surface <= corner * (1 + ROUNDED)]
        rings = surface[surface > corner * (1 + ROUNDED)]
        across = np.log(rings / corner) / np.log(rings[-1] / corner)
        heights = corner * (depth / corner) ** across
        heights[-1] = depth
        return ringed_quads(inner, _limited(surface, inner), rings, heights)

    def _ring_start(self, width: float, depth: float, interfaces: Array) -> float | None:
        """Side of the inner square that rings surround: of homogeneous large bodies touched at a point, else None (and
        where the surface is that of another layout)."""
        law = self.law
        if self.fixed or self.thin or interfaces.size or law.a0 > 0 or min(width, depth) < 5 * law.reach:
            return None
        return self.sides[2][0] if self.sides else law.inner


def _expected_points(size: Callable[[Array], Array], stop: float) -> float:
    """About how many points spaced by ``size`` there are between 0 and ``stop``."""
    x = np.unique(np.concatenate([np.linspace(0, stop, 1000), stop * np.geomspace(1e-10, 1, 1000)]))
    return float(np.trapezoid(1 / size(x), x))


def _rounded(x: float) -> float:
    """The length ``x``, rounded to so many digits that the mesh does not depend on the unit of length."""
    scale = 10.0 ** (TUNING.digits - np.ceil(np.log10(x or 1.0)))
    return float(np.round(x * scale) / scale)


def _limited(surface: Array, lines: Array) -> Array:
    if surface.size * lines.size > TUNING.most_cells:
        raise Refusal(
            f"mesh: {surface.size} x {lines.size} lines make too many quadrilaterals (at most {TUNING.most_cells}): "
            "take larger elements, or triangles"
        )
    return lines


# ---------------------------------------------------------------------- the two layouts
def layout_for(options: FEMOptions, problem: Problem, reach: float) -> Layout:
    """The layout of the options, fine out to the radius ``reach`` [m]. Refusal: too many elements, or a truncation
    that does not fit the body."""
    body = cut_out(problem, reach, options.depth, options.width)
    a0, growth = problem.indenter.a0, options.growth_of_sizes
    if options.layout == "scaled":
        smallest = options.smallest * (reach - a0)
        layout = scaled_layout(body, options.element, reach, a0, smallest, options.spacing, growth)
    else:
        layout = zones_layout(body, options, reach, a0, problem.indenter.tip_radius or 6 * reach)
    if (cells := layout.expected_cells()) > TUNING.most_cells:
        raise Refusal(
            f"mesh: about {cells:.1e} elements expected, too many {options.element}s (at most {TUNING.most_cells}): "
            + _fewer(options, layout, cells)
        )
    return layout


def _fewer(options: FEMOptions, layout: Layout, cells: float) -> str:
    """Remedy for too many ``cells``."""
    if options.tolerance is not None:
        return "ask for a larger mesh.tolerance, or use the method layered where it represents the body"
    size = "mesh.element_size" if options.layout == "zones" else "mesh.spacing or mesh.smallest"
    quads = options.element == "quadrilateral"
    fewer = quads and replace(layout, element="triangle").expected_cells() < cells
    return f"take a larger {size}, or {'triangles' if fewer else 'a larger mesh.growth'}"


def scaled_layout(
    body: MeshedBody, element: str, reach: float, a0: float, smallest: float, spacing: float, growth: float
) -> Layout:
    """Element size ``spacing`` times the distance from the first contact beyond ``smallest`` [m], then growing."""
    law = _law(body, reach, 1.0, a0, growth)
    return Layout(body, replace(law, inner=_rounded(smallest / reach), slope=spacing), reach, element).following()


def zones_layout(body: MeshedBody, options: FEMOptions, reach: float, a0: float, R: float) -> Layout:
    """The paper's zones (Sec. 4.1): uniform ``element_size`` over the contact, then up to ``zone_sizes[k]`` (in units
    of ``R``) within zone I (square R), II (square 2R), III. On a body thinner than R the unit is its depth instead."""
    thin = not body.cut_below and body.depth < R
    unit = body.depth if thin else R
    size = options.element_size if options.element_size is not None else (0.02 if thin else 0.0005) * unit
    extent, e = _rounded(reach / unit), _rounded(size / unit)
    halves = 2 if options.order == 2 and options.element == "triangle" else 1
    second = max(2.0, 2.5 * extent)
    ends = (max(1.0, 1.25 * extent), second, max(TUNING.zone_three, 2 * second))
    zones = tuple((end, max(halves * size, e)) for end, size in zip(ends, options.zone_sizes, strict=True))
    law = replace(_law(body, unit, extent, a0, options.growth_of_sizes), floor=e, zones=() if thin else zones)
    if options.element == "triangle":
        return Layout(body, law, unit, options.element).following()
    far = max(body.width, body.depth, 2 * ends[2] * unit) / unit
    beyond = (far, zones[2][1] + law.far_growth * (far - ends[2]))
    return Layout(body, law, unit, options.element, ((0.0, e), (extent, e), *zones, beyond)).following()


def _law(body: MeshedBody, unit: float, reach: float, a0: float, growth: float) -> SizeLaw:
    """Size law of contact, layers and corners in units of ``unit`` [m]: out to ``reach`` units, round ``a0`` [m]."""
    far_growth = max(growth, min(2 * growth, TUNING.far_growth))
    law = SizeLaw(reach, growth, far_growth, TUNING.far, _rounded(a0 / unit))
    layers, corners = tuple(_layer_limits(body, unit, growth)), tuple(_corners(body, unit, growth))
    return replace(law, layers=layers, corners=corners)


def _corners(body: MeshedBody, unit: float, growth: float) -> Iterator[tuple[float, float, float]]:
    """Points of singular fields, where the side's support meets another one: a free side on a bonded base, a clamped
    side at the free surface."""
    size = TUNING.corner * growth * min(body.depth, body.width) / unit
    singular = {body.depth: body.side == "free" and body.bonded, 0.0: body.side == "clamped"}
    for depth, is_singular in singular.items():
        if is_singular and not body.cut_beside:
            yield _rounded(body.width / unit), _rounded(depth / unit), _rounded(size)


def _layer_limits(body: MeshedBody, unit: float, growth: float) -> Iterator[tuple[float, float, float, float]]:
    """Elements across the layers: ``1/growth`` through the uppermost one, half as many through deeper ones."""
    for i, (top, thickness) in enumerate(body.layers):
        share = (TUNING.top_layer if i == 0 else TUNING.deep_layer) * growth
        t = _rounded(thickness / unit)
        yield _rounded(top / unit), t, min(share, 1 / TUNING.fewest_rows) * t, TUNING.longest * t
