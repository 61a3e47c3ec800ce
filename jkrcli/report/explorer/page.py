"""The page as one text: template, style, scripts, plotting library and data, with nothing left to load."""

from __future__ import annotations

import html
import json
import re
from collections.abc import Mapping
from importlib import resources
from operator import attrgetter
from typing import Any

from ... import __version__
from ...base import InputError, installs

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
