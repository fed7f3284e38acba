"""Formulas as MathML, which browsers draw themselves: no script, no font and no network is needed.

TeX is translated by docutils' own translator; what it does not know is a warning, and so an error of the build.
"""

from __future__ import annotations

import re

from docutils import nodes
from docutils.utils.math import MathError
from docutils.utils.math.latex2mathml import tex2mathml
from sphinx.application import Sphinx
from sphinx.util import logging
from sphinx.writers.html5 import HTML5Translator


LOGGER = logging.getLogger(__name__)
NUMBERED = '<div class="math-display" id="{id}">{math}<span class="eqno">({number})</span></div>\n'


def setup(app: Sphinx) -> dict[str, bool]:
    """Register the renderer; `html_math_renderer = "mathml"` chooses it."""
    app.add_html_math_renderer("mathml", inline_renderers=(inline, None), block_renderers=(block, None))
    return {"parallel_read_safe": True, "parallel_write_safe": True}


def inline(writer: HTML5Translator, node: nodes.math) -> None:
    """Write a formula of a sentence."""
    writer.body.append(translated(node, display=False))
    raise nodes.SkipNode


def block(writer: HTML5Translator, node: nodes.math_block) -> None:
    """Write a formula of its own line, with its number if it has one."""
    math, number = translated(node, display=True), node.get("number")
    if number:
        writer.body.append(NUMBERED.format(id=node["ids"][0] if node["ids"] else "", math=math, number=number))
    else:
        writer.body.append(f'<div class="math-display">{math}</div>\n')
    raise nodes.SkipNode


def translated(node: nodes.math | nodes.math_block, *, display: bool) -> str:
    """Return the MathML of a formula."""
    source = re.sub(r"(?m)^\s*%.*$", "", node.astext()).strip()
    if display and r"\\" in source and r"\begin{" not in source:
        source = rf"\begin{{aligned}}{source}\end{{aligned}}"
    try:
        return str(tex2mathml(source, as_block=display))
    except MathError as error:
        LOGGER.warning("formula %r: %s", source, error, location=node)
        return f"<code>{source}</code>"
