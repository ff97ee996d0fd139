"""Independent ways to iterates: exact rationals, doubled angles, and chords in decimal arithmetic.

Fixtures give them by name.
"""

from decimal import Decimal, localcontext
from fractions import Fraction

import pytest


def rational_orbit(eta, x0, n):
    """x_n of the logistic map, exactly."""
    x = Fraction(x0)
    for _ in range(n):
        x = Fraction(eta) * x * (1 - x)
    return x


def rectangle_path(size, start, direction, n):
    """Place and reflected direction after n bounces, exactly, bounce by bounce in the table itself
    (no unfolding).
    """
    place = [Fraction(x) for x in start]
    speed = [Fraction(u) for u in direction]
    for _ in range(n):
        ways = [
            ((Fraction(s) / 2 if u > 0 else -Fraction(s) / 2) - x) / u if u else None
            for x, u, s in zip(place, speed, size, strict=True)
        ]
        axis = min((i for i in (0, 1) if ways[i] is not None), key=lambda i: ways[i])
        place = [x + ways[axis] * u for x, u in zip(place, speed, strict=True)]
        speed[axis] = -speed[axis]
    return place, speed


def stadium_path(size, start, direction, n, digits=200):
    """Place and direction after n bounces: all four pieces are tried, the nearest hit that lies on
    its piece counts.

    The reflection is that of complex numbers, u -> -nu^2 conj(u) for a unit normal nu.
    """
    with localcontext() as context:
        context.prec = digits
        r = Decimal(str(size[1])) / 2
        a = Decimal(str(size[0])) / 2 - r
        x, y, u, v = (Decimal(str(value)) for value in (*start, *direction))
        length = (u * u + v * v).sqrt()
        u = u / length
        v = v / length
        for _ in range(n):
            hits = [*_walls(x, y, u, v, r, a), *_circles(x, y, u, v, r, a)]
            t, n_x, n_y = min(hit for hit in hits if hit[0] > Decimal(10) ** (-digits // 2))
            x = x + t * u
            y = y + t * v
            re = n_x * n_x - n_y * n_y
            im = 2 * n_x * n_y
            u, v = -(re * u + im * v), -(im * u - re * v)
        return x, y, u, v


def _walls(x, y, u, v, r, a):
    return [
        (t, Decimal(0), Decimal(s))
        for s in (1, -1)
        if v and abs(x + (t := (s * r - y) / v) * u) <= a
    ]


def _circles(x, y, u, v, r, a):
    found = []
    for s in (1, -1):
        q = x - s * a
        b = q * u + y * v
        c = q * q + y * y - r * r
        if b * b > c:
            for t in (-b - (b * b - c).sqrt(), -b + (b * b - c).sqrt()):
                if s * (x + t * u) >= a:
                    found.append((t, (q + t * u) / r, (y + t * v) / r))
    return found


@pytest.fixture
def paths():
    """The functions above by name."""
    return {"logistic": rational_orbit, "rectangle": rectangle_path, "stadium": stadium_path}
