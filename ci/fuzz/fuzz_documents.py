"""Documents made wrong, by Hypothesis: of a good one, one place holds something else.

Unlike bytes that are changed anywhere, these are well formed, so that they come past the parser to
what checks the meaning; and Hypothesis shrinks what it finds.
"""

import json
import math
import tomllib
from collections.abc import Callable
from functools import partial
from typing import Any

from hypothesis import strategies as st

Document = Any
Path = tuple[Any, ...]

NUMBERS = st.one_of(
    st.sampled_from([0, -1, 1, 2, 1e-320, 1e308, -1e308, 2**31, 2**63, 2**64, 10**30, 0.1]),
    st.floats(allow_nan=False, allow_infinity=False),
    st.integers(-(2**70), 2**70),
)
TEXTS = st.one_of(
    st.sampled_from(
        ["", " ", "..", "/", "a/../b", "\x00", "\x1b[2J", "::error::", "*", "{x}", "-"]
    ),
    st.text(max_size=12),
)
LEAVES = st.one_of(NUMBERS, TEXTS, st.booleans(), st.just([]), st.just({}), st.just([[]]))


def places(document: Document, here: Path = ()) -> list[Path]:
    """The paths of everything in a document."""
    found = [here]
    if isinstance(document, dict):
        for name, part in document.items():
            found += places(part, (*here, name))
    if isinstance(document, list):
        for number, part in enumerate(document):
            found += places(part, (*here, number))
    return found


def changed(document: Document, path: Path, change: Callable[[Document], Document]) -> Document:
    """A copy with another part at a path."""
    if not path:
        return change(document)
    copy: Document
    if isinstance(document, dict):
        copy = dict(document)
    else:
        copy = list(document)
    copy[path[0]] = changed(document[path[0]], path[1:], change)
    return copy


def removed(document: Document, path: Path) -> Document:
    """A copy without what is at a path."""

    def without(part: Document) -> Document:
        copy: Document
        if isinstance(part, dict):
            copy = dict(part)
        else:
            copy = list(part)
        del copy[path[-1]]
        return copy

    return changed(document, path[:-1], without)


def added(document: Document, path: Path, name: str, value: Document) -> Document:
    """A copy with one thing more beside what is at a path."""

    def with_more(part: Document) -> Document:
        if isinstance(part, dict):
            return {**part, name: value}
        return [*part, part[path[-1]]]

    return changed(document, path[:-1], with_more)


@st.composite
def wrong(draw: st.DrawFn, document: Document) -> Document:
    """The document with one to three places changed, taken away or doubled."""
    for _ in range(draw(st.integers(1, 3))):
        path = draw(st.sampled_from(places(document)[1:] or [()]))
        way = draw(st.sampled_from(["other", "other", "scaled", "removed", "added"]))
        if not path or way == "other":
            document = changed(document, path, lambda _: draw(LEAVES))
        elif way == "removed":
            document = removed(document, path)
        elif way == "added":
            document = added(document, path, draw(TEXTS), draw(LEAVES))
        else:
            factor = draw(st.sampled_from([-1, 0, 1e-300, 1e300, 1 + 2**-40]))
            document = changed(document, path, partial(scaled, factor=factor))
    return document


def scaled(part: Document, factor: float) -> Document:
    """A number times a factor; of anything else, nothing."""
    is_number = isinstance(part, (int, float)) and not isinstance(part, bool)
    if is_number and math.isfinite(part * factor):
        return part * factor
    return part


def as_json(document: Document) -> bytes:
    """JSON of a document."""
    return json.dumps(document).encode()


def as_toml(document: Document) -> bytes:
    """TOML of a document: inline tables, which JSON nearly has."""
    if not isinstance(document, dict):
        document = {"all": document}
    return "".join(f"{key(name)} = {inline(part)}\n" for name, part in document.items()).encode()


def key(name: str) -> str:
    """A key in quotes."""
    return inline(str(name))


def inline(part: Document) -> str:
    """A value as TOML has it in one line."""
    if isinstance(part, dict):
        return "{" + ", ".join(f"{key(name)} = {inline(one)}" for name, one in part.items()) + "}"
    if isinstance(part, list):
        return "[" + ", ".join(inline(one) for one in part) + "]"
    return json.dumps(part).replace("\x7f", "\\u007f")


def from_json(data: bytes) -> Document:
    """The document of JSON."""
    return json.loads(data)


def from_toml(data: bytes) -> Document:
    """The document of TOML."""
    return tomllib.loads(data.decode())
