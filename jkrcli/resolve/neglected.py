"""What a case will roughly show, and what it leaves out, from coarse exact solutions of the laterally unbounded body.

Left out is one thing at a time: each body is solved with the one thing taken in; loads and slopes S = dP/d(delta)
without adhesion are compared at the depth of the case, pull-off forces under load control. Large strains and weight are
known by formula, where they are.
"""

import contextlib
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, cast

import numpy as np

from ..adhesion.curve import (
    LOAD_CONTROL,
    AdhesiveCurve,
    CriticalPoint,
    Nonadhesive,
    mask_below_atomic_spacing,
    transform,
)
from ..adhesion.validity import Validity, judge, large_strains, refuse_wetting, sizes, with_large_strains
from ..base.errors import Estimate, JkrError, Refusal, Unknown
from ..base.numerics import Array, cubic_spline
from ..base.process import PATIENCE
from ..base.units import show
from ..bodies.indenters import Paraboloid, Sphere
from ..bodies.problem import (
    GEL_TENSION,
    INCOMPRESSIBLE,
    Elastic,
    HalfSpace,
    Loading,
    Problem,
    Rigid,
    alone,
    without_side_walls,
)
from ..formulas import over_hertz, over_jkr
from ..methods.layered.solver import Layered
from ..methods.layered.spectrum import spectrum_seconds
from ..methods.radii import DENSE
from ..series import Series
from .resolve import effect_of_range, half_space_pull_off, pull_off_ratios, ranged, resolve_with
from .sticking import sticking_effect

# What is taken in where a case does not say how much of it there is, and how well that is solved.
LEFT_OUT_GLASS = (70e9, 0.22)  # choice: E [Pa] and nu of what is taken as rigid: soda-lime glass
LEFT_OUT_DENSITY = 1000.0  # choice: kg/m^3, of a body whose density nobody says: of water
LEFT_OUT_OF_STRAINS = 4 / 3  # theory: change of S over that of P where this grows with the root of the depth
# tuned on what cases leave out, by `make constants`: of the solutions; changes are printed to 1e-4
LEFT_OUT_ACCURACY = 1e-5
# choice: kappa over the largest radius, below which a tension is that, in proportion; the second where the first
# would take long
LEFT_OUT_SLIGHT = (1e-3, 1e-2)
# theory: the same on a half-space, where first order in kappa l/a is a formula, good to (kappa l/a)^2 at every radius
LEFT_OUT_SLIGHTEST = 1e-7
# Radii at which a tension is solved for: on 60 random layers changes of load and S then differ by 3e-3 of themselves
# from those of 120 radii, of pull-off by 2e-6. In steps of their logarithm from and to these shares of the radius of
# pull-off without it; tuned on bodies, by `make constants`
LEFT_OUT_FROM, LEFT_OUT_TO, LEFT_OUT_STEP = 0.6, 1.4, 0.14
# Of the largest radius, from which on load and S are compared, at so many; tuned on bodies, by `make constants`
LEFT_OUT_END, LEFT_OUT_ENDS = 0.92, 3
# Of the largest radius the least, and how many, where pull-off moves further than that; tuned on bodies, by `make
# constants`: half as many move what S changes by, by 7 %
LEFT_OUT_SMALLEST, LEFT_OUT_FEW = 0.02, 20
LEFT_OUT_PER_WORK = 0.09  # CPU seconds for each work of adhesion; tuned on a layer and 40 of them, by `make guards`
# times as long as one spectrum take all that are solved; tuned on stacks of 500 and 1,000 layers, by `make guards`
LEFT_OUT_SOLVED = 10


NO_STRAINS = Unknown("known only for spheres on half-spaces and thick layers of rubber (nu = 1/2)")
NO_PULL_OFF = Unknown("pull-off at large strains is not known")
NOT_COMPARED = Unknown("not computed with a range")


@dataclass(frozen=True)
class EffectsPreview:
    """What a case will reach: largest radius ``a`` [m], displacement [m], load [N]; ``series``: to there.

    ``adhesion``: for each work of adhesion [J/m^2] its pull-off and validity.
    ``half_space_error``: by how much the layers change the load at that depth against a half-space of the top material;
    None where there are no layers. ``profile_error``: relative, of an indenter that is known at points only, in what
    any method gives.
    """

    a: float
    delta: float
    P: float
    half_space_error: float | None
    adhesion: tuple[tuple[float, CriticalPoint | Unknown, Validity], ...]
    series: Series
    profile_error: float


def preview_effects(problem: Problem, works: tuple[float, ...], z0: float) -> EffectsPreview:
    """Solve ``problem`` to 1e-5 with its sides left out, and transform it for each work of adhesion.

    Refusal where that is no matter of a moment.
    """
    loading = problem.loading
    if loading.spacing != "radius":
        loading = Loading(loading.to, loading.maximum)
    body = replace(without_side_walls(problem), loading=replace(loading, points=max(loading.points, 100)))
    solution = resolve_with(body, method=Layered(LEFT_OUT_ACCURACY), longest=PATIENCE)
    series = solution.series
    a, delta, P = series.end
    adhesion, functions = [], Nonadhesive.of(series, "exact")
    for w in works:
        refuse_wetting(w, body.specimen.surface_tension)
        curve = AdhesiveCurve(functions, w)
        point = mask_below_atomic_spacing(curve.pull_off(LOAD_CONTROL), curve, LOAD_CONTROL, z0)
        pulled: dict[str, Any] = {"effect_of_range": point}
        if isinstance(point, CriticalPoint):
            pulled = {"a_pull_off": point.a, "effect_of_range": effect_of_range(body, series, w, z0, point)}
        judged = judge(a=a, delta=delta, w=w, **sizes(problem), L=problem.specimen.radius, end_is_cut=False, z0=z0,
                       **pulled)  # fmt: skip
        if isinstance(point, CriticalPoint):
            judged = with_large_strains(judged, large_strains(problem, w, point))
        adhesion.append((w, point, judged))
    matter = None  # relative difference of the load to that of a half-space of the top material at the same depth
    if problem.layers:
        full = series.rim < math.inf
        to = Loading("radius", a, 1) if full else Loading("depth", delta, 1)
        half_space = alone(replace(problem, sticks=False, loading=to))
        with contextlib.suppress(Refusal):  # a half-space would need more of the profile than there is
            other = resolve_with(half_space, method=Layered(LEFT_OUT_ACCURACY)).series
            loads = (series.stiffness, other.stiffness) if full else (series.P, other.P)
            matter = float(loads[0][-1] / loads[1][-1] - 1)
    return EffectsPreview(a, delta, P, matter, tuple(adhesion), series, solution.profile_error)


@dataclass(frozen=True)
class NeglectedEffect:
    """One thing that a case leaves out; or that a simpler formula does and the case has ``included``.

    ``key``: of the case, with which it is taken in, empty where there is none. ``load``, ``S``: change of the load and
    of the contact's stiffness at equal depth, relative; ``pull_off``: of the pull-off force under load control for each
    work of adhesion [J/m^2].
    """

    name: str
    key: str
    load: Estimate
    S: Estimate
    pull_off: Mapping[float, Estimate] = field(default_factory=dict)
    included: bool = False

    @property
    def changes(self) -> dict[str, Estimate]:
        """The three changes by name, that of the pull-off force for the w for which it is largest."""
        pulls = [value for value in self.pull_off.values() if not isinstance(value, Unknown)]
        rest = next(iter(self.pull_off.values()), Unknown("no work of adhesion"))
        return {"load": self.load, "S": self.S, "pull-off force": max(pulls, key=abs, default=rest)}

    @property
    def largest(self) -> tuple[str, float] | None:
        """The largest of the changes with its name; None where none is known."""
        known = {name: value for name, value in self.changes.items() if not isinstance(value, Unknown)}
        return max(known.items(), key=lambda item: abs(item[1]), default=None)

    @property
    def as_dict(self) -> dict[str, Any]:
        """As it stands in JSON."""
        pulls = [{"w_J_per_m2": w, "change": value} for w, value in self.pull_off.items()]
        return {"name": self.name, "key": self.key, "included": self.included, "load": self.load, "S": self.S,
                "pull_off": pulls}  # fmt: skip


def seconds_of_effects(problem: Problem, works: Sequence[float]) -> float:
    """CPU seconds that a body and its neighbours take, none where one alone would take too long, and the pull-off
    forces of so many ``works`` of adhesion."""
    each = spectrum_seconds(problem)
    return LEFT_OUT_PER_WORK * len(works) + (LEFT_OUT_SOLVED * each if each < PATIENCE else 0.0)


def neglected_effects(
    problem: Problem, expected: EffectsPreview, works: Sequence[float], z0: float | None
) -> list[NeglectedEffect]:
    """What ``problem`` leaves out, worst first and what is not known last: at the depth ``expected`` and for each of
    the ``works`` of adhesion [J/m^2]; ``z0``: range of its forces [m], None where the case includes one."""
    body = without_side_walls(replace(problem, specimen=replace(problem.specimen, relaxation=None)))
    works = [w for w in works if w > 0]
    omissions = [*_neighbours(Neighbours(body, expected, works), problem.specimen.radius is not None)]
    omissions.append(_slip(body, expected, works))

    # The range of adhesive forces: at pull-off, and of the load on the adhesive curve at its largest depth
    pulls = {w: judged.effect_of_range for w, _, judged in expected.adhesion if w > 0}
    if z0 is not None and pulls:
        name, key = f"range of adhesion {show(z0, 'length')}", f'adhesion.range = "{show(z0, "length")}"'
        omissions.append(NeglectedEffect(name, key, _load_at_range(body, expected, z0, pulls), NOT_COMPARED, pulls))
    omissions += _strains(body, expected)

    # The weight of a half-space that keeps its volume; of others no formula is known
    material, R, tension = body.specimen.surface, body.indenter.tip_radius, body.specimen.surface_tension
    if R is not None and body.is_half_space and material.nu >= INCOMPRESSIBLE and not tension:
        load, S = over_hertz(expected.a, material.E_star, LEFT_OUT_DENSITY)
        pulls = {w: over_jkr(point.a, material.E_star, LEFT_OUT_DENSITY) if isinstance(point, CriticalPoint) else point
                 for w, point, _ in expected.adhesion if w > 0}  # fmt: skip
        name = f"weight of the specimen, {LEFT_OUT_DENSITY:g} kg/m^3"
        omissions.append(NeglectedEffect(name, "", load, S, pulls))
    omissions += _faces(body, expected)
    return sorted(omissions, key=lambda one: -abs(one.largest[1]) if one.largest else 1.0)


@dataclass(frozen=True)
class Neighbours:
    """A ``body`` and its neighbours at the depth that is ``expected``, with ``works`` of adhesion [J/m^2]."""

    body: Problem
    expected: EffectsPreview
    works: Sequence[float]

    def with_(self, name: str, key: str, **otherwise: Any) -> NeglectedEffect:
        """The body with ``otherwise`` in place of its fields."""
        full, expected = self.body.indenter.rim < math.inf, self.expected  # of a full end at equal radius
        loading = Loading(*(("radius", expected.a) if full else ("depth", expected.delta)), DENSE, "log")
        method = Layered(LEFT_OUT_ACCURACY)
        try:
            other = resolve_with(self.body, method=method, longest=PATIENCE, loading=loading, **otherwise).series
        except JkrError as error:
            return NeglectedEffect(name, key, Unknown(str(error)), Unknown(str(error)))
        return self.over(name, key, self.expected.series, other)

    def over(self, name: str, key: str, plain: Series, other: Series) -> NeglectedEffect:
        """One series of the neighbour over one of the body; both reach the depth."""
        depth = float(plain.delta[-1])
        load, S = (new / old - 1 for new, old in zip(_at(other, depth), _at(plain, depth), strict=True))
        try:
            ratios = pull_off_ratios(other, plain, self.works, Unknown("pull-off lies outside the radii of the case"))
        except JkrError as error:
            ratios = dict.fromkeys(self.works, Unknown(str(error)))
        pulls = {w: ratio if isinstance(ratio, Unknown) else ratio - 1 for w, ratio in ratios.items()}
        return NeglectedEffect(name, key, load, S, pulls)


def _at(series: Series, depth: float) -> tuple[float, float]:
    """P [N] and S [N/m] of a series at a depth [m] that it reaches."""
    assert series.S is not None
    if series.rim < math.inf:  # of a full end in proportion to the depth
        return float(series.S[-1]), float(series.S[-1])
    z = np.log(series.delta)
    load, stiffness = (math.exp(cubic_spline(z, np.log(y))(np.log(depth))) for y in (series.P, series.S))
    return load, stiffness


def _neighbours(neighbours: Neighbours, sides: bool) -> Iterator[NeglectedEffect]:
    """The things for which a neighbouring body is solved; ``sides``: whether the specimen has any."""
    specimen, indenter = neighbours.body.specimen, neighbours.body.indenter
    glass = Elastic(*LEFT_OUT_GLASS)
    if neighbours.body.layers:
        yield _half_space(neighbours)
    if isinstance(indenter, Paraboloid):
        sphere = Sphere(indenter.R, indenter.material)
        yield neighbours.with_("exact sphere", 'indenter.shape = "sphere"', indenter=sphere)
    if indenter.material is None and not specimen.surface_tension:
        elastic = replace(indenter, material=glass)  # type: ignore[type-var]
        yield neighbours.with_(f"elastic indenter, {show(glass.E, 'modulus')}", "indenter.E and nu", indenter=elastic)
    if isinstance(specimen.base, Rigid) and specimen.base.bonded and not sides:
        based = replace(specimen, base=HalfSpace(glass))
        yield neighbours.with_(f"elastic substrate, {show(glass.E, 'modulus')}", "specimen.half_space", specimen=based)
    if not specimen.surface_tension:
        yield _tension(neighbours)


def _half_space(neighbours: Neighbours) -> NeglectedEffect:
    """The top material alone in place of the layers, as a half-space formula has it."""
    other = alone(neighbours.body)
    formula = neighbours.with_(
        "half-space formula, no layers", "", specimen=other.specimen, indenter=other.indenter, sticks=False
    )
    pulls: dict[float, Estimate] = {}
    for w, point, _ in neighbours.expected.adhesion:
        if w > 0:
            there = half_space_pull_off(other, w, LOAD_CONTROL)
            known = isinstance(there, CriticalPoint) and isinstance(point, CriticalPoint)
            pulls[w] = there.P / point.P - 1 if known else Unknown("no pull-off by formula")  # type: ignore[union-attr]
    return replace(formula, pull_off=pulls, included=True)


def _tension(neighbours: Neighbours) -> NeglectedEffect:
    """A surface tension, of a rigid indenter and without friction: no other is derived. A very slight one changes all
    in proportion."""
    body, Ups = neighbours.body, GEL_TENSION
    name, key = f"surface tension {show(Ups, 'tension')}", f'specimen.surface_tension = "{show(Ups, "tension")}"'
    rigid = replace(body, indenter=replace(body.indenter, material=None), sticks=False)  # type: ignore[type-var]
    failed = Unknown("")
    slightest = () if rigid.layers else (LEFT_OUT_SLIGHTEST,)
    for slight in (*slightest, *LEFT_OUT_SLIGHT):
        trial = max(Ups, slight * neighbours.expected.a * rigid.E_star / 2)
        try:
            omission, share = _of_trial(neighbours, rigid, trial, name, key), Ups / trial
        except JkrError as error:
            failed = Unknown(str(error))
            continue
        pulls = dict[float, Estimate]()
        for w, change in omission.pull_off.items():
            try:
                refuse_wetting(w, GEL_TENSION)
                pulls[w] = _part(share, change)
            except JkrError as error:  # a surface of so little tension wets the indenter
                pulls[w] = Unknown(str(error))
        load, S = _part(share, omission.load), _part(share, omission.S)
        return replace(omission, load=load, S=S, pull_off=pulls)
    return NeglectedEffect(name, key, failed, failed)


def _of_trial(neighbours: Neighbours, rigid: Problem, trial: float, name: str, key: str) -> NeglectedEffect:
    """A ``trial`` [N/m] of surface tension on a body with a ``rigid`` indenter: solved near the largest radius and
    around pull-off without it; over all radii where pull-off with it lies elsewhere, or where there is none."""
    a0, specimen = rigid.indenter.a0, rigid.specimen
    reach = neighbours.expected.a - a0
    pulled = {w: point.a - a0 for w, point, _ in neighbours.expected.adhesion
              if w > 0 and isinstance(point, CriticalPoint) and point.a > a0}  # fmt: skip

    def compared(beyond: Array) -> NeglectedEffect:
        plain, tense = (
            resolve_with(rigid, a0 + beyond, Layered(LEFT_OUT_ACCURACY), PATIENCE, specimen=one).series
            for one in (specimen, replace(specimen, surface_tension=trial))
        )
        return neighbours.over(name, key, plain, tense)

    if pulled:
        first, last = LEFT_OUT_FROM * min(pulled.values()), LEFT_OUT_TO * max(pulled.values())
        around = np.exp(np.arange(math.log(first), math.log(min(last, LEFT_OUT_END * reach)), LEFT_OUT_STEP))
        near = compared(np.append(around, reach * np.linspace(LEFT_OUT_END, 1.0, LEFT_OUT_ENDS)))
        if not any(isinstance(near.pull_off[w], Unknown) for w in pulled if w in near.pull_off):
            return near
    return compared(reach * np.geomspace(LEFT_OUT_SMALLEST, 1.0, LEFT_OUT_FEW))


def _part(share: float, change: Estimate) -> Estimate:
    return change if isinstance(change, Unknown) else share * change


def _slip(body: Problem, expected: EffectsPreview, works: Sequence[float]) -> NeglectedEffect:
    """Contact without slip, or with it where the case has none."""
    name, other = ("slip", "sliding") if body.sticks else ("no slip", "sticking")
    key = f'specimen.surface = "{other}"'
    effect = sticking_effect(body, expected.a, works)
    if isinstance(effect, Unknown):
        return NeglectedEffect(name, key, effect, effect)

    def change(ratio: Estimate) -> Estimate:
        return ratio if isinstance(ratio, Unknown) else (1 / ratio if body.sticks else ratio) - 1

    pulls = {w: change(ratio) for w, ratio in effect.pull_off.items()}
    return NeglectedEffect(name, key, change(effect.load), change(effect.stiffness_at_depth), pulls)


def _load_at_range(body: Problem, expected: EffectsPreview, z0: float, pulls: Mapping[float, Estimate]) -> Estimate:
    """Change of the adhesive load, over the load without adhesion, for the w whose pull-off changes most."""
    known = {w: value for w, value in pulls.items() if not isinstance(value, Unknown)}
    if not any(known.values()):
        return 0.0 if known else next(iter(pulls.values()))
    w, series = max(known, key=lambda each: abs(known[each])), expected.series
    try:
        plain, curve = transform(series, "exact", w), ranged(body, series, w, z0)
    except JkrError as error:
        return Unknown(str(error))
    last = int(np.flatnonzero(np.diff(curve.delta) <= 0).max(initial=-1)) + 1  # contact grows with depth from there on
    there = float(cubic_spline(curve.delta[last:], curve.P[last:])(plain.delta[-1]))
    return (there - float(plain.P[-1])) / expected.P


def _faces(body: Problem, expected: EffectsPreview) -> Iterator[NeglectedEffect]:
    """The faces of a pyramid: its contact area is a share of its cone's, on which w acts as that share of w; on layers,
    where S goes with a power of the radius other than 1, the load differs."""
    share, series = body.indenter.contact_share, expected.series
    if share == 1:
        return
    assert series.S is not None
    assert series.dS is not None
    power = float(expected.a * series.dS[-1] / series.S[-1]) if body.layers else 1.0
    pulls = dict[float, Estimate]()
    for w, point in ((w, point) for w, point, _ in expected.adhesion if w > 0):
        fewer = transform(series, "exact", share * w).pull_off(LOAD_CONTROL)
        if isinstance(point, CriticalPoint):
            pulls[w] = fewer.P / point.P - 1 if isinstance(fewer, CriticalPoint) else fewer
        else:
            pulls[w] = point
    load = (power - 1) * (math.sqrt(share) - 1)
    yield NeglectedEffect("faces of the pyramid", "", load, NOT_COMPARED if load else 0.0, pulls)


def _strains(body: Problem, expected: EffectsPreview) -> Iterator[NeglectedEffect]:
    """What large strains do to the load, as far as it is known, and with it to S."""
    if body.indenter.tip_radius is None:
        return
    name, known = "large strains of rubber", body.specimen.surface.nu >= INCOMPRESSIBLE
    judged = judge(a=expected.a, delta=expected.delta, w=0.0, L=None, z0=None, **sizes(body))
    if isinstance(judged.strained, Unknown) or not known:
        yield NeglectedEffect(name, "", NO_STRAINS, NO_STRAINS)
        return
    load = 1 / (1 + judged.strained) - 1
    pulls: dict[float, Estimate] = {}
    for w, _, judged in expected.adhesion:
        change = judged.large_strains  # a range of changes: its end that is larger in size
        if w > 0 and change is None:
            pulls[w] = NO_PULL_OFF
        elif w > 0:
            pulls[w] = change if isinstance(change, Unknown) else max(cast(tuple[float, float], change), key=abs)
    yield NeglectedEffect(name, "", load, LEFT_OUT_OF_STRAINS * load, pulls)
