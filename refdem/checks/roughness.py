"""How a gas of perfectly rough elastic spheres begins to spin: energy of flight and of spin are
shared out, and none is lost.
"""

from collections.abc import Mapping

import numpy as np

from refdem.checks.cooling import DILUTE, ERRORS, FEWEST, SHORT, THEORY, are_alike
from refdem.core.balance import mechanical
from refdem.core.check import Check, CompletedRun, Subject
from refdem.core.finding import Finding
from refdem.core.judgement import undecided, worst
from refdem.core.variant import Variant
from refdem.mechanics.gas import collisions, rough_temperatures
from refdem.scene import Scene
from refdem.scene.elements.contact import Contact
from refdem.scene.elements.periodic_box import PeriodicBox

IN_TUNE = 1e-6
"""Relative: tangential and normal swing last equally long if k_t (1/m_eff + 1/J_eff) is k/m_eff."""
NEVER_SLIDES = 100.0
"""Friction from which (k_t/(k mu))^2, the part of collisions so oblique that they slide, is below
1e-5.
"""


class Roughness(Check):
    """Means over many collisions of spheres that stick: what a tangential spring forgets is energy
    that the gas loses.
    """

    name = "roughness"
    title = "Spin of a rough gas"
    kills = (
        "tangential springs lost when a neighbour list is rebuilt, missing"
        " torques or lever arms, spins of only one of two bodies"
    )
    synchronous = True

    def applies(self, subject: Subject) -> str | None:
        """Equal elastic spheres in a periodic box that stick in every contact, do not spin at
        first, and swing back in time.
        """
        scene = subject.instance.scene
        if "temperature" not in subject.instance.quantities or not scene.all(PeriodicBox):
            return "the scene is not a gas in a periodic box"
        if not are_alike(scene):
            return "the spheres differ, and kinetic theory is for equal ones"
        laws = scene.all(Contact)
        if (
            len(laws) != 1
            or laws[0].law != "linear"
            or laws[0].damping
            or laws[0].friction < NEVER_SLIDES
        ):
            return "the spheres are not both elastic and perfectly rough"
        in_tune = (
            abs(laws[0].tangential_stiffness * (1 + 1 / _inertia(scene)) / laws[0].stiffness - 1)
            < IN_TUNE
        )
        if in_tune and not scene.bodies.omega.any():
            return None
        return "the contacts do not reverse their slip, or bodies spin initially"

    def needs(self, subject: Subject) -> tuple[Variant, ...]:
        """The plain run at the finest level."""
        return (subject.finest,)

    def judge(self, subject: Subject, runs: Mapping[Variant, CompletedRun]) -> list[Finding]:
        """All of the energy, and the part of it that is in spins."""
        if subject.truth is None or "collision_frequency" not in subject.truth.scalars:
            return [undecided(self.name, "energy", "the collision frequency is not certified")]
        scene = subject.instance.scene
        run = runs[subject.finest].trajectory
        frequency = subject.truth.scalars["collision_frequency"][0]
        n = len(scene.bodies)
        mass = float(scene.bodies.mass[0])
        law = scene.all(Contact)[0]
        temperature = subject.instance.p.t0
        soft = frequency * np.pi * np.sqrt(mass / (2 * law.stiffness))
        packing = n * np.pi / 6 * (2 * scene.bodies.radius[0] / scene.all(PeriodicBox)[0].size) ** 3
        if packing > DILUTE or soft > SHORT:
            return [
                undecided(
                    self.name,
                    "energy",
                    (
                        f"collisions are not binary: the packing fraction is {packing:.2g} and"
                        f" contact time times collision frequency is {soft:.2g}"
                    ),
                )
            ]
        t = run.t - run.t[0]
        flight, spin = rough_temperatures(t, temperature, frequency, _inertia(scene))
        met = collisions(t, flight, frequency / np.sqrt(temperature), n)
        if met[-1] < FEWEST:
            return [
                undecided(
                    self.name,
                    "spin",
                    f"only {met[-1]:.2g} collisions are expected; {FEWEST} are needed for a mean",
                )
            ]
        energy = mechanical(scene, run)
        held = soft + ERRORS * np.sqrt(soft / n)
        seen = np.einsum("nk,tnk->t", scene.bodies.inertia, run.omega**2) / (3 * n)
        energies = worst(
            check=self.name,
            quantity="energy",
            t=run.t,
            values=np.abs(energy / energy[0] - 1),
            allowed=held,
            unit="1",
            basis=(
                "energy held in contacts that last, and lost in those of three bodies:"
                " contact time times collision frequency"
            ),
            what="The relative change of kinetic, rotational and contact energy",
        )
        spins = worst(
            check=self.name,
            quantity="spin",
            t=run.t,
            values=np.abs(seen - spin) / temperature,
            allowed=ERRORS * spin / temperature * np.sqrt(2 / np.maximum(met, 1)) + THEORY + held,
            unit="1",
            basis=(
                f"{ERRORS:g} standard errors of the gain in the collisions so far,"
                f" {THEORY:.0%} for kinetic theory, and the energy held in contacts"
            ),
            what=(
                "The error of the rotational temperature against kinetic theory, relative"
                " to the initial temperature,"
            ),
        )
        return [energies, spins]


def _inertia(scene: Scene) -> float:
    """4 J/(m d^2): 2/5 of a homogeneous sphere."""
    bodies = scene.bodies
    return float(bodies.inertia[0, 0] / (bodies.mass[0] * bodies.radius[0] ** 2))


CHECK = Roughness()
