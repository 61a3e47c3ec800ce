"""Roughness as a correction of w on any stack: U = (pi/2) E* int q^2 C/g dq, w_app = r w - gamma (r - 1) - U.

Persson and Tosatti, J. Chem. Phys. 115 (2001) 5597; Dalvi et al., PNAS 116 (2019) 25484.
"""

import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.integrate import quad

import jkrcli as python
from jkrcli.adhesion.roughness import PowerSpectrum, relative_compliance
from jkrcli.base.errors import InputError
from jkrcli.base.numerics import Array
from studies.stack_judge import compliance_ratio

WAVES = {"rms": 50e-9, "shortest": 10e-9, "hurst": 0.8}
WORDS = "rms=50nm,longest=20um,shortest=10nm,hurst=0.8"


def problem(nu: float = 0.5, h: float | None = None, E: float = 1e6, **more: Any) -> python.Problem:
    material = python.Elastic(E=E, nu=nu)
    specimen = python.Specimen((), python.HalfSpace(material))
    if h is not None:
        specimen = python.Specimen((python.Layer(material, h),), python.Rigid(bonded=True))
    return python.Problem(python.Paraboloid(R=1e-4), specimen, python.Loading("radius", 1.5e-5), **more)


@pytest.mark.parametrize(
    ("nu", "h", "longest", "U"),
    [(0.5, None, 20e-6, 0.691), (0.5, 1e-6, 20e-6, 7.982), (0.5, 1e-6, 100e-6, 142.98), (0.5, 1e-5, 20e-6, 0.698),
     (0.5, 1e-5, 100e-6, 0.401), (0.4, None, 100e-6, 0.124), (0.4, 1e-6, 20e-6, 2.449), (0.4, 1e-6, 100e-6, 2.637),
     (0.5, 1e-6, 2e-6, 6.761), (0.4, 1e-6, 2e-6, 6.020)],
)  # fmt: skip
def test_energy_of_self_affine_roughness(nu: float, h: float | None, longest: float, U: float) -> None:
    """In mJ/m^2, for rms 50 nm, H = 0.8, shortest wave 10 nm, E = 1 MPa: by adaptive quadrature of the closed g of a
    bonded layer, every digit."""
    contact = python.Roughness(longest=longest, **WAVES).on(problem(nu, h))
    assert round(contact.energy * 1e3, 3 if U < 100 else 2) == U


@pytest.mark.parametrize("hurst", [0.3, 0.8, 1.0])
def test_the_published_formula_of_a_half_space(hurst: float) -> None:
    """C = C0 q^(-2 - 2 H): U = (pi/2) E* C0 (q1^(1 - 2 H) - q0^(1 - 2 H))/(1 - 2 H), rms^2 = (pi/H) C0 (q0^(-2 H) -
    q1^(-2 H)), slope^2 = 2 pi C0 (q1^(2 - 2 H) - q0^(2 - 2 H))/(2 - 2 H)."""
    q0, q1, rms = 2 * math.pi / 5e-6, 2 * math.pi / 50e-9, 2e-9
    C0 = rms**2 * hurst / math.pi / (q0 ** (-2 * hurst) - q1 ** (-2 * hurst))
    roughness = python.Roughness(rms=rms, longest=5e-6, shortest=50e-9, hurst=hurst)
    body = problem(0.4)
    U = math.pi / 2 * body.E_star * C0 * (q1 ** (1 - 2 * hurst) - q0 ** (1 - 2 * hurst)) / (1 - 2 * hurst)
    contact = roughness.on(body)
    assert contact.energy == pytest.approx(U, rel=1e-11)
    assert abs(contact.energy - U) <= contact.error
    n = 2 - 2 * hurst
    gained = math.log(q1 / q0) if hurst == 1 else (q1**n - q0**n) / n
    assert roughness.spectrum.slope == pytest.approx(math.sqrt(2 * math.pi * C0 * gained), rel=1e-11)
    assert roughness.spectrum.rms == pytest.approx(rms, rel=1e-12)


# Five stacks from the top: (E, nu, h), and what they lie on.
BONDED = python.Rigid(bonded=True)
STACKS: list[tuple[list[tuple[float, float, float]], python.Rigid | python.HalfSpace]] = [
    ([(1e6, 0.5, 1e-6)], BONDED),
    ([(1e6, 0.3, 1e-6)], BONDED),
    ([(1e6, 0.4, 1e-6)], python.HalfSpace(python.Elastic(1e7, 0.25))),
    ([(2e7, 0.35, 0.3e-6)], python.HalfSpace(python.Elastic(1e6, 0.5))),
    ([(1e6, 0.45, 0.4e-6), (3e6, 0.3, 0.5e-6), (5e5, 0.5, 0.8e-6)], BONDED),
]


@pytest.mark.parametrize("stack", STACKS)
@pytest.mark.parametrize("wave", [1e-6, 3e-6, 2e-5])
def test_energy_of_one_wave_is_that_of_the_exact_kernel(stack: Any, wave: float) -> None:
    """u cos(qx) stores E* q u^2/(8 g): a band of relative width 1e-4 about it, rms u/sqrt(2)."""
    layers, base = stack
    specimen = python.Specimen(tuple(python.Layer(python.Elastic(E, nu), h) for E, nu, h in layers), base)
    body = python.Problem(python.Paraboloid(1e-4), specimen, python.Loading("radius", 1e-5))
    u, q = 1e-9, 2 * math.pi / wave
    band = python.Roughness(rms=u / math.sqrt(2), longest=wave * 1.00005, shortest=wave / 1.00005, hurst=0.5)
    (g,) = compliance_ratio(specimen, np.array([q]))
    assert relative_compliance(body, np.array([q]))[0] == pytest.approx(g, rel=1e-8)
    assert band.on(body).energy == pytest.approx(body.E_star * q * u**2 / (8 * g), rel=1e-6)


def test_w_is_turned_around_and_bounded_from_its_side() -> None:
    """w_app = r w - gamma (r - 1) - U, at least; the w behind a measured w_app, at most; r = 1 + slope^2/2."""
    roughness = python.Roughness(longest=20e-6, surface_energy="22 mJ/m^2", **WAVES)
    contact = roughness.on(problem())
    r, gamma = 1 + roughness.spectrum.slope**2 / 2, 0.022
    w = contact.apparent(0.05)
    assert w == pytest.approx(r * 0.05 - gamma * (r - 1) - contact.energy, rel=1e-14)
    assert contact.smooth(w) == pytest.approx(0.05, rel=1e-14)
    assert contact.error_at(0.05) == pytest.approx((0.05 - gamma) * roughness.spectrum.slope**4 / 4, rel=1e-4)
    without = python.Roughness(longest=20e-6, **WAVES).on(problem())
    assert without.apparent(0.05) == 0.05 - contact.energy
    assert "r = 1 taken" in " ".join(without.words())


def profile_spectrum(spectrum: PowerSpectrum, q: Array) -> Array:
    """C_1D(q) = (1/pi) int_q^inf C_iso(p) p/sqrt(p^2 - q^2) dp of a power law without an end."""
    law = lambda p: spectrum.C[0] * (p / spectrum.q[0]) ** -3.6 * (2 * math.pi) ** 2  # noqa: E731
    return np.array([quad(lambda s, k=k: law(k * math.cosh(s)) * k * math.cosh(s), 0, 40)[0] / math.pi for k in q])


@pytest.fixture(name="tables", scope="module")
def _tables(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    spectrum, folder = python.Roughness(longest=20e-6, **WAVES).spectrum, tmp_path_factory.mktemp("tables")
    q = np.geomspace(*spectrum.q, 133)
    C = spectrum.at(q)
    columns = {"C": C, "C_iso": C * (2 * math.pi) ** 2, "q_C_iso_over_pi": q * C * 4 * math.pi,
               "C_1D": profile_spectrum(spectrum, q)}  # fmt: skip
    units = {"C": ("1/um", 1e-6, "nm^4", 1e36), "C_iso": ("1/m", 1, "m^4", 1), "C_1D": ("1/nm", 1e-9, "nm^3", 1e27),
             "q_C_iso_over_pi": ("µm⁻¹", 1e-6, "µm³", 1e18)}  # fmt: skip
    paths = {}
    for name, column in columns.items():
        (x, by_q, y, by_C), paths[name] = units[name], folder / f"{name}.csv"
        rows = "".join(f"{a * by_q!r},{b * by_C!r}\n" for a, b in zip(q.tolist(), column.tolist(), strict=True))
        paths[name].write_text(f"q ({x}),PSD ({y})\n{rows}")
    rows = "".join(
        f"{a * 1e-6!r} {b * 1e18!r}\n" for a, b in zip(q.tolist(), columns["q_C_iso_over_pi"].tolist(), strict=True)
    )
    other = "".join(f"{a * 1e-6!r} {b * 1e18!r}\n" for a, b in zip(q.tolist(), columns["C_1D"].tolist(), strict=True))
    heading = "# {0}\n# ----\n# Columns: Wavevector (µm⁻¹), PSD (µm³)\n{1}\n"
    paths["contact.engineering"] = folder / "psd.txt"
    paths["contact.engineering"].write_text(
        "# Power-spectral density (PSD)\n\n# Topography: x\n\n"
        + heading.format("1D PSD along x", other) + heading.format("q/π × 2D PSD", rows)
    )  # fmt: skip
    return paths


@pytest.mark.parametrize("name", ["C", "C_iso", "q_C_iso_over_pi", "C_1D", "contact.engineering"])
def test_every_convention_gives_the_same_energy(tables: dict[str, Path], name: str) -> None:
    for body in (problem(), problem(h=1e-6)):
        exact = python.Roughness(longest=20e-6, **WAVES).on(body).energy
        convention = "q_C_iso_over_pi" if "." in name else name
        found = python.Roughness(psd=tables[name], convention=convention, rms="50 nm").on(body)
        assert found.energy == pytest.approx(exact, rel=1e-3 if name == "C_1D" else 1e-9)
        assert abs(found.energy - exact) <= max(found.error, 1e-3 * exact if name == "C_1D" else 0)


def test_the_headings_of_contact_engineering_say_the_convention(tables: dict[str, Path]) -> None:
    assert python.Roughness(psd=tables["contact.engineering"]).spectrum.profiles
    with pytest.raises(InputError, match="holds no curve of convention C_iso"):
        _ = python.Roughness(psd=tables["contact.engineering"], convention="C_iso").spectrum


def test_a_given_rms_tells_the_wrong_convention(tables: dict[str, Path], tmp_path: Path) -> None:
    """C_iso read as C makes U 39.5 times too large, and the rms 6.28 times."""
    table = tmp_path / "C_iso.csv"
    table.write_text(tables["C_iso"].read_text().replace("q (1/m),PSD (m^4)", "q,PSD"))
    wrong, right = (python.Roughness(psd=table, convention=name) for name in ("C", "C_iso"))
    assert wrong.spectrum.rms / right.spectrum.rms == pytest.approx(2 * math.pi, rel=1e-12)
    with pytest.raises(InputError, match=r"rms of .* is 314.2 nm, 50 nm is given: convention=C_iso gives it"):
        _ = python.Roughness(psd=table, convention="C", rms="50 nm").spectrum
    near = python.Roughness(psd=table, convention="C_iso", rms="60 nm")
    assert any("60 nm is given" in text for text in near.on(problem()).warnings())


@pytest.mark.parametrize(
    ("words", "message"),
    [
        ("rms=50nm", "longest, shortest, hurst missing"),
        ("rms=50nm,longest=10nm,shortest=1um,hurst=0.8", "shortest wave must be shorter"),
        ("rms=50nm,longest=20um,shortest=10nm,hurst=1.8", "hurst: must be > 0 and <= 1"),
        ("rms=1um,longest=20um,shortest=10nm,hurst=0.8", "the rms slope 2.8"),
        ("rsm=50nm", 'unknown key "rsm"'),
        ("psd=no.csv,convention=C", "no.csv: spectrum not found"),
        ("psd=case.toml,convention=D", "must be one of C, C_iso, q_C_iso_over_pi, C_1D"),
        ("psd=t.csv", "give convention="),
        ("psd=t.csv,convention=C_1D", "this convention has a unit of m^3"),
        ("psd=t.csv,convention=C,shortest=1mm", "leave nothing of the spectrum"),
        ("psd=two.csv,convention=C", "q must rise"),
        ("rms=200nm,longest=20um,shortest=10nm,hurst=0.8", "no adhesion by conformal contact"),
    ],
)  # fmt: skip
def test_refusals_in_one_line(jkr: Any, tmp_path: Path, words: str, message: str) -> None:
    rows = "".join(f"{q},{1 / q**4}\n" for q in range(1, 20))
    (tmp_path / "t.csv").write_text(f"q (1/um),C (um^4)\n{rows}")
    (tmp_path / "two.csv").write_text(f"q (1/um),C (um^4)\n{rows}{rows}")
    flags = ("--radius", "100 um", "--E", "1 MPa", "--nu", "0.5", "--thickness", "1 um", "--w", "50 mJ/m^2")
    jkr("pull-off", *flags, "--roughness", words).refused(message)


def test_bodies_without_a_derivation_are_refused() -> None:
    roughness = python.Roughness(longest=20e-6, **WAVES)
    tense = python.Specimen((), python.HalfSpace(python.Elastic(1e6, 0.5)), surface_tension=0.03)
    for body in (problem(sticks=True), python.Problem(python.Paraboloid(1e-4), tense, python.Loading("radius", 1e-5))):
        with pytest.raises(InputError, match="not derived with"):
            roughness.on(body)


def test_verbs_carry_it(jkr: Any, tmp_path: Path) -> None:
    """``pull-off --load`` turns ``pull-off`` around; JSON, CSV and words say both works of adhesion."""
    (tmp_path / "film.toml").write_text(
        '[indenter]\nshape = "paraboloid"\nradius = "100 um"\n[[specimen.layers]]\nthickness = "1 um"\n'
        'E = "1 MPa"\nnu = 0.5\n[loading]\nradius = "12 um"\n[adhesion]\nw = "50 mJ/m^2"\n'
    )
    assert jkr("run", "film.toml").code == 0
    lost = jkr("pull-off", "film.h5", "--roughness", WORDS, "--json").told["results"][0]
    U = lost["roughness"]["elastic_energy_J_per_m2"]
    assert lost["w_smooth_J_per_m2"] - lost["w_J_per_m2"] == pytest.approx(U, rel=1e-12)
    force = -lost["controls"][0]["pull_off"]["P_N"]
    plain = jkr("pull-off", "film.h5", "--w", repr(lost["w_J_per_m2"]), "--json").told["results"][0]
    assert plain["controls"] == lost["controls"]
    back = jkr("pull-off", "film.h5", "--load", f"{force!r} N", "--roughness", WORDS, "--json")
    measured = json.loads(back.out)["results"][0]
    assert measured["w_smooth_J_per_m2"] == pytest.approx(0.05, rel=1e-6)
    assert measured["w_smooth_bound"] == "upper"
    assert jkr("transform", "film.h5", "--roughness", WORDS, "--no-plots").code == 0
    header, first, *_ = (tmp_path / "film-w0.05-rough.csv").read_text().splitlines()
    row = dict(zip(header.split(","), first.split(","), strict=True))
    assert float(row["w_J_per_m2"]) == lost["w_J_per_m2"]
    assert float(row["w_smooth_J_per_m2"]) == 0.05
    checked = jkr("check", "film.toml", "--roughness", WORDS, "--json").told["adhesion"][0]
    assert checked["w_J_per_m2"] == lost["w_J_per_m2"]
    text = " ".join(jkr("pull-off", "film.h5", "--roughness", WORDS, "-v").out.split())
    assert "42.02 mJ/m^2 at least, by full conformal contact, of 50 mJ/m^2 between smooth surfaces" in text
    assert "U = 7.982 mJ/m^2, 11.6 times a half-space's" in text
    analysed = python.transform(tmp_path / "film.h5", "50 mJ/m^2", roughness=python.Roughness(longest="20 um", **WAVES))
    assert analysed.w == lost["w_J_per_m2"]
    assert any("longest wave 20 um is longer than the contact is wide" in text for text in analysed.warnings)


def test_a_long_noisy_spectrum_of_profiles_is_averaged(tmp_path: Path) -> None:
    q = np.linspace(1, 2000, 2000) * 2 * math.pi / 20e-6
    C = 1e-16 * q**-1.2  # of which no few waves hold the energy
    scatter = np.random.default_rng(3).exponential(size=q.size)
    scatter[7] = 0.0
    energies = []
    for values in (C, C * scatter):
        np.savetxt(tmp_path / "t.csv", np.c_[q, values], delimiter=",", header="q (1/m),C (m^3)", comments="")
        energies.append(python.Roughness(psd=tmp_path / "t.csv", convention="C_1D").on(problem()))
    smooth, noisy = energies
    assert noisy.spectrum.q.size < 160
    assert noisy.spectrum.remarks == ("1 row without q > 0 and C > 0 left out",)
    assert smooth.spectrum.remarks == ()
    assert smooth.error < 0.1 * smooth.energy
    assert abs(noisy.energy - smooth.energy) < noisy.error
