"""A program in C that differentiates is judged through smooth motion and a contact, and a wrong
derivative is named.
"""

import pytest

CASES = ("harmonic-oscillator[gravity=1]", "bouncing-ball[bounces=2 velocity=1,1/2]")


def test_right_derivatives_pass_through_a_spring_and_bounces(workshop):
    found = workshop.judged(workshop.built("tangent"), *CASES)
    assert found.status == 0, found.said
    matrices = [outcome for name, outcome in found.outcomes.items() if "gradient/matrix" in name]
    assert matrices == ["pass", "pass"]
    assert found.outcomes[f"{CASES[0]}/gradient/order"] == "pass"


FAULTS = {
    "the impact time has no slope": ("left = minus(left, s);", "left = plain(left.x - s.x);"),
    "the restitution has no slope": (
        'restitution = of_element(e, "restitution");',
        'restitution = plain(of_element(e, "restitution").x);',
    ),
    "a quotient has the wrong sign": ("(a.d - a.x / b.x * b.d)", "(a.d + a.x / b.x * b.d)"),
}


@pytest.mark.parametrize("name", FAULTS)
def test_a_wrong_derivative_is_named(workshop, name):
    text, other = FAULTS[name]
    found = workshop.judged(workshop.built("tangent", ("dem.c", text, other)), *CASES)
    assert found.status == 1, found.said
    assert found.failed() == {"gradient/matrix"}, found.said
