"""Options of verbs that work on many items at once, and how many processes pay."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import AbstractContextManager
from typing import Any

import click

from ..base.executors import Pool, executor
from .voice import progress

PER_WORKER = 5.0  # CPU seconds of work that make it worth starting processes


def parallel_options(command: Callable[..., Any]) -> Callable[..., Any]:
    """--workers and --scheduler."""
    workers = click.option(
        "--workers", type=click.IntRange(min=1), help="Local processes [default: one per core, if they pay]."
    )
    scheduler = click.option(
        "--scheduler", metavar="ADDRESS", help="Dask scheduler that you run, such as tcp://node1:8786."
    )
    return workers(scheduler(command))


def pool_for(seconds: float, workers: int | None, scheduler: str | None) -> AbstractContextManager[Pool]:
    """The executor for work of about so many CPU ``seconds``: by default this process alone where that is little."""
    few = workers is None and scheduler is None and seconds < 2 * PER_WORKER
    return executor(1 if few else workers, scheduler, progress)
