"""A rigid sphere that slides on a plane under gravity and Coulomb friction, and rolls in the end:
constant accelerations, phase by phase.

Notation: n is the normal of the plane, d a unit vector along it on whose line everything lies, and
a = n x d; u is the velocity along d, w the angular velocity about a. The point of contact slips
with s = u - R w, and J = f m R^2.
"""

from dataclasses import dataclass
from time import perf_counter

import numpy as np
from numpy.typing import NDArray

from refdem.core.engine import Method
from refdem.core.problem import Motion, Request
from refdem.core.trajectory import Cost, Event, Trajectory
from refdem.mechanics.quaternion import product
from refdem.scene import Scene, Sphere
from refdem.scene.elements.contact import Contact
from refdem.scene.elements.plane import Plane
from refdem.scene.elements.uniform_gravity import UniformGravity
from refdem.solvers import _balance
from refdem.solvers._scene_pattern import ANY, ONE, ScenePattern, SceneSolver

Array = NDArray[np.float64]
SLACK = 8 * 2.0**-52
"""Relative rounding of a slip and of a slope; smaller values count as zero."""
ASKEW = 1e-12
"""Largest relative component off the plane, or off the line of the motion: round-off of a scene
that was rotated, or moved by a few ulp.
"""


@dataclass(frozen=True)
class Rolled:
    """Rates and limits of one body on one plane.

    `along` and `pressing` are gravity along d and against n [m/s^2], `friction` is mu, `factor` f.
    """

    direction: Array
    axis: Array
    radius: float
    factor: float
    friction: float
    along: float
    pressing: float

    def rates(self, side: int) -> tuple[float, float]:
        """u' [m/s^2] and w' [rad/s^2] for the sign of the slip, 0 while it rolls."""
        if side == 0:
            # Rolling keeps s = u - R w = 0: u' = g_d/(1 + f), R w' = u'.
            rolling = self.along / (1 + self.factor)
            return rolling, rolling / self.radius
        # Sliding: F/m = -mu g_n sgn s and J w' = -R F, J = f m R^2. Then u' = g_d + F/m and w' =
        # -(F/m)/(f R).
        rubbing = -side * self.friction * self.pressing
        return self.along + rubbing, -rubbing / (self.factor * self.radius)

    def side_after(self) -> int:
        """The sign of the slip right after a time at which it is 0.

        Rolling requires the friction F/m = |g_d| f/(1 + f). It rolls on if this is at most mu g_n.
        """
        limit = self.friction * self.pressing * (1 + 1 / self.factor)
        if abs(self.along) <= limit * (1 + SLACK):
            return 0
        return int(np.sign(self.along))


@dataclass(frozen=True)
class Phase:
    """A phase with constant rates from `begin` [s] on. `state` has the distance [m], u [m/s], the
    angle [rad], w [rad/s] and the work of friction [J] at its beginning.

    `side` is the sign of the slip, 0 while it rolls; `slip` [m/s] is that at the start and
    `slip_rate` [m/s^2] its rate. `rubbing` is the size of the friction [N] while it slides.
    """

    begin: float
    side: int
    state: tuple[float, float, float, float, float]
    rates: tuple[float, float]
    slip: float
    slip_rate: float
    rubbing: float

    def after(self, since: Array) -> tuple[Array, Array, Array, Array, Array]:
        """The five numbers of `state` at times `since` [s] after the beginning of the phase."""
        way, speed, angle, spin, work = self.state
        acceleration, spin_up = self.rates
        gained = since * since / 2
        # The slip distance is the integral of s = u - R w; friction dissipates mu N times its size.
        slipped = self.slip * since + self.slip_rate * gained
        return (
            way + speed * since + acceleration * gained,
            speed + acceleration * since,
            angle + spin * since + spin_up * gained,
            spin + spin_up * since,
            work + self.rubbing * np.abs(slipped),
        )


class ExactRolling(SceneSolver):
    """One sphere on one plane whose slip stays on one line."""

    claims = Method(
        name="exact-rolling",
        summary="constant accelerations while it slides and while it rolls",
        control="exact",
        complete_state=False,
        conserves=frozenset({"energy", "angular-momentum"}),
        cost_rank=1,
    )

    pattern = ScenePattern(
        elements={Contact: ONE, Plane: ONE, UniformGravity: ANY},
        bodies=ONE,
        shape=Sphere,
        law="rigid",
        has_inertia=True,
        irreversible="a body that rolls may have slid before",
    )

    def unsupported_values(self, problem: Motion) -> str | None:
        """None for a sphere that lies on the plane, and moves and turns along one line of it, else
        the reason.
        """
        scene = problem.scene
        bodies = scene.bodies
        load = _balance.pressed(scene)
        if isinstance(load, str):
            return load
        if np.any(bodies.inertia != bodies.inertia[:, :1]):
            return "a body whose moments of inertia differ"
        height = float((bodies.position[0] - load.point) @ load.normal)
        size = max(float(np.abs(bodies.position).max()), float(bodies.radius[0]))
        if abs(height - bodies.radius[0]) > ASKEW * size:
            return "the sphere does not touch the plane at the start"
        speed = float(np.linalg.norm(bodies.velocity[0]))
        if abs(float(bodies.velocity[0] @ load.normal)) > ASKEW * speed:
            return "the sphere moves towards the plane or away from it"
        return _off_line(scene, load)

    def run(self, request: Request) -> tuple[Trajectory, Cost]:
        """Sliding, then rolling or sliding on; the start of rolling is an event."""
        begun = perf_counter()
        scene = request.problem.scene
        bodies = scene.bodies
        rolled = _rolled(scene)
        phases = _phases(rolled, scene)
        times = request.problem.times
        elapsed = times - times[0]
        started = perf_counter()
        columns = np.empty((5, len(times)))
        for phase in phases:
            within = elapsed >= phase.begin
            columns[:, within] = phase.after(elapsed[within] - phase.begin)
        # r = r0 + way d, v = u d, omega = w a, q = (cos(angle/2), sin(angle/2) a) q0.
        way, speed, angle, spin, work = columns
        displacement = way[:, None, None] * rolled.direction
        turned = product(_turn(rolled.axis, angle), bodies.attitude[0])
        trajectory = Trajectory(
            t=times,
            position=bodies.position + displacement,
            velocity=speed[:, None, None] * rolled.direction,
            attitude=turned[:, None],
            omega=spin[:, None, None] * rolled.axis,
            channels={"dissipated_work": work},
            events=_events(phases, times),
        )
        seconds = perf_counter() - started
        return trajectory, Cost(seconds=seconds, setup=started - begun)


def _turn(axis: Array, angle: Array) -> Array:
    """Quaternions (T, 4) of turns about a unit vector (3,) by angles (T,) [rad]."""
    half = angle[:, None] / 2
    return np.concatenate([np.cos(half), np.sin(half) * axis], axis=1)


def _events(phases: list[Phase], times: Array) -> tuple[Event, ...]:
    """The event at which the point of contact sticks, if it does within the run."""
    last = phases[-1]
    time = float(times[0] + last.begin)
    if len(phases) == 1 or last.side or time > times[-1]:
        return ()
    return (Event(time=time, kind="stick", body=0),)


def _rolled(scene: Scene) -> Rolled:
    """The numbers of the one body on the one plane; f = J/(m R^2)."""
    load = _balance.pressed(scene)
    assert not isinstance(load, str)
    bodies = scene.bodies
    mass = float(bodies.mass[0])
    radius = float(bodies.radius[0])
    direction = _direction(scene, load)
    return Rolled(
        direction=direction,
        axis=np.cross(load.normal, direction),
        radius=radius,
        factor=float(bodies.inertia[0, 0]) / (mass * radius * radius),
        friction=scene.all(Contact)[0].friction,
        along=float(load.along @ direction),
        pressing=load.pressing,
    )


def _phases(rolled: Rolled, scene: Scene) -> list[Phase]:
    """The first phase and, where its slip ends, the one after it."""
    bodies = scene.bodies
    speed = float(bodies.velocity[0] @ rolled.direction)
    spin = float(bodies.omega[0] @ rolled.axis)
    # s = u - R w.
    slip = speed - rolled.radius * spin
    if abs(slip) <= SLACK * (abs(speed) + rolled.radius * abs(spin)):
        slip = 0.0
        side = rolled.side_after()
    else:
        side = int(np.sign(slip))
    mass = float(bodies.mass[0])
    first = _phase(rolled, mass, 0.0, side, (0.0, speed, 0.0, spin, 0.0))
    if slip == 0.0 or not first.slip_rate * side < 0:
        return [first]
    # s + s' t = 0.
    ended = -slip / first.slip_rate
    way, speed, angle, spin, work = (float(x) for x in first.after(np.array(ended)))
    last_state = (way, speed, angle, spin, work)
    return [first, _phase(rolled, mass, ended, rolled.side_after(), last_state)]


def _phase(
    rolled: Rolled,
    mass: float,
    begin: float,
    side: int,
    state: tuple[float, float, float, float, float],
) -> Phase:
    """The phase that begins with a state, whose slip has the sign `side`."""
    acceleration, spin_up = rolled.rates(side)
    slip = 0.0
    slip_rate = 0.0
    if side:
        slip = state[1] - rolled.radius * state[3]
        # s' = u' - R w'.
        slip_rate = acceleration - rolled.radius * spin_up
    # The friction mu N = mu m g_n while it slides.
    rubbing = mass * rolled.friction * rolled.pressing
    return Phase(begin, side, state, (acceleration, spin_up), slip, slip_rate, rubbing)


def _direction(scene: Scene, load: _balance.Load) -> Array:
    """The unit vector (3,) of the line of the motion: down the slope, or along the velocity, or
    along the velocity of the point of contact; any line of a level plane for a body at rest.
    """
    bodies = scene.bodies
    # R omega x n = R w d: minus the velocity of the point of contact relative to the centre.
    across = bodies.radius[0] * np.cross(bodies.omega[0], load.normal)
    vectors = [bodies.velocity[0], across]
    # Gravity along a level plane that was rotated is round-off.
    if load.steepness > ASKEW:
        vectors.insert(0, load.along)
    for vector in vectors:
        # v - (v . n) n.
        within = vector - (vector @ load.normal) * load.normal
        length = float(np.linalg.norm(within))
        if length > 0:
            return np.asarray(within / length)
    reference = np.eye(3)[int(np.argmin(np.abs(load.normal)))]
    within = reference - (reference @ load.normal) * load.normal
    return np.asarray(within / np.linalg.norm(within))


def _off_line(scene: Scene, load: _balance.Load) -> str | None:
    """None if velocity and gravity lie along one line of the plane, and the body turns about the
    axis across it, else the reason.
    """
    bodies = scene.bodies
    direction = _direction(scene, load)
    axis = np.cross(load.normal, direction)
    speed = float(np.linalg.norm(bodies.velocity[0]))
    steep = float(np.linalg.norm(load.along))
    moves_aside = abs(float(bodies.velocity[0] @ axis)) > ASKEW * speed
    # In a level plane that was rotated, the component of gravity along it is a rounding of g_n.
    is_pulled_aside = abs(float(load.along @ axis)) > ASKEW * (steep + load.pressing)
    if moves_aside or is_pulled_aside:
        return "the slip leaves the line on which it begins"
    omega = bodies.omega[0]
    aside = float(np.linalg.norm(omega - (omega @ axis) * axis))
    if aside > ASKEW * float(np.linalg.norm(omega)):
        return "the body turns about another axis than it rolls about"
    return None


METHOD = ExactRolling()
