"""Every parameter of every case and member at zero and at the ends of its range is refused by name,
or proved, or said not to be certified; never an arithmetic error in a proof.

`refdem truth impact-benchmarks --set member=contact-path --set tangential_stiffness=0` ended in a
ZeroDivisionError.
"""

from collections.abc import Iterator
from fractions import Fraction

import pytest

from refdem.cases.impact_benchmarks import MEMBERS, member
from refdem.core import discovery
from refdem.core.parameters import Parameter
from refdem.core.problem import Motion
from refdem.core.selection import Selection
from refdem.errors import NotCertifiedError, UsageError

NAMES = [
    name for name in discovery.names("cases") if not isinstance(discovery.case(name), Selection)
]
FAR = 10**4
"""An end beyond this size only keeps numbers in binary64; a proof there may take hours."""
EARLY = Fraction(1, 64)
"""Of the duration."""


def ends(parameter: Parameter) -> list[str]:
    """Zero, and the ends of the range that belong to it."""
    found = [Fraction(0)]
    for end in (parameter.at_least, parameter.at_most):
        if end is not None and abs(end) <= FAR:
            found.append(Fraction(str(end)))
    return [str(end) for end in dict.fromkeys(found)]


def texts(parameter: Parameter, default: str) -> list[str]:
    """The ends of a number; of a vector, in all places and in each of them."""
    if parameter.choices or not default:
        return []
    own = default.split(",")
    found = []
    for end in ends(parameter):
        found.append(",".join([end] * len(own)))
        if len(own) > 1:
            places = range(len(own))
            found += [",".join(end if i == j else own[j] for j in places) for i in places]
    return found


def settings(name: str) -> Iterator[dict[str, str]]:
    """One parameter of a case, or of a member, at an end of its range."""
    declared = {p.name: p for p in discovery.case(name).parameters}
    if name == "impact-benchmarks":
        families = [({"member": one}, dict(member(one).numbers)) for one in MEMBERS]
    else:
        members = declared["member"].choices if "member" in declared else ("",)
        defaults = {own: p.default for own, p in declared.items() if own != "member"}
        families = [({"member": one} if one else {}, defaults) for one in members]
    for family, numbers in families:
        for own, default in numbers.items():
            for text in texts(declared[own], default):
                yield {**family, own: text}


def ask(name: str, given: dict[str, str]) -> None:
    """Everything that a truth says at the start and a little later."""
    instance = discovery.case(name).at(**given)
    truth = instance.truth()
    later = Fraction(1)
    if isinstance(instance.problem, Motion):
        later = Fraction(float(instance.scales.duration)) * EARLY
    for asked in (truth.at, truth.sensitivity):
        for t in (Fraction(0), later):
            try:
                asked(t)
            except NotCertifiedError:
                continue
    try:
        truth.scalars()
    except NotCertifiedError:
        return


@pytest.mark.parametrize("name", NAMES)
def test_an_end_of_a_range_is_refused_by_name_or_proved(name):
    for given in settings(name):
        refused = None
        try:
            ask(name, given)
        except UsageError as error:
            refused = str(error)
        except ArithmeticError as error:
            pytest.fail(f"{name} {given}: {type(error).__name__}: {error}")
        named = [name, *given]
        assert refused is None or any(one in refused for one in named), (given, refused)
