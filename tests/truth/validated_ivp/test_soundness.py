"""Where remainders and Jacobians carry everything: low orders near the edge of the disc, fat starts. Then bugs planted there."""

from fractions import Fraction
from itertools import product

import flint
import pytest
from fields import at, decay, exact, harmonic, integration, power, squares
from flint import acb, arb, arb_mat

from refdem.errors import NotCertifiedError
from refdem.truth.balls import UndecidedError, arb_of, precision
from refdem.truth.validated_ivp import enclosure, field, moved, recurrences
from refdem.truth.validated_ivp import integration as pieces
from refdem.truth.validated_ivp.field import Program, traced
from refdem.truth.validated_ivp.integration import Integration, Steps


def powers_are_held_by_a_sharp_remainder():
    """t^(n+1) by order n from 0, where the remainder is the whole motion."""
    for n, ratio in product(range(1, 9), ("1/2", "7/8")):
        run = integration(power(n), [0, 0], order=n, ratio=ratio)
        end = run.piece(arb(0)).length
        assert all(run.at(arb_of(end * k / 8))[1].contains(arb_of((end * k / 8) ** (n + 1))) for k in range(1, 9))


def low_orders_hold_simple_motions():
    """One and two pieces of low order near the edge of the disc, against 1/(1 - t), e^-t, cos t."""
    motions = [
        (squares, [1], lambda t: [1 / (1 - t)]),
        (decay, [1], lambda t: [(-t).exp()]),
        (harmonic, [1, 0], lambda t: [t.cos(), -t.sin()]),
    ]
    for (rule, start, solution), n, ratio in product(motions, range(1, 9), ("1/3", "3/4")):
        run = integration(rule, start, order=n, ratio=ratio)
        run.advance()
        for k in range(1, 9):
            t = arb_of(run.pieces[0].end * k / 8)
            assert all(value.contains(true) for value, true in zip(run.at(t), solution(t), strict=True))
        end = solution(arb_of(run.pieces[0].end))
        assert all(abs(c - y) <= r for c, y, r in zip(run.centre, end, run.spread.radii(), strict=True))


def cauchy_is_as_sharp_as_it_may_be():
    """The remainder of t^(n+1) is h^(n+1); that of 1/(1 - z/R), times R/(1 - ...), the geometric series itself."""
    for n in range(1, 9):
        found = enclosure.Disc([(arb(2), arb(0))], [arb(n + 1) * arb(2) ** n])
        bound = enclosure.remainder(found, arb("0.01"), n)[0]
        assert bound >= arb("0.01") ** (n + 1)
        assert bound <= arb("0.01") ** (n + 1) * arb("1.01")
        assert enclosure.geometric(arb("0.5"), n) >= arb(2) ** -n
        assert enclosure.jacobian_remainder(enclosure.Disc([(arb(1), arb(3))], []), arb("0.5"), n) >= arb(3).exp().lower() * arb(2) ** -n


def jacobians_of_low_order_hold_the_exact_ones():
    """V of x'' = -x is a rotation, that of y' = y^2 is 1/(1 - t y)^2 for every y of a fat start."""
    for n, ratio in product((1, 2, 5, 8), ("1/6", "7/8")):
        run = integration(harmonic, [1, 0], order=8, jacobian_order=n, ratio=ratio)
        t = arb_of(run.piece(arb(0)).length)
        assert run.jacobian(t)[0, 1].contains(t.sin())
        fat = Integration(squares, lambda: [arb(1, "0.01")], 200, Steps(Fraction(ratio), 8, n))
        t = arb_of(fat.piece(arb(0)).length)
        for y in ("0.991", "1", "1.009"):
            assert fat.jacobian(t)[0, 0].contains(1 / (1 - t * arb(y)) ** 2)
        found = fat.pieces[0].disc
        bound = enclosure.jacobian_remainder(found, t, n)
        assert bound >= enclosure.geometric(t / found.radius, n)


def fat_starts_keep_their_corners():
    """Corners of fat starts after pieces with Jacobians of order 1 to 4, at the ends of pieces and inside them."""
    for n in (1, 2, 4, None):
        run = Integration(harmonic, lambda: [arb(1, "0.01"), arb(0, "0.01")], 64, Steps(Fraction(1, 6), None, n))
        for t in (arb("0.3"), arb(1), arb(2)):
            for x, v in product((arb("0.9901"), arb("1.0099")), (arb("-0.0099"), arb("0.0099"))):
                assert run.at(t)[0].contains(x * t.cos() + v * t.sin())
                assert run.at(t)[1].contains(v * t.cos() - x * t.sin())
    for n, t in product((2, 4, None), ("0.05", "0.2", "0.3")):
        fat = Integration(squares, lambda: [arb(1, "0.01")], 64, Steps(Fraction(1, 6), None, n))
        for y in (arb("0.9901"), arb("1.0099")):
            assert fat.at(arb(t))[0].contains(1 / (1 / y - arb(t)))


def sets_at_the_end_of_a_piece_hold_their_corners():
    """The set of y' = y^2 after one sharp piece: its edges come from the Jacobian of the whole set alone."""
    fat = Integration(squares, lambda: [arb(1, "0.01")], 64)
    fat.advance()
    t, radius = arb_of(fat.pieces[0].end), fat.spread.radii()[0]
    assert all(abs(fat.centre[0] - 1 / (1 / arb(y) - t)) <= radius for y in ("0.990001", "1", "1.009999"))
    assert moved.outward(arb(1, "0.5")) >= arb("1.5")
    assert moved.outward(arb(-1, "0.5")) >= arb("1.5")


def sets_moved_by_hand_hold_their_corners():
    """Random regular maps of a fat set, without any field: e' = V e + u, and the Jacobians multiply."""
    for seed in range(4):
        maps = [arb_mat([[1, seed + k], [k - 2, 2]]) for k in range(4)]
        spread, corners, whole = moved.at_start([arb(1), arb("1e-3")]), list(product((-1, 1), ("-1e-3", "1e-3"))), moved.identity(2)
        points = [arb_mat([[arb(x)], [arb(y)]]).mid() for x, y in corners]
        for matrix in maps:
            # matrix moves the set while the Jacobian is known to a part in 100 only
            spread = moved.moved(spread, matrix + arb_mat(2, 2, [arb(0, "0.01")] * 4), [arb("0.5"), arb("0.25")])
            actual = matrix + arb_mat([[0, "0.0099"], ["-0.0099", 0]])
            points = [actual.mid() * point + arb_mat([["0.499"], ["-0.249"]]) for point in points]
            whole = actual.mid() * whole
        radii = spread.radii()
        assert all(abs(point[i, 0]) <= radii[i] for point in points for i in range(2))
        assert all(spread.jacobian()[i, j].contains(whole[i, j]) for i, j in product(range(2), range(2)))
        inside = spread.frame.solve(points[0])
        assert all(abs(inside[i, 0]) <= spread.lengths[i] for i in range(2))


def boxes_hold_the_solution_on_the_disc():
    """Picard's image of y' = y^2 holds 1/(1 - z) on the whole circle, and its speeds and stiffness are bounds."""
    program, slopes = programs(squares, 1)
    found = enclosure.disc(program, slopes, [arb(1)], arb(1) / 16)
    assert found is not None
    radius = found.radius
    assert found.speed[0] >= 1 / (1 - radius) ** 2
    for outer, stiffness in found.rings:
        assert stiffness >= 2 / (1 - outer)
    assert enclosure.gronwall(found, radius) >= (1 / (1 - radius) ** 2).lower()
    inner = [acb(1)]
    for k in range(1, 5):
        image = enclosure.ring(program, inner, arb(1) / 16)
        assert image is not None
        for angle in range(8):
            z = arb(k) / 16 * acb(arb(angle) / 4).exp_pi_i()
            assert image[0].contains(1 / (1 - z))
        inner = image


def impossible_boxes_are_refused():
    """A disc around a pole, a root across its cut, an image that is not inside."""
    program, slopes = programs(squares, 1)
    assert enclosure.ring(program, [acb(1)], arb(2)) is None
    cut, _ = programs(lambda y: [y[0].sqrt()], 1)
    assert enclosure.ring(cut, [acb(arb("0.01"))], arb(1)) is None
    assert not cut.run([acb(arb(-1), arb(0, 1))])[0].is_finite()
    wide, narrow = acb(arb(0, 2), arb(0, 2)), acb(arb(0, 1), arb(0, 3))
    assert not enclosure.is_inside([wide, narrow], [acb(arb(0, 3), arb(0, 3)), wide])
    assert enclosure.disc(program, slopes, [arb(1)], arb(4)) is None


def derivatives_and_series_are_exact():
    """Coefficients of 1/(1 - t), e^-t, tan and a root; the derivative of every operation against its formula."""
    with precision(128):
        motion, _ = programs(lambda y: [1, (y[0].sin() / y[0].cos()), y[0].exp() * y[0].sqrt()], 3)
        series = recurrences.taylor(motion, exact([1, 0, 0]), 6)
        for h in (arb("1e-6"),):
            assert abs(series[1](h) + ((1 + h).cos() / arb(1).cos()).log()) < arb("1e-34")
        expected = flint.arb_series([1, 1], prec=6)
        assert all(series[2][k + 1].overlaps((expected.exp() * expected.sqrt()).coeffs()[k] / (k + 1)) for k in range(6))
        _, rows = traced(lambda y: [y[0] * y[1] - y[0] / y[1], y[0].sin() * y[1].cos(), y[0].sqrt() + (y[0] * y[1]).exp()], 2)
        found = Program([entry for row in rows for entry in row]).run(exact([2, 3]))
        two, three = arb(2), arb(3)
        true = [three - 1 / three, two + two / 9, two.cos() * three.cos(), -two.sin() * three.sin()]
        true += [1 / (2 * two.sqrt()) + 3 * arb(6).exp(), 2 * arb(6).exp()]
        assert all(a.overlaps(b) for a, b in zip(found, true, strict=True))


def numbers_are_exact_or_refused():
    """0.1 is no constant of a field; centres are exact; times are exact; the start keeps its rounding."""
    with pytest.raises(TypeError, match="expected an int or a Fraction"):
        integration(lambda y: [y[0] * 0.1], [1])
    run = integration(lambda y: [y[0] / 3], ["1/3"], bits=100)
    run.at(arb(1))
    with precision(400):
        assert run.at(arb(1))[0].contains((arb(1) / 3).exp() / 3)
        assert integration(lambda y: [0 * y[0]], ["1/3"], bits=60).at(arb(2))[0].contains(arb_of(Fraction(1, 3)))
        assert all(v.is_exact() for v in run.centre)
    assert [p.begin for p in run.pieces] == [sum((q.length for q in run.pieces[:i]), Fraction(0)) for i in range(len(run.pieces))]
    assert all(pieces.dyadic(arb(x)) <= Fraction(x) for x in ("0.7", "1.999", "130.75"))


def programs(rule, size):
    """The programs of a field and of its Jacobian."""
    outputs, rows = traced(rule, size)
    return Program(outputs), Program([entry for row in rows for entry in row])


GUARDS = [
    powers_are_held_by_a_sharp_remainder,
    cauchy_is_as_sharp_as_it_may_be,
    low_orders_hold_simple_motions,
    jacobians_of_low_order_hold_the_exact_ones,
    fat_starts_keep_their_corners,
    sets_at_the_end_of_a_piece_hold_their_corners,
    sets_moved_by_hand_hold_their_corners,
    boxes_hold_the_solution_on_the_disc,
    impossible_boxes_are_refused,
    derivatives_and_series_are_exact,
    numbers_are_exact_or_refused,
]


@pytest.mark.parametrize("guard", GUARDS)
def test_the_integrator_as_it_is_raises_no_alarm(guard):
    guard()


def test_the_state_of_a_low_order_is_a_ball_that_is_not_empty():
    assert at(decay, [1], "1/4", order=1)[0].rad() > 1e-4


def test_a_motion_into_a_pole_is_certified_to_just_before_it():
    with pytest.raises(NotCertifiedError, match=r"enclosed up to t = 0\.99"):
        at(squares, [1], 2, bits=200)


def test_a_set_that_reaches_a_pole_is_undecided_at_this_precision():
    with pytest.raises(UndecidedError, match="too large"):
        Integration(squares, lambda: [arb(1, "0.01")], 64).at(arb(2))


def every_guard():
    """All of them, one after another."""
    for guard in GUARDS:
        guard()


# a bug: where, what stands there instead
BUGS = {
    "remainder dropped": (pieces, "remainder", lambda found, step, order: [arb(0)] * len(found.speed)),
    "remainder shrunk to an eighth": (pieces, "remainder", lambda f, h, n: [r / 8 for r in REMAINDER(f, h, n)]),
    "remainder halved": (enclosure, "geometric", lambda ratio, order: ratio ** (order + 1) / (1 - ratio) / 2),
    "remainder one order too high": (pieces, "remainder", lambda f, h, n: REMAINDER(f, h, n + 1)),
    "tail starts one order late": (enclosure, "geometric", lambda ratio, order: ratio ** (order + 2) / (1 - ratio)),
    "remainder of the first term only": (enclosure, "geometric", lambda ratio, order: ratio ** (order + 1)),
    "remainder at half the step": (pieces, "remainder", lambda f, h, n: REMAINDER(f, h / 2, n)),
    "speed at the start instead of on the disc": (enclosure, "speeds", lambda rule, box: SPEEDS(rule, [side.mid() for side in box])),
    "speed half as large": (enclosure, "speeds", lambda rule, box: [m / 2 for m in SPEEDS(rule, box)]),
    "stiffness at a point": (enclosure, "norm", lambda slopes, box: NORM(slopes, [side.mid() for side in box])),
    "jacobian without remainder": (moved, "jacobian_remainder", lambda found, step, order: arb(0)),
    "jacobian remainder without its growth": (moved, "jacobian_remainder", lambda f, h, n: enclosure.geometric(h / f.radius, n)),
    "growth of a set forgotten between steps": (pieces, "gronwall", lambda found, since: arb(0)),
    "flow jacobian at a point": (pieces, "flow_jacobian", lambda f, s, box, *rest: JACOBIAN(f, s, [x.mid() for x in box], *rest)),
    "flow jacobian is the identity": (pieces, "flow_jacobian", lambda f, s, box, *rest: moved.identity(len(box))),
    "jacobian series one order short": (moved, "jacobian_series", lambda s, y, n: [*SERIES(s, y, n)[1:], SERIES(s, y, n)[0]]),
    "radius rounded inward": (moved, "outward", lambda value: arb(value.abs_lower())),
    "radius of the midpoint": (moved, "outward", lambda value: arb(value.mid())),
    "local error forgotten": (pieces, "moved", lambda spread, v, local: MOVED(spread, v, [arb(0)] * len(local))),
    "set not moved (stale step)": (pieces, "moved", lambda spread, v, local: spread),
    "set moved by the midpoint of its jacobian": (pieces, "moved", lambda spread, v, local: MOVED(spread, v.mid(), local)),
    "start taken as exact": (pieces, "at_start", lambda radii: START([arb(0)] * len(radii))),
    "lengths taken as signed": (moved, "products", lambda m, r: [abs(x) for x in (m * arb_mat([[y] for y in r])).entries()]),
    "hull is the centre": (pieces, "hull", lambda centre, radii: list(centre)),
    "any image is inside": (enclosure, "is_inside", lambda image, box: True),
    "one side inside suffices": (enclosure, "is_inside", lambda image, box: any(a.contains(b) for a, b in zip(box, image, strict=True))),
    "disc of time is a segment": (enclosure, "square", lambda half: acb(arb(0, half.abs_upper()))),
    "square of half the size": (enclosure, "square", lambda half: acb(arb(0, half / 2), arb(0, half / 2))),
    "root across its cut": (field.ELEMENTARY, "sqrt", lambda value: value.sqrt()),
    "sine for cosine in series": (recurrences, "_slopes", lambda a, n: [arb(0), *a[:n]]),
    "convolution without its last term": (recurrences, "convolution", lambda a, b, n, i, j: CONVOLUTION(a, b, n, i, max(i, j - 1))),
    "quotient rule with the wrong sign": (field.SLOPES, "/", lambda node, a, da, b, db: (da + node * db) / b),
    "constants rounded to doubles": (recurrences, "arb_of", lambda value: arb(float(value))),
    "times rounded": (pieces, "arb_of", lambda value: arb(float(value)) + arb(2) ** -30),
    "length rounded up": (pieces, "dyadic", lambda value: DYADIC(value) + Fraction(1, 2)),
}
REMAINDER, SPEEDS, NORM, JACOBIAN = enclosure.remainder, enclosure.speeds, enclosure.norm, moved.flow_jacobian
SERIES, MOVED, START, CONVOLUTION, DYADIC = moved.jacobian_series, moved.moved, moved.at_start, recurrences.convolution, pieces.dyadic


@pytest.mark.parametrize("bug", BUGS)
def test_a_planted_bug_is_caught(bug, monkeypatch):
    """By a wrong bound, or by times that fall out of their piece."""
    place, name, wrong = BUGS[bug]
    if isinstance(place, dict):
        monkeypatch.setitem(place, name, wrong)
    else:
        monkeypatch.setattr(place, name, wrong)
    with pytest.raises((AssertionError, UndecidedError)):
        every_guard()
