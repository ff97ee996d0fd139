"""Runs of the reference that figures are drawn from.

While a figure is made, `remember` collects the commands by which a person repeats its runs; they
are printed beside it.
"""

import shlex
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from refdem.core import discovery
from refdem.core.case import Instance
from refdem.core.problem import Motion, Problem, Request
from refdem.core.trajectory import Trajectory

Array = NDArray[np.float64]
_COMMANDS: list[list[str]] = []


@contextmanager
def recorded() -> Iterator[list[str]]:
    """Within this context the commands of runs are appended to the list that it yields."""
    _COMMANDS.append([])
    try:
        yield _COMMANDS[-1]
    finally:
        _COMMANDS.pop()


def remember(command: str) -> None:
    """Puts a command beside the figure that is being made."""
    if _COMMANDS:
        _COMMANDS[-1].append(command)


@dataclass(frozen=True, eq=False)
class ObservedRun:
    """A run with the quantities (T,) that the case observes in it, at the samples t (T,)."""

    instance: Instance
    trajectory: Trajectory
    quantities: dict[str, Array]

    @property
    def t(self) -> Array:
        """The samples (T,): seconds, or numbers of iterates."""
        return self.trajectory.t

    def __getitem__(self, name: str) -> Array:
        return self.quantities[name]


def instance(case: str, **parameters: Any) -> Instance:
    """A case at these parameters, numbers or text."""
    given = {name: _text(value) for name, value in parameters.items()}
    return discovery.case(case).at(**given)


def observed(case: str, **parameters: Any) -> ObservedRun:
    """The run of a case by the reference's cheapest method; its command is remembered."""
    case_instance = instance(case, **parameters)
    remember(command(case_instance))
    trajectory = answer(case_instance.problem)
    return ObservedRun(case_instance, trajectory, case_instance.observe(trajectory))


def observed_at(case: str, times: Array, **parameters: Any) -> ObservedRun:
    """The run of a case at other times (T,), with the start of the case at the first of them.

    It is one of many for a curve, so that its command is not remembered.
    """
    case_instance = instance(case, **parameters)
    trajectory = answer(Motion(case_instance.scene, times))
    return ObservedRun(case_instance, trajectory, case_instance.observe(trajectory))


def answer(problem: Problem) -> Trajectory:
    """The reference's answer to any question."""
    reference: Any = discovery.engine("reference")
    request = Request(problem=problem, method=reference.best(problem).name)
    trajectory: Trajectory
    trajectory, *_ = reference.run(request)
    return trajectory


def command(case_instance: Instance) -> str:
    """The command line that judges a run of the reference at these parameters."""
    given = ""
    for name, value in case_instance.p.changed().items():
        assignment = f"{name}={value}"
        given += f" --set {shlex.quote(assignment)}"
    return f"refdem run {case_instance.case.id}{given} --engine reference"


def _text(value: Any) -> str:
    """A parameter as the command line reads it; several numbers are separated by commas."""
    if isinstance(value, tuple):
        return ",".join(map(_text, value))
    if isinstance(value, float):
        # Of numpy's floats too, which write their type otherwise.
        return repr(float(value))
    return str(value)
