"""An adhesive contact as a fit model of nanite and PyJibe: JKR of a layered body, which fits E and w there."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass
from functools import cached_property
from importlib import resources
from string import Template
from typing import Any

import numpy as np

from .. import __version__
from ..adhesion.dem import DemLaw
from ..base.errors import InputError
from ..base.numerics import Array
from ..base.result import Result
from ..base.units import show
from ..bodies.indenters import Paraboloid
from ..resolve.analysis import Analysis

CODE = Template(resources.files(__package__).joinpath("nanite.txt").read_text(encoding="utf-8"))
NANITE_ROWS = 129  # tuned on halfspace, gel and coating: the file meets the curve within 5e-6
NANITE_FINE = 8192  # theory: linear between them errs by the square of their distance in log a, below 1e-6
HALF_SPACE_FURTHER = 100.0  # choice: times the last radius, beyond which no half-space of a record is loaded
NANITE_ERROR = 1e-4  # choice: of the largest force, a tenth of what a fit in nanite can tell


def model_name(stem: str) -> str:
    """Return the key of a model after the ``stem`` of a file: what may be the name of a module."""
    return "jkr_" + (re.sub("[^a-z0-9]+", "_", stem.lower()).strip("_") or "model")


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
        elif problem.indenter.a0:
            why = "a flat end, whose contact does not begin at a point"
        if why:
            raise InputError(f"{result.path}: export --nanite does not represent {why}")
        try:
            DemLaw.of(result.curve)
        except InputError as error:
            raise InputError(f"{result.path}: {error}") from None
        made = cls(result, name)
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

    @cached_property
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

    @cached_property
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
        return CODE.substitute(
            version=__version__, body=body, words=f"JKR, {body}", modulus=modulus, ratios=ratios, reach=reach,
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
