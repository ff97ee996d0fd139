"""Spheres over the floor y = 0 in gravity along -y, under the linear law.

`v` holds the values of a member: exact numbers by name, such as `v.radius`, `v.stiffness`.
"""

from collections.abc import Mapping
from fractions import Fraction
from typing import Any, ClassVar

import numpy as np

from refdem.cases.impact_benchmarks._dashpot import dashpot_of
from refdem.cases.impact_benchmarks._member import POSITIONS_ARE_ROUNDED, Member
from refdem.cases.impact_benchmarks._values import Values
from refdem.cases.impact_benchmarks._wall import linear
from refdem.core.parameters import Parameters
from refdem.core.quantity import Scales
from refdem.core.truth import Truth
from refdem.errors import UsageError
from refdem.scene import Body, Scene, Sphere
from refdem.scene.elements.plane import Plane
from refdem.scene.elements.uniform_gravity import UniformGravity


class OnFloor(Member):
    """A member with spheres on the floor, under one linear law and gravity."""

    def values(self, p: Parameters) -> Values:
        """The parameters with the dashpot that gives the restitution of an impact on the floor
        without gravity; friction is 0 and restitution 1 unless the member has them.
        """
        v = super().values(p)
        v.effective = v.mass
        v.branch = "R"
        v.cutoff = "zero_overlap"
        v.tangential_stiffness = Fraction(0)
        v.complete(friction=Fraction(0), restitution=Fraction(1))
        v.damping = dashpot_of(v, v.effective)
        return v

    def of(self, v: Values, bodies: list[Body], *planes: Plane) -> Scene:
        """The scene of these bodies on the floor, in gravity."""
        ground = Plane(normal=(0.0, 1.0, 0.0))
        weight = UniformGravity(g=(0.0, -float(v.gravity), 0.0))
        return Scene.of(bodies, [ground, *planes, weight, linear(v)])

    def floor(self, v: Values) -> Any:
        """The sphere, its contact with the floor and gravity, in exact numbers, for the truth."""
        from refdem.truth.closed_forms.impact_benchmarks.floor import Floor

        return Floor(
            mass=v.mass,
            radius=v.radius,
            stiffness=v.stiffness,
            damping=v.damping,
            gravity=v.gravity,
        )


def ball(v: Values, mass: Any, height: Fraction, speed: Fraction = Fraction(0)) -> Body:
    """A solid sphere of `mass` [kg] at y = `height` [m], with `speed` [m/s] along x."""
    m = float(mass)
    r = float(v.radius)
    # J = 2/5 m r^2.
    moment = 0.4 * m * r * r
    return Body(
        mass=m,
        inertia=(moment, moment, moment),
        shape=Sphere(radius=r),
        position=(0.0, float(height), 0.0),
        velocity=(float(speed), 0.0, 0.0),
    )


class Bounce(OnFloor):
    """Let fall from `height`; lasts to about the top of the flight after bounce number
    `bounces`.
    """

    bounces: ClassVar[int] = 2

    def values(self, p: Parameters) -> Values:
        """The values of the member; raises UsageError for a start that touches the floor."""
        v = super().values(p)
        if v.height <= v.radius:
            raise UsageError(
                f"parameter height: got {float(v.height):g} m; expected more than the radius"
                f" {float(v.radius):g} m"
            )
        return v

    def scene(self, v: Values) -> Scene:
        """The sphere at rest in the air, at its height above the floor."""
        return self.of(v, [ball(v, v.mass, v.height)])

    def scales(self, v: Values) -> Scales:
        """tau = sqrt(m/k); L the way in tau at the speed of the first impact, at least height/8.

        A fall from rest through s = height - radius takes t = sqrt(2 s/g) and ends at sqrt(2 g s).
        After bounce n the flight up takes t e^n, and so does the way down. The motion lasts for
        the fall, the flights between bounces, half of the last one, and a contact time pi tau a
        bounce:

            T = t (1 + 2 (e + ... + e^(N-1)) + e^N) + N pi tau,   N = bounces.
        """
        tau = float(np.sqrt(float(v.mass / v.stiffness)))
        twice_drop = 2 * float(v.height - v.radius)
        fall_time = float(np.sqrt(twice_drop / float(v.gravity)))
        e = float(v.restitution)
        flights = 1 + 2 * sum(e**n for n in range(1, self.bounces)) + e**self.bounces
        duration = fall_time * flights + self.bounces * np.pi * tau
        impact_speed = float(np.sqrt(twice_drop * float(v.gravity)))
        length = max(impact_speed * tau, float(v.height) / POSITIONS_ARE_ROUNDED)
        return Scales(length=length, tau=tau, duration=float(duration), mass=float(v.mass))

    def truth(self, v: Values, scale: Mapping[str, float]) -> Truth:
        """The truth in closed form, from bounce to bounce."""
        from refdem.truth.closed_forms.impact_benchmarks import floor

        return floor.bounce(
            scale, self.floor(v), height=v.height, restitution=v.restitution, bounces=self.bounces
        )
