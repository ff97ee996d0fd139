"""The older LAMMPS of Debian under the gate, by the same driver."""


def test_the_gate_is_open(gates):
    gates.assert_open("lammps-debian")


def test_a_step_one_per_cent_too_short_closes_it(gates):
    case = "harmonic-oscillator[gravity=0.5]"
    shorter = "timestep {0.99 * scene.step!r}"
    gates.assert_closed(
        "lammps-debian", case, "error/x", "lammps/driver.py", "timestep {scene.step!r}", shorter
    )


def test_friction_at_a_wall_is_the_same_in_each_unit_of_length(gates):
    rows = gates.friction_by_unit_of_length("lmp")
    for words in ("hooke/history", "granular, linear_history"):
        assert [found for found, _ in rows[words]] == ["0.728374"] * 5
