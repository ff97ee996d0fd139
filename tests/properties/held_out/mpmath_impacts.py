"""Oblique impacts of a sphere on a wall under the linear law, for by_mpmath.py: phase after phase,
switches by bisection and secant.

Overlap d and its rate u swing freely. Friction T acts on the sphere along y at the lever l = R -
beta d, m v' = T, J w' = l T: a spring, T = -kt s with s' = v + l w, until that would be more than
friction times the normal force F; then T has that size, and s its length, until kt s' is less than
what the limit gains. Nothing holds while F pulls. Lever R: every phase in closed form; else
mpmath's Taylor integrator.
"""

from mpmath import acos, cos, exp, findroot, log, mp, mpf, pi, sign, sin, sqrt

from tests.properties.held_out.mpmath_tools import case, f

SETS = (
    ("dem-05", "R", {"angle": "0.1234", "stiffness": "1.3e7", "tangential_stiffness": "1.1e7"}),
    ("dem-05", "R-d", {"angle": "0.2871", "stiffness": "9e6", "tangential_stiffness": "7.3e6"}),
    ("dem-05", "R", {"angle": "0.4417", "stiffness": "2.1e7", "tangential_stiffness": "1.57e7"}),
    ("dem-05", "R-d/2", {"angle": "0.613", "stiffness": "6.1e6", "tangential_stiffness": "9.2e6"}),
    ("dem-05", "R-d", {"angle": "1.031", "stiffness": "1.9e7", "tangential_stiffness": "1.2e7"}),
    ("dem-05", "R", {"angle": "1.4801", "stiffness": "3.3e6", "tangential_stiffness": "2.9e6"}),
    ("co-4", "R", {"angle": "0.3173", "restitution": "0.83", "stiffness": "1.1e7"}),
    ("co-4", "R-d", {"angle": "0.0879", "restitution": "0.9", "tangential_stiffness": "8.7e6"}),
    (
        "co-4",
        "R",
        {"angle": "0.5273", "restitution": "0.7", "cutoff": "zero_overlap", "stiffness": "8.8e6"},
    ),
    (
        "co-4",
        "R-d",
        {"angle": "0.2317", "restitution": "0.75", "cutoff": "zero_overlap", "stiffness": "1.5e7"},
    ),
)
OWN = {
    "radius": "0.0025",
    "speed": "3.9",
    "stiffness": "1.72e7",
    "tangential_stiffness": "1.48e7",
    "friction": "0.092",
    "cutoff": "zero_force",
}
RESTITUTION = {"dem-05": "1", "co-4": "0.98"}
STEPS = 640
"""Looks at the switches in a contact."""


class Impact:
    """In units of m, k and the normal velocity: times of sqrt(m/k), lengths of v sqrt(m/k); spins
    as the velocity R w.
    """

    def __init__(self, member, branch, given):
        told = {**OWN, "restitution": RESTITUTION[member], **given}
        self.beta = {"R": mpf(0), "R-d": mpf(1), "R-d/2": mpf(1) / 2}[branch]
        self.radius, self.stiffness, self.friction = (
            f(told["radius"]),
            f(told["stiffness"]),
            f(told["friction"]),
        )
        mass = 4 * pi / 3 * self.radius**3 * 4000
        self.time, self.kt = (
            sqrt(mass / self.stiffness),
            f(told["tangential_stiffness"]) / self.stiffness,
        )
        self.speed, across = (
            f(told["speed"]) * cos(f(told["angle"])),
            f(told["speed"]) * sin(f(told["angle"])),
        )
        self.length = self.speed * self.time
        self.pulls = told["cutoff"] == "zero_overlap"
        self.across, loss = across / self.speed, -log(f(told["restitution"]))
        if self.pulls:
            self.b = loss / sqrt(pi**2 + loss**2)
        else:
            self.b = mpf(0)
        if loss and not self.pulls:
            self.b = cos(findroot(lambda a: 2 * a * cos(a) - loss * sin(a), mpf("1.5")))
        self.w = sqrt(1 - self.b**2)
        self.ends = pi / self.w
        if self.b:
            self.lets_go = 2 * acos(self.b) / self.w
        else:
            self.lets_go = self.ends
        self.phases = self.followed()

    def overlap(self, t):
        return exp(-self.b * t) * sin(self.w * t) / self.w

    def rate(self, t):
        return exp(-self.b * t) * (cos(self.w * t) - self.b / self.w * sin(self.w * t))

    def force(self, t):
        return self.overlap(t) + 2 * self.b * self.rate(t)

    def steepening(self, t):
        return self.rate(t) - 2 * self.b * self.force(t)

    def slip(self, t, y):
        return y[1] + (1 - self.beta * self.overlap(t) * self.length / self.radius) * y[2]

    def motion(self, side, begun, y):
        """(y, v, R w, s) at t from those at `begun`; side 0: stick, else slip to that side, as long
        as the phase lasts.
        """
        if not self.beta:
            return self.closed(side, begun, y)
        return self.integrated(side, begun, y)

    def closed(self, side, begun, y):
        place, v, spin, stretch = y

        def at(t):
            past = t - begun
            if side:
                given = side * self.friction * (self.rate(t) - self.rate(begun))
                gone = (
                    side
                    * self.friction
                    * (self.overlap(t) - self.overlap(begun) - self.rate(begun) * past)
                )
                return (
                    place + v * past + gone,
                    v + given,
                    spin + given * 5 / 2,
                    side * self.friction * self.force(t) / self.kt,
                )
            n = sqrt(self.kt * 7 / 2)
            slip = v + spin
            turned = sin(n * past)
            swung = 1 - cos(n * past)
            given = -self.kt * (stretch * turned / n + slip * swung / n**2)
            gone = -self.kt * (stretch * swung / n**2 + slip * (n * past - turned) / n**3)
            return (
                place + v * past + gone,
                v + given,
                spin + given * 5 / 2,
                stretch * (1 - swung) + slip * turned / n,
            )

        return at

    def integrated(self, side, begun, y):
        short = self.beta * self.length / self.radius

        def rates(_, z):
            d = z[0]
            u = z[1]
            v = z[3]
            spin = z[4]
            stretch = z[5]
            normal = d + 2 * self.b * u
            lever = 1 - short * d
            if side:
                pull = -side * self.friction * normal
            else:
                pull = -self.kt * stretch
            return [u, -normal, v, pull, lever * pull * 5 / 2, v + lever * spin]

        solution = mp.odefun(rates, begun, [self.overlap(begun), self.rate(begun), *y])

        def at(t):
            place, v, spin, stretch = solution(t)[2:]
            return (
                place,
                v,
                spin,
                side * self.friction * self.force(t) / self.kt if side else stretch,
            )

        return at

    def free(self, place, v, spin, _):
        """The motion once nothing presses."""
        return lambda t: (place + v * (t - self.lets_go), v, spin, 0)

    def left(self, side, at):
        """What falls through zero where a phase ends, as a function of t."""
        if side:
            return lambda t: (
                side * self.kt * self.slip(t, at(t)) - self.friction * self.steepening(t)
            )
        return lambda t: self.friction * self.force(t) - abs(self.kt * at(t)[3])

    def followed(self):
        """(begin, side, motion) of every phase; the last, None, flies freely."""
        y = (mpf(0), self.across, mpf(0), mpf(0))
        side = int(not self.b and self.kt * self.across > self.friction)
        found = []
        begun = mpf(0)
        step = self.lets_go / STEPS
        while True:
            at = self.motion(side, begun, y)
            found.append((begun, side, at))
            guard = self.left(side, at)
            ticks = int(begun / step) + 1
            fallen = next((n for n in range(ticks, STEPS) if guard(n * step) < 0), None)
            if fallen is None:
                return [*found, (self.lets_go, None, self.free(*at(self.lets_go)))]
            switch = findroot(
                guard,
                ((fallen - 1) * step if fallen > ticks else begun, fallen * step),
                solver="anderson",
                tol=mpf(10) ** -110,
            )
            y = at(switch)
            if side:
                side = 0
            else:
                side = int(sign(y[3]))
            begun = switch

    def state(self, t):
        """Quantities at t [s]."""
        t = t / self.time
        y = next(at(t) for begun, _, at in reversed(self.phases) if t >= begun)
        if self.pulls:
            ends = self.ends
        else:
            ends = self.lets_go
        inside = min(t, ends)
        u = self.rate(inside)
        deep = self.overlap(inside) + u * (t - inside)
        told = {
            "r_o_x": deep * self.length - self.radius,
            "r_o_y": y[0] * self.length,
            "v_o_x": u * self.speed,
        }
        return told | {"v_o_y": y[1] * self.speed, "omega_o_z": y[2] * self.speed / self.radius}


def impacts():
    """MFiX DEM05 and Chung and Ooi's test 4 at angles and stiffnesses of no set: in the contact,
    and long after it.
    """
    for member, branch, given in SETS:
        impact = Impact(member, branch, given)
        told = {"member": member, "branch": branch, **given}
        for t in ("0.000007", "0.00006"):
            case("impact-benchmarks", told, t, **impact.state(f(t)))
        after = impact.state(f("0.00006"))
        case(
            "impact-benchmarks",
            told,
            None,
            rebound_across=after["v_o_y"],
            rebound_spin=after["omega_o_z"],
            duration=(impact.ends if impact.pulls else impact.lets_go) * impact.time,
        )
