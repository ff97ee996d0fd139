"""Rigid spheres that collide with each other and with planes, from impact to impact
(kernels/impacts.c; Alder and Wainwright 1959).
"""

import numpy as np
from numpy.typing import NDArray

from refdem.core.engine import Method
from refdem.core.problem import Motion, Request
from refdem.core.trajectory import Event, Trajectory
from refdem.errors import EngineError
from refdem.kernels import load
from refdem.mechanics.neighbours import near_pairs
from refdem.scene import Scene, Sphere
from refdem.scene.elements.contact import Contact
from refdem.scene.elements.periodic_box import PeriodicBox
from refdem.scene.elements.plane import Plane
from refdem.scene.elements.uniform_gravity import UniformGravity
from refdem.solvers._kernel_solver import KernelCall, KernelSolver, Struct, samples
from refdem.solvers._scene_pattern import ANY, ONE, OPTIONAL, SOME, ScenePattern

Array = NDArray[np.float64]
FAMILY = "impacts"
FEW = 8
"""Largest number of spheres for which every pair is tested. A cell list is faster from 4 spheres
on, and 3 times as fast at 16, but orders simultaneous impacts in another way.
"""
MOST_EVENTS = 100_000
"""Largest number of impacts that a trajectory lists. A motion with more of them lists none, so that
a list is always complete.
"""
LONGEST = 100_000_000
"""Number of impacts after which a run ends; they take minutes."""
FEWEST_DIAMETERS = 5 * (1 + 2.0**-19)
"""Smallest edge of a periodic box, in largest diameters: 5 cells with the kernel's margin."""
ROUNDED = 8 * 2.0**-53
"""Part of a sum of radii by which spheres may overlap at the start by rounding of positions."""


class Impacts(KernelSolver):
    """Straight lines or parabolas between impulses, without approximation, for any number of
    spheres.
    """

    claims = Method(
        name="impacts",
        summary="event-driven: lines or parabolas from impact to impact, impulses in closed form",
        control="exact",
        conserves=frozenset({"momentum", "angular-momentum", "energy"}),
        locates_events=True,
        cost_rank=5,
    )
    kernels = (FAMILY,)

    pattern = ScenePattern(
        elements={Contact: ONE, Plane: ANY, UniformGravity: ANY, PeriodicBox: OPTIONAL},
        bodies=SOME,
        shape=Sphere,
        law="rigid",
        may_be_fixed=True,
        irreversible="the states before impacts cannot be recovered",
    )

    def unsupported_values(self, problem: Motion) -> str | None:
        """None for spheres with equal moments of inertia that do not overlap at the start, else the
        reason.
        """
        scene = problem.scene
        bodies = scene.bodies
        if np.any(bodies.inertia != bodies.inertia[:, :1]):
            return "a body whose moments of inertia differ: its angular velocity is not constant"
        still = bodies.fixed & (np.any(bodies.velocity, axis=1) | np.any(bodies.omega, axis=1))
        if still.any():
            return f"body {int(np.flatnonzero(still)[0])} is fixed, and moves or turns"
        law = scene.all(Contact)[0]
        if bodies.fixed.any() and scene.all(UniformGravity):
            return "a fixed body, which others fall towards: no quadratic has the times"
        points = (bodies.inertia[:, 0] == 0) & ~bodies.fixed
        if law.friction > 0 and points.any():
            return "friction on a body without moments of inertia"
        return _cramped(scene) or _overlapping(scene) or _on_plane(scene)

    def prepare(self, request: Request) -> KernelCall:
        """Bodies, planes, law and clock; row 0 of the states is the start."""
        problem = request.problem
        bodies = problem.scene.bodies
        count = len(problem.times)
        states = []
        for name in ("position", "velocity", "omega", "attitude"):
            start = getattr(bodies, name)
            rows = np.empty((count, *start.shape))
            rows[0] = start
            states.append(rows)
        workspace = np.empty(load(FAMILY).lib.refdem_impacts_room(len(bodies)))
        events = np.empty((MOST_EVENTS, 3))
        work = np.empty(count)
        # Times are counted from the start, so that their rounding does not depend on its value.
        since_start = problem.times - problem.times[0]
        return KernelCall(
            function="refdem_impacts_run",
            inputs=(_struct(problem.scene),),
            clock=(*samples(since_start), MOST_EVENTS, LONGEST),
            outputs=(workspace, events, work, *states),
        )

    def finish(self, request: Request, call: KernelCall, status: int) -> Trajectory:
        """States, the energy lost, and the impacts as contacts of their first bodies."""
        _, table, work, position, velocity, omega, attitude = call.outputs
        count = len(request.problem.times)
        if status < -count:
            before, after = request.problem.times[-status - count - 1 : -status - count + 1]
            raise EngineError(
                f"impacts: between t = {before:.6g} s and {after:.6g} s spheres come to rest"
                " against each other or on a plane, in infinitely many impacts (inelastic"
                " collapse); expected a run that ends before, or contacts that can last"
            )
        if status < 0:
            t = request.problem.times[-status]
            raise EngineError(
                f"impacts: {LONGEST} impacts did not lead to t = {t:.6g} s; expected fewer"
                " bodies, or a shorter run"
            )
        start = request.problem.times[0]
        # A run of more impacts than the table holds reports none of them.
        events = []
        if status <= MOST_EVENTS:
            for time, body, _ in table[:status]:
                events.append(Event(time=float(start + time), kind="contact", body=int(body)))
        return Trajectory(
            t=request.problem.times,
            position=position,
            velocity=velocity,
            attitude=attitude,
            omega=omega,
            channels={"dissipated_work": work},
            events=tuple(events),
        )


def _struct(scene: Scene) -> Struct:
    """Bodies, planes and law as the kernel's struct."""
    bodies = scene.bodies
    law = scene.all(Contact)[0]
    planes = [[*plane.point, *plane.normal] for plane in scene.all(Plane)]
    gravity = sum((np.array(field.g) for field in scene.all(UniformGravity)), np.zeros(3))
    # A fixed body has infinite mass and moment of inertia. A point has no surface on which friction
    # acts, and gets an infinite moment of inertia.
    mass = np.where(bodies.fixed, np.inf, bodies.mass)
    moment = bodies.inertia[:, 0]
    never_turns = bodies.fixed | (moment == 0)
    inertia = np.where(never_turns, np.inf, moment)
    return Struct(
        FAMILY,
        "refdem_impacts",
        {
            "bodies": len(bodies),
            "planes": len(planes),
            "few": FEW,
            "mass": mass,
            "inertia": inertia,
            "radius": bodies.radius,
            "plane": np.array(planes).reshape(-1, 6),
            "restitution": law.restitution,
            "tangential_restitution": law.slip_restitution,
            "friction": law.friction,
            "gravity": gravity.tolist(),
            "period": _period(scene),
        },
    )


def _period(scene: Scene) -> float:
    """The period [m] of the scene's box; 0 without one."""
    for box in scene.all(PeriodicBox):
        return box.size
    return 0.0


def _cramped(scene: Scene) -> str | None:
    """None if a periodic box is large enough for the cell list, else the reason."""
    period = _period(scene)
    if period == 0:
        return None
    if scene.all(Plane):
        return "planes in a periodic box, of which bodies meet images"
    least = FEWEST_DIAMETERS * 2 * float(scene.bodies.radius.max())
    if period < least:
        return f"a periodic box of {period:.6g} m; expected at least {least:.6g} m, 5 diameters"
    return None


def _overlapping(scene: Scene) -> str | None:
    """None if no spheres overlap at the start and none reaches behind a plane, else the reason."""
    bodies = scene.bodies
    position = bodies.position
    period = _period(scene)
    i, j = near_pairs(position, 2 * float(bodies.radius.max()), period)
    branch = position[j] - position[i]
    if period:
        # The nearest image: b -= L round(b/L), with the period L.
        branch -= period * np.rint(branch / period)
    # They overlap if |r_j - r_i| < R_i + R_j.
    apart = np.linalg.norm(branch, axis=1)
    reach = bodies.radius[i] + bodies.radius[j]
    deep = np.flatnonzero(apart < reach * (1 - ROUNDED))
    if len(deep):
        first, second = sorted((int(i[deep[0]]), int(j[deep[0]])))
        return f"body {first} overlaps body {second} at the start"
    for plane in scene.all(Plane):
        # The height (r - P) . n of a centre over the plane, which must be R at least.
        height = (position - np.array(plane.point)) @ np.array(plane.normal)
        behind = (height < bodies.radius * (1 - ROUNDED)) & ~bodies.fixed
        if np.any(behind):
            return f"body {int(np.flatnonzero(behind)[0])} reaches behind a plane at the start"
    return None


def _on_plane(scene: Scene) -> str | None:
    """None if no sphere rests on a plane under gravity at the start, else the reason: a sphere that
    touches it has a velocity along the normal.
    """
    bodies = scene.bodies
    gravity = sum((np.array(field.g) for field in scene.all(UniformGravity)), np.zeros(3))
    for plane in scene.all(Plane):
        normal = np.array(plane.normal)
        height = (bodies.position - np.array(plane.point)) @ normal
        touches = height <= bodies.radius * (1 + ROUNDED)
        lying = np.flatnonzero(touches & (bodies.velocity @ normal == 0) & ~bodies.fixed)
        if len(lying) and gravity @ normal < 0:
            return f"body {int(lying[0])} lies on a plane: a contact that lasts is no impact"
    return None


METHOD = Impacts()
