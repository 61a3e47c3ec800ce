"""The parts of the hybrid: fields of the half-space, line elements, the stiffness, and intervals."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose

from jkrcli.bodies.problem import Elastic, Layer, Rigid, Specimen
from jkrcli.hybrid.correction import LineElements, Mesh, Region, RingField, lines

T = np.array([0.2, 0.7])
STEP = 1e-5


def field(r: float, z: float, nu: float) -> RingField:
    return RingField.at(np.array([r]), np.array([z]), T, nu)


def slopes(name: str, r: float, z: float, nu: float) -> tuple[np.ndarray, np.ndarray]:
    along_r = getattr(field(r + STEP, z, nu), name) - getattr(field(r - STEP, z, nu), name)
    along_z = getattr(field(r, z + STEP, nu), name) - getattr(field(r, z - STEP, nu), name)
    return along_r / (2 * STEP), along_z / (2 * STEP)


@pytest.mark.parametrize("nu", [0.0, 0.3, 0.5])
@pytest.mark.parametrize(("r", "z"), [(0.4, 0.6), (1.5, 0.3), (0.05, 1.0)])
def test_strains_and_balance_of_the_half_space(r: float, z: float, nu: float) -> None:
    """Differences of step 1e-5 are good to 1e-8 of fields whose lengths are of order one."""
    f = field(r, z, nu)
    (r_r, r_z), (z_r, z_z) = slopes("u_r", r, z, nu), slopes("u_z", r, z, nu)
    for strain, expected in zip(f.strains, (r_r, f.u_r / r, z_z, r_z + z_r), strict=True):
        assert_allclose(strain, expected, rtol=1e-6, atol=1e-7)
    (rr_r, _), (rz_r, rz_z), (_, zz_z) = (slopes(name, r, z, nu) for name in ("s_rr", "s_rz", "s_zz"))
    assert_allclose(rr_r + rz_z + (f.s_rr - f.s_tt) / r, 0, atol=1e-6)
    assert_allclose(rz_r + zz_z + f.s_rz / r, 0, atol=1e-6)
    assert_allclose(f.p, -nu / (1 + nu) * (f.s_rr + f.s_tt + f.s_zz), atol=1e-12)


def test_the_surface_of_the_half_space() -> None:
    """u_z = 1/sqrt(r^2 - t^2) outside the ring and 0 inside; pressed there by -(E*/2) t/(t^2 - r^2)^(3/2)."""
    r = np.array([0.1, 0.5, 1.1])
    f = RingField.at(r, np.full(3, 1e-12), T, 0.3)
    outside = r > T[:, None]
    assert_allclose(f.u_z, np.where(outside, 1 / np.sqrt(np.abs(r**2 - T[:, None] ** 2)), 0), atol=1e-9)
    t, half = T[:, None], 0.5 / (1 - 0.3**2)
    assert_allclose(f.s_zz, np.where(outside, 0, half * t / np.abs(t**2 - r**2) ** 1.5), atol=1e-7)
    assert_allclose(f.s_rz, 0, atol=1e-8)


@settings(max_examples=25, deadline=None)
@given(st.lists(st.integers(1, 7), min_size=1, max_size=5), st.integers(0, 2**31))
def test_line_elements_reproduce_polynomials(degrees: list[int], seed: int) -> None:
    """Of the lowest degree on the line, their derivatives and integrals, at Gauss points and elsewhere."""
    random = np.random.default_rng(seed)
    line = LineElements(np.concatenate([[0.0], np.cumsum(random.uniform(0.2, 1.0, len(degrees)))]), np.array(degrees))
    polynomial = np.polynomial.Polynomial(random.normal(size=min(degrees) + 1))
    x, w = line.rule
    values, slope = line.basis
    nodal = polynomial(line.nodes)
    assert_allclose(values @ nodal, polynomial(x), atol=1e-10)
    assert_allclose(slope @ nodal, polynomial.deriv()(x), atol=1e-8)
    integral = polynomial.integ()
    assert w @ polynomial(x) == pytest.approx(integral(line.edges[-1]) - integral(0.0), abs=1e-10)
    elsewhere = np.sort(random.uniform(0, line.edges[-1], 5))
    joined = np.ones(len(degrees) - 1, dtype=bool)
    assert_allclose(line.at(elsewhere, joined)[0] @ nodal, polynomial(elsewhere), atol=1e-10)
    assert_allclose(line.at(x, joined)[2], line.pressure(joined), atol=1e-12)


def body(nu: float = 0.3, side: str | None = "free", layers: int = 1) -> Specimen:
    stack = tuple(Layer(Elastic(1.0 + i, nu), 1.0 / layers) for i in range(layers))
    return Specimen(stack, Rigid(), 2.0 if side else None, side)  # type: ignore[arg-type]


@pytest.mark.parametrize("nu", [0.3, 0.5])
def test_stiffness(nu: float) -> None:
    """Symmetric; rigid motion along the axis costs nothing; a uniform compression costs its energy."""
    region = Region.of(body(nu), 1.0, 1e-5)
    mesh = Mesh(region, *lines(region, 4))
    K = mesh.stiffness
    assert abs(K - K.T).max() < 1e-12
    _, z = np.meshgrid(mesh.r.nodes, mesh.z.nodes)
    rigid = np.zeros(K.shape[0])
    rigid[mesh.nodes : 2 * mesh.nodes] = 1.0
    assert_allclose(K @ rigid, 0, atol=1e-10)
    uniform = np.zeros(K.shape[0])
    uniform[mesh.nodes : 2 * mesh.nodes] = z.ravel()
    shear = 0.5 / (1 + nu)
    modulus = 2 * shear if nu == 0.5 else (1 - nu) / ((1 + nu) * (1 - 2 * nu))  # without the pressure's part
    assert uniform @ K @ uniform == pytest.approx(np.pi * 2.0**2 * modulus, rel=1e-12)


@pytest.mark.parametrize("nu", [0.3, 0.5])
def test_work_is_the_quadratic_form_of_the_stiffness(nu: float) -> None:
    region = Region.of(body(nu, layers=2), 1.0, 1e-5)
    mesh = Mesh(region, *lines(region, 4))
    U = np.random.default_rng(5).normal(size=(mesh.stiffness.shape[0], 3))
    work, moved = mesh.work(U)
    expected = U.T @ mesh.stiffness @ U
    assert_allclose(work, expected, rtol=1e-10)
    assert (np.abs(work - work.T) <= moved).all()
    assert (moved < 1e-11 * np.diag(expected).max()).all()
