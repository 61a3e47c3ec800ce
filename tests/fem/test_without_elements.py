"""Without the wing: its method, its tables and what needs it are refused by its name, exact methods solve the rest."""

from collections.abc import Iterator

import pytest
from conftest import refused_by

import jkrcli
from jkrcli.base import wings
from jkrcli.base.errors import Refusal
from jkrcli.case.models import parse_case
from jkrcli.cli import call
from jkrcli.methods.protocol import METHODS, register

LACKING = 'needs the wing "fem", which this installation lacks'
LAYER = """
indenter = { shape = "paraboloid", radius = "50 um" }
specimen = { surface = "sticking", layers = [{ E = "1 MPa", nu = 0.45, thickness = "10 um" }] }
loading = { radius = "8 um", points = 20 }
"""


@pytest.fixture(autouse=True)
def _without(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    monkeypatch.setattr(wings, "wings", lambda: ())
    method = METHODS.pop("fem")
    yield
    register(method)  # at its place among the others


@pytest.mark.parametrize("line", ['method = "fem"', "mesh.width = 1e-3", 'contact.algorithm = "incremental"'])
def test_its_method_and_its_tables_are_refused_by_its_name(line: str) -> None:
    (told,) = refused_by(parse_case, f"{line}\n{LAYER}".encode(), "x.toml")
    assert told.endswith(f"{LACKING}: install the whole of jkrcli")


def test_a_profile_without_slip_is_refused_by_its_name_and_the_rest_is_solved() -> None:
    solution = jkrcli.solve(jkrcli.parse_case(LAYER))
    assert solution.method == "layered"
    assert jkrcli.pull_off(solution, 0.05)
    with pytest.raises(Refusal, match=f"^profile: method fem, which alone gives it here, {LACKING}"):
        jkrcli.profile(solution, a=5e-6)


def test_the_doctor_looks_for_no_mesher(capsys: pytest.CaptureFixture[str]) -> None:
    assert call(["doctor", "-v"]) == 0
    assert "gmsh" not in capsys.readouterr().out
