"""A computed body for other programs: a contact law of particle codes as a C header, and a fit model of nanite and
PyJibe, which fits E and w there.
"""

from __future__ import annotations

import math
import re
from dataclasses import dataclass
from functools import cached_property
from importlib import resources
from string import Template
from typing import Any
from zlib import crc32

import numpy as np

from .. import __version__
from ..adhesion.curve import DISPLACEMENT_CONTROL, LOAD_CONTROL, CriticalPoint, Equilibrium, EquilibriumCurve
from ..adhesion.device_path import stability_under
from ..base.errors import InputError, Unknown, counted
from ..base.numerics import MOST_SOLVES, Array, zeros_between
from ..base.registry import Result
from ..base.units import show
from ..bodies.indenters import Paraboloid
from ..formulas import jkr
from ..resolve.analysis import Analysis
from .tables import format_state, quantities

HEADER_CODE = Template(resources.files(__package__).joinpath("dem.c").read_text(encoding="utf-8"))
PERMISSION = (  # of LICENSE-EXCEPTION.md, {} between its lines
    "This file is not under jkr's licence (LICENSE-EXCEPTION.md there): you may use, change and distribute it{}under "
    "terms of your choice, without warranty."
)


def model_name(stem: str) -> str:
    """Return the name of a law or a model after the ``stem`` of a file: what names in C and Python may begin with."""
    return "jkr_" + (re.sub("[^a-z0-9]+", "_", stem.lower()).strip("_") or "model")


@dataclass(frozen=True, eq=False)
class Exported(Result):
    """The contact law of an adhesive curve: ``columns`` are its table, ``code`` the C header, in which all names begin
    with ``name``."""

    law: DemLaw
    result: Analysis
    name: str

    @classmethod
    def of(cls, result: Analysis, name: str | None = None) -> Exported:
        """The law of a curve, by default named after its file; InputError where it is none of one branch."""
        if result.problem.indenter.rim < math.inf:
            raise InputError(f"{result.path}: export is of contacts that begin at a point, not of a full flat end")
        try:
            return cls(DemLaw.of(result.curve), result, model_name(name or result.path.stem))
        except InputError as error:
            raise InputError(f"{result.path}: {error}") from None

    @property
    def columns(self) -> dict[str, Array]:  # type: ignore[override]
        law = self.law
        return {"fraction": np.linspace(0, 1, law.delta.size), "delta_m": law.delta, "P_N": law.P, "a_m": law.a}

    @property
    def code(self) -> str:
        """The C header (C99, no other file) with the table, a function that reads it, test vectors and a check."""
        law, result = self.law, self.result
        upper = self.name.upper()
        numbers = {"DELTA_TOUCH": 0.0, "FORCE_TOUCH": law.jump_in.P, "RADIUS_TOUCH": law.jump_in.a,
                   "DELTA_TEAR": law.tear_off.delta, "FORCE_TEAR": law.tear_off.P, "RADIUS_TEAR": law.tear_off.a,
                   "SPAN": law.delta[-1] - law.delta[0], "FORCE_SCALE": abs(law.P).max(),
                   "RADIUS_SCALE": law.a.max()}  # fmt: skip
        if law.load is not None:
            numbers |= {"DELTA_LOAD": law.load.delta, "FORCE_LOAD": law.load.P, "RADIUS_LOAD": law.load.a}
        vectors = ",\n".join("    { " + ", ".join(f"{float(cell)!r}" for cell in row) + " }" for row in law.vectors)
        return HEADER_CODE.substitute(
            body=result.problem.words.replace("*/", "* /"), w=repr(result.w), error=f"{law.error:.1g}",
            rows=law.delta.size, forces=_listed(law.P), radii=_listed(law.a), vectors=len(law.vectors), vector=vectors,
            numbers="\n".join(f"#define {upper}_{name} ({float(value)!r})" for name, value in numbers.items()),
            name=self.name, NAME=upper, checksum=f"0x{crc32(np.stack([law.delta, law.P, law.a]).tobytes()):08x}UL",
            permission=PERMISSION.format("\n   "),
        )  # fmt: skip

    @property
    def half_space(self) -> dict[str, tuple[float, float]]:
        """Overlap [m] and force [N] at which classical JKR of the uppermost material lets go, by control; empty for a
        tip without a radius."""
        problem, w = self.result.problem, self.result.w
        R, E_star = problem.indenter.tip_radius, problem.E_star
        if R is None:
            return {}
        cubes = {"displacement": 1 / 8, "load": 9 / 8}  # of a, over pi w R^2/E*
        points = {}
        for control, cube in cubes.items():
            delta, P = jkr(np.array((cube * math.pi * w * R**2 / E_star) ** (1 / 3)), E_star, R, w)
            points[control] = (float(delta), float(P))
        return points

    def summary(self) -> dict[str, Any]:
        law, result = self.law, self.result
        named = {"touch": law.jump_in, "tear_off": law.tear_off, "load_control": law.load}
        points = {name: None if at is None else quantities(at, "delta P a") for name, at in named.items()}
        classical = {name: dict(zip(("delta_m", "P_N"), pair, strict=True)) for name, pair in self.half_space.items()}
        return {"file": str(result.path), "name": self.name, "w_J_per_m2": result.w, "rows": law.delta.size,
                "error": law.error, **points, "half_space": classical}  # fmt: skip

    def words(self) -> list[str]:
        law, result = self.law, self.result
        w = result.w
        lines = [
            f"tear-off at {format_state(law.tear_off, 'P delta')} (displacement control), w = {show(w, 'work')}: "
            f"{result.path}",
            f"  table      {law.delta.size} rows up to {show(law.delta[-1], 'length')}, "
            f"good to {law.error:.1g} between",
            f"  function   {self.name}_contact",
            f"  touch      {_state(0.0, law.jump_in.P)}",
        ]
        if law.load is not None:
            lines.append(f"  pull-off   {_state(law.load.delta, law.load.P)} (load control)")
        if classical := self.half_space:
            lines.append(f"  JKR of a half-space of the uppermost material, gamma = w/2 = {show(w / 2, 'work')}:")
            lines += [f"    lets go  {_state(*pair)} ({control} control)" for control, pair in classical.items()]
        return lines


def _listed(column: Array) -> str:
    cells = [f"{float(cell)!r}" for cell in column]
    return ",\n".join("    " + ", ".join(cells[i : i + 4]) for i in range(0, len(cells), 4))


def _state(delta: float, P: float) -> str:
    return f"delta = {show(delta, 'length'):<12} P = {show(P, 'load'):<12}".rstrip()


# --------------------------------------------------------------------------------------------------
# An adhesive contact as a fit model of nanite and PyJibe: JKR of a layered body, which fits E and w there.

MODEL_CODE = Template(resources.files(__package__).joinpath("nanite.txt").read_text(encoding="utf-8"))
NANITE_ROWS = 129  # tuned on halfspace, gel and coating: the file meets the curve within 5e-6
NANITE_FINE = 8192  # theory: linear between them errs by the square of their distance in log a, below 1e-6
HALF_SPACE_FURTHER = 100.0  # choice: times the last radius, beyond which no half-space of a record is loaded
NANITE_ERROR = 1e-4  # choice: of the largest force, a tenth of what a fit in nanite can tell


@dataclass(frozen=True, eq=False)
class NaniteModel(Result):
    """The model file of the adhesive curve ``result``, named ``name``.

    The table holds the contact without adhesion, from which the file forms the curve of any E and w; of a paraboloid
    also of any radius, and on one layer of any thickness, at the a/h of the table.
    """

    result: Analysis
    name: str

    @classmethod
    def of(cls, result: Analysis, name: str) -> NaniteModel:
        """The model of a curve; InputError where E and w do not scale it, or where it is none of one branch."""
        problem = result.problem
        why = None
        if problem.indenter.material is not None:
            why = "an elastic indenter: its modulus would change with E: leave indenter.material out"
        elif problem.specimen.surface_tension:
            why = "surface tension, with which loads are not in proportion to E: leave specimen.surface_tension out"
        elif problem.indenter.a0 or problem.indenter.rim < math.inf:
            why = "a flat end, whose contact does not begin at a point"
        if why:
            raise InputError(f"{result.path}: export --nanite does not represent {why}")
        Exported.of(result)  # a law of one branch
        made = cls(result, model_name(name))
        if made.error > NANITE_ERROR:
            raise InputError(
                f"{result.path}: a table of {NANITE_ROWS} rows meets the curve within {made.error:.1g} of the largest "
                f"force only ({NANITE_ERROR:g} is needed): give a solution of more radii"
            )
        return made

    @property
    def columns(self) -> dict[str, Array]:  # type: ignore[override]
        series, nonadhesive = self.result.curve.series, self.result.jkr.nonadhesive
        a = np.geomspace(series.a[0], series.a[-1], NANITE_ROWS)
        a[[0, -1]] = series.a[[0, -1]]
        parts = nonadhesive.parts(a)
        return {"a_m": a, "delta_H_m": parts.delta_H, "P_H_N": parts.P_H, "S_N_per_m": parts.S, "dS_N_per_m2": parts.dS}

    @property
    def parameters(self) -> dict[str, tuple[str, str, float | None]]:
        """Name, unit and value in the case of each parameter; the value None: no parameter of this body."""
        problem = self.result.problem
        specimen, round_ = problem.specimen, isinstance(problem.indenter, Paraboloid)
        one_layer = round_ and len(specimen.layers) == 1 and specimen.radius is None
        return {
            "E": ("Young's Modulus", "Pa", float(specimen.surface.E)),
            "w": ("Work of Adhesion", "J/m²", float(self.result.w)),
            "R": ("Tip Radius", "m", problem.indenter.tip_radius if round_ else None),
            "h": ("Layer Thickness", "m", specimen.layers[0].thickness if one_layer else None),
            "contact_point": ("Contact Point", "m", 0.0),
            "baseline": ("Force Baseline", "N", 0.0),
        }

    @property
    def code(self) -> str:
        """The file: Python that needs NumPy, SciPy and, as nanite does, lmfit."""
        return self._code(f"{self.error:.0e}")

    def _code(self, error: str) -> str:
        problem, specimen = self.result.problem, self.result.problem.specimen
        used = {name: told for name, told in self.parameters.items() if told[2] is not None}
        R, h = (self.parameters[name][2] for name in "Rh")
        rows = np.column_stack(list(self.columns.values()))
        last, body = rows[-1, 0], problem.words.replace('"', "'")
        if specimen.layers:
            modulus, ratios = "the uppermost layer", " (all moduli keep their ratio)"
            reach = f"a contact radius of {last:.4g} m" if h is None else f"a/h = {last / h:.4g}"
        else:
            modulus, ratios = "the half-space", ""
            if R is not None:  # its columns are power laws, which go on
                last *= HALF_SPACE_FURTHER
            reach = f"a contact radius of {last:.4g} m"
        return MODEL_CODE.substitute(
            version=__version__, permission=PERMISSION.format("\n"),
            body=body, words=f"JKR, {body}", modulus=modulus, ratios=ratios, reach=reach,
            sizes=" tip radius R," * (R is not None) + " thickness h," * (h is not None), error=error,
            last=repr(float(last)), E=repr(used["E"][2]), w=repr(used["w"][2]), R=repr(R), H=repr(h), fine=NANITE_FINE,
            rows="\n".join(f"    [{', '.join(f'{cell:.12e}' for cell in row)}]," for row in rows),
            arguments="".join(f" {name}," for name in "Rh" if name in used),
            passed=",".join(f" {name if name in used else None}" for name in "Rh"),
            tip=repr(R or problem.indenter.tip_radius or float(last)), key=self.name, name=self.title,
            keys=", ".join(f'"{name}"' for name in used),
            names=", ".join(f'"{name}"' for name, _, _ in used.values()),
            units=", ".join(f'"{unit}"' for _, unit, _ in used.values()),
        )  # fmt: skip

    @property
    def title(self) -> str:
        """The name in the list of models."""
        problem = self.result.problem
        nu = f"nu = {problem.specimen.surface.nu:g}"
        layers = problem.specimen.layers
        where = f"layer, {show(layers[0].thickness, 'length')}, {nu}" if layers else nu
        return f"JKR ({self.name.removeprefix('jkr_')}: {where})"

    @cached_property
    def error(self) -> float:
        """The largest difference between the file, as it runs, and the curve, over the largest force."""
        scope: dict[str, Any] = {}
        exec(compile(self._code("unknown"), self.name, "exec"), scope)
        law = DemLaw.of(self.result.curve)
        delta, P, _ = law.vectors.T
        values = {name: value for name, (_, _, value) in self.parameters.items() if value is not None}
        away = np.argsort(-delta)  # the tip moves away
        return float(np.abs(scope["jkr"](-delta[away], **values) - P[away]).max() / np.abs(law.P).max())

    def summary(self) -> dict[str, Any]:
        return {
            "file": str(self.result.path),
            "model_key": self.name,
            "model_name": self.title,
            "parameters": [name for name, (_, _, value) in self.parameters.items() if value is not None],
            "rows": NANITE_ROWS,
            "largest_a_m": float(self.columns["a_m"][-1]),
            "error": self.error,
        }

    def words(self) -> list[str]:
        told, error = self.summary(), 10 ** math.ceil(math.log10(max(self.error, 1e-9)))
        last = show(told["largest_a_m"], "length")
        return [
            f"{self.title}: parameters {', '.join(told['parameters'])}; {self.result.path}",
            f"  table      {NANITE_ROWS} rows up to a = {last}; force within {error:.0e} of the largest",
            "  load it    in PyJibe: Preferences, Extensions; in nanite: load_model_from_file(..., register=True)",
        ]


# --------------------------------------------------------------------------------------------------
# The contact law that a particle code needs: load and contact radius over the overlap, on the branch that is stable
# under displacement control, with the points where contact begins and is lost.

# How finely the law is tabulated.
DEM_FEWEST = 65  # tuned on contact laws, by `make constants`: rows to begin with, doubled until the law is met
# tuned on contact laws, by `make constants`: of the interpolation, relative to the largest load or radius
DEM_ERROR = 1e-6


@dataclass(frozen=True, eq=False)
class DemLaw:
    """A contact law as a table over x = sqrt(delta - delta_tear), in which P and a are smooth: at the tear-off their
    slopes over delta are infinite.

    ``delta, P, a`` [m, N, m]: rows at equal steps of x, from the tear-off on. ``tear_off``: where contact is lost under
    displacement control; ``load``: under load control, None where the table ends before; ``jump_in``: the state after
    first touch at delta = 0. ``error``: the largest of the cubic interpolation, relative to the largest |P| and a.
    ``vectors`` (12, 3): delta, P, a of the curve itself between the rows, with which an implementation is checked.
    """

    delta: Array
    P: Array
    a: Array
    tear_off: CriticalPoint
    load: CriticalPoint | None
    jump_in: Equilibrium
    error: float
    vectors: Array

    @classmethod
    def of(cls, curve: EquilibriumCurve) -> DemLaw:
        """The law of an adhesive curve; InputError where it is none of one branch."""
        stiff, soft = (stability_under(curve, stiffness) for stiffness in (DISPLACEMENT_CONTROL, LOAD_CONTROL))
        if isinstance(stiff.pull_off, Unknown):
            raise InputError(f"tear-off under displacement control is needed: {stiff.pull_off}")
        if stiff.partial:
            raise InputError(
                f"contact shrinks by {counted(len(stiff.partial), 'jump')} before it is lost: no law of one branch"
            )
        if isinstance(stiff.jump_in, Unknown):
            raise InputError(f"the state after first touch is needed: {stiff.jump_in}")
        load = None if isinstance(soft.pull_off, Unknown) else soft.pull_off
        for rows in ((DEM_FEWEST - 1) * 2**step + 1 for step in range(MOST_SOLVES)):
            delta, P, a = stable_branch(curve, stiff.pull_off, np.linspace(0, 1, rows))
            between = (np.arange(rows - 1) + 0.5) / (rows - 1)
            exact = stable_branch(curve, stiff.pull_off, between)
            error = max(float(np.abs(interpolated(column, between) - values).max() / np.abs(values).max())
                        for column, values in zip((P, a), exact[1:], strict=True))  # fmt: skip
            if error <= DEM_ERROR:
                break
        else:
            raise InputError(f"{rows} rows meet the law within {error:.1g} only: give a solution of more radii")
        chosen = np.linspace(0, between.size - 1, 12).round().astype(int)
        return cls(delta, P, a, stiff.pull_off, load, stiff.jump_in, error, np.column_stack(exact)[chosen])


def interpolated(column: Array, x: Array) -> Array:
    """The column of rows at equal steps of x in 0 ... 1 at ``x`` (n,), by the cubic through the four next rows."""
    last = len(column) - 1
    first = np.clip(np.floor(x * last).astype(int) - 1, 0, last - 3)
    s = x * last - first
    weights = (
        -(s - 1) * (s - 2) * (s - 3) / 6,
        s * (s - 2) * (s - 3) / 2,
        -s * (s - 1) * (s - 3) / 2,
        s * (s - 1) * (s - 2) / 6,
    )
    return np.asarray(sum(weight * column[first + i] for i, weight in enumerate(weights)))


def stable_branch(curve: EquilibriumCurve, tear_off: CriticalPoint, x: Array) -> tuple[Array, Array, Array]:
    """delta, P and a of the stable branch at fractions ``x`` of sqrt(delta - delta_tear)."""
    first, last = tear_off.place, curve.places[-1]
    span = curve.at(last)[0] - tear_off.delta
    delta = tear_off.delta + span * x**2
    ends = np.full_like(x, first), np.full_like(x, last)
    places = np.where(x == 0, first, zeros_between(lambda place: curve.at(place)[0] - delta, *ends, 0.0))
    return delta, curve.at(places)[1], curve.contact_radii(places)
