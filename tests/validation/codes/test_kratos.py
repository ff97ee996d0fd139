"""Kratos DEM under the gate."""


def test_the_gate_is_open(gates):
    gates.assert_open("kratos")


def test_a_law_two_per_cent_too_soft_closes_it(gates):
    gates.assert_closed(
        "kratos",
        "two-spheres",
        "order/state",
        "kratos/driver.py",
        "STIFFNESS = 1.432 *",
        "STIFFNESS = 1.46 *",
    )


def test_the_density_of_the_first_for_all_closes_it(gates):
    unequal = (
        "two-spheres[masses=1,3 radii=0.5,0.75 tangential_stiffness=96 friction=0.25"
        " angle=0.5 spins=0,0,0.5,0,0,1]"
    )
    gates.assert_closed(
        "kratos",
        unequal,
        "angular-momentum/total",
        "kratos/driver.py",
        "density[n - 1]",
        "density[0]",
    )
