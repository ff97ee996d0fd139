"""A polygon that a flow moves through phase space (x, v): the motion of its corners, and its area.

Theorem (Liouville): an element dA of phase area changes as d/dt dA = (div F) dA. So the area is
constant for the harmonic oscillator and the pendulum, and decreases as exp(-2 delta t) with viscous
damping. Under dry friction it decreases where a part of the polygon crosses v = 0, by the formula
below.

Hypotheses, and where each is checked:

* with dry friction the polygon starts on one side of v = 0: `_sides_about_the_centre`, exactly;
* how often each part has crossed v = 0, and what has stopped: in ball arithmetic, for whole parts
  of a side (`_side_integral`). UndecidedError where that is not decided, which is reported as
  `corner`;
* the corners move by the closed forms of their flows (`FORMS`), which check their own hypotheses.

Formula (dry friction, force f against the velocity, w^2 = k/m): while v < 0 the flow turns (X, Y) =
(x - f/k, v/w) clockwise about 0. In polar coordinates (R, a) there, dA = w R dR da. A point crosses
v = 0 when its angle reaches -pi, at x = f/k - R, and again each half period pi/w later. What
crosses there between x and x + dx during dt has the area (k|x| + f)/m dx dt before and (k|x| - f)/m
dx dt after. So after n crossings an element that had dA = w R dR da at the start has

    w max(0, R - 2 n f/k) dR da,    n = floor((w t - a)/pi),

zero for what has stopped. By Green's theorem the area is an integral round the polygon at the
start,

    A = (w/2) integral of max(0, R - 2 n f/k)^2 da.

A `Corner` is (x, v) in m (or rad) and m/s; `loss` is 2 f/k, what R loses at each crossing.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from itertools import pairwise
from typing import Any, TypeVar

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
from refdem.truth.dual import Derivatives, atan2, flattened, plain, unflattened
from refdem.truth.exact import number
from refdem.truth.reals import Number
from refdem.truth.refiner import Formula
from refdem.truth.sensitivities import Differentiable, HasEquation

Corner = tuple[Fraction, Fraction]
Told = TypeVar("Told")
FORMS: dict[str, tuple[Any, str, str]] = {
    "harmonic": (harmonic_oscillator.truth, "x", "v"),
    "viscous": (viscous_oscillator.truth, "x", "v"),
    "coulomb": (coulomb_oscillator.truth, "x", "v"),
    "pendulum": (pendulum.truth, "theta", "thetadot"),
}
"""The closed form that moves a corner in each flow, and its names of position and rate."""
LARGEST = 1e100
"""The scale of quantities that are not reported here, so large that their error is negligible."""


@dataclass(frozen=True, kw_only=True)
class PhaseFlow(Guarded, Truth):
    """x_k, v_k of the corners, and `area` [their product's unit], at t >= 0; scalar `area_0`.

    `corners` are those at the start, and `motions` their truths. `square` is w^2 = k/m [1/s^2],
    `shift` f/k [m] the shift of the centre of turning, `delta` [1/s] that of a fluid.
    """

    witness = (
        "area by quadrature of the local factor over the polygon; corners as the cases of the flows"
    )

    flow: str
    corners: tuple[Corner, ...]
    motions: tuple[Truth, ...]
    square: Number
    shift: Number
    delta: Number
    method: str
    digits: int = 40

    def refined(self, digits: int) -> "PhaseFlow":
        """The same truth with radii of at most 10^-digits."""
        motions = tuple(motion.refined(digits) for motion in self.motions)
        return replace(self, digits=digits, motions=motions)

    def at(self, t: Fraction) -> dict[str, Ball]:
        """x_k and v_k of every corner, and `area`, at time t.

        Raises NotCertifiedError if no precision decides how often a part of the polygon has
        crossed v = 0.
        """
        area = self.proved(lambda: {"area": self.area(arb_of(t))}, t)
        return self.of_corners([motion.at(t) for motion in self.motions]) | area

    def derivatives(self, t: Fraction, count: int) -> Derivatives:
        """The derivatives of the quantities by the parameters: of each corner by its own truth, of
        the area by its formula.
        """
        corners = []
        for motion in self.motions:
            if isinstance(motion, HasEquation):
                motion = motion.by_equation()
            assert isinstance(motion, Differentiable)
            corners.append(motion.derivatives(t, count))
        area = self.proved(lambda: flattened({"area": self.area(arb_of(t))}, count), t)
        return self.of_corners(corners) | unflattened(area, count)

    def of_corners(self, corners: Sequence[Mapping[str, Told]]) -> dict[str, Told]:
        """The values of position and rate of each corner, under the names x_k and v_k."""
        _, place, rate = FORMS[self.flow]
        told = {}
        for k, corner in enumerate(corners):
            told[f"x_{k}"] = corner[place]
            told[f"v_{k}"] = corner[rate]
        return told

    def proved(self, formula: Formula, t: Fraction) -> dict[str, Ball]:
        """Balls of a formula of the area at t, to the digits of this truth.

        Raises NotCertifiedError if no precision decides how often a part of the polygon has
        crossed v = 0.
        """
        target = abs(plain(self.first_area())) / Fraction(10) ** self.digits
        balls = refined(formula, target, most=4096)
        if balls is None:
            message = (
                f"at t = {float(t):.17g} s: corner: a corner or a side lies where a part of the"
                " head turns or stops"
            )
            raise NotCertifiedError(message, code="corner", time=float(t))
        return balls

    def sensitivity(self, t: Fraction) -> float:
        """S(t): the largest of those of the corners."""
        return max(motion.sensitivity(t) for motion in self.motions)

    def scalars(self) -> dict[str, Ball]:
        """The initial area, exact."""
        return {"area_0": Ball(self.first_area(), Fraction(0))}

    def first_area(self) -> Fraction:
        """The area of the polygon at the start: half the sum of x_i v_(i+1) - x_(i+1) v_i.

        It is positive where the corners are in counterclockwise order.
        """
        return sum((a[0] * b[1] - b[0] * a[1] for a, b in self.sides()), Fraction(0)) / 2

    def sides(self) -> list[tuple[Corner, Corner]]:
        """The sides of the outline, each as its two corners."""
        return list(zip(self.corners, [*self.corners[1:], self.corners[0]], strict=True))

    def area(self, t: arb) -> arb:
        """The area at time t, at the current precision.

        Raises UndecidedError where it is not decided how often a part has crossed v = 0.
        """
        # A(t) = A(0) exp(-2 delta t) with viscous damping, and A(0) without damping.
        first = arb_of(self.first_area())
        if self.flow == "viscous":
            return first * (-2 * arb_of(self.delta) * t).exp()
        if self.flow != "coulomb":
            return first
        # Dry friction: A = w integral of max(0, R - n loss)^2/2 da with n = floor((w t - a)/pi) and
        # loss = 2 f/k. With w t = half_turns pi + rest and -pi < a < 0, n is half_turns + 1 for
        # angles a below rest - pi, and half_turns above: the ray at that angle separates them.
        phase = arb_of(self.square).sqrt() * t
        half_turns = (phase / arb.pi()).floor().unique_fmpz()
        if half_turns is None:
            raise UndecidedError("how many half periods have passed")
        ray = (phase - half_turns * arb.pi() - arb.pi()).sin_cos()
        loss = 2 * self.shift
        integrals = [
            _side_integral(side, ray, int(half_turns), loss, self.square)
            for side in self._sides_about_the_centre()
        ]
        return sum(integrals, arb(0)) * arb_of(self.square).sqrt()

    def _sides_about_the_centre(self) -> list[tuple[Corner, Corner]]:
        """The sides in (X, v), X = x - f/k, for v < 0.

        A polygon with v > 0 is first rotated by half a turn, (x, v) -> (-x, -v), under which the
        flow is invariant.
        Raises NotCertifiedError if it starts on both sides of v = 0.
        """
        if all(v < 0 for _, v in self.corners):
            sign = 1
        elif all(v > 0 for _, v in self.corners):
            sign = -1
        else:
            raise NotCertifiedError(
                "corner: the head starts on both sides of v = 0", code="corner", time=0.0
            )
        sides = []
        for (x, v), (x_end, v_end) in self.sides():
            begin = (sign * x - self.shift, sign * v)
            end = (sign * x_end - self.shift, sign * v_end)
            sides.append((begin, end))
        return sides


def _side_integral(
    side: tuple[Corner, Corner], ray: tuple[arb, arb], turns: int, loss: Number, square: Number
) -> arb:
    """Half the integral of max(0, R - n loss)^2 da along a side (X, v) of the polygon.

    n is `turns` on the counterclockwise side of the ray (sine, cosine of its angle) and turns + 1
    on the other; `square` is w^2. The side is cut where it meets the ray or a circle R = n loss.
    Between two cuts n and the sign of R - n loss are constant, so that the midpoint of a part is
    representative. Raises UndecidedError where a sign is not decided.
    """
    (x, v), (x_end, v_end) = side
    if x * v_end == x_end * v:
        # The side lies on a ray from the centre: da = 0.
        return arb(0)
    # The side is p + s d with 0 <= s <= 1 in the coordinates (X, Y) = (X, v/w).
    w = arb_of(square).sqrt()
    p = (arb_of(x), arb_of(v) / w)
    d = (arb_of(x_end - x), arb_of(v_end - v) / w)
    sine, cosine = ray
    # The cross product of the ray with an end is positive on its counterclockwise side.
    at_begin = cosine * p[1] - sine * p[0]
    at_end = cosine * (p[1] + d[1]) - sine * (p[0] + d[0])
    if _positive(at_begin) != _positive(at_end):
        # s with cross(ray, p + s d) = 0, which is linear in s.
        cuts = [at_begin / (at_begin - at_end)]
    else:
        cuts = []
    for n in (turns, turns + 1):
        if n:
            # |p + s d|^2 = (n loss)^2
            radius = arb_of(n * loss)
            cuts += _roots(_dot(d, d), 2 * _dot(p, d), _dot(p, p) - radius * radius)
    ends = [arb(0), *_sorted([cut for cut in cuts if _inside(cut)]), arb(1)]
    total = arb(0)
    for begin, end in pairwise(ends):
        a = _point(p, d, begin)
        middle = _point(p, d, (begin + end) / 2)
        b = _point(p, d, end)
        if _positive(cosine * middle[1] - sine * middle[0]):
            n = turns
        else:
            n = turns + 1
        radius = arb_of(n * loss)
        is_moving = not n or _positive(_dot(middle, middle) - radius * radius)
        if is_moving:
            total += _line_integral(a, b, radius)
    return total


def _point(p: tuple[arb, arb], d: tuple[arb, arb], s: arb) -> tuple[arb, arb]:
    """The point p + s d of a side, for s in [0, 1]."""
    return p[0] + s * d[0], p[1] + s * d[1]


def _line_integral(a: tuple[arb, arb], b: tuple[arb, arb], radius: arb) -> arb:
    """Half the integral of (R - c)^2 da along the straight line from a to b, c = radius.

    With D the signed distance of the line from the centre and s the distance along it from its
    nearest point, R^2 = D^2 + s^2 and da = D ds/R^2, so that

        integral of R^2 da = a x b,    integral of R da = D [asinh(s/|D|)],    integral of da = [a].
    """
    # D = (a x b)/|b - a|; s runs from a . (b - a)/|b - a| to b . (b - a)/|b - a|.
    cross = a[0] * b[1] - a[1] * b[0]
    along = (b[0] - a[0], b[1] - a[1])
    length = _dot(along, along).sqrt()
    distance = cross / length
    s_begin = _dot(a, along) / length
    s_end = _dot(b, along) / length
    of_r = distance * ((s_end / abs(distance)).asinh() - (s_begin / abs(distance)).asinh())
    of_angle = atan2(b[1], b[0]) - atan2(a[1], a[0])
    # (1/2) integral of (R^2 - 2 c R + c^2) da
    return (cross - 2 * radius * of_r + radius * radius * of_angle) / 2


def _dot(a: tuple[arb, arb], b: tuple[arb, arb]) -> arb:
    """The dot product of two vectors; a power of a ball that contains 0 would be nan."""
    return a[0] * b[0] + a[1] * b[1]


def _roots(square: arb, linear: arb, constant: arb) -> list[arb]:
    """The real roots of square s^2 + linear s + constant, square > 0; none or two."""
    discriminant = linear * linear - 4 * square * constant
    if _positive(discriminant):
        return [(sign * discriminant.sqrt() - linear) / (2 * square) for sign in (-1, 1)]
    return []


def _inside(cut: arb) -> bool:
    """True if the cut lies between the ends 0 and 1 of a side."""
    return _positive(cut) and _positive(1 - cut)


def _sorted(cuts: list[arb]) -> list[arb]:
    """The cuts in rising order of their midpoints."""
    return sorted(cuts, key=lambda cut: float(cut.mid()))


def _positive(value: arb) -> bool:
    """True if positive, False if negative; raises UndecidedError where the ball contains 0."""
    if not (value > 0 or value < 0):
        raise UndecidedError("on which side of a boundary a part of the head is")
    return bool(value > 0)


def truth(p: Parameters, corners: Sequence[Corner], scale: Mapping[str, float]) -> Truth:
    """The truth at parameters flow, mass, stiffness, delta, friction_force, length, gravity.

    `corners` are the exact (x, v) of the polygon at the start; `scale` has the sizes of x_k and v_k
    against which their errors count.
    """
    flow = str(p["flow"])
    form, _, _ = FORMS[flow]
    form_name = form.__module__.rpartition(".")[2].replace("_", " ")
    return PhaseFlow(
        flow=flow,
        corners=tuple(corners),
        motions=tuple(motions_of(p, corners, scale)),
        square=number(p, "stiffness") / number(p, "mass"),
        shift=number(p, "friction_force") / number(p, "stiffness"),
        delta=number(p, "delta"),
        method=f"corners: {form_name}; area: Liouville's theorem in closed form",
    )


def motions_of(
    p: Parameters, corners: Sequence[Corner], scale: Mapping[str, float]
) -> Iterator[Truth]:
    """The truth of each corner, by the closed form of the flow."""
    flow = str(p["flow"])
    form, place, rate = FORMS[flow]
    names = ("mass", "stiffness", "delta", "friction_force", "length")
    common = {name: p[name] for name in names}
    # The oscillators of this case move horizontally; gravity acts on the pendulum alone.
    if flow == "pendulum":
        common["gravity"] = p["gravity"]
    else:
        common["gravity"] = Fraction(0)
    for k, (x, v) in enumerate(corners):
        sizes = {place: scale[f"x_{k}"], rate: scale[f"v_{k}"]}
        if flow == "pendulum":
            sizes |= dict.fromkeys(("x", "y", "rod_force"), LARGEST)
        yield form({**common, f"{place}0": x, f"{rate}0": v}, sizes)
