"""Contact laws of particles of all sizes: one table for a pair of materials and coatings.

Of a paraboloid r^2/(2 R) on any stack of layers, delta_H and P_H at a contact radius go like 1/R, S and S' do not
depend on R. With the thickness h of the thinner layer that touches and the contact modulus E* of both surfaces

    delta R/h^2 = D(a/h) - sqrt(q) T(a/h),    P/(pi w R) = [G(a/h) - sqrt(q) S T]/(pi q),    q = w R^2/(E* h^3),

(Eq. 13): P/(pi w R) over delta R/h^2 has one parameter. Two coated spheres of the radii R1 and R2 are the paraboloid
R = R1 R2/(R1 + R2), and the compliances of their stacks add (``bodies/problem.py: stacks``).

The table. From the tear-off under displacement control on, P and a are smooth in sqrt(delta - delta_tear). Its abscissa
s in 0 ... 1 and its ordinates,

    delta = delta_tear - delta_tear sinh(U s)^2,    P/(pi w R) = f(s) cosh(U s)^(2 kappa),    ln(a/h),

keep the same size in all rows: U(q) is where a row ends, kappa(q) makes f end near 1. All are interpolated by cubics
over ln q and s.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from importlib import resources
from itertools import chain, pairwise
from pathlib import Path
from string import Template
from typing import Any, cast
from zlib import crc32

import numpy as np

from ..adhesion.contact_shape import refuse_no_disc
from ..adhesion.curve import AdhesiveCurve, Nonadhesive
from ..base.errors import InputError, JkrError, Unknown
from ..base.numerics import Array
from ..base.registry import Result
from ..base.units import show
from ..bodies.indenters import Paraboloid
from ..bodies.problem import Loading, Problem
from ..cli.options import begin, typed_options
from ..methods.integral.fredholm import InaccurateError
from ..methods.layered.solver import Layered
from ..methods.protocol import METHODS, Limits
from ..report.export import PERMISSION, DemLaw, interpolated, model_name, stable_branch
from ..resolve.analysis import Analysis

HEADER_CODE = Template(resources.files(__package__).joinpath("particles.c").read_text(encoding="utf-8"))
SIZES_ERROR = 2e-4  # choice: of the force over its size + pi w R, far below what a work of adhesion is known to
SIZES_FEWEST = 8  # choice: rows of a decade of sizes to begin with, doubled until that holds
SIZES_MOST = 1000  # choice: rows of sizes of a law
SIZES_ROWS = 33, 65, 129  # choice: of a size, the first that will do
SIZES_FINE = 257  # theory: at which the exact contact of a size is known, on and between all those rows
SIZES_PER_DECADE = 40  # tuned on maps, by `make constants`: contact radii of the solution
SIZES_TOLERANCE, SIZES_COARSER = 1e-8, 1e-5  # choice: of the solution, and where a/h is large
SIZES_BELOW = 0.05  # choice: of the least contact radius at tear-off, where the unstable branch is left
UNSTABLE_ROWS = 17  # choice: of the CSV


@dataclass(frozen=True, eq=False)
class Row:
    """The exact contact of one size R [m]: ``columns`` (7,) as the header names them; at equal steps of s overlap [m],
    force over pi w R and radius over h (SIZES_FINE,); its adhesive ``curve`` and its ``law``."""

    R: float
    columns: Array
    delta: Array
    force: Array
    radius: Array
    curve: AdhesiveCurve
    law: DemLaw


@dataclass(frozen=True, eq=False)
class SizesLaw:
    """The contact law of a pair of materials and coatings for the reduced radii of its ``rows``, equal steps of ln R.

    ``strain``: a/R up to which each size is tabulated; ``body``: that of the radius ``high``; ``across``: rows of a
    size. ``errors``: the largest on and between rows and sizes, with that of the solution: of the force over |P| + pi w
    R, of the radius over itself, of ``points`` over pi w R, the overlap of tear-off and their product. ``vectors`` (n,
    5): R, w, delta, P, a where the force errs most between two sizes.
    """

    problem: Problem
    w: float
    low: float
    high: float
    strain: float
    body: Nonadhesive
    rows: Sequence[Row] = ()
    across: int = 0
    errors: Mapping[str, float] = field(default_factory=dict)
    vectors: Array = field(default_factory=lambda: np.empty(0))

    @classmethod
    def of(cls, problem: Problem, w: float, low: float, high: float, strain: float) -> SizesLaw:
        """The law for a ``problem`` of any radius; InputError, Refusal where there is none of one branch at all
        sizes."""
        whole = solved_for_sizes(problem, w, low, high, strain)
        try:
            solution = Layered(SIZES_TOLERANCE)(whole)
        except InaccurateError:
            solution = Layered(SIZES_COARSER)(whole)
        law = cls(problem, w, low, high, strain, Nonadhesive.of(solution.series, "exact"))
        if isinstance(solved := solution.budget.discretisation, Unknown):
            raise InputError(f"the error of the solution is not known ({solved}), nor is that of its law")
        count = max(5, math.ceil(SIZES_FEWEST * math.log10(high / low)))
        rows = [law.row(R) for R in np.geomspace(low, high, count).tolist()]
        while len(rows) <= SIZES_MOST:
            between = [law.row(math.sqrt(one.R * other.R)) for one, other in pairwise(rows)]
            for across in SIZES_ROWS:
                made = replace(law, rows=rows, across=across).compared(between, solved)
                if made.errors["force"] <= SIZES_ERROR:
                    return made
            rows = [*chain.from_iterable(zip(rows, between, strict=False)), rows[-1]]
        raise InputError(f"{len(rows)} sizes meet the law within {made.errors['force']:.1g} only: give fewer sizes")

    @property
    def h(self) -> float:
        """The thickness of the thinner layer that touches [m]; of homogeneous bodies the radius of the case."""
        thickness = self.problem.top_thickness
        return thickness if math.isfinite(thickness) else float(self.problem.indenter.tip_radius or 1.0)

    def q(self, R: float) -> float:
        """Return w R^2/(E* h^3)."""
        return self.w * R**2 / (self.problem.E_star * self.h**3)

    @cached_property
    def columns(self) -> Array:
        """Those of all sizes (sizes, 7)."""
        return np.array([row.columns for row in self.rows])

    @cached_property
    def force(self) -> Array:
        """P/(pi w R) over cosh(U s)^(2 kappa), (sizes, across)."""
        u = np.exp(self.columns[:, 1:2]) * np.linspace(0, 1, self.across)
        return np.array([self.tabulated(row.force) for row in self.rows]) / np.cosh(u) ** (2 * self.columns[:, 2:3])

    @cached_property
    def radius(self) -> Array:
        """ln(a/h) (sizes, across)."""
        return np.log([self.tabulated(row.radius) for row in self.rows])

    def tabulated(self, column: Array) -> Array:
        """The rows of the table among those of an exact contact."""
        return column[:: (SIZES_FINE - 1) // (self.across - 1)]

    def row(self, R: float) -> Row:
        """The exact contact of one size."""
        w, h, unit = self.w, self.h, math.pi * self.w * R
        curve = AdhesiveCurve(self.body.under_profile(self.high / R), w)
        at, end = f"R = {show(R, 'length')}", self.strain * R
        try:
            law = DemLaw.of(curve)
        except InputError as error:
            raise InputError(f"{at}: {error}") from None
        tear, touch, load = law.tear_off.delta, law.jump_in, law.load
        least = max(touch.a, math.inf if load is None else load.a)
        if end <= least:
            raise InputError(f"{at}: adhesion alone makes a/R {least / R:.3g}, and the loading of the case ends at "
                             f"{self.strain:.3g}: give larger sizes or a larger loading")  # fmt: skip
        assert load is not None

        # Where the table ends, and what makes f(s) of one size there, whatever the sign of P
        delta_end, P_end = (float(values) for values in curve.at(np.array(end)))
        reach = math.asinh(math.sqrt((delta_end - tear) / -tear))
        kappa = math.log((P_end - 2 * load.P) / unit + 1) / (2 * math.log(math.cosh(reach)))
        whole = float(curve.at(curve.places[-1:])[0][0]) - tear
        u = reach * np.linspace(0, 1, SIZES_FINE)
        delta, P, a = stable_branch(curve, law.tear_off, np.minimum(np.sqrt(-tear / whole) * np.sinh(u), 1.0))
        lost = -curve.work(law.tear_off.place, touch.place)
        columns = [math.log(-tear * R / h**2), math.log(reach), kappa, load.delta / tear, load.P / unit,
                   touch.P / unit, lost / (unit * -tear)]  # fmt: skip
        return Row(R, np.array(columns), delta, P / unit, a / h, curve, law)

    def compared(self, between: Sequence[Row], solved: float) -> SizesLaw:
        """The law with its errors, those of its solution ``solved``, beside exact contacts of its own sizes and
        ``between`` them."""
        errors, vectors = dict.fromkeys(("force", "radius", "points"), 0.0), list[list[float]]()
        for i, exact in enumerate([*self.rows, *between]):
            y = i / (len(self.rows) - 1) if i < len(self.rows) else (i - len(self.rows) + 0.5) / (len(self.rows) - 1)
            columns, force, radius = self.at(y, exact.delta[1:] * exact.R / self.h**2)  # the first is one of the points
            apart = {
                "force": np.abs(force - exact.force[1:]) / (np.abs(exact.force[1:]) + 1),
                "radius": np.abs(radius / exact.radius[1:] - 1),
                "points": np.abs(np.delete(columns - exact.columns, [1, 2])),  # of the order of 1
            }
            errors = {name: max(errors[name], float(values.max()) + solved) for name, values in apart.items()}
            if i >= len(self.rows):
                at = 1 + int(apart["force"][:-1].argmax())
                P = exact.force[at] * math.pi * self.w * exact.R
                vectors.append([exact.R, self.w, exact.delta[at], P, exact.radius[at] * self.h])
        return replace(self, errors=errors, vectors=np.array(vectors))

    def at(self, y: float, delta: Array) -> tuple[Array, Array, Array]:
        """What the header reads at a fraction ``y`` of ln q: the columns, and force over pi w R and radius over h at
        overlaps ``delta`` R/h^2."""
        place = np.array([y])
        columns, forces, radii = (interpolated(table, place)[0] for table in (self.columns, self.force, self.radius))
        tear, reach, kappa = -math.exp(columns[0]), math.exp(columns[1]), columns[2]
        u = np.minimum(np.arcsinh(np.sqrt(np.maximum((delta - tear) / -tear, 0))), reach)
        force = interpolated(forces, u / reach) * np.cosh(u) ** (2 * kappa)
        return columns, force, np.exp(interpolated(radii, u / reach))


def solved_for_sizes(problem: Problem, w: float, low: float, high: float, strain: float) -> Problem:
    """The ``problem`` of the largest size, over all contact radii that the sizes need."""
    # At tear-off on a half-space a^3 = pi w R^2/(8 E*); an incompressible layer makes it (96 q)^(1/6) h at most
    least = (math.pi * w * low**2 / (8 * problem.E_star)) ** (1 / 3)
    if math.isfinite(h := problem.top_thickness):
        least = min(least, h * (96 * w * low**2 / (problem.E_star * h**3)) ** (1 / 6))
    first, last = SIZES_BELOW * least, strain * high
    radii = np.geomspace(first, last, max(8, math.ceil(SIZES_PER_DECADE * math.log10(last / first))))
    indenter = replace(cast(Any, problem.indenter), R=high)
    return replace(problem, indenter=indenter, loading=Loading.given("radius", tuple(radii.tolist())))


@dataclass(frozen=True, eq=False)
class ExportedSizes(Result):
    """The contact ``law`` of all sizes: ``columns`` are both branches of each size, ``code`` the C header, in which all
    names begin with ``name``."""

    law: SizesLaw
    file: Path
    name: str

    @property
    def columns(self) -> dict[str, Array]:  # type: ignore[override]
        """Rows from the least contact to the deepest, size by size: the unstable branch, which no overlap holds, what
        is passed on unloading alone, and what on loading too."""
        law, parts = self.law, list[dict[str, Array]]()
        for row in law.rows:
            R = row.R
            places = np.geomspace(row.curve.places[0], row.law.tear_off.place, UNSTABLE_ROWS + 1)[:-1]
            lower = (*row.curve.at(places), row.curve.contact_radii(places))
            unit = math.pi * law.w * R
            upper = map(law.tabulated, (row.delta, row.force * unit, row.radius * law.h))
            delta, P, a = (np.concatenate(pair) for pair in zip(lower, upper, strict=True))
            branch = np.where(delta >= 0, "loading and unloading", "unloading")
            branch[:UNSTABLE_ROWS] = "unstable"
            parts.append({
                "R_m": np.full(a.size, R), "w_R2_over_Estar_h3": np.full(a.size, law.q(R)), "branch": branch,
                "delta_R_over_h2": delta * R / law.h**2, "P_over_pi_w_R": P / unit, "a_over_h": a / law.h,
                "delta_m": delta, "P_N": P, "a_m": a,
            })  # fmt: skip
        return {name: np.concatenate([part[name] for part in parts]) for name in parts[0]}

    @property
    def code(self) -> str:
        """The C header (C99 and C++, no other file): table, functions, test vectors and a check."""
        law, indenter = self.law, self.law.problem.indenter
        words = law.problem.words.replace(indenter.words, indenter.noun, 1)  # of any radius
        tables = {"of_size": law.columns, "force_table": law.force, "radius_table": law.radius}
        checksum = crc32(np.concatenate([table.ravel() for table in tables.values()]).tobytes())
        numbers = dict[str, str]()  # of each table, a row in braces, seven to a line
        for name, table in tables.items():
            rows = []
            for row in table:
                cells = [f"{float(cell):.10g}" for cell in row]
                lines = [", ".join(cells[i : i + 7]) for i in range(0, len(cells), 7)]
                rows.append("    { " + ",\n      ".join(lines) + " }")
            numbers[name] = ",\n".join(rows)
        vector = ",\n".join("    { " + ", ".join(f"{float(cell)!r}" for cell in row) + " }" for row in law.vectors)
        return HEADER_CODE.substitute(
            body=words.replace("*/", "* /").rpartition(" to a ")[0], name=self.name, NAME=self.name.upper(),
            low=f"{law.low:g}", high=f"{law.high:g}", w=repr(law.w), h=repr(law.h), E_star=repr(law.problem.E_star),
            sizes=len(law.rows), rows=law.across, vectors=len(law.vectors), vector=vector,
            log_q=", ".join(repr(math.log(law.q(R))) for R in (law.low, law.high)), checksum=f"0x{checksum:08x}UL",
            permission=PERMISSION.format("\n   "),
            **{name: f"{value:.1e}" for name, value in self.stated.items()},
            **numbers,
        )  # fmt: skip

    @property
    def stated(self) -> dict[str, float]:
        """The errors, rounded up to two digits."""
        rounded = {}
        for name, error in self.law.errors.items():
            digit = 10.0 ** (math.floor(math.log10(max(error, 1e-12))) - 1)
            rounded[name] = math.ceil(error / digit) * digit
        return rounded

    def summary(self) -> dict[str, Any]:
        law = self.law
        return {
            "file": str(self.file), "name": self.name, "w_J_per_m2": law.w, "R_m": [law.low, law.high],
            "w_R2_over_Estar_h3": [law.q(law.low), law.q(law.high)], "h_m": law.h, "E_star_Pa": law.problem.E_star,
            "largest_a_over_R": law.strain, "sizes": len(law.rows), "rows": law.across, "errors": dict(law.errors),
            "pull_off_over_pi_w_R": (-law.columns[:, 4]).tolist(),
        }  # fmt: skip

    def words(self) -> list[str]:
        law, stated = self.law, self.stated
        q = " to ".join(f"{law.q(R):.3g}" for R in (law.low, law.high))
        force = " to ".join(f"{-column:.4f}" for column in law.columns[[0, -1], 4])
        return [
            f"R = {show(law.low, 'length')} to {show(law.high, 'length')}, w = {show(law.w, 'work')}: {self.file}",
            f"  w R^2/(E* h^3) {q}: pull-off force {force} pi w R (load control)",
            f"  table      {len(law.rows)} sizes of {law.across} rows up to a = {law.strain:.3g} R",
            f"  error      force {stated['force']:.1e} of |P| + pi w R, radius {stated['radius']:.1e}, points "
            f"{stated['points']:.1e}",
            f"  functions  {self.name}_contact, {self.name}_points_of",
        ]


@dataclass(frozen=True)
class OfSizes:
    """What ``export`` makes in place of the law of one size, for reduced radii between two ``sizes`` [m]."""

    sizes: tuple[float, float]
    limits: Limits

    def of(self, result: Analysis, name: str) -> ExportedSizes:
        """The law up to the contact radii over R of a ``result``; InputError where its bodies have none."""
        problem, what = result.problem, "export --sizes"
        refuse_no_disc(result.solution.facts, what)
        if "slopes" in typed_options():
            raise InputError(f"{what}: solves all sizes with exact slopes, --slopes has no effect: leave it out")
        if not isinstance(problem.indenter, Paraboloid):
            raise InputError(f"{result.path}: {what}: a {problem.indenter.noun} of another size is another shape: give "
                             'shape = "paraboloid"')  # fmt: skip
        if refusal := Layered().refusal(problem):
            raise InputError(f"{result.path}: {what}: {refusal}")
        method = result.solution.method
        if method not in METHODS or not METHODS[method].exact:
            raise InputError(f"{result.path}: {what}: solves the bodies for all sizes by their exact kernel and would "
                             f"ignore the numbers of this solution (method {method}): export its case (.toml) with "
                             'method = "layered", or leave --sizes out')  # fmt: skip
        strain = float(result.curve.series.a[-1]) / problem.indenter.R
        try:
            whole = solved_for_sizes(problem, result.w, *self.sizes, strain)
            begin(what, Layered().forecast(whole), self.limits, "smaller sizes")
            law = SizesLaw.of(problem, result.w, *self.sizes, strain)
        except JkrError as error:
            raise InputError(f"{result.path}: {what}: {error}") from None
        return ExportedSizes(law, result.path, model_name(name))
