"""A wedge that meets a wall, turns and leaves, in closed form (kernels/power_contact.c)."""

from dataclasses import dataclass

import numpy as np

from refdem.core.engine import Method
from refdem.core.problem import Motion, Problem, Request
from refdem.core.trajectory import Trajectory
from refdem.mechanics.quaternion import product
from refdem.scene import Scene
from refdem.scene.elements.wedge import Wedge
from refdem.solvers._kernel_solver import Elapsed, KernelCall, KernelSolver, samples
from refdem.solvers._scene_pattern import ONE, ScenePattern

TURN = np.array([0.0, 0.0, 0.0, 1.0])
"""By pi about the body's z axis."""


class ExactWedge(KernelSolver):
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

    pattern = ScenePattern(elements={Wedge: ONE}, bodies=ONE, may_spin=False)

    def unfit(self, problem: Motion) -> str | None:
        """None for a velocity along the normal of the wall."""
        scene = problem.scene
        velocity = scene.bodies.velocity[0]
        across = np.cross(velocity, scene.all(Wedge)[0].normal)
        if np.linalg.norm(across) > 1e-15 * np.linalg.norm(velocity):
            return "it moves along the wall"
        return None

    def prepare(self, request: Request) -> KernelCall:
        """Both laws, the start along the normal, and room for the times of touch, turn and parting
        and for overlaps and rates.
        """
        elapsed = Elapsed(request.problem)
        meeting = _meeting(request.problem, elapsed.sense)
        return KernelCall(
            function="refdem_power_contact",
            inputs=(meeting.mass, meeting.inward, meeting.outward, meeting.overlap, meeting.rate),
            clock=samples(elapsed.since),
            outputs=(np.empty(3), np.empty((len(elapsed.since), 2))),
        )

    def finish(self, request: Request, call: KernelCall, status: int) -> Trajectory:
        """States at the samples; a run backwards is one with flipped velocities."""
        elapsed = Elapsed(request.problem)
        sense = elapsed.sense
        meeting = _meeting(request.problem, sense)
        scene = request.problem.scene
        bodies = scene.bodies
        touch, rows = call.outputs
        normal = np.array(scene.all(Wedge)[0].normal)
        turned = (elapsed.since > touch[1]) & (touch[1] > 0)
        half_turned = product(bodies.attitude, TURN)
        position = bodies.position - (rows[:, :1, None] - meeting.overlap) * normal
        velocity = bodies.velocity - sense * (rows[:, 1:, None] - meeting.rate) * normal
        pressed = np.maximum(rows[:, 0], 0.0)
        channels = {
            "overlap": pressed,
            "contacts": (pressed > 0).astype(float),
            "dissipated_work": np.where(turned, -meeting.gained, 0.0),
        }
        kinds = ("contact", "turn", "release")
        return Trajectory(
            t=request.problem.times,
            position=position,
            velocity=velocity,
            attitude=np.where(turned[:, None, None], half_turned, bodies.attitude),
            omega=np.zeros_like(velocity),
            channels=channels,
            events=elapsed.events(dict(zip(kinds, touch, strict=True))),
        )


@dataclass(frozen=True)
class _Meeting:
    """A wedge of some `mass` [kg] and its wall: laws on the way in and out, each a factor and an
    exponent of the overlap; overlap [m] and its rate [m/s] at the start.
    """

    mass: float
    inward: np.ndarray
    outward: np.ndarray
    overlap: float
    rate: float

    @property
    def gained(self) -> float:
        """Energy [J] that the turn at the greatest overlap adds."""
        deepest = _deepest(self.mass, self.inward, self.outward, self.overlap, self.rate)
        return _stored(self.outward, deepest) - _stored(self.inward, deepest)


def _meeting(problem: Problem, sense: float) -> _Meeting:
    """Wedge and wall at the start.

    `sense` is -1 for a run backwards, which is a run forwards with the velocities reversed. The
    force is k2 d^2 of an edge, k1 d of a side.
    """
    scene = problem.scene
    bodies = scene.bodies
    wall = scene.all(Wedge)[0]
    mass = float(bodies.mass[0])
    overlap = float(wall.overlap(bodies.position[0]))
    rate = -sense * float(bodies.velocity[0] @ np.array(wall.normal))
    of_edge = np.array([wall.quadratic, 2.0])
    of_side = np.array([wall.stiffness, 1.0])
    if _comes_edge_first(scene, wall, overlap, rate):
        return _Meeting(mass, of_edge, of_side, overlap, rate)
    return _Meeting(mass, of_side, of_edge, overlap, rate)


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
    is_leaving = overlap > 0 and rate < 0
    if is_leaving:
        factor, exponent = outward
    else:
        factor, exponent = inward
    power = exponent + 1
    # factor d^power/power = m v^2/2 + factor d0^power/power at the turning point.
    moving = 0.5 * mass * rate**2 * power / factor
    pressed = max(overlap, 0.0) ** power
    return float((moving + pressed) ** (1 / power))


METHOD = ExactWedge()
