"""Points on rods from fixed pivots, joined by linear springs to each other or to the world, in a
plane, in angles (kernels/joined_rods.c).

With r_i = pivot_i + l_i (sin theta_i, -cos theta_i) and the tangent t_i = (cos theta_i, sin
theta_i)

    m_i l_i theta_i'' = (m_i g + sum of the pulls of springs on i) . t_i.
"""

import numpy as np
from numpy.typing import NDArray

from refdem.core.engine import Method
from refdem.core.problem import Motion, Request
from refdem.core.trajectory import Trajectory
from refdem.errors import EngineError
from refdem.scene import Scene
from refdem.scene.elements.rod import Rod
from refdem.scene.elements.spring import Spring
from refdem.scene.elements.uniform_gravity import UniformGravity
from refdem.solvers import _single_point as single
from refdem.solvers._kernel_solver import KernelCall, KernelSolver, samples
from refdem.solvers._rods import directions_and_rates, inconsistent, turned
from refdem.solvers._scene_pattern import ANY, Count, ScenePattern

Array = NDArray[np.float64]
MOST = 8
"""Largest number of rods, and of springs."""


class JoinedRods(KernelSolver):
    """Angles by Taylor series; positions, velocities and rod forces from the angles."""

    claims = Method(
        name="joined-rods",
        summary=(
            "points on rods from fixed pivots, joined by linear springs, in a plane, in angles:"
            " Taylor series of order 20, steps to round-off"
        ),
        control="exact",
        conserves=frozenset({"energy", "constraint"}),
        reversible=True,
        symplectic=True,
        backward=True,
        cost_rank=2,
    )
    kernels = ("joined_rods",)

    pattern = ScenePattern(
        elements={Rod: Count(1, MOST), Spring: Count(1, MOST), UniformGravity: ANY},
        in_plane=True,
        only_points=True,
    )

    def unsupported_values(self, problem: Motion) -> str | None:
        """None if every point starts on a rod of its own, and every spring is linear, else the
        reason.
        """
        scene = problem.scene
        rods = scene.all(Rod)
        if sorted(rod.a for rod in rods) != list(range(len(scene.bodies))):
            return "not every point hangs from a rod of its own"
        if any(rod.b >= 0 for rod in rods):
            return "a rod joins two points"
        if not all(single.is_linear(spring) for spring in scene.all(Spring)):
            return "a spring is not linear"
        arms, velocities = _at_start(scene)
        for arm, velocity, rod in zip(arms, velocities, rods, strict=True):
            if reason := inconsistent(arm, velocity, rod.length):
                return reason
        return None

    def prepare(self, request: Request) -> KernelCall:
        """Rods, springs and gravity; rows for the rotations [rad] since the start, their rates
        [rad/s], and a variable of the kernel for each spring.
        """
        scene = request.problem.scene
        t = request.problem.times
        rods = scene.all(Rod)
        springs = scene.all(Spring)
        directions, rates = directions_and_rates(*_at_start(scene))
        states = np.empty((len(t), 2 * len(rods) + len(springs)))
        states[0] = np.concatenate([np.zeros(len(rods)), rates, np.zeros(len(springs))])
        # The kernel has a point for each rod, in the order of the rods.
        place = {rod.a: index for index, rod in enumerate(rods)}
        ends = [(place[spring.a], place.get(spring.b, -1)) for spring in springs]
        of_rods = (
            np.array([rod.length for rod in rods]),
            scene.bodies.mass[[rod.a for rod in rods]],
            directions,
            np.array([rod.anchor_b[:2] for rod in rods]),
        )
        of_springs = (
            np.array(ends, np.int64),
            np.array([spring.anchor_b[:2] for spring in springs]),
            np.array([spring.stiffness for spring in springs]),
            np.array([spring.length for spring in springs]),
        )
        gravity = single.gravity(scene)[:2]
        return KernelCall(
            function="refdem_joined_rods",
            inputs=(len(rods), *of_rods, len(springs), *of_springs, gravity),
            clock=samples(t),
            outputs=(states,),
        )

    def finish(self, request: Request, call: KernelCall, status: int) -> Trajectory:
        """Position, velocity and force [N] of every rod at the samples; raises EngineError if the
        series do not reach them.
        """
        (states,) = call.outputs
        if status or not np.all(np.isfinite(states)):
            raise EngineError(
                f"joined-rods: the series do not reach sample {status - 1}; expected a regular"
                f" motion of at most {MOST} rods and as many springs, none of which shrinks to"
                " nothing"
            )
        scene = request.problem.scene
        t = request.problem.times
        rods = scene.all(Rod)
        bobs = [rod.a for rod in rods]
        lengths = np.array([rod.length for rod in rods])
        directions, _ = directions_and_rates(*_at_start(scene))
        arms, relative = turned(lengths[:, None] * directions, states[:, : 2 * len(rods)])
        position = np.empty((len(t), len(bobs), 3))
        velocity = np.empty((len(t), len(bobs), 3))
        position[:, bobs] = np.array([single.anchor(rod) for rod in rods]) + arms
        velocity[:, bobs] = relative
        position[0] = scene.bodies.position
        velocity[0] = scene.bodies.velocity
        channels = {"rod_force": _tension(scene, position, velocity)}
        return Trajectory.of_points(t, position, velocity, channels=channels)


def _at_start(scene: Scene) -> tuple[Array, Array]:
    """Vectors (N, 3) [m] of the rods from pivot to point at the start, and the velocities (N, 3) of
    the points, in the order of the rods.
    """
    rods = scene.all(Rod)
    bobs = [rod.a for rod in rods]
    pivots = np.array([single.anchor(rod) for rod in rods])
    return scene.bodies.position[bobs] - pivots, scene.bodies.velocity[bobs]


def _tension(scene: Scene, position: Array, velocity: Array) -> Array:
    """Tension (T, rods) [N]: T = m |v|^2/l + (m g + F).e, with e from the pivot to the point and F
    the pull of its springs.
    """
    force = np.broadcast_to(scene.bodies.mass[:, None] * single.gravity(scene), position.shape)
    force = force.copy()
    for spring in scene.all(Spring):
        if spring.b >= 0:
            other = position[:, spring.b]
        else:
            other = single.anchor(spring)
        branch = other - position[:, spring.a]
        distance = np.linalg.norm(branch, axis=1, keepdims=True)
        # The pull k (1 - s/|d|) d, with the natural length s; k d for s = 0, also where |d| = 0.
        strength = np.full_like(distance, spring.stiffness)
        if spring.length:
            strength -= spring.stiffness * spring.length / distance
        force[:, spring.a] += strength * branch
        if spring.b >= 0:
            force[:, spring.b] -= strength * branch
    tension = np.empty((len(position), len(scene.all(Rod))))
    for index, rod in enumerate(scene.all(Rod)):
        # T = m |v|^2/l + (m g + F) . e.
        direction = (position[:, rod.a] - single.anchor(rod)) / rod.length
        centripetal = np.sum(velocity[:, rod.a] ** 2, axis=1) / rod.length
        along = np.sum(force[:, rod.a] * direction, axis=1)
        tension[:, index] = scene.bodies.mass[rod.a] * centripetal + along
    return tension


METHOD = JoinedRods()
