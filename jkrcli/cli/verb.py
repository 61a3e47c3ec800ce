"""A verb: its options and how its help shows them, at most twelve that everybody needs; and what it prints: results to
stdout, for people or as JSON, warnings to stderr, lines folded to the terminal's width.
"""

from __future__ import annotations

import contextlib
import functools
import math
import os
import re
import shlex
import shutil
import sys
import textwrap
from collections.abc import Callable, Container, Iterator, Mapping, Sequence
from dataclasses import field, fields, is_dataclass
from functools import partial
from itertools import accumulate
from pathlib import Path
from typing import Any, ClassVar, TextIO, cast

import click

from ..base.errors import printable, writable
from ..base.files import received
from ..base.process import SILENCE, duration

TYPE_CHECKING = False
if TYPE_CHECKING:
    from ..base.registry import Result


LEVEL, WARNED, ANNOUNCED = "jkr.level", "jkr.warned", "jkr.announced"
QUIET, USUAL, VERBOSE = range(3)
WIDE = 100  # choice: columns of a line, on wider terminals too
FIRST_LINES = 12  # choice: lines of a first answer
UNIT = r"(?:%|[anpumkMGTµ]?(?:m|N|J|Pa|s|V)\b)"
TOGETHER = re.compile(rf"(?<=\S) (?== \S)|(?<=[=±]) (?=[-+]?\d)|(?<=\d) (?={UNIT})")  # name, value and unit


def level_options(quiet: bool) -> list[click.Option]:
    """``-v``, and ``-q`` of every verb whose result is a file."""
    levels = {"verbose": (VERBOSE, "Print all of the result, and stages and costs on stderr.")}
    if quiet:
        levels = {"quiet": (QUIET, "Print warnings and errors only, and JSON.")} | levels
    return [
        click.Option(
            [f"-{name[0]}", f"--{name}"], is_flag=True, expose_value=False, callback=partial(_set, level), help=words
        )
        for name, (level, words) in levels.items()
    ]


def _set(level: int, ctx: click.Context, param: click.Parameter, value: bool) -> None:
    if value and ctx.meta.get(LEVEL, level) != level:
        raise click.UsageError("-q and -v exclude each other", ctx)
    if value:
        ctx.meta[LEVEL] = level


def _level() -> int:
    ctx = click.get_current_context(silent=True)
    return USUAL if ctx is None else ctx.meta.get(LEVEL, USUAL)


def folded(line: str) -> str:
    """A line as several of the terminal's width, broken between words; all but the first are set in."""
    width = max(shutil.get_terminal_size((WIDE, 0)).columns, 40)
    if not os.environ.get("COLUMNS", "").isdigit():  # who sets it is obeyed
        width = min(width, WIDE)
    if len(line) <= width:
        return line
    indent = " " * (len(line) - len(line.lstrip()) + 4)
    whole = TOGETHER.sub(lambda gap: "\0" * len(gap[0]), line)
    lines = textwrap.fill(whole, width, subsequent_indent=indent, break_long_words=False, break_on_hyphens=False)
    return lines.replace("\0", " ")


def tell(line: str) -> None:
    """A line on stderr; where nobody can receive it (a full disk, a reader that is gone) work goes on without."""
    try:
        click.echo(line, err=True)
    except OSError:
        give_up(sys.__stderr__)


def give_up(stream: TextIO | None) -> None:
    """Drop what a standard stream still holds and cannot write, so that the interpreter ends quietly with our code."""
    with contextlib.suppress(OSError, ValueError):
        if stream is not None:
            os.dup2(os.open(os.devnull, os.O_WRONLY), stream.fileno())


def say(text: str) -> None:
    """Lines of the summary."""
    if _level() != QUIET:
        click.echo("\n".join(folded(printable(line)) for line in text.split("\n")))


def present(*results: Sequence[str], last: str = "", most: int = FIRST_LINES) -> None:
    """At most ``most`` lines of a result, its verdict first and the ``last`` among them, as the terminal folds them; of
    several results their verdicts. All of it with -v."""
    lines, room = (
        [line for lines in results for line in lines],
        most - (folded(last).count("\n") + 1) * bool(last),
    )
    shown = lines if len(results) == 1 or _level() == VERBOSE else [lines[0] for lines in results]
    heights = list(accumulate(folded(printable(line)).count("\n") + 1 for line in shown))
    if _level() != VERBOSE and shown and (heights[-1] > room or shown != lines):
        shown = shown[: max(sum(height <= room - 1 for height in heights), 1)]
        shown.append(f"  ... {len(lines) - len(shown):,} more lines with -v")
    say("\n".join([*shown, *filter(None, [last])]))


def note(text: str) -> None:
    """A line on stderr on what goes on, for who waits."""
    if _level() != QUIET:
        tell(folded(f"jkr: {printable(text)}"))


def detail(text: str) -> None:
    """A line for those who want to know more."""
    if _level() == VERBOSE:
        tell(folded(f"jkr: {printable(text)}"))


def warn(text: str) -> None:
    """A sentence that a reader of the numbers should know; said once."""
    ctx = click.get_current_context(silent=True)
    before: set[str] = set() if ctx is None else ctx.meta.setdefault(WARNED, set())
    if text not in before:
        before.add(text)
        tell(folded(f"jkr: warning: {printable(text)}"))


def announce(what: str, seconds: float) -> None:
    """Say beforehand what will take so many CPU ``seconds``, where that is long and known."""
    if SILENCE < seconds < math.inf:
        forewarn(f"{what}: about {duration(seconds)} of CPU time", seconds)


def forewarn(words: str, seconds: float) -> None:
    """A note on what will take so many CPU ``seconds``, unless the command has told of half as many or more."""
    ctx = click.get_current_context(silent=True)
    meta: dict[str, float] = {} if ctx is None else ctx.meta
    if seconds > 2 * meta.get(ANNOUNCED, -1.0):
        meta[ANNOUNCED] = seconds
        note(words)


@contextlib.contextmanager
def progress(label: str, total: int, seconds: float) -> Iterator[Callable[[bool], None]]:
    """The forecast of all items, and a bar on stderr, on a terminal alone; what it gives is called as an item is
    finished: whether it failed."""
    announce(label, seconds)
    failed = 0
    with click.progressbar(
        range(total), label=label, file=sys.stderr, hidden=not sys.stderr.isatty(), show_percent=False, show_pos=True,
        item_show_func=lambda count: f"{count} failed" if count else None,
    ) as bar:  # fmt: skip

        def step(wrong: bool) -> None:
            nonlocal failed
            failed += wrong
            bar.update(1, failed)

        yield step


def command_line() -> str:
    """What was typed, as a shell would take it; bytes of names that are no text as escapes."""
    return writable(shlex.join(click.get_current_context().find_root().obj))


def answer(data: Mapping[str, Any]) -> None:
    """A result for machines on stdout."""
    from ..base.files import as_json

    click.echo(as_json(data), nl=False)


def give(result: Result, json: bool, written: str = "", of: Path | None = None) -> None:
    """A result on stdout, for machines or for people, these with what is ``written``; then its warnings, after the name
    of the file that they are ``of``."""
    if json:
        answer(result.summary())
    else:
        present(*result.parts, last=written, most=result.first_lines)
    for line in result.warnings:
        warn(f"{of}: {line}" if of else line)


# --------------------------------------------------------------------------------------------------
# A verb, options that it takes together, and how its help shows the options: at most twelve that everybody needs, the
# names of the others by their kind; ``--help-all`` describes all, each kind under its title.

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
                first = name in FIRST.get(self.name or "", ())
                group = next((title for title, names in GROUPS.items() if name in names and not first), "Options")
                rows[group][name] = record
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
