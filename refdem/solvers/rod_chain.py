"""Points on rods one below the other, in a plane, from a pivot that rests or moves by a law of time
(kernels/rod_chain.c).
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
from refdem.solvers._scene_pattern import ANY, OPTIONAL, Count, ScenePattern
from refdem.solvers._single_point import Array

FITS = 1e-9
"""Part of a length, or of a speed, by which the start may miss what rigid rods and the moved pivot
allow: rounding.
"""
MOST = 8


class RodChain(KernelSolver):
    """Angles by Taylor series; places, velocities and rod forces from them."""

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

    def unfit(self, problem: Motion) -> str | None:
        """None for a chain from one pivot whose start fits its rods."""
        return _broken(problem.scene) or _astray(problem)

    def prepare(self, request: Request) -> KernelCall:
        """Rods, directions at the start, masses and drive, and rows for angles from the start
        [rad], rates [rad/s] and the work of the pivot.
        """
        scene = request.problem.scene
        t = request.problem.times
        chain = _chain(scene)
        aim, rate = _aim(scene, chain, _pivot(scene, t))
        count = len(chain.bobs)
        states = np.empty((len(t), 2 * count + 1))
        states[0] = np.concatenate([np.zeros(count), rate, [0.0]])
        mass = scene.bodies.mass[chain.bobs]
        gravity = single.gravity(scene)[:2]
        return KernelCall(
            function="refdem_rod_chain",
            inputs=(count, _lengths(chain), aim, mass, gravity, *_drive(scene)),
            clock=samples(t),
            outputs=(states,),
        )

    def finish(self, request: Request, call: KernelCall, status: int) -> Trajectory:
        """Position, velocity and the force [N] of every rod at the samples."""
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
        aim, _ = _aim(scene, chain, pivot)
        arms = _lengths(chain)[:, None] * aim
        position, velocity = _places(scene, chain, pivot, arms, states[:, :-1])
        channels = {"rod_force": _tension(scene, pivot, position, velocity)}
        if chain.pivot >= 0:
            channels["dissipated_work"] = _lost(scene, chain.pivot, pivot, states[:, -1])
        return Trajectory.of_points(t, position, velocity, channels=channels)


class Chain(NamedTuple):
    """Numbers of the bobs from the pivot on, the rod above each, and the body that is the pivot
    (-1: a place of the world).
    """

    bobs: list[int]
    rods: list[Rod]
    pivot: int


class Pivot(NamedTuple):
    """Place, velocity and acceleration of the pivot, each (T, 3)."""

    place: Array
    velocity: Array
    acceleration: Array


def _chain(scene: Scene) -> Chain:
    """The chain as far as its rods go; bobs that no rod reaches are left out."""
    anchors = scene.all(MovingAnchor)
    if anchors:
        end = anchors[0].a
    else:
        end = -1
    chain = Chain([], [], end)
    left = list(scene.all(Rod))
    while following := [rod for rod in left if end in (rod.a, rod.b)]:
        rod = following[0]
        left.remove(rod)
        if rod.b == end:
            end = rod.a
        else:
            end = rod.b
        chain.bobs.append(end)
        chain.rods.append(rod)
    return chain


def _lengths(chain: Chain) -> Array:
    """Lengths (N,) [m] of the rods from the pivot on."""
    return np.array([rod.length for rod in chain.rods])


def _broken(scene: Scene) -> str | None:
    """None if the rods are one chain from one pivot that holds every body."""
    anchors = scene.all(MovingAnchor)
    rods = scene.all(Rod)
    if anchors and any(rod.b < 0 for rod in rods):
        return "a rod hangs beside the moved pivot"
    chain = _chain(scene)
    held = {*chain.bobs, *(anchor.a for anchor in anchors)}
    if (
        len(chain.bobs) < len(rods)
        or len(set(chain.bobs)) < len(rods)
        or held != set(range(len(scene.bodies)))
    ):
        return "the rods do not hang one below the other from one pivot"
    return None


def _astray(problem: Motion) -> str | None:
    """None if the start fits rods and pivot in place and in velocity."""
    scene = problem.scene
    bodies = problem.scene.bodies
    chain = _chain(scene)
    pivot = _pivot(scene, problem.times[:1])
    for anchor in scene.all(MovingAnchor):
        size = sum(rod.length for rod in chain.rods)
        off = np.linalg.norm(bodies.position[anchor.a] - pivot.place[0]) / size
        rate = np.linalg.norm(bodies.velocity[anchor.a] - pivot.velocity[0])
        if off > FITS or rate > FITS * abs(anchor.amplitude * anchor.frequency):
            return "the pivot does not start where its law of time has it"
    for arm, speed, rod in zip(*_parts(scene, chain, pivot), chain.rods, strict=True):
        if abs(np.linalg.norm(arm) - rod.length) > FITS * rod.length:
            return f"a rod of length {rod.length} starts {np.linalg.norm(arm)} long"
        if abs(arm @ speed) > FITS * rod.length * np.linalg.norm(speed):
            return "a rod starts with a speed along it"
    return None


def _drive(scene: Scene) -> tuple[Array, float, float]:
    """Amplitude along both axes (2,) [m], frequency [rad/s] and phase of the pivot."""
    for anchor in scene.all(MovingAnchor):
        return anchor.amplitude * np.array(anchor.axis[:2]), anchor.frequency, anchor.phase
    return np.zeros(2), 0.0, 0.0


def _pivot(scene: Scene, t: Array) -> Pivot:
    """The pivot's motion; at rest where the first rod hangs from the world."""
    for anchor in scene.all(MovingAnchor):
        place = anchor.place(t)
        # a = -w^2 x about the middle of the motion.
        acceleration = -(anchor.frequency**2) * (place - np.array(anchor.anchor_b))
        return Pivot(place, anchor.velocity(t), acceleration)
    hung = next(rod for rod in scene.all(Rod) if rod.b < 0)
    rest = np.zeros((len(t), 3))
    return Pivot(rest + single.anchor(hung), rest, rest)


def _parts(scene: Scene, chain: Chain, pivot: Pivot) -> tuple[Array, Array]:
    """From each bob's support to the bob (N, 3) at the start, and the relative velocity."""
    place = np.concatenate([pivot.place[:1], scene.bodies.position[chain.bobs]])
    velocity = np.concatenate([pivot.velocity[:1], scene.bodies.velocity[chain.bobs]])
    return np.diff(place, axis=0), np.diff(velocity, axis=0)


def _aim(scene: Scene, chain: Chain, pivot: Pivot) -> tuple[Array, Array]:
    """Sines and cosines (N, 2) of the angles from (0, -1) at the start, and the rates (N,)."""
    arm, speed = _parts(scene, chain, pivot)
    length = np.linalg.norm(arm, axis=1, keepdims=True)
    aim = np.stack([arm[:, 0], -arm[:, 1]], axis=1) / length
    # theta' = (r x v)_z/r^2.
    turning = arm[:, 0] * speed[:, 1] - arm[:, 1] * speed[:, 0]
    return aim, turning / np.sum(arm**2, axis=1)


def _places(
    scene: Scene, chain: Chain, pivot: Pivot, aim: Array, states: Array
) -> tuple[Array, Array]:
    """Position and velocity (T, bodies, 3) of all bodies;

    `aim` (N, 2) times the lengths. Row 0 is the start as it came.
    """
    turn, rate = np.split(states, 2, axis=1)
    sine = np.sin(turn)
    cosine = np.cos(turn)
    nothing = np.zeros_like(turn)
    x = aim[:, 0] * cosine + aim[:, 1] * sine
    down = aim[:, 1] * cosine - aim[:, 0] * sine
    outward = np.stack([x, -down, nothing], axis=2)
    sideways = rate[..., None] * np.stack([down, x, nothing], axis=2)
    shape = (len(states), len(scene.bodies), 3)
    position = np.empty(shape)
    velocity = np.empty(shape)
    if chain.pivot >= 0:
        position[:, chain.pivot] = pivot.place
        velocity[:, chain.pivot] = pivot.velocity
    position[:, chain.bobs] = pivot.place[:, None] + np.cumsum(outward, axis=1)
    velocity[:, chain.bobs] = pivot.velocity[:, None] + np.cumsum(sideways, axis=1)
    position[0] = scene.bodies.position
    velocity[0] = scene.bodies.velocity
    return position, velocity


def _tension(scene: Scene, pivot: Pivot, position: Array, velocity: Array) -> Array:
    """Tension (T, rods) [N] in the scene's order: what keeps every rod's length, e.(a1 - a2) = -|v1
    - v2|^2/length.
    """
    rods = scene.all(Rod)
    chain = _chain(scene)
    mass = scene.bodies.mass
    gravity = single.gravity(scene)
    rows = np.zeros((len(position), len(rods), len(mass), 3))
    wanted = np.zeros((len(position), len(rods)))

    def at(column: Array, end: int, of_pivot: Array) -> Array:
        """What an end of a rod has: a body's column, or the pivot's where it hangs from it."""
        if end >= 0:
            own: Array = column[:, end]
        else:
            own = of_pivot
        return own

    for number, rod in enumerate(rods):
        apart = at(position, rod.a, pivot.place) - at(position, rod.b, pivot.place)
        relative = at(velocity, rod.a, pivot.velocity) - at(velocity, rod.b, pivot.velocity)
        direction = apart / rod.length
        wanted[:, number] = np.sum(relative**2, axis=1) / rod.length
        # The ends that the force moves: bobs, not the pivot.
        sides = {rod.a: 1.0, rod.b: -1.0}
        ends = {end: side for end, side in sides.items() if end >= 0 and end != chain.pivot}
        for end, side in ends.items():
            rows[:, number, end] = side * direction
            wanted[:, number] += side * direction @ gravity
        if len(ends) == 1:
            (side,) = ends.values()
            wanted[:, number] -= side * np.sum(direction * pivot.acceleration, axis=1)
    coupling = np.einsum("tink,tjnk->tij", rows, rows / mass[:, None])
    solved: Any = np.linalg.solve(coupling, wanted[..., None])[..., 0]
    return np.ascontiguousarray(solved)


def _lost(scene: Scene, number: int, pivot: Pivot, work: Array) -> Array:
    """Energy (T,) [J] that the scene has lost to the anchor since the start: less what it did on
    the chain and on the pivot's mass.
    """
    # Energy of the pivot per mass [J/kg].
    kinetic = 0.5 * np.sum(pivot.velocity**2, axis=1)
    energy: Array = kinetic - pivot.place @ single.gravity(scene)
    return work[0] - work - scene.bodies.mass[number] * (energy - energy[0])


METHOD = RodChain()
