"""Every case holds in the reference and in every other engine at settings drawn at random, and in
the reference at the defaults of each case and member that main lacks.

A draw multiplies or divides each number of a case by up to REFDEM_SPREAD (3), keeps three digits,
and may turn what is 0 on; motions are short. An engine that fails there is wrong, or the check is:
`make alarms` looks at many seeds, REFDEM_SEEDS="first:last", and a test here at one.
"""

import os
import zlib
from collections.abc import Mapping

import msgspec
import numpy as np
import pytest

from refdem.core import discovery
from refdem.core.case import Canonical, Case, Instance
from refdem.core.engine import Engine
from refdem.core.finding import Finding, Record
from refdem.core.parameters import Parameter
from refdem.core.selection import Selection
from refdem.errors import UsageError
from refdem.planning import deviations, in_process, plan
from refdem.planning.specification import Specification, named

REFERENCE = discovery.engine("reference")
SHORT = Specification(name="every row", case=[], levels=3, most_steps=1e4)
FIRST_SEED, LAST_SEED = (int(number) for number in os.environ.get("REFDEM_SEEDS", "0:0").split(":"))
SEEDS = range(FIRST_SEED, LAST_SEED + 1)
SPREAD = float(os.environ.get("REFDEM_SPREAD", "3"))
"""Largest factor between a number that is drawn and its default."""
DRAWS = 64
"""Sets that are drawn until one is of numbers that go together."""
TURNS = 4
"""A motion that is drawn lasts as many of its shortest times."""
CHEAP: Mapping[str, Mapping[str, str]] = {
    "granular-gas": {"n": "64", "duration": "1/2", "samples": "4"},
    "billiards": {"n": "100"},
    "logistic": {"n": "100"},
    "lorenz": {"n": "32"},
    "phase-flow": {"points": "1024"},
    "two-spheres": {"spins": "0,0,1/4,0,0,-1/8"},
}
"""Numbers that are not drawn: how much is computed, and spins whose slip leaves its plane (a proof
of minutes)."""
ENDING = {"pendulum-wheel-mass": "contact with the wheel"}
"""Cases whose motion may end where they have no law for what follows, with the words in which the
reference refuses it: such a set is drawn again."""
KNOWN = {
    # A body that nearly stops on the belt: whether it sticks is decided within a step.
    ("stick-slip", "pymunk", "semi-implicit-euler", "error"),
    # Two runs of ias15 differ by up to 1.2e-13 of the scale, twice the round-off of these motions.
    ("quadratic-response", "rebound", "ias15", "symmetry"),
    ("viscous-oscillator", "rebound", "ias15", "symmetry"),
}
"""Case, engine, method and check of limits that the settings of campaigns do not show, so that
validation/expected has no row for them.
"""
DEAR = 1000
"""Spheres of a gas: rows with more are the business of main and of a whole run of full."""
CASES = [
    name for name in discovery.names("cases") if not isinstance(discovery.case(name), Selection)
]


ENGINES = [name for name in discovery.names("engines") if discovery.engine(name).missing() is None]


def judged(instance: Instance, engine: Engine = REFERENCE) -> list[str]:
    """The sentences of all that an engine does wrong there; raises AssertionError if the reference
    decides nothing.
    """
    truth = in_process.truth_of(instance)
    tasks = plan.tasks(SHORT, instance, (), engine, truth, truth.reason)
    records = [in_process.record_of(task) for task in tasks if task.unsupported is None]
    findings = [(record, finding) for record in records for finding in record.findings]
    wrong = [
        f"{record.id(finding)}: {finding.sentence}"
        for record, finding in findings
        if finding.outcome in ("fail", "error") and not is_known(engine, record, finding)
    ]
    is_decided = any(finding.outcome == "pass" for _, finding in findings)
    assert wrong or is_decided or not engine.is_reference, f"{instance.label}: nothing was decided"
    return wrong


def is_known(engine: Engine, record: Record, finding: Finding) -> bool:
    """True if the engine is expected to fail in this quantity of the case at some parameters, or if
    its limit there is known and has no row, because the settings of campaigns do not show it.
    """
    if (record.case, engine.name, record.method, finding.check) in KNOWN:
        return True
    return any(
        msgspec.structs.replace(deviation, parameters="*").covers(record, finding)
        for deviation in deviations.of_engine(engine)
    )


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
    factor = SPREAD ** rng.uniform(-1.0, 1.0, numbers.shape)
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
def test_every_engine_holds_a_case_at_a_setting_drawn_at_random(case: str, seed: int) -> None:
    instance = drawn_instance(discovery.case(case), seed)
    wrong = {name: judged(instance, discovery.engine(name)) for name in ENGINES}
    assert wrong == {name: [] for name in ENGINES}


@pytest.mark.parametrize("label", rows())
def test_the_reference_holds_a_row_of_full(label: str) -> None:
    from refdem.core.parameters import labelled

    name, given = labelled(label)
    assert judged(discovery.case(name).at(**given)) == []
