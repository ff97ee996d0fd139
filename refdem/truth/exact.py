"""Exact parameters by kind: one number, or the numbers of a vector; what is not exact is
refused.
"""

import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import fields, is_dataclass
from fractions import Fraction
from inspect import signature
from numbers import Number as AnyNumber
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


def refuse_rounded(
    constructor: Callable[..., None], given: Sequence[Any], named: Mapping[str, Any]
) -> None:
    """Raises TypeError for a number that is not exact, in any depth, where a truth's constructor is
    annotated with exact numbers.

    A binary64, a Decimal or a numpy number is never exact. An int is refused too, unless it is
    annotated: 1/3 of ints is rounded. An annotation that has float in it (a scale, against which
    errors count) is left alone.
    """
    refuse_rounded_arguments(constructor, (None, *given), named)


def refuse_rounded_arguments(
    function: Callable[..., Any], given: Sequence[Any], named: Mapping[str, Any]
) -> None:
    """The same for all arguments of a function that makes a truth."""
    found = signature(function)
    owner = function.__qualname__.partition(".")[0]
    for name, value in found.bind(*given, **named).arguments.items():
        refuse_rounded_part(owner, name, value, str(found.parameters[name].annotation))


def refuse_rounded_part(owner: str, name: str, value: Any, annotation: str) -> None:
    """The same for one argument, or for one field of a dataclass."""
    if is_dataclass(value) and not isinstance(value, type):
        for one in fields(value):
            refuse_rounded_part(
                f"{owner}: {type(value).__name__}",
                one.name,
                getattr(value, one.name),
                str(one.type),
            )
        return
    is_exact = re.search(r"\b(Fraction|Number)\b", annotation)
    may_be_rounded = re.search(r"\bfloat\b", annotation)
    if not is_exact or may_be_rounded:
        return
    may_be_int = re.search(r"\bint\b", annotation)
    for part in parts(value):
        is_int = isinstance(part, int)
        if (
            isinstance(part, AnyNumber)
            and not isinstance(part, Fraction)
            and not (is_int and may_be_int)
        ):
            raise TypeError(
                f"{owner} got {part!r} in {name}; expected exact numbers such as Fraction('{part}')"
            )


def parts(value: Any) -> Iterator[Any]:
    """The values in a value, however deep in mappings and sequences."""
    if isinstance(value, Mapping):
        value = list(value.values())
    if isinstance(value, list | tuple):
        for part in value:
            yield from parts(part)
    else:
        yield value
