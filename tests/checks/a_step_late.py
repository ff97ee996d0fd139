"""A plain engine that sees an impact at the start of the step after it: right, and of first order.

It looks for overlaps when a step begins, as engines do that gather contacts first and then advance:

    where two bodies overlap and close at t_k, they exchange the impulse of the law;
    v += h g;  r += h v.

Bodies that meet within a step overlap at its end, and keep the velocities of before in that sample.
"""

import numpy as np

from refdem.core.engine import Engine, Method
from refdem.core.trajectory import Cost, Event, Trajectory
from refdem.scene.elements.contact import Contact
from refdem.scene.elements.plane import Plane
from refdem.scene.elements.uniform_gravity import UniformGravity

ROUNDING = 1e-12
"""Closing speed [m/s] that an impulse without restitution may leave."""
FEWEST_AHEAD = 8
MOST_AHEAD = 1024


class StepLate(Engine):
    """Rigid spheres without friction, planes and uniform gravity."""

    name = "step-late"
    title = "Overlaps looked for at the start of a step"
    methods = (
        Method(
            name="semi-implicit-euler",
            summary="impulses where bodies overlap, then velocities, then positions",
            control="step",
            order=1,
            conserves=frozenset({"momentum"}),
        ),
    )
    steps_late = 0
    """Steps that a wrong version lets pass between an overlap and its impulse."""
    reported_after = None
    """Steps between the time at which an overlap is seen and that at which the impact is told to
    have been; None tells nothing."""
    restitution_factor = 1.0
    """What a wrong version multiplies the restitution by."""

    def missing(self):
        return None

    def version(self):
        return "1"

    def fingerprint(self, method):
        return f"step-late-{self.steps_late}-{self.restitution_factor}"

    def unsupported_motion(self, problem, method):
        laws = problem.scene.all(Contact)
        if len(laws) != 1 or laws[0].law != "rigid" or laws[0].friction > 0:
            return "rigid spheres without friction alone"
        return None

    def run(self, request):
        times = request.problem.times
        scene = request.problem.scene
        stride = round(abs(times[1] - times[0]) / request.step)
        h = (times[1] - times[0]) / stride
        state = _State(scene, self.restitution_factor)
        last = stride * (len(times) - 1)
        rows = [(state.r.copy(), state.v.copy())]
        events = []
        waiting = 0
        done = 0
        # Steps that are tried at once as a flight without impacts.
        ahead = FEWEST_AHEAD
        while done < last:
            tried = min(ahead, last - done)
            r, v = state.flown(tried, h)
            free = state.steps_without_impact(r[:-1], v[:-1])
            if free:
                samples = range(done // stride + 1, (done + free) // stride + 1)
                rows += [(r[k * stride - done], v[k * stride - done]) for k in samples]
                state.r = r[free].copy()
                state.v = v[free].copy()
                done += free
                waiting = 0
                ahead = min(2 * ahead, MOST_AHEAD)
                continue
            ahead = FEWEST_AHEAD
            overlapping = state.overlaps()
            if not overlapping:
                waiting = 0
            elif waiting < self.steps_late:
                waiting += 1
            else:
                if self.reported_after is not None:
                    sample, step = divmod(done, stride)
                    told = float(times[sample] + (step + self.reported_after) * h)
                    events.append(Event(time=told, kind="contact", body=overlapping[0][0]))
                state.collide()
            state.v = state.v + h * state.g
            state.r = state.r + h * state.v
            done += 1
            if done % stride == 0:
                rows.append((state.r.copy(), state.v.copy()))
        position = np.array([r for r, _ in rows])
        velocity = np.array([v for _, v in rows])
        count, bodies = position.shape[:2]
        attitude = np.zeros((count, bodies, 4))
        attitude[..., 0] = 1.0
        omega = np.broadcast_to(scene.bodies.omega, position.shape).copy()
        run = Trajectory(
            t=times,
            position=position,
            velocity=velocity,
            attitude=attitude,
            omega=omega,
            events=tuple(events),
        )
        return run, Cost(seconds=0.0, steps=stride * (len(times) - 1))


class _State:
    """Places and velocities (N, 3), and the impacts that change them."""

    def __init__(self, scene, restitution_factor):
        bodies = scene.bodies
        self.r = bodies.position.copy()
        self.v = bodies.velocity.copy()
        self.mass = bodies.mass
        self.radius = bodies.radius
        self.restitution = scene.all(Contact)[0].restitution * restitution_factor
        self.planes = scene.all(Plane)
        self.g = sum((np.array(field.g) for field in scene.all(UniformGravity)), np.zeros(3))
        self.first, self.second = np.tril_indices(len(self.r), -1)
        # A little more than touching: whether two bodies do overlap is for `overlaps` to say.
        self.reach = (1 + ROUNDING) * (self.radius[self.first] + self.radius[self.second])

    def flown(self, steps, h):
        """Places and velocities (steps + 1, N, 3) from here on, step by step, if nothing meets."""
        gained = np.broadcast_to(h * self.g, (steps, *self.v.shape))
        v = np.cumsum(np.concatenate([self.v[None], gained]), axis=0)
        r = np.cumsum(np.concatenate([self.r[None], h * v[1:]]), axis=0)
        return r, v

    def steps_without_impact(self, r, v):
        """How many of the states (steps, N, 3) come before the first in which bodies may overlap
        and close.
        """
        apart = r[:, self.first] - r[:, self.second]
        towards = v[:, self.first] - v[:, self.second]
        distance = np.sqrt(np.sum(apart**2, axis=-1))
        # Pairs that close have a falling distance: d/dt (x.x)/2 = x.v < 0.
        meets = np.any(
            (distance < self.reach) & (np.sum(apart * towards, axis=-1) < 0),
            axis=1,
        )
        for plane in self.planes:
            away = np.array(plane.normal)
            gap = (r - np.array(plane.point)) @ away - self.radius
            slack = ROUNDING * self.radius
            meets |= np.any((gap < slack) & (v @ away < 0), axis=1)
        if not np.any(meets):
            return len(r)
        return int(np.argmax(meets))

    def overlaps(self):
        """Pairs (i, j, normal from i on, closing speed) that overlap and close; j is None for a
        plane.
        """
        found = []
        for i in range(len(self.r)):
            for plane in self.planes:
                away = np.array(plane.normal)
                gap = (self.r[i] - np.array(plane.point)) @ away - self.radius[i]
                closing = -(self.v[i] @ away)
                if gap < 0 and closing > 0:
                    found.append((i, None, -away, closing))
            for j in range(i):
                apart = self.r[j] - self.r[i]
                distance = np.linalg.norm(apart)
                normal = apart / distance
                closing = (self.v[i] - self.v[j]) @ normal
                if distance < self.radius[i] + self.radius[j] and closing > 0:
                    found.append((i, j, normal, closing))
        return found

    def collide(self):
        """One impulse after another, until no pair closes any more than by rounding."""
        while closing_pairs := [pair for pair in self.overlaps() if pair[3] > ROUNDING]:
            i, j, normal, closing = closing_pairs[0]
            inverse_mass = 1 / self.mass[i]
            if j is not None:
                inverse_mass += 1 / self.mass[j]
            impulse = (1 + self.restitution) * closing / inverse_mass
            self.v[i] -= impulse / self.mass[i] * normal
            if j is not None:
                self.v[j] += impulse / self.mass[j] * normal
