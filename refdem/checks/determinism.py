"""Determinism: the same request twice gives the same bits, and asking for more output changes
nothing.
"""

from collections.abc import Mapping

import numpy as np

from refdem.core.check import Check, CompletedRun, Subject
from refdem.core.finding import Finding
from refdem.core.judgement import judged
from refdem.core.problem import Motion, Problem
from refdem.core.trajectory import Trajectory
from refdem.core.variant import Variant

DENSER = 4
"""Factor of the number of samples in the run with denser output."""


class Determinism(Check):
    """Identical requests give bit-identical results on one machine."""

    name = "determinism"
    title = "Determinism"
    judges = (Problem,)
    kills = (
        "state left over from an earlier run, uninitialised memory, output that"
        " changes the trajectory"
    )

    def applies(self, subject: Subject) -> str | None:
        """None if the method claims to be deterministic, else the reason why not."""
        if subject.method.deterministic:
            return None
        return "the method does not claim to be deterministic"

    def needs(self, subject: Subject) -> tuple[Variant, ...]:
        """The coarsest level whose steps fit the denser output; the same request again; and the
        same with denser output.
        """
        level = self._level(subject)
        variants = (Variant(level), Variant(level, "repeated"))
        if not isinstance(subject.instance.problem, Motion):
            return variants
        return (*variants, Variant(level, "denser_output", DENSER))

    def _level(self, subject: Subject) -> float:
        """The coarsest level with at least DENSER steps a sample, or the finest if none has so
        many.
        """
        interval = subject.instance.problem.interval
        fitting = [
            level
            for level in subject.levels
            if subject.method.control != "step" or level <= interval / DENSER
        ]
        if fitting:
            return fitting[0]
        return subject.levels[-1]

    def judge(self, subject: Subject, runs: Mapping[Variant, CompletedRun]) -> list[Finding]:
        """The largest difference of any number between runs of one request, and between outputs of
        different density.
        """
        base, again, *denser = (runs[variant].trajectory for variant in self.needs(subject))
        is_fixed_step = subject.method.control == "step"
        findings = [
            judged(
                check=self.name,
                quantity="repeated",
                value=_difference(base, again, 1),
                bound=0.0,
                unit="1",
                basis="identical requests must give identical results, bit for bit",
                what="The largest difference between two runs of the same request",
            )
        ]
        if (
            denser
            and is_fixed_step
            and subject.levels[-1] <= subject.instance.problem.interval / DENSER
        ):
            findings.append(
                judged(
                    check=self.name,
                    quantity="output-rate",
                    value=_difference(base, denser[0], DENSER),
                    bound=0.0,
                    unit="1",
                    basis="writing output must not change the trajectory, bit for bit",
                    what=f"The largest difference at {DENSER} times as many samples",
                )
            )
        return findings


def _difference(a: Trajectory, b: Trajectory, stride: int) -> float:
    """Largest absolute difference of any state at the same sample."""
    others = b.columns()
    return max(
        float(np.max(np.abs(values - others[name][::stride]), initial=0.0))
        for name, values in a.columns().items()
    )


CHECK = Determinism()
