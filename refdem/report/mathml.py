"""Equations as MathML, from LaTeX that is not trusted: only elements and attributes of a closed
list get through.
"""

import html
import re
from xml.etree.ElementTree import Element

from markupsafe import Markup

ELEMENTS = {
    "math",
    "mrow",
    "mi",
    "mn",
    "mo",
    "ms",
    "mtext",
    "mspace",
    "mfrac",
    "msqrt",
    "mroot",
    "msub",
    "msup",
    "msubsup",
    "munder",
    "mover",
    "munderover",
    "mmultiscripts",
    "mtable",
    "mtr",
    "mtd",
    "mstyle",
    "mpadded",
    "mphantom",
}
ATTRIBUTES = {
    "mathvariant",
    "stretchy",
    "fence",
    "separator",
    "form",
    "accent",
    "accentunder",
    "displaystyle",
    "scriptlevel",
    "columnalign",
    "rowspacing",
    "columnspacing",
    "linethickness",
    "width",
    "height",
    "depth",
    "lspace",
    "rspace",
    "minsize",
    "maxsize",
    "symmetric",
    "largeop",
    "movablelimits",
}


def equations(latex: str) -> list[Markup]:
    """Each equation of a text that has them separated by `\\quad`, `\\qquad`, `\\\\` or line ends;
    source text if it is no LaTeX.
    """
    return [_equation(part) for part in _parts(latex)]


def _parts(latex: str) -> list[str]:
    """The text cut at separators outside braces and environments."""
    if r"\begin" in latex:
        return [latex.strip()]
    parts = [""]
    depth = 0
    for piece in re.split(r"(\\qquad|\\quad|\\\\|\n|\\left|\\right|\\[{}]|[{}])", latex):
        depth += piece in ("{", r"\left")
        depth -= piece in ("}", r"\right")
        if depth == 0 and piece in (r"\qquad", r"\quad", r"\\", "\n"):
            parts.append("")
        else:
            parts[-1] += piece
    return [part.strip().rstrip(",").strip() for part in parts if part.strip(" ,")]


def _equation(latex: str) -> Markup:
    from latex2mathml.converter import Converter

    try:
        tree = Converter(display="block").convert_to_element(latex)
    except Exception:  # latex2mathml has no common base class for its errors
        return Markup("<code>{}</code>").format(latex)
    return Markup(_clean(tree))


def _clean(element: Element) -> str:
    """The element as markup; elements that are not allowed are replaced by their text."""
    inside = _text(element.text)
    for child in element:
        inside += _clean(child) + _text(child.tail)
    if element.tag not in ELEMENTS:
        return inside
    attributes = ""
    for name, value in element.attrib.items():
        if name in ATTRIBUTES:
            attributes += f' {name}="{html.escape(value)}"'
    if element.tag == "math":
        attributes += ' display="block"'
    return f"<{element.tag}{attributes}>{inside}</{element.tag}>"


def _text(text: str | None) -> str:
    return html.escape(html.unescape(text or ""))
