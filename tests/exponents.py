"""Finite-time Lyapunov exponents (1.133): log sigma_max(D)/t, D being the derivative of the flow
from 0 to t, each number in its scale.

sigma_max^2 is the largest eigenvalue of M = D^T D. Theorem: for P without negative eigenvalues and
tr P = 1, the largest lies between tr P^2 and its root. So with P = M^m/tr M^m, log lambda is known
to (1/m) log(1/tr P^2); m = 2^j by j squarings. Where one eigenvalue stands alone tr P^2 tends to 1
in a few of them; where two are equal m must do it. D comes from the variational equation, across
events with the jump matrix, or from the products of a map's slopes; where a closed form has
neither, from its central differences at 2^-120 of a scale, whose own error, about 2^-240, is in no
radius.
"""

from collections.abc import Sequence
from copy import copy
from fractions import Fraction

from flint import arb, arb_mat, ctx

from refdem.core.truth import Ball, Truth
from refdem.errors import NotCertifiedError
from refdem.truth.balls import UndecidedError, arb_of, ball_of, exclusive, precision
from refdem.truth.events.motion import HybridMotion
from refdem.truth.events.truth import HybridFlow
from refdem.truth.smooth_flow import Variational
from refdem.truth.validated_flow import ValidatedFlow, balls_of
from refdem.truth.validated_ivp.integration import Integration, Steps

LEAST_BITS = 256
"""Bits of the first try."""
MOST_BITS = 2**13
"""The first and the last working precision [bit]."""
MOST_SQUARINGS = 80
"""The most squarings j of M^m, m = 2^j."""
FLOW_BITS = 512
"""The last working precision [bit] of a flow that is integrated: its cost grows much faster than
that of a map.
"""
JACOBIAN_BITS = 96
"""The bits to which the flow Jacobian of a step of a validated flow is known: 1e-20 of an exponent
leaves a third of them to spare.
"""


@exclusive
def exponent(truth: Truth, t: Fraction, *, digits: int = 20) -> Ball:
    """The finite-time Lyapunov exponent log sigma_max(D)/t [1/s, or 1/iterate] at t, with a radius
    of at most 10^-digits.

    The precision is doubled until the radius is met. Raises NotCertifiedError where D is not
    proved.
    """
    target = Fraction(1, 10**digits)
    reason = ""
    bits = LEAST_BITS
    if isinstance(truth, ValidatedFlow | HybridFlow):
        most = FLOW_BITS
    else:
        most = MOST_BITS
    while bits <= most:
        try:
            with precision(bits):
                derivative = variation(truth, t)
                ball = ball_of(log_stretch(derivative, target * t / 2) / arb_of(t))
            if ball.radius <= target:
                return ball
            reason = f"its radius stays at {float(ball.radius):.3g}"
        except (UndecidedError, ValueError) as error:
            reason = str(error)
        bits *= 2
    raise NotCertifiedError(
        f"exponent at t = {float(t):.17g}: {reason}", code="precision", time=float(t)
    )


def exponents(truth: Truth, times: Sequence[Fraction], *, digits: int = 20) -> list[Ball]:
    """Finite-time exponents at several times."""
    return [exponent(truth, t, digits=digits) for t in times]


def log_stretch(derivative: arb_mat, radius: Fraction) -> arb:
    """log sigma_max of a square matrix D, to that radius where its entries allow it.

    With M = D^T D and m = 2^j after j squarings, log sigma_max = (log lambda_max(M^m))/(2 m). M^m
    is kept as P times exp(2 m log_scale), tr P = 1, and lambda_max(P) lies between tr P^2 and its
    root.
    """
    power = derivative.transpose() * derivative
    log_scale = arb(0)
    # 1/(2 m).
    weight = arb(1) / 2
    best: arb | None = None
    for _ in range(MOST_SQUARINGS):
        trace = _trace(power)
        log_scale += weight * trace.log()
        # P, and then P^2.
        power = (1 / trace) * power
        power = power * power
        square = _trace(power)
        bracket = log_scale + weight * square.log().union(square.log() / 2)
        if best is not None and bracket.rad() >= best.rad():
            # What the squarings lose exceeds what they gain.
            break
        best = bracket
        weight = weight / 2
        if best.rad() <= arb_of(radius):
            break
    assert best is not None
    return best


def _trace(matrix: arb_mat) -> arb:
    """The trace of a matrix; UndecidedError unless it is positive."""
    total = sum((matrix[i, i] for i in range(matrix.nrows())), arb(0))
    if not total > 0:
        raise UndecidedError("the derivative of the flow is not known, or zero")
    return total


def variation(truth: Truth, t: Fraction) -> arb_mat:
    """The derivative of the state at t by the start, each number in its scale, at the current
    precision: a square matrix.

    NotCertifiedError for a truth that has no such derivative.
    """
    if isinstance(truth, HybridFlow):
        return _through_events(truth, t)
    if isinstance(truth, ValidatedFlow):
        source: object = _sharper(truth)
    else:
        source = truth
    if not isinstance(source, Variational):
        raise NotCertifiedError(
            f"{type(truth).__name__} has no variational flow", code="end", time=float(t)
        )
    rows = source.jacobian(t)
    return arb_mat(rows.table()[: rows.ncols()])


def _sharper(truth: ValidatedFlow) -> ValidatedFlow:
    """The same flow with its Jacobian to JACOBIAN_BITS; kept, so that its pieces serve all
    times.
    """
    key = ("sharper", ctx.prec)
    if key not in truth.kept:
        steps = Steps(jacobian_bits=JACOBIAN_BITS)
        integration = Integration(truth.field, truth.first, ctx.prec, steps)
        other = copy(truth)
        other.kept = {("integration", ctx.prec): integration}
        truth.kept[key] = other
    sharper: ValidatedFlow = truth.kept[key]
    return sharper


def _through_events(truth: HybridFlow, t: Fraction) -> arb_mat:
    """The derivative of `variation` for a motion from event to event, with the jump matrix at
    each.
    """
    key = ("sharper", ctx.prec)
    kept = truth.proof.kept
    if key not in kept:
        start = balls_of(truth.begin)
        steps = Steps(jacobian_bits=JACOBIAN_BITS)
        kept[key] = HybridMotion(truth.programs, start, truth.first(start), ctx.prec, steps)
    flow = kept[key].jacobian(arb_of(t)).table()
    scales = [arb_of(truth.scale[name]) for name in truth.state]
    moved = list(zip(truth.moved, scales, strict=True))
    return arb_mat(
        [[flow[i][j] * scale_of_start / scale for j, scale_of_start in moved] for i, scale in moved]
    )
