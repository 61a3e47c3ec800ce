"""Inputs to the three readers that an hour of fuzzing by coverage (Atheris) found to go different ways, the smallest of
each: read, or refused in printable lines."""

import json
import math
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest
from series_files import edit

from jkrcli.base.errors import InputError
from jkrcli.bodies.problem import Problem
from jkrcli.case import store
from jkrcli.case.models import Case, load_case, parse_case, plain_toml
from jkrcli.case.store import solve
from jkrcli.measured import files as measured
from jkrcli.resolve import foreign

CORPUS = Path(__file__).parent / "corpus"
BODY = b"""
indenter = { shape = "paraboloid", radius = "6 mm" }
specimen.half_space = { E = "5 MPa", nu = 0.4 }
loading = { radius = "20 um", points = 20 }
"""
READINGS = (  # by the first letter of a table's name; 4: a series, 5: measured columns
    measured.Reading(),
    measured.Reading(contact="estimate"),
    measured.Reading(stiffness=0.3, sensitivity=1e-7, incomplete=True),
    measured.Reading(format="text"),
)


def of(kind: str) -> list[Path]:
    return sorted((CORPUS / kind).iterdir())


def judged(error: InputError) -> None:
    assert error.lines
    assert all(map(str.isprintable, error.lines))


@pytest.fixture(name="problem")
def _problem() -> Problem:
    return parse_case(BODY, "body").model.problem()


@pytest.mark.parametrize("path", of("cases"), ids=lambda path: path.stem)
def test_cases(path: Path) -> None:
    try:
        model = load_case(path).model
    except InputError as error:
        judged(error)
        return
    text = Case(model, "x").to_toml()
    assert parse_case(text.encode(), "again").model.problem().key == model.problem().key
    assert all(map(str.isprintable, plain_toml(text).split("\n")))


@pytest.mark.parametrize("path", of("tables"), ids=lambda path: path.stem)
def test_tables(path: Path, problem: Problem) -> None:
    reader = int(path.stem[0])
    try:
        if reader < len(READINGS):
            for found in measured.each(path, READINGS[reader]):
                if isinstance(found, InputError):
                    judged(found)
        elif reader == 4:
            foreign.read_series(path, problem, foreign.SeriesReading())
        else:
            measured.read(path)
    except InputError as error:
        judged(error)


def value(told: Any) -> Any:
    """What JSON cannot hold: arrays, and numbers that are none."""
    if isinstance(told, dict) and "array" in told:
        return np.array([float(x) for x in told["array"]]).reshape(told["shape"])
    return float(told["float"]) if isinstance(told, dict) else told


def change(file: h5py.File, what: str, name: str, *how: Any) -> None:
    """One change of a series file: of a member, an attribute or a number in a column."""
    match what:
        case "delete":
            del file[name]
        case "group":
            del file[name]
            file.create_group(name)
        case "set":
            del file[name]
            file[name] = value(how[0])
        case "move":
            file.move(name, how[0])
        case "attribute":
            file[name].attrs[how[0]] = value(how[1])
        case "without":
            del file[name].attrs[how[0]]
        case "cell":
            file[name][how[0]] = value(how[1])


@pytest.mark.parametrize("path", of("series"), ids=lambda path: path.stem)
def test_series(path: Path, tmp_path: Path) -> None:
    target = tmp_path / "x.h5"
    store.write_solution(target, solve(parse_case(BODY, "body"))[1])

    def changes(file: h5py.File) -> None:
        for told in json.loads(path.read_text(encoding="utf-8")):
            try:
                change(file, *told)
            except (KeyError, ValueError, TypeError, OSError, RuntimeError, OverflowError, IndexError):
                continue  # of a part that an earlier one took away

    edit(target, changes)
    try:
        found = store.read_solution(target, with_pressure=True)
    except InputError as error:
        judged(error)
        return
    assert all(math.isfinite(x) for x in (*found.series.a, *found.series.delta, *found.series.P))
