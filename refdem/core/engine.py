"""An engine: an adapter that runs problems in some code, and its methods with what they claim."""

from abc import ABC, abstractmethod
from collections.abc import Callable, Generator, Mapping
from dataclasses import dataclass, field
from typing import Literal, TypeVar

from refdem.core.deviation import Deviation
from refdem.core.problem import Motion, Problem, Request
from refdem.core.trajectory import Cost, Trajectory

Result = TypeVar("Result")


UNEQUAL_MOMENTS = "unequal-moments"
"""What `broken_with` may name beside the features of a scene: a body with unequal moments of
inertia that may turn. Such a body's angular momentum depends on its attitude.
"""


@dataclass(frozen=True, kw_only=True)
class Method:
    """One way to run an engine, with its claims; the checks hold it to them.

    control: a fixed `step`, a `tolerance`, or `exact` (round-off only).
    order, order_with: the order p of the error; `order_with` lowers it for scenes with a feature.
    constant: C in `error <= C (1 + t/tau) (h/tau)^p S`, relative to the scale; for a tolerance C in
    `error <= C 1e3 tol S`, there for smooth motions.
    conserves: energy, momentum, angular-momentum, each to round-off.
    broken_with: for a law of `conserves`, the features of a scene with which it holds only to the
    order, and UNEQUAL_MOMENTS.
    symplectic: no secular drift of energy.
    complete_state: a run can be continued from its end state.
    velocity_time: velocities and omegas hold at their sample, or half a step before it.
    differenced_velocities: velocities are differences of places over a step, whose roundings they
    show divided by the step.
    summed_clock: the time is a plain sum of steps, so that each may add an error of u t.
    locates_events: events have their own times, not that of the end of the step they occur in.
    cuts_steps: steps end at each kink of the force, where a contact begins, sticks, slips or ends.
    The error is then that of a smooth motion, but for the part of the step that is cut off.
    tells: kinds of events, contact or release, of which the method reports every one, between
    bodies and at walls; a run without such events is then compared with truth as well.
    answers: the kind of questions that the method is for.
    threads: `Request.threads` may be above 1, and any number of threads gives the same bits.
    differentiates: a run comes with the derivatives of its states by numbers of the scene, where
    `Request.sensitivities` names some.
    start_only: it differentiates by numbers of the start alone: positions, velocities, attitudes
    and omegas of bodies.
    by_name: it runs only if it is requested by name, and so in no campaign of all methods.
    as_shipped: the engine has its own default settings, as for a user who specifies only the scene.
    It runs if a campaign requests it (`as_shipped = true`), or by its name.
    knows: for questions without time, the features that it can answer; others are left out.
    derived: numbers that the adapter computes from others in such a way that a law about them
    always holds, each with the reason. A check of that law could not fail, and so does not apply.
    Known are `attitude` (unit quaternions), `rod` and `ball_joint` (closed joints),
    `dissipated_work` (the energy balance).
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
    differenced_velocities: bool = False
    summed_clock: bool = False
    locates_events: bool = False
    cuts_steps: bool = False
    tells: frozenset[str] = frozenset()
    deterministic: bool = True
    threads: bool = False
    differentiates: bool = False
    start_only: bool = False
    by_name: bool = False
    as_shipped: bool = False
    cost_rank: int = 0
    answers: str = "motion"
    knows: frozenset[str] = frozenset()

    def delay(self, level: float) -> float:
        """Time [s] by which velocities and omegas lag behind their sample at this level."""
        if self.velocity_time == "minus-half-step" and self.control == "step":
            return level / 2
        return 0.0

    def order_for(self, features: frozenset[str]) -> int:
        """The order claimed for a scene with these features: the least that applies."""
        lowered = [order for feature, order in self.order_with.items() if feature in features]
        return min([self.order, *lowered])

    def keeps(self, law: str, features: frozenset[str]) -> bool:
        """True if a law is claimed to hold to round-off in a scene with these features."""
        if self.control == "exact":
            return True
        breaking = self.broken_with.get(law, frozenset())
        return law in self.conserves and not breaking & features

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
"""Work around a program as a generator. It yields each `Waiting`, so that the caller may wait for
several programs at once; it is sent a function that returns or raises what the waiting did; its
return value is the result.
"""


def finished(stages: Stages[Result]) -> Result:
    """The result of work in stages, each waited for in this thread."""
    try:
        # Sent back unchanged: the generator calls it itself, and so waits here.
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
    default_step: float | None = None
    """The step [s] that the engine takes where its user names none; None where each must."""
    time_limit: float | None = None
    budget: float | None = None
    expected: tuple[Deviation, ...] = ()
    may_refuse: frozenset[str] = frozenset()
    """Limits that the engine's own description sets, in seconds a run and seconds a campaign;
    deviations it accepts; and images of a scene (shifted, rotated, mirrored ...) that it may
    refuse when it runs although it runs the scene itself."""

    @property
    def address(self) -> str:
        """The name or the path of a refdem.toml by which `discovery.engine` finds the engine.

        It is valid in other processes too.
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

    def chosen_methods(self, name: str = "", *, as_shipped: bool = False) -> list[Method]:
        """The methods of that name; without a name all that do not need one, those as shipped only
        if requested.
        """
        if name:
            return [method for method in self.methods if method.name == name]
        unnamed = [method for method in self.methods if not method.by_name]
        return [method for method in unnamed if as_shipped or not method.as_shipped]

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
    """An engine whose runs are those of a program; it ends the program itself after
    `time_limit`.
    """

    @abstractmethod
    def stages(self, request: Request) -> Stages[tuple[Trajectory, Cost]]:
        """The run as a generator of stages, which ends with its result."""

    def run(self, request: Request) -> tuple[Trajectory, Cost]:
        """The trajectory and cost at the end of all stages."""
        return finished(self.stages(request))
