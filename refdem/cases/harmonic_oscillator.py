"""The harmonic oscillator, also hanging in gravity (1.92)."""

from refdem.cases import _line
from refdem.cases._line import Array
from refdem.core.case import NEVER, Case
from refdem.core.parameters import Parameter, Parameters
from refdem.core.quantity import Quantity, Scales
from refdem.core.trajectory import Trajectory
from refdem.core.truth import Truth
from refdem.scene import Scene
from refdem.scene.elements.uniform_gravity import UniformGravity


class HarmonicOscillator(Case):
    """A mass on a spring along x; gravity, if any, along +x."""

    id = "harmonic-oscillator"
    title = "Harmonic oscillator"
    words = ("spring", "vibration", "wave", "hooke")
    motion = "oscillating"
    statement = (
        "A mass on a linear spring moves to and fro in a time that does not depend on the"
        " amplitude. Gravity along the spring shifts the equilibrium by m g/k and changes nothing"
        " else."
    )
    latex = (
        r"m\ddot x+kx=mg,\qquad"
        r" x=\frac{mg}{k}+\left(x_0-\frac{mg}{k}\right)\cos\omega_0t"
        r"+\frac{v_0}{\omega_0}\sin\omega_0t"
    )
    source = "Matuttis and Chen 2014, chapter 1, (1.92), figs. 1.14a and 1.15; w0 = sqrt(k/m)"
    parameters = (
        _line.MASS,
        _line.STIFFNESS,
        Parameter(name="gravity", default="0", unit="m/s^2", doc="along +x"),
        *_line.START,
    )
    chaotic_at = NEVER

    def refuse(self, p: Parameters) -> None:
        """Raises UsageError if nothing would ever move."""
        _line.refuse_nothing(self.scales(p).length)

    def scene(self, p: Parameters) -> Scene:
        """The mass on its spring, with gravity where there is some: m x'' = -k x + m g."""
        weight = []
        if p.gravity:
            weight.append(UniformGravity(g=(p.gravity, 0.0, 0.0)))
        return _line.scene(p, *weight)

    def scales(self, p: Parameters) -> Scales:
        """L is the amplitude about the equilibrium plus its shift m g/k; tau = sqrt(m/k)."""
        return _line.scales(p, p.mass * p.gravity / p.stiffness)

    def quantities(self, p: Parameters) -> tuple[Quantity, ...]:
        """The quantities that are judged: position [m] and velocity [m/s]."""
        return _line.quantities(self.scales(p))

    def observe(self, p: Parameters, trajectory: Trajectory) -> dict[str, Array]:
        """The position [m] and the velocity [m/s] at the samples, each (T,)."""
        return _line.observe(trajectory)

    def truth(self, p: Parameters) -> Truth:
        """The truth in closed form, by sine and cosine."""
        from refdem.truth.closed_forms.harmonic_oscillator import truth

        return truth(p, {q.name: q.scale for q in self.quantities(p)})


CASE = HarmonicOscillator()
