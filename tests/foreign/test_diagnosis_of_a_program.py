"""Faults planted in a C program with amplitudes that no catalogue has: the right one is named with
its size, or none is.
"""

import json

import pytest

SPRING = "harmonic-oscillator[duration=4 samples=16]"
HANGING = "harmonic-oscillator[gravity=1 duration=4 samples=16]"
FREE = "free-rigid-body[duration=2 samples=8]"
OMEGA = "memcpy(body[i].w, w, sizeof w);"
WRITTEN = "b->r[0], b->r[1], b->r[2], b->v[0], b->v[1], b->v[2]);"
FAST = "b->r[0], b->r[1], b->r[2], 1.07 * b->v[0], 1.07 * b->v[1], 1.07 * b->v[2]);"
KNOWN = {
    "a stiffer spring": (
        SPRING,
        "spring-stiffness",
        0.0137,
        ("dem.c", "copysign(e->k *", "copysign(1.0137 * e->k *"),
    ),
    "less gravity": (
        HANGING,
        "uniform-gravity-g",
        -0.0269,
        ("dem.c", "body[j / 3].m * e->end", "0.9731 * body[j / 3].m * e->end"),
    ),
    "a longer drift": (
        SPRING,
        "drift-length",
        0.0043,
        ("dem.c", "b->r[k] += h * b->v[k]", "b->r[k] += 1.0043 * h * b->v[k]"),
    ),
    "a second kick that is too short": (
        SPRING,
        "kick-too-short",
        1.3,
        (
            "dem.c",
            "sizeof b->w);\n        kick(b, h / 2);",
            "sizeof b->w);\n        kick(b, 0.987 * h / 2);",
        ),
    ),
    "velocities written too large": (SPRING, "minutes", 0.07 / 59, ("dem.c", WRITTEN, FAST)),
    "a start that turns too slowly": (
        FREE,
        "body-omega",
        -0.1,
        ("dem.c", OMEGA, f"w[0] *= 0.9, w[1] *= 0.9, w[2] *= 0.9, {OMEGA}"),
    ),
    "a spring with a cube": (
        SPRING,
        "spring-cubic",
        10.0,
        (
            "dem.c",
            "pow(fabs(stretch), e->n), stretch)",
            "pow(fabs(stretch), e->n) + 0.1 * e->k * pow(fabs(stretch), 3), stretch)",
        ),
    ),
    "turns that are too long": (
        FREE,
        "turn-length",
        0.0021,
        ("rotation.h", "double angle = h * w[i]", "double angle = 1.0021 * h * w[i]"),
    ),
}
UNKNOWN = {
    "omega written in leaning axes": (
        FREE,
        ("dem.c", "turned(w, b->q, b->w, 1);", "turned(w, b->q, b->w, 1), w[0] += 1e-3 * w[1];"),
    ),
}


def diagnosed(workshop, case, *changes):
    """What `refdem diagnose` says of the C program with these changes."""
    toml = workshop.built("c", *changes)
    record = f"{case}/dem-c/velocity-verlet"
    done = workshop.refdem("diagnose", record, "--engine", str(toml), "--level", "1", "--json")
    assert done.returncode == 0, done.stdout + done.stderr
    return json.loads(done.stdout)


@pytest.mark.parametrize("name", KNOWN)
def test_a_fault_of_any_amplitude_is_named_with_its_size(workshop, name):
    case, fault, amplitude, *changes = KNOWN[name]
    said = diagnosed(workshop, case, *changes)
    assert fault in {said["explained_by"]["fault"], *said["explained_by"]["alike"]}
    fitted = [
        twin["amplitude"]
        for twin in said["twins"]
        if twin["fault"] == fault and twin["distance"] < 1e-9
    ]
    assert fitted[0] == pytest.approx(amplitude, rel=1e-6)


@pytest.mark.parametrize("name", UNKNOWN)
def test_a_fault_that_no_twin_has_is_given_no_name(workshop, name):
    case, *changes = UNKNOWN[name]
    said = diagnosed(workshop, case, *changes)
    assert said["explained_by"] is None
    assert "not a diagnosis" in said["sentence"]
