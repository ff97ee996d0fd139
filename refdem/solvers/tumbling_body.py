"""A convex body that falls on a plane: linear contact at its corners, from event to event
(kernels/tumbling_body.c).
"""

from time import perf_counter
from typing import Any

import numpy as np

from refdem.core.engine import Method
from refdem.core.problem import Motion, Request
from refdem.core.trajectory import Cost, Event, Trajectory
from refdem.errors import EngineError
from refdem.kernels import load, pointer
from refdem.mechanics.quaternion import conjugate, rotated
from refdem.scene import Polyhedron, Scene
from refdem.scene.elements.contact import Contact
from refdem.scene.elements.plane import Plane
from refdem.scene.elements.uniform_gravity import UniformGravity
from refdem.solvers import _single_point as single
from refdem.solvers._single_point import Array
from refdem.solvers.solver import Solver

FAMILY = "tumbling_body"
MOST_CORNERS = 32
MOST_EVENTS = 4096
CHANNELS = ("contacts", "overlap", "contact_force")
KINDS = {0: "contact", 1: "release"}
"""Of an event, by the corner's mode before it: off, or pressing."""


class TumblingBody(Solver):
    """Contact and release of every corner are found to the last bit; nothing is fitted, nothing is
    smoothed.
    """

    claims = Method(
        name="tumbling-body",
        summary=(
            "convex body on a plane: Taylor series of order 20 from event to event of its corners,"
            " steps to round-off"
        ),
        control="exact",
        derived={
            "attitude": (
                "the attitude is divided by its length when it is handed out, so that it is"
                " always 1"
            )
        },
        conserves=frozenset({"energy"}),
        cost_rank=6,
    )
    kernels = (FAMILY,)

    def unsupported(self, problem: Motion) -> str | None:
        """None for one polyhedron under the linear law, whose corners slide as long as they press,
        over one plane.
        """
        scene = problem.scene
        others = [
            e.kind for e in scene.elements if not isinstance(e, Contact | Plane | UniformGravity)
        ]
        if others:
            return f"{others[0]} beside contact, a plane and gravity"
        laws = scene.all(Contact)
        bodies = scene.bodies
        if len(laws) != 1 or len(scene.all(Plane)) != 1 or len(bodies) != 1 or bodies.fixed.any():
            return "not one free body over one plane under one contact law"
        if (
            not isinstance(bodies.shape[0], Polyhedron)
            or not 0 < len(bodies.shape[0].vertices) <= MOST_CORNERS
        ):
            return f"not a polyhedron of at most {MOST_CORNERS} corners"
        if not bodies.inertia[0].min() > 0:
            return "no inertia about one of the axes"
        return _law_unsupported(laws[0]) or _never_held(problem)

    def run(self, request: Request) -> tuple[Trajectory, Cost]:
        """States, contact channels and events; raises EngineError where a corner that presses comes
        to a stop.
        """
        scene = request.problem.scene
        times = np.ascontiguousarray(request.problem.times)
        states, channels, events, cost = _followed(scene, times)
        if events is None:
            raise EngineError(
                "tumbling-body: a corner that presses comes to a stop; expected a tangential"
                " spring, or less friction"
            )
        attitude = states[:, :4] / np.linalg.norm(states[:, :4], axis=1, keepdims=True)
        columns: dict[str, Any] = {
            "position": states[:, 10:13],
            "velocity": rotated(attitude, states[:, 7:10]),
            "attitude": attitude,
            "omega": rotated(attitude, states[:, 4:7]),
        }
        rows: dict[str, Any] = {}
        for name, values in columns.items():
            # The first row is the start as it came, not as it is rounded here.
            values[0] = getattr(scene.bodies, name)[0]
            rows[name] = np.ascontiguousarray(values[:, None])
        shown = dict(zip(CHANNELS, channels.T.copy(), strict=True))
        shown["dissipated_work"] = states[:, 13].copy()
        told = []
        for t, mode, _ in events:
            if mode in KINDS:
                told.append(Event(time=float(t), kind=KINDS[int(mode)], body=0))
        return Trajectory(t=times, channels=shown, events=tuple(told), **rows), cost


def _law_unsupported(law: Contact) -> str | None:
    if law.law != "linear":
        return f"contact law {law.law}"
    if law.friction > 0 and (law.tangential_stiffness > 0 or law.branch != "R"):
        return "friction on corners with a tangential spring, or away from the corner"
    if law.cutoff == "zero_force" or law.damping == 0:
        return None
    return "corners that pull"


def _never_held(problem: Motion) -> str | None:
    """None if no corner that presses comes to a stop, where friction without a tangential spring
    would have to hold it.
    """
    if not problem.scene.all(Contact)[0].friction > 0:
        return None
    if problem.interval < 0:
        return "friction runs forward only"
    _, _, events, _ = _followed(problem.scene, np.ascontiguousarray(problem.times))
    if events is None:
        return (
            "a corner that presses comes to a stop: friction without a tangential spring does not"
            " say what holds it"
        )
    return None


def _followed(scene: Scene, times: Array) -> tuple[Array, Array, Array | None, Cost]:
    """States (T, 14), channels (T, 3) and events (E, 3) of the kernel; no events where it does not
    reach the last sample.
    """
    begun = perf_counter()
    bodies = scene.bodies
    law = scene.all(Contact)[0]
    plane = scene.all(Plane)[0]
    kernel = load(FAMILY)
    shape: Any = bodies.shape[0]
    back = conjugate(bodies.attitude[0])
    states = np.zeros((len(times), 14))
    channels = np.zeros((len(times), 3))
    events = np.zeros((MOST_EVENTS, 3))
    turning = rotated(back, bodies.omega[0])
    moving = rotated(back, bodies.velocity[0])
    states[0, :13] = np.concatenate([bodies.attitude[0], turning, moving, bodies.position[0]])
    given: dict[str, Any] = {
        "inertia": bodies.inertia[0],
        "gravity": single.gravity(scene),
        "plane": np.array([*plane.point, *plane.normal]),
        "corner": np.array(shape.vertices, float),
    }
    # The arrays must live as long as the struct, which does not keep them.
    kept = {
        name: pointer(FAMILY, np.ascontiguousarray(column, float)) for name, column in given.items()
    }
    numbers = {
        "stiffness": law.stiffness,
        "damping": law.damping,
        "friction": law.friction,
        "mass": bodies.mass[0],
        "corners": len(shape.vertices),
    }
    struct = kernel.ffi.new("refdem_tumbling_body *", {**kept, **numbers})
    event, channel, out = (
        pointer(FAMILY, array, output=True) for array in (events, channels, states)
    )
    started = perf_counter()
    count = kernel.lib.refdem_tumbling_body_run(
        struct, len(times), pointer(FAMILY, times), MOST_EVENTS, event, channel, out
    )
    cost = Cost(seconds=perf_counter() - started, setup=started - begun)
    if count >= 0:
        reached = events[:count]
    else:
        reached = None
    return states, channels, reached, cost


METHOD = TumblingBody()
