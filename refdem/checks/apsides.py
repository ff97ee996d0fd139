"""The shape of an orbit that does not turn: Laplace's vector of Kepler's problem, Fradkin's tensor
of a spring in space.

A = v x (r x v)/gm - r/|r| points to periapsis and is as long as the eccentricity; T = (m v v^T + k
r r^T)/(2 E0) has the axes of the ellipse (Fradkin 1967). Both stay in these two fields and in no
other (Bertrand), so that what gives an orbit its right period and keeps its energy and its angular
momentum may still turn it. Errors along the orbit do not count: long after the horizon these do.
"""

from collections.abc import Mapping

import numpy as np

from refdem.core.check import Check, CompletedRun, Subject
from refdem.core.finding import Finding
from refdem.core.judgement import Array, undecided, worst
from refdem.core.refinement import scored
from refdem.core.variant import Variant
from refdem.scene import Scene
from refdem.scene.elements.central_field import CentralField
from refdem.scene.elements.spring import Spring


class Apsides(Check):
    """The change of the vector or of the tensor at the finest level, and by what angle the apsides
    have turned.
    """

    name = "apsides"
    title = "Apsides"
    kills = (
        "a force law that deviates from Newton's, a method whose ellipse"
        " precesses, a velocity not at the time of its position"
    )
    synchronous = True

    def applies(self, subject: Subject) -> str | None:
        """One point under one Newtonian attraction, or one linear spring of no length to a fixed
        point, off a straight line.
        """
        scene = subject.instance.scene
        if (
            len(scene.bodies) != 1
            or scene.bodies.fixed.any()
            or not (_attraction(scene) or _spring(scene))
        ):
            return "no body orbits in a field that conserves its apsides"
        if "dimension:1" in scene.features:
            return "the body moves on a straight line"
        return None

    def needs(self, subject: Subject) -> tuple[Variant, ...]:
        """The plain run at the finest level."""
        return (subject.finest,)

    def judge(self, subject: Subject, runs: Mapping[Variant, CompletedRun]) -> list[Finding]:
        """Against what errors of place and velocity, each within its bound, change it by."""
        run = runs[subject.finest].trajectory
        scene = subject.instance.scene
        scales = subject.instance.scales
        r = run.position[:, 0]
        v = run.velocity[:, 0]
        distance = np.linalg.norm(r, axis=1)
        speed = np.linalg.norm(v, axis=1)
        field = _attraction(scene)
        if field:
            kept = laplace(r, v, field.gm)
            name = "Laplace vector"
            share = (
                2 * speed * distance * scales.speed + speed**2 * scales.length
            ) / field.gm + scales.length / distance
        else:
            spring = scene.all(Spring)[0]
            place = r - np.asarray(spring.anchor_b)
            mass = float(scene.bodies.mass[0])
            kept = fradkin(place, v, mass, spring.stiffness)
            name = "Fradkin tensor"
            arms = (
                spring.stiffness * np.linalg.norm(place, axis=1) * scales.length
                + mass * speed * scales.speed
            )
            share = 2 * arms / (mass * speed[0] ** 2 + spring.stiffness * (place[0] @ place[0]))
        allowed, basis = subject.kept("apsides", subject.levels[-1])
        quantity = name.split()[0].lower()
        count = scored(share * allowed)
        if count < min(2, len(share)):
            return [
                undecided(
                    self.name,
                    quantity,
                    "the bound exceeds a tenth of the orbit before the second sample",
                )
            ]
        change = np.linalg.norm((kept - kept[0]).reshape(len(kept), -1), axis=1)
        return [
            worst(
                check=self.name,
                quantity=quantity,
                t=subject.instance.times[:count],
                values=change[:count],
                allowed=(share * allowed)[:count],
                signal=1.0,
                unit="1",
                basis=f"{basis}, propagated from position and velocity",
                what=(
                    f"The change of the {name} (the apsides precess by {turned(kept):.2g} rad"
                    " over the run)"
                ),
            )
        ]


def laplace(r: Array, v: Array, gm: float) -> Array:
    """Laplace's vector (T, 3), of the length of the eccentricity, of places and velocities (T,
    3).
    """
    vector: Array = np.cross(v, np.cross(r, v)) / gm - r / np.linalg.norm(r, axis=1)[:, None]
    return vector


def fradkin(r: Array, v: Array, mass: float, stiffness: float) -> Array:
    """Fradkin's tensor (T, 3, 3) over the energy at the start, so that its trace is 1."""
    tensor: Array = mass * v[:, :, None] * v[:, None] + stiffness * r[:, :, None] * r[:, None]
    scaled: Array = tensor / np.trace(tensor[0])
    return scaled


def turned(kept: Array) -> float:
    """Angle [rad] between the first and the last long axis; 0 where a circle has none."""
    if kept.ndim == 2:
        first = kept[0]
        last = kept[-1]
        along = float(first @ last)
    else:
        # An eigenvector has no sense: the angle is that of two lines.
        first = np.linalg.eigh(kept[0])[1][:, -1]
        last = np.linalg.eigh(kept[-1])[1][:, -1]
        along = abs(float(first @ last))
    across = np.linalg.norm(np.cross(first, last))
    return float(np.arctan2(across, along))


def _attraction(scene: Scene) -> CentralField | None:
    """The attraction, if nothing else acts."""
    found = scene.all(CentralField)
    if len(scene.elements) == len(found) == 1:
        return found[0]
    return None


def _spring(scene: Scene) -> bool:
    """One linear spring of no length between the point and the world, and nothing else."""
    found = scene.all(Spring)
    if not len(scene.elements) == len(found) == 1:
        return False
    law = found[0]
    linear = law.length == 0 and law.exponent == 1 and not (law.quadratic or law.cubic)
    return linear and law.stiffness > 0 and law.b < 0 and not any(law.anchor_a)


CHECK = Apsides()
