"""The growth of errors (x, v) of one coordinate by formula: for linear forces, and for forces that
are a power of the displacement.

Errors are counted in scales; `ratio` [s] is the scale of x over that of v.
"""

from flint import arb, arb_mat

from refdem.truth.growth import most


def linear(stiffness: arb, sense: int, ratio: arb, t: arb) -> arb_mat:
    """The propagator exp(J t) of x'' = sense * stiffness * x, in scales.

    `sense` is -1 for a spring, 1 for its opposite, 0 for free flight; `stiffness` [1/s^2] is w^2.
    With c = cos w t and s = sin w t (cosh and sinh for the opposite) it is [[c, s/w], [sense w s,
    c]].
    """
    if sense == 0:
        # Free flight: dx(t) = dx(0) + t dv(0), and scale(v)/scale(x) = 1/ratio.
        return arb_mat([[arb(1), t / ratio], [arb(0), arb(1)]])
    rate = stiffness.sqrt()
    if sense < 0:
        even = (rate * t).cos()
        odd = (rate * t).sin()
    else:
        even = (rate * t).cosh()
        odd = (rate * t).sinh()
    # w in units of 1/ratio.
    scaled_rate = rate * ratio
    # [[c, s/w], [sense w s, c]], with w in these units.
    return arb_mat([[even, odd / scaled_rate], [sense * scaled_rate * odd, even]])


def homogeneous(x: arb, v: arb, a: arb, since: arb, power: arb, ratio: arb) -> arb_mat:
    """Two independent errors of a motion x'' = -c |x|^n sgn x, as the columns of a matrix, in the
    state (x, v) with the acceleration a.

    The first is a shift in time, (v, a). The second is a change of the scale of x, with which time
    scales as its power (1 - n)/2: per part of a quantity u with x ~ u^p, p = `power`, it is (p x +
    (1 - p) s v, v + (1 - p) s a), s being the time `since` the start of the scaling. For the speed
    u at touch p = 2/(n + 1); for the amplitude it is 1/p of that error.
    """
    shift = (1 - power) * since
    # Columns (v, a) and (p x + (1 - p) s v, v + (1 - p) s a), in units of the scale of v. The
    # second one is u d/du of x = u^p X(u^(1 - p) s) and of its rate v = u X'(u^(1 - p) s).
    return arb_mat([[v / ratio, (power * x + shift * v) / ratio], [a, v + shift * a]])


def steepness(slope: arb, ratio: arb) -> float:
    """A bound of the norm, in scales, of the Jacobian [[0, 1], [f', 0]] of x'' = f(x) with |f'| <=
    slope.
    """
    # In scales the Jacobian is [[0, 1/ratio], [f' ratio, 0]]; its norm is the largest row sum.
    return most([1 / ratio, slope * ratio])
