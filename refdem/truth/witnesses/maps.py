"""Witnesses of maps: direct iteration at many digits, without any proof; the logistic equation by
Taylor integration.
"""

from collections.abc import Mapping, Sequence
from fractions import Fraction

from flint import arb

from refdem.core.parameters import Exact
from refdem.truth.balls import arb_of, precision
from refdem.truth.exact import number, vector
from refdem.truth.witnesses.cross_check import Claimed, Results, Witness
from refdem.truth.witnesses.taylor import Solution

METHOD = "iteration at many digits, unproven (refdem/truth/witnesses/maps.py)"
SCALE = 4096
"""Fractional bits of the fixed-point numbers; an iterate loses 2 of them, |eta (1 - 2 x)| <= 4."""


def logistic(p: Mapping[str, Exact], times: Sequence[Fraction], claimed: Claimed) -> Results:
    """The logistic map x -> eta x (1 - x) in fixed-point numbers of 2^-4096; the logistic equation
    x' = eta x (1 - x) by Taylor integration.
    """
    eta = number(p, "eta")
    x0 = number(p, "x0")
    if p["form"] == "ode":
        solution = Solution(lambda t, y: [y[0] * (1 - y[0]) * arb_of(eta)], [arb_of(x0)])
        for t in times:
            yield t, {"x_n": solution.at(t)[0]}
        return
    one = 1 << SCALE
    n = 0
    x = int(x0 * one)
    for t in times:
        for _ in range(int(t) - n):
            x = eta.numerator * (x * (one - x) >> SCALE) // eta.denominator
        n = int(t)
        yield t, {"x_n": arb_of(Fraction(x, one))}


def billiard(p: Mapping[str, Exact], times: Sequence[Fraction], claimed: Claimed) -> Results:
    """Position and direction after each bounce, from the nearest wall ahead of the particle."""
    names = ("position.x", "position.y", "direction.x", "direction.y")
    with precision(1024):
        a, b = (arb_of(x) for x in vector(p, "size"))
        is_stadium = p["geometry"] == "stadium"
        position = [arb_of(x) for x in vector(p, "start")]
        direction = [arb_of(x) for x in vector(p, "direction")]
        length = (direction[0] * direction[0] + direction[1] * direction[1]).sqrt()
        direction = [x / length for x in direction]
        # Half the length of the straight walls.
        if is_stadium:
            half_length = (a - b) / 2
        else:
            half_length = a / 2
        n = 0
        for t in times:
            for _ in range(int(t) - n):
                position, direction = bounced(position, direction, half_length, b / 2, is_stadium)
            n = int(t)
            yield t, dict(zip(names, [*position, *direction], strict=True))


def bounced(
    position: list[arb], direction: list[arb], half_length: arb, radius: arb, is_stadium: bool
) -> tuple[list[arb], list[arb]]:
    """The next position on the wall and the direction after it, midpoints alone.

    Straight walls lie at y = +-radius; a stadium has half circles of that radius about
    (+-half_length, 0), a rectangle walls at x = +-half_length. The direction u becomes u - 2 (u.n)
    n at the unit normal n.
    """
    x, y = position
    u, v = direction
    # Distance along the path and normal of every wall that it meets.
    hits: list[tuple[arb, arb, arb]] = []
    for side in (1, -1):
        if side * v > 0:
            distance = (side * radius - y) / v
            if abs(x + distance * u) <= half_length:
                hits.append((distance, arb(0), arb(side)))
        if not is_stadium and side * u > 0:
            hits.append(((side * half_length - x) / u, arb(side), arb(0)))
        if is_stadium:
            # The larger root of |d + s u|^2 = r^2, d being the position from the centre.
            dx = x - side * half_length
            dy = y
            d_u = dx * u + dy * v
            discriminant = d_u * d_u - dx * dx - dy * dy + radius * radius
            if discriminant > 0 and side * (dx + (discriminant.sqrt() - d_u) * u) > 0:
                distance = discriminant.sqrt() - d_u
                nx = (dx + distance * u) / radius
                ny = (dy + distance * v) / radius
                hits.append((distance, nx, ny))
    # Drop the wall on which the particle is, whose distance is 0 up to rounding.
    ahead = [hit for hit in hits if hit[0] > arb(2) ** -200]
    distance, nx, ny = min(ahead, key=lambda hit: float(hit[0]))
    # u -> u - 2 (u . n) n
    double_normal = 2 * (u * nx + v * ny)
    next_position = [(x + distance * u).mid(), (y + distance * v).mid()]
    next_direction = [(u - double_normal * nx).mid(), (v - double_normal * ny).mid()]
    return next_position, next_direction


WITNESSES = {"logistic": Witness(METHOD, logistic), "billiards": Witness(METHOD, billiard)}
