"""Switching systems of the tests whose motions are known exactly; the clock is the last
coordinate.
"""

from fractions import Fraction

from flint import arb

from refdem.truth.balls import arb_of
from refdem.truth.events.crossing import sign
from refdem.truth.events.motion import HybridMotion
from refdem.truth.events.system import Entry, Guard, Mode, Traced
from refdem.truth.events.truth import HybridFlow
from refdem.truth.refiner import Refiner


def bouncing():
    """x'' = -1 above a floor that gives back half the speed."""
    hit = Guard(
        "hit", lambda y: y[0], lambda y: Entry("fall", lambda y: [0, -y[1] / 2, y[2]], {"hit": 1})
    )
    return {"fall": Mode(lambda y: [y[1], -1, 1], (hit,))}


def bounced(x, v, t):
    """Place, velocity and number of bounces at t of x'' = -1 from x, v, by hand."""
    speed = (v * v + 2 * x).sqrt()
    start = v + speed
    up = speed / 2
    hits = 1
    if t < start:
        return x + v * t - t * t / 2, v - t, 0
    while not t < start + 2 * up:
        start = start + 2 * up
        up = up / 2
        hits = hits + 1
    since = t - start
    return up * since - since * since / 2, up - since, hits


def rubbing(force=Fraction(3, 20)):
    """x'' = -x - force sgn x' with Sgn(0) = [-1, 1]."""

    def turned(y):
        left = sign(abs(y[0]) - arb_of(force), "what is left over")
        if left <= 0:
            return Entry("rest", on_ground)
        return Entry("left" if y[0] > 0 else "right", on_ground, {"turn": 1})

    def on_ground(y):
        return [y[0], 0, y[2]]

    return {
        "right": Mode(lambda y: [y[1], -y[0] - force, 1], (Guard("turn", lambda y: y[1], turned),)),
        "left": Mode(lambda y: [y[1], -y[0] + force, 1], (Guard("turn", lambda y: -y[1], turned),)),
        "rest": Mode(lambda y: [0, 0, 1]),
    }


def swinging(level, *, then="left"):
    """x'' = -x that is stopped where x reaches a level."""
    stop = Guard("top", lambda y: level - y[0], lambda y: Entry(then))
    return {"swing": Mode(lambda y: [y[1], -y[0], 1], (stop,)), "left": Mode(lambda y: [0, 0, 1])}


def racing(first, second, *, both=("a", "b")):
    """x' = 1 with guards at two levels; the mode entered says which came first."""
    guards = {
        "a": Guard("a", lambda y: first - y[0], lambda y: Entry("a")),
        "b": Guard("b", lambda y: second - y[0], lambda y: Entry("b")),
    }
    return {
        "run": Mode(lambda y: [1, 1], tuple(guards[name] for name in both)),
        "a": Mode(lambda y: [0, 1]),
        "b": Mode(lambda y: [-1, 1]),
    }


def dipping(depth):
    """A guard (t - 1)^2 - depth^2 that is below zero only for a moment: from 1 - depth on."""
    dip = Guard("dip", lambda y: (y[1] - 1) * (y[1] - 1) - depth * depth, lambda y: Entry("after"))
    return {
        "before": Mode(lambda y: [0, 1], (dip,), window=Fraction(4)),
        "after": Mode(lambda y: [1, 1]),
    }


def ramped():
    """Held while a pull t is below 1; then u' = t - 1, so that u = (t - 1)^2/2 begins with a double
    zero; held again at u = 2.
    """
    release = Guard(
        "release", lambda y: 1 - y[1], lambda y: Entry("slip", lambda y: [0, y[1]], {"stop": 2})
    )
    slips = Mode(
        lambda y: [y[1] - 1, 1],
        (
            Guard("stop", lambda y: y[0], lambda y: Entry("hold")),
            Guard("far", lambda y: 2 - y[0], lambda y: Entry("hold")),
        ),
    )
    return {"hold": Mode(lambda y: [0, 1], (release,)), "slip": slips}


def motion(modes, start, mode, *, radii=(), bits=100, touching=None):
    """The motion of a box of starts."""
    balls = [
        arb_of(Fraction(x)) + arb(0, r)
        for x, r in zip(start, radii or [0] * len(start), strict=True)
    ]
    return HybridMotion(
        {name: Traced(one, len(start)) for name, one in modes.items()},
        balls,
        Entry(mode, None, touching or {}),
        bits,
    )


def flow(modes, start, mode, *, touching=None, digits=40):
    """The truth of the first coordinate (and the second, if that is not the clock)."""
    names = ("x", "v")[: len(start) - 1]
    return HybridFlow(
        modes,
        [Fraction(x) for x in start],
        lambda y: Entry(mode, None, touching or {}),
        lambda y: dict(zip(names, y, strict=False)),
        Refiner.of(dict.fromkeys(names, 1), digits=digits),
        state=names,
        moved=tuple(range(len(names))),
    )
