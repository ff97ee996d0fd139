"""The example program in Fortran holds what it claims; with a fault planted, the gate names what is
wrong.
"""

import pytest

CASES = (
    "harmonic-oscillator",
    "harmonic-oscillator[gravity=1]",
    "free-rigid-body",
    "two-spheres[damping=1]",
)
FAULTS = {
    "the gyroscopic term with the other sign": (
        "free-rigid-body",
        "error/omega_body.x",
        "cross(J*w, w)",
        "cross(w, J*w)",
    ),
    "an explicit step in place of the midpoint": (
        "harmonic-oscillator",
        "error/x",
        "rate(s + h/2*rate(s))",
        "rate(s + 0*h*rate(s))",
    ),
    "the mass forgotten": (
        "two-spheres[masses=1,3 damping=1]",
        "momentum/total",
        "force(:, k)/bodies(k)%mass",
        "force(:, k)",
    ),
}


def test_a_correct_program_raises_no_alarm(workshop):
    found = workshop.judged(workshop.built("fortran"), *CASES)
    assert found.status == 0, found.said
    assert not {"fail", "error", "unsupported"} & set(found.outcomes.values())


@pytest.mark.parametrize("name", FAULTS)
def test_a_planted_fault_turns_the_exit_status_and_is_named(workshop, name):
    case, seen, text, other = FAULTS[name]
    found = workshop.judged(
        workshop.built("fortran", ("main.f90" if "rate(s" in text else "dem.f90", text, other)),
        case,
    )
    assert found.status == 1, found.said
    assert seen in found.failed(), found.said


def test_what_a_program_refuses_at_run_time_is_unsupported(workshop):
    toml = workshop.built(
        "fortran", ("refdem.toml", '"contact:linear"', '"contact:linear", "friction"')
    )
    found = workshop.judged(toml, "two-spheres[damping=1 angle=1/2 friction=1/4]")
    assert set(found.outcomes.values()) == {"unsupported"}
