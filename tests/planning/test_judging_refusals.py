"""A refusal while a run is under way: the whole scene of a program is unsupported; anything else is
an error.
"""

import pytest

from refdem.core import discovery
from refdem.core.finding import Record
from refdem.core.run import Failure, Run
from refdem.core.variant import Variant
from refdem.planning import judging, plan
from refdem.planning.plan import Task
from refdem.planning.specification import Entry, Specification

WHY = "no springs on Saturdays"


def task(engine: str, case: str = "harmonic-oscillator", **more: object) -> Task:
    """A task of the engine's first method that runs the case."""
    specification = Specification(
        name="test", case=[Entry(case)], engines=[engine], levels=3, **more
    )
    ((instance, only),) = plan.instances(specification)
    tasks = plan.tasks(specification, instance, only, discovery.engine(engine), None)
    return next(one for one in tasks if one.unsupported is None)


def judged(one: Task, refused: list[Variant], kind: str = "unsupported") -> Record:
    """What is found where some variants are refused and all others ran."""
    runs = {}
    for variant in one.variants:
        if variant.goes_on:
            continue
        request = plan.request(one, variant)
        if variant in refused:
            failure = Failure(kind=kind, sentence=WHY)
        else:
            failure = None
        trajectory, cost = (None, None) if failure else one.engine.run(request)
        runs[variant] = Run(
            key="",
            request=request,
            engine=one.engine.name,
            version="1",
            trajectory=trajectory,
            failure=failure,
            cost=cost,
        )
    return judging.record(one, "1", runs, [])


def of_runs(record: Record) -> list[tuple[str, str]]:
    return [(f.outcome, f.sentence) for f in record.findings if f.check == "run"]


def plain(one: Task) -> list[Variant]:
    return [variant for variant in one.variants if not variant.goes_on]


def test_the_reference_that_refuses_while_it_runs_is_an_error() -> None:
    one = task("reference")
    ((outcome, sentence),) = of_runs(judged(one, plain(one)))
    assert outcome == "error"
    assert WHY in sentence
    assert "before a run" in sentence


def test_a_program_that_refuses_every_run_does_not_support_the_scene() -> None:
    one = task("pymunk")
    ((outcome, sentence),) = of_runs(judged(one, plain(one)))
    assert outcome == "unsupported"
    assert WHY in sentence


@pytest.mark.parametrize("number", range(4))
def test_a_program_that_refuses_some_runs_of_a_scene_is_an_error(number: int) -> None:
    one = task("pymunk")
    changed = [v for v in plain(one) if v.change != "none"]
    chosen = [plain(one)[0], plain(one)[-1], changed[0], changed[-1]][number]
    ((outcome, sentence),) = of_runs(judged(one, [chosen]))
    assert outcome == "error"
    assert "at every step and in every variant" in sentence


def test_a_picture_that_may_be_refused_is_shown_as_unsupported(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    one = task("pymunk")
    shifted = [variant for variant in one.variants if variant.change == "shifted"]
    assert shifted
    monkeypatch.setattr(one.engine, "may_refuse", frozenset({"shifted"}))
    found = judged(one, shifted)
    assert of_runs(found) == []
    (finding,) = (f for f in found.findings if f.outcome == "unsupported")
    assert (finding.check, finding.quantity) == ("symmetry", "shifted")
    assert WHY in finding.sentence


def test_a_crash_among_refusals_is_what_is_told() -> None:
    one = task("pymunk")
    ((outcome, sentence),) = of_runs(judged(one, plain(one), kind="crash"))
    assert (outcome, "(crash)" in sentence) == ("error", True)


def test_a_check_that_was_named_alone_may_decide_nothing() -> None:
    one = task("pymunk", checks=["error"])
    found = judged(one, [])
    assert {f.outcome for f in found.findings} == {"undecided"}  # there is no truth in this test


def test_a_record_in_which_no_check_of_all_decides_anything_is_an_error() -> None:
    one = task("pymunk")
    bare = Task(
        one.engine, one.subject, None, tuple(check for check in one.checks if check.name == "error")
    )
    assert "error" in {f.outcome for f in judged(bare, []).findings}


@pytest.mark.parametrize("number", [0, -1])
def test_a_run_that_failed_is_named_before_those_not_begun_after_it(number: int) -> None:
    one = task("pymunk")
    cause = plain(one)[number]
    runs = {}
    for variant in plain(one):
        if variant == cause:
            failure = Failure(kind="hang", sentence="it was still running after 1 s")
        else:
            failure = Failure(kind="hang", sentence="it was not started", is_begun=False)
        runs[variant] = Run(
            key="",
            request=plan.request(one, variant),
            engine=one.engine.name,
            version="1",
            failure=failure,
        )
    ((outcome, sentence),) = of_runs(judging.record(one, "1", runs, []))
    assert outcome == "error"
    assert f"The run at {cause} " in sentence
    assert "still running after 1 s" in sentence
