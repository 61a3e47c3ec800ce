"""Inputs to the three readers that an hour of fuzzing by coverage (Atheris) found to go different ways, the smallest of
each: read, or refused in printable lines."""

from pathlib import Path

import pytest

from jkrcli.base.errors import InputError
from jkrcli.bodies.problem import Problem
from jkrcli.case.models import Case, load_case, parse_case, plain_toml
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
