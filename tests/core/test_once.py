"""What is asked of an object is found once for each object, and kept no longer than it."""

import gc
import weakref

from refdem.cases.pendulum import CASE
from refdem.core.once import once_for_each, once_for_latest, once_with_arguments


def test_each_instance_has_its_own_number_which_is_computed_once():
    asked = []

    @once_for_each
    def start(instance):
        asked.append(instance)
        return instance.scene.bodies.position[0, 0]

    low = CASE.at(theta0="1/4")
    high = CASE.at(theta0="2")
    numbers = [start(instance) for instance in (low, high, low, high)]
    assert numbers == [low.scene.bodies.position[0, 0], high.scene.bodies.position[0, 0]] * 2
    assert numbers[0] != numbers[1]
    assert asked == [low, high]


def test_an_instance_that_nobody_needs_is_let_go():
    length = once_for_each(lambda instance: instance.scales.length)
    instance = CASE.at()
    assert length(instance) == instance.scales.length
    known = weakref.ref(instance)
    del instance
    gc.collect()
    assert known() is None


def test_each_argument_has_its_own_answer_which_is_computed_once():
    asked = []

    @once_with_arguments
    def moved(instance, distance):
        asked.append((instance, distance))
        return instance.scales.length + distance

    low = CASE.at(theta0="1/4")
    high = CASE.at(theta0="2")
    for _ in range(2):
        assert moved(low, 1.0) == low.scales.length + 1.0
        assert moved(low, 2.0) == low.scales.length + 2.0
        assert moved(high, 1.0) == high.scales.length + 1.0
    assert asked == [(low, 1.0), (low, 2.0), (high, 1.0)]


def test_answers_for_an_earlier_object_are_let_go():
    asked = []

    @once_for_latest
    def moved(instance, distance):
        asked.append((instance, distance))
        return instance.scales.length + distance

    low = CASE.at(theta0="1/4")
    high = CASE.at(theta0="2")
    for instance in (low, low, high, high, low):
        assert moved(instance, 1.0) == instance.scales.length + 1.0
    assert asked == [(low, 1.0), (high, 1.0), (low, 1.0)]
