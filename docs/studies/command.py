"""What the maintainers' studies, run by make, share on their command lines: options, progress, a line per mistake."""

from __future__ import annotations

import argparse
import contextlib
import itertools
import sys
import warnings
from collections.abc import Callable, Iterator, Sequence
from contextlib import AbstractContextManager
from pathlib import Path
from typing import TypeAlias

from jkrcli.base import units
from jkrcli.base.errors import InputError, JkrError
from jkrcli.base.executors import Pool, Step, executor
from jkrcli.base.process import pin_blas
from jkrcli.report.result import Output

Main: TypeAlias = Callable[[Sequence[str] | None], int]


def parser_of(about: str, parallel: bool = True) -> argparse.ArgumentParser:
    """A parser of the options that all studies share; ``about``: what the study does, for its help."""
    parser = argparse.ArgumentParser(description=about, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("-o", "--output", type=Path, default=Path(), help="folder [default: this one]")
    parser.add_argument("--no-plots", action="store_true", help="write no pictures")
    parser.add_argument("--json", action="store_true", help="print as JSON, where the study has a summary")
    if parallel:
        parser.add_argument("--workers", type=int, help="local processes [default: one per core, if they pay]")
        parser.add_argument("--scheduler", help="Dask scheduler that you run, such as tcp://node1:8786")
    return parser


def quantity(dimension: str) -> Callable[[str], float]:
    """The type of an option that takes a number with a unit."""

    def number(text: str) -> float:
        try:
            return units.parse(text, dimension)
        except ValueError as error:
            raise argparse.ArgumentTypeError(str(error)) from None

    return number


def output_of(given: argparse.Namespace) -> Output:
    """Where and how the study writes, over what was there; its folder is made."""
    output = Output(given.output, True, not given.no_plots, given.json)
    output.folder(Path())
    return output


def pool_of(given: argparse.Namespace, seconds: float) -> AbstractContextManager[Pool]:
    """The workers asked for, for about so many CPU ``seconds``."""
    return executor(given.workers, given.scheduler, counted, seconds)


@contextlib.contextmanager
def counted(label: str, total: int, seconds: float) -> Iterator[Step]:
    """Progress as one line on stderr, on a terminal alone."""
    done, shown = itertools.count(1), sys.stderr.isatty()

    def step(failed: bool) -> None:
        if shown:
            print(f"\r{label} {next(done)}/{total}", end="", file=sys.stderr, flush=True)

    yield step
    if shown:
        print(file=sys.stderr)


def call(main: Main, words: Sequence[str] | None = None) -> int:
    """The exit code of a study: 2 for bad input, 1 for anything else, each with a line per mistake on stderr."""
    pin_blas()
    try:
        with warnings.catch_warnings():
            warnings.filterwarnings("error", "(overflow|divide by zero|invalid value) encountered", RuntimeWarning)
            return main(words)
    except JkrError as error:
        for line in error.lines if isinstance(error, InputError) else [str(error)]:
            print(f"jkr: error: {line}", file=sys.stderr)
        return error.exit_code
