"""Two sections of the mass on a belt, by mpmath's Taylor integrator phase by phase."""

from mpmath import cos, findroot, mp, mpf, odefun, pi, sin

from tests.properties.held_out.mpmath_tools import case, f

GIVEN = {
    "a": "9",
    "lambda0": "3/2",
    "friction_law": "quadratic",
    "belt": "3/4",
    "gamma": "5/2",
    "eta": "6/5",
    "x0": "1",
    "v0": "-1/2",
}
SCAN = mpf(1) / 32
STROBES = 3
PASSAGES = 4


def friction(u):
    """The friction a mu(u) at a relative speed u >= 0."""
    return f("9") * (f("0.3") / (1 + f("3/2") * u) + f("0.1") + f("0.01") * u * u)


def pull(t, x):
    """What friction balances while it sticks."""
    return f("5/2") * cos(f("6/5") * t) - x - friction(f("3/4"))


def root(function, low, high):
    """The zero between two times."""
    return findroot(function, (low, high), solver="anderson", tol=mpf(10) ** (20 - 2 * mp.dps))


def stuck(begin, x):
    """The release of a stick that begins at x, and its motion."""
    strain = lambda t: abs(pull(t, x + f("3/4") * (t - begin))) - friction(0)  # noqa: E731
    t = begin
    while strain(t + SCAN) < 0:
        t += SCAN
    return root(strain, t, t + SCAN), lambda s: (x + f("3/4") * (s - begin), f("3/4"))


def slipped(begin, x, v, side):
    """The end of a slip, its motion, and the points (t, x) at which v = 0 with x > 0."""
    eta = f("6/5")
    belt = f("3/4")
    steady = friction(belt)

    def rates(t, y):
        slip = side * (y[1] - belt)
        force = f("5/2") * y[2] - y[0] - steady - side * friction(slip)
        return [y[1], force, -eta * y[3], eta * y[2]]

    motion = odefun(rates, begin, [x, v, cos(eta * begin), sin(eta * begin)])
    passages = []
    t = begin
    before = v
    while True:
        after = motion(t + SCAN)[1]
        if before * after < 0 and side * (after - belt) > 0:
            rest = root(lambda s: motion(s)[1], t, t + SCAN)
            if motion(rest)[0] > 0:
                passages.append((rest, motion(rest)[0]))
        if side * (after - belt) < 0:
            # A slip begins with v = belt, too.
            low = max(t, begin + SCAN / 1000)
            end = root(lambda s: motion(s)[1] - belt, low, t + SCAN)
            return end, lambda s: tuple(motion(s)[:2]), passages
        before = after
        t += SCAN


def sections():
    """The points of both sections, from a start at which it slips backward and comes to rest at
    once.
    """
    t, x, v = mpf(0), mpf(1), f("-1/2")
    side = -1
    period = 2 * pi / f("6/5")
    due = [n * period for n in range(1, STROBES + 1)]
    strobes = []
    passages = []
    while due or len(passages) < PASSAGES:
        if side:
            end, motion, rests = slipped(t, x, v, side)
            passages += rests
        else:
            end, motion = stuck(t, x)
        while due and due[0] < end:
            strobes.append(motion(due.pop(0)))
        x, v = motion(end)[0], f("3/4")
        t = end
        direction = 1 if pull(t, x) > 0 else -1
        # A stick has ended, or a slip that static friction does not hold.
        is_released = side == 0 or abs(pull(t, x)) > friction(0)
        side = direction if is_released else 0
    found = {}
    for name, points in (("strobe", strobes), ("passage", passages[:PASSAGES])):
        for n, point in enumerate(points, start=1):
            found |= {f"{name}__{n}_o_{i}": value for i, value in enumerate(point)}
    case("poincare-sections", GIVEN, None, **found)
