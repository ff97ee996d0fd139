"""Lorenz' three equations: chaos was found in them by computation, and they carry every error as
far as exact values can be proved.
"""

from fractions import Fraction

import numpy as np

from refdem.core.case import Array, IterationCase, given
from refdem.core.maps import LorenzFlow
from refdem.core.parameters import Parameter, Parameters
from refdem.core.problem import Iteration
from refdem.core.quantity import Quantity, Scales
from refdem.core.trajectory import Trajectory
from refdem.core.truth import Truth
from refdem.errors import UsageError
from refdem.truth.exact import numbers, vector

NAMES = ("x", "y", "z")
CLASSICAL = {"sigma": Fraction(10), "rho": Fraction(28), "beta": Fraction(8, 3)}
"""Lorenz' own numbers, at which Tucker (2002) proved that there is a strange attractor."""


class Lorenz(IterationCase):
    """The state (x, y, z) is sampled at t = n interval, in Lorenz' dimensionless time."""

    id = "lorenz"
    title = "Lorenz' equations"
    words = ("chaos", "butterfly", "attractor", "convection", "horizon", "predictability")
    motion = "formula"
    statement = (
        "Three equations for the convection of a fluid that is heated from below: x is the rate of"
        " turning, y and z are differences of temperature. Every volume of states shrinks at the"
        " same rate sigma + 1 + beta, wherever it is. Up to rho = 1 everything comes to rest at the"
        " origin; beyond it there are two more equilibria, where x = y = +-sqrt(beta (rho - 1)) and"
        " z = rho - 1; from rho = sigma (sigma + beta + 3)/(sigma - beta - 1) on, 24.74 at Lorenz'"
        " numbers, all three are unstable. At rho = 28 neighbours part by a factor e in about 1.1"
        " units of time: whoever computes in binary64 has lost the motion after 35 to 55 units, by"
        " the start and with whatever method, and no run is scored beyond its horizon."
    )
    latex = (
        r"\dot x=\sigma(y-x),\quad\dot y=x(\rho-z)-y,\quad\dot z=xy-\beta z;\qquad"
        r" \nabla\cdot\mathbf f=-(\sigma+1+\beta)"
    )
    source = (
        "Matuttis and Chen 2014, chapter 1, 1.6.4 and its reference 30; Lorenz 1963, (25)-(27);"
        " Sparrow 1982; Tucker 2002"
    )
    parameters = (
        Parameter(name="sigma", default="10", unit="1", doc="Prandtl's number", above=0),
        Parameter(
            name="rho",
            default="28",
            unit="1",
            doc="Rayleigh's number in units of that at which convection sets in",
            at_least=0,
        ),
        Parameter(
            name="beta", default="8/3", unit="1", doc="the shape of the convection cells", above=0
        ),
        Parameter(
            name="start", default="3,-2,15", unit="1", doc="x, y, z of iterate 0", shape=(3,)
        ),
        Parameter(
            name="interval",
            default="1/4",
            unit="1",
            doc="time from one iterate to the next",
            above=0,
            at_most=1,
        ),
        Parameter(
            name="n",
            default="64",
            unit="1",
            doc="number of iterates",
            at_least=1,
            at_most=10_000,
            whole=True,
        ),
    )
    chaotic_at = given(n="96")

    def refuse(self, p: Parameters) -> None:
        """Raises UsageError for a start at rest: nothing would ever move."""
        sigma, rho, beta = numbers(p, "sigma", "rho", "beta").values()
        x, y, z = vector(p, "start")
        rates = (sigma * (y - x), x * (rho - z) - y, x * y - beta * z)
        if not any(rates):
            raise UsageError(
                "lorenz: start is an equilibrium, where nothing moves; take another start"
            )

    def is_chaotic(self, p: Parameters) -> bool | None:
        """True at Lorenz' own numbers, unless the start is on the z axis, which leads into the
        origin; False up to rho = 1, where everything does; None elsewhere.
        """
        x, y, _ = vector(p, "start")
        on_the_axis = x == 0 and y == 0
        shape = numbers(p, "sigma", "rho", "beta")
        if on_the_axis or shape["rho"] <= 1:
            return False
        if shape == CLASSICAL:
            return True
        return None

    def problem(self, p: Parameters) -> Iteration:
        """The start under the flow of the equations over one interval."""
        flow = LorenzFlow(sigma=p.sigma, rho=p.rho, beta=p.beta, interval=p.interval)
        return Iteration(flow, np.array(p.start), int(p.n))

    def scales(self, p: Parameters) -> Scales:
        """L = sigma + rho, the height about which the motion is gathered, or the distance of the
        start from the origin if that is more; tau is one iterate.
        """
        farthest = float(np.linalg.norm(p.start))
        return Scales(length=max(p.sigma + p.rho, farthest), tau=1.0, duration=p.n)

    def quantities(self, p: Parameters) -> tuple[Quantity, ...]:
        """The quantities that are judged: x, y and z."""
        length = self.scales(p).length
        return tuple(Quantity(name, "1", length) for name in NAMES)

    def observe(self, p: Parameters, trajectory: Trajectory) -> dict[str, Array]:
        """x, y and z (T,) of the iterates that are sampled."""
        if "state" not in trajectory.values:
            return {}
        return dict(zip(NAMES, trajectory.values["state"].T, strict=True))

    def truth(self, p: Parameters) -> Truth:
        """The truth by validated integration of the equations."""
        from refdem.truth.closed_forms.lorenz import truth

        return truth(p, {q.name: q.scale for q in self.quantities(p)})


CASE = Lorenz()
