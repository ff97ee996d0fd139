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

BEGIN = 1e-14
"""The slip with which one begins [m/s]: a zero at its very start would be taken for its end."""


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
        slip: Callable[..., Any],
        stick: Callable[..., Any],
    ) -> list[float]:
        """Places > 0 [m] at which v = 0 after `skip` of the periods, from x = v = 0.

        slip(t, x, u, side, end, frequency) -> (t, x, places with times), stick(t, pull, end,
        frequency) -> t.
        """
        t = 0.0
        x = -self.anchor
        u = -self.slider.belt_velocity
        end = 2 * math.pi / frequency * periods
        begin = 2 * math.pi / frequency * skip
        places = []
        # The side to which the mass slips, the sign of u; stick and slip alternate from here on.
        side = math.copysign(1.0, u)
        while True:
            t, x, passed = slip(t, x, u, side, end, frequency)
            places += [place for when, place in passed if when >= begin and place > 0]
            if t < end and abs(self.pull(t, frequency, x)) <= self.limit:
                before = t
                t = stick(t, self.pull(t, frequency, x), end, frequency)
                x += self.slider.belt_velocity * (t - before)
            if t >= end:
                return places
            side = math.copysign(1.0, self.pull(t, frequency, x))
            u = side * BEGIN


def by_heyoka(belt: Belt, tolerance: float) -> tuple[Callable[..., Any], Callable[..., Any]]:
    """heyoka's slip and stick, as `Belt.walked` calls them: integrators compiled once for all
    frequencies, with the frequency and the side of the slip as parameters.
    """
    import heyoka

    x, u = heyoka.make_vars("x", "u")
    pulled = heyoka.make_vars("p")
    w = heyoka.par[0]
    side = heyoka.par[1]
    speed = belt.slider.belt_velocity
    passed: list[tuple[float, float]] = []

    def seen(integrator: Any, when: float, direction: int) -> None:
        passed.append((when, float(integrator.update_d_output(when)[0]) + belt.anchor))

    # x' = u + belt, u' = F cos(w t) - x - side N mu(side u), with m = k = 1.
    drive = belt.amplitude * heyoka.cos(w * heyoka.time)
    acceleration = drive - x - side * belt.friction(side * u)
    rates = [(x, u + speed), (u, acceleration)]
    down = heyoka.event_direction.negative
    up = heyoka.event_direction.positive
    stops = [heyoka.t_event(side * u, direction=down)]
    turns = [heyoka.nt_event(u + speed, callback=seen)]
    slips = heyoka.taylor_adaptive(
        rates, [0.0, 0.0], pars=[1.0, 1.0], t_events=stops, nt_events=turns, tol=tolerance
    )
    # While it sticks x' = belt: the pull P = F cos(w t) - x has P' = -F w sin(w t) - belt.
    held = [(pulled, -belt.amplitude * w * heyoka.sin(w * heyoka.time) - speed)]
    limits = [
        heyoka.t_event(pulled - belt.limit, direction=up),
        heyoka.t_event(pulled + belt.limit, direction=down),
    ]
    sticks = heyoka.taylor_adaptive(held, [0.0], pars=[1.0], t_events=limits, tol=tolerance)

    def slip(
        t: float, x: float, u: float, side: float, end: float, frequency: float
    ) -> tuple[float, float, list[tuple[float, float]]]:
        passed.clear()
        slips.time = t
        slips.state[:] = (x, u)
        slips.pars[:] = (frequency, side)
        slips.propagate_until(end)
        return slips.time, float(slips.state[0]), list(passed)

    def stick(t: float, pull: float, end: float, frequency: float) -> float:
        sticks.time = t
        sticks.state[0] = pull
        sticks.pars[0] = frequency
        sticks.propagate_until(end)
        return float(sticks.time)

    return slip, stick


def by_scipy(belt: Belt, tolerance: float) -> tuple[Callable[..., Any], Callable[..., Any]]:
    """SciPy's DOP853 with its events, as `Belt.walked` calls it; the right-hand side in Python.

    A tolerance below 2.3e-14 is one that DOP853 does not take.
    """
    from scipy.integrate import solve_ivp

    given = {"method": "DOP853", "rtol": max(tolerance, 2.3e-14), "atol": tolerance}
    speed = belt.slider.belt_velocity

    def slip(
        t: float, x: float, u: float, side: float, end: float, frequency: float
    ) -> tuple[float, float, list[tuple[float, float]]]:
        def rates(now: float, y: np.ndarray) -> tuple[float, float]:
            x, u = y
            # x' = u + belt, u' = pull - side N mu(side u), with m = k = 1.
            friction = side * belt.friction(side * u)
            return u + speed, belt.pull(now, frequency, x) - friction

        def stops(now: float, y: np.ndarray) -> float:
            _, u = y
            return float(side * u)

        def turns(now: float, y: np.ndarray) -> float:
            _, u = y
            return float(u + speed)

        # A slip ends where u comes to 0 from its side; turning points, v = u + belt = 0, go on.
        stops.terminal = True  # type: ignore[attr-defined]
        stops.direction = -1  # type: ignore[attr-defined]
        solution = solve_ivp(rates, (t, end), (x, u), events=(stops, turns), **given)
        passed = [
            (float(when), float(y[0]) + belt.anchor)
            for when, y in zip(solution.t_events[1], solution.y_events[1], strict=True)
        ]
        return float(solution.t[-1]), float(solution.y[0, -1]), passed

    def stick(t: float, pull: float, end: float, frequency: float) -> float:
        def rates(now: float, y: np.ndarray) -> tuple[float]:
            return (-belt.amplitude * frequency * math.sin(frequency * now) - speed,)

        def passes(now: float, y: np.ndarray) -> float:
            return float(belt.limit - abs(y[0]))

        passes.terminal = True  # type: ignore[attr-defined]
        passes.direction = -1  # type: ignore[attr-defined]
        solution = solve_ivp(rates, (t, end), (pull,), events=passes, **given)
        return float(solution.t[-1])

    return slip, stick
