"""A rigid prism that hits a smooth plane with one corner and rotates away from it, in closed form.

With the arm r from the centre to the corner, the normal n, the closing speed c = -(u + omega (r x
n)_z) and the coefficient of restitution e, the impulse along n is

    J = (1 + e) c/(1/m + (r x n)_z^2/I),   u+ = u + J/m,   omega+ = omega + (r x n)_z J/I,

and the loss of energy is (1 - e^2) c^2/(2 (1/m + (r x n)_z^2/I)).
"""

from dataclasses import dataclass
from time import perf_counter
from typing import Any

import numpy as np
from numpy.typing import NDArray

from refdem.core.engine import Method
from refdem.core.problem import Motion, Request
from refdem.core.trajectory import Cost, Event, Trajectory
from refdem.mechanics.quaternion import product, rotated, turned_by
from refdem.scene import Polyhedron
from refdem.scene.elements.contact import Contact
from refdem.scene.elements.plane import Plane
from refdem.solvers._scene_pattern import ONE, ScenePattern, SceneSolver

Array = NDArray[np.float64]
ALIKE = 1e-12
"""Relative difference of heights, in radii, up to which corners touch at the same time."""
MOST_ADVANCES = 200
"""Largest number of steps towards the impact of a rotating box. The steps converge quadratically to
the impact of a corner that approaches the plane, but not to a grazing contact.
"""


class ExactCornerImpact(SceneSolver):
    """One impulse between two flights on a straight line, each with a turn at a constant rate."""

    claims = Method(
        name="exact-corner-impact",
        summary="straight line, impulse at a corner, turn at a constant rate",
        control="exact",
        locates_events=True,
        cost_rank=1,
    )

    pattern = ScenePattern(
        elements={Contact: ONE, Plane: ONE},
        bodies=ONE,
        shape=Polyhedron,
        law="rigid",
        has_inertia=True,
        in_plane=True,
        irreversible="the state before an impact cannot be recovered",
    )

    def unsupported_values(self, problem: Motion) -> str | None:
        """None for a smooth plane that one edge along z meets, and no other one after it, else the
        reason.
        """
        scene = problem.scene
        if scene.all(Contact)[0].friction > 0:
            return "friction on a corner"
        met = _met(problem)
        if isinstance(met, str):
            return met
        lasts = float(problem.times[-1] - problem.times[0]) - met.time
        if lasts > met.clear and not met.is_clear_for_ever:
            return "a second corner may meet the plane"
        return None

    def run(self, request: Request) -> tuple[Trajectory, Cost]:
        """States at the samples, the energy lost and the impact."""
        begun = perf_counter()
        problem = request.problem
        assert isinstance(problem, Motion)
        bodies = problem.scene.bodies
        met = _met(problem)
        assert isinstance(met, _Impact)
        started = perf_counter()
        t = problem.times - problem.times[0]
        until = np.minimum(t, met.time)[:, None, None]
        since = np.maximum(t - met.time, 0.0)[:, None, None]
        has_met = t > met.time
        # r = r0 + v0 t + (v+ - v0) (t - t_i) after the impact at t_i; omega is piecewise constant.
        position = bodies.position + bodies.velocity * t[:, None, None] + met.kick * since
        velocity = bodies.velocity + np.where(has_met[:, None, None], met.kick, 0.0)
        omega = np.where(has_met[:, None, None], met.omega, bodies.omega)
        # All rotations are about z and commute: their angles add up.
        attitude = product(turned_by(bodies.omega * until + met.omega * since), bodies.attitude)
        events = []
        if has_met.any():
            events.append(Event(time=float(problem.times[0] + met.time), kind="contact", body=0))
        trajectory = Trajectory(
            t=problem.times,
            position=position,
            velocity=velocity,
            attitude=attitude,
            omega=omega,
            channels={"dissipated_work": np.where(has_met, met.lost, 0.0)},
            events=tuple(events),
        )
        seconds = perf_counter() - started
        return trajectory, Cost(seconds=seconds, setup=started - begun)


@dataclass(frozen=True)
class _Impact:
    """The impact: `time` [s], the change `kick` (3,) [m/s] of the velocity, `omega` (3,) [rad/s]
    after it and the energy `lost` [J].

    No corner can touch the plane for `clear` [s] after it, nor ever if `is_clear_for_ever`.
    """

    time: float
    kick: Array
    omega: Array
    lost: float
    clear: float
    is_clear_for_ever: bool


def _met(problem: Motion) -> _Impact | str:
    """The first impact of a single corner, or the reason why there is none."""
    scene = problem.scene
    bodies = scene.bodies
    plane = scene.all(Plane)[0]
    normal = np.array(plane.normal)
    shape: Any = bodies.shape[0]
    arms = rotated(bodies.attitude[0], np.array(shape.vertices))
    radius = float(np.linalg.norm(arms[:, :2], axis=1).max())
    place = float((bodies.position[0] - np.array(plane.point)) @ normal)
    fall = _Fall(place, float(bodies.velocity[0] @ normal), float(bodies.omega[0, 2]), normal)
    duration = float(problem.times[-1] - problem.times[0])
    time = fall.touch(arms, duration)
    if time is None:
        return "a body that does not come down on the plane from above it"
    arms = rotated(turned_by(np.array([0.0, 0.0, fall.spin * time])), arms)
    heights = arms @ normal
    low = heights < heights.min() + ALIKE * radius
    # The corners of one edge along z touch together, as one corner in the plane of the motion.
    arm = arms[low][0] * np.array([1.0, 1.0, 0.0])
    if np.ptp((arms[low] - arm)[:, :2], axis=0).max() > ALIKE * radius:
        return "a face that meets the plane"
    mass = float(bodies.mass[0])
    inertia = float(bodies.inertia[0, 2])
    # (r x n)_z, and c = -(u + omega (r x n)_z).
    lever = float(arm[0] * normal[1] - arm[1] * normal[0])
    closing = -(fall.speed + fall.spin * lever)
    # J = (1 + e) c/(1/m + (r x n)_z^2/I), omega+ = omega + (r x n)_z J/I, u+ = u + J/m.
    ease = 1 / mass + lever**2 / inertia
    e = scene.all(Contact)[0].restitution
    impulse = (1 + e) * closing / ease
    rate = fall.spin + lever * impulse / inertia
    rise = fall.speed + impulse / mass
    clear = _clear(arms, normal, heights, low, rise, rate, radius)
    # Height of the centre at the impact. All corners are clear for ever once the centre is higher
    # than the radius and rises.
    above = -float(heights.min())
    return _Impact(
        time=time,
        kick=impulse / mass * normal,
        omega=np.array([0.0, 0.0, rate]),
        lost=(1 - e * e) * closing**2 / (2 * ease),
        clear=clear,
        is_clear_for_ever=rise > 0 and radius - above < rise * clear,
    )


@dataclass(frozen=True)
class _Fall:
    """The flight before the impact: height of the centre above the plane [m], its velocity along
    the normal [m/s], the angular velocity about z [rad/s], and the normal (3,).
    """

    place: float
    speed: float
    spin: float
    normal: Array

    def touch(self, arms: Array, duration: float) -> float | None:
        """The time [s] at which the first descending corner touches the plane, or None if none does
        within the duration.

        Conservative advancement (Mirtich 1996): no corner touches before the smallest root of g + u
        s - R omega^2 s^2/2 = 0, with the gap g, its rate u and the distance R of each corner.
        """
        if self.place + float((arms @ self.normal).min()) <= 0:
            return None
        if self.spin == 0:
            if self.speed >= 0:
                return None
            return -(self.place + float((arms @ self.normal).min())) / self.speed
        reach = np.linalg.norm(arms[:, :2], axis=1)
        bend = reach * self.spin**2
        t = 0.0
        for _ in range(MOST_ADVANCES):
            gap, rising = self.corners(arms, t)
            lowest = int(np.argmin(gap))
            # At a gap of the size of rounding one Newton step, t - g/g', gives the time.
            if gap[lowest] <= ALIKE * reach.max():
                if rising[lowest] >= 0:
                    return None
                return t - float(gap[lowest] / rising[lowest])
            # s = (u + sqrt(u^2 + 2 R omega^2 g))/(R omega^2), the least of all corners.
            t += float(((rising + np.sqrt(rising**2 + 2 * bend * gap)) / bend).min())
            if t > duration:
                return None
        return None

    def corners(self, arms: Array, t: float) -> tuple[Array, Array]:
        """Heights (M,) [m] of the corners above the plane at t [s], and their rates [m/s]."""
        turned = rotated(turned_by(np.array([0.0, 0.0, self.spin * t])), arms)
        # g = h + u t + n . R(omega t) r and g' = u + omega (R(omega t) r x n)_z.
        gap = self.place + self.speed * t + turned @ self.normal
        across = turned[:, 0] * self.normal[1] - turned[:, 1] * self.normal[0]
        return gap, self.speed + self.spin * across


def _clear(
    arms: Array,
    normal: Array,
    heights: Array,
    low: NDArray[np.bool_],
    rise: float,
    rate: float,
    radius: float,
) -> float:
    """The time [s] after the impact within which no corner can touch the plane.

    A corner is at least g + u s - R omega^2 s^2/2 above the plane, with its height g and its
    velocity u right after the impact, because its only acceleration is that of the rotation.
    """
    gap = np.where(low, 0.0, heights - heights.min())
    rising = rise + rate * (arms[:, 0] * normal[1] - arms[:, 1] * normal[0])
    bend = radius * rate**2
    if bend == 0:
        return float(np.inf)
    # s = (u + sqrt(u^2 + 2 R omega^2 g))/(R omega^2).
    roots = (rising + np.sqrt(rising**2 + 2 * bend * gap)) / bend
    return float(roots.min())


METHOD = ExactCornerImpact()
