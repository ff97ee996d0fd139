"""The apsides of an orbit: Laplace's vector for Kepler's problem, Fradkin's tensor for a spring.

  A = v x (r x v)/gm - r/|r|               points to periapsis, |A| is the eccentricity
  T = (m v v^T + k r r^T)/(2 E0)           has the principal axes of the ellipse (Fradkin 1967)

They are constant in these two fields and in no other (Bertrand's theorem), so an error that
leaves period, energy and angular momentum constant may still turn the orbit. Errors of position
along the orbit do not change them: they can be judged long after the predictability horizon of the
state.
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
    """The change of A or T at the finest level, with the angle by which the apsides have turned."""

    name = "apsides"
    title = "Apsides"
    kills = (
        "a force law that deviates from Newton's, a method whose ellipse"
        " precesses, a velocity not at the time of its position"
    )
    synchronous = True

    def applies(self, subject: Subject) -> str | None:
        """One point in a Newtonian field, or on a linear spring of natural length 0 to a fixed
        point, that does not move on a straight line.
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
        """One finding: |A - A0| or |T - T0| against the error bounds of r and v, propagated to
        first order.
        """
        run = runs[subject.finest].trajectory
        scene = subject.instance.scene
        r = run.position[:, 0]
        v = run.velocity[:, 0]
        field = _attraction(scene)
        if field:
            name = "Laplace vector"
            invariant = laplace(r, v, field.gm)
            sensitivity = _laplace_sensitivity(subject, r, v, field.gm)
        else:
            spring = scene.all(Spring)[0]
            arm = r - np.asarray(spring.anchor_b)
            name = "Fradkin tensor"
            invariant = fradkin(arm, v, float(scene.bodies.mass[0]), spring.stiffness)
            sensitivity = _fradkin_sensitivity(subject, arm, v, spring.stiffness)
        allowed, basis = subject.kept("apsides", subject.levels[-1])
        quantity = name.split()[0].lower()
        count = scored(sensitivity * allowed)
        if count < min(2, len(sensitivity)):
            why = "the bound exceeds a tenth of the orbit before the second sample"
            return [undecided(self.name, quantity, why)]
        change = np.linalg.norm((invariant - invariant[0]).reshape(len(invariant), -1), axis=1)
        return [
            worst(
                check=self.name,
                quantity=quantity,
                t=subject.instance.times[:count],
                values=change[:count],
                allowed=(sensitivity * allowed)[:count],
                signal=1.0,
                unit="1",
                basis=f"{basis}, propagated from position and velocity",
                what=(
                    f"The change of the {name} (the apsides precess by {turned(invariant):.2g} rad"
                    " over the run)"
                ),
            )
        ]


def _laplace_sensitivity(subject: Subject, r: Array, v: Array, gm: float) -> Array:
    """Change (T,) of Laplace's vector per scaled error of r and v, to first order.

    |dA| <= (2 |v| |r| dv + |v|^2 dr)/gm + dr/|r|, with dr and dv the scales of length and speed.
    """
    scales = subject.instance.scales
    distance = np.linalg.norm(r, axis=1)
    speed = np.linalg.norm(v, axis=1)
    sensitivity: Array = (
        2 * speed * distance * scales.speed + speed**2 * scales.length
    ) / gm + scales.length / distance
    return sensitivity


def _fradkin_sensitivity(subject: Subject, arm: Array, v: Array, stiffness: float) -> Array:
    """Change (T,) of Fradkin's tensor per scaled error of r and v, to first order.

    |dT| <= 2 (k |r| dr + m |v| dv)/(2 E0), with 2 E0 = m v0^2 + k r0^2, and dr and dv the scales of
    length and speed.
    """
    scales = subject.instance.scales
    mass = float(subject.instance.scene.bodies.mass[0])
    speed = np.linalg.norm(v, axis=1)
    terms = stiffness * np.linalg.norm(arm, axis=1) * scales.length + mass * speed * scales.speed
    sensitivity: Array = 2 * terms / (mass * speed[0] ** 2 + stiffness * (arm[0] @ arm[0]))
    return sensitivity


def laplace(r: Array, v: Array, gm: float) -> Array:
    """Laplace's vector A = v x (r x v)/gm - r/|r| (T, 3) of positions r and velocities v (T, 3)."""
    vector: Array = np.cross(v, np.cross(r, v)) / gm - r / np.linalg.norm(r, axis=1)[:, None]
    return vector


def fradkin(r: Array, v: Array, mass: float, stiffness: float) -> Array:
    """Fradkin's tensor (m v v^T + k r r^T)/(2 E0) (T, 3, 3), with E0 the initial energy: trace
    1.
    """
    tensor: Array = mass * v[:, :, None] * v[:, None] + stiffness * r[:, :, None] * r[:, None]
    scaled: Array = tensor / np.trace(tensor[0])
    return scaled


def turned(invariant: Array) -> float:
    """Angle [rad] between the first and the last apsidal line.

    Of vectors (T, 3) it is that of their directions; of tensors (T, 3, 3) that of the axes of the
    largest eigenvalue. A circle has no apsides: 0.
    """
    if invariant.ndim == 2:
        first = invariant[0]
        last = invariant[-1]
        cosine = float(first @ last)
    else:
        # The sign of an eigenvector is arbitrary, so the angle is that between two lines.
        first = np.linalg.eigh(invariant[0])[1][:, -1]
        last = np.linalg.eigh(invariant[-1])[1][:, -1]
        cosine = abs(float(first @ last))
    sine = np.linalg.norm(np.cross(first, last))
    return float(np.arctan2(sine, cosine))


def _attraction(scene: Scene) -> CentralField | None:
    """The central field, if it is the only element; else None."""
    fields = scene.all(CentralField)
    if len(scene.elements) == len(fields) == 1:
        return fields[0]
    return None


def _spring(scene: Scene) -> bool:
    """True if the only element is a linear spring of natural length 0 between the body's centre and
    the world.
    """
    springs = scene.all(Spring)
    if not len(scene.elements) == len(springs) == 1:
        return False
    spring = springs[0]
    linear = spring.length == 0 and spring.exponent == 1 and not (spring.quadratic or spring.cubic)
    return linear and spring.stiffness > 0 and spring.b < 0 and not any(spring.anchor_a)


CHECK = Apsides()
