"""What the oscillators of 1 kg with a quadratic or cubic term in their spring share.

    x'' + 2 delta x' + alpha x + beta x^3 = f0 cos(w t)      (Duffing)
    x'' + 2 delta x' + w0^2 x + eps x^2 = f0 cos(w t)        (quadratic response)

An undamped motion without drive has the energy E = v^2/2 + alpha x^2/2 + beta x^4/4, or v^2/2 +
w0^2 x^2/2 + eps x^3/3; it is bounded inside the well, whose rim is the potential's maximum.
"""

from collections.abc import Callable
from fractions import Fraction
from typing import Any

import numpy as np

from refdem.cases._line import damped_rate
from refdem.core.parameters import Parameter, Parameters
from refdem.core.quantity import Scales
from refdem.mechanics import response
from refdem.scene import Body, Scene
from refdem.scene.element import Element
from refdem.scene.elements.dashpot import Dashpot
from refdem.scene.elements.spring import Spring

ALPHA = Parameter(name="alpha", default="1", unit="1/s^2", doc="linear part of the spring per mass")
BETA = Parameter(
    name="beta", default="1", unit="1/(m^2 s^2)", doc="cubic part of the spring per mass"
)
ESCAPE = (
    "the motion would go to infinity; expected a start below the escape energy, inside the well"
)

RIM_STEPS = 20
"""Steps of the search for a passage over the rim in one shortest time of drive and motion."""
LOST = 1e3
"""Places of the rim beyond which a motion is taken to go to infinity."""
MOST_RIM_STEPS = 20_000
"""Steps of that search at most: 1000 shortest times, after which a driven motion has forgotten how
it began.
"""


def scene(p: Parameters, stiffness: float, *elements: Element, **spring: Any) -> Scene:
    """A point on the x axis, its spring, a dashpot where there is damping, and other elements.

    The spring has its natural `length` when the point is at the origin: it is anchored at x =
    -length. `spring` are its other fields.
    """
    anchor = (-spring.get("length", 0.0), 0.0, 0.0)
    point = Body(mass=1.0, position=(p.x0, 0.0, 0.0), velocity=(p.v0, 0.0, 0.0))
    if p.delta:
        dashpot = [Dashpot(a=0, anchor_b=anchor, damping=2 * p.delta)]
    else:
        dashpot = []
    restoring = Spring(a=0, anchor_b=anchor, stiffness=stiffness, **spring)
    return Scene.of([point], [restoring, *dashpot, *elements])


def scales(
    p: Parameters, stiffness: float, length: float, curvature: float, *drives: float
) -> Scales:
    """Scales with tau = 1/(largest rate): of the spring, the damping, and the `drives` [rad/s].

    The spring's rate is sqrt(|stiffness| + |curvature|), the linear part and the largest change of
    it on the way, each per mass [1/s^2].
    """
    square = abs(stiffness) + abs(curvature)
    rate = float(max(damped_rate(square, p.delta), *drives))
    return Scales(length=length, tau=1 / rate, duration=20 / rate)


def duffing_escapes(p: Parameters, x0: Any, v0: Any = Fraction(0)) -> bool:
    """True if Duffing's motion from x0, v0 without damping and drive is unbounded.

    Decided in exact numbers. With alpha > 0 > beta the rim of the well is at x^2 = -alpha/beta,
    with the energy -alpha^2/(4 beta); a start at or beyond it escapes.
    """
    alpha: Any = p["alpha"]
    beta: Any = p["beta"]
    rises_at_infinity = beta > 0 or (beta == 0 and alpha > 0)
    if rises_at_infinity:
        return False
    has_no_well = alpha <= 0
    if has_no_well:
        return True
    energy = v0**2 / 2 + (alpha + beta * x0**2 / 2) * x0**2 / 2
    is_outside = x0**2 >= -alpha / beta
    is_above_rim = 4 * -beta * energy >= alpha**2
    return bool(is_outside or is_above_rim)


def quadratic_escapes(w0: Any, eps: Any, x0: Any, v0: Any) -> bool:
    """True if the motion x'' = -w0^2 x - eps x^2 from x0, v0 is unbounded.

    Decided in exact numbers. The rim of the well is at x = -w0^2/eps, with the energy w0^6/(6
    eps^2); a start at or beyond it escapes.
    """
    energy = v0**2 / 2 + w0**2 * x0**2 / 2 + eps * x0**3 / 3
    is_outside = eps * x0 <= -(w0**2)
    is_above_rim = 6 * eps**2 * energy >= w0**6
    return bool(is_outside or is_above_rim)


def reach_outside(
    p: Parameters,
    acceleration: Callable[[float, float], float],
    rate: Callable[[float], float],
    rims: tuple[float, ...],
    duration: float,
) -> float:
    """The largest |x| [m] of the damped and driven motion from x0, v0 if a drive carries it over
    a rim of its well, else 0.

    x'' = acceleration(x, t) - 2 delta x' is integrated in binary64 by Heun's method, with
    RIM_STEPS steps in 1/`rate(x)` [s]. `rims` are the places x [m] of the rims, on either side.
    """
    lost = LOST * max(abs(rim) for rim in rims)
    damping = 2.0 * float(p.delta)
    x = float(p.x0)
    v = float(p.v0)
    t = 0.0
    largest = abs(x)
    is_out = False
    for _ in range(MOST_RIM_STEPS):
        if t >= duration or largest > lost:
            break
        h = 1.0 / (RIM_STEPS * rate(x))
        a = acceleration(x, t) - damping * v
        ahead = v + h * a
        a_ahead = acceleration(x + h * v, t + h) - damping * ahead
        x += h * (v + ahead) / 2.0
        v += h * (a + a_ahead) / 2.0
        t += h
        largest = max(largest, abs(x))
        is_out = is_out or any(x / rim >= 1.0 for rim in rims)
    if is_out:
        return largest
    return 0.0


def duffing_reach(p: Parameters) -> float:
    """The farther turning point [m] of Duffing's motion from x0, v0 without damping and drive.

    There v = 0, E = alpha x^2/2 + beta x^4/4, so that x^2 = (sqrt(alpha^2 + 4 beta E) - alpha)/beta
    = 4 E/(alpha + sqrt(alpha^2 + 4 beta E)).
    """
    alpha = p.alpha
    beta = p.beta
    energy = (p.v0**2 + alpha * p.x0**2 + beta * p.x0**4 / 2) / 2
    root = np.sqrt(max(0.0, alpha**2 + 4 * beta * energy))
    # Of the two forms the one without cancellation; the first also holds for beta = 0.
    if alpha > 0:
        square = 4 * energy / (alpha + root)
    else:
        square = (root - alpha) / beta
    return float(np.sqrt(max(0.0, square)))


def balanced_amplitude(p: Parameters) -> float:
    """The largest amplitude [m] of the driven motion by harmonic balance (1.120).

    With beta < 0 it is at most the rim sqrt(-alpha/beta) of the well. With beta = 0 it is the
    steady amplitude f0/sqrt((alpha - w^2)^2 + 4 delta^2 w^2), but near resonance at most what grows
    in 20 shortest times.
    """
    alpha = p.alpha
    beta = p.beta
    if beta == 0:
        w0 = np.sqrt(alpha)
        steady = np.hypot(alpha - p.drive**2, 2 * p.delta * p.drive)
        # f0 t/(2 w0) after t = 20 tau, 1/tau = max(w0, w).
        growing = w0 * max(w0, p.drive) / 10
        return float(abs(p.f0) / max(steady, growing))
    largest = response.balanced_amplitude(p.drive, alpha, beta, p.delta, p.f0)
    if beta > 0:
        return largest
    return min(largest, float(np.sqrt(-alpha / beta)))
