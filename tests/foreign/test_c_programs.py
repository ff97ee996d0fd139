"""The example programs in C and C++ hold what they claim; with a fault planted, the gate names what
is wrong.
"""

import subprocess

import pytest

SMOOTH = ("harmonic-oscillator", "harmonic-oscillator[gravity=1]", "free-rigid-body")
DAMPED = "two-spheres[damping=1]"
RUBBING = "two-spheres[angle=1/2 friction=1/4 masses=1,3 radii=1/2,3/4]"
CONTACTS = ("two-spheres", DAMPED, RUBBING)


@pytest.mark.parametrize(
    ("language", "cases"),
    [
        ("c", SMOOTH + CONTACTS),
        ("cpp", SMOOTH + CONTACTS),
        ("staggered", SMOOTH[:2] + CONTACTS[:2]),
    ],
)
def test_a_correct_program_raises_no_alarm(workshop, language, cases):
    found = workshop.judged(workshop.built(language), *cases)
    assert found.status == 0, found.said
    assert not {"fail", "error", "unsupported"} & set(found.outcomes.values())
    assert [
        name for name, outcome in found.outcomes.items() if outcome == "pass" and "/order/" in name
    ]


FREE = "free-rigid-body"
SPRING = "harmonic-oscillator"


def test_a_correct_program_in_single_precision_raises_no_alarm(workshop):
    found = workshop.judged(workshop.built("c", single=True), *SMOOTH, RUBBING)
    assert found.status == 0, found.said
    assert not {"fail", "error"} & set(found.outcomes.values())
    assert workshop.refdem("smoke", str(workshop.built("c", single=True))).returncode == 0


def test_single_precision_said_to_be_double_is_seen(workshop):
    toml = workshop.built("c", single=True)
    toml.write_text(toml.read_text().replace('precision = "single"\n', ""))
    assert workshop.judged(toml, "harmonic-oscillator[gravity=1]").status in (1, 3)


def test_a_correct_program_of_first_order_raises_no_alarm(workshop):
    synchronous = (
        ("refdem.toml", HALF_STEP, ""),
        (
            "refdem.toml",
            "order = 2",
            "order = 1\nsymplectic = true",
        ),
    )
    found = workshop.judged(
        workshop.built("staggered", ("dem.c", "kick(-h / 2);", "forces();"), *synchronous),
        *SMOOTH[:2],
        DAMPED,
    )
    assert found.status == 0, found.said
    assert found.outcomes["harmonic-oscillator/order/state"] == "pass"


PLUS = "(lj * cos(angle) + lk * sin(angle))"
MINUS = "(lk * cos(angle) - lj * sin(angle))"
OMEGA = "memcpy(body[i].w, w, sizeof w);"
HALF_STEP = 'velocity_time = "minus-half-step"\n'
FAULTS = {
    "the gyroscopic term with the other sign": (
        ("c", FREE, "error/omega_body.x"),
        ("rotation.h", PLUS, PLUS.replace("+", "-")),
        ("rotation.h", MINUS, MINUS.replace("-", "+")),
    ),
    "inertia axes swapped": (
        ("c", FREE, "error/omega_body.x"),
        (
            "dem.c",
            '"inertia");',
            '"inertia"); double kept = b->J[0]; b->J[0] = b->J[2]; b->J[2] = kept;',
        ),
    ),
    "f in place of omega": (
        ("c", FREE, "error/omega.x"),
        ("dem.c", OMEGA, f"w[0] /= 2 * M_PI, w[1] /= 2 * M_PI, w[2] /= 2 * M_PI, {OMEGA}"),
    ),
    "the lever of a sphere halved": (
        ("c", RUBBING, "error/omega1.z"),
        ("dem.c", "a->torque[k] += arm_a", "a->torque[k] += 0.5 * arm_a"),
    ),
    "friction along the slip": (
        ("c", RUBBING, "error/v1.y"),
        ("dem.c", "- rub * slip[k]", "+ rub * slip[k]"),
    ),
    "output one step late": (
        ("c", SPRING, "error/x"),
        ("dem.c", "k < stride; k++", "k < stride - (n == 1); k++"),
    ),
    "contacts told a step late": (
        ("c", DAMPED, "event-times/contact"),
        ("dem.c", "(k + 1) * interval", "(k + 2) * interval"),
    ),
    "events at steps said to be located": (
        ("c", DAMPED, "event-times/contact"),
        ("refdem.toml", "backward = true", "backward = true\nlocates_events = true"),
    ),
    "a force on one body only": (
        ("c", RUBBING, "momentum/total"),
        ("dem.c", "b->f[k] -= f[k];", "b->f[k] -= 0.999 * f[k];"),
    ),
    "staggered velocities said to be synchronous": (
        ("staggered", SPRING, "error/v"),
        ("refdem.toml", HALF_STEP, ""),
    ),
    "a staggered start without its half kick": (
        ("staggered", SPRING, "order/state"),
        ("dem.c", "kick(-h / 2);", "forces();"),
    ),
    "synchronous velocities said to be staggered": (
        ("c", SPRING, "error/v"),
        ("refdem.toml", "[engine]\n", "[engine]\n" + HALF_STEP),
    ),
    "a wrong weight of a stage": (
        ("cpp", SPRING, "order/state"),
        ("dem.cpp", "2 * k2[i] + 2 * k3[i]", "3 * k2[i] + 1 * k3[i]"),
    ),
    "the gyroscopic term forgotten": (
        ("cpp", FREE, "error/omega_body.x"),
        ("dem.cpp", " - cross(w, L)", " - 0.0 * cross(w, L)"),
    ),
    "the damping's sign": (
        ("cpp", DAMPED, "error/v1.x"),
        ("dem.cpp", "+ e.damping * closing", "- e.damping * closing"),
    ),
    "the quaternion conjugated in output": (
        ("cpp", FREE, "error/attitude"),
        ("dem.cpp", '",%.17g", s[o + k]', '",%.17g", k < 7 ? s[o + k] : -s[o + k]'),
    ),
}


@pytest.mark.parametrize("name", FAULTS)
def test_a_planted_fault_turns_the_exit_status_and_is_named(workshop, name):
    (language, case, seen), *changes = FAULTS[name]
    found = workshop.judged(workshop.built(language, *changes), case)
    assert found.status == 1, found.said
    assert seen in found.failed(), found.said


def test_a_rebuilt_program_runs_again_and_an_unchanged_one_does_not(workshop):
    toml = workshop.built("c")
    assert "0 read from the store" in workshop.judged(toml, SPRING).said
    assert "\n0 runs made" in workshop.judged(toml, SPRING).said
    source = toml.parent / "dem.c"
    source.write_text(source.read_text().replace("a->f[k] += f;", "a->f[k] -= f;"))
    subprocess.run(["make", "-s", "-C", str(toml.parents[1]), "c"], check=True)
    flipped = workshop.judged(toml, SPRING)
    assert "0 read from the store" in flipped.said
    assert flipped.status == 1


def test_smoke_and_explain_take_a_program(workshop):
    toml = str(workshop.built("c"))
    smoke = workshop.refdem("smoke", toml)
    assert smoke.returncode == 0, smoke.stdout + smoke.stderr
    assert "pass" in smoke.stdout
    explained = workshop.refdem("explain", DAMPED, "--engine", toml)
    assert "dem-c/velocity-verlet" in explained.stdout
    refused = workshop.refdem("explain", "pendulum", "--engine", toml)
    is_rod = "not supported: rod" in refused.stdout
    assert is_rod or "not supported: constraint" in refused.stdout


def test_what_a_program_refuses_at_run_time_is_unsupported(workshop):
    found = workshop.judged(workshop.built("c"), "two-spheres[damping=1 cutoff=zero_force]")
    assert found.status == 2, "nothing was judged"
    assert set(found.outcomes.values()) == {"unsupported"}
    assert (
        "a force that may not pull"
        in (workshop.home / found.said.split("report: ")[1].split(" (")[0])
        .with_name("records.jsonl")
        .read_text()
    )
