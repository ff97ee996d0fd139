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
from refdem.core.refinement import HORIZON
from refdem.core.trajectory import Trajectory
from refdem.core.variant import Variant
from refdem.scene import Scene
from refdem.scene.elements.contact import Contact
from refdem.scene.elements.plane import Plane

SIDES = 4.0
"""An impulse per effective mass is at most 2 V along the normal and 2 V across it, where V is the
largest speed at which points of the surfaces can meet.
"""

TURNED = "off by at most what the normal turns within a step that sees the impact late"


@dataclass(frozen=True)
class Exchange:
    """What one impact changed: the speed along the normal at which the bodies close and part
    [m/s], and the impulse on the first one along and across the normal [N s].

    `approach` is their relative speed before, `speeds` the sum of all speeds whose rounding counts
    [m/s].
    """

    approach: float
    speeds: float
    closing: float
    parting: float
    pressing: float
    rubbing: float


class RigidImpact(Check):
    """The first and the last sample of one impact, laid beside the law, without any truth.

    The normal is where straight lines from the first sample meet. Nothing but the impact acts, so
    that every method is exact up to it and after it: there is no truncation error. A method that
    sees the impact at the end of a step h sees it up to h V beyond, where the normal between two
    spheres has turned by up to a = h V/R. So an impulse, which is at most 4 V m_n, is off by at
    most 4 V m_n a (1 + a).
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
        found = exchange(scene, run)
        if found is None:
            return [undecided(self.name, "restitution", "no impact is due before the last sample")]
        speed = subject.instance.scales.speed
        fastest = _fastest(scene)
        turned = _turn_of_normal(subject, fastest)
        rounding = subject.noise(subject.levels[-1]) * found.speeds
        # A place that is rounded turns the normal by more where spheres nearly pass each other.
        steep = max(1.0, found.approach / found.closing)
        off = SIDES * fastest * turned * (1 + turned) + rounding * steep
        allowed = off / found.closing
        if allowed > HORIZON:
            why = (
                "the normal may turn so far within a step that the restitution changes by more than"
                " a tenth; smaller steps are needed"
            )
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
                bound=off / speed * (1 + law.friction),
                unit="1",
                basis=f"|p_t| <= mu p_n, {TURNED}",
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
            basis=f"the speeds along the normal are those of the law, {TURNED}",
            what=f"The error of the restitution ({seen:.12g} is seen, the law says {given:.12g})",
        )


def _fastest(scene: Scene) -> float:
    """V [m/s]: the relative speed of the centres and the speeds of the surfaces about them."""
    bodies = scene.bodies
    relative = bodies.velocity[0]
    if len(bodies) == 2:
        relative = relative - bodies.velocity[1]
    surfaces = bodies.radius * np.linalg.norm(bodies.omega, axis=1)
    return float(np.linalg.norm(relative) + surfaces.sum())


def _turn_of_normal(subject: Subject, fastest: float) -> float:
    """The angle [rad] by which the normal may be off because the impact is seen late."""
    scene = subject.instance.scene
    method = subject.method
    if scene.all(Plane) or method.control != "step" or method.locates_events:
        return 0.0
    return subject.levels[-1] * fastest / float(scene.bodies.radius.sum())


def exchange(scene: Scene, run: Trajectory) -> Exchange | None:
    """What the impact changed from the first sample to the last; None if none is due by then.

    Until it is due, and with what velocity, follows from the first sample by straight lines.
    """
    meeting = _meeting(scene, run)
    if meeting is None:
        return None
    normal, when = meeting
    if not when < run.t[-1] - run.t[0]:
        return None
    masses = scene.bodies.mass
    relative = [_relative(run, row) for row in (0, -1)]
    impulse = masses[0] * (run.velocity[-1, 0] - run.velocity[0, 0])
    pressing = -float(impulse @ normal)
    rubbing = float(np.linalg.norm(impulse + pressing * normal))
    return Exchange(
        approach=float(np.linalg.norm(relative[0])),
        speeds=float(np.linalg.norm(run.velocity[[0, -1]], axis=-1).sum()),
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


def _meeting(scene: Scene, run: Trajectory) -> tuple[Array, float] | None:
    """The unit normal (3,) from the first sphere on and the time [s] after the first sample at
    which they meet; None if the first sample shows nothing that comes nearer.
    """
    bodies = scene.bodies
    for plane in scene.all(Plane):
        away = np.array(plane.normal)
        height = float((run.position[0, 0] - np.array(plane.point)) @ away) - bodies.radius[0]
        descent = -float(run.velocity[0, 0] @ away)
        if not descent > 0:
            return None
        return -away, height / descent
    apart = run.position[0, 1] - run.position[0, 0]
    relative = run.velocity[0, 1] - run.velocity[0, 0]
    nearing = -float(apart @ relative)
    if not nearing > 0:
        return None
    reach = float(bodies.radius.sum())
    swept = np.cross(apart, relative)
    # t = c/(-b + sqrt(q)) with b = d.w < 0, c = (|d| - R)(|d| + R), q = w^2 R^2 - |d x w|^2.
    distance = float(np.linalg.norm(apart))
    q = reach**2 * float(relative @ relative) - float(swept @ swept)
    if not q > 0:
        # They pass each other.
        return None
    gap = (distance - reach) * (distance + reach)
    when = gap / (np.sqrt(q) + nearing)
    normal = (apart + when * relative) / reach
    return normal, float(when)


CHECK = RigidImpact()
