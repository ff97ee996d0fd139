"""The channels overlap and contact_force, where a run writes them, agree with the state in the same
row.

The law is F = k d^e + c d', with the overlap d = R + R' - |r' - r| of two spheres.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from refdem.core.check import Array, Check, CompletedRun, Subject
from refdem.core.finding import Finding
from refdem.core.judgement import worst
from refdem.core.trajectory import Trajectory
from refdem.core.variant import Variant
from refdem.scene import Scene, Sphere
from refdem.scene.elements.contact import Contact
from refdem.scene.elements.uniform_gravity import UniformGravity

MOST = 64
"""Largest number of spheres whose pairs are all computed."""


class ContactChannels(Check):
    """The largest overlap and the largest force over all pairs, at the finest level.

    A run that writes neither channel is not judged.
    """

    name = "contact-channels"
    title = "Overlap and contact force"
    kills = (
        "an overlap counted once for each body, a force with the wrong sign or"
        " from the previous step, channels in wrong units"
    )
    synchronous = True

    def applies(self, subject: Subject) -> str | None:
        """Two to 64 spheres that interact by one contact law with an overlap and with nothing
        else.
        """
        scene = subject.instance.scene
        laws = subject.instance.scene.all(Contact)
        if len(laws) != 1 or laws[0].law == "rigid" or {"plane", "periodic_box"} & scene.features:
            return "sphere-sphere contact with overlap is not the only interaction"
        is_few_spheres = (
            all(isinstance(shape, Sphere) for shape in scene.bodies.shape)
            and 2 <= len(scene.bodies) <= MOST
        )
        if is_few_spheres:
            return None
        return f"the scene does not have between 2 and {MOST} spheres"

    def needs(self, subject: Subject) -> tuple[Variant, ...]:
        """The plain run at the finest level."""
        return (subject.finest,)

    def judge(self, subject: Subject, runs: Mapping[Variant, CompletedRun]) -> list[Finding]:
        """One finding for each channel that the run writes: its difference from the state's value,
        relative to the length scale and to the largest force.
        """
        run = runs[subject.finest].trajectory
        pair_states = _pair_states(subject.instance.scene, run)
        findings = []
        if "overlap" in run.channels:
            findings.append(self._overlap(subject, run, pair_states))
        if "contact_force" in run.channels:
            findings += self._force(subject, run, pair_states)
        return findings

    def _overlap(self, subject: Subject, run: Trajectory, pair_states: "_PairStates") -> Finding:
        """The finding that the reported overlap is the largest max(0, d) of the state."""
        length = subject.instance.scales.length
        difference = (
            np.abs(_largest(run, "overlap") - np.maximum(pair_states.overlap, 0.0)) / length
        )
        return worst(
            check=self.name,
            quantity="overlap",
            t=run.t,
            values=difference,
            allowed=_overlap_rounding(subject, run),
            unit="1",
            basis="the channel must follow from the positions in the same row, to round-off",
            what=_what("overlap"),
        )

    def _force(
        self, subject: Subject, run: Trajectory, pair_states: "_PairStates"
    ) -> list[Finding]:
        """The finding that the reported force is the largest of the state, relative to the peak.

        None if no force is observed, or only within rounding of overlap 0, where rounding
        determines whether a dashpot acts.
        """
        peak = float(np.max(pair_states.force))
        rounded = _overlap_rounding(subject, run) * subject.instance.scales.length
        is_resolved = np.all(np.abs(pair_states.overlaps) > rounded, axis=1)
        if not (peak > 0 and is_resolved.any()):
            return []
        # The extra tolerance is the change of the dashpot's force in half a step.
        difference, tolerance = _force_difference(subject, run, pair_states)
        return [
            worst(
                check=self.name,
                quantity="contact_force",
                t=run.t[is_resolved],
                values=difference[is_resolved] / peak,
                allowed=_force_rounding(subject, run, pair_states) + tolerance / peak,
                unit="1",
                basis=(
                    "the channel must follow from positions and velocities in the same row"
                    " (or half a step earlier), to round-off"
                ),
                what=_what("contact force"),
            )
        ]


def _what(channel: str) -> str:
    """The phrase that names the measured difference of a channel."""
    return (
        f"The difference between the reported {channel} and the one"
        " computed from the state, relative to its scale,"
    )


def _largest(run: Trajectory, channel: str) -> Array:
    """The largest value of a channel at every sample (T,); negative ones (pulling forces) count as
    0.
    """
    largest: Array = np.maximum(run.channels[channel].reshape(len(run.t), -1).max(axis=1), 0.0)
    return largest


@dataclass(frozen=True)
class _PairStates:
    """Overlaps and closing speeds of every pair of spheres in a run's states, with the forces that
    they imply.

    The contact law is F = k d^e + c d', with overlap d and closing speed d'; forces that pull count
    as 0.
    """

    law: Contact
    effective: Array  # mass of each pair (P,) [kg]
    overlaps: Array  # of each pair (T, P) [m]
    closing: Array  # speed of each pair (T, P) [m/s]

    @property
    def overlap(self) -> Array:
        """The largest overlap (T,) [m]."""
        largest: Array = self.overlaps.max(axis=1)
        return largest

    @property
    def force(self) -> Array:
        """The largest force (T,) [N], with the velocities of the row."""
        return self._largest_force(np.ones_like(self.effective))

    def force_half_step_earlier(self, h: float) -> Array:
        """The largest force (T,) [N] with velocities half a step h/2 earlier, as a leapfrog has
        them.

        Over half a step the force slows the pair by F h/(2 m_eff), so the earlier closing speed is
        v + F h/(2 m_eff). F = k d^e + c (v + F h/(2 m_eff)) gives F = (k d^e + c v)/(1 - c h/(2
        m_eff)).
        """
        return self._largest_force(1.0 - self.law.damping * h / (2 * self.effective))

    def _largest_force(self, divisor: Array) -> Array:
        """The largest (T,) [N] over all pairs of max(0, (k d^e + c d')/divisor), with the divisor
        (P,) of each pair.
        """
        depth = np.maximum(self.overlaps, 0.0)
        pressing = (
            self.law.stiffness * depth**self.law.exponent + self.law.damping * self.closing
        ) / divisor
        largest: Array = np.where(self.overlaps > 0, np.maximum(pressing, 0.0), 0.0).max(axis=1)
        return largest


def _pair_states(scene: Scene, run: Trajectory) -> _PairStates:
    """Overlaps, closing speeds and effective masses of all pairs of spheres, from positions and
    velocities.
    """
    law = scene.all(Contact)[0]
    i, j = np.triu_indices(len(scene.bodies), 1)
    branch = run.position[:, j] - run.position[:, i]
    relative = run.velocity[:, i] - run.velocity[:, j]
    distance = np.linalg.norm(branch, axis=-1)
    radius = scene.bodies.radius
    # 1/m_eff = 1/m_i + 1/m_j, with 1/m = 0 for fixed bodies; of two fixed ones it is infinite.
    inverse = np.where(scene.bodies.fixed, 0.0, 1.0 / scene.bodies.mass)
    with np.errstate(divide="ignore"):
        effective = 1.0 / (inverse[i] + inverse[j])
    overlap = radius[i] + radius[j] - distance
    closing = np.sum(relative * branch, axis=-1) / distance
    return _PairStates(law, effective, overlap, closing)


def _force_difference(
    subject: Subject, run: Trajectory, pair_states: _PairStates
) -> tuple[Array, float]:
    """Difference (T,) [N] between the reported force and the one from the state, and an extra
    tolerance [N].

    A leapfrog evaluates the dashpot with velocities of half a step earlier. For two spheres with no
    force but contact and gravity that force is known exactly (`force_half_step_earlier`), and the
    smaller of both differences counts. With more bodies or forces it is known only up to the change
    of the dashpot force in half a step, at most c h/m_eff of the largest force: the extra
    tolerance.
    """
    reported = _largest(run, "contact_force")
    difference = np.abs(reported - pair_states.force)
    if pair_states.law.damping == 0 or subject.method.control != "step":
        return difference, 0.0
    scene = subject.instance.scene
    level = subject.levels[-1]
    half_step_share = pair_states.law.damping * level / float(np.min(pair_states.effective))
    is_contact_only = all(
        isinstance(element, Contact | UniformGravity) for element in scene.elements
    )
    if len(scene.bodies) > 2 or not is_contact_only or half_step_share > 1.0:
        return difference, half_step_share * float(np.max(pair_states.force))
    return np.minimum(
        difference, np.abs(reported - pair_states.force_half_step_earlier(level))
    ), 0.0


def _overlap_rounding(subject: Subject, run: Trajectory) -> float:
    """Rounding of an overlap R + R' - |r' - r|, in units of the length scale.

    It is a difference of numbers as large as positions and radii, each rounded here and in the run.
    """
    # u_n + 4 u (max|r| + 2 R)/L.
    reach = float(np.max(np.abs(run.position))) + 2 * float(
        np.max(subject.instance.scene.bodies.radius)
    )
    return (
        subject.round_off(subject.levels[-1])
        + 4 * subject.method.round_off * reach / subject.instance.scales.length
    )


def _force_rounding(subject: Subject, run: Trajectory, pair_states: _PairStates) -> float:
    """Rounding of a force, relative to the largest: of k d^e (e times that of d, relative to the
    largest d), and of the dashpot's velocities.
    """
    length = subject.instance.scales.length
    # dF/F_max of F = k d^e: e (rounding of d)/d_max.
    of_overlap = (
        pair_states.law.exponent
        * _overlap_rounding(subject, run)
        * length
        / float(np.max(pair_states.overlap))
    )
    speed = float(np.max(np.abs(run.velocity)))
    # dF/F_max of the dashpot c |v|: 8 u c |v|/F_max.
    of_speed = (
        8
        * subject.method.round_off
        * pair_states.law.damping
        * speed
        / float(np.max(pair_states.force))
    )
    return subject.round_off(subject.levels[-1]) + of_overlap + of_speed


CHECK = ContactChannels()
