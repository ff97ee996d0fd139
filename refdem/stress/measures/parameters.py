"""The same case at harder parameters, judged by all checks of a run against truth and
invariants.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from fractions import Fraction

from refdem.core.case import Canonical, Instance
from refdem.core.check import Check, Subject
from refdem.stress.measures.measure import Measure, plain_checks, with_samples

SAMPLES = 16


@dataclass(frozen=True)
class Parameters(Measure):
    """`given` has the parameters of the rung, each as text.

    `samples` intervals are seen; invariants alone judge without truth.
    """

    given: Callable[[Fraction], Mapping[str, str]]
    samples: int = SAMPLES
    needs_truth: bool = True

    def instance(self, case: Canonical, given: Mapping[str, str], x: Fraction) -> Instance:
        """The case at the parameters of the rung, and at those that came."""
        return case.at(**with_samples({**self.given(x), **given}, self.samples))

    def checks(self, subject: Subject, x: Fraction) -> tuple[Check, ...]:
        """The checks of `refdem run` that need one run only."""
        return plain_checks(subject)
