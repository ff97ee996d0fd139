"""A Truth by validated integration through events: quantities and event times as balls, S(t) with the jump matrices."""

from collections.abc import Callable, Mapping, Sequence
from fractions import Fraction
from itertools import pairwise
from math import ceil
from time import process_time
from typing import Any, Self, TypeVar

import numpy as np
from flint import arb, arb_mat
from numpy.typing import NDArray

from refdem.core.truth import Ball
from refdem.errors import NotCertifiedError
from refdem.truth.balls import UndecidedError, arb_of, ball_of, precision
from refdem.truth.closed_form import ClosedForm, Size
from refdem.truth.events.crossing import SwitchError
from refdem.truth.events.motion import Motion, first_entry
from refdem.truth.events.system import Entry, Mode, State, Traced
from refdem.truth.smooth_flow import BEYOND_DOUBLES, ORIGINS
from refdem.truth.traced_field import Program, traced
from refdem.truth.validated_flow import Quantities

LADDER = (192, 256, 384, 512, 768, 1024, 1536)
"""Bits, one after another until the radius is met; a motion that asks for more is not certified."""
Found = TypeVar("Found")
PROBE = 1.0
"""CPU seconds of following that a forecast takes."""
LOSS = 24
"""Bits below those of the target that no motion is certified with."""


class HybridFlow(ClosedForm):
    """The motion of a system that switches, for t >= 0.

    `start` has, for each coordinate, an exact number or a function that gives its ball; the last is the clock. `first(y)` gives the
    entry into the first mode from balls of the start, whose reset must be None. `quantities(y)` has quantities by name, those of
    `state` among them; `moved` has the coordinates of the start that S displaces, each in the scale of its quantity of `state`.
    """

    method = "validated integration from event to event: signs by bisection, times by interval Newton, sets through the jump matrix"
    witness = "none"

    def __init__(
        self,
        modes: Mapping[str, Mode],
        start: Sequence[Fraction | int | Callable[[], arb]],
        first: Callable[[State], Entry],
        quantities: Quantities,
        scale: Mapping[str, Size],
        *,
        state: Sequence[str],
        moved: Sequence[int],
        digits: int = 40,
    ) -> None:
        super().__init__(scale, digits=digits)
        self.modes = {name: Traced(mode, len(start)) for name, mode in modes.items()}
        self.begin, self.first, self.state, self.moved = list(start), first, tuple(state), tuple(moved)
        self.names: list[str] = []
        outputs, slopes = traced(lambda y: self.listed(quantities(y)), len(self.begin))
        self.values, self.slopes = Program(outputs), Program([entry for row in slopes for entry in row])

    def listed(self, found: Mapping[str, Any]) -> list[Any]:
        """The quantities one after another, as `names` lists them."""
        self.names = list(found)
        return list(found.values())

    def displaced(self, axis: int, amount: Fraction) -> Self:
        """Raises NotCertifiedError: S comes from the variational equation, with the jump matrices, not from neighbouring starts."""
        raise NotCertifiedError(
            "a motion through events is not displaced: its S comes from the variational equation; ask for `sensitivity`"
        )

    def motion(self, bits: int) -> Motion:
        """The motion at a precision, as far as it has been followed."""
        if ("motion", bits) not in self.kept:
            with precision(bits):
                balls = [value() if callable(value) else arb_of(value) for value in self.begin]
                self.kept["motion", bits] = Motion(self.modes, balls, first_entry(self.first, balls), bits)
        found: Motion = self.kept["motion", bits]
        return found

    def named(self, y: Sequence[arb]) -> dict[str, arb]:
        """The quantities of a state."""
        return dict(zip(self.names, self.values.run(y), strict=True))

    def at(self, t: Fraction) -> dict[str, Ball]:
        return self.climbed(lambda motion: self.named(motion.at(arb_of(t))), f"at t = {float(t):.17g} s")

    def evaluate(self, t: arb) -> dict[str, arb]:
        return self.named(self.motion(LADDER[0]).at(t))

    def events_until(self, t: Fraction) -> list[tuple[str, str | None, Ball]]:
        """Names, modes entered and times [s] of the events before t."""

        def found(motion: Motion) -> dict[str, arb]:
            motion.at(arb_of(t))
            return {f"{event.name} {event.mode} {n}": event.time for n, event in enumerate(motion.events) if event.time < arb_of(t)}

        balls = self.climbed(found, f"events until {float(t):.17g} s")
        told = [(label.split(), ball) for label, ball in balls.items()]
        return [(name, mode if mode in self.modes else None, ball) for (name, mode, _), ball in told]

    def climbed(self, evaluate: Callable[[Any], dict[str, arb]], what: str) -> dict[str, Ball]:
        """Balls at the lowest precision at which all radii are small enough; NotCertifiedError with code, time and last state."""
        target = self.target()

        def within(motion: Any) -> dict[str, Ball]:
            balls = {name: ball_of(value) for name, value in evaluate(motion).items()}
            if any(ball.radius > target for ball in balls.values()):
                raise SwitchError("precision", f"radius stays at {float(max(b.radius for b in balls.values())):.3g}", 0.0)
            return balls

        return self.followed(within, what, self.needed())

    def followed(self, evaluate: Callable[[Any], Found], what: str, ladder: Sequence[int] = LADDER) -> Found:
        """What is found from the motion at the lowest precision of the ladder; NotCertifiedError with code, time and last state."""
        error = SwitchError("precision", "no precision suffices", 0.0)
        for bits in ladder:
            with precision(bits):
                try:
                    return evaluate(self.motion(bits))
                except SwitchError as one:
                    error = one
                    if error.final:
                        break
                except UndecidedError as one:
                    error = SwitchError("precision", str(one), 0.0)
        raise self.uncertified(error, what)

    def needed(self) -> list[int]:
        """The bits of the ladder that can meet the digits; NotCertifiedError if none can."""
        least = ceil(1 / self.target()).bit_length() + LOSS
        found = [bits for bits in LADDER if bits >= least]
        if not found:
            raise NotCertifiedError(f"{self.digits} digits ask for more than {LADDER[-1]} bits; ask for fewer", code="precision")
        return found

    def forecast(self, t: Fraction, digits: int) -> float:
        """CPU seconds that `at(t)` to so many digits is about to cost, from about a second of following the motion."""
        asked = self.refined(digits)
        bits, begun = asked.needed()[0], process_time()
        try:
            motion = asked.motion(bits)
            since = motion.reached()
            while motion.reached() < t and not motion.over() and process_time() < begun + PROBE:
                motion.follow()
        except (UndecidedError, NotCertifiedError):
            return 0.0
        left = t - motion.reached()
        return 0.0 if motion.over() or left <= 0 else (process_time() - begun) * float(left / (motion.reached() - since))

    def uncertified(self, error: SwitchError, what: str) -> NotCertifiedError:
        """The honest end."""
        state = {name: ball_of(value) for name, value in self.named(error.state).items()} if error.state else {}
        time = float(error.state[-1].mid()) if error.state else None
        told = f"; certified up to t = {time:.17g} s" if time is not None else ""
        return NotCertifiedError(f"{what}: {error.code}: {error}{told}", code=error.code, time=time, state=state)

    def response(self, t: Fraction) -> list[arb]:
        """For every quantity, the sum over the coordinates of the start of its scaled response at t."""
        time = arb_of(t)

        def told(motion: Motion) -> list[arb]:
            rows = self.scaled(motion.at(time), motion.jacobian(time))
            if not all(row.is_finite() and row.rad() <= (row.abs_lower() + 1) * arb(1e-3) for row in rows):
                raise SwitchError("precision", "the motion is hardly differentiable in its start", 0.0)
            return rows

        return self.followed(told, f"S at t = {float(t):.17g} s")

    def scaled(self, y: Sequence[arb], flow: arb_mat) -> list[arb]:
        """Row sums of |d quantity_i/scale_i over d start_j/scale_j|."""
        slopes = self.slopes.run(y)
        whole = (arb_mat([slopes[i : i + len(y)] for i in range(0, len(slopes), len(y))]) * flow).table()
        sizes = [arb_of(self.scale[name]) for name in self.state]
        sums = [sum((abs(row[j]) * size for j, size in zip(self.moved, sizes, strict=True)), arb(0)) for row in whole]
        return [total / arb_of(self.scale[name]) for total, name in zip(sums, self.names, strict=True)]

    def sensitivities(self, times: Sequence[Fraction]) -> list[float]:
        """S at every time: the largest growth of an error made at t = 0 or at an earlier one of (up to 32 of) the times.

        Sticking forgets: its flow has no inverse, so growths are products of those from sample to sample.
        """
        grown = [self.sensitivity(t) for t in times]
        every = max(1, -(-len(times) // ORIGINS))
        steps = [self.transfer(first, second) for first, second in pairwise(times)]
        for first in range(0, len(times), every):
            if grown[first] < BEYOND_DOUBLES:
                whole = np.eye(len(self.begin))[:, list(self.moved)]
                for i in range(first + 1, len(times)):
                    whole = steps[i - 1] @ whole
                    grown[i] = max(grown[i], self.size(times[i], whole))
        return grown

    def transfer(self, first: Fraction, second: Fraction) -> NDArray[np.float64]:
        """The derivative of the state at one time by that at an earlier one."""
        ends = arb_of(first), arb_of(second)
        return self.followed(lambda motion: motion.transfer(*ends), f"S from t = {float(first):.17g} s to {float(second):.17g} s")

    def size(self, t: Fraction, change: NDArray[np.float64]) -> float:
        """Largest scaled row sum of the quantities' answers to changes (n, moved) of the state, each in its quantity's scale."""
        rows = np.array([float(x.mid()) for x in self.slopes.run(self.state_at(t))]).reshape(len(self.names), -1) @ change
        own = np.array([float(self.scale[name]) for name in self.names])
        return float(np.max(np.abs(rows) @ [float(self.scale[name]) for name in self.state] / own))

    def state_at(self, t: Fraction) -> list[arb]:
        """The state at the lowest precision that knows it."""
        return self.followed(lambda motion: motion.at(arb_of(t)), f"at t = {float(t):.17g} s")
