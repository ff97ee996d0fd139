"""Certified derivatives for checks, and the numbers of a scene by which programs are requested to
differentiate.
"""

from fractions import Fraction
from functools import cache

from refdem.core import discovery
from refdem.core.case import Instance
from refdem.core.check import CertifiedMatrix, Subject
from refdem.core.engine import Method
from refdem.core.scene_numbers import keys_of, known_rates

DIGITS = 17
"""Digits of the certified derivatives, which are compared with doubles."""
Given = tuple[tuple[str, str], ...]
"""The parameters of an instance as pairs of name and text."""


def certified_matrix(subject: Subject, times: tuple[float, ...]) -> CertifiedMatrix:
    """The derivatives of the quantities of a subject at these times [s].

    Raises NotCertifiedError where they cannot be proved.
    """
    instance = subject.instance
    return _proved(instance.case.id, tuple(instance.p.given.items()), times)


@cache
def _proved(case: str, given: Given, times: tuple[float, ...]) -> CertifiedMatrix:
    """The same of a case at given parameters, proved once in a process."""
    # Imports python-flint, which a campaign that is read from the store does not need.
    from refdem.truth.sensitivities import numbers_of, sensitivities_at

    instance = discovery.case(case).at(**dict(given))
    p = instance.case.written_out(instance.p)
    of = []
    exact_times = [Fraction(t) for t in times]
    for found in sensitivities_at(instance.case.truth, p, exact_times, DIGITS):
        rows = {}
        for quantity, by_number in found.of.items():
            rows[quantity] = {name: ball.rounded() for name, ball in by_number.items()}
        of.append(rows)
    return CertifiedMatrix(p, tuple(numbers_of(p)), tuple(of))


def requested_numbers(instance: Instance, method: Method) -> tuple[str, ...]:
    """The keys of the numbers of the scene on which some number of the case acts, as far as the
    method differentiates by them.
    """
    from refdem.truth.sensitivities import numbers_of

    p = instance.case.written_out(instance.p)
    rates = {}
    for number in numbers_of(p):
        known = known_rates(instance, p, number, start_only=method.start_only)
        rates[number.name] = known
    return keys_of(rates, instance.scene)
