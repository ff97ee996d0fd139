"""Certified departure from the equilibria of a pendulum: the elliptic functions of
refdem/truth/closed_forms/pendulum.py.

The start is theta0 = delta at the bottom and pi - delta at the top, at rest; the top is known
exactly, as half a turn.
"""

from collections.abc import Mapping, Sequence
from fractions import Fraction
from typing import Any

from flint import arb

from refdem.core.parameters import Parameters
from refdem.core.truth import Truth
from refdem.truth.balls import arb_of
from refdem.truth.closed_form import ClosedForm, per_precision
from refdem.truth.closed_forms.pendulum import WITNESS, Equilibrium, Pendulum
from refdem.truth.exact import number
from refdem.truth.growth import Grows
from refdem.truth.smooth_flow import SmoothFlow

SEEN = ("x", "y", "vx", "vy")


class PendulumEquilibria(ClosedForm, SmoothFlow):
    """x, y, vx and vy of a pendulum; theta and thetadot are the coordinates in which the start is
    displaced.
    """

    method = Pendulum.method
    witness = (
        f"{WITNESS}; Cartesian equations with the rod's force (refdem/truth/witnesses/linked.py)"
    )
    state = Pendulum.state
    told = SEEN
    proof_of_s = Pendulum.proof_of_s

    def __init__(self, pendulum: Pendulum) -> None:
        self.refiner = pendulum.refiner
        self.pendulum = pendulum

    def evaluate(self, t: arb) -> dict[str, arb]:
        pendulum = self.pendulum
        angle = pendulum.evaluate(t)
        length = arb_of(pendulum.length)
        if isinstance(pendulum.motion(), Equilibrium):
            if pendulum.half_turns:
                side = length
            else:
                side = -length
            return angle | {"x": arb(0), "y": side, "vx": arb(0), "vy": arb(0)}
        sine, cosine = angle["theta"].sin_cos()
        speed = length * angle["thetadot"]
        place = {name: angle[name] for name in ("theta", "thetadot", "x", "y")}
        return place | {"vx": speed * cosine, "vy": speed * sine}

    def displaced(self, axis: int, amount: Fraction) -> "PendulumEquilibria":
        return PendulumEquilibria(self.pendulum.displaced(axis, amount))

    def seen(self, y: Sequence[Any]) -> dict[str, Any]:
        """The quantities of a state, by the operations of a traced field."""
        theta, rate = y
        sine = theta.sin() * self.pendulum.length
        cosine = theta.cos() * self.pendulum.length
        return {
            "theta": theta,
            "thetadot": rate,
            "x": sine,
            "y": -cosine,
            "vx": cosine * rate,
            "vy": sine * rate,
        }

    @per_precision
    def growth(self) -> Grows:
        return self.pendulum.growth_of(self.pendulum.equation(self.seen))


def truth(p: Parameters, scale: Mapping[str, float]) -> Truth:
    """The truth at these parameters (length, gravity, position, delta)."""
    length = number(p, "length")
    gravity = number(p, "gravity")
    delta = number(p, "delta")
    top = p["position"] == "top"
    start = {
        "mass": Fraction(1),
        "length": length,
        "gravity": gravity,
        "theta0": -delta if top else delta,
        "thetadot0": Fraction(0),
    }
    sizes = {**scale, "theta": 1.0, "thetadot": scale["vx"] / scale["x"]}
    return PendulumEquilibria(Pendulum(start, sizes, half_turns=int(top)))
