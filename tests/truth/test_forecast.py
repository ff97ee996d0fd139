"""A proof that is dear says so before it is worked for: counted in pieces, no clock."""

from contextlib import suppress
from fractions import Fraction

import pytest

from refdem.core import discovery
from refdem.core.selection import Selection
from refdem.errors import RefdemError
from refdem.truth.contact_motion import ContactMotion
from refdem.truth.events.motion import HybridMotion
from refdem.truth.forecast import FAR_BEYOND, FEW_PIECES, HOPELESS, PIECES, Course, told_to
from refdem.truth.validated_ivp.integration import Chain

FAR = 10_000
"""Shortest times tau: no integration gets there in a few pieces."""
ROUGH = 2
"""Pieces within which the first forecast must have come."""
CHEAP = 512
"""Pieces that no forecast need announce: seconds at 40 digits."""
CASES = [
    name for name in discovery.names("cases") if not isinstance(discovery.case(name), Selection)
]


class HeardError(Exception):
    """A forecast has been told."""


class TooMuchError(AssertionError):
    """Work that nothing announced."""


@pytest.fixture
def pieces(monkeypatch):
    """How many pieces of integrations are made; more than CHEAP are TooMuchError."""
    made = [0]

    def counted(step):
        def one(chain):
            made[0] += 1
            if made[0] > CHEAP:
                raise TooMuchError
            return step(chain)

        return one

    for motion, name in (
        (Chain, "advance"),
        (HybridMotion, "follow"),
        (ContactMotion, "follow"),
    ):
        monkeypatch.setattr(motion, name, counted(getattr(motion, name)))
    return made


def heard(seconds):
    raise HeardError


@pytest.mark.parametrize("name", CASES)
def test_of_any_case_a_far_time_is_forecast_after_the_first_pieces_or_is_cheap(name, pieces):
    instance = discovery.case(name).at()
    truth = instance.truth()
    t = Fraction(FAR * instance.scales.tau).limit_denominator(1)
    try:
        with told_to(heard):
            truth.forecast(t, 40)
        truth.at(t)
    except HeardError:
        assert pieces[0] <= ROUGH
    except RefdemError:
        # A refusal is an answer: the counter says that it came soon.
        pass


@pytest.mark.parametrize("name", CASES)
def test_of_any_case_the_values_without_a_time_are_cheap(name, pieces):
    truth = discovery.case(name).at().truth()
    with suppress(RefdemError):
        truth.scalars()
    assert pieces[0] <= CHEAP


def test_forecasts_are_told_at_every_doubling_and_to_nobody_afterwards():
    told = []
    truth = discovery.truth_of("van-der-pol")
    with told_to(told.append):
        truth.forecast(Fraction(40), 40)
    flow = next(flow for key, flow in truth.kept.items() if key[0] == "integration")
    heard_of = len(told)
    # After pieces 1, 2, 4, 8, 16 and so on.
    assert heard_of == len(flow.pieces).bit_length()
    truth.forecast(Fraction(80), 40)
    assert len(told) == heard_of


def test_what_nobody_can_wait_for_is_believed_after_few_pieces_and_a_jerk_at_the_start_is_not():
    is_enough = Course(100).is_enough
    assert is_enough(FEW_PIECES, 1e9, 1.1 * FAR_BEYOND * HOPELESS)
    assert not is_enough(FEW_PIECES, 1e9, 0.9 * FAR_BEYOND * HOPELESS)
    assert not is_enough(FEW_PIECES - 1, 1e9, 1.1 * FAR_BEYOND * HOPELESS)
    assert is_enough(PIECES, 1e9, 1.1 * HOPELESS)
    assert not is_enough(PIECES, 1e9, 0.9 * HOPELESS)
