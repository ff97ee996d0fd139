"""heyoka: Taylor's method of adaptive order and step, compiled for each system (Biscani and Izzo
2021).
"""

from time import perf_counter
from typing import Any

import numpy as np

from refdem.bench.peers._coulomb import coulomb
from refdem.bench.peers._oblique import Oblique, oblique
from refdem.bench.peers._peer import CARTESIAN, Peer
from refdem.core.engine import Method
from refdem.core.problem import Motion, Request
from refdem.core.trajectory import Cost, Trajectory
from refdem.kernels import repeats

EVENTS = "taylor-events"


class Heyoka(Peer):
    """A compiled integrator is kept for each system and tolerance, so that only its first run pays
    for the compiler.
    """

    name = "heyoka"
    title = "heyoka"
    licence = "MPL-2.0"
    methods = (
        Method(
            name="taylor",
            summary="Taylor, order by the tolerance; a pendulum in its angle",
            control="tolerance",
        ),
        Method(
            name="taylor" + CARTESIAN,
            summary="a rod's end by its stabilised constraint force",
            control="tolerance",
        ),
        Method(
            name=EVENTS,
            summary="dry friction, and oblique contact, with their events",
            control="tolerance",
        ),
    )

    def __init__(self) -> None:
        self._compiled: dict[tuple[Any, ...], Any] = {}

    def unsupported_motion(self, problem: Motion, method: Method) -> str | None:
        """None for scenes with equations; events for a Coulomb oscillator."""
        if method.name == EVENTS:
            if coulomb(problem.scene) or oblique(problem.scene):
                return None
            return "dry friction on a line and contact of two spheres are all it has events for"
        return super().unsupported_motion(problem, method)

    def run(self, request: Request) -> tuple[Trajectory, Cost]:
        """States on the grid of the samples, by the dense output of the Taylor series."""
        if request.method == EVENTS:
            return self._with_events(request)
        begun = perf_counter()
        problem = request.problem
        tolerance = request.tolerance
        system = self.supported_equations(problem, request.method)
        key = (system.key, tolerance)
        if key not in self._compiled:
            self._compiled[key] = _integrator(system, tolerance)
        integrator = self._compiled[key]
        seconds = 0.0
        for _ in range(repeats()):
            integrator.time = problem.times[0]
            integrator.state[:] = system.start
            started = perf_counter()
            propagated = integrator.propagate_grid(problem.times)
            seconds += (perf_counter() - started) / repeats()
        cost = Cost(
            seconds=seconds,
            setup=perf_counter() - begun - repeats() * seconds,
            steps=int(propagated[3]),
        )
        return system.trajectory(problem.times, np.ascontiguousarray(propagated[-1])), cost

    def _with_events(self, request: Request) -> tuple[Trajectory, Cost]:
        """Integrates from turning point to turning point, until at one of them the spring is no
        stronger than friction.
        """
        begun = perf_counter()
        t = request.problem.times
        law = coulomb(request.problem.scene)
        if law is None:
            return self._oblique(request)
        key = (law, request.tolerance)
        if key not in self._compiled:
            self._compiled[key] = law.integrator(request.tolerance)
        integrator = self._compiled[key]
        seconds = 0.0
        states = np.empty((len(t), 2))
        for _ in range(repeats()):
            integrator.time = t[0]
            integrator.state[:] = (law.place, law.speed)
            integrator.pars[0] = law.direction
            started = perf_counter()
            propagated = integrator.propagate_grid(t)
            states[: len(propagated[-1])] = propagated[-1]
            states[len(propagated[-1]) :] = integrator.state[0], 0.0
            seconds += (perf_counter() - started) / repeats()
        cost = Cost(
            seconds=seconds,
            setup=perf_counter() - begun - repeats() * seconds,
            steps=int(propagated[3]),
        )
        position = np.zeros((len(t), 1, 3))
        velocity = np.zeros((len(t), 1, 3))
        position[:, 0, 0], velocity[:, 0, 0] = states.T
        return Trajectory.of_points(t, position, velocity), cost

    def _oblique(self, request: Request) -> tuple[Trajectory, Cost]:
        """Integrates from event to event, with an integrator for each mode of the contact."""
        begun = perf_counter()
        t = request.problem.times
        pair = oblique(request.problem.scene)
        assert isinstance(pair, Oblique)
        key = (pair.key, request.tolerance)
        if key not in self._compiled:
            self._compiled[key] = pair.integrators(request.tolerance)
        integrators = self._compiled[key]
        started = perf_counter()
        runs = [pair.followed(integrators, t) for _ in range(repeats())]
        seconds = sum(run[2] for run in runs) / len(runs)
        cost = Cost(seconds=seconds, setup=started - begun, steps=runs[0][1])
        return pair.trajectory(t, runs[0][0]), cost


def _integrator(system: Any, tolerance: float | None) -> Any:
    """The compiled integrator of a system."""
    import heyoka

    names = heyoka.make_vars(*(f"y{number}" for number in range(len(system.start))))
    rates = system.rates(names, heyoka.sin)
    return heyoka.taylor_adaptive(
        list(zip(names, rates, strict=True)), list(system.start), tol=tolerance, compact_mode=False
    )


PEER = Heyoka()
