"""What the body changes against the half-space, as the kernel K(x, t) of the contact equation at a few x and t.

The field on the body is u_t + w_t: the half-space's and a correction, smooth where the body ends or changes away from
the contact. Both obey the same weak form with the loads F_t(v): the half-space's traction on free sides and the stress
(C - C_contact) eps(u_t) where the moduli differ; w_t = -u_t where the body is constrained. Betti's theorem turns the
work of the pressure of x in w_t into

    pi E* K(x, t) = D(x, t) - F_t(w_x) - F_x(w_t) - A(w_t, w_x)
    D(x, t) = int_held T_x . u_t - int_free T_t . u_x - int (C - C_contact) eps(u_t) : eps(u_x),       T: tractions

which is stationary in w: an error e of the discrete fields enters as A(e, e) only. No surface values are read off, and
nothing is taken near the contact. ``RingField`` is the half-space's field u_t, of the pressure of one t.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, replace
from functools import cache, cached_property, partial
from typing import TYPE_CHECKING

import numpy as np
from numpy.polynomial import legendre

from ..base.errors import Refusal, SolveError
from ..base.numerics import AT_ONCE, RESIDUAL_LIMIT, ROUNDED, Array
from ..bodies.problem import (
    AnyGraded,
    AnyTransverse,
    Elastic,
    GradedTransverselyIsotropic,
    HalfSpace,
    Material,
    Rigid,
    Specimen,
    TransverselyIsotropic,
)
from ..formulas import point_force
from ..methods.integral.fredholm import rule

if TYPE_CHECKING:
    from scipy.sparse import coo_matrix, csr_matrix

# --------------------------------------------------------------------------------------------------
# The rectangle in which the correction is computed: layers with supports, in units of the largest contact radius.


# Which layers get a pressure, and where an unbounded body is cut.
REGION_NEARLY_INCOMPRESSIBLE = 0.49  # above it a layer gets a pressure; tuned on reference bodies, by `make tuning`
# of a second cut, which shows what the first one costs; tuned on bodies, by `make constants`: as cheap as it can be
REGION_SHRINK = 3.0
# degree of the elements that show it, at least: with 4 those between both cuts err by more
REGION_LEAST = 6  # tuned on reference bodies, by `make tuning`
REGION_DECAYS = 40.0  # lengths, where the field falls exponentially; tuned on reference bodies, by `make tuning`
# Left by extrapolation over its change, times size/length:
REGION_NEXT_ORDER = 12.0  # tuned on random bodies, by `make bounds`
# Poisson's ratio of a half-space, from which on it does not move sideways where it is pulled from far:
REGION_VANISHING = 0.45  # tuned on random bodies, by `make bounds`
# Relative error left elsewhere, times (size/length)^3:
REGION_CUT = 2.0  # tuned on reference bodies, by `make tuning`


@dataclass(frozen=True)
class Region:
    """Layers from the surface down, 0 <= r <= ``width``, 0 <= z <= sum of ``thicknesses``, in units of ``unit`` [m].

    ``base, side``: whether u_r and whether u_z are prescribed there; what is not is free. ``far``: the half-space that
    begins with the lowest layer, where there is one; base and side then move as under a point force on it. ``length``:
    over which the field decays far away. ``cut_again``: whether this is
    what the second cut of an unbounded body leaves.
    """

    thicknesses: tuple[float, ...]
    materials: tuple[Material, ...]
    width: float
    base: tuple[bool, bool]
    side: tuple[bool, bool]
    far: Elastic | None
    unit: float
    cut_beside: bool
    length: float
    cut_again: bool = False

    @classmethod
    def of(cls, specimen: Specimen, reach: float, error: float) -> Region:
        """The region for contact radii up to ``reach`` [m]; where a body is unbounded, cut off with about ``error``."""
        thick = [layer.thickness / reach for layer in specimen.layers]
        length, size = _size(specimen, thick, error)
        far = None
        if isinstance(specimen.base, HalfSpace):
            assert isinstance(specimen.base.material, Elastic)
            far = specimen.base.material
            thick.append(size - sum(thick))
            base = side = True, True
        else:
            bonded = specimen.base.bonded
            support = specimen.side if specimen.radius is not None else "clamped"
            base, side = (bonded, True), (support != "free", support == "clamped")
        if specimen.radius is not None:
            size = specimen.radius / reach
        return cls(tuple(thick), specimen.materials, size, base, side, far, reach, specimen.radius is None, length)

    @property
    def depth(self) -> float:
        return sum(self.thicknesses)

    @property
    def first(self) -> float:
        """Depth of the first interface, or of the base."""
        return self.thicknesses[0]

    @property
    def changing(self) -> bool:
        """Whether the modulus changes from the contact on."""
        return isinstance(self.materials[0], AnyGraded)

    @property
    def tops(self) -> tuple[float, ...]:
        """Depth of the upper side of every layer."""
        return (0.0, *np.cumsum(self.thicknesses)[:-1].tolist())

    @property
    def reference(self) -> Elastic:
        """The half-space that is the exact part: the material at the contact."""
        return self.materials[0].surface

    @property
    def algebraic(self) -> bool:
        """Whether what the cut costs falls with a power of its distance only."""
        return self.cut_beside and not (self.far is None and self.base[0])

    @property
    def next_order(self) -> float:
        """Part of the change by extrapolating the cut that is left as its error, about."""
        return min(REGION_NEXT_ORDER * self.length / self.width, 1.0)

    @property
    def higher_order(self) -> bool:
        """Whether the leading term of the far field on a half-space nearly vanishes, which extrapolation rests on."""
        return self.far is not None and self.far.nu > REGION_VANISHING

    @property
    def cuts(self) -> tuple[float, ...]:
        """Where the second cut of an unbounded body goes, along r, and along z if it is unbounded there too.

        What it leaves has no such line of its own: its elements are those of the whole body up to there, and their
        errors drop out of the difference.
        """
        if not self.cut_beside or self.cut_again:
            return ()
        inner = 0.0 if self.algebraic else 1.0
        return (inner + (self.width - inner) / REGION_SHRINK,)

    @property
    def corners(self) -> tuple[float, ...]:
        """Depths at which the side meets the surface or the base in a singular corner: one of them fixed, one free."""
        if self.cut_beside:
            return ()
        return (0.0,) * self.side[1] + (self.depth,) * (self.base[0] and not self.side[0])

    @property
    def free_edges(self) -> tuple[float, ...]:
        """Depths at which an interface meets the side in a weaker singularity; none at a roller."""
        return () if self.cut_beside or self.side[0] != self.side[1] else self.tops[1:]

    def nearer(self) -> Region:
        """The same body after the second cut."""
        (width,) = self.cuts
        last = self.thicknesses[-1] - (self.width - width if self.far is not None else 0.0)
        return replace(self, width=width, thicknesses=(*self.thicknesses[:-1], last), cut_again=True)

    @property
    def kinks(self) -> list[float]:
        """Depths inside the layers at which the modulus has a kink."""
        kinks = []
        for top, thickness, material in zip(self.tops, self.thicknesses, self.materials, strict=True):
            if isinstance(material, AnyGraded):
                depths = sorted({z / self.unit for law in material.laws for z in law.kinks})
                kinks += [top + z for z in depths if z < thickness * (1 - ROUNDED)]
        return kinks

    def layer_at(self, z: Array) -> Array:
        """The layer of every depth ``z``."""
        return np.searchsorted(np.array(self.tops[1:]), z, side="right")

    @property
    def mixed(self) -> tuple[bool, ...]:
        """Which layers have a pressure unknown."""
        limit = REGION_NEARLY_INCOMPRESSIBLE
        return tuple(not isinstance(m, AnyTransverse) and m.nu > limit for m in self.materials)

    def moduli(self, z: Array) -> Moduli:
        """Stiffnesses at the depths ``z``, in units of E of the reference."""
        layer = self.layer_at(z)
        C, inverse = np.zeros((5, z.size)), np.zeros(z.size)
        for i, (top, material) in enumerate(zip(self.tops, self.materials, strict=True)):
            at = layer == i
            if isinstance(material, TransverselyIsotropic):
                C[:, at] = np.array(material.stiffness)[:, None]
                continue
            if isinstance(material, GradedTransverselyIsotropic):
                C[:, at] = material.stiffness_at((z[at] - top) * self.unit)
                continue
            E, nu = material.at((z[at] - top) * self.unit), material.nu
            G = E / (2 * (1 + nu))
            bulk = 0.0 * E if self.mixed[i] else E * nu / ((1 + nu) * (1 - 2 * nu))
            inverse[at] = (1 + nu) * (1 - 2 * nu) / (E * nu) if self.mixed[i] else 0.0
            C[:, at] = [bulk + 2 * G, bulk, bulk, bulk + 2 * G, G]
        E0 = self.reference.E
        return Moduli(C / E0, inverse * E0, np.array(self.mixed)[layer])

    def differs(self, z: Array) -> Array:
        """Whether the material at each depth ``z`` is another than the reference."""
        return np.array([material != self.reference for material in self.materials])[self.layer_at(z)]


@dataclass(frozen=True, eq=False)
class Moduli:
    """Rows C11, C12, C13, C33, C44 over depth (without lambda where ``mixed``) and 1/lambda where ``mixed``."""

    C: Array
    inverse_lame: Array
    mixed: Array

    def at(self, rows: Array | slice) -> Moduli:
        """Moduli at some depths."""
        return Moduli(self.C[:, rows], self.inverse_lame[rows], self.mixed[rows])


def _size(specimen: Specimen, thick: list[float], error: float) -> tuple[float, float]:
    """Length over which the field decays, and radius (and depth, of a half-space) at which an unbounded body is cut.

    On a rigid base the length grows with the stiffest layer over the softest, a plate on a soft foundation; if bonded,
    the field decays exponentially. On a half-space or a sliding base the layers' own far field, less that of the point
    force, dies with a power of (length over distance); on a half-space stiff layers are a membrane.
    """
    stiffest = max(layer.moduli[1] for layer in specimen.layers)
    softest = min(layer.moduli[0] for layer in specimen.layers)
    if isinstance(specimen.base, Rigid):
        length = sum(thick) * (stiffest / softest) ** 0.25
        if specimen.base.bonded:
            return length, 1.0 + REGION_DECAYS * length
    else:
        assert isinstance(specimen.base.material, Elastic)
        soft = specimen.base.material.E
        length = sum(t * max(layer.moduli[1] / soft, 1.0) for t, layer in zip(thick, specimen.layers, strict=True))
    length = max(1.0, 2 * length)
    return length, length * (REGION_CUT / error) ** (1 / 3)


def closest_cut(region: Region) -> float:
    """Distance from the contact to the nearest place where the body ends or changes."""
    return min(region.first, math.inf if region.cut_beside else region.width - 1.0)


# --------------------------------------------------------------------------------------------------
# High-order elements along one line, and where their intervals end; elements of a rectangle are products of two.
#
# On every interval between ``edges`` stand Lagrange polynomials on the Gauss-Lobatto points of its own degree. A
# field that is smooth on an interval is met with an error that falls exponentially with the degree (Babuska and Suri
# 1994).
#
# Intervals are short where the correction varies fast, and towards singular corners: seen from a place where the body
# ends or changes, the contact is a ring source at some distance; the correction varies over that distance there, and
# over ever longer ones away from it.


# How long intervals are, and of which degree towards singular corners.
LINE_EXTRA = 2  # Gauss points per interval beyond the degree; tuned on reference bodies, by `make tuning`
LINE_SPARE = 0.2  # part of an interval that is done without; choice: with 0.3 errors of thick layers change sign
LINE_LENGTH = 1.5  # of intervals, over the distance of the source; tuned on reference bodies, by `make tuning`
LINE_GROWTH = 0.67  # of lengths with the distance from the contact; tuned on reference bodies, by `make tuning`
LINE_FAR_GROWTH = 1.0  # the same far from it; tuned on reference bodies, by `make tuning`
LINE_FAR = 10.0  # contact radii, or depths of the first interface; tuned on reference bodies, by `make tuning`
# Of a field that decays exponentially, in lengths: over which it changes, and after which it is gone:
LINE_DECAYING = 0.5  # tuned on random bodies, by `make bounds`
LINE_DECAYED = 2.0  # tuned on random bodies, by `make bounds`
LINE_CORNER = 0.15  # ratio of intervals towards a singular corner; theory: Babuska and Suri 1994, about 0.15
LINE_CORNER_DEGREE = 2  # on the smallest of them, growing by one per interval; theory: likewise
LINE_MOST = 10_000  # intervals between two stops; choice: no solve of the cost that is allowed has as many


SAMPLES = np.unique(np.concatenate([np.linspace(0, 1, 65), np.geomspace(1e-5, 1, 65), 1 - np.geomspace(1e-5, 1, 65)]))


def lobatto(degree: int) -> Array:
    """Gauss-Lobatto points on [-1, 1], ends included; of degree 0 the centre."""
    if degree == 0:
        return np.zeros(1)
    inner = legendre.legroots(legendre.legder([0.0] * degree + [1.0])).real if degree > 1 else np.zeros(0)
    return np.concatenate([[-1.0], inner, [1.0]])


@cache
def _inverse(degree: int) -> Array:
    """Matrix from values at the Gauss-Lobatto points to Legendre coefficients."""
    return np.linalg.inv(legendre.legvander(lobatto(degree), degree))


def shapes(degree: int, x: Array) -> tuple[Array, Array]:
    """Lagrange polynomials of ``degree`` and their derivatives at ``x`` in [-1, 1], (x.size, degree + 1)."""
    inverse = _inverse(degree)
    slopes = legendre.legvander(x, max(degree - 1, 0)) @ legendre.legder(inverse) if degree else np.zeros((x.size, 1))
    return legendre.legvander(x, degree) @ inverse, slopes


@dataclass(frozen=True, eq=False)
class LineElements:
    """Continuous elements between increasing ``edges``, interval i of degree ``degrees[i]`` >= 1."""

    edges: Array
    degrees: Array

    @property
    def nodes(self) -> Array:
        """Positions of the unknowns, increasing."""
        inner = [
            (a + b) / 2 + (b - a) / 2 * lobatto(int(p))[1:]
            for a, b, p in zip(self.edges[:-1], self.edges[1:], self.degrees, strict=True)
        ]
        return np.concatenate([self.edges[:1], *inner])

    @property
    def nodes_of_parts(self) -> Array:
        """How many nodes lie on every edge and inside every interval, by turns."""
        return np.append(np.column_stack([np.ones_like(self.degrees), self.degrees - 1]).ravel(), 1)

    @cached_property
    def rule(self) -> tuple[Array, Array]:
        """Gauss points and weights, interval by interval."""
        parts = [rule(int(p) + LINE_EXTRA) for p in self.degrees]
        half = np.diff(self.edges) / 2
        centre = self.edges[:-1] + half
        x = np.concatenate([c + h * u for c, h, (u, _) in zip(centre, half, parts, strict=True)])
        return x, np.concatenate([h * v for h, (_, v) in zip(half, parts, strict=True)])

    @cached_property
    def basis(self) -> tuple[Array, Array]:
        """Shape functions and their derivatives at the Gauss points, (points, unknowns)."""
        return self._collocated(self.degrees, np.ones(self.degrees.size - 1, dtype=bool))

    def pressure(self, joined: Array) -> Array:
        """Shape functions of one degree less at the Gauss points, continuous at inner edge i where ``joined[i]``."""
        return self._collocated(self.degrees - 1, joined)[0]

    def inside(self, joined: Array) -> Array:
        """Which pressure functions are zero at both ends of their interval."""
        starts = _starts(self.degrees - 1, joined)
        mask = np.ones(starts[-1], dtype=bool)
        mask[starts[:-1]] = mask[starts[:-1] + self.degrees - 1] = False
        return mask

    def at(self, x: Array, joined: Array) -> tuple[Array, Array, Array]:
        """Shape functions, derivatives, and those of the pressure at any increasing ``x`` off the edges."""
        owner = np.searchsorted(self.edges, x) - 1
        local = 2 * (x - self.edges[owner]) / np.diff(self.edges)[owner] - 1
        values, slopes = _assembled(owner, local, self.degrees, np.ones_like(joined), np.diff(self.edges))
        return values, slopes, _assembled(owner, local, self.degrees - 1, joined, np.diff(self.edges))[0]

    def _collocated(self, degrees: Array, joined: Array) -> tuple[Array, Array]:
        local = np.concatenate([rule(int(p) + LINE_EXTRA)[0] for p in self.degrees])
        owner = np.repeat(np.arange(self.degrees.size), self.degrees + LINE_EXTRA)
        return _assembled(owner, local, degrees, joined, np.diff(self.edges))


def _starts(degrees: Array, joined: Array) -> Array:
    """Number of the first function of every interval, and how many there are: neighbours share one where joined."""
    return np.concatenate([[0], np.cumsum(degrees + 1 - np.append(joined, False))])


def _assembled(owner: Array, local: Array, degrees: Array, joined: Array, widths: Array) -> tuple[Array, Array]:
    """Shape functions and derivatives at the places ``local`` in [-1, 1] of the intervals ``owner``."""
    starts = _starts(degrees, joined)
    values, slopes = np.zeros((2, local.size, starts[-1]))
    for i, degree in enumerate(degrees.tolist()):
        rows = np.flatnonzero(owner == i)
        block = np.ix_(rows, starts[i] + np.arange(degree + 1))
        values[block], slopes[block] = shapes(degree, local[rows])
        slopes[block] *= 2 / widths[i]
    return values, slopes


def lines(region: Region, degree: int) -> tuple[LineElements, LineElements]:
    """Elements of a ``degree`` along r and along z."""
    first = region.first
    gap = region.width - 1 if not region.cut_beside else np.inf

    def radial(r: Array) -> Array:
        size = np.minimum(first + _grown(r - 1, first), gap + region.width - r)
        return LINE_LENGTH * np.minimum(size, _decaying(r, region))

    def vertical(z: Array) -> Array:
        return LINE_LENGTH * np.minimum(first + _grown(z - first, first), gap + z)

    # As many graded intervals as let both errors fall together; fewer where the singularity is weaker.
    corners = [(z, degree // 2) for z in region.corners] + [(z, max(degree // 2 - 1, 1)) for z in region.free_edges]
    at_side = max((count for _, count in corners), default=0)
    r = _partition([0.0, *region.cuts, region.width], radial, region.cut_beside)
    z = _partition(
        [*region.tops, *region.kinks, *(region.cuts if region.far else ()), region.depth], vertical, region.cut_beside
    )
    return _graded(r, [(region.width, at_side)], degree), _graded(z, corners, degree)


def extended(r: LineElements, region: Region, degree: int) -> LineElements:
    """The line ``r`` and intervals on to the end of the wider ``region``."""
    end = float(r.edges[-1])

    def beyond(x: Array) -> Array:
        return LINE_LENGTH * np.minimum(region.first + _grown(x - 1, region.first), _decaying(x, region))

    more = _partition([end, region.width], beyond, region.cut_beside)[1:]
    degrees = np.full(more.size, degree)
    return LineElements(np.concatenate([r.edges, more]), np.concatenate([r.degrees, degrees]))


def _grown(beyond: Array, first: float) -> Array:
    """What lengths gain at the distance ``beyond`` the contact, or below the ``first`` interface."""
    faster = (LINE_FAR_GROWTH - LINE_GROWTH) * np.maximum(beyond - LINE_FAR * max(1.0, first), 0.0)
    return LINE_GROWTH * np.maximum(beyond, 0.0) + faster


def _decaying(r: Array, region: Region) -> Array:
    """Distance over which a field that decays exponentially changes, under a stiff layer many thicknesses, and where it
    has decayed more."""
    if region.algebraic or not region.cut_beside:
        return np.full(np.shape(r), np.inf)
    gone = r - 1 - LINE_DECAYED * region.length
    return LINE_DECAYING * region.length + LINE_GROWTH * np.maximum(gone, 0.0)


def _partition(stops: Iterable[float], size: Callable[[Array], Array], wide: bool) -> Array:
    """Edges between the ``stops``, the intervals hardly longer than ``size`` says in them: those of thick layers are so
    few that otherwise errors change sign with the degree, and two degrees agree by accident."""
    ends = np.unique(list(stops))
    edges: list[Array] = [ends[:1]]
    for lo, hi in itertools.pairwise(ends):
        # from the shorter of the sizes at both ends on: of a far cut they are 1e-7 of the distance
        smallest = min(float(size(np.array([end]))[0]) for end in (lo, hi)) / (hi - lo)
        finer = np.geomspace(smallest, SAMPLES[1], 65)[:-1] if smallest < SAMPLES[1] else SAMPLES[:0]
        x = lo + (hi - lo) * np.unique(np.concatenate([SAMPLES, finer, 1 - finer]))
        density = 1 / size(x)
        count = np.concatenate([[0.0], np.cumsum(np.diff(x) * (density[1:] + density[:-1]) / 2)])
        if count[-1] > LINE_MOST:
            instead = "layered or fem" if wide else "fem (with a rigid indenter)"
            raise Refusal(
                "hybrid: the contact or body is so large against the nearest interface that elements would lie in "
                f"{count[-1]:.2g} rows (limit {LINE_MOST}); use a smaller contact, or use the method {instead}"
            )
        pieces = max(1, math.ceil(float(count[-1]) - LINE_SPARE))
        edges += [np.interp(np.arange(1, pieces) * count[-1] / pieces, count, x), np.array([hi])]
    return np.concatenate(edges)


def _graded(edges: Array, corners: list[tuple[float, int]], degree: int) -> LineElements:
    """Intervals next to every corner cut geometrically, every time at ``LINE_CORNER`` of the distance, with degrees
    that fall towards it."""
    pieces = [(a, b, degree) for a, b in itertools.pairwise(edges.tolist())]
    for corner, count in corners:
        parts = []
        for a, b, degree in pieces:
            if not count or corner not in (a, b):
                parts.append((a, b, degree))
                continue
            far = b if a == corner else a
            marks = [far, *(corner + (far - corner) * LINE_CORNER**k for k in range(1, count + 1)), corner]
            degrees = [degree, *(min(degree, LINE_CORNER_DEGREE + k) for k in range(count - 1, -1, -1))]
            ends = zip(itertools.pairwise(marks), degrees, strict=True)
            parts += sorted((min(p, q), max(p, q), d) for (p, q), d in ends)
        pieces = parts
    return LineElements(np.array([0.0, *(b for _, b, _ in pieces)]), np.array([p for *_, p in pieces]))


# --------------------------------------------------------------------------------------------------
# Axisymmetric elasticity on a rectangle of products of line elements: every block is a sum of Kronecker products.
#
# Moduli depend on depth alone, so that each integral over the rectangle is a product of one along r and one along z.
# Unknowns: u_r of all nodes (z by z), u_z of all nodes, and in nearly incompressible layers a pressure of one degree
# less, continuous in the layer (Taylor and Hood 1973). All integrals carry the weight 2 pi r.


# When a solve is repeated.
# Relative residual of a solve that is not repeated for what is left: great contrasts and distances leave 1e-7.
SOLVE_CLOSE = 1e-9  # theory: K errs by its square only


def dissection(nz: int, nr: int) -> Array:
    """Rank (2 nz + 1, 2 nr + 1) of the vertices, sides and insides of ``nz`` times ``nr`` elements in nested
    dissection: the longer way is halved at a line of vertices and sides, which comes after both halves."""
    ranks, count = np.zeros((2 * nz + 1, 2 * nr + 1), dtype=np.int64), itertools.count()

    def number(start: tuple[int, int], stop: tuple[int, int]) -> None:
        along = int(stop[1] // 2 - start[1] // 2 > stop[0] // 2 - start[0] // 2)  # more elements
        middle = (start[along] + stop[along]) // 4 * 2
        if middle <= start[along]:
            ranks[start[0] : stop[0], start[1] : stop[1]] = next(count)
            return
        before, after = list(stop), list(start)
        before[along], after[along] = middle, middle + 1
        number(start, (before[0], before[1]))
        number((after[0], after[1]), stop)
        first, last = list(start), list(stop)
        first[along], last[along] = middle, middle + 1
        ranks[first[0] : last[0], first[1] : last[1]] = next(count)

    number((0, 0), ranks.shape)
    return ranks


@dataclass(frozen=True, eq=False)
class Mesh:
    """Mesh of a region: line elements along ``r`` and ``z``; fields at nodes or Gauss points have the shape (..., z,
    r)."""

    region: Region
    r: LineElements
    z: LineElements

    @cached_property
    def moduli(self) -> Moduli:
        """Stiffnesses at the Gauss points along z."""
        return self.region.moduli(self.z.rule[0])

    @property
    def shape(self) -> tuple[int, int]:
        """Number of nodes along z and along r."""
        return int(self.z.degrees.sum()) + 1, int(self.r.degrees.sum()) + 1

    @property
    def nodes(self) -> int:
        return self.shape[0] * self.shape[1]

    @property
    def joined(self) -> tuple[Array, Array]:
        """Inner edges along r and along z at which a pressure is continuous: not at interfaces."""
        layer = self.region.layer_at((self.z.edges[1:] + self.z.edges[:-1]) / 2)
        return np.ones(self.r.degrees.size - 1, dtype=bool), layer[1:] == layer[:-1]

    @property
    def used(self) -> Array:
        """Which pressure functions along z belong to layers with a pressure."""
        return np.any(self.z.pressure(self.joined[1])[self.moduli.mixed] != 0, axis=0)

    @cached_property
    def pressure(self) -> tuple[Array, Array]:
        """Pressure functions at the Gauss points along r and along z; none along z where no layer needs them."""
        return self.r.pressure(self.joined[0]), self.z.pressure(self.joined[1])[:, self.used]

    @property
    def constrained(self) -> Array:
        """Mask (2, z, r) of the displacements that the supports or the axis prescribe."""
        mask = np.zeros((2, *self.shape), dtype=bool)
        mask[0, :, 0] = True
        mask[:, -1, :] |= np.array(self.region.base)[:, None]
        mask[:, :, -1] |= np.array(self.region.side)[:, None]
        return mask

    @cached_property
    def stiffness(self) -> csr_matrix:
        """The symmetric matrix of all unknowns; indefinite with pressures."""
        from scipy.sparse import bmat

        C11, C12, C13, C33, C44 = self.moduli.C
        r, w = self.r.rule
        w = 2 * np.pi * w
        (V, D), (V_z, D_z) = self.r.basis, self.z.basis
        mass, slope, mixed = _integral(V, w * r, V), _integral(D, w * r, D), _integral(D, w * r, V)
        hoop, cross, whole = _integral(V, w / r, V), _integral(D, w, V), _integral(V, w, V)

        def over_z(left: Array, weight: Array | float, right: Array) -> Array:
            return _integral(left, self.z.rule[1] * weight, right)

        product = partial(_products, _touching(V_z, V_z), _touching(V, V))
        rr = product(
            (over_z(V_z, C11, V_z), slope + hoop),
            (over_z(V_z, C12, V_z), cross + cross.T),
            (over_z(D_z, C44, D_z), mass),
        )
        rz = product((over_z(V_z, C13, D_z), mixed + whole), (over_z(D_z, C44, V_z), mixed.T))
        zz = product((over_z(D_z, C33, D_z), mass), (over_z(V_z, C44, V_z), slope))
        Q, Q_z = self.pressure
        if not Q_z.shape[1]:
            return bmat([[rr, rz], [rz.T, zz]], format="csr")
        coupling = partial(_products, _touching(Q_z, V_z), _touching(Q, V))
        p_r = coupling((over_z(Q_z, 1.0, V_z), _integral(Q, w * r, D) + _integral(Q, w, V)))
        p_z = coupling((over_z(Q_z, 1.0, D_z), _integral(Q, w * r, V)))
        inverse = over_z(Q_z, self.moduli.inverse_lame, Q_z)
        pp = _products(_touching(Q_z, Q_z), _touching(Q, Q), (inverse, _integral(Q, w * r, Q)))
        return bmat([[rr, rz, -p_r.T], [rz.T, zz, -p_z.T], [-p_r, -p_z, -pp]], format="csr")

    def work(self, U: Array) -> tuple[Array, Array]:
        """The work (m, m) of the stresses of each of the fields ``U`` (n, m) in the strains of the others, and how far
        rounding can move it.

        It is gathered from strains: what rounding leaves of U^T A U grows with the square of motions that strain
        nothing, as those of the top of a slender rod, a thousand times what the contact changes there.
        """
        weights = 2 * np.pi * self.z.rule[1][:, None] * (self.r.rule[1] * self.r.rule[0])
        work, moved = np.zeros((2, U.shape[1], U.shape[1]))
        fields, sizes = self._along_r(U), self._along_r(np.abs(U), np.abs)
        points = self.z.rule[0].size
        slab = max(1, AT_ONCE // (U.shape[1] * self.r.rule[0].size))  # points at a time within the memory allowed
        for start in range(0, points, slab):
            rows = slice(start, start + slab)
            rr, tt, zz, rz, p = strains = self._strains(fields, rows)
            C11, C12, C13, C33, C44 = self.moduli.C[:, rows, None, None]
            misfit = rr + tt + zz + self.moduli.inverse_lame[rows, None, None] * p
            s_rr, s_tt = C11 * rr + C12 * tt + C13 * zz - p, C12 * rr + C11 * tt + C13 * zz - p
            stresses = s_rr, s_tt, C13 * (rr + tt) + C33 * zz - p, C44 * rz, -misfit
            for stress, strain, size in zip(stresses, strains, self._strains(sizes, rows, np.abs), strict=True):
                stress *= weights[rows, :, None]
                work += _pairs(stress, strain)
                moved += _pairs(np.abs(stress), size)
        return work, np.finfo(float).eps * (moved + moved.T)

    def _along_r(self, U: Array, of: Callable[[Array], Array] = np.asarray) -> list[Array]:
        """What strains and pressures need of the fields ``U`` (n, m) at the Gauss points along r, by nodes along z: of
        u_r its slope, its value and u_r/r, of u_z its slope and its value, and p, each (z, r * m)."""
        from scipy.sparse import csr_matrix

        (nz, nr), n, m = self.shape, self.nodes, U.shape[1]
        (V, D), (Q, Q_z) = self.r.basis, self.pressure
        hoop = V / self.r.rule[0][:, None]
        u_r, u_z = U[: 2 * n].reshape(2, nz, nr, m)
        p = U[2 * n :].reshape(Q_z.shape[1], Q.shape[1], m)
        pairs = ((D, u_r), (V, u_r), (hoop, u_r), (D, u_z), (V, u_z), (Q, p))
        along = []
        for basis, field in pairs:  # a matrix (points, r) along the second axis of a field (z, r, m)
            A, (z, r, _) = of(basis), field.shape
            values = csr_matrix(A) @ np.moveaxis(field, 0, 1).reshape(r, z * m)
            along.append(np.moveaxis(values.reshape(len(A), z, m), 0, 1).reshape(z, len(A) * m))
        return along

    def _strains(self, along: list[Array], rows: slice, of: Callable[[Array], Array] = np.asarray) -> list[Array]:
        """Strains rr, tt, zz, 2 rz and the pressure (z, r, m) at some ``rows`` of Gauss points, from ``_along_r``."""
        from scipy.sparse import csr_matrix

        V, D, Q = (csr_matrix(of(A[rows])) for A in (*self.z.basis, self.pressure[1]))
        slope_r, u_r, hoop, slope_z, u_z, p = along
        points = self.r.rule[0].size
        strains = V @ slope_r, V @ hoop, D @ u_z, D @ u_r + V @ slope_z, Q @ p
        return [strain.reshape(len(strain), points, strain.shape[1] // points) for strain in strains]

    @property
    def free(self) -> Array:
        """Numbers of the unknowns that nothing prescribes."""
        constrained = np.flatnonzero(self.constrained.ravel())
        return np.setdiff1d(np.arange(self.stiffness.shape[0]), constrained)

    @property
    def order(self) -> Array:
        """The ``free`` unknowns in the order of their elimination: nested dissection of the elements; pressures inside
        an element after the displacements there, others after the last displacement that they couple to, so that no
        pivot is zero."""
        parts = [np.repeat(np.arange(2 * line.degrees.size + 1), line.nodes_of_parts) for line in (self.z, self.r)]
        rank = dissection(self.z.degrees.size, self.r.degrees.size)[np.ix_(*parts)].ravel()
        ranks = np.concatenate([rank, rank])
        coupling = self.stiffness[ranks.size :, : ranks.size]
        if coupling.shape[0]:
            coupled, starts = ranks[coupling.indices], coupling.indptr[:-1]
            inside = np.outer(self.z.inside(self.joined[1])[self.used], self.r.inside(self.joined[0])).ravel()
            after = np.where(inside, np.minimum.reduceat(coupled, starts), np.maximum.reduceat(coupled, starts))
            ranks = np.append(2 * ranks, 2 * after + 1)
        free = self.free
        return free[np.argsort(ranks[free], kind="stable")]

    def solve(self, loads: Array, prescribed: Array) -> Array:
        """Unknowns (n, m) in balance with ``loads`` (n, m) where free, equal to ``prescribed`` (n, m) elsewhere."""
        from scipy.sparse.linalg import splu

        free, K = self.order, self.stiffness
        known = prescribed.copy()
        known[free] = 0.0
        right = (loads - K @ known)[free]
        matrix = K[free][:, free].tocsc()
        lu = splu(matrix, permc_spec="NATURAL", diag_pivot_thresh=0.0, options={"SymmetricMode": True})
        known[free] = lu.solve(right)
        size, left = np.abs(right).max(), right - matrix @ known[free]
        if not np.abs(left).max() < SOLVE_CLOSE * size:
            known[free] += lu.solve(left)
            left = right - matrix @ known[free]
        residual = np.abs(left).max() / size
        if not residual < RESIDUAL_LIMIT:
            raise SolveError(
                f"hybrid: the correction leaves a residual of {residual:.1e}, allowed {RESIDUAL_LIMIT:g}: moduli or "
                "sizes differ by too much for elements; leave out what is far softer, stiffer or thinner than all "
                "else, or, of a wide body, use method layered"
            )
        return known


def _products(z: Array, r: Array, *terms: tuple[Array, Array]) -> coo_matrix:
    """Sums of Kronecker products of a matrix along z and one along r, from the entries where functions overlap."""
    from scipy.sparse import coo_matrix

    (rows_z, columns_z), (rows_r, columns_r) = np.nonzero(z), np.nonzero(r)
    values = sum(np.multiply.outer(A[rows_z, columns_z], B[rows_r, columns_r]) for A, B in terms)
    rows = np.add.outer(rows_z * r.shape[0], rows_r)
    columns = np.add.outer(columns_z * r.shape[1], columns_r)
    shape = z.shape[0] * r.shape[0], z.shape[1] * r.shape[1]
    return coo_matrix((np.ravel(values), (rows.ravel(), columns.ravel())), shape=shape)


def _pairs(stress: Array, strain: Array) -> Array:
    """Sums (m, m) over all points of the products of every ``stress`` (z, r, m) with every ``strain``."""
    m = stress.shape[-1]
    return stress.reshape(-1, m).T @ strain.reshape(-1, m)


def _touching(left: Array, right: Array) -> Array:
    """Pairs of functions whose supports overlap."""
    return (left != 0).astype(float).T @ (right != 0).astype(float) > 0


def _integral(left: Array, weights: Array, right: Array) -> Array:
    """Integral of ``left`` times ``right`` with the given weights at the Gauss points."""
    return left.T @ (weights[:, None] * right)


# Quadrature towards a ring where the modulus changes from the contact on, and how much is in memory at a time.
CORRECTION_TOWARDS = 0.15  # ratio of successive panels; tuned on graded cylinders, by `make tuning`
CORRECTION_PANELS = 7  # tuned on graded cylinders, by `make tuning`
CORRECTION_POINTS = 8  # on each; tuned on graded cylinders, by `make tuning`
# Of the sum of all entries of the energy without their signs, times eps:
CORRECTION_ROUNDING = 0.3  # tuned on a layer on one 2,783 times as stiff, by `make failures`


# ---------------------------------------------------------------------- the half-space
@dataclass(frozen=True, eq=False)
class RingField:
    """Fields of a half-space under the pressures of the contact equation, one per parameter t: (t.size, points).

    The pressure with the Hankel transform p_hat(k) = (E*/2) cos(k t) has, with z downwards, zeta = z + i t and
    rho = sqrt(r^2 + zeta^2), Re rho > 0, a field of elementary functions, as int_0^inf e^(-k zeta) J0(k r) dk = 1/rho.
    All lengths are in one unit, all stresses in units of E of the half-space.

    ``u_r, u_z`` [1/length]; stresses ``s_rr, s_tt, s_zz, s_rz`` and the pressure ``p`` = -lambda div u, finite at
    nu = 1/2 too [E/length^2]. ``u_z`` and z point into the half-space.
    """

    u_r: Array
    u_z: Array
    s_rr: Array
    s_tt: Array
    s_zz: Array
    s_rz: Array
    p: Array
    nu: float

    @classmethod
    def at(cls, r: Array, z: Array, t: Array, nu: float) -> RingField:
        """The fields of the parameters ``t`` at the points (``r``, ``z``) of equal shape, away from r = t, z = 0."""
        zeta = z + 1j * t[:, None]
        rho = np.sqrt(r**2 + zeta**2)
        cube = 1 / rho**3
        sheared = z * cube / rho**2
        narrow = (1 - 2 * nu) / (rho * (rho + zeta))
        loaded, twisted = (zeta * cube).real, ((2 * zeta**2 - r**2) * sheared).real
        half = 0.5 / (1 - nu**2)  # E*/2
        s_zz = -half * (loaded + twisted)
        s_rr = -half * (loaded - twisted + (z * cube - narrow).real)
        s_tt = -4 * half * (1 + nu) / 2 * loaded - s_rr - s_zz
        s_rz = -half * (3 * r * zeta * sheared).real
        u_r = -0.5 / (1 - nu) * r * (narrow - z * cube).real
        u_z = 0.5 / (1 - nu) * (2 * (1 - nu) / rho + z * zeta * cube).real
        return cls(u_r, u_z, s_rr, s_tt, s_zz, s_rz, 2 * nu * half * loaded, nu)

    @property
    def strains(self) -> tuple[Array, Array, Array, Array]:
        """Strains rr, tt, zz and 2 rz [1/length^2], by Hooke's law for E = 1."""
        nu = self.nu
        shear = 0.5 / (1 + nu)
        trace = nu / (1 + nu) * (self.s_rr + self.s_tt + self.s_zz)
        rr, tt, zz = ((s - trace) / (2 * shear) for s in (self.s_rr, self.s_tt, self.s_zz))
        return rr, tt, zz, self.s_rz / shear


# ---------------------------------------------------------------------- the correction
@dataclass(frozen=True, eq=False)
class Correction:
    """Kernel ``K`` (t_i, t_j) [1/unit of length] and its error by ``rounding``; its ``asymmetry`` relative to its
    largest entry; the size of the system solved."""

    K: Array
    rounding: Array
    asymmetry: float
    unknowns: int
    elements: int


def correction(region: Region, t: Array, degree: int) -> Correction:
    """Correction at the parameters ``t`` from one factorisation with as many right-hand sides."""
    return _solved(Mesh(region, *lines(region, degree)), t)


def side_correction(region: Region, wide: Region, t: Array, degree: int) -> Correction:
    """What the side of a body whose modulus changes from the contact on adds to K of the ``wide`` body.

    There the correction is not smooth at the contact, but its change by the side is: the wide body has the same mesh up
    to the side, so that errors near the contact cancel, and the integral of both over the top layer in the difference
    begins at the side.
    """
    mesh = Mesh(region, *lines(region, degree))
    body = _solved(mesh, t, region.width)
    other = _solved(Mesh(wide, extended(mesh.r, wide, degree), mesh.z), t, region.width)
    rounding, unknowns = body.rounding + other.rounding, body.unknowns + other.unknowns
    return replace(body, K=body.K - other.K, rounding=rounding, unknowns=unknowns)


def _solved(mesh: Mesh, t: Array, inner: float = 0.0) -> Correction:
    """Correction on one mesh; ``inner``: radius inside which D leaves out the top layer."""
    region = mesh.region
    loads = _Loads(mesh, t, inner)
    data = sum(loads.on_boundaries(), loads.over_layers())
    prescribed, far = loads.prescribed()
    F = loads.vector
    U = mesh.solve(-F, prescribed)
    energy, (work, moved) = F.T @ U, mesh.work(U)
    J = data - energy - energy.T - work
    if far.any():
        J += ((mesh.stiffness @ U + F).T @ far)[:, None]
    pi_E_star = np.pi / (1 - region.reference.nu**2)
    K = J / pi_E_star
    size = np.abs(F).T @ np.abs(U)
    rounding = CORRECTION_ROUNDING * (moved + np.finfo(float).eps * (size + size.T)) / pi_E_star
    asymmetry, elements = float(np.abs(K - K.T).max() / np.abs(K).max()), mesh.r.degrees.size * mesh.z.degrees.size
    return Correction((K + K.T) / 2, rounding, asymmetry, int(mesh.free.size), elements)


class _Loads:
    """Loads of the half-space's fields: gathers the vector F (unknowns, t), returns the parts of D (t, t) one by
    one."""

    def __init__(self, mesh: Mesh, t: Array, inner: float):
        self.mesh, self.t, self.inner = mesh, t, inner
        self.nu = mesh.region.reference.nu
        self.vector = np.zeros((mesh.stiffness.shape[0], t.size))

    def _field(self, r: Array, z: Array) -> RingField:
        return RingField.at(r, z, self.t, self.nu)

    def prescribed(self) -> tuple[Array, Array]:
        """Displacements w_t (n, t) of all unknowns, used where constrained, and the far field (n,) of the whole body
        there."""
        mesh = self.mesh
        r, z = np.meshgrid(mesh.r.nodes, mesh.z.nodes)
        constrained = mesh.constrained
        outer = constrained.any(axis=0) & (r > 0) | ((r == 0) & (z == z.max()))
        field = self._field(r[outer], z[outer])
        far = np.zeros((2, *mesh.shape))
        far[:, outer] = self._far(r[outer], z[outer])
        w = np.zeros((2, *mesh.shape, self.t.size))
        w[:, outer] = far[:, outer, None] - np.stack([field.u_r.T, field.u_z.T])
        w *= constrained[..., None]
        w[0, :, 0] = 0.0
        rest = mesh.stiffness.shape[0] - 2 * mesh.nodes
        flat = np.append((far * constrained).ravel(), np.zeros(rest))
        return np.vstack([w.reshape(2 * mesh.nodes, -1), np.zeros((rest, self.t.size))]), flat

    def _far(self, r: Array, z: Array) -> Array:
        """Displacement (2, points) of the outer boundary under the total force pi E* of any pressure; 0 if fixed."""
        region = self.mesh.region
        if region.far is None:
            return np.zeros((2, r.size))
        E = region.far.E / region.reference.E
        force = np.pi / (1 - self.nu**2)
        return force * np.stack(point_force(r, z, E, region.far.nu))

    def on_boundaries(self) -> Iterator[Array]:
        """Parts of D on the base and on the side: where a component is fixed, its displacement in the tractions; where
        it is free, loads on the nodes there and the tractions in the displacement."""
        mesh, region = self.mesh, self.mesh.region
        (r, w_r), (z, w_z) = mesh.r.rule, mesh.z.rule
        base = (r, np.full_like(r, region.depth), w_r), region.base, ("s_rz", "s_zz"), mesh.r, np.s_[:, -1, :]
        side = (np.full_like(z, region.width), z, w_z), region.side, ("s_rr", "s_rz"), mesh.z, np.s_[:, :, -1]
        for (x, y, w), held, tractions, line, nodes in (base, side):
            field, far, total = self._field(x, y), self._far(x, y), np.zeros((self.t.size, self.t.size))
            for i, u in enumerate((field.u_r, field.u_z)):
                traction = 2 * np.pi * w * x * getattr(field, tractions[i])
                if held[i]:
                    total += (u - far[i]) @ traction.T
                    continue
                loads = np.zeros((self.t.size, *mesh.shape))
                loads[nodes] = traction @ line.basis[0]
                self.vector[i * mesh.nodes : (i + 1) * mesh.nodes] += loads.reshape(self.t.size, mesh.nodes).T
                total -= traction @ u.T
            yield total

    def over_layers(self) -> Array:
        """Part of D by the stress of the half-space's strains in other materials; of a modulus that changes from the
        contact on, inside ``inner``, its loads only: its work there is singular and in the kernel of the wide body."""
        mesh = self.mesh
        total = np.zeros((self.t.size, self.t.size))
        for slab in Patch.regular(mesh, self.inner).slabs(self.t.size):
            total -= self._loaded_by(slab, np.arange(self.t.size))
        if self.inner:
            for j, t in enumerate(self.t.tolist()):
                self._loaded_by(Patch.around(mesh, self.inner, t), np.array([j]))
        return total

    def _loaded_by(self, patch: Patch, which: Array) -> Array:
        """Add the loads of some of the t on a patch; the work there."""
        *loads, work = patch.integrals(self.t[which], self.nu)
        self.vector[:, which] += np.concatenate([part.reshape(which.size, -1).T for part in loads])
        return work


@dataclass(frozen=True, eq=False)
class Patch:
    """A part of a layer of another material, as products of quadrature points along ``r`` and ``z``: weights (z, r),
    2 pi r included, shape functions, their derivatives and pressure functions along each, and moduli over z."""

    r: Array
    z: Array
    weights: Array
    along_r: tuple[Array, Array, Array]
    along_z: tuple[Array, Array, Array]
    moduli: Moduli

    @classmethod
    def regular(cls, mesh: Mesh, inner: float) -> Patch:
        """Patch of the Gauss points of all other materials; not of the top layer inside the radius ``inner``."""
        (r, w_r), (z, w_z) = mesh.r.rule, mesh.z.rule
        rows = np.flatnonzero(mesh.region.differs(z))
        near = (r < inner) & (mesh.region.layer_at(z[rows]) == 0)[:, None]
        weights = 2 * np.pi * w_z[rows][:, None] * (w_r * r) * ~near
        V_z, D_z = mesh.z.basis
        along_z = (V_z[rows], D_z[rows], mesh.pressure[1][rows])
        return cls(r, z[rows], weights, (*mesh.r.basis, mesh.pressure[0]), along_z, mesh.moduli.at(rows))

    @classmethod
    def around(cls, mesh: Mesh, inner: float, t: float) -> Patch:
        """Patch in the top layer inside ``inner``, of points that crowd towards the ring r = t, z = 0, where stresses
        are singular."""
        r, w_r = _crowded(mesh.r, inner, t)
        z, w_z = _crowded(mesh.z, mesh.region.first, 0.0)
        weights = 2 * np.pi * w_z[:, None] * (w_r * r)
        (V, D, Q), (V_z, D_z, Q_z) = mesh.r.at(r, mesh.joined[0]), mesh.z.at(z, mesh.joined[1])
        return cls(r, z, weights, (V, D, Q), (V_z, D_z, Q_z[:, mesh.used]), mesh.region.moduli(z))

    def slabs(self, count: int) -> Iterator[Patch]:
        """Patches that are slices of z, for ``count`` parameters t at a time within the memory allowed."""
        rows = max(1, AT_ONCE // (count * self.r.size))
        for start in range(0, self.z.size, rows):
            part = slice(start, start + rows)
            V_z, D_z, Q_z = self.along_z
            along_z = (V_z[part], D_z[part], Q_z[part])
            yield Patch(self.r, self.z[part], self.weights[part], self.along_r, along_z, self.moduli.at(part))

    def integrals(self, t: Array, nu: float) -> tuple[Array, Array, Array, Array]:
        """Integrals of the stress (C - C_contact) eps(u_t): loads (t, z, r) of u_r, u_z and of the pressures, and its
        work (t, t) in the strains of every u_t."""
        R, Z = np.meshgrid(self.r, self.z)
        field = RingField.at(R.ravel(), Z.ravel(), t, nu)
        grid = (t.size, *R.shape)
        rr, tt, zz, rz = strains = [strain.reshape(grid) for strain in field.strains]
        C11, C12, C13, C33, C44 = self.moduli.C[:, :, None]
        mixed = self.moduli.mixed[:, None]
        p = field.p.reshape(grid)
        own = np.where(mixed, p, 0.0)
        s_rr = (C11 * rr + C12 * tt + C13 * zz - field.s_rr.reshape(grid) - own) * self.weights
        s_tt = (C12 * rr + C11 * tt + C13 * zz - field.s_tt.reshape(grid) - own) * self.weights
        s_zz = (C13 * (rr + tt) + C33 * zz - field.s_zz.reshape(grid) - own) * self.weights
        s_rz = (C44 * rz - field.s_rz.reshape(grid)) * self.weights
        misfit = (np.where(mixed, rr + tt + zz, 0.0) + self.moduli.inverse_lame[:, None] * p) * self.weights
        (V, D, Q), (V_z, D_z, Q_z) = self.along_r, self.along_z
        work = sum(_work(s, e) for s, e in zip((s_rr, s_tt, s_zz, s_rz), strains, strict=True))
        return (
            V_z.T @ (s_rr @ D + (s_tt / self.r) @ V) + D_z.T @ (s_rz @ V),
            D_z.T @ (s_zz @ V) + V_z.T @ (s_rz @ D),
            -Q_z.T @ (misfit @ Q),
            np.asarray(work) - _work(misfit, p),
        )


def _work(stress: Array, strain: Array) -> Array:
    return stress.reshape(len(stress), -1) @ strain.reshape(len(strain), -1).T


def _crowded(line: LineElements, stop: float, centre: float) -> tuple[Array, Array]:
    """Gauss points and weights between 0 and ``stop``, panels ending at the line's edges and crowding at ``centre``."""
    away = stop * CORRECTION_TOWARDS ** np.arange(CORRECTION_PANELS)
    edges = np.concatenate([line.edges, centre - away, centre + away, [centre, 0.0, stop]])
    edges = np.unique(edges[(edges >= 0) & (edges <= stop)])
    nodes, weights = rule(CORRECTION_POINTS)
    half = np.diff(edges)[:, None] / 2
    return np.ravel(edges[:-1, None] + half * (1 + nodes)), np.ravel(half * weights)
