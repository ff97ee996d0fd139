"""Where the solution exists on a complex disc, how fast it moves there, and the Taylor remainders that follow (Cauchy)."""

from collections.abc import Sequence
from dataclasses import dataclass

from flint import acb, arb

from refdem.truth.balls import precision
from refdem.truth.validated_ivp.field import Program, largest, sum_of

BITS = 64
"""Of boxes: they bound, they need not be sharp."""
TURNS = 12
"""Of the Picard iteration on one ring, before the disc ends or a narrower ring is tried."""
REACH = 5
"""A disc ends where the bound exp(integral of L) of the flow Jacobian would pass exp(5)."""
MOST = 60
"""Rings: what hardly moves is not followed for ever."""
WIDTH = 0.15
"""L times the width of a ring: wider ones need too much room to be proved, narrower ones cost more evaluations."""
Box = list[acb]


@dataclass(frozen=True)
class Disc:
    """For every start in a box and |z| <= radius: y(z) exists, is analytic, and |y_i'(z)| <= speed_i.

    `rings` has outer radii and, for each, a bound L of |J(y(z))| up to there, in the norm of the largest row sum of absolute values.
    """

    rings: list[tuple[arb, arb]]
    speed: list[arb]

    @property
    def radius(self) -> arb:
        """R, exact."""
        return self.rings[-1][0]


def disc(field: Program, jacobian: Program, start: Sequence[arb], first: arb) -> Disc | None:
    """A disc as large as REACH and Picard's theorem allow, ring by ring; None if not even a ring of width `first` is proved.

    Theorem (Picard, along rays): let y(z) lie in the box C for all |z| <= R, and let B be a box with C + z f(B) inside B for all
    |z| <= D, f analytic on B. Then y exists and is analytic for |z| <= R + D and lies in C + D f(B): along each ray the mean of f(y)
    lies in the convex f(B), so y <- y(R) + integral of f(y) maps the continuous functions into B into themselves, and contracts.
    """
    with precision(BITS):
        inner: Box = [acb(value) for value in start]
        rings: list[tuple[arb, arb]] = []
        speed: list[arb] = []
        radius, exponent, width = arb(0), arb(0), first
        while exponent < REACH and len(rings) < MOST:
            box = ring(field, inner, width)
            if box is None:
                break
            stiffness, radius = norm(jacobian, box), radius + width
            exponent += stiffness * width
            if not (exponent < 2 * REACH and radius.is_exact()):
                break
            inner, speed = box, speeds(field, box)
            rings.append((radius, stiffness))
            width = width_of(stiffness, radius)
        return Disc(rings, speed) if rings else None


def width_of(stiffness: arb, most: arb) -> arb:
    """Of a ring where |J| is about `stiffness`: an exact number of few bits, at most `most`."""
    width = (arb(WIDTH) / (stiffness + arb(WIDTH) / most)).lower()
    mantissa, exponent = width.man_exp()
    surplus = max(0, int(mantissa).bit_length() - 8)
    return arb(int(mantissa) >> surplus) * arb(2) ** (int(exponent) + surplus)


def ring(field: Program, inner: Box, width: arb) -> Box | None:
    """A box that holds the solution up to `width` further out than `inner` does; None if none is proved."""
    box = inner
    for _ in range(TURNS):
        image = picard(field, inner, box, width)
        if not all(side.is_finite() for side in image):
            return None
        if is_inside(image, box):
            return image
        box = [wider(side, old) for side, old in zip(image, inner, strict=True)]
    return None


def picard(field: Program, start: Box, box: Box, radius: arb) -> Box:
    """start + z f(box) for all |z| <= radius: a square about the start, as wide as the largest |z f|."""
    return [value + square(radius * largest([rate])) for value, rate in zip(start, field.run(box), strict=True)]


def square(half: arb) -> acb:
    """All complex numbers whose real and imaginary parts are at most that in size."""
    side = arb(0, half.abs_upper())
    return acb(side, side)


def is_inside(image: Box, box: Box) -> bool:
    """Every side of the image lies in that of the box."""
    return all(side.contains(new) for side, new in zip(box, image, strict=True))


def wider(side: acb, start: acb) -> acb:
    """A side with a twentieth more room about the start."""
    return side + (side - start) / 20 + square(arb(2) ** (8 - BITS) * (1 + largest([start])))


def speeds(field: Program, box: Box) -> list[arb]:
    """Bounds of |f_i| over the box."""
    return [largest([rate]) for rate in field.run(box)]


def norm(jacobian: Program, box: Box) -> arb:
    """Bound over the box of the largest row sum of |J_ij|; `jacobian` has the rows one after another."""
    sizes = [largest([entry]) for entry in jacobian.run(box)]
    return largest([sum_of(sizes[i : i + len(box)]) for i in range(0, len(sizes), len(box))])


def geometric(ratio: arb, order: int) -> arb:
    """sum over n > order of ratio^n, for 0 <= ratio < 1."""
    return ratio ** (order + 1) / (1 - ratio)


def remainder(found: Disc, step: arb, order: int) -> list[arb]:
    """Bounds of |y_i(h) - sum_(n <= order) c_n h^n| for |h| = step < radius, for every start in the box of the disc.

    Theorem (Cauchy): |y'| <= M on |z| <= R gives n |c_n| <= M R^(1-n); the tail is at most R M (h/R)^(N+1) / (1 - h/R) / (N+1).
    """
    tail = geometric(step / found.radius, order) / (order + 1)
    return [arb((found.radius * speed * tail).abs_upper()) for speed in found.speed]


def jacobian_remainder(found: Disc, step: arb, order: int) -> arb:
    """Bound of every entry of V(h) - sum_(n <= order) V_n h^n, V the flow Jacobian.

    Theorem: V' = J(y) V, V(0) = 1 gives |V(z)| <= exp(integral of L) on the disc (Gronwall along the ray), so Cauchy gives
    |V_n| <= exp(integral of L up to R) R^-n.
    """
    return arb((gronwall(found, found.radius) * geometric(step / found.radius, order)).abs_upper())


def gronwall(found: Disc, since: arb) -> arb:
    """Bound of the growth in `since` <= radius of a distance between two solutions that start in the box: exp(integral of L)."""
    exponent, inner = arb(0), arb(0)
    for radius, stiffness in found.rings:
        if inner < since:
            exponent += stiffness * (min(radius, since) - inner)
        inner = radius
    return exponent.exp()
