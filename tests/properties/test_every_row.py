"""Every case holds in the reference at settings drawn at random, and at the defaults of each case
and member that main lacks.

A draw moves each number of a case by up to half an octave, keeps three digits, and may turn what is
0 on; motions are short.
"""

import zlib
from collections.abc import Mapping

import numpy as np
import pytest

from refdem.campaign import in_process, plan
from refdem.campaign.specification import Specification, named
from refdem.core import discovery
from refdem.core.case import Canonical, Case, Instance
from refdem.core.parameters import Parameter
from refdem.core.selection import Selection
from refdem.errors import UsageError

REFERENCE = discovery.engine("reference")
SHORT = Specification(name="every row", case=[], levels=3, most_steps=1e4)
SEEDS = range(3)
DRAWS = 64
"""Sets that are drawn until one is of numbers that go together."""
TURNS = 4
"""A motion that is drawn lasts as many of its shortest times."""
CHEAP: Mapping[str, Mapping[str, str]] = {
    "granular-gas": {"n": "64", "duration": "1/2", "samples": "4"},
    "billiards": {"n": "100"},
    "logistic": {"n": "100"},
    "phase-flow": {"points": "1024"},
    "two-spheres": {"spins": "0,0,1/4,0,0,-1/8"},
}
"""Numbers that are not drawn: how much is computed, and spins whose slip leaves its plane (a proof
of minutes)."""
ENDING = {"pendulum-wheel-mass": "contact with the wheel"}
"""Cases whose motion may end where they have no law for what follows, with the words in which the
reference refuses it: such a set is drawn again."""
DEAR = 1000
"""Spheres of a gas: rows with more are the business of main and of a whole run of full."""
CASES = [
    name for name in discovery.names("cases") if not isinstance(discovery.case(name), Selection)
]


def judged(instance: Instance) -> list[str]:
    """The sentences of all that the reference does wrong there; raises AssertionError if it decides
    nothing.
    """
    truth = in_process.truth_of(instance)
    tasks = plan.tasks(SHORT, instance, (), REFERENCE, truth, truth.reason)
    records = [in_process.record_of(task) for task in tasks if task.unsupported is None]
    findings = [(record, finding) for record in records for finding in record.findings]
    wrong = [
        f"{record.id(finding)}: {finding.sentence}"
        for record, finding in findings
        if finding.outcome in ("fail", "error")
    ]
    assert wrong or any(finding.outcome == "pass" for _, finding in findings), (
        f"{instance.label}: nothing was decided"
    )
    return wrong


def drawn(parameter: Parameter, rng: np.random.Generator) -> str:
    """A value near the default, as text; "" where the case decides."""
    if parameter.choices:
        if rng.random() < 0.5:
            return str(rng.choice(parameter.choices))
        return parameter.default
    if parameter.whole or parameter.default == "":
        return parameter.default
    numbers = np.array(
        [float(number) for number in np.atleast_1d(parameter.parsed(parameter.default))]
    )
    factor = 2.0 ** rng.uniform(-0.5, 0.5, numbers.shape)
    turned_on = np.where(
        rng.random(numbers.shape) < 0.25, rng.uniform(0.0, 0.5, numbers.shape), 0.0
    )
    return ",".join(
        f"{value:.3g}" for value in np.where(numbers == 0.0, turned_on, numbers * factor)
    )


def drawn_instance(case: Canonical, seed: int) -> Instance:
    """The case at the first set drawn whose numbers go together."""
    rng = np.random.default_rng([seed, zlib.crc32(case.id.encode())])
    fixed = CHEAP.get(case.id, {})
    for _ in range(DRAWS):
        values = {p.name: drawn(p, rng) for p in case.parameters if p.name not in fixed}
        given = {name: value for name, value in values.items() if value != ""} | dict(fixed)
        given = {name: value for name, value in given.items() if value != _default(case, name)}
        try:
            if isinstance(case, Case) and "duration" not in given:
                duration = TURNS * case.at(**given).scales.tau
                given |= {"duration": f"{duration:.4g}", "samples": "16"}
            instance = case.at(**given)
        except UsageError:
            continue  # values that do not go together, or another member's
        if not ends(instance):
            return instance
    raise AssertionError(f"{case.id}: none of {DRAWS} sets drawn is accepted")


def ends(instance: Instance) -> bool:
    """True if the reference says that the motion ends before its last sample."""
    words = ENDING.get(instance.case.id)
    if words is None:
        return False
    reasons = [REFERENCE.unsupported(instance.problem, method) for method in REFERENCE.methods]
    return any(words in str(reason) for reason in reasons)


def _default(case: Canonical, name: str) -> str:
    """The default of a parameter, "" of one that the case does not declare itself."""
    return next((p.default for p in case.parameters if p.name == name), "")


def rows() -> list[str]:
    """Labels of the rows of full at the defaults of a case or of a member that main lacks; a
    nightly run has the others.
    """
    main = {instance.label for instance, _ in plan.instances(named("main"))}
    entries = [
        entry for entry in named("full").case if entry.id in CASES and set(entry.set) <= {"member"}
    ]
    cheap = [entry for entry in entries if int(float(entry.set.get("n", "0"))) <= DEAR]
    instances = [discovery.case(entry.id).at(**entry.set) for entry in cheap]
    return sorted({instance.label for instance in instances} - main)


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize("case", CASES)
def test_the_reference_holds_a_case_at_a_setting_drawn_at_random(case: str, seed: int) -> None:
    assert judged(drawn_instance(discovery.case(case), seed)) == []


@pytest.mark.parametrize("label", rows())
def test_the_reference_holds_a_row_of_full(label: str) -> None:
    from refdem.core.parameters import labelled

    name, given = labelled(label)
    assert judged(discovery.case(name).at(**given)) == []
