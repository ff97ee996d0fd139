"""Oblique contact of two spheres with friction and a tangential spring in a plane, by Taylor series
from event to event (kernels/oblique.c).

The kernel integrates the relative motion: the overlap d along the line of centres, the transverse
velocity u, the angle of the line, and both spins w. With D = R_i + R_j - d, the normal force F = k
d + c d' and the friction f on i,

    d'' = -u^2/D - F/m,   u' = u d'/D - f/m,   angle' = u/D,   w' = l f/J.

Here 1/m = 1/m_i + 1/m_j, and l is the lever of each sphere.
"""

import numpy as np
from numpy.typing import NDArray

from refdem.core.engine import Method
from refdem.core.problem import Motion, Request
from refdem.core.trajectory import Event, Trajectory
from refdem.errors import EngineError
from refdem.mechanics.quaternion import product
from refdem.scene import Scene, Sphere
from refdem.scene.elements.contact import Contact
from refdem.solvers._kernel_solver import KernelCall, KernelSolver, Struct, samples
from refdem.solvers._scene_pattern import ONE, TWO, ScenePattern

Array = NDArray[np.float64]
FAMILY = "oblique"
ROUNDED = 4 * 2.0**-52
"""Overlap, relative to the sum of radii, that counts as rounding."""
ASKEW = 1e-15
"""Largest relative component off the plane or its normal: round-off of a scene that was
rotated.
"""
COLUMNS = 12
"""Length of a row: d, d', q, angle of the line, 2 spins, 2 angles of rotation, work, contacts,
force, dissipated work.
"""


class ObliqueContact(KernelSolver):
    """Changes between stick and slip, release, and the zero of the normal force are zeros of
    series, located to round-off.
    """

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

    pattern = ScenePattern(
        elements={Contact: ONE},
        bodies=TWO,
        shape=Sphere,
        law="linear",
        irreversible="the motion before friction stopped it cannot be recovered",
    )

    def unsupported_values(self, problem: Motion) -> str | None:
        """None for spheres in contact that approach, with spins normal to the plane of their
        motion, else the reason.
        """
        scene = problem.scene
        bodies = scene.bodies
        law = scene.all(Contact)[0]
        if law.friction > 0 and law.tangential_stiffness == 0:
            return "friction without a tangential spring"
        if law.has_two_levers:
            return "friction whose slip and torque have different levers"
        if np.any(np.ptp(bodies.inertia, axis=1) > 1e-12 * bodies.inertia.max(axis=1)):
            return "a sphere whose three moments of inertia differ"
        axes = frame(scene)
        return _not_in_contact(law, initial_state(scene, axes)) or _spin_out_of_plane(
            bodies.omega, axes[2]
        )

    def prepare(self, request: Request) -> KernelCall:
        """The pair and its start; arrays for the release time and for the rows."""
        scene = request.problem.scene
        t = request.problem.times
        since = t - t[0]
        return KernelCall(
            function="refdem_oblique",
            inputs=(pair_struct(scene, float(since[-1])), initial_state(scene, frame(scene))),
            clock=samples(since),
            outputs=(np.empty(1), np.full((len(t), COLUMNS), np.nan)),
        )

    def finish(self, request: Request, call: KernelCall, status: int) -> Trajectory:
        """States of both spheres, contact channels and the release.

        Raises EngineError if stick and slip alternate without end.
        """
        scene = request.problem.scene
        t = request.problem.times
        release, rows = call.outputs
        # The kernel's status is the number of samples that it has reached.
        if status < len(t):
            raise EngineError(f"hold and slip change without end at t = {t[status]:g} s")
        events: tuple[Event, ...] = ()
        if release[0] <= t[-1] - t[0]:
            events = (Event(time=float(t[0] + release[0]), kind="release", body=0),)
        return _trajectory(scene, frame(scene), t, rows, events)


def _not_in_contact(law: Contact, start: Array) -> str | None:
    """None if the spheres touch and approach at the start, and their force pushes, else the
    reason.
    """
    overlap = start[0]
    rate = start[1]
    if overlap < 0 or (overlap == 0 and rate <= 0):
        return "the spheres do not touch and approach at the start"
    force = law.stiffness * overlap + law.damping * rate
    if overlap > 0 and law.cutoff == "zero_force" and force <= 0:
        return "the force would pull at the start"
    return None


def _spin_out_of_plane(omega: Array, normal: Array) -> str | None:
    """None if the spins (2, 3) are along the normal of the plane of motion, else the reason."""
    tangential = np.linalg.norm(omega - np.outer(omega @ normal, normal), axis=1)
    if np.any(tangential > ASKEW * np.linalg.norm(omega, axis=1)):
        return "a spin turns the motion out of its plane"
    return None


def frame(scene: Scene) -> Array:
    """Rows (3, 3): unit vector from the first centre to the second; across it in the plane of
    motion; the plane's normal.
    """
    bodies = scene.bodies
    line = bodies.position[1] - bodies.position[0]
    relative = bodies.velocity[1] - bodies.velocity[0]
    along = line / np.linalg.norm(line)
    # v - (v . e1) e1.
    across = relative - (relative @ along) * along
    if np.linalg.norm(across) <= ASKEW * np.linalg.norm(relative):
        # Head-on: the motion stays in the plane normal to the spins. Without spins any plane
        # through the line of centres can be chosen.
        spin = bodies.omega[np.argmax(np.linalg.norm(bodies.omega, axis=1))]
        across = np.cross(spin, along)
        if not np.any(across):
            smallest = np.argmin(np.abs(along))
            across = np.cross(along, np.eye(3)[smallest])
    across = across / np.linalg.norm(across)
    return np.array([along, across, np.cross(along, across)])


def initial_state(scene: Scene, axes: Array) -> Array:
    """The kernel's initial state: overlap [m] (0 if it is rounding), its rate, transverse velocity
    [m/s], angle 0, spins [rad/s].
    """
    bodies = scene.bodies
    contact_distance = float(bodies.radius.sum())
    relative = bodies.velocity[1] - bodies.velocity[0]
    overlap = contact_distance - float(np.linalg.norm(bodies.position[1] - bodies.position[0]))
    if abs(overlap) <= ROUNDED * contact_distance:
        overlap = 0.0
    # d' = -v . e1 and q = v . e2, with the velocity v of the second sphere relative to the first.
    rate = -(relative @ axes[0])
    transverse = relative @ axes[1]
    spins = bodies.omega @ axes[2]
    return np.array([overlap, rate, transverse, 0.0, *spins])


def pair_struct(scene: Scene, longest: float) -> Struct:
    """The pair as the kernel's struct; `longest` [s] is the duration."""
    bodies = scene.bodies
    law = scene.all(Contact)[0]
    radius_i, radius_j = bodies.radius.tolist()
    turn_ease_i, turn_ease_j = (_turn_ease(float(j)) for j in bodies.inertia[:, 0])
    numbers = {
        "stiffness": law.stiffness,
        "damping": law.damping,
        "tangential_stiffness": law.tangential_stiffness,
        "friction": law.friction,
        "radius_i": radius_i,
        "radius_j": radius_j,
        "inverse_inertia_i": turn_ease_i,
        "inverse_inertia_j": turn_ease_j,
        "inverse_mass": float(np.sum(1.0 / bodies.mass)),
        "branch": law.torque_shortening,
        "longest": longest,
        "no_pull": law.cutoff == "zero_force",
    }
    return Struct(FAMILY, "refdem_oblique_pair", numbers)


def _turn_ease(inertia: float) -> float:
    """1/J of a sphere, 0 for one without inertia, which no torque rotates."""
    if inertia > 0:
        return 1.0 / inertia
    return 0.0


def _trajectory(
    scene: Scene, axes: Array, t: Array, rows: Array, events: tuple[Event, ...]
) -> Trajectory:
    """The trajectory from the kernel's rows (T, COLUMNS), about a centre of mass in uniform
    motion.
    """
    bodies = scene.bodies
    overlap, rate, transverse, angle = rows[:, :4].T
    # along = cos(angle) e1 + sin(angle) e2, across = -sin(angle) e1 + cos(angle) e2.
    along = np.stack([np.cos(angle), np.sin(angle)], axis=-1) @ axes[:2]
    across = np.stack([-np.sin(angle), np.cos(angle)], axis=-1) @ axes[:2]
    line = bodies.position[1] - bodies.position[0]
    total_mass = bodies.mass.sum()
    # The branch vector is b = (R1 + R2 - d) along; its time derivative q across - d' along, with
    # the transverse velocity q. `branch_change` is b - b(0).
    branch_change = (bodies.radius.sum() - overlap)[:, None] * along - line
    relative = transverse[:, None] * across - rate[:, None] * along
    # r_1 = r_c - m2/(m1 + m2) b and r_2 = r_c + m1/(m1 + m2) b, where the centre of mass is at
    # r_c = r_c(0) + v_c t.
    share = np.array([-bodies.mass[1], bodies.mass[0]])[:, None] / total_mass
    centre_velocity = bodies.mass @ bodies.velocity / total_mass
    position = (
        bodies.position
        + centre_velocity * (t - t[0])[:, None, None]
        + branch_change[:, None] * share
    )
    velocity = centre_velocity + relative[:, None] * share
    # q = (cos(angle/2), sin(angle/2) e3) q0, for the angle by which each sphere has turned.
    half_angle = 0.5 * rows[:, 6:8, None]
    rotation = np.concatenate([np.cos(half_angle), np.sin(half_angle) * axes[2]], axis=-1)
    columns = {
        "position": position,
        "velocity": velocity,
        "omega": rows[:, 4:6, None] * axes[2],
        "attitude": product(rotation, np.broadcast_to(bodies.attitude, rotation.shape)),
    }
    channels = {
        "contacts": rows[:, 9].copy(),
        "overlap": np.maximum(overlap, 0.0),
        "contact_force": rows[:, 10].copy(),
        "dissipated_work": rows[:, 11].copy(),
    }
    for name in ("position", "velocity", "omega", "attitude"):
        columns[name][0] = getattr(bodies, name)
    return Trajectory(t=t, channels=channels, events=events, **columns)


METHOD = ObliqueContact()
