"""A request as lines of `key value`, so that a program in C or Fortran needs no JSON reader."""

from typing import Any

import msgspec

from refdem.core.problem import Request


def request_text(request: Request) -> str:
    """The request as lines such as `scene.bodies.0.mass 1.0`, one for each number or word of its
    JSON.

    Indices count from 0, a list also has its length as `<key>.count`; numbers have 17 digits, and
    those that need not be whole have a point or an exponent; true and false are 1 and 0, null is
    left out.
    """
    document = msgspec.json.decode(request.to_json())
    return "".join(f"{key} {value}\n" for key, value in _lines("", document))


def _lines(key: str, value: Any) -> list[tuple[str, str]]:
    """The lines, as pairs of key and value, of a JSON value that stands at `key` of the
    document.
    """
    if key:
        prefix = f"{key}."
    else:
        prefix = ""
    if isinstance(value, dict):
        return [line for name, entry in value.items() for line in _lines(f"{prefix}{name}", entry)]
    if isinstance(value, list):
        lines = [(f"{prefix}count", str(len(value)))]
        for index, entry in enumerate(value):
            lines += _lines(f"{prefix}{index}", entry)
        return lines
    if value is None:
        return []
    if isinstance(value, bool):
        return [(key, str(int(value)))]
    if isinstance(value, float):
        return [(key, _digits(value))]
    return [(key, str(value))]


def _digits(value: float) -> str:
    """17 significant digits, with a point or an exponent."""
    text = f"{value:.17g}"
    if set(text) & set(".e"):
        return text
    return f"{text}.0"
