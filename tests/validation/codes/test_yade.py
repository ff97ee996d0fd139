"""YADE under the gate."""


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
