"""``jkr completion``: the script that completes verbs, options and files in a shell."""

from __future__ import annotations

import click
from click.shell_completion import get_completion_class

from .verb import verb


@verb()
@click.argument("shell", type=click.Choice(["bash", "zsh", "fish"]))
@click.pass_context
def completion(ctx: click.Context, shell: str) -> None:
    """Print the completion script of SHELL.

    \b
    jkr completion bash >> ~/.bashrc
    jkr completion zsh >> ~/.zshrc
    jkr completion fish > ~/.config/fish/completions/jkr.fish
    """
    kind = get_completion_class(shell)
    assert kind is not None
    click.echo(kind(ctx.find_root().command, {}, "jkr", "_JKR_COMPLETE").source())
