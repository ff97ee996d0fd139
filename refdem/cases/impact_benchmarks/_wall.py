"""A sphere that touches a rigid wall, the plane x = 0, from the left: under the linear law."""

from collections.abc import Mapping
from fractions import Fraction
from typing import Any

import numpy as np

from refdem.cases.impact_benchmarks._dashpot import dashpot_of, linear_contact_time
from refdem.cases.impact_benchmarks._member import POSITIONS_ARE_ROUNDED, Member
from refdem.cases.impact_benchmarks._parameters import LEVERS
from refdem.core.quantity import Scales
from refdem.core.truth import Truth
from refdem.scene import Body, Scene, Sphere
from refdem.scene.elements.contact import Contact
from refdem.scene.elements.plane import Plane


class Wall(Member):
    """The linear law; velocity by speed and angle, or by its normal part and psi = v_t/(friction
    v_n).
    """

    def values(self, p: Any) -> Any:
        """The parameters with `normal`, `across` [m/s], `spin` [rad/s] and, without a stiffness,
        Hertz's `hertz`.
        """
        from refdem.truth.reals import cosine, sine

        v = super().values(p)
        for name in ("spin", "friction", "angle", "psi"):
            v.__dict__.setdefault(name, Fraction(0))
        v.__dict__.setdefault("branch", "R")
        v.__dict__.setdefault("cutoff", "zero_overlap")
        if hasattr(v, "normal_speed"):
            v.normal = v.normal_speed
            v.across = v.psi * v.friction * v.normal_speed
        else:
            v.normal = v.speed * cosine(v.angle)
            v.across = v.speed * sine(v.angle)
        if hasattr(v, "stiffness"):
            v.damping = dashpot_of(v, v.mass)
        return v

    def scene(self, v: Any) -> Scene:
        """The sphere and the wall, which touch without overlap."""
        return Scene.of([struck(v)], [Plane(normal=(-1.0, 0.0, 0.0)), linear(v)])

    def scales(self, v: Any) -> Scales:
        """tau = 1/omega_max; two contacts."""
        lasts = linear_contact_time(v, v.mass)
        stiffest = max(float(v.stiffness), 3.5 * float(v.tangential_stiffness * (v.friction > 0)))
        tau = np.sqrt(float(v.mass) / stiffest)
        return of_impact(v, tau=float(tau), lasts=lasts)

    def truth(self, v: Any, scale: Mapping[str, float]) -> Truth:
        """The truth from one switch of the contact to the next."""
        from refdem.truth.closed_forms.impact_benchmarks.wall import WallImpact, WallPair

        pair = WallPair(
            mass=v.mass,
            radius=v.radius,
            stiffness=v.stiffness,
            damping=v.damping,
            tangential_stiffness=v.tangential_stiffness,
            friction=v.friction,
            normal=v.normal,
            across=v.across,
            spin=v.spin,
            lever=LEVERS[v.branch],
            ends_with_overlap=v.cutoff == "zero_overlap",
        )
        return WallImpact(scale, pair)


def struck(v: Any) -> Body:
    """The sphere, left of the wall."""
    m = float(v.mass)
    r = float(v.radius)
    return Body(
        mass=m,
        inertia=(0.4 * m * r * r,) * 3,
        shape=Sphere(radius=r),
        position=(-r, 0.0, 0.0),
        velocity=(float(v.normal), float(v.across), 0.0),
        omega=(0.0, 0.0, float(v.spin)),
    )


def linear(v: Any) -> Contact:
    """The linear law of contact with these values."""
    numbers = {
        name: float(getattr(v, name))
        for name in ("stiffness", "damping", "tangential_stiffness", "friction")
    }
    return Contact(law="linear", branch=v.branch, cutoff=v.cutoff, **numbers)


def of_impact(v: Any, *, tau: float, lasts: float) -> Scales:
    """Length: the way in tau, but at least R/8."""
    speed = float(np.hypot(float(v.normal), float(v.across))) + abs(float(v.spin * v.radius))
    return Scales(
        length=max(speed * tau, float(v.radius) / POSITIONS_ARE_ROUNDED),
        tau=tau,
        duration=2 * lasts,
        mass=float(v.mass),
    )
