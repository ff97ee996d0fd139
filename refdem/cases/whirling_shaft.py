"""A mass on a shaft that turns: the damping inside the shaft makes it whirl above a speed."""

import numpy as np
from numpy.typing import NDArray

from refdem.cases import _plane
from refdem.core.case import NEVER, Case
from refdem.core.parameters import Parameter, Parameters
from refdem.core.quantity import Quantity, Scales
from refdem.core.trajectory import Trajectory
from refdem.core.truth import Truth
from refdem.errors import UsageError
from refdem.scene import Body, Scene
from refdem.scene.element import Element
from refdem.scene.elements.dashpot import Dashpot
from refdem.scene.elements.rotating_dashpot import RotatingDashpot
from refdem.scene.elements.spring import Spring

Array = NDArray[np.float64]

PHASE = 20.0
"""Duration in radians of the undamped motion."""
MOST_FOLDS = 8.0
"""Duration in e-folds of the growth, where that is less: what has grown further is beyond what some
engines take for a motion.
"""


class WhirlingShaft(Case):
    """A point in the plane x-y, a spring to the origin, a dashpot at rest and one that turns."""

    id = "whirling-shaft"
    title = "Dissipation that destabilises: the whirling shaft"
    words = ("rotor", "whirl", "damping", "instability", "stability", "spring", "dashpot")
    motion = "oscillating"
    statement = (
        "A mass on an elastic shaft that turns is damped from outside, by air at rest, and from"
        " inside, by the material of the shaft, which turns with it. Without damping its"
        " equilibrium is stable at any speed. The damping inside pushes the mass along with the"
        " shaft: above the speed W = w0 (1 + c_e/c_i) this brings more energy in than the damping"
        " outside takes out, and the mass whirls ever wider. At that speed itself it settles on a"
        " circle, on which it turns at w0."
    )
    latex = (
        r"m\ddot z+(c_e+c_i)\,\dot z+(k-ic_i\Omega)\,z=0,\quad z=x+iy,\qquad"
        r" \Omega_{\text{border}}=\omega_0\left(1+\frac{c_e}{c_i}\right),\quad"
        r"\omega_0=\sqrt{k/m}"
    )
    source = (
        "Matuttis and Chen 2014, section 1.7.2: dissipation can destroy stability, after Merkin,"
        " Introduction to the Theory of Stability, 1997; Kimball 1924 (damping inside a shaft)"
    )
    parameters = (
        Parameter(name="mass", default="2", unit="kg", doc="the point mass", above=0),
        Parameter(name="stiffness", default="8", unit="N/m", doc="the shaft's", above=0),
        Parameter(
            name="outer_damping", default="1/2", unit="N s/m", doc="c_e, at rest", at_least=0
        ),
        Parameter(name="inner_damping", default="1", unit="N s/m", doc="c_i, turning", at_least=0),
        Parameter(
            name="turning", default="5", unit="rad/s", doc="W, angular velocity of the shaft"
        ),
        Parameter(name="x0", default="1,0", unit="m", doc="place at the start", shape=(2,)),
        Parameter(name="v0", default="0,1", unit="m/s", doc="velocity at the start", shape=(2,)),
    )
    chaotic_at = NEVER

    def refuse(self, p: Parameters) -> None:
        """Raises UsageError if nothing would ever move."""
        if not (np.any(p.x0) or np.any(p.v0)):
            raise UsageError(
                "parameters x0 and v0: got 0 and 0; expected a start at which something moves"
            )

    def scene(self, p: Parameters) -> Scene:
        """The mass, the spring of the shaft, its damping inside, and the dashpot at rest where
        there is one.
        """
        body = Body(mass=p.mass, position=(*p.x0, 0.0), velocity=(*p.v0, 0.0))
        inside = RotatingDashpot(a=0, damping=p.inner_damping, rate=(0.0, 0.0, p.turning))
        elements: list[Element] = [Spring(a=0, stiffness=p.stiffness), inside]
        if p.outer_damping:
            elements.append(Dashpot(a=0, damping=p.outer_damping))
        return Scene.of([body], elements)

    def scales(self, p: Parameters) -> Scales:
        """L is the amplitude of the undamped motion from this start, 1/tau the larger of w0 and the
        largest root of the characteristic polynomial; T = 20/w0, or 8 e-folds if these are less.
        """
        w0 = float(np.sqrt(p.stiffness / p.mass))
        roots = _roots(p)
        rate = max(w0, float(np.max(np.abs(roots))))
        growth = float(np.max(roots.real))
        # Roots at the left of the imaginary axis, or on it to rounding, end nothing.
        fastest = max(w0 / PHASE, growth / MOST_FOLDS)
        amplitude = float(np.hypot(np.linalg.norm(p.x0), np.linalg.norm(p.v0) / w0))
        return Scales(length=amplitude, tau=1 / rate, duration=1 / fastest, mass=p.mass)

    def quantities(self, p: Parameters) -> tuple[Quantity, ...]:
        """Place [m] and velocity [m/s]."""
        scales = self.scales(p)
        return _plane.quantities(scales.length, scales.speed)

    def observe(self, p: Parameters, trajectory: Trajectory) -> dict[str, Array]:
        """Place [m] and velocity [m/s] at the samples, each (T,)."""
        return _plane.observe(trajectory)

    def truth(self, p: Parameters) -> Truth:
        """Exponentials of the two roots, in the complex plane z = x + i y."""
        from refdem.truth.closed_forms.whirling_shaft import truth

        return truth(p, {q.name: q.scale for q in self.quantities(p)})


def _roots(p: Parameters) -> NDArray[np.complex128]:
    """Both roots (2,) [1/s] of q^2 + 2 b q + w0^2 - i n = 0, 2 b = (c_e + c_i)/m, n = c_i W/m."""
    twice_b = (p.outer_damping + p.inner_damping) / p.mass
    push = p.inner_damping * p.turning / p.mass
    roots = np.roots([1.0, twice_b, p.stiffness / p.mass - 1j * push])
    return roots.astype(np.complex128)


CASE = WhirlingShaft()
