"""Rigid cluster: against a rigid body in axes that are not principal, for every kind of motion,
with planted errors.
"""

from fractions import Fraction

import pytest

from refdem.core.discovery import truth_of
from refdem.truth.balls import precision
from refdem.truth.closed_forms.rigid_cluster import AboutAxis
from refdem.truth.free_body import Elliptic, Separatrix, Steady

TETRAHEDRON = "1,1,1,1,-1,-1,-1,1,-1,-1,-1,1"
KINDS = [
    (Elliptic, {}),
    (
        Elliptic,
        {"masses": "1e-3,7,3,100", "positions": "3,1,4,1,5,9,2,6,5,3,5,8", "omega": "-3,1,4"},
    ),
    (AboutAxis, {"masses": "1,1,1,1", "positions": TETRAHEDRON}),
    (AboutAxis, {"masses": "1,1,1,2", "positions": TETRAHEDRON}),
    (AboutAxis, {"masses": "2,1,1,1", "positions": TETRAHEDRON, "omega": "1,1,1"}),
    (
        Steady,
        {"omega": "0,0,-1", "masses": "1,1,1,1", "positions": "1,0,0,-1,0,0,0,2,1/2,0,-2,1/2"},
    ),
    # J = diag(12, 6, 10): sum of J (J - 10) omega^2 is 0 where omega_x^2 = omega_y^2
    (
        Separatrix,
        {"omega": "1,1,1/2", "masses": "1,1,1,1", "positions": "1,0,1,-1,0,1,0,2,-1,0,-2,-1"},
    ),
]


@pytest.mark.parametrize(("kind", "given"), KINDS)
def test_places_meet_the_witness(apart, kind, given):
    truth = truth_of("rigid-cluster", **given)
    with precision(256):
        assert type(truth.body()) is kind
    assert apart("rigid-cluster", (Fraction(0), Fraction(2)), **given) == {}


PLANTED = {
    "a line of nodes that drifts by 1e-9 too fast": lambda t: vars(t.body()).update(
        drift=t.body().drift * (1 + 1e-9)
    ),
    "axes that are left-handed": lambda t: t.axes().__setitem__(2, [-x for x in t.axes()[2]]),
    "the centre of the points for that of the masses": lambda t: vars(t).update(
        centre=[c + Fraction(1, 10**20) for c in t.centre]
    ),
    "spin of the wrong sign": lambda t: vars(t.body()).update(shift=-t.body().shift),
}


@pytest.mark.parametrize("fault", PLANTED)
def test_the_witness_sees(apart, fault):
    truth = truth_of("rigid-cluster")
    with precision(256):
        PLANTED[fault](truth)
    assert apart("rigid-cluster", (Fraction(2),), truth)


def test_rods_keep_their_lengths_and_the_centre_stays():
    truth = truth_of("rigid-cluster")
    first = truth.at(Fraction(0))
    later = truth.at(Fraction(100))

    def length2(at, i, j):
        return sum((at[f"r{i}.{a}"].mid - at[f"r{j}.{a}"].mid) ** 2 for a in "xyz")

    for i in range(1, 5):
        for j in range(1, i):
            assert abs(length2(later, i, j) - length2(first, i, j)) < Fraction(1, 10**38)
    for a in "xyz":
        moved = sum(
            m * (later[f"r{i}.{a}"].mid - first[f"r{i}.{a}"].mid)
            for i, m in zip(range(1, 5), (1, 2, 1, 3), strict=True)
        )
        assert abs(moved) < Fraction(1, 10**38)


def test_an_error_grows_at_least_as_time():
    truth = truth_of("rigid-cluster")
    assert 10 < truth.sensitivity(Fraction(10)) < truth.sensitivity(Fraction(100)) < 10**4
