"""Two spheres that rub on each other in a plane, by Taylor series from event to event
(kernels/oblique.c).
"""

from time import perf_counter
from typing import Any

import numpy as np
from numpy.typing import NDArray

from refdem.core.engine import Method
from refdem.core.problem import Motion, Request
from refdem.core.trajectory import Cost, Event, Trajectory
from refdem.errors import EngineError
from refdem.kernels import load, pointer, timed
from refdem.mechanics.quaternion import product
from refdem.scene import Scene, Sphere
from refdem.scene.elements.contact import Contact
from refdem.solvers._particles import BRANCH
from refdem.solvers.solver import Solver

Array = NDArray[np.float64]
FAMILY = "oblique"
ROUNDED = 4 * 2.0**-52
"""Overlaps of so many times the distance are rounding."""
ASKEW = 1e-15
"""Part of a vector that may point off the plane or its normal: round-off of a scene turned into
some other direction.
"""
COLUMNS = 12


class ObliqueContact(Solver):
    """Hold, slip, release and the pull of a dashpot are zeros of series, to the last bits."""

    claims = Method(
        name="oblique-contact",
        summary=(
            "Taylor series of order 20 along and across the line of centres; hold, slip and release"
            " as their zeros"
        ),
        control="exact",
        conserves=frozenset({"momentum", "angular-momentum"}),
        cost_rank=8,
    )
    kernels = (FAMILY,)

    def unsupported(self, problem: Motion) -> str | None:
        """None for two free spheres that touch and press, spins across the plane of their motion,
        under linear contact alone.
        """
        scene = problem.scene
        bodies = problem.scene.bodies
        laws = scene.all(Contact)
        if (
            len(bodies) != 2
            or not all(isinstance(shape, Sphere) for shape in bodies.shape)
            or bodies.fixed.any()
        ):
            return "not two free spheres"
        if len(laws) != 1 or len(scene.elements) != 1 or laws[0].law != "linear":
            return "something else than one linear contact law"
        if laws[0].friction > 0 and laws[0].tangential_stiffness == 0:
            return "friction without a tangential spring"
        if np.any(np.ptp(bodies.inertia, axis=1) > 1e-12 * bodies.inertia.max(axis=1)):
            return "a sphere whose three moments of inertia differ"
        if problem.interval < 0:
            return "time runs backwards, and friction has forgotten"
        axes = frame(scene)
        start = beginning(scene, axes)
        if start[0] < 0 or (start[0] == 0 and start[1] <= 0):
            return "the spheres do not touch and approach at the start"
        if (
            start[0] > 0
            and laws[0].cutoff == "zero_force"
            and laws[0].stiffness * start[0] + laws[0].damping * start[1] <= 0
        ):
            return "the force would pull at the start"
        across_plane = np.outer(bodies.omega @ axes[2], axes[2])
        aside = np.linalg.norm(bodies.omega - across_plane, axis=1)
        if np.any(aside > ASKEW * np.linalg.norm(bodies.omega, axis=1)):
            return "a spin turns the motion out of its plane"
        return None

    def run(self, request: Request) -> tuple[Trajectory, Cost]:
        """States of both, contact channels and the release; raises EngineError if hold and slip
        change without end.
        """
        begun = perf_counter()
        scene = request.problem.scene
        t = request.problem.times
        axes = frame(scene)
        start = beginning(scene, axes)
        since = t - t[0]
        out = np.full((len(t), COLUMNS), np.nan)
        release = np.empty(1)
        pair = words(scene, float(since[-1]))
        buffers = [pointer(FAMILY, array, output=True) for array in (release, out)]
        lib = load(FAMILY).lib
        given = (pointer(FAMILY, start), len(t), pointer(FAMILY, since))
        started = perf_counter()
        seconds = timed(lib.refdem_oblique, pair, *given, *buffers)
        cost = Cost(seconds=seconds, setup=started - begun)
        if np.isnan(out[-1, 0]):
            reached = int(np.argmax(np.isnan(out[:, 0])))
            raise EngineError(f"hold and slip change without end at t = {t[reached]:g} s")
        told: tuple[Event, ...] = ()
        if release[0] <= since[-1]:
            told = (Event(time=float(t[0] + release[0]), kind="release", body=0),)
        return _trajectory(scene, axes, t, out, told), cost


def frame(scene: Scene) -> Array:
    """Rows (3, 3): from the first centre to the second; across it in the plane of the motion; the
    normal of that plane.
    """
    bodies = scene.bodies
    line = bodies.position[1] - bodies.position[0]
    relative = bodies.velocity[1] - bodies.velocity[0]
    along = line / np.linalg.norm(line)
    across = relative - (relative @ along) * along
    if np.linalg.norm(across) <= ASKEW * np.linalg.norm(relative):
        # Head on: the spins say in which plane they will move, or else any plane does.
        spin = bodies.omega[np.argmax(np.linalg.norm(bodies.omega, axis=1))]
        across = np.cross(spin, along)
        if not np.any(across):
            least = np.argmin(np.abs(along))
            across = np.cross(along, np.eye(3)[least])
    across = across / np.linalg.norm(across)
    return np.array([along, across, np.cross(along, across)])


def beginning(scene: Scene, axes: Array) -> Array:
    """Overlap [m], its rate and the transverse velocity [m/s], angle 0, spins [rad/s]; an overlap
    that is rounding is none.
    """
    bodies = scene.bodies
    reach = float(bodies.radius.sum())
    relative = bodies.velocity[1] - bodies.velocity[0]
    overlap = reach - float(np.linalg.norm(bodies.position[1] - bodies.position[0]))
    if abs(overlap) <= ROUNDED * reach:
        overlap = 0.0
    rate = -(relative @ axes[0])
    transverse = relative @ axes[1]
    spins = bodies.omega @ axes[2]
    return np.array([overlap, rate, transverse, 0.0, *spins])


def words(scene: Scene, longest: float) -> Any:
    """The pair in the kernel's words."""
    bodies = scene.bodies
    law = scene.all(Contact)[0]
    radius_i, radius_j = bodies.radius.tolist()
    # 1/J, and 0 for a sphere that nothing turns.
    turn_ease_i, turn_ease_j = (1.0 / j if j > 0 else 0.0 for j in bodies.inertia[:, 0])
    numbers = {
        "stiffness": law.stiffness,
        "damping": law.damping,
        "tangential_stiffness": law.tangential_stiffness,
        "friction": law.friction,
        "radius_i": radius_i,
        "radius_j": radius_j,
        "turn_ease_i": turn_ease_i,
        "turn_ease_j": turn_ease_j,
        "ease": float(np.sum(1.0 / bodies.mass)),
        "branch": BRANCH[law.branch],
        "longest": longest,
        "no_pull": law.cutoff == "zero_force",
    }
    return load(FAMILY).ffi.new("refdem_oblique_pair *", numbers)


def _trajectory(
    scene: Scene, axes: Array, t: Array, out: Array, events: tuple[Event, ...]
) -> Trajectory:
    """The kernel's rows about a centre of mass in uniform motion."""
    bodies = scene.bodies
    overlap, rate, transverse, angle = out[:, :4].T
    along = np.stack([np.cos(angle), np.sin(angle)], axis=-1) @ axes[:2]
    across = np.stack([-np.sin(angle), np.cos(angle)], axis=-1) @ axes[:2]
    line = bodies.position[1] - bodies.position[0]
    total = bodies.mass.sum()
    apart = (bodies.radius.sum() - overlap)[:, None] * along - line
    relative = transverse[:, None] * across - rate[:, None] * along
    share = np.array([-bodies.mass[1], bodies.mass[0]])[:, None] / total
    centre = bodies.mass @ bodies.velocity / total
    position = bodies.position + centre * (t - t[0])[:, None, None] + apart[:, None] * share
    velocity = centre + relative[:, None] * share
    half = 0.5 * out[:, 6:8, None]
    turned = np.concatenate([np.cos(half), np.sin(half) * axes[2]], axis=-1)
    columns = {
        "position": position,
        "velocity": velocity,
        "omega": out[:, 4:6, None] * axes[2],
        "attitude": product(turned, np.broadcast_to(bodies.attitude, turned.shape)),
    }
    channels = {
        "contacts": out[:, 9].copy(),
        "overlap": np.maximum(overlap, 0.0),
        "contact_force": out[:, 10].copy(),
        "dissipated_work": out[:, 11].copy(),
    }
    for name in ("position", "velocity", "omega", "attitude"):
        columns[name][0] = getattr(bodies, name)
    return Trajectory(t=t, channels=channels, events=events, **columns)


METHOD = ObliqueContact()
