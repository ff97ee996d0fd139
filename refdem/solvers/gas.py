"""Many equal smooth spheres in a periodic box or between planes: velocity Verlet with a neighbour list (kernels/gas.c)."""

from dataclasses import dataclass
from time import perf_counter
from typing import Any

import numpy as np
from numpy.typing import NDArray

from refdem.core.engine import Method
from refdem.core.problem import Motion, Request
from refdem.core.trajectory import Cost, Event, Trajectory
from refdem.errors import EngineError
from refdem.kernels import load, pointer
from refdem.scene import Scene, Sphere
from refdem.scene.elements.contact import Contact
from refdem.scene.elements.periodic_box import PeriodicBox
from refdem.scene.elements.plane import Plane
from refdem.solvers.solver import Solver

Array = NDArray[np.float64]

FEWEST = 2.5
"""Diameters in the edge of a box, at least: a body meets one image of another at a time, and the list has a skin."""
PACKED = 0.74048
"""The closest packing of spheres: pairs within a diameter and a skin of half of one are limited by it."""
MOST_EVENTS = 100_000
"""Contacts whose begin is told; of a motion with more none is, so that those told are all."""


@dataclass(frozen=True, eq=False)
class Buffers:
    """Arrays of one run, and the addresses of those that the kernel works in."""

    channel: Array
    event: Array
    out: Array
    addresses: tuple[Any, ...]


class Gas(Solver):
    """Second order in energy: a contact that begins within a step is hit or missed by a part of it, as often early as late."""

    claims = Method(
        name="gas",
        summary="velocity Verlet for many equal smooth spheres; cells and a neighbour list; impulses on a grid",
        control="step",
        order=2,
        constant=1 / 128,
        constant_reason="of all bodies few are in contact at a time: energy errs by 3e-5 (e = 0.9) to 5e-4 (e = 0.2) of T/tau (h/tau)^2",
        conserves=frozenset({"momentum"}),
        cost_rank=20,
    )
    kernels = ("gas",)

    def refusal(self, problem: Motion) -> str | None:
        """None for two or more equal spheres that do not spin, with a linear contact law without friction, and no other force."""
        scene = problem.scene
        for element in scene.elements:
            if not isinstance(element, Contact | Plane | PeriodicBox):
                return f"{element.kind} is neither contact nor what bounds a gas"
        return _of_bodies(scene) or _of_bounds(scene) or _of_contact(scene)

    def run(self, request: Request) -> tuple[Trajectory, Cost]:
        """States at the samples, number of contacts, dissipated work and where contacts begin."""
        begun = perf_counter()
        scene, t = request.problem.scene, request.problem.times
        ffi, lib = load("gas").ffi, load("gas").lib
        planes = np.array([(*plane.point, *plane.normal) for plane in scene.all(Plane)]).ravel()
        struct = ffi.new("refdem_gas *", {**_numbers(scene), "plane": pointer("gas", planes) if planes.size else ffi.NULL})
        used = _buffers(scene, struct, len(t))
        started = perf_counter()
        begins = lib.refdem_gas_run(struct, request.signed_step, len(t), request.stride, len(used.event), *used.addresses)
        cost = Cost(seconds=perf_counter() - started, setup=started - begun, steps=request.stride * (len(t) - 1))
        if begins < 0:
            raise EngineError("gas: more bodies in one place than spheres can be; a smaller step would keep them apart")
        told: Any = used.event[:begins] if begins <= len(used.event) else []
        events = tuple(Event(time=float(t[0] + when), kind="contact", body=int(body)) for when, body in told)
        contacts, work = used.channel.T.copy()
        return _trajectory(scene, t, used.out, {"contacts": contacts, "dissipated_work": work}, events), cost


def _of_bodies(scene: Scene) -> str | None:
    bodies = scene.bodies
    if len(bodies) < 2 or not all(isinstance(shape, Sphere) for shape in bodies.shape):
        return "what is not two or more spheres"
    if np.ptp(bodies.radius) or np.ptp(bodies.mass):
        return "spheres that differ"
    return "spheres that spin, or are fixed" if bodies.omega.any() or bodies.fixed.any() else None


def _of_bounds(scene: Scene) -> str | None:
    boxes, walls = scene.all(PeriodicBox), scene.all(Plane)
    if len(boxes) > 1 or (boxes and walls):
        return "more than one kind of bounds"
    if not boxes and not walls:
        return "no bounds: the methods for few bodies find contacts to the last bit"
    if boxes and boxes[0].size < FEWEST * 2 * scene.bodies.radius[0]:
        return f"a box smaller than {FEWEST:g} diameters"
    return None


def _of_contact(scene: Scene) -> str | None:
    laws = scene.all(Contact)
    if len(laws) != 1:
        return "not one contact law"
    return f"contact law {laws[0].law}" if laws[0].law != "linear" else "friction" if laws[0].friction > 0 else None


def _numbers(scene: Scene) -> dict[str, Any]:
    """The fields of the kernel's struct that are numbers; room for pairs as at three times the density, at most closest packing."""
    bodies, law, boxes = scene.bodies, scene.all(Contact)[0], scene.all(PeriodicBox)
    diameter, n = 2 * float(bodies.radius[0]), len(bodies)
    extent = [boxes[0].size] * 3 if boxes else np.maximum(np.ptp(bodies.position, axis=0), diameter)
    filled = min(PACKED, 0.05 + 3 * n * np.pi / 6 * diameter**3 / float(np.prod(extent)))
    most = int(min(n * (n - 1) / 2, n * (20 + 0.5 * 8 * 1.5**3 * filled))) + 6 * n
    numbers: dict[str, Any] = {"bodies": n, "planes": len(scene.all(Plane)), "most_pairs": most, "no_pull": law.cutoff == "zero_force"}
    numbers |= {"mass": bodies.mass[0], "diameter": diameter, "stiffness": law.stiffness, "damping": law.damping}
    return numbers | {"size": boxes[0].size if boxes else 0.0}


def _buffers(scene: Scene, struct: Any, samples: int) -> Buffers:
    """Everything that a run writes; the start is in its place."""
    ffi, lib = load("gas").ffi, load("gas").lib
    work, integers = np.empty(lib.refdem_gas_doubles(struct)), np.empty(lib.refdem_gas_integers(struct), np.int32)
    marks, event = np.empty(lib.refdem_gas_bytes(struct), np.uint8), np.empty((MOST_EVENTS, 2))
    channel, out = np.empty((samples, 2)), np.empty((samples, 2, len(scene.bodies), 3))
    out[0] = scene.bodies.position, scene.bodies.velocity
    pointers = (pointer("gas", work, output=True), ffi.from_buffer("int32_t[]", integers), ffi.from_buffer("uint8_t[]", marks))
    return Buffers(channel, event, out, (*pointers, *(pointer("gas", a, output=True) for a in (event, channel, out))))


def _trajectory(scene: Scene, t: Array, out: Array, channels: dict[str, Array], events: tuple[Event, ...]) -> Trajectory:
    """The kernel's rows as states; no sphere turns."""
    shape = (len(t), len(scene.bodies))
    still: dict[str, Any] = {"attitude": np.broadcast_to(scene.bodies.attitude, (*shape, 4)), "omega": np.zeros((*shape, 3))}
    position, velocity = np.ascontiguousarray(out[:, 0]), np.ascontiguousarray(out[:, 1])
    return Trajectory(t=t, position=position, velocity=velocity, channels=channels, events=events, **still)


METHOD = Gas()
