"""Options of laws over time, known before their engines are imported."""

import sys
from importlib import import_module
from typing import Any

import click

from ..cli import options


class Names(click.Choice):  # type: ignore[type-arg]
    """The names of a registry, "module:NAME": its ``names`` that help shows, and all, once its module is there."""

    def __init__(self, *names: str, of: str):
        super().__init__(names)
        self.module, self.registry = f"jkrcli.{of}".split(":")

    def known(self, now: bool) -> tuple[str, ...]:
        """The names that are known, or ``now`` are to be."""
        module = import_module(self.module) if now else sys.modules.get(self.module)
        return self.choices if module is None else tuple(getattr(module, self.registry))

    def get_metavar(self, **words: Any) -> str | None:  # type: ignore[override]
        self.choices = self.known(False)
        return super().get_metavar(**words)

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        self.choices = self.known(True)
        return super().convert(value, param, ctx)


over_time = options.several(
    click.option("--law", type=Names("power", "log", of="viscoelastic.rate:RATE_LAWS"),
                 help="w depends on the speed of the contact line: w0 and the law's v0, n (or v0, b) are free too, all "
                 "force curves are fitted together; needs t, delta, P. With --relaxation whole force curves of a "
                 "viscoelastic specimen."),
    click.option("--relaxation", type=Names("sls", "kelvin-voigt", "power", "prony", of="bodies.problem:RELAXATIONS"),
                 help="Viscoelastic specimen: modulus, law and contact point from t, delta, P of indentation, dwell "
                 "and retraction; with --free w of whole force curves that adhere."),
    click.option("--terms", type=click.IntRange(1, 4), help="Of --relaxation prony [default: 2]."),
)  # fmt: skip
rest_options = options.several(
    click.option("--rest-load", type=options.LOAD, help="Viscoelastic specimens: at rest under this load, then pulled "
                 "instantly [default: at rest at P = 0]."),
    click.option("--rest-depth", type=options.LENGTH, help="The same at this displacement delta."),
)  # fmt: skip
