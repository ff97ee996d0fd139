"""Energy conservation, or the work-energy balance E(t) + W(t) = E(0) where work W is
dissipated.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from refdem.checks._crossings import is_impacts_alone
from refdem.checks._kinks import may_straddle, straddled
from refdem.checks._sphere_on_plane import starts_on_plane
from refdem.core.balance import energy_scale, kinetic, kinetic_exchanged, mechanical
from refdem.core.check import Check, CompletedRun, Subject
from refdem.core.finding import Finding
from refdem.core.judgement import (
    INTEGRATED,
    Array,
    judged,
    left_at_finest,
    room_of,
    sharpest,
    undecided,
    worst,
)
from refdem.core.refinement import (
    CLOCK_STEPS,
    COUNTING_FLOOR,
    ROUND_OFF_FACTOR,
    flight,
    turning,
)
from refdem.core.trajectory import Trajectory
from refdem.core.variant import Variant
from refdem.core.work import fastest_drive, work_along
from refdem.scene import Scene
from refdem.scene.elements.contact import Contact
from refdem.scene.elements.piecewise_field import PiecewiseField
from refdem.scene.elements.rod import Rod
from refdem.scene.elements.rotating_dashpot import RotatingDashpot
from refdem.scene.elements.spring import Spring
from refdem.scene.elements.uniform_gravity import UniformGravity

TERMS = 2.0
"""Kinetic and potential energy each have an error up to the bound on the state."""

MOST_RADIANS = 2.0
"""Largest phase [rad] of the fastest motion between two samples for which the power is integrated:
positions and velocities at samples resolve phases below 2 pi, and interpolation needs some margin.
"""

SPRINGS = (
    "The rise of energy above its initial value (the tangential contact"
    " springs store an unreported part)"
)
"""Subject of the finding where tangential springs of contacts hold energy that no channel
reports.
"""
TWO_LEVERS = (
    "friction whose slip and torque have different levers exchanges energy other than by its slip"
)
"""The reason why a law with two levers has no energy balance: the power of its tangential force and
torques is not force times slip. So a tangential spring does not return the work done on it, and
friction may increase the energy temporarily.
"""


@dataclass(frozen=True, eq=False)
class Imbalance:
    """The departure of an energy balance from 0.

    `change` (T,) and its error from integration between samples, `uncertainty` (T,), are in units
    of the energy at the start; `what` names the balance in a sentence. `is_rise` is True if only a
    rise counts.
    """

    what: str
    change: Array
    uncertainty: Array | float = 0.0
    is_rise: bool = False


class Energy(Check):
    """The energy balance at the coarsest and at the finest level; a symplectic method also has no
    secular drift.
    """

    name = "energy"
    title = "Energy balance"
    kills = (
        "a force that does not derive from its potential, friction that drives,"
        " work counted twice, a missing gyroscopic term"
    )
    synchronous = True

    def applies(self, subject: Subject) -> str | None:
        """Scenes whose potential energy is known at every sample; closed forms of driven motions
        only where they claim to count the work of the drive.
        """
        method = subject.method
        if (
            subject.instance.scene.is_driven()
            and method.control == "exact"
            and "energy" not in method.conserves
        ):
            return (
                "a drive does work on the system, and the method does not claim to account for it"
            )
        scene = subject.instance.scene
        if (
            "contact:rigid" not in scene.features
            or is_impacts_alone(scene)
            or starts_on_plane(scene)
        ):
            return None
        return "rigid contacts that carry a load have no potential energy"

    def needs(self, subject: Subject) -> tuple[Variant, ...]:
        """The coarsest and the finest level; all levels where the bound at the coarsest may be too
        wide to decide anything.
        """
        if subject.keeps("energy"):
            return tuple(dict.fromkeys((Variant(subject.levels[0]), subject.finest)))
        return subject.plain

    def judge(self, subject: Subject, runs: Mapping[Variant, CompletedRun]) -> list[Finding]:
        """The balance at two levels, or at the finest alone where no claim decides more; that
        dissipated work never decreases; and the secular drift of symplectic methods.
        """
        findings = []
        if len(subject.levels) > 1:
            findings.append(self._balance(subject, subject.finest, runs, "finest"))
        balance = self._balance(subject, _first_sharp(subject, runs), runs, "balance")
        # Undecided findings are reported once, for the finest level.
        if balance.outcome != "undecided" or not findings:
            findings.insert(0, balance)
        reports_work = _dissipated_work(subject, runs[subject.finest]) is not None
        scene = subject.instance.scene
        may_fall = scene.is_driven() or _stiffens(scene) or _has_two_levers(scene)
        if reports_work and not may_fall:
            findings.append(self._dissipation(subject, subject.finest, runs[subject.finest]))
        if _stays_bounded(subject):
            findings.append(self._drift(subject, runs))
        return findings

    def _balance(
        self,
        subject: Subject,
        variant: Variant,
        runs: Mapping[Variant, CompletedRun],
        quantity: str,
    ) -> Finding:
        """The finding on the imbalance at one level.

        With the claim c of the method, the factor f of motions that outgrow their scales
        (`_outgrown_by_force`) and the roundings u_r of positions and sums and u_l of rod lengths,

            bound = TERMS (max(f c, u_r) + u_l).

        At the finest level the bound is at most that which follows from the imbalance at the
        coarsest level with the claimed order.
        """
        unresolved = subject.unresolved(variant.level)
        if unresolved and not subject.keeps("energy"):
            return undecided(self.name, quantity, unresolved)
        measured = self._imbalance(subject, runs[variant])
        if isinstance(measured, str):
            return undecided(self.name, quantity, measured)
        scene = subject.instance.scene
        claimed, basis = subject.kept("energy", variant.level)
        claimed = claimed * _outgrown_by_force(subject, runs[variant].trajectory)
        of_places = subject.round_off(variant.level) * _position_rounding(subject)
        rounding = of_places + _summed_rounding(subject, variant.level)
        of_rods = _rod_rounding(subject)
        # TERMS (max(f c, u_r) + u_l).
        allowed = TERMS * (np.maximum(claimed, rounding) + of_rods)
        changes = self._changes(subject, runs)
        # A rise above an earlier value is often exactly 0, and does not fall with the order.
        has_levels = variant == subject.finest and len(subject.levels) > 2
        if has_levels and not measured.is_rise and changes:
            extrapolated = self._extrapolated(subject, changes, runs[variant])
            if np.any(extrapolated < allowed):
                basis = (
                    "truncation error extrapolated from the coarsest step with the claimed order"
                )
            allowed = np.minimum(allowed, extrapolated)
        if variant != subject.finest and scene.is_conservative() and not measured.is_rise:
            share = self._share_by_halving(subject, variant, runs, allowed)
            if share < 1.0:
                basis += f", of which the change at the next halving leaves {share:.2g}"
            allowed = share * allowed
        return worst(
            check=self.name,
            quantity=quantity,
            t=subject.instance.times,
            values=measured.change,
            allowed=allowed + measured.uncertainty,
            signal=_exchanged(subject, runs[variant]),
            unit="1",
            basis=f"{basis}, times 2 for kinetic and potential energy{_of_samples(measured)}",
            what=f"{measured.what}, relative to the initial energy,",
        )

    def _changes(self, subject: Subject, runs: Mapping[Variant, CompletedRun]) -> list[Array]:
        """The imbalance (T,) plus its error of integration, at every level, coarse to fine; at the
        coarsest alone if not all of them ran; none where it is unknown.
        """
        found: list[Array] = []
        for variant in subject.plain:
            if variant not in runs:
                return found[:1]
            imbalance = self._imbalance(subject, runs[variant])
            if isinstance(imbalance, str):
                return found[:1]
            found.append(imbalance.change + imbalance.uncertainty)
        return found

    def _extrapolated(
        self, subject: Subject, changes: list[Array], finest: CompletedRun
    ) -> Array | float:
        """Bound, one or (T,), on the imbalance at the finest level that the imbalances `changes` at
        the levels imply; infinite if they imply nothing.

        Where steps straddle kinks, C in C h^p scatters by `room_of`, and a step that straddles a
        kink at the finest level adds its own error (`straddled`).
        """
        left = self._left_at(subject, subject.finest, finest, len(changes[0]))
        if not may_straddle(subject):
            return left_at_finest(subject, *changes) + left
        # room max|imbalance at h_0| (h_finest/h_0)^p + left.
        halved = float((subject.levels[-1] / subject.levels[0]) ** subject.order)
        return room_of(subject) * float(np.max(changes[0])) * halved + left

    def _left_at(
        self, subject: Subject, variant: Variant, run: CompletedRun, count: int
    ) -> Array | float:
        """The part of the error of the energy, one or (count,), that does not fall with the step:
        COUNTING_FLOOR round-offs, and the error of steps that straddle kinks; infinite where the
        latter is unknown.
        """
        level = variant.level
        of_places = subject.round_off(level) * _position_rounding(subject)
        # Equal terms, as in free flight, have the same rounding error at every step.
        summation = flight(subject.instance, subject.method, level)
        rounding = of_places + _summed_rounding(subject, level) + _rod_rounding(subject)
        floor: Array | float = TERMS * COUNTING_FLOOR * (rounding + summation)
        if not may_straddle(subject):
            return floor
        if not subject.instance.quantities:
            return np.inf
        by_quantity = straddled(subject, level, run.trajectory, count)
        return floor + TERMS * np.asarray(np.maximum.reduce(list(by_quantity.values())))

    def _share_by_halving(
        self,
        subject: Subject,
        variant: Variant,
        runs: Mapping[Variant, CompletedRun],
        allowed: Array,
    ) -> float:
        """The part of the bound `allowed` (T,) that the change of the energy at the next halving
        leaves, at most 1; 1 where the next level was not run.

        With an error e(h) = C h^p of the energy, the change from h to h/2 is (1 - 2^-p) e(h). So
        e(h) is at most `room_of` times that change over 1 - 2^-p, plus the part that does not fall
        with the step (`_left_at`).
        """
        finer = Variant(variant.level / 2)
        if subject.method.control != "step" or subject.keeps("energy") or finer not in runs:
            return 1.0
        scene = subject.instance.scene
        coarse, fine = (
            mechanical(scene, runs[one].trajectory) / energy_scale(subject.instance)
            for one in (variant, finer)
        )
        change = np.maximum.accumulate(np.abs(coarse - fine))
        left = self._left_at(subject, variant, runs[variant], len(change))
        # e(h) <= room |E(h) - E(h/2)|/(1 - 2^-p) + left;   share = max over t of that / allowed.
        implied = room_of(subject) / (1.0 - 2.0**-subject.order) * change + left
        share = float(np.max(implied / allowed))
        if not np.isfinite(share):
            return 1.0
        return min(1.0, share)

    def _imbalance(self, subject: Subject, run: CompletedRun) -> Imbalance | str:
        """The imbalance, or the reason why it is unknown.

        All are in units of `energy_scale`.

        - conservative scene: |E - E0|
        - tangential contact springs: max(0, E - E0), as they store an unreported part of the
          energy; unknown where slip and torque have different levers
        - work W against dissipation reported: |E + W - E0|
        - drives and dashpots: |E - W - E0| with their work W integrated between samples
        - other dissipation: the rise of E above its minimum so far
        """
        scene = subject.instance.scene
        scale = energy_scale(subject.instance)
        energy = mechanical(scene, run.trajectory)
        # A body at the centre of attraction has infinite energy: the difference is NaN and fails.
        with np.errstate(invalid="ignore"):
            change = np.abs(energy - energy[0]) / scale
        work = _dissipated_work(subject, run)
        if work is None and _stiffens(scene):
            return (
                "a tangential spring that stiffens with its load exchanges energy, and"
                " the run does not report how much"
            )
        if _has_two_levers(scene) and _rubs_by_springs(scene):
            return f"{TWO_LEVERS}, and tangential springs hold a part that no channel reports"
        if work is None and _has_two_levers(scene):
            return f"{TWO_LEVERS}, and the run does not report how much"
        if _rubs_by_springs(scene) and not _stiffens(scene):
            # max(0, E - E0).
            rise = np.maximum(0.0, energy - energy[0]) / scale
            return Imbalance(SPRINGS, rise, is_rise=True)
        if scene.is_conservative():
            return Imbalance("The change of kinetic plus potential energy", change)
        if work is not None:
            # |E + W - E0|, with W the sum over all contacts.
            dissipated = work.reshape(len(energy), -1).sum(axis=1)
            missing = np.abs(energy + dissipated - energy[0]) / scale
            return Imbalance("The change of energy plus dissipated work", missing)
        integrated = self._integrated(subject, run, energy)
        if scene.is_driven() or isinstance(integrated, Imbalance):
            return integrated
        # E(t) - min over s <= t of E(s).
        rise = (energy - np.minimum.accumulate(energy)) / scale
        return Imbalance("The rise of energy above any earlier value", rise, is_rise=True)

    def _integrated(self, subject: Subject, run: CompletedRun, energy: Array) -> Imbalance | str:
        """The change of energy less the work of drives and dashpots, integrated between samples."""
        scene = subject.instance.scene
        scale = energy_scale(subject.instance)
        # Phase of the fastest motion between two samples: dt max(fastest drive, 1/tau) [rad].
        interval = float(np.max(np.abs(np.diff(run.trajectory.t))))
        fastest = max(fastest_drive(scene), 1 / subject.instance.scales.tau)
        if interval * fastest > MOST_RADIANS:
            return (
                "a drive does work on the system, the run does not report how much, and its samples"
                f" are {interval * fastest:.2g} rad of the fastest motion apart;"
                f" at most {MOST_RADIANS:.2g} rad can be integrated"
            )
        work = work_along(scene, run.trajectory)
        if work is None:
            return (
                "a drive does work on the system, the run does not report how much, and"
                " positions and velocities at its samples do not show it"
            )
        # |E - W - E0|, with W the integral of the power of the forces without a potential.
        change = np.abs(energy - energy[0] - work.done) / scale
        return Imbalance(
            "The change of energy less the work of the forces (integrated between samples)",
            change,
            uncertainty=work.uncertainty / scale,
        )

    def _dissipation(self, subject: Subject, variant: Variant, run: CompletedRun) -> Finding:
        """The finding that dissipated work never decreases: W(t) >= W(s) for all s < t."""
        # max over s <= t of W(s), less W(t): 0 for a work that never decreases.
        work = run.trajectory.channels["dissipated_work"].reshape(len(run.trajectory.t), -1).sum(
            axis=1
        ) / energy_scale(subject.instance)
        allowed, basis = subject.kept("energy", variant.level)
        return worst(
            check=self.name,
            quantity="dissipation",
            t=subject.instance.times,
            values=np.maximum.accumulate(work) - work,
            allowed=TERMS * allowed,
            unit="1",
            basis=(
                f"dissipated work cannot decrease: {basis}, times 2 for kinetic and"
                " potential energy"
            ),
            what=(
                "The decrease of the dissipated work below any earlier value, relative to"
                " the initial energy,"
            ),
        )

    def _drift(self, subject: Subject, runs: Mapping[Variant, CompletedRun]) -> Finding:
        """The secular drift: mean energy of the last quarter of the run less that of the first.

        The energy error of a symplectic method of order p stays at C (h/tau)^p for all times
        (Hairer, Lubich and Wanner 2006, chapter IX), where the motion stays bounded. A difference
        of means is at most twice the largest error, and so twice what coarser levels imply for it.
        """
        run = runs[subject.finest]
        energy = mechanical(subject.instance.scene, run.trajectory)
        energy = energy / energy_scale(subject.instance)
        # Means over a quarter remove most of the bounded oscillation of the energy error.
        quarter = max(1, len(energy) // 4)
        drift = abs(float(np.mean(energy[-quarter:]) - np.mean(energy[:quarter])))
        level = subject.levels[-1]
        order = subject.order
        # bound = TERMS (C (h/tau)^p outgrown + rounding).
        of_step = subject.method.constant * (level / subject.instance.scales.tau) ** order
        truncation = of_step * _outgrown(subject, run.trajectory)
        of_places = subject.round_off(level) * _position_rounding(subject)
        rounding = of_places + _summed_rounding(subject, level)
        allowed = TERMS * (truncation + rounding)
        basis = (
            f"a symplectic method of order {order} keeps its energy error at (h/tau)^{order} for"
            " all times"
        )
        changes = self._changes(subject, runs)
        if len(subject.levels) > 2 and changes:
            implied = 2 * float(np.max(self._extrapolated(subject, changes, run)))
            if implied < allowed:
                allowed = implied
                basis = "twice the error of the energy that is implied by that at the coarsest step"
        return judged(
            check=self.name,
            quantity="drift",
            value=drift,
            bound=allowed,
            unit="1",
            basis=basis,
            what=(
                "The secular energy drift (mean of the last quarter of the run less mean"
                " of the first), relative to the initial energy,"
            ),
        )


def _stays_bounded(subject: Subject) -> bool:
    """True if the method keeps a modified energy of a conservative scene, so that the error of the
    energy stays bounded.
    """
    method = subject.method
    is_stepping = method.symplectic and method.control == "step"
    return is_stepping and subject.instance.scene.is_conservative()


def _outgrown(subject: Subject, run: Trajectory) -> float:
    """Factor by which the error of the energy exceeds its scale, in an endless fall or in a field
    in which a slow body gains more kinetic energy than its initial energy; 1 elsewhere.

    A symplectic method of order p keeps a modified energy E + h^p G(r, v) + ..., so that E changes
    by h^p times the change of G. For p = 1, G is half the power of the forces:

        G = -+ m v.a/2.

    Where only uniform gravity acts, G grows with the velocity without bound: the factor is the
    largest |v|/V. In any other field G grows with the kinetic energy, which is bounded: the factor
    is its largest value over the initial energy.
    """
    scene = subject.instance.scene
    falls = all(isinstance(element, UniformGravity) for element in scene.elements)
    if falls:
        fastest = float(np.max(np.linalg.norm(run.velocity, axis=-1), initial=0.0))
        return max(1.0, fastest / subject.instance.scales.speed)
    largest = float(np.max(kinetic(scene, run), initial=0.0))
    return max(1.0, largest / energy_scale(subject.instance))


def _outgrown_by_force(subject: Subject, run: Trajectory) -> Array | float:
    """Factor, or factors (T,), by which velocities or accelerations exceed their scales V and V/tau
    under a drive or a spring that softens, or by which the kinetic energy exceeds its scale in a
    field in which a slow body gains more than its initial energy; 1 elsewhere.

    An error e of the state, in units of its scales, changes the energy by

        |dE| <= |F| e L + m |v| e V,   E_s = m V^2,   L = V tau,

    so that |dE|/E_s <= e (|a| tau/V + |v|/V). The factor is max(1, |a| tau/V, |v|/V), and TERMS
    covers the sum. In a rotating fluid the motion grows in proportion to itself, and the error e of
    a step with it: the factor is then squared.
    """
    scene = subject.instance.scene
    if scene.all(PiecewiseField):
        so_far = np.maximum.accumulate(kinetic(scene, run))
        return np.asarray(np.maximum(1.0, so_far / energy_scale(subject.instance)))
    yields = any(
        spring.stiffness < 0 or spring.quadratic or spring.cubic < 0 for spring in scene.all(Spring)
    )
    if not yields and not scene.is_driven():
        return 1.0
    scales = subject.instance.scales
    # |a| tau/V from differences |v(t') - v(t)|/(t' - t), and |v|/V; each the largest of all bodies.
    change = np.linalg.norm(np.diff(run.velocity, axis=0), axis=-1)
    interval = np.abs(np.diff(run.t))[:, None]
    accelerations = np.max(change / interval, axis=1, initial=0.0) * scales.tau / scales.speed
    speeds = np.max(np.linalg.norm(run.velocity, axis=-1), axis=1, initial=0.0) / scales.speed
    if scene.all(RotatingDashpot):
        # The acceleration of an interval counts at its end.
        at_ends = np.concatenate([[0.0], accelerations])
        so_far = np.maximum.accumulate(np.maximum(speeds, at_ends))
        return np.asarray(np.maximum(1.0, so_far) ** 2)
    return max(1.0, float(np.max(speeds)), float(np.max(accelerations, initial=0.0)))


def _of_samples(measured: Imbalance) -> str:
    """The clause on integration between samples in the basis of a bound."""
    if np.any(measured.uncertainty):
        return f", plus {INTEGRATED}"
    return ""


def _exchanged(subject: Subject, run: CompletedRun) -> Array:
    """Change of the kinetic energy, or of its largest part, since the start (T,), in units of the
    initial energy; 0 if all of it is round-off.

    It is the signal against which the sharpness of a bound on the balance is measured.
    """
    moved = kinetic_exchanged(subject.instance.scene, run.trajectory)
    change: Array = moved / energy_scale(subject.instance)
    rounding = subject.round_off(subject.levels[0])
    if np.any(change > rounding):
        return change
    return np.zeros_like(change)


def _first_sharp(subject: Subject, runs: Mapping[Variant, CompletedRun]) -> Variant:
    """The coarsest level whose bound is at most a tenth of the exchanged energy; if there is none,
    the coarsest.
    """
    exchanged = _exchanged(subject, runs[subject.finest])
    for variant in subject.plain:
        claimed, _ = subject.kept("energy", variant.level)
        if variant not in runs:
            continue
        claimed = claimed * _outgrown_by_force(subject, runs[variant].trajectory)
        if not sharpest(TERMS * claimed, exchanged).is_blind:
            return variant
    return Variant(subject.levels[0])


def _dissipated_work(subject: Subject, run: CompletedRun) -> Array | None:
    """The dissipated work [J] that a run reports; None if it reports none.

    None also for a method that computes it as the missing energy, since the balance then holds by
    construction.
    """
    if "dissipated_work" in subject.method.derived:
        return None
    return run.trajectory.channels.get("dissipated_work")


def _rubs_by_springs(scene: Scene) -> bool:
    """True if friction acts through tangential springs."""
    return any(law.tangential_stiffness > 0 and law.friction > 0 for law in scene.all(Contact))


def _has_two_levers(scene: Scene) -> bool:
    """True if slip and torque of friction have different levers."""
    return any(law.has_two_levers for law in scene.all(Contact))


def _stiffens(scene: Scene) -> bool:
    """True if tangential springs stiffen with the normal load (Hertz's law).

    Such a spring does not return the work done on it, so it has no potential energy.
    """
    return _rubs_by_springs(scene) and "contact:hertz" in scene.features


def _rod_rounding(subject: Subject) -> Array | float:
    """Round-off (T,) of rod lengths, c u sqrt(n) t/tau, where methods with a tolerance integrate
    rods as forces.

    Rounding leaves a relative velocity of the ends along the rod, which changes the length linearly
    in time. Methods that claim the constraint restore it at every step; elsewhere the bound is 0.
    """
    method = subject.method
    scales = subject.instance.scales
    t = subject.instance.times
    if (
        not subject.instance.scene.all(Rod)
        or "constraint" in method.conserves
        or method.control != "tolerance"
    ):
        return 0.0
    # Methods with a tolerance choose their steps: at most so many per tau.
    # c u sqrt(n) |t - t(0)|/tau.
    steps = max(float(len(t)), CLOCK_STEPS * scales.duration / scales.tau)
    drift: Array = (
        ROUND_OFF_FACTOR * method.round_off * np.sqrt(steps) * np.abs(t - t[0]) / scales.tau
    )
    return drift


def _summed_rounding(subject: Subject, level: float) -> float:
    """Round-off that adds up in proportion to the number of steps: of velocities that constant
    gravity increases by the same amount at every step, with the positions they carry, and of bodies
    that turn by the same rotation at every step.
    """
    of_turns = turning(subject.instance, subject.method, level)
    has_gravity = "uniform_gravity" in subject.instance.scene.features
    if has_gravity:
        return of_turns + flight(subject.instance, subject.method, level)
    return of_turns


def _position_rounding(subject: Subject) -> float:
    """Factor on the round-off u of positions in the relative error of the energy, max(1, |r|/L)
    sqrt(E_s/(2 E0)).

    The largest force of a spring of stiffness k and energy E0 is F = sqrt(2 k E0), and the energy
    scale is E_s = m (L/tau)^2 = k L^2, so that a rounding u L of the position gives

        F u L/E0 = u sqrt(2 E_s/E0) = TERMS u sqrt(E_s/(2 E0)).

    The factor is large where bodies meet slowly in stiff contacts. Overlaps are differences of
    positions r, so that u |r| replaces u L where |r| > L.
    """
    # max(1, |r|/L) sqrt(E_s/(2 E0)), with |r|/L only where bodies touch.
    distance = (
        float(np.linalg.norm(subject.instance.scene.bodies.position, axis=1).max())
        / subject.instance.scales.length
    )
    if "contact" not in subject.instance.scene.features:
        distance = 1.0
    return max(1.0, distance) * float(
        np.sqrt(subject.instance.scales.energy / (2 * energy_scale(subject.instance)))
    )


CHECK = Energy()
