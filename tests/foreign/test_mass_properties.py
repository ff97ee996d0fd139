"""A program that is asked for mass properties: right as it is, and named where a fault is planted
in it.
"""

import pytest

CASE = "moments-of-inertia"


def test_a_correct_program_raises_no_alarm_and_is_silent_about_what_it_cannot_say(workshop):
    found = workshop.judged(workshop.built("solids"), CASE)
    assert found.status == 0, found.said
    assert not {"fail", "error"} & set(found.outcomes.values())
    known = {
        name.split("/error/")[1].partition(".")[0]
        for name, outcome in found.outcomes.items()
        if outcome == "pass" and "/error/" in name
    }
    wedges = {"right-angle-wedge", "isosceles-wedge"}
    assert known == {"tetrahedron", "turned-tetrahedron", "rectangular-pyramid", "angle", *wedges}


FAULTS = {
    "a weight of the second moments": (
        "error/angle.inertia.xx",
        "det / 120 * (s",
        "det / 119.99 * (s",
    ),
    "products of inertia with the other sign": (
        "error/angle.inertia.xy",
        '%.17g\\n", -S[0][1]',
        '%.17g\\n", +S[0][1]',
    ),
    "turned the other way": (
        "error/turned-tetrahedron.inertia.xy",
        "R[m][k] * S[k][l] * R[n][l]",
        "R[k][m] * S[k][l] * R[l][n]",
    ),
    "the density forgotten": (
        "error/tetrahedron.inertia.zz",
        "S[m][n] = density * S[m][n]",
        "S[m][n] = S[m][n]",
    ),
    "about the origin": (
        "error/rectangular-pyramid.inertia.xx",
        "sums.second[m][n] -= sums.first[m] * sums.first[n] / sums.volume",
        "sums.second[m][n] -= 0",
    ),
}


@pytest.mark.parametrize("name", FAULTS)
def test_a_planted_fault_is_named(workshop, name):
    seen, text, other = FAULTS[name]
    found = workshop.judged(workshop.built("solids", ("moments.c", text, other)), CASE)
    assert found.status == 1, found.said
    assert seen in found.failed(), found.said


def test_a_motion_is_refused(workshop):
    explained = workshop.refdem(
        "explain", "free-rigid-body", "--engine", str(workshop.built("solids"))
    )
    assert "cannot run a motion" in explained.stdout
