"""A gas of perfectly rough elastic spheres, initially without spin: kinetic energy is shared
between translation and rotation, and none is lost.

`mechanics.gas.rough_temperatures` has the kinetic theory: rotational temperature rises towards the
translational one, by collisions in which spheres stick and reverse their relative surface velocity.
"""

from collections.abc import Mapping

import numpy as np

from refdem.checks.cooling import DILUTE, ERRORS, FEWEST, SHORT, THEORY, are_alike
from refdem.core.balance import mechanical
from refdem.core.check import Check, CompletedRun, Subject
from refdem.core.finding import Finding
from refdem.core.judgement import Array, undecided, worst
from refdem.core.trajectory import Trajectory
from refdem.core.variant import Variant
from refdem.mechanics.gas import collisions, rough_temperatures
from refdem.scene import Scene
from refdem.scene.elements.contact import Contact
from refdem.scene.elements.periodic_box import PeriodicBox

IN_TUNE = 1e-6
"""Relative tolerance of k_t (1/m_eff + 1/J_eff) = k/m_eff, for which tangential and normal
oscillation of a contact last equally long.
"""
NEVER_SLIDES = 100.0
"""Friction coefficient from which the share (k_t/(k mu))^2 of collisions that are so oblique that
they slide is below 1e-5.
"""


class Roughness(Check):
    """Means over many collisions of sticking spheres: elongation that a tangential spring forgets
    is energy that the gas loses.
    """

    name = "roughness"
    title = "Spin of a rough gas"
    kills = (
        "tangential springs lost when a neighbour list is rebuilt, missing"
        " torques or lever arms, spins of only one of two bodies"
    )
    synchronous = True

    def applies(self, subject: Subject) -> str | None:
        """Equal elastic spheres in a periodic box, without initial spin, that stick in every
        contact and reverse their slip.
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
        reverses_slip = (
            abs(laws[0].tangential_stiffness * (1 + 1 / _inertia(scene)) / laws[0].stiffness - 1)
            < IN_TUNE
        )
        if reverses_slip and not scene.bodies.omega.any():
            return None
        return "the contacts do not reverse their slip, or bodies spin initially"

    def needs(self, subject: Subject) -> tuple[Variant, ...]:
        """The plain run at the finest level."""
        return (subject.finest,)

    def judge(self, subject: Subject, runs: Mapping[Variant, CompletedRun]) -> list[Finding]:
        """Two findings: the total energy, and the rotational temperature against kinetic theory."""
        if subject.truth is None or "collision_frequency" not in subject.truth.scalars:
            return [undecided(self.name, "energy", "the collision frequency is not certified")]
        scene = subject.instance.scene
        run = runs[subject.finest].trajectory
        frequency = subject.truth.scalars["collision_frequency"][0]
        n = len(scene.bodies)
        packing, softness = _packing_and_softness(scene, frequency)
        if packing > DILUTE or softness > SHORT:
            why = (
                f"collisions are not binary: the packing fraction is {packing:.2g} and"
                f" contact time times collision frequency is {softness:.2g}"
            )
            return [undecided(self.name, "energy", why)]
        t = run.t - run.t[0]
        t0 = subject.instance.p.t0
        translational, rotational = rough_temperatures(t, t0, frequency, _inertia(scene))
        n_collisions = collisions(t, translational, frequency / np.sqrt(t0), n)
        expected = n_collisions[-1]
        if expected < FEWEST:
            why = f"only {expected:.2g} collisions are expected; {FEWEST} are needed for a mean"
            return [undecided(self.name, "spin", why)]
        # The part of the energy that contacts in progress store, and its scatter.
        stored = softness + ERRORS * np.sqrt(softness / n)
        # Rotational temperature: sum J omega^2 over the 3 n degrees of freedom.
        observed = np.einsum("nk,tnk->t", scene.bodies.inertia, run.omega**2) / (3 * n)
        error = np.abs(observed - rotational) / t0
        # The gain is a sum over the collisions so far, of relative standard error sqrt(2/number).
        scatter = ERRORS * rotational / t0 * np.sqrt(2 / np.maximum(n_collisions, 1))
        return [
            self._energy(scene, run, stored),
            self._spin(run, error, scatter + THEORY + stored),
        ]

    def _energy(self, scene: Scene, run: Trajectory, stored: float) -> Finding:
        """The finding that the total energy is constant, up to the part `stored` in contacts."""
        energy = mechanical(scene, run)
        return worst(
            check=self.name,
            quantity="energy",
            t=run.t,
            values=np.abs(energy / energy[0] - 1),
            allowed=stored,
            unit="1",
            basis=(
                "energy held in contacts that last, and lost in those of three bodies:"
                " contact time times collision frequency"
            ),
            what="The relative change of kinetic, rotational and contact energy",
        )

    def _spin(self, run: Trajectory, error: Array, allowed: Array) -> Finding:
        """The finding on the rotational temperature, both (T,) in units of the initial one."""
        return worst(
            check=self.name,
            quantity="spin",
            t=run.t,
            values=error,
            allowed=allowed,
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


def _packing_and_softness(scene: Scene, frequency: float) -> tuple[float, float]:
    """Packing fraction, and contact time times collision frequency (both [1]).

    n spheres of radius R in a box of edge L fill n pi/6 (2 R/L)^3 of it. An undamped contact of two
    masses m lasts pi sqrt(m/(2 k)).
    """
    bodies = scene.bodies
    law = scene.all(Contact)[0]
    box = scene.all(PeriodicBox)[0]
    mass = float(bodies.mass[0])
    packing = len(bodies) * np.pi / 6 * (2 * bodies.radius[0] / box.size) ** 3
    softness = frequency * np.pi * np.sqrt(mass / (2 * law.stiffness))
    return float(packing), float(softness)


def _inertia(scene: Scene) -> float:
    """J/(m R^2): 2/5 for a homogeneous sphere."""
    bodies = scene.bodies
    return float(bodies.inertia[0, 0] / (bodies.mass[0] * bodies.radius[0] ** 2))


CHECK = Roughness()
