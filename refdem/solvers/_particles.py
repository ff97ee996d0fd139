"""What the methods for points and spheres share: which scenes they can say, and the scene in the
kernel's words.
"""

from itertools import combinations, product
from time import perf_counter
from typing import Any

import numpy as np
from numpy.typing import NDArray

from refdem import kernels
from refdem.core.problem import Motion, Request
from refdem.core.trajectory import Cost, Event, Trajectory
from refdem.mechanics.quaternion import conjugate, rotated
from refdem.scene import Point, Polyhedron, Scene
from refdem.scene.element import Element
from refdem.scene.elements.central_field import CentralField
from refdem.scene.elements.contact import Contact
from refdem.scene.elements.plane import Plane
from refdem.scene.elements.spring import Spring
from refdem.scene.elements.uniform_gravity import UniformGravity

Array = NDArray[np.float64]

ELEMENTS = (Spring, UniformGravity, CentralField, Contact, Plane)
BRANCH = {"R": 0.0, "R-d": 1.0, "R-d/2": 0.5}
METHODS = {"velocity-verlet": 0, "rk4": 1, "contact-events": 2}
FAMILY = "particles"
ORIGIN = np.zeros(3)
FAR = 16.0
"""Places that are more than so many sizes of the scene away cost digits; nearer ones are left as
they are given.
"""
MANY = 12
"""Pairs that are looked at one by one in every step, and whose events cut it."""


def contact_of(scene: Scene) -> Contact | None:
    """The contact law, if some shape can meet anything under it."""
    laws = scene.all(Contact)
    if laws and _can_meet(scene):
        return laws[0]
    return None


def _can_meet(scene: Scene) -> bool:
    """Whether there is a pair at all; of many spheres nobody writes all of them down."""
    shaped = np.array([not isinstance(shape, Point) for shape in scene.bodies.shape])
    can_move = bool(np.any(shaped & ~scene.bodies.fixed))
    has_partner = bool(np.count_nonzero(shaped) > 1 or scene.all(Plane))
    return can_move and has_partner


def pairs(scene: Scene) -> NDArray[np.int64]:
    """Pairs (P, 2) of a body with a later one, or with plane k as -1 - k, that can meet and are not
    both fixed.
    """
    if not scene.all(Contact) or not scene.has_shapes():
        return np.zeros((0, 2), np.int64)
    has_shape = [
        number for number, shape in enumerate(scene.bodies.shape) if not isinstance(shape, Point)
    ]
    fixed = scene.bodies.fixed
    planes = range(len(scene.all(Plane)))
    found = [(i, j) for i, j in combinations(has_shape, 2) if not (fixed[i] and fixed[j])]
    found += [(i, -1 - plane) for i, plane in product(has_shape, planes) if not fixed[i]]
    return np.array(found, np.int64).reshape(-1, 2)


def unsupported(problem: Motion) -> str | None:
    """None if the scene is points and spheres under springs, gravity, a central field and linear or
    Hertzian contact.
    """
    scene = problem.scene
    for element in scene.elements:
        reason = _element_unsupported(element)
        if reason:
            return reason
    if len(scene.all(Contact)) > 1:
        return "more than one contact law"
    spheres = 0
    if scene.all(Contact):
        spheres = int(np.count_nonzero(scene.bodies.radius))
    if spheres * (spheres - 1) / 2 + spheres * len(scene.all(Plane)) > MANY:
        return f"more than {MANY} pairs that may meet"
    law = contact_of(scene)
    if law:
        return _contact_unsupported(scene, law)
    return _body_unsupported(scene)


def _element_unsupported(element: Element) -> str | None:
    if not isinstance(element, ELEMENTS):
        return f"{element.kind} is not a smooth force or a contact"
    if isinstance(element, Spring):
        if any(element.anchor_a) or (element.b >= 0 and any(element.anchor_b)):
            return "a spring away from a body's centre"
        if element.exponent < 1:
            return "a spring whose stiffness is infinite at its natural length"
    return None


def _body_unsupported(scene: Scene) -> str | None:
    bodies = scene.bodies
    spin = rotated(conjugate(bodies.attitude), bodies.omega)
    momentum = bodies.inertia * spin
    gyroscopic = np.linalg.norm(np.cross(spin, momentum), axis=1)
    size = np.linalg.norm(spin, axis=1) * np.linalg.norm(momentum, axis=1)
    if np.any(gyroscopic > 1e-14 * size):
        return "a body that tumbles"
    if np.any(bodies.velocity[bodies.fixed]) or np.any(bodies.omega[bodies.fixed]):
        return "a fixed body that moves"
    return None


def _contact_unsupported(scene: Scene, law: Contact) -> str | None:
    if law.law == "rigid":
        return f"contact law {law.law}"
    if any(isinstance(shape, Polyhedron) for shape in scene.bodies.shape):
        return "contact of polyhedra"
    if law.friction > 0:
        inertia = scene.bodies.inertia[scene.bodies.radius > 0]
        if np.any(np.ptp(inertia, axis=1) > 1e-12 * inertia.max(axis=1)):
            return "friction on a sphere whose three moments of inertia differ"
        if law.tangential_stiffness == 0 and len(pairs(scene)) > 1:
            return "friction without a tangential spring at more than one contact"
    return _body_unsupported(scene)


def middle(scene: Scene) -> Array:
    """The middle (3,) [m] of shapes that are far away; else, and where a field has its centre
    there, the origin.
    """
    shapes = scene.bodies.radius > 0
    places = scene.bodies.position[shapes]
    if not len(places) or scene.all(CentralField):
        return ORIGIN
    found: Array = 0.5 * (places.min(axis=0) + places.max(axis=0))
    size = float(np.ptp(places, axis=0).max() + scene.bodies.radius[shapes].max())
    if np.abs(found).max() > FAR * size:
        return found
    return ORIGIN


class Packed:
    """A scene in the kernel's words, from `origin` (3,) [m]; keeps its arrays alive.

    `turning`: omega and attitude are in the state.
    """

    def __init__(self, scene: Scene, origin: Array) -> None:
        self.origin = origin
        bodies = scene.bodies
        law = contact_of(scene)
        self.turning = bool(np.any(bodies.omega)) or (law is not None and law.friction > 0)
        if law:
            self.pairs = pairs(scene)
        else:
            self.pairs = np.zeros((0, 2), np.int64)
        free = ~bodies.fixed
        inertia = bodies.inertia[:, 0]
        turns = free & (inertia > 0)
        springs = scene.all(Spring)
        planes = scene.all(Plane)
        fields = [field.g for field in scene.all(UniformGravity)]
        if fields:
            gravity = np.sum(fields, axis=0)
        else:
            gravity = np.zeros(3)
        self._kept: dict[str, Any] = {
            "mass": bodies.mass,
            "ease": np.where(free, 1.0 / bodies.mass, 0.0),
            "turn_ease": np.where(turns, 1.0 / np.where(turns, inertia, 1.0), 0.0),
            "radius": bodies.radius,
            "gravity": gravity,
            "spring": np.array([_spring_row(spring, origin) for spring in springs], float),
            "spring_end": np.array([(spring.a, spring.b) for spring in springs], np.int64),
            "plane": np.array([_plane_row(plane, origin) for plane in planes], float),
            "pair": self.pairs,
        }
        numbers: dict[str, Any] = {
            "bodies": len(bodies),
            "springs": len(springs),
            "pairs": len(self.pairs),
            "turning": self.turning,
        }
        numbers["gm"] = sum(e.gm for e in scene.all(CentralField))
        if law:
            numbers |= {
                name: getattr(law, name)
                for name in ("stiffness", "damping", "tangential_stiffness", "friction")
            }
            numbers |= {
                "branch": BRANCH[law.branch],
                "no_pull": law.cutoff == "zero_force",
                "hertz": law.law == "hertz",
            }
        ffi = kernels.load(FAMILY).ffi
        arrays = {
            name: _address(ffi, np.ascontiguousarray(value)) for name, value in self._kept.items()
        }
        self._buffers = arrays
        self.struct = ffi.new("refdem_particles *", {**arrays, **numbers})

    def start(self, scene: Scene, size: int) -> Array:
        """The state (size,) at the start: of all bodies the places [m], then the velocities [m/s],
        then spins and attitudes where they are in it, and zeros for the rest.
        """
        bodies = scene.bodies
        columns = [bodies.position - self.origin, bodies.velocity]
        if self.turning:
            columns += [bodies.omega, bodies.attitude]
        flat = np.concatenate([column.ravel() for column in columns])
        return np.concatenate([flat, np.zeros(size - len(flat))])


def _spring_row(spring: Spring, origin: Array) -> tuple[float, ...]:
    """A spring in the kernel's order of numbers, its anchor counted from `origin` (3,) [m]."""
    anchor = spring.anchor_b - origin
    law = (spring.stiffness, spring.length, spring.exponent)
    return (*law, *anchor, spring.quadratic, spring.cubic)


def _plane_row(plane: Plane, origin: Array) -> tuple[float, ...]:
    """A plane in the kernel's order of numbers: its point from `origin` (3,) [m], its normal."""
    return (*(plane.point - origin), *plane.normal)


def _address(ffi: Any, array: NDArray[Any]) -> Any:
    """Where the kernel finds an array; NULL for an empty one."""
    if not array.size:
        return ffi.NULL
    if array.dtype == np.int64:
        kind = "int64_t[]"
    else:
        kind = "double[]"
    return ffi.from_buffer(kind, array)


def run(
    request: Request, step: float, stride: int, origin: Array = ORIGIN
) -> tuple[Trajectory, Cost]:
    """The motion by the method that the request names, `stride` signed steps `step` [s] a sample;
    places count from `origin` (3,) [m].
    """
    begun = perf_counter()
    scene = request.problem.scene
    times = request.problem.times
    kernel = kernels.load(FAMILY)
    packed = Packed(scene, origin)
    size = kernel.lib.refdem_particles_size(packed.struct)
    out = np.zeros((len(times), size))
    channel = np.zeros((len(times), 4))
    work = np.zeros(kernel.lib.refdem_particles_work(packed.struct))
    mode = np.zeros(max(1, len(packed.pairs)), np.int64)
    event = np.zeros((1024, 3))
    out[0] = packed.start(scene, size)
    buffers = (kernels.pointer(FAMILY, a, output=True) for a in (work, event, channel, out))
    work_at, event_at, channel_at, out_at = buffers
    modes = kernel.ffi.from_buffer("int64_t[]", mode)
    started = perf_counter()
    method = METHODS[request.method]
    events = kernel.lib.refdem_particles_run(
        packed.struct,
        method,
        step,
        len(times),
        stride,
        len(event),
        modes,
        work_at,
        event_at,
        channel_at,
        out_at,
    )
    seconds = perf_counter() - started
    cost = Cost(seconds=seconds, setup=started - begun, steps=stride * (len(times) - 1))
    return _trajectory(scene, times, packed, out, channel, event[:events]), cost


def _trajectory(
    scene: Scene, times: Array, packed: Packed, out: Array, channel: Array, event: Array
) -> Trajectory:
    """The kernel's rows as states, channels and events."""
    count = len(times)
    n = len(scene.bodies)
    # A row has the numbers of all bodies column by column; after them come the springs' states.
    columns: dict[str, Any] = {}
    begin = 0
    for name, width in _COLUMNS.items() if packed.turning else _MOVING.items():
        block = out[:, begin : begin + width * n]
        columns[name] = np.ascontiguousarray(block).reshape(count, n, width)
        begin += width * n
    columns["position"] += packed.origin
    columns["position"][0] = scene.bodies.position
    if not packed.turning:
        columns["omega"] = np.zeros((count, n, 3))
        columns["attitude"] = np.broadcast_to(scene.bodies.attitude, (count, n, 4)).copy()
    told = []
    for t, what, body in event:
        if what == 1:
            kind = "contact"
        else:
            kind = "release"
        told.append(Event(time=float(times[0] + t), kind=kind, body=int(body)))
    channels = {}
    if len(packed.pairs):
        channels = dict(zip(_CHANNELS, channel.T.copy(), strict=True))
    return Trajectory(t=times, channels=channels, events=tuple(told), **columns)


_MOVING = {"position": 3, "velocity": 3}
_COLUMNS = {**_MOVING, "omega": 3, "attitude": 4}
"""Columns of the kernel's rows in their order, and the numbers that each has of a body."""
_CHANNELS = ("contacts", "overlap", "contact_force", "dissipated_work")
