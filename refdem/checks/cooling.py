"""Cooling of a granular gas against kinetic theory.

  T(t) = T0/(1 + t/tau)^2         Haff's law, tau from truth
  w_c = 4 sqrt(pi) n sigma^2 sqrt(T/m) chi      collision frequency of one sphere
  (1 - e^2) T                     mean energy lost in a collision

with the number density n, the diameter sigma, the mass m, the pair correlation chi at contact and
the restitution e (Haff 1983; Brilliantov and Poeschel 2004).

A sample of collisions scatters, so every mean is judged by its standard error. Velocities of an
elastic gas obey Maxwell's distribution.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from refdem.core.check import Array, Check, CompletedRun, Subject
from refdem.core.finding import Finding
from refdem.core.judgement import judged, undecided, worst
from refdem.core.trajectory import Trajectory
from refdem.core.variant import Variant
from refdem.mechanics.gas import (
    collisions,
    haff_temperature,
    kurtosis_error,
    loss_error,
    velocity_kurtosis,
)
from refdem.scene import Scene
from refdem.scene.elements.contact import Contact
from refdem.scene.elements.periodic_box import PeriodicBox

ERRORS = 4.0
"""Standard errors allowed: a correct gas exceeds them with the probability 1e-4."""
THEORY = 0.01
"""Relative error of kinetic theory: velocities deviate from Maxwell's by 3/16 a2, and chi is
approximate.
"""
DILUTE = 0.1
"""Largest packing fraction for which the theory holds."""
SHORT = 0.05
"""Largest contact time times w_c for which collisions are binary."""
ROUGHEST = 0.5
"""Smallest restitution for which the theory holds: a2 stays below 0.06."""
UNIFORM = 2.0
"""Time, in units of tau, up to which the gas stays uniform: fluctuations of the flow decay more
slowly than thermal velocities, by 1 + t/tau, and end in clusters.
"""
ROUNDINGS = 20.0
"""Relative round-off of a temperature over that of a state: twice as much as a square has, and a
factor of ten for other orders of the sum over all spheres.
"""
FEWEST = 30
"""Smallest number of collisions from which a mean is taken."""


@dataclass(frozen=True, eq=False)
class Gas:
    """Parameters of the gas from its scene: number n of spheres, restitution, contact time `lasts`
    [s], packing fraction, and initial w_c [1/s] from truth.
    """

    n: int
    restitution: float
    lasts: float
    packing: float
    frequency: float

    @property
    def softness(self) -> float:
        """The contact time times the collision frequency w_c [1]."""
        return self.lasts * self.frequency

    def doubt(self) -> str | None:
        """The assumption of kinetic theory that the gas violates, or None."""
        if self.packing > DILUTE:
            return (
                f"the gas is not dilute: its packing fraction is {self.packing:.2g}, and"
                f" theory holds up to {DILUTE:g}"
            )
        if self.softness > SHORT:
            return (
                "contacts last too long for binary collisions: contact time times"
                f" collision frequency is {self.softness:.2g}, and theory holds up to"
                f" {SHORT:g}"
            )
        if self.restitution >= ROUGHEST:
            return None
        return (
            f"restitution {self.restitution:.2g} is too far from 1: theory holds from {ROUGHEST:g}"
        )


class Cooling(Check):
    """Means over many collisions, each judged by its standard error, since samples of a gas cool
    differently.
    """

    name = "cooling"
    title = "Cooling of a gas"
    kills = (
        "collisions missed by a stale neighbour list, periodic images off by one"
        " box, a wrong restitution, pairs counted twice"
    )
    synchronous = True

    def applies(self, subject: Subject) -> str | None:
        """Equal frictionless spheres with a linear or a rigid contact law in a periodic box."""
        scene = subject.instance.scene
        laws = subject.instance.scene.all(Contact)
        if "temperature" not in subject.instance.quantities or not scene.all(PeriodicBox):
            return "the scene is not a gas in a periodic box"
        if not are_alike(scene):
            return "the spheres differ, and kinetic theory is for equal ones"
        if len(laws) == 1 and laws[0].law in ("linear", "rigid") and not laws[0].friction:
            return None
        return "the contact law is not linear or rigid, without friction"

    def needs(self, subject: Subject) -> tuple[Variant, ...]:
        """The plain run at the finest level."""
        return (subject.finest,)

    def judge(self, subject: Subject, runs: Mapping[Variant, CompletedRun]) -> list[Finding]:
        """Findings for the temperature, the kurtosis of the velocities, the number of collisions
        and the energy lost in each.
        """
        if subject.truth is None or "collision_frequency" not in subject.truth.scalars:
            return [undecided(self.name, "temperature", "the collision frequency is not certified")]
        gas = _gas(subject.instance.scene, subject.truth.scalars["collision_frequency"][0])
        run = runs[subject.finest].trajectory
        if (doubt := gas.doubt()) is not None:
            return [undecided(self.name, "temperature", doubt)]
        temperature = subject.instance.observe(run)["temperature"]
        haff = subject.truth.scalars.get("haff_time", (np.inf, 0.0))[0]
        # Samples while the gas is still uniform.
        count = int(np.searchsorted(run.t - run.t[0], UNIFORM * haff, side="right"))
        elapsed = run.t[:count] - run.t[0]
        rounding = ROUNDINGS * subject.round_off(subject.levels[-1])
        findings = [self._temperature(gas, elapsed, temperature[:count], haff, rounding)]
        if gas.restitution == 1:
            findings.append(self._distribution(gas, run))
        contact_times = [event.time for event in run.events if event.kind == "contact"]
        if not contact_times or count < len(run.t):
            return findings
        return findings + self._collision_findings(gas, run, temperature, len(contact_times))

    def _temperature(
        self, gas: Gas, t: Array, temperature: Array, haff: float, rounding: float
    ) -> Finding:
        """ln T against Haff's law.

        ln T is a sum of the losses in all collisions so far, so its scatter is `loss_error` of
        their number. A relative error THEORY of tau shifts ln T by THEORY times

          d ln T / d ln tau = 2 (t/tau)/(1 + t/tau).

        Contacts in progress store a part w_c t_c of the energy, which also scatters. An elastic gas
        of rigid spheres has neither: `rounding`, the relative round-off of T, is left.
        """
        # T0/(1 + t/tau)^2.
        law = haff_temperature(t, temperature[0], haff)
        # N(t) = (n - 1)/2 times the integral of w_c = w_c(0) sqrt(T/T0).
        n_collisions = collisions(t, law, gas.frequency / np.sqrt(temperature[0]), gas.n)
        # d ln T / d ln tau = 2 (t/tau)/(1 + t/tau).
        tau_sensitivity = 2 * (t / haff) / (1 + t / haff)
        # w_c t_c + ERRORS sqrt(w_c t_c/n): the part of the energy that contacts store, and its
        # scatter in a gas of n spheres.
        stored = gas.softness + ERRORS * np.sqrt(gas.softness / gas.n)
        # |ln T - ln T_Haff| <= ERRORS loss_error(N) + THEORY d ln T/d ln tau + stored + round-off.
        allowed = (
            ERRORS * loss_error(gas.restitution, gas.n, n_collisions)
            + THEORY * tau_sensitivity
            + stored
            + rounding
        )
        if np.isinf(haff):
            compared = "its initial value"
        else:
            compared = "T0/(1 + t/tau)^2"
        return worst(
            check=self.name,
            quantity="temperature",
            t=t,
            values=np.abs(np.log(temperature / law)),
            allowed=allowed,
            signal=np.abs(np.log(law / law[0])),
            unit="1",
            basis=(
                f"{ERRORS:g} standard errors of the energy lost in the collisions so far,"
                f" {THEORY:.0%} of tau, the energy held in contacts, and round-off"
            ),
            what=f"The logarithm of the ratio of the temperature to {compared}",
            remedy="use more particles, or a longer run",
        )

    def _distribution(self, gas: Gas, run: Trajectory) -> Finding:
        """The excess kurtosis of the final velocities, 0 for Maxwell's distribution."""
        return judged(
            check=self.name,
            quantity="kurtosis",
            value=abs(velocity_kurtosis(run.velocity[-1])),
            bound=ERRORS * kurtosis_error(gas.n) + gas.softness,
            unit="1",
            basis=f"{ERRORS:g} standard errors of the kurtosis of 3 (n - 1) velocity components",
            what="The excess kurtosis of the velocities at the end",
        )

    def _collision_findings(
        self, gas: Gas, run: Trajectory, temperature: Array, observed: int
    ) -> list[Finding]:
        """Number of collisions against the integral of w_c; and the mean energy loss of a
        collision, in units of (1 - e^2) T.
        """
        # N(t) = (n - 1)/2 times the integral of w_c = w_c(0) sqrt(T/T(0)), T as observed.
        expected_so_far = collisions(
            run.t, temperature, gas.frequency / np.sqrt(temperature[0]), gas.n
        )
        expected = float(expected_so_far[-1])
        if expected < FEWEST:
            why = f"only {expected:.2g} collisions are expected; {FEWEST} are needed for a mean"
            return [undecided(self.name, "collisions", why)]
        # |N_observed/N - 1| <= ERRORS/sqrt(N) + THEORY + w_c t_c: the scatter of a Poisson count,
        # the error of the theory, and the duration of contacts.
        allowed = float(ERRORS / np.sqrt(expected) + THEORY + gas.softness)
        basis = f"{ERRORS:g} standard errors of the count, and {THEORY:.0%} for kinetic theory"
        count = judged(
            check=self.name,
            quantity="collisions",
            value=abs(observed / expected - 1),
            bound=allowed,
            unit="1",
            basis=basis,
            what=(
                "The relative error of the number of collisions"
                f" ({observed}, expected {expected:.5g})"
            ),
        )
        work = run.channels.get("dissipated_work")
        inelasticity = 1 - gas.restitution**2
        if work is None or not inelasticity > 0:
            return [count]
        mean_temperature = _mean_over_collisions(temperature, expected_so_far)
        # Observed loss W/N_observed of a collision over the theoretical (1 - e^2) <T>.
        loss_ratio = float(np.sum(work[-1])) / (observed * inelasticity * mean_temperature)
        loss = judged(
            check=self.name,
            quantity="loss",
            value=abs(loss_ratio - 1),
            bound=allowed + gas.lasts / float(run.t[-1] - run.t[0]),
            unit="1",
            basis=f"{basis}, and the collisions still in progress at the end",
            what="The relative error of the energy lost per collision, compared with (1 - e^2) T,",
        )
        return [count, loss]


def _mean_over_collisions(temperature: Array, n_collisions: Array) -> float:
    """The mean temperature at a collision, from samples (T,) of it and of the collisions so far.

    Each interval between samples counts as often as spheres collide in it.
    """
    # <T> = sum over intervals k of (N_(k+1) - N_k) sqrt(T_k T_(k+1)) / N(end).
    in_interval = np.diff(n_collisions)
    interval_temperature = np.sqrt(temperature[1:] * temperature[:-1])
    return float(np.sum(in_interval * interval_temperature)) / float(n_collisions[-1])


def are_alike(scene: Scene) -> bool:
    """True if all bodies have the mass and the radius of the first."""
    bodies = scene.bodies
    return bool(np.all(bodies.mass == bodies.mass[0]) and np.all(bodies.radius == bodies.radius[0]))


def _gas(scene: Scene, frequency: float) -> Gas:
    """Parameters of a gas of equal spheres.

    A rigid contact takes no time and has its restitution in its law. Under the linear law, for two
    equal masses m the overlap d obeys d'' + 2 b d' + (2 k/m) d = 0 with b = c/m, so that

      w^2 = 2 k/m - b^2,   contact time = pi/w,   restitution = exp(-pi b/w).
    """
    n = len(scene.bodies)
    law = scene.all(Contact)[0]
    # The volume of the spheres over that of the box.
    volume = 4 / 3 * np.pi * np.sum(scene.bodies.radius**3)
    (box,) = scene.all(PeriodicBox)
    packing = float(volume / box.size**3)
    if law.law == "rigid":
        return Gas(n, law.restitution, 0.0, packing, frequency)
    mass = float(scene.bodies.mass[0])
    # b = c/m,   w = sqrt(2 k/m - b^2), 0 if overdamped.
    b = law.damping / mass
    w = float(np.sqrt(max(2 * law.stiffness / mass - b**2, 0.0)))
    # Contact time pi/w: half a period of the overlap.
    if w:
        duration = np.pi / w
    else:
        duration = np.inf
    # e = exp(-pi b/w).
    restitution = 1.0
    if b:
        restitution = float(np.exp(-b * duration))
    return Gas(n, restitution, float(duration), packing, frequency)


CHECK = Cooling()
