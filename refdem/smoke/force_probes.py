"""Probes of forces away from the origin, along other axes, between two bodies and with the clock.

Each has a scene and its motion in closed form, `expected(t)`.
"""

import numpy as np
from numpy.typing import NDArray

from refdem.scene import Body, Scene, Sphere
from refdem.scene.elements.contact import Contact
from refdem.scene.elements.dashpot import Dashpot
from refdem.scene.elements.force import Force
from refdem.scene.elements.plane import Plane
from refdem.scene.elements.rod import Rod
from refdem.scene.elements.slider import Slider
from refdem.scene.elements.spring import Spring
from refdem.scene.elements.uniform_gravity import UniformGravity
from refdem.smoke.probes import Expected, Probe
from refdem.smoke.space_probes import in_space, unlike_probes

Array = NDArray[np.float64]
Vector = tuple[float, float, float]

STIFFNESS = 800.0
"""Stiffness [N/m] of contacts, which last a seventh of a second."""
LATER = 2.0
"""Time [s] at which a driven probe starts."""


def force_probes() -> tuple[Probe, ...]:
    """The probes of forces: springs, dashpots, drag, friction, drives, a rod, contacts, fixed
    bodies; those that a plane has room for are asked in it and in space.
    """
    springs = (_diagonal_spring(), _two_springs())
    damped = (_damped_pair(), _slide())
    driven = (_drive("drive", start=0.0), _drive("drive that starts later", start=LATER))
    coupled = (_drive_between(), _dumbbell())
    knocks = (
        _knock("knock in a plane", normal=(0.6, 0.8, 0.0), drift=(0.5, -0.25, 0.0)),
        _knock("knock in space", normal=(2 / 3, -1 / 3, 2 / 3), drift=(0.5, -0.25, 0.75)),
    )
    others = (_floor(), *unlike_probes())
    planar = (*damped, *coupled, *others)
    fixed = (_hanging_from_fixed(), _resting_on_fixed())
    as_written = (*springs, *damped, *driven, *coupled, *knocks, *others)
    return (*as_written, *map(in_space, planar), *fixed)


def _moved(start: Array, along: Array, x: Array, v: Array) -> Expected:
    """Motion of one body along a line: r = start + x e, v e with the unit vector e = `along`.

    `x` [m] and `v` [m/s] are (T,).
    """
    return {
        "position": (start + np.outer(x, along))[:, None],
        "velocity": np.outer(v, along)[:, None],
    }


def _diagonal_spring() -> Probe:
    """A mass on a spring along a diagonal, tied to a point that is not the origin.

    The stretch is s = cos(2 t)/2, for w = sqrt(k/m) = 2 /s.
    """
    anchor = np.array([-1.0, 2.0, 0.5])
    along = np.array([2.0, -1.0, 2.0]) / 3.0
    length = 1.5
    body = Body(mass=2.0, position=_vector(anchor + (length + 0.5) * along))
    spring = Spring(a=0, stiffness=8.0, length=length, anchor_b=_vector(anchor))

    def expected(t: Array) -> Expected:
        return _moved(anchor, along, length + np.cos(2 * t) / 2, -np.sin(2 * t))

    scene = Scene.of([body], [spring])
    return Probe(
        name="spring in space",
        verifies="the rest length of a spring and its anchor in the world",
        scene=scene,
        expected=expected,
    )


def _two_springs() -> Probe:
    """A mass between two unlike springs on a diagonal, which are alternately compressed and
    stretched.

    m s'' = -k1 (s - l1) + k2 (D - s - l2), with the distance s from the first anchor and D of the
    anchors: it oscillates about (k1 l1 + k2 (D - l2))/(k1 + k2) with
    w = sqrt((k1 + k2)/m) = 2 /s.
    """
    anchor = np.array([-1.0, 2.0, 0.0])
    along = np.array([0.8, -0.6, 0.0])
    lengths = (1.5, 0.5)
    stiffnesses = (3.0, 5.0)
    apart = 3.0
    force_at_anchor = stiffnesses[0] * lengths[0] + stiffnesses[1] * (apart - lengths[1])
    resting = force_at_anchor / sum(stiffnesses)
    body = Body(mass=2.0, position=_vector(anchor + (resting + 0.75) * along))
    ends = (anchor, anchor + apart * along)
    springs = [
        Spring(a=0, stiffness=stiffness, length=length, anchor_b=_vector(end))
        for stiffness, length, end in zip(stiffnesses, lengths, ends, strict=True)
    ]

    def expected(t: Array) -> Expected:
        return _moved(anchor, along, resting + 0.75 * np.cos(2 * t), -1.5 * np.sin(2 * t))

    return Probe(
        name="two springs",
        verifies="the stiffness and rest length of each of several springs",
        scene=Scene.of([body], springs),
        expected=expected,
    )


def _damped_pair() -> Probe:
    """Two points joined by a dashpot, of which one passes the other askew.

    In every direction the relative velocity decays as exp(-g t), g = c/mu, with the reduced mass
    mu = m1 m2/(m1 + m2).
    """
    masses = np.array([2.0, 3.0])
    rate = 2.0
    reduced_mass = masses.prod() / masses.sum()
    places = np.array([[1.0, -0.5, 0.0], [-0.25, 0.75, 0.0]])
    centre_velocity = np.array([0.25, 0.5, 0.0])
    relative = np.array([1.5, 1.0, 0.0])
    shares = np.array([masses[1], -masses[0]]) / masses.sum()

    def expected(t: Array) -> Expected:
        decay = np.exp(-rate * t)
        moved = np.outer((1 - decay) / rate, relative)[:, None] * shares[:, None]
        drift = t[:, None, None] * centre_velocity
        velocity = np.outer(decay, relative)[:, None] * shares[:, None]
        return {"position": places + drift + moved, "velocity": centre_velocity + velocity}

    speeds = expected(np.zeros(1))["velocity"][0]
    bodies = [
        Body(mass=float(mass), position=_vector(place), velocity=_vector(speed))
        for mass, place, speed in zip(masses, places, speeds, strict=True)
    ]
    dashpot = Dashpot(a=0, b=1, damping=rate * reduced_mass)
    return Probe(
        name="dashpot",
        verifies="the force of a dashpot, which opposes the whole relative velocity",
        scene=Scene.of(bodies, [dashpot]),
        expected=expected,
    )


def _slide() -> Probe:
    """Dry friction along an oblique axis: mu N/m = 1/2 m/s^2, s = t - t^2/4 from 1 m/s."""
    start = np.array([1.0, -2.0, 0.0])
    along = np.array([0.6, 0.8, 0.0])
    body = Body(mass=2.0, position=_vector(start), velocity=_vector(along))
    slider = Slider(a=0, friction=0.25, normal_force=4.0, axis=_vector(along))

    def expected(t: Array) -> Expected:
        return _moved(start, along, t - t * t / 4, 1 - t / 2)

    scene = Scene.of([body], [slider])
    return Probe(
        name="friction along another axis",
        verifies="the axis of dry friction",
        scene=scene,
        expected=expected,
    )


def _drive(name: str, *, start: float) -> Probe:
    """A force A cos(w t + phase) along y, t being the scene's own time: it reads the clock.

    It never vanishes within the probe: step control that is relative to the force would stop there.
    """
    amplitude = 12.0
    rate = 1.25
    phase = -0.7
    mass = 2.0
    start_velocity = 0.5
    body = Body(mass=mass, position=(1.0, 0.0, 0.0), velocity=(0.0, start_velocity, 0.0))
    force = Force(a=0, amplitude=amplitude, frequency=rate, phase=phase, axis=(0.0, 1.0, 0.0))
    angle_at_start = rate * start + phase

    def expected(t: Array) -> Expected:
        # m v' = A cos(a) with the angle a = w t + a0, integrated twice from the start on:
        # v = v0 + A/(m w) (sin a - sin a0),
        # y = (v0 - A/(m w) sin a0) t + A/(m w^2) (cos a0 - cos a).
        angle = rate * t + angle_at_start
        velocity_amplitude = amplitude / (mass * rate)
        v = start_velocity + velocity_amplitude * (np.sin(angle) - np.sin(angle_at_start))
        oscillation = velocity_amplitude / rate * (np.cos(angle_at_start) - np.cos(angle))
        y = (start_velocity - velocity_amplitude * np.sin(angle_at_start)) * t + oscillation
        return _moved(np.array([1.0, 0.0, 0.0]), np.array([0.0, 1.0, 0.0]), y, v)

    scene = Scene.of([body], [force])
    verifies = "the frequency, phase and time of a harmonic force"
    return Probe(name=name, verifies=verifies, scene=scene, expected=expected, start=start)


def _drive_between() -> Probe:
    """A force A cos(w t) along an oblique axis on one of two points, and the opposite on the other.

    m v' = +-A cos(w t), so that v = v0 +- A/(m w) sin(w t), and the place changes by v0 t +-
    A/(m w^2) (1 - cos(w t)).
    """
    masses = np.array([2.0, 5.0])
    signs = np.array([1.0, -1.0])
    amplitude = 12.0
    rate = 1.25
    axis = np.array([0.8, -0.6, 0.0])
    places = np.array([[1.0, -0.5, 0.0], [-0.25, 0.75, 0.0]])
    start_velocity = np.array([[0.25, 0.5, 0.0], [-0.5, 1.0, 0.0]])
    velocity_amplitude = (signs * amplitude / (masses * rate))[:, None] * axis

    def expected(t: Array) -> Expected:
        clock = t[:, None, None]
        changed = velocity_amplitude * np.sin(rate * clock)
        moved = velocity_amplitude / rate * (1 - np.cos(rate * clock))
        return {
            "position": places + clock * start_velocity + moved,
            "velocity": start_velocity + changed,
        }

    bodies = [
        Body(mass=float(mass), position=_vector(place), velocity=_vector(speed))
        for mass, place, speed in zip(masses, places, start_velocity, strict=True)
    ]
    force = Force(a=0, b=1, amplitude=amplitude, frequency=rate, axis=_vector(axis))
    return Probe(
        name="drive between two",
        verifies="a force between two bodies, with its reaction on the second",
        scene=Scene.of(bodies, [force]),
        expected=expected,
    )


def _dumbbell() -> Probe:
    """Two points on a rod that turns about their centre of mass, which moves.

    The tension is mu w^2 l with the reduced mass mu = m1 m2/(m1 + m2).
    """
    first_mass = 2.0
    second_mass = 3.0
    length = 1.25
    rate = 2.0
    total = first_mass + second_mass
    centre = np.array([1.0, -0.5, 0.0])
    drift = np.array([0.25, 0.5, 0.0])
    # Signed distances from the centre of mass along the rod.
    arms = np.array([second_mass, -first_mass]) / total * length

    def expected(t: Array) -> Expected:
        # The rod's direction and its normal at the angle w t + 1/2.
        angle = rate * t + 0.5
        along = np.column_stack([np.cos(angle), np.sin(angle), 0 * t])[:, None]
        across = np.column_stack([-np.sin(angle), np.cos(angle), 0 * t])[:, None]
        position = (centre + np.outer(t, drift))[:, None] + arms[:, None] * along
        velocity = drift + rate * arms[:, None] * across
        tension = first_mass * second_mass / total * rate**2 * length
        return {"position": position, "velocity": velocity, "rod_force": np.full(len(t), tension)}

    start = expected(np.zeros(1))
    places = map(_vector, start["position"][0])
    speeds = map(_vector, start["velocity"][0])
    masses = (first_mass, second_mass)
    bodies = [
        Body(mass=mass, position=place, velocity=speed)
        for mass, place, speed in zip(masses, places, speeds, strict=True)
    ]
    scene = Scene.of(bodies, [Rod(a=1, b=0, length=length)])
    return Probe(
        name="dumbbell",
        verifies="a rod between two bodies, and the sign of its force",
        scene=scene,
        expected=expected,
    )


def _closing(t: Array, rate: float) -> tuple[Array, Array]:
    """An undamped head-on contact that begins at t = 0, with w = `rate` [1/s].

    Returns the closing velocity over its first value (T,), cos(w t) up to w t = pi and -1 after
    that, and its integral (T,) [s].
    """
    phase = np.minimum(rate * t, np.pi)
    time_after_contact = np.maximum(t - np.pi / rate, 0.0)
    return np.cos(phase), np.sin(phase) / rate - time_after_contact


def _knock(name: str, *, normal: Vector, drift: Vector) -> Probe:
    """Two unlike spheres that touch at the start and close along `normal`, the front one listed
    first; their centre of mass moves with `drift` [m/s].

    The contact has w = sqrt(k/mu) with the reduced mass mu = m1 m2/(m1 + m2).
    """
    front_mass = 3.0
    back_mass = 2.0
    front_radius = 0.25
    back_radius = 0.5
    total = front_mass + back_mass
    rate = float(np.sqrt(STIFFNESS * total / (front_mass * back_mass)))
    speed = 1.5
    along = np.array(normal)
    centre_velocity = np.array(drift)
    back_start = np.array([-1.0, 0.5, 0.0])
    front_start = back_start + (front_radius + back_radius) * along
    # The part of the relative motion that each body makes.
    shares = np.array([-back_mass, front_mass]) / total

    def expected(t: Array) -> Expected:
        closing, closed = (speed * x for x in _closing(t, rate))
        starts = np.stack([front_start, back_start])
        # Relative to the centre of mass the closing velocity falls from `speed` to -speed.
        approach = (closed[:, None] * shares)[..., None] * along
        position = starts + t[:, None, None] * centre_velocity + approach
        velocity = centre_velocity + (closing[:, None] * shares)[..., None] * along
        return {"position": position, "velocity": velocity}

    start = expected(np.zeros(1))
    front_place, back_place = map(_vector, start["position"][0])
    front_speed, back_speed = map(_vector, start["velocity"][0])
    front = Body(
        mass=front_mass,
        position=front_place,
        velocity=front_speed,
        shape=Sphere(radius=front_radius),
    )
    back = Body(
        mass=back_mass, position=back_place, velocity=back_speed, shape=Sphere(radius=back_radius)
    )
    bodies = [front, back]
    scene = Scene.of(bodies, [Contact(law="linear", stiffness=STIFFNESS)])
    verifies = "the masses, the radii and the direction of the contact force"
    return Probe(name=name, verifies=verifies, scene=scene, expected=expected)


def _floor() -> Probe:
    """A smooth sphere that glides along a sloping wall and bounces back from it, w = sqrt(k/m)."""
    mass = 2.0
    radius = 0.5
    speed = 1.5
    rate = float(np.sqrt(STIFFNESS / mass))
    normal = np.array([-0.6, 0.8, 0.0])
    glide = np.array([0.8, 0.6, 0.0])
    point = np.array([1.0, -2.0, 0.0])
    start = point + radius * normal

    def expected(t: Array) -> Expected:
        closing, closed = (speed * x for x in _closing(t, rate))
        position = start + np.outer(t, glide) - np.outer(closed, normal)
        velocity = glide - np.outer(closing, normal)
        return {"position": position[:, None], "velocity": velocity[:, None]}

    body = Body(
        mass=mass,
        position=_vector(start),
        velocity=_vector(glide - speed * normal),
        shape=Sphere(radius=radius),
    )
    scene = Scene.of(
        [body],
        [
            Plane(point=_vector(point), normal=_vector(normal)),
            Contact(law="linear", stiffness=STIFFNESS),
        ],
    )
    return Probe(
        name="floor", verifies="the position and normal of a wall", scene=scene, expected=expected
    )


def _hanging_from_fixed() -> Probe:
    """A mass that hangs by a spring from a fixed body, which neither falls nor is pulled.

    It oscillates along gravity about the stretch m g/k with w = sqrt(k/m).
    """
    mass = 2.0
    rate = 4.0
    length = 1.25
    weight = 8.0
    speed = 1.5
    down = np.array([2.0, -1.0, -2.0]) / 3.0
    support = np.array([1.0, -0.5, 0.25])
    hanging = length + weight / rate**2

    def expected(t: Array) -> Expected:
        place = hanging + speed / rate * np.sin(rate * t)
        return _beside_fixed(support, down, place, speed * np.cos(rate * t))

    fixed = Body(mass=3.0, position=_vector(support), fixed=True)
    hung = Body(
        mass=mass, position=_vector(support + hanging * down), velocity=_vector(speed * down)
    )
    elements = [
        UniformGravity(g=_vector(weight * down)),
        Spring(a=0, b=1, stiffness=mass * rate**2, length=length),
    ]
    return Probe(
        name="hanging from a fixed body",
        verifies="a fixed body, which neither gravity nor a spring may move",
        scene=Scene.of([fixed, hung], elements),
        expected=expected,
    )


def _resting_on_fixed() -> Probe:
    """A sphere that its weight holds on a fixed sphere, which neither falls nor is pushed.

    It oscillates along gravity about the overlap m g/k with w = sqrt(k/m), with an amplitude below
    that overlap.
    """
    mass = 2.0
    weight = 8.0
    rate = float(np.sqrt(STIFFNESS / mass))
    resting = weight / rate**2
    speed = resting * rate / 2
    radii = (0.5, 0.25)
    up = np.array([0.0, 0.6, 0.8])
    support = np.array([-1.0, 0.5, 0.25])

    def expected(t: Array) -> Expected:
        place = sum(radii) - resting + speed / rate * np.sin(rate * t)
        return _beside_fixed(support, up, place, speed * np.cos(rate * t))

    start = support + (sum(radii) - resting) * up
    fixed = Body(mass=3.0, position=_vector(support), shape=Sphere(radius=radii[0]), fixed=True)
    resting_body = Body(
        mass=mass,
        position=_vector(start),
        velocity=_vector(speed * up),
        shape=Sphere(radius=radii[1]),
    )
    elements = [
        UniformGravity(g=_vector(-weight * up)),
        Contact(law="linear", stiffness=STIFFNESS),
    ]
    return Probe(
        name="resting on a fixed sphere",
        verifies="a fixed body, which neither gravity nor a contact may move",
        scene=Scene.of([fixed, resting_body], elements),
        expected=expected,
    )


def _beside_fixed(support: Array, along: Array, x: Array, v: Array) -> Expected:
    """Motion of a second body at `support` + x e, the first one being fixed at `support`.

    `x` [m] and `v` [m/s] are (T,), `support` [m] and the unit vector e = `along` (3,).
    """
    moving = _moved(support, along, x, v)
    return {
        "position": np.concatenate([0 * moving["position"] + support, moving["position"]], axis=1),
        "velocity": np.concatenate([0 * moving["velocity"], moving["velocity"]], axis=1),
    }


def _vector(values: Array) -> Vector:
    """The three numbers of an array (3,), as scenes take them."""
    x, y, z = values.tolist()
    return x, y, z
