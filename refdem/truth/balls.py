"""Arb balls: made from exact parameters, turned into exact core balls, at a working precision that
is raised until it suffices.
"""

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from fractions import Fraction
from functools import wraps
from inspect import isfunction
from threading import RLock
from typing import Any, ParamSpec, Self, TypeVar

from flint import acb, arb, arb_mat, arb_series, ctx, fmpq

from refdem.core.truth import Ball
from refdem.truth.dual import DualBall, ExactDual, plain
from refdem.truth.exact import refuse_rounded

CONTEXT = RLock()
"""Held while a proof runs: precision and length of series are settings of the whole process in
python-flint, not of a thread.
"""

FARTHEST = 2**13
"""Largest size of the binary exponent of a value that is reported, about 10^2466. Python refuses to
write the decimals of larger numbers, and a fraction such as exp(-1e60), a damped motion long after
its start, would take all memory.
"""

CONSTRUCTORS = ("__init__", "__post_init__")

Parameters = ParamSpec("Parameters")
Result = TypeVar("Result")


def exclusive(function: Callable[Parameters, Result]) -> Callable[Parameters, Result]:
    """A decorator: the function is run by one thread at a time.

    A second thread that set the precision, or cut a series short, meanwhile would change every ball
    of the first one. A thread that holds the lock may call other such functions; it must not wait
    inside `precision` for another thread that proves something.
    """

    @wraps(function)
    def guarded(*given: Parameters.args, **named: Parameters.kwargs) -> Result:
        with CONTEXT:
            return function(*given, **named)

    return guarded


class Guarded:
    """A base of everything that proves: one thread at a time, and from exact numbers alone.

    Public methods and the constructor are run by one thread at a time: so the proofs that any
    number of threads make are, bit for bit, those that one thread makes. The constructor refuses
    rounded numbers where it is annotated with exact ones: 1/3 of ints is rounded, and 0.1 is not
    1/10.
    """

    def __init_subclass__(cls, **named: Any) -> None:
        super().__init_subclass__(**named)
        for name, member in list(vars(cls).items()):
            is_public = name in CONSTRUCTORS or not name.startswith("_")
            if is_public and isfunction(member):
                setattr(cls, name, exclusive(member))

    def __new__(cls, *given: Any, **named: Any) -> Self:
        if given or named:
            refuse_rounded(cls.__init__, given, named)
        return super().__new__(cls)


@contextmanager
def precision(bits: int) -> Iterator[None]:
    """Arb's working precision [bits], restored afterwards; other threads that ask for one wait."""
    with CONTEXT:
        before = ctx.prec
        ctx.prec = bits
        try:
            yield
        finally:
            ctx.prec = before


@contextmanager
def series_length(terms: int) -> Iterator[None]:
    """The number of terms that power series keep, restored afterwards; other threads that ask for
    one wait.
    """
    with CONTEXT:
        before = ctx.cap
        ctx.cap = terms
        try:
            yield
        finally:
            ctx.cap = before


def terms_of(series: arb_series, count: int) -> list[arb]:
    """The first `count` terms of a series.

    RuntimeError if it knows fewer: what is cut off is not 0.
    """
    if series.prec < count:
        raise RuntimeError(
            f"a series knows {series.prec} terms; expected {count}: its length was changed while it"
            " was made"
        )
    return [series[k] for k in range(count)]


class Enclosed(ABC):
    """A number that is known by balls: one at each precision."""

    @abstractmethod
    def ball(self) -> arb:
        """A ball, at the current precision, that contains the number."""


def arb_of(value: "Fraction | int | arb | Enclosed") -> arb:
    """A ball that contains an exact number, at the current precision, with its derivatives if it is
    dual; a ball is returned as it is.

    All numbers enter a proof through this function: TypeError for a binary64, a Decimal or anything
    else that is rounded.
    """
    if isinstance(value, arb):
        return value
    if isinstance(value, Enclosed):
        return value.ball()
    if isinstance(value, ExactDual):
        return DualBall(arb_of(plain(value)), [arb_of(slope) for slope in value.slopes])
    if isinstance(value, bool) or not isinstance(value, int | Fraction):
        message = (
            f"a proof got {value!r} ({type(value).__name__}); expected an exact rational (Fraction"
            " or int) or a ball"
        )
        raise TypeError(f"{message}: a rounded number is not the number that was meant")
    exact = Fraction(value)
    return arb(fmpq(exact.numerator, exact.denominator))


def ball_of(value: arb) -> Ball:
    """The core ball, of exact rational midpoint and radius, that holds an Arb ball.

    It is the same ball unless one of these numbers is below 2^-FARTHEST. ValueError if the ball is
    not finite, or above 2^FARTHEST.
    """
    if not value.is_finite():
        raise ValueError(f"{value} is not finite")
    mid = value.mid()
    radius = _magnitude(value.rad())
    if mid != 0 and _size(mid) < -FARTHEST:
        return Ball(Fraction(0), _magnitude(mid) + radius)
    return Ball(_exact(mid), radius)


def _magnitude(value: arb) -> Fraction:
    """|value| as an exact number, rounded up to 2^-FARTHEST if it is smaller, but for 0."""
    if value == 0:
        return Fraction(0)
    if _size(value) < -FARTHEST:
        return Fraction(1, 2**FARTHEST)
    return abs(_exact(value))


def _size(value: arb) -> int:
    """The least binary exponent with |value| < 2^size, of an exact value."""
    mantissa, exponent = value.man_exp()
    return int(exponent) + int(mantissa).bit_length()


def _exact(value: arb) -> Fraction:
    """The rational value of a ball without a radius; ValueError above 2^FARTHEST."""
    mantissa, exponent = value.man_exp()
    if _size(value) > FARTHEST:
        raise ValueError(f"a value above 2^{FARTHEST} is too large to be told")
    return Fraction(int(mantissa)) * Fraction(2) ** int(exponent)


def outward(value: arb | acb) -> arb:
    """An exact number that |value| does not exceed; nan if it is not finite."""
    return value.abs_upper()


def largest(values: Sequence[arb | acb]) -> arb:
    """An exact upper bound of all absolute values (0 if there are none); nan if one is not
    finite.
    """
    largest_bound = arb(0)
    for bound in map(outward, values):
        if not bound.is_finite():
            return arb("nan")
        if bound > largest_bound:
            largest_bound = bound
    return largest_bound


def nearest_integer(value: arb) -> int:
    """The whole number nearest to the midpoint of a ball; exact, so that it can be taken out of a
    period.
    """
    return round(_exact(value.mid()))


class UndecidedError(ValueError):
    """Balls at this precision cannot tell which branch of a formula holds, or cannot follow a
    motion.

    `code` says which end it is if no precision helps (errors.py lists them); `final` says that more
    bits would not help. Where a motion was followed up to a `time` [s], `balls` has its state
    there, the last certified one.
    """

    def __init__(
        self,
        message: str,
        *,
        code: str = "separatrix",
        final: bool = False,
        time: float | None = None,
        balls: Mapping[str, Ball] | None = None,
    ) -> None:
        super().__init__(message)
        self.code = code
        self.final = final
        self.time = time
        self.balls = dict(balls or {})


SPARE = 32
"""The bits by which the precision is raised beyond those that a radius is too large by: a radius
grows a little with the roundings of a longer computation.
"""


@dataclass(frozen=True)
class Climb:
    """The outcome of raising the precision: the last `balls` (None if the last precision gave
    none), the `reason` why there are none, and the last precision [bit].
    """

    balls: dict[str, Ball] | None
    reason: ValueError | None
    bits: int


def climbed(
    evaluate: Callable[[], dict[str, arb]], target: Fraction, bits: int = 256, most: int = 16384
) -> Climb:
    """The balls of a formula, evaluated at rising precision until every radius is at most `target`.

    It also ends where `most` bits are reached, or no bits can help. The precision begins at `bits`.
    It rises by the bits that the largest radius is too large by, and twofold where the formula is
    undecided or not finite.
    """
    while True:
        balls: dict[str, Ball] | None = None
        reason: ValueError | None = None
        with precision(bits):
            try:
                balls = {name: ball_of(value) for name, value in evaluate().items()}
            except ValueError as error:
                reason = error
        if balls is None:
            largest_radius = None
        else:
            largest_radius = max((ball.radius for ball in balls.values()), default=Fraction(0))
        is_met = largest_radius is not None and largest_radius <= target
        is_final = isinstance(reason, UndecidedError) and reason.final
        if is_met or bits >= most or is_final:
            return Climb(balls, reason, bits)
        if largest_radius is None:
            more_bits = bits
        else:
            missing_bits = (largest_radius / target).__ceil__().bit_length()
            more_bits = max(bits // 4, missing_bits + SPARE)
        bits = min(most, bits + more_bits)


def refined(
    evaluate: Callable[[], dict[str, arb]], target: Fraction, bits: int = 256, most: int = 16384
) -> dict[str, Ball] | None:
    """The balls of `climbed`: None if the formula is undecided or not finite to the end."""
    return climbed(evaluate, target, bits, most).balls


def unit_matrix(size: int) -> arb_mat:
    """The exact unit matrix (size, size)."""
    return arb_mat(size, size, [int(i == j) for i in range(size) for j in range(size)])
