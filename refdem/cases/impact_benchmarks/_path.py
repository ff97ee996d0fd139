"""Two spheres that pass each other on a prescribed path: a contact law without an integrator, up to
the summing of its force.
"""

from collections.abc import Mapping
from fractions import Fraction
from math import isqrt
from typing import Any

import numpy as np

from refdem.cases.impact_benchmarks._member import Array, Member
from refdem.cases.impact_benchmarks._parameters import LEVERS
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
    """A number of at most 21 bits that is at least sqrt(square) > 0, and above it by less than
    2^-19 of it: exact, and in binary64.
    """
    bits = (square.numerator.bit_length() - square.denominator.bit_length()) // 2
    unit = Fraction(2) ** (bits - 20)
    return (isqrt((square / unit**2).__floor__()) + 1) * unit


class Path(Member):
    """Body 2 flies by body 1, which rests, with constant spin; what body 1 gets is seen as its mass
    times its velocity.
    """

    frame: Any = PLAIN

    def written(self, p: Parameters) -> dict[str, Any]:
        """The parameters with the path: it passes at `off`, the radii less the greatest overlap,
        and begins at -`begin`, where they are apart.

        They touch at half a chord from the middle, sqrt(d (2 (R1 + R2) - d)) for the greatest
        overlap d; it begins 5/4 as far away.
        """
        found = super().written(p)
        overlap = found["overlap"]
        reach = found["radius"] + found["partner_radius"]
        if not 0 < overlap < min(found["radius"], found["partner_radius"]):
            raise UsageError(
                f"parameter overlap: got {float(overlap):g} m; expected it between 0 and the"
                " smaller radius"
            )
        chord = overlap * (2 * reach - overlap)
        return {
            **found,
            "off": reach - overlap,
            "half_squared": chord,
            "begin": short_root(Fraction(25, 16) * chord),
        }

    def values(self, p: Parameters) -> Any:
        """The parameters with `half` the length of the chord [m], rounded, for the scales."""
        v = super().values(p)
        v.damping = Fraction(0)
        v.cutoff = "zero_overlap"
        v.half = float(np.sqrt(float(v.half_squared)))
        return v

    def scene(self, v: Any) -> Scene:
        """The two spheres, both too heavy for contact to change their motion."""
        mass = float(HEAVY)
        axes = np.array(self.frame, float)
        place = axes @ [-float(v.begin), float(v.off), 0.0]
        rate = axes @ [float(v.speed), 0.0, 0.0]
        spin = axes @ [0.0, 0.0, float(v.partner_spin)]
        r = float(v.radius)
        s = float(v.partner_radius)
        first = Body(mass=mass, inertia=(0.4 * mass * r * r,) * 3, shape=Sphere(radius=r))
        second = Body(
            mass=mass,
            inertia=(0.4 * mass * s * s,) * 3,
            shape=Sphere(radius=s),
            position=tuple(place),
            velocity=tuple(rate),
            omega=tuple(spin),
        )
        return Scene.of([first, second], [linear(v)])

    def scales(self, v: Any) -> Scales:
        """A quarter of the time of contact; the way there and as far beyond."""
        tau = v.half / 2 / float(v.speed)
        return Scales(
            float(v.radius + v.partner_radius), tau, 2 * float(v.begin / v.speed), float(HEAVY)
        )

    def quantities(self, v: Any) -> tuple[Quantity, ...]:
        """Impulses in units of the largest normal force for the time of contact; place and velocity
        of body 2.
        """
        s = self.scales(v)
        push = float(v.stiffness * v.overlap) * 4 * self.scales(v).tau
        kinds = (
            ("impulse", "N s", push),
            ("turning", "N m s", push * float(v.radius)),
            ("r", "m", s.length),
            ("v", "m/s", float(v.speed)),
        )
        found = []
        for kind, unit, size in kinds:
            found += [Quantity(f"{kind}.{axis}", unit, size) for axis in "xyz"]
        return tuple(found)

    def observe(self, v: Any, run: Trajectory) -> dict[str, Array]:
        """The motion of body 1, and its place on the path."""
        mass = float(HEAVY)
        moment = 0.4 * float(HEAVY) * float(v.radius) ** 2
        columns = [
            mass * run.velocity[:, 0],
            moment * run.omega[:, 0],
            run.position[:, 1],
            run.velocity[:, 1],
        ]
        names = [quantity.name for quantity in self.quantities(v)]
        return dict(zip(names, np.concatenate(columns, axis=1).T, strict=True))

    def truth(self, v: Any, scale: Mapping[str, float]) -> Truth:
        """The truth in closed form between proven switches."""
        from refdem.truth.closed_forms.impact_benchmarks.contact_path import ContactPath, Passing

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
        return ContactPath(scale, passing)
