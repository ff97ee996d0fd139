"""A plane as one triangle that no body passes, for codes whose walls are triangles."""

import math

from border import cannot, of_kind


def is_along_an_axis(plane):
    """True for a plane whose normal is +-x, +-y or +-z."""
    return max(map(abs, plane["normal"])) == 1


def reach(request, plane):
    """Distance [m] from a plane's point that no body passes; UnsupportedError for a body that
    starts behind the plane, which a triangle would push the other way.

    r = 2 (x0 + R + (v + g T) T), twice the way of the fastest body.
    """
    cannot(of_kind(request, "spring"), "springs beside planes: how far they throw is not bounded")
    duration = request["times"][-1] - request["times"][0]
    gravity = sum(math.hypot(*field["g"]) for field in of_kind(request, "uniform_gravity"))
    ways = []
    for body in request["scene"]["bodies"]:
        away = [x - p for x, p in zip(body["position"], plane["point"], strict=True)]
        height = sum(a * n for a, n in zip(away, plane["normal"], strict=True))
        cannot(height <= 0, "bodies that start behind a plane")
        speed = math.hypot(*body["velocity"]) + gravity * duration
        ways.append(math.hypot(*away) + body["shape"].get("radius", 0.0) + speed * duration)
    return 2 * max(ways)


def corners(plane, inradius):
    """The corners (3, 3) of an equilateral triangle around the plane's point, anticlockwise as
    seen from the side to which the normal points.
    """
    normal = plane["normal"]
    least = min(range(3), key=lambda k: abs(normal[k]))
    across = cross(normal, [float(k == least) for k in range(3)])
    length = math.hypot(*across)
    first = [a / length for a in across]
    second = cross(normal, first)
    found = []
    for angle in (0.0, 2 * math.pi / 3, 4 * math.pi / 3):
        # The corners are twice the inradius away: p + 2 r (e1 cos a + e2 sin a).
        along = 2 * inradius * math.cos(angle)
        aside = 2 * inradius * math.sin(angle)
        rows = zip(plane["point"], first, second, strict=True)
        found.append([p + along * a + aside * b for p, a, b in rows])
    return found


def cross(a, b):
    """The vector product a x b (3)."""
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
