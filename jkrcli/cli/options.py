"""A verb: the options that it takes, at most twelve that its help describes unless all are asked for; options that
several verbs share, and their types: numbers with units, pairs of a key and its value, rows; what is written, -o,
--no-plots, --force and --json, as one argument."""

from __future__ import annotations

import contextlib
import functools
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, fields, is_dataclass
from functools import partial
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias, cast, get_args

import click
from click.core import ParameterSource

from ..adhesion.rules import RULES
from ..base import units
from ..base.arguments import exactly_one
from ..base.files import HANDED, received
from ..base.units import Ranged, doubtful_work
from ..base.wings import absent
from ..methods.protocol import LESS, Forecast, Limits, check_cost
from ..report.result import Output
from .printing import LEVEL, QUIET, VERBOSE, forewarn, warn

if TYPE_CHECKING:
    from ..adhesion.finite_range import RangeRequest
    from ..adhesion.roughness import Roughness
    from ..series import Solution

    ParamType = click.ParamType[Any, Any]
    PathType = click.Path[Path]
else:
    ParamType, PathType = click.ParamType, click.Path  # not generic in every version of click

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
    "Several force curves": ("shared", "own", "tip-radius", "sample"),
    "Speed and time": (
        "law", "relaxation", "terms", "rate", "rate-advance", "speed", "speed-approach", "hold", "dwell", "dwell-time",
        "program",
    ),
    "Numerics": ("tolerance", "slopes", "modulus-factor", "points", "rtol", "repeat"),
    "Limits": ("limit-memory", "limit-time", "hours", "workers", "scheduler"),
    "Output": (
        "output", "force", "json", "no-plots", "plot", "report", "quiet", "verbose", "dimensionless", "scale",
        "together", "help",
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


def as_one(name: str, make: Callable[..., Any] | str, *options: Options) -> Options:
    """Options that a verb takes as one argument ``name``: what ``make``, or "module:name" imported when the verb is
    called, makes of their values; of a dataclass those fields that are ``typed`` before the others. An option of the
    same ``name`` is one of theirs, wherever it stands."""
    if is_dataclass(make):
        options = (*(one.metadata["option"](one.name) for one in fields(make) if one.metadata), *options)

    def unused() -> None: ...

    several(*options)(unused)
    keys = {option.name for option in unused.__click_params__} | {name}  # type: ignore[attr-defined]

    def decorate(command: Command) -> Command:
        @functools.wraps(command)
        def taking(*words: Any, **others: Any) -> Any:
            values = {key: others.pop(key) for key in keys & others.keys()}
            if isinstance(make, str):
                module, attribute = make.split(":")
                called = getattr(import_module(f"jkrcli.{module}"), attribute)
            else:
                called = make
            return command(*words, **{name: called(**values)}, **others)

        return several(*options)(taking)

    return decorate


def typed(kind: Any, help: str, called: str = "") -> Any:
    """A field of a dataclass that is typed as an option, ``called`` so where not as the field."""
    return field(metadata={"option": lambda name: click.option(called or flag(name), name, type=kind, help=help)})


def flag(name: str) -> str:
    """What the option of a parameter is called on the command line."""
    return f"--{name.replace('_', '-')}"


def typed_options() -> dict[str, Any]:
    """The options and arguments that the user gave, by their names, with their values."""
    context = click.get_current_context()
    names = (name for name in context.params if context.get_parameter_source(name) is ParameterSource.COMMANDLINE)
    return {name: context.params[name] for name in names}


class MappingOption(click.Option):
    """An option KEY=VALUE, of which several are one mapping."""


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
                takes_more = any(getattr(parameter, kind, False) for kind in ("multiple", "is_flag", "count"))
                if isinstance(parameter, click.Option) and not takes_more and (times := order.count(parameter)) > 1:
                    raise click.UsageError(
                        f"{max(parameter.opts, key=len)} is given {times} times: it takes one value", ctx
                    )
        rest = super().parse_args(ctx, args)
        for parameter in self.params:
            if getattr(parameter.type, "keyed", False) and parameter.multiple:
                pairs = ctx.params.get(parameter.name or "") or ()
                keys = [key for key, _ in pairs]
                if twice := next((key for key in keys if keys.count(key) > 1), None):
                    raise click.UsageError(f"{parameter.opts[0]}: {twice} is given twice: it takes one value", ctx)
                if isinstance(parameter, MappingOption):
                    ctx.params[parameter.name or ""] = dict(pairs)
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
        handed = HANDED.fullmatch(str(path)) and not (ctx is not None and ctx.resilient_parsing)
        return received(cast(Path, path)) if handed else path


def verb(usage: str = "", name: str | None = None) -> Callable[[Command], click.Command]:
    """A command of the paths that its ``usage`` names as its help does: "file", "series measured...", "[files...]"."""

    def decorate(command: Command) -> click.Command:
        for word in reversed(usage.split()):
            count = -1 if "..." in word else 1
            command = click.argument(word.strip("[.]"), type=FileType(), nargs=count, required=word[0] != "[")(command)
        return click.command(name, cls=Verb)(command)

    return decorate


def _help_all(ctx: click.Context, param: click.Parameter, value: bool) -> None:
    if value and not ctx.resilient_parsing:
        ctx.meta[ALL] = True
        click.echo(ctx.get_help())
        ctx.exit()


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


# --------------------------------------------------------------------------------------------------
# Types of options, and options that several verbs share.

WORKERS = click.IntRange(1, 1024)


class NumberRange(click.FloatRange):
    """A number of a range; "nan", which every comparison lets pass, is of none."""

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        number = super().convert(value, param, ctx)
        if math.isnan(number):
            self.fail(f"{value} is not in the range {self._describe_range()}.", param, ctx)
        return number


def choice(kind: Any) -> Any:
    """The words of a ``Literal``."""
    return click.Choice([str(word) for word in get_args(kind)])


class MethodType(click.Choice):  # type: ignore[type-arg]
    """The name of a method; that of a wing that is not there is refused by it."""

    def get_invalid_choice_message(self, value: Any, ctx: click.Context | None) -> str:
        lacking = absent(f"method {value}")
        return f"{value} {lacking}" if lacking else super().get_invalid_choice_message(value, ctx)


POSITIVE = NumberRange(min=0, min_open=True)


class ParsedType(ParamType):
    """What ``parsed`` makes of a text; its ValueError is the message on the option. ``keyed``: a key and its value."""

    keyed = False

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        if not isinstance(value, str):  # it is one already
            return value
        try:
            return self.parsed(value)
        except ValueError as error:
            self.fail(str(error), param, ctx)

    def parsed(self, text: str) -> Any:
        """The value of ``text``; ValueError with what it must be."""
        raise NotImplementedError


class QuantityType(ParsedType):
    """A number, SI or with a unit, as Python reads one that is ``annotated`` so."""

    def __init__(self, name: str, annotated: Any):
        self.name = name
        self.ranged: Ranged = next(note for note in annotated.__metadata__ if isinstance(note, Ranged))

    def parsed(self, text: str) -> Any:
        return self.ranged.read(text)


class WorkType(QuantityType):
    """A work of adhesion; a doubtful bare number is warned of."""

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> float:
        work = super().convert(value, param, ctx)
        with contextlib.suppress(ValueError):  # of what was typed a number without a unit may be meant otherwise
            if isinstance(value, str) and math.isfinite(float(value)) and (doubt := doubtful_work(work)):
                warn(f"{param.opts[0] if param else 'w'}: {doubt}")
        return work


WORK = WorkType("WORK", units.Work)
LENGTH, LOAD = QuantityType("LENGTH", units.AnyLength), QuantityType("LOAD", units.AnyForce)
LENGTH_ABOVE_0, STRESS = QuantityType("LENGTH", units.Length), QuantityType("STRESS", units.Modulus)
FACTOR, SENSITIVITY = QuantityType("FACTOR", units.Factor), QuantityType("SENSITIVITY", units.Sensitivity)
STIFFNESS = QuantityType("STIFFNESS", units.Stiffness)  # of a device
CONTROL = QuantityType("STIFFNESS", units.Control)  # of what holds a contact


class KeyValueType(ParsedType):
    """KEY=TEXT with one of ``keys``; ``what`` names the text in help."""

    what, keyed = "NAME", True

    def __init__(self, keys: Sequence[str]):
        self.name, self.keys = f"KEY={self.what}", keys

    def parsed(self, text: str) -> Any:
        key, mark, value = text.partition("=")
        if not mark or key not in self.keys or not value:
            raise ValueError(f'must be KEY=VALUE with a key of {", ".join(self.keys)}, got "{text}"')
        return key, self.valued(key, value)

    def valued(self, key: str, value: str) -> Any:
        """What the ``value`` of a ``key`` stands for; ValueError with what it must be."""
        return value


class NamedType(ParsedType):
    """NAME=TEXT, told apart by the name alone: what the text may be depends on it."""

    name, example, keyed = "NAME=VALUE", 'NAME=VALUE, such as w="50 mJ/m^2"', True
    parted = staticmethod(str.partition)

    def parsed(self, text: str) -> Any:
        name, mark, value = (part.strip() for part in self.parted(text, "="))
        if not (name and mark and value):
            raise ValueError(f'must be {self.example}, got "{text}"')
        return name, value


class ColumnUnitType(NamedType):
    """KEY=UNIT with the key of a quantity, or the name or number of a column: only its file tells them apart."""

    name, example = "KEY=UNIT", "KEY=UNIT with a quantity or a column, such as P=nN"
    parted = staticmethod(str.rpartition)


class PairsType(ParsedType):
    """KEY=VALUE,KEY=VALUE ..."""

    name = "KEY=VALUE,..."

    def parsed(self, text: str) -> Any:
        pairs: dict[str, str] = {}
        for pair in text.split(","):
            key, mark, value = (part.strip() for part in pair.partition("="))
            if not (key and mark and value):
                raise ValueError(f'must be KEY=VALUE,..., such as v0="1 um/s",n=0.6, got "{text}"')
            if key in pairs:
                raise ValueError(f"{key} is given twice")
            pairs[key] = value
        return pairs


class RowsType(ParsedType):
    """FIRST..LAST, whole numbers from 1 on."""

    name = "FIRST..LAST"

    def parsed(self, text: str) -> Any:
        first, mark, last = text.partition("..")
        if not (mark and first.isdecimal() and last.isdecimal() and 0 < int(first[:9]) < int(last[:9])):
            raise ValueError(f'must be FIRST..LAST, two rows counted from 1, such as 100..900, got "{text}"')
        return int(first[:9]), int(last[:9])


NAMED, PAIRS, ROWS = NamedType(), PairsType(), RowsType()


class ScaleType(KeyValueType):
    """KEY=VALUE with a key among a, delta, P: a length or a load."""

    what = "VALUE"

    def __init__(self, keys: Sequence[str] = ("a", "delta", "P")):
        super().__init__(keys)

    def valued(self, key: str, value: str) -> Any:
        return (LOAD if key == "P" else LENGTH).parsed(value)


SCALE = ScaleType()


class KeyNumberType(KeyValueType):
    """KEY=NUMBER, the number finite and not 0."""

    what = "NUMBER"

    def valued(self, key: str, value: str) -> Any:
        number = 0.0
        with contextlib.suppress(ValueError):
            number = float(value)
        if not math.isfinite(number) or number == 0:
            raise ValueError(f'must be KEY=NUMBER, finite and not 0, got "{key}={value}"')
        return number


ANY = Limits(math.inf, math.inf)  # of verbs that have none


limits_options = as_one(
    "limits",
    lambda limit_memory, limit_time: Limits(limit_memory, limit_time),
    click.option("--limit-memory", type=POSITIVE, metavar="GIB",
                 help="Refuse runs that need more memory [default: 80 % of what is free]."),
    click.option("--limit-time", type=POSITIVE, default=Limits().hours, show_default=True, metavar="HOURS",
                 help="Refuse runs that need more CPU time."),
)  # fmt: skip


def begin(what: str, cost: Forecast, limits: Limits = ANY, less: str = LESS) -> None:
    """Say what ``what`` will cost, where that is much; Refusal beyond the ``limits``, with the advice to ask for
    ``less``."""
    if words := check_cost(what, cost, limits, less):
        forewarn(words, cost.seconds)


slopes_option = click.option("--slopes", type=click.Choice(["auto", *RULES]), default="auto", show_default=True,
                             help="Rule for the stiffness S = dP/ddelta and its derivative S'.")  # fmt: skip
modulus_factor_option = click.option(
    "--modulus-factor", type=FACTOR, default="1", show_default=True,
    help="Multiply all moduli, and a surface tension, by this factor; no new solution is needed.",
)  # fmt: skip


Parallel: TypeAlias = tuple[int | None, str | None]  # local processes, and the address of a Dask scheduler
parallel_options = as_one(
    "parallel",
    lambda workers, scheduler: (workers, scheduler),
    click.option("--workers", type=WORKERS, help="Local processes [default: one per core, if they pay]."),
    click.option("--scheduler", metavar="ADDRESS", help="Dask scheduler that you run, such as tcp://node1:8786."),
)


@dataclass(frozen=True)
class RangeOptions:
    """Adhesion of finite range: its tension [Pa] or its length [m]; None where it is the case's."""

    stress: float | None = typed(STRESS, 'Cohesive stress of finite-range adhesion, "100 MPa" [default: the case\'s].')
    length: float | None = typed(LENGTH_ABOVE_0, 'The same by its range, "0.3 nm".', "--range")

    def of(self, solution: Solution) -> RangeRequest:
        """The range for a ``solution``."""
        from ..adhesion.finite_range import RangeRequest

        return RangeRequest.of(solution.record, self.stress, self.length, "--stress or --range")


@dataclass(frozen=True, kw_only=True)
class CurveOptions(RangeOptions):
    """How curves are made of a solution: adhesion of finite range, the rule for slopes, a factor of all moduli."""

    slopes: str
    modulus_factor: float


@dataclass(frozen=True)
class State:
    """One state of a contact, by its ``radius`` [m] or ``load`` [N], and the ``work`` of adhesion [J/m^2]."""

    radius: float | None = typed(LENGTH, 'Contact radius, "2 um".', "--a")
    load: float | None = typed(LOAD, 'Load, "-3 mN" (stable branch), compression positive.')
    work: float | None = typed(WORK, "Work of adhesion; 0: nonadhesive [default: the case's first].", "--w")

    def refuse_wrong(self, verb: str) -> None:
        """InputError where not exactly one of radius and load is there."""
        exactly_one(verb, **{"--a": self.radius, "--load": self.load})


def _roughness(roughness: dict[str, str] | None, surface_energy: float | None) -> Roughness | None:
    if roughness is None and surface_energy is None:
        return None
    from ..adhesion.roughness import Roughness

    return Roughness.of_words(roughness, surface_energy)


roughness_options = as_one(
    "roughness",
    _roughness,
    click.option("--roughness", type=PAIRS,
                 help="Rough surfaces: rms=50nm,longest=20um,shortest=10nm,hurst=0.8, or psd=FILE,convention=C_iso (C, "
                 "q_C_iso_over_pi, C_1D): w less the elastic energy of full contact."),
    click.option("--surface-energy", type=WORK,
                 help='Of the soft body, "22 mJ/m^2": its area grows on rough surfaces [default: not counted].'),
)  # fmt: skip
state_options = as_one("state", State)
range_options = as_one("attraction", RangeOptions)
curve_options = as_one("how", CurveOptions, slopes_option, modulus_factor_option)


ONE_FILE = "Replace an existing file that jkr did not write."  # help of --force
ENDINGS = (".msh", ".vtu", ".csv", ".json", ".png", ".svg", ".pdf", ".h5", ".html", ".toml", ".txt")
json_option = click.option("--json", "as_json", is_flag=True, help="Print as JSON.")


class Folder(PathType):
    """A folder, there or to be made; a name that ends like one of the files that go into it is answered."""

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        folder = super().convert(value, param, ctx)
        if folder.suffix in ENDINGS and not folder.is_dir():
            self.fail(f"must be a folder, got the file name {folder}: file names follow the input")
        return folder


def into_folder(help: str = "Folder [default: the file's].", **options: Any) -> Options:
    """-o for a folder."""
    return click.option("-o", "--output", type=Folder(path_type=Path, file_okay=False), help=help, **options)


def into_file(help: str) -> Options:
    """-o for a file."""
    return click.option("-o", "--output", type=click.Path(path_type=Path), help=help)


def output_options(
    plots: str = "", json: str = "", force: str = "Replace existing files that jkr did not write."
) -> Options:
    """--no-plots, --force and --json with their help, the first and last where they have one.

    The verb takes the values, with that of -o (see ``into_folder``), as one argument ``output``: an ``Output``.
    """
    helps = {"--no-plots": plots, "--force": force, "--json": json}
    flags = [click.option(flag, is_flag=True, help=words) for flag, words in helps.items() if words]

    def made(force: bool, output: Path | None = None, no_plots: bool = False, json: bool = False) -> Output:
        return Output(output, force, not no_plots, json)

    return as_one("output", made, *flags)
