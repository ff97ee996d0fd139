"""One free body with damping inside (kernels/dissipating_body.c)."""

from time import perf_counter

import numpy as np

from refdem.core.engine import Method
from refdem.core.problem import Motion, Request
from refdem.core.trajectory import Cost, Trajectory
from refdem.errors import EngineError
from refdem.kernels import load, pointer
from refdem.mechanics.quaternion import conjugate, rotated
from refdem.scene.elements.internal_damping import InternalDamping
from refdem.solvers.solver import Solver


class DissipatingBody(Solver):
    """Angular momentum in principal axes and attitude by Taylor series; the centre flies
    straight.
    """

    claims = Method(
        name="dissipating-body",
        summary="a body that loses energy inside: Taylor series of order 20, steps to round-off",
        control="exact",
        derived={
            "attitude": (
                "the attitude is divided by its length when it is handed out, so that it is"
                " always 1"
            ),
            "dissipated_work": (
                "it is told as what the energy lacks, so that the balance always holds"
            ),
        },
        conserves=frozenset({"momentum", "angular-momentum"}),
        backward=True,
        cost_rank=2,
    )
    kernels = ("dissipating_body",)

    def unsupported(self, problem: Motion) -> str | None:
        """None for one free body with inertia about every axis and damping inside it, and nothing
        else.
        """
        scene = problem.scene
        if (
            len(scene.bodies) != 1
            or scene.bodies.fixed.any()
            or not np.all(scene.bodies.inertia > 0)
        ):
            return "not one free body with inertia"
        if [element.kind for element in scene.elements] != ["internal_damping"]:
            return "not internal damping alone"
        return None

    def run(self, request: Request) -> tuple[Trajectory, Cost]:
        """States and the work dissipated at the samples."""
        begun = perf_counter()
        scene = request.problem.scene
        t = request.problem.times
        bodies = scene.bodies
        damping = scene.all(InternalDamping)[0].coefficient
        inertia = np.ascontiguousarray(bodies.inertia[0])
        attitude = bodies.attitude[0]
        # A row: angular momentum in principal axes [kg m^2/s], attitude.
        momentum = inertia * rotated(conjugate(attitude), bodies.omega[0])
        out = np.empty((len(t), 7))
        out[0] = np.concatenate([momentum, attitude])
        moments = pointer("dissipating_body", inertia)
        samples = pointer("dissipating_body", t)
        row = pointer("dissipating_body", out, output=True)
        started = perf_counter()
        failed = load("dissipating_body").lib.refdem_dissipating_body(
            moments, damping, len(t), samples, row
        )
        cost = Cost(seconds=perf_counter() - started, setup=started - begun)
        if failed:
            raise EngineError(
                f"dissipating-body: no step leads to t = {t[failed - 1]:.6g} s; take a smaller"
                " damping or duration"
            )
        turn = out[:, 3:] / np.linalg.norm(out[:, 3:], axis=1, keepdims=True)
        omega = rotated(turn, out[:, :3] / inertia)
        omega[0] = bodies.omega[0]
        energy = 0.5 * np.sum(out[:, :3] ** 2 / inertia, axis=1)
        flown = (t - t[0])[:, None, None] * bodies.velocity
        found = Trajectory(
            t=t,
            position=bodies.position + flown,
            velocity=np.broadcast_to(bodies.velocity, flown.shape).copy(),
            attitude=turn[:, None],
            omega=omega[:, None],
            channels={"dissipated_work": energy[0] - energy},
        )
        return found, cost


METHOD = DissipatingBody()
