"""A mass on a spring with dry friction, between events: m x'' = -k x - f s with s the direction in
which it slides.
"""

from dataclasses import dataclass
from typing import Any

from refdem.scene import Scene
from refdem.scene.elements.slider import Slider
from refdem.scene.elements.spring import Spring


@dataclass(frozen=True)
class Coulomb:
    """Place [m] and speed [m/s] at the start, k/m [1/s^2] and f/m [m/s^2]."""

    place: float
    speed: float
    stiffness: float
    friction: float

    @property
    def direction(self) -> float:
        """The sign of the velocity, or of where the spring pulls from rest."""
        towards = self.speed or -self.place
        if towards > 0:
            return 1.0
        return -1.0

    def integrator(self, tolerance: float | None) -> Any:
        """heyoka's integrator, which stops at a turning point where friction holds and else turns
        round.
        """
        import heyoka

        x, v = heyoka.make_vars("x", "v")

        def turned(integrator: Any, sign: int) -> bool:
            place = float(integrator.state[0])
            if place > 0:
                integrator.pars[0] = -1.0
            else:
                integrator.pars[0] = 1.0
            return abs(self.stiffness * place) > self.friction

        acceleration = -self.stiffness * x - self.friction * heyoka.par[0]
        rates = [(x, v), (v, acceleration)]
        start = [self.place, self.speed]
        events = [heyoka.t_event(v, callback=turned)]
        return heyoka.taylor_adaptive(
            rates, start, pars=[self.direction], t_events=events, tol=tolerance
        )


def coulomb(scene: Scene) -> Coulomb | None:
    """The oscillator, if the scene is one along x whose spring has no natural length."""
    kinds = sorted(element.kind for element in scene.elements)
    if len(scene.bodies) != 1 or kinds != ["slider", "spring"]:
        return None
    (spring,) = scene.all(Spring)
    (slider,) = scene.all(Slider)
    bodies = scene.bodies
    aside = (
        *bodies.position[0, 1:],
        *bodies.velocity[0, 1:],
        *spring.anchor_a,
        *spring.anchor_b,
        spring.length,
    )
    curved = (
        spring.quadratic
        or spring.cubic
        or spring.exponent != 1
        or slider.belt_velocity
        or slider.law != "coulomb"
    )
    if any(aside) or curved or spring.b >= 0 or slider.b >= 0 or slider.axis != (1.0, 0.0, 0.0):
        return None
    mass = float(bodies.mass[0])
    return Coulomb(
        place=float(bodies.position[0, 0]),
        speed=float(bodies.velocity[0, 0]),
        stiffness=spring.stiffness / mass,
        friction=slider.friction * slider.normal_force / mass,
    )
