"""Two spheres that pass each other on a prescribed path: a test of a contact law alone.

Both are so heavy that the contact does not change their motion, so that the only integration is the
sum of its force: body 1 rests at the origin, body 2 flies past it along a straight line.
"""

from collections.abc import Mapping
from fractions import Fraction
from math import isqrt
from typing import Any

import numpy as np

from refdem.cases.impact_benchmarks._member import Array, Member
from refdem.cases.impact_benchmarks._parameters import LEVERS
from refdem.cases.impact_benchmarks._values import Values
from refdem.cases.impact_benchmarks._wall import linear
from refdem.core.parameters import Parameters
from refdem.core.quantity import Quantity, Scales
from refdem.core.trajectory import Trajectory
from refdem.core.truth import Truth
from refdem.errors import UsageError
from refdem.scene import Body, Scene, Sphere

HEAVY = Fraction(10**64)
"""[kg]: no force of the law moves it by more than rounding."""
NONE = Fraction(0)
ONE = Fraction(1)
PLAIN = ((ONE, NONE, NONE), (NONE, ONE, NONE), (NONE, NONE, ONE))


def short_root(square: Fraction) -> Fraction:
    """An upper bound of sqrt(square) > 0, close to a relative 2^-19, that is exact in binary64.

    It is a multiple of a power of two near 2^-20 of the root: a number of about 21 bits.
    """
    bits = (square.numerator.bit_length() - square.denominator.bit_length()) // 2
    unit = Fraction(2) ** (bits - 20)
    whole_square = (square / unit**2).__floor__()
    return (isqrt(whole_square) + 1) * unit


class Path(Member):
    """Body 2 flies past body 1, which rests, with constant spin. The impulse and the angular
    impulse that body 1 receives are its mass times velocity and its moment times omega.

    `frame` is the matrix (3, 3) whose columns are the axes of the path in space.
    """

    frame: Any = PLAIN

    def written(self, p: Parameters) -> dict[str, Any]:
        """The parameters with the path x = -begin + v t, y = off of body 2.

        With the sum R of the radii and the greatest overlap d: `off` = R - d, and the spheres touch
        at x = -+half, half^2 = R^2 - (R - d)^2 = d (2 R - d), which is `half_squared`. The path
        begins 5/4 as far away.
        """
        numbers = super().written(p)
        overlap = numbers["overlap"]
        contact_distance = numbers["radius"] + numbers["partner_radius"]
        if not 0 < overlap < min(numbers["radius"], numbers["partner_radius"]):
            raise UsageError(
                f"parameter overlap: got {float(overlap):g} m; expected it between 0 and the"
                " smaller radius"
            )
        half_squared = overlap * (2 * contact_distance - overlap)
        return {
            **numbers,
            "off": contact_distance - overlap,
            "half_squared": half_squared,
            "begin": short_root(Fraction(25, 16) * half_squared),
        }

    def values(self, p: Parameters) -> Values:
        """The parameters with `half` [m], half of the path's length in contact, rounded for the
        scales.
        """
        v = super().values(p)
        v.damping = Fraction(0)
        v.cutoff = "zero_overlap"
        v.half = float(np.sqrt(float(v.half_squared)))
        return v

    def scene(self, v: Values) -> Scene:
        """The two spheres, both too heavy for contact to change their motion."""
        mass = float(HEAVY)
        axes = np.array(self.frame, float)
        position = axes @ [-float(v.begin), float(v.off), 0.0]
        velocity = axes @ [float(v.speed), 0.0, 0.0]
        omega = axes @ [0.0, 0.0, float(v.partner_spin)]
        r1 = float(v.radius)
        r2 = float(v.partner_radius)
        # J = 2/5 m R^2.
        moment1 = 0.4 * mass * r1 * r1
        moment2 = 0.4 * mass * r2 * r2
        first = Body(mass=mass, inertia=(moment1, moment1, moment1), shape=Sphere(radius=r1))
        second = Body(
            mass=mass,
            inertia=(moment2, moment2, moment2),
            shape=Sphere(radius=r2),
            position=tuple(position),
            velocity=tuple(velocity),
            omega=tuple(omega),
        )
        return Scene.of([first, second], [linear(v)])

    def scales(self, v: Values) -> Scales:
        """L = R1 + R2; tau is a quarter of the time of contact; T takes body 2 from -begin to
        begin.
        """
        tau = v.half / 2 / float(v.speed)
        duration = 2 * float(v.begin / v.speed)
        return Scales(
            length=float(v.radius + v.partner_radius),
            tau=tau,
            duration=duration,
            mass=float(HEAVY),
        )

    def quantities(self, v: Values) -> tuple[Quantity, ...]:
        """Impulse and angular impulse (`turning`) of body 1; position and velocity of body 2.

        The scale of the impulse is the largest normal force k d for the time of contact, 4 tau.
        """
        s = self.scales(v)
        impulse = float(v.stiffness * v.overlap) * 4 * self.scales(v).tau
        vectors = (
            ("impulse", "N s", impulse),
            ("turning", "N m s", impulse * float(v.radius)),
            ("r", "m", s.length),
            ("v", "m/s", float(v.speed)),
        )
        components = []
        for vector, unit, scale in vectors:
            components += [Quantity(f"{vector}.{axis}", unit, scale) for axis in "xyz"]
        return tuple(components)

    def observe(self, v: Values, run: Trajectory) -> dict[str, Array]:
        """The components (T,) of `quantities`: m v and J omega of body 1, r and v of body 2."""
        mass = float(HEAVY)
        # J = 2/5 m R^2.
        moment = 0.4 * float(HEAVY) * float(v.radius) ** 2
        columns = [
            mass * run.velocity[:, 0],
            moment * run.omega[:, 0],
            run.position[:, 1],
            run.velocity[:, 1],
        ]
        names = [quantity.name for quantity in self.quantities(v)]
        return dict(zip(names, np.concatenate(columns, axis=1).T, strict=True))

    def truth(self, v: Values, scale: Mapping[str, float]) -> Truth:
        """The truth in closed form between proven switches."""
        from refdem.truth.closed_forms.impact_benchmarks.contact_path import ContactPath, Passing
        from refdem.truth.refiner import Refiner

        names = ("stiffness", "tangential_stiffness", "friction")
        numbers = {name: getattr(v, name) for name in names}
        passing = Passing(
            mass=HEAVY,
            radii=(v.radius, v.partner_radius),
            **numbers,
            spin=v.partner_spin,
            lever=LEVERS[v.branch],
            start=(-v.begin, v.off, v.speed, Fraction(0)),
            frame=self.frame,
        )
        return ContactPath(Refiner.of(scale), passing)
