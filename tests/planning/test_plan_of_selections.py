"""A selection asks one check of every case: where that cannot decide, it is no error of the
engine.
"""

from dataclasses import replace

import msgspec
import pytest

from refdem.core import discovery
from refdem.faults.transparent import Transparent
from refdem.planning import plan
from refdem.planning.in_process import record_of, truth_of
from refdem.planning.specification import Specification


@pytest.mark.parametrize(
    ("is_selection", "outcomes"), [(True, {"undecided"}), (False, {"undecided", "error"})]
)
def test_a_check_that_cannot_decide_is_an_error_only_where_the_case_itself_was_asked_for(
    is_selection, outcomes
):
    instance = discovery.case("two-body-orbit").at(duration="4")
    unproved = msgspec.structs.replace(truth_of(instance), until=0)
    specification = Specification(name="test", case=[], levels=3, method="verlet")
    (task,) = plan.tasks(
        specification, instance, ("reversal",), Transparent(), unproved, "withheld"
    )
    assert task.is_selection
    record = record_of(replace(task, is_selection=is_selection))
    assert {finding.outcome for finding in record.findings} == outcomes
