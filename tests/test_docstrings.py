"""Docstrings of the Python interface and of what a contributor registers: numpydoc sections that name what there is."""

import inspect
import re
from collections.abc import Callable
from typing import Any

import pytest

import jkrcli as jkr
from jkrcli.bodies.problem import Indenter
from jkrcli.measured.model_changes import AlternativeModel
from jkrcli.methods.protocol import Method

OFFERED = {name: getattr(jkr, name) for name in jkr.__all__ if inspect.isfunction(getattr(jkr, name))}
FUNCTIONS = {name: one for name, one in OFFERED.items() if not (one.__doc__ or "").startswith("Deprecated: `fit`")}
HEAD = re.compile(r"^([A-Z]\w+)\n-+$", re.M)


def sections(text: str) -> dict[str, str]:
    """The parts of a docstring by their heads; the summary by ""."""
    parts = HEAD.split(inspect.cleandoc(text))
    return {"": parts[0]} | dict(zip(parts[1::2], parts[2::2], strict=True))


def documented(part: str) -> list[str]:
    heads = [line.split(" : ")[0] for line in part.splitlines() if line and not line.startswith(" ")]
    return [name.strip().lstrip("*") for head in heads for name in head.split(",")]


@pytest.mark.parametrize("function", FUNCTIONS.values(), ids=FUNCTIONS)
def test_a_function_of_the_interface_says_what_it_takes_and_gives(function: Callable[..., Any]) -> None:
    parts = sections(function.__doc__ or "")
    assert parts[""].splitlines()[0].endswith(".")
    assert parts[""].split()[0] not in ("The", "A", "An", "What", "Whether", "Which", "How", "Where")
    assert documented(parts["Parameters"]) == list(inspect.signature(function).parameters)
    assert parts["Returns"].strip()


def test_what_is_said_to_be_raised_is_an_error_of_the_interface() -> None:
    named = {
        name for function in FUNCTIONS.values() for name in documented(sections(function.__doc__).get("Raises", ""))
    }
    assert named
    assert all(issubclass(getattr(jkr, name), jkr.JkrError) for name in named)


@pytest.mark.parametrize("kind", [jkr.Reading, AlternativeModel], ids=lambda kind: kind.__name__)
def test_the_fields_of_what_is_filled_in_are_described(kind: type) -> None:
    assert set(documented(sections(kind.__doc__ or "")["Parameters"])) == set(inspect.signature(kind).parameters)


@pytest.mark.parametrize("kind", [Indenter, Method], ids=lambda kind: kind.__name__)
def test_the_methods_that_a_contributor_writes_are_described(kind: type) -> None:
    text = sections(kind.__doc__ or "")["Methods"]
    heads = {line.split("(")[0] for line in text.splitlines() if line and not line.startswith(" ")}
    abstract = getattr(kind, "__abstractmethods__", None)
    assert heads == set(abstract or {"__call__", "refusal", "forecast"})
