"""The rule "exact"."""

from __future__ import annotations

from .. import Rule, register

register(
    Rule("exact", "The slopes that the series carries; nothing is smoothed.", "jkrcli.adhesion.slopes.exact:exact")
)
