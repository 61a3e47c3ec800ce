"""States of the bodies and meshes as results, and what finite elements need of a machine."""

from __future__ import annotations

import importlib
from dataclasses import dataclass
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import TYPE_CHECKING, Any, cast

import numpy as np

from ..adhesion import device_path
from ..adhesion.contact_shape import refuse_no_disc
from ..base.errors import LEVEL
from ..base.numerics import ROUNDED, Array
from ..base.registry import Result
from ..base.units import show
from ..case.models import Case, method_of
from ..report.check import Finding
from ..report.result import Figure
from ..report.tables import format_state, quantities
from ..resolve.analysis import Analysis, analyse
from ..series import Solution
from .mesh import SYSTEM_PACKAGES, Grid, how_to_install, write_vtu
from .solver import FEM

if TYPE_CHECKING:
    from .fields import ContactState

# --------------------------------------------------------------------------------------------------
# Pressure and shape of the surface, displacement and stress in the body, at one state of contact.

FIELD_COLUMNS = {"r": "r_m", "zz": "sigma_zz_Pa", "rz": "sigma_rz_Pa", "zz_error": "sigma_zz_err_Pa",
           "rz_error": "sigma_rz_err_Pa", "area": "ring_area_m2"}  # fmt: skip


def method_for(solution: Solution) -> FEM:
    """The finite elements for fields in the body of ``solution``: those that made it, or as its case says."""
    refuse_no_disc(solution.facts, "fields")
    case = solution.record.case
    made = solution.solver if solution.method == "fem" else None
    return cast(FEM, made or (method_of(case.model, "fem") if isinstance(case, Case) else FEM()))


def surface_columns(solution: Solution, a: float, w: float) -> dict[str, Array]:
    """Pressure at the nodes inside, displacement and gap at the vertices from the edge out to 3 a, by finite elements;
    where the surfaces stick, shear too, outwards positive."""
    from .fields import STATE_ORDER, contact_state

    curve = analyse(solution, [w])[0].curve
    delta, _ = (float(value) for value in curve.at(np.array(a)))
    state = contact_state(method_for(solution), solution.problem, a, delta)
    points, line = state.grid.points, state.lines["surface"]
    beyond = np.flatnonzero((np.abs(points[:, 1]) <= 1e-12 * a) & (a <= points[:, 0]) & (points[:, 0] <= 3 * a))
    beyond = beyond[np.argsort(points[beyond, 0], kind="stable")][::STATE_ORDER]  # the elements' vertices
    inside = line.r < a * (1 - ROUNDED)
    r, none = np.concatenate([line.r[inside], points[beyond, 0]]), np.zeros(beyond.size)
    f, lower = solution.problem.indenter.f(r), -state.displacement[beyond, 1]
    displacement = np.concatenate([(delta - f)[: -none.size], lower])
    shear = {"shear_Pa": np.concatenate([line.rz[inside], none])} if solution.problem.sticks else {}
    return {
        "r_m": r,
        "pressure_Pa": np.concatenate([-line.zz[inside], none]),
        **shear,
        "displacement_m": displacement,
        "gap_m": np.where(r < a, 0.0, f - delta + displacement),
    }


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
        from .fields import contact_state

        if a is None:
            assert load is not None
            a = device_path.stable_radius(curve.curve, load)
        delta, P = (float(value) for value in curve.curve.at(np.array(a)))
        # What an elastic indenter leaves of the displacement on a layered body, from the pressures of method layered;
        # None where it is rigid, or acts by the modulus alone
        surface, at = None, a
        if curve.problem.indenter.material is not None and not curve.problem.is_half_space:
            from ..methods.layered.solver import surface_profile

            def surface(r: Array) -> Array:
                return surface_profile(curve.problem, at, curve.w, r_surface=r).displacement

        state = contact_state(method, curve.problem, a, delta, surface)
        return cls(curve, P if load is None else load, state, component)  # but for round-off

    @property
    def columns(self) -> dict[str, Array]:  # type: ignore[override]
        """One row for each point of each line."""
        lines = self.state.lines.items()
        return {
            "line": np.concatenate([np.full(line.r.size, name) for name, line in lines]),
            "depth_m": np.concatenate([np.full(line.r.size, line.depth) for _, line in lines]),
            **{
                column: np.concatenate([getattr(line, key) for _, line in lines])
                for key, column in FIELD_COLUMNS.items()
            },
            "level": np.full(sum(line.r.size for _, line in lines), LEVEL),
        }

    def summary(self) -> dict[str, Any]:
        state = self.state
        return {
            "file": str(self.curve.path),
            "level": LEVEL,
            **quantities(state, "a"),
            **quantities(self.curve, "w"),
            **quantities(state, "delta P"),
            "P_series_N": self.P,
            "difference": abs(state.P - self.P) / state.lines["surface"].size,
            "elements": len(state.grid.cells),
            "interpolation_error": dict(state.interpolation_error),
            "lines": {
                name: {"depth_m": line.depth, "load_N": line.load, "imbalance": state.imbalance[name],
                       "error": state.error[name]}
                for name, line in state.lines.items()
            },
        }  # fmt: skip

    def words(self) -> list[str]:
        state, summary = self.state, self.summary()
        mises, r, depth = state.largest_mises
        return [
            f"{format_state(state, 'P a delta')}, w = {show(self.curve.w, 'work')}: {self.curve.path}",
            f"  load         of the solution {show(self.P, 'load')}: differs by {summary['difference']:.0e} of the "
            f"contact forces; {summary['elements']} quadratic triangles",
            f"  von Mises    at most {show(mises, 'modulus')} (a/20 off the edge), at r = {show(r, 'length')}, depth "
            f"{show(depth, 'length')}",
            f"  fields       interpolation error within {state.interpolation_error['displacement']:.0e} of the largest "
            f"displacement, {state.interpolation_error['von_mises']:.0e} of the largest von Mises stress (r < 3 a, "
            "a/20 off the edge)",
            *(
                f"  {name:<12} carries {show(line['load_N'], 'load'):<10} (balance within {abs(line['imbalance']):.0e})"
                f"; mean error of the tractions {line['error']:.0e}"
                for name, line in summary["lines"].items()
            ),
        ]

    def figure(self) -> Figure:
        from .figures import contact_zone_figure

        return contact_zone_figure(self.state, self.curve.problem.indenter, self.curve.w, self.component)

    def write_vtu(self, target: Path, mark: str = "") -> None:
        """Displacement and stresses at the nodes of quadratic triangles for ParaView, with the errors of what is
        interpolated in each of these, and ``mark`` behind it."""
        state, names = self.state, [f"sigma_{name}" for name in ("rr", "tt", "zz", "rz")]
        data = {"displacement_m": np.column_stack([state.displacement, np.zeros(len(state.displacement))])}
        data |= {f"{name}_Pa": values for name, values in zip(names, state.stress, strict=True)}
        data |= {"von_mises_Pa": state.mises}
        errors = {"displacement_err_m": np.hypot(*state.errors["displacement"].T)}
        errors |= {f"{name}_err_Pa": values for name, values in zip(names, state.errors["stress"].T, strict=True)}
        errors |= {"von_mises_err_Pa": state.errors["mises"]}
        write_vtu(state.grid, target, data, errors, state.middles)
        with target.open("a") as file:
            file.write(mark)


# --------------------------------------------------------------------------------------------------
# The finite-element mesh of a case as a result: its size and quality, its picture.


@dataclass(frozen=True, eq=False)
class Meshed(Result):
    """The ``mesh`` of the case in ``file``, fine within the ``reach`` [m] of the expected contact."""

    file: Path
    mesh: Grid
    reach: float

    def summary(self) -> dict[str, Any]:
        mesh, quality = self.mesh, self.mesh.quality()
        return {
            "file": str(self.file),
            "element": mesh.element,
            "elements": len(mesh.cells),
            "vertices": len(mesh.points),
            "r_m": mesh.width,
            "depth_m": mesh.depth,
            "reach_m": self.reach,
            "vertices_within_reach": int(np.sum(mesh.surface_radii() <= self.reach)),
            "quality": {
                "least": float(quality.min()),
                "median": float(np.median(quality)),
                "greatest": float(quality.max()),
            },
        }

    def words(self) -> list[str]:
        summary = self.summary()
        low, middle, high = (summary["quality"][name] for name in ("least", "median", "greatest"))
        return [
            f"{summary['elements']} {summary['element']}s, {summary['vertices']} vertices: {self.file}",
            f"  body      r <= {show(summary['r_m'], 'length')}, depth {show(summary['depth_m'], 'length')}; "
            f"{summary['vertices_within_reach']} surface vertices within the expected contact of "
            f"{show(self.reach, 'length')}",
            f"  quality   {low:.3f} to {high:.3f}, median {middle:.3f} (1 is best)",
        ]

    def figure(self) -> Figure:
        from .figures import mesh_figure

        return mesh_figure(self.mesh, self.reach)


def mesher() -> Finding:
    """gmsh is installed as a package but needs libraries of the system, which only loading it tells."""
    try:
        importlib.import_module("gmsh")
        return Finding("gmsh", "ok", version("gmsh"))
    except PackageNotFoundError:
        return Finding("gmsh", "ok", "from the system")
    except ImportError:
        return Finding("gmsh", "optional", "not installed (finite elements)", how_to_install())
    except OSError as error:
        remedy = f"sudo apt-get install --no-install-recommends {SYSTEM_PACKAGES}"
        return Finding("gmsh", "missing", f"cannot load: {error}; methods without a mesh work", remedy)
