"""Fields of the tests, each written from its equation of motion, and integrations of them."""

from fractions import Fraction
from functools import partial

from refdem.truth.balls import arb_of
from refdem.truth.validated_ivp.integration import Integration, Steps


def harmonic(y):
    """x'' = -x."""
    return [y[1], -y[0]]


def squares(y):
    """y' = y^2: 1/(1/y0 - t)."""
    return [y[0] * y[0]]


def decay(y):
    """y' = -y."""
    return [-y[0]]


def growth(y):
    """y' = y by 1 * y and an exponential of time: (e^t, t, e^t - 1)."""
    return [y[0], 1, y[1].exp()]


def power(n):
    """(t, t^(n+1)), the only motion for which Cauchy's estimate of c_(n+1) is sharp."""

    def field(y):
        product = n + 1
        for _ in range(n):
            product = product * y[0]
        return [1, product]

    return field


def pendulum(y):
    """theta'' = -sin theta."""
    return [y[1], -y[0].sin()]


def kepler(y):
    """x'' = -x/r^3."""
    square = y[0] * y[0] + y[1] * y[1]
    cube = square * square.sqrt()
    return [y[2], y[3], -y[0] / cube, -y[1] / cube]


def van_der_pol(y):
    """x'' = 2 (1 - x^2) x' - x."""
    return [y[1], 2 * (1 - y[0] * y[0]) * y[1] - y[0]]


def duffing(y):
    """x'' + x'/4 - x + x^3 = 3/10 cos t; time is the third coordinate."""
    return [y[1], y[0] - y[0] * y[0] * y[0] - y[1] / 4 + Fraction(3, 10) * y[2].cos(), 1]


def kapitza(y):
    """theta'' = (1 + 2 cos(8 t)) sin theta about the upright position."""
    return [y[1], (1 + 2 * (8 * y[2]).cos()) * y[0].sin(), 1]


def double_pendulum(y):
    """Equal masses and rods, g = l = 1: the explicit accelerations of both angles."""
    a, b, u, v = y
    d = a - b
    share = 3 - (2 * d).cos()
    first = -3 * a.sin() - (a - 2 * b).sin() - 2 * d.sin() * (v * v + u * u * d.cos())
    second = 2 * d.sin() * (2 * u * u + 2 * a.cos() + v * v * d.cos())
    return [u, v, first / share, second / share]


def rigid_body(y):
    """Euler's equations for inertia 1, 2, 3 and q' = q omega/2."""
    (a, b, c) = y[:3]
    (w, x, y_, z) = y[3:]
    half = Fraction(1, 2)
    turning = [
        -(x * a + y_ * b + z * c),
        w * a + y_ * c - z * b,
        w * b + z * a - x * c,
        w * c + x * b - y_ * a,
    ]
    return [-b * c, c * a, -a * b / 3, *(half * rate for rate in turning)]


def exact(values):
    """Balls of exact numbers at the current precision."""
    return [arb_of(Fraction(value)) for value in values]


def integration(field, start, *, bits=200, ratio="1/6", order=None, jacobian_order=None):
    """An integration from exact numbers."""
    return Integration(
        field, partial(exact, start), bits, Steps(Fraction(ratio), order, jacobian_order)
    )


def at(field, start, t, **options):
    """The state at an exact time."""
    return integration(field, start, **options).at(arb_of(Fraction(t)))
