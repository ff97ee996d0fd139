"""Spheres over the floor y = 0 in gravity along -y, under the linear law."""

from collections.abc import Mapping
from fractions import Fraction
from typing import Any, ClassVar

import numpy as np

from refdem.cases.impact_benchmarks._dashpot import dashpot_of
from refdem.cases.impact_benchmarks._member import POSITIONS_ARE_ROUNDED, Member
from refdem.cases.impact_benchmarks._wall import linear
from refdem.core.parameters import Parameters
from refdem.core.quantity import Scales
from refdem.core.truth import Truth
from refdem.errors import UsageError
from refdem.scene import Body, Scene, Sphere
from refdem.scene.elements.plane import Plane
from refdem.scene.elements.uniform_gravity import UniformGravity


class OnFloor(Member):
    """What the members have in common: one law, gravity."""

    def values(self, p: Parameters) -> Any:
        """The parameters with the dashpot that makes the restitution of the sphere on the floor,
        without gravity.
        """
        v = super().values(p)
        v.effective = v.mass
        v.branch = "R"
        v.cutoff = "zero_overlap"
        v.tangential_stiffness = Fraction(0)
        v.__dict__.setdefault("friction", Fraction(0))
        v.__dict__.setdefault("restitution", Fraction(1))
        v.damping = dashpot_of(v, v.effective)
        return v

    def of(self, v: Any, bodies: list[Body], *planes: Plane) -> Scene:
        """The scene of these bodies on the floor, in gravity."""
        ground = Plane(normal=(0.0, 1.0, 0.0))
        weight = UniformGravity(g=(0.0, -float(v.gravity), 0.0))
        return Scene.of(bodies, [ground, *planes, weight, linear(v)])

    def floor(self, v: Any) -> Any:
        """The floor as truth is told of it, in exact numbers."""
        from refdem.truth.closed_forms.impact_benchmarks.floor import Floor

        return Floor(
            mass=v.mass,
            radius=v.radius,
            stiffness=v.stiffness,
            damping=v.damping,
            gravity=v.gravity,
        )


def ball(v: Any, mass: Any, height: Fraction, speed: Fraction = Fraction(0)) -> Body:
    """A solid sphere over the origin."""
    m = float(mass)
    r = float(v.radius)
    return Body(
        mass=m,
        inertia=(0.4 * m * r * r,) * 3,
        shape=Sphere(radius=r),
        position=(0.0, float(height), 0.0),
        velocity=(float(speed), 0.0, 0.0),
    )


class Bounce(OnFloor):
    """Let fall from `height`; lasts to about the top of the flight after bounce number
    `bounces`.
    """

    bounces: ClassVar[int] = 2

    def values(self, p: Parameters) -> Any:
        """The values of the member; raises UsageError for a start that touches the floor."""
        v = super().values(p)
        if v.height <= v.radius:
            raise UsageError(
                f"parameter height: got {float(v.height):g} m; expected more than the radius"
                f" {float(v.radius):g} m"
            )
        return v

    def scene(self, v: Any) -> Scene:
        """The sphere at rest in the air, at its height above the floor."""
        return self.of(v, [ball(v, v.mass, v.height)])

    def scales(self, v: Any) -> Scales:
        """tau = sqrt(m/k); the length that it falls in that time at the floor, but at least
        height/8.
        """
        tau = float(np.sqrt(float(v.mass / v.stiffness)))
        drop = 2 * float(v.height - v.radius)
        fall = float(np.sqrt(drop / float(v.gravity)))
        e = float(v.restitution)
        flights = 1 + 2 * sum(e**n for n in range(1, self.bounces)) + e**self.bounces
        lasts = fall * flights + self.bounces * np.pi * tau
        speed = float(np.sqrt(drop * float(v.gravity)))
        length = max(speed * tau, float(v.height) / POSITIONS_ARE_ROUNDED)
        return Scales(length=length, tau=tau, duration=float(lasts), mass=float(v.mass))

    def truth(self, v: Any, scale: Mapping[str, float]) -> Truth:
        """The truth in closed form, from bounce to bounce."""
        from refdem.truth.closed_forms.impact_benchmarks import floor

        return floor.bounce(
            scale, self.floor(v), height=v.height, restitution=v.restitution, bounces=self.bounces
        )
