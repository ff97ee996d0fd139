"""Random settings of every case: a few parameters drawn near their defaults, a short duration, and
times soon after the start.
"""

import os
import random
from collections.abc import Callable, Mapping
from fractions import Fraction
from typing import TypeVar

from refdem.cases.impact_benchmarks import MEMBERS, member
from refdem.core import discovery
from refdem.core.case import Instance
from refdem.core.parameters import Parameter
from refdem.core.selection import Selection
from refdem.errors import RefdemError

T = TypeVar("T")
SETTINGS = int(os.environ.get("REFDEM_RANDOM_SETTINGS", "1"))
SEED = os.environ.get("REFDEM_RANDOM_SEED", "12")
TRIES = 40
"""Draws for one setting: some are refused, for parameters that do not go together."""
SHORT = Fraction(1, 16)
"""Part of its default duration that a motion gets: validated integration costs as much as the time
it covers.
"""
EARLY = (Fraction(1, 16), Fraction(1, 4))
"""Parts of that."""
ITERATES = (Fraction(1), Fraction(7))
LEFT_ALONE = ("duration", "samples", "points", "n", "spheres", "member")
NAMES = [
    name for name in discovery.names("cases") if not isinstance(discovery.case(name), Selection)
]


def near(rng: random.Random, parameter: Parameter, value: Fraction) -> Fraction:
    """A number within a factor of 3 of a default, or of 1/4 where that is 0; inside the bounds."""
    found = (value or Fraction(1, 4)) * Fraction(rng.randint(300, 3000), 1000)
    low: float | None = parameter.at_least
    if parameter.above is not None:
        low = parameter.above
    if low is None and rng.random() < 0.3:
        found = -found
    if low is not None and found <= Fraction(repr(low)):
        found = abs(found)
    if parameter.at_most is None:
        high = None
    else:
        high = Fraction(repr(parameter.at_most))
    if high is None or found <= high:
        return found
    return high * Fraction(rng.randint(100, 999), 1000)


def drawn(rng: random.Random, parameter: Parameter, default: str) -> str:
    """Another value of a parameter, as text."""
    if parameter.choices:
        return rng.choice(parameter.choices)
    own = Parameter(
        name=parameter.name, default=default, unit="", doc="", shape=parameter.shape
    ).parsed(default)
    if isinstance(own, tuple):
        values = own
    elif isinstance(own, Fraction):
        values = (own,)
    else:
        # What is left out by default is drawn as what is 0 by default.
        values = (Fraction(0),)
    if parameter.whole:
        return default
    return ",".join(str(near(rng, parameter, value)) for value in values)


def defaults_of(case: str, given: Mapping[str, str]) -> dict[str, str]:
    """The defaults of a case, as text; of impact benchmarks, those of the member that is given."""
    if case == "impact-benchmarks":
        return dict(member(given["member"]).numbers)
    return {p.name: p.default for p in discovery.case(case).parameters if p.default}


def written(case: str, given: Mapping[str, str]) -> dict[str, str]:
    """Every parameter that has a value, as text."""
    return {**defaults_of(case, given), **given}


def settings(rng: random.Random, case: str) -> dict[str, str]:
    """A few parameters of a case, drawn anew."""
    declared = {p.name: p for p in discovery.case(case).parameters}
    given = {}
    if case == "impact-benchmarks":
        given["member"] = rng.choice(MEMBERS)
    defaults = {
        name: text for name, text in defaults_of(case, given).items() if name not in LEFT_ALONE
    }
    chosen = rng.sample(sorted(defaults), min(len(defaults), rng.randint(1, 4)))
    return given | {name: drawn(rng, declared[name], defaults[name]) for name in chosen}


def shortened(case: str, given: dict[str, str]) -> Instance:
    """The case at a setting, with a short duration where it has one."""
    instance = discovery.case(case).at(**given)
    if "duration" not in instance.p:
        return instance
    return discovery.case(case).at(
        **{**given, "duration": str(Fraction(instance.scales.duration) * SHORT)}
    )


def early(instance: Instance) -> tuple[Fraction, ...]:
    """Two exact times soon after the start."""
    if instance.case.id in ("logistic", "lorenz", "billiards"):
        return ITERATES
    if "duration" not in instance.p:
        return ()
    duration = Fraction(instance.scales.duration)
    return tuple(duration * part for part in EARLY)


def first_accepted(case: str, number: int, made: Callable[[random.Random], T]) -> T:
    """What is made of the first setting of a case's sequence that is not refused."""
    rng = random.Random(f"{SEED} {case} {number}")
    for _ in range(TRIES):
        try:
            return made(rng)
        except RefdemError:
            continue
    raise AssertionError(f"{case}: no setting of {TRIES} was accepted")
