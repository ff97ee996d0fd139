"""Known faults: the error, the settings on which it acts, and the quantity of the check that must
detect it; and an engine with such a fault.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from refdem.core.engine import Engine, Method
from refdem.core.problem import Motion, Problem, Request
from refdem.core.trajectory import Cost, Trajectory
from refdem.faults.correct_parts import CORRECT
from refdem.faults.parts import Parts
from refdem.faults.transparent import Transparent

Inside = Callable[[Parts], Mapping[str, Any]]


@dataclass(frozen=True, kw_only=True)
class Fault:
    """One known fault. Exactly one of `before`, `after` and `inside` defines the error.

    before(request) changes the request, after(request, trajectory) the trajectory. inside(parts)
    gives the faulty parts by name, and is called for every engine, so that engines do not share the
    memory of parts. `on` names the settings on which the fault acts with `method` of the
    transparent engine, `sees` is the (check, quantity) that must fail there, and `levels` is the
    number of refinement levels that this needs.
    """

    name: str
    kind: str
    sentence: str
    on: tuple[str, ...]
    sees: tuple[str, str]
    method: str = "verlet"
    before: Callable[[Request], Request] | None = None
    after: Callable[[Request, Trajectory], Trajectory] | None = None
    inside: Inside | None = None
    levels: int = 3

    def __post_init__(self) -> None:
        if [self.before, self.after, self.inside].count(None) != 2:
            raise ValueError(f"fault {self.name}: expected exactly one of before, after and inside")

    def carrier(self, engine: Engine | None = None) -> Engine:
        """An engine that has the fault: the transparent one, or any other if the fault is not
        inside.
        """
        if self.inside:
            if engine is not None and not isinstance(engine, Transparent):
                raise ValueError(f"fault {self.name} is inside a part of the transparent engine")
            return Transparent(CORRECT.with_(**self.inside(CORRECT)))
        return Carrier(engine or Transparent(), self)


class Carrier(Engine):
    """An engine whose requests or trajectories are changed by a fault."""

    def __init__(self, engine: Engine, fault: Fault) -> None:
        self.engine = engine
        self.fault = fault
        self.name = engine.name
        self.title = engine.title
        self.methods = engine.methods
        self.is_reference = engine.is_reference

    def missing(self) -> str | None:
        """The reason why the carried engine is missing, or None."""
        return self.engine.missing()

    def version(self) -> str:
        """The version of the engine, with the name of the fault."""
        return f"{self.engine.version()} with {self.fault.name}"

    def fingerprint(self, method: Method) -> str:
        """The fingerprint of the engine, with that of the fault."""
        return f"{self.engine.fingerprint(method)} {self.fault.name}"

    def unsupported_motion(self, problem: Motion, method: Method) -> str | None:
        """The reason why the carried engine cannot run the motion, or None."""
        return self.engine.unsupported_motion(problem, method)

    def unsupported(self, problem: Problem, method: Method) -> str | None:
        """The reason why the carried engine cannot run the problem, or None."""
        return self.engine.unsupported(problem, method)

    def run(self, request: Request) -> tuple[Trajectory, Cost]:
        """The run of the engine, with the request or the trajectory changed by the fault."""
        if self.fault.before:
            changed = self.fault.before(request)
        else:
            changed = request
        trajectory, cost = self.engine.run(changed)
        if self.fault.after:
            trajectory = self.fault.after(request, trajectory)
        return trajectory, cost
