"""Every verb on shipped inputs, with another value of each of its options."""

import math
import shutil
from collections.abc import Callable, Iterator
from functools import cache
from pathlib import Path
from typing import Any

import click

import jkrcli
from jkrcli.cli import jkr as program

CASES = Path(__file__).parents[1] / "cases"
INPUTS = {  # what is shipped, by the names that it has here
    "gel.toml": "gel.toml", "relaxing.toml": "relaxing-gel.toml", "probe.csv": "measured/gel-probe.csv",
    "raw.txt": "measured/raw-force-curve.txt",
}  # fmt: skip
SWEEP = """
base = "gel.toml"
outputs.quantities = ["pull_off"]
[[axes]]
key = "specimen.layers[0].thickness"
values = ["0.3 mm", "0.6 mm"]
"""
BASES: dict[str, tuple[str, ...]] = {  # verbs on shipped inputs; what follows the colon tells those of one verb apart
    "new": ("mine.toml",), "check": ("gel.toml",), "run": ("gel.toml",), "mesh": ("gel.toml",),
    "import": ("table.csv", "--case", "gel.toml", "--sort"), "transform": ("gel.h5",),
    "pull-off": ("gel.h5", "--json"), "pull-off:load": ("gel.h5", "--load", "1 mN"),
    "pull-off:options": ("--radius", "5 um", "--E", "1 MPa", "--nu", "0.5", "--w", "0.01"),
    "pull-off:relaxing": ("relaxing.h5", "--w", "20 mJ/m^2"),
    "cycle": ("gel.h5", "--w-approach", "20 mJ/m^2"),
    "cycle:rate": ("gel.h5", "--rate", "v0=1 um/s,n=0.6", "--speed", "10 um/s", "--to-load", "1 mN"),
    "cycle:relaxing": ("relaxing.h5", "--w-approach", "0", "--speed", "10 um/s", "--to-depth", "50 um"),
    "profile": ("gel.h5", "--a", "0.6 mm"), "profile:load": ("gel.h5", "--load", "1 mN"),
    "fields": ("gel.h5", "--a", "0.6 mm"),
    "export": ("gel.h5", "--dem"), "export:nanite": ("gel.h5", "--nanite"), "explore": ("gel.h5", "probe.csv"),
    "look": ("raw.txt",), "work": ("gel.h5", "probe.csv"), "compare": ("gel.h5", "less.h5"),
    "compare:curves": ("gel-w0.04.csv", "less-w0.04.csv"), "sweep": ("sweep.toml",), "show": ("gel.h5",),
    "study pull-off-map": ("--nu", "0.3", "--q", "1"), "study sticking-map": ("--nu", "0.3", "--ratio", "1"),
    "study transition-map": ("--nu", "0.3", "--q", "1", "--mu", "1"),
    "study adhesion-map": ("--nu", "0.3", "--q", "1", "--mu", "1", "--load", "1"),
    "study rate-map": ("--speed", "1", "--stiffness", "rigid", "--thickness", "0.3"),
    "study roughness-map": ("--rms", "10 nm", "--rms", "20 nm", "--modulus", "1 MPa"),
    "study converge": ("gel.toml", "--levels", "2"), "bench": ("gel.toml", "--repeat", "1"), "doctor": (),
    "fit": ("gel.toml", "probe.csv"), "fit:raw": ("raw.txt", "--radius", "5 um", "--nu", "0.5"),
}  # fmt: skip
WORDS: dict[str, tuple[str, ...]] = {  # what another value of an option is
    "--w": ("30 mJ/m^2",), "--stress": ("1 kPa",), "--range": ("2 um",), "--slopes": ("integral",),
    "--modulus-factor": ("2",), "--stiffness": ("1 N/m",), "--load": ("1 mN",), "--method": ("fem",),
    "--tolerance": ("1e-4",), "--output": ("there",), "--dimensionless": ("half-space",),
    "--scale": ("a=1 um", "--scale", "delta=1 um", "--scale", "P=1 uN"), "--a": ("0.5 mm",),
    "--w-approach": ("10 mJ/m^2",), "--w-retract": ("70 mJ/m^2",), "--to-load": ("0.5 mN",), "--to-depth": ("10 um",),
    "--rest-load": ("0.1 mN",), "--rest-depth": ("1 um",), "--points": ("9",), "--uncertain": ("E=5%",),
    "--rtol": ("0.9",), "--find": ("indenter.radius",), "--column": ("a=3",), "--overlap": ("0.9",),
    "--plot": ("there.png",), "--limit-time": ("1e-12",), "--limit-memory": ("1e-12",), "--rate": ("v0=1 um/s,n=0.6",),
    "--rate-advance": ("v0=1 um/s,n=0.6",), "--speed": ("1 um/s",), "--speed-approach": ("1 um/s",), "--hold": ("1 s",),
    "--dwell": ("1 mN",), "--dwell-time": ("1 s",), "--program": ("no.csv",), "--nodes": ("no.csv",),
    "--relaxation": ("sls",), "--case": ("gel.toml",), "--shape": ("cone",), "--radius": ("2 mm",),
    "--half-angle": ("80 deg",), "--cap": ("parabola",), "--E": ("2 MPa",), "--nu": ("0.4",),
    "--thickness": ("0.1 mm",), "--base": ("frictionless",), "--unit": ("P=uN",), "--factor": ("P=2",),
    "--zero": ("delta=0.1 um",), "--sign": ("as-is",), "--area": ("projected",), "--separator": ("tab",),
    "--decimal": (",",), "--component": ("rr",), "--flip": ("P",), "--contact": ("estimate",),
    "--sensitivity": ("45 nm/V",), "--format": ("afm",), "--rows": ("5..60",), "--where": ("segment=retract",),
    "--segment": ("approach",), "--noise": ("P=50 uN",), "--use": ("delta,P",), "--window": ("7",), "--only": ("1",),
    "--show-case": ("1",), "--hours": ("0",), "--contact-shape": ("any",),
    "--roughness": ("rms=9nm,longest=1um,shortest=100nm,hurst=0.8",), "--surface-energy": ("20 mJ/m^2",),
    "--sizes": ("0.8 mm..1.2 mm",), "--rms": ("50 nm",), "--modulus": ("2 MPa",), "--longest": ("9 um",),
    "--shortest": ("50 nm",), "--hurst": ("0.7",), "--q": ("3",), "--beta": ("0.1",), "--ratio": ("3",), "--mu": ("3",),
    "--free": ("P0",), "--fix": ("w=40 mJ/m^2",), "--start": ("w=30 mJ/m^2",), "--bound": ("w=60 mJ/m^2..1 J/m^2",),
    "--law": ("power",), "--terms": ("1",), "--base-line": ("sine",), "--branch": ("compressive",),
    "--loss": ("cauchy",), "--confidence": ("profile",), "--model": ("auto",), "--level": ("0.5",),
    "--samples": ("30",), "--seed": ("7",), "--shared": ("w",), "--own": ("w",), "--tip-radius": ("3 mm",),
    "--surface": ("sticking",), "--name": ("other",), "--grid": ("6x5",), "--sample": ("gel-(.*)",),
}  # fmt: skip
HERE: dict[tuple[str, str], tuple[str, ...]] = {  # and where it is not: by verb, or by one of its bases
    ("compare", "--column"): ("a",), ("new", "--example"): ("gel",), ("study rate-map", "--rate"): ("n=0.5",),
    ("study rate-map", "--speed"): ("2",), ("study rate-map", "--stiffness"): ("1",),
    ("study rate-map", "--thickness"): ("0.5",), ("study adhesion-map", "--load"): ("2",),
    ("import", "--area"): ("surface",), ("import", "--column"): ("a=delta_m",), ("look", "--column"): ("P=a_um",),
    ("work", "--column"): ("P=a_um",), ("explore", "--column"): ("P=a_um",), ("bench", "--repeat"): ("2",),
    ("study converge", "--levels"): ("3",), ("study converge", "--contact"): ("incremental",),
    ("export", "--name"): ("other",), ("pull-off", "--slopes"): ("integral",), ("fit", "--stiffness"): ("5 kN/m",),
    ("import", "--unit"): ("P=mN",), ("import", "--case"): ("soft.toml",), ("import", "--zero"): ("P=-1 uN",),
    ("compare", "--overlap"): ("0.99",), ("compare", "--rtol"): ("1e-9",), ("pull-off", "--stiffness"): ("10 N/m",),
    ("pull-off:load", "--uncertain"): ("R=2%",), ("look", "--decimal"): (".",), ("look", "--contact"): ("estimate",),
    ("look", "--where"): ("curve=other",), ("fit", "--uncertain"): ("radius=3%",),
    ("fit:raw", "--free"): ("compliance",), ("fit:raw", "--decimal"): (".",), ("fit:raw", "--fix"): ("w=1 mJ/m^2",),
    ("fit:raw", "--start"): ("w=2 mJ/m^2",), ("fit:raw", "--bound"): ("w=2 mJ/m^2..1 J/m^2",),
    ("fit:raw", "--noise"): ("P=1 nN",), ("fit:raw", "--contact"): ("as-is",), ("fit:raw", "--tip-radius"): ("3 um",),
    ("fit:raw", "--unit"): ("P=pN",), ("fit:raw", "--thickness"): ("20 um",), ("fit:raw", "--rows"): ("5..1800",),
    ("pull-off:options", "--thickness"): ("20 um",), ("cycle:rate", "--hold"): ("1 s",),
    ("cycle:rate", "--dwell"): ("5 um", "--dwell-time", "1 s"),
    ("cycle:relaxing", "--dwell"): ("20 um", "--dwell-time", "1 s"), ("sweep", "--show-case"): ("1",),
    ("study converge", "--w"): ("30 mJ/m^2",), ("bench", "--method"): ("closed-form",),
}  # fmt: skip
# How much is said, whether a file of another's is replaced, where it is computed: none changes what is.
EXEMPT = {"--force", "--quiet", "--verbose", "--workers", "--scheduler"}


def commands(group: click.Group, path: tuple[str, ...] = ()) -> Iterator[tuple[tuple[str, ...], click.Command]]:
    context = click.Context(group)
    for name in group.list_commands(context):
        command = group.get_command(context, name)
        assert command is not None
        if isinstance(command, click.Group):
            yield from commands(command, (*path, name))
        else:
            yield (*path, name), command


def left(folder: Path) -> dict[str, bytes]:
    return {str(path.relative_to(folder)): path.read_bytes() for path in sorted(folder.rglob("*")) if path.is_file()}


def verb_of(base: str) -> str:
    return base.partition(":")[0]


@cache
def options_of(base: str) -> list[click.Option]:
    command = dict(commands(program))[tuple(verb_of(base).split())]
    return [each for each in command.params
            if isinstance(each, click.Option) and not each.is_eager and each.opts[-1] not in EXEMPT]  # fmt: skip


def typed(base: str, option: click.Option) -> tuple[str, ...]:
    name = (option.secondary_opts or option.opts if option.default is True else option.opts)[-1]
    if option.is_flag:
        return (name,)
    return (name, *(HERE.get((base, name)) or HERE.get((verb_of(base), name)) or WORDS[name]))


KNOWN: dict[str, bytes] = {}  # what was made of them


def write_inputs(folder: Path, jkr: Callable[..., Any]) -> None:
    """Shipped cases and records, what is solved of them, and the same as another program would write it."""
    if not KNOWN:
        _make_inputs(folder, jkr)
        KNOWN.update(left(folder))
    for name, content in KNOWN.items():
        (folder / name).write_bytes(content)


def _make_inputs(folder: Path, jkr: Callable[..., Any]) -> None:
    for name, source in INPUTS.items():
        shutil.copy(CASES / source, folder / name)
    gel = (folder / "gel.toml").read_text()
    (folder / "soft.toml").write_text(gel.replace('"15 kPa"', '"12 kPa"'))
    (folder / "less.toml").write_text(gel.replace('"1.2 mm"', '"1.18 mm"').replace("points = 100", "points = 60"))
    (folder / "sweep.toml").write_text(SWEEP)
    for name in ("gel", "less", "relaxing"):
        assert jkr("run", f"{name}.toml", "-q").code == 0
    series = jkrcli.read("gel.h5").series
    rows = zip((math.pi * series.a**2).tolist(), series.delta.tolist(), (-series.P).tolist(), strict=True)
    lines = [",".join(map(repr, row)) for row in rows]
    (folder / "table.csv").write_text("\n".join(["area_m2,delta_m,P_N", *lines[::-1], ""]))
    assert jkr("transform", "gel.h5", "less.h5", "--w", "0.04", "--no-plots").code == 0
