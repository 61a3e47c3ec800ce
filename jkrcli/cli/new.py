"""``jkr new``: a commented case file to start from."""

from __future__ import annotations

from pathlib import Path

import click

from ..base.errors import InputError
from ..base.files import check_target, write_text
from .voice import say

TEMPLATE = """\
# A case for jkr. Numbers are SI (m, N, Pa, J/m^2); text may carry a unit: "100 um", "5 GPa", "50 mJ/m^2".
# Lines that begin with "# " and a key are options with their defaults or alternatives.

title = "My specimen"
method = "auto"                 # auto (the least model that does it) | closed-form | layered | hybrid | fem

[indenter]                      # rigid; add E and nu for an elastic one
shape = "sphere"                # sphere | paraboloid | power | cone | flat | table
radius = "100 um"
# paraboloid: radius, counter_radius (a spherical specimen); power: coefficient, exponent (f = B r^d, SI);
# cone: half_angle = "70 deg"; flat: flat_radius, edge_radius; table: file = "profile.csv" (r_m, f_m), or lists r and f

[specimen]                      # layers from the contact surface down, on a rigid base ...
base = "bonded"                 # bonded | frictionless
# radius = "1 mm"               # a finite cylinder; with side = "free" | "roller" | "clamped"

[[specimen.layers]]
name = "layer"
thickness = "10 um"
E = "5 MPa"
nu = 0.45
# a modulus over depth: E = { law = "linear", top = "5 MPa", bottom = "1 MPa" } (linear | exponential), { law = "power",
# top = ..., length = ..., exponent = n } (top (1 + z/length)^n), or { depth = [0, "2 um", "10 um"], E = [...] };
# transversely isotropic, p in the plane, z along the depth: E_p, E_z, nu_p, nu_zp, G_z instead of E and nu

# ... or on an elastic half-space (then without base; without layers it is the whole specimen):
# [specimen.half_space]
# E = "5 GPa"
# nu = 0.4

[loading]                       # exactly one of depth, load, radius: the largest value, or a list of values
depth = "1 um"
points = 100
spacing = "radius"              # radius | depth | log (graded towards first contact: cones, flat ends)

[adhesion]                      # used by jkr transform, not by jkr run
w = "50 mJ/m^2"                 # or a list
z0 = "0.3 nm"                   # equilibrium distance, for the Tabor number

# [layered]
# tolerance = 1e-8              # relative accuracy asked of the exact layer solution

# [mesh]                        # finite elements only; everything has a default
# layout = "scaled"             # scaled | zones (the paper's)
# element = "triangle"          # triangle | quadrilateral
# order = 2                     # 1 | 2

# [contact]                     # finite elements only
# algorithm = "nested"          # nested (every contact radius exactly) | incremental (the paper's increments)
"""


@click.command()
@click.argument("file", type=click.Path(path_type=Path))
@click.option("--force", is_flag=True, help="Replace an existing file.")
def new(file: Path, force: bool) -> None:
    """Write a commented case to FILE, ready to edit and run.

    \b
    jkr new my.toml && jkr run my.toml && jkr transform my.h5
    """
    if file.exists() and not force:
        raise InputError(f"{file}: exists; give --force to replace it, or another name")
    check_target(file, force=True)
    write_text(file, TEMPLATE)
    say(f"written {file}; next: jkr run {file}")
