"""Sweep files that tests of sweeps share, and what they read of their tables."""

import csv
from pathlib import Path

from jkrcli.many.sweep_plan import Plan, load_plan

HALF_SPACE = """
[base]
method = "closed-form"
indenter = { shape = "paraboloid", radius = "1 mm" }
specimen.half_space = { E = "1 MPa", nu = 0.3 }
loading = { radius = "0.1 mm" }
adhesion = { w = "50 mJ/m^2" }
"""
TWO_LAYERS = """
[base]
method = "layered"
indenter = { shape = "sphere", radius = "1 mm" }
specimen.layers = [{ E = "1 MPa", nu = 0.3, thickness = "0.1 mm" }, { E = "2 MPa", nu = 0.4, thickness = "0.2 mm" }]
loading = { radius = "0.1 mm", points = 20 }
adhesion = { w = "50 mJ/m^2" }
"""
AXIS = '[[axes]]\nkey = "specimen.half_space.nu"\nvalues = [0.1, 0.3, 0.5]\n'
SHARED = """
[[axes]]
key = "adhesion.w"
values = [0.01, 0.02, 0.05]
[[axes]]
zip = { "specimen.layers[0].E" = ["1 MPa", "3 MPa", "0.7 MPa"], "specimen.layers[1].E" = ["2 MPa", "6 MPa", "1.4 MPa"] }
[[axes]]
key = "specimen.layers[0].thickness"
values = ["0.1 mm", "0.2 mm"]
"""
BAD = """
[samples]
count = 40
seed = 3
method = "random"
[samples.of]
"specimen.half_space.nu" = { distribution = "normal", mean = 0.45, sd = 0.05 }
"""
R = 1e-3


def axis(key: str, rest: str) -> str:
    """An axis of a sweep file."""
    return f'[[axes]]\nkey = "{key}"\n{rest}\n'


def samples(distribution: str, key: str = "adhesion.w") -> str:
    """Three draws of one key."""
    return f'[samples]\ncount = 3\n[samples.of]\n"{key}" = {{ {distribution} }}\n'


def plan_of(tmp_path: Path, text: str) -> Plan:
    """The plan of a sweep file of this text."""
    path = tmp_path / "s.toml"
    path.write_text(text)
    return load_plan(path)


def rows(path: Path) -> list[dict[str, str]]:
    """The rows of a table by their columns."""
    with path.open(newline="") as file:
        return list(csv.DictReader(file))
