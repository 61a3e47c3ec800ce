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

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any

PACKAGE = Path(__file__).parent.parent


@dataclass(frozen=True)
class Verb:
    """A verb of a wing: the ``section`` of the help and the verb ``after`` which it stands there, one line of ``help``,
    and the ``module`` that holds it, imported when it is called; ``of_core``: one of the core, with more options."""

    section: str
    after: str
    help: str
    module: str
    of_core: bool = False


@dataclass(frozen=True)
class Wing:
    """What a wing registers: ``verbs`` of the command line, or more of one of the core; ``options`` of verbs that are
    not its own alone, by the verb; ``functions`` and classes of the Python interface with the modules that hold them;
    ``methods`` with the modules that make them known (``methods/protocol.py``); ``uses``: words by which others refuse
    what they cannot do without it; ``offers``: by the names that others ask for, what it adds to their results, as
    "module:name"."""

    name: str
    verbs: Mapping[str, Verb] = field(default_factory=dict)
    functions: Mapping[str, str] = field(default_factory=dict)
    options: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    methods: Mapping[str, str] = field(default_factory=dict)
    uses: tuple[str, ...] = ()
    offers: Mapping[str, str] = field(default_factory=dict)

    @property
    def names(self) -> dict[str, list[str]]:
        """All that is refused by name where the wing is not there, by kind."""
        own = [name for name, verb in self.verbs.items() if not verb.of_core]
        options = [f"{verb} {option}" for verb, some in self.options.items() for option in some]
        methods = [f"method {name}" for name in self.methods]
        kinds = {"verbs": own, "options": options, "functions": self.functions, "methods": methods, "uses": self.uses}
        return {kind: list(names) for kind, names in kinds.items() if names}


@cache
def wings() -> tuple[Wing, ...]:
    """The wings whose folders are there, in the order of their names."""
    folders = sorted(PACKAGE.glob("*/wing.py"))
    return tuple(import_module(f"jkrcli.{path.parent.name}.wing").WING for path in folders)


def is_offered(name: str) -> bool:
    """Whether a wing offers what is asked for by this ``name``."""
    return any(name in wing.offers for wing in wings())


def offered(name: str) -> Any:
    """What a wing offers by this ``name``, its engine imported now; None where no wing does."""
    if not is_offered(name):
        return None
    place = next(wing.offers[name] for wing in wings() if name in wing.offers)
    module, attribute = place.split(":")
    return getattr(import_module(f"jkrcli.{module}"), attribute)


def absent(name: str) -> str:
    """What refuses a ``name`` of a wing that is not there, "cycle --speed" of an option; empty for any other."""
    import tomllib

    known = tomllib.loads((PACKAGE / "wings.toml").read_text(encoding="utf-8"))
    for wing, kinds in known.items():
        if wing not in {each.name for each in wings()} and any(name in names for names in kinds.values()):
            return f'needs the wing "{wing}", which this installation lacks: install the whole of jkrcli'
    return ""
