"""Exact parameters by kind: one number, or the numbers of a vector; what is not exact is refused."""

import re
from collections.abc import Callable, Mapping, Sequence
from fractions import Fraction
from inspect import signature
from typing import Any

from refdem.core.parameters import Exact


def number(p: Mapping[str, Exact], name: str) -> Fraction:
    """The parameter as one exact number; TypeError if it is something else."""
    value = p[name]
    if not isinstance(value, Fraction):
        raise TypeError(f"parameter {name} is {value!r}; expected a number")
    return value


def numbers(p: Mapping[str, Exact], *names: str) -> dict[str, Fraction]:
    """Several of them by name."""
    return {name: number(p, name) for name in names}


def vector(p: Mapping[str, Exact], name: str) -> tuple[Fraction, ...]:
    """The parameter as a flat tuple of exact numbers; TypeError if it is something else."""
    value = p[name]
    if not isinstance(value, tuple):
        raise TypeError(f"parameter {name} is {value!r}; expected a vector")
    return value


def refuse_rounded(constructor: Callable[..., None], given: Sequence[Any], named: Mapping[str, Any]) -> None:
    """Raises TypeError for an int or float, in any depth, where an argument is annotated with Fraction but not with float (nor int)."""
    found = signature(constructor)
    for name, value in found.bind(None, *given, **named).arguments.items():
        annotation = str(found.parameters[name].annotation)
        if re.search(r"\bFraction\b", annotation) and not re.search(r"\bfloat\b", annotation):
            for part in parts(value):
                if isinstance(part, float) or (isinstance(part, int) and not re.search(r"\bint\b", annotation)):
                    owner = constructor.__qualname__.partition(".")[0]
                    raise TypeError(f"{owner} got {part!r} in {name}; expected exact numbers such as Fraction('{part}')")


def parts(value: Any) -> list[Any]:
    """The values in a value, however deep in mappings and sequences."""
    if isinstance(value, Mapping):
        return parts(list(value.values()))
    return [found for part in value for found in parts(part)] if isinstance(value, list | tuple) else [value]
