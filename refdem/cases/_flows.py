"""The four scenes of phase-flow, and the maps between their states and the phase plane (x, v).

For the oscillators x is the position [m] and v the velocity [m/s]; for the pendulum x is the angle
from the downward vertical [rad] and v its rate [rad/s].
"""

from fractions import Fraction

import numpy as np

from refdem.cases import _line
from refdem.cases._cat import Array, points
from refdem.core.parameters import Parameters
from refdem.core.quantity import Scales
from refdem.core.trajectory import Trajectory
from refdem.scene import Body, Element, Scene
from refdem.scene.elements.dashpot import Dashpot
from refdem.scene.elements.rod import Rod
from refdem.scene.elements.slider import Slider
from refdem.scene.elements.spring import Spring
from refdem.scene.elements.uniform_gravity import UniformGravity

FLOWS = ("harmonic", "viscous", "coulomb", "pendulum")


def scene(p: Parameters) -> Scene:
    """The oscillator or the pendulum of the parameter `flow`, at the outline's first corner."""
    position, velocity = starts(p, points(p)[:1])
    body = Body(mass=p.mass, position=tuple(position[0, 0]), velocity=tuple(velocity[0, 0]))
    if p.flow == "pendulum":
        rod = Rod(a=0, length=p.length)
        weight = UniformGravity(g=(0.0, -p.gravity, 0.0))
        return Scene.of([body], [rod, weight])
    # A normal force of 1 N makes the coefficient of friction equal to the friction force.
    resistance: dict[str, list[Element]] = {
        "viscous": [Dashpot(a=0, damping=2 * p.mass * p.delta)],
        "coulomb": [Slider(a=0, friction=p.friction_force, normal_force=1.0)],
    }
    return Scene.of([body], [Spring(a=0, stiffness=p.stiffness), *resistance.get(p.flow, [])])


def starts(p: Parameters, outline: Array) -> tuple[Array, Array]:
    """Position and velocity (M, 1, 3) of the one body for points (M, 2) of the phase plane.

    For the pendulum r = l (sin x, -cos x, 0) and r' = l v (cos x, sin x, 0).
    """
    x, v = outline.T
    zero = np.zeros_like(x)
    if p.flow != "pendulum":
        position = np.stack((x, zero, zero), axis=-1)
        velocity = np.stack((v, zero, zero), axis=-1)
        return position[:, None], velocity[:, None]
    sine = np.sin(x)
    cosine = np.cos(x)
    radial = np.stack((sine, -cosine, zero), axis=-1)
    tangential = np.stack((cosine, sine, zero), axis=-1)
    position = p.length * radial
    velocity = (p.length * v)[:, None] * tangential
    return position[:, None], velocity[:, None]


def phase_points(p: Parameters, trajectory: Trajectory) -> tuple[Array, Array]:
    """x and v (T, M) of the outline's points: the inverse of `starts`.

    Angles are continuous along the outline: neighbours differ by less than half a revolution.
    """
    position = trajectory.values["position"][:, :, 0]
    velocity = trajectory.values["velocity"][:, :, 0]
    if p.flow != "pendulum":
        return position[..., 0], velocity[..., 0]
    angle = np.arctan2(position[..., 0], -position[..., 1])
    # x' = r' . (cos x, sin x, 0)/l.
    rate = (velocity[..., 0] * np.cos(angle) + velocity[..., 1] * np.sin(angle)) / p.length
    return np.unwrap(angle, axis=1), rate


def scales(p: Parameters, corners: list[tuple[Fraction, Fraction]]) -> Scales:
    """Scales of the flow: L is the largest amplitude hypot(x, v/w0) of the corners, tau the time of
    a radian, T = 5 pi/w0.
    """
    is_pendulum = p.flow == "pendulum"
    if is_pendulum:
        w0 = float(np.sqrt(p.gravity / p.length))
    else:
        w0 = float(np.sqrt(p.stiffness / p.mass))
    amplitude = max(float(np.hypot(x, v / w0)) for x, v in np.array(corners, float))
    if p.flow == "viscous":
        rate = _line.damped_rate(w0**2, p.delta)
    elif is_pendulum:
        # At the bottom the pendulum turns at most at w0 times its amplitude [rad].
        rate = w0 * max(1.0, amplitude)
    else:
        rate = w0
    return Scales(length=amplitude, tau=1 / rate, duration=5 * np.pi / w0, mass=p.mass)
