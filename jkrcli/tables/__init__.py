"""What the cells of headers of tables say, names and units, by the words of ``words.toml``; what separates columns."""

from __future__ import annotations

import re
import tomllib
from collections.abc import Mapping
from functools import lru_cache
from pathlib import Path
from typing import Any

from ..base.process import REMEMBERED
from ..base.units import UNITS

# --------------------------------------------------------------------------------------------------
# Header cells as programs and instruments write them: a name and a unit.

LONGEST = 200  # choice: characters of a cell or a line that names something; longer ones take long to look through
WORDS: Mapping[str, Any] = tomllib.loads(Path(__file__).with_name("words.toml").read_text(encoding="utf-8"))
SPELLED: Mapping[str, str] = WORDS["units"]
BLANK = "blank"
SEPARATORS = {"tab": "\t", "semicolon": ";", "comma": ",", BLANK: None}


@lru_cache(maxsize=REMEMBERED)
def split_name(title: str) -> tuple[str, str]:
    """Name and unit of a header cell: "P (mN)", "P [mN]", "P / mN", "P_mN", "P in mN", "P mN"; "" where no unit is."""
    title = title.strip()
    if len(title) > LONGEST:
        return title, ""
    if match := re.match(r"(.*?)\s*(?:\[([^\]]*)\]|\(([^)]*)\))\Z", title):
        return match[1], (match[2] or match[3] or "").strip()
    if (match := re.match(r"(.+?)(?:\s*[/,_]\s*|\s+(?:in\s+)?)([^/,_\s]+)\Z", title)) and unit_power(match[2]):
        return match[1], match[2]
    return title, ""


def unit_power(unit: str) -> tuple[str, int] | None:
    """Dimension ("length", "area", "load" or "time") and power of ten of a unit; None where it is none of these."""
    unit = unit.strip().replace("µ", "u").replace("μ", "u").replace("²", "^2").replace("**", "^")
    unit = SPELLED.get(unit.lower().removesuffix("s"), SPELLED.get(unit.lower().removesuffix("n"), unit))
    for dimension in ("length", "load", "time"):
        if unit in UNITS[dimension]:
            return dimension, UNITS[dimension][unit]
    base = re.sub(r"\^?2\Z", "", unit)
    return ("area", 2 * UNITS["length"][base]) if base != unit and base in UNITS["length"] else None


def quantities(kind: str) -> dict[str, Any]:
    """What columns of a table of a ``kind`` hold, "measured" or "computed", by its key: meaning, dimension, names."""
    return WORDS["contact"] | WORDS[kind]["more"]
