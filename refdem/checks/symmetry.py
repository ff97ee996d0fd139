"""Symmetry: the same scene shifted, rotated, boosted, mirrored, relabelled, in other units, started later. Needs no truth."""

from collections.abc import Mapping

import numpy as np

from refdem.core import symmetry
from refdem.core.check import Array, Check, Outcome, Trial
from refdem.core.finding import Finding
from refdem.core.judgement import certified, distances, growth_shown, perturbation, undecided, worst
from refdem.core.refinement import COUNTING_FLOOR, scored
from refdem.core.trajectory import Trajectory
from refdem.core.variant import Variant

CHANCE = 2.0
"""Octaves by which chance may keep a difference from falling with the step: that between two kinked errors scatters by 1.4."""


class Symmetry(Check):
    """The motion is the same however the scene is put before the code, to round-off."""

    name = "symmetry"
    title = "Symmetry"
    kills = "a frame taken for another, a hard-wired length or time, bodies treated unequally, a force that knows the origin"

    def applies(self, trial: Trial) -> str | None:
        """Scenes with some symmetry that the method can be shown."""
        return None if self._shown(trial) else "no symmetry of the scene is one that the method can run"

    def _shown(self, trial: Trial) -> list[str]:
        """Symmetries that the scene has and whose picture of it the method does not refuse."""
        scene = trial.instance.scene
        names = [name for name in symmetry.NAMES if symmetry.broken(scene, name) is None]
        return [name for name in names if trial.refusal(symmetry.picture(trial.instance, name)[1]) is None]

    def needs(self, trial: Trial) -> tuple[Variant, ...]:
        """One level, as it is, in every symmetry, and with the start moved a little."""
        level = level_for(trial)
        shown = tuple(Variant(level, name) for name in self._shown(trial))  # type: ignore[arg-type]
        other: tuple[Variant, ...] = ()
        if _has_axes(trial) and Variant(level, "rotated") in shown:
            other = (trial.finest, Variant(trial.levels[-1], "rotated"))
        elif _falls(trial):
            other = tuple(Variant(trial.levels[0], change) for change in ("none", *(variant.change for variant in shown)))  # type: ignore[arg-type]
        return (Variant(level), Variant(level, "perturbed", perturbation(trial.method)), *shown, *other)

    def judge(self, trial: Trial, runs: Mapping[Variant, Outcome]) -> list[Finding]:
        """One finding a symmetry: the largest scaled difference of any state."""
        plain, perturbed, *others = self.needs(trial)
        shown = [variant for variant in others if variant.level == plain.level and variant.change != "none"]
        base = runs[plain].trajectory
        growth = growth_of(trial, runs[perturbed].trajectory if perturbed in runs else base, base)
        found = []
        for variant in shown:
            if variant not in runs:  # the code said when it ran that it cannot show this one
                continue
            view = symmetry.of(trial.instance, variant.change)
            bounds = allowed(trial, view, growth)
            count = scored(bounds)
            if count < 2:
                found.append(undecided(self.name, variant.change, "round-off may grow past a tenth of the scale before the second sample"))
                continue
            apart = distances(trial.instance, view.undone(runs[variant].trajectory), base)
            if variant.change == "rotated" and _has_axes(trial) and np.any(apart[:count] > bounds[:count]):
                found.append(self._rotated(trial, runs, apart, growth))
                continue
            steady = _steady(trial, runs, variant, view, growth, apart, count)
            found.append(
                worst(
                    check=self.name,
                    quantity=variant.change,
                    t=trial.instance.times[:count],
                    values=apart[:count],
                    allowed=(bounds if steady is None else np.minimum(bounds, steady))[:count],
                    unit="1",
                    basis=_basis(trial, steady is not None),
                    what=f"The difference between the motion and the same {variant.change}, in units of each scale,",
                )
            )
        return found or [undecided(self.name, "any", "the code refused every symmetry of the scene when it ran")]

    def _rotated(self, trial: Trial, runs: Mapping[Variant, Outcome], coarse: Array, growth: Array) -> Finding:
        """A method may put attitudes in coordinates with axes of their own: then what differs is truncation, and falls with the step."""
        level, finest = level_for(trial), trial.levels[-1]
        view = symmetry.of(trial.instance, "rotated")
        fine = distances(trial.instance, view.undone(runs[Variant(finest, "rotated")].trajectory), runs[trial.finest].trajectory)
        order, octaves = trial.method.order_for(trial.instance.scene.features), np.log2(level / finest)
        allowed = (2 * trial.truncation(finest)) * growth
        count = scored(allowed)
        largest, falls = float(np.max(fine)), float(np.max(coarse)) / 2.0 ** (octaves * (order - 0.5))
        falling = np.maximum(falls, 2 * trial.noise(finest) * symmetry.size(trial.instance, view) * growth)
        what = "The difference between the motion and the same rotated, in units of each scale, at the finest step"
        return worst(
            check=self.name,
            quantity="rotated",
            t=trial.instance.times[:count],
            values=fine[:count],
            allowed=np.minimum(allowed, falling)[:count],
            unit="1",
            basis=f"it is more than round-off, so it must be a truncation error of order {order} at both steps and fall with it",
            what=f"{what} ({largest:.2g} there, {float(np.max(coarse)):.2g} at {level / finest:.0f} times the step)",
        )


def _has_axes(trial: Trial) -> bool:
    """Attitudes, which a method with steps may put in coordinates whose truncation error knows the axes of space."""
    turns = "rotation" in trial.instance.scene.features
    return turns and trial.method.control == "step" and len(trial.levels) > 1 and not _decides(trial)


def level_for(trial: Trial) -> float:
    """The coarsest, where nothing is hidden by a small step; the finest where truncation has to be allowed for."""
    return trial.levels[-1] if _decides(trial) else trial.levels[0]


def growth_of(trial: Trial, perturbed: Trajectory, base: Trajectory) -> Array:
    """How much an early error has grown (T,): S of the truth, or what the moved start shows."""
    if (truth := certified(trial)) is not None and truth.until == len(base.t):
        return truth.growth()
    return growth_shown(trial.instance, trial.method, perturbed, base)


def allowed(trial: Trial, view: symmetry.Symmetry, growth: Array) -> Array:
    """Round-off of both runs with the numbers as large as the symmetry makes them; truncation where a branch may flip.

    A contact that begins, or a step size that is chosen, hangs on the last bit: there the two runs may take other steps.
    In other units the moments of inertia are rounded anew, which makes another body of a needle.
    """
    level = level_for(trial)
    rounding = 2 * trial.noise(level) * symmetry.size(trial.instance, view)
    if view.units != symmetry.Symmetry().units:
        rounding += trial.method.round_off * symmetry.rounded_rates(trial.instance)
    found: Array = (rounding + (trial.truncation(level) if _decides(trial) else 0.0)) * growth
    return found


def _falls(trial: Trial) -> bool:
    """Steps may hang on the last bit, and there are levels enough to see that what this makes falls with the step."""
    if not _decides(trial) or trial.method.control != "step":
        return False
    order = trial.method.order_for(trial.instance.scene.features)
    return bool(order * np.log2(trial.levels[0] / trial.levels[-1]) > CHANCE)


def _steady(
    trial: Trial, runs: Mapping[Variant, Outcome], variant: Variant, view: symmetry.Symmetry, growth: Array, apart: Array, count: int
) -> Array | None:
    """What may differ at the finest step (T,) if the coarsest shows a difference as large; None if it does not, or was not run.

    What hangs on the last bit is rare, and as large as the error of a step. A force that breaks the symmetry is so at every step.
    Nothing is said of differences that are mostly round-off.
    """
    coarsest = trial.levels[0]
    plain, changed = Variant(coarsest), Variant(coarsest, variant.change)
    if not _falls(trial) or plain not in runs or changed not in runs:
        return None
    coarse = distances(trial.instance, view.undone(runs[changed].trajectory), runs[plain].trajectory)[:count]
    sizes = symmetry.size(trial.instance, view) * growth
    rounding = [COUNTING_FLOOR * 2 * trial.noise(level) * sizes for level in (coarsest, variant.level)]
    largest, octaves = float(np.max(coarse)), np.log2(coarsest / variant.level)
    alike = bool(np.any(coarse > rounding[0][:count])) and float(np.max(apart[:count])) < 2.0**CHANCE * largest
    falling = largest * 2.0 ** (CHANCE - octaves * trial.method.order_for(trial.instance.scene.features))
    return np.maximum(falling, rounding[1]) if alike else None


def _basis(trial: Trial, steady: bool) -> str:
    if steady:
        return "the coarsest step shows it as well, and what hangs on round-off must fall with the step"
    differs = "round-off and the steps that hang on it" if _decides(trial) else "round-off"
    return f"the laws of mechanics are the same there, so only {differs}, as it grows in this motion, may differ"


def _decides(trial: Trial) -> bool:
    """The last bit may decide something: which step size is chosen, or in which step of a method that does not look for it
    a contact begins or a body sticks."""
    features = trial.instance.scene.features
    switches = {"contact", "friction"} & features and trial.method.control == "step"
    return trial.method.control == "tolerance" or bool(switches and trial.method.order_for(features) < max(2, trial.method.order))


CHECK = Symmetry()
