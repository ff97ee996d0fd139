"""The transparent engine: small parts in plain Python into which known faults are planted. It is
not discovered among the engines.
"""

import math
from time import perf_counter
from typing import Any

import numpy as np
from numpy.typing import NDArray

from refdem.core import fingerprint
from refdem.core.engine import Engine, Method
from refdem.core.problem import Ensemble, Iteration, Motion, Problem, Request
from refdem.core.trajectory import Cost, Event, Trajectory
from refdem.faults import tangent
from refdem.faults.correct_parts import CORRECT
from refdem.faults.events import advance, first_modes, stored_energy
from refdem.faults.holding import rod_forces
from refdem.faults.iterating import iterated
from refdem.faults.loads import meeting
from refdem.faults.outlines import carried
from refdem.faults.parts import Moving, Parts
from refdem.faults.sphere_on_plane import leaves_its_line, starts_on_plane
from refdem.faults.state import State
from refdem.faults.steps import STEPS
from refdem.faults.world import PRECISIONS, SUPPORTED, start_of, world_of
from refdem.scene import Scene
from refdem.scene.element import Element, Field, Link
from refdem.scene.elements.ball_joint import BallJoint
from refdem.scene.elements.catch import Catch
from refdem.scene.elements.contact import Contact
from refdem.scene.elements.plane import Plane
from refdem.scene.elements.rod import Rod
from refdem.scene.elements.slider import Slider
from refdem.scene.elements.string_over_wheel import StringOverWheel
from refdem.scene.elements.uniform_gravity import UniformGravity
from refdem.scene.shapes import Polyhedron

KEPT = frozenset({"momentum", "angular-momentum", "constraint"})
_VERLET: dict[str, Any] = {
    "control": "step",
    "order": 2,
    "conserves": KEPT,
    "reversible": True,
    "symplectic": True,
    "backward": True,
}
_VERLET |= {"locates_events": True}
SUMMED: dict[str, Any] = {"summed_clock": True}
"""The time of a state is a sum of steps in double precision (faults/steps.py).

For a method in single precision the rounding of this sum is negligible.
"""
METHODS = (
    Method(
        name="euler",
        summary="kick, drift; gyroscopic term explicit",
        control="step",
        order=1,
        conserves=frozenset({"momentum"}),
        **SUMMED,
    ),
    Method(
        name="drift-first",
        summary="drift, kick",
        control="step",
        order=1,
        conserves=frozenset({"momentum"}),
        **SUMMED,
    ),
    Method(
        name="explicit-euler",
        summary="explicit Euler",
        control="step",
        order=1,
        conserves=frozenset({"momentum"}),
        **SUMMED,
    ),
    Method(
        name="verlet",
        summary="velocity Verlet, RATTLE, rotations about principal axes; cut at events",
        **(_VERLET | SUMMED),
    ),
    Method(name="suzuki", summary="five Verlet steps", **(_VERLET | SUMMED | {"order": 4})),
    Method(
        name="rk4",
        summary="classical Runge-Kutta",
        control="step",
        order=4,
        conserves=frozenset({"momentum"}),
        backward=True,
        **SUMMED,
    ),
    Method(name="iterated", summary="maps, iterate by iterate", control="exact"),
    Method(
        name="carried", summary="linear flows, start by start", control="exact", answers="ensemble"
    ),
    Method(
        name="verlet-single",
        summary="velocity Verlet in single precision",
        precision="single",
        **_VERLET,
    ),
    Method(
        name="verlet-tangent",
        summary="velocity Verlet in dual numbers, cut at impacts; it differentiates",
        **(_VERLET | SUMMED | {"backward": False, "differentiates": True}),
    ),
)
LINEAR = frozenset({"spring", "dashpot", "dimension:1"})


class Transparent(Engine):
    """Points, spheres and free bodies; each method is a step function; `parts` can be replaced."""

    name = "transparent"
    title = "Transparent engine"
    methods = METHODS
    licence = "BSD-3-Clause"

    def __init__(self, parts: Parts = CORRECT) -> None:
        self.parts = parts
        self.kept: dict[str, Any] = {}

    def missing(self) -> str | None:
        """None: the transparent engine is always installed."""
        return None

    def version(self) -> str:
        """The version of the transparent engine."""
        return "1"

    def fingerprint(self, method: Method) -> str:
        """The fingerprint of the engine's source."""
        return fingerprint.of_source("faults")

    def unsupported_motion(self, problem: Motion, method: Method) -> str | None:
        """None if the method supports the motion, else the reason."""
        if method.name in ("iterated", "carried"):
            return "cannot run a motion"
        if method.differentiates:
            return tangent.refused(problem.scene)
        return self._unsupported_scene(problem.scene, method)

    def _unsupported_scene(self, scene: Scene, method: Method) -> str | None:
        """None for scenes of the methods that are composed of `Parts`, else the reason."""
        for element in scene.elements:
            if reason := _refused(element):
                return reason
        reason = _rigid_refused(scene) or _corners_refused(scene) or _fixed_refused(scene, method)
        if reason:
            return reason
        if (
            method.name in ("drift-first", "explicit-euler")
            and {"rotation", "constraint"} & scene.features
        ):
            return "the method moves points without constraints only"
        if (
            not method.name.startswith("verlet")
            and {"slider", "contact", "wedge", "piecewise_field", "catch"} & scene.features
        ):
            return "the method finds no events: sliding, contacts, edges of fields, catches"
        if method.name == "suzuki" and any(e.reads_velocity for e in scene.elements):
            return "the method has no forces that depend on velocity"
        if method.name == "euler" and "ball_joint" in scene.features:
            return "the method has no ball joint"
        if method.name == "rk4" and "constraint" in scene.features:
            return "the method has no constraints"
        return None

    def unsupported(self, problem: Problem, method: Method) -> str | None:
        """None for iterations by `iterated`, linear flows by `carried` and supported motions, else
        the reason.
        """
        if isinstance(problem, Ensemble) and method.name == "carried":
            if problem.features <= LINEAR:
                return None
            return "the flow is not linear"
        if isinstance(problem, Iteration) and method.name == "iterated":
            return None
        return super().unsupported(problem, method)

    def run(self, request: Request) -> tuple[Trajectory, Cost]:
        """The trajectory by fixed steps, divided at events, with a sample after every `stride` of
        them.
        """
        begun = perf_counter()
        self.parts.fresh(self.kept)
        if isinstance(request.problem, Iteration):
            return iterated(request.problem, self.parts.maps), Cost(
                seconds=perf_counter() - begun, steps=request.problem.n
            )
        if isinstance(request.problem, Ensemble):
            return carried(request.problem, self.parts.flow), Cost(seconds=perf_counter() - begun)
        method = self.method(request.method)
        if method.differentiates:
            return tangent.run(request, self.parts)
        scene = request.problem.scene
        times = request.problem.times
        number = PRECISIONS[method.precision]
        world = world_of(scene, number)
        sense = math.copysign(1.0, request.problem.interval)
        motion = Moving(world, self.parts, sense)
        state = start_of(scene, world, self.parts.to_body)
        h = number(request.signed_step)
        state.t = float(times[0])
        first_modes(motion, state, h)
        load = self.parts.loads(world, state, self.parts)
        record = Recording(motion, len(times), float(times[0]), request.problem.interval)
        record.row(0, state)
        for count in range(1, len(times)):
            for _ in range(request.stride):
                state, load = advance(motion, STEPS[method.name], state, load, h)
            state = record.row(count, state)
        steps = request.stride * (len(times) - 1)
        return record.trajectory(), Cost(seconds=perf_counter() - begun, steps=steps)


def _refused(element: Element) -> str | None:
    """None for an element that the engine supports with these fields, else the reason."""
    if isinstance(element, Link) and element.has_force:
        if element.has_central_anchors():
            return None
        return f"a {element.kind} between points of bodies other than their centres"
    if not isinstance(element, (Field, *SUPPORTED)):
        return f"the transparent engine has no {element.kind}"
    if (
        isinstance(element, Rod)
        and not any(element.anchor_a)
        and not (element.b >= 0 and any(element.anchor_b))
    ):
        return None
    if isinstance(element, BallJoint) and element.b < 0:
        if sum(x != 0 for x in element.anchor_a) <= 1:
            return None
        return "a joint off the principal axes"
    if isinstance(element, BallJoint | Catch | Rod | Slider) and (
        any(element.anchor_a) or element.b >= 0
    ):
        return f"a {element.kind} that does not join a centre to the world"
    if isinstance(element, StringOverWheel) and element.radius > 0:
        return "a string over a wheel that has a size"
    if isinstance(element, Contact) and element.law == "hertz" and element.tangential_stiffness > 0:
        return "the transparent engine has no tangential spring under Hertz's law"
    return None


NEAR = 2.0**-20
"""Smallest gap between a sphere and a plane, relative to the radius, that counts as apart in any
precision.
"""


def _rigid_refused(scene: Scene) -> str | None:
    """None without a rigid law, and for scenes of it that the engine supports, else the reason.

    These are any number of colliding spheres with equal moments of inertia, or one that lies on a
    plane, on which only gravity acts; and a single polyhedron.
    """
    if "contact:rigid" not in scene.features:
        return None
    if not all(isinstance(element, Contact | Plane | UniformGravity) for element in scene.elements):
        return "the transparent engine has no rigid contact under forces other than gravity"
    if _is_smooth_corner(scene):
        return None
    moments = scene.bodies.inertia
    is_round = scene.bodies.radius > 0
    if not is_round.all() or np.any(moments != moments[:, :1]) or not moments.all():
        return "the transparent engine has rigid contacts of spheres with equal moments only"
    if scene.bodies.fixed.any():
        return "the transparent engine has no rigid contact with a fixed body"
    if starts_on_plane(scene):
        if leaves_its_line(scene):
            return "a slip that turns"
        return None
    if scene.all(UniformGravity) and _is_on_plane(scene):
        return (
            "the transparent engine has no rigid contact with a plane from the start under gravity"
        )
    return None


def _is_smooth_corner(scene: Scene) -> bool:
    """True if one polyhedron in free flight collides with planes under the rigid law, without
    friction.
    """
    law = scene.all(Contact)[0]
    is_smooth = law.law == "rigid" and law.friction == 0 and not scene.all(UniformGravity)
    return is_smooth and [type(shape) for shape in scene.bodies.shape] == [Polyhedron]


def _is_on_plane(scene: Scene) -> bool:
    """True if a sphere touches a plane at the start, or has a gap of less than NEAR radii."""
    bodies = scene.bodies
    for plane in scene.all(Plane):
        height = (bodies.position - np.array(plane.point)) @ np.array(plane.normal)
        if np.any(height <= bodies.radius * (1 + NEAR)):
            return True
    return False


def _fixed_refused(scene: Scene, method: Method) -> str | None:
    """None without a fixed body, and for the methods that do not move it, else the reason."""
    if not scene.bodies.fixed.any() or method.name.startswith("verlet"):
        return None
    return "the method moves every body"


def _corners_refused(scene: Scene) -> str | None:
    """None without polyhedra that can touch, and for a single one whose corners slide on planes or
    collide with them in free flight without friction, else the reason.
    """
    if not scene.all(Contact) or not any(
        isinstance(shape, Polyhedron) for shape in scene.bodies.shape
    ):
        return None
    law = scene.all(Contact)[0]
    spring = law.friction > 0 and (law.tangential_stiffness > 0 or law.branch != "R")
    is_known = law.law == "linear" or _is_smooth_corner(scene)
    if len(scene.bodies) > 1 or spring or not is_known:
        return "the transparent engine has no such contact of polyhedra"
    return None


class Recording:
    """The rows of a trajectory in double precision."""

    def __init__(self, motion: Moving, samples: int, start: float, interval: float) -> None:
        bodies = len(motion.world.mass)
        self.motion = motion
        self.start = start
        self.interval = interval
        self.t = np.zeros(samples)
        self.columns: dict[str, Any] = {
            name: np.zeros((samples, bodies, width)) for name, width in WIDTHS.items()
        }
        self.columns["attitude"][..., 0] = 1.0
        self.channels: dict[str, NDArray[np.float64]] = {}
        if motion.world.rods and all(rod.b < 0 for rod in motion.world.rods):
            self.channels["rod_force"] = np.zeros((samples, len(motion.world.rods)))
        if motion.world.law is not None and not motion.world.is_rigid:
            self.channels |= {name: np.zeros(samples) for name in ("overlap", "contact_force")}
        springs = motion.world.law is not None and motion.world.law.tangential_stiffness > 0
        if (
            motion.world.sliders or motion.world.walls or motion.world.law is not None
        ) and not springs:
            self.channels["dissipated_work"] = np.zeros(samples)

    def row(self, count: int, state: State) -> State:
        """Writes one sample and returns the state with which the run continues."""
        parts = self.motion.parts
        world = self.motion.world
        state = parts.output(state)
        self.t[count] = parts.clock(self.start, count, self.interval)
        for i in range(len(world.mass)):
            self.columns["position"][count, i] = state.r[i]
            self.columns["velocity"][count, i] = state.v[i]
            if world.turns[i]:
                self.columns["attitude"][count, i] = state.q[i]
                self.columns["omega"][count, i] = parts.to_space(state.q[i], state.w[i])
        if "rod_force" in self.channels:
            self.channels["rod_force"][count] = rod_forces(self.motion, state)
        work = state.work
        if "overlap" not in self.channels:
            pairs = range(0)
        else:
            pairs = range(len(world.pairs))
        for number in pairs:
            _, depth, rate, _ = meeting(world, state, parts, number)
            if state.acting[number]:
                push = parts.normal_force(world.law, depth, rate)
            else:
                push = 0.0
                # The potential counts k d^(n+1)/(n+1) for every overlap d > 0, also after the
                # contact has ended, when this energy is lost: it is not yet part of the dissipated
                # work.
                work -= stored_energy(world, depth)
            self.channels["overlap"][count] = max(self.channels["overlap"][count], depth)
            self.channels["contact_force"][count] = max(self.channels["contact_force"][count], push)
        if "dissipated_work" in self.channels:
            self.channels["dissipated_work"][count] = work
        return state

    def trajectory(self) -> Trajectory:
        """The recorded samples as a trajectory."""
        events = tuple(
            Event(time=time, kind=kind, body=body) for time, kind, body in self.motion.events
        )
        return Trajectory(t=self.t, **self.columns, channels=self.channels, events=events)


WIDTHS = {"position": 3, "velocity": 3, "attitude": 4, "omega": 3}
