"""One state of a contact as a result: pressure and shape of its surface, displacement and stress in the body."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ..adhesion import stable_radius
from ..base import Array, lists, show
from ..beside import Analysis
from .result import Figure, Result
from .tables import quantities, state_words

if TYPE_CHECKING:
    from ..methods import FEM, ContactState

COMPONENTS = ("zz", "rr", "tt", "rz", "mises")
COLUMNS = {"r": "r_m", "zz": "sigma_zz_Pa", "rz": "sigma_rz_Pa", "zz_error": "sigma_zz_err_Pa",
           "rz_error": "sigma_rz_err_Pa", "area": "ring_area_m2"}  # fmt: skip


@dataclass(frozen=True, eq=False)
class Profile(Result):
    """Pressure, displacement and gap over r around a contact of radius ``a`` [m] with ``w`` [J/m^2]."""

    path: Path
    a: float
    w: float
    columns: Mapping[str, Array]

    def summary(self) -> dict[str, Any]:
        return {"file": str(self.path), **quantities(self, "a w"), **lists(self.columns)}

    def words(self) -> list[str]:
        return [f"{state_words(self, 'a w')}: {self.path}"]

    def figure(self) -> Figure:
        from .plots.body import profile_figure

        return profile_figure(self.columns, self.a, self.w)


@dataclass(frozen=True, eq=False)
class Fields(Result):
    """A ``state`` of the bodies of a ``curve`` by finite elements; ``P`` [N]: the load of the series there;
    ``component``: of the stress in the picture."""

    curve: Analysis
    P: float
    state: ContactState
    component: str = "zz"

    @classmethod
    def of(
        cls, curve: Analysis, method: FEM, *, a: float | None = None, load: float | None = None, component: str = "zz"
    ) -> Fields:
        """The state at the contact radius ``a`` [m], or at a ``load`` [N] on the stable branch."""
        from ..methods import contact_state

        if a is None:
            assert load is not None
            a = stable_radius(curve.curve, load)
        delta, P = (float(value) for value in curve.curve.at(np.array(a)))
        state = contact_state(method, curve.problem, a, delta, _surface(curve, a))
        return cls(curve, P if load is None else load, state, component)  # but for round-off

    @property
    def columns(self) -> dict[str, Array]:  # type: ignore[override]
        """One row for each point of each line."""
        lines = self.state.lines.items()
        return {
            "line": np.concatenate([np.full(line.r.size, name) for name, line in lines]),
            "depth_m": np.concatenate([np.full(line.r.size, line.depth) for _, line in lines]),
            **{column: np.concatenate([getattr(line, key) for _, line in lines]) for key, column in COLUMNS.items()},
        }

    def summary(self) -> dict[str, Any]:
        state = self.state
        return {
            "file": str(self.curve.path),
            **quantities(state, "a"),
            **quantities(self.curve, "w"),
            **quantities(state, "delta P"),
            "P_series_N": self.P,
            "difference": abs(state.P - self.P) / state.lines["surface"].size,
            "elements": len(state.grid.cells),
            "lines": {
                name: {"depth_m": line.depth, "load_N": line.load, "imbalance": state.imbalance[name],
                       "error": state.error[name]}
                for name, line in state.lines.items()
            },
        }  # fmt: skip

    def words(self) -> list[str]:
        state, summary = self.state, self.summary()
        return [
            f"{state_words(state, 'P a delta')}, w = {show(self.curve.w, 'work')}: {self.curve.path}",
            f"  load         of the series {show(self.P, 'load')}: {summary['difference']:.0e} of the forces in the "
            f"contact apart; {summary['elements']} elements",
            *(
                f"  {name:<12} carries {show(line['load_N'], 'load'):<10} (balance within {abs(line['imbalance']):.0e})"
                f"; tractions good to {line['error']:.0e} on average"
                for name, line in summary["lines"].items()
            ),
        ]

    def figure(self) -> Figure:
        from .plots.body import contact_zone_figure

        return contact_zone_figure(self.state, self.curve.problem.indenter, self.curve.w, self.component)

    def write_vtu(self, target: Path, mark: str = "") -> None:
        """Displacement and stresses at all nodes for ParaView, with ``mark`` behind it."""
        from ..methods import write_vtu

        state = self.state
        stress = zip(("rr", "tt", "zz", "rz"), state.stress, strict=True)
        data = {"displacement_m": np.column_stack([state.displacement, np.zeros(len(state.displacement))])}
        data |= {f"sigma_{name}_Pa": values for name, values in stress}
        write_vtu(state.grid, target, data | {"von_mises_Pa": state.mises})
        with target.open("a") as file:
            file.write(mark)


def _surface(curve: Analysis, a: float) -> Callable[[Array], Array] | None:
    """What an elastic indenter leaves of the displacement on a layered body, from the pressures of method layered; None
    where it is rigid, or acts by the modulus alone."""
    from ..methods import surface_profile

    problem = curve.problem
    if problem.indenter.material is None or problem.is_half_space:
        return None
    return lambda r: surface_profile(problem, a, curve.w, r_surface=r).displacement
