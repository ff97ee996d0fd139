"""How errors (x, v) of one coordinate grow where there is a formula: linear forces, and forces that
are a power of the displacement.

Errors are counted in scales; `ratio` [s] is the scale of x over that of v.
"""

from flint import arb, arb_mat

from refdem.truth.growth import most


def linear(stiffness: arb, sense: int, ratio: arb, t: arb) -> arb_mat:
    """exp(J t) of x'' = sense * stiffness * x, sense being -1 for a spring, 1 for its opposite, 0
    for free flight.
    """
    if sense == 0:
        return arb_mat([[arb(1), t / ratio], [arb(0), arb(1)]])
    rate = stiffness.sqrt()
    even, odd = (
        ((rate * t).cos(), (rate * t).sin())
        if sense < 0
        else ((rate * t).cosh(), (rate * t).sinh())
    )
    turn = rate * ratio
    return arb_mat([[even, odd / turn], [sense * turn * odd, even]])


def homogeneous(x: arb, v: arb, a: arb, since: arb, power: arb, ratio: arb) -> arb_mat:
    """Two independent errors of a motion x'' = -c |x|^n sgn x, as columns, in the state (x, v) with
    the acceleration a.

    A shift in time, (v, a), and a change of the scale of x, of which time changes as its power (1 -
    n)/2. Per part of a quantity u that goes with x as u ~ x^(1/p), p = `power`, the latter is (p x
    + (1 - p) s v, v + (1 - p) s a), s being the time since the begin of the scaling: u is the speed
    at touch and p = 2/(n + 1), or, times p, the amplitude.
    """
    late = (1 - power) * since
    return arb_mat([[v / ratio, (power * x + late * v) / ratio], [a, v + late * a]])


def steepness(slope: arb, ratio: arb) -> float:
    """The norm of the Jacobian of x'' = f(x) with |f'| <= slope."""
    return most([1 / ratio, slope * ratio])
