"""The page as one text: template, style, scripts, plotting library and data, with nothing left to load; and what was
written of it, in words and as JSON."""

from __future__ import annotations

import html
import json
import re
from collections.abc import Mapping
from dataclasses import dataclass
from importlib import resources
from operator import attrgetter
from pathlib import Path
from typing import Any

from ... import __version__
from ...base import InputError, installs
from ..result import Result

SCRIPTS = ("curve.js", "controls.js", "plots.js", "page.js")


def page(content: Mapping[str, Any]) -> str:
    """The HTML of ``content`` (see ``payload``); InputError where the plotting library is missing."""
    parts = {
        "title": html.escape(f"{content['stem']}: {content['body']}"),
        "style": _own("page.css"),
        "library": _library(),
        "content": _safe(json.dumps(content, allow_nan=False, separators=(",", ":"), default=attrgetter("reason"))),
        "script": "\n".join(map(_own, SCRIPTS)),
        "mark": f"<!-- jkr {__version__} -->",
    }
    return re.sub(r"\{\{(\w+)\}\}", lambda place: parts[place[1]], _own("page.html"))


def _own(name: str) -> str:
    return resources.files(__package__).joinpath(name).read_text(encoding="utf-8")


def _library() -> str:
    try:
        from plotly.offline import get_plotlyjs
    except ImportError:
        raise InputError(f"explore: needs the optional package plotly: {installs('explore')}") from None
    return get_plotlyjs()


def _safe(text: str) -> str:
    """JSON that cannot end the element it stands in."""
    return text.replace("<", "\\u003c").replace("\u2028", "\\u2028").replace("\u2029", "\\u2029")


@dataclass(frozen=True)
class Explored(Result):
    """The ``page`` of the series in ``file``, of so many ``rows``, that begins with ``w`` [J/m^2], and what was laid
    over it."""

    file: Path
    page: Path
    w: float
    rows: int
    curves: int
    measured_rows: int

    @property
    def size(self) -> int:
        """Bytes of the page."""
        return self.page.stat().st_size

    def summary(self) -> dict[str, Any]:
        written = {"file": str(self.file), "page": str(self.page), "bytes": self.size, "w_J_per_m2": self.w}
        return written | {"measured_curves": self.curves, "measured_points": self.measured_rows}

    def words(self) -> list[str]:
        overlaid = f", {self.measured_rows} measured points in {self.curves} curves" if self.curves else ""
        return [
            f"{self.rows} points{overlaid}: {self.file}",
            f"  written {self.page} ({self.size / 1e6:.1f} MB): open it in a browser",
        ]
