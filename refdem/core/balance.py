"""Energy, momentum and angular momentum of a scene along a trajectory, with the scales that make their errors numbers."""

import numpy as np
from numpy.typing import NDArray

from refdem.core.case import Instance
from refdem.core.trajectory import Trajectory
from refdem.mechanics import energy, momentum
from refdem.scene import Scene
from refdem.scene.elements.central_field import CentralField
from refdem.scene.elements.contact import Contact
from refdem.scene.elements.spring import Spring
from refdem.scene.elements.uniform_gravity import UniformGravity

Array = NDArray[np.float64]


def kinetic(scene: Scene, run: Trajectory) -> Array:
    """Kinetic energy (T,) [J]."""
    return energy.kinetic(scene.bodies.mass, scene.bodies.inertia, run.velocity, run.attitude, run.omega)


def mechanical(scene: Scene, run: Trajectory) -> Array:
    """Kinetic and potential energy (T,) [J]."""
    return kinetic(scene, run) + scene.potential(run.position, run.attitude)


def energy_scale(instance: Instance) -> float:
    """Kinetic energy and size of the potential at the start [J]; m (L/tau)^2 if both are zero.

    The zero of a weight's potential is where the origin is: there it counts at least as the kinetic energy m (L/tau)^2 / 2.
    """
    bodies = instance.scene.bodies
    start = Trajectory(t=np.zeros(1), **{name: getattr(bodies, name)[None] for name in ("position", "velocity", "attitude", "omega")})
    size = kinetic(instance.scene, start)[0] + abs(instance.scene.potential(start.position, start.attitude)[0])
    if instance.scene.all(UniformGravity):
        size = max(size, instance.scales.energy / 2)
    return float(size) or instance.scales.energy


def linear(scene: Scene, run: Trajectory) -> Array:
    """Momentum (T, 3) [kg m/s]."""
    return momentum.linear(scene.bodies.mass, run.velocity)


def momentum_scale(instance: Instance) -> float:
    """Sum of m |v| at the start [kg m/s]; m L/tau if nothing moves."""
    bodies = instance.scene.bodies
    return float(bodies.mass @ np.linalg.norm(bodies.velocity, axis=1)) or instance.scales.mass * instance.scales.speed


def angular(scene: Scene, run: Trajectory) -> dict[str, Array]:
    """Orbital, spin and total angular momentum about the origin, each (T, 3) [kg m^2/s]."""
    bodies = scene.bodies
    orbital = momentum.orbital(bodies.mass, run.position, run.velocity)
    spin = momentum.spin(bodies.inertia, run.attitude, run.omega)
    return {"orbital": orbital, "spin": spin, "total": orbital + spin}


def angular_scale(instance: Instance) -> float:
    """Sum of m |r| |v| + |J omega| at the start [kg m^2/s]; m L^2/tau if nothing moves.

    Bodies on which nothing acts fly as far as they go: |r| is then the farthest, for r x v is rounded on its scale.
    """
    bodies = instance.scene.bodies
    speed = np.linalg.norm(bodies.velocity, axis=1)
    flight = 0.0 if instance.scene.elements else instance.scales.duration * speed
    orbital = bodies.mass @ ((np.linalg.norm(bodies.position, axis=1) + flight) * speed)
    spin = np.sum(bodies.inertia.max(axis=1) * np.linalg.norm(bodies.omega, axis=1))
    return float(orbital + spin) or instance.scales.mass * instance.scales.length * instance.scales.speed


def torque_reason(scene: Scene) -> str | None:
    """None if no torque about the origin acts from outside, else where one comes from."""
    for element in scene.elements:
        if isinstance(element, Contact) and element.friction > 0 and element.branch != "R-d/2":
            return f"the branch vectors {element.branch} do not sum to the centre distance, so the contact law itself changes it"
        central = isinstance(element, CentralField) or (
            isinstance(element, Spring) and not any(element.anchor_a) and not (element.b < 0 and any(element.anchor_b))
        )
        if element.external and not central:
            return f"the element {element.kind} exerts a torque from outside"
    return "a body is fixed" if scene.bodies.fixed.any() else None
