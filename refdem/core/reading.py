"""Files that people and programs wrote, read as what they should be: whatever is wrong is one
sentence with the place.

Raised is UsageError alone, for a name that no file can have, a folder, bytes that are no text,
brackets in brackets without end, and for what does not fit.
"""

import re
import tomllib
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any, TypeVar

import msgspec

from refdem.core.outside import one_line
from refdem.core.parameters import nearest
from refdem.errors import UNREADABLE, UsageError

T = TypeVar("T")
UNKNOWN = re.compile(r"unknown field `([^`]*)`")


def content(path: Path, expected: str) -> bytes:
    """The bytes of a file; `expected` says what should have been there."""
    try:
        return path.read_bytes()
    except (OSError, ValueError) as error:
        why = getattr(error, "strerror", None) or error
        raise UsageError(f"{one_line(str(path))}: {why}; expected {expected}") from None


def is_file(path: Path) -> bool:
    """Whether there is a file of that name; no for a name that none can have."""
    try:
        return path.is_file()
    except (OSError, ValueError):
        return False


def toml_as(
    kind: type[T], path: Path, expected: str, defaults: Mapping[str, Any] | None = None
) -> T:
    """A TOML file as a `kind`; `defaults` stand for what it does not say."""
    data = content(path, expected)
    try:
        found = tomllib.loads(data.decode("utf-8"))
        return msgspec.convert({**(defaults or {}), **found}, kind)
    except UNREADABLE as error:
        raise UsageError(f"{one_line(str(path))}: {said(error, kind)}") from None


def json_as(kind: type[T], data: bytes, where: str) -> T:
    """JSON as a `kind`; `where` says whose it is."""
    try:
        return msgspec.json.decode(data, type=kind)
    except UNREADABLE as error:
        raise UsageError(f"{where}: {said(error, kind)}") from None


def said(error: Exception, kind: Any) -> str:
    """What is wrong, with the nearest name where one is not known."""
    if isinstance(error, RecursionError):
        return "brackets within brackets, too deep to be read"
    text = one_line(str(error))
    unknown = UNKNOWN.search(text)
    if unknown is None:
        return text
    name = unknown[1]
    known = set(names(kind))
    if name in known:
        return f"{text}; {name!r} is a field of another table: move it there"
    return f"{text}; {nearest(name, known)}"


def names(kind: Any) -> Iterator[str]:
    """The names of all fields of a kind and of the kinds within it."""
    waiting = [msgspec.inspect.type_info(kind)]
    while waiting:
        found = waiting.pop()
        if isinstance(found, msgspec.inspect.StructType):
            for field in found.fields:
                yield field.encode_name
                waiting.append(field.type)
        elif isinstance(found, msgspec.inspect.ListType):
            waiting.append(found.item_type)
        elif isinstance(found, msgspec.inspect.Metadata):
            waiting.append(found.type)
        elif isinstance(found, msgspec.inspect.UnionType):
            waiting += found.types
