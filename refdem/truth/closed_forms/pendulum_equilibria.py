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
from refdem.core.truth import Ball, Truth
from refdem.truth.balls import arb_of
from refdem.truth.closed_forms.pendulum import WITNESS, Equilibrium, Pendulum
from refdem.truth.exact import number

SEEN = ("x", "y", "vx", "vy")


class PendulumEquilibria(Pendulum):
    """x, y, vx and vy; theta and thetadot are the coordinates in which the start is displaced."""

    witness = (
        f"{WITNESS}; Cartesian equations with the rod's force (refdem/truth/witnesses/linked.py)"
    )

    def evaluate(self, t: arb) -> dict[str, arb]:
        angle = super().evaluate(t)
        if isinstance(self.motion(), Equilibrium):
            side = arb_of(self.length) * (1 if self.half_turns else -1)
            return angle | {"x": arb(0), "y": side, "vx": arb(0), "vy": arb(0)}
        sine, cosine = angle["theta"].sin_cos()
        speed = arb_of(self.length) * angle["thetadot"]
        place = {name: angle[name] for name in ("theta", "thetadot", "x", "y")}
        return place | {"vx": speed * cosine, "vy": speed * sine}

    def seen(self, y: Sequence[Any]) -> dict[str, Any]:
        theta, rate = y
        sine = theta.sin() * self.length
        cosine = theta.cos() * self.length
        return {
            "theta": theta,
            "thetadot": rate,
            "x": sine,
            "y": -cosine,
            "vx": cosine * rate,
            "vy": sine * rate,
        }

    def at(self, t: Fraction) -> dict[str, Ball]:
        found = super().at(t)
        return {name: found[name] for name in SEEN}

    def constants(self) -> dict[str, arb]:
        return {}


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
    return PendulumEquilibria(start, sizes, half_turns=int(top))
