"""Energy, or the work-energy balance where something dissipates."""

from collections.abc import Mapping

import numpy as np

from refdem.core.balance import energy_scale, kinetic, mechanical
from refdem.core.check import Check, CompletedRun, Subject
from refdem.core.finding import Finding
from refdem.core.judgement import Array, judged, left_at_finest, sharpest, undecided, worst
from refdem.core.refinement import CLOCK_STEPS, COUNTING_FLOOR, ROUND_OFF_FACTOR, flight
from refdem.core.variant import Variant
from refdem.scene import Scene
from refdem.scene.elements.contact import Contact
from refdem.scene.elements.plane import Plane
from refdem.scene.elements.rod import Rod

TERMS = 2.0
"""Kinetic and potential energy each err by the bound on the state."""

SPRINGS = (
    "The rise of energy above its initial value (the tangential contact"
    " springs store an unreported part)"
)


class Energy(Check):
    """What goes in comes out, at the coarsest and the finest level; a symplectic method has no
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
        """Where the potential energy is known at every sample, and a closed form keeps count of
        what a drive brings in.
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
        if "contact:rigid" in scene.features and not _is_impacts_alone(scene):
            return "rigid contacts that carry a load have no potential energy"
        return None

    def needs(self, subject: Subject) -> tuple[Variant, ...]:
        """The coarsest and the finest level; all of them where the coarsest may have a bound that
        is too wide to see anything.
        """
        if subject.method.keeps("energy", subject.instance.problem.features):
            return tuple(dict.fromkeys((Variant(subject.levels[0]), subject.finest)))
        return subject.plain

    def judge(self, subject: Subject, runs: Mapping[Variant, CompletedRun]) -> list[Finding]:
        """Balance at each level; drift at the finest one if the method claims to have none."""
        found = [self._balance(subject, _first_sharp(subject, runs), runs, "balance")]
        if len(subject.levels) > 1:
            found.append(self._balance(subject, subject.finest, runs, "finest"))
        shown = _work(subject, runs[subject.finest]) is not None
        scene = subject.instance.scene
        if shown and not scene.is_driven() and not _stiffens(scene):
            found.append(self._dissipation(subject, subject.finest, runs[subject.finest]))
        if (
            subject.method.symplectic
            and subject.method.control == "step"
            and subject.instance.scene.is_conservative()
        ):
            found.append(self._drift(subject, runs[subject.finest]))
        return found

    def _balance(
        self,
        subject: Subject,
        variant: Variant,
        runs: Mapping[Variant, CompletedRun],
        quantity: str,
    ) -> Finding:
        """The imbalance at one level; at the finest it must have fallen with the order from what
        the coarsest shows.
        """
        measured = self._imbalance(subject, runs[variant])
        if isinstance(measured, str):
            return undecided(self.name, quantity, measured)
        what, change = measured
        kept, basis = subject.kept("energy", variant.level)
        rounding = subject.round_off(variant.level) * _of_positions(subject) + _of_falling(
            subject, variant.level
        )
        of_rods = _of_rods(subject)
        allowed = TERMS * (np.maximum(kept, rounding) + of_rods)
        coarse = self._imbalance(subject, runs[Variant(subject.levels[0])])
        two_sided = not what.startswith("The rise")
        if (
            variant == subject.finest
            and len(subject.levels) > 2
            and two_sided
            and not isinstance(coarse, str)
        ):
            # Equal terms that are added up step by step, as in free flight, round alike.
            alike = flight(subject.instance, subject.method, variant.level)
            fallen = left_at_finest(subject, coarse[1]) + TERMS * COUNTING_FLOOR * (
                rounding + of_rods + alike
            )
            if np.any(fallen < allowed):
                basis = (
                    "truncation error extrapolated from the coarsest step with the claimed order"
                )
            allowed = np.minimum(allowed, fallen)
        return worst(
            check=self.name,
            quantity=quantity,
            t=subject.instance.times,
            values=change,
            allowed=allowed,
            signal=_exchanged(subject, runs[variant]),
            unit="1",
            basis=f"{basis}, times 2 for kinetic and potential energy",
            what=f"{what}, relative to the initial energy,",
        )

    def _imbalance(self, subject: Subject, run: CompletedRun) -> tuple[str, Array] | str:
        """What changes and by how much (T,), in units of the energy at the start; or why nobody can
        say.
        """
        scene = subject.instance.scene
        scale = energy_scale(subject.instance)
        energy = mechanical(scene, run.trajectory)
        what = "The change of kinetic plus potential energy"
        with np.errstate(
            invalid="ignore"
        ):  # a body in the centre of attraction has no finite energy: not a number fails
            change = np.abs(energy - energy[0]) / scale
        work = _work(subject, run)
        if work is None and _stiffens(scene):
            return (
                "a tangential spring that stiffens with its load exchanges energy, and"
                " the run does not report how much"
            )
        if _rubs_by_springs(scene) and not _stiffens(scene):
            what = SPRINGS
            change = np.maximum(0.0, energy - energy[0]) / scale
        elif not scene.is_conservative():
            if work is None and scene.is_driven():
                return "a drive does work on the system, and the run does not report how much"
            if work is None:
                what = "The rise of energy above any earlier value"
                change = (energy - np.minimum.accumulate(energy)) / scale
            else:
                what = "The change of energy plus dissipated work"
                change = (
                    np.abs(energy + work.reshape(len(energy), -1).sum(axis=1) - energy[0]) / scale
                )
        return what, change

    def _dissipation(self, subject: Subject, variant: Variant, run: CompletedRun) -> Finding:
        """Work done against friction and damping is lost: it never comes back."""
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

    def _drift(self, subject: Subject, run: CompletedRun) -> Finding:
        """Secular drift: the mean over the last quarter against the mean over the first."""
        energy = mechanical(subject.instance.scene, run.trajectory) / energy_scale(subject.instance)
        quarter = max(1, len(energy) // 4)
        drift = abs(float(np.mean(energy[-quarter:]) - np.mean(energy[:quarter])))
        level = subject.levels[-1]
        order = subject.order
        truncation = subject.method.constant * (level / subject.instance.scales.tau) ** order
        rounding = subject.round_off(level) * _of_positions(subject) + _of_falling(subject, level)
        allowed = TERMS * (truncation + rounding)
        return judged(
            check=self.name,
            quantity="drift",
            value=drift,
            bound=allowed,
            unit="1",
            basis=(
                f"a symplectic method of order {order} keeps its energy error at"
                f" (h/tau)^{order} for all times"
            ),
            what=(
                "The secular energy drift (mean of the last quarter of the run less mean"
                " of the first), relative to the initial energy,"
            ),
        )


def _is_impacts_alone(scene: Scene) -> bool:
    """Nothing but impacts of spheres, with each other and with planes: between them bodies are
    free.
    """
    return set(scene.all(Contact)) | set(scene.all(Plane)) == set(scene.elements) and bool(
        (scene.bodies.radius > 0).all()
    )


def _exchanged(subject: Subject, run: CompletedRun) -> Array:
    """How much the kinetic energy has changed since the start (T,), in units of the energy at the
    start: what there is to balance.
    """
    moving = kinetic(subject.instance.scene, run.trajectory)
    away: Array = np.abs(moving - moving[0]) / energy_scale(subject.instance)
    rounding = subject.round_off(subject.levels[0])
    if np.any(away > rounding):
        return away
    return np.zeros_like(away)


def _first_sharp(subject: Subject, runs: Mapping[Variant, CompletedRun]) -> Variant:
    """The coarsest level whose bound is no more than a tenth of the energy that is exchanged; the
    coarsest of all if none is.
    """
    exchanged = _exchanged(subject, runs[subject.finest])
    for variant in subject.plain:
        kept, _ = subject.kept("energy", variant.level)
        if variant in runs and not sharpest(TERMS * kept, exchanged).is_blind:
            return variant
    return Variant(subject.levels[0])


def _work(subject: Subject, run: CompletedRun) -> Array | None:
    """The dissipated work [J] that a run shows.

    None of a method that tells what the energy lacks, for then any balance holds.
    """
    if "dissipated_work" in subject.method.derived:
        return None
    return run.trajectory.channels.get("dissipated_work")


def _rubs_by_springs(scene: Scene) -> bool:
    """Friction acts through tangential springs."""
    return any(law.tangential_stiffness > 0 and law.friction > 0 for law in scene.all(Contact))


def _stiffens(scene: Scene) -> bool:
    """True if tangential springs grow stiffer with the load (Hertz's law): what they take is not
    what they give, and no potential keeps account of it.
    """
    return _rubs_by_springs(scene) and "contact:hertz" in scene.features


def _of_rods(subject: Subject) -> Array | float:
    """Round-off (T,) where only their force holds rods: what rounds their ends' speed along them
    goes on as length, c u sqrt(n) t/tau.

    A method that claims the constraint brings them back at every step.
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
    steps = max(float(len(t)), CLOCK_STEPS * scales.duration / scales.tau)
    drift: Array = (
        ROUND_OFF_FACTOR * method.round_off * np.sqrt(steps) * np.abs(t - t[0]) / scales.tau
    )
    return drift


def _of_falling(subject: Subject, level: float) -> float:
    """Round-off of velocities to which constant gravity adds the same at every step, and of the
    places they carry.
    """
    falls = "uniform_gravity" in subject.instance.scene.features
    if falls:
        return flight(subject.instance, subject.method, level)
    return 0.0


def _of_positions(subject: Subject) -> float:
    """Round-off of positions as energy: the largest force sqrt(2 k E0) times u L, over E0; 1 where
    the motion fills its scale.

    With E_s = m (L/tau)^2 = k L^2 it is sqrt(E_s / (2 E0)); large where bodies that are far apart
    in units of the way they go meet slowly, as in a stiff contact. Overlaps are differences of
    places, so that it is u |r| that counts where |r| > L.
    """
    far = (
        float(np.linalg.norm(subject.instance.scene.bodies.position, axis=1).max())
        / subject.instance.scales.length
    )
    if "contact" not in subject.instance.scene.features:
        far = 1.0
    return max(1.0, far) * float(
        np.sqrt(subject.instance.scales.energy / (2 * energy_scale(subject.instance)))
    )


CHECK = Energy()
