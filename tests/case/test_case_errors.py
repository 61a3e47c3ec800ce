"""Wrong case files: every mistake is one line with file, key, value and what is allowed."""

import pytest
from conftest import refused_by

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

WRONG_MODULUS = "specimen.half_space.E: must be a modulus, got"
ONE_CHANGE = [  # what is changed, into what, and how the one line begins
    ("100 um", "-100 um", "indenter.radius: must be > 0, got -100 um"),
    ('"100 um"', "0", "indenter.radius: must be > 0, got 0 m"),
    ('"100 um"', "true", "indenter.radius: must be a length, got true"),
    ('"100 um"', "nan", "indenter.radius: must be a finite number, got nan m"),
    ('"100 um"', "inf", "indenter.radius: must be a finite number, got inf m"),
    ("100 um", "100 kPa", f'indenter.radius: must be a length, got "100 kPa": unknown unit "kPa" {LENGTHS}'),
    ("5 GPa", "5 Gpa", f'{WRONG_MODULUS} "5 Gpa": unknown unit "Gpa", did you mean "GPa"? {MODULI}'),
    ("5 GPa", "5 KPa", f'{WRONG_MODULUS} "5 KPa": unknown unit "KPa", did you mean "kPa"?'),
    ("5 GPa", "5 mPa", f'{WRONG_MODULUS} "5 mPa": unknown unit "mPa", did you mean "MPa"?'),
    ("100 um", "1,5 um", 'indenter.radius: must be a length, got "1,5 um": unknown unit ",5 um"'),
    ("100 um", "large", 'indenter.radius: must be a length, such as "100 um", got "large"'),
    ("nu = 0.4", "nu = 0.51", "specimen.half_space.nu: must be > -1 and <= 0.5, got 0.51"),
    ("nu = 0.4", "nu = -1", "specimen.half_space.nu: must be > -1 and <= 0.5, got -1"),
    ("nu = 0.4", "nu = nan", "specimen.half_space.nu: must be a finite number, got nan"),
    ("5 GPa", "-3 Pa", "specimen.half_space.E: must be > 0, got -3 Pa"),
    ("nu = 0.4", "", "specimen.half_space.nu: is required"),
    ("radius =", "raduis =", 'indenter.raduis: unknown key, did you mean "radius"? (allowed: E, nu, layers, shape, '),
    ("radius =", "counter_radius = 1e-3\nradius =", 'indenter.counter_radius: unknown key: the radius of a spherical '
        'specimen needs shape = "paraboloid"'),
    ('"sphere"', '"spere"', f'indenter.shape: must be one of {", ".join(SHAPES)}, got "spere", did you mean "sphere"'),
    ('shape = "sphere"', "", "indenter.shape: is required"),
    ('depth = "3 um"', 'depth = "3 um"\nload = 1', "loading: needs exactly one of depth, load, radius, got depth and "),
    ('depth = "3 um"', "", "loading: needs exactly one of depth, load, radius, got none"),
    ('"3 um"', "[2e-6, 1e-6]", "loading: the values of depth must increase, got [2e-06, 1e-06]"),
    ('"3 um"', '[1e-6, "x"]', 'loading.depth[1]: must be a length, such as "100 um", got "x"'),
    ('"3 um"', '"3 um"\npoints = 10.5', "loading.points: must be a whole number, got 10.5"),
    ('"3 um"', '"3 um"\npoints = 0', "loading.points: must be >= 1, got 0"),
    ('"3 um"', '"3 um"\nspacing = "deep"', "loading.spacing: must be one of radius, depth, load, log, got "),
    ('"3 um"', '"3 um"\n[adhesion]\nw = -1', "adhesion.w: must be >= 0, got -1 J/m^2"),
    ('"3 um"', '"3 um"\n[mesh]\norder = 3', "mesh.order: must be one of 1, 2, got 3"),
]  # fmt: skip


@pytest.mark.parametrize(("old", "new", "line"), ONE_CHANGE)
def test_one_mistake_gives_one_line(old: str, new: str, line: str) -> None:
    assert GOOD.count(old) == 1
    (found,) = refused_by(parse_case, GOOD.replace(old, new).encode(), "my.toml")
    assert found.startswith(f"my.toml: {line}")


def test_all_mistakes_are_reported_at_once() -> None:
    text = """
    metod = "fem"
    indenter = { shape = "cone", half_angle = "100 deg" }
    specimen.base = "bondd"
    specimen.layers = [
        { thickness = "1 um", E = "1 MPa", nu = 0.3 },
        { thickness = "-1 um", E = "-3 Pa", nu = 0.3 },
    ]
    loading.load = "1 mN"
    """
    beginnings = (
        "my.toml: indenter.half_angle: must be > 0 and < 1.5708, got 100 deg",
        'my.toml: metod: unknown key, did you mean "method"? (allowed: title, method, indenter, specimen, loading, ',
        'my.toml: specimen.base: must be one of bonded, frictionless, got "bondd", did you mean "bonded"?',
        "my.toml: specimen.layers[1].E: must be > 0, got -3 Pa",
        "my.toml: specimen.layers[1].thickness: must be > 0, got -1 um",
    )
    for line, beginning in zip(refused_by(parse_case, text.encode(), "my.toml"), beginnings, strict=True):
        assert line.startswith(beginning)


SPHERE = "indenter={shape='paraboloid',radius=1}\nloading.depth=0.1\n"
ON_HALF_SPACE = "\nspecimen.half_space={E=1,nu=0.3}\nloading.depth=0.1"
WHOLE_FILES = [
    ("", ["indenter: is required", "loading: is required", "specimen: is required"]),
    ("[indenter\n", ["is not valid TOML: expected ']' at the end of a table declaration (at line 1, column 10)"]),
    ("a = 1\na = 2\n", ["is not valid TOML: cannot overwrite a value (at line 2, column 6)"]),
    ("base = 'x.toml'\n[[axes]]\nkey = 'E'", ["is a sweep file, not a case: jkr sweep runs it"]),
    (b"\x89HDF\r\n", ["is not a text file (byte 0 is not UTF-8)"]),
    ("indenter = 3\nspecimen = []\nloading = 'x'",
     ["indenter: must be a table, got 3", 'loading: must be a table, got "x"', "specimen: must be a table, got []"]),
    (SPHERE + "specimen={}", ["specimen: is empty: give [specimen.half_space] with E and nu, or [[specimen.layers]]"]),
    (SPHERE + "specimen={base='bonded',half_space={E=1,nu=0.3}}", ["specimen: give either base (rigid) or half_space"]),
    ("indenter={shape='sphere',radius=1,E=1}" + ON_HALF_SPACE, ["indenter: an elastic indenter needs both E and nu "]),
    ("indenter={shape='paraboloid',radius=1,counter_radius=-0.5}" + ON_HALF_SPACE,
     ["indenter: counter_radius must be > 0, or < -radius for a cavity that the indenter fits, got -0.5 m"]),
    ("indenter={shape='table',r=[0,1,2,3],f=[0,1,1.5,3]}" + ON_HALF_SPACE,
     ["indenter: profile table: must be convex, the slope falls at point 2 (r = 1 m); JKR needs a contact disc that "]),
    ("indenter={shape='table',file='no.csv'}" + ON_HALF_SPACE, ["indenter: no.csv: profile file not found"]),
]  # fmt: skip


@pytest.mark.parametrize(("content", "lines"), WHOLE_FILES)
def test_wrong_file(content: str | bytes, lines: list[str]) -> None:
    said = refused_by(parse_case, content if isinstance(content, bytes) else content.encode(), "my.toml")
    for found, line in zip(said, lines, strict=True):
        assert found.startswith(f"my.toml: {line}")


def test_missing_file_suggests_a_neighbour(tmp_path) -> None:
    (tmp_path / "halfspace.toml").write_text(GOOD)
    with pytest.raises(InputError, match=r'halfspce.toml: case file not found, did you mean ".*/halfspace.toml"\?$'):
        load_case(tmp_path / "halfspce.toml")


def test_folder_instead_of_file(tmp_path) -> None:
    with pytest.raises(InputError, match=r": is a folder, not a case file$"):
        load_case(tmp_path)
