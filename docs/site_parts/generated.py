"""Directives ``case-keys``, ``verbs`` and ``python-reference``: parts of pages made from the program."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Iterator

import click
from docutils import nodes
from sphinx.application import Sphinx
from sphinx.util.docutils import SphinxDirective

import jkrcli
from jkrcli.cli import GROUPS, jkr
from jkrcli.cli.options import ALL
from jkrcli.many.verbs import STUDIES


def verbs() -> str:
    """Every verb with its help as it is printed, in groups."""
    return "\n\n".join(_groups())


def _groups() -> Iterator[str]:
    for title, group in GROUPS.items():
        yield f"## {title}"
        for verb in group:
            yield f"### jkr {verb}\n\n```text\n{_help(verb)}\n```"
            if verb == "study":
                yield from (f"#### jkr study {name}\n\n```text\n{_help(verb, name)}\n```" for name in STUDIES)


def _help(*words: str) -> str:
    """What ``jkr WORDS --help`` prints."""
    command: click.Command = jkr
    context = click.Context(jkr, info_name="jkr", **jkr.context_settings)
    for word in words:
        assert isinstance(command, click.Group)
        found = command.get_command(context, word)
        assert found is not None
        command, context = found, click.Context(found, info_name=word, parent=context)
    context.meta[ALL] = True
    return command.get_help(context)


class Verbs(SphinxDirective):
    """The verbs from their help."""

    def run(self) -> list[nodes.Node]:
        return self.parse_text_to_nodes(verbs(), allow_section_headings=True)


class CaseKeys(SphinxDirective):
    """The keys of a case file from the models."""

    def run(self) -> list[nodes.Node]:
        from .keys import page

        return self.parse_text_to_nodes(page(), allow_section_headings=True)


class PythonReference(SphinxDirective):
    """The names of the Python interface with their docstrings."""

    def run(self) -> list[nodes.Node]:
        parts = ("## Functions", inspect.isfunction), ("## Objects", inspect.isclass)
        return self.parse_text_to_nodes("\n\n".join(_described(*part) for part in parts), allow_section_headings=True)


def _described(title: str, kind: Callable[[object], bool]) -> str:
    """Every name of ``jkrcli.__all__`` of a kind: its parameters and its docstring as they stand in the source."""
    things = {name: getattr(jkrcli, name) for name in jkrcli.__all__}
    names = [name for name, thing in things.items() if kind(thing) and "Deprecated: " not in (thing.__doc__ or "")]
    return "\n\n".join([title, *(f"### jkr.{name}\n\n```python\n{_signature(name)}\n```" for name in names)])


def _signature(name: str) -> str:
    thing = getattr(jkrcli, name)
    text = inspect.getdoc(thing) or ""
    head = "" if inspect.isclass(thing) and issubclass(thing, Exception) else _parameters(thing)
    return f'{name}{head}\n"""{text}"""'


def _parameters(thing: Callable[..., object]) -> str:
    """The parameters with their defaults; types are told by the docstring, in words."""
    bare = [item.replace(annotation=inspect.Parameter.empty) for item in inspect.signature(thing).parameters.values()]
    return str(inspect.Signature(bare))


def setup(app: Sphinx) -> dict[str, bool]:
    app.add_directive("verbs", Verbs)
    app.add_directive("case-keys", CaseKeys)
    app.add_directive("python-reference", PythonReference)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
