"""A command's JSON is what Python's ``summary()`` gives, and what it prints is what ``print`` does."""

import json
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from conftest import write_table

import jkrcli as python
from jkrcli.base.registry import Result
from jkrcli.case import store
from jkrcli.many.sweep import Means, alone, sweep
from jkrcli.many.sweep_plan import load_plan
from jkrcli.report.archive import Shown
from jkrcli.report.export import Exported
from jkrcli.report.solved import Imported
from jkrcli.resolve.foreign import SeriesReading, read_series
from jkrcli.series import Solution

CASES = Path(__file__).parent.parent / "cases"
PROBE = CASES / "measured" / "gel-probe.csv"
RECORD = CASES / "measured" / "raw-force-curve.txt"


@pytest.fixture(name="solved", scope="module")
def _solved(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("solved")
    python.save(python.solve(CASES / "gel.toml"), folder / "gel.h5")
    curve = python.transform(folder / "gel.h5", "40 mJ/m^2").curve
    for name, found, first in (("gel.csv", curve, 20), ("series.csv", python.read(folder / "gel.h5").series, 0)):
        write_table(folder / name, "a_m,delta_m,P_N", *(getattr(found, key)[first:] for key in ("a", "delta", "P")))
    specimen = python.Specimen((), python.HalfSpace(python.Elastic(1e5, 0.5)))
    tip = python.Problem(python.Sphere(5e-6), specimen, python.Loading("radius", 1e-6))
    python.save(python.solve(tip), folder / "tip.h5")
    return folder


@pytest.fixture(name="gel")
def _gel(solved: Path, tmp_path: Path) -> str:
    shutil.copytree(solved, tmp_path, dirs_exist_ok=True)
    return "gel.h5"


def _taken() -> Solution:
    return read_series(Path("series.csv"), python.load_case(CASES / "gel.toml").model.problem(), SeriesReading())


def plain(value: Any) -> Any:
    return json.loads(json.dumps(value, default=lambda unknown: unknown.reason))


def _silent(text: str) -> None:
    """Says nothing."""


MODULI = """[base]
method = "layered"
indenter = { shape = "paraboloid", radius = "1 mm" }
specimen.half_space = { E = "1 MPa", nu = 0.3 }
loading = { radius = "0.1 mm", points = 20 }
adhesion = { w = "50 mJ/m^2" }
[[axes]]
key = "specimen.half_space.nu"
values = [0.1, 0.3, 0.5]
"""


def timeless(value: Any) -> Any:
    if isinstance(value, dict):
        return {key: timeless(item) for key, item in value.items() if key not in TIMES}
    return [timeless(item) for item in value] if isinstance(value, list) else value


WAY = [0.0, 1.0, 2.0, 3.0, 4.0], [-1e-5, 2e-5, 0.0, 3e-5, -1e-4]
MADE: dict[str, tuple[str, Callable[[], Result]]] = {
    "check": ("check gel.toml", lambda: python.check(CASES / "gel.toml")),
    "look": ("look measured/raw-force-curve.txt --no-plots", lambda: python.look(RECORD)),
    "pull-off": ("pull-off gel.h5 --w 40mJ/m^2", lambda: python.pull_off("gel.h5", "40 mJ/m^2")),
    "pull-off by an instrument": ("pull-off gel.h5 --w 0.04 --stiffness 2kN/m",
        lambda: python.pull_off("gel.h5", 0.04, stiffness=["2 kN/m"])),
    "w of a pull-off": ("pull-off gel.h5 --load 1.2mN --uncertain R=1%",
        lambda: python.pull_off("gel.h5", load="1.2 mN", uncertain={"R": "1%"})),
    "transform": ("transform gel.h5 --w 40mJ/m^2 --no-plots", lambda: python.transform("gel.h5", "40 mJ/m^2")),
    "cycle": ("cycle gel.h5 --w-approach 35mJ/m^2 --w-retract 45mJ/m^2 --to-load 0.5mN --no-plots",
        lambda: python.cycle("gel.h5", "45 mJ/m^2", w_approach=0.035, to_load=5e-4)),
    "cycle by a program": ("cycle gel.h5 --w-approach 35mJ/m^2 --w-retract 0.045 --program way.csv --no-plots",
        lambda: python.cycle("gel.h5", 0.045, w_approach=0.035, program=python.Program(*WAY))),
    "cycle at speed": ("cycle gel.h5 --rate v0=1e-6,n=0.6 --speed 1e-4 --to-load 0.5mN --no-plots",
        lambda: python.cycle_at_speed("gel.h5", 0.035, {"v0": 1e-6, "n": 0.6}, 1e-4, to_load=5e-4)),
    "cycle of what relaxes": ("cycle soft.h5 --speed 10um/s --to-depth 50um --hold 5s --no-plots",
        lambda: python.cycle_relaxing("soft.h5", speed="10 um/s", to_depth="50 um", hold=5.0)),
    "cycle in the limits of what relaxes": ("cycle soft.h5 --w-approach 1mJ/m^2 --to-depth 50um --no-plots",
        lambda: python.cycle("soft.h5", "1 mJ/m^2", to_depth="50 um")),
    "work": ("work gel.h5 gel.csv --noise P=2uN --force --no-plots",
        lambda: python.work("gel.h5", "gel.csv", noise={"P": 2e-6})),
    "export": ("export gel.h5 --dem --w 40mJ/m^2 --force", lambda: Exported.of(python.transform("gel.h5", 0.04))),
    "import": ("import series.csv --case gel.toml -o taken.h5",
        lambda: Imported(Path("taken.h5"), _taken(), Path("series.csv"))),
    "compare": ("compare gel.h5 gel.h5", lambda: python.compare("gel.h5", "gel.h5")),
    "compare curves": ("compare gel.csv gel.csv", lambda: python.compare("gel.csv", "gel.csv")),
    "fit": ("fit gel.toml measured/gel-probe.csv --no-plots --force -o .",
        lambda: python.fit(str(CASES / "gel.toml"), PROBE)),
    "fit of a force curve": ("fit tip.h5 measured/raw-force-curve.txt --no-plots --force",
        lambda: python.fit("tip.h5", RECORD)),
    "pull-off map": ("study pull-off-map --q 1 --nu 0.3 --no-plots",
        lambda: python.study_map("pull-off", q=[1.0], nu=[0.3])),
    "sweep": ("sweep moduli.toml --no-plots -o swept",
        lambda: sweep(load_plan(Path("moduli.toml")), Path("swept"), Means(workers=1), False, _silent)),
    "one case of a sweep": ("sweep moduli.toml --only 1", lambda: alone(load_plan(Path("moduli.toml")), 1)),
    "fit of a law": ("fit gel.h5 speed.csv --law power --fix v0=1e-6 --fix n=0.6 --no-plots --force",
        lambda: python.fit("gel.h5", ["speed.csv"], law="power", fix={"v0": "1e-6", "n": "0.6"})),
    "fit of relaxation": ("fit soft.h5 soft.csv --free relaxation --relaxation sls --no-plots --force",
        lambda: python.fit("soft.h5", "soft.csv", relaxation="sls")),
    "fit of surface tension": ("fit ball.toml one.csv --fix surface_tension=1mN/m --no-plots --force",
        lambda: python.fit("ball.toml", ["one.csv"], fix={"surface_tension": "1 mN/m"})),
    "fit of force curves together": ("fit ball.toml one.csv two.csv --shared E_star,w --no-plots --force",
        lambda: python.fit("ball.toml", ["one.csv", "two.csv"], shared=["E_star", "w"])),
    "rate map": ("study rate-map --speed 1 --stiffness rigid --no-plots",
        lambda: python.study_map("rate", speed=[1.0], stiffness=["rigid"])),
    "roughness map": ("study roughness-map --rms 9nm --thickness 2um --no-plots",
        lambda: python.study_map("roughness", rms=["9 nm"], thickness=["2 um"])),
    "sticking map": ("study sticking-map --ratio 1 --nu 0.3 --no-plots",
        lambda: python.study_map("sticking", ratio=[1.0], nu=[0.3])),
    "transition map": ("study transition-map --q 1 --mu 1 --no-plots",
        lambda: python.study_map("transition", q=[1.0], mu=[1.0])),
    "adhesion map": ("study adhesion-map --q 1e-4 --mu 1 --load 1 --no-plots",
        lambda: python.study_map("adhesion", q=1e-4, mu=[1.0], load=[1.0])),
    "profile": ("profile gel.h5 --load 0.5mN --w 40mJ/m^2", lambda: python.profile("gel.h5", load="0.5 mN", w=0.04)),
    "show": ("show gel.h5", lambda: Shown([store.read_solution(Path("gel.h5"))])),
}  # fmt: skip


SLOW = {name for name in MADE if name.startswith("fit of")} - {"fit of a force curve"}
SLOW |= {"pull-off by an instrument", "cycle in the limits of what relaxes", "transition map", "adhesion map",
         "roughness map", "sticking map"}  # fmt: skip
TIMES = {"cpu_s"}  # no two solves take the same
INSIDE = {"look": "files", "pull-off": "results", "transform": "results", "work": "results"}


def _records() -> None:
    """Tables of what a device would record at a speed, on a body that relaxes, with a ball."""
    fast = python.cycle_at_speed("gel.h5", 0.035, {"v0": 1e-6, "n": 0.6}, 1e-4, to_load=5e-4).columns
    slow = python.cycle_relaxing("soft.h5", speed="10 um/s", to_depth="50 um", hold=5.0).columns
    for name, columns in (("speed.csv", fast), ("soft.csv", slow)):
        _, rows = np.unique(columns["t_s"], return_index=True)
        table = np.column_stack([np.asarray(columns[key])[rows] for key in ("t_s", "delta_m", "P_N")])
        np.savetxt(name, table, delimiter=",", header="t_s,delta_m,P_N", comments="")
    Path("ball.toml").write_text(BALL)
    for name in ("one.csv", "two.csv"):
        np.savetxt(name, np.column_stack(arrays()), delimiter=",", header="delta_m,P_N", comments="")


@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=pytest.mark.slow) if name in SLOW else name for name in MADE]
)
def test_command_and_python_say_the_same(jkr: Callable, gel: str, name: str) -> None:
    command, make = MADE[name]
    words = [CASES / word if (CASES / word).is_file() else word for word in command.split()]
    np.savetxt("way.csv", np.transpose(WAY), delimiter=",", header="t_s,x_m", comments="")
    Path("moduli.toml").write_text(MODULI)
    if "soft.h5" in words or (name in SLOW and words[0] == "fit"):
        assert jkr("run", CASES / "relaxing-gel.toml", "-o", "soft.h5").code == 0
    if name in SLOW and words[0] == "fit":
        _records()
    result, done = make(), jkr(*words, "--json")
    assert done.code == 0, done.err
    found = json.loads(done.out)
    if inside := INSIDE.get(command.split()[0]):
        (found,) = found[inside]
    assert timeless(plain(result.summary())) == timeless(found)
    assert str(result) in jkr(*words, "-v").out


def test_columns_of_any_result_are_a_data_frame() -> None:
    pytest.importorskip("pandas")
    result = python.study_map("pull-off", q=[0.1, 1.0], nu=[0.3])
    frame = result.to_pandas()
    assert list(frame.columns) == list(result.columns)
    assert len(frame) == 2


def arrays() -> tuple[np.ndarray, np.ndarray]:
    """Load over displacement of JKR on a half-space of E* = 2 MPa, R = 1 mm, w = 50 mJ/m^2."""
    a = np.linspace(3e-5, 9e-5, 40)
    root = np.sqrt(2 * np.pi * 0.05 * a / 2e6)
    return a**2 / 1e-3 - root, 4 * 2e6 * a**3 / 3e-3 - 2 * 2e6 * a * root


BALL = """
indenter = { shape = "paraboloid", radius = "1 mm" }
specimen.half_space = { E = "1.5 MPa", nu = 0.5 }
loading.radius = "0.1 mm"
"""


@pytest.mark.parametrize(
    ("columns", "said"),
    [
        ({}, "fit: give either what was measured or arrays of a, delta, P, t"),
        ({"delta": [1e-6, 2e-6], "P": [1.0]}, r"data: all columns must be one-dimensional and of one length, got "),
        ({"delta": [1e-6, 2e-6, float("nan")], "P": [1.0, 2.0, 3.0]}, "data: "),
    ],
)
def test_columns_that_are_no_curve_are_refused(columns: dict[str, Any], said: str) -> None:
    with pytest.raises(python.InputError, match=f"^{said}"):
        python.fit(python.parse_case(BALL), **columns)
