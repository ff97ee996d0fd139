"""What the oscillators of 1 kg with a square or a cube in their spring share: scene, scales, and
when they escape.
"""

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


def scene(p: Parameters, stiffness: float, *elements: Element, **spring: Any) -> Scene:
    """A point on the x axis, a spring at rest at the origin (anchored at -length), a dashpot beside
    it, and what else acts.
    """
    anchor = (-spring.get("length", 0.0), 0.0, 0.0)
    point = Body(mass=1.0, position=(p.x0, 0.0, 0.0), velocity=(p.v0, 0.0, 0.0))
    if p.delta:
        dashpot = [Dashpot(a=0, anchor_b=anchor, damping=2 * p.delta)]
    else:
        dashpot = []
    return Scene.of(
        [point], [Spring(a=0, anchor_b=anchor, stiffness=stiffness, **spring), *dashpot, *elements]
    )


def scales(
    p: Parameters, stiffness: float, length: float, curvature: float, *drives: float
) -> Scales:
    """tau from the largest stiffness |stiffness| + curvature [1/s^2] per mass, the damping and the
    drives.
    """
    square = abs(stiffness) + abs(curvature)
    rate = float(max(damped_rate(square, p.delta), *drives))
    return Scales(length=length, tau=1 / rate, duration=20 / rate)


def duffing_escapes(p: Parameters, x0: Any, v0: Any = Fraction(0)) -> bool:
    """The motion from there, without damping and drive, is not bounded: exactly, at or beyond the
    rim of the well.
    """
    alpha: Any = p["alpha"]
    beta: Any = p["beta"]
    if beta > 0 or (beta == 0 and alpha > 0):
        return False
    if alpha <= 0:
        return True
    energy = v0**2 / 2 + (alpha + beta * x0**2 / 2) * x0**2 / 2
    return bool(x0**2 >= -alpha / beta or 4 * -beta * energy >= alpha**2)


def quadratic_escapes(w0: Any, eps: Any, x0: Any, v0: Any) -> bool:
    """The motion under -w0^2 x - eps x^2 is not bounded: exactly, at or beyond the rim x =
    -w0^2/eps of the well.
    """
    energy = v0**2 / 2 + w0**2 * x0**2 / 2 + eps * x0**3 / 3
    return bool(eps * x0 <= -(w0**2) or 6 * eps**2 * energy >= w0**6)


def duffing_reach(p: Parameters) -> float:
    """The farther turning point [m] of the motion from x0, v0 without damping and drive."""
    alpha = p.alpha
    beta = p.beta
    energy = (p.v0**2 + alpha * p.x0**2 + beta * p.x0**4 / 2) / 2
    root = np.sqrt(max(0.0, alpha**2 + 4 * beta * energy))
    if alpha > 0:
        square = 4 * energy / (alpha + root)
    else:
        square = (root - alpha) / beta
    return float(np.sqrt(max(0.0, square)))


def balanced_amplitude(p: Parameters) -> float:
    """The largest amplitude [m] that harmonic balance has for the drive (1.120).

    With beta < 0 no more than the rim of the well; without damping and beta no more than grows in
    20 shortest times.
    """
    alpha = p.alpha
    beta = p.beta
    if beta == 0:
        drag = np.hypot(alpha - p.drive**2, 2 * p.delta * p.drive)
        return float(abs(p.f0) / max(drag, np.sqrt(alpha) * max(np.sqrt(alpha), p.drive) / 10))
    largest = response.balanced_amplitude(p.drive, alpha, beta, p.delta, p.f0)
    if beta > 0:
        return largest
    return min(largest, float(np.sqrt(-alpha / beta)))
