"""Determinism: the same request twice gives the same bits, and neither more output nor another
number of threads changes anything.
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
THREADS = 2
"""Threads of the run that is compared with that on one: the fewest that can disturb each other, and
as many as any machine has.
"""


class Determinism(Check):
    """Identical requests give bit-identical results on one machine."""

    name = "determinism"
    title = "Determinism"
    judges = (Problem,)
    kills = (
        "state left over from an earlier run, uninitialised memory, output that"
        " changes the trajectory, sums whose order depends on the number of threads"
    )

    def applies(self, subject: Subject) -> str | None:
        """None if the method claims to be deterministic, else the reason why not."""
        if subject.method.deterministic:
            return None
        return "the method does not claim to be deterministic"

    def needs(self, subject: Subject) -> tuple[Variant, ...]:
        """The coarsest level whose steps fit the denser output; the same request again; the same
        with denser output, where a sample has enough steps for that; and, if the method claims it,
        the same on more threads.
        """
        level = self._level(subject)
        variants = [Variant(level), Variant(level, "repeated")]
        if isinstance(subject.instance.problem, Motion):
            if _has_steps_for_denser_output(subject, level):
                variants.append(Variant(level, "denser_output", DENSER))
            if subject.method.threads:
                variants.append(Variant(level, "threads", THREADS))
        return tuple(variants)

    def _level(self, subject: Subject) -> float:
        """The coarsest level with at least DENSER steps a sample, or the finest if none has so
        many.
        """
        for level in subject.levels:
            if _has_steps_for_denser_output(subject, level):
                return level
        return subject.levels[-1]

    def judge(self, subject: Subject, runs: Mapping[Variant, CompletedRun]) -> list[Finding]:
        """The largest difference of any number between runs of one request, between outputs of
        different density, and between numbers of threads.
        """
        variants: dict[str, Variant] = {}
        for variant in self.needs(subject):
            variants[variant.change] = variant
        base = runs[variants["none"]].trajectory

        def difference(change: str, stride: int) -> float:
            """The largest difference of a variant from the plain run, whose samples are `stride`
            samples of the variant apart.
            """
            return _difference(base, runs[variants[change]].trajectory, stride)

        is_fixed_step = subject.method.control == "step"
        findings = [
            judged(
                check=self.name,
                quantity="repeated",
                value=difference("repeated", 1),
                bound=0.0,
                unit="1",
                basis="identical requests must give identical results, bit for bit",
                what="The largest difference between two runs of the same request",
            )
        ]
        if "denser_output" in variants and is_fixed_step:
            findings.append(
                judged(
                    check=self.name,
                    quantity="output-rate",
                    value=difference("denser_output", DENSER),
                    bound=0.0,
                    unit="1",
                    basis="writing output must not change the trajectory, bit for bit",
                    what=f"The largest difference at {DENSER} times as many samples",
                )
            )
        if "threads" in variants:
            findings.append(
                judged(
                    check=self.name,
                    quantity="threads",
                    value=difference("threads", 1),
                    bound=0.0,
                    unit="1",
                    basis="the method claims the same bits for any number of threads",
                    what=f"The largest difference between one thread and {THREADS}",
                )
            )
        return findings


def _has_steps_for_denser_output(subject: Subject, level: float) -> bool:
    """True if a step ends at each of the DENSER samples that take the place of one.

    Steps are the sample interval or halvings of it; methods without a fixed step end anywhere.
    """
    if subject.method.control != "step":
        return True
    return bool(level <= subject.instance.problem.interval / DENSER)


def _difference(a: Trajectory, b: Trajectory, stride: int) -> float:
    """Largest absolute difference of any state at the same sample.

    Of q and -q, which are the same attitude, the nearer is taken: a code that writes the one with w
    >= 0, or the one nearest to that of its last row, may write either.
    """
    others = b.columns()
    largest = 0.0
    for name, values in a.columns().items():
        beside = others[name][::stride]
        distance = np.abs(values - beside)
        if name == "attitude":
            opposite = np.abs(values + beside)
            is_nearer = opposite.max(axis=-1) < distance.max(axis=-1)
            distance = np.where(is_nearer[..., None], opposite, distance)
        largest = max(largest, float(np.max(distance, initial=0.0)))
    return largest


CHECK = Determinism()
