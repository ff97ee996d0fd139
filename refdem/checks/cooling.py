"""How a gas cools: Haff's law, how often spheres meet and what a meeting costs, and Maxwell's
velocities of an elastic one.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

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
"""Standard errors allowed: of 1e4 right gases one is beyond."""
THEORY = 0.01
"""What the theory leaves out: velocities that are not quite Maxwell's (3/16 a2), and chi."""
DILUTE = 0.1
SHORT = 0.05
ROUGHEST = 0.5
"""The theory holds below this packing fraction, contact time times w_c, and above this restitution
(a2 then stays below 0.06).
"""
UNIFORM = 2.0
"""In units of tau: velocities that vary in space fall slower than thermal ones, by 1 + t/tau, and
at last make clusters.
"""
FEWEST = 30
"""Collisions from which a mean is taken."""


@dataclass(frozen=True, eq=False)
class Gas:
    """What the scene says of the gas: number, restitution, contact time [s], packing fraction, and
    w_c [1/s] at the start from truth.
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
        """None where the theory holds, else the assumption that does not."""
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
    """A mean over many collisions, judged by its standard error: no two gases cool alike."""

    name = "cooling"
    title = "Cooling of a gas"
    kills = (
        "collisions missed by a stale neighbour list, periodic images off by one"
        " box, a wrong restitution, pairs counted twice"
    )
    synchronous = True

    def applies(self, subject: Subject) -> str | None:
        """Equal smooth spheres in a periodic box."""
        scene = subject.instance.scene
        laws = subject.instance.scene.all(Contact)
        if "temperature" not in subject.instance.quantities or not scene.all(PeriodicBox):
            return "the scene is not a gas in a periodic box"
        if not are_alike(scene):
            return "the spheres differ, and kinetic theory is for equal ones"
        if len(laws) == 1 and laws[0].law == "linear" and not laws[0].friction:
            return None
        return "the contact law is not linear and frictionless"

    def needs(self, subject: Subject) -> tuple[Variant, ...]:
        """The plain run at the finest level."""
        return (subject.finest,)

    def judge(self, subject: Subject, runs: Mapping[Variant, CompletedRun]) -> list[Finding]:
        """Temperature, number of collisions, energy lost in one, shape of the distribution: what
        the run shows of them.
        """
        if subject.truth is None or "collision_frequency" not in subject.truth.scalars:
            return [undecided(self.name, "temperature", "the collision frequency is not certified")]
        gas = _gas(subject.instance.scene, subject.truth.scalars["collision_frequency"][0])
        run = runs[subject.finest].trajectory
        if (doubt := gas.doubt()) is not None:
            return [undecided(self.name, "temperature", doubt)]
        temperature = subject.instance.observe(run)["temperature"]
        haff = subject.truth.scalars.get("haff_time", (np.inf, 0.0))[0]
        count = int(np.searchsorted(run.t - run.t[0], UNIFORM * haff, side="right"))
        found = [self._temperature(gas, run.t[:count] - run.t[0], temperature[:count], haff)]
        if gas.restitution == 1:
            found.append(self._distribution(gas, run))
        begins = [event.time for event in run.events if event.kind == "contact"]
        if not begins or count < len(run.t):
            return found
        return found + self._meetings(gas, run, temperature, len(begins))

    def _temperature(self, gas: Gas, t: Array, temperature: Array, haff: float) -> Finding:
        """ln T against Haff's law: its scatter is that of the sum of the losses in the collisions
        so far.
        """
        law = haff_temperature(t, temperature[0], haff)
        met = collisions(t, law, gas.frequency / np.sqrt(temperature[0]), gas.n)
        grown = 2 * (t / haff) / (1 + t / haff)
        stored = gas.softness + ERRORS * np.sqrt(gas.softness / gas.n)
        allowed = ERRORS * loss_error(gas.restitution, gas.n, met) + THEORY * grown + stored
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
                f" {THEORY:.0%} of tau, and the energy held in contacts"
            ),
            what=f"The logarithm of the ratio of the temperature to {compared}",
        )

    def _distribution(self, gas: Gas, run: Trajectory) -> Finding:
        """The excess of the fourth moment, which Maxwell's distribution does not have."""
        return judged(
            check=self.name,
            quantity="kurtosis",
            value=abs(velocity_kurtosis(run.velocity[-1])),
            bound=ERRORS * kurtosis_error(gas.n) + gas.softness,
            unit="1",
            basis=f"{ERRORS:g} standard errors of the kurtosis of 3 (n - 1) velocity components",
            what="The excess kurtosis of the velocities at the end",
        )

    def _meetings(self, gas: Gas, run: Trajectory, temperature: Array, seen: int) -> list[Finding]:
        """How many collisions, and what each has cost in units of (1 - e^2) T."""
        met = collisions(run.t, temperature, gas.frequency / np.sqrt(temperature[0]), gas.n)
        expected = float(met[-1])
        given = 1 - gas.restitution**2
        if expected < FEWEST:
            return [
                undecided(
                    self.name,
                    "collisions",
                    (
                        f"only {expected:.2g} collisions are expected; {FEWEST} are needed for a"
                        " mean"
                    ),
                )
            ]
        allowed = ERRORS / np.sqrt(expected) + THEORY + gas.softness
        counted = (
            f"The relative error of the number of collisions ({seen}, expected {expected:.5g})"
        )
        of = f"{ERRORS:g} standard errors of the count, and {THEORY:.0%} for kinetic theory"
        more: dict[str, Any] = {
            "check": self.name,
            "unit": "1",
            "bound": float(allowed),
            "basis": of,
        }
        found = [
            judged(
                quantity="collisions",
                value=abs(seen / expected - 1),
                what=f"{counted}",
                **more,
            )
        ]
        work = run.channels.get("dissipated_work")
        if work is not None and given > 0:
            mean = (
                float(np.sum(np.diff(met) * np.sqrt(temperature[1:] * temperature[:-1]))) / expected
            )
            lost = float(np.sum(work[-1])) / (seen * given * mean)
            what = "The relative error of the energy lost per collision, compared with (1 - e^2) T,"
            more |= {"bound": float(allowed) + gas.lasts / float(run.t[-1] - run.t[0])}
            more |= {"basis": f"{of}, and the collisions still in progress at the end"}
            found.append(judged(quantity="loss", value=abs(lost - 1), what=what, **more))
        return found


def are_alike(scene: Scene) -> bool:
    """All bodies have the mass and the radius of the first."""
    bodies = scene.bodies
    return bool(np.all(bodies.mass == bodies.mass[0]) and np.all(bodies.radius == bodies.radius[0]))


def _gas(scene: Scene, frequency: float) -> Gas:
    """Restitution exp(-pi b/w) and duration pi/w of the linear law, b = c/m, w^2 = 2 k/m - b^2, for
    equal masses.
    """
    law = scene.all(Contact)[0]
    mass = float(scene.bodies.mass[0])
    n = len(scene.bodies)
    damping = law.damping / mass
    swing = float(np.sqrt(max(2 * law.stiffness / mass - damping**2, 0.0)))
    if swing:
        lasts = np.pi / swing
    else:
        lasts = np.inf
    # The volume of the spheres over that of the box.
    volume = 4 / 3 * np.pi * np.sum(scene.bodies.radius**3)
    (box,) = scene.all(PeriodicBox)
    packing = volume / box.size**3
    restitution = 1.0
    if damping:
        restitution = float(np.exp(-damping * lasts))
    return Gas(n, restitution, float(lasts), float(packing), frequency)


CHECK = Cooling()
