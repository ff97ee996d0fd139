"""Two spheres that meet along the line of their centres, in closed form (kernels/head_on.c); both
cut-offs, any damping.
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
"""Overlaps of so many times the distance, and sideways speeds of so many times the speed, are
rounding.
"""


class ExactHeadOn(KernelSolver):
    """Free flight, damped sine, free flight, about a centre of mass in uniform motion."""

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

    def unfit(self, problem: Motion) -> str | None:
        """None for spheres that meet along the line of their centres, and forward in time if the
        contact is damped.
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
        """The law, the start along the line of centres, and room for the times of touch and
        release and for the rows.
        """
        scene = request.problem.scene
        elapsed = Elapsed(request.problem)
        law = scene.all(Contact)[0]
        overlap, closing, _ = approach(scene)
        start = min(unrounded(scene, overlap), 0.0)
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
        """States at the samples; a run backwards is one with flipped velocities."""
        scene = request.problem.scene
        overlap, _, _ = approach(scene)
        start = min(unrounded(scene, overlap), 0.0)
        touch, rows = call.outputs
        # A row: overlap, its rate, contacts, force, dissipated work.
        pressed, rate, contacts, force, work = rows.T
        channels = {
            "overlap": np.maximum(pressed, 0.0),
            "contacts": contacts.copy(),
            "contact_force": force.copy(),
            "dissipated_work": work.copy(),
        }
        told = {"contact": touch[0], "release": touch[1]}
        return met(request.problem, pressed - start, rate, channels, told)


def approach(scene: Scene) -> tuple[float, float, float]:
    """Overlap [m], speed at which it grows [m/s] and sideways speed [m/s] at the start; no square
    of a small length underflows.
    """
    bodies = scene.bodies
    normal = along(scene)
    relative = bodies.velocity[0] - bodies.velocity[1]
    closing = float(relative @ normal)
    overlap = float(bodies.radius.sum()) - hypot(*(bodies.position[1] - bodies.position[0]))
    return overlap, closing, hypot(*(relative - closing * normal))


def unrounded(scene: Scene, overlap: float) -> float:
    """The overlap [m] at the start; 0 where it is what rounding leaves of a touch."""
    if abs(overlap) > ROUNDED * scene.bodies.radius.sum():
        return overlap
    return 0.0


def met(
    problem: Problem,
    pressed: Array,
    rate: Array,
    channels: dict[str, Array],
    told: dict[str, float],
) -> Trajectory:
    """The trajectory of two spheres whose overlap has grown by `pressed` (T,) [m] and whose
    overlap's rate is `rate` (T,) [m/s], time counted upwards; `told`: when its events are [s].
    """
    scene = problem.scene
    bodies = scene.bodies
    elapsed = Elapsed(problem)
    _, closing, _ = approach(scene)
    sped = elapsed.sense * rate - closing
    position, velocity = states(scene, elapsed.since * elapsed.sense, pressed, sped)
    return Trajectory(
        t=problem.times,
        position=position,
        velocity=velocity,
        attitude=np.repeat(bodies.attitude[None], len(problem.times), axis=0),
        omega=np.zeros_like(velocity),
        channels=channels,
        events=elapsed.events(told),
    )


def along(scene: Scene) -> Array:
    """Unit vector (3,) from the first centre to the second."""
    line: Array = scene.bodies.position[1] - scene.bodies.position[0]
    return line / hypot(*line)


def states(scene: Scene, t: Array, pressed: Array, sped: Array) -> tuple[Array, Array]:
    """Positions and velocities (T, 2, 3) where the overlap and its rate have grown by `pressed` [m]
    and `sped` [m/s].
    """
    bodies = scene.bodies
    total = bodies.mass.sum()
    centre = bodies.mass @ bodies.velocity / total
    # Of a change of the overlap, m2/(m1 + m2) moves the first and m1/(m1 + m2) the second.
    share = np.array([bodies.mass[1], -bodies.mass[0]])[:, None] / total * along(scene)
    position = bodies.position + centre * t[:, None, None] + pressed[:, None, None] * share
    return position, bodies.velocity + sped[:, None, None] * share


METHOD = ExactHeadOn()
