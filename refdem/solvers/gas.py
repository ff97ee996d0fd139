"""Many equal spheres, smooth or rough, in a periodic box, between planes or in the open: velocity
Verlet with a neighbour list.

The kernel is gas.c. The environment variable REFDEM_THREADS is the number of threads of a run, 1 if
it is not set: worker processes share the cores already.
No bit of the result depends on it.
"""

import os
from dataclasses import dataclass
from time import perf_counter
from typing import Any

import numpy as np
from numpy.typing import NDArray

from refdem.core.engine import Method
from refdem.core.problem import Motion, Request
from refdem.core.trajectory import Cost, Event, Trajectory
from refdem.errors import EngineError, UsageError
from refdem.kernels import load, pointer
from refdem.scene import Scene
from refdem.scene.elements.contact import Contact
from refdem.scene.elements.periodic_box import PeriodicBox
from refdem.scene.elements.plane import Plane
from refdem.solvers._particles import BRANCH, MANY
from refdem.solvers.solver import Solver

Array = NDArray[np.float64]

STATE = {"position": 3, "velocity": 3, "omega": 3, "attitude": 4}
MOVING = ("position", "velocity")
FEWEST = 2.5
"""Diameters in the edge of a box, at least: a body meets one image of another at a time, and the
list has a skin.
"""
PACKED = 0.74048
"""The closest packing of spheres: pairs within a diameter and a skin of half of one are limited by
it.
"""
TOUCHING = 4
"""Contacts of a body with later ones: 3 in the closest random packing."""
MOST_EVENTS = 100_000
"""Contacts whose begin is told; of a motion with more none is, so that those told are all."""


THREADS = "REFDEM_THREADS"
MOST_THREADS = 64


@dataclass(frozen=True, eq=False)
class Buffers:
    """Arrays of one run; `turning`: omega and attitude are told, else no sphere turns."""

    channel: Array
    event: Array
    events: NDArray[np.int64]
    states: dict[str, Array]
    room: NDArray[np.uint8]

    def addresses(self) -> tuple[Any, ...]:
        """The addresses of the arrays in the kernel's order; NULL for states that are not told."""
        ffi = load("gas").ffi
        states = []
        for name in STATE:
            rows = self.states.get(name)
            if rows is None:
                address = ffi.NULL
            else:
                address = pointer("gas", rows, output=True)
            states.append(address)
        room = ffi.from_buffer("uint8_t[]", self.room)
        events = ffi.from_buffer("int64_t[]", self.events)
        event = pointer("gas", self.event, output=True)
        channel = pointer("gas", self.channel, output=True)
        return (room, events, event, channel, *states)


class Gas(Solver):
    """Second order in energy: a contact that begins within a step is hit or missed by a part of it,
    as often early as late.

    With friction first order: what a tangential spring forgets at its limit, it forgets at the end
    of a step.
    """

    claims = Method(
        name="gas",
        summary=(
            "velocity Verlet for many equal spheres; cells and a neighbour list, tangential springs"
            " kept; impulses on a grid"
        ),
        control="step",
        order=2,
        order_with={"friction": 1},
        constant=1 / 128,
        constant_reason=(
            "of all bodies few are in contact at a time: energy errs by 3e-5 (e = 0.9) to 5e-4 (e ="
            " 0.2) of T/tau (h/tau)^2"
        ),
        conserves=frozenset({"momentum", "angular-momentum"}),
        cost_rank=20,
    )
    kernels = ("gas",)

    def unsupported(self, problem: Motion) -> str | None:
        """None for many equal spheres under a linear contact law, with a tangential spring if there
        is friction, and no other force.
        """
        scene = problem.scene
        for element in scene.elements:
            if not isinstance(element, Contact | Plane | PeriodicBox):
                return f"{element.kind} is neither contact nor what bounds a gas"
        return _of_bodies(scene) or _of_bounds(scene) or _of_contact(scene)

    def run(self, request: Request) -> tuple[Trajectory, Cost]:
        """States at the samples, number of contacts, dissipated work and where contacts begin."""
        begun = perf_counter()
        scene = request.problem.scene
        t = request.problem.times
        ffi = load("gas").ffi
        lib = load("gas").lib
        planes = np.array([(*plane.point, *plane.normal) for plane in scene.all(Plane)]).ravel()
        # `planes` must live as long as the struct, which does not keep it.
        if planes.size:
            at_planes = pointer("gas", planes)
        else:
            at_planes = ffi.NULL
        struct = ffi.new("refdem_gas *", {**_numbers(scene), "plane": at_planes})
        used = _buffers(scene, struct, len(t))
        started = perf_counter()
        counts = len(used.events), request.signed_step, len(t), request.stride, used.event.shape[1]
        fault = lib.refdem_gas_run(struct, *counts, *used.addresses())
        cost = Cost(
            seconds=perf_counter() - started,
            setup=started - begun,
            steps=request.stride * (len(t) - 1),
        )
        if fault == 2:
            raise EngineError(
                f"gas: {len(used.events)} threads asked for by {THREADS} could not be had"
            )
        if fault:
            raise EngineError(
                "gas: more bodies in one place than spheres can be; a smaller step would keep"
                " them apart"
            )
        contacts, work = used.channel.T.copy()
        channels = {"contacts": contacts, "dissipated_work": work}
        events = _begins(used, float(t[0]))
        return _trajectory(scene, t, used.states, channels, events), cost


def _of_bodies(scene: Scene) -> str | None:
    bodies = scene.bodies
    if len(bodies) < 2 or not bodies.radius.all():
        return "what is not two or more spheres"
    if np.ptp(bodies.radius) or np.ptp(bodies.mass) or np.ptp(bodies.inertia):
        return "spheres that differ"
    if bodies.fixed.any():
        return "spheres that are fixed"
    return None


def _of_bounds(scene: Scene) -> str | None:
    boxes = scene.all(PeriodicBox)
    walls = scene.all(Plane)
    n = len(scene.bodies)
    if len(boxes) > 1 or (boxes and walls):
        return "more than one kind of bounds"
    if not boxes and n * (n - 1) // 2 + n * len(walls) <= MANY:
        return "few bodies: the methods for them find contacts to the last bit"
    if boxes and boxes[0].size < FEWEST * 2 * scene.bodies.radius[0]:
        return f"a box smaller than {FEWEST:g} diameters"
    return None


def _of_contact(scene: Scene) -> str | None:
    laws = scene.all(Contact)
    if len(laws) != 1:
        return "not one contact law"
    if laws[0].law != "linear":
        return f"contact law {laws[0].law}"
    if laws[0].friction > 0 and laws[0].tangential_stiffness == 0:
        return "friction without a tangential spring"
    return None


def _numbers(scene: Scene) -> dict[str, Any]:
    """The fields of the kernel's struct that are numbers; room for pairs as at three times the
    density, at most closest packing.
    """
    bodies = scene.bodies
    law = scene.all(Contact)[0]
    boxes = scene.all(PeriodicBox)
    diameter = 2 * float(bodies.radius[0])
    n = len(bodies)
    planes = len(scene.all(Plane))
    if boxes:
        size = boxes[0].size
    else:
        size = 0.0
    if boxes:
        extent = [size] * 3
    else:
        extent = np.maximum(np.ptp(bodies.position, axis=0), diameter)
    # The part of space that the spheres would fill at three times their density.
    filled = min(PACKED, 0.05 + 3 * n * np.pi / 6 * diameter**3 / float(np.prod(extent)))
    # Half the partners of a sphere within 1.5 diameters, and some; never more than all pairs.
    listed = n * (20 + 0.5 * 8 * 1.5**3 * filled)
    most = int(min(n * (n - 1) / 2, listed)) + n * planes
    return {
        "bodies": n,
        "planes": planes,
        "most_pairs": most,
        "most_contacts": min(most, TOUCHING * n + n * min(planes, 3)),
        "turning": law.friction > 0 or bool(bodies.omega.any()),
        "size": size,
        "mass": bodies.mass[0],
        "inertia": bodies.inertia[0, 0],
        "diameter": diameter,
        "stiffness": law.stiffness,
        "damping": law.damping,
        "tangential_stiffness": law.tangential_stiffness,
        "friction": law.friction,
        "branch": BRANCH[law.branch],
        "no_pull": law.cutoff == "zero_force",
    }


def _buffers(scene: Scene, struct: Any, samples: int) -> Buffers:
    """Everything that a run writes; the start is in its place."""
    n = len(scene.bodies)
    members = min(threads(), len(scene.bodies))
    states = {
        name: np.empty((samples, n, width))
        for name, width in STATE.items()
        if struct.turning or name in MOVING
    }
    for name, rows in states.items():
        rows[0] = getattr(scene.bodies, name)
    room = np.empty(load("gas").lib.refdem_gas_room(struct, members), np.uint8)
    return Buffers(
        np.empty((samples, 2)),
        np.empty((members, MOST_EVENTS, 2)),
        np.zeros(members, np.int64),
        states,
        room,
    )


def threads() -> int:
    """The number of threads that REFDEM_THREADS asks for; raises UsageError for what is no number
    of threads.
    """
    said = os.environ.get(THREADS, "1")
    if not said.isdecimal() or not 1 <= int(said) <= MOST_THREADS:
        raise UsageError(f"{THREADS} is {said!r}; expected a whole number from 1 to {MOST_THREADS}")
    return int(said)


def _begins(used: Buffers, start: float) -> tuple[Event, ...]:
    """Contacts that begin, in time and then in the order of the threads, which is that of the list;
    none if there were too many.
    """
    if used.events.sum() > MOST_EVENTS:
        return ()
    by_thread = [rows[:count] for rows, count in zip(used.event, used.events, strict=True)]
    told = np.concatenate(by_thread)
    in_time = told[np.argsort(told[:, 0], kind="stable")]
    events = [Event(start + when, "contact", int(body)) for when, body in in_time.tolist()]
    return tuple(events)


def _trajectory(
    scene: Scene,
    t: Array,
    states: dict[str, Array],
    channels: dict[str, Array],
    events: tuple[Event, ...],
) -> Trajectory:
    """The kernel's rows as states; where spins and friction are not there, no sphere turns."""
    shape = (len(t), len(scene.bodies))
    still: dict[str, Any] = {
        "attitude": np.broadcast_to(scene.bodies.attitude, (*shape, 4)),
        "omega": np.broadcast_to(np.zeros(3), (*shape, 3)),
    }
    return Trajectory(t=t, channels=channels, events=events, **{**still, **states})


METHOD = Gas()
