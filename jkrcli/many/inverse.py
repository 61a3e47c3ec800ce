"""The inverse question: which value of a number of the case gives a wanted pull-off force.

The pull-off force F is a smooth function of any one number x of a case, often nearly a power of it, but it need not be
monotone: on a coated body it is not over the tip's radius. So F is computed at ``FIND_SCAN`` values over the bounds,
and wherever ln(F/F_wanted) changes its sign lies a root, found to ``FIND_EXACT`` by Brent's method. Roots nearer to
each other than the scan's step are not seen.
"""

from __future__ import annotations

import contextlib
import inspect
import itertools
import math
import time
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from ..adhesion.curve import LOAD_CONTROL, control
from ..adhesion.finite_range import RangeRequest
from ..base.arguments import checked
from ..base.errors import Estimate, InputError, JkrError, Unknown, did_you_mean, known
from ..base.numerics import ROWS, Array
from ..base.registry import Result
from ..base.units import Control, Force, show
from ..bodies.problem import BASE, Loading, layer_names
from ..case.models import CaseModel, load_case, model_of
from ..cli.options import begin
from ..methods.layered.solver import Layered
from ..methods.protocol import Forecast, Limits
from ..report.tables import transpose_rows
from ..resolve.analysis import where_lost
from ..resolve.neglected import LEFT_OUT_ACCURACY
from ..resolve.reach import solved_for

FIND_SCAN, FIND_STEPS = 25, 12  # choice: values over the bounds; evaluations for each root at most
FIND_EXACT = 1e-9  # theory: of the logs, far below any error of the force
FIND_JUMP = 1e-6  # choice: of ln(F/F_wanted), beyond which a change of sign is no solution
FIND_WITHIN = 30.0  # choice: factor about the case's own value, within which is looked where no bounds are told
DIMENSIONS = {"m": "length", "Pa": "modulus", "J_per_m2": "work", "rad": "angle"}  # of the keys of cases


@dataclass(frozen=True)
class Root:
    """A ``value`` of the key that gives the ``force`` [N], and its half-width, by that of the force."""

    value: float
    force: float
    error: Estimate


@dataclass(frozen=True, eq=False)
class FoundValues(Result):
    """The ``roots`` of a ``key`` of the case in ``file``, in SI by its ``unit``, which give the pull-off force ``load``
    [N] under a device of ``stiffness`` [N/m]; what was looked at: ``values`` and their ``forces``, nan where the case
    has none, and why, ``left_out``."""

    file: Path
    key: str
    unit: str
    load: float
    stiffness: float
    roots: Sequence[Root]
    values: Array
    forces: Array
    left_out: str

    @property
    def columns(self) -> dict[str, list[Any]]:  # type: ignore[override]
        name = f"{self.key}_{self.unit}" if self.unit else self.key
        return transpose_rows(
            [{name: root.value, "pull_off_N": root.force, "error": known(root.error)} for root in self.roots]
        )

    def summary(self) -> dict[str, Any]:
        return {
            "file": str(self.file), "key": self.key, "unit": self.unit, "load_N": self.load,
            "stiffness_N_per_m": self.stiffness if math.isfinite(self.stiffness) else None,
            "solutions": [{"value": root.value, "error": known(root.error)} for root in self.roots],
            "scan": {"values": self.values.tolist(),
                     "pull_off_N": [force if math.isfinite(force) else None for force in self.forces]},
        }  # fmt: skip

    def words(self) -> list[str]:
        each = [f"{self.key} = {self._words(root.value)}" for root in self.roots]
        several = f"{len(each)} solutions: " if len(each) > 1 else ""
        low, high = (self._words(value) for value in self.values[[0, -1]].tolist())
        forces = " to ".join(show(float(end(self.forces)), "load", 4) for end in (np.nanmin, np.nanmax))
        # The largest relative error of the solutions, by that of the force
        errors = [math.nan if isinstance(root.error, Unknown) else root.error / abs(root.value) for root in self.roots]
        exact = f"; numerical error {max(errors):.1g}" if np.isfinite(errors).all() and errors else ""
        seen = f"{self.left_out}{exact}; solutions nearer to each other than {self.step} are not seen"
        return [
            f"{several}{'; '.join(each)}: {self.file} under {control(self.stiffness)}",
            f"  {self.values.size} values from {low} to {high} give {forces}{seen}",
        ]

    def _words(self, value: float) -> str:
        return show(value, DIMENSIONS.get(self.unit, "number"), 6)

    @property
    def step(self) -> str:
        """From one value to the next, in words."""
        if self.values[0] <= 0:
            return f"{self.values[1] - self.values[0]:.3g}"
        return f"a factor {self.values[1] / self.values[0]:.3g}"


@checked
def find_value(
    file: str | Path, key: str, load: Force | Any, bounds: tuple[Any, Any] | None = None,
    stiffness: Control | Any = LOAD_CONTROL, slopes: str = "auto", limits: Limits | None = None,
) -> FoundValues:  # fmt: skip
    """Find the values of a number of a case that give a pull-off force.

    Parameters
    ----------
    file : path
        A case file with one work of adhesion.
    key : str
        Of a number in it, such as "indenter.radius" or "specimen.layers[0].thickness", or its short name: "R", "w",
        "h:skin", "E:skin" and "nu:skin" of the layer "skin", "E:base" of the half-space.
    load : float or str
        The pull-off force [N].
    bounds : (low, high), optional
        Between which is looked, numbers or texts with units; by default a factor 30 about the case's own value.
    stiffness : float or str, optional
        Of the device [N/m]; 0, the default, under load control.
    slopes : str, optional
        As of ``transform``.
    limits : Limits, optional
        Of CPU time; by default one hour.

    Returns
    -------
    FoundValues
        All solutions, the least first.

    Raises
    ------
    Refusal
        Where it would cost more than the limits.
    InputError
        Where the key is no number of the case, or no value gives that force: the forces that there are.
    """
    from .sweep_plan import unit_of, value_at, with_values

    file = Path(file)
    tables = load_case(file).model.model_dump(exclude_none=True)

    def model_at(value: Any) -> CaseModel:
        return model_of(with_values(tables, {key: value}), str(file), file.parent)

    def si(value: Any) -> float:
        return float(value_at(model_at(value), key))

    here, case = None, model_of(tables, str(file), file.parent)
    names = short_names(case)
    key = names.get(key, key)
    with contextlib.suppress(KeyError, IndexError, TypeError, InputError):
        here = value_at(case, key)
    if isinstance(here, bool) or not isinstance(here, int | float):
        raise InputError(
            f"--find: {key} is no number of {file}{did_you_mean(key, [*names, *names.values()])}; allowed are "
            f"{', '.join(names)}, and keys such as {list(names.values())[-1]}"
        )
    ends = (here / FIND_WITHIN, here * FIND_WITHIN) if bounds is None else tuple(map(si, bounds))
    low, high = ends
    if not low < high:
        raise InputError(f"--find: {key} needs bounds LOW..HIGH that rise, got {low:g}..{high:g}")
    log = low > 0
    spread = np.geomspace(low, high, FIND_SCAN) if log else np.linspace(low, high, FIND_SCAN)
    known_at, refused = dict[float, tuple[float, Estimate]](), list[str]()

    def excess(x: float) -> float:
        """ln(F/F_wanted) at a value, nan where the case has no pull-off or is none."""
        if x not in known_at:
            try:
                model = model_at(x)
                works = model.adhesion.w
                if len(works) != 1 or not works[0] > 0:
                    raise InputError("one w > 0 is needed under [adhesion]")
                solution = solved_for(model.problem(), works, slopes)
                ((behaviour, error),) = where_lost(solution, works, [stiffness], slopes, 1.0, RangeRequest())[0][1]
                lost = behaviour.pull_off
                if isinstance(lost, Unknown) or lost.P >= 0:
                    raise InputError(lost.reason if isinstance(lost, Unknown) else "nothing pulls")
                size: Estimate = Unknown("unknown")
                if error is not None and not isinstance(error, Unknown):
                    size = error["P"] / -lost.P
                known_at[x] = -lost.P, size
            except JkrError as reason:
                refused.append(str(reason))
                return math.nan
        return math.log(known_at[x][0] / load)

    def seconds(x: float) -> float:
        """CPU seconds of a value: forecast where the body is solved to its rim, whatever w is, else what it takes."""
        began = time.process_time()
        with contextlib.suppress(JkrError):
            problem = model_at(x).problem()
            if (rim := problem.indenter.rim) < math.inf and problem.layers:
                body = replace(problem, loading=Loading("radius", rim, ROWS, "log"))
                return 2 * Layered(LEFT_OUT_ACCURACY).forecast(body).seconds  # solved coarsely, then for its pull-off
        excess(x)
        return time.process_time() - began

    # What all values cost, geometrically between the ends where only those are known
    each = 1 if case.problem().indenter.rim < math.inf and case.problem().layers else FIND_SCAN - 1
    costs = np.log([seconds(x) for x in spread[::each].tolist()])
    total = np.exp(np.interp(np.arange(FIND_SCAN), np.arange(0, FIND_SCAN, each), costs)).sum()
    cost = Forecast(float(total), 0.0, 0.0)
    begin(f"pull-off of {FIND_SCAN} values of {key}", cost, limits or Limits(), "narrower bounds, KEY=LOW..HIGH")
    scanned = [excess(x) for x in spread.tolist()]
    if not np.isfinite(scanned).any():
        raise InputError(refused[0])

    from scipy.optimize import brentq

    # A root between each two neighbours of opposite sign, in ln x where x is positive
    to, back = (math.log, math.exp) if log else (float, float)
    roots = list[Root]()
    for (x, f), (y, g) in itertools.pairwise(zip([*spread.tolist(), math.inf], [*scanned, math.nan], strict=True)):
        if f * g < 0 or f == 0:
            # by Brent's method, in ``FIND_STEPS`` at most
            value = x if f == 0 else back(brentq(
                lambda u: excess(back(u)), to(x), to(y), xtol=FIND_EXACT, rtol=4 * np.finfo(float).eps,
                maxiter=FIND_STEPS, full_output=True, disp=False,
            )[0])  # fmt: skip
            if not abs(excess(value)) < FIND_JUMP:  # the force jumps there, or the case has none
                refused.append(f"the force jumps, or ends, near {value:.6g}")
                continue
            (force, error), slope = known_at[value], (g - f) / (y - x)
            within = error if isinstance(error, Unknown) else error / abs(slope or math.nan)
            roots.append(Root(value, force, within))
    forces = load * np.exp(scanned)
    lost = int(np.count_nonzero(np.isnan(forces)))
    left_out = f" (not {lost} of them: {refused[0]})" if lost else "; ".join(["", *refused[-1:]])
    found = FoundValues(
        file, key, unit_of(tables, key, here, file.parent), load, stiffness, roots, spread, forces, left_out
    )
    if not roots:
        wanted, looked = show(load, "load", 4), found.words()[1].strip()
        raise InputError(f"{file}: no {key} gives a pull-off force of {wanted}: {looked}; give other bounds, "
                         f"{key}=LOW..HIGH")  # fmt: skip
    return found


def short_names(case: CaseModel) -> dict[str, str]:
    """Keys of a case by the names that fits give to its numbers: "R", "w", "h:skin", "E:base"; without the layer's
    name where one part alone is meant."""
    specimen = case.problem().specimen
    parts = [f"specimen.layers[{i}]" for i in range(len(specimen.layers))] + ["specimen.half_space"]
    names = {"R": "indenter.radius", "w": "adhesion.w"}
    for name, part in zip(layer_names(specimen), parts, strict=False):  # a rigid substrate has none
        symbols = {"E": "E", "nu": "nu"} if name == BASE else {"h": "thickness", "E": "E", "nu": "nu"}
        names |= {f"{symbol}:{name}": f"{part}.{key}" for symbol, key in symbols.items()}
    if len({name.partition(":")[2] for name in names}) == 2:  # of nothing, and of the one part
        names = {name.partition(":")[0]: key for name, key in names.items()} | names
    return names


def find_by_words(
    files: Sequence[Path], sought: str, load: float | None, works: Sequence[float], stiffnesses: Sequence[float],
    slopes: str, limits: Limits,
) -> FoundValues:  # fmt: skip
    """What ``pull-off --find`` asks for."""
    if load is None:
        raise InputError('pull-off: --find needs the pull-off force that is wanted, such as --load "5 uN"')
    if len(files) != 1 or files[0].suffix != ".toml":
        raise InputError("pull-off: --find needs one case file (.toml)")
    if works or len(stiffnesses) > 1:
        raise InputError("pull-off: --find takes w from the case, and one --stiffness")
    key, _, bounds = sought.partition("=")
    low, dots, high = bounds.partition("..")
    if bounds and not dots:
        raise InputError(f"--find: must be KEY or KEY=LOW..HIGH, got {sought}; the force that is wanted is --load")
    unchecked: Any = inspect.unwrap(find_value)  # whose messages name options
    return unchecked(files[0], key, abs(load), (low.strip(), high.strip()) if bounds else None,
                     stiffnesses[0] if stiffnesses else LOAD_CONTROL, slopes, limits)  # fmt: skip
