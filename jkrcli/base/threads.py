"""One BLAS thread: the same numbers on every machine, faster at these sizes, and no core works for two."""

from __future__ import annotations

import functools
import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

# What libraries that are loaded later read from the environment.
ONE_THREAD = dict.fromkeys(("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"), "1")


_pinned: list[bool] = []  # holds True in a process that began with one thread


def begin_with_one() -> None:
    """One BLAS thread in this process, of which NumPy reads when it is first imported; too late after that."""
    os.environ.update(ONE_THREAD)
    _pinned[:] = [True] * ("numpy" not in sys.modules or bool(_pinned))


@functools.cache
def pin_blas() -> None:
    """One BLAS thread in this process from now on, whatever is loaded already."""
    from threadpoolctl import threadpool_limits

    os.environ.update(ONE_THREAD)
    threadpool_limits(1)


@contextmanager
def one_thread() -> Iterator[None]:
    """Context, or decorator, in which linear algebra works on one thread, whatever the environment says: on small
    matrices and many-column solves more only wait."""
    if _pinned:
        yield
    else:
        with _libraries("scipy.linalg" in sys.modules, "cvxopt" in sys.modules).limit(limits=1):
            yield


@functools.cache
def _libraries(*loaded: bool) -> Any:
    """All BLAS libraries, searched once for what is ``loaded`` (it takes milliseconds)."""
    from threadpoolctl import ThreadpoolController

    return ThreadpoolController()
