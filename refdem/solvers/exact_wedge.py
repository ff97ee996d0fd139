"""A wedge that hits a wall, rotates by pi and leaves, in closed form (kernels/power_contact.c).

The force is k2 d^2 while the edge points at the wall, and k1 d while the side does. The wedge
rotates by pi at the greatest overlap, so that one law acts on approach and the other on separation.
"""

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
"""The rotation by pi about the body's z axis."""


class ExactWedge(KernelSolver):
    """Free flight, approach under one law, separation under the other, free flight. The orientation
    of the wedge selects the law.
    """

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

    def unsupported_values(self, problem: Motion) -> str | None:
        """None for a velocity along the wall's normal, else the reason."""
        scene = problem.scene
        velocity = scene.bodies.velocity[0]
        across = np.cross(velocity, scene.all(Wedge)[0].normal)
        if np.linalg.norm(across) > 1e-15 * np.linalg.norm(velocity):
            return "it moves along the wall"
        return None

    def prepare(self, request: Request) -> KernelCall:
        """Both laws and the start along the normal; arrays for the times of contact, turn and
        release, and for overlaps and rates.
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
        """States at the samples; a run backward in time is one with velocities reversed."""
        elapsed = Elapsed(request.problem)
        sense = elapsed.sense
        meeting = _meeting(request.problem, sense)
        scene = request.problem.scene
        bodies = scene.bodies
        times, rows = call.outputs
        normal = np.array(scene.all(Wedge)[0].normal)
        # The wedge turns at the greatest overlap, times[1]; a time <= 0 is before the start.
        has_turned = (elapsed.since > times[1]) & (times[1] > 0)
        turned_attitude = product(bodies.attitude, TURN)
        # The overlap grows against the wall's normal.
        position = bodies.position - (rows[:, :1, None] - meeting.overlap) * normal
        velocity = bodies.velocity - sense * (rows[:, 1:, None] - meeting.rate) * normal
        overlap = np.maximum(rows[:, 0], 0.0)
        channels = {
            "overlap": overlap,
            "contacts": (overlap > 0).astype(float),
            "dissipated_work": np.where(has_turned, -meeting.gained, 0.0),
        }
        kinds = ("contact", "turn", "release")
        return Trajectory(
            t=request.problem.times,
            position=position,
            velocity=velocity,
            attitude=np.where(has_turned[:, None, None], turned_attitude, bodies.attitude),
            omega=np.zeros_like(velocity),
            channels=channels,
            events=elapsed.events(dict(zip(kinds, times, strict=True))),
        )


@dataclass(frozen=True)
class _Meeting:
    """A wedge and its wall along the normal at the start.

    `mass` [kg]; `inward` and `outward`: the contact laws on the way in and out, each (factor,
    exponent) of the overlap; `overlap` [m] and its `rate` [m/s].
    """

    mass: float
    inward: np.ndarray
    outward: np.ndarray
    overlap: float
    rate: float

    @property
    def gained(self) -> float:
        """Energy [J] that the rotation at the greatest overlap adds: that stored under the outward
        law minus that under the inward law.
        """
        deepest = _deepest(self.mass, self.inward, self.outward, self.overlap, self.rate)
        return _stored(self.outward, deepest) - _stored(self.inward, deepest)


def _meeting(problem: Problem, sense: float) -> _Meeting:
    """Wedge and wall at the start; `sense` -1 for a run backward in time, which runs forward with
    velocities reversed.
    """
    scene = problem.scene
    bodies = scene.bodies
    wall = scene.all(Wedge)[0]
    mass = float(bodies.mass[0])
    overlap = float(wall.overlap(bodies.position[0]))
    rate = -sense * float(bodies.velocity[0] @ np.array(wall.normal))
    of_edge = np.array([wall.quadratic, 2.0])
    of_side = np.array([wall.stiffness, 1.0])
    if _approaches_edge_first(scene, wall, overlap, rate):
        return _Meeting(mass, of_edge, of_side, overlap, rate)
    return _Meeting(mass, of_side, of_edge, overlap, rate)


def _stored(law: np.ndarray, overlap: float) -> float:
    """Energy [J] stored in an overlap [m] under the force `factor d^exponent`:
    factor d^(exponent + 1)/(exponent + 1).
    """
    factor, exponent = law
    energy: float = factor / (exponent + 1) * overlap ** (exponent + 1)
    return energy


def _approaches_edge_first(scene: Scene, wall: Wedge, overlap: float, rate: float) -> bool:
    """True if the edge points at the wall during the approach. During the separation, after the
    rotation, it points away from it.
    """
    edge_now = bool(wall.edge_first(scene.bodies.attitude[0]))
    if overlap > 0 and rate < 0:
        return not edge_now
    return edge_now


def _deepest(
    mass: float, inward: np.ndarray, outward: np.ndarray, overlap: float, rate: float
) -> float:
    """Greatest overlap [m] of the contact; 0 if there is none.

    From the energy: factor D^p/p = m v^2/2 + factor d^p/p with p = exponent + 1.
    """
    if overlap <= 0 and rate <= 0:
        return 0.0
    is_leaving = overlap > 0 and rate < 0
    if is_leaving:
        factor, exponent = outward
    else:
        factor, exponent = inward
    power = exponent + 1
    # factor d^power/power = m v^2/2 + factor d0^power/power at the turning point.
    kinetic_term = 0.5 * mass * rate**2 * power / factor
    overlap_term = max(overlap, 0.0) ** power
    return float((kinetic_term + overlap_term) ** (1 / power))


METHOD = ExactWedge()
