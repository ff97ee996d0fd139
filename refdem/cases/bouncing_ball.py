"""A bouncing ball: a rigid sphere that falls, or is thrown, and bounces on a plane."""

from fractions import Fraction

import numpy as np
from numpy.typing import NDArray

from refdem.cases import _plane, _rigid
from refdem.core.case import NEVER, Case
from refdem.core.parameters import Parameter, Parameters
from refdem.core.quantity import Quantity, Scales
from refdem.core.trajectory import Trajectory
from refdem.core.truth import Truth
from refdem.errors import UsageError
from refdem.scene import Scene
from refdem.scene.elements.plane import Plane
from refdem.scene.elements.uniform_gravity import UniformGravity

Array = NDArray[np.float64]
MOST_BOUNCES = 40
"""Bounces that a run may show: e^-n digits are lost towards their end."""
WITHIN_FLIGHT = (1 / 4, 3 / 4)
"""The run ends between these parts of the flight after its last bounce."""


class BouncingBall(Case):
    """The plane is y = 0, gravity points along -y; the ball moves in the plane x-y and spins about
    z.
    """

    id = "bouncing-ball"
    title = "Bouncing ball"
    words = ("bounce", "drop", "floor", "restitution", "gravity")
    motion = "colliding"
    statement = (
        "A rigid ball falls on a plane, or is thrown, and bounces. Each bounce leaves the part e of"
        " the speed at which it meets the plane, so that each flight is e times as long as the one"
        " before it: the bounces come to an end in finite time, at T, and without number. Friction"
        " stops the slip of the point that touches, or reverses a part of it, and is cut at mu"
        " times the normal impulse. The run ends before T, towards which errors grow without bound;"
        " the rest that follows is left out."
    )
    latex = (
        r"v_n=e^{n-1}v_1,\quad t_n=t_1+\frac{2v_1}{g}\sum_{k=1}^{n-1}e^k,\quad"
        r" T=t_1+\frac{2v_1}{g}\,\frac{e}{1-e}"
    )
    source = (
        "Bernstein 1977, Am. J. Phys. 45, 41; Garwin 1969, Am. J. Phys. 37, 88; Falcon, Laroche,"
        " Fauve and Coste 1998, Eur. Phys. J. B 3"
    )
    parameters = (
        *_rigid.one_sphere("ball"),
        Parameter(
            name="height",
            default="2",
            unit="m",
            doc="of the lowest point of the ball over the plane at the start",
            above=0,
        ),
        Parameter(
            name="velocity",
            default="0,0",
            unit="m/s",
            doc="of the centre along x and y at the start",
            shape=(2,),
        ),
        Parameter(name="spin", default="0", unit="rad/s", doc="omega about z at the start"),
        Parameter(name="gravity", default="9.8125", unit="m/s^2", doc="along -y", above=0),
        Parameter(
            name="restitution",
            default="3/4",
            unit="1",
            doc="speed away from the plane after a bounce over that towards it before",
            above=0,
            at_most=1,
        ),
        *_rigid.LAW[1:],
        Parameter(
            name="bounces",
            default="6",
            unit="1",
            doc="after so many the run ends, unless a duration is given",
            at_least=1,
            at_most=MOST_BOUNCES,
            whole=True,
        ),
    )
    chaotic_at = NEVER

    def refuse(self, p: Parameters) -> None:
        """Raises UsageError for a run that does not end before the bounces do, or that has too
        many of them.
        """
        from refdem.truth.closed_forms.bouncing_ball import is_before_accumulation

        duration = p["duration"]
        if not isinstance(duration, Fraction):
            # The run ends in the flight after the last of the requested bounces.
            return
        last = float(duration)
        if not is_before_accumulation(p, duration):
            raise UsageError(
                f"parameter duration: got {last:.6g} s, before which the bounces come to an end;"
                " expected a shorter one: take fewer bounces or a shorter duration"
            )
        if len(_before(p, last)) > MOST_BOUNCES:
            raise UsageError(
                f"parameter duration: got {last:.6g} s with more than {MOST_BOUNCES} bounces;"
                " expected fewer: take a shorter duration"
            )

    def scene(self, p: Parameters) -> Scene:
        """The ball, the plane, gravity and the rigid law."""
        body = _rigid.sphere(
            mass=p.mass,
            factor=p.inertia_factor,
            radius=p.radius,
            position=np.array([0.0, p.height + p.radius, 0.0]),
            velocity=np.array([*p.velocity, 0.0]),
            omega=np.array([0.0, 0.0, p.spin]),
        )
        gravity = UniformGravity(g=(0.0, -p.gravity, 0.0))
        return Scene.of([body], [_rigid.contact(p), Plane(normal=(0.0, 1.0, 0.0)), gravity])

    def scales(self, p: Parameters) -> Scales:
        """tau is the shortest flight between two bounces of the run, at most that of the fall; L =
        v tau with the fastest of centre and surface.
        """
        samples = int(p.samples)
        count = int(p.bounces)
        times = _bounces(p, count + 1)
        flight = times[count] - times[count - 1]
        least, most = (times[count - 1] + part * flight for part in WITHIN_FLIGHT)
        duration = _rigid.clear_of_all(times, samples, least=least, most=most)
        end = p.duration or duration
        before = _before(p, end)
        # v_1 = sqrt(u^2 + 2 g h): the fastest that it falls.
        falling = float(np.sqrt(p.velocity[1] ** 2 + 2.0 * p.gravity * p.height))
        centre = float(np.hypot(falling, p.velocity[0]))
        fastest = max(centre, p.radius * abs(p.spin))
        longest = falling / p.gravity
        if len(before) > 0:
            # The flight after the last bounce is the shortest one.
            longest = min(longest, 2 * falling / p.gravity * p.restitution ** len(before))
        # A bounce that is detected late affects samples up to the next bounce.
        interval = end / samples
        past = np.modf(before / interval)[0]
        tau = _rigid.shortest_time(before, (1.0 - past) * interval, longest)
        return Scales(length=fastest * tau, tau=tau, duration=duration, mass=p.mass)

    def quantities(self, p: Parameters) -> tuple[Quantity, ...]:
        """Place, velocity and angular velocity in the plane."""
        scales = self.scales(p)
        spin = max(abs(p.spin), scales.speed / p.radius)
        return _plane.quantities_with_spin(scales.length, scales.speed, spin)

    def observe(self, p: Parameters, trajectory: Trajectory) -> dict[str, Array]:
        """Place, velocity and angular velocity in the plane at the samples, each (T,)."""
        return _plane.observe_with_spin(trajectory)

    def truth(self, p: Parameters) -> Truth:
        """All bounces in exact arithmetic of one square root."""
        from refdem.truth.closed_forms.bouncing_ball import truth

        return truth(p, {q.name: q.scale for q in self.quantities(p)})


def _bounces(p: Parameters, count: int) -> Array:
    """The times (count,) [s] of the first bounces: t_n = t_1 + (2 v_1/g) (e + ... + e^(n-1))."""
    upwards = p.velocity[1]
    speed = float(np.sqrt(upwards**2 + 2.0 * p.gravity * p.height))
    if upwards > 0:
        first = (upwards + speed) / p.gravity
    else:
        # (u + v)/g without cancellation.
        first = 2.0 * p.height / (speed - upwards)
    flights = 2.0 * speed / p.gravity * p.restitution ** np.arange(1, count)
    times: Array = first + np.append(0.0, np.cumsum(flights))
    return times


def _before(p: Parameters, end: float) -> Array:
    """The times [s] of the bounces before the end [s], of which one more than MOST_BOUNCES are
    looked for.
    """
    times = _bounces(p, MOST_BOUNCES + 1)
    return times[times < end]


CASE = BouncingBall()
