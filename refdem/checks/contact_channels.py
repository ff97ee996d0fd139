"""Overlap and contact force, where a run writes them, are those of the places and velocities of the
same row.
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
"""Spheres of which every pair is looked at."""


class ContactChannels(Check):
    """The largest of all pairs of spheres, at the finest level; a run that writes neither is not
    judged.
    """

    name = "contact-channels"
    title = "Overlap and contact force"
    kills = (
        "an overlap counted once for each body, a force with the wrong sign or"
        " from the previous step, channels in wrong units"
    )
    synchronous = True

    def applies(self, subject: Subject) -> str | None:
        """A few spheres that meet each other and nothing else, under a law with an overlap."""
        scene = subject.instance.scene
        laws = subject.instance.scene.all(Contact)
        if len(laws) != 1 or laws[0].law == "rigid" or {"plane", "periodic_box"} & scene.features:
            return "sphere-sphere contact with overlap is not the only interaction"
        alone = (
            all(isinstance(shape, Sphere) for shape in scene.bodies.shape)
            and 2 <= len(scene.bodies) <= MOST
        )
        if alone:
            return None
        return f"the scene does not have between 2 and {MOST} spheres"

    def needs(self, subject: Subject) -> tuple[Variant, ...]:
        """The plain run at the finest level."""
        return (subject.finest,)

    def judge(self, subject: Subject, runs: Mapping[Variant, CompletedRun]) -> list[Finding]:
        """Each channel against the state, in units of the length of the scene and of the largest
        force.
        """
        run = runs[subject.finest].trajectory
        meeting = _of_states(subject.instance.scene, run)
        length = subject.instance.scales.length
        rounded = _rounded_overlap(subject, run)
        peak = float(np.max(meeting.force))
        found = []
        if "overlap" in run.channels:
            off = np.abs(_largest(run, "overlap") - np.maximum(meeting.overlap, 0.0)) / length
            basis = "the channel must follow from the positions in the same row, to round-off"
            found.append(("overlap", run.t, off, np.full(len(off), rounded), basis))
        # At the touch rounding says whether a dashpot acts.
        told = np.abs(meeting.overlap) > rounded * length
        if "contact_force" in run.channels and peak > 0 and told.any():
            off, apart = _off_force(subject, run, meeting)
            allowed = np.full(len(off), _rounded_force(subject, run, meeting) + apart / peak)
            basis = (
                "the channel must follow from positions and velocities in the same row"
                " (or half a step earlier), to round-off"
            )
            found.append(("contact_force", run.t[told], off[told] / peak, allowed[told], basis))
        return [
            worst(
                check=self.name,
                quantity=name,
                t=t,
                values=values,
                allowed=allowed,
                unit="1",
                basis=basis,
                what=(
                    f"The difference between the reported {name.replace('_', ' ')} and the one"
                    " computed from the state, relative to its scale,"
                ),
            )
            for name, t, values, allowed, basis in found
        ]


def _largest(run: Trajectory, channel: str) -> Array:
    """The largest value of a channel at every sample (T,); pulls count as none."""
    largest: Array = np.maximum(run.channels[channel].reshape(len(run.t), -1).max(axis=1), 0.0)
    return largest


@dataclass(frozen=True)
class _Meeting:
    """What the rows say: the largest overlap (T,) [m], negative where none meet, and the largest
    forces (T,) [N] that press.

    `force` has the velocities of its row, `of_half_step(h)` those of half a step h before it.
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
        return self._pressing(np.ones_like(self.effective))

    def of_half_step(self, h: float) -> Array:
        """The largest force (T,) [N] with the velocities of half a step before, as a leapfrog has
        them.

        The pair closes faster then, by F h/2 over its effective mass: F = k d^e + c (v + F h/(2
        m)).
        """
        return self._pressing(1.0 - self.law.damping * h / (2 * self.effective))

    def _pressing(self, part: Array) -> Array:
        """The largest of the forces (T,) [N] of the law over a part (P,) of each, pulls counting as
        none.
        """
        depth = np.maximum(self.overlaps, 0.0)
        pressing = (
            self.law.stiffness * depth**self.law.exponent + self.law.damping * self.closing
        ) / part
        largest: Array = np.where(self.overlaps > 0, np.maximum(pressing, 0.0), 0.0).max(axis=1)
        return largest


def _of_states(scene: Scene, run: Trajectory) -> _Meeting:
    """What spheres do to each other as places and velocities say."""
    law = scene.all(Contact)[0]
    i, j = np.triu_indices(len(scene.bodies), 1)
    apart = run.position[:, j] - run.position[:, i]
    relative = run.velocity[:, i] - run.velocity[:, j]
    distance = np.linalg.norm(apart, axis=-1)
    radius = scene.bodies.radius
    inverse = np.where(scene.bodies.fixed, 0.0, 1.0 / scene.bodies.mass)
    with np.errstate(divide="ignore"):
        effective = 1.0 / (inverse[i] + inverse[j])
    return _Meeting(
        law,
        effective,
        radius[i] + radius[j] - distance,
        np.sum(relative * apart, axis=-1) / distance,
    )


def _off_force(subject: Subject, run: Trajectory, meeting: _Meeting) -> tuple[Array, float]:
    """How far (T,) [N] the force told is from that of the row, and by how much more [N] it may be
    off.

    A leapfrog takes the dashpot's velocities half a step before the row. Where two spheres meet and
    nothing else pulls them apart that is another number of the same row, and the nearer counts; in
    a crowd it is known to what half a step changes velocities by.
    """
    told = _largest(run, "contact_force")
    off = np.abs(told - meeting.force)
    if meeting.law.damping == 0 or subject.method.control != "step":
        return off, 0.0
    scene = subject.instance.scene
    level = subject.levels[-1]
    late = meeting.law.damping * level / float(np.min(meeting.effective))
    alone = all(isinstance(element, Contact | UniformGravity) for element in scene.elements)
    if len(scene.bodies) > 2 or not alone or late > 1.0:
        return off, late * float(np.max(meeting.force))
    return np.minimum(off, np.abs(told - meeting.of_half_step(level))), 0.0


def _rounded_overlap(subject: Subject, run: Trajectory) -> float:
    """Rounding of an overlap, in units of the length.

    R + R' - |d| is a difference of numbers as large as places and radii, each rounded, here and in
    the run.
    """
    reach = float(np.max(np.abs(run.position))) + 2 * float(
        np.max(subject.instance.scene.bodies.radius)
    )
    return (
        subject.round_off(subject.levels[-1])
        + 4 * subject.method.round_off * reach / subject.instance.scales.length
    )


def _rounded_force(subject: Subject, run: Trajectory, meeting: _Meeting) -> float:
    """Rounding of the force, in units of the largest: that of an overlap over the largest, and that
    of a dashpot's velocities.
    """
    length = subject.instance.scales.length
    of_overlap = (
        meeting.law.exponent
        * _rounded_overlap(subject, run)
        * length
        / float(np.max(meeting.overlap))
    )
    speed = float(np.max(np.abs(run.velocity)))
    of_speed = (
        8 * subject.method.round_off * meeting.law.damping * speed / float(np.max(meeting.force))
    )
    return subject.round_off(subject.levels[-1]) + of_overlap + of_speed


CHECK = ContactChannels()
