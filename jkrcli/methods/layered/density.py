"""The function phi of the contact equation at one contact radius, inside the contact and, extended, beyond it."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.polynomial import legendre

from ...base.errors import InputError
from ...bodies.indenters import Indenter, Paraboloid, PowerLaw, RoundedFlat, Sphere, TableProfile
from .kernel import Kernel, gauss, rule, split
from .solver import AbelImage, Nested

Array = np.ndarray

PIECE = 18  # Gauss nodes on each piece of the smooth part, one kernel scale wide
MORE = 6  # Gauss nodes than that on each panel of an integral over phi
WIDEST = 1.5  # largest panel in an angle


@dataclass(frozen=True, eq=False)
class Density:
    """phi(x) = (2/pi) (delta - F(x)) - (2/pi) int_0^a K(x,t) phi(t) dt [m] for 0 <= x <= ``reach``.

    The last term is smooth; it is kept as Legendre series ``coefficients`` on the equal pieces between ``edges`` [m].
    """

    indenter: Indenter
    a: float
    delta: float
    edges: Array
    coefficients: Array
    breaks: tuple[float, ...]

    @classmethod
    def of(cls, kernel: Kernel, indenter: Indenter, nested: Nested, shift: float, reach: float) -> Density:
        """phi at the last radius of ``nested`` for the displacement delta_H - ``shift`` [m], up to ``reach`` [m]."""
        return next(cls.each(kernel, indenter, nested, [nested.panels.radii.size - 1], shift, reach))

    @classmethod
    def each(
        cls,
        kernel: Kernel,
        indenter: Indenter,
        nested: Nested,
        which: Iterable[int],
        shift: float,
        reach: float,
        order: int = PIECE,
    ) -> Iterator[Density]:
        """The same at the radii of the numbers ``which``, from one evaluation of the kernel; ``order``: nodes on each
        piece."""
        pieces = max(math.ceil(reach / kernel.scale), 1)
        edges = np.linspace(0, reach, pieces + 1)
        nodes, node_weights = rule(order)
        x, _ = gauss(edges[:-1], edges[1:], nodes, node_weights)
        K = 2 / math.pi * kernel(x, nested.panels.x)
        project = legendre.legvander(nodes, order - 1) * node_weights[:, None] * (np.arange(order) + 0.5)
        breaks = AbelImage.of(indenter).breaks
        for n in which:
            t, weights, phi = nested.density(n, shift)
            smooth = (K[:, : t.size] @ (weights * phi)).reshape(pieces, order)
            a, delta = float(nested.panels.radii[n]), float(nested.delta[n]) - shift
            yield cls(indenter, a, delta, edges, (smooth @ project).T, breaks)

    def anchored(self) -> Density:
        """The same with phi(a) = 0 not only to rounding: that is what decides on the gap next to a nonadhesive edge."""
        return replace(self, delta=self.delta - math.pi / 2 * float(self(np.array([self.a]))[0]))

    def __call__(self, x: Array) -> Array:
        """phi(x) [m]."""
        return 2 / math.pi * (self.delta - self.indenter.abel(x)) - self._smooth(x, self.coefficients)

    def slope(self, x: Array) -> Array:
        """phi'(x) [-], x > 0."""
        derivative = legendre.legder(self.coefficients) * (2 / self.edges[1])
        return -2 / math.pi * abel_slope(self.indenter, x) - self._smooth(x, derivative)

    def _smooth(self, x: Array, coefficients: Array) -> Array:
        piece = np.clip(np.searchsorted(self.edges, x, side="right") - 1, 0, self.edges.size - 2)
        local = 2 * (x - self.edges[piece]) / self.edges[1] - 1
        return legendre.legval(local, coefficients[:, piece], tensor=False)

    def nodes(self, lo: float, hi: float, angle: Callable[[Array], Array]) -> tuple[Array, Array]:
        """Quadrature nodes and weights in ``angle(x)`` for x from ``lo`` to ``hi``.

        Panels end at pieces and breaks, and nodes crowd quadratically at each left end, where F may have a kink.
        """
        inner = np.concatenate([self.edges, self.breaks])
        inner = inner[(inner > lo) & (inner < hi)]
        theta = angle(np.unique(np.concatenate([[lo], inner, [hi]])))
        pieces = np.maximum(np.ceil(np.diff(theta) / WIDEST), 1).astype(int)
        left, right = split(theta[:-1], theta[1:], pieces)
        u, v = rule(len(self.coefficients) + MORE)
        u, v = (u + 1) / 2, v / 2
        width = (right - left)[:, None]
        return np.ravel(left[:, None] + width * u**2), np.ravel(width * (2 * u * v))


def abel_slope(indenter: Indenter, x: Array) -> Array:
    """F'(x) [-] of the Abel image, x > 0: F' = F/x + int_0^x r f''(r)/sqrt(x^2 - r^2) dr, in closed form."""
    match indenter:
        case Paraboloid(R=R):
            return 2 * x / R
        case Sphere(R=R):
            return np.arctanh(x / R) + x * R / ((R - x) * (R + x))
        case PowerLaw(d=d):
            return d * indenter.abel(x) / x
        case RoundedFlat(b=b, edge_radius=edge_radius):
            root = np.sqrt(np.maximum(x - b, 0) * (x + b))
            return (2 * root - b * np.arctan2(root, b)) / edge_radius
        case TableProfile(knots=knots, slopes=slopes):
            below = np.minimum(knots, x[..., None])
            root = np.sqrt((x[..., None] - below) * (x[..., None] + below))
            return indenter.abel(x) / x - np.sum(np.diff(slopes) / np.diff(knots) * np.diff(root, axis=-1), axis=-1)
    raise InputError(f"profile: pressures under a {type(indenter).__name__} are not implemented")
