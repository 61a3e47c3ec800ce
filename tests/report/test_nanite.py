"""``jkr export --nanite``: the model file as it runs, and in an installed nanite where ``make study NAME=test-nanite``
has made its environment."""

import importlib.util
import inspect
import json
import math
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest
from scipy.optimize import brentq, least_squares

import jkrcli as jkr_package
from jkrcli.base.files import is_ours

R, H, E, NU, W = 5e-6, 4e-6, 2e4, 0.49, 1e-4
CASE = """
indenter = {{ shape = "paraboloid", radius = "5 um"{indenter} }}
specimen = {{ {specimen} }}
loading = {{ radius = "3 um", points = 80 }}
adhesion = {{ w = "0.1 mJ/m^2" }}
"""
HALF_SPACE = 'half_space = { E = "20 kPa", nu = 0.49 }'
LAYER = 'base = "bonded", layers = [{ E = "20 kPa", nu = 0.49, thickness = "4 um" }]'


class Parameters(dict):
    """Stands for lmfit's: what a model of nanite asks of it."""

    def add(self, name: str, value: float, **more: object) -> None:
        self[name] = value


def exported(jkr: Callable, specimen: str = LAYER, indenter: str = "", words: tuple[str, ...] = ()) -> dict:
    Path("my film.toml").write_text(CASE.format(specimen=specimen, indenter=indenter))
    assert jkr("run", "my film.toml", "--force").code == 0
    return jkr("export", "my film.h5", "--nanite", "--json", "--force", *words).told


def loaded(monkeypatch: pytest.MonkeyPatch) -> ModuleType:
    lmfit = ModuleType("lmfit")
    lmfit.Parameters = Parameters
    monkeypatch.setitem(sys.modules, "lmfit", lmfit)
    spec = importlib.util.spec_from_file_location("model_jkr_my_film", "model_jkr_my_film.py")
    model = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(model)
    return model


def jkr_of_a_half_space(delta: float, E_star: float, radius: float, w: float) -> float:
    """Johnson, Kendall and Roberts (1971), on the branch from the tear-off on; independent of the package."""
    t = math.sqrt(2 * math.pi * w / E_star)
    least = (radius * t / 4) ** (2 / 3)  # where d(delta)/da = 2 a/R - t/(2 sqrt(a)) vanishes
    a = brentq(lambda a: a**2 / radius - t * math.sqrt(a) - delta, least, 10 * radius, xtol=1e-18, rtol=1e-14)
    return 4 * E_star * a**3 / (3 * radius) - math.sqrt(8 * math.pi * w * E_star * a**3)


def curve_on_the_layer(E: float, w: float, radius: float, h: float, delta: np.ndarray) -> np.ndarray:
    layer = jkr_package.Layer(jkr_package.Elastic(E, NU), h)
    specimen = jkr_package.Specimen((layer,), jkr_package.Rigid())
    solution = jkr_package.solve(
        jkr_package.Problem(jkr_package.Paraboloid(radius), specimen, jkr_package.Loading("radius", 0.75 * h, 200))
    )
    curve = jkr_package.transform(solution, w).curve
    return np.array([curve.at(np.array(max(curve.radii(delta=value))))[1] for value in delta]).ravel()


def test_half_space_is_jkr_at_any_modulus_work_and_radius(jkr: Callable, monkeypatch: pytest.MonkeyPatch) -> None:
    told = exported(jkr, HALF_SPACE)
    assert told["parameters"] == ["E", "w", "R", "contact_point", "baseline"]
    assert told["error"] < 1e-5
    model = loaded(monkeypatch)
    for modulus, w, radius in ((E, W, R), (4e3, 5e-4, R), (3e5, 2e-5, 20e-6)):
        E_star = modulus / (1 - NU**2)
        tear = -0.75 * (math.pi**2 * w**2 * radius / E_star**2) ** (1 / 3)
        delta = np.concatenate([0.999 * tear * np.array([1, 0.9, 0.5]), -tear * np.array([0.1, 1, 4, 10])])
        right = np.array([jkr_of_a_half_space(value, E_star, radius, w) for value in delta])
        tip, scale = 0.3e-6 - delta, np.abs(right).max()
        values = {"E": modulus, "w": w, "R": radius, "contact_point": 0.3e-6, "baseline": 1e-9}
        retraction, approach = model.jkr(tip[::-1], **values)[::-1], model.jkr(tip, **values)
        assert retraction - 1e-9 == pytest.approx(right, abs=2e-5 * scale)
        assert approach - 1e-9 == pytest.approx(np.where(delta < 0, 0, right), abs=2e-5 * scale)


def test_layer_follows_modulus_work_radius_and_thickness(jkr: Callable, monkeypatch: pytest.MonkeyPatch) -> None:
    told = exported(jkr)
    assert told["parameters"] == ["E", "w", "R", "h", "contact_point", "baseline"]
    model = loaded(monkeypatch)
    for values in ((E, W, R, H), (5e4, 3e-4, R, H), (1e4, 5e-5, 8e-6, H), (E, W, 7e-6, 6e-6)):
        delta = np.linspace(1e-9, 0.3e-6, 5)
        right = curve_on_the_layer(*values, delta)
        assert model.jkr(-delta, *values) == pytest.approx(right, abs=2e-5 * np.abs(right).max())


def test_approach_jumps_in_where_bodies_touch_and_retraction_lasts_longer(jkr, monkeypatch) -> None:
    exported(jkr)
    model = loaded(monkeypatch)
    tip = np.linspace(1e-6, -0.5e-6, 3001)
    approach, retraction = model.jkr(tip, E, W, R, H), model.jkr(tip[::-1], E, W, R, H)[::-1]
    assert (approach[tip > 0] == 0).all()
    assert approach[tip < -1e-9] == pytest.approx(retraction[tip < -1e-9], rel=1e-12)
    held = tip[(retraction < 0) & (tip > 0)]
    tear_off = jkr("export", "my film.h5", "--dem", "--json").told["tear_off"]["delta_m"]
    assert -held.max() == pytest.approx(tear_off, abs=1e-9)


def test_fit_finds_modulus_work_and_contact_point(jkr: Callable, monkeypatch: pytest.MonkeyPatch) -> None:
    """Through ``residual`` with parameters as nanite hands them; the record is solved for itself."""
    exported(jkr)
    model = loaded(monkeypatch)
    delta = np.linspace(-0.03e-6, 0.7e-6, 60)
    record = curve_on_the_layer(3.5e4, 2.5e-4, R, H, delta) + 2e-11

    class Values(dict):
        valuesdict = dict.copy

    def residual(x: np.ndarray) -> np.ndarray:
        names = {"E": E * x[0], "w": W * x[1], "R": R, "h": H, "contact_point": 1e-7 * x[2], "baseline": 1e-9 * x[3]}
        return model.residual(Values(names), (4e-8 - delta)[::-1], record[::-1], 0) / 1e-9  # as the tip moves away

    found = least_squares(residual, [1.0, 1.0, 0.0, 0.0], bounds=([0.0, 0.0, -9, -9], 99)).x
    assert found[:2] == pytest.approx([3.5e4 / E, 2.5e-4 / W], rel=1e-4)
    assert found[2:] == pytest.approx([0.4, 0.02], abs=1e-3)


def test_interface_is_what_nanite_checks(jkr: Callable, monkeypatch: pytest.MonkeyPatch) -> None:
    told = exported(jkr)
    model = loaded(monkeypatch)
    keys = told["parameters"]
    assert (list(model.get_parameter_defaults()), model.parameter_keys) == (keys, keys)
    assert list(inspect.signature(model.model_func).parameters) == ["delta", *keys]
    assert len(set(model.parameter_names)) == len(model.parameter_units) == len(keys)
    assert (model.valid_axes_x, model.valid_axes_y, model.model_key) == (["tip position"], ["force"], "jkr_my_film")
    assert is_ours(Path("model_jkr_my_film.py"))
    record = {"force": np.array([0.0, 1.0, 1.0, -3.0, 0.0, 0.0]) * 1e-9, "segment": np.repeat([0, 1], 3)}
    assert model.compute_ancillaries(record)["w"] == pytest.approx(3e-9 / (1.5 * math.pi * R))


REFUSED = {
    "elastic indenter": (HALF_SPACE, ', E = "70 GPa", nu = 0.2', "indenter.material"),
    "surface tension": (HALF_SPACE + ', surface_tension = "30 mN/m"', "", "surface_tension"),
}


@pytest.mark.first(1)
@pytest.mark.parametrize("why", REFUSED)
def test_what_does_not_scale_with_the_modulus_is_refused(jkr: Callable, why: str) -> None:
    specimen, indenter, said = REFUSED[why]
    Path("x.toml").write_text(CASE.format(specimen=specimen, indenter=indenter))
    assert jkr("run", "x.toml").code == 0
    jkr("export", "x.h5", "--nanite").refused(said)
    assert not list(Path().glob("model_*"))


NANITE = Path(sys.prefix).with_name(f"{Path(sys.prefix).name}-nanite") / "bin" / "python"
FITTED = """
import json, sys
import nanite, numpy as np
model = nanite.model.load_model_from_file("model_jkr_my_film.py", register=True)
tip, force = np.loadtxt("record.txt").T
data = {"tip position": tip, "force": force, "segment": np.repeat([0, 1], tip.size // 2)}
record = nanite.Indentation(data, {"path": "record.tab", "enum": 0, "point count": tip.size})
found = []
for segment in (0, 1):
    record.fit_model(model_key=model.model_key, segment=segment, weight_cp=0, params_initial=None)
    found.append({key: value.value for key, value in record.fit_properties["params_fitted"].items()})
json.dump(found, sys.stdout)
"""


@pytest.mark.slow
@pytest.mark.skipif(not NANITE.exists(), reason="no nanite beside this environment: make study NAME=test-nanite")
def test_nanite_fits_a_layer(jkr: Callable) -> None:
    """E and w to 1e-3 from approach and retraction, from the case's E and from nanite's own estimates of the rest."""
    exported(jkr)
    delta = np.linspace(-0.052e-6, 0.7e-6, 151)
    loads = curve_on_the_layer(3.5e4, 2.5e-4, R, H, delta)
    free = np.linspace(-1.5e-6, -0.2e-6, 200)
    approach = np.concatenate([0 * free, np.where(delta < 0, 0, loads)])
    retraction = np.concatenate([0 * free, loads])[::-1]
    tip = 4e-8 - np.concatenate([free, delta])
    np.savetxt("record.txt", np.column_stack([[*tip, *tip[::-1]], [*approach, *retraction]]))
    done = subprocess.run([str(NANITE), "-c", FITTED], capture_output=True, text=True, timeout=300)
    assert done.returncode == 0, done.stderr
    for found in json.loads(done.stdout):
        assert (found["E"], found["w"]) == pytest.approx((3.5e4, 2.5e-4), rel=1e-3)
        assert found["contact_point"] == pytest.approx(4e-8, abs=1e-10)
