"""Every slip of the source is settled by its own numbers: what holds is what was measured, what was
said is not.
"""

import itertools
import math

import numpy as np
import pytest

from refdem.core import discovery
from refdem.manual import slips
from refdem.manual.slip import KnownSlip
from refdem.manual.slips import SLIPS, crossings, slips_of

MEASURED = {
    slip.where: slip.measure for slip in SLIPS if set(slip.cases) & set(discovery.names("cases"))
}


def values(where: str) -> list[float]:
    return [float(value) for _, value in MEASURED[where]()]


@pytest.mark.parametrize("where", ["(1.116)", "(1.95), (1.96)", "section 1.7.3"])
def test_the_measured_value_is_what_holds_and_not_what_was_said(where: str) -> None:
    measured, holds, said = values(where)
    assert abs(measured - holds) < 0.03 * abs(measured - said)


def test_the_root_that_holds_needs_the_force_that_is_there() -> None:
    holds, said = values("(1.121)")
    assert holds == 1.5
    assert abs(said - 1.5) > 0.01


def test_the_second_sign_is_that_of_the_matrix() -> None:
    (_, second), (_, first), (_, matrix) = MEASURED["(1.62) against (1.64)"]()
    assert second == matrix != first


def test_euler_angles_diverge_at_the_pole_alone() -> None:
    assert values("section 1.3.7") == pytest.approx(
        [0, 1 / math.tan(0.1), 1e3, 1e6], abs=1e-5, rel=1e-5
    )


def test_the_spin_wanders_unless_it_is_about_a_principal_axis() -> None:
    wanders, stays = values("section 1.3.6")
    assert wanders > 0.1
    assert stays == 0


def test_a_quaternion_and_its_rate_do_not_commute() -> None:
    commutator, other, product = values("after (1.75)")
    assert commutator > 0.1
    assert other == product == 0


def test_beyond_a_damping_the_amplitude_has_no_peak() -> None:
    *amplitudes, squared = values("(1.106)")
    assert all(a > b for a, b in itertools.pairwise(amplitudes))
    assert squared < 0


def test_driven_paths_cross_and_free_ones_do_not() -> None:
    driven, free = values("sections 1.5.4, 1.6.2")
    assert driven > 0
    assert free == 0


def test_resonance_grows_as_was_stated() -> None:
    first, other, later, again = values("exercise 1.3")
    assert (first, later) == (other, again)
    assert abs(later) > 5 * abs(first)


def test_the_product_is_no_quarter_turn() -> None:
    (_, first), (_, second), *_, (_, angle) = MEASURED["figure 1.7"]()
    assert first == "(0, 1, 0)"
    assert second != "(-1, 0, 0)"
    assert float(angle) == pytest.approx(120)


def test_the_transpose_of_the_printed_matrix_turns_the_tensor() -> None:
    holds, said = values("(1.30)")
    assert holds == 0
    assert said > 0.05


def test_without_torque_the_angular_momentum_stays_and_the_tensor_turns() -> None:
    tensor, momentum = values("section 1.3.6, (1.32)")
    assert tensor > 0.1
    assert momentum == 0


def test_the_dashed_lines_keep_their_height() -> None:
    place, speed, damped = values("captions of figures 1.15 and 1.16")
    assert (place, speed) == (1, -1)
    assert abs(damped) < 0.1


def test_the_rule_of_the_product_is_that_of_the_definitions() -> None:
    (_, table), (_, rule), (_, motion), (_, cosine) = MEASURED["exercise 1.2 a"]()
    assert table == rule == "(-60, 12, 30, 24)"
    assert motion == cosine


def test_filippov_moves_nothing_along_the_segment_of_rest() -> None:
    _, (_, weight), (_, sliding), (_, stop), (_, early), (_, late) = MEASURED[
        "section 1.4.3, on Filippov's theory"
    ]()
    assert 0 < float(weight) < 1
    assert sliding == "(0, 0)"
    assert float(stop) == pytest.approx(3 * math.pi, rel=1e-5)
    assert early == late == "-0.1"


def test_a_crossing_is_a_crossing() -> None:
    assert crossings(np.array([[0, 0], [1, 1], [1, 0], [0, 1.0]])) == 1
    assert crossings(np.array([[0, 0], [1, 0], [1, 1], [0, 1.0]])) == 0


def test_a_slip_is_measured_when_its_page_is_made(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(
        slips,
        "SLIPS",
        (
            KnownSlip(
                cases=("pendulum",),
                where="(9.99)",
                says="said",
                holds="holds",
                measure=lambda: (("now", "1"),),
            ),
        ),
    )
    (found,) = slips_of("pendulum")
    assert found.measured == (("now", "1"),)
    assert slips_of("duffing") == ()


def test_every_slip_has_a_case() -> None:
    assert len(SLIPS) == 27
    assert len({slip.where for slip in SLIPS}) == len(SLIPS)
    assert all(slip.measure.__doc__ for slip in SLIPS)
