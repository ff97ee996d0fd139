"""Energy, momentum and angular momentum of a scene along a trajectory, and a scale for each.

    E = sum (m v.v / 2 + omega.J omega / 2) + potential of every element       [J]
    p = sum m v                                                               [kg m/s]
    L = sum (m r x v + J omega), about the origin of space                    [kg m^2/s]

A check divides the error of each by its scale, so that bounds are numbers without a unit.
"""

import numpy as np
from numpy.typing import NDArray

from refdem.core.case import Instance
from refdem.core.once import once_for_each, once_with_arguments
from refdem.core.trajectory import Trajectory
from refdem.mechanics import energy, momentum
from refdem.scene import Scene

Array = NDArray[np.float64]


def kinetic(scene: Scene, run: Trajectory) -> Array:
    """Kinetic energy (T,) [J] of the bodies, and of what elements move (a wheel)."""
    bodies = scene.bodies
    of_bodies = energy.kinetic(bodies.mass, bodies.inertia, run.velocity, run.attitude, run.omega)
    of_elements = [element.kinetic(scene, run.velocity) for element in scene.elements]
    total: Array = np.sum([of_bodies, *of_elements], axis=0)
    return total


def kinetic_exchanged(scene: Scene, run: Trajectory) -> Array:
    """The largest change (T,) [J] since the start of the kinetic energy, or of a part of it: of one
    body along one axis of space, or about one of its principal axes.

    The kinetic energy of a body that tumbles freely is constant, while its axes exchange it.
    """
    bodies = scene.bodies
    parts = energy.kinetic_parts(bodies.mass, bodies.inertia, run.velocity, run.attitude, run.omega)
    total = kinetic(scene, run)
    of_parts = np.abs(parts - parts[0]).max(axis=(1, 2), initial=0.0)
    largest: Array = np.maximum(np.abs(total - total[0]), of_parts)
    return largest


def mechanical(scene: Scene, run: Trajectory) -> Array:
    """Kinetic plus potential energy (T,) [J] of the scene."""
    return _mechanical(run, scene)


@once_with_arguments
def _mechanical(run: Trajectory, scene: Scene) -> Array:
    """The same, computed once for each run: a check of the energy needs it several times."""
    return kinetic(scene, run) + scene.potential(run.position, run.attitude)


@once_for_each
def energy_scale(instance: Instance) -> float:
    """The scale [J] of errors of the energy: the energy at the start.

    It is the kinetic energy plus the size of the potential energy; m (L/tau)^2 if both are zero.
    With gravity, a repelling spring or a drive the energy at the start may be 0 although much is
    exchanged later, so the scale is at least m (L/tau)^2 / 2 there.
    """
    scene = instance.scene
    states = ("position", "velocity", "attitude", "omega")
    columns = {name: getattr(scene.bodies, name)[None] for name in states}
    start = Trajectory(t=np.zeros(1), **columns)
    # scale = T(0) + max(|V(0)|, sum of |terms| of each element): the terms of one potential may
    # cancel in V, as those of a spring do.
    terms = [
        element.potential_terms(start.position, start.attitude)[0] for element in scene.elements
    ]
    potential = abs(scene.potential(start.position, start.attitude)[0])
    scale = kinetic(scene, start)[0] + max(potential, *terms, 0.0)
    # At least m (L/tau)^2/2 where the start may have no energy: if the zero of a potential is
    # arbitrary, or if a drive acts on bodies at rest.
    is_arbitrary = any(element.has_arbitrary_zero() for element in scene.elements)
    if is_arbitrary or scene.is_driven():
        scale = max(scale, instance.scales.energy / 2)
    return float(scale) or instance.scales.energy


def linear(scene: Scene, run: Trajectory) -> Array:
    """Total linear momentum (T, 3) [kg m/s]."""
    return momentum.linear(scene.bodies.mass, run.velocity)


def momentum_scale(instance: Instance) -> float:
    """Sum of m |v| at the start [kg m/s]; m L/tau if nothing moves."""
    bodies = instance.scene.bodies
    speed = np.linalg.norm(bodies.velocity, axis=1)
    at_start = float(bodies.mass @ speed)
    return at_start or instance.scales.mass * instance.scales.speed


def angular(scene: Scene, run: Trajectory) -> dict[str, Array]:
    """Orbital, spin and total angular momentum about the origin, each (T, 3) [kg m^2/s]."""
    bodies = scene.bodies
    orbital = momentum.orbital(bodies.mass, run.position, run.velocity)
    spin = momentum.spin(bodies.inertia, run.attitude, run.omega)
    return {"orbital": orbital, "spin": spin, "total": orbital + spin}


def angular_scale(instance: Instance) -> float:
    """Sum of m |r| |v| + |J omega| at the start [kg m^2/s]; m L^2/tau if nothing moves.

    Without forces a body moves away as far as |v| T. Its r x v is then rounded on the scale of the
    largest distance, so |r| is that distance: |r(0)| + |v| T.
    """
    scales = instance.scales
    bodies = instance.scene.bodies
    speed = np.linalg.norm(bodies.velocity, axis=1)
    if instance.scene.elements:
        flight = 0.0
    else:
        flight = scales.duration * speed
    # sum m |r| |v| + |J omega|, with |r| = |r(0)| + |v| T of a free body; J at most J_max.
    distance = np.linalg.norm(bodies.position, axis=1) + flight
    orbital = bodies.mass @ (distance * speed)
    spin = np.sum(bodies.inertia.max(axis=1) * np.linalg.norm(bodies.omega, axis=1))
    return float(orbital + spin) or scales.mass * scales.length * scales.speed


def torque_reason(scene: Scene) -> str | None:
    """None if the total angular momentum about the origin is conserved, else the reason.

    It changes by any torque about the origin: of the world, or of a pair of forces that do not act
    along one line.
    """
    for element in scene.elements:
        reason = element.torque_reason()
        if reason is not None:
            return reason
    if scene.bodies.fixed.any():
        return "a body is fixed"
    return None
