"""A sphere that touches a rigid wall, the plane x = 0, from the left: under the linear law."""

from collections.abc import Mapping
from fractions import Fraction

import numpy as np

from refdem.cases.impact_benchmarks._dashpot import dashpot_of, linear_contact_time
from refdem.cases.impact_benchmarks._member import POSITIONS_ARE_ROUNDED, Member
from refdem.cases.impact_benchmarks._parameters import LEVERS
from refdem.cases.impact_benchmarks._values import Values
from refdem.core.parameters import Parameters
from refdem.core.quantity import Scales
from refdem.core.truth import Truth
from refdem.scene import Body, Scene, Sphere
from refdem.scene.elements.contact import Contact
from refdem.scene.elements.plane import Plane


class Wall(Member):
    """The linear law; velocity by speed and angle, or by its normal part and psi = v_t/(friction
    v_n).
    """

    def values(self, p: Parameters) -> Values:
        """The parameters with the `normal` and tangential (`across`) velocity [m/s] and the `spin`
        [rad/s] at touch; with a stiffness, also the dashpot.

        Spin, friction, angle and psi are 0 unless the member has them.
        """
        from refdem.truth.reals import cosine, sine

        v = super().values(p)
        zero = Fraction(0)
        v.complete(spin=zero, friction=zero, angle=zero, psi=zero)
        v.complete(branch="R", cutoff="zero_overlap")
        if hasattr(v, "normal_speed"):
            v.normal = v.normal_speed
            v.across = v.psi * v.friction * v.normal_speed
        else:
            v.normal = v.speed * cosine(v.angle)
            v.across = v.speed * sine(v.angle)
        if hasattr(v, "stiffness"):
            v.damping = dashpot_of(v, v.mass)
        return v

    def scene(self, v: Values) -> Scene:
        """The sphere and the wall, which touch without overlap."""
        return Scene.of([struck(v)], [Plane(normal=(-1.0, 0.0, 0.0)), linear(v)])

    def scales(self, v: Values) -> Scales:
        """tau = 1/omega_max; two contact durations.

        omega_max^2 = max(k_n, 7/2 k_t)/m: of a solid sphere that sticks and rotates, 2/7 m resists
        the tangential spring, which acts only with friction.
        """
        contact_time = linear_contact_time(v, v.mass)
        tangential = v.tangential_stiffness * (v.friction > 0)
        stiffest = max(float(v.stiffness), 3.5 * float(tangential))
        tau = np.sqrt(float(v.mass) / stiffest)
        return of_impact(v, tau=float(tau), contact_time=contact_time)

    def truth(self, v: Values, scale: Mapping[str, float]) -> Truth:
        """The truth from one switch of the contact to the next."""
        from refdem.truth.closed_forms.impact_benchmarks.wall import WallImpact, WallPair
        from refdem.truth.refiner import Refiner

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
        return WallImpact(Refiner.of(scale), pair)


def struck(v: Values) -> Body:
    """The sphere left of the wall, which it touches; `normal` is its velocity towards the wall."""
    m = float(v.mass)
    r = float(v.radius)
    # J = 2/5 m r^2.
    moment = 0.4 * m * r * r
    return Body(
        mass=m,
        inertia=(moment, moment, moment),
        shape=Sphere(radius=r),
        position=(-r, 0.0, 0.0),
        velocity=(float(v.normal), float(v.across), 0.0),
        omega=(0.0, 0.0, float(v.spin)),
    )


def linear(v: Values) -> Contact:
    """The linear law of contact with these values."""
    numbers = {
        name: float(getattr(v, name))
        for name in ("stiffness", "damping", "tangential_stiffness", "friction")
    }
    return Contact(law="linear", branch=v.branch, cutoff=v.cutoff, **numbers)


def of_impact(v: Values, *, tau: float, contact_time: float) -> Scales:
    """Scales of an impact on the wall that lasts two contact durations.

    L is the way in tau at the speed of the sphere plus that of its rim, but at least R/8.
    """
    rim_speed = abs(float(v.spin * v.radius))
    speed = float(np.hypot(float(v.normal), float(v.across))) + rim_speed
    length = max(speed * tau, float(v.radius) / POSITIONS_ARE_ROUNDED)
    return Scales(length=length, tau=tau, duration=2 * contact_time, mass=float(v.mass))
