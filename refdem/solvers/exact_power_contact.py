"""Two spheres in head-on collision under Hertz's law, m_eff d'' = -k d^(3/2), in closed form
(kernels/power_contact.c).
"""

import numpy as np
from numpy.typing import NDArray

from refdem.core.engine import Method
from refdem.core.problem import Motion, Request
from refdem.core.trajectory import Trajectory
from refdem.scene import Sphere
from refdem.scene.elements.contact import Contact
from refdem.solvers._kernel_solver import Elapsed, KernelCall, KernelSolver, samples
from refdem.solvers._scene_pattern import ONE, TWO, ScenePattern
from refdem.solvers.exact_head_on import ROUNDED, approach, met, unrounded

Array = NDArray[np.float64]


class ExactPowerContact(KernelSolver):
    """Free flight, a contact in closed form, free flight; the centre of mass moves uniformly."""

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

    pattern = ScenePattern(
        elements={Contact: ONE}, bodies=TWO, shape=Sphere, law="hertz", may_spin=False
    )

    def unsupported_values(self, problem: Motion) -> str | None:
        """None for spheres that meet along the line of their centres, else the reason."""
        _, closing, sideways = approach(problem.scene)
        if sideways > ROUNDED * abs(closing):
            return "the spheres do not meet along the line of their centres"
        return None

    def prepare(self, request: Request) -> KernelCall:
        """The law and the start along the line of centres; arrays for the times of contact,
        greatest overlap and release, and for overlaps and rates.
        """
        scene = request.problem.scene
        elapsed = Elapsed(request.problem)
        contact = scene.all(Contact)[0]
        overlap, closing, _ = approach(scene)
        mass = scene.bodies.mass
        effective_mass = float(mass.prod() / mass.sum())
        law = np.array([contact.stiffness, contact.exponent])
        start = (unrounded(scene, overlap), elapsed.sense * closing)
        return KernelCall(
            function="refdem_power_contact",
            inputs=(effective_mass, law, law, *start),
            clock=samples(elapsed.since),
            outputs=(np.empty(3), np.empty((len(elapsed.since), 2))),
        )

    def finish(self, request: Request, call: KernelCall, status: int) -> Trajectory:
        """States at the samples; a run backward in time is one with velocities reversed."""
        scene = request.problem.scene
        overlap, _, _ = approach(scene)
        times, rows = call.outputs
        overlaps, rate = rows.T
        channels = _channels(np.maximum(overlaps, 0.0), scene.all(Contact)[0])
        events = {"contact": times[0], "release": times[2]}
        return met(request.problem, overlaps - unrounded(scene, overlap), rate, channels, events)


def _channels(overlap: Array, law: Contact) -> dict[str, Array]:
    """The contact's channels, each (T,), from the overlap >= 0 (T,) [m]; the force is k d^n."""
    return {
        "overlap": overlap,
        "contacts": (overlap > 0).astype(float),
        "contact_force": law.stiffness * overlap**law.exponent,
    }


METHOD = ExactPowerContact()
