"""What the families of by_mpmath.py share: 60 digits, the integrator, and what has been said."""

from mpmath import cos, mp, mpf, nstr, odefun, sin

mp.dps = 60
FOUND = []


def f(text):
    """A decimal or a fraction."""
    top, _, bottom = text.partition("/")
    return mpf(top) / mpf(bottom or 1)


def ode(rates, start, t):
    """The state at t."""
    return odefun(rates, mpf(0), [mpf(x) for x in start])(t)


def waves(*rates):
    """cos and sin of w t as unknowns: their starts, and their rates by their values (mpmath's
    Taylor series like polynomials).
    """
    return [1, 0] * len(rates), lambda y: [
        x for n, w in enumerate(rates) for x in (-w * y[2 * n + 1], w * y[2 * n])
    ]


def case(name, given, t, **found):
    """Says values of a case."""
    for quantity, value in found.items():
        FOUND.append(
            (
                name,
                given,
                t,
                quantity.replace("__", "-").replace("_o_", "."),
                nstr(mp.re(value), 48),
            )
        )


def second(accelerate, x, v, t, *drives):
    """x and v of x'' = accelerate(x, v, cosines of the drives)."""
    start, turn = waves(*drives)
    found = ode(
        lambda s, y: [y[1], accelerate(y[0], y[1], *y[2::2]), *turn(y[2:])], (x, v, *start), t
    )
    return {"x": found[0], "v": found[1]}


def swung(strength, theta, rate, t):
    """Angle and rate of theta'' = strength sin theta; its cosine and sine are unknowns."""
    rates = lambda s, y: [y[1], strength * y[3], -y[3] * y[1], y[2] * y[1]]  # noqa: E731
    return ode(rates, (theta, rate, cos(theta), sin(theta)), t)[:2]
