"""The rule "exact"."""

from __future__ import annotations

from .. import Rule, register

SENTENCE = "The slopes that the series carries; nothing is smoothed."
register(Rule("exact", SENTENCE, "jkrcli.adhesion.slopes.exact:exact"))
