"""Parameters of a case: exact numbers as the caller wrote them, with units and bounds."""

import difflib
import re
from collections.abc import Iterator, Mapping, Sequence
from copy import copy
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import numpy as np

from refdem.core.outside import one_line
from refdem.errors import UsageError

Exact = Fraction | tuple[Fraction, ...] | str | None
_LABEL = re.compile(r"([a-z0-9-]+)(?:\[(.*)\])?")
_NUMBER = re.compile(
    r"[+-]?(\d{1,60}(\.\d{0,60})?|\.\d{1,60})([eE][+-]?\d{1,3})?(/\d{1,60})?", re.ASCII
)
SMALLEST = Fraction(1, 10**100)
LARGEST = Fraction(10**100)
"""Squares and products of three parameters stay inside binary64."""


@dataclass(frozen=True, kw_only=True)
class Parameter:
    """The declaration of one parameter of a case.

    `default` is text ("3/2", "1,2,3"; "" where the case computes one). A parameter is a number, an
    array of numbers of the given `shape`, or one of the words `choices`; numbers lie within the
    bounds `above` (exclusive), `at_least` and `at_most`, and are integers if `whole` is True.
    """

    name: str
    default: str
    unit: str
    doc: str
    shape: tuple[int, ...] = ()
    above: float | None = None
    at_least: float | None = None
    at_most: float | None = None
    choices: tuple[str, ...] = ()
    whole: bool = False

    def bounds(self) -> str:
        """The bounds as text, such as "> 0 and <= 4"."""
        if self.choices:
            return " | ".join(self.choices)
        bounds = []
        if self.whole:
            bounds.append("whole")
        if self.above is not None:
            bounds.append(f"> {self.above:g}")
        elif self.at_least is not None:
            bounds.append(f">= {self.at_least:g}")
        if self.at_most is not None:
            bounds.append(f"<= {self.at_most:g}")
        return " and ".join(bounds) or "any"

    def parsed(self, text: str) -> Exact:
        """The exact value of `text`; raises UsageError that names the parameter."""
        if self.choices:
            if text not in self.choices:
                raise UsageError(
                    f"parameter {self.name}: got {text!r}; expected one of"
                    f" {', '.join(self.choices)}"
                )
            return text
        if text == "" and self.default == "":
            return None
        numbers = tuple(self._number(entry.strip()) for entry in text.split(","))
        if self.shape:
            expected = int(np.prod(self.shape))
        else:
            expected = 1
        if len(numbers) != expected:
            raise UsageError(
                f"parameter {self.name}: got {len(numbers)} numbers in {text!r}; expected"
                f" {expected}, separated by commas"
            )
        for number in numbers:
            self._refuse_out_of_bounds(number)
        if self.shape:
            return numbers
        return numbers[0]

    def _number(self, text: str) -> Fraction:
        """The exact value of a decimal or a fraction of decimals over a whole number."""
        if not _NUMBER.fullmatch(text):
            raise UsageError(
                f"parameter {self.name}: got {text!r}; expected a finite decimal or fraction such"
                " as 0.15, 1e-3 or 3/2"
            )
        numerator, _, denominator = text.partition("/")
        if denominator and int(denominator) == 0:
            raise UsageError(f"parameter {self.name}: got {text!r}; the denominator is zero")
        number = Fraction(numerator) / int(denominator or 1)
        if number and not SMALLEST <= abs(number) <= LARGEST:
            raise UsageError(
                f"parameter {self.name}: got {text!r}; expected 0 or a size between 1e-100 and"
                " 1e100"
            )
        return number

    def _refuse_out_of_bounds(self, number: Fraction) -> None:
        """Raises UsageError unless the number meets every bound that the parameter has."""
        meets_above = self.above is None or number > _as_written(self.above)
        meets_at_least = self.at_least is None or number >= _as_written(self.at_least)
        meets_at_most = self.at_most is None or number <= _as_written(self.at_most)
        meets_whole = not self.whole or number.denominator == 1
        if not (meets_above and meets_at_least and meets_at_most and meets_whole):
            raise UsageError(
                f"parameter {self.name}: got {float(number):.17g} {self.unit}; expected"
                f" {self.bounds()}"
            )


class Parameters(Mapping[str, Exact]):
    """The parameters of an instance, as exact values by name.

    `p.name` gives the rounded float or array (shape as declared) that engines run.
    """

    def __init__(self, declared: tuple[Parameter, ...], given: Mapping[str, str]) -> None:
        """Parses the `given` texts, and the defaults of the other declared parameters.

        Raises UsageError for a name that is not declared, or a text that its parameter refuses.
        """
        self.declared = {parameter.name: parameter for parameter in declared}
        for name in given:
            if name not in self.declared:
                raise UsageError(f"no parameter {name!r}; {nearest(name, self.declared)}")
        self.given = dict(given)
        self._exact = {p.name: p.parsed(given.get(p.name, p.default)) for p in declared}

    def __getitem__(self, name: str) -> Exact:
        return self._exact[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._exact)

    def __len__(self) -> int:
        return len(self._exact)

    def __getattr__(self, name: str) -> Any:
        """The parameter of that name as engines run it: a float, an array, or a word."""
        if name.startswith("_") or name not in self._exact:
            raise AttributeError(name)
        exact = self._exact[name]
        if isinstance(exact, tuple):
            return np.array([float(x) for x in exact]).reshape(self.declared[name].shape)
        if isinstance(exact, Fraction):
            return float(exact)
        return exact

    def replaced(self, exact: Mapping[str, Exact]) -> "Parameters":
        """The same parameters with other exact values of some; bounds are not checked."""
        other = copy(self)
        other._exact = self._exact | dict(exact)
        return other

    def texts(self) -> dict[str, str]:
        """Every value as text that `parsed` reads back."""
        return {name: _text(value) for name, value in self._exact.items()}

    def changed(self) -> dict[str, str]:
        """The values that differ from the defaults, as text, in declared order."""
        texts = {}
        for name, value in self._exact.items():
            parameter = self.declared[name]
            if value != parameter.parsed(parameter.default):
                texts[name] = _text(value)
        return texts


def _as_written(bound: float) -> Fraction:
    """A bound as the source has it: 0.999999 is that decimal, not the double below it."""
    return Fraction(repr(bound))


def _text(value: Exact) -> str:
    """The shortest text that `parsed` reads as exactly this value: a decimal, else a fraction."""
    if isinstance(value, tuple):
        return ",".join(_text(x) for x in value)
    if not isinstance(value, Fraction):
        return value or ""
    decimal = repr(float(value))
    # A fraction too large for a double is printed as inf.
    if "inf" not in decimal and Fraction(decimal) == value:
        exact = decimal
    else:
        exact = str(value)
    if exact.endswith(".0"):
        return exact[:-2]
    return exact


def text_of(value: Any) -> str:
    """A parameter as text: text as it is, a number as its exact value, several separated by commas.

    A float is the binary64 number that it is: 0.1 is 3602879701896397/36028797018963968, and "0.1"
    one tenth. Raises UsageError for anything else.
    """
    if isinstance(value, str):
        return value
    if isinstance(value, Sequence | np.ndarray):
        return ",".join(text_of(entry) for entry in value)
    try:
        return str(Fraction(value))
    except (TypeError, ValueError, OverflowError):
        raise UsageError(
            f"a parameter is {one_line(repr(value))}; expected a finite number, a text such as"
            ' "1/3", or several of them'
        ) from None


def nearest(name: str, known: Any) -> str:
    """A hint for an unknown name: the most similar of the `known` names, or all of them."""
    close = difflib.get_close_matches(name, list(known), 1, 0.5)
    if close:
        return f"did you mean {close[0]!r}?"
    return f"known: {', '.join(sorted(known))}"


def labelled(label: str) -> tuple[str, dict[str, str]]:
    """Case id and parameters of `case`, `case[name=value name=value]` or `case[member]`; raises
    UsageError.
    """
    match = _LABEL.fullmatch(label)
    if not match:
        raise UsageError(
            f"case {label!r} is not a valid name; expected a name such as pendulum or"
            " pendulum[theta0=2]"
        )
    pairs = (match[2] or "").split()
    # `case[name]` is short for `case[member=name]`.
    if pairs and "=" not in pairs[0]:
        pairs[0] = f"member={pairs[0]}"
    return match[1], settings(pairs)


def settings(pairs: list[str]) -> dict[str, str]:
    """Parameters from `name=value` texts; raises UsageError."""
    texts: dict[str, str] = {}
    for pair in pairs:
        name, equals, value = pair.partition("=")
        if not equals or not name or not value:
            raise UsageError(
                f"--set got {pair!r}; expected name=value, for example theta0=2 or inertia=1,2,3"
            )
        if texts.get(name, value) != value:
            raise UsageError(
                f"--set got {name} twice, as {texts[name]} and as {value}; expected it once"
            )
        texts[name] = value
    return texts
