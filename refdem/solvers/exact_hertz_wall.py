"""One sphere against a wall under Hertz's law: kernels/power_contact.c along the normal, sliding
friction by its impulse.

Across, whatever the friction, the slip p and its way q say all: of what the slip loses the velocity
takes 2/7 and the spin, times R, 5/7, and the work done against friction is m (p0^2 - p^2)/7.
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


class ExactHertzWall(SceneSolver):
    """A sphere against a wall under Hertz's law; its slip keeps its line.

    Sliding, the slip falls by 7/2 mu times the normal impulse per mass, and stays zero then; or a
    tangential spring takes it.
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
        irreversible="friction has forgotten where it came from",
    )

    def unfit(self, problem: Motion) -> str | None:
        """None for a sphere at or before the plane whose slip keeps its line."""
        scene = problem.scene
        bodies = scene.bodies
        law = scene.all(Contact)[0]
        plane = scene.all(Plane)[0]
        radius = bodies.radius[0]
        moment = 0.4 * bodies.mass[0] * radius**2
        solid = np.all(np.abs(bodies.inertia[0] - moment) <= ROUNDED * moment)
        if law.friction > 0 and (law.branch != "R" or not solid):
            return "friction with another lever than R, or on a sphere that is not solid"
        if np.any(bodies.omega) and not (solid and np.all(bodies.omega[0, :2] == 0)):
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
        since = t - t[0]
        out, touch = impact.normal(since)
        if impact.springs:
            across = impact.bent
        else:
            across = impact.rubbed
        lost, missed = across(since, out, touch)
        found = impact.moved(since, out, lost, missed)
        events = []
        for when, kind in ((touch[0], "contact"), (touch[2], "release")):
            if 0 < when <= since[-1]:
                events.append(Event(time=float(t[0] + when), kind=kind, body=0))
        trajectory = Trajectory(t=t, events=tuple(events), **found)
        cost = Cost(seconds=perf_counter() - started, setup=started - begun)
        return trajectory, cost


class Impact:
    """The start, split into its parts along and across the normal n into the wall."""

    def __init__(self, scene: Scene) -> None:
        bodies = scene.bodies
        self.law = scene.all(Contact)[0]
        plane = scene.all(Plane)[0]
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
        size = float(np.linalg.norm(slip))
        if size > ROUNDED * np.linalg.norm(self.velocity):
            self.slip = size
        else:
            self.slip = 0.0
        if self.slip:
            self.along = slip / self.slip
        else:
            self.along = 0.0 * slip
        has_spring = self.law.friction > 0 and self.law.tangential_stiffness > 0
        self.springs = self.slip > 0 and has_spring

    def normal(self, t: Array) -> tuple[Array, Array]:
        """Overlap and rate (T, 2), and when it touches, turns and parts."""
        out = np.empty((len(t), 2))
        touch = np.empty(3)
        law = np.array([self.law.stiffness, self.law.exponent])
        call = KernelCall(
            function="refdem_power_contact",
            inputs=(self.mass, law, law, self.overlap, self.rate),
            clock=samples(t),
            outputs=(touch, out),
        )
        call.made("power_contact")
        return out, touch

    def stop(self, impulse: float, touch: Array) -> float:
        """When the normal impulse per mass has come to `impulse`, by bisection (the motion is
        smooth there).
        """
        low = touch[0]
        high = touch[2]
        for _ in range(60):
            middle = (low + high) / 2
            out, _ = self.normal(np.array([middle]))
            if self.rate - out[0, 1] > impulse:
                high = middle
            else:
                low = middle
        return float(low + high) / 2

    def rubbed(self, t: Array, out: Array, touch: Array) -> tuple[Array, Array]:
        """What the slip has lost (T,) [m/s] by sliding friction, and its way that is missing (T,)
        [m].
        """
        if self.slip > 0:
            friction = self.law.friction
        else:
            friction = 0.0
        # The impulse per mass that ends the slip: 7/2 mu J = slip.
        if friction:
            enough = self.slip * 2 / 7 / friction
        else:
            enough = np.inf
        if enough < 2 * self.rate:
            end = self.stop(enough, touch)
        else:
            end = np.inf
        # The integral of the impulse per mass over the time: while it slides, then while it rolls.
        until = np.minimum(t, end)
        then, _ = self.normal(until)
        way = self.rate * until - (then[:, 0] - self.overlap)
        rolled = np.zeros_like(t)
        if np.isfinite(end):
            rolled = enough * (t - until)
        impulse = np.minimum(self.rate - out[:, 1], enough)
        return 3.5 * friction * impulse, 3.5 * friction * (way + rolled)

    def bent(self, t: Array, out: Array, touch: Array) -> tuple[Array, Array]:
        """The same by a tangential spring, which begins unstretched at touch."""
        # Units of the series: the speed at touch, and the greatest overlap.
        speed = self.rate
        turned, _ = self.normal(touch[1:2])
        deep = float(turned[0, 0])
        spring = Spring(self.law.tangential_stiffness / self.law.stiffness, self.law.friction)
        found = course(spring, self.slip / speed)
        slip = np.full(len(t), self.slip)
        way = self.slip * t
        last, gone = found.end()
        after = t - touch[2]
        for n in np.flatnonzero((t > touch[0]) & (after < 0)):
            depth = max(out[n, 0], 0.0) / deep
            p, q = found.at(depth, out[n, 1] / speed)
            slip[n] = p * speed
            way[n] = self.slip * touch[0] + q * deep
        parted = after >= 0
        slip[parted] = last * speed
        way[parted] = self.slip * touch[0] + gone * deep + last * speed * after[parted]
        return self.slip - slip, self.slip * t - way

    def moved(self, t: Array, out: Array, lost: Array, missed: Array) -> dict[str, Any]:
        """Columns and channels of a trajectory, from what the slip has lost and its way misses."""
        pressed = out[:, 0] - self.overlap
        # Of what the slip loses the velocity takes 2/7, and the spin, times R, 5/7.
        flown = self.place + self.across * t[:, None]
        held_back = missed[:, None] * self.along * (2 / 7)
        position = flown + pressed[:, None] * self.n - held_back
        braked = lost[:, None] * self.along * (2 / 7)
        velocity = self.across + out[:, 1:] * self.n - braked
        turning = np.cross(self.n, self.along)
        omega = self.omega - lost[:, None] * turning * (5 / 7 / self.radius)
        work = self.mass / 7 * lost * (2 * self.slip - lost)
        depth = np.maximum(out[:, 0], 0.0)
        force = self.law.stiffness * depth**self.law.exponent
        channels = {
            "overlap": depth,
            "contacts": (depth > 0).astype(float),
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
