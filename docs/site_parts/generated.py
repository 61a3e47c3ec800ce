"""Directives ``case-keys``, ``verbs`` and ``python-reference``, and a page for each verb, made from the program."""

from __future__ import annotations

import inspect
import re
from collections.abc import Callable, Iterator
from pathlib import Path

import click
from docutils import nodes
from sphinx.application import Sphinx
from sphinx.config import Config
from sphinx.util.docutils import SphinxDirective

import jkrcli
from jkrcli.cli import GROUPS, jkr
from jkrcli.cli.options import GROUPS as OPTIONS
from jkrcli.many.verbs import STUDIES

VERBS = Path("reference", "verbs")  # pages that are written anew by every build, one for each verb


def verbs() -> str:
    """Every verb with a line on it, by groups, and the tree of their pages."""
    parts = []
    for title, group in GROUPS.items():
        rows = "".join(f"| [`jkr {verb}`](verbs/{verb}.md) | {_plain(text)} |\n" for verb, text in group.items())
        parts.append(f"## {title}\n\n| verb | |\n|---|---|\n{rows}")
    pages = "\n".join(f"verbs/{verb}" for group in GROUPS.values() for verb in group)
    return "\n".join([*parts, f"```{{toctree}}\n:hidden:\n\n{pages}\n```"])


def write_verbs(app: Sphinx, config: Config) -> None:
    """Write a page for each verb; what stands there already stays untouched."""
    folder = Path(app.srcdir, VERBS)
    folder.mkdir(exist_ok=True)
    pages = {f"{verb}.md": _page(verb) for group in GROUPS.values() for verb in group}
    for old in folder.glob("*.md"):
        if old.name not in pages:
            old.unlink()
    for name, text in pages.items():
        path = folder / name
        if not path.exists() or path.read_text(encoding="utf-8") != text:
            path.write_text(text, encoding="utf-8")


def _page(verb: str) -> str:
    parts = [f"# jkr {verb}\n\n{_help(verb)}\n"]
    if verb == "study":
        parts += [f"## jkr study {name}\n\n{_help(verb, name)}\n" for name in STUDIES]
    return "\n".join(parts)


def _help(*words: str) -> str:
    """What ``jkr WORDS --help-all`` says, as paragraphs, examples and tables of options."""
    command: click.Command = jkr
    context = click.Context(jkr, info_name="jkr", **jkr.context_settings)
    for word in words:
        assert isinstance(command, click.Group)
        found = command.get_command(context, word)
        assert found is not None
        command, context = found, click.Context(found, info_name=word, parent=context)
    usage = " ".join(command.collect_usage_pieces(context))
    text, _, examples = inspect.cleandoc(command.help or "").partition("\b\n")
    parts = [_plain(text.strip()), f"```sh\njkr {' '.join(words)} {usage}\n```"]
    parts += [f"Examples:\n\n```sh\n{examples.strip()}\n```"] if examples else []
    return "\n\n".join([*parts, *_options(command, context)])


def _options(command: click.Command, context: click.Context) -> Iterator[str]:
    """Tables of the options of a verb, by their groups."""
    groups: dict[str, list[str]] = {title: [] for title in ("Options", *OPTIONS)}
    for parameter in command.get_params(context):
        record = parameter.get_help_record(context) if isinstance(parameter, click.Option) else None
        if record is not None:
            name = max(parameter.opts, key=len).removeprefix("--")
            group = next((title for title, names in OPTIONS.items() if name in names), "Options")
            groups[group].append(f"| `{record[0].replace('|', BAR)}` | {_plain(record[1])} |\n")
    for title, rows in groups.items():
        if rows:
            yield f"| {title} | |\n|---|---|\n{''.join(rows)}"


BAR = "\\|"


def _plain(text: str) -> str:
    """Text of the help whose characters mean nothing else on a page."""
    return re.sub(r"([<>*_$|`\[\]~])", r"\\\1", text)


class Verbs(SphinxDirective):
    """The verbs, each with a link to its page."""

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
    app.connect("config-inited", write_verbs)
    app.add_directive("verbs", Verbs)
    app.add_directive("case-keys", CaseKeys)
    app.add_directive("python-reference", PythonReference)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
