"""The witness of quadratic-drag: v' = -g - (c/m) |v| v by Taylor integration."""

from collections.abc import Mapping, Sequence
from fractions import Fraction
from typing import Any

from flint import arb

from refdem.core.parameters import Exact
from refdem.truth.balls import arb_of
from refdem.truth.exact import number
from refdem.truth.witnesses.cross_check import Claimed, Results, Witness
from refdem.truth.witnesses.taylor import Solution

METHOD = "Taylor integration at 58 digits, unproven (truth/witnesses/quadratic_drag.py)"


def values(p: Mapping[str, Exact], times: Sequence[Fraction], claimed: Claimed) -> Results:
    """y [m] and v [m/s], the turning point and the terminal velocity.

    Ascent and descent are integrated separately, with opposite signs of the drag.
    """
    gravity = arb_of(number(p, "gravity"))
    drag = arb_of(number(p, "drag") / number(p, "mass"))
    speed = number(p, "v0")

    def rates(sign: int) -> Any:
        # y' = v, v' = -g + sign (c/m) v^2 with the sign -1 on the way up and 1 on the way down.
        def of(t: Any, state: Sequence[Any]) -> list[Any]:
            velocity = state[1]
            return [velocity, sign * drag * velocity * velocity - gravity]

        return of

    turning = arb(0)
    top = arb(0)
    going_up = Solution(rates(-1), [arb(0), arb_of(speed)])
    if speed > 0:
        near = float(claimed["top_time"])
        turning = going_up.crossing(lambda state: state[1], near, near / 64)
        top, _ = going_up.at(turning)
        going_down = Solution(rates(1), [top, arb(0)])
        yield None, {"top": top, "top_time": turning}
    else:
        going_down = Solution(rates(1), [arb(0), arb_of(speed)])
    # At the terminal velocity the drag balances the weight: c v_t^2 = m g.
    yield None, {"terminal_velocity": (gravity / drag).sqrt()}
    for t in times:
        if speed > 0 and arb_of(t) < turning:
            y, v = going_up.at(t)
        else:
            y, v = going_down.at(arb_of(t) - turning)
        yield t, {"y": y, "v": v}


WITNESSES = {"quadratic-drag": Witness(METHOD, values)}
