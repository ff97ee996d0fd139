"""The logistic map and the logistic equation (1.127): one is chaotic, the other never."""

from fractions import Fraction
from typing import ClassVar

import numpy as np

from refdem.core.case import Array, IterationCase
from refdem.core.maps import Logistic as LogisticMap
from refdem.core.maps import LogisticFlow
from refdem.core.parameters import Parameter, Parameters
from refdem.core.problem import Iteration
from refdem.core.quantity import Quantity, Scales
from refdem.core.trajectory import Trajectory
from refdem.core.truth import Truth


class Logistic(IterationCase):
    """The logistic map for x in [0, 1]."""

    id = "logistic"
    title = "Logistic map"
    words = ("chaos", "map", "bifurcation", "iteration", "feigenbaum")
    motion = "formula"
    statement = (
        "Each number is eta times the last one, times what that lacks of 1. Up to eta = 3 the"
        " iterates settle on 1 - 1/eta; at 3 they begin to alternate between two values, at 1 +"
        " sqrt 6 between four, and the doublings, each window 4.6692016 times shorter than the one"
        " before, pile up at eta = 3.5699457. Beyond lies chaos, and at eta = 4 errors double at"
        " every step: no run in binary64 can be compared with truth for more than some fifty"
        " iterates, and none is scored after that. The differential equation of the same right-hand"
        " side (form=ode, seen at t = n) climbs to 1 for any eta and is never chaotic: what a"
        " continuum model shows, a discrete one need not."
    )
    latex = (
        r"x_{n+1}=\eta\,x_n(1-x_n);\qquad \dot"
        r" x=\eta\,x(1-x):\;x(t)=\frac{1}{1+(1/x_0-1)e^{-\eta t}}"
    )
    source = (
        "Matuttis and Chen 2014, chapter 1, (1.127) and 1.6.2, 1.6.3, fig. 1.32; May 1976;"
        " Feigenbaum 1978"
    )
    parameters = (
        Parameter(
            name="eta", default="15/4", unit="1", doc="the nonlinearity", at_least=0, at_most=4
        ),
        Parameter(name="x0", default="1/4", unit="1", doc="iterate 0", at_least=0, at_most=1),
        Parameter(
            name="n",
            default="64",
            unit="1",
            doc="number of iterates",
            at_least=1,
            at_most=10_000_000,
            whole=True,
        ),
        Parameter(
            name="form",
            default="map",
            unit="",
            doc="the map, or the differential equation at t = n",
            choices=("map", "ode"),
        ),
    )
    chaotic_at: ClassVar = {"eta": "4"}

    def is_chaotic(self, p: Parameters) -> bool | None:
        """True for the map at eta = 4; False for the equation, for the map below the limit of the
        period doublings, and for a start on the fixed point 0 or on its preimage 1.

        None between: there windows of periodic orbits lie dense.
        """
        eta = p["eta"]
        assert isinstance(eta, Fraction)
        is_regular = p["form"] == "ode" or eta < Fraction("3.5699")
        if is_regular or p["x0"] in (0, 1):
            return False
        if eta == 4:
            return True
        return None

    def problem(self, p: Parameters) -> Iteration:
        """x0 under the map, or under the flow of the equation over one unit of time."""
        map_type: type[LogisticFlow | LogisticMap] = LogisticMap
        if p.form == "ode":
            map_type = LogisticFlow
        return Iteration(map_type(eta=p.eta), np.array([p.x0]), int(p.n))

    def scales(self, p: Parameters) -> Scales:
        """x lies in [0, 1]; tau is one iterate."""
        return Scales(length=1.0, tau=1.0, duration=p.n)

    def quantities(self, p: Parameters) -> tuple[Quantity, ...]:
        """The quantity that is judged: the iterate x."""
        return (Quantity("x_n", "1", 1.0),)

    def observe(self, p: Parameters, trajectory: Trajectory) -> dict[str, Array]:
        """The iterates x (T,) that are sampled."""
        if "x" in trajectory.values:
            return {"x_n": trajectory.values["x"]}
        return {}

    def truth(self, p: Parameters) -> Truth:
        """Balls about the orbit, or the closed form of the equation."""
        from refdem.truth.maps.logistic import truth

        return truth(p, {q.name: q.scale for q in self.quantities(p)})


CASE = Logistic()
