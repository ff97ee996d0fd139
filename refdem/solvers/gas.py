"""Many equal spheres, smooth or rough, in a periodic box, between planes or in unbounded space:
velocity Verlet with a neighbour list (kernels/gas.c).

    v += h/2 a,   r += h v,   v += h/2 a,   spins alike        (Swope et al. 1982)

A run uses the number of threads of its request, 1 by default, because worker processes already
share the cores. The environment variable REFDEM_THREADS sets a larger number. The result is the
same to the last bit for any number of threads.
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
from refdem.solvers._particles import MANY
from refdem.solvers._scene_pattern import ANY, ONE, OPTIONAL, Count, ScenePattern

Array = NDArray[np.float64]

STATE = {"position": 3, "velocity": 3, "omega": 3, "attitude": 4}
"""Quantities of the state in the kernel's order, with their lengths."""
MOVING = ("position", "velocity")
"""Quantities that the kernel also integrates for spheres that do not rotate."""
FEWEST = 2.5
"""Smallest edge of a box, in diameters. A body then touches at most one image of another at a time,
and the neighbour list has a skin.
"""
PACKED = 0.74048
"""Packing fraction of the closest packing of spheres, which limits the number of pairs within a
diameter and a skin of half a diameter.
"""
TOUCHING = 4
"""Capacity for contacts of a body with bodies later in the list; random close packing has 3."""
MOST_EVENTS = 100_000
"""Largest number of contact events that are reported. A motion with more of them reports none, so
that a list is always complete.
"""


NO_THREADS = 2
"""Status of the kernel if it cannot start its threads."""
ASTRAY = 3
"""Status of the kernel if a body is so far away that the motion must have diverged."""
THREADS = "REFDEM_THREADS"
"""Name of the environment variable."""
MOST_THREADS = 64
"""Largest number of threads (MOST_THREADS in kernels/gas_team.h)."""


class Gas(KernelSolver):
    """Second order in energy: a contact that begins inside a step adds an error for the rest of
    that step, whose sign is random.

    First order with friction: a tangential spring that exceeds Coulomb's limit is shortened at the
    end of the step.
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
        threads=True,
        cost_rank=20,
    )
    kernels = ("gas",)

    pattern = ScenePattern(
        elements={Contact: ONE, Plane: ANY, PeriodicBox: OPTIONAL},
        bodies=Count(2),
        law="linear",
    )

    def unsupported_values(self, problem: Motion) -> str | None:
        """None for many equal spheres with one kind of bounds, and a tangential spring if there is
        friction, else the reason.
        """
        scene = problem.scene
        return (
            _bodies_unsupported(scene) or _bounds_unsupported(scene) or _contact_unsupported(scene)
        )

    def prepare(self, request: Request) -> KernelCall:
        """The gas and its threads; arrays for the kernel's work space, events, channels and states,
        with the start in row 0.
        """
        scene = request.problem.scene
        count = len(request.problem.times)
        fields = _fields(scene)
        struct = Struct("gas", "refdem_gas", fields)
        n_threads = min(max(request.threads, threads()), len(scene.bodies))
        n_bytes = load("gas").lib.refdem_gas_room(struct.address, n_threads)
        work_space = np.empty(n_bytes, np.uint8)
        event_counts = np.zeros(n_threads, np.int64)
        event_rows = np.empty((n_threads, MOST_EVENTS, 2))
        channels = np.empty((count, 2))
        states = _states(scene, count, bool(fields["turning"]))
        return KernelCall(
            function="refdem_gas_run",
            inputs=(struct, n_threads),
            clock=(*steps_to_samples(request), MOST_EVENTS),
            outputs=(work_space, event_counts, event_rows, channels, *states),
            steps=steps_of(request),
        )

    def finish(self, request: Request, call: KernelCall, status: int) -> Trajectory:
        """States at the samples, number of contacts, dissipated work, and the events of contacts
        that start.
        """
        t = request.problem.times
        _, event_counts, event_rows, channel_rows, *states = call.outputs
        if status == NO_THREADS:
            raise EngineError(
                f"gas: {len(event_counts)} threads, asked for by the request or {THREADS}, could"
                " not be had"
            )
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
        contacts, work = channel_rows.T.copy()
        channels = {"contacts": contacts, "dissipated_work": work}
        events = _contact_events(event_counts, event_rows, float(t[0]))
        columns: dict[str, Array] = {}
        for name, rows in zip(STATE, states, strict=True):
            if rows is not None:
                columns[name] = rows
        return _trajectory(request.problem.scene, t, columns, channels, events)


def _bodies_unsupported(scene: Scene) -> str | None:
    """None if all bodies are equal spheres, else the reason."""
    bodies = scene.bodies
    if not bodies.radius.all():
        return "bodies that are no spheres"
    if np.ptp(bodies.radius) or np.ptp(bodies.mass) or np.ptp(bodies.inertia):
        return "spheres that differ"
    return None


def _bounds_unsupported(scene: Scene) -> str | None:
    """None for a large enough box, or planes, or the open, and more than a few bodies, else the
    reason.
    """
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


def _contact_unsupported(scene: Scene) -> str | None:
    """None if friction has a tangential spring and one lever, else the reason."""
    law = scene.all(Contact)[0]
    if law.has_two_levers:
        return "friction whose slip and torque have different levers"
    if law.friction > 0 and law.tangential_stiffness == 0:
        return "friction without a tangential spring"
    return None


def _fields(scene: Scene) -> dict[str, Any]:
    """The fields of the kernel's struct `refdem_gas`: the bodies, which are all alike, the walls,
    the box and the law.
    """
    bodies = scene.bodies
    law = scene.all(Contact)[0]
    walls = [(*plane.point, *plane.normal) for plane in scene.all(Plane)]
    box_size = 0.0
    for box in scene.all(PeriodicBox):
        box_size = box.size
    # Frictionless spheres keep their spins, so that attitudes are integrated only if some sphere
    # spins.
    turning = law.friction > 0 or bool(bodies.omega.any())
    of_spheres = {
        "bodies": len(bodies),
        "turning": turning,
        "mass": bodies.mass[0],
        "inertia": bodies.inertia[0, 0],
        "diameter": 2 * float(bodies.radius[0]),
    }
    of_bounds = {"planes": len(walls), "plane": np.array(walls, float), "size": box_size}
    of_law = {
        "stiffness": law.stiffness,
        "damping": law.damping,
        "tangential_stiffness": law.tangential_stiffness,
        "friction": law.friction,
        "branch": law.torque_shortening,
        "no_pull": law.cutoff == "zero_force",
    }
    return _capacities(scene, box_size) | of_spheres | of_bounds | of_law


def _capacities(scene: Scene, box_size: float) -> dict[str, int]:
    """Capacities of the kernel's lists: the most pairs and contacts at three times the initial
    density, at most closest packing.

    `box_size` [m] is the edge of the box, or 0 without one.
    """
    bodies = scene.bodies
    n = len(bodies)
    planes = len(scene.all(Plane))
    diameter = 2 * float(bodies.radius[0])
    if box_size > 0:
        volume = float(np.prod([box_size] * 3))
    else:
        volume = float(np.prod(np.maximum(np.ptp(bodies.position, axis=0), diameter)))
    # Packing fraction at three times the initial density, 3 n (pi/6 d^3)/V.
    sphere = np.pi / 6 * diameter**3
    packing = min(PACKED, 0.05 + 3 * n * sphere / volume)
    # Half of the neighbours of a sphere, since each pair is listed once. A ball with a radius of
    # 1.5 diameters has the volume of 8 1.5^3 spheres and holds `packing` times as many. 20 more
    # allow for fluctuations.
    later_neighbours = 20 + 0.5 * 8 * 1.5**3 * packing
    pairs = int(min(n * (n - 1) / 2, n * later_neighbours)) + n * planes
    contacts = TOUCHING * n + n * min(planes, 3)
    return {"most_pairs": pairs, "most_contacts": min(pairs, contacts)}


def _states(scene: Scene, samples: int, turning: bool) -> list[Array | None]:
    """Arrays for the states in the kernel's order, with the start in row 0; None for quantities
    that it does not write.
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
    """The number of threads from REFDEM_THREADS; raises UsageError if it is not a whole number from
    1 to 64.
    """
    text = os.environ.get(THREADS, "1")
    if not text.isdecimal() or not 1 <= int(text) <= MOST_THREADS:
        raise UsageError(f"{THREADS} is {text!r}; expected a whole number from 1 to {MOST_THREADS}")
    return int(text)


def _contact_events(
    counts: NDArray[np.int64], rows_by_thread: Array, start: float
) -> tuple[Event, ...]:
    """Events of contacts that start, in time; none if there were too many to report all.

    Equal times keep the order of threads, which is that of the list, so the result does not depend
    on their number.
    """
    if counts.sum() > MOST_EVENTS:
        return ()
    by_thread = [of_thread[:count] for of_thread, count in zip(rows_by_thread, counts, strict=True)]
    rows = np.concatenate(by_thread)
    in_time = rows[np.argsort(rows[:, 0], kind="stable")]
    return tuple(Event(start + time, "contact", int(body)) for time, body in in_time.tolist())


def _trajectory(
    scene: Scene,
    t: Array,
    states: dict[str, Array],
    channels: dict[str, Array],
    events: tuple[Event, ...],
) -> Trajectory:
    """The trajectory from the kernel's columns; spheres that it does not rotate keep attitude and
    omega = 0.
    """
    shape = (len(t), len(scene.bodies))
    defaults: dict[str, Any] = {
        "attitude": np.broadcast_to(scene.bodies.attitude, (*shape, 4)),
        "omega": np.broadcast_to(np.zeros(3), (*shape, 3)),
    }
    return Trajectory(t=t, channels=channels, events=events, **{**defaults, **states})


METHOD = Gas()
