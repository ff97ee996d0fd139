"""Symmetry: the same scene shifted, rotated, boosted, mirrored, relabelled, in other units, started
later. Needs no truth.
"""

from collections.abc import Mapping

import numpy as np

from refdem.core import symmetry
from refdem.core.check import Array, Check, CompletedRun, Subject
from refdem.core.finding import Finding
from refdem.core.judgement import (
    MORE,
    PERTURBED,
    ROOM,
    certified,
    distances,
    followed,
    growth_shown,
    largest_so_far,
    perturbation,
    room_of,
    undecided,
    worst,
)
from refdem.core.refinement import COUNTING_FLOOR, scored
from refdem.core.trajectory import Trajectory
from refdem.core.variant import Variant

SWITCHES = frozenset({"contact", "friction", "catch", "wedge"})
"""What jumps: in which step it does so hangs on the last bit where it falls on the end of a step.
"""
DRAWS = (-64, 16, -16, 1, -1)
"""Units in the last place, times those of `perturbation`/64, by which the start is moved as well
where a rounding may decide.

What a rounding decides lies within a rounding of a threshold, so of two starts moved to either side
of it by more than a rounding one decides otherwise. The small ones stand for motions that grow so
fast that large ones no longer show it.
"""
REORDERED = frozenset({"rotated", "mirrored", "relabelled", "rescaled"})
"""Pictures in which iterations over contacts begin elsewhere: others are found or come first, or a
tolerance is in other units.
"""


class Symmetry(Check):
    """The motion is the same however the scene is put before the code, to round-off."""

    name = "symmetry"
    title = "Symmetry"
    kills = (
        "confused frames of reference, a hard-wired length or time, bodies"
        " treated unequally, a force that depends on the origin"
    )

    def applies(self, subject: Subject) -> str | None:
        """Scenes with some symmetry that the method can be shown."""
        if self._shown(subject):
            return None
        return "the method can run no symmetry of the scene"

    def _shown(self, subject: Subject) -> list[str]:
        """Symmetries that the scene has and whose picture of it the method does not refuse."""
        scene = subject.instance.scene
        names = [name for name in symmetry.NAMES if symmetry.broken(scene, name) is None]
        return [
            name
            for name in names
            if subject.unsupported(symmetry.picture(subject.instance, name)[1]) is None
        ]

    def needs(self, subject: Subject) -> tuple[Variant, ...]:
        """One level, as it is, in every symmetry, and with the start moved a little: by several
        amounts where a rounding decides.

        Where a truncation error may know the axes of space, the scene turned at a second level too:
        such an error falls.
        """
        level = level_for(subject)
        shown = tuple(Variant(level, name) for name in self._shown(subject))  # type: ignore[arg-type]
        other: tuple[Variant, ...] = ()
        if _has_axes(subject) and Variant(level, "rotated") in shown:
            beside = _beside(subject)
            other = (Variant(beside), Variant(beside, "rotated"))
        if _decides(subject) and subject.method.control == "step":
            other = (*other, *_draws(subject, level), *_coarser(subject))
        elif subject.method.control == "tolerance":
            other = tuple(Variant(looser) for looser in subject.levels[:-1])
        return (
            Variant(level),
            Variant(level, "perturbed", perturbation(subject.method)),
            *shown,
            *other,
        )

    def judge(self, subject: Subject, runs: Mapping[Variant, CompletedRun]) -> list[Finding]:
        """One finding a symmetry: the largest scaled difference of any state."""
        plain, perturbed, *others = self.needs(subject)
        shown = [
            variant
            for variant in others
            if variant.level == plain.level and variant.change in symmetry.NAMES
        ]
        base = runs[plain].trajectory
        growth = growth_of(subject, _least_moved(subject, runs, perturbed), base)
        found = []
        for variant in shown:
            if variant not in runs:  # the code said when it ran that it cannot show this one
                continue
            view = symmetry.of(subject.instance, variant.change)
            decided = _decided_by_rounding(subject, runs, growth, variant.change)
            bounds = round_off(subject, view) * growth + decided
            count = scored(bounds)
            if count < 2:
                found.append(
                    undecided(
                        self.name,
                        variant.change,
                        "round-off may exceed a tenth of the scale before the second sample",
                    )
                )
                continue
            apart = distances(subject.instance, view.undone(runs[variant].trajectory), base)
            if (
                variant.change == "rotated"
                and _has_axes(subject)
                and np.any(apart[:count] > bounds[:count])
            ):
                found.append(self._rotated(subject, runs, growth, decided))
                continue
            found.append(
                worst(
                    check=self.name,
                    quantity=variant.change,
                    t=subject.instance.times[:count],
                    values=apart[:count],
                    allowed=bounds[:count],
                    unit="1",
                    basis=_basis(subject),
                    what=(
                        f"The difference between the motion and its {variant.change} counterpart,"
                        " relative to each scale,"
                    ),
                )
            )
        return found or [
            undecided(
                self.name, "any", "the engine refused every symmetry of the scene during the run"
            )
        ]

    def _rotated(
        self, subject: Subject, runs: Mapping[Variant, CompletedRun], growth: Array, decided: Array
    ) -> Finding:
        """A method may put attitudes in coordinates with axes of their own: then what differs is
        truncation, and falls with the step.

        What a rounding decides need not fall: `decided` (T,) is allowed beside it.
        """
        coarsest = subject.levels[0]
        finest = subject.levels[-1]
        view = symmetry.of(subject.instance, "rotated")
        turned = {
            level: view.undone(runs[Variant(level, "rotated")].trajectory)
            for level in (coarsest, finest)
        }
        coarse = distances(subject.instance, turned[coarsest], runs[Variant(coarsest)].trajectory)
        fine = distances(subject.instance, turned[finest], runs[Variant(finest)].trajectory)
        order = subject.order
        octaves = np.log2(coarsest / finest)
        allowed = (2 * subject.truncation(finest)) * growth
        count = scored(allowed)
        largest = float(np.max(fine))
        falls = float(np.max(coarse)) / 2.0 ** (octaves * (order - 0.5))
        falling = np.maximum(
            falls, 2 * subject.noise(finest) * symmetry.size(subject.instance, view) * growth
        )
        what = (
            "The difference between the motion and its rotated counterpart at the"
            " finest step, relative to each scale"
        )
        bounds = np.minimum(allowed, falling) + decided
        largest_coarse = float(np.max(coarse))
        return worst(
            check=self.name,
            quantity="rotated",
            t=subject.instance.times[:count],
            values=fine[:count],
            allowed=bounds[:count],
            unit="1",
            basis=(
                "the difference exceeds round-off, so it must be truncation error of"
                f" order {order} at both steps and fall with it"
            ),
            what=(
                f"{what} ({largest:.2g}; at {coarsest / finest:.0f} times the step"
                f" {largest_coarse:.2g}),"
            ),
        )


def _has_axes(subject: Subject) -> bool:
    """Attitudes, which a method with steps may put in coordinates whose truncation error knows the
    axes of space.
    """
    turns = "rotation" in subject.instance.scene.features
    return turns and subject.method.control == "step" and len(subject.levels) > 1


def _beside(subject: Subject) -> float:
    """The level to compare with that of `level_for`: the other end of the ladder."""
    is_finest = level_for(subject) == subject.levels[-1]
    if is_finest:
        return subject.levels[0]
    return subject.levels[-1]


def level_for(subject: Subject) -> float:
    """The coarsest, where nothing is hidden by a small step; the finest where truncation has to be
    allowed for.
    """
    if _decides(subject):
        return subject.levels[-1]
    return subject.levels[0]


def growth_of(subject: Subject, perturbed: Trajectory, base: Trajectory) -> Array:
    """How much an early error has grown (T,): S of the truth, or what the moved start shows.

    S is that of the true motion. A run that has left it, as one whose steps are too long for a
    close passage, grows as its own moved start shows from there on.
    """
    truth = certified(subject)
    shown = growth_shown(subject.instance, subject.method, perturbed, base)
    if truth is None or truth.until != len(base.t):
        return shown
    growth = truth.growth()
    left = followed(subject, level_for(subject), base, truth)
    found: Array = np.concatenate([growth[:left], np.maximum(growth, shown)[left:]])
    return found


def round_off(subject: Subject, view: symmetry.Symmetry) -> float:
    """Round-off of both runs with the numbers as large as the symmetry makes them.

    In other units the moments of inertia are rounded anew, which makes another body of a needle.
    """
    level = level_for(subject)
    rounding = 2 * subject.noise(level) * symmetry.size(subject.instance, view)
    if view.units != symmetry.Symmetry().units:
        rounding += subject.method.round_off * symmetry.rounded_rates(subject.instance)
    return rounding


def allowed(subject: Subject, view: symmetry.Symmetry, growth: Array) -> Array:
    """Round-off of both runs (T,), and their truncation where a branch may flip: for pictures of
    which no moved starts are run.
    """
    error = np.full_like(growth, round_off(subject, view))
    if _decides(subject):
        error += 2 * subject.truncation(level_for(subject))
    return error * growth


def _draws(subject: Subject, level: float) -> tuple[Variant, ...]:
    """The start moved by other amounts, to either side of whatever threshold is within a rounding
    of it.
    """
    units = perturbation(subject.method) // PERTURBED
    return tuple(Variant(level, "perturbed", draw * units) for draw in DRAWS)


def _coarser(subject: Subject) -> tuple[Variant, ...]:
    """The plain run at twice the step, which shows the truncation error of iterations that find
    forces between rigid bodies.
    """
    if _iterates(subject) and len(subject.levels) > 1:
        return (Variant(subject.levels[-2]),)
    return ()


def _iterates(subject: Subject) -> bool:
    """Forces between rigid bodies are found by iterations, which end at a tolerance of their
    own.
    """
    return subject.method.control == "step" and "contact:rigid" in subject.instance.scene.features


def _decided_by_rounding(
    subject: Subject, runs: Mapping[Variant, CompletedRun], growth: Array, picture: str
) -> Array:
    """What may differ (T,) in a picture because a rounding decided otherwise: never more than
    truncation of both runs.

    A contact that begins, or a body that sticks, in this step or in the next hangs on the last bit
    where it falls on the end of a step. Both outcomes are right then, and a start moved by a few
    roundings has the other one. Where no moved start shows it, nothing hung on a rounding.

    Step sizes that are chosen always hang on roundings: see `_chosen`. Iterations over contacts of
    rigid bodies that begin with another contact leave something else of the forces: a part of the
    truncation error, which the run at twice the step shows.
    """
    if not _decides(subject):
        return np.zeros(len(growth))
    level = level_for(subject)
    base = runs[Variant(level)].trajectory
    truncation: Array = 2 * subject.truncation(level) * growth
    if subject.method.control != "step":
        return np.minimum(truncation, _chosen(subject, runs, growth, picture))
    draws = [runs[variant].trajectory for variant in _moved(subject, level) if variant in runs]
    if not draws:
        return truncation
    largest = np.maximum.reduce([distances(subject.instance, draw, base) for draw in draws])
    shown: Array = MORE * np.maximum.accumulate(largest)
    if _iterates(subject):
        shown = shown + _left_by_iterations(subject, runs, growth, picture)
    return np.minimum(shown, truncation)


def _left_by_iterations(
    subject: Subject, runs: Mapping[Variant, CompletedRun], growth: Array, picture: str
) -> Array:
    """What iterations over contacts of rigid bodies may leave in a picture (T,).

    Many roundings, and what the step still changes where the picture puts contacts in another order
    or in other units. Measured: a stack that is turned has other points of contact in MuJoCo and
    moves by 1.2 times as much as when the step is doubled.
    """
    level = level_for(subject)
    rounding: Array = _many_roundings(subject, picture) * growth
    if picture not in REORDERED:
        return rounding
    coarser = _coarser(subject)
    if not coarser or coarser[0] not in runs:
        return np.full(len(growth), np.inf)
    change = distances(
        subject.instance, runs[coarser[0]].trajectory, runs[Variant(level)].trajectory
    )
    return rounding + room_of(subject) * np.maximum.accumulate(change)


def _many_roundings(subject: Subject, picture: str) -> float:
    """Round-off of a picture where more is computed than a few numbers a step: iterations, or steps
    of which nobody tells how many.
    """
    view = symmetry.of(subject.instance, picture)
    return (
        COUNTING_FLOOR * subject.noise(level_for(subject)) * symmetry.size(subject.instance, view)
    )


def _looser(subject: Subject, picture: str) -> float | None:
    """The coarsest tolerance that a picture may stand for, of those that ran; None where they were
    all stricter.

    A tolerance that is relative grows with the numbers of the picture, and one that is absolute
    with its units.
    """
    view = symmetry.of(subject.instance, picture)
    longest = max(max(view.units), 1.0 / min(view.units))
    effective = subject.levels[-1] * longest * symmetry.size(subject.instance, view)
    return next((level for level in reversed(subject.levels[:-1]) if level >= effective), None)


def _chosen(
    subject: Subject, runs: Mapping[Variant, CompletedRun], growth: Array, picture: str
) -> Array:
    """How far two choices of steps may take a motion apart (T,): as far as a run with a looser
    tolerance comes from truth.

    What a run makes of a tolerance falls in stairs where orders are chosen as well as steps, so
    that this run may stand on another stair than its picture; a tolerance that is looser by a level
    has both above it. Without truth for all of the motion nobody knows: infinitely.
    """
    unknown = np.full(len(growth), np.inf)
    truth = certified(subject)
    looser = _looser(subject, picture)
    if truth is None or truth.until < len(growth) or looser is None:
        return unknown
    own = float(largest_so_far(subject, looser, runs[Variant(looser)].trajectory, truth)[-1])
    found: Array = ROOM * own + _many_roundings(subject, picture) * growth
    return found


def _least_moved(
    subject: Subject, runs: Mapping[Variant, CompletedRun], perturbed: Variant
) -> Trajectory:
    """The run from the start moved up, or down where a rounding decides and that went less far:
    what it decides is no growth.

    A code may refuse moved starts: then the plain run.
    """
    base = runs[Variant(perturbed.level)].trajectory
    down = Variant(perturbed.level, "perturbed", -perturbed.amount)
    draws = [runs[variant].trajectory for variant in (perturbed, down) if variant in runs]
    return min(
        draws, key=lambda draw: float(np.max(distances(subject.instance, draw, base))), default=base
    )


def _moved(subject: Subject, level: float) -> tuple[Variant, ...]:
    """The variants with a perturbed start, in all draws."""
    return (Variant(level, "perturbed", perturbation(subject.method)), *_draws(subject, level))


def _basis(subject: Subject) -> str:
    differs = "round-off"
    if _decides(subject):
        differs = "round-off, and discrete decisions that it flips in perturbed starts,"
    return (
        f"the laws of mechanics are invariant, so only {differs} amplified by the motion may differ"
    )


def _decides(subject: Subject) -> bool:
    """The last bit may decide something: which step size is chosen, or in which step of a method
    that does not look for it a contact begins or a body sticks."""
    features = subject.instance.scene.features
    switches = SWITCHES & features and subject.method.control == "step"
    return subject.method.control == "tolerance" or bool(
        switches and subject.order < max(2, subject.method.order)
    )


CHECK = Symmetry()
