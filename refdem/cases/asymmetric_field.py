"""A particle crosses an asymmetric field of force and gains energy; coming back it loses as much
(1.139).
"""

import numpy as np

from refdem.cases._line import Array, observe
from refdem.core.case import Case
from refdem.core.parameters import Parameter, Parameters
from refdem.core.quantity import Quantity, Scales
from refdem.core.trajectory import Trajectory
from refdem.core.truth import Truth
from refdem.errors import UsageError
from refdem.scene import Body, Scene
from refdem.scene.elements.piecewise_field import PiecewiseField


class AsymmetricField(Case):
    """A point on x, from x0 with v0, and a force between x1 and x2 that is largest at 0."""

    id = "asymmetric-field"
    title = "Asymmetric field of force"
    words = ("escape", "potential", "well")
    motion = "oscillating"
    statement = (
        "A force that rises from x1 to 0 and falls more steeply, or less, to x2 pushes all that"
        " crosses it forward: kinetic energy appears. On the way back it disappears again, to the"
        " same amount: kinetic energy plus minus the integral of the force stays."
    )
    latex = (
        r"F=k_1(x-x_1)\ (x_1<x<0),\quad F=k_2x-k_1x_1\ (0<x<x_2),\quad k_2=\frac{k_1x_1}{x_2},\quad"
        r"W=\int F\,\mathrm dx=\tfrac12k_1|x_1|(x_2-x_1)"
    )
    source = "Matuttis and Chen 2014, chapter 1, (1.139) and (1.140), fig. 1.37"
    parameters = (
        Parameter(name="mass", default="1", unit="kg", doc="the particle", above=0),
        Parameter(
            name="k1",
            default="1",
            unit="N/m",
            doc="slope of the force from x1 to 0; the other follows",
            above=0,
        ),
        Parameter(
            name="x1", default="-1", unit="m", doc="where the force begins, below 0", at_most=0
        ),
        Parameter(name="x2", default="1/2", unit="m", doc="where it ends, above 0", above=0),
        Parameter(name="x0", default="-5/4", unit="m", doc="place at the start"),
        Parameter(name="v0", default="1", unit="m/s", doc="velocity at the start"),
    )

    def refuse(self, p: Parameters) -> None:
        """Raises UsageError for a field without a rising flank, and for a particle that nothing
        ever moves.
        """
        if p.x1 == 0:
            raise UsageError(
                "parameter x1: got 0; expected it below 0: the force rises from there to 0"
            )
        if p.v0 == 0 and not p.x1 < p.x0 < p.x2:
            raise UsageError(
                "parameters x0 and v0: got a start at rest outside the field; expected one at which"
                " something moves"
            )

    def scene(self, p: Parameters) -> Scene:
        """The particle at its start, and the field along x with k2 = k1 x1/x2, which makes the
        force continuous at 0.
        """
        point = Body(mass=p.mass, position=(p.x0, 0.0, 0.0), velocity=(p.v0, 0.0, 0.0))
        return Scene.of([point], [PiecewiseField(k1=p.k1, k2=p.k1 * p.x1 / p.x2, x1=p.x1, x2=p.x2)])

    def scales(self, p: Parameters) -> Scales:
        """L is the width of the field or |x0|; T twice the time to cross the field.

        tau is sqrt(m/k) of the steeper flank, k2 = k1 |x1|/x2, or the time of a crossing at the
        largest speed, v^2 = v0^2 + 2 W/m with the work W = k1 |x1| (x2 - x1)/2, if that is shorter.
        """
        width = p.x2 - p.x1
        largest_speed = np.sqrt(p.v0**2 - p.k1 * p.x1 * (p.x2 - p.x1) / p.mass)
        oscillation = np.sqrt(p.mass / (p.k1 * max(1.0, -p.x1 / p.x2)))
        tau = float(min(oscillation, width / largest_speed))
        distance = width + max(0.0, p.x1 - p.x0, p.x0 - p.x2)
        if not p.x1 < p.x0 < p.x2:
            speed = abs(p.v0)
        else:
            # A start at rest inside the field is pushed out of it.
            speed = max(abs(p.v0), width / float(oscillation))
        duration = float(2 * distance / speed)
        return Scales(length=max(width, abs(p.x0)), tau=tau, duration=duration, mass=p.mass)

    def quantities(self, p: Parameters) -> tuple[Quantity, ...]:
        """The quantities that are judged: position [m] and velocity [m/s]."""
        s = self.scales(p)
        return (Quantity("x", "m", s.length), Quantity("v", "m/s", s.speed))

    def observe(self, p: Parameters, trajectory: Trajectory) -> dict[str, Array]:
        """The position [m] and the velocity [m/s] at the samples, each (T,)."""
        return observe(trajectory)

    def truth(self, p: Parameters) -> Truth:
        """Hyperbolic functions, then sine and cosine, between exact energies."""
        from refdem.truth.closed_forms.asymmetric_field import truth

        return truth(p, {q.name: q.scale for q in self.quantities(p)})


CASE = AsymmetricField()
