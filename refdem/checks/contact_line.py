"""Angular momentum about the line of contact of a body that slides or rolls: friction and the force
of the plane have no moment about it.
"""

from collections.abc import Mapping

import numpy as np

from refdem.checks._sphere_on_plane import (
    ROUNDED,
    gravity_of,
    moment,
    moment_of_gravity,
    slip_at_start,
    starts_on_plane,
)
from refdem.core.check import Check, CompletedRun, Subject
from refdem.core.finding import Finding
from refdem.core.judgement import Array, room_of, worst
from refdem.core.refinement import COUNTING_FLOOR, flight
from refdem.core.trajectory import Trajectory
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
        if not starts_on_plane(scene):
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
        """The coarsest level where the method claims to keep angular momentum; else the finest as
        well.
        """
        coarsest = Variant(subject.levels[0])
        if subject.keeps("angular-momentum"):
            return (coarsest,)
        return tuple(dict.fromkeys((coarsest, subject.finest)))

    def judge(self, subject: Subject, runs: Mapping[Variant, CompletedRun]) -> list[Finding]:
        """One finding: the moment, less that of gravity.

        The bound at the finest level is also what the coarsest level's excess implies with the
        claimed order.
        """
        variant = self.needs(subject)[-1]
        scene = subject.instance.scene
        run = runs[variant].trajectory
        claimed, basis = subject.kept("angular-momentum", variant.level)
        rounding = flight(subject.instance, subject.method, variant.level)
        allowed = claimed + rounding
        coarsest = subject.levels[0]
        # Extrapolated from the coarsest level: excess(h) = excess(h_0) (h/h_0)^p.
        if variant.level != coarsest and subject.method.control == "step":
            coarse = float(np.max(_excess(subject, runs[Variant(coarsest)].trajectory)))
            fallen = coarse * (variant.level / coarsest) ** subject.order
            floor = COUNTING_FLOOR * (subject.round_off(variant.level) + rounding)
            extrapolated = room_of(subject) * fallen + floor
            if np.any(extrapolated < allowed):
                basis = (
                    "truncation error extrapolated from the coarsest step with the claimed order"
                )
            allowed = np.minimum(allowed, extrapolated)
        # Friction changes J omega and R n x m v by opposite amounts. The signal is the change of
        # the first, |J (omega - omega_0)|/size.
        spun_up = scene.bodies.inertia[0, 0] * (run.omega[:, 0] - run.omega[0, 0])
        # The smallest positive number where nothing is exchanged: a signal of 0 would mark a law
        # that always decides (`Sight`), and here friction should act.
        exchanged = np.maximum(np.linalg.norm(spun_up, axis=1), np.finfo(float).tiny)
        signal: Array = exchanged / _size(subject)
        return [
            worst(
                check=self.name,
                quantity="moment",
                t=subject.instance.times,
                values=_excess(subject, run),
                allowed=allowed,
                signal=signal,
                unit="1",
                basis=f"contact forces have no moment about the line of contact: {basis}",
                what=(
                    "The change of angular momentum about the line of contact beyond that by"
                    " gravity, relative to m R |v| + J |omega|,"
                ),
            )
        ]


def _excess(subject: Subject, run: Trajectory) -> Array:
    """The change of the moment beyond that by gravity (T,), in units of `_size`."""
    scene = subject.instance.scene
    # |M(t) - M(0) - R n x m g t|/size,  M = R n x m v + J (omega - (omega.n) n).
    now = moment(scene, run.velocity[:, 0], run.omega[:, 0])
    elapsed = (run.t - run.t[0])[:, None]
    gained = now - now[0]
    excess: Array = np.linalg.norm(gained - elapsed * moment_of_gravity(scene), axis=1)
    return excess / _size(subject)


def _size(subject: Subject) -> float:
    """The scale m R |v| + J |omega| + |R n x m g| T of the moment [kg m^2/s], with v and omega at
    the start and the time T [s] of the last sample.
    """
    scene = subject.instance.scene
    bodies = scene.bodies
    orbital = float(bodies.mass[0] * bodies.radius[0] * np.linalg.norm(bodies.velocity[0]))
    spin = float(bodies.inertia[0, 0] * np.linalg.norm(bodies.omega[0]))
    gained = float(np.linalg.norm(moment_of_gravity(scene))) * subject.instance.times[-1]
    return orbital + spin + float(gained)


CHECK = ContactLine()
