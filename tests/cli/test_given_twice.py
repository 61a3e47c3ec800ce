"""An option that takes one value, or one of each key, is refused when it is given twice, whatever the verb."""

from collections.abc import Callable, Iterator

import click
import pytest

from jkrcli import cli


def verbs(group: click.Group, path: tuple[str, ...] = ()) -> Iterator[tuple[tuple[str, ...], click.Command]]:
    """All verbs with the words that call them."""
    context = click.Context(group)
    for name in group.list_commands(context):
        command = group.get_command(context, name)
        if isinstance(command, click.Group):
            yield from verbs(command, (*path, name))
        elif command is not None:
            yield (*path, name), command


def test_every_option_of_every_verb(jkr: Callable) -> None:
    tried = 0
    for words, command in verbs(cli.jkr):
        for option in command.params:
            if not isinstance(option, click.Option) or option.is_flag or option.count:
                continue
            name = max(option.opts, key=len)
            keyed = option.multiple and getattr(option.type, "keyed", False)
            if option.multiple and not keyed:
                continue
            arguments = ["x"] * sum(isinstance(item, click.Argument) for item in command.params)
            given = [name, "P=1", name, "P=2"] if keyed else [name, "1", name, "2"]
            done = jkr(*words, *arguments, *given)
            assert done.code == 2, (words, name)
            said = f"{name}: P is given twice" if keyed else f"{name} is given 2 times"
            assert said in done.err or "must be KEY=" in done.err, (words, name, done.err)
            tried += 1
    assert tried > 150


@pytest.mark.parametrize("flags", [("--json", "--json"), ("-q", "-q"), ("--w", "1", "--w", "2")])
def test_flags_and_options_of_several_values_may_be_repeated(flags: tuple[str, ...], jkr: Callable) -> None:
    assert "is given" not in jkr("transform", "missing.h5", *flags).err
