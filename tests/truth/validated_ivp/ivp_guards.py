"""Claims about the integrator `ivp` that only sound bounds meet: low orders, where remainders and
Jacobians carry everything, fat starts.

Each takes the modules of the package, so that it can be asked about a package with a planted bug.
"""

from fractions import Fraction
from itertools import product

import pytest
from flint import acb, arb, arb_poly, arb_series, ctx

from refdem.truth.balls import arb_of, precision
from tests.truth.validated_ivp.fields import decay, exact, harmonic, power, squares


def run(ivp, field, start, *, bits=200, ratio="1/6", order=None, jacobian_order=None):
    """An integration from exact numbers, or from balls."""

    def begin():
        if isinstance(start[0], arb):
            return start
        return exact(start)

    return ivp.integration.Integration(
        field, begin, bits, ivp.integration.Steps(Fraction(ratio), order, jacobian_order)
    )


def programs(ivp, rule, size):
    """The programs of a field and of its Jacobian."""
    outputs, rows = ivp.field.traced(rule, size)
    return ivp.field.Program(outputs), ivp.field.Program([entry for row in rows for entry in row])


def around(ivp, rule, start, *, radii=None, order=12, ratio=0.25):
    """A disc about the Taylor polynomial from an exact start."""
    field, slopes = programs(ivp, rule, len(start))
    with precision(200):
        polynomials = ivp.recurrences.taylor(field, exact(start), order)
    return ivp.enclosure.disc(
        field,
        slopes,
        polynomials,
        order,
        radii or [arb(0)] * len(start),
        least=[arb(0)] * len(start),
        ratio=ratio,
        first=1.0,
    )


def powers_are_held_by_the_remainder(ivp):
    """t^(n+1) by order n from 0, where the remainder is the whole motion."""
    for n, ratio in product(range(1, 9), ("1/2", "7/8")):
        found = run(ivp, power(n), [0, 0], order=n, ratio=ratio)
        end = found.piece(arb(0)).length
        assert all(
            found.at(arb_of(end * k / 8))[1].contains(arb_of((end * k / 8) ** (n + 1)))
            for k in range(1, 9)
        )


def low_orders_hold_simple_motions(ivp):
    """One piece and the set at its end, of low order near the edge of the disc, against 1/(1 - t),
    e^-t, cos t.
    """
    motions = [
        (squares, [1], lambda t: [1 / (1 - t)]),
        (decay, [1], lambda t: [(-t).exp()]),
        (harmonic, [1, 0], lambda t: [t.cos(), -t.sin()]),
    ]
    for (rule, start, solution), n, ratio in product(motions, range(1, 9), ("1/3", "7/8")):
        found = run(ivp, rule, start, order=n, ratio=ratio)
        found.advance()
        for k in range(1, 9):
            t = arb_of(found.pieces[0].end * k / 8)
            assert all(
                value.contains(true) for value, true in zip(found.at(t), solution(t), strict=True)
            )
        end = solution(arb_of(found.pieces[0].end))
        assert all(
            abs(c - y) <= r for c, y, r in zip(found.centre, end, found.spread.radii(), strict=True)
        )


def the_remainder_is_as_sharp_as_it_may_be(ivp):
    """By hand: of t^(n+1), whose defect is one power; of a geometric series; with its growth; in
    each coordinate's weight.
    """
    for n in range(1, 9):
        found = ivp.enclosure.Disc(
            n, [arb(1)], arb(2), arb(n + 1) * arb(2) ** n, Fraction(1), [(arb(2), arb(0))]
        )
        bound = found.apart(arb("0.01"), arb(0))
        assert arb("0.01") ** (n + 1) <= bound <= arb("0.01") ** (n + 1) * arb("1.01")
        assert ivp.enclosure.geometric(arb("0.5"), n) >= arb(2) ** (1 - n)
        # 1 + sum of (z/R)^k, k > n, at z = R/2, times exp(3)
        other = ivp.enclosure.Disc(n, [arb(1)], arb(2), arb(0), Fraction(1), [(arb(1), arb(3))])
        assert other.jacobian_remainder(arb("0.5"), n) >= arb(3).exp().lower() * arb(2) ** -n
    rings = [(arb(1), arb(2)), (arb(2), arb(3)), (arb(4), arb(5))]
    ringed = ivp.enclosure.Disc(3, [arb(1), arb(8)], arb(5), arb(0), Fraction(1), rings)
    for since, exponent in (("0.5", 1), ("1", 2), ("1.5", "3.5"), ("3", 10), ("4", 15)):
        assert abs(ringed.gronwall(arb(since)).log() - arb(exponent)) < 1e-12
        assert ringed.apart(arb(since), arb("0.25")) >= arb(exponent).exp().lower() / 4
    assert ringed.sides(arb("0.5"))[1] >= 4
    assert not ringed.apart(arb("4.5"), arb(0)).is_finite()


def discs_hold_their_solutions(ivp):
    """y' = y^2 from 1 and from fat sets about it: no pole inside, and every bound holds on the
    circle of the disc.
    """
    for wide, order, ratio in product(("0", "0.01", "0.1", "0.3"), (6, 12, 40), (0.1, 0.25, 0.6)):
        found = around(ivp, squares, [1], radii=[arb(wide)], order=order, ratio=ratio)
        if found is None:
            assert arb(wide) > 0 or ratio > 0.5
            continue
        y = 1 + arb(wide)
        assert found.radius * y < 1
        weight = found.weights[0]
        with precision(400):
            for r, stiffness in found.rings:
                assert stiffness >= (2 * y / (1 - r * y)).lower()
                polynomial = sum(r**n for n in range(order + 1))
                assert found.apart(r, arb(wide) / weight) * weight >= abs(
                    y / (1 - r * y) - polynomial
                )
            assert found.speed * weight >= sum(found.outer**n for n in range(order + 1)) ** 2
            assert found.gronwall(found.radius) >= (1 / (1 - found.radius * y) ** 2).lower()


def no_disc_is_larger_than_the_life_of_the_set(ivp):
    """y' = y^3 at rest in 0, with starts up to 1/10 about it that end in poles at t = 50: shorter
    and shorter steps are asked for.
    """
    for halvings in range(24):
        found = around(
            ivp, lambda y: [y[0] * y[0] * y[0]], [0], radii=[arb("0.1")], ratio=0.25 / 2**halvings
        )
        assert found is None or found.radius < 50
    assert found is not None


def weights_are_those_of_a_norm(ivp):
    """x'' = -10^8 x: the norm of J holds that of J u for u with |u_i| = w_i, and is near its
    frequency.
    """
    found = around(ivp, lambda y: [y[1], -(10**8) * y[0]], [1, 0])
    one, two = found.weights
    for _, stiffness in found.rings:
        assert stiffness >= (two / one).lower()
        assert stiffness >= (10**8 * one / two).lower()
    assert found.rings[0][1] < 2e4
    matrix = [arb(1), arb(-5), arb(2), arb("0.25")]
    assert ivp.enclosure.matrix_norm(matrix, [arb(1), arb(1)]) >= 6
    assert ivp.enclosure.matrix_norm(matrix, [arb(1), arb(2)]) >= 11
    assert ivp.enclosure.norm([acb(3, -4), acb(0)], [arb(1), arb(1)]) >= 5


def impossible_discs_are_refused(ivp):
    """A root across its cut, a divisor that vanishes, boxes of what is not finite, a real line
    instead of a disc.
    """
    cut, _ = programs(ivp, lambda y: [y[0].sqrt()], 1)
    assert not cut.run([acb(arb(-1), arb(0, 1))])[0].is_finite()
    assert not ivp.enclosure.norm([acb("nan")], [arb(1)]).is_finite()
    for rule, start in ((lambda y: [y[0].sqrt()], "1/100"), (lambda y: [1 / y[0]], "1/100")):
        found = around(ivp, rule, [start])
        assert found is not None
        assert found.radius < 1
    tube = ivp.enclosure.Tube([arb_poly([1, 2, -3, 4])])
    for k in range(8):
        z = acb(arb(k) / 4).exp_pi_i() / 2
        inside = 1 + 2 * z - 3 * z * z + 4 * z * z * z
        assert tube.box(arb("0.5"))[0].contains(inside)
        assert tube.box(arb("0.5"), [arb("0.1")])[0].contains(
            inside + acb(arb(k) / 4).exp_pi_i() / 10
        )


def derivatives_and_series_are_exact(ivp):
    """Coefficients of tan, exp and a root; the derivative of every operation against its
    formula.
    """
    with precision(128):
        motion, _ = programs(
            ivp, lambda y: [1, (y[0].sin() / y[0].cos()), y[0].exp() * y[0].sqrt()], 3
        )
        series = ivp.recurrences.taylor(motion, exact([1, 0, 0]), 6)
        h = arb("1e-6")
        assert abs(series[1](h) + ((1 + h).cos() / arb(1).cos()).log()) < arb("1e-34")
        expected = arb_series([1, 1], prec=6)
        assert all(
            series[2][k + 1].overlaps((expected.exp() * expected.sqrt()).coeffs()[k] / (k + 1))
            for k in range(6)
        )
        _, rows = ivp.field.traced(
            lambda y: [
                y[0] * y[1] - y[0] / y[1],
                y[0].sin() * y[1].cos(),
                y[0].sqrt() + (y[0] * y[1]).exp(),
            ],
            2,
        )
        found = ivp.field.Program([entry for row in rows for entry in row]).run(exact([2, 3]))
        two = arb(2)
        three = arb(3)
        true = [three - 1 / three, two + two / 9, two.cos() * three.cos(), -two.sin() * three.sin()]
        true += [1 / (2 * two.sqrt()) + 3 * arb(6).exp(), 2 * arb(6).exp()]
        assert all(a.overlaps(b) for a, b in zip(found, true, strict=True))


def long_series_are_those_of_closed_forms(ivp):
    """150 coefficients, most of them made block by block, of every operation, against the series of
    the closed forms.
    """
    rules = [
        lambda a: a * a,
        lambda a: a.exp(),
        lambda a: 1 / a,
        lambda a: a * a.sqrt(),
        lambda a: a.cos(),
    ]
    starts = [1, 0, 1, 1, 0]
    order = 150
    whole, _ = programs(
        ivp,
        lambda y: [*(rule(a) for rule, a in zip(rules, y, strict=False)), y[4].sin(), y[0] * y[6]],
        7,
    )
    with precision(200):
        found = ivp.recurrences.taylor(whole, exact([*starts, 0, 1]), order)
    before = ctx.cap
    with precision(400):
        ctx.cap = order + 1
        t = arb_series([0, 1], prec=order + 1)
        rise = t.exp()
        fall = (-t).exp()
        true = [1 / (1 - t), -(1 - t).log(), (1 + 2 * t).sqrt(), 1 / (1 - t / 2) / (1 - t / 2)]
        true += [
            (2 / (rise + fall)).integral(),
            ((rise - fall) / (rise + fall)).integral(),
            1 / (1 - t),
        ]
        coefficients = [[*one.coeffs(), *[arb(0)] * order][: order + 1] for one in true]
        ctx.cap = before
        for series, closed in zip(found, coefficients, strict=True):
            assert all(series[n].overlaps(closed[n]) for n in range(order + 1))
            assert all(series[n].rad() < arb(2) ** n * 1e-40 for n in range(order + 1))


def late_pieces_hold_many_digits(ivp):
    """x'' = -x, and x' = x/3 from a start that is no binary fraction, at times far from 0: errors
    of 1e-20 in a time show.
    """
    turned, grown = (
        run(ivp, harmonic, [1, 0], bits=200),
        run(ivp, lambda y: [y[0] / 3], ["1/3"], bits=200),
    )
    with precision(400):
        for k in range(1, 16):
            t = arb(k) * 7 / 3
            x, v = turned.at(t)
            assert x.rad() < 1e-50
            assert x.contains(t.cos())
            assert v.contains(-t.sin())
            assert grown.at(t)[0].contains((t / 3).exp() / 3)
            flow = turned.jacobian(t)
            assert flow[0, 1].rad() < 1e-9
            assert flow[0, 1].contains(t.sin())
        assert len(turned.pieces) > 8


def numbers_are_exact_or_refused(ivp):
    """0.1 is no constant of a field; centres and times are exact; the start keeps its rounding;
    balls of time are held.
    """
    with pytest.raises(TypeError, match="expected an int, a Fraction"):
        run(ivp, lambda y: [y[0] * 0.1], [1])
    found = run(ivp, lambda y: [y[0] / 3], ["1/3"], bits=100)
    with precision(400):
        assert found.at(arb(2))[0].contains((arb(2) / 3).exp() / 3)
        assert (
            run(ivp, lambda y: [0 * y[0]], ["1/3"], bits=60)
            .at(arb(2))[0]
            .contains(arb_of(Fraction(1, 3)))
        )
        wide = found.at(arb(1, "0.1"))[0]
        assert all(wide.contains((arb(t) / 3).exp() / 3) for t in ("0.9001", "1", "1.0999"))
        assert all(v.is_exact() for v in found.centre)
    assert [p.begin for p in found.pieces] == [
        sum((q.length for q in found.pieces[:i]), Fraction(0)) for i in range(len(found.pieces))
    ]
    assert found.begins == [p.begin for p in found.pieces]


def bounds_are_rounded_outward(ivp):
    """Bounds from balls hold the upper ends of these; coefficients of fat starts hold those of
    every start.
    """
    rings = [(arb(1), arb(2, "0.5"))]
    found = ivp.enclosure.Disc(3, [arb(1)], arb(4), arb(0), Fraction(1), rings)
    assert found.apart(arb(1), arb("0.25")) >= arb("2.499").exp().lower() / 4
    assert found.sides(arb(1, "0.5"))[0] >= 1.5


def radii_follow_the_start(ivp):
    """Coefficients n of y' = y^2 from a fat start hold y^(n+1) for every y of it."""
    field, _ = programs(ivp, squares, 1)
    series = ivp.recurrences.taylor(field, [arb(1, "0.01")], 40)[0]
    assert all(
        series[n].contains(arb(y) ** (n + 1)) for y in ("0.9901", "1.0099") for n in range(41)
    )


def constants_have_the_current_precision(ivp):
    """A program that was run at 64 bits knows 1/3 to 300 bits when it is run at 300."""
    field, _ = programs(ivp, lambda y: [y[0] / 3], 1)
    for bits in (64, 300):
        with precision(bits):
            third = field.run([arb(1)])[0]
            assert third.rad() < arb(2) ** (2 - bits)
            assert abs(3 * third - 1) < arb(2) ** (4 - bits)


GUARDS = [
    bounds_are_rounded_outward,
    radii_follow_the_start,
    constants_have_the_current_precision,
    powers_are_held_by_the_remainder,
    low_orders_hold_simple_motions,
    the_remainder_is_as_sharp_as_it_may_be,
    discs_hold_their_solutions,
    no_disc_is_larger_than_the_life_of_the_set,
    weights_are_those_of_a_norm,
    impossible_discs_are_refused,
    derivatives_and_series_are_exact,
    long_series_are_those_of_closed_forms,
    late_pieces_hold_many_digits,
    numbers_are_exact_or_refused,
]
