"""Wings: folders that stand on the core of the program and are known to it by what they register.

A wing has one module ``wing``, which holds a ``WING``: names and help texts, no engine, nothing but the standard
library. The core finds wings by listing its folders and names none. What belongs to one whose folder was taken away
is refused by the list of ``wings.toml``.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cache
from importlib import import_module
from pathlib import Path

PACKAGE = Path(__file__).parent.parent


@dataclass(frozen=True)
class Verb:
    """A verb of a wing: the ``section`` of the help and the verb ``after`` which it stands there, one line of ``help``,
    and the ``module`` that holds it, imported when it is called."""

    section: str
    after: str
    help: str
    module: str


@dataclass(frozen=True)
class Wing:
    """What a wing registers: ``verbs`` of the command line and ``functions`` of the Python interface, the latter with
    the modules that hold them."""

    name: str
    verbs: Mapping[str, Verb] = field(default_factory=dict)
    functions: Mapping[str, str] = field(default_factory=dict)


@cache
def wings() -> tuple[Wing, ...]:
    """The wings whose folders are there, in the order of their names."""
    folders = sorted(path.parent.name for path in PACKAGE.glob("*/wing.py"))
    return tuple(import_module(f"jkrcli.{folder}.wing").WING for folder in folders)


def wing_of(name: str) -> str | None:
    """The wing that a verb or a function of Python called ``name`` belongs to, whether it is there or not."""
    import tomllib

    known = tomllib.loads((PACKAGE / "wings.toml").read_text(encoding="utf-8"))
    return next((wing for wing, names in known.items() if any(name in some for some in names.values())), None)


def absent(name: str) -> str:
    """The sentence that refuses a ``name`` of a wing that is not there; empty for any other."""
    wing = wing_of(name)
    if wing is None or wing in {each.name for each in wings()}:
        return ""
    return f'{name}: is of the wing "{wing}", which this installation lacks: install the whole of jkrcli'
