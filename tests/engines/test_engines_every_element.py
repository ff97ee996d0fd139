"""Every element of a scene as every engine says it, with no number that is 0 or 1: against a plain
integration of the laws as they are written.

The scenes have several bodies of unlike masses, of which none is at the origin; links name them in
both orders, and begin at the first of them as well as at others. A number that an adapter or a
kernel drops, takes twice, or takes of another body shows.
"""

from collections.abc import Callable, Iterator

import numpy as np
import pytest
from numpy.typing import NDArray

from refdem.core import discovery
from refdem.core.problem import Motion, Request
from refdem.scene import Body, Scene, Sphere
from refdem.scene.element import Element, Link
from refdem.scene.elements.central_field import CentralField
from refdem.scene.elements.contact import Contact
from refdem.scene.elements.dashpot import Dashpot
from refdem.scene.elements.force import Force
from refdem.scene.elements.piecewise_field import PiecewiseField
from refdem.scene.elements.rotating_dashpot import RotatingDashpot
from refdem.scene.elements.slider import Slider
from refdem.scene.elements.spring import Spring
from refdem.scene.elements.uniform_gravity import UniformGravity

Array = NDArray[np.float64]

START = 0.75
"""[s], the time at which the scenes begin."""
SAMPLES = 4
INTERVAL = 2.0**-3
"""[s] between samples."""
FINE = 2.0**-9
"""[s], the step of the plain integration and of methods that have one."""
TOLERANCE = 1e-9
"""Of methods that have one."""
BOUNDS = {1: 2e-2, 2: 1e-3}
"""Largest error of a method, as a part of how far the scene moves, by its order; EXACT of others.
Wrong numbers move it by tenths of that.
"""
EXACT = 1e-4

SceneOf = Callable[[bool], Scene]
"""A scene in a plane, or in space if it is true."""


def bodies(in_space: bool, radii: tuple[float, ...] = ()) -> list[Body]:
    """Three bodies that move and a fourth that does not, in a plane or in space."""
    rows = (
        (2.0, (0.8, -0.6, 0.35), (0.4, 0.3, -0.25)),
        (3.0, (-0.7, 0.45, -0.5), (-0.2, 0.6, 0.35)),
        (0.5, (0.25, 1.3, 0.2), (0.7, -0.4, 0.15)),
    )
    flat = (1.0, 1.0, float(in_space))
    found = []
    for mass, position, velocity in rows:
        shape = Sphere(radius=radii[len(found)]) if radii else None
        more = {} if shape is None else {"shape": shape}
        found.append(
            Body(
                mass=mass,
                position=tuple(np.multiply(position, flat)),
                velocity=tuple(np.multiply(velocity, flat)),
                **more,
            )
        )
    return found


def still(in_space: bool) -> Body:
    """A body that nothing moves."""
    return Body(mass=1.7, position=(-1.6, -1.1, 0.3 * in_space), fixed=True)


def vector(x: float, y: float, z: float, in_space: bool) -> tuple[float, float, float]:
    """A vector, without its z in a plane."""
    return x, y, z * in_space


def turn(x: float, y: float, z: float, in_space: bool) -> tuple[float, float, float]:
    """An angular velocity, in a plane about z alone."""
    return x * in_space, y * in_space, z


def axis(in_space: bool) -> tuple[float, float, float]:
    """An oblique unit vector."""
    return (2 / 3, -1 / 3, 2 / 3) if in_space else (0.8, -0.6, 0.0)


def springs(s: bool) -> Scene:
    links = [
        Spring(a=0, b=1, stiffness=4.0, length=0.7, quadratic=1.5, cubic=2.5),
        Spring(a=2, b=0, stiffness=3.0, length=0.4),
        Spring(a=1, stiffness=5.0, length=0.6, anchor_b=vector(0.5, -1.2, 0.7, s)),
        Spring(a=2, b=3, stiffness=2.5, length=0.3),
        UniformGravity(g=vector(0.9, -1.4, 0.6, s)),
        UniformGravity(g=vector(-0.3, -2.5, -1.9, s)),
    ]
    return Scene.of([*bodies(s), still(s)], links)


def springs_of_a_power(s: bool) -> Scene:
    links = [
        Spring(a=1, b=0, stiffness=4.0, length=0.7, exponent=1.5),
        Spring(a=2, stiffness=3.0, length=2.5, exponent=2.5, anchor_b=vector(0.5, -1.2, 0.7, s)),
    ]
    return Scene.of(bodies(s), links)


def springs_of_no_length(s: bool) -> Scene:
    """Linear ones, which are the same along every axis, two of them on one body; and odd ones."""
    links = [
        Spring(a=0, stiffness=3.0, anchor_b=vector(0.4, -0.2, 0.3, s)),
        Spring(a=1, stiffness=2.5, anchor_b=vector(-0.5, 0.9, -0.4, s)),
        Spring(a=1, stiffness=1.5, anchor_b=vector(0.6, 0.3, 0.2, s)),
        Spring(a=2, b=1, stiffness=0.7),
        Spring(a=2, stiffness=1.2, cubic=2.3, anchor_b=vector(0.6, 0.3, 0.2, s)),
        Spring(a=1, b=0, stiffness=1.7, exponent=3.0, cubic=0.4),
        Spring(a=1, b=3, stiffness=0.9, length=0.2, exponent=3.0),
    ]
    return Scene.of([*bodies(s), still(s)], links)


def dashpots(s: bool) -> Scene:
    links = [
        Dashpot(a=0, damping=0.7, van_der_pol=0.9, anchor_b=vector(0.5, -1.2, 0.7, s)),
        Dashpot(a=2, damping=1.6, anchor_b=vector(0.5, 0.7, -0.4, s)),
    ]
    return Scene.of(bodies(s), links)


def dashpots_between(s: bool) -> Scene:
    links = [
        Dashpot(a=1, b=0, damping=0.7, van_der_pol=0.9),
        Dashpot(a=1, b=2, damping=1.6),
    ]
    return Scene.of(bodies(s), links)


def equal_dashpots(s: bool) -> Scene:
    """The same rate for all bodies."""
    own = bodies(s)
    return Scene.of(own, [Dashpot(a=n, damping=1.3 * body.mass) for n, body in enumerate(own)])


def fluids_that_turn(s: bool) -> Scene:
    """Beside a dashpot of a fluid at rest, and two on one body."""
    links = [
        RotatingDashpot(
            a=0, damping=1.7, rate=turn(0.6, -0.9, 2.3, s), anchor_b=vector(0.5, -1.2, 0.7, s)
        ),
        RotatingDashpot(
            a=2, damping=0.6, rate=turn(-1.4, 0.7, -3.1, s), anchor_b=vector(-0.3, 0.4, 0.2, s)
        ),
        RotatingDashpot(a=2, damping=0.4, rate=turn(0.3, 0.8, 1.9, s)),
        Dashpot(a=0, damping=0.9),
    ]
    return Scene.of(bodies(s), links)


def drives(s: bool) -> Scene:
    links = [
        Force(a=0, amplitude=2.3, frequency=1.9, phase=0.4, axis=axis(s)),
        Force(a=2, amplitude=-0.8, frequency=3.1, phase=-0.7, axis=(0.0, 1.0, 0.0)),
        Force(a=2, amplitude=0.6, frequency=0.9, phase=1.7, axis=axis(s)),
    ]
    return Scene.of(bodies(s), links)


def drives_between(s: bool) -> Scene:
    links = [
        Force(a=1, b=0, amplitude=2.3, frequency=1.9, phase=0.4, axis=axis(s)),
        Force(a=1, b=2, amplitude=0.8, frequency=3.1, phase=-0.7, axis=(0.0, 1.0, 0.0)),
    ]
    return Scene.of(bodies(s), links)


def centre(s: bool) -> Scene:
    return Scene.of(bodies(s), [CentralField(gm=1.7)])


def two_centres(s: bool) -> Scene:
    return Scene.of(bodies(s), [CentralField(gm=0.9), CentralField(gm=0.8)])


def piecewise(s: bool) -> Scene:
    """On both flanks, and beyond the end of one of them."""
    fields = [
        PiecewiseField(
            k1=3.0, k2=-1.5, x1=-0.8, x2=1.6, axis=axis(s), point=vector(0.2, -0.3, 0.4, s)
        ),
        PiecewiseField(
            k1=5.0, k2=-2.0, x1=-0.6, x2=1.5, axis=(0.0, 1.0, 0.0), point=vector(0.6, 0.9, -0.2, s)
        ),
    ]
    return Scene.of([*bodies(s), still(s)], fields)


def contacts(law: Contact, count: int = 3) -> SceneOf:
    """Pairs that press each other all the time. Without damping some never meet: where a force sets
    in with a jump, a plain integration is no witness.
    """
    radii = (1.3, 0.8, 0.02)
    if law.damping:
        radii = (2.2, 1.8, 1.2)
    return lambda in_space: Scene.of(bodies(in_space, radii)[:count], [law])


def line(link: Link, count: int) -> SceneOf:
    """Bodies on the x axis, which move too fast to come to rest."""
    rows = [(2.0, 0.8, 1.9), (3.0, -0.7, -1.6), (0.5, 2.3, 3.7)]
    own = [
        Body(mass=mass, position=(x, 0.0, 0.0), velocity=(v, 0.0, 0.0))
        for mass, x, v in rows[:count]
    ]
    return lambda in_space: Scene.of(own, [link])


STRIBECK = {"normal_force": 2.5, "mu0": 0.5, "mu1": 0.2, "lambda0": 1.4, "lambda1": 0.15}
SCENES = {
    "springs": springs,
    "springs of a power": springs_of_a_power,
    "springs of no length": springs_of_no_length,
    "dashpots": dashpots,
    "dashpots between": dashpots_between,
    "equal dashpots": equal_dashpots,
    "fluids that turn": fluids_that_turn,
    "drives": drives,
    "drives between": drives_between,
    "centre": centre,
    "two centres": two_centres,
    "piecewise": piecewise,
    "linear contacts": contacts(Contact(law="linear", stiffness=9.0)),
    "hertz contacts": contacts(Contact(law="hertz", stiffness=9.0)),
    "damped contacts": contacts(Contact(law="linear", stiffness=1.9, damping=0.8)),
    "damped contacts that do not pull": contacts(
        Contact(law="linear", stiffness=1.9, damping=1.8, cutoff="zero_force")
    ),
    "one contact": contacts(
        Contact(law="linear", stiffness=1.9, damping=0.8, cutoff="zero_force"), 2
    ),
    "slider": line(Slider(a=0, friction=0.3, normal_force=2.5), 1),
    "slider beside others": line(Slider(a=1, friction=0.3, normal_force=2.5), 3),
    "slider between": line(Slider(a=1, b=0, friction=0.3, normal_force=2.5), 2),
    "belt": line(Slider(a=0, friction=0.3, normal_force=2.5, belt_velocity=-1.2), 1),
    "stribeck": line(Slider(a=0, law="stribeck", belt_velocity=-1.2, **STRIBECK), 1),
    "stribeck linear": line(Slider(a=0, law="stribeck_linear", belt_velocity=-1.2, **STRIBECK), 1),
}


def accelerations(scene: Scene, t: float, x: Array, v: Array) -> Array:
    """(N, 3) [m/s^2], by the laws in the docstrings of refdem/scene/elements."""
    mass = scene.bodies.mass[:, None]
    force = np.zeros_like(x)
    for e in scene.elements:
        if isinstance(e, Link):
            f = pull_of(e, t, x, v)
            force[e.a] += f
            if e.b >= 0:
                force[e.b] -= f
        elif isinstance(e, Contact):
            for a, b, f in pressed(scene, e, x, v):
                force[a] += f
                force[b] -= f
        else:
            force += field_of(e, mass, x)
    force[scene.bodies.fixed] = 0.0
    return force / mass


def field_of(e: Element, mass: Array, x: Array) -> Array:
    """The force (N, 3) [N] of a field on all bodies."""
    if isinstance(e, UniformGravity):
        return mass * np.array(e.g)
    if isinstance(e, CentralField):
        return -e.gm * mass * x / np.linalg.norm(x, axis=1)[:, None] ** 3
    assert isinstance(e, PiecewiseField)
    s = (x - np.array(e.point)) @ np.array(e.axis)
    f = np.zeros_like(s)
    rises = (s >= e.x1) & (s <= 0)
    falls = (s > 0) & (s <= e.x2)
    f[rises] = e.k1 * (s[rises] - e.x1)
    f[falls] = e.k2 * (s[falls] - e.x2)
    return f[:, None] * np.array(e.axis)


def pull_of(e: Link, t: float, x: Array, v: Array) -> Array:
    """The force (3) [N] of a link on its body a; on b it is the opposite."""
    r = x[e.a] - np.array(e.anchor_b)
    w = v[e.a]
    if e.b >= 0:
        r = x[e.a] - x[e.b]
        w = v[e.a] - v[e.b]
    if isinstance(e, Spring):
        d = np.linalg.norm(r)
        s = d - e.length
        pull = e.stiffness * np.sign(s) * abs(s) ** e.exponent + e.quadratic * s**2
        return -(pull + e.cubic * s**3) * r / d
    if isinstance(e, Dashpot):
        return -(e.damping + e.van_der_pol * (r @ r)) * w
    if isinstance(e, RotatingDashpot):
        return -e.damping * (w - np.cross(np.array(e.rate), r))
    if isinstance(e, Force):
        return e.amplitude * np.cos(e.frequency * t + e.phase) * np.array(e.axis)
    assert isinstance(e, Slider)
    u = float(w @ np.array(e.axis)) - e.belt_velocity
    mu = e.friction
    if e.law != "coulomb":
        last = abs(u)
        if e.law == "stribeck":
            last = u * u
        mu = (e.mu0 - e.mu1) / (1 + e.lambda0 * abs(u)) + e.mu1 + e.lambda1 * last
    return -mu * e.normal_force * np.sign(u) * np.array(e.axis)


def pressed(scene: Scene, law: Contact, x: Array, v: Array) -> Iterator[tuple[int, int, Array]]:
    """Pairs of spheres that overlap, and the force on the first of each."""
    radius = scene.bodies.radius
    for a in range(len(x)):
        for b in range(a):
            r = x[a] - x[b]
            d = np.linalg.norm(r)
            overlap = radius[a] + radius[b] - d
            if overlap <= 0:
                continue
            f = law.stiffness * overlap**law.exponent - law.damping * ((v[a] - v[b]) @ r) / d
            if law.cutoff == "zero_force":
                f = max(f, 0.0)
            yield a, b, f * r / d


def plain(scene: Scene) -> tuple[Array, Array]:
    """Positions and velocities (T, N, 3) at the samples, by classical Runge-Kutta."""
    x = np.array(scene.bodies.position)
    v = np.array(scene.bodies.velocity)
    h = FINE
    rows = [(x, v)]
    for n in range(round(SAMPLES * INTERVAL / h)):
        t = START + n * h
        k1 = accelerations(scene, t, x, v)
        k2 = accelerations(scene, t + h / 2, x + h / 2 * v, v + h / 2 * k1)
        k3 = accelerations(scene, t + h / 2, x + h / 2 * v + h * h / 4 * k1, v + h / 2 * k2)
        k4 = accelerations(scene, t + h, x + h * v + h * h / 2 * k2, v + h * k3)
        x = x + h * v + h * h / 6 * (k1 + k2 + k3)
        v = v + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
        if (n + 1) % round(INTERVAL / h) == 0:
            rows.append((x, v))
    positions, velocities = (np.array(column) for column in zip(*rows, strict=True))
    return positions, velocities


ENGINES = ("reference", "pymunk", "rebound", "mujoco")


CARRIED = {
    "springs": "mujoco pymunk rebound reference",
    "springs of a power": "mujoco pymunk rebound reference",
    "springs of no length": "mujoco pymunk rebound reference",
    "dashpots": "mujoco pymunk rebound",
    "dashpots between": "mujoco rebound",
    "equal dashpots": "mujoco pymunk rebound",
    "fluids that turn": "mujoco pymunk rebound",
    "drives": "mujoco pymunk rebound",
    "drives between": "mujoco rebound",
    "centre": "mujoco pymunk rebound reference",
    "two centres": "mujoco pymunk rebound reference",
    "piecewise": "mujoco pymunk rebound",
    "linear contacts": "pymunk rebound reference",
    "damped contacts": "pymunk reference",
    "damped contacts that do not pull": "pymunk reference",
    "one contact": "mujoco pymunk reference",
    "hertz contacts": "pymunk rebound reference",
    "slider": "mujoco pymunk",
    "slider beside others": "mujoco pymunk",
    "slider between": "pymunk",
    "belt": "mujoco pymunk",
    "stribeck": "pymunk",
    "stribeck linear": "pymunk",
}
"""The engines that run a scene in a plane; Chipmunk runs none in space."""
ON_A_LINE = ("slider", "belt", "stribeck")


def runs(engine: str, problem: Motion) -> Iterator[tuple[str, float, Array, Array]]:
    """Name, bound and motion of every method of an engine that runs a problem."""
    found = discovery.engine(engine)
    for method in found.methods:
        if found.unsupported(problem, method) is not None:
            continue
        bound = EXACT
        control: dict[str, float] = {}
        if method.control == "step":
            bound = BOUNDS.get(method.order_for(problem.scene.features), EXACT)
            control = {"step": FINE}
        elif method.control == "tolerance":
            control = {"tolerance": TOLERANCE}
        run, cost = found.run(Request(problem=problem, method=method.name, **control))
        if method.control == "step":
            assert cost.steps == round(SAMPLES * INTERVAL / FINE)
        np.testing.assert_allclose(run.t, problem.times, rtol=1e-12)
        velocity = run.velocity
        if method.velocity_time != "synchronous":
            velocity = np.full_like(velocity, np.nan)
        yield method.name, bound, run.position, velocity


@pytest.mark.parametrize("in_space", [False, True], ids=["plane", "space"])
@pytest.mark.parametrize("name", SCENES)
def test_an_element_is_what_its_definition_says(name: str, in_space: bool) -> None:
    scene = SCENES[name](in_space)
    position, velocity = plain(scene)
    times = START + INTERVAL * np.arange(SAMPLES + 1)
    size = np.abs(position - position[0]).max()
    speed = max(np.abs(velocity - velocity[0]).max(), size / (SAMPLES * INTERVAL))
    wrong = []
    ran = set()
    for engine in ENGINES:
        for method, bound, x, v in runs(engine, Motion(scene, times)):
            ran.add(engine)
            error = np.abs(x - position).max() / size
            if np.isfinite(v).all():
                error = max(error, np.abs(v - velocity).max() / speed)
            if not error < bound:
                wrong.append(f"{engine} {method}: {error:.2g} > {bound:g}")
    assert wrong == []
    carried = set(CARRIED[name].split())
    if in_space and not name.startswith(ON_A_LINE):
        carried -= {"pymunk"}
    assert ran == carried
