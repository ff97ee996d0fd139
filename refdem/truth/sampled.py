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
    """The truth at these exact binary64 times [s], up to the first at which it cannot be certified,
    and `delays` [s] earlier.
    """
    values: dict[str, list[float]] = {}
    radii: dict[str, list[float]] = {}
    certified: list[Fraction] = []
    reason = ""
    for t in (Fraction(float(t)) for t in times):
        try:
            balls = truth.at(t)
            _ = truth.sensitivity(t)
        except NotCertifiedError as error:
            reason = str(error)
            break
        certified.append(t)
        for name, ball in balls.items():
            value, radius = ball.rounded()
            values.setdefault(name, []).append(value)
            radii.setdefault(name, []).append(radius)
    scalars = certified_scalars(truth)
    return SampledTruth(
        t=[float(t) for t in times],
        values=values,
        radii=radii,
        sensitivity=truth.sensitivities(certified),
        scalars={name: ball.rounded() for name, ball in scalars.items()},
        method=truth.method,
        witness=truth.witness,
        until=len(certified),
        reason=reason,
        printed={name: ball.decimals(PRINTED) for name, ball in scalars.items()},
        earlier={
            delay: _earlier(truth, certified, Fraction(delay)) for delay in delays if certified
        },
    )


def _earlier(
    truth: Truth, certified: Sequence[Fraction], delay: Fraction
) -> tuple[dict[str, list[float]], dict[str, list[float]]]:
    """Values and radii so much before each sample; before the first nothing is known: an infinite
    radius.
    """
    samples = [truth.at(t - delay) for t in certified[1:]]
    names = truth.at(certified[0])
    rounded = {
        name: [(0.0, math.inf), *(balls[name].rounded() for balls in samples)] for name in names
    }
    values = {name: [value for value, _ in pairs] for name, pairs in rounded.items()}
    return values, {name: [radius for _, radius in pairs] for name, pairs in rounded.items()}


def certified_scalars(truth: Truth) -> Mapping[str, Ball]:
    """The scalars; none if they cannot be certified."""
    try:
        return truth.scalars()
    except NotCertifiedError:
        return {}
