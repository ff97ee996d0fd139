"""Determinism: the same request twice gives the same bits, and asking for more output changes
nothing.
"""

from collections.abc import Mapping

import numpy as np

from refdem.core.check import Check, Outcome, Trial
from refdem.core.finding import Finding
from refdem.core.judgement import judged
from refdem.core.problem import Motion, Problem
from refdem.core.trajectory import Trajectory
from refdem.core.variant import Variant

DENSER = 4


class Determinism(Check):
    """Bit-equal on one machine."""

    name = "determinism"
    title = "Determinism"
    judges = (Problem,)
    kills = (
        "state left over from an earlier run, uninitialised memory, output that changes the"
        " trajectory"
    )

    def applies(self, trial: Trial) -> str | None:
        """Methods that claim it."""
        if trial.method.deterministic:
            return None
        return "the method does not claim it"

    def needs(self, trial: Trial) -> tuple[Variant, ...]:
        """The coarsest level that is not coarser than the denser output, again, and with denser
        output.
        """
        level = self._level(trial)
        asked = (Variant(level), Variant(level, "repeated"))
        if not isinstance(trial.instance.problem, Motion):
            return asked
        return (*asked, Variant(level, "denser_output", DENSER))

    def _level(self, trial: Trial) -> float:
        interval = trial.instance.problem.interval
        fitting = [
            level
            for level in trial.levels
            if trial.method.control != "step" or level <= interval / DENSER
        ]
        if fitting:
            return fitting[0]
        return trial.levels[-1]

    def judge(self, trial: Trial, runs: Mapping[Variant, Outcome]) -> list[Finding]:
        """The largest difference of any number, twice."""
        base, again, *denser = (runs[variant].trajectory for variant in self.needs(trial))
        step = trial.method.control == "step"
        found = [
            judged(
                check=self.name,
                quantity="repeated",
                value=_difference(base, again, 1),
                bound=0.0,
                unit="1",
                basis="the same request has the same answer, to the last bit",
                what="The largest difference between two runs of one request",
            )
        ]
        if denser and step and trial.levels[-1] <= trial.instance.problem.interval / DENSER:
            found.append(
                judged(
                    check=self.name,
                    quantity="output-rate",
                    value=_difference(base, denser[0], DENSER),
                    bound=0.0,
                    unit="1",
                    basis="output is read, never written: the bits stay the same",
                    what=f"The largest difference when {DENSER} times the samples are asked for",
                )
            )
        return found


def _difference(a: Trajectory, b: Trajectory, stride: int) -> float:
    """Largest absolute difference of any state at the same sample."""
    others = b.columns()
    return max(
        float(np.max(np.abs(values - others[name][::stride]), initial=0.0))
        for name, values in a.columns().items()
    )


CHECK = Determinism()
