"""Two spheres that meet along the line of their centres under Hertz's law, in closed form
(kernels/power_contact.c).
"""

from time import perf_counter

import numpy as np
from numpy.typing import NDArray

from refdem.core.engine import Method
from refdem.core.problem import Motion, Request
from refdem.core.trajectory import Cost, Event, Trajectory
from refdem.kernels import load, pointer
from refdem.scene import Sphere
from refdem.scene.elements.contact import Contact
from refdem.solvers.exact_head_on import ROUNDED, approach, states
from refdem.solvers.solver import Solver

Array = NDArray[np.float64]


class ExactPowerContact(Solver):
    """Free flight, a contact in closed form, free flight, about a centre of mass in uniform
    motion.
    """

    claims = Method(
        name="exact-hertz",
        summary="Hertz's contact by the inverse of the incomplete beta function",
        control="exact",
        conserves=frozenset({"momentum", "angular-momentum"}),
        reversible=True,
        symplectic=True,
        backward=True,
        cost_rank=5,
    )
    kernels = ("power_contact",)

    def unsupported(self, problem: Motion) -> str | None:
        """None for two free spheres that do not turn, nothing but Hertz's contact, and no sideways
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
        if len(laws) != 1 or len(scene.elements) != 1 or laws[0].law != "hertz":
            return "something else than one contact law of Hertz"
        if np.any(bodies.omega):
            return "a sphere turns"
        _, closing, sideways = approach(scene)
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
            start = overlap
        else:
            start = 0.0
        since = sense * (t - t[0])
        out = np.empty((len(t), 2))
        touch = np.empty(3)
        mass = float(bodies.mass.prod() / bodies.mass.sum())
        force = np.array([law.stiffness, law.exponent])
        kernel = load("power_contact").lib
        laws = pointer("power_contact", force)
        samples = pointer("power_contact", since)
        buffers = [pointer("power_contact", array, output=True) for array in (touch, out)]
        started = perf_counter()
        kernel.refdem_power_contact(
            mass, laws, laws, start, sense * closing, len(t), samples, *buffers
        )
        cost = Cost(seconds=perf_counter() - started, setup=started - begun)
        overlap_now = out[:, 0]
        rate_now = sense * out[:, 1]
        position, velocity = states(scene, since * sense, overlap_now - start, rate_now - closing)
        events = []
        for when, kind in ((touch[0], "contact"), (touch[2], "release")):
            if 0 < when <= since[-1]:
                events.append(Event(time=float(t[0] + sense * when), kind=kind, body=0))
        found = Trajectory(
            t=t,
            position=position,
            velocity=velocity,
            attitude=np.repeat(bodies.attitude[None], len(t), axis=0),
            omega=np.zeros_like(velocity),
            channels=_channels(np.maximum(overlap_now, 0.0), law),
            events=tuple(events),
        )
        return found, cost


def _channels(overlap: Array, law: Contact) -> dict[str, Array]:
    """The channels of the contact, each (T,), from the overlap >= 0 (T,) [m]."""
    return {
        "overlap": overlap,
        "contacts": (overlap > 0).astype(float),
        "contact_force": law.stiffness * overlap**law.exponent,
    }


METHOD = ExactPowerContact()
