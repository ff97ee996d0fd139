"""An oscillator with dry friction, which stops for ever: m x'' + f Sgn(x') + k x = 0 (1.97)."""

from refdem.cases import _line, _slope
from refdem.cases._line import Array
from refdem.core.case import NEVER, Case
from refdem.core.parameters import Parameter, Parameters
from refdem.core.quantity import Quantity, Scales
from refdem.core.trajectory import Trajectory
from refdem.core.truth import Truth
from refdem.errors import UsageError
from refdem.scene import Scene
from refdem.scene.elements.contact import Contact
from refdem.scene.elements.slider import Slider
from refdem.scene.elements.spring import Spring
from refdem.scene.elements.uniform_gravity import UniformGravity


class CoulombOscillator(Case):
    """A mass on a spring along x, dry friction against the world: of a slider, or of a floor on
    which a block lies.
    """

    id = "coulomb-oscillator"
    title = "Coulomb oscillator"
    words = ("friction", "dry", "spring", "stop", "damping")
    motion = "rubbing"
    statement = (
        "A mass on a spring rubs on the ground with a force of constant size. Every half cycle is"
        " harmonic about a shifted centre and loses 2 f/k of amplitude, until at a turning point"
        " the spring is no stronger than friction: there it stays, exactly. The mass is a point"
        " with an element of friction, or a block that its weight presses on a floor."
    )
    latex = r"m\ddot x+f\,\mathrm{Sgn}(\dot x)+kx\ni 0,\qquad \mathrm{Sgn}(0)=[-1,1]"
    source = (
        "Matuttis and Chen 2014, chapter 1, (1.97)-(1.100), figs. 1.15 and 1.20; stops if and only"
        " if k|x| <= f"
    )
    parameters = (
        Parameter(
            name="member",
            default="slider",
            unit="1",
            doc="what rubs: an element of friction, or a block on a floor",
            choices=("slider", "block"),
        ),
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
        Parameter(
            name="gravity",
            default="9.8125",
            unit="m/s^2",
            doc="what presses the block on its floor",
            above=0,
        ),
    )
    chaotic_at = NEVER

    def refuse(self, p: Parameters) -> None:
        """Raises UsageError if there is no length to compare with, and for a block that would tip.

        The spring pulls at the height of the block's centre, so that friction alone has a torque
        about it, at most f h/2, and the floor's force m g acts at most f h/(2 m g) from the middle
        of the base, of width w. The block does not tip while f h < m g w; it never lifts, since all
        that acts along the normal is its weight and the floor.
        """
        _line.refuse_nothing(self.scales(p).length)
        width, height, _ = _slope.SIDES
        if p.member == "block" and not p.friction_force * height < p.mass * p.gravity * width:
            raise UsageError(
                f"parameter friction_force: got {p.friction_force:g} N; expected less than"
                f" {p.mass * p.gravity * width / height:g} N, beyond which the block tips"
            )

    def scene(self, p: Parameters) -> Scene:
        """The mass on its spring, and what rubs: m x'' = -k x - f Sgn(x').

        The slider is pressed with 1 N, so that its coefficient is the friction force f.
        """
        if p.member == "block":
            return _floor(p)
        friction = []
        if p.friction_force:
            friction.append(Slider(a=0, friction=p.friction_force, normal_force=1.0))
        return _line.scene(p, *friction)

    def scales(self, p: Parameters) -> Scales:
        """The scales of the motion; its length is the amplitude at the start."""
        return _line.scales(p)

    def quantities(self, p: Parameters) -> tuple[Quantity, ...]:
        """The quantities that are judged: position [m] and velocity [m/s]."""
        return _line.quantities(self.scales(p))

    def observe(self, p: Parameters, trajectory: Trajectory) -> dict[str, Array]:
        """The position [m] and the velocity [m/s] at the samples, each (T,)."""
        return _line.observe(trajectory)

    def truth(self, p: Parameters) -> Truth:
        """The certified motion: half cycles with exact turning points."""
        from refdem.truth.closed_forms.coulomb_oscillator import truth

        return truth(p, {q.name: q.scale for q in self.quantities(p)})


def _floor(p: Parameters) -> Scene:
    """A block on the floor y = 0, and a spring that pulls its centre to x = 0 at its own height.

    Its weight m g presses it, so that f/(m g) is the coefficient of friction.
    """
    coefficient = p.friction_force / (p.mass * p.gravity)
    return Scene.of(
        [_slope.block(p.mass, p.x0, p.v0)],
        [
            Spring(a=0, stiffness=p.stiffness, anchor_b=(0.0, _slope.height(), 0.0)),
            _slope.PLANE,
            UniformGravity(g=(0.0, -p.gravity, 0.0)),
            Contact(law="rigid", friction=coefficient),
        ],
    )


CASE = CoulombOscillator()
