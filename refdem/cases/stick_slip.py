"""The stick-slip oscillator: a driven mass on a spring and a moving belt, with Stribeck friction
(1.125).
"""

from fractions import Fraction
from typing import Any

from refdem.cases import _line
from refdem.cases._line import Array
from refdem.core.case import Case, given
from refdem.core.parameters import Parameter, Parameters
from refdem.core.quantity import Quantity, Scales
from refdem.core.trajectory import Trajectory
from refdem.core.truth import Truth
from refdem.scene import Body, Scene
from refdem.scene.elements.force import Force
from refdem.scene.elements.slider import Slider
from refdem.scene.elements.spring import Spring

LAWS = {"quadratic": "stribeck", "linear": "stribeck_linear"}
MOST_FADING = 4.0
"""Rate at which static friction fades with the speed, in units of 1/tau, at most: a step of tau/16
then sees it change by at most a quarter.
"""


class StickSlip(Case):
    """A unit mass on a unit spring along x; the belt's steady pull a mu(belt) shifts the spring's
    anchor.
    """

    id = "stick-slip"
    title = "Stick-slip oscillator"
    words = ("friction", "belt", "brake", "squeal", "stribeck")
    motion = "rubbing"
    statement = (
        "A driven mass on a spring rubs on a belt. It sticks, moving exactly as the belt, while the"
        " pull P of spring and drive is at most a mu0; it is released when P passes that limit and"
        " then slips, the friction falling with the speed (Stribeck). Settled by measurement"
        " against figs. 1.29-1.31: the last term is quadratic (with gamma = 0.5 x keeps within"
        " -2.9..2.8, v within -2.8..1; linear, x reaches -4.4 and v -3.6, outside the figures)."
        " With gamma = 0.5 no eta of 500 in 0.9..2.5 has an exponent above zero: periodic windows"
        " and quasi-periodic motion; chaos between windows begins near gamma = 0.6 (0.7: 1 of 8 eta"
        " in 0.9..1.5)."
    )
    latex = r"\ddot x\in\gamma\cos\eta t-x-a\,\mu(b)-a\,\mu(|u|)\,\mathrm{Sgn}(u),\quad u=\dot x-b"
    source = "Matuttis and Chen 2014, section 1.6.2, (1.125), (1.126), figs. 1.27-1.31"
    parameters = (
        Parameter(name="a", default="10", unit="N", doc="normal force", above=0),
        Parameter(name="mu0", default="0.4", unit="1", doc="static friction", above=0),
        Parameter(name="mu1", default="0.1", unit="1", doc="dynamic friction", at_least=0),
        Parameter(
            name="lambda0",
            default="1.42",
            unit="s/m",
            doc="how fast static friction fades",
            at_least=0,
        ),
        Parameter(
            name="lambda1",
            default="0.01",
            unit="s^2/m^2",
            doc="how fast friction grows (s/m if linear)",
            at_least=0,
        ),
        Parameter(
            name="friction_law",
            default="quadratic",
            unit="",
            doc="last term of mu",
            choices=tuple(LAWS),
        ),
        Parameter(name="belt", default="1", unit="m/s", doc="velocity of the belt"),
        Parameter(name="gamma", default="0.5", unit="N", doc="amplitude of the drive"),
        Parameter(
            name="eta", default="1.2", unit="rad/s", doc="frequency of the drive", at_least=0
        ),
        Parameter(name="x0", default="0", unit="m", doc="place at the start"),
        Parameter(name="v0", default="0", unit="m/s", doc="velocity at the start"),
    )
    chaotic_at = given(
        friction_law="linear",
        gamma="2",
        eta="1.06",
        x0="1",
        v0="1/2",
        duration="160",
        samples="320",
    )

    def slider(self, p: Parameters) -> Slider:
        """The slider: the moving belt with Stribeck friction, or Coulomb friction mu0 if the
        coefficient does not depend on the speed.
        """
        depends_on_speed = p.lambda1 or (p.lambda0 and p.mu0 != p.mu1)
        if depends_on_speed:
            law = {
                "law": LAWS[p.friction_law],
                "mu0": p.mu0,
                "mu1": p.mu1,
                "lambda0": p.lambda0,
                "lambda1": p.lambda1,
            }
        else:
            law = {"friction": p.mu0}
        return Slider(a=0, normal_force=p.a, belt_velocity=p.belt, **law)

    def scene(self, p: Parameters) -> Scene:
        """The mass with spring, belt and drive: x'' in -(x + a mu(b)) - a mu(|u|) Sgn(u) + gamma
        cos(eta t), with the belt's velocity b and u = x' - b.
        """
        slider = self.slider(p)
        # The constant force -a mu(belt) of (1.125) is a shift of the anchor of the unit spring.
        steady_pull = p.a * slider.coefficient(abs(p.belt))
        spring = Spring(a=0, stiffness=1.0, anchor_b=(-steady_pull, 0.0, 0.0))
        point = Body(mass=1.0, position=(p.x0, 0.0, 0.0), velocity=(p.v0, 0.0, 0.0))
        if p.gamma:
            drive = [Force(a=0, amplitude=p.gamma, frequency=p.eta)]
        else:
            drive = []
        return Scene.of([point], [spring, slider, *drive])

    def scales(self, p: Parameters) -> Scales:
        """L = a mu0 + |gamma| + |x0| + |v0|, the stretch that balances friction, drive and start;
        tau is the shortest time of spring, drive and friction; T = 20 of the shorter time of spring
        and drive. A belt that runs backwards does not balance its steady pull but doubles it: the
        mass then comes to rest at -2 a mu(|b|).

        Friction that grows with the speed damps the motion at the rate a dmu/du, that is 2 a
        lambda1 u (a lambda1 if linear). The largest u is that of the start or, as the mass comes
        back, that of the belt and of what friction, drive and the place at the start make.

        Static friction fades from mu0 at the rate a (mu0 - mu1) lambda0. A step that is long
        against that jumps over the speeds at which the mass sticks. Where mu1 is the larger one,
        this friction damps, too.
        """
        oscillation = max(1.0, p.eta)
        coefficient = p.mu0
        if p.belt < 0:
            coefficient = max(p.mu0, 2.0 * self.slider(p).coefficient(abs(p.belt)))
        swing = p.a * coefficient + abs(p.gamma) + abs(p.x0)
        fastest = max(abs(p.v0 - p.belt), abs(p.belt) + swing)
        damping = p.a * p.lambda1
        if p.friction_law == "quadratic":
            damping *= 2.0 * fastest
        fading = p.a * (p.mu0 - p.mu1) * p.lambda0
        return Scales(
            length=swing + abs(p.v0),
            tau=1.0 / max(oscillation, damping - min(fading, 0.0), fading / MOST_FADING),
            duration=20.0 / oscillation,
        )

    def quantities(self, p: Parameters) -> tuple[Quantity, ...]:
        """The quantities that are judged: position [m] and velocity [m/s]."""
        return _line.quantities(self.scales(p))

    def observe(self, p: Parameters, trajectory: Trajectory) -> dict[str, Array]:
        """The position [m] and the velocity [m/s] at the samples, each (T,)."""
        return _line.observe(trajectory)

    def truth(self, p: Parameters) -> Truth:
        """Validated integration from event to event."""
        from refdem.truth.closed_forms.stick_slip import truth

        duration: Any = p["duration"]
        eta: Any = p["eta"]
        # The default duration of `scales`, 20 tau, as an exact number.
        until = duration or 20 / max(Fraction(1), eta)
        return truth(p, {q.name: q.scale for q in self.quantities(p)}, until)


CASE = StickSlip()
