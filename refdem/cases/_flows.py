"""Four scenes in whose phase space an outline is carried: the plane of place and rate, there and
back.
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
    """The oscillator, or the pendulum, at the first corner."""
    place, rate = starts(p, points(p)[:1])
    body = Body(mass=p.mass, position=tuple(place[0, 0]), velocity=tuple(rate[0, 0]))
    if p.flow == "pendulum":
        rod = Rod(a=0, length=p.length)
        weight = UniformGravity(g=(0.0, -p.gravity, 0.0))
        return Scene.of([body], [rod, weight])
    more: dict[str, list[Element]] = {
        "viscous": [Dashpot(a=0, damping=2 * p.mass * p.delta)],
        "coulomb": [Slider(a=0, friction=p.friction_force, normal_force=1.0)],
    }
    return Scene.of([body], [Spring(a=0, stiffness=p.stiffness), *more.get(p.flow, [])])


def starts(p: Parameters, outline: Array) -> tuple[Array, Array]:
    """Position and velocity (M, 1, 3) of points (M, 2) of phase space."""
    x, v = outline.T
    zero = np.zeros_like(x)
    if p.flow != "pendulum":
        place = np.stack((x, zero, zero), axis=-1)
        speed = np.stack((v, zero, zero), axis=-1)
        return place[:, None], speed[:, None]
    sine = np.sin(x)
    cosine = np.cos(x)
    along = np.stack((sine, -cosine, zero), axis=-1)
    across = np.stack((cosine, sine, zero), axis=-1)
    position = p.length * along
    velocity = (p.length * v)[:, None] * across
    return position[:, None], velocity[:, None]


def seen(p: Parameters, trajectory: Trajectory) -> tuple[Array, Array]:
    """Place and rate (T, M); angles go on from point to point."""
    position = trajectory.values["position"][:, :, 0]
    velocity = trajectory.values["velocity"][:, :, 0]
    if p.flow != "pendulum":
        return position[..., 0], velocity[..., 0]
    angle = np.arctan2(position[..., 0], -position[..., 1])
    rate = (velocity[..., 0] * np.cos(angle) + velocity[..., 1] * np.sin(angle)) / p.length
    return np.unwrap(angle, axis=1), rate


def scales(p: Parameters, corners: list[tuple[Fraction, Fraction]]) -> Scales:
    """The farthest corner, and how long it takes for a radian."""
    is_rod = p.flow == "pendulum"
    w0 = float(np.sqrt(p.gravity / p.length if is_rod else p.stiffness / p.mass))
    far = max(float(np.hypot(x, v / w0)) for x, v in np.array(corners, float))
    if p.flow == "viscous":
        rate = _line.damped_rate(w0**2, p.delta)
    elif is_rod:
        rate = w0 * max(1.0, far)
    else:
        rate = w0
    return Scales(length=far, tau=1 / rate, duration=5 * np.pi / w0, mass=p.mass)
