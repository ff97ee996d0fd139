"""Functions that read TOML and JSON files of users and programs into typed structs.

Every fault becomes a UsageError of one sentence with its place: a name that no file can have, a
folder, bytes that are no text, brackets nested too deeply, a field that does not fit.
"""

import os
import re
import stat
import tomllib
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any, TypeVar

import msgspec

from refdem.core.outside import one_line
from refdem.core.parameters import nearest
from refdem.errors import UNREADABLE, UsageError

T = TypeVar("T")
MOST_BYTES = 2**26
"""Of a file; a baseline of 100,000 findings has a fifth of that, and /dev/zero has no end."""
UNKNOWN = re.compile(r"unknown field `([^`]*)`")
NO_WORD = re.compile(r"Invalid enum value '(.*)' - at `.*\.(\w+)[^.]*`")
"""A word that is none of those of its field, and the name of the field."""


def content(path: Path, expected: str) -> bytes:
    """The bytes of a file; raises UsageError that ends with `expected`, what the file should be.

    A pipe or device is refused at once: reading a pipe without a writer would never end.
    """
    try:
        with open(path, "rb", opener=_unwaiting) as file:
            if not stat.S_ISREG(os.fstat(file.fileno()).st_mode):
                raise ValueError("a pipe or a device, not a file")
            data = file.read(MOST_BYTES + 1)
    except (OSError, ValueError) as error:
        why = getattr(error, "strerror", None) or error
        raise UsageError(f"{one_line(str(path))}: {why}; expected {expected}") from None
    if len(data) > MOST_BYTES:
        raise UsageError(
            f"{one_line(str(path))}: more than {MOST_BYTES} bytes; expected {expected}"
        )
    return data


def _unwaiting(path: str, flags: int) -> int:
    """Opens a file without blocking, as a pipe without a writer would."""
    return os.open(path, flags | os.O_NONBLOCK)


def is_file(path: Path) -> bool:
    """True if there is a file of that name; False also for a name that no file can have."""
    try:
        return path.is_file()
    except (OSError, ValueError):
        return False


def toml_as(
    kind: type[T], path: Path, expected: str, defaults: Mapping[str, Any] | None = None
) -> T:
    """A TOML file as a struct of type `kind`; `defaults` are values of fields that it leaves out.

    Raises UsageError with the place of the first fault.
    """
    data = content(path, expected)
    try:
        fields = tomllib.loads(data.decode("utf-8"))
        return msgspec.convert({**(defaults or {}), **fields}, kind)
    except UNREADABLE as error:
        raise UsageError(f"{one_line(str(path))}: {error_message(error, kind)}") from None


def json_as(kind: type[T], data: bytes, where: str) -> T:
    """JSON as a struct of type `kind`; raises UsageError that begins with `where`, its origin."""
    try:
        return msgspec.json.decode(data, type=kind)
    except UNREADABLE as error:
        raise UsageError(f"{where}: {error_message(error, kind)}") from None


def error_message(error: Exception, kind: Any) -> str:
    """The message, on one line, of an error of decoding a `kind`.

    For an unknown field or word it suggests the most similar known one.
    """
    if isinstance(error, RecursionError):
        return "brackets within brackets, too deep to be read"
    text = one_line(str(error))
    unknown = UNKNOWN.search(text)
    if unknown is not None:
        name = unknown[1]
        known = {field.encode_name for field in fields(kind)}
        if name in known:
            return f"{text}; {name!r} is a field of another table: move it there"
        return f"{text}; {nearest(name, known)}"
    no_word = NO_WORD.search(text)
    if no_word is not None:
        word, name = no_word.groups()
        return f"{text}; {nearest(word, words(kind, name))}"
    return text


def words(kind: Any, name: str) -> set[str]:
    """The words that fields of that name may hold, in a struct type and those nested in it."""
    found = set[str]()
    for field in fields(kind):
        if field.encode_name == name:
            for info in nested(field.type):
                if isinstance(info, msgspec.inspect.LiteralType):
                    found.update(map(str, info.values))
    return found


def fields(kind: Any) -> Iterator[msgspec.inspect.Field]:
    """All fields of a struct type and of the types nested in it."""
    for info in nested(msgspec.inspect.type_info(kind)):
        if isinstance(info, msgspec.inspect.StructType):
            yield from info.fields


def nested(info: msgspec.inspect.Type) -> Iterator[msgspec.inspect.Type]:
    """A type and those nested in it: of fields, items and unions, and without annotations."""
    unvisited = [info]
    while unvisited:
        info = unvisited.pop()
        yield info
        if isinstance(info, msgspec.inspect.StructType):
            unvisited += [field.type for field in info.fields]
        elif isinstance(info, msgspec.inspect.ListType):
            unvisited.append(info.item_type)
        elif isinstance(info, msgspec.inspect.Metadata):
            unvisited.append(info.type)
        elif isinstance(info, msgspec.inspect.UnionType):
            unvisited += info.types
