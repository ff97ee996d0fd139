"""The family of impact benchmarks: every member is found, held by the reference, and takes its own
parameters alone.
"""

import msgspec
import pytest

from refdem.cases.impact_benchmarks import MEMBERS
from refdem.core import discovery
from refdem.core.parameters import labelled
from refdem.core.problem import Motion
from refdem.errors import UsageError
from refdem.planning.in_process import record_of, task_of, truth_of

REFERENCE = discovery.engine("reference")
METHODS = {
    "co-1": "exact-hertz",
    **dict.fromkeys(("co-2", "dem-05-hertz", "dem-05-mindlin"), "exact-hertz-wall"),
    **dict.fromkeys(("co-7", "co-8"), "oblique-contact"),
}
"""The cheapest of the reference, where it is not contact-events."""


def test_the_members_are_those_of_chung_and_ooi_and_of_mfix():
    others = {
        "dem-05-hertz",
        "dem-05-mindlin",
        "three-spheres",
        "contact-path",
        "contact-path-turned",
    }
    assert {f"co-{n}" for n in range(1, 9)} | {f"dem-0{n}" for n in range(1, 6)} | others == set(
        MEMBERS
    )


def test_a_label_may_name_the_member_alone():
    assert labelled("impact-benchmarks[co-4]") == ("impact-benchmarks", {"member": "co-4"})
    assert labelled("impact-benchmarks[dem-05 angle=1]") == (
        "impact-benchmarks",
        {"member": "dem-05", "angle": "1"},
    )
    with pytest.raises(UsageError, match="expected name=value"):
        labelled("impact-benchmarks[angle=1 dem-05]")


@pytest.mark.parametrize("member", MEMBERS)
def test_the_reference_holds_every_member(member):
    instance = discovery.case("impact-benchmarks").at(member=member)
    method = REFERENCE.best(instance.problem).name
    assert method == METHODS.get(member, "contact-events")
    record = record_of(task_of(REFERENCE, method, instance, truth_of(instance), 1))
    assert msgspec.msgpack.encode(record)
    findings = record.findings
    assert [f.sentence for f in findings if f.outcome not in ("pass", "unsupported")] == []
    assert sum(f.check == "error" for f in findings) == len(instance.quantities)


@pytest.mark.parametrize(
    ("given", "word"),
    [
        ({"member": "co-1", "friction": "0.1"}, "friction"),
        ({"member": "dem-04", "restitution": "1"}, "restitution"),
        ({"member": "dem-02", "height": "0.1"}, "height"),
        ({"member": "dem-03", "height": "0.01"}, "height"),
        ({"member": "co-9"}, "member"),
    ],
)
def test_what_a_member_does_not_have_is_refused_by_name(given, word):
    with pytest.raises(UsageError, match=word):
        discovery.case("impact-benchmarks").at(**given)


def test_hertz_on_a_wall_is_refused_where_the_closed_form_ends():
    solver = next(method for method in REFERENCE.methods if method.name == "exact-hertz-wall")
    instance = discovery.case("impact-benchmarks").at(member="dem-05-hertz")
    bodies = instance.scene.bodies
    assert REFERENCE.unsupported_motion(instance.problem, solver) is None
    for changed in ({"position": bodies.position * 0.99}, {"omega": [[0.0, 1.0, 0.0]]}):
        scene = type(instance.scene)(bodies.with_state(**changed), instance.scene.elements)
        assert REFERENCE.unsupported_motion(Motion(scene, instance.times), solver) is not None
    assert REFERENCE.unsupported_motion(Motion(instance.scene, -instance.times), solver) is not None


@pytest.mark.parametrize("name", ["mujoco", "pymunk", "rebound"])
def test_no_engine_pretends_to_rub_by_a_spring(name):
    engine = discovery.engine(name)
    problem = discovery.case("impact-benchmarks").at(member="co-4").problem
    assert all(engine.unsupported_motion(problem, method) for method in engine.methods)
