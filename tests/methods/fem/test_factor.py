"""Sparse factors: both libraries give the same numbers, and say what they cannot do."""

import numpy as np
import pytest
from conftest import refused_by
from scipy.sparse import csc_matrix, diags

from jkrcli.base.errors import SolveError, installs
from jkrcli.base.process import StageClock
from jkrcli.bodies.indenters import Paraboloid
from jkrcli.bodies.problem import Elastic, HalfSpace, Layer, Loading, Problem, Rigid, Specimen
from jkrcli.methods.fem import FEM, elasticity
from jkrcli.methods.fem.elasticity import sparse_factor
from jkrcli.methods.fem.model import Discretisation, Model, run

UNIT = Problem(Paraboloid(10.0), Specimen((), HalfSpace(Elastic(1.0, 0.3))), Loading("radius", 1.0))
GEL = Problem(Paraboloid(100.0), Specimen((Layer(Elastic(1.0, 0.5), 1.0),), Rigid()), Loading("radius", 1.0))
QUICK = {"estimate_error": False, "edge_correction": False, "spacing": 0.1, "growth": 0.3}


def chain(n: int) -> csc_matrix:
    """A positive definite tridiagonal matrix, diagonal 3, off-diagonals -1."""
    return csc_matrix(diags([-np.ones(n - 1), 3 * np.ones(n), -np.ones(n - 1)], [-1, 0, 1]))


@pytest.mark.parametrize("solver", ["superlu", "cholmod"])
def test_the_root_is_that_of_the_condensed_matrix(solver: str) -> None:
    if solver == "cholmod":
        pytest.importorskip("cvxopt")
    A = chain(40)
    found = sparse_factor(A, 7, True, solver)  # type: ignore[arg-type]
    condensed = np.linalg.inv(np.linalg.inv(A.toarray())[-7:, -7:])
    np.testing.assert_allclose(found.root @ found.root.T, condensed, rtol=1e-13, atol=1e-14)  # entries of order one
    b = np.linspace(1, 2, 40)
    np.testing.assert_allclose(A @ found.solve(b), b, rtol=1e-13)
    assert found.entries >= 79  # the two diagonals of the factor


def test_both_libraries_give_the_same_surface() -> None:
    pytest.importorskip("cvxopt")
    method = FEM(**QUICK)
    reach = method.reach(UNIT)
    models: dict[str, Model] = {}
    for solver in ("superlu", "cholmod"):
        layout = run(method, UNIT, StageClock()).level.model.discretisation.layout
        models[solver] = Discretisation(layout, 2, (), reach, solver).build(StageClock())  # type: ignore[arg-type]
    C = [model.surface.C for model in models.values()]
    np.testing.assert_allclose(C[0], C[1], rtol=1e-12, atol=1e-12 * C[0].max())
    assert [model.factor.factor.name for model in models.values()] == ["SuperLU", "CHOLMOD"]
    assert models["cholmod"].surface.residual < 1e-12


def test_the_solver_is_recorded_and_saddle_points_stay_with_scipy() -> None:
    pytest.importorskip("cvxopt")
    assert FEM(solver="cholmod", **QUICK)(UNIT).facts["solver"].startswith("CHOLMOD")
    assert FEM(solver="superlu", **QUICK)(UNIT).facts["solver"].startswith("SuperLU")
    assert FEM(solver="cholmod", **QUICK)(GEL).facts["solver"].startswith("SuperLU")


def test_cholmod_leaves_its_options_as_they_were() -> None:
    cholmod = pytest.importorskip("cvxopt.cholmod")
    before = dict(cholmod.options)
    sparse_factor(chain(5), 2, True, "cholmod")
    assert cholmod.options == before


@pytest.mark.parametrize(
    ("solver", "message"),
    [
        ("superlu", "factorisation: the condensed stiffness is not positive"),
        ("cholmod", "factorisation: the stiffness is not"),
    ],
)
def test_an_indefinite_matrix_is_found(solver: str, message: str) -> None:
    if solver == "cholmod":
        pytest.importorskip("cvxopt")
    A = chain(6).tolil()
    A[5, 5] = -1.0
    with pytest.raises(SolveError, match=message):
        sparse_factor(A.tocsc(), 2, True, solver)  # type: ignore[arg-type]


def test_a_missing_library_is_one_line(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(elasticity, "has_cholmod", lambda: False)
    assert refused_by(sparse_factor, chain(5), 2, True, "cholmod") == (
        f'mesh.solver: "cholmod" needs the optional package cvxopt: {installs("fast")}',
    )
    assert sparse_factor(chain(5), 2, True, "auto").name == "SuperLU"


def test_auto_takes_cholmod_where_it_pays(tuned) -> None:
    pytest.importorskip("cvxopt")
    assert sparse_factor(chain(50), 2, True, "auto").name == "SuperLU"
    tuned("jkrcli.methods.fem.elasticity.FACTOR_SMALL", 10)
    assert sparse_factor(chain(50), 2, True, "auto").name == "CHOLMOD"
