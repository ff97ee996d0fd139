"""A case: a canonical problem with parameters; an instance: the case at one set of them."""

from abc import ABC, abstractmethod
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cached_property
from typing import Any, ClassVar, Literal

import numpy as np
from numpy.typing import NDArray

from refdem.core.parameters import LARGEST, SMALLEST, Parameter, Parameters
from refdem.core.problem import Ensemble, Iteration, Motion, Problem
from refdem.core.quantity import Quantity, Scales
from refdem.core.trajectory import Trajectory
from refdem.core.truth import Truth
from refdem.errors import UsageError
from refdem.scene import Scene

Array = NDArray[np.float64]

SHORTEST = 1e-6
"""Smallest duration in units of tau: in a shorter one the motion is hidden by round-off."""
LONGEST = 1e12
"""Largest duration in units of tau: the rounding of one parameter, u = 1.1e-16, then changes the
phase by 1e12 u = 1e-4.
"""

NEVER: Mapping[str, str] = {}
"""`chaotic_at` of a case that is never chaotic, whatever its parameters."""


def given(**parameters: str) -> Mapping[str, str]:
    """The parameters as a mapping from name to text, which is the form of `chaotic_at`."""
    return parameters


@contextmanager
def within_binary64(label: str) -> Iterator[None]:
    """Context in which overflow, division by zero and invalid operations raise UsageError.

    These occur if parameters that are each within their bounds together lead to numbers outside the
    range of binary64.
    """
    try:
        with np.errstate(over="raise", divide="raise", invalid="raise"):
            yield
    except ArithmeticError as error:
        reason = "what follows from these parameters is too large or too small for binary64"
        raise UsageError(f"{label}: {reason} ({error.args[-1]}): take other parameters") from error


Moving = Literal[
    "spinning",
    "swinging",
    "oscillating",
    "rubbing",
    "colliding",
    "orbiting",
    "flying",
    "formula",
    "other",
]
"""What happens in a case: bodies turn freely or about a joint; hang on rods and strings; move on
springs or in fields; rub, stick and roll; collide; attract each other; fly without contact. A
"formula" has no motion: identities, tensors and maps. "other" is the default.
"""

CLOCK = (
    Parameter(
        name="duration",
        default="",
        unit="s",
        doc="how long the motion lasts; 20 tau by default",
        above=0,
    ),
    Parameter(
        name="samples",
        default="64",
        unit="1",
        doc="number of sample intervals",
        at_least=2,
        at_most=100_000,
        whole=True,
    ),
)


class Canonical(ABC):
    """A canonical problem of any kind.

    Adding one is one file in cases/ with an instance of a subclass named CASE.
    """

    id: ClassVar[str]
    title: ClassVar[str]
    words: ClassVar[tuple[str, ...]] = ()
    motion: ClassVar[Moving] = "other"
    statement: ClassVar[str]
    latex: ClassVar[str]
    source: ClassVar[str]
    parameters: ClassVar[tuple[Parameter, ...]]
    exclude: ClassVar[Mapping[str, str]] = {}
    clock: ClassVar[tuple[Parameter, ...]] = ()
    chaotic_at: ClassVar[Mapping[str, str] | None] = None

    @abstractmethod
    def problem(self, p: Parameters) -> Problem:
        """The problem that engines are given for these parameters."""

    @abstractmethod
    def scales(self, p: Parameters) -> Scales:
        """Length, shortest time, default duration (which `duration` replaces) and mass."""

    def lasting(self, p: Parameters) -> Scales:
        """The scales, with the requested duration."""
        return self.scales(p)

    @abstractmethod
    def quantities(self, p: Parameters) -> tuple[Quantity, ...]:
        """The quantities that are compared, with their scales."""

    @abstractmethod
    def observe(self, p: Parameters, trajectory: Trajectory) -> dict[str, Array]:
        """Every quantity (T,) that can be computed from the trajectory, by name.

        A quantity whose channel is missing from the trajectory is omitted.
        """

    @abstractmethod
    def truth(self, p: Parameters) -> Truth:
        """The certified values; raises NotCertifiedError where there are none."""

    def refuse(self, p: Parameters) -> None:  # noqa: B027 (most cases have nothing to refuse)
        """Raises UsageError for values that are each in bounds but do not go together."""

    def meant(self, p: Parameters) -> Mapping[str, Any]:
        """The exact values of the parameters, from which a witness of the truth computes.

        They are the parameters themselves unless a case derives others from them.
        """
        return p

    def written_out(self, p: Parameters) -> Parameters:
        """The parameters with every named choice replaced by the numbers that it selects.

        They are the parameters themselves unless a case has such choices.
        """
        return p

    def is_chaotic(self, p: Parameters) -> bool | None:
        """True at the parameters `chaotic_at`, False where that is NEVER.

        None at other parameters, and where the case does not declare `chaotic_at`: not known.
        """
        if self.chaotic_at is None:
            return None
        if self.chaotic_at == NEVER:
            return False
        chaotic = {name: p.declared[name].parsed(text) for name, text in self.chaotic_at.items()}
        if all(p[name] == value for name, value in chaotic.items()):
            return True
        return None

    def exclude_for(self, p: Parameters) -> Mapping[str, str]:
        """Checks that are left out at these parameters, with reasons."""
        return self.exclude

    def at(self, **given: str) -> "Instance":
        """The case at one set of parameters, each as text; raises UsageError."""
        p = Parameters((*self.parameters, *self.clock), given)
        instance = Instance(self, p)
        with within_binary64(instance.label):
            self.refuse(p)
            instance.refuse_unjudgeable()
        return instance


class Timed(Canonical):
    """A canonical problem in time: it lasts `duration`, divided into `samples` intervals."""

    clock = CLOCK

    def lasting(self, p: Parameters) -> Scales:
        """The scales, with the requested duration."""
        default = self.scales(p)
        return Scales(default.length, default.tau, p.duration or default.duration, default.mass)

    def times(self, p: Parameters) -> Array:
        """Times (T,) [s] of the samples, T = samples + 1, from 0 to about the duration.

        They are whole multiples of one interval, whose mantissa is rounded to 20 bits. Multiples
        of the interval and its halvings, which are the steps, are then exact in binary64.
        """
        samples = int(p.samples)
        # duration/samples = mantissa 2^exponent, 1/2 <= mantissa < 1.
        mantissa, exponent = np.frexp(self.lasting(p).duration / samples)
        interval = np.ldexp(np.round(np.ldexp(mantissa, 20)), int(exponent) - 20)
        return np.asarray(np.arange(samples + 1) * interval, dtype=np.float64)


class Case(Timed):
    """A canonical motion: a scene that moves for `duration`, divided into `samples` intervals."""

    @abstractmethod
    def scene(self, p: Parameters) -> Scene:
        """The scene in its initial state."""

    def problem(self, p: Parameters) -> Motion:
        """The motion of the scene over the samples of the case."""
        return Motion(self.scene(p), self.times(p))


class EnsembleCase(Timed):
    """A canonical flow: a closed outline of points in phase space (x, v) is carried along by it."""

    @abstractmethod
    def problem(self, p: Parameters) -> Ensemble:
        """The scene, and the points of the outline as its starts."""

    @abstractmethod
    def starts(self, p: Parameters, outline: Array) -> tuple[Array, Array]:
        """Position and velocity (M, N, 3) of M points (M, 2) of the phase plane (x, v)."""

    @abstractmethod
    def outline(self, p: Parameters, trajectory: Trajectory) -> tuple[Array, Array]:
        """Coordinates x and v (T, M) of the points of the closed outline, in order along it."""


class IterationCase(Canonical):
    """A canonical iteration of a map; tau is one iteration, the duration their number."""

    @abstractmethod
    def problem(self, p: Parameters) -> Iteration:
        """The iteration: map, start and number of iterates."""


@dataclass(frozen=True, eq=False)
class Instance:
    """A case at one set of parameters."""

    case: Canonical
    p: Parameters

    @cached_property
    def label(self) -> str:
        """`case[name=value name=value]`, with the parameters that differ from their defaults."""
        changed = " ".join(f"{name}={value}" for name, value in self.p.changed().items())
        if changed:
            return f"{self.case.id}[{changed}]"
        return self.case.id

    @cached_property
    def scene(self) -> Scene:
        """The scene at its start; raises UsageError where the question is not a motion."""
        return self.problem.scene

    @cached_property
    def scales(self) -> Scales:
        """The scales, with the requested duration."""
        return self.case.lasting(self.p)

    def refuse_unjudgeable(self) -> None:
        """Raises UsageError for scales whose squares and products binary64 cannot hold, or a
        duration outside SHORTEST to LONGEST tau.
        """
        scales = self.scales
        all_scales = [scales.length, scales.tau, scales.mass, scales.energy]
        all_scales += [quantity.scale for quantity in self.quantities.values()]
        if not all(SMALLEST < scale < LARGEST for scale in all_scales):
            listed = (
                f"length {scales.length:.3g} m, time {scales.tau:.3g} s, mass {scales.mass:.3g} kg,"
                f" energy {scales.energy:.3g} J"
            )
            raise UsageError(
                f"{self.label}: the scales come to {listed}; expected each between 1e-100 and"
                " 1e100: take other parameters"
            )
        duration_in_tau = scales.duration / scales.tau
        if not SHORTEST <= duration_in_tau <= LONGEST:
            got = (
                f"{scales.duration:.6g} s, {duration_in_tau:.3g} times the shortest time tau ="
                f" {scales.tau:.6g} s of the motion; expected {SHORTEST:g} to {LONGEST:g} times tau"
            )
            if "duration" in self.p.changed():
                raise UsageError(f"parameter duration: got {got}")
            raise UsageError(f"{self.label}: it lasts {got}: take other parameters")

    @cached_property
    def quantities(self) -> dict[str, Quantity]:
        """The quantities that are compared, by name."""
        with within_binary64(self.label):
            return {q.name: q for q in self.case.quantities(self.p)}

    @cached_property
    def times(self) -> Array:
        """Samples (T,): times [s] of a motion, numbers of iterations of a map."""
        return self.problem.times

    @cached_property
    def problem(self) -> Problem:
        """The problem that engines are given."""
        with within_binary64(self.label):
            return self.case.problem(self.p)

    @property
    def motion(self) -> Motion:
        """The requested motion; raises UsageError for a problem of another kind."""
        if not isinstance(self.problem, Motion):
            raise UsageError(f"{self.label} asks for {self.problem.words}, not for a motion")
        return self.problem

    def observe(self, trajectory: Trajectory) -> dict[str, Array]:
        """Every quantity that the trajectory shows, each (T,)."""
        return self.case.observe(self.p, trajectory)

    def truth(self) -> Truth:
        """The certified values of this instance."""
        return self.case.truth(self.p)
