"""An engine: an adapter that runs problems in some code, and its methods with what they claim."""

from abc import ABC, abstractmethod
from collections.abc import Callable, Generator, Mapping
from dataclasses import dataclass, field
from typing import Literal, TypeVar

from refdem.core.deviation import Deviation
from refdem.core.problem import Motion, Problem, Request
from refdem.core.trajectory import Cost, Trajectory

Result = TypeVar("Result")


@dataclass(frozen=True, kw_only=True)
class Method:
    """One way to run an engine, and what is claimed for it; the checks hold it to the claims.

    control: a fixed `step`, a `tolerance`, or `exact` (round-off only). `order_with` lowers the
    order where a scene has the feature. `constant` is C in `error <= C L (T/tau) (h/tau)^p`, or in
    `error <= C 1e3 tol S` of a tolerance, there for smooth motions. `conserves`: energy, momentum,
    angular-momentum, each to round-off; `broken_with`: features of a scene with which a law among
    them is kept to the order only; `symplectic`: no secular drift of energy. `complete_state`: a
    run can go on from its end state.
    `velocity_time`: velocities and omegas hold at their sample, or half a step before it.
    `summed_clock`: its time is a plain sum of its steps, so that it may be off by u t for each of
    them. `locates_events`: it tells events at their own times and not at the end of the step that
    sees them. `answers` is the kind of questions that it is for; of one without time it `knows`
    these features, and is silent about others. `derived` names what the adapter makes of other
    numbers in such a way that a law about it always holds, each with the reason: a check of that
    law could not fail, and so does not apply. Known are `attitude` (unit quaternions), `rod` and
    `ball_joint` (closed joints), `dissipated_work` (the energy balance).
    """

    name: str
    summary: str
    control: Literal["step", "tolerance", "exact"]
    order: int = 0
    order_with: Mapping[str, int] = field(default_factory=dict)
    constant: float = 1.0
    constant_reason: str = ""
    conserves: frozenset[str] = frozenset()
    broken_with: Mapping[str, frozenset[str]] = field(default_factory=dict)
    derived: Mapping[str, str] = field(default_factory=dict)
    reversible: bool = False
    symplectic: bool = False
    backward: bool = False
    complete_state: bool = True
    precision: Literal["double", "single"] = "double"
    velocity_time: Literal["synchronous", "minus-half-step"] = "synchronous"
    summed_clock: bool = False
    locates_events: bool = False
    deterministic: bool = True
    cost_rank: int = 0
    answers: str = "motion"
    knows: frozenset[str] = frozenset()

    def delay(self, level: float) -> float:
        """Time [s] by which velocities and omegas lag behind their sample at this level."""
        if self.velocity_time == "minus-half-step" and self.control == "step":
            return level / 2
        return 0.0

    def order_for(self, features: frozenset[str]) -> int:
        """The order claimed for a scene with these features."""
        return min(
            [
                self.order,
                *(order for feature, order in self.order_with.items() if feature in features),
            ]
        )

    def keeps(self, law: str, features: frozenset[str]) -> bool:
        """Whether a law is claimed to hold to round-off in a scene with these features."""
        if self.control == "exact":
            return True
        return law in self.conserves and not self.broken_with.get(law, frozenset()) & features

    @property
    def round_off(self) -> float:
        """Unit round-off u of the declared precision."""
        if self.precision == "double":
            return 2.0**-53
        return 2.0**-24


@dataclass(frozen=True)
class Default:
    """One line of the audit of defaults: a setting, what the engine comes with, what the adapter
    sets, and why.
    """

    setting: str
    default: str
    used: str
    why: str


Waiting = Callable[[], float]
"""Starts a program, waits for it, returns the seconds that it took or raises; safe in any thread.
"""
Stages = Generator[Waiting, Waiting, Result]
"""Work around a program: yields what waits, is sent what then returns or raises the same, returns
its result.
"""


def finished(stages: Stages[Result]) -> Result:
    """The result of work in stages, all of it done here."""
    try:
        waiting = next(stages)
        while True:
            waiting = stages.send(waiting)
    except StopIteration as end:
        result: Result = end.value
        return result


class Engine(ABC):
    """An adapter to a code under test.

    It gets the question and never the answer; it is imported without importing the engine itself.
    """

    name: str
    title: str
    methods: tuple[Method, ...]
    audit: tuple[Default, ...] = ()
    licence: str = ""
    is_reference: bool = False
    time_limit: float | None = None
    budget: float | None = None
    expected: tuple[Deviation, ...] = ()
    may_refuse: frozenset[str] = frozenset()
    """Limits that the engine's own description sets, in seconds a run and seconds a campaign;
    deviations it accepts; and pictures of a scene (shifted, rotated, mirrored ...) that it may
    refuse when it runs although it runs the scene itself."""

    @property
    def address(self) -> str:
        """What `discovery.engine` finds it by, also in another process: its name, or the path of
        its refdem.toml.
        """
        return self.name

    @abstractmethod
    def missing(self) -> str | None:
        """None if the engine can be run here, else what to install."""

    @abstractmethod
    def version(self) -> str:
        """The version of the engine itself, as it reports it."""

    @abstractmethod
    def fingerprint(self, method: Method) -> str:
        """A digest of all that can change a run: the engine, its adapter, the kernels it uses."""

    @abstractmethod
    def unsupported_motion(self, problem: Motion, method: Method) -> str | None:
        """None if the method can run the problem, else the missing feature in a few words."""

    def unsupported(self, problem: Problem, method: Method) -> str | None:
        """None if the method can run a problem of any kind, else the reason."""
        if method.answers != problem.kind:
            return f"cannot run {problem.words}"
        if isinstance(problem, Motion):
            return self.unsupported_motion(problem, method)
        if method.knows & problem.features:
            return None
        return f"the engine supports none of the requested {problem.words}"

    @abstractmethod
    def run(self, request: Request) -> tuple[Trajectory, Cost]:
        """Runs one request in the engine's native loop."""

    def method(self, name: str) -> Method:
        """The method that has the given name; UsageError if there is none."""
        from refdem.core.parameters import nearest
        from refdem.errors import UsageError

        for method in self.methods:
            if method.name == name:
                return method
        raise UsageError(
            f"engine {self.name} has no method {name!r};"
            f" {nearest(name, [m.name for m in self.methods])}"
        )


class ProgramEngine(Engine):
    """An engine whose runs are those of a program, which it ends by `time_limit`: whoever wants
    them need only wait.
    """

    @abstractmethod
    def stages(self, request: Request) -> Stages[tuple[Trajectory, Cost]]:
        """The run as a generator of stages, which ends with its result."""

    def run(self, request: Request) -> tuple[Trajectory, Cost]:
        """The trajectory and cost at the end of all stages."""
        return finished(self.stages(request))
