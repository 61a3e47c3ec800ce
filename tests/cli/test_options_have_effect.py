"""No option is accepted without effect: of a verb it reaches what the verb does, of a method it changes the method."""

import ast
import inspect
import textwrap
from collections.abc import Callable

import click
import pytest
from conftest import refused_by
from every_verb import commands

from jkrcli import cli
from jkrcli.case.models import method_of, parse_case, places
from jkrcli.methods.protocol import METHODS

CASE = """
indenter = { shape = "paraboloid", radius = "1 mm" }
specimen.layers = [{ thickness = "0.2 mm", E = "1 MPa", nu = 0.3 }]
loading.radius = "0.1 mm"
"""
OTHERS = {  # what to write for another value of an option, where that is not half its default
    "layout": 'layout = "zones"', "element": 'element = "quadrilateral"', "order": "order = 1",
    "formulation": 'formulation = "mixed"', "element_size": 'element_size = "5 um"\nlayout = "zones"',
    "zone_sizes": 'zone_sizes = [0.01, 0.02, 0.3]\nlayout = "zones"', "depth": 'depth = "20 mm"',
    "width": 'width = "20 mm"', "contact_radius": 'contact_radius = "0.2 mm"', "growth": "growth = 0.3",
    "margin": "margin = 1.3", "edge_correction": "edge_correction = false", "estimate_error": "estimate_error = false",
    "tolerance": "tolerance = 1e-3", "solver": 'solver = "superlu"', "contact": 'algorithm = "incremental"',
    "integration": 'integration = "reduced"\norder = 1\nelement = "quadrilateral"\nlayout = "zones"',
}  # fmt: skip


@pytest.mark.parametrize("path", [path for path, _ in commands(cli.jkr)], ids=" ".join)
def test_every_parameter_of_a_verb_is_read_by_it(path: tuple[str, ...]) -> None:
    command = dict(commands(cli.jkr))[path]
    assert command.callback is not None
    body = ast.parse(textwrap.dedent(inspect.getsource(inspect.unwrap(command.callback)))).body[0]
    assert isinstance(body, ast.FunctionDef)
    read = {node.id for part in body.body for node in ast.walk(part) if isinstance(node, ast.Name)}
    given = {argument.arg for argument in (*body.args.args, *body.args.kwonlyargs)}
    assert given <= read


@pytest.mark.parametrize(
    ("method", "option"), [(name, option) for name, known in METHODS.items() for option in places(known)]
)
def test_every_option_of_a_method_changes_it(method: str, option: str) -> None:
    place = places(METHODS[method])[option]
    plain = parse_case(CASE.encode(), "plain.toml").model
    line = OTHERS.get(option) or f"{place.key} = {place.default / 2!r}"
    other = parse_case(f"{CASE}[{place.table}]\n{line}\n".encode(), "other.toml").model
    assert getattr(method_of(plain, method), option) != getattr(method_of(other, method), option)


def test_sizes_of_another_layout_are_refused() -> None:
    assert refused_by(parse_case, f"{CASE}[mesh]\nzone_sizes = [0.01, 0.02, 0.3]\n".encode(), "my.toml") == (
        'my.toml: mesh: zone_sizes belong to layout "zones"; the layout "scaled" takes spacing',
    )


@pytest.mark.parametrize("line", ["spacing = 0.05", "growth = 0.3"])
def test_sizes_beside_a_tolerance_are_refused(line: str) -> None:
    problem = parse_case(f"{CASE}[mesh]\ntolerance = 1e-3\n{line}\n".encode(), "my.toml").model
    reason = method_of(problem, "fem").refusal(problem.problem())
    assert reason is not None
    assert "mesh.spacing and mesh.growth follow from mesh.tolerance: leave them out" in reason


def test_every_option_of_every_verb(jkr: Callable) -> None:
    tried = 0
    for words, command in commands(cli.jkr):
        for option in command.params:
            if not isinstance(option, click.Option) or option.is_flag or option.count:
                continue
            name = max(option.opts, key=len)
            keyed = option.multiple and getattr(option.type, "keyed", False)
            if option.multiple and not keyed:
                continue
            arguments = ["x"] * sum(isinstance(item, click.Argument) for item in command.params)
            given = [name, "P=1", name, "P=2"] if keyed else [name, "1", name, "2"]
            done = jkr(*words, *arguments, *given)
            assert done.code == 2, (words, name)
            said = f"{name}: P is given twice" if keyed else f"{name} is given 2 times"
            assert said in done.err or "must be KEY=" in done.err, (words, name, done.err)
            tried += 1
    assert tried > 150


@pytest.mark.parametrize("flags", [("--json", "--json"), ("-q", "-q"), ("--w", "1", "--w", "2")])
def test_flags_and_options_of_several_values_may_be_repeated(flags: tuple[str, ...], jkr: Callable) -> None:
    assert "is given" not in jkr("transform", "missing.h5", *flags).err
