"""Which methods of the reference answer each problem of the main campaign: one that refuses
unawares would be missed by nobody.

A wrong formula can make a method refuse its own scene; another method then answers, and every
verdict is green. So the answers are kept beside this test. After a change that is meant, run
`python tests/engines/test_reference_answers.py` and commit answers.csv. A problem or a method that
is not in that file is new and has tests of its own; here only some method must answer it.
"""

import csv
from pathlib import Path

from refdem.engines.reference import ENGINE
from refdem.planning import plan
from refdem.planning.specification import named

TESTS = Path(__file__).parents[1]
KEPT = Path(__file__).with_name("answers.csv")


def answers() -> dict[str, str]:
    """By label of the problem, the methods that answer, cheapest first."""
    found = {}
    for instance, _ in plan.instances(named("main")):
        answering = [
            method.name
            for method in ENGINE.methods
            if ENGINE.unsupported(instance.problem, method) is None
        ]
        found[instance.label] = " ".join(answering)
    return found


def test_every_method_answers_what_it_answered() -> None:
    with KEPT.open(newline="") as file:
        kept = dict(csv.reader(file))
    known = set(" ".join(kept.values()).split())
    found = answers()
    changed = {}
    for label, before in kept.items():
        now = [method for method in found.get(label, "").split() if method in known]
        if " ".join(now) != before:
            changed[label] = (before, found.get(label))
    assert not changed, f"label: (kept, found) = {changed}"
    assert all(found.values())


def test_every_method_answers_something_that_is_kept_or_has_tests_of_its_own() -> None:
    with KEPT.open(newline="") as file:
        known = set(" ".join(dict(csv.reader(file)).values()).split())
    for method in ENGINE.methods:
        own = f"test_{method.name.replace('-', '_')}.py"
        assert method.name in known or list(TESTS.rglob(own)), method.name


if __name__ == "__main__":
    with KEPT.open("w", newline="") as out:
        csv.writer(out, lineterminator="\n").writerows(sorted(answers().items()))
