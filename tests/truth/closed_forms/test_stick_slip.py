"""Stick-slip: literals of an independent integration, the belt held exactly, wrong formulas
planted, precision that grows.
"""

from fractions import Fraction

import numpy as np
import pytest

from refdem.core import discovery
from refdem.errors import NotCertifiedError
from refdem.truth.closed_forms import stick_slip

# mpmath.odefun (Taylor, 40 digits) phase by phase, events by Anderson's regula falsi; 34 digits
# printed
LITERALS = {
    (("duration", "20"),): {
        3: ("0.4942459170649548495864160001141798", "-0.9395797617063486585420679413572676"),
        10: ("0.26186269121346567834294896026515", "-1.683604675599681668308377994234081"),
        20: ("-2.628787449209600476511980534676059", "1"),
        "stick_1": "5.368781403217035023079635363406621",
        "slip_1": "7.706348370983677569193205146825317",
        "slip_2": "15.3458261421672319052747461919198",
        "stick_3": "19.86946878917688597154097832435835",
    },
    (
        ("friction_law", "linear"),
        ("gamma", "2"),
        ("eta", "5/4"),
        ("x0", "1"),
        ("v0", "2"),
        ("duration", "16"),
    ): {
        3: ("-1.056111948152082554820675357540388", "-4.714483598097687931652532209473606"),
        10: ("0.9664721152918132125094205774454065", "1"),
        16: ("-2.625482597355539057650827162312357", "2.650822703904852002904839710048684"),
        "stick_1": "0.2262075031169417224909077201355726",
        "cross_1": "4.529709414927973580435100959673431",
        "slip_3": "11.13274040318144382164149503920305",
        "cross_2": "14.59643109112225753240793466413748",
    },
    (
        ("a", "4"),
        ("mu0", "0.3"),
        ("mu1", "0.15"),
        ("lambda0", "2"),
        ("lambda1", "0.05"),
        ("belt", "-0.5"),
        ("gamma", "3"),
        ("eta", "1.6"),
        ("x0", "-1"),
        ("v0", "0.25"),
        ("duration", "12"),
    ): {
        # Before any event: what goes wrong at once is seen before it goes to infinity.
        1: ("-0.177610086911473074647612551007337", "0.6774004185498456167942897468080859"),
        7: ("-2.403065226026426987747057442849965", "-1.543304318789409553535817208179646"),
        12: ("-2.075566117231000843020066276347243", "1.994162294225159294291541634697936"),
        "cross_1": "1.409897294633285898312590089394196",
        "cross_6": "11.17457998099115350268313048098453",
    },
}


def truth_of(**given):
    """The truth at parameters."""
    return discovery.case("stick-slip").at(**given).truth()


def agreement(given):
    """Every literal of a set lies in its ball, to its last printed digits; the earliest first."""
    truth = truth_of(**dict(given))
    for where, said in LITERALS[given].items():
        if isinstance(where, str):
            found = [truth.scalars()[where]]
        else:
            found = truth.at(Fraction(where)).values()
        for ball, text in zip(found, [said] if isinstance(where, str) else said, strict=True):
            assert abs(ball.mid - Fraction(text)) <= Fraction(1, 10**32)
            assert ball.radius < Fraction(1, 10**40)


def every_agreement():
    """All sets, the last first: it crosses the belt without sticking."""
    for given in reversed(LITERALS):
        agreement(given)


@pytest.mark.parametrize("given", LITERALS, ids=lambda given: given[0][1])
def test_literals_of_an_independent_integration_agree(given):
    agreement(given)


def doubled(name):
    """A friction law with one number wrong by a part in a thousand."""
    plain = stick_slip.StickSlip.friction

    def friction(self, speed):
        from dataclasses import replace

        return plain(replace(self, **{name: getattr(self, name) * Fraction(1001, 1000)}), speed)

    return friction


def no_constant(self, y):
    """The belt's steady pull is forgotten."""
    return self.gamma * (self.eta * y[2]).cos() - y[0]


def sine(self, y):
    """The drive is a sine."""
    return self.gamma * (self.eta * y[2]).sin() - y[0] - self.friction(abs(self.belt))


def always_sticks(self, y):
    """Whatever the pull, it sticks."""
    return stick_slip.Entry("stick", stick_slip.on_belt)


WRONG = {
    **{
        f"{name} off by 1e-3": ("friction", doubled(name)) for name in ("mu1", "lambda0", "lambda1")
    },
    "no steady pull": ("pull", no_constant),
    "sine for cosine": ("pull", sine),
    "sticks whatever the pull": ("landing", always_sticks),
    "friction drives": ("slipping", lambda self, side: SLIPPING(self, -side)),
    "limit a tenth too high": ("limit", property(lambda self: self.a * self.mu0 * 11 / 10)),
}
SLIPPING = stick_slip.StickSlip.slipping


@pytest.mark.parametrize("wrong", WRONG)
def test_a_wrong_formula_is_seen(wrong, monkeypatch):
    monkeypatch.setattr(stick_slip.StickSlip, *WRONG[wrong])
    with pytest.raises((AssertionError, NotCertifiedError, ValueError)):
        every_agreement()


def test_a_start_on_the_belt_sticks_if_the_pull_is_within_the_limit_and_slips_if_not():
    assert truth_of(v0="1", duration="1").at(Fraction(1, 2))["v"].mid == 1
    assert list(truth_of(v0="1", duration="2").scalars()) == ["slip_1"]
    assert abs(truth_of(v0="1", x0="3", duration="1").at(Fraction(1, 2))["v"].mid - 1) > Fraction(
        1, 10
    )


def test_a_start_exactly_at_the_limit_goes_where_the_pull_goes():
    # P = gamma - x0 - a mu(belt) = -a mu0 at x0 = gamma + a (mu0 - mu(belt)); the belt drags it
    # further: it is released at once
    edge = Fraction(1, 2) + 4 - 10 * (Fraction(3, 10) / Fraction(242, 100) + Fraction(11, 100))
    assert truth_of(v0="1", x0=str(edge), duration="1").at(Fraction(1, 2))["v"].mid < Fraction(
        99, 100
    )
    other = Fraction(1, 2) - 4 - 10 * (Fraction(3, 10) / Fraction(242, 100) + Fraction(11, 100))
    assert truth_of(v0="1", x0=str(other), duration="1").at(Fraction(1, 2))["v"].mid == 1
    with pytest.raises(NotCertifiedError) as told:
        truth_of(v0="0", belt="0", x0="1/2", gamma="1/2", duration="1").at(Fraction(1, 2))
    assert told.value.code == "corner"


def test_more_digits_are_balls_inside_the_first():
    for digits in (20, 60):
        sharper = truth_of().refined(digits).at(Fraction(7))
        plain = truth_of().at(Fraction(7))
        assert all(ball.radius < Fraction(1, 10**digits) for ball in sharper.values())
        assert all(
            abs(sharper[name].mid - ball.mid) <= ball.radius + sharper[name].radius
            for name, ball in plain.items()
        )


def test_sensitivity_is_the_growth_of_a_displaced_start():
    truth = truth_of()
    step = Fraction(1, 2**60)
    for t in (Fraction(4), Fraction(9)):
        moved = truth_of(x0=str(step)).at(t), truth_of(v0=str(step)).at(t)
        length = float(truth.scale["x"])
        speed = float(truth.scale["v"])
        rows = [
            sum(
                abs(float((one[name].mid - truth.at(t)[name].mid) / step)) * size
                for one, size in zip(moved, (length, speed), strict=True)
            )
            / float(truth.scale[name])
            for name in ("x", "v")
        ]
        assert max(1, *rows) <= truth.sensitivity(t) * (1 + 1e-6)


def test_errors_made_while_it_sticks_forget_the_velocity():
    truth = truth_of()
    grown = truth.sensitivities([Fraction(n) for n in range(0, 21, 2)])
    assert all(
        later >= truth.sensitivity(Fraction(n)) * (1 - 1e-9)
        for n, later in zip(range(0, 21, 2), grown, strict=True)
    )
    assert np.all(np.isfinite(grown))
