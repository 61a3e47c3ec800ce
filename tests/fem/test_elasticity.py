"""Elasticity: states of uniform strain are exact on any mesh, rigid lift costs nothing, supports balance the load."""

import numpy as np
import pytest
from conftest import refused_by
from scipy.sparse import csc_matrix, diags

from jkrcli.base.errors import Refusal, SolveError, installs
from jkrcli.bodies.indenters import Paraboloid
from jkrcli.bodies.problem import Elastic, HalfSpace, Layer, Loading, Problem, Rigid, Specimen, TransverselyIsotropic
from jkrcli.fem import elasticity
from jkrcli.fem.elasticity import Boussinesq, TransversePointForce, assemble, condense, factorise, sparse_factor
from jkrcli.fem.mesh import MeshedBody, make_grid, ringed_quads, triangles
from jkrcli.fem.solver import FEM

HEIGHT, WIDTH = 1.5, 2.0
CASES = [
    (element, order, mixed)
    for element in ("triangle", "quadrilateral")
    for order in (1, 2)
    for mixed in ((), (0,))
    if not (order == 1 and mixed)
]


def system_of(grid, materials, order, mixed=(), bonded=True, side="free", reduced=False):
    held = MeshedBody((1.0,) * len(materials), tuple(materials), 1.0, bonded, side, cut_below=False, cut_beside=False)
    return assemble(grid, held, order, mixed, reduced)


def body(element):
    if element == "triangle":
        surface = np.array([0.0, 0.2, 0.7, 1.0, 1.6, WIDTH])
        return triangles(surface, HEIGHT, [], "0.3+0.1*x")
    r = np.array([0.0, 0.3, 0.5])
    return make_grid(*ringed_quads(r, r * 0.8, np.array([1.1, WIDTH]), np.array([0.9, HEIGHT])), np.array([]))


def displacement(system, radial, axial, pressure):
    """u_r = radial * r, u_z = axial * z, and a constant pressure."""
    r, z = system.nodes.T
    count = system.K.shape[0] - 2 * len(system.nodes)
    return np.concatenate([radial * r, axial * z, np.full(count, pressure)])


@pytest.mark.parametrize(("element", "order", "mixed"), CASES)
def test_uniform_strain_is_exact_on_any_mesh(element, order, mixed):
    material, radial, axial = Elastic(3.0, 0.35), 0.02, -0.05
    system = system_of(body(element), [material], order, mixed=mixed)
    lam, mu = material.lame, material.G
    dilatation = 2 * radial + axial
    u = displacement(system, radial, axial, -lam * dilatation)
    forces = system.K @ u
    r, z = system.nodes.T
    inside = (r > 0) & (r < WIDTH) & (z < 0) & (z > -HEIGHT)
    everywhere = np.concatenate([inside, (r < WIDTH) & (z < 0) & (z > -HEIGHT)])
    scale = np.abs(forces).max()
    N = len(system.nodes)
    assert np.abs(forces[: 2 * N][everywhere]).max() < 1e-13 * scale  # equilibrium inside, to round-off
    assert np.abs(forces[2 * N :]).max(initial=0.0) < 1e-13 * scale  # p = -lambda div u holds
    volume = np.pi * WIDTH**2 * HEIGHT
    energy = volume * (lam * dilatation**2 + 2 * mu * (2 * radial**2 + axial**2))
    assert u @ forces == pytest.approx(energy, rel=1e-12)
    sigma_zz = lam * dilatation + 2 * mu * axial
    assert forces[system.normal].sum() == pytest.approx(sigma_zz * np.pi * WIDTH**2, rel=1e-12)


@pytest.mark.parametrize(("element", "order", "mixed"), CASES)
@pytest.mark.parametrize("nu", [0.3, 0.4999])
def test_a_confined_cylinder_has_the_oedometer_stiffness(element, order, mixed, nu):
    """Roller sides and a sliding base: uniform axial strain; P = (lambda + 2 mu) area / height per displacement."""
    material = Elastic(2.0, nu)
    system = system_of(body(element), [material], order, bonded=False, side="roller", mixed=mixed)
    surface = condense(system, factorise(system, system.normal))
    forces = np.linalg.solve(surface.C, np.ones(surface.radii.size))
    expected = (material.lame + 2 * material.G) * np.pi * WIDTH**2 / HEIGHT
    assert forces.sum() == pytest.approx(expected, rel=1e-10)  # exact but for the condition of nu = 0.4999 (1e4)


def test_incompressible_layers_need_the_mixed_form():
    with pytest.raises(Refusal, match=r"nu: 0\.5 needs the mixed form"):
        system_of(body("triangle"), [Elastic(1.0, 0.5)], 2)


@pytest.mark.parametrize(("element", "order", "mixed"), CASES)
def test_condensation_agrees_with_full_solves_and_the_base_carries_the_load(element, order, mixed):
    system = system_of(body(element), [Elastic(3.0, 0.35)], order, mixed=mixed)
    n = 4
    factor = factorise(system, system.normal[:n])
    surface = condense(system, factor)
    loads = np.zeros(system.K.shape[0])
    loads[system.normal[2]] = -1.0
    u = factor.solve(loads)
    assert factor.residual(u, loads) < 1e-12
    np.testing.assert_allclose(-u[system.normal[:n]], surface.C[:, 2], rtol=1e-11)
    assert system.vertical_reaction(u) == pytest.approx(1.0, rel=1e-11)
    assert np.array_equal(surface.C, surface.C.T)
    assert np.linalg.eigvalsh(surface.C).min() > 0


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
    tuned("jkrcli.fem.elasticity.FACTOR_SMALL", 10)
    assert sparse_factor(chain(50), 2, True, "auto").name == "CHOLMOD"


TRANSVERSE = [
    TransverselyIsotropic(1.0, 3.0, 0.2, 0.3, 0.5), TransverselyIsotropic(5.0, 1.0, 0.2, 0.1, 3.0),
    TransverselyIsotropic(5.0, 1.0, 0.2, 0.1, 0.3),
]  # fmt: skip


def test_the_point_force_with_isotropic_constants_is_boussinesqs():
    r, z = np.array([0.0, 0.1, 1.0, 3.0]), np.array([-0.5, -1.0, -0.3, -2.0])
    force = TransversePointForce(TransverselyIsotropic(2.6, 2.6, 0.3, 0.3, 1.0))
    for found, exact in zip(force.displacement(r, z), Boussinesq(Elastic(2.6, 0.3)).displacement(r, z), strict=True):
        assert found == pytest.approx(exact, rel=1e-6)  # equal roots are taken 1e-4 apart
    for found, exact in zip(force.side_traction(r, z), Boussinesq(Elastic(2.6, 0.3)).side_traction(r, z), strict=True):
        assert found == pytest.approx(exact, rel=1e-5)


@pytest.mark.parametrize("material", TRANSVERSE)
def test_the_point_force_obeys_hookes_law_and_sinks_as_it_should(material):
    r, z, step = np.array([0.1, 1.0, 3.0]), np.array([-1.0, -0.3, -2.0]), 1e-5
    force = TransversePointForce(material)
    assert force.displacement(r, 0 * r)[1] * np.pi * material.E_star * r == pytest.approx(-np.ones(3), rel=1e-12)
    along_r = [np.subtract(*pair) / (2 * step) for pair in zip(
        force.displacement(r + step, z), force.displacement(r - step, z), strict=True)]  # fmt: skip
    along_z = [np.subtract(*pair) / (2 * step) for pair in zip(
        force.displacement(r, z + step), force.displacement(r, z - step), strict=True)]  # fmt: skip
    C11, C12, C13, _, C44 = material.stiffness
    s_rr = C11 * along_r[0] + C12 * force.displacement(r, z)[0] / r + C13 * along_z[1]
    s_rz = C44 * (along_z[0] + along_r[1])
    found = force.side_traction(r, z)
    assert found[0] == pytest.approx(s_rr, rel=1e-5, abs=1e-8)  # central differences
    assert found[1] == pytest.approx(s_rz, rel=1e-5, abs=1e-8)
