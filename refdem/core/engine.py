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
"""A condition that `broken_with` may name in addition to features of a scene: a body with unequal
moments of inertia may turn. The angular momentum of such a body depends on its attitude.
"""


@dataclass(frozen=True, kw_only=True)
class Method:
    """One way to run an engine, with its claims, which the checks test.

    control: a fixed `step`, a `tolerance`, or `exact` (round-off only).
    order, order_with: the order p of the error; `order_with` lowers it for scenes with a feature.
    constant: C in `error <= C (1 + t/tau) (h/tau)^p S`, relative to the scale; for a tolerance C in
    `error <= C 1e3 tol S`, which is claimed for smooth motions only.
    conserves: energy, momentum, angular-momentum, each to round-off.
    broken_with: for a law of `conserves`, the features of a scene with which it holds only to the
    order, and UNEQUAL_MOMENTS.
    symplectic: no secular drift of energy.
    complete_state: a run can be continued from its end state.
    velocity_time: velocities and omegas are those at the sample, or half a step before it.
    differenced_velocities: velocities are differences of positions divided by the step, so that
    they contain roundings of positions divided by the step.
    summed_clock: the time is a plain sum of steps, so that each may add an error of u t.
    locates_events: events have their own times, not that of the end of the step they occur in.
    cuts_steps: steps end at each kink of the force, where a contact begins, sticks, slips or ends.
    The error is then that of a smooth motion, except for the last part of a cut step.
    tells: kinds of events, contact or release, of which the method reports every one, between
    bodies and at walls. If a run then reports no such event, that is compared with truth as well.
    answers: the kind of problem that the method solves.
    threads: `Request.threads` may be above 1, and any number of threads gives the same bits.
    differentiates: a run comes with the derivatives of its states by numbers of the scene, where
    `Request.sensitivities` names some.
    start_only: it differentiates by numbers of the start alone: positions, velocities, attitudes
    and omegas of bodies.
    by_name: it runs only if it is requested by name, and so in no campaign of all methods.
    as_shipped: the engine has its own default settings, as for a user who specifies only the scene.
    It runs if a campaign requests it (`as_shipped = true`), or if it is requested by name.
    knows: for problems without time, the features that it can compute; others are omitted.
    derived: numbers that the adapter computes from others in such a way that a law about them
    always holds, each with the reason. A check of that law could not fail, and so does not apply.
    The names are `attitude` (unit quaternions), `rod` and `ball_joint` (closed joints), and
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
    """One line of the audit of defaults: a setting, its default in the engine, the value that the
    adapter uses, and the reason.
    """

    setting: str
    default: str
    used: str
    why: str


Waiting = Callable[[], float]
"""A function that starts a program, waits for it, and returns the seconds that it took, or raises;
it may be called in any thread.
"""
Stages = Generator[Waiting, Waiting, Result]
"""The work before and after the runs of programs, as a generator.

It yields a `Waiting` for each run, so that the caller may wait for several programs at once. The
caller calls it in any thread, and sends back a function that returns or raises what this call
returned or raised. The return value of the generator is the result.
"""


def finished(stages: Stages[Result]) -> Result:
    """The result of work in stages, whose programs run in this thread one after the other."""
    try:
        # The function is sent back uncalled; the generator calls it, and so waits in this thread.
        waiting = next(stages)
        while True:
            waiting = stages.send(waiting)
    except StopIteration as end:
        result: Result = end.value
        return result


class Engine(ABC):
    """An adapter to a code under test.

    It is given the problem and never the certified answer. Importing the adapter does not import
    the engine itself.
    """

    name: str
    title: str
    methods: tuple[Method, ...]
    audit: tuple[Default, ...] = ()
    licence: str = ""
    is_reference: bool = False
    default_step: float | None = None
    """The default step [s] of the engine; None if the user must always set one."""
    time_limit: float | None = None
    budget: float | None = None
    expected: tuple[Deviation, ...] = ()
    may_refuse: frozenset[str] = frozenset()
    """`time_limit` and `budget` are limits from the engine's own description, in seconds for a run
    and for a campaign. `expected` are the deviations it accepts. `may_refuse` are images of a scene
    (shifted, rotated, mirrored ...) that it may refuse during the run although it runs the scene
    itself.
    """

    @property
    def address(self) -> str:
        """The name or the path of a refdem.toml by which `discovery.engine` finds the engine.

        It is valid in other processes too.
        """
        return self.name

    @abstractmethod
    def missing(self) -> str | None:
        """None if the engine can be run on this machine, else what to install."""

    @abstractmethod
    def version(self) -> str:
        """The version of the engine itself, as it reports it."""

    @abstractmethod
    def fingerprint(self, method: Method) -> str:
        """A digest of everything that can change a run: engine, adapter, and kernels."""

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
        """The methods of that name; without a name all methods that are not `by_name`, and the
        `as_shipped` ones only if requested.
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
