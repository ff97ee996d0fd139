"""Time reversal: on from the end with velocities flipped, or with negative steps, back to the
start.
"""

import math
from collections.abc import Mapping

import numpy as np

from refdem.core.check import Check, CompletedRun, Subject
from refdem.core.finding import Finding
from refdem.core.judgement import (
    ROOM,
    certified,
    judged,
    largest_so_far,
    no_truth,
    order_statement,
    room_of,
    undecided,
)
from refdem.core.refinement import COUNTING_FLOOR, HORIZON, clock, flight, kinked
from refdem.core.trajectory import Trajectory
from refdem.core.variant import Change, Variant
from refdem.mechanics.quaternion import angle_between

FURTHER = 4
"""Halvings of the finest step for the way back: growth counts both ways, so that a motion may be
predictable there but not back.
"""


class Reversal(Check):
    """A reversible method returns to round-off; any other to its truncation error."""

    name = "reversal"
    title = "Time reversal"
    kills = "a force taken at the wrong time level, hidden dissipation, hidden state"
    synchronous = True

    def applies(self, subject: Subject) -> str | None:
        """Scenes without a direction of time and methods whose end state is complete."""
        if not subject.instance.scene.is_reversible():
            return "the system gains or loses energy, so its motion is not reversible"
        if "contact:rigid" in subject.instance.scene.features:
            return "rigid contact forces at rest are not part of the state"
        if subject.method.complete_state:
            return None
        return "the final state of the method is incomplete, so a run cannot be continued from it"

    def needs(self, subject: Subject) -> tuple[Variant, ...]:
        """A level, reversed, and backward where the method can; the two finest of the subject where
        the defect has an order.
        """
        if subject.method.backward:
            changes: tuple[Change, ...] = ("reversed", "backward")
        else:
            changes = ("reversed",)
        level = _level(subject)
        if _has_order(subject):
            pair = subject.levels[-2:]
        else:
            pair = ()
        told = Variant(_telling(subject, level))
        shown = (
            Variant(level),
            told,
            *(Variant(level, change) for change in changes),
            *(Variant(h, "reversed") for h in pair),
        )
        return tuple(dict.fromkeys(shown))

    def judge(self, subject: Subject, runs: Mapping[Variant, CompletedRun]) -> list[Finding]:
        """The distance from the start, in units of each quantity's scale, and how fast it falls
        with the step.
        """
        truth = certified(subject)
        if truth is None:
            return [undecided(self.name, "return", no_truth(subject))]
        level = _level(subject)
        growth = float(truth.growth()[-1])
        size = _size(subject, level)
        basis = (
            "truncation error of the forward and backward runs, the first amplified on the way back"
        )
        if _is_exact(subject):
            basis = (
                "a reversible method returns to round-off, c u sqrt(n) forward and"
                " backward, times the sensitivity S of both"
            )
        if _has_order(subject) and len(subject.levels) > 1:
            order = self._order(subject, runs, growth)
        else:
            order = []
        if size > HORIZON:
            return order or [
                undecided(
                    self.name,
                    "return",
                    (
                        "the bound on the return error exceeds a tenth of the scale: the run is"
                        " longer than the predictability horizon"
                    ),
                )
            ]
        fallen = _fallen(subject, runs, level, growth)
        shown = _shown(subject, runs, level)
        if shown < size:
            size = shown
            basis = "the backward run may add as much error as the forward run is seen to have"
        if size > fallen:
            basis = "truncation error extrapolated from a larger step with the claimed order"
        return order + [
            judged(
                check=self.name,
                quantity=variant.change,
                value=_defect(subject, runs[variant].trajectory, variant.change),
                bound=min(size, fallen),
                unit="1",
                basis=basis,
                what=(
                    "The distance from the initial state after running forward and backward"
                    f" ({variant.change}), relative to each scale,"
                ),
            )
            for variant in self.needs(subject)
            if variant.level == level and variant.goes_on
        ]

    def _order(
        self, subject: Subject, runs: Mapping[Variant, CompletedRun], growth: float
    ) -> list[Finding]:
        """The return defect falls with order p if p is odd, p + 1 if it is even: the leading even
        term undoes itself.
        """
        order = subject.order
        if order % 2:
            expected = order
        else:
            expected = order + 1
        coarse, fine = (
            _defect(subject, runs[Variant(h, "reversed")].trajectory, "reversed")
            for h in subject.levels[-2:]
        )
        scales = subject.instance.scales
        method = subject.method
        following = (
            method.constant
            * scales.duration
            / scales.tau
            * (subject.levels[-1] / scales.tau) ** (expected + 1)
        )
        floor = max(following, COUNTING_FLOOR * subject.noise(subject.levels[-1]) * growth**2)
        if (
            not floor < fine <= coarse < HORIZON
        ):  # below the next term of the error there is no leading one to see
            return []
        seen = math.log2(coarse / fine)
        return [
            judged(
                check=self.name,
                quantity="order",
                value=max(0.0, expected - seen),
                bound=max(0.15, 0.05 * expected),
                unit="1",
                basis=(
                    f"a reversible method of order {order} has a return error of order {expected},"
                    " within max(0.15, 0.05 p)"
                ),
                statement=order_statement(
                    seen,
                    expected,
                    max(0.0, expected - seen),
                    max(0.15, 0.05 * expected),
                    "return error at the finest pair of steps",
                ),
            )
        ]


def _fallen(
    subject: Subject, runs: Mapping[Variant, CompletedRun], level: float, growth: float
) -> float:
    """What the claimed order leaves at a level of the defect at a coarser one; infinite where
    nobody knows.
    """
    if not _has_order(subject) or len(subject.levels) < 3:
        return math.inf
    coarse = _defect(subject, runs[Variant(subject.levels[-2], "reversed")].trajectory, "reversed")
    order = subject.order
    octaves = math.log2(subject.levels[-2] / level)
    of_order: float = ROOM * coarse / 2.0 ** (order * octaves)
    return of_order + COUNTING_FLOOR * subject.noise(level) * growth


def _is_exact(subject: Subject) -> bool:
    """The way back undoes the way there, to round-off."""
    return subject.method.reversible or subject.method.control == "exact"


def _size(subject: Subject, level: float) -> float:
    """What the defect of the way back may be at a level, as the claims say; needs truth.

    With the flow's Jacobian D, what is wrong by e after a time s is wrong by D(T) D(s)^-1 e at the
    end, and the way back takes that to D(s)^-1 e: to first order it undoes the growth on the way
    there, and S counts once.
    """
    reached = _reached(subject, level)
    return _there_and_back(subject, reached * _unbent(subject), reached)


def _unbent(subject: Subject) -> float:
    """How many times S the growth on the way back may be, or S times at most.

    D^-1 of a reversible scene is D transposed and put in another order (D is symplectic), so that
    in the maximum norm it is at most S times the number of columns.
    """
    assert subject.truth is not None
    bodies = subject.instance.scene.bodies
    columns = 2 * bodies.position.size
    if "rotation" in subject.instance.scene.features:
        columns *= 2
    return min(float(columns), float(subject.truth.growth()[-1]))


def _there_and_back(subject: Subject, each: float, reached: float) -> float:
    """The defect where each way adds `each`, and what is wrong at the end by `reached` bends the
    way back by its square, grown by S.
    """
    assert subject.truth is not None
    return 2 * (each + reached**2 * float(subject.truth.growth()[-1]))


def _reached(subject: Subject, level: float) -> float:
    """What the way there may be off by, as its claims say: an error made early, times S."""
    assert subject.truth is not None
    if not _is_exact(subject):
        return float(subject.bound(level)[-1])
    summed = clock(subject.instance, subject.method, level) + flight(
        subject.instance, subject.method, level
    )
    return (math.sqrt(2.0) * subject.round_off(level) + summed) * float(subject.truth.growth()[-1])


def _shown(subject: Subject, runs: Mapping[Variant, CompletedRun], level: float) -> float:
    """What the defect may be, as the error of the way there shows it against truth; infinite where
    nobody knows.

    The way back goes by the same places, and D and D^-1 have the same singular values: errors of no
    particular kind grow as much there as on the way there, within a factor of the columns. Those of
    equal steps may be of a kind that does not grow on the way there, but does on the way back:
    symplectic Euler's is that of another start (Hairer, Lubich and Wanner 2006, chapter IX), and
    the way back starts elsewhere. They are given all of S. Round-off adds to it: an error may be
    small by chance, as where no number has to be rounded.
    """
    truth = certified(subject)
    assert truth is not None
    telling = _telling(subject, level)
    if truth.until < len(subject.instance.times) or (
        subject.method.control == "tolerance" and telling == level
    ):
        return math.inf
    if subject.method.control == "tolerance":
        room = ROOM
    else:
        room = room_of(subject)
    own = room * float(
        largest_so_far(subject, telling, runs[Variant(telling)].trajectory, truth)[-1]
    )
    reached = own + COUNTING_FLOOR * subject.noise(level)
    if subject.method.control == "step":
        grown = float(truth.growth()[-1])
    else:
        grown = _unbent(subject)
    return _there_and_back(subject, reached * grown, reached)


def _telling(subject: Subject, level: float) -> float:
    """The level whose error is taken for that of the way back: of chosen steps a looser one, for
    they may be others on the way back.
    """
    if subject.method.control == "tolerance" and len(subject.levels) > 1:
        return subject.levels[-2]
    return level


def _level(subject: Subject) -> float:
    """The level that is judged: the finest, or the first half of a half of it at which the way back
    is still predictable.
    """
    finest = subject.levels[-1]
    if certified(subject) is None or subject.method.control != "step" or _is_exact(subject):
        return finest
    finer = (finest / 2**k for k in range(FURTHER + 1))
    return next((level for level in finer if _size(subject, level) <= HORIZON), finest)


def _has_order(subject: Subject) -> bool:
    """The defect is a truncation error, and no kink within a step scatters it."""
    return (
        subject.method.control == "step" and not _is_exact(subject) and not kinked(subject.instance)
    )


def _defect(subject: Subject, back: Trajectory, change: Change) -> float:
    """Largest scaled difference between the start and the state that came back."""
    start = subject.instance.scene.bodies
    end = back.end()
    scales = subject.instance.scales
    if change == "reversed":
        sign = -1.0
    else:
        sign = 1.0
    spin = np.max(np.linalg.norm(start.omega, axis=1)) or 1.0 / scales.tau
    # A run that was reversed ends with the velocities of the start, of the other sign.
    position = float(np.max(np.abs(end["position"] - start.position)))
    velocity = float(np.max(np.abs(sign * end["velocity"] - start.velocity)))
    omega = float(np.max(np.abs(sign * end["omega"] - start.omega)))
    angle = 0.0
    if "rotation" in subject.instance.scene.features:
        angle = float(np.max(angle_between(end["attitude"], start.attitude)))
    return max(position / scales.length, velocity / scales.speed, omega / float(spin), angle)


CHECK = Reversal()
