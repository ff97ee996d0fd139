"""Truth at the samples of one problem, rounded to doubles with radii: what judging reads and the store keeps."""

import math
from collections.abc import Sequence
from fractions import Fraction

from refdem.core.truth import SampledTruth, Truth
from refdem.errors import NotCertifiedError


def sampled(truth: Truth, times: Sequence[float], delays: Sequence[float] = ()) -> SampledTruth:
    """The truth at these exact binary64 times [s], up to the first at which it cannot be certified, and `delays` [s] earlier."""
    values: dict[str, list[float]] = {}
    radii: dict[str, list[float]] = {}
    certified: list[Fraction] = []
    reason = ""
    for t in (Fraction(float(t)) for t in times):
        try:
            balls, _ = truth.at(t), truth.sensitivity(t)
        except NotCertifiedError as error:
            reason = str(error)
            break
        certified.append(t)
        for name, ball in balls.items():
            value, radius = ball.rounded()
            values.setdefault(name, []).append(value)
            radii.setdefault(name, []).append(radius)
    return SampledTruth(
        t=[float(t) for t in times],
        values=values,
        radii=radii,
        sensitivity=truth.sensitivities(certified),
        scalars=rounded_scalars(truth),
        method=truth.method,
        witness=truth.witness,
        until=len(certified),
        reason=reason,
        earlier={delay: _earlier(truth, certified, Fraction(delay)) for delay in delays if certified},
    )


def _earlier(truth: Truth, certified: Sequence[Fraction], delay: Fraction) -> tuple[dict[str, list[float]], dict[str, list[float]]]:
    """Values and radii so much before each sample; before the first nothing is known: an infinite radius."""
    samples = [truth.at(t - delay) for t in certified[1:]]
    names = truth.at(certified[0])
    rounded = {name: [(0.0, math.inf), *(balls[name].rounded() for balls in samples)] for name in names}
    values = {name: [value for value, _ in pairs] for name, pairs in rounded.items()}
    return values, {name: [radius for _, radius in pairs] for name, pairs in rounded.items()}


def rounded_scalars(truth: Truth) -> dict[str, tuple[float, float]]:
    """The scalars as doubles with radii; none if they cannot be certified."""
    try:
        return {name: ball.rounded() for name, ball in truth.scalars().items()}
    except NotCertifiedError:
        return {}
