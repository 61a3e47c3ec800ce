"""The rule "integral"."""

from __future__ import annotations

from .. import Rule, register

register(
    Rule(
        "integral",
        "S' and d(delta_H)/da fitted through their integrals; nothing is differentiated.",
        "jkrcli.adhesion.slopes.integral:integral",
    )
)
