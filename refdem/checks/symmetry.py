"""Symmetries of mechanics: shifting, rotating, boosting, mirroring, relabelling, rescaling or
delaying a scene transforms its motion and does not change it otherwise.

An *image* of the scene is the scene after such a transformation. The run of an image, transformed
back, must agree with the plain run to round-off. No truth is needed.
"""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import NamedTuple

import numpy as np

from refdem.checks._beside_impacts import nearest_velocities
from refdem.checks._crossings import has_crossings
from refdem.checks._impacts import growth_across, is_sequence, listed
from refdem.checks.contact_impulse import alternating_slip, slip_in_scales
from refdem.core import symmetry
from refdem.core.case import Instance
from refdem.core.check import Array, Check, CompletedRun, Subject
from refdem.core.finding import Finding
from refdem.core.judgement import (
    KINK_PREDICTION_FACTOR,
    MORE,
    PERTURBED,
    certified,
    distances,
    followed,
    growth_shown,
    largest_so_far,
    moves,
    perturbation,
    room_of,
    undecided,
    worst,
)
from refdem.core.once import once_with_arguments
from refdem.core.refinement import COUNTING_FLOOR, clock, scored
from refdem.core.trajectory import Trajectory
from refdem.core.variant import Variant
from refdem.scene import Polyhedron
from refdem.scene.elements.contact import Contact
from refdem.scene.elements.spring import Spring
from refdem.scene.elements.uniform_gravity import UniformGravity
from refdem.scene.shapes import extent

DRAWS = (16, -16, 1, -1)
"""Further perturbations of the start, in units of `perturbation`/64, where rounding decides.

A rounding decides a discrete event where a quantity is within one rounding of its threshold. Two
starts that lie on either side of the threshold, each by more than a rounding, have different
outcomes. The small amounts are for motions whose errors grow so fast that with large amounts the
growth hides the effect of a decision.
"""
REORDERED = frozenset({"rotated", "mirrored", "relabelled", "rescaled"})
"""Images that change the iterations over contacts: contacts are found in another order or at other
points, or a tolerance has other units.
"""


class Symmetry(Check):
    """The motion does not depend on the frame, the order of bodies, the units or the clock, to
    round-off.
    """

    name = "symmetry"
    title = "Symmetry"
    kills = (
        "confused frames of reference, a hard-wired length or time, bodies"
        " treated unequally, a force that depends on the origin"
    )

    def applies(self, subject: Subject) -> str | None:
        """Scenes with a symmetry whose image the method supports."""
        if self._shown(subject):
            return None
        return "the method can run no symmetry of the scene"

    def _shown(self, subject: Subject) -> list[str]:
        """Names of the symmetries that the scene has and whose image the method supports."""
        scene = subject.instance.scene
        names = [name for name in symmetry.NAMES if symmetry.broken(scene, name) is None]
        return [
            name
            for name in names
            if subject.unsupported(symmetry.image(subject.instance, name)[1]) is None
        ]

    def needs(self, subject: Subject) -> tuple[Variant, ...]:
        """The first level plain, with its start perturbed, and in every image; the looser
        tolerances where the engine chooses its steps.
        """
        level = _first_level(subject)
        looser: tuple[Variant, ...] = ()
        if subject.method.control == "tolerance":
            looser = tuple(map(Variant, subject.levels[:-1]))
        return (
            Variant(level),
            *_perturbed_starts(subject, level),
            *_images(level, self._shown(subject)),
            *looser,
        )

    def further(
        self, subject: Subject, runs: Mapping[Variant, CompletedRun]
    ) -> tuple[Variant, ...]:
        """Where images differ by more than round-off at the first level: those at the finest.

        Truncation error may depend on the axes of space; then it falls with the step. A rounding
        may decide in which step a contact begins; perturbed starts then show what it changes, and
        further ones where the first two do not show as much as an image does.
        """
        if subject.method.control != "step":
            return ()
        level = subject.levels[-1]
        coarse = Level(subject, runs, _first_level(subject))
        differing = [name for name in self._shown(subject) if not coarse.agrees_with(name)]
        if not _rounding_decides(subject):
            if "rotated" in differing and _has_axes(subject):
                return (Variant(level), *_images(level, ["rotated"]))
            return ()
        if not differing:
            return ()
        fine = (
            Variant(level),
            *_perturbed_starts(subject, level),
            *_images(level, differing),
            *_coarser_run(subject),
        )
        last = Level(subject, runs, level)
        if all(self._is_explained(last, name) for name in differing):
            return fine
        return (*fine, *_further_perturbations(subject, level))

    def _is_explained(self, level: "Level", name: str) -> bool:
        """True if an image differs by no more than the runs from perturbed starts allow, or has not
        been run.
        """
        if Variant(level.level) not in level.runs or not level.has_image(name):
            return True
        return self._image(level, name).outcome == "pass"

    def judge(self, subject: Subject, runs: Mapping[Variant, CompletedRun]) -> list[Finding]:
        """One finding for each symmetry: the largest difference of any state, in units of each
        scale.
        """
        first = Level(subject, runs, _first_level(subject))
        last = Level(subject, runs, level_for(subject))
        findings = []
        for name in self._shown(subject):
            # An engine may refuse an image only when it runs.
            if first.level != last.level and first.agrees_with(name):
                findings.append(self._agreement(first, name))
            elif last.has_image(name):
                findings.append(self._image(last, name))
        return findings or [
            undecided(
                self.name, "any", "the engine refused every symmetry of the scene during the run"
            )
        ]

    def _agreement(self, level: "Level", name: str) -> Finding:
        """The finding that an image, transformed back, is the plain run to round-off."""
        difference, _, rounding = level.compared(name)
        difference = np.minimum(difference, level.least_beside_impacts(name, rounding))
        return self._difference(level.subject, name, difference, rounding, ONLY)

    def _image(self, level: "Level", name: str) -> Finding:
        """The finding that an image, transformed back, equals the plain run to round-off and
        decisions by rounding.
        """
        subject = level.subject
        compared = level.compared(name)
        growth = compared.growth
        decided = _decided_by_rounding(subject, level.runs, growth, name)
        if _flips_nothing(subject, level.runs, compared.difference, compared.rounding):
            decided = np.zeros(len(growth))
        # |image - plain| <= rounding + decisions by rounding, each grown by the motion.
        bounds = compared.rounding + decided
        difference = np.minimum(compared.difference, level.least_beside_impacts(name, bounds))
        count = scored(bounds)
        if count < 2:
            why = "round-off may exceed a tenth of the scale before the second sample"
            return undecided(self.name, name, why)
        exceeds = bool(np.any(difference[:count] > bounds[:count]))
        if exceeds and name == "rotated" and _has_axes(subject):
            return self._rotated(subject, level.runs, growth, decided)
        return self._difference(
            subject, name, difference[:count], bounds[:count], _differs(subject)
        )

    def _difference(
        self, subject: Subject, name: str, difference: Array, bounds: Array, differs: str
    ) -> Finding:
        """The finding on a difference (T,) of an image; `differs` describes in words what the
        bounds (T,) allow.
        """
        return worst(
            check=self.name,
            quantity=name,
            t=subject.instance.times[: len(bounds)],
            values=difference,
            allowed=bounds,
            unit="1",
            basis=(
                f"the laws of mechanics are invariant, so only {differs} amplified by the motion"
                " may differ"
            ),
            what=(
                f"The difference between the motion and its {name} counterpart,"
                " relative to each scale,"
            ),
        )

    def _rotated(
        self, subject: Subject, runs: Mapping[Variant, CompletedRun], growth: Array, decided: Array
    ) -> Finding:
        """The finding for a rotated scene where the difference exceeds round-off: it must be
        truncation error, and fall with the step.

        A method may describe attitudes in coordinates that depend on the axes of space, such as
        Euler angles, so that its truncation error is not invariant. A difference due to decisions
        by rounding need not fall with the step: `decided` (T,) is allowed in addition.
        """
        coarsest = subject.levels[0]
        finest = subject.levels[-1]
        coarse = _rotation_difference(subject, runs, coarsest)
        fine = _rotation_difference(subject, runs, finest)
        order = subject.order
        truncation = (2 * subject.truncation(finest)) * growth
        count = scored(truncation)
        # d(h) <= min(2 E(h) S, max(d(h_0) (h/h_0)^(p - 1/2), round-off)) + decided,
        # with the truncation error E, its growth S, the coarsest step h_0, and h_0/h = 2^octaves.
        octaves = np.log2(coarsest / finest)
        extrapolated = float(np.max(coarse)) / 2.0 ** (octaves * (order - 0.5))
        view = symmetry.of(subject.instance, "rotated")
        rounding = 2 * subject.noise(finest) * symmetry.size(subject.instance, view) * growth
        bounds = np.minimum(truncation, np.maximum(extrapolated, rounding)) + decided
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
                "The difference between the motion and its rotated counterpart at the"
                f" finest step, relative to each scale ({float(np.max(fine)):.2g};"
                f" at {coarsest / finest:.0f} times the step {float(np.max(coarse)):.2g}),"
            ),
        )


class Compared(NamedTuple):
    """An image compared with the plain run: the difference (T,) of their states in units of the
    scales, the growth (T,) of errors, and the bound (T,) on that difference due to round-off of
    both runs, growth included.
    """

    difference: Array
    growth: Array
    rounding: Array


@dataclass(frozen=True, eq=False)
class Level:
    """The runs of one level of a subject: plain, from perturbed starts, and in images."""

    subject: Subject
    runs: Mapping[Variant, CompletedRun]
    level: float
    _held: dict[str, Trajectory] = field(default_factory=dict, init=False)
    """The last image requested. Only one is kept, to limit the memory for a large gas."""

    @cached_property
    def plain(self) -> Trajectory:
        """The plain run of the level."""
        return self.runs[Variant(self.level)].trajectory

    @cached_property
    def growth(self) -> Array:
        """Growth (T,) of an early error: see `growth_of`."""
        moved = _least_moved(self.subject, self.runs, self.level)
        return growth_of(self.subject, self.level, moved, self.plain)

    def has_image(self, name: str) -> bool:
        """True if an image was run, and not refused."""
        return _image_of(self.level, name) in self.runs

    def image(self, name: str) -> Trajectory:
        """The run of an image, transformed back."""
        if name not in self._held:
            self._held.clear()
            run = self.runs[_image_of(self.level, name)]
            view = symmetry.of(self.subject.instance, name)
            self._held[name] = view.undone(run.trajectory)
        return self._held[name]

    def compared(self, name: str) -> Compared:
        """An image, which was run, beside the plain run."""
        growth = self.growth
        if name == "rotated":
            growth = np.maximum(growth, _growth_across(self.subject))
        view = symmetry.of(self.subject.instance, name)
        rounding = round_off(self.subject, self.level, view) * growth
        difference = _distance_of_image(
            self.runs[_image_of(self.level, name)].trajectory,
            self.plain,
            self.subject.instance,
            name,
        )
        return Compared(difference, growth, rounding)

    def agrees_with(self, name: str) -> bool:
        """True if an image, transformed back, equals the plain run to round-off at every sample,
        and round-off is small enough at each for the comparison to count.
        """
        if Variant(self.level) not in self.runs or not self.has_image(name):
            return False
        difference, _, rounding = self.compared(name)
        if scored(rounding) < len(rounding):
            return False
        if np.any(difference > rounding):
            difference = np.minimum(difference, self.least_beside_impacts(name, rounding))
        return bool(np.all(difference <= rounding))

    def least_beside_impacts(self, name: str, bounds: Array) -> Array:
        """The smallest difference (T,) between an image and the plain run, with samples next to an
        impact taken before or after it in either run; infinite without certified impacts.

        Next to an impact a rounding decides on which side of it a sample is. `bounds` (T,) bounds
        the difference of the states of both runs.
        """
        least = np.full(len(self.plain.t), np.inf)
        subject = self.subject
        truth = certified(subject)
        if truth is None or not has_crossings(subject.instance.scene):
            return least
        image = self.image(name)
        for run, other in ((self.plain, image), (image, self.plain)):
            for replaced in nearest_velocities(subject, self.level, run, truth, bounds):
                least = np.minimum(least, distances(subject.instance, replaced, other))
        return least


def _images(level: float, names: Iterable[str]) -> tuple[Variant, ...]:
    """The images of these names at a level."""
    return tuple(_image_of(level, name) for name in names)


def _image_of(level: float, name: str) -> Variant:
    """The image of this name at a level."""
    return Variant(level, name)  # type: ignore[arg-type]


@once_with_arguments
def _distance_of_image(run: Trajectory, plain: Trajectory, instance: Instance, name: str) -> Array:
    """Largest scaled difference (T,) between the plain run and the run of an image, transformed
    back. It is computed once: both the further runs and the verdict follow from it.
    """
    return distances(instance, symmetry.of(instance, name).undone(run), plain)


def _rotation_difference(
    subject: Subject, runs: Mapping[Variant, CompletedRun], level: float
) -> Array:
    """Largest scaled difference (T,) between the plain run at a level and the rotated one, rotated
    back.
    """
    rotated = runs[Variant(level, "rotated")].trajectory
    plain = runs[Variant(level)].trajectory
    return _distance_of_image(rotated, plain, subject.instance, "rotated")


def _has_axes(subject: Subject) -> bool:
    """True if a method with fixed steps integrates attitudes at several levels: its truncation
    error may depend on the axes of space.
    """
    turns = "rotation" in subject.instance.scene.features
    return turns and subject.method.control == "step" and len(subject.levels) > 1


def _first_level(subject: Subject) -> float:
    """The level at which images are compared first: the coarsest, where truncation error is largest
    and agreement to round-off the strongest evidence; the tightest tolerance where the engine
    chooses its steps.
    """
    if subject.method.control == "tolerance":
        return subject.levels[-1]
    return subject.levels[0]


def level_for(subject: Subject) -> float:
    """The level whose images are judged: the coarsest, or the finest where rounding decides, since
    the bound then includes truncation error.
    """
    if _rounding_decides(subject):
        return subject.levels[-1]
    return subject.levels[0]


def growth_of(subject: Subject, level: float, perturbed: Trajectory, base: Trajectory) -> Array:
    """Growth factor (T,) of an early error: S of the truth, or G of a perturbed start.

    S is the growth along the true motion, G = `growth_shown` that observed between the run from a
    perturbed start and the plain run. The result is S up to the sample at which the plain run
    departs from the true motion by more than HORIZON, for example in a close passage with too long
    steps, and max(S, G) from there on. Without truth for the whole motion it is G.
    """
    truth = certified(subject)
    observed = growth_shown(subject.instance, subject.method, perturbed, base)
    if truth is None or truth.until != len(base.t):
        return observed
    growth = truth.growth()
    departure = followed(subject, level, base, truth)
    combined: Array = np.concatenate([growth[:departure], np.maximum(growth, observed)[departure:]])
    return combined


def _growth_across(subject: Subject) -> Array:
    """Growth (T,) of rounding errors that lead a rotated motion out of its line or plane, by
    `growth_across`; 1 without certified impacts.
    """
    truth = certified(subject)
    if truth is None or not is_sequence(subject.instance.scene):
        return np.ones(len(subject.instance.times))
    return growth_across(subject.instance, listed(truth.scalars))


def round_off(subject: Subject, level: float, view: symmetry.Symmetry) -> float:
    """Relative round-off of both runs of a level before it grows, 2 (noise(h) + d) s, where s is
    the size of the numbers in the image relative to those of the scene.

    Fixed steps from the same start to the same samples are summed to the same times, so that the
    noise of the clock is left out unless the image has another clock.

    The term d = round_off(h) tau/h is for methods with a fixed step that do not claim to conserve
    momentum: these may compute velocities as differences of positions, as in Stoermer's rule
    v = (r' - r)/h. A rounding error u r of a position then causes an error u r/h, which in units of
    the speed L/tau is u r/L times tau/h.

    A change of units rounds the moments of inertia again, which is visible for very slender bodies.
    """
    method = subject.method
    noise = subject.noise(level)
    if method.control == "step" and has_same_clock(view):
        noise -= clock(subject.instance, method, level)
    if method.control == "step" and "momentum" not in method.conserves:
        noise += subject.round_off(level) * subject.instance.scales.tau / level
    # 2 (noise + d) s.
    rounding = 2 * noise * symmetry.size(subject.instance, view)
    if view.units != symmetry.Symmetry().units:
        rounding += method.round_off * symmetry.rounded_rates(subject.instance)
    return rounding


def has_same_clock(view: symmetry.Symmetry) -> bool:
    """True if the image has the sample times of the scene."""
    return view.delay == 0.0 and view.units[2] == 1.0


def allowed(subject: Subject, view: symmetry.Symmetry, growth: Array) -> Array:
    """Bound (T,) for images without perturbed runs: round-off of both runs, plus their truncation
    error where a decision may depend on rounding.
    """
    # (round-off + 2 E) growth.
    level = level_for(subject)
    error = np.full_like(growth, round_off(subject, level, view))
    if _rounding_decides(subject):
        error += 2 * subject.truncation(level)
    return error * growth


def _perturbed_starts(subject: Subject, level: float) -> tuple[Variant, ...]:
    """The start perturbed by `perturbation`; with both signs where a rounding may decide, since the
    effect of a decision in one of them is not growth.
    """
    amount = perturbation(subject.method)
    upwards = Variant(level, "perturbed", amount)
    if _rounding_decides(subject) and subject.method.control == "step":
        return (upwards, Variant(level, "perturbed", -amount))
    return (upwards,)


def _further_perturbations(subject: Subject, level: float) -> tuple[Variant, ...]:
    """Starts perturbed by DRAWS units in the last place of the method's precision."""
    units = perturbation(subject.method) // PERTURBED
    return tuple(Variant(level, "perturbed", draw * units) for draw in DRAWS)


def _coarser_run(subject: Subject) -> tuple[Variant, ...]:
    """The plain run at twice the step, which shows the error that contact iterations leave; none
    without such iterations.
    """
    if _iterates(subject) and len(subject.levels) > 1:
        return (Variant(subject.levels[-2]),)
    return ()


def _iterates(subject: Subject) -> bool:
    """True if forces between rigid bodies are found by iteration to a tolerance, in fixed
    steps.
    """
    return subject.method.control == "step" and "contact:rigid" in subject.instance.scene.features


def _decided_by_rounding(
    subject: Subject, runs: Mapping[Variant, CompletedRun], growth: Array, image: str
) -> Array:
    """Difference (T,) allowed in an image since roundings decide discrete events otherwise in it.

    If a contact or a stick begins at the end of a step to the last bit, a rounding decides whether
    it begins in that step or in the next. Both outcomes are correct, and a start perturbed by a few
    roundings has the other one. Where no perturbed start differs from the plain run, no rounding
    decided an event.

    Let B = 2 E S be the truncation error E of both runs times its growth S, and D the largest
    difference so far of the plain run and the runs from perturbed starts. The allowed difference is

    - 0 where rounding decides nothing;
    - min(B, `_difference_of_step_choices`) where the engine chooses the steps, which always depend
      on roundings;
    - B + `_fall_in_a_step` S for a polyhedron that moves along a plane it lies on;
    - B + 2 s S where friction alternates in sign about a slip of 0: its sign is decided by a
      rounding at every step, and s is the slip that one step of friction produces;
    - min(B, MORE D + `_left_by_iterations`) otherwise, where the second term is for solvers that
      iterate over contacts: in another order they leave another part of the truncation error;
    - B where no perturbed start was run, for a rescaled polyhedron, or if s is not known.
    """
    if not _rounding_decides(subject):
        return np.zeros(len(growth))
    level = level_for(subject)
    base = runs[Variant(level)].trajectory
    truncation: Array = 2 * subject.truncation(level) * growth
    if subject.method.control != "step":
        return np.minimum(truncation, _difference_of_step_choices(subject, runs, growth, image))
    shown = _differences_of_perturbed_starts(subject, runs, base)
    if not shown:
        return truncation
    if _lies_on_plane(subject):
        return truncation + _fall_in_a_step(subject, level) * growth
    if image == "rescaled" and "shape:polyhedron" in subject.instance.scene.features:
        # Contact solvers reduce overlaps at a rate [1/s] of their own, which does not scale with
        # the unit of time. A corner that leaves slowly overlaps for many steps.
        return truncation
    # D, the effect of decisions by rounding, from the runs with perturbed starts.
    largest = np.maximum.reduce(shown)
    slip = alternating_slip(subject, base, level)
    if slip is None:
        return truncation
    if slip > 0:
        # Along an axis the slip may be exactly 0, in the plain run and in every perturbed start.
        return truncation + 2 * slip_in_scales(subject, slip) * growth
    observed: Array = MORE * np.maximum.accumulate(largest)
    if _iterates(subject):
        observed = observed + _left_by_iterations(subject, runs, growth, image)
    return np.minimum(observed, truncation)


def _lies_on_plane(subject: Subject) -> bool:
    """True if a polyhedron moves, or a spring pulls it, along a plane on which gravity presses it,
    by rigid contact.

    Its corners touch the plane to the last bit, so that at every step a rounding decides which of
    them are in contact, and few perturbed starts have the same sequence of decisions as an image.
    """
    scene = subject.instance.scene
    truth = certified(subject)
    is_pulled = bool(scene.all(Spring)) or (truth is not None and moves(truth))
    on_plane = {"contact:rigid", "plane", "shape:polyhedron", "uniform_gravity"}
    return is_pulled and _iterates(subject) and on_plane <= scene.features


def _fall_in_a_step(subject: Subject, level: float) -> float:
    """Twice (for both runs) the larger of the velocity g h that a corner gains in a step without
    contact, and of the spin g h/R of a body of extent R supported at other corners, in units of
    their scales: 2 max(g h/V, g h tau/R).
    """
    scene = subject.instance.scene
    scales = subject.instance.scales
    fields = [np.array(field.g) for field in scene.all(UniformGravity)]
    speed = float(np.linalg.norm(np.sum(fields, axis=0))) * level
    smallest = min(extent(shape) for shape in scene.bodies.shape if isinstance(shape, Polyhedron))
    return 2 * max(speed / scales.speed, speed / smallest * scales.tau)


def _differences_of_perturbed_starts(
    subject: Subject, runs: Mapping[Variant, CompletedRun], base: Trajectory
) -> list[Array]:
    """Difference (T,) between the plain run and every run from a perturbed start, in scales."""
    level = level_for(subject)
    variants = (
        *_perturbed_starts(subject, level),
        *_further_perturbations(subject, level),
    )
    return [
        distances(subject.instance, runs[variant].trajectory, base)
        for variant in variants
        if variant in runs
    ]


def _flips_nothing(
    subject: Subject, runs: Mapping[Variant, CompletedRun], difference: Array, rounding: Array
) -> bool:
    """True if a difference (T,) is too small to be the effect of a decision by rounding, whose two
    outcomes are motions a finite distance apart.

    In a collision of two bodies without friction, roundings decide in which step contact begins and
    in which it ends. Perturbed starts whose difference exceeds `rounding` (T,) show the effect of
    one of these decisions. The effect of the other is smaller in the ratio of the speeds of closing
    and parting, which is taken to be at most KINK_PREDICTION_FACTOR. So the condition is

        max difference < (smallest such effect)/KINK_PREDICTION_FACTOR.
    """
    if not _rounding_decides(subject) or not _is_one_collision(subject):
        return False
    base = runs[Variant(level_for(subject))].trajectory
    shown = _differences_of_perturbed_starts(subject, runs, base)
    flips = [float(np.max(shift)) for shift in shown if np.any(shift > rounding)]
    return bool(flips) and float(np.max(difference)) < min(flips) / KINK_PREDICTION_FACTOR


def _is_one_collision(subject: Subject) -> bool:
    """True for two bodies with a contact without friction, in fixed steps, that meet once."""
    scene = subject.instance.scene
    laws = scene.all(Contact)
    return (
        subject.method.control == "step"
        and not _iterates(subject)
        and len(scene.bodies) == 2
        and len(scene.elements) == len(laws) == 1
        and laws[0].friction == 0
    )


def _left_by_iterations(
    subject: Subject, runs: Mapping[Variant, CompletedRun], growth: Array, image: str
) -> Array:
    """Difference (T,) that iterations over contacts of rigid bodies may leave in an image.

    It is R S + f d, with the round-off R of many operations (`_many_roundings`) and its growth S.
    The second term is for the images in REORDERED: d is the largest difference so far between the
    plain runs at the steps h and 2 h, f the factor `room_of`. It is infinite without a run at 2 h.
    Measured: a rotated stack has other contact points in MuJoCo, which changes its motion by 1.2 d.
    """
    level = level_for(subject)
    rounding: Array = _many_roundings(subject, image) * growth
    if image not in REORDERED:
        return rounding
    coarser = _coarser_run(subject)
    if not coarser or coarser[0] not in runs:
        return np.full(len(growth), np.inf)
    coarse_run = runs[coarser[0]].trajectory
    fine_run = runs[Variant(level)].trajectory
    change = distances(subject.instance, coarse_run, fine_run)
    return rounding + room_of(subject) * np.maximum.accumulate(change)


def _many_roundings(subject: Subject, image: str) -> float:
    """Round-off of an image where each step takes many operations: iterations, or an unknown
    number of inner steps.
    """
    view = symmetry.of(subject.instance, image)
    return (
        COUNTING_FLOOR * subject.noise(level_for(subject)) * symmetry.size(subject.instance, view)
    )


def _looser_tolerance(subject: Subject, image: str) -> float | None:
    """The tightest tolerance that ran and is at least as loose as the image makes the finest one;
    None without one.

    A relative tolerance grows with the numbers of the image, an absolute one with its units.
    """
    view = symmetry.of(subject.instance, image)
    unit_ratio = max(max(view.units), 1.0 / min(view.units))
    effective = subject.levels[-1] * unit_ratio * symmetry.size(subject.instance, view)
    return next((level for level in reversed(subject.levels[:-1]) if level >= effective), None)


def _difference_of_step_choices(
    subject: Subject, runs: Mapping[Variant, CompletedRun], growth: Array, image: str
) -> Array:
    """Difference (T,) due to another choice of step sizes: f e + R S, with the largest error e
    against truth of a run with a looser tolerance, the factor f = `room_of` for the scatter that
    kinks cause, and grown round-off R S.

    Where a method chooses its order as well as its step, the error is a piecewise constant function
    of the tolerance, so a run and its image may have the errors of neighbouring pieces. The error
    at the next looser tolerance exceeds both. Without truth for the whole motion, or without such a
    run, the result is infinite.
    """
    unknown = np.full(len(growth), np.inf)
    truth = certified(subject)
    looser = _looser_tolerance(subject, image)
    if truth is None or truth.until < len(growth) or looser is None:
        return unknown
    observed = float(largest_so_far(subject, looser, runs[Variant(looser)].trajectory, truth)[-1])
    bound: Array = room_of(subject) * observed + _many_roundings(subject, image) * growth
    return bound


def _least_moved(
    subject: Subject, runs: Mapping[Variant, CompletedRun], level: float
) -> Trajectory:
    """The run from a start perturbed upwards or downwards that differs less from the plain run,
    since the effect of a decision by rounding in one of them is not growth.

    If the engine refuses perturbed starts, it is the plain run.
    """
    base = runs[Variant(level)].trajectory
    variants = _perturbed_starts(subject, level)
    perturbed_runs = [runs[variant].trajectory for variant in variants if variant in runs]
    return min(
        perturbed_runs,
        key=lambda run: float(np.max(distances(subject.instance, run, base))),
        default=base,
    )


ONLY = "round-off"
"""The cause of differences where rounding decides nothing."""


def _differs(subject: Subject) -> str:
    """The possible causes of a difference, in words."""
    if _rounding_decides(subject):
        return f"{ONLY}, and discrete decisions that it flips in perturbed starts,"
    return ONLY


def _rounding_decides(subject: Subject) -> bool:
    """True if the last bit may decide which step size is chosen, or in which step a contact begins
    or a body sticks, for methods that do not locate such events.
    """
    if subject.method.control == "tolerance":
        return True
    # Where a switch falls on the end of a step, rounding decides in which step it happens.
    switches = any(element.switches for element in subject.instance.scene.elements)
    is_step = subject.method.control == "step"
    return switches and is_step and subject.order < max(2, subject.method.order)


CHECK = Symmetry()
