"""YADE under the gate."""

from pathlib import Path

import pytest

DRIVER = Path(__file__).resolve().parents[3] / "validation/codes/yade/driver.py"
LAW = {
    "law": "linear",
    "stiffness": 128.0,
    "tangential_stiffness": 64.0,
    "friction": 0.25,
    "branch": "R-d/2",
    "cutoff": "zero_force",
}


def test_the_gate_is_open(gates):
    gates.assert_open("yade")


def test_a_material_as_its_documentation_has_it_closes_it(gates):
    gates.assert_closed(
        "yade",
        "two-spheres[damping=1 cutoff=zero_force]",
        "order/state",
        "yade/driver.py",
        "ViscElMat(kn=2 * kn",
        "ViscElMat(kn=kn",
    )


def test_a_facet_taken_for_a_sphere_of_the_same_radius_closes_it(gates):
    gates.assert_closed(
        "yade",
        "impact-benchmarks[member=dem-05 branch=R-d/2]",
        "error/v.x",
        "yade/driver.py",
        "material(law, radius, is_facet=True)",
        "material(law, radius)",
    )


@pytest.mark.parametrize(
    ("cosine", "sine", "size", "damping"),
    [(-1.0, 0.0, 1.0, 0.0), (0.0, 1.0, 1.0, 1.0), (0.8, 0.6, 1e-5, 0.0), (-0.6, -0.8, 1.0, 1.0)],
)
def test_a_wall_of_any_normal_is_the_same_wall(tmp_path, bounce, cosine, sine, size, damping):
    command = ("yade", "-x", "-n", str(DRIVER))
    law = LAW | {"damping": damping}
    bounce(command, law, size).assert_as_upright(tmp_path, cosine, sine)
