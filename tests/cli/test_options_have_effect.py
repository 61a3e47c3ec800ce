"""No option is accepted without effect: of a verb it reaches what the verb does, of a method it changes the method."""

import ast
import inspect
import math
import re
import textwrap
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import click
import numpy as np
import pytest

from jkrcli import cli
from jkrcli.base.errors import InputError
from jkrcli.case.models import method_of, parse_case, places
from jkrcli.methods.protocol import METHODS

CASE = """
[indenter]
shape = "paraboloid"
radius = "1 mm"
[specimen]
layers = [{ thickness = "0.2 mm", E = "1 MPa", nu = 0.3 }]
[loading]
radius = "0.1 mm"
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


def _commands(group: click.Group, path: tuple[str, ...] = ()) -> Iterator[tuple[tuple[str, ...], click.Command]]:
    context = click.Context(group)
    for name in group.list_commands(context):
        command = group.get_command(context, name)
        assert command is not None
        if isinstance(command, click.Group):
            yield from _commands(command, (*path, name))
        else:
            yield (*path, name), command


@pytest.mark.parametrize("path", [path for path, _ in _commands(cli.jkr)], ids=" ".join)
def test_every_parameter_of_a_verb_is_read_by_it(path: tuple[str, ...]) -> None:
    command = dict(_commands(cli.jkr))[path]
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
    with pytest.raises(InputError) as caught:
        parse_case(f"{CASE}[mesh]\nzone_sizes = [0.01, 0.02, 0.3]\n".encode(), "my.toml")
    assert caught.value.lines == (
        'my.toml: mesh: zone_sizes belong to layout "zones"; the layout "scaled" takes spacing',
    )


@pytest.mark.parametrize("line", ["spacing = 0.05", "growth = 0.3"])
def test_sizes_beside_a_tolerance_are_refused(line: str) -> None:
    problem = parse_case(f"{CASE}[mesh]\ntolerance = 1e-3\n{line}\n".encode(), "my.toml").model
    reason = method_of(problem, "fem").refusal(problem.problem())
    assert reason is not None
    assert "mesh.spacing and mesh.growth follow from mesh.tolerance: leave them out" in reason


# ---------------------------------------------------------------------- what an option of a verb changes
SMALL = """
[indenter]
shape = "paraboloid"
radius = "1 mm"
[specimen]
half_space = { E = "1 MPa", nu = 0.3 }
[loading]
radius = "0.1 mm"
points = 12
[adhesion]
w = "50 mJ/m^2"
"""
SWEEP = """
base = "small.toml"
[[axes]]
key = "indenter.radius"
values = ["1 mm", "2 mm"]
[outputs]
quantities = ["pull_off"]
"""
BASES: dict[str, tuple[str, ...]] = {  # verbs, with what they are given in every run
    "new": ("mine.toml",), "check": ("small.toml",), "run": ("small.toml",),
    "import": ("table.csv", "--case", "small.toml", "--sort"), "mesh": ("small.toml",), "transform": ("small.h5",),
    "pull-off": ("small.h5",), "cycle": ("small.h5", "--w-approach", "20 mJ/m^2"),
    "profile": ("small.h5", "--a", "0.05 mm"), "fields": ("small.h5", "--a", "0.05 mm"),
    "export": ("small.h5", "--dem"), "explore": ("small.h5", "probe.csv"), "look": ("probe.csv",),
    "work": ("small.h5", "probe.csv"),
    "compare": ("small-w0.05.csv", "other-w0.05.csv", "--overlap", "0.5"), "sweep": ("sweep.toml",),
    "study pull-off-map": ("--nu", "0.3", "--q", "1", "--q", "2"),
    "study sticking-map": ("--nu", "0.3", "--ratio", "1", "--ratio", "2"),
    "study transition-map": ("--nu", "0.3", "--q", "1", "--mu", "1", "--mu", "2"),
    "study adhesion-map": ("--nu", "0.3", "--q", "1", "--mu", "1", "--mu", "2", "--load", "1"),
    "study rate-map": ("--speed", "1", "--stiffness", "rigid", "--thickness", "0.3"),
    "study roughness-map": ("--rms", "10 nm", "--rms", "20 nm", "--modulus", "1 MPa"),
    "show": ("small.h5",), "doctor": (), "completion": ("bash",),
    "bench": ("small.toml", "--repeat", "1"), "study converge": ("small.toml", "--levels", "2"),
}  # fmt: skip
VALUES: dict[str, tuple[str, ...]] = {  # what another value of an option is, where it is the same for all verbs
    "--w": ("30 mJ/m^2",), "--stress": ("1 kPa",), "--range": ("2 um",), "--slopes": ("integral",),
    "--modulus-factor": ("2",), "--stiffness": ("1 N/m",), "--load": ("1 mN",), "--method": ("layered",),
    "--tolerance": ("1e-4",), "--output": ("there",), "--dimensionless": ("dimensionless",), "--scale": ("radius",),
    "--a": ("0.06 mm",), "--w-approach": ("10 mJ/m^2",), "--w-retract": ("70 mJ/m^2",), "--to-load": ("0.1 mN",),
    "--to-depth": ("1 um",), "--rest-load": ("1 mN",), "--rest-depth": ("1 um",),
    "--points": ("9",), "--uncertain": ("E=5%",), "--rtol": ("0.9",), "--find": ("indenter.radius",),
    "--column": ("a=a_um",), "--overlap": ("0.9",), "--plot": ("there.png",), "--limit-time": ("1e-9 s",),
    "--limit-memory": ("1 KiB",), "--rate": ("v0=1 um/s,n=0.6",), "--rate-advance": ("v0=1 um/s,n=0.6",),
    "--speed": ("1 um/s",), "--speed-approach": ("1 um/s",), "--hold": ("1 s",), "--dwell": ("1 mN",),
    "--dwell-time": ("1 s",), "--program": ("no.csv",), "--nodes": ("no.csv",),
    "--relaxation": ("no.csv",), "--case": ("other.toml",),
    "--shape": ("cone",), "--radius": ("2 mm",), "--half-angle": ("80 deg",), "--cap": ("parabola",),
    "--E": ("2 MPa",), "--nu": ("0.4",),
    "--thickness": ("0.1 mm",), "--base": ("frictionless",), "--unit": ("P=mN",), "--factor": ("P=2",),
    "--zero": ("delta=0.1 um",), "--sign": ("as-is",), "--area": ("projected",), "--separator": ("tab",),
    "--decimal": (",",), "--component": ("rr",), "--flip": ("P",), "--contact": ("estimate",),
    "--sensitivity": ("45 nm/V",), "--format": ("afm",), "--rows": ("5..30",), "--where": ("segment=retract",),
    "--segment": ("retract",),
    "--noise": ("P=3 uN",),
    "--use": ("delta,P",), "--window": ("7",), "--only": ("1",), "--show-case": ("1",), "--hours": ("0",),
    "--contact-shape": ("any",), "--roughness": ("rms=9nm,longest=1um,shortest=100nm,hurst=0.8",),
    "--surface-energy": ("20 mJ/m^2",), "--sizes": ("0.8 mm..1.2 mm",),
    "--rms": ("50 nm",), "--modulus": ("2 MPa",), "--longest": ("9 um",), "--shortest": ("50 nm",), "--hurst": ("0.7",),
    "--q": ("3",), "--beta": ("0.1",), "--ratio": ("3",), "--mu": ("3",),
}  # fmt: skip
OWN: dict[tuple[str, str], tuple[str, ...]] = {  # and where it is not
    ("compare", "--column"): ("a",), ("new", "--example"): ("gel",),
    ("study rate-map", "--rate"): ("n=0.5",), ("study rate-map", "--speed"): ("2",),
    ("study rate-map", "--stiffness"): ("1",), ("study rate-map", "--thickness"): ("0.5",),
    ("study adhesion-map", "--load"): ("2",),
    ("import", "--area"): ("surface",),
    ("import", "--column"): ("a=delta_um",), ("look", "--column"): ("P=a_um",), ("work", "--column"): ("P=a_um",),
    ("explore", "--column"): ("P=a_um",),
    ("bench", "--repeat"): ("2",), ("study converge", "--levels"): ("3",),
    ("study converge", "--contact"): ("incremental",), ("export", "--name"): ("other",),
}  # fmt: skip
TIMES = {  # what of the output they are, where they are no numbers with a unit
    "bench": r"\d+\.\d+", "study converge": r"(?m)[\d.]+ *$|CPU seconds .*"}  # fmt: skip
# How much is said, whether a file of another's is replaced, where it is computed: none changes what is.
EXEMPT = {"--force", "--quiet", "--verbose", "--workers", "--scheduler"}


def _options(verb: str) -> list[click.Option]:
    command = dict(_commands(cli.jkr))[tuple(verb.split())]
    return [each for each in command.params if isinstance(each, click.Option) and each.opts[-1] not in EXEMPT]


def _measured() -> str:
    """Rows of a contact that is pulled off, with noise: JKR of ``SMALL``, in SI."""
    rng, E_star, R, w = np.random.default_rng(1), 1e6 / 0.91, 1e-3, 0.05
    a = np.linspace(9e-5, 5.8e-5, 40)
    t = np.sqrt(2 * math.pi * a * w / E_star)
    delta, P = a**2 / R - t, 4 * E_star * a**3 / (3 * R) - 2 * E_star * a * t
    rows = zip(np.arange(40), a * 1e6, delta * 1e6, P * 1e6 + rng.normal(0, 3, 40), strict=True)
    return "t_s,a_um,delta_um,P_uN,segment\n" + "".join(
        ",".join(f"{value:.8g}" for value in row) + (",approach\n" if row[0] < 4 else ",retract\n") for row in rows
    )


def _timeless(name: str, text: bytes) -> bytes:
    """What a file holds, but for times, which series and pictures hold too."""
    timed = "convergence" in name
    if name.endswith(".h5") or (timed and name.endswith((".svg", ".png"))):
        return b""
    return re.sub(rb"(?m),[\d.]+$|.*(cpu|time).*", b"", text) if timed else text


def _left(folder: Path) -> dict[str, bytes]:
    return {str(path.relative_to(folder)): path.read_bytes() for path in sorted(folder.rglob("*")) if path.is_file()}


def test_every_option_of_every_verb_is_tried() -> None:
    """Those of ``fit`` are in ``test_fit_options.py``."""
    assert {" ".join(path) for path, _ in _commands(cli.jkr)} == {*BASES, "fit"}
    for verb in BASES:
        names = {each.opts[-1] for each in _options(verb) if not each.is_flag}
        assert names <= {*VALUES, *(name for owner, name in OWN if owner == verb)}, verb


@pytest.mark.slow
@pytest.mark.parametrize("verb", BASES)
def test_every_option_of_a_verb_changes_what_it_says_or_leaves_or_is_refused(
    jkr: Any, tmp_path: Path, verb: str
) -> None:
    (tmp_path / "small.toml").write_text(SMALL)
    (tmp_path / "other.toml").write_text(SMALL.replace("1 MPa", "1.5 MPa").replace("0.1 mm", "0.06 mm"))
    (tmp_path / "sweep.toml").write_text(SWEEP)
    (tmp_path / "probe.csv").write_text(_measured())
    (tmp_path / "table.csv").write_text(
        "area_um2,delta_um,P_uN\n"
        + "".join(f"{math.pi * a * a},{a * a / 1e3},-{4e3 / 2.73 * (a / 1e3) ** 3 * 1e3}\n" for a in range(90, 9, -10))
    )
    assert jkr("run", "small.toml", "--method", "closed-form").code == 0
    assert jkr("run", "other.toml", "--method", "closed-form").code == 0
    if verb == "compare":
        assert jkr("transform", "small.h5", "other.h5", "--no-plots").code == 0
    before = _left(tmp_path)

    def tried(*words: str) -> tuple[int, str, dict[str, bytes]]:
        """Exit code, output, and the files, but for those of the series and pictures, which hold times."""
        for name in set(_left(tmp_path)) - set(before):
            (tmp_path / name).unlink()
        outcome = jkr(*verb.split(), *words)
        left = {name: _timeless(name, text) for name, text in _left(tmp_path).items()}
        said = re.sub(TIMES.get(verb, r"[\d.]+ m?s\b"), "", outcome.out + outcome.err)
        return outcome.code, said, left

    plain = tried(*BASES[verb])
    without = []
    for option in _options(verb):
        name = (option.secondary_opts or option.opts if option.default is True else option.opts)[-1]
        words = () if option.is_flag else OWN.get((verb, name)) or VALUES[name]
        other = plain
        if option.is_flag and name in BASES[verb]:
            other = tried(*(word for word in BASES[verb] if word != name))
        if tried(*BASES[verb], name, *words) == other:
            without.append(name)
    assert not without, " ".join(without)
