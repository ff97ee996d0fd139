"""Exact parameters by kind: one number, or the numbers of a vector."""

from collections.abc import Mapping
from fractions import Fraction

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
