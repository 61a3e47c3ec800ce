"""The items of a study worked on by the executor that all verbs share, their results in order."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import Executor
from typing import TypeVar

from ...base.executors import completed

Item = TypeVar("Item")
Result = TypeVar("Result")


def in_order(
    executor: Executor | None, function: Callable[[Item], Result], items: Sequence[Item], label: str, chunk: int = 1
) -> list[Result]:
    """``function`` of all items (None: in this process, one after the other); the first exception to come is raised."""
    if executor is None:
        return [function(item) for item in items]
    found: dict[int, Result] = {}
    for index, result in completed(executor, function, items, label, chunk):
        if isinstance(result, Exception):
            raise result
        found[index] = result
    return [found[index] for index in range(len(items))]
