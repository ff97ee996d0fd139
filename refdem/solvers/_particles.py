"""Base of the methods for points and spheres (kernels/particles.c): which scenes they support, and
the scene as the kernel's struct.
"""

from abc import abstractmethod
from itertools import combinations, product
from typing import Any

import numpy as np
from numpy.typing import NDArray

from refdem import kernels
from refdem.core.problem import Motion, Request
from refdem.core.trajectory import Event, Trajectory
from refdem.mechanics.quaternion import conjugate, rotated
from refdem.scene import Bodies, Point, Polyhedron, Scene
from refdem.scene.elements.central_field import CentralField
from refdem.scene.elements.contact import Contact
from refdem.scene.elements.plane import Plane
from refdem.scene.elements.spring import Spring
from refdem.scene.elements.uniform_gravity import UniformGravity
from refdem.solvers._kernel_solver import KernelCall, KernelSolver, Struct
from refdem.solvers._scene_pattern import ANY, OPTIONAL, ScenePattern
from refdem.solvers._single_point import gravity

Array = NDArray[np.float64]

PATTERN = ScenePattern(
    elements={
        Spring: ANY,
        UniformGravity: ANY,
        CentralField: ANY,
        Contact: OPTIONAL,
        Plane: ANY,
    },
    may_be_fixed=True,
)
"""Points and spheres under springs, gravity, a central field and contact."""
METHODS = {"velocity-verlet": 0, "rk4": 1, "contact-events": 2}
"""Numbers of the methods in the kernel."""
FAMILY = "particles"
ORIGIN = np.zeros(3)
FAR = 16.0
"""Distance from the origin, in sizes of the scene, beyond which positions are counted from the
scene's middle to save digits.
"""
MOST_EVENTS = 1024
"""Largest number of events that are reported; later ones are left out."""
MANY = 12
"""Largest number of pairs. The kernel examines every pair in every step, and divides the step at
the events of each.
"""


def contact_of(scene: Scene) -> Contact | None:
    """The contact law, if any shape can be in contact with anything; else None."""
    laws = scene.all(Contact)
    if laws and _can_meet(scene):
        return laws[0]
    return None


def _can_meet(scene: Scene) -> bool:
    """True if a pair exists that can be in contact, without listing the pairs of many spheres."""
    shaped = np.array([not isinstance(shape, Point) for shape in scene.bodies.shape])
    can_move = bool(np.any(shaped & ~scene.bodies.fixed))
    has_partner = bool(np.count_nonzero(shaped) > 1 or scene.all(Plane))
    return can_move and has_partner


def pairs(scene: Scene) -> NDArray[np.int64]:
    """Pairs (P, 2) of bodies i < j that can be in contact and are not both fixed; plane k counts as
    body -1 - k.
    """
    if not scene.all(Contact) or not scene.has_shapes():
        return np.zeros((0, 2), np.int64)
    has_shape = [
        index for index, shape in enumerate(scene.bodies.shape) if not isinstance(shape, Point)
    ]
    fixed = scene.bodies.fixed
    planes = range(len(scene.all(Plane)))
    result = [(i, j) for i, j in combinations(has_shape, 2) if not (fixed[i] and fixed[j])]
    result += [(i, -1 - plane) for i, plane in product(has_shape, planes) if not fixed[i]]
    return np.array(result, np.int64).reshape(-1, 2)


def unsupported(problem: Motion) -> str | None:
    """None if the scene is points and spheres under springs, gravity, a central field and linear or
    Hertzian contact, else the reason.
    """
    return PATTERN.unsupported(problem) or unsupported_values(problem)


def unsupported_values(problem: Motion) -> str | None:
    """None if springs, bodies and contacts of a scene with PATTERN are supported by the kernel,
    else the reason.
    """
    scene = problem.scene
    for spring in scene.all(Spring):
        if any(spring.anchor_a) or (spring.b >= 0 and any(spring.anchor_b)):
            return "a spring away from a body's centre"
        if spring.exponent < 1:
            return "a spring whose stiffness is infinite at its natural length"
    spheres = 0
    if scene.all(Contact):
        spheres = int(np.count_nonzero(scene.bodies.radius))
    if spheres * (spheres - 1) / 2 + spheres * len(scene.all(Plane)) > MANY:
        return f"more than {MANY} pairs that may meet"
    law = contact_of(scene)
    if law:
        return _contact_unsupported(scene, law)
    return _body_unsupported(scene)


def _body_unsupported(scene: Scene) -> str | None:
    """None if no body needs Euler's equations (omega x J omega = 0) and fixed bodies are at rest,
    else the reason.
    """
    bodies = scene.bodies
    # omega in body axes, J omega, and the gyroscopic torque omega x J omega.
    spin = rotated(conjugate(bodies.attitude), bodies.omega)
    momentum = bodies.inertia * spin
    gyroscopic = np.linalg.norm(np.cross(spin, momentum), axis=1)
    magnitude = np.linalg.norm(spin, axis=1) * np.linalg.norm(momentum, axis=1)
    if np.any(gyroscopic > 1e-14 * magnitude):
        return "a body that tumbles"
    if np.any(bodies.velocity[bodies.fixed]) or np.any(bodies.omega[bodies.fixed]):
        return "a fixed body that moves"
    return None


def _contact_unsupported(scene: Scene, law: Contact) -> str | None:
    """None if the contact law and the bodies under it are supported, else the reason."""
    if law.law == "rigid":
        return f"contact law {law.law}"
    if any(isinstance(shape, Polyhedron) for shape in scene.bodies.shape):
        return "contact of polyhedra"
    if law.friction > 0:
        # A torque on a sphere with three equal moments J changes omega by torque/J.
        inertia = scene.bodies.inertia[scene.bodies.radius > 0]
        if np.any(np.ptp(inertia, axis=1) > 1e-12 * inertia.max(axis=1)):
            return "friction on a sphere whose three moments of inertia differ"
        if law.tangential_stiffness == 0 and len(pairs(scene)) > 1:
            return "friction without a tangential spring at more than one contact"
    return _body_unsupported(scene)


def middle(scene: Scene) -> Array:
    """The middle (3,) [m] of all shapes if they are far from the origin, else the origin.

    In a central field it is always the origin.
    """
    shapes = scene.bodies.radius > 0
    positions = scene.bodies.position[shapes]
    if not len(positions) or scene.all(CentralField):
        return ORIGIN
    # The middle of the box around all centres, and its longest edge plus the largest radius.
    centre: Array = 0.5 * (positions.min(axis=0) + positions.max(axis=0))
    extent = float(np.ptp(positions, axis=0).max() + scene.bodies.radius[shapes].max())
    if np.abs(centre).max() > FAR * extent:
        return centre
    return ORIGIN


class Packed:
    """A scene as the kernel's struct, with positions counted from `origin` (3,) [m].

    `turning` is True if omega and attitude are part of the state. `pairs` (P, 2) are those that can
    be in contact.
    """

    def __init__(self, scene: Scene, origin: Array) -> None:
        self.origin = origin
        bodies = scene.bodies
        law = contact_of(scene)
        has_friction = law is not None and law.friction > 0
        self.turning = bool(np.any(bodies.omega)) or has_friction
        self.pairs = np.zeros((0, 2), np.int64)
        if law:
            self.pairs = pairs(scene)
        fields: dict[str, Any] = {
            "pair": self.pairs,
            "pairs": len(self.pairs),
            "turning": self.turning,
        }
        fields |= _body_fields(bodies)
        fields |= _gravity_fields(scene)
        fields |= _element_fields(scene, origin)
        if law:
            fields |= _law_fields(law)
        self.struct = Struct(FAMILY, "refdem_particles", fields)

    def start(self, scene: Scene, length: int) -> Array:
        """The initial state (size,): positions [m] of all bodies, then velocities [m/s], then, if
        they rotate, omega and attitudes; zeros for what the kernel keeps after them (the state of
        tangential springs).
        """
        bodies = scene.bodies
        columns = [bodies.position - self.origin, bodies.velocity]
        if self.turning:
            columns += [bodies.omega, bodies.attitude]
        flat = np.concatenate([column.ravel() for column in columns])
        return np.concatenate([flat, np.zeros(length - len(flat))])


def _body_fields(bodies: Bodies) -> dict[str, Any]:
    """Bodies as fields of the kernel's struct; 1/m and 1/J are 0 for fixed ones, which no force
    moves.
    """
    return {
        "mass": bodies.mass,
        "inverse_mass": np.where(bodies.fixed, 0.0, 1.0 / bodies.mass),
        "inverse_inertia": _turn_ease(bodies),
        "radius": bodies.radius,
        "bodies": len(bodies),
    }


def _gravity_fields(scene: Scene) -> dict[str, Any]:
    """The acceleration of uniform gravity (3,) [m/s^2], and GM [m^3/s^2] of all central fields."""
    gm = sum(field.gm for field in scene.all(CentralField))
    return {"gravity": gravity(scene), "gm": gm}


def _turn_ease(bodies: Bodies) -> Array:
    """The inverse moments of inertia 1/J (N,) of bodies; 0 for fixed bodies and points."""
    inertia = bodies.inertia[:, 0]
    turns = ~bodies.fixed & (inertia > 0)
    safe = np.where(turns, inertia, 1.0)
    return np.where(turns, 1.0 / safe, 0.0)


def _law_fields(law: Contact) -> dict[str, Any]:
    """The contact law as fields of the kernel's struct."""
    return {
        "stiffness": law.stiffness,
        "damping": law.damping,
        "tangential_stiffness": law.tangential_stiffness,
        "friction": law.friction,
        "slip_shortening": law.slip_shortening,
        "torque_shortening": law.torque_shortening,
        "no_pull": law.cutoff == "zero_force",
        "hertz": law.law == "hertz",
    }


def _element_fields(scene: Scene, origin: Array) -> dict[str, Any]:
    """Springs and planes as fields of the kernel's struct, counted from `origin` (3,) [m]."""
    springs = scene.all(Spring)
    rows = [_spring_row(spring, origin) for spring in springs]
    ends = [(spring.a, spring.b) for spring in springs]
    planes = [_plane_row(plane, origin) for plane in scene.all(Plane)]
    return {
        "spring": np.array(rows, float),
        "spring_end": np.array(ends, np.int64),
        "springs": len(springs),
        "plane": np.array(planes, float),
    }


def _spring_row(spring: Spring, origin: Array) -> tuple[float, ...]:
    """A spring as a row of numbers in the kernel's order, its anchor counted from `origin` (3,)
    [m].
    """
    anchor = spring.anchor_b - origin
    law = (spring.stiffness, spring.length, spring.exponent)
    return (*law, *anchor, spring.quadratic, spring.cubic)


def _plane_row(plane: Plane, origin: Array) -> tuple[float, ...]:
    """A plane as a row of numbers: its point from `origin` (3,) [m], its normal."""
    return (*(plane.point - origin), *plane.normal)


class ParticleSolver(KernelSolver):
    """Points and spheres by the method of kernels/particles.c that the claims name."""

    pattern = PATTERN
    kernels = (FAMILY,)

    @abstractmethod
    def origin(self, scene: Scene) -> Array:
        """The point (3,) [m] from which the kernel counts positions."""

    @abstractmethod
    def stride(self, request: Request) -> int:
        """Number of steps from each sample to the next."""

    def prepare(self, request: Request) -> KernelCall:
        """The scene, the method and its step, and arrays for contact modes, work space, events,
        channels and states.
        """
        scene = request.problem.scene
        count = len(request.problem.times)
        stride = self.stride(request)
        packed = Packed(scene, self.origin(scene))
        lib = kernels.load(FAMILY).lib
        length = lib.refdem_particles_size(packed.struct.address)
        states = np.zeros((count, length))
        states[0] = packed.start(scene, length)
        if request.step is None:
            step = request.problem.interval / stride
        else:
            step = request.signed_step
        modes = np.zeros(max(1, len(packed.pairs)), np.int64)
        work_space = np.zeros(lib.refdem_particles_work(packed.struct.address))
        events = np.zeros((MOST_EVENTS, 3))
        channels = np.zeros((count, len(_CHANNELS)))
        return KernelCall(
            function="refdem_particles_run",
            inputs=(packed.struct, METHODS[self.claims.name]),
            clock=(step, count, stride, MOST_EVENTS),
            outputs=(modes, work_space, events, channels, states),
            steps=stride * (count - 1),
        )

    def finish(self, request: Request, call: KernelCall, status: int) -> Trajectory:
        """States, channels and events at the samples."""
        scene = request.problem.scene
        packed = Packed(scene, self.origin(scene))
        # The kernel's status is the number of events that it has written.
        _, _, event_rows, channel, states = call.outputs
        return _trajectory(
            scene, request.problem.times, packed, states, channel, event_rows[:status]
        )


def _trajectory(
    scene: Scene,
    times: Array,
    packed: Packed,
    state_rows: Array,
    channel_rows: Array,
    event_rows: Array,
) -> Trajectory:
    """The trajectory from the kernel's rows.

    `state_rows` (T, size) holds the state vectors; `channel_rows` (T, 4) the _CHANNELS;
    `event_rows` rows of time [s], kind (1 contact, else release) and body.
    """
    count = len(times)
    n = len(scene.bodies)
    # A row has the numbers of all bodies column by column; after them come the springs' states.
    columns: dict[str, Any] = {}
    first_column = 0
    if packed.turning:
        widths = _COLUMNS
    else:
        widths = _MOVING
    for name, width in widths.items():
        block = state_rows[:, first_column : first_column + width * n]
        columns[name] = np.ascontiguousarray(block).reshape(count, n, width)
        first_column += width * n
    columns["position"] += packed.origin
    columns["position"][0] = scene.bodies.position
    if not packed.turning:
        columns["omega"] = np.zeros((count, n, 3))
        columns["attitude"] = np.broadcast_to(scene.bodies.attitude, (count, n, 4)).copy()
    events = []
    for t, code, body in event_rows:
        if code == 1:
            kind = "contact"
        else:
            kind = "release"
        events.append(Event(time=float(times[0] + t), kind=kind, body=int(body)))
    channels = {}
    if len(packed.pairs):
        channels = dict(zip(_CHANNELS, channel_rows.T.copy(), strict=True))
    return Trajectory(t=times, channels=channels, events=tuple(events), **columns)


_MOVING = {"position": 3, "velocity": 3}
_COLUMNS = {**_MOVING, "omega": 3, "attitude": 4}
"""Quantities of a state vector in the kernel's order, with the length of each for one body."""
_CHANNELS = ("contacts", "overlap", "contact_force", "dissipated_work")
