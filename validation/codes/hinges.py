"""A chain of points on rods in a plane as a chain of hinges, for codes with minimal coordinates."""

from dataclasses import dataclass

import numpy as np
from served import cannot

LEAST_SINE = 1e-12
"""Below which two directions are one, and a vector lies in a plane."""


@dataclass(frozen=True)
class Hinge:
    """The hinge at the upper end of a rod.

    `number` of the body at its end; `at` (3) [m], the place of the hinge as the hinge before it has
    it; `arm` (3) [m] from the hinge to the body; `rate` [rad/s] relative to the rod before.
    """

    number: int
    at: np.ndarray
    arm: np.ndarray
    rate: float


def hinges(scene):
    """The axis (3) of all hinges, and the hinges from the world on.

    Raises UnsupportedError for rods that are no such chain.
    """
    numbers, pivot = scene.chain()
    bodies = [scene.bodies[number] for number in numbers]
    cannot(any(any(body["inertia"]) for body in bodies), "rods between bodies that turn")
    axis = normal(scene, bodies, np.array(pivot))
    found = []
    at = np.array(pivot)
    above = {"position": pivot, "velocity": [0.0, 0.0, 0.0]}
    turned = 0.0
    for number, body in zip(numbers, bodies, strict=True):
        arm = np.array(body["position"]) - above["position"]
        moving = np.array(body["velocity"]) - above["velocity"]
        # omega = n . (r x v) / r^2, of which the hinge has what the rod before it has not.
        omega = axis @ np.cross(arm, moving) / (arm @ arm)
        found.append(Hinge(number, at, arm, omega - turned))
        at = arm
        above = body
        turned = omega
    return axis, found


def normal(scene, bodies, pivot):
    """The unit normal of the plane in which all points stay."""
    arms = [np.array(body["position"]) - pivot for body in bodies]
    velocities = [np.array(body["velocity"]) for body in bodies]
    vectors = [*arms, *velocities, np.array(scene.gravity)]
    crossed = max((np.cross(arms[0], other) for other in vectors), key=np.linalg.norm)
    size = np.linalg.norm(crossed)
    if size < LEAST_SINE * np.linalg.norm(arms[0]):
        # All lies along one line: any plane that holds it will do.
        axis = np.eye(3)[np.argmin(np.abs(arms[0]))]
        crossed = np.cross(arms[0], axis)
        size = np.linalg.norm(crossed)
    unit = crossed / size
    out = max(abs(unit @ vector) / (1 + np.linalg.norm(vector)) for vector in vectors)
    cannot(out > LEAST_SINE, "rods that move in space")
    return unit
