"""A verb, options that it takes together, and how its help shows the options: at most twelve that everybody needs,
the names of the others by their kind; ``--help-all`` describes all, each kind under its title."""

from __future__ import annotations

import functools
from collections.abc import Callable, Container, Mapping
from dataclasses import field, fields, is_dataclass
from pathlib import Path
from typing import Any, ClassVar, cast

import click

from ..base.files import received
from .output import level_options

ALL = "jkr.help_all"
LINES = 80  # of the help of a verb: two screens
MOST_OPTIONS = 12  # choice: that a help describes without --help-all
Command = Callable[..., Any]
Options = Callable[[Command], Command]  # one or several, as a decorator

GROUPS = {
    "Reading": (
        "column", "unit", "factor", "flip", "zero", "contact", "stiffness", "sensitivity", "format", "separator",
        "decimal", "rows", "where", "sign", "area", "sort",
    ),
    "Statistics": (
        "start", "bound", "branch", "base-line", "noise", "loss", "confidence", "level", "samples", "seed", "uncertain",
        "window",
    ),
    "Several force curves": ("shared", "own", "tip-radius"),
    "Speed and time": (
        "law", "relaxation", "terms", "rate", "rate-advance", "speed", "speed-approach", "hold", "dwell", "dwell-time",
        "program",
    ),
    "Numerics": ("tolerance", "slopes", "modulus-factor", "points", "rtol", "repeat"),
    "Limits": ("limit-memory", "limit-time", "hours", "workers", "scheduler"),
    "Output": (
        "output", "force", "json", "no-plots", "plot", "quiet", "verbose", "dimensionless", "scale", "together", "help",
    ),
}  # fmt: skip
# What the field calls what an option gives, where its name is no near miss.
SYMBOLS = {
    "R": "radius", "r": "radius", "alpha": "half-angle", "angle": "half-angle", "theta": "half-angle",
    "h": "thickness", "t": "thickness", "modulus": "E", "young": "E", "Young": "E", "e": "E", "poisson": "nu",
    "Poisson": "nu", "k": "stiffness", "spring-constant": "stiffness", "invOLS": "sensitivity", "W": "w", "gamma": "w",
    "v": "speed", "F": "load", "P": "load",
}  # fmt: skip
# What the help of a verb with more options describes; of another the first of each kind.
DESCRIBED = {
    "import": "case shape radius E nu thickness base column unit factor output help",
    "transform": "w slopes stress range dimensionless together output no-plots force json verbose help",
    "pull-off": "shape radius E nu thickness base w load stiffness uncertain json help",
    "cycle": "w-approach w-retract stiffness to-load to-depth speed hold rate stress range output help",
    "look": "shape radius column unit factor stiffness sensitivity where rows output no-plots help",
    "fit": "shape radius nu thickness base stiffness free fix uncertain rivals output help",
    "work": "use segment noise column unit flip zero contact stiffness output no-plots help",
    "explore": "w column unit factor flip zero stiffness slopes output force json help",
}
# Options that mean something else to some verbs, where everybody needs them.
FIRST = {"cycle": ("stiffness",), "pull-off": ("stiffness", "uncertain"), "rate-map": ("rate", "speed", "stiffness")}


def several(*options: Options) -> Options:
    """Options as one, in this order."""
    return lambda command: functools.reduce(lambda decorated, option: option(decorated), reversed(options), command)


def as_one(name: str, make: Callable[..., Any], *options: Options) -> Options:
    """Options that a verb takes as one argument ``name``: what ``make`` makes of their values; of a dataclass those
    fields that are ``typed`` before the others. An option of the same ``name`` is one of theirs, wherever it stands."""
    if is_dataclass(make):
        options = (*(one.metadata["option"](one.name) for one in fields(make) if one.metadata), *options)

    def unused() -> None: ...

    several(*options)(unused)
    keys = {option.name for option in unused.__click_params__} | {name}  # type: ignore[attr-defined]

    def decorate(command: Command) -> Command:
        @functools.wraps(command)
        def taking(*words: Any, **others: Any) -> Any:
            values = {key: others.pop(key) for key in keys & others.keys()}
            return command(*words, **{name: make(**values)}, **others)

        return several(*options)(taking)

    return decorate


def typed(kind: Any, help: str, called: str = "") -> Any:
    """A field of a dataclass that is typed as an option, ``called`` so where not as the field."""
    return field(metadata={"option": lambda name: click.option(called or flag(name), name, type=kind, help=help)})


def flag(name: str) -> str:
    """What the option of a parameter is called on the command line."""
    return f"--{name.replace('_', '-')}"


class Verb(click.Command):
    """A command whose help shows its options in groups."""

    def __init__(self, *words: Any, **others: Any):
        super().__init__(*words, **others)
        kind = {"is_flag": True, "is_eager": True, "expose_value": False, "hidden": True}
        self.params.append(click.Option(["--help-all"], callback=_help_all, help="Describe every option.", **kind))

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        """Parse, but refuse an option of one value that is given twice, and a key twice of one that takes pairs: the
        last would be taken in silence."""
        if not ctx.resilient_parsing:
            try:
                *_, order = self.make_parser(ctx).parse_args(list(args))
            except click.NoSuchOption as error:
                own = {option for parameter in self.params for option in parameter.opts}
                if (meant := f"--{SYMBOLS.get(error.option_name.strip('-'), '')}") in own:
                    error.possibilities = [meant]  # type: ignore[misc]
                raise
            for parameter in order:
                takes_more = (
                    parameter.multiple or getattr(parameter, "is_flag", False) or getattr(parameter, "count", False)
                )
                if isinstance(parameter, click.Option) and not takes_more and (times := order.count(parameter)) > 1:
                    raise click.UsageError(
                        f"{max(parameter.opts, key=len)} is given {times} times: it takes one value", ctx
                    )
        rest = super().parse_args(ctx, args)
        for parameter in self.params:
            if getattr(parameter.type, "keyed", False) and parameter.multiple:
                keys = [key for key, _ in ctx.params.get(parameter.name or "") or ()]
                if twice := next((key for key in keys if keys.count(key) > 1), None):
                    raise click.UsageError(f"{parameter.opts[0]}: {twice} is given twice: it takes one value", ctx)
        return rest

    def format_options(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        rows: dict[str, dict[str, tuple[str, str]]] = {title: {} for title in ("Options", *GROUPS)}
        for parameter in self.get_params(ctx):
            record = parameter.get_help_record(ctx) if isinstance(parameter, click.Option) else None
            if record is not None:
                name = max(parameter.opts, key=len).removeprefix("--")
                rows[self._group(name)][name] = record
        names = [name for records in rows.values() for name in records]
        whole = ctx.meta.get(ALL, False) or len(names) <= MOST_OPTIONS
        described = (
            names if whole else DESCRIBED.get(self.name or "", "").split() or [*names[: MOST_OPTIONS - 1], "help"]
        )
        for title, records in rows.items():
            if shown := [record for name, record in records.items() if name in described]:
                with formatter.section(title):
                    formatter.write_dl(shown)
        if not whole:
            formatter.write_paragraph()
            for title, records in rows.items():
                if others := [f"--{name}" for name in records if name not in described]:
                    formatter.write_text(f"{'Also' if title == 'Options' else title}: {' '.join(others)}")
            formatter.write_text(f"Every option described: {ctx.command_path} --help-all")

    def _group(self, option: str) -> str:
        if option in FIRST.get(self.name or "", ()):
            return "Options"
        return next((title for title, names in GROUPS.items() if option in names), "Options")


class FileType(click.Path):
    """A file to read, which may come through a pipe."""

    def __init__(self) -> None:
        super().__init__(path_type=Path)

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        path = super().convert(value, param, ctx)
        return path if ctx is not None and ctx.resilient_parsing else received(cast(Path, path))


def verb(usage: str = "", name: str | None = None) -> Callable[[Command], click.Command]:
    """A command of the paths that its ``usage`` names as its help does: "file", "series measured...", "[files...]"."""

    def decorate(command: Command) -> click.Command:
        for word in reversed(usage.split()):
            count = -1 if "..." in word else 1
            command = click.argument(word.strip("[.]"), type=FileType(), nargs=count, required=word[0] != "[")(command)
        return click.command(name, cls=Verb)(command)

    return decorate


class LateGroup(click.Group):
    """A group whose commands are imported, or made, when they are called; ``titles``: their names with a line each, by
    the titles of the help's sections; ``silent``: those that print no result. What writes files can be quiet."""

    titles: ClassVar[Mapping[str, Mapping[str, str]]]
    silent: ClassVar[Container[str]] = ()

    def made(self, name: str) -> click.Command:
        """The command called ``name``."""
        raise NotImplementedError

    def unknown(self, name: str) -> str:
        """The message on a ``name`` that no command has."""
        raise NotImplementedError

    def list_commands(self, ctx: click.Context) -> list[str]:
        return [name for names in self.titles.values() for name in names]

    def get_command(self, ctx: click.Context, name: str) -> click.Command | None:
        if name not in self.list_commands(ctx):
            return None
        command = self.made(name)
        options = {option for parameter in command.params for option in parameter.opts}
        if name not in self.silent and "--verbose" not in options:
            command.params += level_options(quiet="--force" in options)
        return command

    def resolve_command(
        self, ctx: click.Context, args: list[str]
    ) -> tuple[str | None, click.Command | None, list[str]]:
        if args and args[0] not in self.list_commands(ctx) and not args[0].startswith("-"):
            raise click.UsageError(self.unknown(args[0]), ctx)
        return super().resolve_command(ctx, args)

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        width = max(map(len, self.list_commands(ctx)))
        for title, names in self.titles.items():
            with formatter.section(title):
                formatter.write_dl([(name.ljust(width), text) for name, text in names.items()])


def _help_all(ctx: click.Context, param: click.Parameter, value: bool) -> None:
    if value and not ctx.resilient_parsing:
        ctx.meta[ALL] = True
        click.echo(ctx.get_help())
        ctx.exit()
