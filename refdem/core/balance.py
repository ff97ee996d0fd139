"""Energy, momentum and angular momentum of a scene along a trajectory, with the scales that make
their errors numbers.
"""

import numpy as np
from numpy.typing import NDArray

from refdem.core.case import Instance
from refdem.core.trajectory import Trajectory
from refdem.mechanics import energy, momentum
from refdem.scene import Scene
from refdem.scene.elements.catch import Catch
from refdem.scene.elements.central_field import CentralField
from refdem.scene.elements.contact import Contact
from refdem.scene.elements.dashpot import Dashpot
from refdem.scene.elements.drag import Drag
from refdem.scene.elements.periodic_box import PeriodicBox
from refdem.scene.elements.rod import Rod
from refdem.scene.elements.spring import Spring
from refdem.scene.elements.uniform_gravity import UniformGravity

Array = NDArray[np.float64]

ALONG_THE_LINE = (Spring, Rod, Catch)
"""Links whose force points along the line between their anchors."""


def kinetic(scene: Scene, run: Trajectory) -> Array:
    """Kinetic energy (T,) [J] of the bodies, and of what elements move (a wheel)."""
    own = energy.kinetic(
        scene.bodies.mass, scene.bodies.inertia, run.velocity, run.attitude, run.omega
    )
    total: Array = np.sum(
        [own, *(element.kinetic(scene, run.velocity) for element in scene.elements)], axis=0
    )
    return total


def mechanical(scene: Scene, run: Trajectory) -> Array:
    """Kinetic plus potential energy (T,) [J] of the scene."""
    return kinetic(scene, run) + scene.potential(run.position, run.attitude)


def energy_scale(instance: Instance) -> float:
    """Kinetic energy and size of the potential at the start [J]; m (L/tau)^2 if both are zero.

    The zero of a weight's potential is where the origin is, that of a spring which pushes is on a
    hill, and a drive may find everything at rest: there it counts at least as the kinetic energy m
    (L/tau)^2 / 2. Where the square or the cube of a spring pushes against its linear part, both
    count.
    """
    bodies = instance.scene.bodies
    start = Trajectory(
        t=np.zeros(1),
        **{
            name: getattr(bodies, name)[None]
            for name in ("position", "velocity", "attitude", "omega")
        },
    )
    held = [abs(instance.scene.potential(start.position, start.attitude)[0])]
    held += [
        spring.potential_size(start.position, start.attitude)[0]
        for spring in instance.scene.all(Spring)
    ]
    size = kinetic(instance.scene, start)[0] + max(held)
    pushes = any(spring.stiffness < 0 for spring in instance.scene.all(Spring))
    if instance.scene.all(UniformGravity) or instance.scene.is_driven() or pushes:
        size = max(size, instance.scales.energy / 2)
    return float(size) or instance.scales.energy


def linear(scene: Scene, run: Trajectory) -> Array:
    """Total linear momentum (T, 3) [kg m/s]."""
    return momentum.linear(scene.bodies.mass, run.velocity)


def momentum_scale(instance: Instance) -> float:
    """Sum of m |v| at the start [kg m/s]; m L/tau if nothing moves."""
    bodies = instance.scene.bodies
    return (
        float(bodies.mass @ np.linalg.norm(bodies.velocity, axis=1))
        or instance.scales.mass * instance.scales.speed
    )


def angular(scene: Scene, run: Trajectory) -> dict[str, Array]:
    """Orbital, spin and total angular momentum about the origin, each (T, 3) [kg m^2/s]."""
    bodies = scene.bodies
    orbital = momentum.orbital(bodies.mass, run.position, run.velocity)
    spin = momentum.spin(bodies.inertia, run.attitude, run.omega)
    return {"orbital": orbital, "spin": spin, "total": orbital + spin}


def angular_scale(instance: Instance) -> float:
    """Sum of m |r| |v| + |J omega| at the start [kg m^2/s]; m L^2/tau if nothing moves.

    Bodies on which nothing acts fly as far as they go: |r| is then the farthest, for r x v is
    rounded on its scale.
    """
    bodies = instance.scene.bodies
    speed = np.linalg.norm(bodies.velocity, axis=1)
    if instance.scene.elements:
        flight = 0.0
    else:
        flight = instance.scales.duration * speed
    orbital = bodies.mass @ ((np.linalg.norm(bodies.position, axis=1) + flight) * speed)
    spin = np.sum(bodies.inertia.max(axis=1) * np.linalg.norm(bodies.omega, axis=1))
    return (
        float(orbital + spin)
        or instance.scales.mass * instance.scales.length * instance.scales.speed
    )


def torque_reason(scene: Scene) -> str | None:
    """None if no torque about the origin acts from outside, else where one comes from."""
    for element in scene.elements:
        if isinstance(element, Contact) and element.friction > 0 and element.branch != "R-d/2":
            return (
                f"the branch vectors {element.branch} do not sum to the centre distance,"
                " so the contact law itself changes it"
            )
        if isinstance(element, Dashpot | Drag) and element.b >= 0:
            return (
                f"a {element.kind} also resists transverse motion of its ends and so exerts a"
                " torque"
            )
        if isinstance(element, PeriodicBox):
            return "forces between periodic images do not act along one line"
        central = isinstance(element, CentralField) or (
            isinstance(element, ALONG_THE_LINE)
            and not any(element.anchor_a)
            and not (element.b < 0 and any(element.anchor_b))
        )
        if element.external and not central:
            return f"the element {element.kind} exerts an external torque"
    if scene.bodies.fixed.any():
        return "a body is fixed"
    return None
