"""A wedge that meets a wall, turns and leaves, in closed form (kernels/power_contact.c)."""

from time import perf_counter

import numpy as np

from refdem.core.engine import Method
from refdem.core.problem import Motion, Request
from refdem.core.trajectory import Cost, Event, Trajectory
from refdem.kernels import load, pointer
from refdem.mechanics.quaternion import product
from refdem.scene import Scene
from refdem.scene.elements.wedge import Wedge
from refdem.solvers.solver import Solver

TURN = np.array([0.0, 0.0, 0.0, 1.0])
"""By pi about the body's z axis."""


class ExactWedge(Solver):
    """Free flight, in with one law, out with the other, free flight; the orientation chooses."""

    claims = Method(
        name="exact-wedge",
        summary="one power law in and another out, in closed form; the law is the orientation's",
        control="exact",
        conserves=frozenset({"energy"}),
        reversible=True,
        backward=True,
        cost_rank=0,
    )
    kernels = ("power_contact",)

    def unsupported(self, problem: Motion) -> str | None:
        """None for one free body that moves along the normal and does not turn by itself, and
        nothing but one wall for wedges.
        """
        scene = problem.scene
        bodies = problem.scene.bodies
        if len(scene.elements) != 1 or not isinstance(scene.elements[0], Wedge):
            return "something else than one wall for wedges"
        if len(bodies) != 1 or bodies.fixed.any() or np.any(bodies.omega):
            return "not one free body that does not turn"
        across = np.cross(bodies.velocity[0], scene.elements[0].normal)
        if np.linalg.norm(across) > 1e-15 * np.linalg.norm(bodies.velocity[0]):
            return "it moves along the wall"
        return None

    def run(self, request: Request) -> tuple[Trajectory, Cost]:
        """States at the samples; a run backwards is one with flipped velocities."""
        begun = perf_counter()
        scene = request.problem.scene
        t = request.problem.times
        wall = scene.all(Wedge)[0]
        bodies = scene.bodies
        sense = float(np.sign(request.problem.interval))
        start = float(wall.overlap(bodies.position[0]))
        rate = -sense * float(bodies.velocity[0] @ np.array(wall.normal))
        # A law: factor and exponent of the overlap.
        of_edge = np.array([wall.quadratic, 2.0])
        of_side = np.array([wall.stiffness, 1.0])
        is_edge_first = _comes_edge_first(scene, wall, start, rate)
        if is_edge_first:
            inward = of_edge
        else:
            inward = of_side
        if is_edge_first:
            outward = of_side
        else:
            outward = of_edge
        since = sense * (t - t[0])
        out = np.empty((len(t), 2))
        touch = np.empty(3)
        kernel = load("power_contact").lib
        mass = float(bodies.mass[0])
        laws = [pointer("power_contact", law) for law in (inward, outward)]
        samples = pointer("power_contact", since)
        buffers = [pointer("power_contact", array, output=True) for array in (touch, out)]
        started = perf_counter()
        kernel.refdem_power_contact(mass, *laws, start, rate, len(t), samples, *buffers)
        cost = Cost(seconds=perf_counter() - started, setup=started - begun)
        normal = np.array(wall.normal)
        turned = (since > touch[1]) & (touch[1] > 0)
        attitude = np.where(turned[:, None, None], product(bodies.attitude, TURN), bodies.attitude)
        position = bodies.position - (out[:, :1, None] - start) * normal
        velocity = bodies.velocity - sense * (out[:, 1:, None] - rate) * normal
        pressed = np.maximum(out[:, 0], 0.0)
        deepest = _deepest(mass, inward, outward, start, rate)
        gained = _stored(outward, deepest) - _stored(inward, deepest)
        channels = {
            "overlap": pressed,
            "contacts": (pressed > 0).astype(float),
            "dissipated_work": np.where(turned, -gained, 0.0),
        }
        events = []
        for when, kind in zip(touch, ("contact", "turn", "release"), strict=True):
            if 0 < when <= since[-1]:
                events.append(Event(time=float(t[0] + sense * when), kind=kind, body=0))
        found = Trajectory(
            t=t,
            position=position,
            velocity=velocity,
            attitude=attitude,
            omega=np.zeros_like(velocity),
            channels=channels,
            events=tuple(events),
        )
        return found, cost


def _stored(law: np.ndarray, overlap: float) -> float:
    """Energy [J] stored in an overlap [m] under the force `factor d^exponent`:
    factor d^(exponent + 1)/(exponent + 1).
    """
    factor, exponent = law
    energy: float = factor / (exponent + 1) * overlap ** (exponent + 1)
    return energy


def _comes_edge_first(scene: Scene, wall: Wedge, overlap: float, rate: float) -> bool:
    """Whether the way in is, or was, edge first: it turns in between."""
    edge = bool(wall.edge_first(scene.bodies.attitude[0]))
    if overlap > 0 and rate < 0:
        return not edge
    return edge


def _deepest(
    mass: float, inward: np.ndarray, outward: np.ndarray, overlap: float, rate: float
) -> float:
    """Greatest overlap [m] of the contact; 0 if there is none."""
    if overlap <= 0 and rate <= 0:
        return 0.0
    factor, exponent = outward if overlap > 0 and rate < 0 else inward
    power = exponent + 1
    # factor d^power/power = m v^2/2 + factor d0^power/power at the turning point.
    moving = 0.5 * mass * rate**2 * power / factor
    pressed = max(overlap, 0.0) ** power
    return float((moving + pressed) ** (1 / power))


METHOD = ExactWedge()
