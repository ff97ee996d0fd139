"""The campaigns hold, for every engine, settings that it can say of every case that it can say; and
every row of the catalogue.
"""

from collections.abc import Iterator
from itertools import chain

import pytest

from refdem.cases.impact_benchmarks import MEMBERS
from refdem.core import discovery
from refdem.core.case import Canonical, Instance
from refdem.core.engine import Engine
from refdem.core.parameters import Parameter
from refdem.core.selection import Selection
from refdem.errors import UsageError
from refdem.planning import plan
from refdem.planning.specification import Specification, named

ENGINES = [
    name
    for name in discovery.own_names("engines")
    if not discovery.engine(name).is_reference and discovery.engine(name).missing() is None
]
TRIED = ("0", "1/2", "1", "3")
"""Values of a number that make a scene simpler or other: nothing, a half, one, a whole odd number.
"""
CROWD = {"n": "64"}
"""A gas of few spheres has the features of one of many."""
CASES = [
    name for name in discovery.names("cases") if not isinstance(discovery.case(name), Selection)
]


def instances(*campaigns: str) -> list[Instance]:
    """Every instance that a campaign names, of a case that is none of the selections."""
    entries = list(chain.from_iterable(named(name).case for name in campaigns))
    kept = [entry for entry in entries if entry.id in CASES]
    return [instance for instance, _ in plan.instances(Specification(name="test", case=kept))]


MAIN = instances("main")
TELLING = named("gate").case
FULL = instances("full")


def values(parameter: Parameter) -> list[str]:
    """What is tried of a parameter: every choice, or a few numbers, the same for all components and
    along the last axis.
    """
    if parameter.choices:
        return list(parameter.choices)
    count = 1
    for size in parameter.shape:
        count *= size
    if count == 1:
        return list(TRIED)
    along_last = ",".join(["0"] * (count - 1) + ["1"])
    return [*(",".join([value] * count) for value in ("0", "1")), along_last]


def tried(case: Canonical) -> Iterator[Instance]:
    """The case at its defaults and at the settings of the campaigns gate and main, each as it is
    and with one parameter changed.
    """
    if case.id == "granular-gas":
        common = CROWD
    else:
        common = {}
    own = [dict(instance.p.given) for instance in MAIN if instance.case.id == case.id]
    telling = [entry.set for entry in TELLING if entry.id == case.id]
    bases = [{}, *telling, *own]
    changes = [
        {p.name: value} for p in case.parameters if p.name not in common for value in values(p)
    ]
    for given in chain(bases, ({**base, **change} for base in bases for change in changes)):
        try:
            yield case.at(**(given | common))
        except UsageError:
            continue  # values that do not go together


def says(engine: Engine, instance: Instance) -> bool:
    return any(engine.unsupported(instance.problem, method) is None for method in engine.methods)


def said(engine: Engine, among: list[Instance], case: str) -> set[str]:
    """Features of the questions of a case that the engine can say; the number of dimensions is none
    of the engine's skills.
    """
    found = (
        instance.problem.features
        for instance in among
        if instance.case.id == case and says(engine, instance)
    )
    return {
        feature
        for features in found
        for feature in features
        if not feature.startswith("dimension:")
    }


@pytest.mark.parametrize("case", CASES)
def test_what_an_engine_can_say_of_a_case_is_in_the_campaigns(case: str) -> None:
    every = list(tried(discovery.case(case)))
    for name in ENGINES:
        engine = discovery.engine(name)
        able = [instance for instance in every if says(engine, instance)]
        if not able:
            continue
        in_main = [
            instance for instance in MAIN if instance.case.id == case and says(engine, instance)
        ]
        assert in_main, (
            f"{name} can say {able[0].label}, and main has nothing of this case that it can say"
        )
        lacking = said(engine, able, case) - said(engine, FULL, case)
        shown = next(
            (instance.label for instance in able if lacking & instance.problem.features), ""
        )
        assert not lacking, (
            f"{name} can say {', '.join(sorted(lacking))} of this case, as in {shown}, and no"
            " campaign has it"
        )


@pytest.mark.parametrize("case", discovery.names("cases"))
def test_every_case_is_at_its_defaults_in_a_campaign(case: str) -> None:
    if case in CASES:
        assert discovery.case(case).at().label in {instance.label for instance in FULL}
    else:
        assert case in {entry.id for entry in named("full").case}


@pytest.mark.parametrize("member", MEMBERS)
def test_every_impact_benchmark_is_at_its_defaults_in_a_campaign(member: str) -> None:
    label = discovery.case("impact-benchmarks").at(member=member).label
    assert label in {instance.label for instance in FULL}


def test_full_has_everything_that_main_has() -> None:
    assert {instance.label for instance in MAIN} <= {instance.label for instance in FULL}


def test_a_campaign_that_includes_itself_is_refused(tmp_path) -> None:
    (tmp_path / "one.toml").write_text('include = ["two"]\n')
    (tmp_path / "two.toml").write_text('include = ["one"]\n')
    with pytest.raises(UsageError, match="includes itself"):
        named(str(tmp_path / "one.toml"))
