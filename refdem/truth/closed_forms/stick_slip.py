"""A mass on a spring with friction on a moving belt (1.125):

    x'' in gamma cos(eta t) - x - a mu(|belt|) - a mu(|u|) Sgn(u),    u = x' - belt,

with the friction a mu(w) = a ((mu0 - mu1)/(1 + lambda0 w) + mu1 + lambda1 w^2) (or lambda1 w).

Modes: the mass slips forward (u > 0), backward (u < 0), or sticks (u = 0), which is possible while
|P| <= a mu0 with the pull P = gamma cos(eta t) - x - a mu(|belt|). A forward slip that follows a
stick begins with a double zero of u: there u' = P - a mu0 = 0 and u'' = P' > 0. On a belt at rest x
is constant while the mass sticks, so that the time of release, if any, is an arc cosine.

A state y is (x, u, t): the clock t is a coordinate, because the drive depends on it. An `Entry` has
the mode that begins, its initial state, and, for each guard that vanishes there, the order of its
zero.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction
from functools import partial
from typing import Any

from flint import arb

from refdem.core.parameters import Parameters
from refdem.core.truth import Ball, Truth
from refdem.errors import NotCertifiedError
from refdem.truth.balls import arb_of
from refdem.truth.events.crossing import SwitchError, sign
from refdem.truth.events.system import Entry, Guard, Mode, State
from refdem.truth.events.truth import HybridFlow
from refdem.truth.exact import numbers
from refdem.truth.refiner import Refiner
from refdem.truth.traced_field import Field

# Indices of the coordinates of a state.
PLACE = 0  # x [m]
SLIP = 1  # u [m/s]
CLOCK = 2  # t [s]
NAMES = ("a", "mu0", "mu1", "lambda0", "lambda1", "belt", "gamma", "eta", "x0", "v0")
FORWARD = "forward"
BACKWARD = "backward"
STICK = "stick"


@dataclass(frozen=True)
class StickSlip:
    """Exact parameters in SI units (mass and stiffness are 1).

    `law` is quadratic or linear, the last term of mu. State: x, u, t.
    """

    a: Fraction
    mu0: Fraction
    mu1: Fraction
    lambda0: Fraction
    lambda1: Fraction
    belt: Fraction
    gamma: Fraction
    eta: Fraction
    x0: Fraction
    v0: Fraction
    law: str

    def friction(self, speed: Any) -> Any:
        """The friction a mu(w) at a relative speed w >= 0."""
        if self.law == "quadratic":
            growing = speed * speed
        else:
            growing = speed
        # a ((mu0 - mu1)/(1 + lambda0 w) + mu1 + lambda1 w^2), or lambda1 w.
        falling = (self.mu0 - self.mu1) / (1 + self.lambda0 * speed)
        return self.a * (falling + self.mu1 + self.lambda1 * growing)

    @property
    def limit(self) -> Fraction:
        """The limit a mu0 of static friction, the largest |P| at which the mass sticks."""
        return self.a * self.mu0

    def pull(self, y: Any) -> Any:
        """The pull P = gamma cos(eta t) - x - a mu(|belt|), which friction balances in a stick."""
        return self.gamma * (self.eta * y[CLOCK]).cos() - y[PLACE] - self.friction(abs(self.belt))

    def modes(self) -> dict[str, Mode]:
        """The three modes of the motion, by name.

        A guard is positive while its mode lasts; the event is its zero.
        """
        limit = self.limit
        # A slip ends where u = 0.
        forward_stop = Guard("stop", lambda y: y[SLIP], self.landing)
        backward_stop = Guard("stop", lambda y: -y[SLIP], self.landing)
        # Sticking ends where |P| = a mu0. The slip begins with a double zero of u.
        release_forward = Guard(
            FORWARD,
            lambda y: limit - self.pull(y),
            lambda y: Entry(FORWARD, on_belt, {"stop": 2}),
        )
        release_backward = Guard(
            BACKWARD,
            lambda y: limit + self.pull(y),
            lambda y: Entry(BACKWARD, on_belt, {"stop": 2}),
        )
        # On a belt that stands still the time of release is known in closed form.
        if self.belt:
            closed_form = None
        else:
            closed_form = self.leaves
        stick = Mode(
            lambda y: [self.belt, 0, 1],
            (release_forward, release_backward),
            closed_form,
            self.window(),
        )
        return {
            FORWARD: Mode(self.slipping(1), (forward_stop,)),
            BACKWARD: Mode(self.slipping(-1), (backward_stop,)),
            STICK: stick,
        }

    def slipping(self, side: int) -> Field:
        """The field of a slip: x' = u + belt, u' = P - side a mu(|u|), t' = 1.

        `side` is the sign of u: 1 forward, -1 backward.
        """

        def field(y: Any) -> list[Any]:
            friction = self.friction(side * y[SLIP])
            # x' = u + belt,  u' = P - side a mu(|u|).
            return [y[SLIP] + self.belt, self.pull(y) - side * friction, 1]

        return field

    def window(self) -> Fraction:
        """About a quarter of the drive's period [s]."""
        if self.eta:
            return min(Fraction(1), Fraction(3, 2) / self.eta)
        return Fraction(1)

    def landing(self, y: State) -> Entry:
        """The mode after a slip has reached u = 0 in state y.

        It is a stick if |P| < a mu0, and otherwise a slip to the side of P. Raises SwitchError
        where it is not decided whether |P| or a mu0 is larger.
        """
        drive = arb_of(self.gamma) * (arb_of(self.eta) * y[CLOCK]).cos()
        limit = arb_of(self.limit)
        pull = drive - y[PLACE] - arb_of(self.friction(abs(self.belt)))
        if abs(pull) < limit:
            return Entry(STICK, on_belt)
        # u crosses 0 with the rate P -+ a mu0, which is not 0: a simple zero of its guard.
        if pull > limit:
            return Entry(FORWARD, on_belt, {"stop": 1})
        if pull < -limit:
            return Entry(BACKWARD, on_belt, {"stop": 1})
        raise SwitchError(
            "corner",
            "it meets the belt with a pull at the limit of friction",
            float(y[CLOCK].mid()),
        )

    def first(self, y: State) -> Entry:
        """The mode at the start, decided in exact rationals.

        Raises NotCertifiedError where it starts on a belt at rest with the pull exactly at the
        limit: then neither the sign of the pull nor that of its rate is conclusive.
        """
        slip = self.v0 - self.belt
        pull = self.gamma - self.x0 - self.friction(abs(self.belt))
        if slip > 0:
            return Entry(FORWARD, None, {})
        if slip < 0:
            return Entry(BACKWARD, None, {})
        # u = 0 and |P| > a mu0: it leaves the belt at once, u having a simple zero.
        if pull > self.limit:
            return Entry(FORWARD, None, {"stop": 1})
        if pull < -self.limit:
            return Entry(BACKWARD, None, {"stop": 1})
        if abs(pull) < self.limit:
            return Entry(STICK)
        # |P| = a mu0: the mass leaves the belt if |P| rises. At t = 0 the derivative of
        # gamma cos(eta t) is 0, so that P' = -x' = -belt.
        if pull > 0:
            side = FORWARD
            leaving = -self.belt
        else:
            side = BACKWARD
            leaving = self.belt
        if leaving == 0:
            raise NotCertifiedError(
                "it starts on a belt at rest with a pull exactly at the limit of friction",
                code="corner",
                time=0.0,
            )
        if leaving > 0:
            return Entry(side, None, {"stop": 2})
        return Entry(STICK, None, {side: 1})

    def leaves(self, y: State) -> tuple[str, arb] | None:
        """The release from a belt at rest: its side and the time [s] until it, or None if never.

        P = +-a mu0 with a mu(belt) = a mu0: gamma cos(eta t) = x + a mu0 +- a mu0, the first time
        after the clock of state y.
        """
        releases = {}
        for side, offset in ((FORWARD, 2 * self.limit), (BACKWARD, Fraction(0))):
            elapsed = self.next_time(y[PLACE] + arb_of(offset), y[CLOCK])
            if elapsed is not None:
                releases[side] = elapsed
        if len(releases) < 2:
            return next(iter(releases.items()), None)
        if sign(releases[BACKWARD] - releases[FORWARD], "the order of two releases") > 0:
            first = FORWARD
        else:
            first = BACKWARD
        return first, releases[first]

    def next_time(self, level: arb, clock: arb) -> arb | None:
        """The time [s] after `clock` until gamma cos(eta t) = level; None if it never is.

        The solutions are eta t = +-acos(level/gamma) + 2 pi k; for each sign k is the smallest with
        t >= clock. Raises SwitchError where balls decide neither that the level is reached nor
        which k it is.
        """
        if not self.gamma or not self.eta or abs(level) > abs(arb_of(self.gamma)):
            return None
        if not abs(level) < abs(arb_of(self.gamma)):
            raise SwitchError(
                "grazing", "the largest pull is at the limit of friction", float(clock.mid())
            )
        angle = (level / arb_of(self.gamma)).acos()
        full_turn = 2 * arb.pi()
        elapsed = []
        for branch in (angle, -angle):
            # k = ceil((eta t - branch)/(2 pi)).
            turns = ((arb_of(self.eta) * clock - branch) / full_turn).ceil().unique_fmpz()
            if turns is None:
                raise SwitchError(
                    "corner", "the release is not told from the landing", float(clock.mid())
                )
            elapsed.append((branch + full_turn * int(turns)) / arb_of(self.eta) - clock)
        if sign(elapsed[1] - elapsed[0], "the order of two branches") > 0:
            return elapsed[0]
        return elapsed[1]


def on_belt(y: Any) -> list[Any]:
    """The same state with u exactly 0."""
    return [y[PLACE], 0, y[CLOCK]]


WITNESS = (
    "mpmath.odefun at 40 digits, events by regula falsi (literals in the tests);"
    " refdem/truth/witnesses/stick_slip.py"
)


def times_of_events(until: Fraction, flow: HybridFlow) -> dict[str, Ball]:
    """The times [s] of the events up to `until` [s], or as far as they are certified.

    stick_n, slip_n and cross_n are when for the n-th time it begins to stick, is released, or
    passes u = 0.
    """
    try:
        events = flow.events_until(until)
    except NotCertifiedError as error:
        if error.time:
            events = flow.events_until(Fraction(error.time))
        else:
            events = []
    times: dict[str, Ball] = {}
    counts = dict.fromkeys(("stick", "slip", "cross"), 0)
    for guard, next_mode, time in events:
        kind = kind_of_event(guard, next_mode)
        counts[kind] += 1
        times[f"{kind}_{counts[kind]}"] = time
    return times


def kind_of_event(name: str, mode: str | None) -> str:
    """The name of an event, `slip`, `stick` or `cross`, from its guard and the mode it leads to."""
    if name != "stop":
        return "slip"
    if mode == STICK:
        return "stick"
    return "cross"


def truth(p: Parameters, scale: Mapping[str, float], until: Fraction) -> Truth:
    """The truth at the parameters of case stick-slip: x [m], v [m/s] at t >= 0.

    `scale` has the sizes of x and v against which their errors count. Scalars are the times of the
    events up to `until` [s].
    """
    system = StickSlip(law=str(p["friction_law"]), **numbers(p, *NAMES))
    start = [system.x0, system.v0 - system.belt, Fraction(0)]
    return HybridFlow(
        system.modes(),
        start,
        system.first,
        lambda y: {"x": y[PLACE], "v": y[SLIP] + system.belt},
        Refiner.of(scale),
        state=("x", "v"),
        moved=(0, 1),
        witness=WITNESS,
        extremes=partial(times_of_events, until),
    )
