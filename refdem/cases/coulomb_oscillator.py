"""An oscillator with dry friction, which stops for ever: m x'' + f Sgn(x') + k x = 0 (1.97)."""

from refdem.cases import _line
from refdem.cases._line import Array
from refdem.core.case import NEVER, Case
from refdem.core.parameters import Parameter, Parameters
from refdem.core.quantity import Quantity, Scales
from refdem.core.trajectory import Trajectory
from refdem.core.truth import Truth
from refdem.scene import Scene
from refdem.scene.elements.slider import Slider


class CoulombOscillator(Case):
    """A mass on a spring along x, dry friction against the world."""

    id = "coulomb-oscillator"
    title = "Coulomb oscillator"
    words = ("friction", "dry", "spring", "stop", "damping")
    motion = "rubbing"
    statement = (
        "A mass on a spring rubs on the ground with a force of constant size. Every half cycle is"
        " harmonic about a shifted centre and loses 2 f/k of amplitude, until at a turning point"
        " the spring is no stronger than friction: there it stays, exactly."
    )
    latex = r"m\ddot x+f\,\mathrm{Sgn}(\dot x)+kx\ni 0,\qquad \mathrm{Sgn}(0)=[-1,1]"
    source = (
        "Matuttis and Chen 2014, chapter 1, (1.97)-(1.100), figs. 1.15 and 1.20; stops if and only"
        " if k|x| <= f"
    )
    parameters = (
        _line.MASS,
        _line.STIFFNESS,
        Parameter(
            name="friction_force",
            default="0.15",
            unit="N",
            doc="size of the dry friction",
            at_least=0,
        ),
        *_line.START,
    )
    chaotic_at = NEVER

    def refuse(self, p: Parameters) -> None:
        """Raises UsageError if there is no length to compare with."""
        _line.refuse_nothing(self.scales(p).length)

    def scene(self, p: Parameters) -> Scene:
        """The mass on its spring, and a slider: m x'' = -k x - f Sgn(x').

        The slider is pressed with 1 N, so that its coefficient is the friction force f.
        """
        friction = []
        if p.friction_force:
            friction.append(Slider(a=0, friction=p.friction_force, normal_force=1.0))
        return _line.scene(p, *friction)

    def scales(self, p: Parameters) -> Scales:
        """The scales of the motion; its length is the amplitude at the start."""
        return _line.scales(p)

    def quantities(self, p: Parameters) -> tuple[Quantity, ...]:
        """The quantities that are judged: place [m] and velocity [m/s]."""
        return _line.quantities(self.scales(p))

    def observe(self, p: Parameters, trajectory: Trajectory) -> dict[str, Array]:
        """The place [m] and the velocity [m/s] at the samples, each (T,)."""
        return _line.observe(trajectory)

    def truth(self, p: Parameters) -> Truth:
        """The certified motion: half cycles with exact turning points."""
        from refdem.truth.closed_forms.coulomb_oscillator import truth

        return truth(p, {q.name: q.scale for q in self.quantities(p)})


CASE = CoulombOscillator()
