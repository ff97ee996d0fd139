"""A request as lines of `key value`, so that a program in C or Fortran needs no JSON reader."""

from typing import Any

import msgspec

from refdem.core.problem import Request


def request_text(request: Request) -> str:
    """Lines `scene.bodies.0.mass 1.0`: indices from 0, numbers with 17 digits, true and false as 1
    and 0, null left out.

    A list also has its length as `<key>.count`; numbers that need not be whole have a point or an
    exponent.
    """
    return "".join(
        f"{key} {value}\n" for key, value in _lines("", msgspec.json.decode(request.to_json()))
    )


def _lines(key: str, value: Any) -> list[tuple[str, str]]:
    """The lines, as pairs of key and value, of every leaf of a document."""
    if key:
        prefix = f"{key}."
    else:
        prefix = ""
    if isinstance(value, dict):
        return [line for name, part in value.items() for line in _lines(f"{prefix}{name}", part)]
    if isinstance(value, list):
        lines = [(f"{prefix}count", str(len(value)))]
        return lines + [
            line for n, part in enumerate(value) for line in _lines(f"{prefix}{n}", part)
        ]
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
