"""Certified sensitivities, against differences of certified values that lie much nearer, and a
derivative that is lost on purpose.
"""

from collections.abc import Callable
from dataclasses import replace
from fractions import Fraction

import pytest

from refdem.core import discovery
from refdem.core.parameters import Parameters
from refdem.core.truth import Ball, Truth
from refdem.errors import NotCertifiedError
from refdem.truth.closed_forms.impact_benchmarks.contact_path import ContactPath
from refdem.truth.closed_forms.quadratic_drag import QuadraticDrag
from refdem.truth.dual import plain
from refdem.truth.sensitivities import Number, numbers_of, sensitivities, sensitivities_at

DIGITS = 20
STEP = Fraction(1, 10**20)
"""Differences over it have an error of 1e-40 times the third derivative."""

SETTINGS = [
    ("harmonic-oscillator", {"mass": "2", "gravity": "3/7", "v0": "1/3"}, "5/2"),
    ("viscous-oscillator", {"gravity": "1/3", "v0": "-1/2"}, "7/3"),
    ("driven-oscillator", {}, "5/3"),
    ("coulomb-oscillator", {"v0": "1/3"}, "9/4"),
    ("quadratic-drag", {"v0": "5"}, "3/2"),
    ("quadratic-drag", {"v0": "-20"}, "3/2"),
    ("bouncing-ball", {"velocity": "1/2,1/3", "spin": "2", "friction": "1/5"}, "7/5"),
    ("captured-mass", {}, "6"),
    ("corner-impact", {}, "1"),
    ("asymmetric-field", {}, "2"),
    ("wedge-collision", {}, "1"),
    ("rolling", {}, "1/2"),
    ("hard-wall", {}, "3/2"),
    ("hard-spheres", {}, "2"),
    ("hard-spheres", {"friction": "1/5", "spins": "1,2,3,-1,1/2,1"}, "5/2"),
    ("newtons-cradle", {}, "3/2"),
    ("pendulum", {"mass": "1", "length": "1", "theta0": "2"}, "5/2"),
    ("pendulum", {"theta0": "1/2", "thetadot0": "9"}, "1"),
    ("pendulum-equilibria", {"delta": "1/3"}, "1"),
    ("duffing", {"amplitude": "3/2"}, "3"),
    ("whirling-shaft", {}, "1"),
    ("van-der-pol", {}, "2"),
    ("driven-duffing", {}, "2"),
    ("quadratic-response", {}, "2"),
    ("dissipating-body", {}, "1"),
    ("free-rigid-body", {}, "1"),
    ("two-body-orbit", {}, "3"),
    ("two-body-orbit", {"stiffness": "2"}, "3"),
    ("two-spheres", {}, "2"),
    ("newtons-first-law", {"spin": "1/2"}, "2"),
    ("logistic", {}, "7"),
    ("logistic", {"eta": "4", "x0": "1/3"}, "12"),
    ("logistic", {"form": "ode"}, "2"),
    ("logistic", {"form": "ode", "x0": "0"}, "2"),
    ("billiards", {"geometry": "rectangle"}, "5"),
    ("billiards", {"geometry": "rectangle", "direction": "-3,7"}, "12"),
    ("billiards", {}, "4"),
    ("billiards", {"size": "2,2"}, "6"),
    ("quaternions", {}, "0"),
    ("rotations", {}, "0"),
    ("hertz-spheres", {}, "1/100"),
    ("hertz-spheres", {}, "1/13"),
    ("hertz-spheres", {}, "3/20"),
    ("hertz-spheres", {}, "1"),
    ("bifurcations", {}, "0"),
    ("bifurcations", {"beta": "-1/20", "delta": "1/50", "f0": "1/10"}, "0"),
    ("billiard-break", {"rows": "2", "friction": "1/10"}, "3/2"),
    ("rigid-cluster", {}, "1/2"),
    ("phase-flow", {}, "5/2"),
    ("phase-flow", {"flow": "viscous"}, "5/2"),
    ("phase-flow", {"flow": "coulomb"}, "5/2"),
    ("phase-flow", {"flow": "pendulum"}, "1"),
    ("block-on-slope", {"friction": "1/5"}, "3/2"),
    ("block-on-slope", {"friction": "9/10"}, "3/2"),
    ("power-oscillator", {}, "7"),
    ("power-oscillator", {"exponent": "5/2", "amplitude": "-2", "mass": "3"}, "20"),
    ("power-oscillator", {"exponent": "1", "amplitude": "1/3"}, "0"),
    ("impact-benchmarks", {"member": "dem-05-hertz"}, "1/400000"),
    ("impact-benchmarks", {"member": "dem-05-hertz"}, "1/100000"),
    ("impact-benchmarks", {"member": "dem-05-hertz", "angle": "1/20"}, "1/200000"),
    ("impact-benchmarks", {"member": "dem-05-mindlin"}, "1/400000"),
    ("impact-benchmarks", {"member": "dem-05-mindlin"}, "1/100000"),
    ("impact-benchmarks", {"member": "dem-05-mindlin", "angle": "-1/20"}, "1/100000"),
    ("impact-benchmarks", {"member": "dem-05-mindlin", "angle": "1/2"}, "1/100000"),
]


Make = Callable[[Parameters], Truth]


def difference(make: Make, p: Parameters, t: Fraction, number: Number) -> dict[str, Fraction]:
    """Central differences over STEP of values to 60 digits."""
    ahead, behind = (
        make(number.set_in(p, number.of(p) + sense * STEP)).refined(60).at(t) for sense in (1, -1)
    )
    return {name: (ahead[name].mid - behind[name].mid) / (2 * STEP) for name in ahead}


@pytest.mark.parametrize(("case", "given", "time"), SETTINGS)
def test_derivatives_are_what_differences_tend_to(
    case: str, given: dict[str, str], time: str
) -> None:
    chosen = discovery.case(case)
    p = chosen.written_out(chosen.at(**given).p)
    hold_to_differences(chosen.truth, p, Fraction(time))


def hold_to_differences(make: Make, p: Parameters, t: Fraction) -> None:
    """Fails unless every derivative at t agrees with differences, and those that are missing are by
    numbers that are 0.
    """
    found = sensitivities(make, p, t, DIGITS)
    for number in numbers_of(p):
        if number.name in found.missing:
            continue
        seen = difference(make, p, t, number)
        for quantity, slopes in found.of.items():
            ball = slopes[number.name]
            away = abs(ball.mid - seen[quantity])
            assert away <= ball.radius + Fraction(1, 10**25), (quantity, number.name)
            assert ball.radius < Fraction(1, 10 ** (DIGITS - 2))
    # What is missing is a border of kinds of motion: friction, spin or restitution that are 0.
    assert all(number.of(p) == 0 for number in numbers_of(p) if number.name in found.missing)


@pytest.mark.parametrize("time", ["1/2", "1"])
@pytest.mark.parametrize("spin", ["-102/100", "3"])
@pytest.mark.parametrize("member", ["contact-path", "contact-path-turned"])
def test_impulses_of_a_passing_have_the_derivatives_of_a_straight_path(
    member: str, spin: str, time: str
) -> None:
    """Of masses that leave more digits for the differences than those of the members do."""
    chosen = discovery.case("impact-benchmarks")

    def heavier(p: Parameters) -> Truth:
        truth = chosen.truth(p)
        assert isinstance(truth, ContactPath)
        return replace(truth, path=replace(truth.path, mass=Fraction(10) ** 100))

    p = chosen.written_out(chosen.at(member=member, partner_spin=spin).p)
    hold_to_differences(heavier, p, Fraction(time))


def test_two_equal_elastic_balls_exchange_their_motions() -> None:
    """The second moves on as if it were the first, a diameter ahead: its place after the impact
    depends on the start of the first alone, as a code that differentiates through its steps
    without the time of impact does not find.
    """
    chosen = discovery.case("newtons-cradle")
    p = chosen.at(balls="2", velocities="2,1/2,0,0,0,0,0").p
    t = Fraction(1)
    of = sensitivities(chosen.truth, p, t, DIGITS).of
    exact: dict[tuple[str, str], Fraction | int] = {
        ("r1.x", "velocities.0"): 0,
        ("r1.x", "velocities.1"): t,
        ("r2.x", "velocities.0"): t,
        ("r2.x", "velocities.1"): 0,
        ("v1.x", "velocities.0"): 0,
        ("v1.x", "velocities.1"): 1,
        ("v2.x", "velocities.0"): 1,
        ("v2.x", "velocities.1"): 0,
    }
    for (quantity, number), expected in exact.items():
        ball = of[quantity][number]
        assert abs(ball.mid - expected) <= ball.radius, (quantity, number)


def test_a_derivative_that_a_formula_loses_is_missing(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(
        QuadraticDrag, "terminal_squared", property(lambda form: plain(_terminal(form)))
    )
    chosen = discovery.case("quadratic-drag")
    found = sensitivities(chosen.truth, chosen.at(v0="5").p, Fraction(1), DIGITS)
    assert set(found.missing) == {"mass", "gravity", "drag"}
    assert set(found.of["y"]) == {"v0"}
    assert "does not carry the number" in found.missing["drag"]


def _terminal(form: QuadraticDrag) -> Fraction:
    return form.mass * form.gravity / form.drag


def test_a_number_that_starts_on_a_border_has_no_derivative() -> None:
    """Friction holds on one side of v0 = 0 otherwise than on the other."""
    chosen = discovery.case("coulomb-oscillator")
    found = sensitivities(chosen.truth, chosen.at().p, Fraction(5, 2), DIGITS)
    assert list(found.missing) == ["v0"]
    assert isinstance(found.of["x"]["mass"], Ball)


def test_several_times_at_once_have_the_derivatives_of_each() -> None:
    """The ball falls until 0.64 s; friction that is 0 has a derivative until then."""
    chosen = discovery.case("bouncing-ball")
    p = chosen.at(velocity="1/2,0", spin="2").p
    times = [Fraction(1, 2), Fraction(1)]
    together = sensitivities_at(chosen.truth, p, times, DIGITS)
    assert [list(found.missing) for found in together] == [[], ["friction"]]
    for t, found in zip(times, together, strict=True):
        alone = sensitivities(chosen.truth, p, t, DIGITS)
        assert found.t == t
        assert found.missing.keys() == alone.missing.keys()
        assert found.of == alone.of


def test_numbers_that_are_0_are_moved_one_by_one() -> None:
    """Friction acts where the ball spins: beside 0 in both, the motion is of another kind."""
    chosen = discovery.case("bouncing-ball")
    p = chosen.at(velocity="1/2,0", spin="0", friction="0").p
    moved: list[Parameters] = []

    def recorded(given: Parameters) -> Truth:
        moved.append(given)
        return chosen.truth(given)

    sensitivities_at(recorded, p, [Fraction(1, 2)], DIGITS)
    values = [(given["friction"], given["spin"]) for given in moved]
    numbers = [pair for pair in values if all(isinstance(one, Fraction) for one in pair)]
    assert any(friction for friction, _ in numbers)
    assert any(spin for _, spin in numbers)
    assert not any(friction and spin for friction, spin in numbers)


def test_derivatives_of_a_chaotic_map_are_the_product_of_its_slopes() -> None:
    """They are larger than 1e50, and differences over a fixed part of the start tell nothing."""
    chosen = discovery.case("logistic")
    p = chosen.at(eta="4", x0="1/3").p
    t = Fraction(200)
    truth = chosen.truth(p).refined(150)
    product = Fraction(1)
    for n in range(200):
        product *= 4 * (1 - 2 * truth.at(Fraction(n))["x_n"].mid)
    found = sensitivities(chosen.truth, p, t, DIGITS)
    assert found.missing == {}
    ball = found.of["x_n"]["x0"]
    assert abs(ball.mid) > 10**50
    assert abs(ball.mid - product) <= ball.radius + Fraction(1, 10**DIGITS)


def test_a_free_box_moves_by_its_velocity_and_turns_as_a_free_body() -> None:
    chosen = discovery.case("neglected-gyroscopic")
    p = chosen.at(omega_body="1/8,1/4,0").p
    t = Fraction(1, 4)
    found = sensitivities(chosen.truth, p, t, DIGITS)
    assert found.missing == {}
    assert found.of["x"]["velocity.0"] == Ball(t, Fraction(0))
    assert found.of["omega.z"]["velocity.0"].mid == 0
    seen = difference(chosen.truth, p, t, Number("inertia", 1))
    ball = found.of["attitude.z"]["inertia.1"]
    assert abs(ball.mid - seen["attitude.z"]) <= ball.radius + Fraction(1, 10**25)


def test_a_gas_without_a_certified_motion_says_so() -> None:
    chosen = discovery.case("granular-gas")
    with pytest.raises(NotCertifiedError, match="the motion is chaotic"):
        sensitivities(chosen.truth, chosen.at().p, Fraction(1), DIGITS)


def test_a_spring_without_length_has_the_derivative_by_its_length() -> None:
    chosen = discovery.case("coupled-pendulums")
    p = chosen.at(spring_length="0").p
    t = Fraction(1, 4)
    found = sensitivities(chosen.truth, p, t, DIGITS)
    assert found.missing == {}
    seen = difference(chosen.truth, p, t, Number("spring_length"))
    ball = found.of["theta1"]["spring_length"]
    assert abs(ball.mid - seen["theta1"]) <= ball.radius + Fraction(1, 10**25)


def test_a_block_on_the_border_of_sliding_says_by_which_numbers_there_is_none() -> None:
    chosen = discovery.case("block-on-slope")
    p = chosen.at(friction="3/4", slope="3/4").p
    found = sensitivities(chosen.truth, p, Fraction(1), DIGITS)
    assert set(found.missing) == {"friction", "slope"}
    assert found.of["s"]["gravity"] == Ball(Fraction(0), Fraction(0))


class Told(Truth):
    """A truth whose values do not come from the parameters."""

    method = "a table"
    witness = "none"

    def at(self, t: Fraction) -> dict[str, Ball]:
        """One quantity, 0."""
        return {"x": Ball(Fraction(0), Fraction(0))}

    def sensitivity(self, t: Fraction) -> float:
        """No growth."""
        return 1.0


def test_a_truth_that_has_none_says_so() -> None:
    p = discovery.case("logistic").at().p
    with pytest.raises(NotCertifiedError, match="not certified yet: a table"):
        sensitivities(lambda _: Told(), p, Fraction(1), DIGITS)
