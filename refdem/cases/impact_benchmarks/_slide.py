"""A sphere that lies on the floor, slides, and rolls in the end."""

from collections.abc import Mapping
from fractions import Fraction

import numpy as np

from refdem.cases.impact_benchmarks._floor import OnFloor, ball
from refdem.cases.impact_benchmarks._member import POSITIONS_ARE_ROUNDED
from refdem.cases.impact_benchmarks._values import Values
from refdem.core.parameters import Parameters
from refdem.core.quantity import Scales
from refdem.core.truth import Truth
from refdem.errors import UsageError
from refdem.scene import Scene


class Slide(OnFloor):
    """Thrown along x with `speed`, without spin, its overlap that of its weight; lasts twice as
    long as it slides.
    """

    def values(self, p: Parameters) -> Values:
        """The parameters; UsageError without friction, where the sphere slides for ever."""
        v = super().values(p)
        if not v.friction:
            raise UsageError(
                "parameter friction: got 0; expected more than 0: without it the sphere never rolls"
            )
        return v

    def scene(self, v: Values) -> Scene:
        """The sphere on the floor, where its weight holds it in equilibrium along y."""
        # k d = m g.
        overlap = v.mass * v.gravity / v.stiffness
        return self.of(v, [ball(v, v.mass, v.radius - overlap, v.speed)])

    def scales(self, v: Values) -> Scales:
        """tau = sqrt(m/k); L the way in tau, at least R/8; it lasts twice the slide.

        A solid sphere slides for t = 2 v0/(7 mu g), until friction has spun it up to v = omega R.
        """
        tau = float(np.sqrt(float(v.mass / v.stiffness)))
        sliding_time = float(Fraction(2, 7) * v.speed / (v.friction * v.gravity))
        length = max(float(v.speed) * tau, float(v.radius) / POSITIONS_ARE_ROUNDED)
        return Scales(length=length, tau=tau, duration=2 * sliding_time, mass=float(v.mass))

    def truth(self, v: Values, scale: Mapping[str, float]) -> Truth:
        """The truth in closed form: sliding, then rolling."""
        from refdem.truth.closed_forms.impact_benchmarks.slide_to_roll import SlideToRoll
        from refdem.truth.refiner import Refiner

        names = ("mass", "radius", "stiffness", "gravity", "friction", "speed")
        numbers = {name: getattr(v, name) for name in names}
        nothing = Fraction(0)
        begin = (nothing, nothing, v.speed, nothing, nothing)
        return SlideToRoll(refiner=Refiner.of(scale), **numbers, begin=begin)
