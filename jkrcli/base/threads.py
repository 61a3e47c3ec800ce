"""One BLAS thread: the same numbers on every machine, faster at these sizes, and no core is asked for twice."""

from __future__ import annotations

import functools
import os
from collections.abc import Callable
from typing import ParamSpec, TypeVar

Arguments = ParamSpec("Arguments")
Result = TypeVar("Result")
# What libraries that are loaded later read from the environment.
ONE_THREAD = dict.fromkeys(("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"), "1")


@functools.cache
def pin_blas() -> None:
    """One BLAS thread in this process from now on."""
    from threadpoolctl import threadpool_limits

    os.environ.update(ONE_THREAD)
    threadpool_limits(1)


def one_thread(function: Callable[Arguments, Result]) -> Callable[Arguments, Result]:
    """``function`` with linear algebra on one thread, whatever the environment says; restored afterwards."""

    @functools.wraps(function)
    def limited(*arguments: Arguments.args, **options: Arguments.kwargs) -> Result:
        from threadpoolctl import threadpool_limits

        with threadpool_limits(1):
            return function(*arguments, **options)

    return limited
