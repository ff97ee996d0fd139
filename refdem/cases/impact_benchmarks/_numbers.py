"""Exact numbers of the benchmarks: what is irrational (pi, roots, logarithms, sines) is the rational nearest to it in 100 digits."""

from decimal import Context, Decimal
from fractions import Fraction
from functools import cache

from refdem.errors import UsageError

DIGITS = Context(prec=100)
PI = Fraction("3.141592653589793238462643383279502884197169399375105820974944592307816406286208998628034825342117067982")

MATERIALS = {
    "glass": ("4.8e10", "0.2", "2800"),
    "limestone": ("2e10", "0.25", "2500"),
    "aluminium-alloy": ("7e10", "0.3", "2699"),
    "magnesium-alloy": ("4e10", "0.35", "1800"),
    "aluminium-oxide": ("3.8e11", "0.23", "4000"),
    "steel": ("2.08e11", "0.3", "7850"),
}
"""Young's modulus [Pa], Poisson's ratio and density [kg/m^3] (Chung and Ooi 2011, tables 1 to 8)."""


def decimal(value: Fraction) -> Decimal:
    """To 100 digits."""
    return DIGITS.divide(Decimal(value.numerator), Decimal(value.denominator))


@cache
def root(value: Fraction) -> Fraction:
    """Square root."""
    return Fraction(DIGITS.sqrt(decimal(value)))


def sine(angle: Fraction) -> Fraction:
    """Of an angle of a few radians, by its series."""
    angle = Fraction(decimal(angle))
    total, term, n = Fraction(0), angle, 1
    while abs(term) > Fraction(1, 10**110):
        total += term
        n += 2
        term = Fraction(decimal(-term * angle * angle / (n * (n - 1))))
    return Fraction(decimal(total))


def ball_mass(density: Fraction, radius: Fraction) -> Fraction:
    """4/3 pi R^3 rho [kg]."""
    return Fraction(4, 3) * PI * radius**3 * density


@cache
def damping(restitution: Fraction, mass: Fraction, stiffness: Fraction, cutoff: str) -> Fraction:
    """The dashpot [kg/s] that gives a linear contact of this effective mass its restitution e > 0: ln e = -b t_c.

    With b = w0 cos a, t_c w0 is pi/sin a until the overlap ends, 2a/sin a until the force does (e > 1/e^2).
    """
    if restitution == 1:
        return Fraction(0)
    decay = -Fraction(DIGITS.ln(decimal(restitution)))
    if cutoff == "zero_overlap":
        return 2 * decay * root(mass * stiffness / (PI**2 + decay**2))
    if not decay < 2:
        raise UsageError(f"parameter restitution: got {float(restitution):g}; expected more than exp(-2) where the force must not pull")
    angle = PI / 2 - decay / 4
    for _ in range(12):
        cosine, size = sine(angle + PI / 2), sine(angle)
        step = Fraction(decimal((2 * angle * cosine / size - decay) / (2 * cosine / size - 2 * angle / size**2)))
        angle = Fraction(decimal(max(angle / 2, min(angle - step, PI / 2))))
    return 2 * sine(angle + PI / 2) * root(mass * stiffness)


def hertz_stiffness(modulus: Fraction, poisson: Fraction, radius: Fraction, *, wall: bool) -> Fraction:
    """4/3 E* sqrt(R*) [N/m^(3/2)] of a sphere on a rigid wall, or of two equal spheres: E* = E/(1 - nu^2) and R, or half of each."""
    stiff, size = modulus / (1 - poisson**2), radius
    return Fraction(4, 3) * (stiff * root(size) if wall else stiff / 2 * root(size / 2))


def mindlin_stiffness(modulus: Fraction, poisson: Fraction, radius: Fraction) -> Fraction:
    """8 G* sqrt(R) [N/m^(3/2)] of a sphere on a rigid wall without slip (Mindlin 1949): G* = G/(2 - nu), G = E/(2 (1 + nu))."""
    return 4 * modulus / ((1 + poisson) * (2 - poisson)) * root(radius)
