"""Claims about sets and flow Jacobians of the integrator `ivp`: fat starts with Jacobians of low
order, maps by hand.
"""

from fractions import Fraction
from itertools import product

from flint import arb, arb_mat

from refdem.truth.balls import arb_of, unit_matrix
from tests.truth.validated_ivp.fields import harmonic, squares
from tests.truth.validated_ivp.ivp_guards import programs, run


def jacobians_of_low_order_hold_the_exact_ones(ivp):
    """V of x'' = -x is a rotation, that of y' = y^2 is 1/(1 - t y)^2 for every y of a fat start."""
    for n, ratio in product((1, 2, 5, 8), ("1/6", "7/8")):
        found = run(ivp, harmonic, [1, 0], order=8, jacobian_order=n, ratio=ratio)
        t = arb_of(found.piece(arb(0)).length)
        assert found.jacobian(t)[0, 1].contains(t.sin())
        assert found.jacobian(t)[1, 1].contains(t.cos())
        fat = run(ivp, squares, [arb(1, "0.01")], order=8, jacobian_order=n, ratio=ratio)
        t = arb_of(fat.piece(arb(0)).length)
        for y in ("0.991", "1", "1.009"):
            assert fat.jacobian(t)[0, 0].contains(1 / (1 - t * arb(y)) ** 2)
    for n in (1, 2, 3):
        found = run(ivp, squares, [1], order=n, jacobian_order=30)
        t = arb_of(found.piece(arb(0)).length)
        assert found.jacobian(t)[0, 0].contains(1 / (1 - t) ** 2)
    stiff = run(ivp, lambda y: [y[1], -(10**8) * y[0]], [1, 0], order=8, jacobian_order=2)
    t = arb_of(stiff.piece(arb(0)).length)
    assert stiff.jacobian(t)[1, 0].contains(-(10**4) * (10**4 * t).sin())
    assert stiff.jacobian(t)[0, 1].contains((10**4 * t).sin() / 10**4)


def jacobian_series_hold_every_start(ivp):
    """Coefficients (n+1) y^n of V for y' = y^2, for all y of a set; of the last of them as of the
    first.
    """
    field, slopes = programs(ivp, squares, 1)
    found = ivp.enclosure.Disc(12, [arb(2)], arb(1), arb(1), Fraction(1), [(arb("0.9"), arb(6))])
    terms = ivp.moved.flow_series(
        slopes, ivp.recurrences.taylor(field, [arb(1)], 12), found, arb("0.01") / 2, 6
    )
    assert len(terms) == 7
    assert all(
        term[0, 0].contains((n + 1) * arb(y) ** n)
        for n, term in enumerate(terms)
        for y in ("0.9901", "1", "1.0099")
    )


def fat_starts_keep_their_corners(ivp):
    """Corners of fat starts after pieces with Jacobians of order 1 to 4, at the ends of pieces and
    inside them.
    """
    for n, t in product((1, 2, 4, None), ("0.3", "1", "2")):
        found = run(ivp, harmonic, [arb(1, "0.01"), arb(0, "0.01")], bits=64, jacobian_order=n)
        t = arb(t)
        for x, v in product((arb("0.9901"), arb("1.0099")), (arb("-0.0099"), arb("0.0099"))):
            assert found.at(t)[0].contains(x * t.cos() + v * t.sin())
            assert found.at(t)[1].contains(v * t.cos() - x * t.sin())
    for n, t in product((2, 4, None), ("0.05", "0.2", "0.3")):
        fat = run(ivp, squares, [arb(1, "0.01")], bits=64, jacobian_order=n)
        for y in (arb("0.9901"), arb("1.0099")):
            assert fat.at(arb(t))[0].contains(1 / (1 / y - arb(t)))


def sets_at_the_end_of_a_piece_hold_their_corners(ivp):
    """The set of y' = y^2 after one sharp piece: its edges come from the Jacobian of the whole set
    alone.
    """
    fat = run(ivp, squares, [arb(1, "0.01")], bits=64)
    fat.advance()
    t = arb_of(fat.pieces[0].end)
    radius = fat.spread.radii()[0]
    assert all(
        abs(fat.centre[0] - 1 / (1 / arb(y) - t)) <= radius for y in ("0.990001", "1", "1.009999")
    )
    assert ivp.moved.products(arb_mat([[1, -1]]), [arb(1), arb(2)])[0] >= 3
    assert ivp.moved.at_start([arb("0.5", "0.25")]).radii()[0] >= arb("0.75")


def sets_moved_by_hand_hold_their_corners(ivp):
    """Random regular maps of a fat set, without any field: e' = V e + u, and the Jacobians
    multiply.
    """
    for seed in range(4):
        maps = [arb_mat([[1, seed + k], [k - 2, 2]]) for k in range(4)]
        spread = ivp.moved.at_start([arb(1), arb("1e-3")])
        corners = product((-1, 1), ("-1e-3", "1e-3"))
        whole = unit_matrix(2)
        points = [arb_mat([[arb(x)], [arb(y)]]).mid() for x, y in corners]
        for matrix in maps:
            # matrix moves the set while the Jacobian is known to a part in 100 only
            spread = ivp.moved.moved(
                spread, matrix + arb_mat(2, 2, [arb(0, "0.01")] * 4), [arb("0.5"), arb("0.25")]
            )
            actual = matrix + arb_mat([[0, "0.0099"], ["-0.0099", 0]])
            points = [actual.mid() * point + arb_mat([["0.499"], ["-0.249"]]) for point in points]
            whole = actual.mid() * whole
        radii = spread.radii()
        assert all(abs(point[i, 0]) <= radii[i] for point in points for i in range(2))
        assert all(
            spread.jacobian()[i, j].contains(whole[i, j]) for i, j in product(range(2), range(2))
        )
        inside = spread.frame.solve(points[0])
        assert all(abs(inside[i, 0]) <= spread.lengths[i] for i in range(2))
    turned = ivp.moved.moved(
        ivp.moved.at_start([arb(0)] * 2), arb_mat([[1, -1], [1, 1]]), [arb(1)] * 2
    )
    for corner in ([[1], [1]], [[1], [-1]]):
        inside = turned.frame.solve(arb_mat(corner))
        assert all(abs(inside[i, 0]) <= turned.lengths[i] + 1e-12 for i in range(2))
    wide = ivp.moved.moved(ivp.moved.at_start([arb(1)]), arb_mat([[arb(1, "0.1")]]), [arb(0)])
    assert wide.radii()[0] >= 1.0999


SET_GUARDS = [
    jacobians_of_low_order_hold_the_exact_ones,
    jacobian_series_hold_every_start,
    fat_starts_keep_their_corners,
    sets_at_the_end_of_a_piece_hold_their_corners,
    sets_moved_by_hand_hold_their_corners,
]
