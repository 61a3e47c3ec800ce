"""The kernel that a series by ``hybrid`` keeps: what is solved further on the same bodies needs no finite elements."""

from collections.abc import Callable
from dataclasses import replace
from functools import cache
from pathlib import Path

import h5py
import numpy as np
import pytest

from jkrcli.adhesion.curve import CriticalPoint
from jkrcli.adhesion.finite_range import RangeRequest
from jkrcli.base.errors import InputError
from jkrcli.bodies.indenters import Sphere
from jkrcli.bodies.problem import Elastic, Graded, Layer, Linear, Loading, Problem, Rigid, Specimen
from jkrcli.case import store
from jkrcli.hybrid import correction
from jkrcli.hybrid.solver import Hybrid
from jkrcli.methods.integral.fredholm import COLUMNS
from jkrcli.resolve.analysis import analyse, method_behind, profile_columns
from jkrcli.series import Solution

W = 0.04
GEL, STIFF = Elastic(15e3, 0.499), Elastic(60e3, 0.3)
LOADING = Loading("radius", 1.2e-3, 30)
CYLINDER = Problem(Sphere(6e-3), Specimen((Layer(GEL, 3.6e-4),), Rigid(), 1.8e-3, "free"), LOADING)
GRADED = Layer(Graded(Linear(15e3, 30e3, 1e-3), 0.4), 1e-3)
BODIES = {
    "cylinder": CYLINDER,
    "wide, elastic indenter": Problem(
        Sphere(6e-3, STIFF), Specimen((Layer(GEL, 3.6e-4), Layer(STIFF, 4e-4)), Rigid()), LOADING
    ),
    "side alone": replace(CYLINDER, specimen=Specimen((GRADED,), Rigid(), 2.4e-3, "free")),
}


@pytest.fixture(name="systems")
def _systems(monkeypatch: pytest.MonkeyPatch) -> list[int]:
    seen: list[int] = []
    solved = correction._solved

    def counted(*arguments, **options):
        found = solved(*arguments, **options)
        seen.append(found.unknowns)
        return found

    monkeypatch.setattr(correction, "_solved", counted)
    return seen


@cache
def solved(name: str) -> Solution:
    return Hybrid()(BODIES[name])


def stored(name: str, path: Path) -> Solution:
    store.write_solution(path, solved(name))
    return store.read_solution(path)


@pytest.mark.first(1)
@pytest.mark.parametrize("name", BODIES)
def test_points_with_the_kept_kernel_agree_with_those_of_their_own(
    name: str, tmp_path: Path, systems: list[int]
) -> None:
    solution = stored(name, tmp_path / "x.h5")
    systems.clear()
    result = analyse(solution, [W])[0]
    points = {control: (point, result.pull_off_errors[control]) for control, point in result.pull_off.items()}
    assert not systems
    own = analyse(replace(solution, kernel=None), [W])[0]
    for control, (point, stated) in points.items():
        other, of_other = own.pull_off[control], own.pull_off_errors[control]
        assert systems
        assert isinstance(point, CriticalPoint)
        assert isinstance(other, CriticalPoint)
        for quantity in ("P", "delta"):
            assert abs(getattr(point, quantity) - getattr(other, quantity)) <= stated[quantity] + of_other[quantity]
            assert stated[quantity] <= 4 * of_other[quantity]  # measured: 0.5 to 3.0


@pytest.mark.first(2)
@pytest.mark.parametrize("name", BODIES)
def test_rows_solved_again_with_it_are_those_of_the_series(name: str, tmp_path: Path, systems: list[int]) -> None:
    solution = stored(name, tmp_path / "x.h5")
    systems.clear()
    for series in (solution, solution.scaled(3.0)):
        method = method_behind(series)
        assert method is not None
        again = method(replace(series.problem, loading=Loading.given("radius", tuple(series.series.a[::3].tolist()))))
        for column in COLUMNS:
            there, row = getattr(series.series, column)[::3], getattr(again.series, column)
            np.testing.assert_allclose(row, there, rtol=1e-7)
            errors = series.series.errors[column][::3]
            np.testing.assert_allclose(again.series.errors[column], errors, rtol=0.02, atol=1e-7 * there.max())
    assert not systems


def test_no_verb_solves_the_kernel_of_a_series_again(jkr: Callable, tmp_path: Path, systems: list[int]) -> None:
    stored("cylinder", tmp_path / "x.h5")
    systems.clear()
    for words in ("transform x.h5 --w 0.04 --no-plots", "pull-off x.h5 --w 0.04", "cycle x.h5 --w-approach 0.04"):
        assert jkr(*words.split()).code == 0, words
    assert not systems


@pytest.mark.slow
def test_other_bodies_and_larger_radii_have_a_kernel_of_their_own(tmp_path: Path, systems: list[int]) -> None:
    solution = stored("cylinder", tmp_path / "x.h5")
    method = method_behind(solution)
    assert method is not None
    softer = replace(CYLINDER, specimen=replace(CYLINDER.specimen, layers=(Layer(Elastic(15e3, 0.4), 3.6e-4),)))
    for problem in (softer, replace(CYLINDER, loading=Loading("radius", 1.3e-3, 30))):
        systems.clear()
        found, own = method(problem).series, Hybrid()(problem).series
        assert systems
        np.testing.assert_array_equal(found.P, own.P)


@pytest.mark.parametrize(
    ("a", "request_"),
    [(3e-4, RangeRequest()), pytest.param(1e-4, RangeRequest(stress=5e4), marks=pytest.mark.slow)],
    ids=["JKR", "of finite range"],
)
def test_pressures_use_it_as_far_as_it_reaches(
    a: float, request_: RangeRequest, tmp_path: Path, systems: list[int]
) -> None:
    solution = stored("cylinder", tmp_path / "x.h5")
    systems.clear()
    kept = profile_columns(solution, a, W, request_)
    assert not systems
    own = profile_columns(replace(solution, kernel=None), a, W, request_)
    assert systems
    assert kept["r_m"][-1] == pytest.approx(own["r_m"][-1], rel=1e-4)
    for name, column in kept.items():
        np.testing.assert_allclose(column, own[name], rtol=1e-3, atol=1e-4 * np.abs(own[name]).max())


@pytest.mark.parametrize(
    ("change", "word"),
    [
        (lambda file: file["kernel"].attrs.__setitem__("reach_m", -1.0), "attribute reach_m must be finite and > 0"),
        (lambda file: file["kernel/radii"].__setitem__(0, 1.0), "increasing radii"),
        (lambda file: file.__delitem__("kernel/weights"), 'dataset "kernel/weights" is missing'),
    ],
)
def test_a_wrong_kernel_is_refused_in_one_line(
    change: Callable[[h5py.File], None], word: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "x.h5"
    stored("cylinder", path)
    with h5py.File(path, "r+") as file:
        change(file)
    with pytest.raises(InputError, match="does not hold what was written"):
        store.read_solution(path)
    monkeypatch.setattr(store.hdf5, "is_sound", lambda _: True)
    with pytest.raises(InputError, match="kernel", check=lambda error: word in str(error)):
        store.read_solution(path)
