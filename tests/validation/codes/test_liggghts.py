"""LIGGGHTS under the gate."""


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
