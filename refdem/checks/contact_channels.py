"""Overlap and contact force, where a run writes them, are those of the places and velocities of the same row."""

from collections.abc import Mapping

import numpy as np

from refdem.core.check import Array, Check, Outcome, Trial
from refdem.core.finding import Finding
from refdem.core.judgement import worst
from refdem.core.trajectory import Trajectory
from refdem.core.variant import Variant
from refdem.scene import Scene, Sphere
from refdem.scene.elements.contact import Contact

MOST = 64
"""Spheres of which every pair is looked at."""


class ContactChannels(Check):
    """The largest of all pairs of spheres, at the finest level; a run that writes neither is not judged."""

    name = "contact-channels"
    title = "Overlap and contact force"
    kills = "an overlap counted for each body, a force of the step before or with the other sign, channels in other units"
    synchronous = True

    def applies(self, trial: Trial) -> str | None:
        """A few spheres that meet each other and nothing else, under a law with an overlap."""
        scene, laws = trial.instance.scene, trial.instance.scene.all(Contact)
        if len(laws) != 1 or laws[0].law == "rigid" or {"plane", "periodic_box"} & scene.features:
            return "spheres do not meet each other alone, or without overlap"
        alone = all(isinstance(shape, Sphere) for shape in scene.bodies.shape) and 2 <= len(scene.bodies) <= MOST
        return None if alone else f"it is not a scene of 2 to {MOST} spheres"

    def needs(self, trial: Trial) -> tuple[Variant, ...]:
        """The finest level."""
        return (trial.finest,)

    def judge(self, trial: Trial, runs: Mapping[Variant, Outcome]) -> list[Finding]:
        """Each channel against the state, in units of the length of the scene and of the largest force."""
        run, scene, level = runs[trial.finest].trajectory, trial.instance.scene, trial.levels[-1]
        overlap, force = _of_states(scene, run)
        length, exact, peak = trial.instance.scales.length, trial.round_off(level), float(np.max(force))
        found = []
        if "overlap" in run.channels:
            off = np.abs(_largest(run, "overlap") - np.maximum(overlap, 0.0)) / length
            # R + R' - |d| is a difference of numbers as large as places and radii, each rounded, here and in the run.
            reach = float(np.max(np.abs(run.position))) + 2 * float(np.max(scene.bodies.radius))
            rounded = exact + 4 * trial.method.round_off * reach / length
            found.append(("overlap", run.t, off, np.full(len(off), rounded), "it follows from the places of the same row, to round-off"))
        told = np.abs(overlap) > exact * length  # at the touch rounding says whether a dashpot acts
        if "contact_force" in run.channels and peak > 0 and told.any():
            off = np.abs(_largest(run, "contact_force") - force)[told] / peak
            allowed = trial.truncation(level) + exact * (1 + length / float(np.max(overlap)))
            basis = "it follows from the state of the same row, to the truncation error of velocities and to round-off"
            found.append(("contact_force", run.t[told], off, allowed[told], basis))
        return [
            worst(
                check=self.name,
                quantity=name,
                t=t,
                values=values,
                allowed=allowed,
                unit="1",
                basis=basis,
                what=f"What the {name.replace('_', ' ')} differs by from that of the state, in units of its scale,",
            )
            for name, t, values, allowed, basis in found
        ]


def _largest(run: Trajectory, channel: str) -> Array:
    """The largest value of a channel at every sample (T,); pulls count as none."""
    largest: Array = np.maximum(run.channels[channel].reshape(len(run.t), -1).max(axis=1), 0.0)
    return largest


def _of_states(scene: Scene, run: Trajectory) -> tuple[Array, Array]:
    """The largest overlap (T,) [m], negative where none meet, and the largest force (T,) [N] with which a pair presses."""
    law, (i, j) = scene.all(Contact)[0], np.triu_indices(len(scene.bodies), 1)
    apart, relative = run.position[:, j] - run.position[:, i], run.velocity[:, i] - run.velocity[:, j]
    distance = np.linalg.norm(apart, axis=-1)
    overlap = scene.bodies.radius[i] + scene.bodies.radius[j] - distance
    rate = np.sum(relative * apart, axis=-1) / distance
    force = np.where(overlap > 0, law.stiffness * np.maximum(overlap, 0.0) ** law.exponent + law.damping * rate, 0.0)
    return overlap.max(axis=1), np.maximum(force.max(axis=1), 0.0)


CHECK = ContactChannels()
