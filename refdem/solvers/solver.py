"""Base class of every method of the reference implementation: claims, a refusal, and a run over C
kernels.
"""

from abc import ABC, abstractmethod
from typing import Any

from refdem.core.engine import Method
from refdem.core.problem import Motion, Problem, Request
from refdem.core.trajectory import Cost, Trajectory


class Solver(ABC):
    """One method. A file in solvers/ with an instance named METHOD is discovered automatically.

    `kernels` names every C family that the method calls; their digests are part of a run's key.
    `answers` is the kind of problem that it solves, the only kind passed to `unsupported` and
    `run`.
    """

    claims: Method
    answers: type[Problem] = Motion
    kernels: tuple[str, ...] = ()

    @abstractmethod
    def unsupported(self, problem: Any) -> str | None:
        """None if the method can solve the problem, else the reason. It depends on the content of
        the scene, never on the name of a case.
        """

    @abstractmethod
    def run(self, request: Request) -> tuple[Trajectory, Cost]:
        """The trajectory, and the cost, which is the time in the kernel alone."""
