"""Rigid spheres with each other and with planes, from impact to impact (kernels/impacts.c)."""

import numpy as np
from numpy.typing import NDArray

from refdem.core.engine import Method
from refdem.core.problem import Motion, Request
from refdem.core.trajectory import Event, Trajectory
from refdem.errors import EngineError
from refdem.kernels import load
from refdem.scene import Bodies, Sphere
from refdem.scene.elements.contact import Contact
from refdem.scene.elements.plane import Plane
from refdem.solvers._kernel_solver import KernelCall, KernelSolver, Struct, samples
from refdem.solvers._scene_pattern import ANY, ONE, SOME, ScenePattern

Array = NDArray[np.float64]
FAMILY = "impacts"
FEW = 16
"""Spheres up to which every pair is looked at; measured."""
MOST_EVENTS = 100_000
"""Impacts that are told; of a motion with more none is, so that those told are all."""
LONGEST = 100_000_000
"""Impacts after which a run ends: spheres that lose energy may meet without end in finite time."""
ROUNDED = 8 * 2.0**-53
"""Part of a sum of radii by which spheres may overlap at the start: places are rounded."""


class Impacts(KernelSolver):
    """Straight lines and impulses; nothing is approximated, whatever the number of spheres."""

    claims = Method(
        name="impacts",
        summary="event-driven: straight lines from impact to impact, impulses in closed form",
        control="exact",
        conserves=frozenset({"momentum", "angular-momentum", "energy"}),
        locates_events=True,
        cost_rank=5,
    )
    kernels = (FAMILY,)

    pattern = ScenePattern(
        elements={Contact: ONE, Plane: ANY},
        bodies=SOME,
        shape=Sphere,
        law="rigid",
        may_be_fixed=True,
        irreversible="impacts have forgotten where they came from",
    )

    def unfit(self, problem: Motion) -> str | None:
        """None for spheres that start apart and turn alike about all axes."""
        scene = problem.scene
        bodies = scene.bodies
        if np.any(bodies.inertia != bodies.inertia[:, :1]):
            return "a body whose moments of inertia differ: its angular velocity is not constant"
        still = bodies.fixed & (np.any(bodies.velocity, axis=1) | np.any(bodies.omega, axis=1))
        if still.any():
            return f"body {int(np.flatnonzero(still)[0])} is fixed, and moves or turns"
        law = scene.all(Contact)[0]
        points = (bodies.inertia[:, 0] == 0) & ~bodies.fixed
        if law.friction > 0 and points.any():
            return "friction on a body without moments of inertia"
        return _overlapping(bodies, scene.all(Plane))

    def prepare(self, request: Request) -> KernelCall:
        """Bodies, planes, law and clock; the start is in its row."""
        problem = request.problem
        scene = problem.scene
        bodies = scene.bodies
        law = scene.all(Contact)[0]
        planes = [[*plane.point, *plane.normal] for plane in scene.all(Plane)]
        held = bodies.fixed | (bodies.inertia[:, 0] == 0)
        struct = Struct(
            FAMILY,
            "refdem_impacts",
            {
                "bodies": len(bodies),
                "planes": len(planes),
                "few": FEW,
                "mass": np.where(bodies.fixed, np.inf, bodies.mass),
                "inertia": np.where(held, np.inf, bodies.inertia[:, 0]),
                "radius": bodies.radius,
                "plane": np.array(planes).reshape(-1, 6),
                "restitution": law.restitution,
                "tangential_restitution": law.slip_restitution,
                "friction": law.friction,
                "period": 0.0,
                "gravity": [0.0, 0.0, 0.0],
            },
        )
        count = len(problem.times)
        states = []
        for name in ("position", "velocity", "omega", "attitude"):
            start = getattr(bodies, name)
            rows = np.empty((count, *start.shape))
            rows[0] = start
            states.append(rows)
        room = np.empty(load(FAMILY).lib.refdem_impacts_room(len(bodies)))
        events = np.empty((MOST_EVENTS, 3))
        return KernelCall(
            function="refdem_impacts_run",
            inputs=(struct,),
            # Counted from the start: impacts are as exact whenever that is.
            clock=(*samples(problem.times - problem.times[0]), MOST_EVENTS, LONGEST),
            outputs=(room, events, np.empty(count), *states),
        )

    def finish(self, request: Request, call: KernelCall, status: int) -> Trajectory:
        """States, the energy lost, and the impacts as contacts of their first bodies."""
        _, table, work, position, velocity, omega, attitude = call.outputs
        if status < 0:
            t = request.problem.times[-status]
            raise EngineError(
                f"impacts: {LONGEST} impacts did not lead to t = {t:.6g} s: spheres that lose"
                " energy meet without end in finite time"
            )
        start = request.problem.times[0]
        told = []
        if status <= MOST_EVENTS:
            for time, body, _ in table[:status]:
                told.append(Event(time=float(start + time), kind="contact", body=int(body)))
        return Trajectory(
            t=request.problem.times,
            position=position,
            velocity=velocity,
            attitude=attitude,
            omega=omega,
            channels={"dissipated_work": work},
            events=tuple(told),
        )


def _overlapping(bodies: Bodies, planes: list[Plane]) -> str | None:
    """None if no spheres overlap at the start and none reaches behind a plane."""
    for i in range(len(bodies)):
        apart = np.linalg.norm(bodies.position[i + 1 :] - bodies.position[i], axis=1)
        reach = bodies.radius[i + 1 :] + bodies.radius[i]
        if np.any(apart < reach * (1 - ROUNDED)):
            return f"body {i} overlaps another one at the start"
    for plane in planes:
        height = (bodies.position - np.array(plane.point)) @ np.array(plane.normal)
        behind = (height < bodies.radius * (1 - ROUNDED)) & ~bodies.fixed
        if np.any(behind):
            return f"body {int(np.flatnonzero(behind)[0])} reaches behind a plane at the start"
    return None


METHOD = Impacts()
