"""A check: decides itself where it applies, names the runs it needs, and judges them."""

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from refdem.core import refinement
from refdem.core.case import Instance
from refdem.core.engine import UNEQUAL_MOMENTS, Method
from refdem.core.finding import Finding
from refdem.core.once import once_for_latest
from refdem.core.parameters import Parameters
from refdem.core.problem import Motion, Problem
from refdem.core.scene_numbers import CaseNumber
from refdem.core.trajectory import Cost, Trajectory
from refdem.core.truth import SampledTruth
from refdem.core.variant import Variant
from refdem.scene import Scene

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Subject:
    """One method on one instance, with all that a check needs to judge it.

    `levels` are the refinement levels, coarse to fine: steps [s], or tolerances. `truth` is None
    if nothing is certified; `truth_reason` is then the reason. `unsupported(motion)` is the reason
    why the method cannot run that motion, or None. `derivatives(subject, times)` are the certified
    derivatives of the quantities at times [s]; it raises NotCertifiedError if there are none.
    """

    instance: Instance
    method: Method
    levels: tuple[float, ...]
    truth: SampledTruth | None
    truth_reason: str = ""
    unsupported: Callable[[Motion], str | None] = lambda motion: None
    derivatives: "Callable[[Subject, tuple[float, ...]], CertifiedMatrix] | None" = None

    @property
    def finest(self) -> Variant:
        """The plain run of the finest level."""
        return Variant(self.levels[-1])

    @property
    def order(self) -> float:
        """The order to which the method is held in this scene (`refinement.order`)."""
        return refinement.order(self.instance, self.method)

    @once_for_latest
    def round_off(self, level: float) -> float:
        """Relative round-off that a run at this level may show."""
        return refinement.round_off(
            self.instance, self.method, refinement.steps_at(self.instance, self.method, level)
        )

    @once_for_latest
    def noise(self, level: float) -> float:
        """Relative error of positions and velocities that does not decrease with the step.

        It is round-off plus the systematic rounding of repeated sums of equal terms, in the clock
        and in steady motion.
        """
        clock = refinement.clock(self.instance, self.method, level)
        flight = refinement.flight(self.instance, self.method, level)
        return self.round_off(level) + (clock + flight)

    @once_for_latest
    def resolution(self, level: float) -> float:
        """The larger of `noise` and the rounding of positions far from the origin.

        It is for quantities in units of the scale of the motion. Where the bound takes the size of
        the positions into account itself, as for the image of a shifted scene, `noise` is used.
        """
        return refinement.resolution(self.instance, self.method, level)

    def floor(self, level: float) -> float:
        """Relative error below which a difference is not significant: max(COUNTING_FLOOR noise,
        resolution).

        The rounding of positions far from the origin has no factor, since it already is a bound on
        the sum of all roundings of a position.
        """
        return max(refinement.COUNTING_FLOOR * self.noise(level), self.resolution(level))

    @once_for_latest
    def truncation(self, level: float) -> Array:
        """Relative truncation error (T,) allowed at this level."""
        return refinement.truncation(self.instance, self.method, level, self.instance.times)

    @property
    def constant(self) -> float:
        """The error constant C that a step is allowed here (`refinement.error_constant`)."""
        return refinement.error_constant(self.instance, self.method)

    def unresolved(self, level: float) -> str | None:
        """The reason why, due to friction that alternates in sign from step to step, this step does
        not resolve the motion, or None.
        """
        if self.method.control != "step" or self.constant == self.method.constant:
            return None
        at_start = float(self.truncation(level)[0])
        if at_start < refinement.UNRESOLVED:
            return None
        return (
            f"friction that alternates may put a step of {level:.3g} s off by {at_start:.2g} of the"
            " scale of the motion within its shortest time"
        )

    @once_for_latest
    def bound(self, level: float) -> Array:
        """Relative error (until,) allowed at every certified sample."""
        if self.truth is None:
            raise ValueError("a bound on the state needs truth")
        return refinement.bound(self.instance, self.method, level, self.truth)

    def keeps(self, law: str) -> bool:
        """True if the method claims that a conservation law holds to round-off in this scene."""
        features = self.instance.problem.features
        if isinstance(self.instance.problem, Motion) and _may_tumble(self.instance.scene):
            features |= {UNEQUAL_MOMENTS}
        return self.method.keeps(law, features)

    def kept(self, claim: str, level: float) -> tuple[Array, str]:
        """Bound (T,) on the relative change of a conserved quantity, and the basis of that bound.

        It is round-off where the method claims `claim` (energy, momentum, angular-momentum) to be
        conserved in this scene, else round-off plus the truncation error of the claimed order.
        """
        rounding = np.full(len(self.instance.times), self.round_off(level))
        if self.keeps(claim):
            return rounding, "the method claims to conserve it to round-off, c u sqrt(n)"
        return rounding + self.truncation(level), "truncation error of the claimed order"

    @property
    def plain(self) -> tuple[Variant, ...]:
        """The plain run of every level."""
        return tuple(Variant(level) for level in self.levels)


def _may_tumble(scene: Scene) -> bool:
    """True if a free body with unequal moments of inertia spins, or an element may turn it."""
    if "rotation" not in scene.features:
        return False
    moments = scene.bodies.inertia[~scene.bodies.fixed]
    return bool(np.any(moments != moments[:, :1]))


@dataclass(frozen=True, eq=False)
class CertifiedMatrix:
    """Certified derivatives of the quantities of a case by its numbers: (value, radius) in
    `of[time][quantity][number]`.

    `numbers` are all numbers of the case, and `p` the parameters from which they are read. There is
    no derivative by a number that is missing from `of`.
    """

    p: Parameters
    numbers: tuple[CaseNumber, ...]
    of: tuple[Mapping[str, Mapping[str, tuple[float, float]]], ...]


@dataclass(frozen=True, eq=False)
class CompletedRun:
    """A run that produced a trajectory, as a check sees it."""

    trajectory: Trajectory
    cost: Cost


class Check(ABC):
    """One property of a run that is verified.

    Adding one is one file in checks/ with an instance of a subclass named CHECK.
    """

    name: ClassVar[str]
    title: ClassVar[str]
    kills: ClassVar[str]  # the fault that it catches, in a few words
    synchronous: ClassVar[bool] = (
        False  # it reads positions and velocities together, so they must be of one time
    )
    judges: ClassVar[tuple[type[Problem], ...]] = (Motion,)  # kinds of questions that it applies to

    @abstractmethod
    def applies(self, subject: Subject) -> str | None:
        """None if it applies, else the reason why not."""

    def left_out(self, subject: Subject) -> str | None:
        """None if it judges this kind of question and applies, else the reason why not."""
        problem = subject.instance.problem
        if isinstance(problem, self.judges):
            return self.applies(subject)
        return f"the check does not judge {problem.words}"

    @abstractmethod
    def needs(self, subject: Subject) -> tuple[Variant, ...]:
        """The runs that `judge` will read."""

    def further(
        self, subject: Subject, runs: Mapping[Variant, CompletedRun]
    ) -> tuple[Variant, ...]:
        """The runs that `judge` will read in addition, given the results so far; none if these
        decide.

        `runs` has those of `needs` and those that earlier calls returned. The method is called
        again until it returns no new ones.
        """
        return ()

    @abstractmethod
    def judge(self, subject: Subject, runs: Mapping[Variant, CompletedRun]) -> list[Finding]:
        """The findings; none if the runs do not contain the data that the check judges."""
