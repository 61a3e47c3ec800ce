"""By how much the edge of the contact runs ahead of the nodes whose radii a series reports, and its loads over those of
the bodies that it is said to be of.

The bodies' own solution tells the radius at every displacement, whatever the modulus. Counted in nodes a(delta) lies z
beyond the node of its row, and where the edge runs c elements ahead, z is anywhere between c and c + 1, each place as
likely: the rows next to these ends tell c, all of them together, with what scatters about them. The radius of the tip
makes all a(delta) too large or too small together, and is sought with it. Loads at equal displacement then tell the
factor of the moduli.

Where the bodies have no solution, or it is not to be used, the tip still has: the smaller the contact, the more it is
one with a half-space, a -> F^-1(delta). What the rest of the body makes of it grows as a^2; its powers are fitted with
c, which tells which node it is whose radius is reported, and little more.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from ..adhesion.slopes.nodes import AS_THEY_ARE, Ahead, NodeRadii, as_nodes, node_radii
from ..base.numerics import HALF_WIDTH, ROUNDED, Array, cubic_spline, f_tail
from ..base.units import show
from ..bodies.indenters import Indenter
from ..bodies.problem import Problem
from ..series import RawSeries, Series
from .resolve import own_solution

# What is thought of the edge before, and how it is found.
# elements by which the edge runs ahead of a node that begins to carry; theory: 0 for exact complementarity,
# 0.1 to 0.3 for surfaces, averaged pressures and thresholds
AHEAD_KNOWN = (0.0, 0.3)
# and what the radius of another node, the nearest or the next one, adds; theory: as the nodes are counted
AHEAD_NODES = (0.0, -0.5, -1.0)
AHEAD_USUAL = 0.7  # choice: probability that it is the outermost node
AHEAD_LEAST = 0.01  # elements that are left; tuned on node-based series, by `make node-study`
AHEAD_ROWS = 160  # choice: most rows that are asked, those next to another radius first
AHEAD_FIRST = 2.5  # choice: elements, below which meshes do not tell where the edge is
AHEAD_OUTLIER = 0.01  # choice: probability of a row that tells nothing
# relative scatter of radii at equal displacement that is thought possible; choice: decades
AHEAD_SCATTER = (1e-5, 1e-4, 3e-4, 1e-3, 3e-3, 1e-2)
AHEAD_BLUR = 0.01  # choice: elements, of the ends of the interval
AHEAD_RADIUS = 0.002  # of displacements at equal radii; choice: usual size of what meshes and cuts make of them
AHEAD_WRONG = 0.05  # choice: of displacements, from which the radius of the tip is another
AHEAD_LOADS = 1.1  # choice: factor of loads that is warned of; meshes that do not lock err by less than a third
AHEAD_DEEP = 0.1  # choice: of the largest displacement, from which loads count
AHEAD_NEAR = 0.04  # choice: by how much a factor may miss that of a usual cause
# choice: Poisson's ratio from which, and factor up to which elements lock
AHEAD_LOCKS = (0.45, 2.5)
# mean log likelihood of a row, from which the bodies are those; tuned on node-based series, by `make node-study`
AHEAD_FITS = -1.0
# of radii, up to which a body departs from the half-space; tuned on node-based series, by `make node-study`
AHEAD_HALF_SPACE = (0.3, 0.15)
# of the radius, from its square on, by which it does; tuned on node-based series, by `make node-study`
AHEAD_POWERS = (2, 3)
AHEAD_SPARE = 4  # touches beyond what is fitted; choice: fewer tell nothing
AHEAD_ALIKE = 1.001  # choice: of sizes of elements, told as one number
# Radii that increments reach by equal steps are those of nodes where the edge is this many elements off them, and
# so many standard errors, and loads at equal displacement are those of the bodies to this part:
AHEAD_OFF = 0.25  # choice: less is no matter
AHEAD_SURE = 4.0  # choice: rare
AHEAD_SAME = 0.02  # choice: meshes that do not lock err by less

# theory: loads of a part of the body over those of the whole
PARTS = {
    1 / 180: "a wedge of 2 degrees, CalculiX's: --factor P=180",
    1 / 360: "a wedge of 1 degree: --factor P=360",
    1 / 72: "a wedge of 5 degrees: --factor P=72",
    1 / (2 * math.pi): "loads per radian: --factor P=6.2832",
    1 / 2: "half of the body: --factor P=2",
    1 / 4: "a quarter of the body: --factor P=4",
    2.0: "a half model counted twice: --factor P=0.5",
    4.0: "a quarter counted fourfold: --factor P=0.25",
}


@dataclass(frozen=True)
class Loads:
    """``factor`` of the loads over those of the bodies at equal displacement, with its relative half-width
    ``error``; ``stretch``: factor of the displacements over those of the bodies at equal radii, 1 where it may be;
    ``fits``: whether radii over displacements are of the shape that the bodies have."""

    factor: float
    error: float
    stretch: float
    fits: bool

    @property
    def words(self) -> str:
        """The factor with its error."""
        number = f"{self.factor:#.4g}".rstrip(".")
        return f"{number} ± {self.factor * self.error:.1g} times the exact loads of these bodies at equal displacement"

    def doubts(self, problem: Problem) -> tuple[str, ...]:
        """What is likely to be wrong, if anything is, as one warning that begins with the loads."""
        parts, R = [], problem.indenter.tip_radius
        off = abs(math.log(self.factor)) > max(math.log(AHEAD_LOADS), self.error)
        if off:
            parts.append(f"the loads are {self.words}{f': {self._causes(problem)}' if self.fits else ''}")
        if not self.fits:
            layers = problem.specimen.layers
            what = f"the thickness {show(layers[0].thickness, 'length')}, R" if layers else "R"
            alone = not off and self.error < AHEAD_SAME  # loads at equal displacement do not feel the radii
            parts.append(
                f"the loads are {self.words}, contact radii are not: is their unit right, and are they those of nodes "
                "(import --nodes)?" if alone
                else f"contact radii, displacements and loads are not those of these bodies: are {what} and the units "
                "right?"
            )  # fmt: skip
        elif abs(math.log(self.stretch)) > math.log(AHEAD_LOADS):
            fitting = "" if R is None else f" (R = {show(R / self.stretch, 'length')} fits)"
            there = (
                f"at equal contact radii the displacements are {self.stretch:.3g} times the exact ones of these bodies"
            )
            parts.append(f"{there}{fitting}: is R right, and the unit of radius and displacement?")
        return ("; ".join(parts),) if parts else ()

    def _causes(self, problem: Problem) -> str:
        usual = [cause for part, cause in PARTS.items() if abs(math.log(self.factor / part)) < AHEAD_NEAR]
        power = math.log10(self.factor)
        if round(power) and abs(power - round(power)) < AHEAD_NEAR:
            usual.append(f"a unit, {10.0 ** round(power):g} times too {'large' if power > 0 else 'small'}")
        nu = max(material.surface.nu for material in problem.specimen.materials)
        if nu > AHEAD_LOCKS[0] and 1 < self.factor < AHEAD_LOCKS[1]:
            usual.append(f"elements that lock at nu = {nu:g}")
        known = any(abs(math.log(self.factor / part)) < AHEAD_NEAR for part in PARTS)
        return "; ".join(usual if known else [*usual, "a part of the body (--factor P=...), a unit, E?"])


@dataclass(frozen=True, eq=False)
class Compared:
    """Rows ``raw`` beside the bodies that they are said to be of: the radii of ``nodes`` they have, the bodies' ``own``
    solution, and by how much the edge runs ``ahead`` of those nodes; None where there is none."""

    problem: Problem
    raw: RawSeries
    nodes: NodeRadii | None
    own: Series | None
    ahead: Ahead
    found: Found | None

    @property
    def rows(self) -> RawSeries:
        """The rows at radii of the edge of the contact, as far as these are known."""
        return self.raw.touching if self.nodes is None else self.nodes.touches(self.ahead.elements).rows

    @property
    def of_nodes(self) -> str:
        """What is known of the radii, in words; empty where they are none of nodes."""
        if self.nodes is None:
            return ""
        c, error, source, _ = self.ahead
        least, most = float(self.nodes.element.min()), float(self.nodes.element.max())
        range_ = f"{show(least, 'length')} to " if most > AHEAD_ALIKE * least else ""
        spacing = f"radii of nodes, spacing {range_}{show(most, 'length')}"
        if source == "assumed":
            return f"{spacing}; where the edge is between them is not known: {c:+.2f} ± {error:.2f} elements taken"
        how = {"body": "corrected", "tip": "corrected by the tip alone"}[source]
        where = f"{abs(c):.2f} ± {error:.2f} elements {'outside' if c >= 0 else 'inside'} the node"
        return f"{spacing}; the contact edge is {where}: {how}"

    def loads(self) -> Loads | None:
        """The factor of the loads over those of the bodies; None where these have no solution."""
        own = self.own
        if own is None:
            return None
        a, fits = self.rows, self.found is None or self.found.fit > AHEAD_FITS
        stretch = _stretch(own, a, 0.0) if self.found is None else self.found.stretch
        as_it_is = self._loads(own, 0.0, fits)
        if abs(stretch) < AHEAD_WRONG or (as_it_is is not None and _same(as_it_is)):
            return as_it_is
        return self._loads(own, stretch, fits)

    def _loads(self, own: Series, stretch: float, fits: bool) -> Loads | None:
        """The factor of the loads at displacements that are those of the bodies after a ``stretch`` of their logs."""
        rows = self.raw.touching
        x = np.log(rows.delta[rows.delta > 0]) + stretch
        P = rows.P[rows.delta > 0]
        inside = (x > np.log(own.delta[0])) & (x < np.log(own.delta[-1])) & (P > 0)
        inside &= x > np.log(AHEAD_DEEP) + x[inside].max(initial=-np.inf)
        if inside.sum() < AHEAD_SPARE:
            return None
        gap = np.log(P[inside]) - cubic_spline(np.log(own.delta), np.log(own.P))(x[inside]) + stretch
        parts = [float(np.median(part)) for part in np.array_split(gap, min(AHEAD_SPARE, gap.size))]
        middle = float(np.median(gap))
        scatter = 1.25 * float(np.median(np.abs(gap - middle))) / 0.6745 / math.sqrt(gap.size)
        error = math.hypot((max(parts) - min(parts)) / 2, HALF_WIDTH * scatter)
        fits = fits and error < math.log(AHEAD_LOADS)
        return Loads(math.exp(middle), max(error, 1e-4), math.exp(-stretch), fits)


def _same(loads: Loads) -> bool:
    """Whether loads at equal displacement are those of the bodies: then no other tip explains what the radii miss."""
    return abs(math.log(loads.factor)) + loads.error < DEPARTURE_LEAST


def compared(problem: Problem, raw: RawSeries, with_bodies: bool = True, disc: bool = True) -> Compared:
    """``raw`` beside the bodies of ``problem``, or beside their tip alone; as it is where it is no ``disc``."""
    if not disc:
        return Compared(problem, raw, None, None, AS_THEY_ARE, None)
    touching, nodes = raw.touching, node_radii(raw)
    reached = touching.a if nodes is None else np.append(touching.a, touching.a[-1] + 2 * nodes.spacing)
    within = np.minimum(reached[reached > problem.indenter.a0], problem.indenter.r_max * (1 - ROUNDED))
    own = own_solution(problem, within) if with_bodies and within.size else None
    if nodes is None and own is not None:
        nodes = _beside_body(raw, Compared(problem, raw, None, own, AS_THEY_ARE, None))
        if nodes is not None:  # and the fit is to know
            element = np.interp(raw.a, nodes.rows.a, nodes.element)
            raw = replace(raw, element=element)
    if nodes is None:
        return Compared(problem, raw, None, own, AS_THEY_ARE, None)
    found = None if own is None else by_body(nodes, own)
    if found is not None and found.fit > AHEAD_FITS:
        return Compared(problem, raw, nodes, own, found.ahead, found)
    return Compared(problem, raw, nodes, own, by_tip(nodes, problem.indenter), found)


def _beside_body(raw: RawSeries, as_they_are: Compared) -> NodeRadii | None:
    """Rows as those of nodes where the bodies alone tell that they are: radii of increments that pass as many elements
    each are as smooth as those of the edge, all the same part of an element off. None where they are the bodies' own,
    or loads at equal displacement, which do not feel the radius, are those of other bodies."""
    own, nodes = as_they_are.own, as_nodes(raw)
    assert own is not None
    if nodes is None:
        return None
    loads, rows, e = as_they_are._loads(own, 0.0, True), nodes.rows, nodes.element
    inside = (rows.a > AHEAD_FIRST * e) & (rows.delta > own.delta[0]) & (rows.delta < own.delta[-1])
    if loads is None or loads.error > AHEAD_SAME or np.count_nonzero(inside) < 2 + AHEAD_SPARE:
        return None
    beyond = cubic_spline(np.log(own.delta), np.log(own.a - own.a0))
    x = np.log(rows.delta[inside])
    a = own.a0 + np.exp(beyond(x))
    columns = np.stack([np.ones(a.size), (a - own.a0) * beyond(x, 1) / e[inside]])  # what an error of R does, too
    z = nodes.counted(a) - nodes.number[inside]
    (off, stretch), *_ = np.linalg.lstsq(columns.T, z, rcond=None)
    left = z - np.array([off, stretch]) @ columns
    variance = float(left @ left) / (z.size - 2) * float(np.linalg.inv(columns @ columns.T)[0, 0])
    told = abs(off) > max(AHEAD_OFF, AHEAD_SURE * math.sqrt(variance)) and np.abs(left).max() < 1
    return nodes if told and by_body(nodes, own).fit > AHEAD_FITS else None


@dataclass(frozen=True)
class Found:
    """``ahead``: by how much the edge runs ahead; ``stretch``: log of displacements of the body's solution over those
    of the series at equal radii; ``fit``: the mean of the log likelihood of the rows, 0 where all lie between a node
    and the next."""

    ahead: Ahead
    stretch: float
    fit: float


def by_body(nodes: NodeRadii, own: Series) -> Found:
    """What the bodies' ``own`` solution tells of the edge."""
    # Rows that tell most: those next to another radius, beyond the first elements
    rows, changes = nodes.rows, np.diff(nodes.rows.a) > 0
    near = np.append(changes, True) | np.append(True, changes)
    inner = rows.a > AHEAD_FIRST * nodes.element
    chosen = np.flatnonzero(near & inner if np.count_nonzero(near & inner) >= AHEAD_ROWS // 8 else near)
    chosen = chosen[np.unique(np.linspace(0, chosen.size - 1, AHEAD_ROWS).astype(int))] if chosen.size else chosen
    delta, e = rows.delta[chosen], nodes.element[chosen]
    beyond = cubic_spline(np.log(own.delta), np.log(own.a - own.a0))
    # 0 where the displacements are the same, as far as a radius is known
    offset = _stretch(own, rows, nodes.element / 2)
    if abs(offset) <= AHEAD_WRONG + 3 * float(np.median(nodes.element / rows.a)):
        offset = 0.0
    x = np.log(delta) + offset
    a = own.a0 + np.exp(beyond(x))
    z, lever = nodes.counted(a) - nodes.number[chosen], (a - own.a0) * beyond(x, 1) / e
    spread = np.sinh(np.linspace(-3, 3, 25)) * AHEAD_RADIUS
    ends = -1.6, 0.9
    for refinement in range(2):
        c = np.linspace(*ends, 41)
        logs = np.stack([_log_likelihood(z, lever, a / e, c, spread, scatter) for scatter in AHEAD_SCATTER])
        logs -= np.log1p((spread / AHEAD_RADIUS) ** 2)  # Cauchy's: more is rare, not excluded
        weights = np.exp(logs - logs.max())
        weights /= weights.sum()
        mean_c, sd_c = _moments(c, weights.sum(axis=(0, 2)))
        mean_s, sd_s = _moments(spread, weights.sum(axis=(0, 1)))
        if refinement == 0:
            ends = mean_c - 4 * max(sd_c, 0.02), mean_c + 4 * max(sd_c, 0.02)
            width = 4 * max(sd_s, 3e-4)
            spread = np.linspace(mean_s - width, mean_s + width, 25)
    error = math.hypot(HALF_WIDTH * sd_c, AHEAD_LEAST)
    # By least squares with the stretch, where touches scatter as their errors say
    touches = nodes.touches(mean_c)
    within = touches.rows.a > AHEAD_FIRST * touches.element
    spacing, sure = touches.element[within], touches.errors[within] / touches.element[within] / HALF_WIDTH
    seen_x = np.log(touches.rows.delta[within]) + (offset + mean_s)
    columns = np.stack([np.ones(spacing.size), np.exp(beyond(seen_x)) * beyond(seen_x, 1) / spacing]) / sure
    normal = columns @ columns.T + np.diag([0.0, AHEAD_RADIUS**-2])
    of_scatter = math.sqrt(float(np.linalg.inv(normal)[0] @ (columns @ columns.T) @ np.linalg.inv(normal)[0]))
    left = math.hypot(HALF_WIDTH * math.sqrt(max(sd_c**2 - of_scatter**2, 0.0)), AHEAD_LEAST)
    return Found(Ahead(mean_c, error, "body", left), offset + mean_s, float(logs.max()) / z.size)


def by_tip(nodes: NodeRadii, indenter: Indenter) -> Ahead:
    """What the tip alone tells of the edge: which node it is, where the contact is small enough."""
    c = np.linspace(-1.2, 0.5, 171)
    low, high = AHEAD_KNOWN
    prior = np.zeros(c.size)
    usual = AHEAD_USUAL if nodes.rows.element is None else 1.0  # a mesh is given with the nodes in contact
    for share, node in zip((usual, *[(1 - usual) / 2] * 2), AHEAD_NODES, strict=True):
        inside = (c >= node + low - 1e-9) & (c <= node + high + 1e-9)
        prior[inside] += share / inside.sum()
    seen = _of_half_space(nodes, indenter)
    if seen is not None:
        at, error = seen
        prior *= np.exp(-0.5 * ((c - at) / error) ** 2)
        if prior.sum() < 1e-30:
            return Ahead(at, HALF_WIDTH * error, "tip", HALF_WIDTH * error)
    mean, sd = _moments(c, prior / prior.sum())
    return Ahead(mean, HALF_WIDTH * sd, "assumed" if seen is None else "tip", HALF_WIDTH * sd)


def _of_half_space(nodes: NodeRadii, indenter: Indenter) -> tuple[float, float] | None:
    """c and its standard error by the first touches, where the body is not yet far from a half-space; None where there
    are too few of them. What other ranges and powers make of it differently counts as error."""
    touches = nodes.touches()
    if indenter.a0 > 0:
        return None
    a, e = touches.rows.a, touches.element
    # Radii at which the tip touches a half-space at the displacements `delta` (n,) [m].
    top = min(indenter.r_max * (1 - 1e-9), 10 * float(a[-1]))
    radii = indenter.a0 + np.geomspace(1e-3 * float(a[0]), top - indenter.a0, 2000)
    alone = np.exp(np.interp(np.log(touches.rows.delta), np.log(indenter.abel(radii)), np.log(radii)))
    tries = []
    for limit in AHEAD_HALF_SPACE:
        far = np.abs(alone / a - 1) > limit + e / a
        few = int(np.argmax(far)) if far.any() else a.size
        for powers in AHEAD_POWERS:
            if few < powers + 1 + AHEAD_SPARE:
                break
            off = nodes.counted(alone[:few]) - touches.at[:few]
            tries.append(_fitted(a[:few], e[:few], off, touches.errors[:few], powers))
    if len(tries) < 2:
        return None
    values, errors = np.array(tries).T
    value = float(values[-1])
    return value, float(np.hypot(errors[-1], np.abs(values[:-1] - value).max()))


def _fitted(a: Array, e: Array, z: Array, errors: Array, powers: int) -> tuple[float, float]:
    """c and its standard error, by the places ``z`` (n,) beyond the nodes at which the tip alone would touch a
    half-space, counted in nodes; with some ``powers`` of the radius from its square on."""
    weights = HALF_WIDTH * e / errors
    x = a / a[-1]
    columns = np.stack([np.ones(a.size), *(x ** (2 + i) * e[-1] / e for i in range(powers))], axis=1)
    normal = columns * weights[:, None]
    covariance = np.linalg.inv(normal.T @ normal + 1e-12 * np.eye(columns.shape[1]))
    coefficients = covariance @ normal.T @ (weights * z)
    left = weights * (z - columns @ coefficients)
    unit = max(float(left @ left) / (a.size - columns.shape[1]), 1.0)
    return float(coefficients[0]), float(np.hypot(np.sqrt(unit * covariance[0, 0]), 0.03))


def _stretch(own: Series, rows: RawSeries, ahead: Array | float) -> float:
    """Log of the body's displacements over those of the rows at equal radii, the edge ``ahead`` of theirs [m]: the
    median over the larger half; 0 where the body's solution has none of these."""
    a = rows.a + ahead
    there = (rows.a >= np.median(rows.a)) & (a > own.a[0]) & (rows.a <= own.a[-1]) & (rows.delta > 0)
    if not there.any():
        return 0.0
    log_delta = cubic_spline(np.log(own.a - own.a0), np.log(own.delta))
    return float(np.median(log_delta(np.log(a[there] - own.a0)) - np.log(rows.delta[there])))


def _log_likelihood(z: Array, lever: Array, count: Array, c: Array, stretch: Array, scatter: float) -> Array:
    """Log of the likelihood of ``c`` (m,) elements and ``stretch`` (k,), shape (m, k), for rows (n,) that lie ``z``
    elements beyond their nodes, each blurred by the ``scatter`` of its radius of ``count`` elements."""
    from scipy.special import ndtr

    blur = np.hypot(AHEAD_BLUR, scatter * count)
    at = ((z[:, None] + lever[:, None] * stretch)[:, None, :] - c[:, None]) / blur[:, None, None]
    inside = ndtr(at) - ndtr(at - 1 / blur[:, None, None])
    return np.log((1 - AHEAD_OUTLIER) * inside + 0.1 * AHEAD_OUTLIER).sum(axis=0)


def _moments(x: Array, weights: Array) -> tuple[float, float]:
    mean = float(weights @ x)
    return mean, math.sqrt(max(float(weights @ (x - mean) ** 2), 0.0))


# --------------------------------------------------------------------------------------------------
# How a measured or computed series departs from the solution of the bodies that it is claimed to be of.

# When a departure is reported.
DEPARTURE_FEWEST = 8  # choice: points; the parabolas take six numbers
DEPARTURE_CHANCE = 2e-3  # probability that independent noise shows as much; choice: rare
DEPARTURE_OF_LINE = 2e-2  # that it shows as straight a line in the load; tuned on drifts, by `make noise-study`
DEPARTURE_LEAST = 5e-3  # choice: of delta or P; meshes of finite elements leave as much
DEPARTURE_OF_NODES = 0.05  # of the load where radii are those of nodes; choice: cut and coarse bodies leave as much
DEPARTURE_FLOOR = 1e-14  # theory: variance below which nothing is known of the scatter
DEPARTURE_LONGEST = 0.99  # choice: correlation of neighbours; more is drift itself


def check_against_solution(beside: Compared) -> tuple[str, ...]:
    """A sentence on how rows depart from the bodies' own solution by more than their scatter explains, if they do.

    Nothing where no exact method represents the bodies, or where points are few. Radii of nodes lie anywhere within an
    element, which says nothing of the bodies: their loads are compared at equal displacement.
    """
    own = beside.own
    if own is None:
        return ()
    if beside.nodes is not None:
        rows = beside.nodes.rows
        usable = (rows.delta > max(AHEAD_DEEP * rows.delta.max(), own.delta[0])) & (rows.delta <= own.delta[-1])
        if np.count_nonzero(usable) < DEPARTURE_FEWEST:
            return ()
        x, logs = np.log(own.delta), np.log(np.stack([own.a, own.P]))
        log_a, expected = cubic_spline(x, logs.T)(np.log(rows.delta[usable])).T
        gap = np.log(rows.P[usable]) - expected
        rates = cubic_spline(logs[0], np.stack([x, logs[1]], axis=1))(log_a, 1).T
        return _judged(np.stack([0 * gap, gap]), rates, log_a, DEPARTURE_OF_NODES, "displacements")
    raw = beside.rows
    usable = (raw.a > own.a[0]) & (raw.a <= own.a[-1]) & (raw.delta > 0) & (raw.P > 0)
    a, delta, P = (values[usable] for values in (raw.a, raw.delta, raw.P))
    if a.size < DEPARTURE_FEWEST:
        return ()
    x, logs = np.log(own.a), np.log(np.stack([own.delta, own.P]))
    at = np.log(a)
    expected = cubic_spline(x, logs.T)
    gap = np.log(np.stack([delta, P])) - expected(at).T
    found = _judged(gap, expected(at, 1).T, at, DEPARTURE_LEAST, "contact radii")
    loads = beside._loads(own, 0.0, True)
    if not found or loads is None or not _same(loads):
        return found
    there = (delta > own.delta[0]) & (delta <= own.delta[-1])
    beyond = cubic_spline(np.log(own.delta), np.log(own.a - own.a0))(np.log(delta[there]))
    off = a[there] / (own.a0 + np.exp(beyond)) - 1
    worst = float(off[np.argmax(np.abs(off))])
    return (
        f"at equal displacement contact radii are off those of these bodies by {worst:+.1%}, where loads agree: are "
        "the radii, or the area that they are from (import --area), right? The stated errors do not include it",
    )


def _judged(gap: Array, rates: Array, x: Array, least: float, equal: str) -> tuple[str, ...]:
    """The sentence on the ``gap`` (2, n) of the logs of delta and P at log radii ``x`` from the bodies' own solution,
    whose slopes over x are ``rates`` (2, n); none where it is scatter, or below ``least``. ``equal``: at what."""
    smooth = _smooth(gap, rates, x)
    if smooth is None:
        return ()
    displacement, load = smooth
    spans = {
        "displacement": float(displacement[np.argmax(np.abs(displacement))]),
        "load": float(np.ptp(load) * np.sign(load[-1] - load[0])),
    }
    name = max(spans, key=lambda key: abs(spans[key]))
    if abs(spans[name]) < least:
        return ()
    how = "drifts from" if name == "load" else "departs from"
    return (
        f"the {name} {how} the solution of these bodies at the same {equal} by {spans[name]:+.1%}, beyond the scatter "
        "(the modulus left free): drift, a wrong contact point, or other bodies; the stated errors do not include it",
    )


def _smooth(gap: Array, rates: Array, x: Array) -> tuple[Array, Array] | None:
    """The smooth part (n,) of the ``gap`` in displacement and load, a parabola along the rows in each, or a straight
    line in the load alone; None where chance explains both (F tests against the scatter of independent rows).

    The modulus is free: a constant in the gap of the load is no departure.
    """
    from ..adhesion.slopes.integral import decorrelated, estimate, whitener

    n = x.size
    t = np.linspace(-1, 1, n)
    powers = np.stack([np.ones(n), t, t**2])
    columns = np.zeros((6, 2, n))
    columns[:3, 0], columns[3:, 1] = powers, powers
    parabola = np.linalg.lstsq(powers.T, gap.T, rcond=None)[0].T @ powers
    variances, _ = estimate(x - x.max(), gap - parabola, rates[0], rates[1], 6.0, DEPARTURE_FLOOR)
    whiten = whitener(variances, rates[0], rates[1])
    white, basis = (np.einsum("ijn,...jn->...in", whiten, values) for values in (gap, columns))
    # Correlation of neighbours among the rows, its bias by the parabola taken out; 0 where chance explains it
    rest = np.einsum("ijn,jn->in", whiten, gap - parabola)
    lag1 = float(np.sum(rest[:, 1:] * rest[:, :-1]) / max(np.sum(rest**2), 1e-300))
    rho = 0.0 if lag1 < 2 / np.sqrt(2 * n) else min(lag1 + (3 + 4 * lag1) / n, DEPARTURE_LONGEST)
    target, design = decorrelated(white, rho).ravel(), decorrelated(basis.reshape(-1, n), rho).reshape(6, -1)
    parabolas, line, modulus = slice(0, 6), slice(3, 5), slice(3, 4)  # rows of the design
    fits = []  # coefficients and least sum of squares
    for rows in (parabolas, line, modulus):
        coefficients = np.linalg.lstsq(design[rows].T, target, rcond=None)[0]
        fits.append((coefficients, float(np.sum((target - coefficients @ design[rows]) ** 2))))
    (both, full), (drift, straight), (_, none) = fits
    free = target.size - 6
    chance, of_line = (
        float(f_tail(more, free, (none - left) / more / max(full / free, 1e-300)))
        for more, left in ((5, full), (1, straight))
    )
    if chance <= DEPARTURE_CHANCE:
        return both[:3] @ powers, both[3:] @ powers
    if of_line <= DEPARTURE_OF_LINE:
        return np.zeros(n), drift @ powers[:2]
    return None
