"""A chain of points on rods, one below the other, in a plane, from a fixed pivot or one that moves
as a function of time (kernels/rod_chain.c).

Angles theta_i are measured from (0, -1), so that rod i is l_i (sin theta_i, -cos theta_i). With the
loads mu_i = m_i + ... + m_N and G = g - pivot'' (Landau and Lifshitz, Mechanics, section 5)

    sum_j A_ij theta_j'' = mu_i l_i G . (cos theta_i, sin theta_i) - sum_j B_ij theta_j'^2,
    A_ij, B_ij = mu_max(i,j) l_i l_j times the cosine and the sine of theta_i - theta_j.

The kernel integrates the rotations since the start, theta_i - theta_i(0), by Taylor series.
"""

from typing import Any, NamedTuple

import numpy as np

from refdem.core.engine import Method
from refdem.core.problem import Motion, Request
from refdem.core.trajectory import Trajectory
from refdem.errors import EngineError
from refdem.scene import Scene
from refdem.scene.elements.moving_anchor import MovingAnchor
from refdem.scene.elements.rod import Rod
from refdem.scene.elements.uniform_gravity import UniformGravity
from refdem.solvers import _single_point as single
from refdem.solvers._kernel_solver import KernelCall, KernelSolver, samples
from refdem.solvers._rods import FITS, directions_and_rates, inconsistent, turned
from refdem.solvers._scene_pattern import ANY, OPTIONAL, Count, ScenePattern
from refdem.solvers._single_point import Array

MOST = 8
"""Largest number of rods."""


class RodChain(KernelSolver):
    """Angles by Taylor series; positions, velocities and rod forces from the angles."""

    claims = Method(
        name="rod-chain",
        summary=(
            "planar chain of rods in angles, pivot at rest or moved: Taylor series of order 20,"
            " steps to round-off"
        ),
        control="exact",
        conserves=frozenset({"energy", "constraint"}),
        reversible=True,
        symplectic=True,
        backward=True,
        cost_rank=2,
    )
    kernels = ("rod_chain",)

    pattern = ScenePattern(
        elements={Rod: Count(1, MOST), MovingAnchor: OPTIONAL, UniformGravity: ANY},
        in_plane=True,
        only_points=True,
    )

    def unsupported_values(self, problem: Motion) -> str | None:
        """None for a chain from one pivot whose start fits its rods, else the reason."""
        return _not_a_chain(problem.scene) or _misfit(problem)

    def prepare(self, request: Request) -> KernelCall:
        """Rods, initial directions, masses and drive; rows for rotations [rad] since the start,
        their rates [rad/s] and the work of the pivot.
        """
        scene = request.problem.scene
        t = request.problem.times
        chain = _chain(scene)
        directions, rate = _initial_directions(scene, chain, _pivot(scene, t))
        n_rods = len(chain.bobs)
        states = np.empty((len(t), 2 * n_rods + 1))
        states[0] = np.concatenate([np.zeros(n_rods), rate, [0.0]])
        mass = scene.bodies.mass[chain.bobs]
        gravity = single.gravity(scene)[:2]
        return KernelCall(
            function="refdem_rod_chain",
            inputs=(n_rods, _lengths(chain), directions, mass, gravity, *_drive(scene)),
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
                f"rod-chain: the series do not reach sample {status - 1}; expected a regular motion"
                f" of at most {MOST} rods"
            )
        scene = request.problem.scene
        t = request.problem.times
        chain = _chain(scene)
        pivot = _pivot(scene, t)
        directions, _ = _initial_directions(scene, chain, pivot)
        arms = _lengths(chain)[:, None] * directions
        position, velocity = _positions_and_velocities(scene, chain, pivot, arms, states[:, :-1])
        channels = {"rod_force": _tension(scene, pivot, position, velocity)}
        if chain.pivot >= 0:
            channels["dissipated_work"] = _energy_lost(scene, chain.pivot, pivot, states[:, -1])
        return Trajectory.of_points(t, position, velocity, channels=channels)


class Chain(NamedTuple):
    """Indices of the bobs from the pivot downwards, the rod above each, and the body that is the
    pivot (-1: a point of the world).
    """

    bobs: list[int]
    rods: list[Rod]
    pivot: int


class Pivot(NamedTuple):
    """Position, velocity and acceleration of the pivot, each (T, 3)."""

    place: Array
    velocity: Array
    acceleration: Array


def _chain(scene: Scene) -> Chain:
    """The chain of rods from the pivot; bobs that no rod connects to it are left out."""
    anchors = scene.all(MovingAnchor)
    if anchors:
        end = anchors[0].a
    else:
        end = -1
    chain = Chain([], [], end)
    remaining = list(scene.all(Rod))
    while attached := [rod for rod in remaining if end in (rod.a, rod.b)]:
        rod = attached[0]
        remaining.remove(rod)
        if rod.b == end:
            end = rod.a
        else:
            end = rod.b
        chain.bobs.append(end)
        chain.rods.append(rod)
    return chain


def _lengths(chain: Chain) -> Array:
    """Lengths (N,) [m] of the rods from the pivot downwards."""
    return np.array([rod.length for rod in chain.rods])


def _not_a_chain(scene: Scene) -> str | None:
    """None if the rods are one chain from one pivot that holds every body, else the reason."""
    anchors = scene.all(MovingAnchor)
    rods = scene.all(Rod)
    if anchors and any(rod.b < 0 for rod in rods):
        return "a rod hangs beside the moved pivot"
    chain = _chain(scene)
    chain_bodies = {*chain.bobs, *(anchor.a for anchor in anchors)}
    if (
        len(chain.bobs) < len(rods)
        or len(set(chain.bobs)) < len(rods)
        or chain_bodies != set(range(len(scene.bodies)))
    ):
        return "the rods do not hang one below the other from one pivot"
    return None


def _misfit(problem: Motion) -> str | None:
    """None if the start fits rods and pivot in position and velocity, else the reason."""
    scene = problem.scene
    bodies = problem.scene.bodies
    chain = _chain(scene)
    pivot = _pivot(scene, problem.times[:1])
    for anchor in scene.all(MovingAnchor):
        chain_length = sum(rod.length for rod in chain.rods)
        distance = np.linalg.norm(bodies.position[anchor.a] - pivot.place[0]) / chain_length
        speed_error = np.linalg.norm(bodies.velocity[anchor.a] - pivot.velocity[0])
        if distance > FITS or speed_error > FITS * abs(anchor.amplitude * anchor.frequency):
            return "the pivot does not start where its law of time has it"
    for arm, relative_velocity, rod in zip(
        *_initial_branches(scene, chain, pivot), chain.rods, strict=True
    ):
        if reason := inconsistent(arm, relative_velocity, rod.length):
            return reason
    return None


def _drive(scene: Scene) -> tuple[Array, float, float]:
    """The pivot's motion in x and y: amplitude (2,) [m], frequency [rad/s], phase."""
    for anchor in scene.all(MovingAnchor):
        return anchor.amplitude * np.array(anchor.axis[:2]), anchor.frequency, anchor.phase
    return np.zeros(2), 0.0, 0.0


def _pivot(scene: Scene, t: Array) -> Pivot:
    """The pivot's motion at times t (T,); at rest where the first rod hangs from the world."""
    for anchor in scene.all(MovingAnchor):
        position = anchor.place(t)
        # a = -w^2 (r - middle).
        acceleration = -(anchor.frequency**2) * (position - np.array(anchor.anchor_b))
        return Pivot(position, anchor.velocity(t), acceleration)
    first_rod = next(rod for rod in scene.all(Rod) if rod.b < 0)
    zero = np.zeros((len(t), 3))
    return Pivot(zero + single.anchor(first_rod), zero, zero)


def _initial_branches(scene: Scene, chain: Chain, pivot: Pivot) -> tuple[Array, Array]:
    """Initial vectors (N, 3) [m] from each bob's support to the bob, and relative velocities (N,
    3).
    """
    position = np.concatenate([pivot.place[:1], scene.bodies.position[chain.bobs]])
    velocity = np.concatenate([pivot.velocity[:1], scene.bodies.velocity[chain.bobs]])
    return np.diff(position, axis=0), np.diff(velocity, axis=0)


def _initial_directions(scene: Scene, chain: Chain, pivot: Pivot) -> tuple[Array, Array]:
    """Sine and cosine of the initial angles (N, 2), and the angular velocities (N,)."""
    return directions_and_rates(*_initial_branches(scene, chain, pivot))


def _positions_and_velocities(
    scene: Scene, chain: Chain, pivot: Pivot, rods_at_start: Array, states: Array
) -> tuple[Array, Array]:
    """Position and velocity (T, bodies, 3) of all bodies; row 0 is the given start.

    `rods_at_start` (N, 2) are the rods at the start, l (sin theta0, cos theta0); `states` (T, 2 N)
    are the turns and their rates.
    """
    rod_vectors, relative_velocity = turned(rods_at_start, states)
    shape = (len(states), len(scene.bodies), 3)
    position = np.empty(shape)
    velocity = np.empty(shape)
    if chain.pivot >= 0:
        position[:, chain.pivot] = pivot.place
        velocity[:, chain.pivot] = pivot.velocity
    position[:, chain.bobs] = pivot.place[:, None] + np.cumsum(rod_vectors, axis=1)
    velocity[:, chain.bobs] = pivot.velocity[:, None] + np.cumsum(relative_velocity, axis=1)
    position[0] = scene.bodies.position
    velocity[0] = scene.bodies.velocity
    return position, velocity


def _tension(scene: Scene, pivot: Pivot, position: Array, velocity: Array) -> Array:
    """Tension (T, rods) [N] of the rods in the scene's order.

    A rod of length l with the unit vector e from end 2 to end 1 keeps its length if e . (a1 - a2) =
    -|v1 - v2|^2/l. The bobs have the accelerations g - M^-1 G^T T, where row r of G is e at end 1
    of rod r and -e at end 2; the acceleration a_p of the pivot is given. The tensions T then solve

        G M^-1 G^T T = b,   b = |v1 - v2|^2/l + G g + (e . a_p at end 1, -e . a_p at end 2),

    with G over bobs only. The terms of g cancel for a rod between two bobs.
    """
    rods = scene.all(Rod)
    chain = _chain(scene)
    mass = scene.bodies.mass
    gravity = single.gravity(scene)
    jacobian = np.zeros((len(position), len(rods), len(mass), 3))
    right_hand_side = np.zeros((len(position), len(rods)))

    def at(column: Array, end: int, of_pivot: Array) -> Array:
        """The column of a body at a rod's end, or of the pivot where the rod hangs from the
        world.
        """
        if end >= 0:
            result: Array = column[:, end]
        else:
            result = of_pivot
        return result

    for index, rod in enumerate(rods):
        rod_vector = at(position, rod.a, pivot.place) - at(position, rod.b, pivot.place)
        relative = at(velocity, rod.a, pivot.velocity) - at(velocity, rod.b, pivot.velocity)
        direction = rod_vector / rod.length
        right_hand_side[:, index] = np.sum(relative**2, axis=1) / rod.length
        # The ends that can move under the tension are bobs; the pivot is prescribed.
        sides = {rod.a: 1.0, rod.b: -1.0}
        ends = {end: side for end, side in sides.items() if end >= 0 and end != chain.pivot}
        for end, side in ends.items():
            jacobian[:, index, end] = side * direction
            right_hand_side[:, index] += side * direction @ gravity
        if len(ends) == 1:
            (side,) = ends.values()
            right_hand_side[:, index] -= side * np.sum(direction * pivot.acceleration, axis=1)
    coupling = np.einsum("tink,tjnk->tij", jacobian, jacobian / mass[:, None])
    tension: Any = np.linalg.solve(coupling, right_hand_side[..., None])[..., 0]
    return np.ascontiguousarray(tension)


def _energy_lost(scene: Scene, pivot_body: int, pivot: Pivot, work: Array) -> Array:
    """Energy (T,) [J] that the scene has lost through the moving anchor since the start.

    It is minus the work of the anchor on the chain, W(t) - W(0), minus the change of the energy of
    the pivot's own mass, m (v^2/2 - g . r).
    """
    # Energy of the pivot per mass [J/kg].
    kinetic = 0.5 * np.sum(pivot.velocity**2, axis=1)
    energy: Array = kinetic - pivot.place @ single.gravity(scene)
    lost: Array = work[0] - work - scene.bodies.mass[pivot_body] * (energy - energy[0])
    return lost


METHOD = RodChain()
