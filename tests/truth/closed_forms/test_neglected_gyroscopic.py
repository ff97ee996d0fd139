"""The box of neglected-gyroscopic: forces against the witness's, values against it, planted errors,
flight.
"""

from fractions import Fraction

import pytest
from flint import arb

from refdem.core import discovery
from refdem.truth import rotation
from refdem.truth.balls import arb_of, precision
from refdem.truth.closed_forms.neglected_gyroscopic import slope
from refdem.truth.traced_field import Program, traced
from refdem.truth.tumbling_contact import SIGNS, BodyState
from refdem.truth.witnesses.tumbling import PRESSES, Box, moving

CASE = discovery.case("neglected-gyroscopic")
GIVEN = {
    "member": "slope",
    "attitude": "3,-1,2,1",
    "velocity": "1,1/3,-2",
    "height": "1/25",
    "slope": "1/4",
}


def rates(truth, system):
    """Force and torque (about the centre) in space on the box at its start while one corner
    presses.
    """
    start = [value() if callable(value) else arb_of(value) for value in truth.begin]
    corner = SIGNS.index((-1, 1, -1))
    found = Program(traced(system.field(frozenset({corner})), 14)[0]).run(start)
    half = arb_of(system.slope) / 2
    tilt = [half.cos(), arb(0), half.sin(), arb(0)]
    return rotation.rotated(tilt, found[10:13]), rotation.rotated(tilt, found[4:7])


def expected(p):
    """The same from the equations of the witness: L' = d(R J omega)/dt."""
    box = Box(p)
    y = box.start()
    modes = tuple(
        PRESSES if signs == (-1, 1, -1) else 0
        for signs in ((2 * (n & 1) - 1, (n & 2) - 1, (n >> 1 & 2) - 1) for n in range(8))
    )
    rate = box.rates(modes, arb(0), y)
    spin = [j * w for j, w in zip(box.inertia, y[9:12], strict=True)]
    grown = [j * w for j, w in zip(box.inertia, rate[9:12], strict=True)]
    return rate[15:18], [
        rotation.dot(rate[3 * i : 3 * i + 3], spin) + rotation.dot(y[3 * i : 3 * i + 3], grown)
        for i in range(3)
    ]


def apart(instance, truth=None):
    with precision(192):
        pairs = zip(
            rates(truth or instance.truth(), slope(instance.p)), expected(instance.p), strict=True
        )
        return max(
            float(abs(a - b).mid())
            for left, right in pairs
            for a, b in zip(left, right, strict=True)
        )


@pytest.mark.parametrize(
    "given", [{}, {"friction": "0"}, {"damping": "0"}, {"inertia": "2e-5,3e-5,4e-5", "mass": "1/7"}]
)
def test_force_and_torque_at_a_corner_are_those_of_the_witness(given):
    assert apart(CASE.at(**GIVEN | given)) < 1e-40


@pytest.mark.parametrize(
    ("name", "wrong"),
    [
        (
            "pressure",
            lambda self, corner: (
                -self.system.stiffness * self.gap(corner)
                + self.system.damping * self.velocity(corner)[2]
            ),
        ),
        ("pressure", lambda self, corner: -self.system.stiffness * self.gap(corner)),
        ("gap", lambda self, corner: self.y[9]),
        ("velocity", lambda self, corner: list(self.y[10:13])),
        ("force_on", lambda self, corner: [0, 0, self.pressure(corner)]),
    ],
)
def test_a_planted_error_is_seen(monkeypatch, name, wrong):
    monkeypatch.setattr(BodyState, name, wrong)
    assert apart(CASE.at(**GIVEN)) > 1e-6


def test_values_after_a_touch_are_those_of_the_witness():
    instance = CASE.at(member="slope")
    truth = instance.truth()
    times = [Fraction(1, 20), Fraction("0.129025")]
    with precision(256):
        for t, values in moving(instance.p, list(times), {}):
            balls = truth.at(t)
            assert len(values) == 18
            assert (
                max(
                    float(abs(value - arb_of(balls[name].mid)).mid())
                    for name, value in values.items()
                )
                < 1e-31
            )
    assert [name for name, _, _ in truth.events_until(times[-1])] == ["touch6"]
    assert 10 < truth.sensitivity(times[0]) < 100


def test_in_flight_the_centre_moves_uniformly_and_the_body_as_a_free_one():
    truth = CASE.at(velocity="1/3,-2,1/7").truth()
    free = discovery.truth_of(
        "free-rigid-body",
        inertia="2e-5,4e-5,5.2e-5",
        omega_body=",".join(["31.41592653589793"] * 3),
    )
    t = Fraction(3, 5)
    balls = truth.at(t)
    body = free.at(t)
    assert [balls[axis].mid for axis in "xyz"] == [Fraction(1, 5), Fraction(-6, 5), Fraction(3, 35)]
    assert max(abs(balls[name].mid - body[name].mid) for name in body) < Fraction(1, 10**30)
    assert truth.sensitivity(t) > 1 + 0.6 * 2
    assert set(truth.scalars()) == set(free.scalars())


def test_s_of_a_place_in_flight_is_what_errors_of_place_and_velocity_grow_to():
    """Errors of one scale, along each other: the sum of components was 5/3 as much."""
    instance = CASE.at(velocity="10,-20,20")
    truth = instance.truth()
    length = instance.quantities["x"].scale
    for t in (Fraction(1, 100), Fraction(3, 5)):
        # |v| = 30 m/s.
        growth = 1 + float(t) * 30 / length
        assert growth > truth.body.sensitivity(t)
        assert growth * (1 - 1e-12) <= truth.sensitivity(t) <= growth * (1 + 1e-9)
