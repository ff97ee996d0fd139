"""Circular motion after a capture, with v = r omega and L = J omega, J = m r^2.

The hook holds the mass at its distance r at the catch. Angular momentum L about the hook is that
before the catch.
"""

from collections.abc import Mapping

import numpy as np

from refdem.core.check import Check, CompletedRun, Subject
from refdem.core.finding import Finding
from refdem.core.judgement import Array, Sight, certified, judged, no_truth, undecided
from refdem.core.variant import Variant
from refdem.scene.elements.catch import Catch


class Capture(Check):
    """After the capture, omega from the positions agrees with truth, with v/r and with L/(m
    r^2).
    """

    name = "capture"
    title = "Captured mass"
    kills = (
        "a hook that lets the line slip or reels it in, that conserves momentum"
        " instead of angular momentum, or brakes what it catches"
    )
    synchronous = True

    def applies(self, subject: Subject) -> str | None:
        """Scenes with a hook fixed to the world, that catches a mass according to truth."""
        if not any(hook.b < 0 for hook in subject.instance.scene.all(Catch)):
            return "the scene has no catch"
        if subject.truth is None or "omega" in subject.truth.scalars:
            return None
        return "no body is caught"

    def needs(self, subject: Subject) -> tuple[Variant, ...]:
        """The plain run at the finest level."""
        return (subject.finest,)

    def judge(self, subject: Subject, runs: Mapping[Variant, CompletedRun]) -> list[Finding]:
        """Three findings: omega against truth, v/(r omega) against 1, and L/omega against m r^2."""
        truth = certified(subject)
        if truth is None:
            return [undecided(self.name, "omega", no_truth(subject))]
        run = runs[subject.finest].trajectory
        scene = subject.instance.scene
        hook = next(hook for hook in scene.all(Catch) if hook.b < 0)
        arm = run.position[:, hook.a] - np.array(hook.anchor_b)
        velocity = run.velocity[:, hook.a]
        caught = np.flatnonzero(_is_circling(arm, velocity))
        if len(caught) < 3 or len(caught) < len(run.t) - caught[0]:
            why = "fewer than three samples follow the catch, or the body is not held after it"
            return [undecided(self.name, "omega", why)]
        first = caught[0] + 1
        omega_run = _rate(arm[first:], velocity[first:], run.t[first:])
        omega = truth.scalars["omega"][0]
        inertia = truth.scalars["inertia"][0]
        # At the end of the run: r, v and L = m |r x v|.
        # speed: v/(r omega) = 1;   inertia: L/omega = m r^2.
        distance = np.linalg.norm(arm, axis=1)[-1]
        speed = np.linalg.norm(velocity[-1])
        angular_momentum = scene.bodies.mass[hook.a] * np.linalg.norm(
            np.cross(arm[-1], velocity[-1])
        )
        return [
            self._error(
                subject,
                "omega",
                omega_run / omega - 1,
                (
                    "The relative error of the angular velocity after the catch, compared"
                    " with v/r at the catch,"
                ),
            ),
            self._error(
                subject,
                "speed",
                speed / (omega_run * distance) - 1,
                "The deviation of the final v/(r omega) from 1",
            ),
            self._error(
                subject,
                "inertia",
                angular_momentum / omega_run / inertia - 1,
                "The relative error of L/omega, compared with m r^2,",
            ),
        ]

    def _error(self, subject: Subject, quantity: str, error: float, what: str) -> Finding:
        """The finding on one relative error, against the state's bound at the end of the run."""
        bound = float(subject.bound(subject.levels[-1])[-1])
        return judged(
            check=self.name,
            quantity=quantity,
            value=abs(float(error)),
            bound=bound,
            sight=Sight(bound, 1.0),
            unit="1",
            basis="the error bound of the state at the end of the run",
            what=what,
        )


def _is_circling(arm: Array, velocity: Array) -> Array:
    """True (T,) where r.v = 0 to a part in 1000: on the circle, not on the line before it."""
    # |r . v| < 1e-3 |r| |v|.
    radial = np.abs(np.sum(arm * velocity, axis=1))
    distance = np.linalg.norm(arm, axis=1)
    is_circling: Array = radial < 1e-3 * distance * np.linalg.norm(velocity, axis=1)
    return is_circling


def _rate(arm: Array, velocity: Array, t: Array) -> float:
    """Mean angular velocity [rad/s]: the angle turned from the first to the last sample over the
    time.

    Positions give the angle between two samples modulo 2 pi; v/r gives how many whole turns a
    coarse sampling leaves out.
    """
    # Angles are counted about the normal r x v of the plane of motion.
    normal = np.cross(arm[0], velocity[0])
    normal = normal / (np.linalg.norm(normal) or 1.0)
    # Angle from r to r': atan2(n . (r x r'), r . r'), modulo 2 pi.
    sine = np.cross(arm[:-1], arm[1:]) @ normal
    cosine = np.sum(arm[:-1] * arm[1:], axis=1)
    angle = np.arctan2(sine, cosine)
    # The angle |v|/|r| dt, accurate enough to count whole turns.
    expected = np.linalg.norm(velocity[:-1], axis=1) / np.linalg.norm(arm[:-1], axis=1) * np.diff(t)
    whole_turns = 2 * np.pi * np.round((expected - angle) / (2 * np.pi))
    # omega = sum of (angle + 2 pi turns) over (t_last - t_first).
    return float(np.sum(angle + whole_turns) / (t[-1] - t[0]))


CHECK = Capture()
