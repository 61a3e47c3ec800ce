"""Computations that go on together: what several of them need of one kind is computed for all of them in one call.

A *flow* is a computation written as a generator, in the order of its mathematics, that asks for its costly numbers:

    def flow(model):
        state = yield from ask(states, (model, x))
        ...
        return result

``states`` is a *kernel*: it takes a list of what is asked for and gives a list of answers, each of which depends on its
own question alone. A kernel works on arrays with one more axis, so that twenty questions cost little more than one.
``alone`` carries one flow out, ``together`` many: a single computation is a batch of one, and there is no second code.
An answer that is an exception is raised where it was asked for, in that flow only.
"""

from __future__ import annotations

from collections.abc import Callable, Generator, Hashable, Iterable, Sequence
from typing import Any, TypeAlias, TypeVar, cast

import numpy as np

from ..base.errors import JkrError

Question = TypeVar("Question")
Answer = TypeVar("Answer")
End = TypeVar("End")
Item = TypeVar("Item")

Kernel: TypeAlias = Callable[[list[Question]], Sequence[Answer | Exception]]


Flow: TypeAlias = Generator[tuple[Kernel[Any, Any], Any], Any, End]  # asks for the answer of a kernel to a question


def ask(kernel: Kernel[Question, Answer], question: Question) -> Flow[Answer]:
    """The answer of a ``kernel`` to a ``question``, within a flow: ``answer = yield from ask(kernel, question)``."""
    return (yield (kernel, question))


def alone(flow: Flow[End]) -> End:
    """Carry one flow out and return its result; its exceptions are raised."""
    (end,) = together([flow])
    if isinstance(end, Exception):
        raise end
    return end


def beside(flows: Sequence[Flow[End]]) -> Flow[list[End]]:
    """The results of several flows within a flow, which go on beside each other and those of others that wait as well;
    the first of their exceptions is raised."""
    return (yield from ask(_beside, flows))


def _beside(groups: list[Sequence[Flow[Any]]]) -> list[list[Any] | Exception]:
    found = iter(together([flow for flows in groups for flow in flows]))
    each = [[next(found) for _ in flows] for flows in groups]
    return [next((end for end in ends if isinstance(end, Exception)), ends) for ends in each]


def together(flows: Sequence[Flow[End]]) -> list[End | Exception]:
    """Carry out ``flows``, as of fits in lockstep, and return their results in their order, exceptions in place of
    those that failed.

    All go on until each waits for an answer. The kernel that was asked first answers next, so that flows which are
    behind catch up and kernels that come later have the most questions at once.
    """
    ends: list[Any] = [None] * len(flows)
    waiting: dict[Kernel[Any, Any], list[tuple[int, Any]]] = {}

    def go_on(which: int, answer: Any) -> None:
        flow = flows[which]
        try:
            wanted, question = flow.throw(answer) if isinstance(answer, Exception) else flow.send(answer)
        except StopIteration as end:
            ends[which] = end.value
        except Exception as error:
            ends[which] = error
        else:
            waiting.setdefault(wanted, []).append((which, question))

    for which in range(len(flows)):
        go_on(which, None)
    while (kernel := next((one for one, asked in waiting.items() if asked), None)) is not None:
        asked, waiting[kernel] = waiting[kernel], []
        for (which, _), answer in zip(asked, answers(kernel, [question for _, question in asked]), strict=True):
            go_on(which, answer)
    return ends


def answers(kernel: Kernel[Question, Answer], questions: list[Question]) -> Sequence[Answer | Exception]:
    """The answers of a ``kernel``; where it fails as a whole those to each question alone, or the exception."""
    try:
        return kernel(questions)
    except (JkrError, ArithmeticError, ValueError, MemoryError, RuntimeWarning) as error:  # others are faults of ours
        if len(questions) == 1:
            return [error]
        return [answer for question in questions for answer in answers(kernel, [question])]


def by_groups(
    items: Sequence[Item], key: Callable[[Item], Hashable], of: Callable[[Any, list[Item]], Iterable[Answer]]
) -> list[Answer]:
    """The answers ``of`` a key and those of the ``items`` that have it, in the order of the items."""
    places: dict[Hashable, list[int]] = {}
    for place, item in enumerate(items):
        places.setdefault(key(item), []).append(place)
    found: dict[int, Answer] = {}
    for own, some in places.items():
        found |= dict(zip(some, of(own, [items[place] for place in some]), strict=True))
    return [found[place] for place in range(len(items))]


def quiet(flow: Flow[End]) -> Flow[End]:
    """The flow with NumPy's warnings of arithmetic off while it goes on, and on again while it waits."""
    answer: Any = None
    while True:
        with np.errstate(all="ignore"):
            try:
                request = flow.throw(answer) if isinstance(answer, Exception) else flow.send(answer)
            except StopIteration as end:
                return cast(End, end.value)
        try:
            answer = yield request
        except Exception as error:
            answer = error
