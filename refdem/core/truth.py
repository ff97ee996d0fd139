"""Certified values: balls with an exact midpoint and a proven radius, and their samples rounded to
doubles, with which runs are compared.
"""

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction

import msgspec
import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Ball:
    """The closed interval [mid - radius, mid + radius], both exact."""

    mid: Fraction
    radius: Fraction

    def __post_init__(self) -> None:
        """Raises TypeError for a number that is not exact, such as a float."""
        for value in (self.mid, self.radius):
            if isinstance(value, bool) or not isinstance(value, int | Fraction):
                type_name = type(value).__name__
                raise TypeError(
                    f"a ball got {value!r} ({type_name}); expected exact numbers (Fraction or int)"
                )

    def __float__(self) -> float:
        """The double nearest to the middle; the ball need not contain it (see `rounded`)."""
        return float(self.mid)

    def rounded(self) -> tuple[float, float]:
        """The nearest double and a radius about it (rounded up) that contains the ball."""
        mid = float(self.mid)
        radius = float(abs(self.mid - Fraction(mid)) + self.radius)
        return mid, float(np.nextafter(radius, np.inf)) if radius else 0.0

    def decimals(self, places: int = 60) -> tuple[str, str]:
        """Decimal midpoint and decimal radius of an interval that contains the ball.

        The midpoint has as many decimal places as the radius warrants, but at most `places`. The
        radius covers the rounding of the midpoint, |mid - decimal| + radius, and is rounded up.
        """
        if self.radius:
            # Two digits beyond the first one of the radius.
            places = min(places, -_exponent(self.radius) + 2)
        unit = Fraction(10) ** -places
        scaled = round(self.mid / unit)
        radius = abs(self.mid - scaled * unit) + self.radius
        return _decimal(scaled, places), _rounded_up(radius)


def _exponent(value: Fraction) -> int:
    """The decimal exponent floor(log10(value)) of a value > 0."""
    guess = len(str(value.numerator)) - len(str(value.denominator))
    if value >= Fraction(10) ** guess:
        return guess
    return guess - 1


def _decimal(scaled: int, places: int) -> str:
    """The decimal string of scaled * 10**-places."""
    if places <= 0:
        return str(scaled * 10**-places)
    digits = str(abs(scaled)).rjust(places + 1, "0")
    return ("-" if scaled < 0 else "") + digits[:-places] + "." + digits[-places:]


def _rounded_up(value: Fraction) -> str:
    """Three significant digits, rounded away from zero, in scientific notation."""
    if not value:
        return "0"
    exponent = _exponent(value) - 2
    # ceil(x) = -floor(-x); it has three digits, or four where it rounds up to 1000.
    digits = str(-((-value / Fraction(10) ** exponent).__floor__()))
    return f"{digits[0]}.{digits[1:3]}e{exponent + len(digits) - 1}"


class Truth(ABC):
    """The certified values of a case's quantities as functions of time.

    `method` states how they are proved, `witness` which independent computation checks them.
    """

    method: str
    witness: str

    @abstractmethod
    def at(self, t: Fraction) -> Mapping[str, Ball]:
        """Every quantity at the exact time t [s]; raises NotCertifiedError where it cannot be
        proved.
        """

    @abstractmethod
    def sensitivity(self, t: Fraction) -> float:
        """S(t) >= 1, a bound on error growth: an error made at any time s in [0, t] is at t at most
        S(t) times as large as at s, to first order in the error.

        With D(t) the derivative of the state at t by the initial state, in coordinates scaled like
        the quantities,

            sup over 0 <= s <= t of |D(t) D(s)^-1|  <=  S(t).

        The norm at s and at t is the largest Euclidean length of any part of the state. Rotation
        and angular velocity of a free body are one part each; otherwise every coordinate is one.

        Bounds use the largest S so far (`SampledTruth.growth`). S(t) depends on t alone, not on the
        other requested times.
        """

    def refined(self, digits: int) -> "Truth":
        """The same truth with radii of at most 10^-digits, if radii can be chosen; else itself."""
        return self

    def sensitivities(self, times: Sequence[Fraction]) -> list[float]:
        """Error growth S at the samples of a run, one number each."""
        return [self.sensitivity(t) for t in times]

    def scalars(self) -> Mapping[str, Ball]:
        """Values that do not depend on time: periods, durations, numbers of flips."""
        return {}

    def forecast(self, t: Fraction, digits: int) -> float:
        """Estimated CPU seconds of `at(t)` with radii of at most 10^-digits; 0 if negligible."""
        return 0.0


class SampledTruth(msgspec.Struct, frozen=True, kw_only=True):
    """Truth at the samples of one problem: doubles with radii, for judgement and for the
    store.

    `until` is the number of certified samples, `reason` states why there are no more. `values` and
    `radii` (until,) are by quantity, `sensitivity` (until,) is S. `scalars` are (value, radius),
    `printed` the same in decimals. `earlier` maps a delay [s] to (values, radii) at that time
    before each sample, for velocities that lag. Times before the first sample are not certified:
    the radius there is infinite.
    """

    t: list[float]
    values: dict[str, list[float]]
    radii: dict[str, list[float]]
    sensitivity: list[float]
    scalars: dict[str, tuple[float, float]]
    method: str
    witness: str
    until: int
    reason: str = ""
    printed: dict[str, tuple[str, str]] = {}
    earlier: dict[float, tuple[dict[str, list[float]], dict[str, list[float]]]] = {}

    def value(self, name: str) -> Array:
        """The certified samples of one quantity (until,)."""
        return np.array(self.values[name])

    def radius(self, name: str) -> Array:
        """Radius (until,) of the certified values of a quantity."""
        return np.array(self.radii[name])

    def delayed(self, delay: float) -> "SampledTruth":
        """The truth `delay` [s] before each sample; `earlier` must contain this delay."""
        values, radii = self.earlier[delay]
        return msgspec.structs.replace(self, values=values, radii=radii)

    def growth(self) -> Array:
        """The largest S so far (until,), at least 1: a bound on the growth of earlier errors."""
        return np.maximum.accumulate(np.maximum(1.0, np.array(self.sensitivity)))
