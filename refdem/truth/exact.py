"""The parameters of a case as exact numbers or vectors, and the refusal of rounded numbers in the
constructors of truths.
"""

import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import fields, is_dataclass
from fractions import Fraction
from functools import cache
from inspect import signature, unwrap
from numbers import Number as AnyNumber
from typing import Any, get_args

from refdem.core.parameters import Exact


def number(p: Mapping[str, Exact], name: str) -> Fraction:
    """The parameter as one exact number; TypeError if it is something else."""
    value = p[name]
    if not isinstance(value, Fraction):
        raise TypeError(f"parameter {name} is {value!r}; expected a number")
    return value


def numbers(p: Mapping[str, Exact], *names: str) -> dict[str, Fraction]:
    """Several parameters as exact numbers, by name."""
    return {name: number(p, name) for name in names}


def vector(p: Mapping[str, Exact], name: str) -> tuple[Fraction, ...]:
    """The parameter as a flat tuple of exact numbers; TypeError if it is something else."""
    value = p[name]
    if not isinstance(value, tuple):
        raise TypeError(f"parameter {name} is {value!r}; expected a vector")
    return value


def sign_of(value: Any) -> int:
    """The sign -1, 0 or 1 of an exact number: a rational, or any other that decides `>` and `<`."""
    return int(value > 0) - int(value < 0)


def refuse_rounded(
    constructor: Callable[..., None], given: Sequence[Any], named: Mapping[str, Any]
) -> None:
    """Raises TypeError for a number that is not exact where a truth's constructor is annotated with
    exact numbers; `given` and `named` are its arguments.

    Numbers are looked for at any depth of mappings, sequences and dataclasses. A binary64, a
    Decimal or a numpy number is never exact. An int is refused too, unless it is annotated: 1/3 of
    ints is rounded. An annotation that has float in it (a scale, against which errors count) is
    left alone.
    """
    # None stands in for `self`, which is not made yet.
    refuse_rounded_arguments(constructor, (None, *given), named)


def refuse_rounded_arguments(
    function: Callable[..., Any], given: Sequence[Any], named: Mapping[str, Any]
) -> None:
    """Raises TypeError as `refuse_rounded` does, for all arguments of a function that makes a
    truth.
    """
    kinds = argument_kinds(function)
    owner = function.__qualname__.partition(".")[0]
    for name, value in signature(function).bind(*given, **named).arguments.items():
        refuse_rounded_part(owner, name, value, kinds[name])


def refuse_rounded_part(owner: str, name: str, value: Any, kinds: frozenset[Any]) -> None:
    """Raises TypeError as `refuse_rounded` does, for the argument or the field `name` of `owner`,
    whose annotation is made of the types `kinds`.
    """
    if is_dataclass(value) and not isinstance(value, type):
        whole = f"{owner}: {type(value).__name__}"
        for field, kinds_of_field in field_kinds(type(value)).items():
            refuse_rounded_part(whole, field, getattr(value, field), kinds_of_field)
        return
    if Fraction not in kinds or float in kinds:
        return
    for part in parts(value):
        is_exact = isinstance(part, Fraction) or (isinstance(part, int) and int in kinds)
        if isinstance(part, AnyNumber) and not is_exact:
            raise TypeError(
                f"{owner} got {part!r} in {name}; expected exact numbers such as Fraction('{part}')"
            )


@cache
def argument_kinds(function: Callable[..., Any]) -> dict[str, frozenset[Any]]:
    """The types in the annotation of each argument of a function."""
    names = unwrap(function).__globals__
    arguments = signature(function).parameters
    return {name: types_in(one.annotation, names) for name, one in arguments.items()}


@cache
def field_kinds(kind: type) -> dict[str, frozenset[Any]]:
    """The types in the annotation of each field of a dataclass."""
    names = vars(sys.modules[kind.__module__])
    return {one.name: types_in(one.type, names) for one in fields(kind)}


def types_in(annotation: Any, names: Mapping[str, Any]) -> frozenset[Any]:
    """The types that an annotation is made of, at any depth: Fraction and int for `dict[Fraction,
    list[int]]`.

    An annotation that is written as a text is read with the `names` of its module.
    """
    if isinstance(annotation, str):
        annotation = eval(annotation, dict(names))
    if isinstance(annotation, list):
        # The arguments of a callable.
        inner = tuple(annotation)
    else:
        inner = get_args(annotation)
        if not inner:
            return frozenset([annotation])
    types: set[Any] = set()
    for one in inner:
        types |= types_in(one, names)
    return frozenset(types)


def parts(value: Any) -> Iterator[Any]:
    """The values in a mapping, list or tuple, at any depth; any other value by itself."""
    if isinstance(value, Mapping):
        value = list(value.values())
    if isinstance(value, list | tuple):
        for part in value:
            yield from parts(part)
    else:
        yield value
