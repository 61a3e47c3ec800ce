"""Without the wing: its method is refused by its name, finite elements solve what they can."""

from collections.abc import Iterator
from functools import partial
from pathlib import Path

import pytest
from conftest import refused_by

import jkrcli
from jkrcli.adhesion.finite_range import AttractedBody
from jkrcli.base import wings
from jkrcli.base.errors import InputError, Refusal
from jkrcli.case.models import method_of, parse_case
from jkrcli.cli import call
from jkrcli.methods.protocol import METHODS, choose_method, method_class, register

LACKING = 'needs the wing "hybrid", which this installation lacks'
CYLINDER = """
indenter = { shape = "paraboloid", radius = "50 um" }
specimen = { radius = "60 um", side = "free", layers = [{ E = "1 MPa", nu = 0.45, thickness = "10 um" }] }
loading = { radius = "8 um", points = 20 }
"""


@pytest.fixture
def _without(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    monkeypatch.setattr(wings, "wings", lambda: ())
    method = METHODS.pop("hybrid")
    yield
    register(method)  # at its place among the others


@pytest.mark.usefixtures("_without")
def test_a_cylinder_is_for_finite_elements_and_the_method_is_refused_by_its_name() -> None:
    for line in ('method = "hybrid"\n', "hybrid.tolerance = 1e-4\n"):
        assert LACKING in refused_by(parse_case, (line + CYLINDER).encode(), "x.toml")[0]
    for asked in (method_class, partial(method_of, parse_case(CYLINDER.encode(), "x.toml").model)):
        with pytest.raises(InputError, match=LACKING):
            asked("hybrid")
    rigid, elastic = (
        parse_case(text.encode(), "x.toml").model.problem()
        for text in (CYLINDER, CYLINDER.replace('"50 um"', '"50 um", E = "1 GPa", nu = 0.3'))
    )
    assert choose_method(rigid, "auto", lambda name: method_class(name)()).name == "fem"
    refused = refused_by(choose_method, elastic, "auto", lambda name: method_class(name)())
    assert all("use" in line and "hybrid (install the whole of jkrcli)" in line for line in refused)
    with pytest.raises(Refusal, match=f"the kernel of a cylinder {LACKING}"):
        _ = AttractedBody(rigid).limit


@pytest.mark.usefixtures("_without")
def test_whoever_asks_for_the_method_is_told(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "x.toml").write_text(CYLINDER)
    assert call(["run", str(tmp_path / "x.toml"), "--method", "hybrid"]) == 2
    assert LACKING in " ".join(capsys.readouterr().err.split())
    assert LACKING in refused_by(jkrcli.solve, jkrcli.load_case(tmp_path / "x.toml"), "hybrid")[0]
