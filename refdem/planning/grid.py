"""The settings of a parameter study: every combination of the values that each parameter takes."""

import itertools
import math
from collections.abc import Mapping
from fractions import Fraction

from refdem.core import discovery
from refdem.core.case import Canonical, Instance
from refdem.core.outside import one_line
from refdem.core.parameters import Parameter, labelled, nearest, settings
from refdem.core.selection import Selection
from refdem.errors import UsageError

MOST = 2500
"""Largest number of settings, 50 by 50: a range with a mistyped step easily has more."""
EXAMPLES = "0.5,1,2 or 0.5:2:0.5 (first:last:step)"


def instances(label: str, pairs: list[str]) -> tuple[list[Instance], list[str]]:
    """The case at every combination of the values that `pairs` (`name=values`) give, the last
    parameter fastest, and the names of these parameters.

    Values are separated by commas, and by semicolons where one value has commas itself; a range is
    `first:last:step`. Raises UsageError for anything else, and for a setting that the case refuses.
    """
    name, fixed = labelled(label)
    case = discovery.case(name)
    if isinstance(case, Selection):
        raise UsageError(
            f"{name} is a selection of cases, which set their own parameters; expected one case, as"
            " in `refdem sweep pendulum --set theta0=0.5,1,2`"
        )
    texts = settings(pairs)
    if not texts:
        raise UsageError(
            "no parameter varies: --set is missing; expected a parameter with its values, as in"
            f" `refdem sweep {name} --set NAME={EXAMPLES.partition(' ')[0]}`"
        )
    twice = [parameter for parameter in texts if parameter in fixed]
    if twice:
        raise UsageError(
            f"{twice[0]} is in {one_line(label)!r} and in --set; expected it in one of them"
        )
    values = _values(case, texts)
    count = math.prod(len(listed) for listed in values.values())
    _refuse_many(count, "--set gives {} settings")
    found: dict[str, Instance] = {}
    for combination in itertools.product(*values.values()):
        given = dict(zip(values, combination, strict=True))
        try:
            instance = case.at(**(fixed | given))
        except UsageError as error:
            place = " ".join(f"{key}={value}" for key, value in given.items())
            raise UsageError(f"setting {one_line(place)}: {error}") from error
        # The same setting may be written in two ways, such as 1 and 1.0.
        found.setdefault(instance.label, instance)
    return list(found.values()), list(values)


def _values(case: Canonical, texts: Mapping[str, str]) -> dict[str, list[str]]:
    """The values of each parameter as text, in the order in which they are to vary."""
    declared = {parameter.name: parameter for parameter in (*case.parameters, *case.clock)}
    values = {}
    for name, text in texts.items():
        if name not in declared:
            raise UsageError(f"no parameter {one_line(name)!r}; {nearest(name, declared)}")
        values[name] = values_of(declared[name], text)
    return values


def values_of(parameter: Parameter, text: str) -> list[str]:
    """The values that a text lists for a parameter, each as text; raises UsageError.

    An array has commas inside, so that only semicolons separate its values.
    """
    listed = []
    for group in text.split(";"):
        if parameter.shape:
            listed.append(group)
        else:
            listed += group.split(",")
    values = []
    for part in listed:
        if ":" in part:
            values += _range(parameter, part.strip())
        else:
            values.append(part.strip())
    for value in values:
        if not value:
            raise UsageError(
                f"parameter {parameter.name}: {one_line(text)!r} has an empty value; expected"
                f" values such as {EXAMPLES}"
            )
        parameter.parsed(value)
    return values


def _range(parameter: Parameter, text: str) -> list[str]:
    """The numbers of `first:last:step`, exact; `last` is included if a step ends there."""
    parts = text.split(":")
    if len(parts) != 3 or parameter.shape or parameter.choices:
        raise UsageError(
            f"parameter {parameter.name}: got {one_line(text)!r}; expected values such as"
            f" {_example(parameter)}"
        )
    first, last, step = (_exact(part, parameter.name) for part in parts)
    if step == 0 or (last - first) * step < 0:
        raise UsageError(
            f"parameter {parameter.name}: the step of {one_line(text)!r} does not lead from the"
            " first value to the last; expected a step with the sign of last - first, and not 0"
        )
    count = (last - first) // step + 1
    _refuse_many(count, f"parameter {parameter.name}: its range has {{}} values")
    return [str(first + number * step) for number in range(count)]


def _example(parameter: Parameter) -> str:
    """Examples of values of the parameter, as a user may write them."""
    if parameter.choices:
        return ",".join(parameter.choices)
    if parameter.shape:
        return f"{parameter.default or '1,2,3'}, with ; between two of them"
    return EXAMPLES


def _exact(text: str, name: str) -> Fraction:
    """A number of a range, without the bounds of the parameter, which do not apply to the step."""
    number = Parameter(name=name, default="0", unit="1", doc="").parsed(text.strip())
    assert isinstance(number, Fraction)
    return number


def _refuse_many(count: int, words: str) -> None:
    """Raises UsageError for more than MOST of what the words say, as `--set gives {} settings`."""
    if count > MOST:
        statement = words.format(one_line(str(count), 40))
        raise UsageError(
            f"{statement}; expected at most {MOST}: take larger steps, or several sweeps"
        )
