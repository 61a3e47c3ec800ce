"""The command line: verbs are imported when they are called, so that ``jkr --help`` stays instant."""

import importlib
import io
import keyword
import os
import re
import sys
import warnings
from collections.abc import Container, Mapping, Sequence
from typing import ClassVar

import click

from .. import __version__
from ..base import process
from ..base.errors import InputError, JkrError, did_you_mean, printable
from ..base.wings import absent, wings
from .printing import folded, give_up, tell, warn

# One BLAS thread in this process, of which NumPy reads when it is first imported; too late after that: the same numbers
# everywhere, and faster at these sizes.
os.environ.update(process.ONE_THREAD)
process.pinned[:] = [True] * ("numpy" not in sys.modules or bool(process.pinned))
os.environ["PYDANTIC_DISABLE_PLUGINS"] = "__all__"  # nothing foreign reads along, and no search for it

MOST_WORDS = 100_000  # choice: of a command line; more take seconds to take apart

INTERRUPTED = 130  # 128 + SIGINT, as shells count
LITTLE = 1 << 29  # choice: bytes of address space; NumPy, SciPy and matplotlib take 0.4 GB to load
NO_ROOM = ("failed to map segment", "cannot allocate memory", "bad_alloc")  # of libraries that do not load
OUT_OF_MEMORY = "out of memory: use fewer points, larger elements or a cheaper method"

# What numpy warns of where a result would be no number: an error here, because nothing good can follow.
ARITHMETIC = "(overflow|divide by zero|invalid value) encountered"

CORE = {
    "Commands": {
        "new": "Write a commented case file to start from.",
        "check": "Method, cost and neglected effects, before it is solved.",
        "run": "Solve a case without adhesion: P, delta and a to HDF5.",
        "import": "Read P, delta and a that another program computed.",
        "transform": "JKR curve of each w (Eq. 13): CSV, JSON, plots.",
        "pull-off": "Pull-off force and stability; w from a measured force.",
    },
    "More of a case": {
        "compare": "Compare two results; exit code 1 where they differ.",
    },
    "More of an adhesive curve": {
        "cycle": "Force curve of an approach-retract cycle, over time too.",
        "profile": "Contact pressure, surface shape and gap at one state.",
        "export": "The contact law for particle codes: a C header and a table.",
    },
    "More of a measurement": {},
    "More": {
        "show": "Print what a solution file holds.",
        "doctor": "Check what works on this machine, and how to get the rest.",
        "completion": "Print the completion script of a shell.",
    },
}
MODULES = {  # where each verb is
    verb: f"cli.{module}"
    for module, verbs in {
        "case_verbs": ("new", "check", "run", "import"),
        "curve_verbs": ("transform", "pull-off", "profile", "export"),
        "cycle": ("cycle",),
        "file_verbs": ("compare", "show", "doctor", "completion"),
    }.items()
    for verb in verbs
} | {verb: each.module for wing in wings() for verb, each in wing.verbs.items()}


def _with_wings(core: Mapping[str, Mapping[str, str]]) -> dict[str, dict[str, str]]:
    """The verbs of the ``core`` and of all wings, with a line each, by the sections of the help; one of the core that a
    wing can do more with keeps its place."""
    groups = {title: list(names.items()) for title, names in core.items()}
    for wing in wings():
        for verb, each in wing.verbs.items():
            before = ["", *(name for name, _ in groups[each.section])]
            if verb not in before:
                at = before.index(each.after)
                groups[each.section].insert(at, (verb, each.help))
    return {title: dict(names) for title, names in groups.items() if names}


GROUPS = _with_wings(CORE)
VERBS = {verb: text for group in GROUPS.values() for verb, text in group.items()}
RARE = frozenset({"bench", "compare", "completion", "doctor", "mesh", "show", "study"})  # listed by --help --all alone
SILENT = frozenset({"completion", "study"})  # what one prints is a script, the other is a group


class LateGroup(click.Group):
    """A group whose commands are imported, or made, when they are called; ``titles``: their names with a line each, by
    the titles of the help's sections; ``silent``: those that print no result; ``rare``: those that the help lists with
    --all alone. What writes files can be quiet."""

    titles: ClassVar[Mapping[str, Mapping[str, str]]]
    silent: ClassVar[Container[str]] = ()
    rare: ClassVar[Container[str]] = ()

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
        from .options import level_options  # the command's module has it already

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
        rare = () if "--all" in (ctx.obj or ()) else self.rare
        for title, names in self.titles.items():
            if rows := [(name.ljust(width), text) for name, text in names.items() if name not in rare]:
                with formatter.section(title):
                    formatter.write_dl(rows)


class Verbs(LateGroup):
    """The verbs, each in a module of its own."""

    titles, silent, rare = GROUPS, SILENT, RARE

    def made(self, name: str) -> click.Command:
        attribute = name.replace("-", "_") + "_" * keyword.iskeyword(name)
        command: click.Command = getattr(importlib.import_module(f"jkrcli.{MODULES[name]}"), attribute)
        process.loaded()
        return command

    def unknown(self, name: str) -> str:
        if lacking := absent(name):
            return f"{name}: {lacking}"
        return f'unknown command "{name}"{did_you_mean(name, VERBS)} (commands: {", ".join(VERBS)})'


jkr = Verbs(
    "jkr",
    context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 100},
    help="""
    Adhesive (JKR) contact of axisymmetric bodies: from a case file to the adhesive curve, from a measured curve to
    E* and w.

    \b
    jkr run my.toml -o data.h5                    solve without adhesion
    jkr transform data.h5 --w "50 mJ/m^2"         the adhesive curve of any w
    jkr import fe.csv --case my.toml              another program's P, delta, a
    jkr transform fe.h5 --slopes loocv-kept       by the paper's splines (LOOCV)
    jkr fit curve.csv --radius "5 um" --nu 0.5    E* and w of a force curve

    Exit codes: 0 done, 2 bad input, 130 interrupted (Ctrl-C), 1 anything else.
    """,
)
click.version_option(__version__, prog_name="jkr")(jkr)
click.option("--all", is_flag=True, expose_value=False, help="With --help: list every verb.")(jkr)


def main() -> int:
    """Carry out the words of the process and return its exit code: one line per mistake on stderr, never a traceback
    for what the user can mend."""
    if isinstance(sys.stdout, io.TextIOWrapper):
        sys.stdout.reconfigure(errors="backslashreplace")  # a name that the terminal's encoding lacks is no mistake
    return call()


def call(arguments: Sequence[str] | None = None) -> int:
    """Run the command line and return its exit code."""
    try:
        words = list(sys.argv[1:] if arguments is None else arguments)
        if len(words) > MOST_WORDS:
            raise InputError(f"the command line holds {len(words):,} words, at most {MOST_WORDS:,} are read")
        # Say that ``ulimit -v`` leaves little: libraries that find no room wait for it, or end in words of their own.
        if (most := process.address_space()) < LITTLE:
            warn(f"the address space is limited to {most // 2**20:.0f} MiB: libraries may not load, or hang; "
                 "raise ulimit -v")  # fmt: skip
        # Say that a date for reproducible builds is none: libraries end in a ValueError of their own over it.
        try:
            int(date := os.environ.get("SOURCE_DATE_EPOCH", "0"))
        except ValueError:
            warn(f'SOURCE_DATE_EPOCH must be a whole number, got "{date}": it is left out')
            del os.environ["SOURCE_DATE_EPOCH"]
        with warnings.catch_warnings():
            warnings.filterwarnings("error", ARITHMETIC, RuntimeWarning)
            code = jkr.main(args=words, prog_name="jkr", standalone_mode=False, obj=["jkr", *words])
        return code if isinstance(code, int) else 0
    except InputError as error:
        return _fail(error.lines, error.exit_code)
    except JkrError as error:
        return _fail([str(error)], error.exit_code)
    except click.exceptions.NoArgsIsHelpError as error:
        click.echo(error.format_message())
        return 0
    except click.ClickException as error:
        verb, option = getattr(getattr(error, "ctx", None), "info_name", ""), getattr(error, "option_name", "")
        if lacking := absent(f"{verb} {option}"):
            return _fail([f"{verb}: {option} {lacking}"], 2)
        message = " ".join(line.strip() for line in error.format_message().splitlines()).strip().rstrip(".")
        message = re.sub(r"\. Did you mean (.*)\?$", r", did you mean \1?", message)
        if isinstance(error, click.UsageError) and error.ctx is not None:
            message += f"; see {error.ctx.command_path} --help"
        return _fail([message[:1].lower() + message[1:]], 2)
    except (KeyboardInterrupt, click.Abort) as error:
        which = str(error) or str(error.__cause__ or "")  # files, where some were replaced: see ``base.together``
        return _fail([f"interrupted; {which or 'nothing half-written was left'}"], INTERRUPTED)
    except (RuntimeWarning, OverflowError) as error:
        return _fail([f"arithmetic overflow ({error}): check the units of all lengths, moduli, loads and w"], 1)
    except (MemoryError, ImportError) as error:
        if isinstance(error, ImportError) and not any(words in str(error).lower() for words in NO_ROOM):
            raise
        return _fail([OUT_OF_MEMORY], 1)
    except BrokenPipeError:
        give_up(sys.__stdout__)
        return 1
    except OSError as error:
        if error.filename is None:
            give_up(sys.__stdout__)
        which = error.filename or "output"
        if not error.filename and isinstance(error, FileNotFoundError):
            which = "temporary files" if "temporary" in str(error) else "the current folder"
        return _fail([f"{which}: {error.strerror or error}"], 1)


def _fail(lines: Sequence[str], code: int) -> int:
    for line in lines:
        words = f"jkr: error: {printable(line)}"
        tell(folded(words) if sys.stderr.isatty() else words)  # one line in a log
    return code
