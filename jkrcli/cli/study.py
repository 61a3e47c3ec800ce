"""``jkr study``: maps and studies over many bodies, each a subcommand in a module of its own."""

from __future__ import annotations

import importlib

import click

STUDIES = {
    "pull-off-map": "The pull-off force on a layer, in pi w R, over w R^2/(E* h^3).",
    "sticking-map": "What sticking changes on a layer: S and load over those of sliding, over a/h.",
    "transition-map": "The pull-off force on a layer between JKR and DMT, over the range of adhesion.",
    "adhesion-map": "Which model of adhesion holds on a layer, over its range and the load.",
    "rate-map": "Pull-off force and energy lost over speed, stiffness and body.",
    "converge": "The same case on a sequence of meshes.",
}
MAKE = {
    "noise": "noise-study",
    "chart": "chart",
    "failures": "failures",
    "figures": "figures",
}  # studies of the methods


class Studies(click.Group):
    """A group whose commands live in the modules ``study_<name>`` and are imported on call only."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        return list(STUDIES)

    def get_command(self, ctx: click.Context, name: str) -> click.Command | None:
        if name not in STUDIES:
            return None
        attribute = f"study_{name.replace('-', '_')}"
        return getattr(importlib.import_module(f".{attribute}", __package__), attribute)

    def resolve_command(
        self, ctx: click.Context, args: list[str]
    ) -> tuple[str | None, click.Command | None, list[str]]:
        if args and args[0] not in STUDIES and not args[0].startswith("-"):
            if args[0] in MAKE:
                raise click.UsageError(f'"{args[0]}" is now run as make {MAKE[args[0]]}', ctx)
            raise click.UsageError(f'unknown study "{args[0]}" (studies: {", ".join(STUDIES)})', ctx)
        return super().resolve_command(ctx, args)

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        with formatter.section("Studies"):
            formatter.write_dl(list(STUDIES.items()))


@click.group(cls=Studies)
def study() -> None:
    """Maps and studies over many bodies.

    \b
    jkr study pull-off-map --nu 0.3 --nu 0.499
    """
