"""A mass on a spring that rubs on a moving belt: x'' in gamma cos(eta t) - x - a mu(belt) - a mu(u)
Sgn(u), u = x' - belt (1.125).

Modes: it slips forward (u > 0), backward (u < 0), or sticks (u = 0), which it may while |P| <= a
mu0 with the pull P = gamma cos(eta t) - x - a mu(belt). A slip begins with a double zero of u:
there u' = P - a mu0 = 0 and u'' = P' > 0. On a belt that stands still x is constant while it
sticks, so that the time of release is an arc cosine, or there is none.
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
from refdem.truth.traced_field import Field

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
            last = speed * speed
        else:
            last = speed
        return self.a * (
            (self.mu0 - self.mu1) / (1 + self.lambda0 * speed) + self.mu1 + self.lambda1 * last
        )

    @property
    def limit(self) -> Fraction:
        """a mu0: the largest pull at which it sticks."""
        return self.a * self.mu0

    def pull(self, y: Any) -> Any:
        """The force P that friction must balance in a state."""
        return self.gamma * (self.eta * y[2]).cos() - y[0] - self.friction(abs(self.belt))

    def modes(self) -> dict[str, Mode]:
        """The three modes of the motion, by name."""
        limit = self.limit
        forward, backward = (
            Guard("stop", lambda y: y[1], self.landing),
            Guard("stop", lambda y: -y[1], self.landing),
        )
        release = (
            Guard(
                FORWARD,
                lambda y: limit - self.pull(y),
                lambda y: Entry(FORWARD, on_belt, {"stop": 2}),
            ),
            Guard(
                BACKWARD,
                lambda y: limit + self.pull(y),
                lambda y: Entry(BACKWARD, on_belt, {"stop": 2}),
            ),
        )
        return {
            FORWARD: Mode(self.slipping(1), (forward,)),
            BACKWARD: Mode(self.slipping(-1), (backward,)),
            STICK: Mode(
                lambda y: [self.belt, 0, 1],
                release,
                None if self.belt else self.leaves,
                self.window(),
            ),
        }

    def slipping(self, side: int) -> Field:
        """x' = u + belt, u' = P - side a mu(|u|), t' = 1."""
        return lambda y: [y[1] + self.belt, self.pull(y) - side * self.friction(side * y[1]), 1]

    def window(self) -> Fraction:
        """About a quarter of the drive's period [s]."""
        if self.eta:
            return min(Fraction(1), Fraction(3, 2) / self.eta)
        return Fraction(1)

    def landing(self, y: State) -> Entry:
        """The entry at u = 0: it sticks or crosses, by the pull."""
        wave = arb_of(self.gamma) * (arb_of(self.eta) * y[2]).cos()
        limit = arb_of(self.limit)
        pull = wave - y[0] - arb_of(self.friction(abs(self.belt)))
        if abs(pull) < limit:
            return Entry(STICK, on_belt)
        if abs(pull) > limit:
            return Entry(FORWARD if pull > 0 else BACKWARD, on_belt, {"stop": 1})
        raise SwitchError(
            "corner", "it meets the belt with a pull at the limit of friction", float(y[2].mid())
        )

    def first(self, y: State) -> Entry:
        """The mode at the start, by exact numbers: at rest on the belt and exactly at the limit the
        change of the pull decides.
        """
        slip = self.v0 - self.belt
        pull = self.gamma - self.x0 - self.friction(abs(self.belt))
        if slip or abs(pull) > self.limit:
            side = slip or pull
            return Entry(FORWARD if side > 0 else BACKWARD, None, {} if slip else {"stop": 1})
        if abs(pull) < self.limit:
            return Entry(STICK)
        side, leaving = (FORWARD, -self.belt) if pull > 0 else (BACKWARD, self.belt)
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
        """The event that ends sticking on a belt at rest: gamma cos(eta t) = x + a mu0 +- a mu0 the
        first time after the clock of y, or never.
        """
        found = {}
        for side, offset in ((FORWARD, 2 * self.limit), (BACKWARD, Fraction(0))):
            since = self.next_time(y[0] + arb_of(offset), y[2])
            if since is not None:
                found[side] = since
        if len(found) < 2:
            return next(iter(found.items()), None)
        if sign(found[BACKWARD] - found[FORWARD], "the order of two releases") > 0:
            first = FORWARD
        else:
            first = BACKWARD
        return first, found[first]

    def next_time(self, level: arb, clock: arb) -> arb | None:
        """Time after `clock` until gamma cos(eta t) = level; None if it never is."""
        if not self.gamma or not self.eta or abs(level) > abs(arb_of(self.gamma)):
            return None
        if not abs(level) < abs(arb_of(self.gamma)):
            raise SwitchError(
                "grazing", "the largest pull is at the limit of friction", float(clock.mid())
            )
        angle = (level / arb_of(self.gamma)).acos()
        turn = 2 * arb.pi()
        phases = []
        for branch in (angle, -angle):
            turns = ((arb_of(self.eta) * clock - branch) / turn).ceil().unique_fmpz()
            if turns is None:
                raise SwitchError(
                    "corner", "the release is not told from the landing", float(clock.mid())
                )
            phases.append((branch + turn * int(turns)) / arb_of(self.eta) - clock)
        if sign(phases[1] - phases[0], "the order of two branches") > 0:
            return phases[0]
        return phases[1]


def on_belt(y: Any) -> list[Any]:
    """The same state with u exactly 0."""
    return [y[0], 0, y[2]]


WITNESS = (
    "mpmath.odefun at 40 digits, events by regula falsi (literals in the tests);"
    " refdem/truth/witnesses/stick_slip.py"
)


def times_of_events(until: Fraction, flow: HybridFlow) -> dict[str, Ball]:
    """stick_n, slip_n, cross_n: when for the n-th time it sticks, is released, passes u = 0 [s].

    Up to `until` [s], or as far as they are certified.
    """
    try:
        events = flow.events_until(until)
    except NotCertifiedError as error:
        if error.time:
            events = flow.events_until(Fraction(error.time))
        else:
            events = []
    found: dict[str, Ball] = {}
    counts = dict.fromkeys(("stick", "slip", "cross"), 0)
    for name, mode, ball in events:
        kind = kind_of_event(name, mode)
        counts[kind] += 1
        found[f"{kind}_{counts[kind]}"] = ball
    return found


def kind_of_event(name: str, mode: str | None) -> str:
    """What an event is called, by the guard and the mode that is entered."""
    if name != "stop":
        return "slip"
    if mode == STICK:
        return "stick"
    return "cross"


def truth(p: Parameters, scale: Mapping[str, float], until: Fraction) -> Truth:
    """The truth at the parameters of case stick-slip: x [m], v [m/s] at t >= 0.

    `scale` of x and v; scalars are the times of events `until` [s].
    """
    system = StickSlip(law=str(p["friction_law"]), **numbers(p, *NAMES))
    start = [system.x0, system.v0 - system.belt, Fraction(0)]
    return HybridFlow(
        system.modes(),
        start,
        system.first,
        lambda y: {"x": y[0], "v": y[1] + system.belt},
        scale,
        state=("x", "v"),
        moved=(0, 1),
        witness=WITNESS,
        extremes=partial(times_of_events, until),
    )
