"""Changes that samples show, and what is not told of them, by hand."""

from refdem.checks._shown_events import ShownEvent, changes, first_unreported
from refdem.core.trajectory import Event


def test_a_change_is_counted_once_from_each_state_to_the_other():
    t = [0.0, 1.0, 2.0, 3.0, 4.0, 5.0]
    before = [False, True, True, False, True, False]
    after = [True, False, False, True, False, False]
    assert changes(t, before, after) == [3.0]
    assert changes(t, after, before) == [1.0, 4.0]


def test_an_event_must_be_told_of_one_of_its_bodies_by_the_time_that_shows_it():
    first = ShownEvent("contact", 1.0, (0, 2), 1)
    second = ShownEvent("contact", 3.0, (0, 2), 2)
    shown = [second, first]
    of_first = Event(0.5, "contact", 2)
    of_second = Event(3.25, "contact", 0)
    assert first_unreported(shown, [of_first, of_second], 0.25) is None
    assert first_unreported(shown, [of_first, of_second], 0.125) == second
    assert first_unreported(shown, [Event(0.5, "contact", 1), of_second], 0.25) == first
