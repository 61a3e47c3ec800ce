"""Equations as MathML, which browsers draw themselves: no script, no font and no picture has to be fetched."""

from __future__ import annotations

from docutils import nodes
from docutils.utils.math import MathError, latex2mathml, unichar2tex
from sphinx.application import Sphinx
from sphinx.util import logging

LOGGER = logging.getLogger(__name__)


def _mathml(latex: str, display: bool) -> str:
    """The element <math> of an equation in LaTeX."""
    try:
        return latex2mathml.tex2mathml(latex.translate(unichar2tex.uni2tex_table), as_block=display)
    except MathError as error:
        LOGGER.warning("cannot set the equation %s: %s", latex, error)
        return ""


def visit_math(self: object, node: nodes.math) -> None:
    """An equation in a line of text."""
    self.body.append(_mathml(node.astext(), display=False))
    raise nodes.SkipNode


def visit_displaymath(self: object, node: nodes.math_block) -> None:
    """An equation on lines of its own, with its number where it has one."""
    number = f'<span class="eqno">({node["number"]})</span>' if node.get("number") else ""
    self.body.append(f'<div class="math">{number}{_mathml(node.astext(), display=True)}</div>')
    raise nodes.SkipNode


def setup(app: Sphinx) -> dict[str, bool]:
    app.add_html_math_renderer("mathml", (visit_math, None), (visit_displaymath, None))
    return {"parallel_read_safe": True, "parallel_write_safe": True}
