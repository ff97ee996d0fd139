"""Pages as Sphinx reads them: links that leave the site, and notebooks.

A link to a file or folder of the repository that is no page becomes the name of that file.
"""

import json
import re
from pathlib import Path
from typing import Any

from myst_parser.parsers.sphinx_ import MystParser
from sphinx.application import Sphinx

ROOT = Path(__file__).parents[2]
LINK = re.compile(r"(?<!!)\[([^\]\n]+)\]\(([^)\s]+)\)")
"""A link in Markdown that is no picture: its words and its target."""
MANUAL = "reports/manual/index"
CONTENTS = "\n```{toctree}\n:hidden:\n:glob:\n\n[!i]*\ni[!n]*\nintermediate*\n```\n"


def without_files(app: Sphinx, docname: str, source: list[str]) -> None:
    """Replaces links to what is no page by their words and the path."""
    place = Path(app.env.doc2path(docname)).parent

    def kept(found: re.Match[str]) -> str:
        words, target = found.groups()
        if re.match(r"[a-z]+:|#", target):
            return found[0]
        path = (place / target.partition("#")[0]).resolve()
        if app.project.path2doc(path) in app.project.docnames or not path.exists():
            return found[0]
        name = path.relative_to(ROOT).as_posix()
        if words.strip("`") in (name, target):
            return f"`{name}`"
        return f"{words} (`{name}`)"

    source[0] = LINK.sub(kept, source[0])


def with_contents(app: Sphinx, docname: str, source: list[str]) -> None:
    """Adds the pages of the manual to the navigation: its index lists them in a table."""
    if docname == MANUAL:
        source[0] += CONTENTS


def page_of(notebook: dict[str, Any]) -> str:
    """The cells of a notebook as Markdown, each with the text that it printed."""
    parts = []
    for cell in notebook["cells"]:
        text = "".join(cell["source"])
        if cell["cell_type"] == "markdown":
            parts.append(text)
            continue
        parts.append(f"```python\n{text}\n```")
        printed = "".join("".join(output.get("text", "")) for output in cell["outputs"])
        if printed:
            parts.append(f"```text\n{printed.rstrip()}\n```")
    return "\n\n".join(parts) + "\n"


class NotebookParser(MystParser):
    """Reads a notebook as the page of its cells."""

    supported = ("notebook",)

    def parse(self, inputstring: str, document: Any) -> None:
        """Parses the Markdown of a notebook."""
        super().parse(page_of(json.loads(inputstring)), document)


def setup(app: Sphinx) -> dict[str, Any]:
    """Connects all of these."""
    app.add_source_parser(NotebookParser)
    app.connect("source-read", without_files)
    app.connect("source-read", with_contents)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
