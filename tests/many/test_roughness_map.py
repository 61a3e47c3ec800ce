"""The map of w over the rms of roughness and the modulus, of a half-space and of a bonded film."""

import pytest

import jkrcli as jkr


def test_map_of_w_over_rms_and_modulus() -> None:
    columns = jkr.study_map("roughness", rms=["5 nm", "50 nm", "1 um"], modulus="1 MPa", w="5 mJ/m^2").columns
    specimen = jkr.Specimen((jkr.Layer(jkr.Elastic(E=1e6, nu=0.5), 1e-6),), jkr.Rigid(bonded=True))
    film = jkr.Problem(jkr.Paraboloid(R=1e-4), specimen, jkr.Loading("radius", 1.5e-5))
    U = jkr.Roughness(rms=50e-9, longest=20e-6, shortest=10e-9, hurst=0.8).on(film).energy
    half, layer = columns["elastic_energy_J_per_m2"].reshape(2, 3)
    assert layer[:2] == pytest.approx([U / 100, U], rel=1e-9)
    assert half[1] == pytest.approx(0.6908354e-3, rel=1e-6)
    assert columns["w_J_per_m2"][:2] == pytest.approx(5e-3 - half[:2], rel=1e-12)
    assert columns["reason"][[2, 4]].tolist() == ["rms slope above 1", "U > w: no adhesion by conformal contact"]
