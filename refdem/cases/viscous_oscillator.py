"""The oscillator damped in proportion to its velocity (1.95), in all three regimes, also hanging in
a fluid.
"""

from dataclasses import replace

from refdem.cases import _line
from refdem.cases._line import Array
from refdem.core.case import NEVER, Case
from refdem.core.parameters import Parameter, Parameters
from refdem.core.quantity import Quantity, Scales
from refdem.core.trajectory import Trajectory
from refdem.core.truth import Truth
from refdem.scene import Scene
from refdem.scene.elements.dashpot import Dashpot
from refdem.scene.elements.uniform_gravity import UniformGravity


class ViscousOscillator(Case):
    """A mass on a spring along x, a dashpot of 2 m delta, gravity along +x."""

    id = "viscous-oscillator"
    title = "Viscously damped oscillator"
    words = ("damping", "spring", "dashpot", "decay", "vibration")
    motion = "oscillating"
    statement = (
        "A mass on a spring moves in a fluid that resists in proportion to its velocity. Below"
        " critical damping it oscillates and its amplitude decays as exp(-delta t); at and above it"
        " creeps back. Any area of phase space shrinks as exp(-2 delta t)."
    )
    latex = (
        r"\ddot x+2\delta\dot x+\omega_0^2x=g,\qquad \delta=\frac{b}{2m},\quad\omega_0^2=\frac km"
    )
    source = (
        "Matuttis and Chen 2014, chapter 1, (1.95), (1.96) with the factor 2 that it lacks, figs."
        " 1.15 and 1.19"
    )
    parameters = (
        _line.MASS,
        _line.STIFFNESS,
        Parameter(name="gravity", default="0", unit="m/s^2", doc="along +x"),
        _line.DELTA,
        *_line.START,
    )
    chaotic_at = NEVER

    def refuse(self, p: Parameters) -> None:
        """Raises UsageError if nothing would ever move."""
        _line.refuse_nothing(self.scales(p).length)

    def scene(self, p: Parameters) -> Scene:
        """The mass on its spring, with dashpot and gravity where there are some: m x'' = -k x - 2 m
        delta x' + m g.
        """
        if p.delta:
            dashpot = [Dashpot(a=0, damping=2 * p.mass * p.delta)]
        else:
            dashpot = []
        if p.gravity:
            gravity = [UniformGravity(g=(p.gravity, 0.0, 0.0))]
        else:
            gravity = []
        return _line.scene(p, *dashpot, *gravity)

    def scales(self, p: Parameters) -> Scales:
        """The scales of the undamped motion, with 1/tau the larger of w0 and the over-damped decay
        (`_line.damped_rate`).
        """
        undamped = _line.scales(p, p.mass * p.gravity / p.stiffness)
        tau = 1 / _line.damped_rate(p.stiffness / p.mass, p.delta)
        return replace(undamped, tau=tau)

    def quantities(self, p: Parameters) -> tuple[Quantity, ...]:
        """The quantities that are judged: position [m] and velocity [m/s]."""
        return _line.quantities(self.scales(p))

    def observe(self, p: Parameters, trajectory: Trajectory) -> dict[str, Array]:
        """The position [m] and the velocity [m/s] at the samples, each (T,)."""
        return _line.observe(trajectory)

    def truth(self, p: Parameters) -> Truth:
        """Exponential times sine and cosine, or their limits."""
        from refdem.truth.closed_forms.viscous_oscillator import truth

        return truth(p, {q.name: q.scale for q in self.quantities(p)})


CASE = ViscousOscillator()
