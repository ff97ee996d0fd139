"""Points of two Poincare sections of the mass on a belt (1.125): x and v once a period of the
drive, and the times and positions of v = 0 with x > 0.

On a belt of velocity b > 0, v = 0 is only possible in a backward slip (u = -b < 0). That slip is
divided into two modes with the same equations, v > 0 and v < 0, so that v = 0 is an event whose
time interval Newton encloses. There v' = gamma cos(eta t) - x, because the friction a mu(b) cancels
the constant -a mu(b) of the pull.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from typing import Any, Self

from flint import arb, ctx

from refdem.core.parameters import Parameters
from refdem.core.truth import Truth
from refdem.errors import NotCertifiedError
from refdem.truth.balls import arb_of
from refdem.truth.closed_form import ClosedForm, per_precision
from refdem.truth.closed_forms.quaternions import listed
from refdem.truth.closed_forms.stick_slip import BACKWARD, CLOCK, NAMES, PLACE, SLIP, StickSlip
from refdem.truth.events.crossing import sign
from refdem.truth.events.motion import Event, HybridMotion
from refdem.truth.events.system import Entry, Guard, Mode, State
from refdem.truth.events.truth import HybridFlow
from refdem.truth.exact import numbers
from refdem.truth.growth import Grows, Told
from refdem.truth.refiner import Refiner

RETREAT = "retreat"
"""The mode of a backward slip with v < 0; BACKWARD is the one with v > 0."""
PASSAGE = "passage"
"""The event v = 0."""
STROBES = 3
"""Number of periods of the drive at whose ends the state is given."""
PASSAGES = 4
"""Number of passages of v = 0 with x > 0 that are given."""
MOST_PERIODS = 16
"""Length of the search for them in periods of the drive, or of the spring if that is longer."""


@dataclass(frozen=True)
class Sectioned:
    """The motion of an oscillator whose belt moves forward, with an event wherever v = 0."""

    oscillator: StickSlip

    def modes(self) -> dict[str, Mode]:
        """The modes of the motion, by name, the backward slip in two parts."""
        belt = self.oscillator.belt
        modes = self.oscillator.modes()
        field = self.oscillator.slipping(-1)
        # A guard is positive inside its mode: v = u + b > 0, and -v > 0 in the retreat.
        falls = Guard(
            PASSAGE,
            lambda y: y[SLIP] + belt,
            lambda y: Entry(RETREAT, self.at_rest, {PASSAGE: 1}),
        )
        rises = Guard(
            PASSAGE,
            lambda y: -y[SLIP] - belt,
            lambda y: Entry(BACKWARD, self.at_rest, {PASSAGE: 1}),
        )
        modes[BACKWARD] = Mode(field, (*modes[BACKWARD].guards, falls))
        modes[RETREAT] = Mode(field, (rises,))
        return modes

    def at_rest(self, y: Any) -> list[Any]:
        """The same state with v exactly 0."""
        return [y[PLACE], -self.oscillator.belt, y[CLOCK]]

    def first(self, y: State) -> Entry:
        """The mode at the start, decided in exact rationals.

        Raises NotCertifiedError where it starts with v = 0 and no acceleration.
        """
        oscillator = self.oscillator
        if oscillator.v0 > 0:
            return oscillator.first(y)
        if oscillator.v0 < 0:
            return Entry(RETREAT)
        # The drive is gamma at t = 0: v' = gamma - x.
        rate = oscillator.gamma - oscillator.x0
        if rate == 0:
            raise NotCertifiedError("it starts at rest without a force", code="grazing", time=0.0)
        if rate > 0:
            return Entry(BACKWARD, None, {PASSAGE: 1})
        return Entry(RETREAT, None, {PASSAGE: 1})


@dataclass(frozen=True)
class Sections(ClosedForm):
    """Points of the sections of a motion, at the current precision."""

    method = "validated integration from event to event"
    state = ()

    oscillator: StickSlip
    of_motion: Mapping[str, Fraction]
    witness: str

    @cached_property
    def flow(self) -> HybridFlow:
        """The motion itself, with the sizes of x and v."""
        oscillator = self.oscillator
        sectioned = Sectioned(oscillator)
        return HybridFlow(
            sectioned.modes(),
            [oscillator.x0, oscillator.v0 - oscillator.belt, Fraction(0)],
            sectioned.first,
            lambda y: {"x": y[PLACE], "v": y[SLIP] + oscillator.belt},
            Refiner(self.of_motion),
            state=("x", "v"),
            moved=(0, 1),
        )

    @per_precision
    def constants(self) -> dict[str, arb]:
        """Every point of both sections, by the names of the rows."""
        motion = self.flow.motion(ctx.prec)
        rows = {}
        for n in range(1, STROBES + 1):
            state = motion.at(self.strobe_time(n))
            # x and v = u + b.
            rows[f"strobe-{n}"] = [state[PLACE], state[SLIP] + arb_of(self.oscillator.belt)]
        for n, event in enumerate(self.passages(motion), start=1):
            rows[f"passage-{n}"] = [event.time, event.state[PLACE]]
        return listed(rows)

    def strobe_time(self, n: int) -> arb:
        """The time [s] of so many periods of the drive, 2 pi n/eta."""
        return 2 * n * arb.pi() / arb_of(self.oscillator.eta)

    def passages(self, motion: HybridMotion) -> list[Event]:
        """The first PASSAGES passages of v = 0 with x > 0.

        Raises NotCertifiedError where there are fewer in MOST_PERIODS periods.
        """
        found: list[Event] = []
        searched = 0
        # Mass and stiffness are 1, so that the spring has the frequency 1: 2 pi/min(1, eta).
        last = 2 * MOST_PERIODS * Fraction(math.pi) / min(Fraction(1), self.oscillator.eta)
        while len(found) < PASSAGES:
            while searched == len(motion.events):
                if motion.over() or motion.reached() > last:
                    raise NotCertifiedError(
                        f"it passes v = 0 with x > 0 only {len(found)} times in"
                        f" {MOST_PERIODS} periods"
                    )
                motion.follow()
            event = motion.events[searched]
            searched += 1
            if event.name == PASSAGE and sign(event.state[PLACE], "the place at v = 0") > 0:
                found.append(event)
        return found

    def evaluate(self, t: arb) -> dict[str, arb]:
        """The points: nothing depends on time."""
        return self.constants()

    def displaced(self, axis: int, amount: Fraction) -> Self:
        """There is no start to displace: raises NotCertifiedError."""
        raise NotCertifiedError("the case has no start; its values are scalars")

    @per_precision
    def growth(self) -> Grows:
        """The largest growth of an error of the motion in any of the points, in their scales.

        It is S of the motion at the latest point, times max(1, V/(|v'| T)): an error dv of the
        velocity moves a time of passage by dv/|v'|, with the scales V of v and T of that time. The
        position at v = 0 does not change with the time to first order.
        """
        passages = self.passages(self.flow.motion(ctx.prec))
        latest = max(float(self.strobe_time(STROBES)), float(passages[-1].time))
        grown = arb(self.flow.sensitivity(Fraction(latest)))
        factor = arb(1)
        for n, event in enumerate(passages, start=1):
            # At v = 0: v' = gamma cos(eta t) - x.
            drive = arb_of(self.oscillator.gamma) * (arb_of(self.oscillator.eta) * event.time).cos()
            rate = abs(drive - event.state[PLACE])
            size = arb_of(self.scale[f"passage-{n}.0"])
            # (V/T)/|v'|.
            shift = arb_of(self.of_motion["v"]) / (rate * size)
            factor = factor.max(shift)
        largest = grown * factor
        return Told(lambda t: largest)


WITNESS = (
    "mpmath.odefun at 40 digits phase by phase, events by the secant (literals in the tests);"
    " refdem/truth/witnesses/poincare_sections.py"
)


def truth(p: Parameters, scale: Mapping[str, float], of_motion: Mapping[str, float]) -> Truth:
    """The truth at the parameters of case poincare-sections: `scale` of every number, and those of
    x [m] and v [m/s] along the motion.
    """
    oscillator = StickSlip(law=str(p["friction_law"]), **numbers(p, *NAMES))
    sizes = {name: Fraction(size) for name, size in of_motion.items()}
    return Sections(Refiner.of(scale), oscillator, sizes, WITNESS)
