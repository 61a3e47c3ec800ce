"""One BLAS thread: the same numbers on every machine, and faster at these sizes."""

from __future__ import annotations

from collections.abc import Callable
from functools import wraps
from typing import ParamSpec, TypeVar

from threadpoolctl import threadpool_limits

Arguments = ParamSpec("Arguments")
Result = TypeVar("Result")


def one_thread(function: Callable[Arguments, Result]) -> Callable[Arguments, Result]:
    """``function`` with linear algebra on one thread, whatever the environment says; restored afterwards."""

    @wraps(function)
    def limited(*arguments: Arguments.args, **options: Arguments.kwargs) -> Result:
        with threadpool_limits(1):
            return function(*arguments, **options)

    return limited
