"""The section of a point on a belt that is driven, by the peers: Stribeck's law between events, the
drive at many frequencies.

A slip, x' = u + belt, m u' = pull - side N mu(side u), ends at side u = 0; the section counts v = 0
on its way. Sticking, the pull alone is followed, P' = -F w sin(w t) - k belt, to where it passes
the limit.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from refdem.scene import Scene
from refdem.scene.elements.force import Force
from refdem.scene.elements.slider import Slider
from refdem.scene.elements.spring import Spring

Slip = Callable[
    [float, float, float, float, float, float], tuple[float, float, list[tuple[float, float]]]
]
"""slip(t, x, u, side, end, frequency) -> (t, x, crossings): follows a slip from time t to its end,
or to the time `end`; the crossings of v = 0 on its way are pairs of time and place.
"""
Stick = Callable[[float, float, float, float], float]
"""stick(t, pull, end, frequency) -> t: the time at which the pull passes the limit, or `end`."""
BEGIN = 1e-14
"""Initial slip velocity [m/s]; a slip that starts at 0 would be taken for one that ends."""


@dataclass(frozen=True)
class Belt:
    """Unit mass and spring; places from the spring's anchor."""

    slider: Slider
    amplitude: float
    anchor: float

    @classmethod
    def of(cls, scene: Scene) -> "Belt":
        """The belt of a scene of the case stick-slip."""
        (slider,) = scene.all(Slider)
        (drive,) = scene.all(Force)
        (spring,) = scene.all(Spring)
        return cls(slider, amplitude=drive.amplitude, anchor=spring.anchor_b[0])

    @property
    def limit(self) -> float:
        """The largest force [N] that static friction can balance."""
        return self.slider.normal_force * self.slider.mu0

    def friction(self, w: Any) -> Any:
        """N mu at the speed w of a slip, for numbers and symbols."""
        # mu(w) = (mu0 - mu1)/(1 + lambda0 w) + mu1 + lambda1 w^2 (1.126).
        s = self.slider
        falling = (s.mu0 - s.mu1) / (1.0 + s.lambda0 * w)
        mu = falling + s.mu1 + s.lambda1 * w * w
        return s.normal_force * mu

    def pull(self, t: float, frequency: float, x: float) -> float:
        """The force [N] of the spring and the drive at time t."""
        return self.amplitude * math.cos(frequency * t) - x

    def walked(
        self,
        frequency: float,
        periods: int,
        skip: int,
        slip: Slip,
        stick: Stick,
    ) -> list[float]:
        """Places > 0 [m] at which v = 0 after `skip` of the periods, from x = v = 0."""
        t = 0.0
        x = -self.anchor
        u = -self.slider.belt_velocity
        end = 2 * math.pi / frequency * periods
        begin = 2 * math.pi / frequency * skip
        places = []
        # The side to which the mass slips, the sign of u; stick and slip alternate from here on.
        side = math.copysign(1.0, u)
        while True:
            t, x, crossings = slip(t, x, u, side, end, frequency)
            places += [place for time, place in crossings if time >= begin and place > 0]
            if t < end and abs(self.pull(t, frequency, x)) <= self.limit:
                stick_begin = t
                t = stick(t, self.pull(t, frequency, x), end, frequency)
                x += self.slider.belt_velocity * (t - stick_begin)
            if t >= end:
                return places
            side = math.copysign(1.0, self.pull(t, frequency, x))
            u = side * BEGIN


def by_heyoka(belt: Belt, tolerance: float) -> tuple[Slip, Stick]:
    """heyoka's slip and stick: integrators compiled once for all frequencies, with the frequency
    and the side of the slip as parameters.
    """
    return _slip_by_heyoka(belt, tolerance), _stick_by_heyoka(belt, tolerance)


def _slip_by_heyoka(belt: Belt, tolerance: float) -> Slip:
    """heyoka's slip: par[0] is the frequency of the drive, par[1] the side."""
    import heyoka

    x, u = heyoka.make_vars("x", "u")
    w = heyoka.par[0]
    side = heyoka.par[1]
    speed = belt.slider.belt_velocity
    crossings: list[tuple[float, float]] = []

    def record_crossing(integrator: Any, t: float, direction: int) -> None:
        crossings.append((t, float(integrator.update_d_output(t)[0]) + belt.anchor))

    # x' = u + belt, u' = F cos(w t) - x - side N mu(side u), with m = k = 1.
    drive = belt.amplitude * heyoka.cos(w * heyoka.time)
    acceleration = drive - x - side * belt.friction(side * u)
    falling = heyoka.event_direction.negative
    integrator = heyoka.taylor_adaptive(
        [(x, u + speed), (u, acceleration)],
        [0.0, 0.0],
        pars=[1.0, 1.0],
        t_events=[heyoka.t_event(side * u, direction=falling)],
        nt_events=[heyoka.nt_event(u + speed, callback=record_crossing)],
        tol=tolerance,
    )

    def slip(
        t: float, x: float, u: float, side: float, end: float, frequency: float
    ) -> tuple[float, float, list[tuple[float, float]]]:
        crossings.clear()
        integrator.time = t
        integrator.state[:] = (x, u)
        integrator.pars[:] = (frequency, side)
        integrator.propagate_until(end)
        return integrator.time, float(integrator.state[0]), list(crossings)

    return slip


def _stick_by_heyoka(belt: Belt, tolerance: float) -> Stick:
    """heyoka's stick: par[0] is the frequency of the drive."""
    import heyoka

    pull = heyoka.make_vars("p")
    w = heyoka.par[0]
    # While it sticks x' = belt: the pull P = F cos(w t) - x has P' = -F w sin(w t) - belt.
    speed = belt.slider.belt_velocity
    rates = [(pull, -belt.amplitude * w * heyoka.sin(w * heyoka.time) - speed)]
    limits = [
        heyoka.t_event(pull - belt.limit, direction=heyoka.event_direction.positive),
        heyoka.t_event(pull + belt.limit, direction=heyoka.event_direction.negative),
    ]
    integrator = heyoka.taylor_adaptive(rates, [0.0], pars=[1.0], t_events=limits, tol=tolerance)

    def stick(t: float, pull: float, end: float, frequency: float) -> float:
        integrator.time = t
        integrator.state[0] = pull
        integrator.pars[0] = frequency
        integrator.propagate_until(end)
        return float(integrator.time)

    return stick


def by_scipy(belt: Belt, tolerance: float) -> tuple[Slip, Stick]:
    """SciPy's slip and stick, DOP853 with its events; the right-hand side is in Python."""
    # DOP853 accepts no relative tolerance below 2.3e-14.
    options = {"method": "DOP853", "rtol": max(tolerance, 2.3e-14), "atol": tolerance}
    return _slip_by_scipy(belt, options), _stick_by_scipy(belt, options)


def _slip_by_scipy(belt: Belt, options: dict[str, Any]) -> Slip:
    """SciPy's slip, with these options of solve_ivp."""
    from scipy.integrate import solve_ivp

    speed = belt.slider.belt_velocity

    def slip(
        t: float, x: float, u: float, side: float, end: float, frequency: float
    ) -> tuple[float, float, list[tuple[float, float]]]:
        def rates(t: float, y: np.ndarray) -> tuple[float, float]:
            x, u = y
            # x' = u + belt, u' = pull - side N mu(side u), with m = k = 1.
            friction = side * belt.friction(side * u)
            return u + speed, belt.pull(t, frequency, x) - friction

        def stops(t: float, y: np.ndarray) -> float:
            _, u = y
            return float(side * u)

        def turns(t: float, y: np.ndarray) -> float:
            _, u = y
            return float(u + speed)

        # A slip ends where u comes to 0 from its side; turning points, v = u + belt = 0, go on.
        stops.terminal = True  # type: ignore[attr-defined]
        stops.direction = -1  # type: ignore[attr-defined]
        solution = solve_ivp(rates, (t, end), (x, u), events=(stops, turns), **options)
        _, turn_times = solution.t_events
        _, turn_states = solution.y_events
        crossings = []
        for turn_time, y in zip(turn_times, turn_states, strict=True):
            crossings.append((float(turn_time), float(y[0]) + belt.anchor))
        return float(solution.t[-1]), float(solution.y[0, -1]), crossings

    return slip


def _stick_by_scipy(belt: Belt, options: dict[str, Any]) -> Stick:
    """SciPy's stick, with these options of solve_ivp."""
    from scipy.integrate import solve_ivp

    speed = belt.slider.belt_velocity

    def stick(t: float, pull: float, end: float, frequency: float) -> float:
        def rates(t: float, y: np.ndarray) -> tuple[float]:
            # P' = -F w sin(w t) - belt.
            return (-belt.amplitude * frequency * math.sin(frequency * t) - speed,)

        def passes(t: float, y: np.ndarray) -> float:
            return float(belt.limit - abs(y[0]))

        passes.terminal = True  # type: ignore[attr-defined]
        passes.direction = -1  # type: ignore[attr-defined]
        solution = solve_ivp(rates, (t, end), (pull,), events=passes, **options)
        return float(solution.t[-1])

    return stick
