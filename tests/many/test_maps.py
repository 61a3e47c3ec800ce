"""Maps: published and independent values, limits, what is drawn and written, refusals."""

import csv
import math
import re
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from maugis import Maugis

import jkrcli
from jkrcli import InputError
from jkrcli.many.maps import RATE_MAP, ZONES

QS = (1e-3, 1e-2, 1e-1, 1.0, 10.0, 100.0, 1e3, 1e4)
# -P_min/(pi w R) of a bonded layer on a rigid base over w R^2/(E* h^3), computed by two independent programs.
VALUES = {
    0.3: (1.5027, 1.5230, 1.6267, 1.7936, 1.8966, 1.9474, 1.9720, 1.9846),
    0.499: (1.5041, 1.5348, 1.6878, 1.9327, 2.1410, 2.3330, 2.4978, 2.6134),
}


@cache
def columns(nu: float, base: str = "bonded", qs: tuple[float, ...] = QS) -> dict[str, np.ndarray]:
    return jkrcli.study_map("pull-off", nu=[nu], base=base, q=qs).columns


def forces(nu: float, base: str = "bonded", qs: tuple[float, ...] = QS) -> list[float]:
    return columns(nu, base, qs)["minus_P_over_pi_w_R"].tolist()


@pytest.mark.parametrize("nu", VALUES)
def test_values_of_the_map(nu: float) -> None:
    assert [round(force, 4) for force in forces(nu)] == list(VALUES[nu])  # every digit


@pytest.mark.parametrize("nu", [-0.5, 0.0, 0.3])
def test_thick_and_thin_compressible_limits(nu: float) -> None:
    found = columns(nu, qs=(1e-6, 1e6))
    (thick, thin), (narrow, wide) = found["minus_P_over_pi_w_R"], found["a_over_h"]
    assert thick == pytest.approx(1.5, abs=1e-5)  # departs as q: 3e-6
    assert narrow == pytest.approx((9 * np.pi * 1e-6 / 8) ** (1 / 3), rel=1e-4)
    c = (1 - nu) ** 2 / (1 - 2 * nu)  # K h/E*, Eq. 22
    assert thin == pytest.approx(2, abs=0.01)  # departs as h/a, 1/50
    assert wide == pytest.approx((8e6 / c) ** 0.25, rel=0.03)


def test_thin_incompressible_limit_is_approached_slowly() -> None:
    found = forces(0.5, qs=(1e3, 1e4, 1e5, 1e6))
    assert found == sorted(found)
    gaps = 3 - np.array(found)
    ratios = gaps[1:] / gaps[:-1]
    assert np.all((ratios > 0.64) & (ratios < 0.72))  # the gap falls as h/a: by 10^(-1/6) = 0.68 per decade of q


def test_a_nearly_incompressible_layer_overshoots_and_comes_back_to_the_compressible_limit() -> None:
    found = forces(0.45, qs=(1.0, 1e2, 1e4, 1e6))
    assert found[0] < 2 < max(found)
    assert found[-1] < found[-2]
    assert found[-1] > 2


def test_on_a_frictionless_base_nu_does_not_matter() -> None:
    one, two = (forces(nu, "frictionless") for nu in (0.0, 0.5))
    assert one == pytest.approx(two, rel=1e-10)  # E* alone counts
    assert set(columns(0.0, "frictionless")["base"]) == {"frictionless"}
    assert max(one) < 2


def test_each_value_once_in_order() -> None:
    found = jkrcli.study_map("pull-off", nu=[0.3, 0.3], q=[1.0, 0.1, 1.0]).columns
    assert (found["nu"].tolist(), found["w_R2_over_Estar_h3"].tolist()) == ([0.3, 0.3], [0.1, 1.0])
    assert forces(0.3, qs=(1.0,))[0] == pytest.approx(found["minus_P_over_pi_w_R"][1], rel=1e-6)  # other radii


@pytest.mark.parametrize(("name", "axes", "said"), [
    ("pull-off", {"q": [1.0, 1e-7]}, "pull-off map: q must be >= 1e-06 and <= 1e+07, got 1e-07"),
    ("pull-off", {"nu": [0.6]}, "pull-off map: nu must be > -1 and <= 0.5, got 0.6"),
    ("pull-off", {"q": [float("nan")]}, "pull-off map: q must be a finite number, got nan"),
    ("pull-off", {"base": "wet"}, 'pull-off map: base must be bonded or frictionless, got "wet"'),
    ("pull-off", {"mu": [1.0]}, 'pull-off map: has no axis "mu" (axes: nu, base, q, beta)'),
    ("sticking", {"nu": [0.5], "ratio": [50.0]}, "sticking map: ratio must be >= 0.01 and <= 12, got 50"),
    ("transition", {"mu": [1000.0]}, "transition map: mu must be >= 0.05 and <= 50, got 1000.0"),
    ("pulloff", {}, 'unknown map "pulloff" (maps: pull-off, sticking, '),
])  # fmt: skip
def test_what_a_map_has_not_is_refused(name: str, axes: dict, said: str) -> None:
    with pytest.raises(InputError, match=re.escape(said)):
        jkrcli.study_map(name, **axes)


@pytest.mark.parametrize("mu", [0.03, 0.5, 20.0])
def test_a_thick_layer_of_the_adhesion_map_is_a_half_space(mu: float) -> None:
    """delta_a = delta_H - delta and (P_H - P)/P_H at given loads; q = 1e-9 leaves a/h below 5e-3."""
    q, loads = 1e-9, (0.5, 2.0, 20.0)
    found = jkrcli.study_map("adhesion", nu=0.3, q=q, mu=(mu,), load=loads).columns
    lam = 2 * mu * (9 / 16 / np.pi) ** (1 / 3)  # K = 4 E*/3
    exact = Maugis(1.0, 1.0, q, lam, 1 + np.geomspace(1e4, 1e-9, 20_000))
    rising = slice(int(np.argmin(exact.P)), None)
    a = np.interp(np.array(loads) * np.pi * q, exact.P[rising], exact.a[rising])
    delta = np.interp(a, exact.a[rising], exact.delta[rising])
    length = q / exact.stress
    assert found["a_over_h"] == pytest.approx(a, rel=0.01)
    assert found["adhesive_over_range"] == pytest.approx((a**2 - delta) / length, rel=0.02)
    assert found["adhesive_share"] == pytest.approx(
        1 - np.array(loads) * np.pi * q / (4 / 3 * a**3), rel=0.03, abs=1e-3
    )


@pytest.mark.slow
def test_zones_follow_from_range_and_load() -> None:
    mus = (0.02, 1.0, 50.0)
    thick = jkrcli.study_map("adhesion", q=1e-4, mu=mus, load=(0.1, 1.0)).columns["zone"]
    assert thick[:3].tolist() == ["DMT", "Maugis", "JKR"]
    thin = jkrcli.study_map("adhesion", q=100.0, mu=mus, load=(0.1, 100.0)).columns["zone"]
    assert thin[:4].tolist() == ["rigid", "DMT", "Maugis", "Hertz"]  # a thin layer is a stiff one


def test_the_command_of_the_adhesion_map(jkr) -> None:
    words = ("study", "adhesion-map", "--q", 1, "--mu", 0.1, "--mu", 1, "--mu", 10, "--load", 1, "--load", 10)
    assert jkr(*words).code == 0
    rows = list(csv.DictReader(Path("adhesion-map.csv").read_text().splitlines()))
    assert len(rows) == 6
    assert {row["zone"] for row in rows} <= set(ZONES)
    assert Path("adhesion-map.png").exists()
    for wrong in (("--q", 0), ("--mu", 1e4), ("--load", -1), ("--nu", 0.7)):
        jkr("study", "adhesion-map", *wrong).refused()


def test_both_logarithmic_panels_hold_their_lines() -> None:
    """Limits of a linear axis were kept: energies that span a decade were drawn above a panel of negative energies."""
    columns = {"V_over_v0": [1e-3, 1.0, 1e2], "h_over_R": [math.inf] * 3, "k_over_Estar_R": [math.inf] * 3,
               "minus_P_over_pi_w0_R": [1.5, 2.3, 8.3], "dissipated_over_w0_pi_a2": [1.0, 3.0, 40.0]}  # fmt: skip
    figure = RATE_MAP.draw({name: np.array(values) for name, values in columns.items()})
    for axes, (low, high) in zip(figure.axes, ((1.5, 8.3), (1.0, 40.0)), strict=True):
        assert 0 < axes.get_ylim()[0] < low
        assert axes.get_ylim()[1] > high


def test_map_of_w_over_rms_and_modulus() -> None:
    columns = jkrcli.study_map("roughness", rms=["5 nm", "50 nm", "1 um"], modulus="1 MPa", w="5 mJ/m^2").columns
    specimen = jkrcli.Specimen((jkrcli.Layer(jkrcli.Elastic(E=1e6, nu=0.5), 1e-6),), jkrcli.Rigid(bonded=True))
    film = jkrcli.Problem(jkrcli.Paraboloid(R=1e-4), specimen, jkrcli.Loading("radius", 1.5e-5))
    U = jkrcli.Roughness(rms=50e-9, longest=20e-6, shortest=10e-9, hurst=0.8).on(film).energy
    half, layer = columns["elastic_energy_J_per_m2"].reshape(2, 3)
    assert layer[:2] == pytest.approx([U / 100, U], rel=1e-9)
    assert half[1] == pytest.approx(0.6908354e-3, rel=1e-6)
    assert columns["w_J_per_m2"][:2] == pytest.approx(5e-3 - half[:2], rel=1e-12)
    assert columns["reason"][[2, 4]].tolist() == ["rms slope above 1", "U > w: no adhesion by conformal contact"]


def test_the_sticking_map_meets_independent_values():
    """Tied finite elements and an integral equation of another make: 1.674 and 1.627 for the load, flat ends for S."""
    columns = jkrcli.study_map("sticking", nu=[0.5, 0.499], ratio=[1.0, 2.0, 10 / 3]).columns
    load = columns["load_ratio"].reshape(2, 3)[:, 2]
    np.testing.assert_allclose(load, [1.674, 1.627], atol=2e-3)
    np.testing.assert_allclose(columns["S_ratio"][:2], [3.929038 / 3.618736, 12.502665 / 9.149450], rtol=1e-5)


def test_narrow_contacts_have_the_half_space_factor():
    columns = jkrcli.study_map("sticking", nu=[0.0], ratio=[0.01]).columns
    assert columns["S_ratio"][0] == pytest.approx(1.0986, abs=2e-3)


def test_the_transition_map_on_a_thick_layer_is_maugis_own() -> None:
    """mu = sigma (R/(w E*^2))^(1/3); the layer adds 3e-4."""
    q, mu = 1e-4, 0.5
    found = jkrcli.study_map("transition", nu=[0.5], q=[q], mu=[mu]).columns
    lam = 2 * mu * (9 / (16 * math.pi)) ** (1 / 3)
    half_space = Maugis(1.0, 1.0, q, lam, np.geomspace(1.01, 20, 2000))
    assert found["minus_P_over_pi_w_R"] == pytest.approx(-half_space.P.min() / (math.pi * q), rel=1e-3)
