"""Certified motion near the equilibria of a pendulum, by the elliptic functions of
refdem/truth/closed_forms/pendulum.py.

The start is at rest at theta0 = delta near the bottom, or at pi - delta near the top; pi is exact,
as a half turn.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

from flint import arb

from refdem.core.parameters import Parameters
from refdem.core.truth import Truth
from refdem.truth.balls import arb_of
from refdem.truth.closed_form import ClosedForm, displaced_part, per_precision
from refdem.truth.closed_forms.pendulum import WITNESS, Equilibrium, Pendulum
from refdem.truth.exact import number
from refdem.truth.growth import Grows
from refdem.truth.refiner import Refiner
from refdem.truth.smooth_flow import derivative_by_start
from refdem.truth.validated_flow import ValidatedFlow

SEEN = ("x", "y", "vx", "vy")


@dataclass(frozen=True)
class PendulumEquilibria(ClosedForm):
    """The truth of a pendulum near an equilibrium: x, y [m], vx and vy [m/s].

    theta and thetadot are the coordinates in which the start is displaced.
    """

    method = Pendulum.method
    witness = (
        f"{WITNESS}; Cartesian equations with the rod's force (refdem/truth/witnesses/linked.py)"
    )
    state = Pendulum.state
    reported = SEEN
    proof_of_s = Pendulum.proof_of_s

    pendulum: Pendulum

    displaced = displaced_part("pendulum")
    jacobian = derivative_by_start

    def by_equation(self) -> ValidatedFlow:
        """The quantities from the equation of motion, to the same digits."""
        flow = self.pendulum.equation(self.seen).refined(self.digits)
        flow.reported = SEEN
        return flow

    def evaluate(self, t: arb) -> dict[str, arb]:
        """x = l sin theta, y = -l cos theta and their rates; at rest these are exact."""
        pendulum = self.pendulum
        quantities = pendulum.evaluate(t)
        length = arb_of(pendulum.length)
        if isinstance(pendulum.motion(), Equilibrium):
            # theta = pi: y = l; theta = 0: y = -l.
            if pendulum.half_turns:
                height = length
            else:
                height = -length
            return quantities | {"x": arb(0), "y": height, "vx": arb(0), "vy": arb(0)}
        # vx = l theta' cos theta,  vy = l theta' sin theta
        sine, cosine = quantities["theta"].sin_cos()
        speed = length * quantities["thetadot"]
        position = {name: quantities[name] for name in ("theta", "thetadot", "x", "y")}
        return position | {"vx": speed * cosine, "vy": speed * sine}

    def seen(self, y: Sequence[Any]) -> dict[str, Any]:
        """The quantities of a state, by the operations of a traced field."""
        theta, thetadot = y
        # x = l sin theta, y = -l cos theta, vx = l theta' cos theta, vy = l theta' sin theta.
        l_sine = theta.sin() * self.pendulum.length
        l_cosine = theta.cos() * self.pendulum.length
        return {
            "theta": theta,
            "thetadot": thetadot,
            "x": l_sine,
            "y": -l_cosine,
            "vx": l_cosine * thetadot,
            "vy": l_sine * thetadot,
        }

    @per_precision
    def growth(self) -> Grows:
        return self.pendulum.growth_of(self.pendulum.equation(self.seen))


def truth(p: Parameters, scale: Mapping[str, float]) -> Truth:
    """The truth at these parameters (length, gravity, position, delta)."""
    length = number(p, "length")
    gravity = number(p, "gravity")
    delta = number(p, "delta")
    # Near the top theta = pi - delta: half a turn and the offset -delta.
    is_top = p["position"] == "top"
    if is_top:
        theta0 = -delta
    else:
        theta0 = delta
    start = {
        "mass": Fraction(1),
        "length": length,
        "gravity": gravity,
        "theta0": theta0,
        "thetadot0": Fraction(0),
    }
    refiner = Refiner.of({**scale, "theta": 1.0, "thetadot": scale["vx"] / scale["x"]})
    return PendulumEquilibria(refiner, Pendulum(refiner=refiner, **start, half_turns=int(is_top)))
