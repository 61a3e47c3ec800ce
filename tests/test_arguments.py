"""What a user gives in Python is what is meant, or is refused in one line that names the parameter and what is allowed:
wrong types, words, ranges and idle options are drawn for every public function and dataclass, by their annotations."""

from __future__ import annotations

import inspect
import math
import types
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import fields, is_dataclass
from functools import partial
from pathlib import Path
from typing import Annotated, Any, Literal, Union, get_args, get_origin, get_type_hints

import numpy as np
import pytest

import jkrcli as jkr
from jkrcli.base.arguments import as_arguments
from jkrcli.base.units import Ranged
from jkrcli.measured.curve import Curve

CASES = Path(__file__).parent.parent / "cases"
GEL, PROBE = CASES / "gel.toml", CASES / "measured" / "gel-probe.csv"
FILM, BULK = jkr.Elastic(1e6, 0.3), jkr.HalfSpace(jkr.Elastic(1e6, 0.3))
LINEAR = jkr.Linear(1e6, 2e6, 1e-6)
SPECIMEN, TIP, LOADING = jkr.Specimen((), BULK), jkr.Sphere(1e-3), jkr.Loading("radius", 1e-4)
MADE: dict[str, dict[str, Any]] = {  # right fields of every public dataclass
    "ClosedForm": {}, "FEM": {}, "Hybrid": {}, "Layered": {}, "Limits": {}, "Reading": {}, "Rigid": {},
    "Coated": {"layers": (jkr.Layer(FILM, 1e-6),), "core": FILM}, "Elastic": {"E": 1e6, "nu": 0.3},
    "Exponential": {"top": 1e6, "bottom": 2e6, "depth": 1e-6}, "Linear": {"top": 1e6, "bottom": 2e6, "depth": 1e-6},
    "Graded": {"law": LINEAR, "nu": 0.3}, "HalfSpace": {"material": FILM},
    "GradedTransverselyIsotropic": {"E_p": LINEAR, "E_z": 1e6, "nu_p": 0.3, "nu_zp": 0.3, "G_z": 1e6},
    "TransverselyIsotropic": {"E_p": 1e6, "E_z": 1e6, "nu_p": 0.3, "nu_zp": 0.3, "G_z": 1e6},
    "Layer": {"material": FILM, "thickness": 1e-6}, "Loading": {"to": "radius", "maximum": 1e-4},
    "LogRate": {"v0": 1e-6, "b": 1e-3}, "PowerRate": {"v0": 1e-6, "n": 0.5}, "Paraboloid": {"R": 1e-3},
    "FlatPunch": {"R": 1e-3},
    "Sphere": {"R": 1e-3}, "Power": {"top": 1e6, "length": 1e-6, "exponent": 0.5}, "PowerLaw": {"B": 1.0, "d": 2.0},
    "PowerRelaxation": {"time": 1.0, "exponent": 0.3}, "StandardSolid": {"ratio": 0.3, "time": 1.0},
    "KelvinVoigtSolid": {"ratio": 0.3, "retardation": 1.0},
    "Prony": {"weights": (0.3,), "times": (1.0,)}, "Pyramid": {"B": 1.0, "d": 1.0},
    "Problem": {"indenter": TIP, "specimen": SPECIMEN, "loading": LOADING},
    "Program": {"t": (0.0, 1.0), "x": (0.0, 1e-6)}, "RoundedCone": {"R": 1e-6, "half_angle": 0.5},
    "Roughness": {"rms": 1e-9, "longest": 1e-6, "shortest": 1e-7, "hurst": 0.8},
    "RoundedFlat": {"b": 1e-6, "edge_radius": 1e-7}, "Specimen": {"layers": (), "base": BULK},
    "TableProfile": {"r": (0.0, 1.0, 2.0), "heights": (0.0, 1.0, 4.0)},
    "Tabulated": {"depths": (0.0, 1e-6), "moduli": (1e6, 2e6)}, "Unknown": {"reason": "none"},
}  # fmt: skip
CALLED: dict[str, dict[str, Any]] = {  # right arguments of every public function, none of which is read or solved
    "check": {"case": "no.toml"}, "compare": {"first": "no.h5", "second": "no.h5"},
    "cycle": {"solved": "no.h5", "w": 0.04}, "cycle_relaxing": {"solved": "no.h5"},
    "cycle_at_speed": {"solved": "no.h5", "w": 0.04, "law": {"v0": 1e-6, "n": 0.5}},
    "find_value": {"file": "no.toml", "key": "indenter.radius", "load": 1e-6},
    "fit": {"body": "no.toml"}, "identify": {"body": "no.toml"}, "load_case": {"path": "no.toml"},
    "identify_joint": {"body": "no.toml", "measured": ["no.csv"]},
    "identify_law": {"body": "no.toml", "measured": ["no.csv"]},
    "identify_relaxation": {"body": "no.toml", "measured": "no.csv"},
    "identify_tension": {"body": "no.toml", "measured": ["no.csv"]}, "look": {"path": "no.csv"},
    "measured_curves": {"path": "no.csv"}, "parse_case": {"text": ""}, "plan": {"body": "no.toml", "found": None},
    "plot": {"curve": None}, "profile": {"solved": "no.h5", "a": 1e-6}, "pull_off": {"solved": "no.h5", "w": 0.04},
    "read": {"path": "no.h5"}, "save": {"solved": None, "path": "no.h5"}, "solve": {"problem": "no.toml"},
    "study_map": {"name": "pull-off"}, "summary": {"curve": None}, "table": {"curve": None},
    "to_pandas": {"curve": None}, "transform": {"solved": "no.h5", "w": 0.04},
    "work": {"solved": "no.h5", "measured": "no.csv"},
}  # fmt: skip
NO_KIND = {"t", "x"}  # of a program: arrays
FREE = {"Unknown"}  # any reason will do


def wrong_values(kind: Any, mapped: bool = False) -> Iterator[Any]:
    """Values that an annotation does not allow; ``mapped``: of an entry, where a mapping may be of many kinds."""
    origin, parts = get_origin(kind), get_args(kind)
    if origin is Annotated:
        notes = [note for note in kind.__metadata__ if isinstance(note, Ranged)]
        if not notes:
            yield from wrong_values(parts[0])
            if hasattr(kind.__metadata__[-1], "names"):
                yield from ("magic", "autoo")
            return
        yield from ("12 parrots", object(), [1.0, {}], True, math.nan, 1j, "", np.ma.masked, np.array([1.0, 2.0]))
        for limit, step in (("above", 0), ("least", -1), ("below", 0), ("most", 1)):
            if (end := getattr(notes[-1], limit)) is not None and not (end == 0 and notes[-1].words):
                yield end + step
    elif origin is Literal:
        yield from (f"{parts[0]}{parts[0]}", 3.7, object(), ["a"], "")
    elif origin in (Union, types.UnionType):
        kinds = [part for part in parts if part is not Any]
        single = [part for part in kinds if part is not type(None)]
        if len(single) == 1:
            yield from wrong_values(single[0])
        elif str not in single:
            yield object()
        if str in single or float in single:
            yield object()
    elif origin in (tuple, Iterable, Sequence, Collection, frozenset):
        yield {"a": 1}
        yield from ([one] for one in wrong_values(parts[0]) if parts[0] is not str)
    elif origin is Mapping:
        yield from ("w=1", 3, ["w"], object())
    elif kind is bool:
        yield from ("yes", 2, None, object())
    elif kind is int:
        yield from ("one", 1.5, None, object())
    elif kind is float:
        yield from ("12 parrots", object(), None)
    elif kind is str:
        yield from (3, object(), ["a"])
    elif isinstance(kind, type):
        yield from (object(), "none such", 3.7, kind)


def parameters_of(function: Callable[..., Any]) -> dict[str, Any]:
    plain = inspect.unwrap(function)
    called: Any = types.SimpleNamespace(__annotations__={**plain.__annotations__})
    called.__annotations__.pop("return", None)
    hints = get_type_hints(called, plain.__globals__, include_extras=True)
    return {name: hints[name] for name, item in inspect.signature(plain).parameters.items()
            if item.kind is not item.VAR_KEYWORD and hints[name] is not Any}  # fmt: skip


FUNCTIONS = [name for name in jkr.__all__ if inspect.isfunction(getattr(jkr, name))]
CLASSES = [name for name in jkr.__all__ if is_dataclass(getattr(jkr, name)) and name not in FREE]


def test_all_public_names_are_drawn() -> None:
    assert set(FUNCTIONS) <= set(CALLED)
    assert set(CLASSES) <= set(MADE)


def refused_by_name(call: Callable[[], Any], name: str, value: Any) -> None:
    with pytest.raises(jkr.JkrError) as caught:
        pytest.fail(f"{name} = {value!r} is taken: {call()}")
    assert name in str(caught.value), (value, str(caught.value))
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("name", CLASSES)
def test_wrong_fields_are_refused_by_name(name: str) -> None:
    kind, right = getattr(jkr, name), MADE[name]
    kind(**right)
    hints = get_type_hints(kind, include_extras=True)
    for item in fields(kind):
        if not item.init or item.name in NO_KIND:
            continue
        for value in wrong_values(hints[item.name]):
            if value is None and item.default is None:
                continue
            refused_by_name(partial(kind, **right | {item.name: value}), item.name, value)


@pytest.mark.parametrize("name", FUNCTIONS)
def test_wrong_arguments_are_refused_by_name(name: str) -> None:
    function, right = getattr(jkr, name), CALLED[name]
    for parameter, kind in parameters_of(function).items():
        for value in wrong_values(kind):
            refused_by_name(partial(function, **right | {parameter: value}), parameter, value)
    with pytest.raises(jkr.InputError, match=r"wronk|has no"):
        function(**right, wronk=1)


PULL: dict[str, Any] = {"solved": GEL, "w": 0.04}
RAW = {"body": GEL, "measured": PROBE}
PROGRAM = jkr.Program([0.0, 1.0], [0.0, 1e-6])
IDLE: list[tuple[Callable[..., Any], dict[str, Any], str]] = [
    (jkr.fit, {**RAW, "samples": 50}, "samples"), (jkr.fit, {**RAW, "seed": 3}, "seed"),
    (jkr.fit, {**RAW, "samples": 50, "confidence": "profile"}, "samples"),
    *((jkr.fit, {"body": GEL, "measured": [PROBE], "shared": ["w"], **one}, next(iter(one)))
      for one in ({"loss": "huber"}, {"samples": 50}, {"seed": 1}, {"model": "auto"}, {"uncertain": {"radius": "3%"}},
                  {"confidence": "bootstrap"})),
    (jkr.fit, {"body": GEL, "measured": [PROBE], "shared": ["w"], "slopes": "loocv", "tip_radii": ["1 mm"]}, "slopes"),
    *((jkr.fit, {"body": GEL, "measured": [PROBE], "law": "power", **one}, next(iter(one)))
      for one in ({"loss": "huber"}, {"samples": 50}, {"noise": {"P": 1e-9}}, {"confidence": "bootstrap"},
                  {"branch": "all"}, {"bound": {"w": "..1"}})),
    *((jkr.fit, {**RAW, "relaxation": "sls", **one}, next(iter(one)))
      for one in ({"terms": 2}, {"slopes": "integral"}, {"loss": "huber"}, {"start": {"time": 1}})),
    (jkr.cycle, {**PULL, "program": PROGRAM, "to_load": "1 mN"}, "to_load"),
    (jkr.cycle, {**PULL, "to_load": "1 mN", "to_depth": "1 um"}, "to_depth"),
    (jkr.cycle, {**PULL, "rest_load": "1 mN"}, "rest"),
    (jkr.cycle, {**PULL, "stress": 1e3, "w_approach": 0.02}, "one work of adhesion"),
    (jkr.work, {"solved": GEL, "measured": PROBE, "use": "a,P", "noise": {"delta": 1e-6}}, "noise delta"),
    *((jkr.cycle_at_speed, {**PULL, "law": {"v0": 1e-6, "n": 0.5}, "program": PROGRAM, **one}, next(iter(one)))
      for one in ({"speed": 1e-6}, {"hold": 1}, {"speed_approach": 1e-6}, {"to_depth": 1e-6})),
    *((jkr.cycle_relaxing, {"solved": GEL, "relaxation": jkr.StandardSolid(0.3, 1), "speed": 1e-6, **one},
       next(iter(one))) for one in ({"stress": 1e3}, {"compare_rate": True}, {"rest_load": 1e-3}, {"length": 1e-9})),
    (jkr.cycle_relaxing, {**PULL, "relaxation": jkr.StandardSolid(0.3, 1), "speed": 1e-6, "stress": 1e3,
                          "rest_load": 0, "hold": 3}, "hold"),
    (jkr.pull_off, {"solved": GEL, "load": 1e-3, "stress": 1e3}, "stress"),
    (jkr.pull_off, {**PULL, "uncertain": {"load": "5%"}}, "uncertain"),
    (jkr.pull_off, {"solved": GEL, "load": 1e-3, "stiffness": [1, 2]}, "stiffness"),
    (jkr.pull_off, {**PULL, "rest_depth": 1e-6}, "rest"), (jkr.pull_off, {**PULL, "load": 1}, "load"),
    (jkr.profile, {**PULL, "a": 1e-4, "load": 1e-3}, "load"), (jkr.profile, PULL, "give exactly one of a and load"),
    (jkr.transform, {**PULL, "stress": 1e3, "length": 1e-9}, "stress"),
]  # fmt: skip


@pytest.fixture(scope="module", name="gel")
def _gel() -> Any:
    return jkr.solve(GEL)


@pytest.fixture(scope="module", autouse=True)
def _made_results(gel: Any) -> None:
    """Results that wrong calls have beside what is wrong in them."""
    solved = jkr.solve(jkr.Problem(TIP, SPECIMEN, jkr.Loading("radius", 1e-4, 8)))
    curve = jkr.transform(solved, 0.04)
    for name, words in CALLED.items():
        words |= {key: solved if name == "save" else curve for key in ("curve", "solved") if words.get(key, 1) is None}
    CALLED["plan"]["found"] = jkr.fit(gel, PROBE)


@pytest.mark.parametrize(("function", "words", "named"), IDLE, ids=lambda one: getattr(one, "__name__", ""))
def test_what_would_have_no_effect_is_refused(gel, function, words, named) -> None:
    words = {key: gel if value is GEL else value for key, value in words.items()}
    with pytest.raises(jkr.InputError, match=named):
        function(**words)


def test_a_method_of_what_is_solved_and_a_reading_of_what_is_read(gel: Any) -> None:
    with pytest.raises(jkr.InputError, match=r"^method: is of what is not solved yet"):
        jkr.transform(gel, 0.04, method="fem")
    curve = jkr.measured_curves(PROBE)[0]
    with pytest.raises(jkr.InputError, match=r"^reading: is of what is not read yet"):
        jkr.fit(gel, curve, reading=jkr.Reading(flip="P"))


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ({"branch": "al"}, "fit.branch.*did you mean \"all\""), ({"noise": {"P": "1 um"}}, "noise: .*P.*force"),
        ({"segement": "both"}, "fit: has no parameter \"segement\", did you mean \"segment\""),
        ({"fix": {"w": [1]}}, "fix: \"w\" must be"), ({"bound": {"w": (0, 1)}}, "fit: w: must be a number"),
    ],
)  # fmt: skip
def test_options_of_a_fit(gel: Any, words: dict[str, Any], said: str) -> None:
    with pytest.raises(jkr.InputError, match=said):
        jkr.fit(gel, PROBE, **words)


def test_quantities_with_units_lists_and_numbers_of_numpy() -> None:
    by_text = jkr.Problem(
        jkr.Sphere("6 mm"),
        jkr.Specimen([jkr.Layer(jkr.Elastic("15 kPa", np.float32(0.5)), "0.36 mm")]),
        jkr.Loading("radius", "1.2 mm", np.int64(40)),
    )
    plain = jkr.Layer(jkr.Elastic(15e3, 0.5), 0.36e-3)
    assert by_text == jkr.Problem(jkr.Sphere(6e-3), jkr.Specimen((plain,)), jkr.Loading("radius", 1.2e-3, 40))
    assert by_text.key == jkr.Problem(jkr.Sphere(6e-3), jkr.Specimen(plain), jkr.Loading("radius", 1.2e-3, 40)).key
    table = jkr.Tabulated(np.array([0.0, 1e-6]), ["1 MPa", 2e6])
    assert table == jkr.Tabulated((0.0, 1e-6), (1e6, 2e6))
    assert jkr.Loading("load", "1 mN").maximum == 1e-3
    for wrong in (lambda: jkr.Loading("depht", 1e-6), lambda: jkr.Loading("depth", "1 mN")):
        with pytest.raises(jkr.InputError, match=r"loading\.(to|maximum): "):
            wrong()
    with pytest.raises(jkr.InputError, match=r"specimen.base: must be a Rigid or a HalfSpace, got the class Rigid"):
        jkr.Specimen(plain, jkr.Rigid)


def test_series_and_texts_are_lists_of_numbers() -> None:
    pandas = pytest.importorskip("pandas")
    table = pandas.DataFrame({"r": [0.0, 1e-6, 2e-6], "z": [0.0, 1e-9, 4e-9]})
    assert jkr.TableProfile(table["r"], table["z"]).r == (0.0, 1e-6, 2e-6)
    with pytest.raises(jkr.InputError, match=r"r: must be a list, got DataFrame"):
        jkr.TableProfile(table[["r"]], table["z"])
    program = jkr.Program(["0 ms", "20 ms"], [0, "1 um"])
    assert program.t.tolist() == [0.0, 0.02]
    assert program.x.tolist() == [0.0, 1e-6]
    with pytest.raises(jkr.InputError, match=r'program: t: entry 2 must be a time, got "1 m"'):
        jkr.Program(["0 s", "1 m"], [0, "1 um"])


@pytest.mark.parametrize(
    ("call", "said"),
    [
        (lambda gel: jkr.solve(GEL, jkr.Layered), r"got the class Layered: write Layered\(\.\.\.\)"),
        (lambda gel: jkr.cycle_relaxing(gel, jkr.StandardSolid, "1 um/s"), "relaxation: .*the class StandardSolid"),
        (lambda gel: jkr.transform(gel, 0.04, modulus_factor=1e300), r"modulus_factor: must be >= 1e-12 and <= 1e\+12"),
        (lambda gel: jkr.study_map("rate", rate="n=0.5"), "rate must be a mapping"),
        (lambda gel: jkr.Loading("radius", 1e-4, 5, "given", (1e-5, 1e-4)), "loading.values: are 2 up to 0.0001"),
        (lambda gel: jkr.Loading("radius", 1e-4, 5, "given", (1e-5, 1e-3)), "points and maximum say 5 up to 0.0001"),
        (lambda gel: jkr.Loading("radius", 1e-4, 2, values=(1e-5, 1e-4)), 'loading.values: are for spacing "given"'),
        (lambda gel: jkr.plot(jkr.transform(gel, 0.04), "curve.pdf"), "path: must end in .png or .svg, got curve.pdf"),
    ],
)
def test_what_ended_in_an_error_of_python_or_in_silence(gel: Any, call: Callable[[Any], Any], said: str) -> None:
    with pytest.raises(jkr.InputError, match=said):
        call(gel)


@pytest.mark.parametrize(
    ("call", "said"),
    [
        (lambda gel: jkr.measured_curves(PROBE, units={"Q": "nN"}), r'no single column "Q" for units=\{"Q": "nN"\}'),
        (lambda gel: jkr.fit(gel, PROBE, base_line="sine"), "base_line sine is for raw .* with contact fitted"),
        (lambda gel: jkr.identify_joint(gel, PROBE), "shared: needs two force curves"),
        (lambda gel: jkr.pull_off(gel, 0.04, rest_load=1e-3), "leave rest_load and rest_depth out"),
        (lambda gel: jkr.solve(GEL, "fem", jkr.Limits(1e-6)), r"raise the limit by limits\.memory"),
        (lambda gel: jkr.load_case(PROBE.with_name("gel.h5")), "gel.h5"),
    ],
)
def test_messages_name_arguments_and_no_options(gel: Any, call: Callable[[Any], Any], said: str) -> None:
    with pytest.raises(jkr.InputError, match=said, check=lambda error: "--" not in str(error)):
        call(gel)


def test_options_of_commands_and_names_of_files_stay() -> None:
    for text in ("jkr fit --surface both fits either", "my--unit.csv: is empty", "(import --nodes)?", "make chart --x"):
        assert as_arguments(text) == text


def test_equal_to_the_last_digit_may_be_asked_for(gel: Any) -> None:
    assert jkr.compare(gel, gel, rtol=0).rtol == 0


def test_many_numbers_are_within_their_range() -> None:
    values = np.linspace(1e-6, 1e-4, 50)
    assert jkr.Loading.given("radius", tuple(values)).values == tuple(values.tolist())
    for wrong in (0.0, math.nan, -1.0):
        with pytest.raises(jkr.InputError, match=r"loading.values: entry 7 must be"):
            jkr.Loading("radius", 1e-4, 50, "given", np.where(values == values[6], wrong, values).tolist())


def _columns() -> dict[str, Any]:
    curve = jkr.measured_curves(PROBE)[0]
    return {name: getattr(curve, name) for name in curve.measured if name in ("a", "delta", "P")}


def test_columns_as_users_have_them(gel: Any) -> None:
    pandas = pytest.importorskip("pandas")
    right = _columns()
    n = len(next(iter(right.values())))
    spoilt = {name: np.insert(values, 5, 1e3 * values[3]) for name, values in right.items()}
    mask = np.arange(n + 1) == 5
    kinds = {
        "lists": {name: values.tolist() for name, values in right.items()},
        "masked": {name: np.ma.array(values, mask=mask) for name, values in spoilt.items()},
        "gaps": {name: pandas.Series(values, dtype="Float64").where(~mask) for name, values in spoilt.items()},
        "none": {name: [None if i == 5 else x for i, x in enumerate(values)] for name, values in spoilt.items()},
    }
    found = {name: jkr.fit(gel, **columns) for name, columns in kinds.items()}
    found["frame"] = jkr.fit(gel, pandas.DataFrame(right))
    found["file"] = jkr.fit(gel, PROBE)
    delta, P = 1e6 * right["delta"], 1e9 * right["P"]
    found["units"] = jkr.fit(gel, {"indentation (um)": delta, "force (nN)": P, "a_m": right["a"]})
    by = jkr.Reading(units={"P": "nN", "delta": "um"})
    found["units told"] = jkr.fit(gel, delta=delta, P=P, a=right["a"], reading=by)
    for name, fit in found.items():
        assert fit.value("E_star") == pytest.approx(found["lists"].value("E_star"), rel=1e-9), name


def test_a_masked_value_of_a_curve_is_refused() -> None:
    with pytest.raises(jkr.InputError, match=r"P\[1\] is not finite"):
        Curve("one", delta=[1.0, 2.0], P=np.ma.array([1.0, 2.0], mask=[False, True]))


def test_one_file_is_a_list_of_one_and_no_list_of_letters() -> None:
    with pytest.raises(jkr.InputError, match=r"no-such-record.csv"):
        jkr.identify_joint(GEL, "no-such-record.csv")
    with pytest.raises(jkr.InputError, match=r"measured: must be a list"):
        jkr.identify_joint(GEL, {"P": [1.0]})
