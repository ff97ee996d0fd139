"""The same scene in another frame (far away, fast, rotated, later, in other units), compared with
itself in its own frame.
"""

import sys
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from fractions import Fraction

import numpy as np
from numpy.typing import NDArray

from refdem.checks.symmetry import allowed, growth_of, level_for
from refdem.core import refinement, symmetry
from refdem.core.case import Canonical, Instance
from refdem.core.check import Check, CompletedRun, Subject
from refdem.core.engine import Engine, Method
from refdem.core.finding import Finding
from refdem.core.judgement import distances, perturbation, undecided, worst
from refdem.core.problem import Motion, Request
from refdem.core.refinement import scored
from refdem.core.symmetry import Symmetry
from refdem.core.trajectory import Trajectory
from refdem.core.variant import Change, Variant
from refdem.planning import plan
from refdem.planning.plan import Task
from refdem.stress.measures.measure import LEVELS, MOST_STEPS, Measure

Array = NDArray[np.float64]
Show = Callable[[Instance, float], Symmetry]
"""The transformation of a point x, for an instance of a case."""
TINY = 2.0**-1074
"""The smallest positive number in binary64; numbers below 2^-1022 are rounded to multiples of
it.
"""


def _trajectory(runs: Mapping[Variant, CompletedRun], variant: Variant) -> Trajectory | None:
    """The trajectory of a variant; None if it was not run."""
    if variant not in runs:
        return None
    return runs[variant].trajectory


@dataclass(frozen=True)
class Frame(Measure):
    """Another frame: `show` returns the transformation of a point x, `change` names the symmetry it
    belongs to.

    With `is_distinguishable` the transformation differs from the identity by the relative amount
    x, and the runs must distinguish a tenth of that difference.
    """

    change: Change
    show: Show
    is_distinguishable: bool = False

    def instance(self, case: Canonical, parameters: Mapping[str, str], x: Fraction) -> Instance:
        """The case with its own parameters, whatever the point."""
        return case.at(**parameters)

    def levels(self, instance: Instance, method: Method, x: Fraction) -> tuple[float, ...]:
        """A short refinement; the check chooses a level from it."""
        return refinement.levels(instance, method, LEVELS, MOST_STEPS)

    def unsupported(
        self, engine: Engine, method: Method, instance: Instance, x: Fraction
    ) -> str | None:
        """None if the scene has the symmetry and the method supports it in both frames, else the
        reason.
        """
        if not isinstance(instance.problem, Motion):
            return f"{instance.problem.words} does not have a frame of reference"
        broken = symmetry.broken(instance.scene, self.change)
        frame = self.show(instance, float(x))
        return (
            broken
            or engine.unsupported(instance.problem, method)
            or engine.unsupported(frame.applied(instance.motion), method)
        )

    def request(self, task: Task, variant: Variant, x: Fraction) -> Request:
        """The scene in the frame, with the step in the frame's unit of time."""
        if variant.change != self.change:
            return plan.request(task, variant)
        plain = plan.request(task, variant.base)
        frame = self.show(task.subject.instance, float(x))
        step = plain.step
        if step is not None:
            step = step * frame.units[2]
        problem = frame.applied(task.subject.instance.motion)
        return Request(problem=problem, method=plain.method, step=step, tolerance=plain.tolerance)

    def checks(self, subject: Subject, x: Fraction) -> tuple[Check, ...]:
        """The check that the motion is the same."""
        part = None
        if self.is_distinguishable:
            part = float(x)
        return (SameMotion(self.change, self.show(subject.instance, float(x)), part),)


class SameMotion(Check):
    """The motion in the frame, transformed back, agrees with the plain motion to round-off of the
    frame's numbers.

    `change` names the symmetry and `view` is its transformation. With `part`, the relative amount
    by which the transformation differs from the identity, a tenth of it is the bound.
    """

    name = "frame"
    title = "Frame"
    kills = (
        "precision lost far from the origin, an absolute threshold, a force that"
        " depends on the origin, internal single precision"
    )

    def __init__(self, change: Change, view: Symmetry, part: float | None) -> None:
        self.change = change
        self.view = view
        self.part = part

    def applies(self, subject: Subject) -> str | None:
        """Always: the measure has refused scenes without such a frame."""
        return None

    def needs(self, subject: Subject) -> tuple[Variant, ...]:
        """One level plain, with its start perturbed, and in the frame."""
        level = level_for(subject)
        return (
            Variant(level),
            Variant(level, "perturbed", perturbation(subject.method)),
            Variant(level, self.change),
        )

    def judge(self, subject: Subject, runs: Mapping[Variant, CompletedRun]) -> list[Finding]:
        """One finding: the largest difference of any state, in units of each scale."""
        plain, perturbed, transformed = (
            _trajectory(runs, variant) for variant in self.needs(subject)
        )
        if plain is None or transformed is None:
            return [
                undecided(self.name, self.change, "the engine refused the scene during the run")
            ]
        growth = growth_of(subject, level_for(subject), perturbed or plain, plain)
        bounds = self._bounds(subject, growth)
        count = len(bounds)
        if count < 2:
            why = "round-off alone may be as large as the difference to be resolved"
            return [undecided(self.name, self.change, why)]
        with np.errstate(all="ignore"):
            difference = distances(subject.instance, self.view.undone(transformed), plain)
        return [
            worst(
                check=self.name,
                quantity=self.change,
                t=subject.instance.times[:count],
                values=difference[:count],
                allowed=bounds,
                unit="1",
                basis=self._basis(),
                what=(
                    "The difference between the motion and its counterpart in this frame,"
                    " relative to each scale,"
                ),
            )
        ]

    def _bounds(self, subject: Subject, growth: Array) -> Array:
        """The bound of every sample that can be judged (at most T), relative to the scales.

        It is round-off amplified by the motion, as far as that stays small. Where the
        transformation differs from the identity by a part, it is a tenth of that part, at every
        sample or at none: round-off must stay below it to the end.
        """
        round_off = allowed(subject, self.view, growth) * self._denormal(subject)
        if self.part is None:
            return round_off[: scored(round_off)]
        bound = self.part / 10
        is_resolved = round_off[-1] <= bound
        if is_resolved:
            return np.full(len(round_off), bound)
        return np.array([])

    def _basis(self) -> str:
        """The basis of the bound in words."""
        if self.part is not None:
            return (
                "starts that differ by x lead to motions that differ by x, and a tenth of"
                " that must be resolved"
            )
        return (
            "the laws of mechanics are invariant, so only round-off of numbers of"
            " that size, amplified by the motion, may differ"
        )

    def _denormal(self, subject: Subject) -> float:
        """Factor from u to the relative rounding of numbers of the frame's size: 1, except near the
        denormal range.
        """
        scales = subject.instance.scales
        _, length, time = self.view.units
        smallest = min(scales.length * length, scales.speed * length / time)
        if smallest <= TINY:
            return sys.float_info.max
        return max(1.0, TINY / smallest * 2.0**53)
