"""Many equal spheres, smooth or rough, in a periodic box, between planes or in the open: velocity
Verlet with a neighbour list.

The kernel is gas.c. The environment variable REFDEM_THREADS is the number of threads of a run, 1 if
it is not set: worker processes share the cores already.
No bit of the result depends on it.
"""

import os
from typing import Any

import numpy as np
from numpy.typing import NDArray

from refdem.core.engine import Method
from refdem.core.problem import Motion, Request
from refdem.core.trajectory import Event, Trajectory
from refdem.errors import EngineError, UsageError
from refdem.kernels import load
from refdem.scene import Scene
from refdem.scene.elements.contact import Contact
from refdem.scene.elements.periodic_box import PeriodicBox
from refdem.scene.elements.plane import Plane
from refdem.solvers._kernel_solver import (
    KernelCall,
    KernelSolver,
    Struct,
    steps_of,
    steps_to_samples,
)
from refdem.solvers._particles import BRANCH, MANY
from refdem.solvers._scene_pattern import ANY, ONE, OPTIONAL, Count, ScenePattern

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


NO_THREADS = 2
"""What the kernel returns if it cannot have its threads."""
ASTRAY = 3
"""What it returns if a body flew so far that the motion must have diverged."""
THREADS = "REFDEM_THREADS"
MOST_THREADS = 64


class Gas(KernelSolver):
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

    pattern = ScenePattern(
        elements={Contact: ONE, Plane: ANY, PeriodicBox: OPTIONAL},
        bodies=Count(2),
        law="linear",
    )

    def unfit(self, problem: Motion) -> str | None:
        """None for many equal spheres in one kind of bounds, with a tangential spring if there is
        friction.
        """
        scene = problem.scene
        return _of_bodies(scene) or _of_bounds(scene) or _of_contact(scene)

    def prepare(self, request: Request) -> KernelCall:
        """The gas and its threads, and room for lists, events, channels and states; the start is in
        its place.
        """
        scene = request.problem.scene
        count = len(request.problem.times)
        fields = _fields(scene)
        struct = Struct("gas", "refdem_gas", fields)
        members = min(threads(), len(scene.bodies))
        size = load("gas").lib.refdem_gas_room(struct.address, members)
        room = np.empty(size, np.uint8)
        begun = np.zeros(members, np.int64)
        told = np.empty((members, MOST_EVENTS, 2))
        channels = np.empty((count, 2))
        states = _states(scene, count, bool(fields["turning"]))
        return KernelCall(
            function="refdem_gas_run",
            inputs=(struct, members),
            clock=(*steps_to_samples(request), MOST_EVENTS),
            outputs=(room, begun, told, channels, *states),
            steps=steps_of(request),
        )

    def finish(self, request: Request, call: KernelCall, status: int) -> Trajectory:
        """States at the samples, number of contacts, dissipated work and where contacts begin."""
        t = request.problem.times
        _, begun, told, channel, *states = call.outputs
        if status == NO_THREADS:
            raise EngineError(f"gas: {len(begun)} threads asked for by {THREADS} could not be had")
        if status == ASTRAY:
            raise EngineError(
                "gas: the motion diverged (a body is more than 2e9 boxes away); a smaller step"
                " would follow the contacts"
            )
        if status:
            raise EngineError(
                "gas: more bodies in one place than spheres can be; a smaller step would keep"
                " them apart"
            )
        contacts, work = channel.T.copy()
        channels = {"contacts": contacts, "dissipated_work": work}
        events = _begins(begun, told, float(t[0]))
        columns = {name: rows for name, rows in zip(STATE, states, strict=True) if rows is not None}
        return _trajectory(request.problem.scene, t, columns, channels, events)


def _of_bodies(scene: Scene) -> str | None:
    bodies = scene.bodies
    if not bodies.radius.all():
        return "bodies that are no spheres"
    if np.ptp(bodies.radius) or np.ptp(bodies.mass) or np.ptp(bodies.inertia):
        return "spheres that differ"
    return None


def _of_bounds(scene: Scene) -> str | None:
    boxes = scene.all(PeriodicBox)
    walls = scene.all(Plane)
    n = len(scene.bodies)
    if boxes and walls:
        return "a box and planes; expected one kind of bounds"
    if not boxes and n * (n - 1) // 2 + n * len(walls) <= MANY:
        return "few bodies: the methods for them find contacts to the last bit"
    if boxes and boxes[0].size < FEWEST * 2 * scene.bodies.radius[0]:
        return f"a box smaller than {FEWEST:g} diameters"
    return None


def _of_contact(scene: Scene) -> str | None:
    law = scene.all(Contact)[0]
    if law.friction > 0 and law.tangential_stiffness == 0:
        return "friction without a tangential spring"
    return None


def _fields(scene: Scene) -> dict[str, Any]:
    """The fields of the kernel's struct."""
    bodies = scene.bodies
    law = scene.all(Contact)[0]
    walls = [(*plane.point, *plane.normal) for plane in scene.all(Plane)]
    size = 0.0
    for box in scene.all(PeriodicBox):
        size = box.size
    return _room_fields(scene, size) | {
        "bodies": len(bodies),
        "planes": len(walls),
        "plane": np.array(walls, float),
        "turning": law.friction > 0 or bool(bodies.omega.any()),
        "size": size,
        "mass": bodies.mass[0],
        "inertia": bodies.inertia[0, 0],
        "diameter": 2 * float(bodies.radius[0]),
        "stiffness": law.stiffness,
        "damping": law.damping,
        "tangential_stiffness": law.tangential_stiffness,
        "friction": law.friction,
        "branch": BRANCH[law.branch],
        "no_pull": law.cutoff == "zero_force",
    }


def _room_fields(scene: Scene, size: float) -> dict[str, int]:
    """The most pairs and contacts there can be, as at three times the density of the start, but at
    most closest packing; `size` is the edge of the box [m], or 0.
    """
    bodies = scene.bodies
    n = len(bodies)
    planes = len(scene.all(Plane))
    diameter = 2 * float(bodies.radius[0])
    if size > 0:
        volume = float(np.prod([size] * 3))
    else:
        volume = float(np.prod(np.maximum(np.ptp(bodies.position, axis=0), diameter)))
    # The part of space that the spheres would fill at three times their density.
    sphere = np.pi / 6 * diameter**3
    filled = min(PACKED, 0.05 + 3 * n * sphere / volume)
    # Half the partners of a sphere within 1.5 diameters, and some; never more than all pairs.
    partners = 20 + 0.5 * 8 * 1.5**3 * filled
    pairs = int(min(n * (n - 1) / 2, n * partners)) + n * planes
    contacts = TOUCHING * n + n * min(planes, 3)
    return {"most_pairs": pairs, "most_contacts": min(pairs, contacts)}


def _states(scene: Scene, samples: int, turning: bool) -> list[Array | None]:
    """Room for the states in the kernel's order, the start in row 0; None for those that are not
    told.
    """
    rows: list[Array | None] = []
    for name, width in STATE.items():
        if not turning and name not in MOVING:
            rows.append(None)
            continue
        column = np.empty((samples, len(scene.bodies), width))
        column[0] = getattr(scene.bodies, name)
        rows.append(column)
    return rows


def threads() -> int:
    """The number of threads that REFDEM_THREADS asks for; raises UsageError for what is no number
    of threads.
    """
    said = os.environ.get(THREADS, "1")
    if not said.isdecimal() or not 1 <= int(said) <= MOST_THREADS:
        raise UsageError(f"{THREADS} is {said!r}; expected a whole number from 1 to {MOST_THREADS}")
    return int(said)


def _begins(begun: NDArray[np.int64], told: Array, start: float) -> tuple[Event, ...]:
    """Contacts that begin, in time and then in the order of the threads, which is that of the list;
    none if there were too many.
    """
    if begun.sum() > MOST_EVENTS:
        return ()
    by_thread = [rows[:count] for rows, count in zip(told, begun, strict=True)]
    found = np.concatenate(by_thread)
    in_time = found[np.argsort(found[:, 0], kind="stable")]
    return tuple(Event(start + when, "contact", int(body)) for when, body in in_time.tolist())


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
