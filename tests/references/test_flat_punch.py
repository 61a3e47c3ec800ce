"""Flat punch with a sharp edge: Kendall's pull-off on a half-space (J. Phys. D 4 (1971) 1186), G = w at the full end on
any stack, and the edge that recedes on a thin incompressible layer, against an integral equation of the tests' own."""

import math
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from layer_contact import contact
from scipy.optimize import brentq

import jkrcli
from jkrcli.adhesion.curve import DISPLACEMENT_CONTROL, LOAD_CONTROL, CriticalPoint, transform
from jkrcli.adhesion.device_path import cycle, stability_under, turning_radius
from jkrcli.adhesion.pull_off_error import error_of_rows
from jkrcli.base.errors import Unknown
from jkrcli.bodies.indenters import FlatPunch
from jkrcli.formulas import punch_of_range
from jkrcli.resolve.analysis import analyse

E, W = 1e6, 0.05
E_STAR = E / 0.75  # nu = 1/2
H = 1e-3
LAYER = 'layers = [{ E = "1 MPa", nu = 0.5, thickness = "1 mm" }]'
CASE = """
indenter = {{ shape = "flat", radius = {R} }}
specimen = {{ {specimen} }}
loading = {{ {loading} }}
adhesion = {{ w = 0.05 }}
"""


def on_layer(R: float, loading: jkrcli.Loading | None = None) -> jkrcli.Problem:
    specimen = jkrcli.Specimen((jkrcli.Layer(jkrcli.Elastic(E, 0.5), H),))
    return jkrcli.Problem(FlatPunch(R), specimen, loading or jkrcli.Loading("radius", R, 100, "log"))


def stiffness(a_over_h: float) -> float:
    """S/(2 E* a) of a flat end on the layer, by the tests' own integral equation."""
    return contact(a_over_h, 0.5)[2] / (2 * a_over_h)


def slope(a_over_h: float) -> float:
    return contact(a_over_h, 0.5)[3] / 2


def controls(jkr: Callable, R: float, specimen: str, *options: str, loading: str = 'depth = "10 um"') -> list[dict]:
    Path("punch.toml").write_text(CASE.format(R=R, specimen=specimen, loading=loading))
    return jkr("pull-off", "punch.toml", "--json", *options).told["results"][0]["controls"]


@pytest.mark.parametrize("loading", ["radius = 20e-6", 'depth = "1 um"\nspacing = "depth"', 'load = "1 mN"'])
def test_kendalls_pull_off_under_either_control(jkr: Callable, loading: str) -> None:
    R, w, E_star = 20e-6, 0.05, 5e6 / (1 - 0.45**2)
    text = CASE.replace("{{ {loading} }}", "{{ " + loading.replace("\n", ", ") + " }}")
    Path("punch.toml").write_text(text.format(R=R, specimen="half_space = { E = 5e6, nu = 0.45 }"))
    found = jkr("pull-off", "punch.toml", "--json").told["results"][0]["controls"]
    for one in found:
        assert one["pull_off"]["a_m"] == R
        assert one["pull_off"]["P_N"] == pytest.approx(-math.sqrt(8 * math.pi * w * E_star * R**3), rel=1e-10)
        assert one["pull_off"]["delta_m"] == pytest.approx(-math.sqrt(2 * math.pi * w * R / E_star), rel=1e-10)
        assert one["pull_off"]["P_err_N"] < 1e-13 * abs(one["pull_off"]["P_N"])
        assert one["jump_in"] == {"P_N": 0, "delta_m": 0, "a_m": R}
    # all of the elastic energy at pull-off is lost: S delta^2/2 = 2 pi R^2 w
    assert found[1]["energy_lost_J"] == pytest.approx(2 * math.pi * R**2 * w, rel=1e-10)


@pytest.mark.parametrize("R_over_h", [0.2, 5.0])
def test_pull_off_from_a_layer_is_that_of_the_reference(jkr: Callable, R_over_h: float) -> None:
    """P = S sqrt(4 pi w a/S') at a = R under either control; held, contact is lost where S'/a is least, or there."""
    R = R_over_h * H
    loaded, held = controls(jkr, R, LAYER, loading=f'radius = {R}, spacing = "log"')
    t = math.sqrt(4 * math.pi * W * R / (2 * E_STAR * slope(R_over_h)))
    S = 2 * E_STAR * R * stiffness(R_over_h)
    assert loaded["pull_off"]["P_N"] == pytest.approx(-S * t, rel=1e-8)
    assert held["pull_off"] == loaded["pull_off"]
    assert loaded["contact_lost"]["a_m"] == R
    fold = brentq(lambda a: slope(1.001 * a) / 1.001 - slope(0.999 * a) / 0.999, 0.3, 0.7, xtol=1e-9)
    assert fold == pytest.approx(0.4619, abs=1e-4)
    a = min(fold, R_over_h)
    t = math.sqrt(4 * math.pi * W * a * H / (2 * E_STAR * slope(a)))
    assert held["contact_lost"]["a_m"] == pytest.approx(
        a * H, rel=1e-5
    )  # the difference of the reference is flat there
    assert held["contact_lost"]["delta_m"] == pytest.approx(-t, rel=1e-8)
    assert held["contact_lost"]["P_N"] == pytest.approx(-2 * E_STAR * a * H * stiffness(a) * t, rel=3e-5)
    for lost in (loaded["pull_off"], held["contact_lost"]):
        assert lost["P_err_N"] < 1e-7 * abs(lost["P_N"])


def test_energy_of_a_cycle_is_what_the_receding_edge_and_the_last_jump_take() -> None:
    """Energy lost = w pi (R^2 - a^2) down to the fold at a, and S delta^2/2, all that is stored there."""
    R = 5 * H
    curve = analyse(jkrcli.solve(on_layer(R), "layered"), [W])[0].curve
    held = stability_under(curve, DISPLACEMENT_CONTROL)
    a, delta = held.lost.a, held.lost.delta
    S = 2 * E_STAR * a * stiffness(a / H)
    lost = W * math.pi * (R**2 - a**2) + S * delta**2 / 2
    assert held.energy_lost == pytest.approx(lost, rel=1e-7)
    assert held.separation == pytest.approx(lost, rel=1e-7)
    assert abs(held.energy_lost - lost) <= held.energy_lost_error < 1e-4 * lost
    assert stability_under(curve, LOAD_CONTROL).pull_off.a == R


@pytest.mark.parametrize("device", [LOAD_CONTROL, 1e4, DISPLACEMENT_CONTROL])
def test_the_pull_off_force_is_the_largest_tension_on_the_way(device: float) -> None:
    curve = analyse(jkrcli.solve(on_layer(5 * H), "layered"), [W])[0].curve
    behaviour = stability_under(curve, device)
    passed = cycle(curve, curve, device).path.rows(400)["P_N"]
    assert behaviour.pull_off.P == pytest.approx(passed.min(), rel=1e-9)
    assert (behaviour.lost.a < 5 * H) == (device == DISPLACEMENT_CONTROL)


def test_few_rows_do_not_tell_that_contact_is_lost_at_the_rim() -> None:
    """Between two rows the displacement may be lower than at the rim, and on a thin layer it is; not so the load."""
    radii = (2.5 * H, 5 * H)
    series = jkrcli.solve(on_layer(5 * H, jkrcli.Loading.given("radius", radii)), "layered").series
    curve = transform(series, "exact", W)
    rim = curve.point(5 * H)
    lost = CriticalPoint(**vars(rim))
    assert isinstance(error_of_rows(curve, lost, DISPLACEMENT_CONTROL), Unknown)
    errors = error_of_rows(curve, lost, LOAD_CONTROL)
    assert not isinstance(errors, Unknown)
    assert errors["P"] < 1e-7 * abs(lost.P)


def test_trace_follows_the_full_end_then_the_receding_edge() -> None:
    R = 5 * H
    S = 2 * E_STAR * R * stiffness(5.0)
    curve = analyse(jkrcli.solve(on_layer(R, jkrcli.Loading("load", 2000 * W * R)), "layered"), [W])[0].curve
    turn = turning_radius(curve, DISPLACEMENT_CONTROL, load=1000 * W * R)
    columns = cycle(curve, curve, DISPLACEMENT_CONTROL, turn).path.rows(50)
    full = columns["a_m"] == R
    np.testing.assert_allclose(columns["P_N"][full], S * columns["delta_m"][full], rtol=1e-8, atol=1e-12)
    assert columns["P_N"].max() == pytest.approx(1000 * W * R, rel=1e-9)
    receding = columns["a_m"] < R
    assert np.count_nonzero(receding) >= 24
    G = columns["P_N"][receding][0] ** 2  # of the last edge that carries a load: P = S delta, G = S' delta^2/(4 pi a)
    a = columns["a_m"][receding][0] / H
    assert G == pytest.approx(4 * math.pi * W * a * H * (2 * E_STAR * a * H * stiffness(a)) ** 2
                              / (2 * E_STAR * slope(a)), rel=1e-4)  # fmt: skip


def test_another_w_on_retraction_leaves_the_loading_line() -> None:
    """The full end is pinned at whatever w: P = S delta both ways, pull-off goes with the root of w."""
    R = 0.4 * H
    solution = jkrcli.solve(on_layer(R, jkrcli.Loading("load", 0.02)), "layered")
    approach, retraction = (one.curve for one in analyse(solution, [W, 4 * W]))
    whole = cycle(approach, retraction, 1e6)
    plain = cycle(approach, approach, 1e6)
    columns, S = whole.path.rows(20), 2 * E_STAR * R * stiffness(0.4)
    np.testing.assert_allclose(columns["P_N"], S * columns["delta_m"], rtol=1e-8, atol=1e-15)
    assert columns["P_N"][-1] == pytest.approx(2 * plain.path.rows(20)["P_N"][-1], rel=1e-9)


@pytest.mark.parametrize(
    ("specimen", "relation"),
    [pytest.param(f"{LAYER}, surface_tension = 0.03", 1e-6, marks=pytest.mark.slow),
     (f'{LAYER}, surface = "sticking"', 1e-7),
     (f'{LAYER}, radius = "8 mm", side = "free"', 1e-4)],
)  # fmt: skip
def test_pull_off_of_any_body_is_g_equal_w_at_the_full_end(jkr: Callable, specimen: str, relation: float) -> None:
    """P = S delta, G = S' delta^2/(4 pi R) = w, S' the slope of S of punches a little larger and smaller."""
    R, step = 2e-3, 1e-3
    found = controls(jkr, R, specimen)[0]["pull_off"]
    S = {}
    for factor in (1 - step, 1.0, 1 + step):
        Path("other.toml").write_text(CASE.format(R=R * factor, specimen=specimen, loading=f"radius = {R * factor}"))
        S[factor] = float(jkrcli.solve("other.toml").series.S[-1])
    dS = (S[1 + step] - S[1 - step]) / (2 * step * R)
    assert found["P_N"] == pytest.approx(S[1.0] * found["delta_m"], rel=relation)
    assert dS * found["delta_m"] ** 2 / (4 * math.pi * R) == pytest.approx(W, rel=max(relation, 1e-5))


REFUSED = {
    ("transform", "--range", "1 nm"): "not derived at the sharp edge of a flat punch",
    ("run", "--method", "fem", "--force"): "contact radii of nodes do not meet the sharp edge",
    ("profile", "--load", "1 mN"): "carried by the full end",
    ("export", "--nanite"): "a flat end, whose contact does not begin at a point",
    ("export", "--dem"): "contacts that begin at a point",
    ("import", "--case", "punch.toml"): "its P = S delta is solved: jkr run CASE",
}


@pytest.mark.parametrize("options", REFUSED, ids=" ".join)
def test_what_is_not_derived_is_refused(jkr: Callable, options: tuple[str, ...]) -> None:
    verb, *rest = options
    Path("punch.toml").write_text(CASE.format(R=1e-3, specimen=LAYER, loading="radius = 1e-3"))
    file = "punch.toml"
    if verb == "export":
        jkr("run", file)
        file = "punch.h5"
    if verb == "import":
        file = "table.csv"
        Path(file).write_text("a (mm),delta (um),P (mN)\n1,1,2\n1,2,4\n1,3,6\n")
    there = set(Path().iterdir())
    refused = jkr(verb, file, *rest)
    assert refused.code == 2
    assert REFUSED[options] in " ".join(refused.err.split())
    assert refused.err.count("jkr: error") == 1
    assert set(Path().iterdir()) - there <= {Path("punch.h5")}  # the solution of the case


def test_viscoelastic_bodies_under_a_punch_are_refused(jkr: Callable) -> None:
    relaxing = f'{LAYER}, relaxation = {{ law = "sls", ratio = 0.1, time = 1 }}'
    Path("punch.toml").write_text(CASE.format(R=1e-3, specimen=relaxing, loading="radius = 1e-3"))
    assert "viscoelastic specimen with a sharp-edged flat punch" in jkr("run", "punch.toml").err


def test_a_loading_that_ends_inside_the_punch_says_that_the_rim_is_not_reached(jkr: Callable) -> None:
    loaded, held = controls(jkr, 1e-3, LAYER, loading="radius = 0.8e-3")
    assert "pull-off lies outside" in loaded["pull_off"]["reason"]
    assert "pull-off lies outside" in held["pull_off"]["reason"]
    assert held["contact_lost"]["a_m"] == pytest.approx(0.4619e-3, rel=1e-4)
    Path("punch.toml").write_text(CASE.format(R=1e-3, specimen=LAYER, loading="radius = 1.1e-3"))
    beyond = jkr("run", "punch.toml").err
    assert "a contact radius of 1.1 mm lies beyond the profile" in beyond
    assert beyond.count("jkr: error") == 1


def test_neglected_effects_are_at_the_radius_that_is_reached(jkr: Callable) -> None:
    """The substrate in series, S_film and S_glass, moves S by less than their ratio, wherever loading ends."""
    Path("punch.toml").write_text(CASE.format(R=1e-3, specimen=LAYER, loading='radius = "0.8 mm"'))
    said = jkr("check", "punch.toml", "--json").told["left_out"]
    changes = {one["name"]: one["S"] for one in said}
    a = 0.8
    film, glass = 2 * E_STAR * a * 1e-3 * stiffness(a), 2 * 70e9 / (1 - 0.2**2) * a * 1e-3
    (substrate,) = (S for name, S in changes.items() if name.startswith("elastic substrate"))
    assert -1.5 * film / glass < substrate < 0


def test_the_error_of_smoothed_slopes_at_the_rim() -> None:
    """It holds the true one, and is not the scale of the noise times the bias of the end."""
    solution = jkrcli.solve(on_layer(5 * H, jkrcli.Loading("radius", 5 * H)), "layered")
    exact, (one,) = analyse(solution, [W])[0].pull_off["load"].P, analyse(solution, [W], "loocv")
    off = abs(one.pull_off["load"].P / exact - 1)
    stated = one.pull_off_errors["load"]["P"] / abs(exact)
    assert off <= stated < 0.05


def test_the_stated_error_of_a_pressed_punch_holds_the_true_one() -> None:
    """Far from the load at which it lets go, P = S delta errs as S does."""
    R = 2 * H
    rough = analyse(jkrcli.solve(on_layer(R, jkrcli.Loading("depth", 1e-4)), jkrcli.Layered(1e-3)), [W])[0].curve
    end = np.array(rough.places[-1])
    (delta, P), error = rough.at(end), float(rough.error_at(end)["P"])
    exact = 2 * E_STAR * R * stiffness(2.0) * delta
    assert P > 20 * abs(rough.P.min())
    assert abs(P - exact) <= error
    assert error == pytest.approx(float(rough.series.errors["S"][-1]) * delta, rel=0.2)


def test_a_small_punch_on_something_stiff_says_what_a_range_changes(jkr: Callable) -> None:
    Path("punch.toml").write_text(
        CASE.format(R=1e-8, specimen="half_space = { E = 70e9, nu = 0.2 }", loading="load = 1e-9")
    )
    said = jkr("pull-off", "punch.toml", "--stiffness", "load")
    share = punch_of_range(1e-8, W, 70e9 / 0.96, 0.3e-9) / math.sqrt(8 * math.pi * W * 70e9 / 0.96 * 1e-24)
    assert f"attraction over the range z0 makes the pull-off force {100 * (1 - share):.3g} % smaller" in said.out
    layer = "layers = [{ E = 70e9, nu = 0.2, thickness = 2e-8 }]"
    Path("punch.toml").write_text(CASE.format(R=1e-8, specimen=layer, loading="load = 1e-9"))
    for verb in ("pull-off", "check"):
        assert "whether JKR holds is unknown: attraction over the range z0" in " ".join(
            jkr(verb, "punch.toml").out.split()
        )


def test_the_first_line_names_the_force_that_is_right(jkr: Callable) -> None:
    where = ("--radius", "10 nm", "--E", "70 GPa", "--nu", "0.4", "--w", "50 mJ/m^2")
    first = " ".join(jkr("pull-off", *where).out.split("(E = 70")[0].split())
    assert "by JKR; 3.06 nN (load) with a range of 300 pm" in first
    assert "pull-off force 3.06 nN (load)" in jkr("pull-off", *where, "--range", "0.3 nm").out
