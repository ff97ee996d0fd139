"""Which methods of the reference answer each problem of the main campaign: one that refuses
unawares would be missed by nobody.

A wrong formula can make a method refuse its own scene; another method then answers, and every
verdict is green. So the answers are kept beside this test. After a change that is meant: `python
tests/engines/test_reference_answers.py`, and commit answers.csv.
"""

import csv
from pathlib import Path

from refdem.campaign import plan
from refdem.campaign.specification import named
from refdem.engines.reference import ENGINE

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
    found = answers()
    changed = {
        label: (kept.get(label), found.get(label))
        for label in kept.keys() | found.keys()
        if kept.get(label) != found.get(label)
    }
    assert not changed, f"label: (kept, found) = {changed}"
    assert all(found.values())


if __name__ == "__main__":
    with KEPT.open("w", newline="") as out:
        csv.writer(out, lineterminator="\n").writerows(sorted(answers().items()))
