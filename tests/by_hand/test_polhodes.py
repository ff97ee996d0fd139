"""The path of omega on the ellipsoid of inertia, on certified motions: bounds of T and L, and the
axis about which it closes.
"""

from fractions import Fraction

import pytest

from refdem.core import discovery

INERTIA = (1, 2, 3)


def twice_energy_and_squared_momentum(omega: list[Fraction]) -> tuple[Fraction, Fraction]:
    """2 T = sum J omega^2 and L^2 = sum J^2 omega^2."""
    energy = sum((j * w * w for j, w in zip(INERTIA, omega, strict=True)), Fraction(0))
    momentum = sum(((j * w) ** 2 for j, w in zip(INERTIA, omega, strict=True)), Fraction(0))
    return energy, momentum


@pytest.mark.parametrize(
    ("omega_body", "axis"), [("5/4,1/2,1/4", 0), ("1/4,1/2,5/4", 2), ("9/10,11/10,13/10", 2)]
)
def test_the_path_closes_about_the_axis_that_the_separatrix_tells(
    omega_body: str, axis: int
) -> None:
    """The first or third component keeps its sign in all of the motion; the others change theirs,
    as omega_2 does on every path but the separatrix.
    """
    instance = discovery.case("free-rigid-body").at(omega_body=omega_body, duration="24")
    truth = instance.truth()
    start = [Fraction(part) for part in omega_body.split(",")]
    energy, momentum = twice_energy_and_squared_momentum(start)
    if energy * INERTIA[1] > momentum:
        assert axis == 0
    else:
        assert axis == 2
    signs: list[set[bool]] = [set(), set(), set()]
    for eighth in range(8 * 24):
        balls = truth.at(Fraction(eighth, 8))
        omega = [balls[f"omega_body.{name}"] for name in "xyz"]
        for number, ball in enumerate(omega):
            assert abs(ball.mid) > ball.radius
            signs[number].add(ball.mid > 0)
        twice, squared = twice_energy_and_squared_momentum([ball.mid for ball in omega])
        # Both are kept, to what the balls leave open.
        assert abs(twice - energy) < Fraction(1, 10**20)
        assert abs(squared - momentum) < Fraction(1, 10**20)
        assert squared / INERTIA[2] <= twice <= squared / INERTIA[0]
    assert [number for number in range(3) if len(signs[number]) == 1] == [axis]
