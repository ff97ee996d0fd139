"""Which part of the kill matrix a change runs in continuous integration: never less than it can
touch.
"""

import pytest
from touched_faults import touched

from refdem.faults.catalogue import faults
from refdem.faults.catalogue.lever import FAULTS as LEVER


def test_pages_tests_and_kernels_touch_no_fault():
    assert (
        touched(
            ["README.md", "tests/core/test_truth.py", "refdem/kernels/gas.c", "refdem/cli/run.py"]
        )
        == set()
    )


def test_a_file_of_the_catalogue_touches_its_faults():
    assert touched(["refdem/faults/catalogue/lever.py"]) == {fault.name for fault in LEVER}


def test_a_check_touches_the_faults_that_are_named_for_it():
    seen = {fault.name for fault in faults() if fault.sees[0] == "second-integral"}
    assert seen
    assert touched(["refdem/checks/second_integral.py"]) == seen


def test_a_case_touches_the_faults_that_act_on_it():
    assert {"no-gyroscopic-term", "torque-in-space-axes"} & {
        fault.name for fault in faults()
    } <= touched(["refdem/cases/free_rigid_body.py"])


@pytest.mark.parametrize(
    "file",
    [
        "refdem/core/check.py",
        "refdem/faults/transparent.py",
        "refdem/truth/balls.py",
        "refdem/checks/__init__.py",
    ],
)
def test_what_every_fault_goes_through_touches_them_all(file):
    assert touched([file]) is None
