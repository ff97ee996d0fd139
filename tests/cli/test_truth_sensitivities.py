"""`refdem truth --sensitivities` prints derivatives with radii, as a table and as JSON."""

import json
from fractions import Fraction


def test_the_table_has_a_line_for_each_quantity_and_number(command_line):
    done = command_line("truth", "quadratic-drag", "--sensitivities", "--at", "1", "--digits", "12")
    assert done.returncode == 0, done.stderr
    lines = done.stdout.splitlines()
    assert len(lines) == 2 * 4
    assert any(line.startswith("d v(1)/d drag ") and "(m/s)/(kg/m)" in line for line in lines)


def test_json_has_the_exact_values_of_a_motion_without_forces(command_line):
    """x = x0 cos w t, so that dx/dx0 = cos w t = cos 1."""
    arguments = ("--set", "mass=1", "--set", "stiffness=1", "--at", "1", "--json")
    done = command_line("truth", "harmonic-oscillator", "--sensitivities", *arguments)
    assert done.returncode == 0, done.stderr
    document = json.loads(done.stdout)
    (row,) = [
        row for row in document["sensitivities"] if (row["quantity"], row["by"]) == ("x", "x0")
    ]
    cosine = Fraction("0.5403023058681397174009366074429766037323")
    assert abs(Fraction(row["mid"]) - cosine) <= Fraction(row["radius"]) + Fraction(1, 10**40)
    assert Fraction(row["radius"]) < Fraction(1, 10**38)
    assert document["missing"] == {}


def test_a_border_is_told_and_the_rest_is_there(command_line):
    done = command_line("truth", "coulomb-oscillator", "--sensitivities", "--at", "5/2")
    assert done.returncode == 0
    assert "no derivative by v0: differences of certified values tend to" in done.stderr
    assert "d x(5/2)/d mass" in done.stdout
    by_v0 = [line for line in done.stdout.splitlines() if "/d v0" in line]
    assert all(", beside it at v0 = " in line for line in by_v0)
    # It moves to one side or the other: both sides have a derivative of either quantity.
    assert len(by_v0) == 4
    assert "no quantity depends on gravity at these times" in done.stderr


def test_a_case_without_time_needs_none(command_line):
    """The mass rho a b c of a box, by a."""
    done = command_line("truth", "moments-of-inertia", "--sensitivities", "--digits", "12")
    assert done.returncode == 0, done.stderr
    (line,) = (one for one in done.stdout.splitlines() if one.startswith("d cuboid.mass(0)/d a "))
    assert line.split()[3] == "3.00000000000000000"


def test_without_a_time_and_without_a_formula_it_says_so(command_line):
    done = command_line("truth", "pendulum", "--sensitivities")
    assert done.returncode == 2
    assert "--sensitivities needs times" in done.stderr
    done = command_line("truth", "granular-gas", "--sensitivities", "--at", "3")
    assert done.returncode != 0
    assert "the motion is chaotic" in done.stderr
    assert "Traceback" not in done.stderr
