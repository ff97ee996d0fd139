"""Truth at the samples of one problem, rounded to doubles with radii: what judging reads and the
store keeps.
"""

import math
from collections.abc import Mapping, Sequence
from fractions import Fraction

from refdem.core.truth import Ball, SampledTruth, Truth
from refdem.errors import NotCertifiedError

PRINTED = 20
"""Decimal places of the scalars that people read."""


def sampled(truth: Truth, times: Sequence[float], delays: Sequence[float] = ()) -> SampledTruth:
    """The truth at these exact binary64 times [s], up to the first at which it cannot be certified.

    The values at the times `delays` [s] before each sample are included.
    """
    certified: list[Fraction] = []
    states: list[Mapping[str, Ball]] = []
    reason = ""
    for sample in times:
        # The exact number that the double is.
        t = Fraction(float(sample))
        try:
            balls = truth.at(t)
            # A time without S is not certified, since the bound on errors would be missing.
            _ = truth.sensitivity(t)
        except NotCertifiedError as error:
            reason = str(error)
            break
        certified.append(t)
        states.append(balls)
    values, radii = _columns(states)
    scalars = certified_scalars(truth)
    rounded = {name: ball.rounded() for name, ball in scalars.items()}
    printed = {name: ball.decimals(PRINTED) for name, ball in scalars.items()}
    earlier = {}
    if certified:
        earlier = {delay: _earlier(truth, certified, Fraction(delay)) for delay in delays}
    return SampledTruth(
        t=[float(t) for t in times],
        values=values,
        radii=radii,
        sensitivity=truth.sensitivities(certified),
        scalars=rounded,
        method=truth.method,
        witness=truth.witness,
        until=len(certified),
        reason=reason,
        printed=printed,
        earlier=earlier,
    )


def _columns(
    states: Sequence[Mapping[str, Ball]],
) -> tuple[dict[str, list[float]], dict[str, list[float]]]:
    """The values and radii of each quantity, rounded to doubles, one a state."""
    values: dict[str, list[float]] = {}
    radii: dict[str, list[float]] = {}
    for balls in states:
        for name, ball in balls.items():
            value, radius = ball.rounded()
            values.setdefault(name, []).append(value)
            radii.setdefault(name, []).append(radius)
    return values, radii


def _earlier(
    truth: Truth, certified: Sequence[Fraction], delay: Fraction
) -> tuple[dict[str, list[float]], dict[str, list[float]]]:
    """The values and radii of each quantity, `delay` [s] before each sample.

    Before the first sample nothing is known: 0 with an infinite radius.
    """
    names = truth.at(certified[0])
    later_values, later_radii = _columns([truth.at(t - delay) for t in certified[1:]])
    values = {name: [0.0, *later_values.get(name, [])] for name in names}
    radii = {name: [math.inf, *later_radii.get(name, [])] for name in names}
    return values, radii


def certified_scalars(truth: Truth) -> Mapping[str, Ball]:
    """The scalars; none if they cannot be certified."""
    try:
        return truth.scalars()
    except NotCertifiedError:
        return {}
