"""Numbers that follow from the parameters of a contact: masses of spheres, the dashpot of a
restitution, Hertz's and Mindlin's stiffness.
"""

from fractions import Fraction

from flint import arb

from refdem.truth.balls import arb_of
from refdem.truth.dual import ball, carried
from refdem.truth.power_contact import root as solved
from refdem.truth.reals import Number, Real, is_zero, logarithm, pi, root

LEAST_SLOPE = Fraction(2, 3)
"""The least derivative by z of h(z) = 2 - 2 sqrt(z) cot sqrt(z), for 0 <= z < pi^2: all
coefficients of its power series are positive, the first is 2/3.
"""


def sphere_mass(density: Fraction, radius: Fraction) -> Real:
    """4/3 pi R^3 rho [kg] of a solid sphere; density [kg/m^3], radius [m]."""
    mass: Real = Fraction(4, 3) * radius**3 * density * pi()
    return mass


def dashpot(
    restitution: Fraction, mass: Number, stiffness: Fraction, *, ends_with_overlap: bool
) -> Number:
    """The damping c [kg/s] that gives a linear contact of this effective mass [kg] and stiffness
    [N/m] its restitution 0 < e <= 1.

    With w0 = sqrt(k/m) and c/(2m) = w0 cos(alpha) the contact lasts t_c = pi/(w0 sin alpha) until
    the overlap ends and 2 alpha/(w0 sin alpha) until the force does, and ln(1/e) = t_c c/(2m)
    (Schwager and Poeschel 2007). So cos alpha = D/sqrt(pi^2 + D^2) until the overlap ends, and 2
    alpha cot alpha = D until the force does, with D = ln(1/e), which is below 2 for every damping
    that is not over-critical: ValueError for an e that is not above exp(-2) there.
    """
    # D = ln(1/e), and c = 2 cos(alpha) sqrt(m k).
    decay = -logarithm(restitution)
    if is_zero(decay):
        return Fraction(0)
    # At e = 1 both laws have c = 0 and dc/dD = (2/pi) sqrt(m k).
    if ends_with_overlap or restitution == 1:
        return 2 * decay * root(mass * stiffness / (pi() ** 2 + decay**2))
    if not decay < 2:
        raise ValueError(f"restitution {restitution} is not above exp(-2)")
    damping: Number = 2 * Real(lambda: damping_cosine(arb_of(decay))) * root(mass * stiffness)
    return damping


def damping_cosine(decay: arb) -> arb:
    """cos(alpha) with 2 alpha cot(alpha) = decay and 0 < alpha < pi/2, for 0 < decay < 2.

    In z = alpha^2 the function h(z) = 2 - 2 sqrt(z) cot sqrt(z) is analytic and grows from 0 at
    least as fast as LEAST_SLOPE z, so that h(z) = 2 - decay has exactly one root, also where alpha
    is nearly 0 (restitution near exp(-2)) and a root in alpha itself would be nearly double.
    For any z at which an iteration ends, |h(z) - (2 - decay)|/LEAST_SLOPE bounds its error. The
    root is never above (2 - decay)/LEAST_SLOPE, which is the only bound where 2 - decay is lost in
    rounding.
    """
    goal = 2 - ball(decay)
    least = arb_of(LEAST_SLOPE)
    # All z that the bound (2 - decay)/LEAST_SLOPE allows, and the root itself where it is found.
    square = arb(0).union(arb((goal / least).upper()))
    if goal > 0:
        z = solved(shortfall, shortfall_slope, goal, least)
        if z.is_finite() and z > 0:
            square = z
    # cos sqrt(z) falls with z: its values at both ends of z are sharper than that of a ball, whose
    # radius sqrt would blow up near 0.
    low = arb(square.upper()).sqrt().cos()
    if square > 0:
        high = arb(square.lower()).sqrt().cos()
    else:
        high = arb(1)
    return carried(low.union(high), (damping_cosine_slope(square), decay))


def damping_cosine_slope(square: arb) -> arb:
    """d cos(alpha)/d decay = sin(alpha)/(2 alpha h'(z)), z being alpha^2 = `square`.

    With h'(z) = (1 - sin(2 alpha)/(2 alpha))/sin^2(alpha) it is sin^3(alpha)/(2 alpha - sin 2
    alpha); not finite where the ball of z holds 0.
    """
    angle = square.sqrt()
    sine = angle.sin()
    # sin(alpha)/(2 alpha h'(z)) = sin^3(alpha)/(2 alpha - sin(2 alpha))
    return sine**3 / (2 * angle - (2 * angle).sin())


def shortfall(square: arb) -> arb:
    """The function h(z) = 2 - 2 sqrt(z) cot sqrt(z) of `damping_cosine` at z = `square`."""
    angle = square.sqrt()
    # sqrt(z) cot sqrt(z) = cos(alpha)/sinc(alpha), with alpha = sqrt(z).
    return 2 - 2 * angle.cos() / angle.sinc()


def shortfall_slope(square: arb) -> arb:
    """The derivative h'(z) = (z - c + c^2)/z with c = sqrt(z) cot sqrt(z), for Newton's steps.

    LEAST_SLOPE where rounding would spoil it; no proof rests on it.
    """
    cotangent = 1 - shortfall(square) / 2
    slope = (square - cotangent + cotangent * cotangent) / square
    if slope > arb_of(LEAST_SLOPE):
        return slope
    return arb_of(LEAST_SLOPE)


def hertz_modulus(modulus: Fraction, poisson: Fraction) -> Fraction:
    """4/3 E/(1 - nu^2) [Pa]: times sqrt(R) it is Hertz's stiffness of a sphere on a rigid wall."""
    return Fraction(4, 3) * modulus / (1 - poisson**2)


def hertz_wall_stiffness(modulus: Fraction, poisson: Fraction, radius: Fraction) -> Number:
    """4/3 E* sqrt(R) [N/m^(3/2)] of a sphere on a rigid wall, E* = E/(1 - nu^2) (Hertz 1882)."""
    return hertz_modulus(modulus, poisson) * root(radius)


def hertz_pair_stiffness(modulus: Fraction, poisson: Fraction, radius: Fraction) -> Number:
    """4/3 E* sqrt(R*) [N/m^(3/2)] of two equal spheres: half of a wall's E*, and R* = R/2."""
    return hertz_modulus(modulus, poisson) / 2 * root(radius / 2)


def mindlin_modulus(modulus: Fraction, poisson: Fraction) -> Fraction:
    """8 G* [Pa] of a sphere on a rigid wall, G* = G/(2 - nu) and G = E/(2 (1 + nu)) (Mindlin
    1949).
    """
    return 4 * modulus / ((1 + poisson) * (2 - poisson))


def mindlin_wall_stiffness(modulus: Fraction, poisson: Fraction, radius: Fraction) -> Number:
    """8 G* sqrt(R) [N/m^(3/2)] of a sphere on a rigid wall without slip (Mindlin 1949)."""
    return mindlin_modulus(modulus, poisson) * root(radius)
