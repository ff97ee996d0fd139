"""Derivatives in a CSV file are read as they are told, and what is wrong is named with its line."""

import numpy as np
import pytest

from refdem.core.sensitivities_csv import SENSITIVITY_COLUMNS, with_sensitivities
from refdem.core.trajectory import Trajectory
from refdem.errors import EngineError

ASKED = ("scene.bodies.0.mass", "scene.elements.0.stiffness")
RUN = Trajectory.of_points(np.array([0.0, 0.5]), np.zeros((2, 1, 3)), np.zeros((2, 1, 3)))
HEADER = ",".join(SENSITIVITY_COLUMNS)


def rows():
    """The lines of a right file: the k-th row tells k in every column of the place and velocity."""
    lines = [HEADER]
    for key in ASKED:
        for t in RUN.t:
            number = len(lines)
            lines.append(f"{key},{t},0," + ",".join([str(number)] * 6) + "," * 7)
    return lines


def read(tmp_path, lines):
    """The trajectory with the derivatives in a file of these lines."""
    path = tmp_path / "sensitivities.csv"
    path.write_text("\n".join(lines) + "\n")
    return with_sensitivities(RUN, path, ASKED)


def test_derivatives_are_read_by_number_and_sample(tmp_path):
    derivatives = read(tmp_path, rows()).derivatives
    assert tuple(derivatives) == ASKED
    assert derivatives[ASKED[1]].shape == (2, 1, 13)
    np.testing.assert_array_equal(derivatives[ASKED[1]][:, 0, 5], [3.0, 4.0])
    np.testing.assert_array_equal(derivatives[ASKED[1]][:, 0, 6:], 0.0)


def test_a_trajectory_keeps_its_derivatives_to_the_last_bit(tmp_path):
    run = read(tmp_path, rows())
    again = Trajectory.from_bytes(run.to_bytes())
    for key in ASKED:
        np.testing.assert_array_equal(again.derivatives[key], run.derivatives[key])


def test_nothing_is_read_where_nothing_was_asked_for(tmp_path):
    assert with_sensitivities(RUN, tmp_path / "none.csv", ()) is RUN


def test_a_file_that_is_missing_is_named_with_its_columns(tmp_path):
    with pytest.raises(EngineError, match=r"wrote no none.csv; .* number,t,body,x"):
        with_sensitivities(RUN, tmp_path / "none.csv", ASKED)


def changed(number, old, new):
    """The lines of a right file with one of them changed."""
    lines = rows()
    assert old in lines[number]
    lines[number] = lines[number].replace(old, new, 1)
    return lines


@pytest.mark.parametrize(
    ("lines", "says"),
    [
        (changed(0, "number", "parameter"), r"line 1 is 'parameter,t,.*expected number,t,body"),
        (changed(1, "mass", "inertia"), r"line 2 begins with .*expected scene.bodies.0.mass,0,0"),
        (changed(2, "0.5", "0.25"), r"line 3 begins with .*expected scene.bodies.0.mass,0.5,0"),
        (changed(4, ",0,4", ",1,4"), r"line 5 begins with .*stiffness,0.5,0: the numbers in"),
        (changed(3, "3,", "nan,"), r"line 4: x is 'nan'; expected a finite number"),
        (changed(3, "3,3", "3"), r"line 4 has 15 columns; expected 16"),
        (rows()[:-1], r"has 3 rows; expected 4: 2 numbers of 2 samples of 1 bodies"),
        ([*rows(), rows()[-1]], r"has more rows; expected 4"),
        (changed(4, ",,,,,,,", ",1,0,0,0,0,0,"), r"line 5: wz is ''; expected a finite number"),
    ],
)
def test_what_is_wrong_is_named_with_its_line(tmp_path, lines, says):
    with pytest.raises(EngineError, match=says):
        read(tmp_path, lines)
