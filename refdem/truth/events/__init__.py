"""Validated integration of systems that switch: fields, the switching functions that end them, and
jumps of the state.

system: what an author writes; crossing: signs proved by bisection, the first zero by interval
Newton; motion: the error set carried from phase to phase through the event; truth: a Truth made of
them. Where balls cannot decide: NotCertifiedError with code, time, state.

A block that a spring drags to rest (coordinates x, v and, always last, the clock; v is set to an
exact 0 by the reset):

    slide = Mode(lambda y: [y[1], -y[0] - f, 1], (Guard("stop", lambda y: y[1], lambda y:
    Entry("rest", lambda y: [y[0], 0, y[2]])),)) rest = Mode(lambda y: [0, 0, 1])
    HybridFlow({"slide": slide, "rest": rest}, [x0, v0, 0], lambda y: Entry("slide"), quantities,
    Refiner.of(scale), state=("x", "v"), moved=(0, 1))

A guard that is zero at the entry by construction is named with the order of that zero:
Entry("slide", reset, {"stop": 1}); `sign` of crossing decides branches in `then`.
`HybridFlow.events_until(t)` lists events; `.motion(bits).events` has their states.
"""
