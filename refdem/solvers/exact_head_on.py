"""Two spheres that meet along the line of their centres, in closed form (kernels/head_on.c); both
cut-offs, any damping.
"""

from math import hypot
from time import perf_counter

import numpy as np
from numpy.typing import NDArray

from refdem.core.engine import Method
from refdem.core.problem import Motion, Request
from refdem.core.trajectory import Cost, Event, Trajectory
from refdem.kernels import load, pointer
from refdem.scene import Scene, Sphere
from refdem.scene.elements.contact import Contact
from refdem.solvers.solver import Solver

Array = NDArray[np.float64]

ROUNDED = 4 * 2.0**-52
"""Overlaps of so many times the distance, and sideways speeds of so many times the speed, are
rounding.
"""


class ExactHeadOn(Solver):
    """Free flight, damped sine, free flight, about a centre of mass in uniform motion."""

    claims = Method(
        name="exact-head-on",
        summary="the damped sine between touch and release, in closed form",
        control="exact",
        conserves=frozenset({"momentum", "angular-momentum"}),
        reversible=True,
        symplectic=True,
        backward=True,
        cost_rank=5,
    )
    kernels = ("head_on",)

    def unsupported(self, problem: Motion) -> str | None:
        """None for two free spheres that do not turn, nothing but linear contact, and no sideways
        velocity.
        """
        scene = problem.scene
        bodies = problem.scene.bodies
        laws = scene.all(Contact)
        if (
            len(bodies) != 2
            or not all(isinstance(shape, Sphere) for shape in bodies.shape)
            or bodies.fixed.any()
        ):
            return "not two free spheres"
        if len(laws) != 1 or len(scene.elements) != 1 or laws[0].law != "linear":
            return "something else than one linear contact law"
        if np.any(bodies.omega):
            return "a sphere turns"
        if problem.interval < 0 and laws[0].damping > 0:
            return "time runs backwards through a dashpot"
        overlap, closing, sideways = approach(scene)
        distance = float(bodies.radius.sum())
        if overlap > ROUNDED * distance:
            return "the spheres overlap at the start"
        if sideways > ROUNDED * abs(closing):
            return "the spheres do not meet along the line of their centres"
        return None

    def run(self, request: Request) -> tuple[Trajectory, Cost]:
        """States at the samples; a run backwards is one with flipped velocities."""
        begun = perf_counter()
        scene = request.problem.scene
        t = request.problem.times
        law = scene.all(Contact)[0]
        bodies = scene.bodies
        sense = float(np.sign(request.problem.interval))
        overlap, closing, _ = approach(scene)
        if abs(overlap) > ROUNDED * bodies.radius.sum():
            start = min(overlap, 0.0)
        else:
            start = 0.0
        since = sense * (t - t[0])
        out = np.empty((len(t), 5))
        touch = np.empty(2)
        numbers = (
            *bodies.mass.tolist(),
            law.stiffness,
            law.damping,
            law.cutoff == "zero_force",
            start,
            sense * closing,
        )
        buffers = [pointer("head_on", array, output=True) for array in (touch, out)]
        lib = load("head_on").lib
        started = perf_counter()
        lib.refdem_head_on(*numbers, len(t), pointer("head_on", since), *buffers)
        cost = Cost(seconds=perf_counter() - started, setup=started - begun)
        # The kernel's rows: overlap, its rate, contacts, force, dissipated work.
        overlap_now = out[:, 0]
        rate_now = sense * out[:, 1]
        position, velocity = states(scene, since * sense, overlap_now - start, rate_now - closing)
        channels = {
            "overlap": np.maximum(overlap_now, 0.0),
            "contacts": out[:, 2].copy(),
            "contact_force": out[:, 3].copy(),
            "dissipated_work": out[:, 4].copy(),
        }
        events = []
        for when, kind in zip(touch, ("contact", "release"), strict=True):
            if 0 < when <= since[-1]:
                events.append(Event(time=float(t[0] + sense * when), kind=kind, body=0))
        found = Trajectory(
            t=t,
            position=position,
            velocity=velocity,
            attitude=np.repeat(bodies.attitude[None], len(t), axis=0),
            omega=np.zeros_like(velocity),
            channels=channels,
            events=tuple(events),
        )
        return found, cost


def approach(scene: Scene) -> tuple[float, float, float]:
    """Overlap [m], speed at which it grows [m/s] and sideways speed [m/s] at the start; no square
    of a small length underflows.
    """
    bodies = scene.bodies
    normal = along(scene)
    relative = bodies.velocity[0] - bodies.velocity[1]
    closing = float(relative @ normal)
    overlap = float(bodies.radius.sum()) - hypot(*(bodies.position[1] - bodies.position[0]))
    return overlap, closing, hypot(*(relative - closing * normal))


def along(scene: Scene) -> Array:
    """Unit vector (3,) from the first centre to the second."""
    line: Array = scene.bodies.position[1] - scene.bodies.position[0]
    return line / hypot(*line)


def states(scene: Scene, t: Array, pressed: Array, sped: Array) -> tuple[Array, Array]:
    """Positions and velocities (T, 2, 3) where the overlap and its rate have grown by `pressed` [m]
    and `sped` [m/s].
    """
    bodies = scene.bodies
    total = bodies.mass.sum()
    centre = bodies.mass @ bodies.velocity / total
    # Of a change of the overlap, m2/(m1 + m2) moves the first and m1/(m1 + m2) the second.
    share = np.array([bodies.mass[1], -bodies.mass[0]])[:, None] / total * along(scene)
    position = bodies.position + centre * t[:, None, None] + pressed[:, None, None] * share
    return position, bodies.velocity + sped[:, None, None] * share


METHOD = ExactHeadOn()
