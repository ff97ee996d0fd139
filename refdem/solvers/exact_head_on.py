"""Two spheres in head-on collision under the linear law, in closed form (kernels/head_on.c).

The overlap d obeys m_eff d'' = -k d - c d' from contact to release, by either cut-off and for any
damping. The centre of mass moves uniformly.
"""

from math import hypot

import numpy as np
from numpy.typing import NDArray

from refdem.core.engine import Method
from refdem.core.problem import Motion, Problem, Request
from refdem.core.trajectory import Trajectory
from refdem.scene import Scene, Sphere
from refdem.scene.elements.contact import Contact
from refdem.solvers._kernel_solver import Elapsed, KernelCall, KernelSolver, samples
from refdem.solvers._scene_pattern import ONE, TWO, ScenePattern

Array = NDArray[np.float64]

ROUNDED = 4 * 2.0**-52
"""Relative rounding of overlaps, in units of the sum of radii, and of transverse speeds, in units
of the closing speed.
"""


class ExactHeadOn(KernelSolver):
    """Free flight, a damped sine, free flight; the centre of mass moves uniformly."""

    claims = Method(
        name="exact-head-on",
        summary="the damped sine between touch and release, in closed form",
        control="exact",
        conserves=frozenset({"momentum", "angular-momentum"}),
        reversible=True,
        symplectic=True,
        backward=True,
        cost_rank=5,
    )
    kernels = ("head_on",)

    pattern = ScenePattern(
        elements={Contact: ONE}, bodies=TWO, shape=Sphere, law="linear", may_spin=False
    )

    def unsupported_values(self, problem: Motion) -> str | None:
        """None for spheres that meet along the line of their centres, and forward in time if the
        contact is damped, else the reason.
        """
        scene = problem.scene
        if problem.interval < 0 and scene.all(Contact)[0].damping > 0:
            return "time runs backwards through a dashpot"
        overlap, closing, sideways = approach(scene)
        if overlap > ROUNDED * float(scene.bodies.radius.sum()):
            return "the spheres overlap at the start"
        if sideways > ROUNDED * abs(closing):
            return "the spheres do not meet along the line of their centres"
        return None

    def prepare(self, request: Request) -> KernelCall:
        """The law and the start along the line of centres; arrays for the times of contact and
        release and for the rows.
        """
        scene = request.problem.scene
        elapsed = Elapsed(request.problem)
        law = scene.all(Contact)[0]
        overlap, closing, _ = approach(scene)
        start = min(unrounded(scene, overlap), 0.0)
        # The kernel starts before or at contact, so that the overlap is at most 0.
        no_pull = law.cutoff == "zero_force"
        return KernelCall(
            function="refdem_head_on",
            inputs=(
                *scene.bodies.mass.tolist(),
                law.stiffness,
                law.damping,
                no_pull,
                start,
                elapsed.sense * closing,
            ),
            clock=samples(elapsed.since),
            outputs=(np.empty(2), np.empty((len(elapsed.since), 5))),
        )

    def finish(self, request: Request, call: KernelCall, status: int) -> Trajectory:
        """States at the samples; a run backward in time is one with velocities reversed."""
        scene = request.problem.scene
        overlap, _, _ = approach(scene)
        start = min(unrounded(scene, overlap), 0.0)
        times, rows = call.outputs
        # A row: overlap, its rate, contacts, force, dissipated work.
        overlaps, rate, contacts, force, work = rows.T
        channels = {
            "overlap": np.maximum(overlaps, 0.0),
            "contacts": contacts.copy(),
            "contact_force": force.copy(),
            "dissipated_work": work.copy(),
        }
        events = {"contact": times[0], "release": times[1]}
        return met(request.problem, overlaps - start, rate, channels, events)


def approach(scene: Scene) -> tuple[float, float, float]:
    """Overlap [m], closing speed [m/s] and transverse speed [m/s] at the start.

    Lengths by hypot: the square of a very small length would underflow.
    """
    bodies = scene.bodies
    normal = along(scene)
    relative = bodies.velocity[0] - bodies.velocity[1]
    closing = float(relative @ normal)
    overlap = float(bodies.radius.sum()) - hypot(*(bodies.position[1] - bodies.position[0]))
    return overlap, closing, hypot(*(relative - closing * normal))


def unrounded(scene: Scene, overlap: float) -> float:
    """The initial overlap [m]; 0 where it is only the rounding of a contact."""
    if abs(overlap) > ROUNDED * scene.bodies.radius.sum():
        return overlap
    return 0.0


def met(
    problem: Problem,
    overlap_growth: Array,
    rate: Array,
    channels: dict[str, Array],
    event_times: dict[str, float],
) -> Trajectory:
    """The trajectory of two spheres from their relative motion.

    `overlap_growth` (T,) [m] is the growth of the overlap since the start, `rate` (T,) [m/s] the
    overlap's rate in elapsed time, `event_times` the elapsed times [s] of events by kind.
    """
    scene = problem.scene
    bodies = scene.bodies
    elapsed = Elapsed(problem)
    _, closing, _ = approach(scene)
    rate_change = elapsed.sense * rate - closing
    position, velocity = states(scene, elapsed.since * elapsed.sense, overlap_growth, rate_change)
    return Trajectory(
        t=problem.times,
        position=position,
        velocity=velocity,
        attitude=np.repeat(bodies.attitude[None], len(problem.times), axis=0),
        omega=np.zeros_like(velocity),
        channels=channels,
        events=elapsed.events(event_times),
    )


def along(scene: Scene) -> Array:
    """Unit vector (3,) from the first centre to the second."""
    line: Array = scene.bodies.position[1] - scene.bodies.position[0]
    return line / hypot(*line)


def states(
    scene: Scene, t: Array, overlap_growth: Array, rate_growth: Array
) -> tuple[Array, Array]:
    """Positions and velocities (T, 2, 3) after the overlap has grown by `overlap_growth` [m] and
    its rate by `rate_growth` [m/s].
    """
    bodies = scene.bodies
    total_mass = bodies.mass.sum()
    centre_velocity = bodies.mass @ bodies.velocity / total_mass
    # The contact does not accelerate the centre of mass. Of a change D of the overlap the first
    # sphere moves by m2/(m1 + m2) D along the normal, and the second by -m1/(m1 + m2) D.
    share = np.array([bodies.mass[1], -bodies.mass[0]])[:, None] / total_mass * along(scene)
    position = (
        bodies.position + centre_velocity * t[:, None, None] + overlap_growth[:, None, None] * share
    )
    return position, bodies.velocity + rate_growth[:, None, None] * share


METHOD = ExactHeadOn()
