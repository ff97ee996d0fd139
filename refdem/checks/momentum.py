"""Momentum of an isolated scene is constant, since action equals reaction at every step; under
gravity it changes between impacts by the impulse of the weight alone.

    sum m_i v_i(t) = sum m_i v_i(0)     isolated scene, or the two bodies of one impact
    v_i(t') - v_i(t) = g (t' - t)       a body in free fall from t to t'
"""

from collections.abc import Mapping

import numpy as np

from refdem.checks._crossings import crossings
from refdem.checks._impacts import dense_variant, falling, is_sequence, listed, windows
from refdem.checks._impulses import bodies_of
from refdem.checks.event_times import late_by
from refdem.core.balance import linear, momentum_scale
from refdem.core.check import Array, Check, CompletedRun, Subject
from refdem.core.finding import Finding
from refdem.core.judgement import certified, no_truth, undecided, worst
from refdem.core.refinement import sweeping
from refdem.core.trajectory import Trajectory
from refdem.core.truth import SampledTruth
from refdem.core.variant import Variant
from refdem.scene.elements.contact import Contact


class Momentum(Check):
    """Total momentum is constant to round-off at the coarsest level, where a small step hides
    nothing.

    In scenes of successive impacts the momentum of the two bodies of each impact is constant
    through it, relative to the impulse that they exchange, and the velocity of a falling body
    changes by g t between two impacts.
    """

    name = "momentum"
    title = "Momentum"
    kills = (
        "a contact force applied to one body only, a lost mass, velocities exchanged between"
        " bodies, a reaction on the wrong one, a drag that the scene does not have"
    )

    def applies(self, subject: Subject) -> str | None:
        """None for isolated scenes and for impacts of bodies that fall, else the reason why not."""
        scene = subject.instance.scene
        if scene.is_isolated() or _falls_between_impacts(subject):
            return None
        return "an external force acts, so momentum is not conserved"

    def needs(self, subject: Subject) -> tuple[Variant, ...]:
        """The plain run at the coarsest level; at the finest one for successive impacts."""
        needed = []
        if subject.instance.scene.is_isolated():
            needed.append(Variant(subject.levels[0]))
        if _falls_between_impacts(subject):
            needed.append(subject.finest)
        if _meets_in_sequence(subject):
            needed += [subject.finest, dense_variant(subject)]
        return tuple(dict.fromkeys(needed))

    def judge(self, subject: Subject, runs: Mapping[Variant, CompletedRun]) -> list[Finding]:
        """The largest change of total momentum; for successive impacts also that of each pair of
        bodies and the departure of each flight from free fall.
        """
        findings = []
        if subject.instance.scene.is_isolated():
            findings.append(_of_total(subject, runs[Variant(subject.levels[0])].trajectory))
        if _meets_in_sequence(subject):
            plain = runs[subject.finest].trajectory
            findings += _of_pairs(subject, plain, runs[dense_variant(subject)].trajectory)
        if _falls_between_impacts(subject):
            findings.append(_in_flights(subject, runs[subject.finest].trajectory))
        return findings


def _meets_in_sequence(subject: Subject) -> bool:
    """True if truth lists the impacts of free spheres on which nothing else acts."""
    truth = certified(subject)
    scene = subject.instance.scene
    return (
        truth is not None
        and scene.is_isolated()
        and is_sequence(scene)
        and bool(listed(truth.scalars))
    )


def _falls_between_impacts(subject: Subject) -> bool:
    """True for impacts of spheres under gravity, listed by truth if there is one."""
    scene = subject.instance.scene
    if not is_sequence(scene) or not np.any(falling(scene)):
        return False
    truth = certified(subject)
    return truth is None or bool(listed(truth.scalars))


def _of_total(subject: Subject, run: Trajectory) -> Finding:
    """The largest change of total momentum, in units of the initial sum of m |v|."""
    # |sum m v(t) - sum m v(0)| / sum m |v(0)|.
    total = linear(subject.instance.scene, run)
    change = np.linalg.norm(total - total[0], axis=1)
    rounding = subject.round_off(subject.levels[0]) * sweeping(subject.instance, subject.method)
    return worst(
        check=Momentum.name,
        quantity="total",
        t=subject.instance.times,
        values=change / momentum_scale(subject.instance),
        allowed=rounding * _in_slow_motion(subject),
        signal=_exchanged(subject, run),
        unit="1",
        basis=(
            "action equals reaction at every step, so only round-off, c u sqrt(n),"
            " may change momentum"
        ),
        what="The change of total momentum, relative to the initial sum of m|v|,",
    )


def _in_slow_motion(subject: Subject) -> float:
    """Factor >= 1 on the round-off of momentum in units of the initial sum of m |v|.

    It is 1 for velocities that are rounded relative to their own size. Velocities computed as
    differences of positions have the rounding errors of positions, u V with the speed scale V =
    L/tau, at any speed of the bodies: the factor is (sum m) V/(sum m |v|).
    """
    if not subject.method.differenced_velocities:
        return 1.0
    instance = subject.instance
    # max(1, (sum m) V / sum m |v(0)|).
    unit = float(instance.scene.bodies.mass.sum()) * instance.scales.speed
    return max(1.0, unit / momentum_scale(instance))


def _of_pairs(subject: Subject, plain: Trajectory, run: Trajectory) -> list[Finding]:
    """The largest change of the momentum of two colliding bodies, in units of the impulse (1 + e)
    m_n c of the law; empty if no two samples isolate an impact.

    e is the restitution, m_n = 1/(1/m_1 + 1/m_2) and c the certified closing speed.
    """
    truth = certified(subject)
    assert truth is not None
    scene = subject.instance.scene
    law = scene.all(Contact)[0]
    rounding = subject.round_off(subject.levels[-1])
    times = []
    values = []
    allowed = []
    for window in windows(truth, run, _late_by(subject, truth, plain)):
        bodies = bodies_of(scene, window)
        numbers = list(window.impact.bodies)
        momenta = bodies.mass[:, None] * run.velocity[[window.first, window.last]][:, numbers]
        exchanged = (1.0 + law.restitution) * bodies.normal_mass * window.impact.closing
        # |(m_1 v_1 + m_2 v_2)(last) - (m_1 v_1 + m_2 v_2)(first)|/((1 + e) m_n c), up to
        # u sum m_i |v_i|/((1 + e) m_n c), summed over both bodies and both samples.
        change = momenta[1].sum(axis=0) - momenta[0].sum(axis=0)
        times.append(window.impact.time)
        values.append(float(np.linalg.norm(change)) / exchanged)
        allowed.append(rounding * float(np.linalg.norm(momenta, axis=-1).sum()) / exchanged)
    if not times:
        return []
    return [
        worst(
            check=Momentum.name,
            quantity="pairs",
            t=np.array(times),
            values=np.array(values),
            allowed=np.array(allowed),
            signal=1.0,
            unit="1",
            basis="action equals reaction in every impact, so only round-off may change momentum",
            what=(
                f"The change of the momentum of two bodies that meet, the largest of {len(times)}"
                " impacts, relative to the impulse of the law,"
            ),
        )
    ]


def _in_flights(subject: Subject, run: Trajectory) -> Finding:
    """The largest |dv - g dt| between two samples of a body that has no impact between them."""
    truth = certified(subject)
    if truth is None:
        return undecided(Momentum.name, "flights", no_truth(subject))
    # |v(t') - v(t) - g (t' - t)|/V
    fallen = falling(subject.instance.scene) * np.diff(run.t)[:, None, None]
    departure = np.linalg.norm(np.diff(run.velocity, axis=0) - fallen, axis=-1)
    is_flight = _flights(subject, truth, run)
    if not is_flight.any():
        return undecided(
            Momentum.name, "flights", "each interval between samples contains an impact"
        )
    speed = subject.instance.scales.speed
    return worst(
        check=Momentum.name,
        quantity="flights",
        t=run.t[1:],
        values=np.max(departure * is_flight, axis=1) / speed,
        allowed=subject.noise(subject.levels[-1]),
        signal=np.max(np.linalg.norm(fallen, axis=-1) * is_flight, axis=1) / speed,
        unit="1",
        basis=(
            "between impacts velocities change by g dt, which every method adds exactly:"
            " round-off, and u for each of n equal terms"
        ),
        what="The change of a velocity in flight less g dt, relative to L/tau,",
    )


def _flights(subject: Subject, truth: SampledTruth, run: Trajectory) -> Array:
    """True (T - 1, N) where a body certainly has no impact between two successive samples.

    False beyond the last certified sample, and from the first impact whose time is not bounded.
    """
    impacts = listed(truth.scalars)
    late = _late_by(subject, truth, run)
    begin = run.t[:-1]
    end = run.t[1:]
    is_flight = np.ones((len(begin), len(subject.instance.scene.bodies)), dtype=bool)
    is_flight[truth.until - 1 :] = False
    for number, impact in enumerate(impacts):
        if number == len(late):
            is_flight[end >= impact.time] = False
            break
        # [begin, end] and [t_i - late_i, t_i + late_i] intersect.
        may_meet = (end >= impact.time - late[number]) & (begin <= impact.time + late[number])
        for body in impact.bodies:
            is_flight[may_meet, body] = False
    return is_flight


def _late_by(subject: Subject, truth: SampledTruth, run: Trajectory) -> list[float]:
    """The time [s] by which each certified impact may come earlier or later in the run."""
    return late_by(subject, truth, crossings(subject, truth)["contact"], run)


def _exchanged(subject: Subject, run: Trajectory) -> Array:
    """The largest change of any body's momentum since the start (T,), in units of the initial sum
    of m |v|; 0 if all of it is round-off.

    It is the signal: the momentum that the bodies exchange.
    """
    # max over i of m_i |v_i(t) - v_i(0)| / sum m |v(0)|
    change = subject.instance.scene.bodies.mass[:, None] * (run.velocity - run.velocity[0])
    largest: Array = np.linalg.norm(change, axis=-1).max(axis=1) / momentum_scale(subject.instance)
    rounding = subject.round_off(subject.levels[0])
    if np.any(largest > rounding):
        return largest
    return np.zeros_like(largest)


CHECK = Momentum()
