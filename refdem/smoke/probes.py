"""Small scenes whose motion has a closed form, with which `refdem smoke` tests an adapter.

Each detects one conversion that may be wrong: a unit, a sign, an axis, an order.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property, partial

import numpy as np
from numpy.typing import NDArray

from refdem.mechanics.quaternion import conjugate, product, rotated
from refdem.scene import Body, Scene, Sphere
from refdem.scene.element import Element
from refdem.scene.elements.central_field import CentralField
from refdem.scene.elements.contact import Contact
from refdem.scene.elements.rod import Rod
from refdem.scene.elements.slider import Slider
from refdem.scene.elements.spring import Spring
from refdem.scene.elements.uniform_gravity import UniformGravity
from refdem.smoke.probe_motion import motion

Array = NDArray[np.float64]
Expected = dict[str, Array]

INTERVAL = 2.0**-5
"""Interval between samples [s], a power of two: whole multiples of it are exact in binary64."""
SAMPLES = 32
"""Intervals of a probe; with INTERVAL it lasts 1 s, in which every probe moves by its own scale."""
HALF = 0.5**0.5
"""1/sqrt(2): cosine and sine of half a right angle, in the quaternion of a quarter turn."""


@dataclass(frozen=True)
class Mistake:
    """A known mistake in words, and the motion `expected(t)` of a probe that it would make."""

    description: str
    expected: Callable[[Array], Expected]


@dataclass(frozen=True, eq=False, kw_only=True)
class Probe:
    """A scene with the time [s] at its start, its motion in closed form, and what it `verifies`
    of an adapter.

    `expected(t)`, for the time t (T,) [s] since the start, has columns of a trajectory (T, N, ...),
    channels (T,), or `omega_body` (T, N, 3), by name. `mistakes` are those that it can identify.
    `uncertainty` bounds the error of `expected` itself, in units of the scales. `is_smooth` is set
    where a law of the scene has a kink or a jump that this motion does not reach.
    """

    name: str
    verifies: str
    scene: Scene
    expected: Callable[[Array], Expected]
    start: float = 0.0
    backwards: bool = False
    mistakes: tuple[Mistake, ...] = ()
    uncertainty: float = 0.0
    is_smooth: bool = False

    @property
    def times(self) -> Array:
        """A second in samples; falling where the probe runs backwards."""
        if self.backwards:
            direction = -1.0
        else:
            direction = 1.0
        return np.asarray(self.start + direction * INTERVAL * np.arange(SAMPLES + 1))

    @cached_property
    def expected_values(self) -> Expected:
        """The expected columns at `times`."""
        return self.expected(self.times - self.start)

    @cached_property
    def wrong_answers(self) -> list[tuple[str, Expected]]:
        """Each mistake in words, with the answer at `times` that it would give."""
        elapsed = self.times - self.start
        return [(mistake.description, mistake.expected(elapsed)) for mistake in self.mistakes]


def probes() -> tuple[Probe, ...]:
    """All of them: flight, fall, turning, forces, contact."""
    wobbles = [_wobble(axis) for axis in range(3)]
    return (*_flights(), *_falls(), *_spins(), *wobbles, *_forces(), _knock())


def _straight(*bodies: Body) -> Callable[[Array], Expected]:
    """The motion r = r0 + t v0 of every body."""
    position = np.array([body.position for body in bodies])
    velocity = np.array([body.velocity for body in bodies])

    def expected(t: Array) -> Expected:
        s = t[:, None, None]
        return {"position": position + s * velocity, "velocity": velocity + 0 * s}

    return expected


def _flights() -> tuple[Probe, ...]:
    """Force-free points in one, two and three dimensions, two of them, and a start that is not at
    time zero.
    """
    line = Body(mass=2.0, position=(1.0, 0.0, 0.0), velocity=(-3.0, 0.0, 0.0))
    plane = Body(mass=2.0, position=(1.0, -2.0, 0.0), velocity=(-3.0, 4.0, 0.0))
    space = Body(mass=2.0, position=(1.0, -2.0, 3.0), velocity=(-3.0, 4.0, 5.0))
    other = Body(mass=5.0, position=(40.0, 0.0, 0.0), velocity=(0.0, 2.0, 0.0))

    def flight(name: str, verifies: str, *bodies: Body, start: float = 0.0) -> Probe:
        scene = Scene.of(bodies)
        return Probe(
            name=name, verifies=verifies, scene=scene, expected=_straight(*bodies), start=start
        )

    return (
        flight("line", "the x axis and the units of length and time", line),
        flight("plane", "the order of the axes in two dimensions", plane),
        flight("space", "the order of the axes", space),
        flight("two bodies", "the order of the bodies", plane, other),
        flight("later", "the time at which the scene starts", line, start=2.0),
    )


def _falls() -> tuple[Probe, ...]:
    """Thrown points: the direction and the unit of gravity."""

    def fall(
        name: str, velocity: tuple[float, float, float], g: tuple[float, float, float]
    ) -> Probe:
        """A point thrown with `velocity` [m/s] in gravity g [m/s^2]: r = v0 t + g t^2/2."""
        thrown = Body(mass=3.0, velocity=velocity)
        pull = np.array(g)

        def expected(t: Array) -> Expected:
            s = t[:, None, None]
            return {
                "position": s * np.array(velocity) + s**2 * pull / 2,
                "velocity": np.array(velocity) + s * pull,
            }

        return Probe(
            name=name,
            verifies="the sign, axis and unit of gravity",
            scene=Scene.of([thrown], [UniformGravity(g=g)]),
            expected=expected,
        )

    return (
        fall("fall in a plane", velocity=(2.0, 3.0, 0.0), g=(0.0, -9.8, 0.0)),
        fall("fall in space", velocity=(2.0, 0.0, 3.0), g=(1.0, 0.0, -9.8)),
    )


def _spins() -> tuple[Probe, ...]:
    """Steady rotations about a principal axis: they show the order, sign and side of quaternions,
    radians, and the axes of omega.
    """

    place = np.array([1.5, -0.75, 0.0])
    drift = np.array([0.5, 1.25, 0.0])

    def spin(
        name: str, verifies: str, omega: Array, attitude: tuple[float, float, float, float]
    ) -> Probe:
        """A body that spins steadily with `omega` [rad/s], in space axes, from `attitude` on."""
        body = Body(
            mass=1.0,
            inertia=(1.0, 2.0, 2.5),
            position=(1.5, -0.75, 0.0),
            velocity=(0.5, 1.25, 0.0),
            omega=tuple(omega),
            attitude=attitude,
        )
        rate = float(np.linalg.norm(omega))

        def expected(t: Array) -> Expected:
            # The quaternion (cos a/2, n sin a/2) of the angle a = |omega| t about n.
            half = rate * t / 2
            rotation = np.column_stack([np.cos(half), np.outer(np.sin(half), omega / rate)])
            return {
                "position": place + t[:, None, None] * drift,
                "velocity": drift + 0 * t[:, None, None],
                "attitude": product(rotation, np.array(attitude))[:, None],
                "omega": np.tile(omega, (len(t), 1, 1)),
            }

        return Probe(name=name, verifies=verifies, scene=Scene.of([body]), expected=expected)

    upright = (1.0, 0.0, 0.0, 0.0)
    tipped = (HALF, HALF, 0.0, 0.0)
    quarter = np.array([0.0, 0.0, np.pi / 2])
    about_x = np.array([1.5, 0.0, 0.0])
    about_z = np.array([0.0, 0.0, 1.5])
    of_units = "the unit of angles (rad) and the order and sign of the quaternion"
    of_axes = "omega in space axes and the order of quaternion products"
    return (
        spin("quarter turn", of_units, quarter, upright),
        spin("turn about x", "the order of the components of the quaternion", about_x, upright),
        spin("tipped body", of_axes, about_z, tipped),
    )


def _wobble(axis: int) -> Probe:
    """A symmetric top that spins off its symmetry axis, which is the body's `axis` (0, 1 or 2).

    Euler's equations with J1 = J2: omega1' = -W omega2, omega2' = W omega1, W = (J3 - J1)/J1 omega3
    (Landau and Lifshitz, Mechanics, section 36), so that omega_body turns about that axis at W.
    """
    inertia = np.roll([1.0, 1.0, 1.8], axis + 1)
    # With a part along every axis, no other order of the axes leaves omega_body constant, as a
    # gyroscopic term that is missing does.
    start = np.roll([0.6, 0.8, 2.0], axis + 1)
    # W = (1.8 - 1)/1 * 2.
    rate = 0.8 * 2.0
    body = Body(mass=1.0, inertia=tuple(inertia), omega=tuple(start))

    def expected(t: Array) -> Expected:
        c = np.cos(rate * t)
        s = np.sin(rate * t)
        omega_body = np.column_stack([0.6 * c - 0.8 * s, 0.6 * s + 0.8 * c, np.full(len(t), 2.0)])
        # The angular momentum is constant in space, where the body axes are at the start.
        momentum = np.tile(inertia * start, (len(t), 1, 1))
        return {
            "omega_body": np.roll(omega_body, axis + 1, axis=1)[:, None],
            "angular_momentum": momentum,
        }

    scene = Scene.of([body])
    return Probe(
        name=f"wobble about {'xyz'[axis]}",
        verifies="the order of the inertia axes and the gyroscopic term omega x J omega",
        scene=scene,
        expected=expected,
        mistakes=turning_mistakes(scene),
    )


ORDERS = ("xzy", "yxz", "zyx", "yzx", "zxy")
"""Every other order of three axes."""


def turning_mistakes(scene: Scene) -> tuple[Mistake, ...]:
    """Mistakes that rotate a body wrongly: moments of inertia in another order, and a gyroscopic
    term that is missing or has the opposite sign.
    """
    bodies = scene.bodies
    orders: dict[bytes, list[str]] = {}
    for order in ORDERS:
        reordered = bodies.inertia[:, ["xyz".index(axis) for axis in order]]
        # An order that does not change the moments is no mistake; equal results are kept once.
        if not np.array_equal(reordered, bodies.inertia):
            orders.setdefault(reordered.tobytes(), []).append(order)
    mistakes = []
    for moments, same in orders.items():
        inertia = np.frombuffer(moments).reshape(bodies.inertia.shape)
        changed = Scene(replace(bodies, inertia=inertia), scene.elements)
        description = f"the moments of inertia are in the order {' or '.join(same)} instead of xyz"
        mistakes.append(Mistake(description, partial(_turned, changed, 1.0)))
    if mistakes:
        term = "the gyroscopic term omega x J omega of Euler's equations"
        mistakes.append(Mistake(f"{term} is missing", partial(_turned, scene, 0.0)))
        mistakes.append(Mistake(f"{term} has the opposite sign", partial(_turned, scene, -1.0)))
    return tuple(mistakes)


def _turned(scene: Scene, gyroscopic: float, t: Array) -> Expected:
    """The columns of a motion with this factor of the gyroscopic term, and `omega_body`."""
    # One step per sample has an error of 1e-5 of the scale, which suffices to identify a mistake.
    columns = motion(scene, t, gyroscopic=gyroscopic, longest_step=INTERVAL)
    columns["omega_body"] = rotated(conjugate(columns["attitude"]), columns["omega"])
    return columns


def _along(x: Array, v: Array) -> Expected:
    """One body's position and velocity from those along x, each (T,)."""
    return {"position": _on_x(x[:, None]), "velocity": _on_x(v[:, None])}


def _on_x(values: Array) -> Array:
    """Vectors (T, N, 3) along x of these sizes (T, N)."""
    return np.pad(values[..., None], ((0, 0), (0, 0), (0, 2)))


def _forces() -> tuple[Probe, ...]:
    """A spring (w = 2 /s), dry friction (1/2 m/s^2), a hanging rod (m g = 30 N) and a circular
    orbit (w^2 = gm/r^3 = 4 /s^2): signs and units of forces.
    """

    def force(
        name: str,
        verifies: str,
        body: Body,
        elements: list[Element],
        expected: Callable[[Array], Expected],
    ) -> Probe:
        return Probe(
            name=name, verifies=verifies, scene=Scene.of([body], elements), expected=expected
        )

    def hanging(t: Array) -> Expected:
        """At rest 2 m below the pivot; the tension is m g = 3 kg * 10 m/s^2."""
        return {
            "position": np.tile([0.0, -2.0, 0.0], (len(t), 1, 1)),
            "rod_force": np.full(len(t), 30.0),
        }

    def circle(t: Array) -> Expected:
        """w^2 = gm/r^3 = 4 /s^2 at r = 1 m."""
        place = np.column_stack([np.cos(2 * t), np.sin(2 * t), 0 * t])
        return {"position": place[:, None]}

    def swinging(t: Array) -> Expected:
        """x = cos(w t), w^2 = k/m = 4 /s^2."""
        return _along(np.cos(2 * t), -2 * np.sin(2 * t))

    def rubbed(t: Array) -> Expected:
        """x = t - t^2/4: friction mu N = 1 N slows 2 kg by 1/2 m/s^2, until t = 2 s."""
        return _along(t - t * t / 4, 1 - t / 2)

    spring = Spring(a=0, stiffness=8.0)
    slider = Slider(a=0, friction=0.25, normal_force=4.0)
    bob = Body(mass=3.0, position=(0.0, -2.0, 0.0))
    pull = UniformGravity(g=(0.0, -10.0, 0.0))
    start = Body(mass=2.0, position=(1.0, 0.0, 0.0))
    thrown = Body(mass=2.0, velocity=(1.0, 0.0, 0.0))
    planet = Body(mass=2.0, position=(1.0, 0.0, 0.0), velocity=(0.0, 2.0, 0.0))
    rod = Rod(a=0, length=2.0)
    field = CentralField(gm=4.0)
    return (
        force("spring", "the sign and unit of stiffness", start, [spring], swinging),
        force("friction", "the sign and unit of dry friction", thrown, [slider], rubbed),
        force(
            "hanging rod", "the sign and unit of the force of the rod", bob, [rod, pull], hanging
        ),
        force("circle", "the sign and unit of the central field", planet, [field], circle),
    )


def _knock() -> Probe:
    """Two equal spheres that touch and close head-on, undamped: after pi sqrt(m/(2 k)) they have
    exchanged their velocities.
    """
    ball = Sphere(radius=0.5)
    first_sphere = Body(mass=2.0, position=(-0.5, 0.0, 0.0), velocity=(1.0, 0.0, 0.0), shape=ball)
    second_sphere = Body(mass=2.0, position=(0.5, 0.0, 0.0), velocity=(0.0, 0.0, 0.0), shape=ball)
    stiffness = 400.0

    def expected(t: Array) -> Expected:
        # The reduced mass is 1 kg, so that the contact turns at sqrt(k).
        phase = np.minimum(np.sqrt(stiffness) * t, np.pi)
        first = (1 + np.cos(phase)) / 2
        second = (1 - np.cos(phase)) / 2
        return {"velocity": _on_x(np.stack([first, second], axis=1))}

    scene = Scene.of([first_sphere, second_sphere], [Contact(law="linear", stiffness=stiffness)])
    return Probe(
        name="knock",
        verifies="the sign and unit of the contact force",
        scene=scene,
        expected=expected,
    )
