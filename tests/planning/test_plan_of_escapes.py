"""A motion that is infinite before its last sample is nobody's fault: no engine is asked for it."""

from refdem.core import discovery
from refdem.planning import plan
from refdem.planning.in_process import truth_of
from refdem.planning.specification import Specification

ESCAPES = {"beta": "-0.351", "v0": "0.77", "samples": "16"}
SHORT = Specification(name="escape", case=[], levels=3)


def reasons(duration: str) -> dict[str, str | None]:
    """Why engines are not asked for Duffing's oscillator with a spring that yields, by method."""
    instance = discovery.case("driven-duffing").at(duration=duration, **ESCAPES)
    truth = truth_of(instance)
    engine = discovery.engine("pymunk")
    tasks = plan.tasks(SHORT, instance, (), engine, truth, truth.reason)
    return {task.method.name: task.unsupported for task in tasks}


def test_a_motion_that_escapes_before_its_last_sample_is_not_asked_for():
    for reason in reasons("3.502").values():
        assert "does not last until its last sample" in reason
        assert "the motion is infinite before t = 2.4515" in reason


def test_a_motion_that_ends_before_its_escape_is_asked_for():
    assert None in reasons("2").values()
