"""One method of one engine on one instance, which runs a level and returns its errors and its run
time.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from refdem.core.case import Instance
from refdem.core.engine import Engine, Method
from refdem.core.judgement import errors
from refdem.core.problem import Problem, Request
from refdem.core.trajectory import Cost, Trajectory
from refdem.core.truth import SampledTruth

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Entrant:
    """An engine's method with the levels that it is run at; a peer is an engine that only the bench
    knows.
    """

    instance: Instance
    engine: Engine
    method: Method
    levels: tuple[float, ...]
    is_peer: bool = False

    def request(self, level: float, problem: Problem | None = None) -> Request:
        """The request of a level, for the problem of the instance unless another one is given."""
        if problem is None:
            problem = self.instance.problem
        control: dict[str, Any] = {}
        if self.method.control != "exact":
            control[self.method.control] = level
        return Request(problem=problem, method=self.method.name, **control)

    def run(self, level: float) -> tuple[Trajectory, Cost]:
        """One run; raises EngineError if the samples are not the requested ones."""
        request = self.request(level)
        trajectory, cost = self.engine.run(request)
        request.refuse_misaligned(trajectory.t, self.method.round_off)
        return trajectory, cost

    def errors(self, trajectory: Trajectory, truth: SampledTruth, level: float) -> dict[str, float]:
        """The largest error over the run of each quantity, in units of its scale."""
        delay = self.method.delay(level)
        over_time: dict[str, Array] = errors(self.instance, trajectory, truth, delay)
        return {name: float(np.max(values)) for name, values in over_time.items()}
