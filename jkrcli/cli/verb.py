"""A verb, and how its help groups the options: what everybody needs first, each other kind under its title."""

from __future__ import annotations

import click

GROUPS = {
    "Reading": (
        "column", "unit", "factor", "flip", "zero", "contact", "stiffness", "sensitivity", "format", "separator",
        "decimal", "rows", "where", "sign", "area", "sort",
    ),
    "Statistics": (
        "start", "bound", "branch", "base-line", "noise", "loss", "confidence", "level", "samples", "seed", "uncertain",
        "window",
    ),
    "Speed and time": (
        "law", "relaxation", "terms", "rate", "rate-advance", "speed", "speed-approach", "hold", "dwell", "dwell-time",
        "program",
    ),
    "Numerics": ("tolerance", "slopes", "modulus-factor", "points", "rtol", "repeat"),
    "Limits": ("limit-memory", "limit-time", "hours", "workers", "scheduler"),
    "Output": (
        "output", "force", "json", "no-plots", "plot", "quiet", "verbose", "dimensionless", "scale", "together", "help",
    ),
}  # fmt: skip
# Options that mean something else to some verbs, where everybody needs them.
FIRST = {"cycle": ("stiffness",), "pull-off": ("stiffness", "uncertain"), "rate-map": ("rate", "speed", "stiffness")}


class Verb(click.Command):
    """A command whose help shows its options in groups."""

    def format_options(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        rows: dict[str, list[tuple[str, str]]] = {title: [] for title in ("Options", *GROUPS)}
        for parameter in self.get_params(ctx):
            record = parameter.get_help_record(ctx) if isinstance(parameter, click.Option) else None
            if record is not None:
                rows[self._group(max(parameter.opts, key=len).removeprefix("--"))].append(record)
        for title, records in rows.items():
            if records:
                with formatter.section(title):
                    formatter.write_dl(records)

    def _group(self, option: str) -> str:
        if option in FIRST.get(self.name or "", ()):
            return "Options"
        return next((title for title, names in GROUPS.items() if option in names), "Options")
