"""Springs that harden and that soften have their folds, and what has none is refused."""

import pytest

from refdem.core import discovery
from refdem.errors import UsageError

SOFTENING = {"beta": "-1/20", "delta": "1/50", "f0": "1/10"}


def certified(**given: str) -> dict[str, float]:
    scalars = discovery.case("bifurcations").at(**given).truth().scalars()
    return {name: float(ball.mid) for name, ball in scalars.items()}


def test_a_spring_that_hardens_leans_up_and_one_that_softens_leans_down() -> None:
    hardening = certified()
    softening = certified(**SOFTENING)
    # The linear resonance is at 1 rad/s.
    assert 1 < hardening["lower-fold.0"] < hardening["upper-fold.0"]
    assert hardening["lower-fold.1"] < hardening["upper-fold.1"]
    assert softening["lower-fold.0"] < softening["upper-fold.0"] < 1
    assert softening["lower-fold.1"] > softening["upper-fold.1"]


@pytest.mark.parametrize(
    ("given", "parameter"),
    [
        ({"beta": "0"}, "beta"),
        ({**SOFTENING, "f0": "3/10"}, "delta"),
        ({**SOFTENING, "delta": "1/10", "amplitude": "1/4"}, "delta"),
        ({**SOFTENING, "amplitude": "4"}, "amplitude"),
    ],
)
def test_what_has_no_folds_is_refused(given: dict[str, str], parameter: str) -> None:
    with pytest.raises(UsageError, match=f"parameter {parameter}: "):
        discovery.case("bifurcations").at(**given)
