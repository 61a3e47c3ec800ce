"""A body by flags instead of a case file: indenter, and a half-space or one layer; the body of a fit by either."""

from __future__ import annotations

import contextlib
import re
from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any, TypeAlias

import click

from .. import bodies, case
from ..base import InputError, doubtful_modulus, writable
from ..identification import fit as fits
from ..methods import Limits
from .verb import as_one
from .verb import flag as option
from .voice import warn

SHALLOW = 0.2  # choice: of the tip radius, to which a body is solved first; the data may ask for more
Flags: TypeAlias = Mapping[str, str | None]  # by their names; None: not given
FLAGS = ("shape", "radius", "half_angle", "cap", "modulus", "nu", "thickness", "base")
SHAPES = {  # by flags, and which of them each needs
    **dict.fromkeys(("sphere", "paraboloid"), ("radius",)),
    "rounded-cone": ("radius", "half_angle"),
    **dict.fromkeys(("cone", "pyramid", "three-sided-pyramid"), ("half_angle",)),
}
CHOICES = {"cap": ("rounded-cone",)}  # flags with a default, and of what
FLAG_OF = {"E" if name == "modulus" else name: name for name in FLAGS[1:]}  # by the last part of a case's key
KEYS = re.compile(rf"\b(?:indenter|specimen)(?:\.half_space|\.layers\[0\])?\.({'|'.join(FLAG_OF)})\b")
OPTIONS = (
    click.option("--shape", type=click.Choice(list(SHAPES)), metavar="SHAPE",
                 help=f"{', '.join(SHAPES)} [default: sphere]."),
    click.option("--radius", help='Its radius, "100 um".'),
    click.option("--half-angle", help='Of a cone, of a pyramid to a face: "35 deg".'),
    click.option("--cap", help="Rounded cone: parabola [default: sphere]."),
    click.option("--E", "modulus", help='Young\'s modulus of the specimen, "5 GPa".'),
    click.option("--nu", help="Its Poisson's ratio."),
    click.option("--thickness", help="A layer of this thickness [default: a half-space]."),
    click.option("--base", help="Under the layer: bonded or frictionless [default: bonded]."),
)  # fmt: skip


body_options = as_one("flags", dict, *OPTIONS)
tip_options = as_one("flags", dict, *OPTIONS[:4])


def flag(name: str) -> str:
    """What a flag is called on the command line."""
    return "--E" if name == "modulus" else option(name)


def named_flags(body: Flags) -> str:
    """The flags that were given, for messages."""
    return ", ".join(flag(name) for name in FLAGS if body.get(name) is not None)


def by_flags(verb: str, body: Flags, files: Sequence[Path]) -> bool:
    """Whether the body is given by flags; InputError where it is also given by ``files``."""
    named = named_flags(body)
    if named and files:
        names = ", ".join(map(str, files))
        raise InputError(f"{verb}: give a body file or the body by flags, not both: {names} and {named}")
    return bool(named)


def case_of(verb: str, body: Flags, instead: str, modulus: str | None = None, **keys: Any) -> case.Case:
    """The case of a body by flags, with more ``keys`` of its own, "loading" among them; the rest as of ``tables_of``.
    InputError names flags, not the keys that they stand for."""
    import tomli_w

    content = tomli_w.dumps(tables_of(verb, body, instead, modulus) | keys).encode()
    try:
        return case.parse_case(content, verb)
    except InputError as error:
        raise InputError([KEYS.sub(lambda key: flag(FLAG_OF[key[1]]), line, count=1) for line in error.lines]) from None


def tip_of(verb: str, flags: Flags) -> bodies.Indenter | None:
    """The tip of the ``tip_options``; None where none is given."""
    if not any(flags.values()):
        return None
    body = dict.fromkeys(FLAGS) | dict(flags) | {"modulus": "1 MPa", "nu": "0.5"}  # any: the tip is rigid
    return case_of(verb, body, "", loading={"radius": 1.0}).model.problem().indenter


def tables_of(verb: str, body: Flags, instead: str, modulus: str | None) -> dict[str, Any]:
    """Indenter and specimen of a case from flags; InputError names missing flags, and what may be given ``instead``.

    ``modulus``: the specimen's where there is no flag for it; None: the flag is required.
    """
    values = {**body, "modulus": body["modulus"] or modulus}
    texts = {name: None if value is None else writable(value) for name, value in values.items()}
    shape = texts["shape"] or "sphere"
    sizes = SHAPES[shape]
    choices = [name for name, shapes in CHOICES.items() if shape in shapes and texts[name] is not None]
    optional = [name for name in ("radius", "half_angle", *CHOICES) if texts[name] is not None]
    if unused := [flag(name) for name in optional if name not in (*sizes, *choices)]:
        raise InputError(f"{verb}: a {shape} has no {unused[0]}: leave it out, or give another --shape")
    missing = [flag(name) for name in (*sizes, "modulus", "nu") if texts[name] is None]
    if missing:
        either = f"needs {instead}, or the body by flags: " if instead else ""
        raise InputError(f"{verb}: {either}{', '.join(missing)} missing")
    if texts["base"] is not None and texts["thickness"] is None:
        raise InputError(f"{verb}: --base needs --thickness: a half-space has no base")
    entries = {name: number_or_text(text) for name, text in texts.items()}
    for name in ("radius", "thickness"):
        size = entries[name]
        if isinstance(size, float) and size >= 0.1:  # choice: [m], larger than what is pressed
            warn(f"{flag(name)} {texts[name]} without a unit is {size:g} m: give its unit, {flag(name)} "
                 f'"{texts[name]} um"')  # fmt: skip
    E = entries["modulus"]
    if isinstance(E, float) and E > 0 and (doubt := doubtful_modulus(E)):
        warn(f"--E: {doubt}")
    material = {"E": E, "nu": entries["nu"]}
    specimen: dict[str, Any] = {"half_space": material}
    if entries["thickness"] is not None:
        layer = material | {"thickness": entries["thickness"]}
        specimen = {"base": texts["base"] or "bonded", "layers": [layer]}
    indenter = {"shape": shape} | {name: entries[name] for name in (*sizes, *choices)}
    return {"indenter": indenter, "specimen": specimen}


def number_or_text(text: str | None) -> float | str | None:
    """A bare number as one, so that it is SI; else the text, for the case reader to judge."""
    with contextlib.suppress(ValueError, TypeError):
        return float(text)  # type: ignore[arg-type]
    return text


def body_and_measured(
    body_file: Path, measured: tuple[Path, ...], flags: Flags
) -> tuple[Path | Flags, tuple[Path, ...]]:
    """What describes the body, a file or the flags, and the measured files: by flags every file is one."""
    by_case = not by_flags("fit", flags, [body_file] if _is_body(body_file) else [])
    if by_case and not measured:
        raise InputError("fit: give MEASURED files behind BODY, or the body by flags: --radius, --nu")
    return (body_file, measured) if by_case else (flags, (body_file, *measured))


def _is_body(path: Path) -> bool:
    """Whether the file is a case, or a series and no measured one."""
    if path.suffix != ".h5" or not path.is_file():
        return path.suffix == ".toml"
    from ..base import format_of
    from ..case import SERIES

    return format_of(path) == SERIES


def fitted_body(source: Path | Flags, slopes: str, limits: Limits) -> fits.FittedBody:
    """The body of a file, or of flags: there a modulus that is not told is 1 MPa, which no result depends on."""
    from .series import read_series

    if isinstance(source, Path):
        return fits.body_of(source if source.suffix == ".toml" else read_series(source), slopes, limits)
    of_flags = partial(case_of, "fit", source, "a case or series file", "1 MPa")
    radius = of_flags(loading={"radius": 1.0}).model.problem().indenter.tip_radius
    method = "closed-form" if source["thickness"] is None else "layered"  # so that no other is imported
    radius = radius or 5e-6  # choice: [m], of a tip that has none
    shallow = of_flags(loading={"radius": SHALLOW * radius}, method=method)
    return replace(fits.body_of(shallow, slopes, limits), moduli_known=source["modulus"] is not None)
