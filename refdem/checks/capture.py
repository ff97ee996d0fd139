"""What a hook has caught goes round it: v = r omega, and J = m r^2 is what makes L = J omega."""

from collections.abc import Mapping

import numpy as np

from refdem.core.check import Check, CompletedRun, Subject
from refdem.core.finding import Finding
from refdem.core.judgement import Array, Sight, certified, judged, no_truth, undecided
from refdem.core.variant import Variant
from refdem.scene.elements.catch import Catch


class Capture(Check):
    """Between the samples after the catch: the rate of turning from the places, against v/r and
    against L/(m r^2).
    """

    name = "capture"
    title = "Captured mass"
    kills = (
        "a hook that lets the line slip or reels it in, that conserves momentum"
        " instead of angular momentum, or brakes what it catches"
    )
    synchronous = True

    def applies(self, subject: Subject) -> str | None:
        """Scenes with a hook of the world that truth says catches something."""
        if not any(hook.b < 0 for hook in subject.instance.scene.all(Catch)):
            return "the scene has no catch"
        if subject.truth is None or "omega" in subject.truth.scalars:
            return None
        return "no body is caught"

    def needs(self, subject: Subject) -> tuple[Variant, ...]:
        """The plain run at the finest level."""
        return (subject.finest,)

    def judge(self, subject: Subject, runs: Mapping[Variant, CompletedRun]) -> list[Finding]:
        """Rate of turning, v/omega against the distance, and L/omega against the moment of
        inertia.
        """
        truth = certified(subject)
        if truth is None:
            return [undecided(self.name, "omega", no_truth(subject))]
        run = runs[subject.finest].trajectory
        scene = subject.instance.scene
        hook = next(hook for hook in scene.all(Catch) if hook.b < 0)
        arm = run.position[:, hook.a] - np.array(hook.anchor_b)
        velocity = run.velocity[:, hook.a]
        distance = np.linalg.norm(arm, axis=1)
        caught = np.flatnonzero(
            np.abs(np.sum(arm * velocity, axis=1))
            < 1e-3 * distance * np.linalg.norm(velocity, axis=1)
        )
        if len(caught) < 3 or len(caught) < len(run.t) - caught[0]:
            return [
                undecided(
                    self.name,
                    "omega",
                    ("fewer than three samples follow the catch, or the body is not held after it"),
                )
            ]
        first = caught[0] + 1
        bound = float(subject.bound(subject.levels[-1])[-1])
        rate = _rate(arm[first:], run.velocity[first:, hook.a], run.t[first:])
        omega = truth.scalars["omega"][0]
        inertia = truth.scalars["inertia"][0]
        spin = scene.bodies.mass[hook.a] * np.linalg.norm(np.cross(arm[-1], velocity[-1]))
        values = {
            "omega": (
                rate / omega - 1,
                (
                    "The relative error of the angular velocity after the catch, compared"
                    " with v/r at the catch,"
                ),
            ),
            "speed": (
                np.linalg.norm(velocity[-1]) / (rate * distance[-1]) - 1,
                "The deviation of the final v/(r omega) from 1",
            ),
            "inertia": (
                spin / rate / inertia - 1,
                "The relative error of L/omega, compared with m r^2,",
            ),
        }
        return [
            judged(
                check=self.name,
                quantity=name,
                value=abs(float(value)),
                bound=bound,
                sight=Sight(bound, 1.0),
                unit="1",
                basis="the error bound of the state at the end of the run",
                what=what,
            )
            for name, (value, what) in values.items()
        ]


def _rate(arm: Array, velocity: Array, t: Array) -> float:
    """Angle turned from the first to the last sample over the time [rad/s].

    What remains of each step beyond whole turns comes from the places alone; how many whole turns a
    coarse sampling hides, from v/r.
    """
    normal = np.cross(arm[0], velocity[0])
    normal = normal / (np.linalg.norm(normal) or 1.0)
    sine = np.cross(arm[:-1], arm[1:]) @ normal
    cosine = np.sum(arm[:-1] * arm[1:], axis=1)
    angle = np.arctan2(sine, cosine)
    expected = np.linalg.norm(velocity[:-1], axis=1) / np.linalg.norm(arm[:-1], axis=1) * np.diff(t)
    return float(
        np.sum(angle + 2 * np.pi * np.round((expected - angle) / (2 * np.pi))) / (t[-1] - t[0])
    )


CHECK = Capture()
