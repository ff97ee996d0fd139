"""Angular momentum about the line of contact of a body that slides or rolls: friction and the force
of the plane have no moment about it.
"""

from collections.abc import Mapping

import numpy as np

from refdem.checks._lying import (
    ROUNDED,
    gravity_of,
    lies,
    moment,
    moment_of_gravity,
    slip_at_start,
)
from refdem.core.check import Check, CompletedRun, Subject
from refdem.core.finding import Finding
from refdem.core.judgement import Array, worst
from refdem.core.refinement import flight
from refdem.core.variant import Variant
from refdem.scene.elements.contact import Contact


class ContactLine(Check):
    """R n x m v + J omega grows by R n x m g t, however much friction there is, and whatever it
    does at the end of the slip.
    """

    name = "contact-line"
    title = "Angular momentum about the line of contact"
    kills = (
        "friction with another lever arm than the radius, a spin-up with the wrong moment of"
        " inertia, friction that turns a body and does not brake it"
    )
    synchronous = True

    def applies(self, subject: Subject) -> str | None:
        """None for one rigid sphere that lies on a plane, on which friction acts, else the
        reason.
        """
        scene = subject.instance.scene
        if not lies(scene):
            return "no rigid sphere lies on a plane"
        slip, _ = slip_at_start(scene)
        speed = float(np.linalg.norm(scene.bodies.velocity[0]))
        pressing = float(np.linalg.norm(gravity_of(scene)))
        slides = float(np.linalg.norm(slip)) > ROUNDED * speed
        is_level = float(np.linalg.norm(moment_of_gravity(scene))) <= ROUNDED * pressing
        if scene.all(Contact)[0].friction == 0 or (is_level and not slides):
            return "no friction acts"
        return None

    def needs(self, subject: Subject) -> tuple[Variant, ...]:
        """The coarsest level where the method claims to keep angular momentum, else the finest."""
        if subject.keeps("angular-momentum"):
            return (Variant(subject.levels[0]),)
        return (subject.finest,)

    def judge(self, subject: Subject, runs: Mapping[Variant, CompletedRun]) -> list[Finding]:
        """One finding: the moment, less that of gravity."""
        (variant,) = self.needs(subject)
        scene = subject.instance.scene
        run = runs[variant].trajectory
        now = moment(scene, run.velocity[:, 0], run.omega[:, 0])
        elapsed = (run.t - run.t[0])[:, None]
        gained = now - now[0]
        excess = np.linalg.norm(gained - elapsed * moment_of_gravity(scene), axis=1)
        claimed, basis = subject.kept("angular-momentum", variant.level)
        # Friction takes from m R v what it gives to J omega: how far either moves is the signal.
        normal_part = scene.bodies.inertia[0, 0] * (run.omega[:, 0] - run.omega[0, 0])
        signal: Array = np.linalg.norm(normal_part, axis=1) / _size(subject)
        return [
            worst(
                check=self.name,
                quantity="moment",
                t=subject.instance.times,
                values=excess / _size(subject),
                allowed=claimed + flight(subject.instance, subject.method, variant.level),
                signal=signal,
                unit="1",
                basis=f"contact forces have no moment about the line of contact: {basis}",
                what=(
                    "The change of angular momentum about the line of contact beyond that by"
                    " gravity, relative to m R |v| + J |omega|,"
                ),
            )
        ]


def _size(subject: Subject) -> float:
    """The sum of m R |v| and J |omega| at the start, and of what gravity makes of them in the run
    [kg m^2/s].
    """
    scene = subject.instance.scene
    bodies = scene.bodies
    orbital = float(bodies.mass[0] * bodies.radius[0] * np.linalg.norm(bodies.velocity[0]))
    spin = float(bodies.inertia[0, 0] * np.linalg.norm(bodies.omega[0]))
    gained = float(np.linalg.norm(moment_of_gravity(scene))) * subject.instance.times[-1]
    return orbital + spin + float(gained)


CHECK = ContactLine()
