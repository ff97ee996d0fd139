"""Impacts of rigid spheres with each other and with planes against the law: restitution, an impulse
in the friction cone, the friction and the change of spins.

A single impact needs no truth. Of impacts in sequence the certified list gives the bodies and the
times; each impact is judged between the samples around it (_impulses.py).
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from refdem.checks._crossings import closing_speed, crossings, is_impact
from refdem.checks._impacts import Impact, dense_variant, is_sequence, listed, windows
from refdem.checks._impulses import Struck, bodies_of, by_law, off, pulls, spin_noise, struck
from refdem.checks.event_times import late_by
from refdem.core.check import Array, Check, CompletedRun, Subject
from refdem.core.finding import Finding
from refdem.core.judgement import Sight, certified, judged, no_truth, undecided
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

TURNED = "up to the rotation of the normal in a step that detects the impact late"


@dataclass(frozen=True)
class Exchange:
    """The change by one impact: the speeds along the normal at which the bodies close and part
    [m/s], and the impulse on the first one along (`pressing`) and across (`rubbing`) it [N s].

    `approach` is the relative speed of the centres before the impact, `speeds` the sum of the
    speeds that enter with their rounding errors [m/s].
    """

    approach: float
    speeds: float
    closing: float
    parting: float
    pressing: float
    rubbing: float


class RigidImpact(Check):
    """The samples before and after an impact, compared with the law.

    For a single impact these are the first and the last sample, and no truth is needed. The normal
    is that at the contact of free flights along straight lines from the first sample. Nothing but
    the impact acts, so that every method is exact before and after it: there is no truncation
    error. A method that applies the impact at the end of a step h does so up to h V beyond the
    contact, where the normal between two spheres has turned by up to a = h V/R. So the error of an
    impulse, which is at most 4 V m_n, is at most 4 V m_n a (1 + a). Of a sequence every impact is
    judged that two samples isolate.
    """

    name = "rigid-impact"
    title = "Impulse of an impact"
    kills = (
        "restitution applied twice, below a threshold, not at all or only in some impacts, friction"
        " beyond its limit, a pair met twice or never"
    )
    synchronous = True

    def applies(self, subject: Subject) -> str | None:
        """Two free spheres that close under the rigid law, or one and a plane; more of them where
        truth has the list of their impacts.
        """
        scene = subject.instance.scene
        if not is_impact(scene):
            if not is_sequence(scene):
                return "the scene is neither two rigid spheres nor one and a plane"
            if certified(subject) and not _list(subject):
                return "the certified truth has no list of impacts"
            return None
        closing, _ = closing_speed(scene)
        if closing > 0:
            return None
        return "the spheres do not close"

    def needs(self, subject: Subject) -> tuple[Variant, ...]:
        """The plain run at the finest level; for a sequence also with samples so dense that impacts
        come alone.
        """
        if is_impact(subject.instance.scene):
            return (subject.finest,)
        return tuple(dict.fromkeys((subject.finest, dense_variant(subject))))

    def judge(self, subject: Subject, runs: Mapping[Variant, CompletedRun]) -> list[Finding]:
        """Restitution, and with friction the cone."""
        scene = subject.instance.scene
        run = runs[subject.finest].trajectory
        if not is_impact(scene):
            return _in_sequence(subject, run, runs[dense_variant(subject)].trajectory)
        found = exchange(scene, run)
        if found is None:
            return [undecided(self.name, "restitution", "no impact is due before the last sample")]
        speed = subject.instance.scales.speed
        fastest = _fastest(scene)
        turned = _turn_of_normal(subject, fastest)
        rounding = subject.noise(subject.levels[-1]) * found.speeds
        # Error of a speed along the normal, with the relative speed w and the closing speed c:
        #   off = 4 V a (1 + a) + u sum |v| max(1, w/c).
        # In a grazing impact a rounding of positions turns the normal by w/c times as much.
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
        # (|p_t| - mu p_n)/(m V), positive outside the cone
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
        observed = found.parting / found.closing
        return judged(
            check=self.name,
            quantity="restitution",
            value=abs(observed - given),
            bound=allowed,
            sight=Sight(allowed, 1 + given),
            unit="1",
            basis=f"the speeds along the normal are those of the law, {TURNED}",
            what=(
                f"The error of the restitution ({observed:.12g} observed, {given:.12g} by the law)"
            ),
        )


def _list(subject: Subject) -> list[Impact]:
    """The certified impacts; none without truth."""
    if subject.truth is None:
        return []
    return listed(subject.truth.scalars)


@dataclass(frozen=True)
class Departure:
    """The deviation of one impact from the law, and its bound for a correct method [1].

    `words` state the observed value or the time, for the finding.
    """

    value: float
    bound: float
    words: str

    @property
    def share(self) -> float:
        """The value over its bound."""
        return self.value / self.bound


Measure = Callable[[Subject, Trajectory, Struck], Departure]


def _in_sequence(subject: Subject, plain: Trajectory, run: Trajectory) -> list[Finding]:
    """The impacts of the certified list, each by its impulse; one finding for each part of it.

    The plain run gives the bounds on the times of the impacts, `run`, with denser samples, the
    velocities around them.
    """
    truth = certified(subject)
    if truth is None:
        return [undecided("rigid-impact", "restitution", no_truth(subject))]
    scene = subject.instance.scene
    known = crossings(subject, truth)["contact"]
    alone = windows(truth, run, late_by(subject, truth, known, plain))
    measured = [found for window in alone if (found := struck(scene, run, window)) is not None]
    findings = [
        _worst_of(subject, run, measured, "restitution", _restitution_of, "the restitution"),
    ]
    if scene.all(Contact)[0].friction > 0:
        findings.append(
            _worst_of(subject, run, measured, "friction", _friction_of, "the tangential impulse")
        )
        findings.append(_worst_of(subject, run, measured, "spin", _spin_of, "the change of spins"))
    return findings


def _worst_of(
    subject: Subject,
    run: Trajectory,
    measured: list[Struck],
    quantity: str,
    measure: Measure,
    noun: str,
) -> Finding:
    """The finding on the impact with the largest ratio of value to bound; undecided if all bounds
    exceed HORIZON.
    """
    departures = [measure(subject, run, found) for found in measured if found.closing > 0]
    sharp = [one for one in departures if one.bound <= HORIZON]
    total = len(_list(subject))
    if not sharp:
        why = (
            f"none of {total} impacts is alone between two samples with a closing speed known to"
            " 10 %; smaller steps or more samples are needed"
        )
        return undecided("rigid-impact", quantity, why)
    worst = max(sharp, key=lambda one: one.share)
    return judged(
        check="rigid-impact",
        quantity=quantity,
        value=worst.value,
        bound=worst.bound,
        sight=Sight(worst.bound, 1.0),
        unit="1",
        basis=(
            "velocities before and after the impact follow from free flight; what remains is"
            " round-off, and the effect of gravity or of the rotation of the normal in a step that"
            " detects the impact late"
        ),
        what=(
            f"The error of {noun}, the largest of {len(sharp)} impacts of {total} ({worst.words}),"
        ),
    )


def _restitution_of(subject: Subject, run: Trajectory, found: Struck) -> Departure:
    """The parting speed over the closing speed c, compared with the restitution e of the law."""
    # |parting/c - e| <= (1 + e) off/c:  both speeds are off by at most `off`.
    given = subject.instance.scene.all(Contact)[0].restitution
    ratio = found.parting / found.closing
    along, _ = pulls(subject.instance.scene, found)
    bound = (1.0 + given) * off(subject, run, found, along) / found.closing
    words = (
        f"{ratio:.12g} observed at t = {found.window.impact.time:.6g} s, {given:.12g} by the law"
    )
    return Departure(abs(ratio - given), bound, words)


def _friction_of(subject: Subject, run: Trajectory, found: Struck) -> Departure:
    """The impulse P_t across the normal compared with that of the law, in units of effective mass
    times closing speed, m_n c.

    The law projects the impulse -(1 + b) m_t s on the friction cone |P_t| <= mu (1 + e) m_n c,
    where s is the slip and b the slip restitution. A projection on a ball does not increase
    distances, so an error of s enters with a factor of at most (1 + b) m_t, and an error of c with
    a factor of at most mu (1 + e) m_n.
    """
    scene = subject.instance.scene
    law = scene.all(Contact)[0]
    bodies = bodies_of(scene, found.window)
    unit = bodies.normal_mass * found.closing
    # |P - (P.n) n - P_law|/(m_n c)
    across = found.impulse - float(found.impulse @ found.normal) * found.normal
    departure = float(np.linalg.norm(across - by_law(scene, found))) / unit
    # ((1 + b) m_t + mu (1 + e) m_n) (error of a speed)
    carried = (1.0 + law.slip_restitution) * bodies.tangential_mass
    carried += law.friction * (1.0 + law.restitution) * bodies.normal_mass
    along, across_normal = pulls(scene, found)
    spinning = spin_noise(subject) * found.fastest
    by_slip = carried * (off(subject, run, found, along + across_normal) + spinning)
    # The observed impulse is m_1 times a difference of two velocities.
    by_speeds = 2.0 * float(bodies.mass[0]) * off(subject, run, found, across_normal)
    return Departure(departure, (by_slip + by_speeds) / unit, _when(found))


def _spin_of(subject: Subject, run: Trajectory, found: Struck) -> Departure:
    """J times the change of omega against the moment R n x P of the observed impulse, in units of R
    times effective mass times the closing speed.

    The moment is the same for both bodies: the lever arm and the impulse of the second one are both
    of opposite sign.
    """
    scene = subject.instance.scene
    bodies = bodies_of(scene, found.window)
    unit = bodies.normal_mass * found.closing * bodies.radius
    # |J_i dw_i - R_i n x P|/(R_i m_n c)
    moment = bodies.radius[:, None] * np.cross(found.normal, found.impulse)
    departure = float(np.max(np.linalg.norm(found.spun - moment, axis=1) / unit))
    # u J_i (|w_i| before + |w_i| after)/(R_i m_n c), and 2 m_1 (error of a speed)/(m_n c)
    numbers = list(found.window.impact.bodies)
    rows = [found.window.first, found.window.last]
    omega = np.linalg.norm(run.omega[rows][:, numbers], axis=-1).sum(axis=0)
    rounded = spin_noise(subject) * float(np.max(bodies.inertia * omega / unit))
    _, across = pulls(scene, found)
    speeds = 2.0 * float(bodies.mass[0]) * off(subject, run, found, across)
    bound = rounded + speeds / float(bodies.normal_mass * found.closing)
    return Departure(departure, bound, _when(found))


def _when(found: Struck) -> str:
    """The certified time of an impact, in words."""
    return f"the one at t = {found.window.impact.time:.6g} s"


def _fastest(scene: Scene) -> float:
    """V = |v_12| + sum R_i |omega_i| [m/s]: a bound on relative speeds of surface points."""
    bodies = scene.bodies
    relative = bodies.velocity[0]
    if len(bodies) == 2:
        relative = relative - bodies.velocity[1]
    surfaces = bodies.radius * np.linalg.norm(bodies.omega, axis=1)
    return float(np.linalg.norm(relative) + surfaces.sum())


def _turn_of_normal(subject: Subject, fastest: float) -> float:
    """The angle a = h V/R [rad] by which the normal turns in a step h, with the sum R of the radii.

    It is the error of the normal if the impact is applied at the end of a step. For a plane, and
    where events are located, it is 0.
    """
    scene = subject.instance.scene
    method = subject.method
    if scene.all(Plane) or method.control != "step" or method.locates_events:
        return 0.0
    return subject.levels[-1] * fastest / float(scene.bodies.radius.sum())


def exchange(scene: Scene, run: Trajectory) -> Exchange | None:
    """The change by the impact from the first sample to the last; None without an impact between.

    Its time and normal follow from free flight along straight lines from the first sample.
    """
    meeting = _meeting(scene, run)
    if meeting is None:
        return None
    normal, when = meeting
    if not when < run.t[-1] - run.t[0]:
        return None
    masses = scene.bodies.mass
    relative = [_relative(run, row) for row in (0, -1)]
    # P = m_1 dv_1,  pressing = -P.n,  rubbing = |P - (P.n) n|
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
    """The velocity (3,) of the first sphere relative to the second, or to a plane."""
    velocity: Array = run.velocity[row, 0]
    if run.velocity.shape[1] == 2:
        velocity = velocity - run.velocity[row, 1]
    return velocity


def _meeting(scene: Scene, run: Trajectory) -> tuple[Array, float] | None:
    """The unit normal (3,), away from the first sphere, and the time [s] after the first sample of
    the impact by free flight; None if the bodies do not meet.
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
