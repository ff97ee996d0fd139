"""Requests: steps divide samples, times are exact, keys change with everything that matters."""

import json

import numpy as np
import pytest

from refdem.core.problem import Motion, Request
from refdem.core.request_text import request_text
from refdem.errors import EngineError, UsageError
from refdem.scene import Body, Scene
from refdem.scene.elements.spring import Spring


def request_of(step=0.125, stiffness=1.0, **more):
    scene = Scene.of([Body(mass=1.0, position=(1.0, 0.0, 0.0))], [Spring(a=0, stiffness=stiffness)])
    return Request(problem=Motion(scene, np.arange(5) * 0.5), method="m", step=step, **more)


def test_stride_counts_steps_from_sample_to_sample():
    assert request_of(0.125).stride == 4


@pytest.mark.parametrize("step", [0.3, 1.0])
def test_a_step_that_does_not_divide_the_samples_is_refused(step):
    with pytest.raises(UsageError, match="whole fraction"):
        _ = request_of(step).stride


@pytest.mark.parametrize("step", [0.0, -1.0, float("nan"), float("inf")])
def test_a_step_that_is_no_step_is_refused(step):
    with pytest.raises(UsageError, match="step"):
        request_of(step)


def test_the_key_changes_with_scene_step_repeat_and_engine():
    keys = {
        request_of().key("e"),
        request_of(stiffness=np.nextafter(1.0, 2)).key("e"),
        request_of(0.25).key("e"),
        request_of(repeat=1).key("e"),
        request_of().key("f"),
    }
    assert len(keys) == 5
    assert request_of().key("e") == request_of().key("e")


def test_json_reads_back_to_the_same_key():
    request = request_of(step=0.1 / 3)
    assert Request.from_json(request.to_json()).key("e") == request.key("e")


def test_time_that_is_off_is_refused_with_the_sample():
    times = request_of().problem.times.copy()
    times[3] += 1e-6
    with pytest.raises(EngineError, match=r"t\[3\]"):
        request_of().refuse_misaligned(times)
    with pytest.raises(EngineError, match="4 samples"):
        request_of().refuse_misaligned(times[:4])


def test_a_clock_in_single_precision_is_off_by_its_round_off_and_no_more():
    times = request_of().problem.times
    single = times.astype(np.float32).astype(float) * (1 + 2.0**-24)
    with pytest.raises(EngineError):
        request_of().refuse_misaligned(single)
    request_of().refuse_misaligned(single, 2.0**-24)
    with pytest.raises(EngineError):
        request_of().refuse_misaligned(times * (1 + 2.0**-20), 2.0**-24)


def test_times_that_go_nowhere_are_refused():
    with pytest.raises(UsageError, match="rising or all falling"):
        Motion(request_of().problem.scene, np.array([0.0, 1.0, 1.0]))


def test_a_clock_that_adds_up_its_steps_is_read_and_one_that_loses_a_step_is_not():
    fine = request_of(step=0.5 / 65536)
    times = fine.problem.times
    steps = fine.stride * (len(times) - 1)
    fine.refuse_misaligned(times * (1 + 0.9 * steps * 2.0**-53))
    with pytest.raises(EngineError, match="the sample that was asked for"):
        fine.refuse_misaligned(times * (1 + 1 / steps))


def test_a_request_says_how_many_steps_lie_between_samples():
    assert json.loads(request_of(0.125).to_json())["stride"] == 4
    assert "\nstride 4\n" in request_text(request_of(0.125))
    assert json.loads(request_of(None, tolerance=1e-6).to_json())["stride"] is None
    assert "stride" not in request_text(request_of(None, tolerance=1e-6))


def test_a_request_whose_stride_is_not_that_of_its_step_is_refused():
    text = request_of(0.125).to_json().replace(b'"stride":4', b'"stride":5')
    with pytest.raises(UsageError, match="stride is 5; expected 4"):
        Request.from_json(text)


@pytest.mark.parametrize("change", ["rescaled", "delayed", "reversed", "falling", "denser"])
def test_the_stride_is_the_same_whole_number_however_the_run_is_varied(change):
    rescale = 3.0 + 2.0**-24
    interval = 20 / 64 * (1 + 2.0**-19)  # 20 bits, as samples have
    times = interval * np.arange(65)
    varied = {
        "rescaled": (rescale * times, rescale * interval / 96),
        "delayed": (times + 16 * interval, interval / 96),
        "reversed": (times, interval / 96),
        "falling": (times[::-1], interval / 96),
        "denser": (interval / 4 * np.arange(257), interval / (4 * 96)),
    }
    shown, step = varied[change]
    assert (
        Request(problem=Motion(request_of().problem.scene, shown), method="m", step=step).stride
        == 96
    )


def test_samples_that_are_not_evenly_spaced_have_no_stride():
    uneven = Motion(request_of().problem.scene, np.array([0.0, 0.5, 1.25, 1.5]))
    request = Request(problem=uneven, method="m", step=0.125)
    with pytest.raises(UsageError, match=r"times\[2\] is 1.25 s; expected 1 s"):
        _ = request.stride
    assert json.loads(Request(problem=uneven, method="m", tolerance=1e-6).to_json())["times"] == [
        0.0,
        0.5,
        1.25,
        1.5,
    ]


def test_a_clock_that_is_off_by_a_step_is_told_to_count():
    request = request_of(0.125)
    times = request.problem.times.copy()
    times[3:] += 0.125
    with pytest.raises(
        EngineError,
        match="took 1 step too many on the way: count `stride` steps from each sample to the next",
    ):
        request.refuse_misaligned(times)
    with pytest.raises(EngineError, match="2 steps too few"):
        request.refuse_misaligned(request.problem.times - np.array([0.0, 0.0, 0.0, 0.0, 0.25]))
    with pytest.raises(EngineError) as all_late:
        request.refuse_misaligned(request.problem.times + 0.125)
    assert "count" not in str(all_late.value)
