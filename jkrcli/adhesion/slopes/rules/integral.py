"""The rule "integral"."""

from __future__ import annotations

from .. import Rule, register

SENTENCE = "S' and d(delta_H)/da fitted through their integrals; nothing is differentiated."
register(Rule("integral", SENTENCE, "jkrcli.adhesion.slopes.integral:integral"))
