"""A convex body that falls on a plane, with linear contact at its corners, from event to event
(kernels/tumbling_body.c).

In body axes, with the rotation matrix R of q, omega w and velocity V = R^T v:

    q' = q w/2,   J w' = (J w) x w + sum a x F,   V' = V x w + R^T g + sum F/m,   r' = R V.

A corner a that presses has F = N n - mu N s/|s|, N = k d + c d', with its overlap d and slip s.
"""

from typing import Any

import numpy as np

from refdem.core.engine import Method
from refdem.core.problem import Motion, Problem, Request
from refdem.core.trajectory import Event, Trajectory
from refdem.errors import EngineError
from refdem.mechanics.quaternion import conjugate, rotated
from refdem.scene import Polyhedron, Scene
from refdem.scene.elements.contact import Contact
from refdem.scene.elements.plane import Plane
from refdem.scene.elements.uniform_gravity import UniformGravity
from refdem.solvers import _single_point as single
from refdem.solvers._kernel_solver import (
    KernelCall,
    KernelSolver,
    Struct,
    samples,
    turning_states,
)
from refdem.solvers._scene_pattern import ANY, ONE, ScenePattern

FAMILY = "tumbling_body"
MOST_CORNERS = 32
"""Largest number of corners of a body, the size of the kernel's tables."""
MOST_EVENTS = 4096
"""Rows of the table of events, many more than the impacts of a body that comes to rest on a slope.
"""
CHANNELS = ("contacts", "overlap", "contact_force")
KINDS = {0: "contact", 1: "release"}
"""Kind of an event by the mode of the corner before it: 0 off the plane, 1 pressing."""


class TumblingBody(KernelSolver):
    """Contact and release of every corner are located to round-off; forces are not regularised."""

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

    pattern = ScenePattern(
        elements={Contact: ONE, Plane: ONE, UniformGravity: ANY},
        bodies=ONE,
        shape=Polyhedron,
        law="linear",
        has_inertia=True,
        irreversible="its kernel goes from event to event forward only",
    )

    def unsupported_values(self, problem: Motion) -> str | None:
        """None for a body whose corners slide as long as they press on the plane, else the
        reason.
        """
        scene = problem.scene
        shape: Any = scene.bodies.shape[0]
        if not 0 < len(shape.vertices) <= MOST_CORNERS:
            return f"{len(shape.vertices)} corners; expected 1 to {MOST_CORNERS}"
        return _law_unsupported(scene.all(Contact)[0]) or self._never_held(problem)

    def _never_held(self, problem: Motion) -> str | None:
        """None if no pressing corner comes to a stop, else the reason.

        A trial run detects this. Without a tangential spring the law does not determine the static
        friction at such a corner.
        """
        if not problem.scene.all(Contact)[0].friction > 0:
            return None
        if _call(problem).made(FAMILY) < 0:
            return (
                "a corner that presses comes to a stop: friction without a tangential spring does"
                " not say what holds it"
            )
        return None

    def prepare(self, request: Request) -> KernelCall:
        """Body, plane and law; arrays for events, channels and states."""
        return _call(request.problem)

    def finish(self, request: Request, call: KernelCall, status: int) -> Trajectory:
        """States, contact channels and events; raises EngineError if a pressing corner comes to a
        stop.
        """
        if status < 0:
            raise EngineError(
                "tumbling-body: a corner that presses comes to a stop; expected a tangential"
                " spring, or less friction"
            )
        # A row: attitude (4), omega (3) and velocity (3) in body axes, position (3), work (1).
        event_rows, channel_rows, states = call.outputs
        # v = R V and omega in space axes R w, with the rotation matrix R of q/|q|.
        attitude = states[:, :4] / np.linalg.norm(states[:, :4], axis=1, keepdims=True)
        columns = {
            "position": states[:, 10:13],
            "velocity": rotated(attitude, states[:, 7:10]),
            "attitude": attitude,
            "omega": rotated(attitude, states[:, 4:7]),
        }
        channels = dict(zip(CHANNELS, channel_rows.T.copy(), strict=True))
        channels["dissipated_work"] = states[:, 13].copy()
        # The kernel's status is the number of events that it has written.
        events = []
        for time, mode, _ in event_rows[:status]:
            if mode in KINDS:
                events.append(Event(time=float(time), kind=KINDS[int(mode)], body=0))
        return Trajectory(
            t=request.problem.times,
            channels=channels,
            events=tuple(events),
            **turning_states(request.problem.scene.bodies, columns),
        )


def _law_unsupported(law: Contact) -> str | None:
    """None for frictionless corners or sliding friction at the corner itself, which may not pull,
    else the reason.
    """
    if law.friction > 0 and (law.tangential_stiffness > 0 or law.branch != "R"):
        return "friction on corners with a tangential spring, or away from the corner"
    if law.cutoff == "zero_force" or law.damping == 0:
        return None
    return "corners that pull"


def _call(problem: Problem) -> KernelCall:
    """The kernel's call for a motion; its status is the number of events, or negative if it stops
    before the last sample.
    """
    scene = problem.scene
    t = problem.times
    bodies = scene.bodies
    # w = R^T omega and V = R^T v.
    to_body = conjugate(bodies.attitude[0])
    omega_body = rotated(to_body, bodies.omega[0])
    velocity_body = rotated(to_body, bodies.velocity[0])
    start = (bodies.attitude[0], omega_body, velocity_body, bodies.position[0])
    states = np.zeros((len(t), 14))
    states[0, :13] = np.concatenate(start)
    return KernelCall(
        function="refdem_tumbling_body_run",
        inputs=(_struct(scene),),
        clock=(*samples(t), MOST_EVENTS),
        outputs=(np.zeros((MOST_EVENTS, 3)), np.zeros((len(t), 3)), states),
    )


def _struct(scene: Scene) -> Struct:
    """Body, plane and contact law as the kernel's struct."""
    bodies = scene.bodies
    law = scene.all(Contact)[0]
    plane = scene.all(Plane)[0]
    shape: Any = bodies.shape[0]
    fields = {
        "inertia": bodies.inertia[0],
        "gravity": single.gravity(scene),
        "plane": np.array([*plane.point, *plane.normal]),
        "corner": np.array(shape.vertices, float),
        "stiffness": law.stiffness,
        "damping": law.damping,
        "friction": law.friction,
        "mass": bodies.mass[0],
        "corners": len(shape.vertices),
    }
    return Struct(FAMILY, "refdem_tumbling_body", fields)


METHOD = TumblingBody()
