"""``jkr study``: a verb for each map, made of its row, and the convergence of meshes."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar

import click

from ..many.study import MAPS
from ..report import PICTURES, Output
from .option_types import PairsType
from .options import Parallel, parallel_options
from .output import give, into_folder, output_options
from .verb import LateGroup, Verb, several
from .voice import progress

if TYPE_CHECKING:
    from ..many.study.maps import Axis, Map

STUDIES = {f"{name}-map": words for name, words in MAPS.items()} | {
    "converge": "The same case on a sequence of meshes."
}
MAKE = {name: name for name in ("chart", "failures", "figures")} | {"noise": "noise-study"}  # studies of the methods


class Studies(LateGroup):
    """The studies: of maps each is made of its row."""

    titles: ClassVar = {"Studies": STUDIES}
    voiced = STUDIES

    def made(self, name: str) -> click.Command:
        if name == "converge":
            from .study_converge import study_converge

            return study_converge
        from ..many.study.maps import map_of

        return _command(map_of(name.removesuffix("-map")))

    def unknown(self, name: str) -> str:
        if name in MAKE:
            return f'"{name}" is now run as make {MAKE[name]}'
        return f'unknown study "{name}" (studies: {", ".join(STUDIES)})'


@click.group(cls=Studies)
def study() -> None:
    """Maps and studies over many bodies.

    \b
    jkr study pull-off-map --nu 0.3 --nu 0.499
    """


def _command(row: Map) -> click.Command:
    """The verb of a map: an option for each axis."""

    @parallel_options
    @into_folder("Folder [default: .].", default=Path())
    @output_options(plots="Write the CSV only.", json="Print the table as JSON.")
    def study_map(output: Output, parallel: Parallel, **axes: Any) -> None:
        from ..base import executor

        chosen = {name: value for name, value in axes.items() if value not in (None, ())}
        files = output.files(output.folder(Path()) / f"{row.name}-map", (".csv", *PICTURES))
        with executor(*parallel, progress, row.forecast(**chosen)) as pool:
            result = row.over(pool, **chosen)
        files.write(result.columns, figure=files.draw(result.figure))
        give(result, output.json, f"  written {files}")

    options = several(*(_option(name, axis) for name, axis in row.axes.items()))
    return click.command(f"{row.name}-map", cls=Verb, help=row.help)(options(study_map))


def _option(name: str, axis: Axis) -> Any:
    kind: Any = float if axis.read is None else str
    default = axis.default if axis.several else (axis.default,)
    if isinstance(axis.default, dict):
        kind = PairsType()
        default = [f"{key}={value}" for key, value in axis.default.items()]
    elif isinstance(axis.allowed, tuple):
        kind = click.Choice(axis.allowed)
    shown = axis.shown or ", ".join(map(str, default))
    return click.option(f"--{name}", type=kind, multiple=axis.several, help=f"{axis.help}  [default: {shown}]".strip())
