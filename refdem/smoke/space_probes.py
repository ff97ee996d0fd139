"""Probes in space: those of a plane turned out of it, drag, a damped knock, and three bodies that
fall.

Cases and probes in a plane are for engines of two dimensions as well. Of these alone, a force that
leaves out the third component of a velocity, or its reaction, shows nowhere.
"""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from refdem.core.problem import Motion
from refdem.core.symmetry import Symmetry
from refdem.scene import Body, Point, Scene, Sphere
from refdem.scene.element import Element
from refdem.scene.elements.contact import Contact
from refdem.scene.elements.drag import Drag
from refdem.scene.elements.uniform_gravity import UniformGravity
from refdem.smoke.probes import Expected, Probe

Array = NDArray[np.float64]

TURN = Symmetry(turn=np.array([1.0, 2.0, 3.0, 4.0]) / np.sqrt(30.0))
"""A rotation that takes no axis to an axis, and no plane of axes to one."""
VECTORS = ("position", "velocity")
"""Columns that turn with space."""


def in_space(probe: Probe) -> Probe:
    """The probe, of points or smooth spheres in a plane, turned by TURN: r' = Q r, v' = Q v."""

    def expected(t: Array) -> Expected:
        columns = probe.expected(t)
        turned = {name: columns[name] @ TURN.q.T for name in VECTORS}
        return columns | turned

    scene = TURN.applied(Motion(probe.scene, probe.times)).scene
    return replace(probe, name=f"{probe.name} in space", scene=scene, expected=expected)


def unlike_probes() -> tuple[Probe, ...]:
    """Drag, a damped knock, three points and three rigid spheres that fall, each in a plane."""
    points = _three_fall("three points fall", radius=0.0, elements=())
    rigid = Contact(law="rigid", restitution=0.5)
    spheres = _three_fall("three spheres fall", radius=0.25, elements=(rigid,))
    return (_drag(), _damped_knock(), points, spheres)


def _drag() -> Probe:
    """A point that drag alone slows along an oblique line, m v' = -c v^2.

    v = v0/(1 + a t) and s = v0/a ln(1 + a t), with a = c v0/m.
    """
    mass = 2.0
    speed = 5.0
    coefficient = 0.4
    along = np.array([0.6, -0.8, 0.0])
    start = np.array([1.0, -0.5, 0.0])
    rate = coefficient * speed / mass

    def expected(t: Array) -> Expected:
        passed = speed / rate * np.log1p(rate * t)
        velocity = speed / (1 + rate * t)
        return {
            "position": (start + np.outer(passed, along))[:, None],
            "velocity": np.outer(velocity, along)[:, None],
        }

    body = Body(mass=mass, position=_vector(start), velocity=_vector(speed * along))
    return Probe(
        name="drag",
        verifies="the drag force, which opposes the velocity and grows with its magnitude in space",
        scene=Scene.of([body], [Drag(a=0, coefficient=coefficient)]),
        expected=expected,
    )


def _damped_knock() -> Probe:
    """Two unlike smooth spheres whose contact, with a dashpot along an oblique normal, begins
    before the start and ends after the end: the force is smooth, and its jump at the touch is out.

    With g = c/(2 mu), w^2 = k/mu - g^2 and the reduced mass mu = m1 m2/(m1 + m2), the overlap is
    d = u/w exp(-g s) sin(w s) at the time s after the touch, and
    d' = u exp(-g s) (cos(w s) - g/w sin(w s)).
    """
    masses = np.array([3.0, 2.0])
    radii = (0.5, 1.0)
    speed = 0.3
    stiffness = 4.8
    damping = 1.2
    reduced_mass = float(masses.prod() / masses.sum())
    decay = damping / (2 * reduced_mass)
    rate = float(np.sqrt(stiffness / reduced_mass - decay**2))
    normal = np.array([0.6, 0.8, 0.0])
    drift = np.array([0.5, -0.25, 0.0])
    since_touch = 0.125
    first_place = np.array([-1.0, 0.5, 0.0])
    places = np.stack([first_place, first_place + sum(radii) * normal])
    # The part of the relative motion that each body makes.
    shares = np.array([masses[1], -masses[0]])[:, None] / masses.sum() * normal

    def expected(t: Array) -> Expected:
        s = t + since_touch
        fading = speed * np.exp(-decay * s)
        overlap = fading / rate * np.sin(rate * s)
        closing = fading * (np.cos(rate * s) - decay / rate * np.sin(rate * s))
        return {
            "position": places + t[:, None, None] * drift + overlap[:, None, None] * shares,
            "velocity": drift + closing[:, None, None] * shares,
        }

    start = expected(np.zeros(1))
    bodies = [
        Body(
            mass=float(mass),
            position=_vector(place),
            velocity=_vector(velocity),
            shape=Sphere(radius=radius),
        )
        for mass, place, velocity, radius in zip(
            masses, start["position"][0], start["velocity"][0], radii, strict=True
        )
    ]
    return Probe(
        name="damped knock",
        verifies="the dashpot of a contact and the direction of the relative velocity",
        scene=Scene.of(bodies, [Contact(law="linear", stiffness=stiffness, damping=damping)]),
        expected=expected,
        is_smooth=True,
    )


def _three_fall(name: str, *, radius: float, elements: tuple[Element, ...]) -> Probe:
    """Three bodies of unlike masses thrown apart in the same gravity: r = r0 + v0 t + g t^2/2.

    They are points for the radius 0, else spheres, which `elements` may let meet: they never do.
    """
    masses = (3.0, 0.5, 2.0)
    places = np.array([[1.0, -0.5, 0.0], [-2.0, 0.75, 0.0], [4.0, 2.5, 0.0]])
    speeds = np.array([[0.5, 1.0, 0.0], [-1.5, 0.25, 0.0], [2.0, -0.5, 0.0]])
    pull = np.array([3.0, -9.75, 0.0])

    def expected(t: Array) -> Expected:
        clock = t[:, None, None]
        return {
            "position": places + clock * speeds + clock**2 / 2 * pull,
            "velocity": speeds + clock * pull,
        }

    shape: Point | Sphere = Point()
    if radius > 0:
        shape = Sphere(radius=radius)
    bodies = [
        Body(mass=mass, position=_vector(place), velocity=_vector(speed), shape=shape)
        for mass, place, speed in zip(masses, places, speeds, strict=True)
    ]
    return Probe(
        name=name,
        verifies="gravity on every body, whatever its mass and index",
        scene=Scene.of(bodies, [UniformGravity(g=_vector(pull)), *elements]),
        expected=expected,
    )


def _vector(values: Array) -> tuple[float, float, float]:
    """The three numbers of an array (3,), as scenes take them."""
    x, y, z = values.tolist()
    return x, y, z
