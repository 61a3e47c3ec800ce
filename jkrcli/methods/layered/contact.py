"""One indenter on one layered specimen: nonadhesive contact at any radii, with as many nodes as an accuracy needs."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from ...base.errors import Refusal, SolveError, counted
from ...base.numerics import NO_CLAIM, Array, EvenCubic, cubic_spline
from ...bodies.indenters import Indenter
from ...bodies.problem import Solid, Specimen, contact_modulus
from ..integral import fredholm
from ..integral.fredholm import Quadrature, distinct
from .spectrum import LayeredSpectrum

if TYPE_CHECKING:
    from ..integral.finite_range import Attraction
    from ..integral.logarithm import LogarithmicAttraction

# --------------------------------------------------------------------------------------------------
# Product integration of the kernel's logarithmic part on composite Gauss panels.
#
# The symmetrised Nystrom matrix of ``fredholm`` is Galerkin's with the polynomials l_i of each panel that are 1 at
# one Gauss node and 0 at the others, as long as Gauss quadrature may stand for the integrals. Where the kernel tau(|x
# - t|) has a logarithm at x = t it may not: here the entries are the integrals themselves,
#
#     K_ij = 1/(w_i w_j) int int l_i(x) (tau(|x - t|) + tau(x + t))/2 l_j(t) dx dt,
#
# so that the matrix stays symmetric, positive definite and nested. On one panel the difference s = x - t has a
# polynomial weight and only int tau(s) s^n ds are needed; close panels use quadrature points that crowd at the ends
# that face each other; tau(x + t) is the difference to a mirrored panel.

Transform = Callable[[Array], Array]

# Points of the integrals on panels that lie close to each other.
PRODUCT_CLOSE = 2.0  # widths of the wider one, within which panels do; tuned on graded layers, by `make tuning`
# points along each of two panels, for each node of one: the polynomials of the nodes in a root of three
PRODUCT_CROWDED = 3.0  # tuned on graded layers, by `make tuning`
PRODUCT_LEAST = 14  # of those points; tuned on graded layers, by `make tuning`
PRODUCT_PER_DECADE = 250  # knots of the spline of tau, good to 1e-9; tuned on graded layers, by `make tuning`


def _points(order: int) -> int:
    """Points along a panel of ``order`` nodes."""
    return max(PRODUCT_LEAST, math.ceil(PRODUCT_CROWDED * order))


def product_matrix(transform: Transform, panels: fredholm.Panels) -> Array:
    """Matrix of K at all nodes and, in its last columns and rows, at the radii (of those only the nodes inside count).

    ``transform``: tau(s) [1/m] for s > 0, at most a logarithm at 0; entries [1/m], shape (nodes + radii, nodes +
    radii). The block of the radii among themselves is left at zero.
    """
    n = panels.x.size
    # A spline over ln(s) in place of tau, several times as fast and good to 1e-9
    smallest = float(np.diff(panels.edges).min()) * fredholm.crowded_rule(2 * _points(panels.order), 3)[0][0]
    ln_s = logarithms(smallest, 2 * float(panels.edges[-1]))
    spline = EvenCubic(ln_s[0], ln_s[1] - ln_s[0], cubic_spline(ln_s, transform(np.exp(ln_s))).c)

    def tau(s: Array) -> Array:
        return spline(np.log(s))

    total = np.zeros((n + panels.radii.size, n + panels.radii.size))
    total[:n, :n] = (_entries(tau, panels, False) + _entries(tau, panels, True)) / 2
    total[:n, n:] = (_columns(tau, panels, False) + _columns(tau, panels, True)) / 2
    total[n:, :n] = total[:n, n:].T
    return total


def logarithms(smallest: float, largest: float) -> Array:
    """Evenly spaced knots ln(s) with which a spline of tau is good to 1e-9."""
    ends = math.log(smallest), math.log(largest)
    return np.linspace(*ends, math.ceil(PRODUCT_PER_DECADE * (ends[1] - ends[0]) / math.log(10)))


def _entries(transform: Transform, panels: fredholm.Panels, mirrored: bool) -> Array:
    """Block of the nodes: the part of x - t or, ``mirrored``, of x + t."""
    order, count = panels.order, panels.edges.size - 1
    lo, width = panels.edges[:-1], np.diff(panels.edges)
    # tau of all distances between the nodes, zero where there is none.
    i, j = np.tril_indices(panels.x.size, 0 if mirrored else -1)
    values = np.zeros((panels.x.size, panels.x.size))
    values[i, j] = values[j, i] = transform(panels.x[i] + panels.x[j] if mirrored else panels.x[i] - panels.x[j])
    plain = values.reshape(count, order, count, order)
    gaps = lo[:, None] + lo if mirrored else lo[:, None] - panels.edges[1:]
    right, left = np.nonzero(np.tril(gaps < PRODUCT_CLOSE * np.maximum(width[:, None], width), 0 if mirrored else -1))
    points = _points(order)
    project = _projection(order, points)
    facing = project if mirrored else project[:, ::-1]
    u = fredholm.crowded_rule(points, 3)[0]
    gap = np.maximum(gaps[right, left], 0.0)[:, None, None]
    values = transform(gap + width[right][:, None, None] * u[:, None] + width[left][:, None, None] * u)
    blocks = np.einsum("bqr,qi,rj->bij", values, project, facing, optimize=True)
    plain[right, :, left, :] = blocks
    plain[left, :, right, :] = blocks.transpose(0, 2, 1)
    if not mirrored:
        each = np.arange(count)
        # int tau(s) sum over x - t = +s and -s of l_i(x) l_j(t), over w_i w_j: nodes s, weights (s, i, j)
        s, v = fredholm.crowded_rule(2 * points, 3)
        nodes, w = fredholm.rule(order)
        inside = np.outer(1 - s, (nodes + 1) / 2)
        first, second = fredholm.lagrange(order, inside), fredholm.lagrange(order, inside + s[:, None])
        overlap = np.einsum("q,s,sqi,sqj->sij", w / 2, v * (1 - s), first, second, optimize=True)
        weights = (overlap + overlap.transpose(0, 2, 1)) / np.outer(w / 2, w / 2)
        plain[each, :, each, :] = np.tensordot(transform(width[:, None] * s), weights, 1)
    return plain.reshape(panels.x.size, -1)


def _columns(transform: Transform, panels: fredholm.Panels, mirrored: bool) -> Array:
    """Columns of the radii a at the nodes t inside each: the part of a - t or, ``mirrored``, of a + t."""
    order, count = panels.order, panels.edges.size - 1
    lo, width = panels.edges[:-1], np.diff(panels.edges)
    distance = panels.x[:, None] + panels.radii if mirrored else np.abs(panels.x[:, None] - panels.radii)
    plain = transform(distance).reshape(count, order, -1)
    gaps = (lo if mirrored else -panels.edges[1:])[:, None] + panels.radii
    inside = panels.edges[1:, None] <= panels.radii
    panel, radius = np.nonzero(inside & (gaps < PRODUCT_CLOSE * width[:, None]))
    points = _points(order)
    project = _projection(order, points)
    values = transform(gaps[panel, radius][:, None] + width[panel][:, None] * fredholm.crowded_rule(points, 3)[0])
    plain[panel, :, radius] = values @ (project if mirrored else project[:, ::-1])
    return plain.reshape(panels.x.size, -1)


def _projection(order: int, points: int) -> Array:
    """(1/w_i) int l_i f = sum over the crowded nodes q of f_q times this (q, i)."""
    u, v = fredholm.crowded_rule(points, 3)
    return v[:, None] * fredholm.lagrange(order, u) / (fredholm.rule(order)[1] / 2)


# How a result is refined and checked, and what is refused.
# The quadrature is planned for this much less than the tolerance:
LAYERED_MARGIN = 8.0  # tuned on random bodies, by `make failures`
LAYERED_REFINEMENTS = 4  # at most; choice: each takes about twice the time
LAYERED_CHECKS = 12  # radii of the second quadrature, spread over all; tuned on random bodies, by `make failures`
LAYERED_GRADED = 20  # under a modulus that varies over depth; tuned on graded layers, by `make failures`
LAYERED_GAPS = 6  # more of them, after the widest gaps; tuned on random bodies, by `make failures`
LAYERED_FIRSTS = 4  # and first ones of groups; tuned on random bodies, by `make failures`
LAYERED_NEXT = 3  # choice: and those after the first one, in a geometric sequence
LAYERED_SAFETY = 4.0  # on the difference of the two quadratures; tuned on random bodies, by `make failures`
# radii on each side of one, from which its error is: differences go through zero
LAYERED_ABOUT = 2  # tuned on graded layers, by `make failures`
# of the largest difference of its column, and of its radius, which is stated where less is seen:
LAYERED_SHARE = 0.01  # tuned on graded layers, by `make failures`
LAYERED_MOST_NODES = 4000  # choice: a matrix of 128 MB
LAYERED_MOST_FLOPS = 4e11  # choice: minutes
LAYERED_COSINES = 2**19  # at once, of a kernel's function of the distance; choice: 4 MB
LAYERED_GROUP = 16  # least radii that are solved together; tuned on series of 100 to 10,000 points, by `make guards`
LAYERED_PER_GROUP = 2e7  # operations in place of what each group costs beside; tuned on the same, by `make guards`
LAYERED_NARROWER = 8.0  # panels per length over which a graded modulus changes; choice: some 1e-5 of the load
# operations per entry of a kernel's logarithmic part; tuned on bodies, by `make guards`: for forecasts
LAYERED_LOGARITHM = 400


GRADED = 1e-5  # the least tolerance under a modulus that varies over depth; tuned on graded layers, by `make failures`


@dataclass(frozen=True, eq=False)
class IndenterOnLayers(ABC):
    """An indenter on a layered specimen, whatever their surfaces do to each other; ``what`` is solved in how many
    ``rows``."""

    what: ClassVar[str]
    rows: ClassVar[str] = "rows"
    indenter: Indenter
    specimen: Specimen
    limit: float = math.inf  # the kernel is known at every radius; a search for forecasts need not go so far

    @property
    @abstractmethod
    def spectrum(self) -> LayeredSpectrum:
        """The compliance of both bodies over the wave number."""

    @property
    def E_star(self) -> float:
        """Contact modulus of the materials that touch [Pa]."""
        return contact_modulus(self.specimen.surface, self.indenter.material)

    @property
    def scale(self) -> float:
        """The length over which the kernel varies [m]; infinite for a homogeneous half-space."""
        return self.spectrum.scale

    @abstractmethod
    def plan(self, radii: Array, tolerance: float) -> Any:
        """The plan expected to be accurate to ``tolerance`` at the increasing ``radii`` [m]."""

    @abstractmethod
    def solved(self, radii: Array, plan: Any) -> fredholm.ContactResult:
        """Contact at the increasing ``radii`` [m]."""

    def checking(self, radii: Array, plan: Any, tolerance: float) -> tuple[IndenterOnLayers, Any]:
        """What solves at ``radii`` [m] by a discretisation that shares nothing with ``plan``, and its plan."""
        return self, plan.finer()

    def finer(self, plan: Any) -> Any:
        """The next plan where ``plan`` was too coarse."""
        return plan.finer()

    def unresolved(self, plan: Any, failure: SolveError) -> Exception:
        """What to raise where all plans up to ``plan`` were too coarse to solve the equation."""
        return failure

    def refined(self, radii: Array, tolerance: float) -> tuple[Any, Array]:
        """The result at ``radii`` and its estimated relative error at each, below ``tolerance``, from a second
        discretisation that differs in every part; it is done at some of the radii. Refusal where refinement does not
        reach the tolerance."""
        plan, best = self.plan(radii, tolerance / LAYERED_MARGIN), math.inf
        some = checked(radii, getattr(plan, "groups", 1), self.specimen.is_graded)
        failure = SolveError("contact equation: not solved")
        other, check = self.checking(radii[some], plan, tolerance)
        for _ in range(LAYERED_REFINEMENTS):
            try:
                main = self.solved(radii, plan)
                if (rounding := main.rounding.max()) > tolerance:
                    best = 2 * rounding  # the second discretisation's is as large
                    break
                errors = _errors(main, other.solved(radii[some], check), some) + tolerance * NO_CLAIM
                best = min(best, float(errors.max()))
                if best <= tolerance:
                    return main, errors
            except SolveError as error:
                failure = error
            except Refusal:
                if math.isinf(best):
                    raise
                break  # refined beyond the limits of the cost
            plan, check = self.finer(plan), self.finer(check)
        if math.isinf(best):
            raise self.unresolved(plan, failure)
        missed = f"layered: the estimated relative error{self.what} is {best:.1e} with {plan.nodes} {self.rows}, above "
        missed, smaller = f"{missed}the tolerance {tolerance:.1e}; ", "use a smaller contact radius"
        raise fredholm.InaccurateError(
            f"{missed}{fredholm.tolerance_remedy('layered', best)}{smaller}", f"{missed}{smaller}", best
        )


@dataclass(frozen=True, eq=False)
class LayeredContact(IndenterOnLayers):
    """Surfaces that slide, solved at given radii; nothing is kept between calls except the spectrum. ``order``: Gauss
    nodes per panel in k."""

    what = ""
    rows = "nodes"
    order: int = 24

    @cached_property
    def spectrum(self) -> LayeredSpectrum:
        return _spectrum(self.specimen, self.indenter.material)

    def plan(self, radii: Array, tolerance: float) -> Quadrature:
        """The cheapest quadrature expected to be accurate to ``tolerance`` at the increasing ``radii`` [m].

        Radii begin panels, which many radii would make more than the kernel needs: they are dealt out in groups.
        """
        plans = []
        for groups in 2 ** np.arange(int(math.log2(max(radii.size / LAYERED_GROUP, 1))) + 1):
            each = self.together(radii[(radii.size - 1) % groups :: groups], tolerance)
            plans.append(replace(each, groups=int(groups)))
        return min(plans, key=lambda plan: self.flops(radii, plan))

    def together(self, radii: Array, tolerance: float) -> Quadrature:
        """The same for all ``radii`` on one set of panels."""
        own = radii, self.indenter.a0, self.scale, tolerance
        tail = self.spectrum.tail
        return Quadrature.cheapest(*own) if tail is None else Quadrature.crowded(*own, tail.strength)

    def flops(self, radii: Array, plan: Quadrature) -> float:
        """Floating-point operations of one solve, about."""
        spectrum, each = self.spectrum, math.ceil(radii.size / plan.groups)
        waves = 300 + 0.5 * spectrum.bandwidth(spectrum.floor) * 2 * radii[-1]
        waves += 0 if spectrum.tail is None else LAYERED_LOGARITHM
        group = (plan.nodes + each) ** 2 * waves + plan.nodes**3 / 3 + plan.nodes**2 * each
        return float(plan.groups * group + (plan.groups - 1) * LAYERED_PER_GROUP)

    def guard(self, radii: Array, plan: Quadrature) -> None:
        """Refuse what would take minutes or gigabytes."""
        if plan.nodes > LAYERED_MOST_NODES or self.flops(radii, plan) > LAYERED_MOST_FLOPS:
            many = plan.groups > 1 and plan.nodes <= LAYERED_MOST_NODES  # each group costs as much
            fewer = ", or fewer points" if many else ""
            raise Refusal(
                f"layered: a = {radii[-1]:g} m is {radii[-1] / self.spectrum.scale:.4g} times the length over which "
                f"the layers act ({self.spectrum.scale:.3g} m) and needs {plan.nodes} nodes for "
                f"{counted(radii.size, 'radius', 'radii')} (limit {LAYERED_MOST_NODES}); use a smaller contact{fewer}"
            )

    def solved(self, radii: Array, plan: Quadrature) -> fredholm.ContactResult:
        """Contact at the increasing ``radii`` [m]; of one group with its densities, an ``EquationResult``."""
        self.guard(radii, plan)
        kernel, tail = self.spectrum.kernel(2 * float(radii[-1]), self.order), self.spectrum.tail
        columns, rounding = np.empty((4, radii.size)), np.empty(radii.size)
        for start in range(plan.groups):
            dealt = slice(start, None, plan.groups)
            panels = fredholm.Panels.through(radii[dealt], plan, self.indenter.a0)
            K = kernel.square(panels.places)
            if tail is not None:
                K = K + product_matrix(tail.transform, panels)
            part = fredholm.solve(K, panels, self.indenter, self.E_star, plan.inner)
            if plan.groups == 1:
                return part
            columns[:, dealt], rounding[dealt] = part.columns, part.rounding
        delta, P, S, dS = columns
        return fredholm.ContactResult(replace(part.panels, radii=radii), delta, P, S, dS, rounding)

    def matrix(self, panels: fredholm.Panels) -> Array:
        """K [1/m] at the places of the ``panels``."""
        tail = self.spectrum.tail
        K = self.spectrum.kernel(2 * float(panels.edges[-1]), self.order).square(panels.places)
        return K if tail is None else K + product_matrix(tail.transform, panels)

    def attraction(self, reach: float, tolerance: float) -> Attraction:
        """The pair of bodies ready for adhesion of finite range up to ``reach`` [m], K to the relative
        ``tolerance``."""
        from ..integral.finite_range import Attraction

        panels = self.attraction_panels(reach, tolerance)
        return Attraction.of(self.indenter, self.E_star, panels, self.matrix(panels))

    def logarithmic(self, reach: float, tolerance: float, order: int) -> LogarithmicAttraction:
        """The same where the modulus changes right below the contact, on panels of ``order`` nodes, with a spline over
        ln(s) in place of the kernel's function of the distance s."""
        from scipy.interpolate import make_interp_spline

        from ..integral import logarithm

        spectrum = LayeredSpectrum(self.specimen, self.indenter.material, logarithm.LOGARITHM_FLOOR)
        kernel, tail = spectrum.kernel(2 * reach, self.order), spectrum.tail
        assert tail is not None
        # The part of the rest of g - 1 is smooth at s = 0; it varies over ``finest`` and, far away, over s
        v = np.arange(0.0, math.asinh(2 * reach / tail.finest) + 2 * logarithm.LOGARITHM_STEP, logarithm.LOGARITHM_STEP)
        parts = np.array_split(np.sinh(v) * tail.finest, max(v.size * kernel.k.size // LAYERED_COSINES, 1))
        waves = np.concatenate([np.cos(np.outer(part, kernel.k)) @ kernel.weights for part in parts])
        rest = make_interp_spline(v, waves, 7)
        ends = math.log(logarithm.LOGARITHM_NEAREST * reach), math.log(2 * reach)
        ln_s = np.linspace(*ends, math.ceil(logarithm.LOGARITHM_KNOTS * order * (ends[1] - ends[0]) / math.log(10)))
        s = np.exp(ln_s)
        whole = tail.transform(s) + rest(np.arcsinh(s / tail.finest))
        spline = EvenCubic(ln_s[0], ln_s[1] - ln_s[0], cubic_spline(ln_s, whole).c)

        def tau(distance: Array) -> Array:
            return spline(np.log(np.maximum(distance, s[0])))

        widest = logarithm.widest_panel(tau, order, reach, tolerance, self.specimen.top_thickness)
        return logarithm.LogarithmicAttraction(self.indenter, self.E_star, tau, reach, order, widest)

    def attraction_panels(self, reach: float, tolerance: float) -> fredholm.Panels:
        """The panels of ``attraction``; Refusal where they are too many."""
        from ..integral.finite_range import panels_for

        crowding = 1.0 if self.spectrum.tail is None else LAYERED_NARROWER * self.scale / self.spectrum.tail.finest
        return panels_for(reach, self.indenter.a0, self.scale, tolerance, crowding)

    def checking(self, radii: Array, plan: Any, tolerance: float) -> tuple[LayeredContact, Quadrature]:
        """Shared is g(k) alone: other panels and nodes in x, few wide ones of high order, other nodes in k, other means
        of F."""
        check = self.plan(radii, tolerance / LAYERED_MARGIN**3).finer()
        return replace(self, order=20), replace(check, inner=26)

    def finer(self, plan: Quadrature) -> Quadrature:
        return plan.finer() if self.spectrum.tail is None else plan.narrower()

    def unresolved(self, plan: Quadrature, failure: SolveError) -> fredholm.InaccurateError:
        missed = f"layered: {plan.nodes} nodes do not resolve the kernel, the error is not known; use "
        less = "a smaller contact radius"
        return fredholm.InaccurateError(f"{missed}more points or {less}", f"{missed}{less}")


@lru_cache(maxsize=8)  # the radii of one body are often solved in several steps
def _spectrum(specimen: Specimen, indenter: Solid | None) -> LayeredSpectrum:
    return LayeredSpectrum(specimen, indenter)


def _errors(main: fredholm.ContactResult, other: fredholm.ContactResult, some: Array) -> Array:
    """Relative error of each column at every radius (4, radii): the largest difference at the ``some`` radii about it,
    ``about`` and one on each side, with a safety, and rounding."""
    seen, about = np.abs(other.columns / main.columns[:, some] - 1), LAYERED_ABOUT
    wide = np.lib.stride_tricks.sliding_window_view(np.pad(seen, ((0, 0), (about, about))), 2 * about + 1, axis=1)
    near = np.maximum(wide.max(axis=-1), LAYERED_SHARE * np.maximum(seen.max(axis=0), seen.max(axis=1)[:, None]))
    after = np.minimum(np.searchsorted(some, np.arange(main.delta.size)), some.size - 1)
    return LAYERED_SAFETY * np.maximum(near[:, after], near[:, np.maximum(after - 1, 0)]) + main.rounding


def checked(radii: Array, groups: int = 1, graded: bool = False) -> Array:
    """Indices of the radii at which a result is checked: spread over all, more of them under a ``graded`` modulus,
    whose errors change from radius to radius, with the ends of the widest gaps, the first radii of some ``groups``,
    inside which a single panel has to hold what F does next to the axis, and some between the first two."""
    spread = np.linspace(0, radii.size - 1, LAYERED_GRADED if graded else LAYERED_CHECKS).astype(int)
    widest = np.argsort(np.diff(radii, prepend=0.0))[-LAYERED_GAPS:]
    firsts = np.geomspace(1, groups, LAYERED_FIRSTS).astype(int) - 1
    after = np.geomspace(1, max(spread[1] / 2, 1), LAYERED_NEXT).astype(int)
    return distinct(np.minimum(np.concatenate([spread, widest, firsts, after]), radii.size - 1))
