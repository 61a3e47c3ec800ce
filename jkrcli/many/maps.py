"""Studies over many bodies: maps, each a ``Map`` below, known by its line of ``MAPS`` in ``wing.py``."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import product
from typing import Any, TypeAlias

import numpy as np

from .. import __version__
from ..adhesion.curve import LOAD_CONTROL, AdhesiveCurve, CriticalPoint, Nonadhesive, transform
from ..adhesion.device_path import Program
from ..adhesion.finite_range import AttractedBody, FiniteRangeBody, Range
from ..adhesion.roughness import ROUGH_STEEPEST, Roughness
from ..base.arguments import checked, reader
from ..base.errors import InputError, JkrError, SolveError, Unknown, counted, known
from ..base.executors import Pool, in_order
from ..base.files import lists
from ..base.numerics import MOST_STEPS, Array, pchip
from ..base.process import one_thread
from ..base.registry import Result
from ..base.units import Ranged, show
from ..base.wings import offered
from ..bodies.indenters import Paraboloid
from ..bodies.problem import Elastic, HalfSpace, Layer, Loading, Problem, Rigid, Specimen
from ..formulas import wetting_radius
from ..methods.closed_form import ClosedForm
from ..methods.layered.solver import Layered
from ..methods.protocol import Method
from ..report.result import Figure
from ..series import Series
from .wing import maps

# --------------------------------------------------------------------------------------------------
# A map: quantities of a paraboloid on standard bodies over some axes. What a map is stands in its row, a ``Map``; how
# axes are read, columns computed, forecast, printed and drawn stands here, once for all.

Values: TypeAlias = dict[str, Any]  # of all axes: a tuple of several, else one
Columns: TypeAlias = dict[str, Array]
Work: TypeAlias = tuple[Callable[[Any], Columns], Sequence[Any]]  # what gives the rows of a cell, and the cells
Q = "w_R2_over_Estar_h3"


@dataclass(frozen=True)
class Axis:
    """An axis of a map, or one number or word of its bodies (``several`` False).

    ``default``: values where none are given, ``shown`` what help says of them; ``allowed``: their range, or the words;
    ``family``: a line for each, in the order given, else they rise; ``read``: what makes a value of something else.
    """

    default: Any
    help: str = ""
    allowed: Ranged | tuple[str, ...] | None = None
    shown: str | None = None
    several: bool = True
    family: bool = False
    read: Callable[[Any], Any] | None = None

    def values(self, chosen: Any) -> Any:
        """The values of this axis, each once; ValueError where one is not allowed."""
        if not self.several:
            return self._value(self.default if chosen is None else chosen)
        chosen = [chosen] if np.isscalar(chosen) else chosen
        values = [self._value(item) for item in (self.default if chosen is None or len(chosen) == 0 else chosen)]
        return tuple(dict.fromkeys(values) if self.family else sorted(set(values)))

    def _value(self, value: Any) -> Any:
        if self.read is not None:
            return self.read(value)
        if isinstance(self.allowed, Ranged):
            return self.allowed.read(value)
        if self.allowed is not None and value not in self.allowed:
            raise ValueError(f'must be {" or ".join(self.allowed)}, got "{value}"')
        return value


POISSON = Ranged("number", above=-1, most=0.5)
BASE = Axis("bonded", allowed=("bonded", "frictionless"), several=False)
SHOWN_Q, SHOWN_NU = (Q, "w R^2/(E* h^3)", "15.4g"), ("nu", "nu", "6g")


@dataclass(frozen=True)
class Map:
    """A row of the table: its ``help`` with an example, its axes by their options, the ``work`` that gives its columns,
    the CPU ``seconds`` that this takes.

    ``title`` names values in braces; ``shown``: column, heading and format of what is printed, or a function that gives
    the lines; ``order``: a column by which rows are sorted; ``draw``: its figure.
    """

    name: str
    help: str
    axes: Mapping[str, Axis]
    work: Callable[[Values], Work]
    seconds: Callable[[Values], float]
    title: str
    shown: Sequence[tuple[str, str, str]] | Callable[[Columns], Iterator[str]]
    draw: Callable[[Columns], Figure]
    order: str = ""

    def values(self, axes: Mapping[str, Any]) -> Values:
        """The values of all axes; InputError where one is unknown or outside its range."""
        if unknown := [name for name in axes if name not in self.axes]:
            raise InputError(f'{self.name} map: has no axis "{unknown[0]}" (axes: {", ".join(self.axes)})')
        values = {}
        for name, axis in self.axes.items():
            try:
                values[name] = axis.values(axes.get(name))
            except ValueError as error:
                raise InputError(f"{self.name} map: {name} {error}") from None
        return values

    def forecast(self, **axes: Any) -> float:
        """CPU seconds that the map over the ``axes`` takes."""
        return self.seconds(self.values(axes))

    def over(self, pool: Pool | None = None, **axes: Any) -> MapResult:
        """The map over the ``axes``; ``pool`` works on its cells (default: this process)."""
        values = self.values(axes)
        parts = in_order(pool, *self.work(values), f"{self.name} map")
        columns = {name: np.concatenate([part[name] for part in parts]) for name in parts[0]}
        if self.order:
            rows = np.argsort(columns[self.order], kind="stable")
            columns = {name: column[rows] for name, column in columns.items()}
        return MapResult(self, values, columns)


@dataclass(frozen=True, eq=False)
class MapResult(Result):
    """A map over the ``values`` of its axes: ``columns`` of one length, NaN and a ``reason`` where nothing is known."""

    map: Map
    values: Values
    columns: Columns

    def summary(self) -> dict[str, Any]:
        return lists(self.columns)

    @property
    def warnings(self) -> list[str]:
        reasons = [reason for reason in self.columns.get("reason", np.array([])).tolist() if reason]
        are = "is" if len(reasons) == 1 else "are"
        return [f"{counted(len(reasons), 'point')} {are} not known, the first: {reasons[0]}"] if reasons else []

    def words(self) -> list[str]:
        head, shown = self.map.title.format(**self.values), self.map.shown
        if callable(shown):
            return [head, *shown(self.columns)]
        widths = [int(form.split(".")[0].rstrip("g")) for _, _, form in shown]
        heads = " ".join(f"{words:>{width}}" for (_, words, _), width in zip(shown, widths, strict=True))
        lines = [" ".join(f"{value:>{form}}" for value, (_, _, form) in zip(row, shown, strict=True))
                 for row in zip(*(self.columns[name].tolist() for name, _, _ in shown), strict=True)]  # fmt: skip
        return [head, *(f"  {line}" for line in (heads, *lines))]

    def figure(self) -> Figure:
        return self.map.draw(self.columns)


def map_of(name: str) -> Map:
    """The row of the map called ``name``."""
    if name not in (names := maps()):
        raise InputError(f'unknown map "{name}" (maps: {", ".join(names)})')
    rows = (PULL_OFF_MAP, STICKING_MAP, TRANSITION_MAP, ADHESION_MAP, RATE_MAP, ROUGHNESS_MAP)
    return next(row for row in rows if row.name == name)


def rows(**columns: Any) -> Columns:
    """Columns of one length of numbers, words and arrays."""
    return dict(zip(columns, map(np.ravel, np.broadcast_arrays(*columns.values())), strict=True))


def within(least: float, most: float) -> Ranged:
    """The range of an axis."""
    return Ranged("number", least=least, most=most)


def series_at(radii: Array, specimen: Specimen, method: Method, sticks: bool = False) -> Series:
    """The series of a paraboloid of R = 1 m at the ``radii`` [m]."""
    loading = Loading.given("radius", tuple(radii.tolist()))
    return method(Problem(Paraboloid(1.0), specimen, loading, sticks)).series


def layer(nu: float, bonded: bool = True, thickness: float = 1.0) -> Specimen:
    """A layer of E* = 1 Pa and a ``thickness`` [m] on a rigid base."""
    return Specimen((Layer(Elastic(1 - nu**2, nu), thickness),), Rigid(bonded))


# --------------------------------------------------------------------------------------------------
# The adhesion map of Johnson and Greenwood (J. Colloid Interface Sci. 192 (1997) 326) for a layer: which model holds.
#
# Over mu = sigma (R/(E*^2 w))^(1/3) and the load in pi w R, by the contact that carries the load with adhesion of
# finite range, of radius a: delta_a = delta_H(a) - delta is what adhesion adds to the elastic displacement, and
# (P_H(a) - P)/P_H what it adds to the load. Hertz: that part is small; rigid (Bradley): elastic displacements are
# small against the range; DMT: those of adhesion are; JKR: they are many times the range; else Maugis' transition.

# Where one model ends, which part of the map there is, and what it takes.
ZONE_LITTLE = 0.05  # theory: Johnson and Greenwood (1997): what is left out of a model
ZONE_MANY = 20.0  # theory: the same, of delta_a over the range, above which JKR holds
ZONE_POINTS = 80  # tuned on maps, by `make constants`: contact radii of a curve; more are added where it bends
ZONE_BEYOND = 1.2  # tuned on maps, by `make constants`: of the largest load, to which the body is solved
ZONE_FURTHER = 1.6  # tuned on maps, by `make constants`: of the load without adhesion from one solve to the next
ZONE_PER_MU = 0.065  # CPU seconds; tuned on maps of 29 and 200 ranges, by `make guards`


ZONES = ("Hertz", "JKR", "Maugis", "DMT", "rigid")


def _adhesion_work(values: Values) -> Work:
    """One body serves all ranges, in units of h = R = 1 m, E* = 1 Pa."""
    q = values["q"]
    # The series without adhesion to the radius at which JKR carries the `load` [N].
    specimen = layer(values["nu"], values["base"] == "bonded")
    load = ZONE_BEYOND * values["load"][-1] * math.pi * q
    plain = load
    for _ in range(MOST_STEPS):
        problem = Problem(Paraboloid(1.0), specimen, Loading("load", plain, ZONE_POINTS))
        series = Layered()(problem).series
        if transform(series, "exact", q).P[-1] > load:
            break
        plain *= ZONE_FURTHER
    body = FiniteRangeBody(problem, series, AttractedBody(problem))
    return partial(_adhesion_row, body, values), values["mu"]


def _adhesion_row(body: FiniteRangeBody, values: Values, mu: float) -> Columns:
    """The contacts of one range on a ``body`` that carry the loads, and their zone (Johnson and Greenwood).

    a over h, ``adhesive`` = delta_a and ``elastic`` = delta_H, both over the range, ``share`` = (P_H - P)/P_H.
    """
    nu, q, loads = values["nu"], values["q"], np.array(values["load"])
    try:
        curve = body.curve(Range.of(q, stress=mu * q ** (1 / 3)))
    except JkrError as error:
        raise SolveError(f"adhesion map: nu = {nu:g}, q = {q:g}, mu = {mu:g}: {error}") from None
    # The stable contacts under load control, whose load rises with the radius
    touching, parts, stable = curve.touching, curve.parts, slice(int(np.argmin(curve.touching.P)), None)
    delta_H, P_H = parts.delta_H[stable], parts.P_H[stable]
    added, lost = delta_H - touching.delta[stable], P_H - touching.P[stable]
    columns = (touching.a[stable], added / curve.law.length, delta_H / curve.law.length, lost, P_H)
    a, adhesive, elastic, lost, plain = (
        np.interp(loads * math.pi * q, touching.P[stable], column) for column in columns
    )
    share = lost / plain
    # Which of ``ZONES`` a contact lies in
    small, rigid = adhesive <= ZONE_LITTLE, np.maximum(elastic, adhesive) <= ZONE_LITTLE
    inside = np.where(adhesive >= ZONE_MANY, 1, np.where(rigid, 4, np.where(small, 3, 2)))
    zone = np.array(ZONES)[np.where(share <= ZONE_LITTLE, 0, inside)]
    return rows(nu=nu, base=values["base"], w_R2_over_Estar_h3=q, mu=mu, load_over_pi_w_R=loads, a_over_h=a,
                adhesive_over_range=adhesive, elastic_over_range=elastic, adhesive_share=share, zone=zone)  # fmt: skip


def _shown(columns: Columns) -> Iterator[str]:
    """A line for each load, a letter for each range."""
    yield "  load over pi w R | mu: " + ", ".join(f"{mu:.3g}" for mu in np.unique(columns["mu"]))
    for load in np.unique(columns["load_over_pi_w_R"])[::-1]:
        row = columns["zone"][columns["load_over_pi_w_R"] == load]
        yield f"  {load:>16.3g} | {''.join(zone[0] for zone in row)}"
    yield "  " + ", ".join(f"{zone[0]}: {zone}" for zone in ZONES)


def _adhesion_figure(columns: Columns) -> Figure:
    from .figures import zones_figure

    return zones_figure(columns, ZONES)


ADHESION_MAP = Map(
    "adhesion",
    """Map which model of adhesion holds for a paraboloid on a layer on a rigid substrate: Hertz, JKR, DMT, rigid
    bodies, or the transition that needs a finite range.

    The map follows Johnson and Greenwood: a model holds where it errs by less than 5 %. The results are
    adhesion-map.csv, .png and .svg.

    \b
    jkr study adhesion-map --nu 0.499 --q 100 -o map
    """,
    {
        "nu": Axis(0.499, "", POISSON, several=False),
        "base": BASE,
        "q": Axis(1.0, "w R^2/(E* h^3); 1e-4: a half-space.", Ranged("number", above=0), several=False),
        "mu": Axis(tuple(np.geomspace(0.02, 50, 29).tolist()), "Values of stress (R/(E*^2 w))^(1/3)",
                   within(0.01, 100.0), "29 from 0.02 to 50"),
        "load": Axis(tuple(np.geomspace(0.1, 100, 31).tolist()), "Loads over pi w R",
                      within(1e-3, 1e3), "31 from 0.1 to 100"),
    },
    _adhesion_work,
    lambda values: ZONE_PER_MU * len(values["mu"]),
    "{base} layer on a rigid substrate, paraboloid, nu = {nu:g}, w R^2/(E* h^3) = {q:g}: what holds",
    _shown,
    _adhesion_figure,
    order="load_over_pi_w_R",
)  # fmt: skip


# --------------------------------------------------------------------------------------------------
# The pull-off map: how far a layer's pull-off force lies from the half-space's, over how strongly it adheres.
#
# For a paraboloid on one layer on a rigid base, -P_min/(pi w R) under load control depends on Poisson's ratio, the
# base and q = w R^2/(E* h^3) alone: 3/2 for thick layers (small q), 2 for thin compressible, 3 for thin
# incompressible ones. Nearly incompressible layers rise above 2 and come back to it (nu = 0.45: 2.105 at q = 1e3,
# 2.027 at 1e6).

# Which part of the map there is, how finely its series are solved, and what that takes.
# tuned on maps, by `make constants`: of the contact radius; twice as many change the pull-off force by 4e-8
MAP_PER_DECADE = 40
# tuned on maps, by `make constants`: relative, of the series; a/h near 100 at nu = 1/2 leaves 1e-7
MAP_TOLERANCE = 1e-6
MAP_PER_NU = 4e-3  # CPU seconds; tuned on maps of 30 and 300 ratios of Poisson, by `make guards`
MAP_PER_TENSE = 0.3  # CPU seconds of a q under surface tension; tuned on maps of 30, by `make guards`
MAP_PER_POINT = 1e-3  # CPU seconds of a q; tuned on maps of 1000, by `make guards`


LIMITS = {1.5: "thick: 3/2", 2.0: "thin, compressible: 2", 3.0: "thin, incompressible: 3"}


def _pull_off_work(values: Values) -> Work:
    """One unit series per Poisson's ratio serves every q, unless the surface has a tension."""
    qs = values["q"]
    cells = [(nu, beta, group) for nu in values["nu"] for beta in values["beta"]
             for group in ([[q] for q in qs] if beta else [qs])]  # fmt: skip
    return partial(_pull_off_points, values["base"]), cells


def _pull_off_points(base: str, cell: tuple[float, float, Sequence[float]]) -> Columns:
    """The points of one Poisson's ratio, in units of h = R = 1 m, E* = 1 Pa.

    The paraboloid's problem is linear in R, so that no small strain is needed.
    """
    nu, beta, qs = cell
    tension = beta * qs[0] ** (1 / 3)
    # From well below to well above a/h at pull-off: (9 pi q/8)^(1/3) for thick layers, for thin ones between
    # (96 q)^(1/6) and (384 q)^(1/6) where they are incompressible, and up to (8 q)^(1/4).
    thick = [(9 * math.pi * q / 8) ** (1 / 3) for q in (qs[0], qs[-1])]
    low, high = 0.4 * min(thick[0], (96 * qs[0]) ** (1 / 6)), 1.5 * min(thick[1], (8 * qs[-1]) ** (1 / 4) + 1)
    if tension:
        low = min(low, 0.5 * wetting_radius(1.0, qs[0], tension))
    count = max(8, math.ceil(MAP_PER_DECADE * math.log10(high / low)))
    specimen = replace(layer(nu, base == "bonded"), surface_tension=tension)
    series = series_at(np.geomspace(low, high, count), specimen, Layered(MAP_TOLERANCE))
    body = Nonadhesive.of(series, "exact")
    points = list[tuple[float, float, float]]()
    for one in qs:
        point = AdhesiveCurve(body, one).pull_off(LOAD_CONTROL)
        if isinstance(point, Unknown):
            raise SolveError(f"pull-off map: nu = {nu:g}, q = {one:g}: {point.reason}")
        points.append((point.P, point.a, point.delta))
    q, (P, a, delta) = np.array(qs), np.transpose(points)
    return rows(nu=nu, base=base, w_R2_over_Estar_h3=q, minus_P_over_pi_w_R=-P / (math.pi * q), a_over_h=a,
                delta_R_over_h2=delta, beta=beta, solved_by=f"jkr {__version__} layered")  # fmt: skip


def _pull_off_figure(columns: Columns) -> Figure:
    from .figures import MapPanel, lines_figure

    title = f"layer on a rigid substrate, {columns['base'][0]}"
    families = {"nu": r"$\nu$ = {:g}".format}
    if columns["beta"].any():
        families["beta"] = r"$\beta$ = {:g}".format
    panel = MapPanel("minus_P_over_pi_w_R", r"pull-off force / $\pi w R$", title, LIMITS, (1.4, 3.15))
    return lines_figure(columns, (Q, r"$w R^2 / (E^* h^3)$"), [panel], families)


PULL_OFF_MAP = Map(
    "pull-off",
    """Map the pull-off force of a paraboloid on a layer on a rigid substrate, in pi w R, over w R^2/(E* h^3).

    All slopes are exact. The results are pull-off-map.csv, .png and .svg.

    \b
    jkr study pull-off-map --nu 0.3 --nu 0.5 -o map
    jkr study pull-off-map --nu 0.45 --q 0.02 --base frictionless
    jkr study pull-off-map --nu 0.5 --q 1 --q 10 --beta 0 --beta 0.1
    """,
    {
        "nu": Axis((0.3, 0.499), "Repeatable.", POISSON, family=True),
        "base": BASE,
        "q": Axis(
            tuple((10.0 ** (np.arange(-12, 17) / 4)).tolist()),
            "Values of w R^2/(E* h^3)",
            within(1e-6, 1e7),
            "1e-3 to 1e4",
        ),
        "beta": Axis(
            (0.0,), "Surface tension over E* a0, a0 = (w R^2/E*)^(1/3); repeatable.", within(0.0, 100.0), family=True
        ),
    },
    _pull_off_work,
    lambda values: (
        len(values["nu"])
        * sum(MAP_PER_NU + (MAP_PER_TENSE if beta else MAP_PER_POINT) * len(values["q"]) for beta in values["beta"])
    ),
    "{base} layer on a rigid substrate, paraboloid: pull-off force in pi w R",
    [SHOWN_NU, ("beta", "beta", "6g"), SHOWN_Q, ("minus_P_over_pi_w_R", "force", "8.4f"), ("a_over_h", "a/h", "9.4g")],
    _pull_off_figure,
)


# --------------------------------------------------------------------------------------------------
# The rate map: pull-off force and energy lost over the speed of the device, its stiffness and the body.
#
# Units: R = 1 m, E* = w0 = 1 of a paraboloid, v0 = 1 m/s; a layer of thickness h on a rigid base beside the half-
# space. The device goes back from equilibrium at no load.

# How finely and how far its series go, and what they take.
# tuned on maps, by `make constants`: of the contact radius; twice as many change the forces by less than 1e-7
RATE_MAP_PER_DECADE = 40
# tuned on maps, by `make constants`: radius in units of that at no load, where contact is as good as lost
RATE_MAP_SMALLEST = 1e-3
RATE_MAP_LARGEST = 1.3  # tuned on maps, by `make constants`: the same, beyond which no path goes
RATE_MAP_TOLERANCE = 1e-7  # tuned on maps, by `make constants`: relative, of the layer's series
RATE_MAP_PER_POINT = 0.075  # CPU seconds; tuned on maps of 13 and 100 speeds, by `make guards`


POSITIVE = Ranged("number", above=0)


def _rate_points(values: Values, thickness: float) -> Columns:
    """The points of one body, a layer of this ``thickness`` in radii (infinite: the half-space), over stiffness [E* R]
    and speed [v0] of the device: energy dissipated at the edge over w0 times the area at no load, relative error of the
    force."""
    # The body in units of R = E* = 1, and the radius at no load with w = 1: that of a layer is smaller
    nu, a, whole = values["nu"], (4.5 * math.pi) ** (1 / 3), math.isinf(thickness)
    specimen = Specimen((), HalfSpace(Elastic(1 - nu**2, nu))) if whole else layer(nu, thickness=thickness)
    low, high = RATE_MAP_SMALLEST * a, RATE_MAP_LARGEST * a
    count = math.ceil(RATE_MAP_PER_DECADE * math.log10(high / low))
    method = ClosedForm() if whole else Layered(RATE_MAP_TOLERANCE)
    body = Nonadhesive.of(series_at(np.geomspace(low, high, count), specimen, method), "exact")
    radii = AdhesiveCurve(body, 1.0).radii(P=0.0)
    if not radii:
        raise SolveError(f"rate map: no equilibrium without load on a layer of h = {thickness:g} R")
    a, devices = radii[-1], list(product(values["stiffness"], values["speed"]))
    (k, V), points = np.transpose(devices), list[tuple[float, float, float]]()
    for stiffness, speed in devices:
        contact = offered("contact of a law over speed")(body, values["rate"], 1.0, 1.0, stiffness)
        history = contact.history(Program.on(float(contact.edge.position_at(np.array(a), 1.0)), -speed), a)
        force, lost = -history.pull_off.P / math.pi, history.dissipated / (math.pi * a**2)
        points.append((force, lost, known(history.error["P"]) or 0.0))
    forces, energies, errors = np.transpose(points)
    return rows(h_over_R=thickness, k_over_Estar_R=k, V_over_v0=V, minus_P_over_pi_w0_R=forces,
                dissipated_over_w0_pi_a2=energies, P_relative_error=errors)  # fmt: skip


def _stiffness(text: Any) -> float:
    try:
        return math.inf if text == "rigid" else POSITIVE.read(text)
    except ValueError:
        raise ValueError(f'must be a number > 0 in E* R, or "rigid", got "{text}"') from None


def _rate_figure(columns: Columns) -> Figure:
    from .figures import MapPanel, lines_figure

    panels = [MapPanel("minus_P_over_pi_w0_R", r"pull-off force / $\pi w_0 R$", logs="xy"),
              MapPanel("dissipated_over_w0_pi_a2", r"energy lost at the edge / $\pi w_0 a^2$", logs="xy")]  # fmt: skip
    return lines_figure(columns, ("V_over_v0", "speed of the instrument $V/v_0$"), panels, {
        "h_over_R": lambda h: "half-space" if math.isinf(h) else f"$h$ = {h:g} $R$",
        "k_over_Estar_R": lambda k: "rigid" if math.isinf(k) else f"$k$ = {k:g} $E^* R$",
    })  # fmt: skip


RATE_MAP = Map(
    "rate",
    """Map pull-off force and lost energy as functions of the speed and stiffness of the device, for several bodies.

    A paraboloid with E* = R = w0 = v0 = 1 retracts from equilibrium at zero load, from a half-space and from bonded
    layers of the given thickness (in R). The results are rate-map.csv, .png and .svg.

    \b
    jkr study rate-map --rate n=0.6 --thickness 0.3 -o map
    jkr study rate-map --rate law=log,b=0.3 --stiffness rigid --speed 1
    """,
    {
        "rate": Axis(
            {"n": "0.6"},
            "The law in units of w0 and v0: n=0.6; law=log,b=0.3.",
            several=False,
            read=lambda keys: offered("a law of w over speed")({"v0": 1.0} | reader(Mapping[str, Any])(keys), "--rate"),
        ),
        "thickness": Axis((0.3,), "Of a bonded layer on a rigid substrate, in R; repeatable.", POSITIVE, family=True),
        "nu": Axis(0.3, "Poisson's ratio of the layers.", POISSON, several=False),
        "stiffness": Axis(
            ("rigid", "1"), 'Of the machine, in E* R; "rigid"; repeatable.', family=True, read=_stiffness
        ),
        "speed": Axis(tuple(10.0 ** (i / 2) for i in range(-8, 5)), "Of the machine, in v0", POSITIVE, "1e-4 to 100"),
    },
    lambda values: (partial(_rate_points, values), list(dict.fromkeys([math.inf, *values["thickness"]]))),
    lambda values: (
        RATE_MAP_PER_POINT * (1 + len(values["thickness"])) * len(values["stiffness"]) * len(values["speed"])
    ),
    "paraboloid, E* = R = w0 = v0 = 1: pull-off force in pi w0 R, energy in w0 pi a^2 at no load",
    [
        ("h_over_R", "h/R", "8.3g"),
        ("k_over_Estar_R", "k/(E* R)", "9.3g"),
        ("V_over_v0", "V/v0", "10.4g"),
        ("minus_P_over_pi_w0_R", "force", "9.4f"),
        ("dissipated_over_w0_pi_a2", "energy", "9.4g"),
    ],
    _rate_figure,
)


# --------------------------------------------------------------------------------------------------
# A map of what no slip changes: S and load of a bonded layer without slip over those without friction, over a/h.

# Which part of the map there is, how finely its series are solved, and what that takes.
STICKING_MAP_PER_DECADE = 20  # choice: of the contact radius, between which loads are interpolated to 1e-4
# of the largest a/h; tuned on maps, by `make constants`: a stuck contact is wider at equal depth by less
STICKING_MAP_BEYOND = 1.2
# tuned on maps, by `make constants`: relative, of the series; ratios are printed to four digits
STICKING_MAP_TOLERANCE = 1e-4
STICKING_MAP_PER_NU = 0.25  # CPU seconds; tuned on maps of 6 and 40 ratios of Poisson, by `make guards`
STICKING_MAP_PER_POINT = 5e-4  # CPU seconds of an a/h; tuned on maps of 1000, by `make guards`


def _rows(ratios: Sequence[float], nu: float) -> Columns:
    """For each a/h the ratio of S at that radius and that of the load at the depth where the sliding contact has that
    radius, in units of h = R = 1 m, E* = 1 Pa."""
    wanted = np.array(ratios)
    decades = np.log10(STICKING_MAP_BEYOND * wanted[-1] / wanted[0])
    radii = np.geomspace(wanted[0], STICKING_MAP_BEYOND * wanted[-1], max(int(STICKING_MAP_PER_DECADE * decades), 8))
    radii = np.unique(np.concatenate([radii, wanted]))
    sliding, sticking = (
        series_at(radii, layer(nu), Layered(STICKING_MAP_TOLERANCE), sticks) for sticks in (False, True)
    )
    at = np.searchsorted(radii, wanted)
    assert sliding.S is not None
    assert sticking.S is not None
    logs = pchip(np.log(sticking.delta), np.log(sticking.P))
    load = np.exp(logs(np.log(sliding.delta[at]))) / sliding.P[at]
    return rows(nu=nu, a_over_h=wanted, S_ratio=sticking.S[at] / sliding.S[at], load_ratio=load,
                solved_by=f"jkr {__version__} layered")  # fmt: skip


def _sticking_figure(columns: Columns) -> Figure:
    from .figures import MapPanel, lines_figure

    titles = {"S_ratio": "$S$ at equal radius", "load_ratio": "load at equal depth"}
    panels = [MapPanel(name, "no slip / frictionless", title) for name, title in titles.items()]
    return lines_figure(columns, ("a_over_h", "$a / h$"), panels, {"nu": r"$\nu$ = {:g}".format})


STICKING_MAP = Map(
    "sticking",
    """Map the ratio of contact without slip to frictionless contact under a paraboloid on a layer that is bonded to a
    rigid substrate, over a/h.

    The map shows two ratios of no slip to frictionless contact: of the stiffness S = dP/ddelta at equal contact radius,
    and of the load at equal depth. The results are sticking-map.csv, .png and .svg.

    \b
    jkr study sticking-map -o map
    jkr study sticking-map --nu 0.499 --ratio 3.333
    """,
    {
        "nu": Axis((0.0, 0.3, 0.45, 0.49, 0.499, 0.5), "Repeatable.", POISSON, family=True),
        "ratio": Axis((0.05, 0.1, 0.2, 0.5, 1.0, 2.0, 10 / 3, 5.0, 10.0), "Values of a/h",
                      within(1e-2, 12.0), "0.05 to 10"),
    },
    lambda values: (partial(_rows, values["ratio"]), values["nu"]),
    lambda values: len(values["nu"]) * (STICKING_MAP_PER_NU + STICKING_MAP_PER_POINT * len(values["ratio"])),
    "paraboloid on a bonded layer: no slip over frictionless",
    [SHOWN_NU, ("a_over_h", "a/h", "8.4g"), ("S_ratio", "S", "8.4f"), ("load_ratio", "load at equal depth", "20.4f")],
    _sticking_figure,
)  # fmt: skip


# --------------------------------------------------------------------------------------------------
# The transition map: the pull-off force of a paraboloid on a layer from JKR to DMT, over how strongly and how far it
# adheres.
#
# -P_min/(pi w R) under load control depends on Poisson's ratio, the base, q = w R^2/(E* h^3) and mu = sigma (R/(E*^2
# w))^(1/3) alone: the adhesion map of Johnson and Greenwood (J. Colloid Interface Sci. 192 (1997) 326) for a layer.
# Its limits are JKR's force on that layer for large mu, and 2 for small; thin incompressible layers rise above both.

# Which part of the map there is, how finely it is solved, and what that takes.
TRANSITION_POINTS = 60  # tuned on maps, by `make constants`: contact radii of a curve; more are added where it bends
TRANSITION_ROOM = 1.5  # tuned on maps, by `make constants`: of the largest radius over that of pull-off without a range
TRANSITION_PER_POINT = 0.06  # CPU seconds; tuned on maps of 17 and 100 ranges, by `make guards`


def _transition_row(base: str, mus: Sequence[float], cell: tuple[float, float]) -> Columns:
    """All ranges of one layer and one work of adhesion, in units of h = R = 1 m, E* = 1 Pa."""
    nu, q = cell
    thick, thin = (9 * math.pi * q / 8) ** (1 / 3), max((8 * q) ** (1 / 4), (384 * q) ** (1 / 6))
    a = TRANSITION_ROOM * max(thick, min(thin, 2 * thick))
    problem = Problem(Paraboloid(1.0), layer(nu, base == "bonded"), Loading("radius", a, TRANSITION_POINTS))
    solution = Layered()(problem)
    sharp = transform(solution.series, "exact", q).pull_off(LOAD_CONTROL)
    if isinstance(sharp, Unknown):
        raise SolveError(f"transition map: nu = {nu:g}, q = {q:g}: {sharp.reason}")
    body = FiniteRangeBody(problem, solution.series, AttractedBody(problem))
    points = list[tuple[float, float, float, str]]()
    for mu in mus:  # load, a and c at pull-off, NaN where there is none, and the reason
        try:
            point = body.curve(Range.of(q, stress=mu * q ** (1 / 3))).pull_off(LOAD_CONTROL)
        except JkrError as error:
            point = Unknown(str(error))
        if isinstance(point, CriticalPoint) and point.c is not None:
            points.append((point.P, point.a, point.c, ""))
        else:
            lost = point.reason if isinstance(point, Unknown) else "no pull-off"
            points.append((math.nan, math.nan, math.nan, f"nu = {nu:g}, q = {q:g}, mu = {mu:g}: {lost}"))
    (P, a_h, c_h, reason), unit = zip(*points, strict=True), -math.pi * q
    return rows(nu=nu, base=base, w_R2_over_Estar_h3=q, mu=np.array(mus), minus_P_over_pi_w_R=np.array(P) / unit,
                jkr_minus_P_over_pi_w_R=sharp.P / unit, a_over_h=a_h, c_over_h=c_h, reason=reason)  # fmt: skip


def _transition_figure(columns: Columns) -> Figure:
    """Filled where there are values enough on both axes, else as lines."""
    from .figures import MU, MapPanel, filled_figure, lines_figure

    if min(np.unique(columns[name]).size for name in (Q, "mu")) >= 4:
        return filled_figure(columns)
    title = f"layer on a rigid substrate, {columns['base'][0]}; dashed: JKR, dotted: long range"
    panel = MapPanel(
        "minus_P_over_pi_w_R", r"pull-off force / $\pi w R$", title, {2.0: ""}, dashed="jkr_minus_P_over_pi_w_R"
    )
    over = ("mu", MU)
    return lines_figure(columns, over, [panel], {Q: r"$w R^2/(E^* h^3)$ = {:g}".format, "nu": r"$\nu$ = {:g}".format})


TRANSITION_MAP = Map(
    "transition",
    """Map the pull-off force of a paraboloid on a layer on a rigid substrate, in pi w R, over the range of adhesion.

    mu is the Tabor number of the range. The limits are the force of JKR on the same layer and 2 pi w R of a long range.
    The results are transition-map.csv, .png and .svg. The picture is filled if both axes have at least four values;
    otherwise it shows lines.

    \b
    jkr study transition-map --nu 0.3 --q 1 --mu 0.3 --mu 3 -o map
    """,
    {
        "nu": Axis((0.499,), "Repeatable.", POISSON, family=True),
        "base": BASE,
        "q": Axis(tuple(np.geomspace(1e-2, 1e2, 13).tolist()), "Values of w R^2/(E* h^3)",
                      within(1e-4, 1e4), "13 from 0.01 to 100"),
        "mu": Axis(tuple(np.geomspace(0.1, 30, 17).tolist()), "Values of stress (R/(E*^2 w))^(1/3)",
                   within(0.05, 50.0), "17 from 0.1 to 30"),
    },
    lambda values: (partial(_transition_row, values["base"], values["mu"]), [*product(values["nu"], values["q"])]),
    lambda values: TRANSITION_PER_POINT * math.prod(len(values[name]) for name in ("nu", "q", "mu")),
    "{base} layer on a rigid substrate, paraboloid: pull-off force in pi w R",
    [SHOWN_NU, SHOWN_Q, ("mu", "mu", "6g"), ("minus_P_over_pi_w_R", "force", "8.4f"),
     ("jkr_minus_P_over_pi_w_R", "JKR", "8.4f"), ("a_over_h", "a/h", "9.4g"), ("c_over_h", "c/h", "9.4g")],
    _transition_figure,
)  # fmt: skip


# --------------------------------------------------------------------------------------------------
# The roughness map: what full conformal contact leaves of w, over the rms height and the modulus. U ~ E rms^2 of one
# body and one shape of spectrum, so that one integral serves all cells of a layer.

ROUGHNESS_FLAT = 1e-3  # choice: rms over the shortest wave of the unit spectrum, whose slope is small
ROUGHNESS_PER_LAYER = 2e-3  # CPU seconds; tuned on maps of 1 and 50 layers, by `make guards`


def _roughness_rows(values: Values, thickness: float) -> Columns:
    """U and w over rms and E on one layer; NaN and the reason where contact is partial or slopes are steep."""
    rms, E = (column.ravel() for column in np.meshgrid(values["rms"], values["modulus"]))
    waves = {name: values[name] for name in ("longest", "shortest", "hurst")}
    material = Elastic(1.0, values["nu"])
    layers = () if math.isinf(thickness) else (Layer(material, thickness),)
    specimen = Specimen(layers, Rigid(True) if layers else HalfSpace(material))
    height = values["shortest"] * ROUGHNESS_FLAT
    unit = Roughness(rms=height, **waves).on(Problem(Paraboloid(1.0), specimen, Loading("radius", 1.0)))
    U, slope = unit.energy * E * (rms / height) ** 2, unit.spectrum.slope * rms / height
    reason = np.where(U >= values["w"], "U > w: no adhesion by conformal contact", "")
    reason = np.where(slope > ROUGH_STEEPEST, f"rms slope above {ROUGH_STEEPEST:g}", reason)
    w = np.where(reason == "", values["w"] - U, np.nan)
    return rows(h_m=thickness, E_Pa=E, rms_m=rms, rms_slope=slope, elastic_energy_J_per_m2=U, w_J_per_m2=w,
                w_smooth_J_per_m2=values["w"], reason=reason)  # fmt: skip


def _roughness_figure(columns: Columns) -> Figure:
    from .figures import MapPanel, lines_figure

    over, labels = ("rms_m", "rms height [m]"), {"E_Pa": lambda E: f"$E$ = {show(E, 'modulus')}"}
    if np.unique(columns["rms_m"]).size < np.unique(columns["E_Pa"]).size:
        over, labels = ("E_Pa", "Young's modulus [Pa]"), {"rms_m": lambda rms: f"rms {show(rms, 'length')}"}
    labels |= {"h_m": lambda h: "half-space" if math.isinf(h) else f"$h$ = {show(h, 'length')}"}
    panel = MapPanel("w_J_per_m2", "work of adhesion at least [J/m$^2$]", "full conformal contact, $r$ = 1")
    return lines_figure(columns, over, [panel], labels)


ROUGHNESS_MAP = Map(
    "roughness",
    """Map the work of adhesion that full conformal contact leaves between rough surfaces, over rms height and modulus.

    The specimen is a half-space or a bonded layer. The true area is taken as the nominal one (r = 1), so that only the
    product E rms^2 matters. The results are roughness-map.csv, .png and .svg.

    \b
    jkr study roughness-map --thickness "1 um" --w "50 mJ/m^2" -o map
    jkr study roughness-map --rms "50 nm" --modulus "1 MPa" --modulus "3 MPa"
    """,
    {
        "rms": Axis(tuple(np.geomspace(5e-9, 500e-9, 21).tolist()), "Rms heights; repeatable.", shown="5 to 500 nm",
                    read=Ranged("length", above=0).read),
        "modulus": Axis((1e6,), "Young's moduli; repeatable.", family=True, shown="1 MPa",
                        read=Ranged("modulus", above=0).read),
        "thickness": Axis((math.inf, 1e-6), "Of bonded layers, or half-space; repeatable.", family=True,
                          shown="half-space, 1 um",
                          read=Ranged("length", above=0, words=(("half-space", math.inf),)).read),
        "nu": Axis(0.5, "Poisson's ratio.", POISSON, several=False),
        "longest": Axis(20e-6, "Longest wave.", several=False, shown="20 um", read=Ranged("length", above=0).read),
        "shortest": Axis(10e-9, "Shortest wave.", several=False, shown="10 nm", read=Ranged("length", above=0).read),
        "hurst": Axis(0.8, "Hurst exponent.", Ranged("number", above=0, most=1), several=False),
        "w": Axis(0.05, "Between smooth surfaces.", several=False, shown="50 mJ/m^2",
                  read=Ranged("work", above=0).read),
    },
    lambda values: (partial(_roughness_rows, values), values["thickness"]),
    lambda values: ROUGHNESS_PER_LAYER * len(values["thickness"]),
    "bonded layers and half-space, nu = {nu:g}: what roughness leaves of w = {w:g} J/m^2",
    [("h_m", "h [m]", "10.3g"), ("E_Pa", "E [Pa]", "10.3g"), ("rms_m", "rms [m]", "10.3g"),
     ("elastic_energy_J_per_m2", "U [J/m^2]", "11.4g"), ("w_J_per_m2", "w at least", "11.4g")],
    _roughness_figure,
)  # fmt: skip


@checked
def study_map(name: str, **axes: Any) -> MapResult:
    """Compute a map of results over parameters, as ``jkr study <name>-map`` does.

    Parameters
    ----------
    name : str
        "pull-off", "sticking", "transition", "adhesion", "rate" or "roughness".
    **axes
        Values of its parameters: ``study_map("pull-off", nu=[0.3], q=[0.1, 1])``.

    Returns
    -------
    MapResult
        ``columns``, ``summary()`` and ``figure()``.

    Raises
    ------
    InputError
        Where an axis is unknown, or a value is out of its range.
    """
    return one_thread()(map_of(name).over)(**axes)
