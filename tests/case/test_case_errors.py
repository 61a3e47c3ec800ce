"""Wrong case files: every mistake is one whole line with file, key, value and what is allowed."""

import pytest

from jkrcli.base.errors import InputError
from jkrcli.bodies.indenters import SHAPES
from jkrcli.case.models import load_case, parse_case

GOOD = """
[indenter]
shape = "sphere"
radius = "100 um"
[specimen.half_space]
E = "5 GPa"
nu = 0.4
[loading]
depth = "3 um"
"""
LENGTHS = "(allowed: m, pm, nm, um, mm, km, cm, Å)"
MODULI = "(allowed: Pa, kPa, MPa, GPa, TPa, N/m^2, kN/m^2, N/mm^2)"

ONE_CHANGE = {
    "negative radius": ("100 um", "-100 um", "indenter.radius: must be > 0, got -100 um"),
    "zero radius": ('"100 um"', "0", "indenter.radius: must be > 0, got 0 m"),
    "radius is a bool": ('"100 um"', "true", "indenter.radius: must be a length, got true"),
    "radius is nan": ('"100 um"', "nan", "indenter.radius: must be a finite number, got nan m"),
    "radius is inf": ('"100 um"', "inf", "indenter.radius: must be a finite number, got inf m"),
    "wrong unit": (
        "100 um",
        "100 kPa",
        f'indenter.radius: must be a length, got "100 kPa": unknown unit "kPa" {LENGTHS}',
    ),
    "misspelt unit": (
        "5 GPa",
        "5 Gpa",
        f'specimen.half_space.E: must be a modulus, got "5 Gpa": unknown unit "Gpa", did you mean "GPa"? {MODULI}',
    ),
    "unit in capitals": (
        "5 GPa",
        "5 KPa",
        f'specimen.half_space.E: must be a modulus, got "5 KPa": unknown unit "KPa", did you mean "kPa"? {MODULI}',
    ),
    "unit of small letters": (
        "5 GPa",
        "5 mPa",
        f'specimen.half_space.E: must be a modulus, got "5 mPa": unknown unit "mPa", did you mean "MPa"? {MODULI}',
    ),
    "decimal comma": (
        "100 um",
        "1,5 um",
        f'indenter.radius: must be a length, got "1,5 um": unknown unit ",5 um" {LENGTHS}',
    ),
    "no number": ("100 um", "large", 'indenter.radius: must be a length, such as "100 um", got "large"'),
    "nu above one half": ("nu = 0.4", "nu = 0.51", "specimen.half_space.nu: must be > -1 and <= 0.5, got 0.51"),
    "nu is minus one": ("nu = 0.4", "nu = -1", "specimen.half_space.nu: must be > -1 and <= 0.5, got -1"),
    "nu is nan": ("nu = 0.4", "nu = nan", "specimen.half_space.nu: must be a finite number, got nan"),
    "negative E": ("5 GPa", "-3 Pa", "specimen.half_space.E: must be > 0, got -3 Pa"),
    "missing nu": ("nu = 0.4", "", "specimen.half_space.nu: is required"),
    "unknown key": (
        "radius =",
        "raduis =",
        'indenter.raduis: unknown key, did you mean "radius"? (allowed: E, nu, layers, shape, radius)',
    ),
    "radius of the specimen under a sphere": (
        "radius =",
        "counter_radius = 1e-3\nradius =",
        'indenter.counter_radius: unknown key: the radius of a spherical specimen needs shape = "paraboloid"; omit it '
        "on a flat specimen (allowed: E, nu, layers, shape, radius)",
    ),
    "unknown shape": (
        '"sphere"',
        '"spere"',
        f'indenter.shape: must be one of {", ".join(SHAPES)}, got "spere", did you mean "sphere"?',
    ),
    "missing shape": ('shape = "sphere"', "", "indenter.shape: is required"),
    "two goals": (
        'depth = "3 um"',
        'depth = "3 um"\nload = 1',
        "loading: needs exactly one of depth, load, radius, got depth and load",
    ),
    "no goal": ('depth = "3 um"', "", "loading: needs exactly one of depth, load, radius, got none"),
    "falling depths": ('"3 um"', "[2e-6, 1e-6]", "loading: the values of depth must increase, got [2e-06, 1e-06]"),
    "bad item of a list": ('"3 um"', '[1e-6, "x"]', 'loading.depth[1]: must be a length, such as "100 um", got "x"'),
    "points is no integer": ('"3 um"', '"3 um"\npoints = 10.5', "loading.points: must be a whole number, got 10.5"),
    "no points": ('"3 um"', '"3 um"\npoints = 0', "loading.points: must be >= 1, got 0"),
    "spacing": (
        '"3 um"',
        '"3 um"\nspacing = "deep"',
        'loading.spacing: must be one of radius, depth, load, log, got "deep", did you mean "depth"?',
    ),
    "negative w": ('depth = "3 um"', 'depth = "3 um"\n[adhesion]\nw = -1', "adhesion.w: must be >= 0, got -1 J/m^2"),
    "table is a number": (
        'depth = "3 um"',
        'depth = "3 um"\n[mesh]\norder = 3',
        "mesh.order: must be one of 1, 2, got 3",
    ),
}


@pytest.mark.parametrize("name", ONE_CHANGE)
def test_one_mistake_gives_its_whole_line(name: str) -> None:
    old, new, line = ONE_CHANGE[name]
    assert GOOD.count(old) == 1
    with pytest.raises(InputError) as caught:
        parse_case(GOOD.replace(old, new).encode(), "my.toml")
    assert caught.value.lines == (f"my.toml: {line}",)


def test_all_mistakes_are_reported_at_once() -> None:
    text = """
    metod = "fem"
    [indenter]
    shape = "cone"
    half_angle = "100 deg"
    [specimen]
    base = "bondd"
    [[specimen.layers]]
    thickness = "1 um"
    E = "1 MPa"
    nu = 0.3
    [[specimen.layers]]
    thickness = "-1 um"
    E = "-3 Pa"
    nu = 0.3
    [loading]
    load = "1 mN"
    """
    with pytest.raises(InputError) as caught:
        parse_case(text.encode(), "my.toml")
    assert caught.value.lines == (
        "my.toml: indenter.half_angle: must be > 0 and < 1.5708, got 100 deg",
        'my.toml: metod: unknown key, did you mean "method"? (allowed: title, method, indenter, specimen, loading, '
        "adhesion, mesh, contact, layered, hybrid)",
        'my.toml: specimen.base: must be one of bonded, frictionless, got "bondd", did you mean "bonded"?',
        "my.toml: specimen.layers[1].E: must be > 0, got -3 Pa",
        "my.toml: specimen.layers[1].thickness: must be > 0, got -1 um",
    )


WHOLE_FILES = {
    "empty": (b"", ["indenter: is required", "loading: is required", "specimen: is required"]),
    "not toml": (
        b"[indenter\n",
        ["is not valid TOML: expected ']' at the end of a table declaration (at line 1, column 10)"],
    ),
    "twice the same key": (b"a = 1\na = 2\n", ["is not valid TOML: cannot overwrite a value (at line 2, column 6)"]),
    "a sweep": (b"base = 'x.toml'\n[[axes]]\nkey = 'E'", ["is a sweep file, not a case: jkr sweep runs it"]),
    "binary": (b"\x89HDF\r\n", ["is not a text file (byte 0 is not UTF-8)"]),
    "wrong types": (
        b"indenter = 3\nspecimen = []\nloading = 'x'",
        ["indenter: must be a table, got 3", 'loading: must be a table, got "x"', "specimen: must be a table, got []"],
    ),
    "empty specimen": (
        b"[indenter]\nshape='paraboloid'\nradius=1\n[specimen]\n[loading]\ndepth=0.1",
        ["specimen: is empty: give [specimen.half_space] with E and nu, or [[specimen.layers]]"],
    ),
    "two bases": (
        b"[indenter]\nshape='paraboloid'\nradius=1\n[specimen]\nbase='bonded'\nhalf_space={E=1,nu=0.3}\n[loading]\ndepth=0.1",
        ["specimen: give either base (rigid) or half_space (elastic) below the layers, got both"],
    ),
    "half an elastic indenter": (
        b"[indenter]\nshape='sphere'\nradius=1\nE=1\n[specimen.half_space]\nE=1\nnu=0.3\n[loading]\ndepth=0.1",
        ["indenter: an elastic indenter needs both E and nu (leave both out for a rigid one)"],
    ),
    "cavity too small": (
        b"[indenter]\nshape='paraboloid'\nradius=1\ncounter_radius=-0.5\n[specimen.half_space]\nE=1\nnu=0.3\n[loading]\ndepth=0.1",
        ["indenter: counter_radius must be > 0, or < -radius for a cavity that the indenter fits, got -0.5 m"],
    ),
    "concave profile": (
        b"[indenter]\nshape='table'\nr=[0,1,2,3]\nf=[0,1,1.5,3]\n[specimen.half_space]\nE=1\nnu=0.3\n[loading]\ndepth=0.1",
        [
            "indenter: profile table: must be convex, the slope falls at point 2 (r = 1 m); JKR needs a contact "
            "disc that only grows: remove that point, or for measured points say how much they scatter: noise = "
            '"0.05 nm"'
        ],
    ),
    "missing profile": (
        b"[indenter]\nshape='table'\nfile='no.csv'\n[specimen.half_space]\nE=1\nnu=0.3\n[loading]\ndepth=0.1",
        ["indenter: no.csv: profile file not found"],
    ),
}


@pytest.mark.parametrize("name", WHOLE_FILES)
def test_wrong_file(name: str) -> None:
    content, lines = WHOLE_FILES[name]
    with pytest.raises(InputError) as caught:
        parse_case(content, "my.toml")
    assert caught.value.lines == tuple(f"my.toml: {line}" for line in lines)


def test_missing_file_suggests_a_neighbour(tmp_path) -> None:
    (tmp_path / "halfspace.toml").write_text(GOOD)
    with pytest.raises(InputError) as caught:
        load_case(tmp_path / "halfspce.toml")
    path = tmp_path
    assert caught.value.lines == (f'{path}/halfspce.toml: case file not found, did you mean "{path}/halfspace.toml"?',)


def test_folder_instead_of_file(tmp_path) -> None:
    with pytest.raises(InputError) as caught:
        load_case(tmp_path)
    assert caught.value.lines == (f"{tmp_path}: is a folder, not a case file",)
