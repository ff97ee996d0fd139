"""The oscillator whose spring pulls with a power of its stretch (1.113): the period depends on the
amplitude.
"""

import numpy as np

from refdem.cases import _line
from refdem.cases._line import Array
from refdem.core.case import NEVER, Case
from refdem.core.parameters import Parameter, Parameters
from refdem.core.quantity import Quantity, Scales
from refdem.core.trajectory import Trajectory
from refdem.core.truth import Truth
from refdem.scene import Body, Scene
from refdem.scene.elements.spring import Spring


class PowerOscillator(Case):
    """A mass on a power-law spring along x, let go at `amplitude`."""

    id = "power-oscillator"
    title = "Power-law oscillator"
    words = ("nonlinear", "spring", "hertz", "stiffness")
    motion = "oscillating"
    statement = (
        "A spring pulls with a power n of its stretch. With n = 1 the period does not depend on the"
        " amplitude; with n > 1 it falls as A^((1 - n)/2): for n = 2 it is 2 pi at A = 1.195254."
    )
    latex = (
        r"m\ddot x+k|x|^n\,\mathrm{sgn}\,x=0,\qquad"
        r" T=4\sqrt{\frac{m}{2k(n+1)}}\,A^{(1-n)/2}\,B\left(\tfrac1{n+1},\tfrac12\right)"
    )
    source = "Matuttis and Chen 2014, chapter 1, (1.113), fig. 1.21"
    parameters = (
        _line.MASS,
        Parameter(name="stiffness", default="1", unit="N/m^n", doc="the spring", above=0),
        Parameter(
            name="exponent",
            default="3/2",
            unit="1",
            doc="n, the power of the stretch",
            at_least=1,
            at_most=9,
        ),
        Parameter(
            name="amplitude", default="1", unit="m", doc="place at the start, where it is at rest"
        ),
    )
    chaotic_at = NEVER

    def refuse(self, p: Parameters) -> None:
        """Raises UsageError if nothing would ever move."""
        _line.refuse_nothing(abs(p.amplitude), "amplitude")

    def scene(self, p: Parameters) -> Scene:
        """The mass at rest on a spring of natural length 0: m x'' = -k |x|^n sgn x."""
        point = Body(mass=p.mass, position=(p.amplitude, 0.0, 0.0))
        return Scene.of([point], [Spring(a=0, stiffness=p.stiffness, exponent=p.exponent)])

    def scales(self, p: Parameters) -> Scales:
        """L is the amplitude A; 1/tau^2 = n k A^(n-1)/m, from the largest stiffness on the way."""
        steepest = p.exponent * p.stiffness * abs(p.amplitude) ** (p.exponent - 1)
        tau = float(np.sqrt(p.mass / steepest))
        return Scales(length=abs(p.amplitude), tau=tau, duration=20 * tau, mass=p.mass)

    def quantities(self, p: Parameters) -> tuple[Quantity, ...]:
        """The quantities that are judged: position [m] and velocity [m/s]."""
        return _line.quantities(self.scales(p))

    def observe(self, p: Parameters, trajectory: Trajectory) -> dict[str, Array]:
        """The position [m] and the velocity [m/s] at the samples, each (T,)."""
        return _line.observe(trajectory)

    def truth(self, p: Parameters) -> Truth:
        """The certified motion, by inverse incomplete beta functions."""
        from refdem.truth.closed_forms.power_oscillator import truth

        return truth(p, {q.name: q.scale for q in self.quantities(p)})


CASE = PowerOscillator()
