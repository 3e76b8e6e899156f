"""Formulas as MathML, which browsers draw by themselves: no script, no font from elsewhere."""

import html
import re

from latex2mathml.converter import convert

_BLOCK = re.compile(r'<div class="arithmatex">\s*\\\[(.*?)\\\]\s*</div>', re.DOTALL)
_INLINE = re.compile(r'<span class="arithmatex">\\\((.*?)\\\)</span>', re.DOTALL)


def with_mathml(page: str) -> str:
    """Turn the LaTeX that pymdownx.arithmatex has marked in a page's HTML into MathML."""
    page = _BLOCK.sub(lambda match: convert(html.unescape(match[1].strip()), display="block"), page)
    return _INLINE.sub(lambda match: convert(html.unescape(match[1].strip())), page)
