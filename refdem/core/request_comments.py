"""The lines of a request with comments that explain each of its parts.

The comments are the descriptions in the JSON Schema.
"""

import textwrap
from collections.abc import Iterator

import msgspec

from refdem.core.problem import Motion, Request, RequestDocument
from refdem.core.request_text import request_text
from refdem.scene import Body

COLUMNS = 98
"""Width of a comment."""
ELEMENTS = (
    "what acts on the bodies; `a` and `b` are numbers of bodies, from 0, and b = -1 is the world;"
    " anchors [m] are in body axes from the centre of mass, those of the world in space axes"
)


def commented(request: Request) -> Iterator[str]:
    """The lines of `request_text`, each new field, body and element with its meaning before it as
    lines that start with #.
    """
    meanings = dict(_meanings(request))
    for line in request_text(request).splitlines():
        key = line.partition(" ")[0]
        meaning = _first_of(key, meanings)
        if meaning:
            yield from textwrap.wrap(meaning, COLUMNS, initial_indent="# ", subsequent_indent="# ")
        yield line


def _first_of(key: str, meanings: dict[str, str]) -> str:
    """The meaning of the part that begins with this line, "" if none does; each is given once."""
    parts = key.split(".")
    for count in range(len(parts), 0, -1):
        meaning = meanings.pop(".".join(parts[:count]), "")
        if meaning:
            return meaning
    return ""


def _meanings(request: Request) -> Iterator[tuple[str, str]]:
    """Pairs of a key of the request and its meaning."""
    if not isinstance(request.problem, Motion):
        yield "problem", request.problem.words
        return
    for field in msgspec.inspect.type_info(RequestDocument).fields:  # type: ignore[attr-defined]
        description = _description(field.type)
        if description:
            yield field.name, description
    yield "method", "name of the method, as refdem.toml has it"
    yield "scene.elements.count", ELEMENTS
    scene = request.problem.scene
    if not scene.has_bodies_file:
        yield "scene.bodies.0", _sentence(Body)
    for number, element in enumerate(scene.elements):
        yield f"scene.elements.{number}", _sentence(type(element))


def _description(type_of_field: msgspec.inspect.Type) -> str:
    """The description of a field's type, or of the first of its alternatives that has one."""
    extra = getattr(type_of_field, "extra_json_schema", None) or {}
    if "description" in extra:
        return str(extra["description"])
    for alternative in getattr(type_of_field, "types", ()):
        found = _description(alternative)
        if found:
            return found
    return ""


def _sentence(kind: type) -> str:
    """The docstring of a type as one line."""
    return " ".join((kind.__doc__ or "").split())
