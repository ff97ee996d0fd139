"""Displaced starts of spheres that touch at t = 0, along every coordinate that their S counts.

What the parameters of a pair do not move, the symmetries of its motion do: the same motion
elsewhere, in a frame that moves uniformly, turned, or later.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import Any

from refdem.core.truth import Ball
from refdem.truth.closed_forms.impact_benchmarks.three_spheres import ThreeSpheres
from refdem.truth.closed_forms.impact_benchmarks.wall import WallImpact
from refdem.truth.closed_forms.spinning_spheres import SpinningSpheres
from refdem.truth.collision import Collision
from refdem.truth.refiner import Refiner

Values = Mapping[str, Ball]
Change = Callable[[Fraction, Values], Mapping[str, Fraction]]
"""What a symmetry adds to the quantities at a time, to first order."""
AXES = "xyz"


@dataclass(frozen=True)
class Seen:
    """A motion as it is seen from another place, frame or side."""

    truth: Collision
    change: Change

    def at(self, t: Fraction) -> Values:
        """The quantities at t, with the change."""
        values = self.truth.at(t)
        changes = self.change(t, values)
        return {
            name: Ball(ball.mid + changes.get(name, 0), ball.radius)
            for name, ball in values.items()
        }


@dataclass(frozen=True)
class TouchesLater:
    """A motion whose spheres fly freely for `delay` [s] before they touch."""

    truth: Collision
    delay: Fraction

    def at(self, t: Fraction) -> Values:
        """The quantities at t: those of `delay` before, or on the way to touch at the start."""
        if t >= self.delay:
            return self.truth.at(t - self.delay)
        values = self.truth.at(Fraction(0))
        found = dict(values)
        for name in values:
            if name.startswith("r"):
                speed = values["v" + name[1:]].mid
                found[name] = Ball(values[name].mid - speed * (self.delay - t), values[name].radius)
        return found


def bodies(values: Values) -> list[str]:
    """What follows r, v and omega in the names of the bodies: a number, or nothing."""
    return sorted({name.split(".")[0][1:] for name in values if name.startswith("r")})


def elsewhere(axis: str, amount: Fraction) -> Change:
    """The change [m] of all places along an axis."""
    return lambda t, values: {f"r{body}.{axis}": amount for body in bodies(values)}


def in_moving_frame(axis: str, amount: Fraction) -> Change:
    """The change of all velocities [m/s] along an axis, and of the places that follow from it."""

    def change(t: Fraction, values: Values) -> Mapping[str, Fraction]:
        found = {}
        for body in bodies(values):
            found[f"v{body}.{axis}"] = amount
            found[f"r{body}.{axis}"] = amount * t
        return found

    return change


def turned(axis: int, amount: Fraction) -> Change:
    """The change of all vectors by a small turn [rad] about an axis through the origin."""
    one, other = (AXES[(axis + k) % 3] for k in (1, 2))

    def change(t: Fraction, values: Values) -> Mapping[str, Fraction]:
        found = {}
        for vector in {name.split(".")[0] for name in values}:
            # e x (a, b) = (-b, a) in the plane across e.
            found[f"{vector}.{one}"] = -amount * values[f"{vector}.{other}"].mid
            found[f"{vector}.{other}"] = amount * values[f"{vector}.{one}"].mid
        return found

    return change


def other_parameters(truth: Collision, size: Fraction) -> list[Collision]:
    """The motions after touch of pairs with other velocities and spins."""
    scale = {name.split(".")[0].rstrip("123"): value for name, value in truth.scale.items()}
    velocity = size * scale["v"]
    spin = size * scale["omega"]
    if isinstance(truth, WallImpact):
        wall = truth.wall
        pairs: list[Any] = [
            replace(wall, normal=wall.normal + velocity),
            replace(wall, across=wall.across + velocity),
            replace(wall, spin=wall.spin + spin),
        ]
    else:
        pair = truth.spheres
        pairs = [
            replace(pair, closing_speed=pair.closing_speed + velocity),
            replace(pair, angle=pair.angle + size),
        ]
        for place in spins_of(truth):
            spins = list(pair.spins)
            spins[place] += spin
            pairs.append(replace(pair, spins=tuple(spins)))
    return [type(truth)(Refiner.of(truth.scale), pair) for pair in pairs]


def spins_of(truth: Collision) -> list[int]:
    """The places of the spins that S counts: all six, or the two across the plane."""
    if isinstance(truth, SpinningSpheres):
        return list(range(6))
    return [2, 5]


def symmetries(truth: Collision, size: Fraction) -> list[Change]:
    """The changes by which the same motion is seen otherwise."""
    lengths = size * truth.scale[next(name for name in truth.scale if name.startswith("r"))]
    speeds = size * truth.scale[next(name for name in truth.scale if name.startswith("v"))]
    if isinstance(truth, WallImpact):
        return [elsewhere("y", lengths)]
    if isinstance(truth, ThreeSpheres):
        return [turned(2, size)]
    if isinstance(truth, SpinningSpheres):
        axes = AXES
        turns = [turned(axis, size) for axis in range(3)]
    else:
        axes = "xy"
        turns = [turned(2, size)]
    places = [elsewhere(axis, lengths) for axis in axes]
    frames = [in_moving_frame(axis, speeds) for axis in axes]
    return [*places, *frames, *turns]


def touching_starts(
    truth: Collision, size: Fraction, everything: Callable[[Any], Any]
) -> list[Any]:
    """A motion from a displaced start for every coordinate that S counts; `size` is that of the
    displacement, in scales.
    """
    found: list[Any] = [everything(other) for other in other_parameters(truth, size)]
    found += [Seen(truth, change) for change in symmetries(truth, size)]
    start = truth.at(Fraction(0))
    fastest = max(
        abs(ball.mid) / truth.scale[name.replace("v", "r", 1)]
        for name, ball in start.items()
        if name.startswith("v")
    )
    found.append(TouchesLater(truth, size / fastest))
    return found
