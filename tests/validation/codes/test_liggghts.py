"""LIGGGHTS under the gate."""

from pathlib import Path

import pytest

DRIVER = Path(__file__).resolve().parents[3] / "validation/codes/liggghts/driver.py"
LAW = {
    "law": "linear",
    "stiffness": 128.0,
    "tangential_stiffness": 64.0,
    "damping": 1.0,
    "friction": 0.25,
    "branch": "R-d/2",
    "cutoff": "zero_force",
}


def test_the_gate_is_open(gates):
    gates.assert_open("liggghts")


def test_numbers_of_a_contact_one_per_cent_too_high_close_it(gates):
    gates.assert_closed(
        "liggghts",
        "two-spheres[damping=1]",
        "order/state",
        "liggghts/driver.py",
        "{law[key] if key",
        "{1.01 * law[key] if key",
    )


def test_a_wall_a_tenth_of_a_radius_away_closes_it(gates):
    gates.assert_closed(
        "liggghts",
        "impact-benchmarks[member=co-6 branch=R-d/2]",
        "error/v.x",
        "liggghts/driver.py",
        """{plane['point'][k]!r}\"""",
        """{plane['point'][k] + 0.01!r}\"""",
    )


@pytest.mark.parametrize("size", [1.0, 1e-5])
@pytest.mark.parametrize(
    ("cosine", "sine"), [(-1.0, 0.0), (0.0, 1.0), (0.0, -1.0), (0.8, 0.6), (-0.6, -0.8)]
)
def test_a_wall_of_any_normal_is_the_same_wall(tmp_path, bounce, cosine, sine, size):
    command = ("python3", str(DRIVER), "liggghts")
    bounce(command, LAW, size).assert_as_upright(tmp_path, cosine, sine)
