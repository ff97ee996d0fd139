"""One sphere against a wall under Hertz's law: the normal motion in closed form
(kernels/power_contact.c), sliding friction by its impulse.

The slip velocity p and the slip distance q = integral p dt determine the tangential motion. For a
solid sphere (J = 2/5 m R^2) a tangential impulse per mass i changes the velocity by i, R omega by
5/2 i, and therefore p by 7/2 i. A loss of p is thus shared by velocity and R omega as 2/7 and 5/7,
and friction dissipates m (p0^2 - p^2)/7.
"""

from time import perf_counter
from typing import Any

import numpy as np
from numpy.typing import NDArray

from refdem.core.engine import Method
from refdem.core.problem import Motion, Request
from refdem.core.trajectory import Cost, Event, Trajectory
from refdem.scene import Scene, Sphere
from refdem.scene.elements.contact import Contact
from refdem.scene.elements.plane import Plane
from refdem.solvers._kernel_solver import KernelCall, samples
from refdem.solvers._mindlin_spring import Spring, course
from refdem.solvers._scene_pattern import ONE, ScenePattern, SceneSolver

Array = NDArray[np.float64]
ROUNDED = 4 * 2.0**-52
"""Relative size of overlaps, slips and differences of inertia that are rounding."""


class ExactHertzWall(SceneSolver):
    """A sphere against a wall under Hertz's law, whose slip stays on one line.

    Without a tangential spring the slip decreases by 7/2 mu times the normal impulse per mass until
    it is zero, and stays zero. A tangential spring is integrated by `_mindlin_spring`.
    """

    claims = Method(
        name="exact-hertz-wall",
        summary=(
            "Hertz's contact with a wall in closed form; sliding friction by the impulse, or a"
            " tangential spring by Taylor series"
        ),
        control="exact",
        conserves=frozenset({"energy"}),
        complete_state=False,
        cost_rank=5,
    )
    kernels = ("power_contact",)

    pattern = ScenePattern(
        elements={Contact: ONE, Plane: ONE},
        bodies=ONE,
        shape=Sphere,
        law="hertz",
        irreversible="the motion before friction stopped it cannot be recovered",
    )

    def unsupported_values(self, problem: Motion) -> str | None:
        """None for a sphere at or before the plane whose slip stays on one line, else the
        reason.
        """
        scene = problem.scene
        bodies = scene.bodies
        law = scene.all(Contact)[0]
        plane = scene.all(Plane)[0]
        radius = bodies.radius[0]
        # J = 2/5 m R^2, for which a tangential impulse per mass i changes the slip by 7/2 i.
        solid_moment = 0.4 * bodies.mass[0] * radius**2
        is_solid = np.all(np.abs(bodies.inertia[0] - solid_moment) <= ROUNDED * solid_moment)
        if law.friction > 0 and (law.branch != "R" or not is_solid):
            return "friction with another lever than R, or on a sphere that is not solid"
        if np.any(bodies.omega) and not (is_solid and np.all(bodies.omega[0, :2] == 0)):
            return "the sphere turns about another axis than z"
        height = (bodies.position[0] - np.array(plane.point)) @ np.array(plane.normal)
        if float(height) - radius < -ROUNDED * radius:
            return "sphere and plane overlap at the start"
        return None

    def run(self, request: Request) -> tuple[Trajectory, Cost]:
        """States, contact channels and events at the samples."""
        begun = perf_counter()
        scene = request.problem.scene
        t = request.problem.times
        impact = Impact(scene)
        started = perf_counter()
        elapsed = t - t[0]
        overlap_and_rate, times = impact.normal(elapsed)
        if impact.springs:
            slip_law = impact.spring_losses
        else:
            slip_law = impact.sliding_losses
        slip_loss, distance_loss = slip_law(elapsed, overlap_and_rate, times)
        columns = impact.columns_after(elapsed, overlap_and_rate, slip_loss, distance_loss)
        events = []
        for when, kind in ((times[0], "contact"), (times[2], "release")):
            if 0 < when <= elapsed[-1]:
                events.append(Event(time=float(t[0] + when), kind=kind, body=0))
        trajectory = Trajectory(t=t, events=tuple(events), **columns)
        cost = Cost(seconds=perf_counter() - started, setup=started - begun)
        return trajectory, cost


class Impact:
    """The initial state, resolved along and across the unit normal n into the wall."""

    def __init__(self, scene: Scene) -> None:
        bodies = scene.bodies
        self.law = scene.all(Contact)[0]
        plane = scene.all(Plane)[0]
        # n into the wall; d = R + (r - P) . n with the point P of the plane, and d' = v . n.
        self.n = -np.array(plane.normal)
        self.mass = float(bodies.mass[0])
        self.radius = float(bodies.radius[0])
        self.place = bodies.position[0]
        self.velocity = bodies.velocity[0]
        self.omega = bodies.omega[0]
        self.attitude = bodies.attitude[0]
        overlap = self.radius + float((self.place - np.array(plane.point)) @ self.n)
        if abs(overlap) <= ROUNDED * self.radius:
            self.overlap = 0.0
        else:
            self.overlap = overlap
        self.rate = float(self.velocity @ self.n)
        self.across = self.velocity - self.rate * self.n
        # Velocity of the point of contact: v + R omega x n, without its part along n.
        slip = self.across + self.radius * np.cross(self.omega, self.n)
        speed = float(np.linalg.norm(slip))
        if speed > ROUNDED * np.linalg.norm(self.velocity):
            self.slip = speed
        else:
            self.slip = 0.0
        if self.slip:
            self.along = slip / self.slip
        else:
            self.along = 0.0 * slip
        has_spring = self.law.friction > 0 and self.law.tangential_stiffness > 0
        self.springs = self.slip > 0 and has_spring

    def normal(self, t: Array) -> tuple[Array, Array]:
        """Overlap and its rate (T, 2) at elapsed times t, and the times (3,) of contact, greatest
        overlap and release.
        """
        overlap_and_rate = np.empty((len(t), 2))
        times = np.empty(3)
        law = np.array([self.law.stiffness, self.law.exponent])
        call = KernelCall(
            function="refdem_power_contact",
            inputs=(self.mass, law, law, self.overlap, self.rate),
            clock=samples(t),
            outputs=(times, overlap_and_rate),
        )
        call.made("power_contact")
        return overlap_and_rate, times

    def stopping_time(self, impulse: float, times: Array) -> float:
        """The time [s] at which the normal impulse per mass has reached `impulse`, by bisection.

        The impulse per mass up to time t is rate(0) - rate(t).
        """
        low = times[0]
        high = times[2]
        for _ in range(60):
            middle = (low + high) / 2
            state, _ = self.normal(np.array([middle]))
            if self.rate - state[0, 1] > impulse:
                high = middle
            else:
                low = middle
        return float(low + high) / 2

    def sliding_losses(
        self, t: Array, overlap_and_rate: Array, times: Array
    ) -> tuple[Array, Array]:
        """Loss of slip velocity (T,) [m/s] by sliding friction, and loss of slip distance (T,) [m],
        its integral.

        The loss is 7/2 mu J, with the normal impulse per mass J = rate(0) - rate(t), until it has
        used up the slip.
        """
        if self.slip > 0:
            friction = self.law.friction
        else:
            friction = 0.0
        # The impulse per mass that ends the slip: 7/2 mu J = slip.
        if friction:
            stopping_impulse = self.slip * 2 / 7 / friction
        else:
            stopping_impulse = np.inf
        # The normal impulse per mass of the whole contact is 2 rate(0).
        if stopping_impulse < 2 * self.rate:
            stop_time = self.stopping_time(stopping_impulse, times)
        else:
            stop_time = np.inf
        # Time integral of J: rate(0) t - (d(t) - d(0)) up to the end of the slip at t_s, and J(t_s)
        # (t - t_s) beyond it.
        sliding_until = np.minimum(t, stop_time)
        state_then, _ = self.normal(sliding_until)
        sliding_integral = self.rate * sliding_until - (state_then[:, 0] - self.overlap)
        rolling_integral = np.zeros_like(t)
        if np.isfinite(stop_time):
            rolling_integral = stopping_impulse * (t - sliding_until)
        impulse = np.minimum(self.rate - overlap_and_rate[:, 1], stopping_impulse)
        return 3.5 * friction * impulse, 3.5 * friction * (sliding_integral + rolling_integral)

    def spring_losses(self, t: Array, overlap_and_rate: Array, times: Array) -> tuple[Array, Array]:
        """The losses of slip velocity and slip distance with a tangential spring that is relaxed at
        first contact.
        """
        # Units of the series: the speed at touch, and the greatest overlap. In these units p is the
        # slip velocity and q the slip distance since touch.
        speed = self.rate
        at_turn, _ = self.normal(times[1:2])
        greatest_overlap = float(at_turn[0, 0])
        spring = Spring(self.law.tangential_stiffness / self.law.stiffness, self.law.friction)
        contact = course(spring, self.slip / speed)
        slip = np.full(len(t), self.slip)
        distance = self.slip * t
        final_slip, final_distance = contact.end()
        after = t - times[2]
        # During the contact from the series; after it the slip is constant.
        for n in np.flatnonzero((t > times[0]) & (after < 0)):
            depth = max(overlap_and_rate[n, 0], 0.0) / greatest_overlap
            p, q = contact.at(depth, overlap_and_rate[n, 1] / speed)
            slip[n] = p * speed
            distance[n] = self.slip * times[0] + q * greatest_overlap
        is_released = after >= 0
        slip[is_released] = final_slip * speed
        distance[is_released] = (
            self.slip * times[0]
            + final_distance * greatest_overlap
            + final_slip * speed * after[is_released]
        )
        return self.slip - slip, self.slip * t - distance

    def columns_after(
        self, t: Array, overlap_and_rate: Array, slip_loss: Array, distance_loss: Array
    ) -> dict[str, Any]:
        """Columns and channels of a trajectory, from the losses of slip velocity and slip
        distance.
        """
        overlap_growth = overlap_and_rate[:, 0] - self.overlap
        # With the loss D of slip velocity and its integral Q:
        # r = r0 + across t + (d - d0) n - 2/7 Q along,
        # v = across + d' n - 2/7 D along,
        # omega = omega0 - 5/7 D/R (n x along).
        free_flight = self.place + self.across * t[:, None]
        shift_back = distance_loss[:, None] * self.along * (2 / 7)
        position = free_flight + overlap_growth[:, None] * self.n - shift_back
        velocity_loss = slip_loss[:, None] * self.along * (2 / 7)
        velocity = self.across + overlap_and_rate[:, 1:] * self.n - velocity_loss
        spin_axis = np.cross(self.n, self.along)
        omega = self.omega - slip_loss[:, None] * spin_axis * (5 / 7 / self.radius)
        # Friction dissipates m (p0^2 - p^2)/7 = m lost (2 p0 - lost)/7.
        work = self.mass / 7 * slip_loss * (2 * self.slip - slip_loss)
        overlap = np.maximum(overlap_and_rate[:, 0], 0.0)
        force = self.law.stiffness * overlap**self.law.exponent
        channels = {
            "overlap": overlap,
            "contacts": (overlap > 0).astype(float),
            "contact_force": force,
            "dissipated_work": work,
        }
        attitude = np.repeat(self.attitude[None, None], len(t), axis=0)
        columns = {
            "position": position[:, None],
            "velocity": velocity[:, None],
            "omega": omega[:, None],
        }
        return columns | {"attitude": attitude, "channels": channels}


METHOD = ExactHertzWall()
