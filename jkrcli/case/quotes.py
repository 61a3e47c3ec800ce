"""Numbers with a unit that stand in a TOML file without quotes: ``radius = 10 um``, which is no TOML."""

from __future__ import annotations

import re

from ..base import InputError

NUMBER = r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?"
UNIT = r"[a-zA-ZµμÅ°][\w/^²*.-]*"
UNQUOTED = re.compile(
    rf"""(?P<key>(?:^|[{{,])[ \t]*[\w."'-]+)[ \t]*=[ \t]*(?P<value>{NUMBER}[ \t]*{UNIT})[ \t]*(?=[\#,}}]|\r?$)""",
    re.MULTILINE,
)
NUMERAL = re.compile(r"0[xob][0-9a-fA-F_]+")  # TOML's own numbers with letters


class UnquotedError(InputError):
    """Values with a unit lack their quotes, one in each of the ``lines``; ``quoted``: the text with them."""

    def __init__(self, source: str, text: str):
        self.quoted = UNQUOTED.sub(_quoted, text)
        super().__init__([
            f"{source}: line {text.count(chr(10), 0, match.start('value')) + 1}: text with a unit must stand in "
            f"quotes: {_quoted(match).strip('{, ')}"
            for match in UNQUOTED.finditer(text)
            if not NUMERAL.fullmatch(match["value"])
        ])  # fmt: skip


def _quoted(match: re.Match[str]) -> str:
    return match[0] if NUMERAL.fullmatch(match["value"]) else f'{match["key"]} = "{match["value"]}"'
