"""Witness of a sphere that bounces on a plane under gravity: the end of each flight by bisection of
the height, every impact from a linear system (rigid_impacts.py).

The closed forms of the truth for times and speeds are not used.
"""

from collections.abc import Mapping, Sequence
from fractions import Fraction

from flint import arb

from refdem.core.parameters import Exact
from refdem.truth.balls import arb_of
from refdem.truth.exact import number, vector
from refdem.truth.witnesses.cross_check import Claimed, Results, Witness
from refdem.truth.witnesses.rigid_impacts import HALVINGS, LAW, Sphere, struck

METHOD = (
    "each flight to the next zero of the height by bisection, impulses from the balance equations"
    " by elimination, unproven (refdem/truth/witnesses/bounces.py)"
)


class Flight:
    """A sphere in flight since `now` [s] under gravity along -y."""

    def __init__(self, p: Mapping[str, Exact]) -> None:
        mass = arb_of(number(p, "mass"))
        radius = arb_of(number(p, "radius"))
        moment = arb_of(number(p, "inertia_factor")) * mass * radius * radius
        vx, vy = (arb_of(x) for x in vector(p, "velocity"))
        place = [arb(0), arb_of(number(p, "height")) + radius, arb(0)]
        spin = [arb(0), arb(0), arb_of(number(p, "spin"))]
        self.sphere = Sphere(mass, moment, radius, place, [vx, vy, arb(0)], spin)
        self.law = {name: arb_of(number(p, name)) for name in LAW}
        self.gravity = arb_of(number(p, "gravity"))
        self.now = arb(0)
        self.height = arb_of(number(p, "height"))
        self.bounces = 0
        self.told: dict[str, arb] = {}

    def next_bounce(self) -> arb:
        """The time of the next zero of h + v_y s - g s^2/2, bisected after the apex v_y/g."""
        upwards = self.sphere.v[1]

        def above(t: arb) -> arb:
            # h + v_y s - g s^2/2
            return arb(self.height + t * (upwards - self.gravity * t / 2))

        low = arb.max(arb(0), (upwards / self.gravity).mid())
        high = low + 1
        while above(high) > 0:
            high = 2 * high
        for _ in range(HALVINGS):
            middle = ((low + high) / 2).mid()
            if above(middle) > 0:
                low = middle
            else:
                high = middle
        return self.now + high

    def moved(self, t: arb) -> tuple[list[arb], list[arb]]:
        """Place r + v s - g s^2/2 e_y and velocity v - g s e_y, s after the last bounce."""
        since = t - self.now
        place = [r + v * since for r, v in zip(self.sphere.r, self.sphere.v, strict=True)]
        place[1] -= self.gravity * since * since / 2
        velocity = list(self.sphere.v)
        velocity[1] -= self.gravity * since
        return place, velocity

    def strike(self, when: arb) -> None:
        """Advances the sphere to the time `when` of the bounce, and solves the impact."""
        self.sphere.r, self.sphere.v = self.moved(when)
        self.now = when
        # The height is measured from the lowest point of the sphere.
        self.height = arb(0)
        self.bounces += 1
        name = f"impact_{self.bounces}"
        self.told[name] = when
        self.told[f"{name}_closing"] = -self.sphere.v[1]
        self.sphere.r[1] = self.sphere.radius
        into = [arb(0), arb(-1), arb(0)]
        velocities, _ = struck([self.sphere], into, self.law)
        self.sphere.v = velocities[:3]
        self.sphere.omega = velocities[3:6]


def bouncing_ball(p: Mapping[str, Exact], times: Sequence[Fraction], claimed: Claimed) -> Results:
    """The states at the times, the time of the first bounce, and the bounces up to the last one of
    these times.
    """
    flight = Flight(p)
    coming = flight.next_bounce()
    first = coming
    e = flight.law["restitution"]
    for t in times:
        until = arb_of(t)
        while coming < until:
            flight.strike(coming)
            coming = flight.next_bounce()
        place, velocity = flight.moved(until)
        yield (
            t,
            {
                "x": place[0],
                "y": place[1],
                "vx": velocity[0],
                "vy": velocity[1],
                "omega": flight.sphere.omega[2],
            },
        )
    scalars = {"first_bounce": first, **flight.told}
    if e < 1:
        # Each flight after a bounce is e times as long as the one before. Their durations from this
        # one on have the sum length/(1 - e).
        ended = flight.now
        length = coming - ended
        if flight.bounces == 0:
            flight.strike(coming)
            ended = coming
            length = flight.next_bounce() - ended
        scalars["accumulation_time"] = ended + length / (1 - e)
    yield None, scalars


WITNESSES = {"bouncing-ball": Witness(METHOD, bouncing_ball)}
