"""What two rigid spheres do to each other when they meet: restitution out against restitution in,
an impulse in the friction cone, energy that is never gained.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from refdem.checks._crossings import closing_speed, is_impact
from refdem.core.check import Array, Check, CompletedRun, Subject
from refdem.core.finding import Finding
from refdem.core.judgement import Sight, judged, undecided
from refdem.core.refinement import HORIZON, ROUND_OFF_FACTOR
from refdem.core.trajectory import Trajectory
from refdem.core.variant import Variant
from refdem.scene import Scene
from refdem.scene.elements.contact import Contact
from refdem.scene.elements.plane import Plane

SIDES = 4.0
"""Errors of velocities that add to one of a relative velocity: of both bodies, before and after."""


@dataclass(frozen=True)
class Exchange:
    """What one impact changed: the speed along the normal at which the bodies close and part
    [m/s], and the impulse on the first one along and across the normal [N s].
    """

    closing: float
    parting: float
    pressing: float
    rubbing: float


class RigidImpact(Check):
    """The first and the last sample of one impact, laid beside the law, without any truth.

    The normal is where straight lines from the first sample meet. An error E of the state, in its
    scales, is one of at most 4 E in a relative velocity, and turns the normal by at most as much
    again.
    """

    name = "rigid-impact"
    title = "Impulse of an impact"
    kills = (
        "restitution applied twice, below a threshold or not at all, friction beyond its limit, a"
        " pair met twice or never"
    )
    synchronous = True

    def applies(self, subject: Subject) -> str | None:
        """Two free spheres that close under the rigid law, or one and a plane."""
        scene = subject.instance.scene
        if not is_impact(scene):
            return "the scene is neither two rigid spheres nor one and a plane"
        closing, _ = closing_speed(scene)
        if closing > 0:
            return None
        return "the spheres do not close"

    def needs(self, subject: Subject) -> tuple[Variant, ...]:
        """The plain run at the finest level."""
        return (subject.finest,)

    def judge(self, subject: Subject, runs: Mapping[Variant, CompletedRun]) -> list[Finding]:
        """Restitution, and with friction the cone."""
        scene = subject.instance.scene
        run = runs[subject.finest].trajectory
        error = float(np.max(subject.bound(subject.levels[-1])))
        rounding = ROUND_OFF_FACTOR * subject.method.round_off
        found = exchange(scene, run)
        if found is None:
            return [undecided(self.name, "restitution", "no impact is due before the last sample")]
        speed = subject.instance.scales.speed
        allowed = 2 * SIDES * (error + rounding) * speed / found.closing
        if allowed > HORIZON:
            why = "an error within the bound changes the restitution by more than a tenth"
            return [undecided(self.name, "restitution", why)]
        findings = [self._restitution(scene, found, allowed)]
        law = scene.all(Contact)[0]
        mass = subject.instance.scales.mass
        beyond = max(0.0, found.rubbing - law.friction * found.pressing) / (mass * speed)
        findings.append(
            judged(
                check=self.name,
                quantity="cone",
                value=beyond,
                bound=allowed * found.closing / speed * (1 + law.friction),
                unit="1",
                basis=(
                    "|p_t| <= mu p_n, and an error within the bound on the state changes both"
                    " impulses by at most that"
                ),
                what=(
                    "The tangential impulse in excess of mu times the normal one, in units of"
                    " effective mass times speed,"
                ),
            )
        )
        return findings

    def _restitution(self, scene: Scene, found: Exchange, allowed: float) -> Finding:
        """The parting speed over the closing speed, against the law's."""
        given = scene.all(Contact)[0].restitution
        seen = found.parting / found.closing
        return judged(
            check=self.name,
            quantity="restitution",
            value=abs(seen - given),
            bound=allowed,
            sight=Sight(allowed, 1 + given),
            unit="1",
            basis=(
                "an error within the bound on the state changes the speeds along the normal by at"
                " most that"
            ),
            what=f"The error of the restitution ({seen:.12g} is seen, the law says {given:.12g})",
        )


def exchange(scene: Scene, run: Trajectory) -> Exchange | None:
    """What the impact changed from the first sample to the last; None if none is due by then.

    Until it is due, and with what velocity, follows from the first sample by straight lines.
    """
    normal, when = _meeting(scene, run)
    if not when < run.t[-1] - run.t[0]:
        return None
    masses = scene.bodies.mass
    relative = [_relative(run, row) for row in (0, -1)]
    impulse = masses[0] * (run.velocity[-1, 0] - run.velocity[0, 0])
    pressing = -float(impulse @ normal)
    rubbing = float(np.linalg.norm(impulse + pressing * normal))
    return Exchange(
        closing=float(relative[0] @ normal),
        parting=-float(relative[1] @ normal),
        pressing=pressing,
        rubbing=rubbing,
    )


def _relative(run: Trajectory, row: int) -> Array:
    """The velocity (3,) of the first sphere against the second, or against a plane."""
    velocity: Array = run.velocity[row, 0]
    if run.velocity.shape[1] == 2:
        velocity = velocity - run.velocity[row, 1]
    return velocity


def _meeting(scene: Scene, run: Trajectory) -> tuple[Array, float]:
    """The unit normal (3,) from the first sphere on and the time [s] after the first sample at
    which they meet.
    """
    bodies = scene.bodies
    for plane in scene.all(Plane):
        away = np.array(plane.normal)
        height = float((run.position[0, 0] - np.array(plane.point)) @ away) - bodies.radius[0]
        return -away, height / -float(run.velocity[0, 0] @ away)
    apart = run.position[0, 1] - run.position[0, 0]
    relative = run.velocity[0, 1] - run.velocity[0, 0]
    reach = float(bodies.radius.sum())
    swept = np.cross(apart, relative)
    # t = c/(-b + sqrt(q)) with b = d.w, c = (|d| - R)(|d| + R), q = w^2 R^2 - |d x w|^2.
    distance = float(np.linalg.norm(apart))
    q = reach**2 * float(relative @ relative) - float(swept @ swept)
    gap = (distance - reach) * (distance + reach)
    when = gap / (np.sqrt(max(q, 0.0)) - float(apart @ relative))
    normal = (apart + when * relative) / reach
    return normal, float(when)


CHECK = RigidImpact()
