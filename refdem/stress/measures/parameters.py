"""The same case at more extreme parameters, judged by the checks of a run against truth and
conservation laws.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from fractions import Fraction
from types import MappingProxyType

from refdem.core.case import Canonical, Instance
from refdem.core.check import Check, Subject
from refdem.stress.measures.measure import Measure, plain_checks, with_samples
from refdem.stress.sweep import Sweep

SAMPLES = 16
"""Sample intervals of a point: enough to see a drift, few to store."""


@dataclass(frozen=True)
class Parameters(Measure):
    """`given` returns the parameters of a point, each as text; `samples` is the number of sample
    intervals.

    Without truth only conservation laws judge.
    """

    given: Callable[[Fraction], Mapping[str, str]]
    samples: int = SAMPLES
    needs_truth: bool = True

    def instance(self, case: Canonical, parameters: Mapping[str, str], x: Fraction) -> Instance:
        """The case at the point's parameters, which given ones override."""
        return case.at(**with_samples({**self.given(x), **parameters}, self.samples))

    def checks(self, subject: Subject, x: Fraction) -> tuple[Check, ...]:
        """The checks of `refdem run` that need one run only."""
        return plain_checks(subject)


def parameter_sweep(
    name: str,
    along: str,
    points: tuple[str, ...],
    given: Callable[[Fraction], Mapping[str, str]],
    promised: str = "",
    *,
    case: str | Canonical,
    basis: str = "",
    samples: int = SAMPLES,
    needs_truth: bool = True,
    exempt: Mapping[str, tuple[str, str]] = MappingProxyType({}),
    costly: bool = False,
) -> Sweep:
    """A sweep whose points are parameters of one case.

    `given` and `samples` are those of `Parameters`, all other arguments those of `Sweep`. A
    battery fixes by `functools.partial` what its sweeps have in common.
    """
    return Sweep(
        name=name,
        case=case,
        along=along,
        points=points,
        measure=Parameters(given, samples=samples, needs_truth=needs_truth),
        promised=promised,
        basis=basis,
        exempt=exempt,
        costly=costly,
    )
