"""Reference pages from the code: commands with their options, and the fields of files.

Each directive writes Markdown and lets the parser of the page read it.
"""

import contextlib
import io
import json
from typing import Any

from docutils import nodes
from sphinx.application import Sphinx
from sphinx.util.docutils import SphinxDirective

PLACES = {"<": "&lt;", ">": "&gt;", "|": "\\|", "*": "\\*", "_": "\\_"}


def plain(text: str) -> str:
    """A text as Markdown shows it letter by letter, in one cell of a table; code stays code."""
    parts = " ".join(text.split()).split("`")
    for number in range(0, len(parts), 2):
        parts[number] = "".join(PLACES.get(letter, letter) for letter in parts[number])
    for number in range(1, len(parts), 2):
        parts[number] = parts[number].replace("|", "\\|")
    return "`".join(parts)


def code(text: str) -> str:
    """A text as code in one cell of a table; no text where there is none."""
    if not text:
        return ""
    return "`" + text.replace("|", "\\|") + "`"


def table(head: tuple[str, ...], rows: list[tuple[str, ...]]) -> str:
    """A table in Markdown."""
    lines = [head, tuple("---" for _ in head), *rows]
    return "\n".join("| " + " | ".join(line) + " |" for line in lines) + "\n"


def option_default(option: Any) -> str:
    """The default of an option as a person would type it."""
    value = option.default
    if value is None or value == "" or value is False or callable(value):
        return ""
    if isinstance(value, (list, tuple)):
        return " ".join(map(str, value))
    return str(value)


def option_names(option: Any) -> str:
    """How an option or an argument is written."""
    if option.param_type_name == "argument":
        return code(option.make_metavar(None) if option.metavar else option.name.upper())
    return ", ".join(code(name) for name in [*option.opts, *option.secondary_opts])


def of_command(name: str, command: Any) -> str:
    """A command: what it does, an example, its arguments and options."""
    said, _, example = (command.help or "").partition("Example:")
    parts = [f"## refdem {name}\n"]
    parts += [plain(paragraph) + "\n" for paragraph in said.strip().split("\n\n")]
    if example:
        parts.append(f"```text\n{' '.join(example.split())}\n```\n")
    rows = [
        (option_names(option), code(option_default(option)), plain(option.help or ""))
        for option in command.params
        if option.name != "help"
    ]
    if rows:
        parts.append(table(("argument or option", "default", "meaning"), rows))
    return "\n".join(parts)


class Commands(SphinxDirective):
    """All commands of the command line, each with its arguments and options."""

    def run(self) -> list[nodes.Node]:
        """Returns the nodes of the sections."""
        import typer

        from refdem.cli.app import app

        commands = typer.main.get_command(app).commands  # type: ignore[attr-defined]
        text = "\n".join(of_command(name, commands[name]) for name in sorted(commands))
        return self.parse_text_to_nodes(text, allow_section_headings=True)


def type_name(field: dict[str, Any]) -> str:
    """The type of a field in words."""
    if "$ref" in field:
        return field["$ref"].rpartition("/")[2]
    if "anyOf" in field:
        return " or ".join(type_name(one) for one in field["anyOf"])
    if "enum" in field:
        return "one of: " + ", ".join(code(str(one)) for one in field["enum"])
    if "const" in field:
        return code(json.dumps(field["const"]))
    if "prefixItems" in field:
        return f"array of {len(field['prefixItems'])} ({type_name(field['prefixItems'][0])})"
    if isinstance(field.get("items"), dict):
        return "array of " + type_name(field["items"])
    if isinstance(field.get("additionalProperties"), dict):
        return "table of " + type_name(field["additionalProperties"])
    return str(field.get("type", "any"))


def of_object(title: str, fields: dict[str, Any]) -> str:
    """A table of the fields of one object."""
    required = fields.get("required", [])
    rows = []
    for name, field in fields["properties"].items():
        default = ""
        if "default" in field:
            default = code(json.dumps(field["default"]))
        if name in required:
            default = "required"
        rows.append((code(name), type_name(field), default, plain(field.get("description", ""))))
    said = plain(fields.get("description", ""))
    return f"### {title}\n\n{said}\n\n" + table(("field", "type", "default", "meaning"), rows)


class Schema(SphinxDirective):
    """The fields of a file, as `refdem schema` has them."""

    required_arguments = 1

    def run(self) -> list[nodes.Node]:
        """Returns the nodes of the tables."""
        from refdem.cli.schema import command

        printed = io.StringIO()
        with contextlib.redirect_stdout(printed):
            command(self.arguments[0])
        schema = json.loads(printed.getvalue())
        objects = schema.get("$defs", {})
        if "items" in schema:
            # A table: each row is an object of its cells.
            objects = {"A row": schema["items"]}
        parts = [
            of_object(title, fields)
            for title, fields in objects.items()
            if fields.get("properties")
        ]
        return self.parse_text_to_nodes("\n".join(parts), allow_section_headings=True)


def escaped(paragraph: str) -> str:
    """A paragraph of plain text in which nothing outside code is markup; a table of words, whose
    lines are indented, is shown as it stands.
    """
    if "\n " in paragraph:
        return "::\n\n" + "\n".join("   " + line for line in paragraph.split("\n"))
    parts = paragraph.split("`")
    for number in range(0, len(parts), 2):
        part = parts[number].replace("\\", "\\\\")
        for letter in "*|_":
            part = part.replace(letter, "\\" + letter)
        parts[number] = part
    return "`".join(parts)


def as_plain_text(
    app: Sphinx, what: str, name: str, found: Any, options: Any, lines: list[str]
) -> None:
    """Docstrings are plain text, and are shown as such."""
    paragraphs = "\n".join(lines).split("\n\n")
    lines[:] = "\n\n".join(map(escaped, paragraphs)).split("\n")


def setup(app: Sphinx) -> dict[str, Any]:
    """Adds the directives."""
    app.add_directive("refdem-commands", Commands)
    app.add_directive("refdem-schema", Schema)
    app.connect("autodoc-process-docstring", as_plain_text)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
