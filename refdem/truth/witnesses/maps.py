"""Witnesses of maps: iterated as they are written, at many digits and without any proof; the
logistic equation by Taylor integration.
"""

from collections.abc import Mapping, Sequence
from fractions import Fraction

from flint import arb

from refdem.core.parameters import Exact
from refdem.truth.balls import arb_of, precision
from refdem.truth.exact import number, vector
from refdem.truth.witnesses.taylor import Solution
from refdem.truth.witnesses.testimony import Claimed, Said, Witness

METHOD = "iteration at many digits, unproven (refdem/truth/witnesses/maps.py)"
SCALE = 4096
"""Bits after the point of whole-number arithmetic: two are lost by an iterate."""


def logistic(p: Mapping[str, Exact], times: Sequence[Fraction], claimed: Claimed) -> Said:
    """x -> eta x (1 - x) in whole numbers of 2^-4096; the equation of the same right-hand side by
    Taylor integration.
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


def billiard(p: Mapping[str, Exact], times: Sequence[Fraction], claimed: Claimed) -> Said:
    """Place and direction after each bounce, by the nearest wall in front: straight walls by their
    line, half circles by their chord.
    """
    with precision(1024):
        (a, b) = (arb_of(x) for x in vector(p, "size"))
        stadium = p["geometry"] == "stadium"
        place = [arb_of(x) for x in vector(p, "start")]
        along = [arb_of(x) for x in vector(p, "direction")]
        size = (along[0] * along[0] + along[1] * along[1]).sqrt()
        along = [x / size for x in along]
        if stadium:
            straight = (a - b) / 2
        else:
            straight = a / 2
        n = 0
        for t in times:
            for _ in range(int(t) - n):
                place, along = bounced(place, along, straight, b / 2, stadium)
            n = int(t)
            yield (
                t,
                dict(
                    zip(
                        ("position.x", "position.y", "direction.x", "direction.y"),
                        [*place, *along],
                        strict=True,
                    )
                ),
            )


def bounced(
    place: list[arb], along: list[arb], straight: arb, half: arb, stadium: bool
) -> tuple[list[arb], list[arb]]:
    """The next place on the wall and the direction after it, midpoints alone."""
    (x, y) = place
    (u, v) = along
    hits: list[tuple[arb, arb, arb]] = []
    for side in (1, -1):
        if side * v > 0:
            way = (side * half - y) / v
            hits += [(way, arb(0), arb(side))] if abs(x + way * u) <= straight else []
        if not stadium and side * u > 0:
            hits.append(((side * straight - x) / u, arb(side), arb(0)))
        if stadium:
            dx = x - side * straight
            dy = y
            middle = dx * u + dy * v
            under = middle * middle - dx * dx - dy * dy + half * half
            if under > 0 and side * (dx + (under.sqrt() - middle) * u) > 0:
                way = under.sqrt() - middle
                hits.append((way, (dx + way * u) / half, (dy + way * v) / half))
    way, nx, ny = min(
        (hit for hit in hits if hit[0] > arb(2) ** -200), key=lambda hit: float(hit[0])
    )
    turn = 2 * (u * nx + v * ny)
    return [(x + way * u).mid(), (y + way * v).mid()], [
        (u - turn * nx).mid(),
        (v - turn * ny).mid(),
    ]


WITNESSES = {"logistic": Witness(METHOD, logistic), "billiards": Witness(METHOD, billiard)}
