"""A polygon carried through phase space: its corners one by one, and its area.

Liouville: d/dt dA = (div F) dA: kept by oscillator and pendulum, times exp(-2 delta t) in a fluid.
Under dry friction take v < 0, where the flow turns (X, Y) = (x - f/k, v/w) clockwise about 0, dA =
w R dR da. A point crosses v = 0 when a reaches -pi, at x = f/k - R, and again each half period
later; what crosses there between x and x + dx during dt has the area (k|x| + f)/m dx dt before and
(k|x| - f)/m dx dt after. So after n crossings dA is w max(0, R - 2 n f/k) dR da, zero for what has
stopped, and by Green's theorem A = w/2 of the integral of max(0, R - 2 n f/k)^2 da round the
polygon, n = floor((w t - a)/pi).
"""

from collections.abc import Mapping, Sequence
from copy import copy
from fractions import Fraction
from itertools import pairwise
from typing import Any

from flint import arb

from refdem.core.parameters import Parameters
from refdem.core.truth import Ball, Truth
from refdem.errors import NotCertifiedError
from refdem.truth.balls import Guarded, UndecidedError, arb_of, refined
from refdem.truth.closed_forms import (
    coulomb_oscillator,
    harmonic_oscillator,
    pendulum,
    viscous_oscillator,
)
from refdem.truth.exact import number

Corner = tuple[Fraction, Fraction]
FORMS: dict[str, tuple[Any, str, str]] = {
    "harmonic": (harmonic_oscillator.truth, "x", "v"),
    "viscous": (viscous_oscillator.truth, "x", "v"),
    "coulomb": (coulomb_oscillator.truth, "x", "v"),
    "pendulum": (pendulum.truth, "theta", "thetadot"),
}
"""Whose motion a corner has, and the names of its place and rate there."""
LARGEST = 1e100


class PhaseFlow(Guarded, Truth):
    """x_k, v_k of the corners, and `area` [their product's unit], at t >= 0; scalar `area_0`."""

    witness = (
        "area by quadrature of the local factor over the polygon; corners as the cases of the flows"
    )

    def __init__(
        self,
        p: Mapping[str, Any],
        corners: Sequence[Corner],
        scale: Mapping[str, float],
        *,
        digits: int = 40,
    ) -> None:
        form, self.place, self.rate = FORMS[p["flow"]]
        self.flow, self.corners, self.digits = p["flow"], list(corners), digits
        self.delta = number(p, "delta")
        self.square = number(p, "stiffness") / number(p, "mass")
        self.shift = number(p, "friction_force") / number(p, "stiffness")
        self.method = (
            f"corners: {form.__module__.rpartition('.')[2].replace('_', ' ')}; area: Liouville's"
            " theorem in closed form"
        )
        kept = {
            name: p[name] for name in ("mass", "stiffness", "delta", "friction_force", "length")
        }
        kept["gravity"] = p["gravity"] if self.flow == "pendulum" else Fraction(0)
        self.motions: list[Truth] = []
        for k, (x, v) in enumerate(corners):
            own = {self.place: scale[f"x_{k}"], self.rate: scale[f"v_{k}"]}
            if (
                self.flow == "pendulum"
            ):  # what else it knows of; as large as it can be, so that it never counts
                own |= {"x": float(p["length"]), "y": float(p["length"]), "rod_force": LARGEST}
            start = {f"{self.place}0": x, f"{self.rate}0": v}
            self.motions.append(form({**kept, **start}, own))

    def refined(self, digits: int) -> "PhaseFlow":
        """The same truth with radii of at most 10^-digits."""
        other = copy(self)
        other.digits, other.motions = digits, [motion.refined(digits) for motion in self.motions]
        return other

    def at(self, t: Fraction) -> dict[str, Ball]:
        """Every corner, and the area."""
        found: dict[str, Ball] = {}
        for k, motion in enumerate(self.motions):
            balls = motion.at(t)
            found |= {f"x_{k}": balls[self.place], f"v_{k}": balls[self.rate]}
        area = refined(
            lambda: {"area": self.area(arb_of(t))},
            abs(self.first_area()) / Fraction(10) ** self.digits,
            most=4096,
        )
        if area is None:
            told = (
                f"at t = {float(t):.17g} s: corner: a corner or a side lies where a part of the"
                " head turns or stops"
            )
            raise NotCertifiedError(told, code="corner", time=float(t))
        return found | area

    def sensitivity(self, t: Fraction) -> float:
        """The sensitivity S(t) of the corner that feels its start most."""
        return max(motion.sensitivity(t) for motion in self.motions)

    def scalars(self) -> dict[str, Ball]:
        """The area at the start, exact."""
        return {"area_0": Ball(self.first_area(), Fraction(0))}

    def first_area(self) -> Fraction:
        """The area of the polygon at the start, positive against the clock."""
        return sum((a[0] * b[1] - b[0] * a[1] for a, b in self.sides()), Fraction(0)) / 2

    def sides(self) -> list[tuple[Corner, Corner]]:
        """The sides of the outline, each as its two corners."""
        return list(zip(self.corners, [*self.corners[1:], self.corners[0]], strict=True))

    def area(self, t: arb) -> arb:
        """Every quantity at time t, at the current precision.

        UndecidedError where balls cannot tell how often a part has turned.
        """
        first = arb_of(self.first_area())
        if self.flow == "viscous":
            return first * (-2 * arb_of(self.delta) * t).exp()
        if self.flow != "coulomb":
            return first
        turned = self._turned()
        phase = arb_of(self.square).sqrt() * t
        half_turns = (phase / arb.pi()).floor().unique_fmpz()
        if half_turns is None:
            raise UndecidedError("how many half periods have passed")
        ray = (phase - half_turns * arb.pi() - arb.pi()).sin_cos()
        total = sum(
            (_swept(side, ray, int(half_turns), 2 * self.shift, self.square) for side in turned),
            arb(0),
        )
        return total * arb_of(self.square).sqrt()

    def _turned(self) -> list[tuple[Corner, Corner]]:
        """Sides in (X, v) for v < 0; a head above v = 0 is turned by half a turn, under which the
        flow is the same.
        """
        if all(v < 0 for _, v in self.corners):
            return [((a[0] - self.shift, a[1]), (b[0] - self.shift, b[1])) for a, b in self.sides()]
        if all(v > 0 for _, v in self.corners):
            return [
                ((-a[0] - self.shift, -a[1]), (-b[0] - self.shift, -b[1])) for a, b in self.sides()
            ]
        raise NotCertifiedError(
            "corner: the head starts on both sides of v = 0", code="corner", time=0.0
        )


def _swept(
    side: tuple[Corner, Corner], ray: tuple[arb, arb], turns: int, loss: Fraction, square: Fraction
) -> arb:
    """Half the integral of max(0, R - n loss)^2 da along a side, n = turns + 1 beyond the ray
    (sine, cosine), else `turns`.
    """
    (x, v), (x_end, v_end) = side
    if x * v_end == x_end * v:
        return arb(0)  # along a ray from the centre
    w = arb_of(square).sqrt()
    p = (arb_of(x), arb_of(v) / w)
    d = (arb_of(x_end - x), arb_of(v_end - v) / w)
    sine, cosine = ray
    # cross product with the ray: positive on the side that is yet to turn
    ends_beyond = [cosine * q[1] - sine * q[0] for q in (p, (p[0] + d[0], p[1] + d[1]))]
    is_cut = _positive(ends_beyond[0]) != _positive(ends_beyond[1])
    if is_cut:
        cuts = [ends_beyond[0] / (ends_beyond[0] - ends_beyond[1])]
    else:
        cuts = []
    for n in (turns, turns + 1):
        if n:
            reach = arb_of(n * loss)
            cuts += _roots(_dot(d, d), 2 * _dot(p, d), _dot(p, p) - reach * reach)
    ends = [arb(0), *_sorted([cut for cut in cuts if _inside(cut)]), arb(1)]
    total = arb(0)
    for begin, end in pairwise(ends):
        a, middle, b = (
            tuple(q + s * e for q, e in zip(p, d, strict=True))
            for s in (begin, (begin + end) / 2, end)
        )
        if _positive(cosine * middle[1] - sine * middle[0]):
            n = turns
        else:
            n = turns + 1
        reach = arb_of(n * loss)
        if not n or _positive(_dot(middle, middle) - reach * reach):
            total += _piece(a, b, reach)
    return total


def _piece(a: Any, b: Any, reach: arb) -> arb:
    """Half the integral of (R - reach)^2 da along the straight line from a to b: R^2 da is twice an
    area, R da is c d asinh(s/|c|).
    """
    twice = a[0] * b[1] - a[1] * b[0]
    along = (b[0] - a[0], b[1] - a[1])
    length = _dot(along, along).sqrt()
    off = twice / length
    s_begin, s_end = (_dot(q, along) / length for q in (a, b))
    swing = off * ((s_end / abs(off)).asinh() - (s_begin / abs(off)).asinh())
    turn = arb.atan2(b[1], b[0]) - arb.atan2(a[1], a[0])
    found: arb = (twice - 2 * reach * swing + reach * reach * turn) / 2
    return found


def _dot(a: Any, b: Any) -> arb:
    """The dot product of two vectors; a power of a ball that holds 0 would be nan."""
    found: arb = a[0] * b[0] + a[1] * b[1]
    return found


def _roots(square: arb, linear: arb, constant: arb) -> list[arb]:
    """Real roots of square s^2 + linear s + constant, square > 0."""
    inside = linear * linear - 4 * square * constant
    if _positive(inside):
        return [(sign * inside.sqrt() - linear) / (2 * square) for sign in (-1, 1)]
    return []


def _inside(cut: arb) -> bool:
    return _positive(cut) and _positive(1 - cut)


def _sorted(cuts: list[arb]) -> list[arb]:
    return sorted(cuts, key=lambda cut: float(cut.mid()))


def _positive(value: arb) -> bool:
    """Whether it is positive and not negative; UndecidedError where a ball holds both."""
    if not (value > 0 or value < 0):
        raise UndecidedError("on which side of a boundary a part of the head is")
    return bool(value > 0)


def truth(p: Parameters, corners: Sequence[Corner], scale: Mapping[str, float]) -> Truth:
    """The truth at parameters flow, mass, stiffness, delta, friction_force, length, gravity.

    `scale` of x_k and v_k.
    """
    return PhaseFlow(p, corners, scale)
