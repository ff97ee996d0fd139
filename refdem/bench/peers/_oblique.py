"""Two spheres that touch, hold or slip, and part in a plane: equations between events, those of the
mode that a contact is in.

State: overlap d, its rate g, transverse velocity q of the second from the first, angle of the line
of centres, spins, tangential spring s.
"""

from dataclasses import dataclass
from time import perf_counter
from typing import Any

import numpy as np
from numpy.typing import NDArray

from refdem.core import discovery
from refdem.core.problem import Motion
from refdem.core.trajectory import Trajectory
from refdem.scene import Scene
from refdem.scene.elements.contact import Contact

Array = NDArray[np.float64]
BRANCH = {"R": 0.0, "R-d": 1.0, "R-d/2": 0.5}
HOLDS, SLIPS, FREE, APART = range(4)
INSIDE = 1 - 1e-14
"""A spring that begins to hold is shorter than its longest by this, so that no event is seen where
it begins.
"""


@dataclass(frozen=True, eq=False)
class Oblique:
    """A scene of two spheres that touch, centres along x, moving in the plane z = 0."""

    scene: Scene
    law: Contact

    @property
    def key(self) -> tuple[Any, ...]:
        """What the equations depend on."""
        bodies = self.scene.bodies
        return (
            self.law,
            *bodies.mass.tolist(),
            *bodies.radius.tolist(),
            *bodies.inertia[:, 0].tolist(),
        )

    @property
    def share(self) -> float:
        """The spring at its longest over the normal force [m/N]."""
        if self.law.friction:
            return self.law.friction / self.law.tangential_stiffness
        return 0.0

    def start(self) -> tuple[list[float], int, float]:
        """State, mode and side of the slip."""
        bodies = self.scene.bodies
        relative = bodies.velocity[1] - bodies.velocity[0]
        (p, r) = bodies.omega[:, 2]
        slip = float(bodies.radius[0] * p + bodies.radius[1] * r - relative[1])
        held = bool(self.law.damping) or abs(slip) <= self.share * self.law.stiffness * -relative[0]
        state = [0.0, -relative[0], relative[1], 0.0, p, r, 0.0]
        return (
            state,
            (HOLDS if held else SLIPS) if self.law.friction else FREE,
            1.0 if slip > 0 else -1.0,
        )

    def integrators(self, tolerance: float | None) -> list[Any]:
        """heyoka's integrators: the spring holds; it slips to the side of par[0]; no friction.

        Each stops at what ends it.
        """
        import heyoka

        bodies = self.scene.bodies
        law = self.law
        down = {"direction": heyoka.event_direction.negative}
        (r1, r2), (j1, j2) = bodies.radius.tolist(), bodies.inertia[:, 0].tolist()
        d, g, q, _, spin1, spin2, s = names = heyoka.make_vars("d", "g", "q", "a", "u", "v", "s")
        force = law.stiffness * d + law.damping * g
        side = heyoka.par[0]
        ease = float(np.sum(1 / bodies.mass))
        turn = q / (r1 + r2 - d)
        arm1 = r1 - BRANCH[law.branch] * d
        arm2 = r2 - BRANCH[law.branch] * d
        slip = arm1 * spin1 + arm2 * spin2 - q
        bend = -q * turn - ease * force
        ends = side * slip - self.share * (law.stiffness * g + law.damping * bend)
        watched = {
            HOLDS: [self.share * force - s, self.share * force + s],
            SLIPS: [ends, *([force] if law.damping else [])],
            FREE: [],
        }
        made = []
        for mode in (HOLDS, SLIPS, FREE) if law.friction else (FREE,):
            across = (-law.tangential_stiffness * s, -side * law.friction * force, 0.0)[mode]
            rates = [
                g,
                bend,
                g * turn - ease * across,
                turn,
                arm1 * across / j1,
                arm2 * across / j2,
                slip if mode == HOLDS else 0.0,
            ]
            events = [heyoka.t_event(what, **down) for what in (d, *watched[mode])]
            system = [
                (name, heyoka.expression(rate) if isinstance(rate, float) else rate)
                for name, rate in zip(names, rates, strict=True)
            ]
            made.append(
                heyoka.taylor_adaptive(
                    system, [0.0] * 7, pars=[1.0] * (mode == SLIPS), t_events=events, tol=tolerance
                )
            )
        return made

    def followed(self, integrators: list[Any], t: Array) -> tuple[list[Array], int, float]:
        """States in touch at the samples, then the one at which they part, if they do, with its
        time as last number; steps; seconds.

        The seconds are those of heyoka's own loops alone: what sets them up between events is no
        part of a compiled program's time.
        """
        state, mode, side = self.start()
        found = [np.array(state)]
        now = t[0]
        steps = 0
        seconds = 0.0
        while len(found) < len(t):
            integrator = integrators[mode if self.law.friction else 0]
            integrator.time = now
            integrator.state[:] = state
            if mode == SLIPS:
                integrator.pars[0] = side
            grid = np.concatenate([[now], t[len(found) :]])
            started = perf_counter()
            if len(grid) == 2:
                told = integrator.propagate_until(t[-1])
            else:
                told = integrator.propagate_grid(grid)
            seconds += perf_counter() - started
            found += [] if len(grid) == 2 else list(told[-1][1:])
            while len(found) < len(t) and t[len(found)] <= integrator.time:
                found.append(
                    integrator.update_d_output(t[len(found)]).copy()
                )  # of the step that an event has cut
            steps += int(told[3])
            if len(found) == len(t):
                break
            now = integrator.time
            state = integrator.state.copy()
            mode, side = self._after(mode, side, -int(told[0]) - 1, state)
            if mode == APART:
                found.append(np.array([*state, now]))
                break
        return found, steps, seconds

    def _after(self, mode: int, side: float, event: int, state: Array) -> tuple[int, float]:
        """Mode and side after an event; the spring where it begins to hold."""
        if event == 0:
            return APART, side
        if mode == HOLDS:
            return SLIPS, 1.0 if event == 1 else -1.0
        if event == 1:
            state[6] = (
                side
                * INSIDE
                * self.share
                * (self.law.stiffness * state[0] + self.law.damping * state[1])
            )
        return (HOLDS if event == 1 else FREE), side

    def trajectory(self, t: Array, found: list[Array]) -> Trajectory:
        """The motion of both, straight on once they have parted."""
        bodies = self.scene.bodies
        parted = len(found[-1]) == 8
        touch = np.array([row[:7] for row in found])
        d, _, q, angle, p, r, _ = touch.T
        reach = bodies.radius.sum() - d
        g = touch[:, 1]
        c = np.cos(angle)
        s = np.sin(angle)
        place = reach * np.array([c, s])
        speed = np.array([-g * c - q * s, -g * s + q * c])
        spins = np.array([p, r])
        if parted:
            since = t[len(found) - 1 :] - found[-1][7]
            place = np.concatenate([place[:, :-1], place[:, -1:] + speed[:, -1:] * since], axis=1)
            later = [np.repeat(column[:, -1:], len(since), axis=1) for column in (speed, spins)]
            speed, spins = (
                np.concatenate([column[:, :-1], more], axis=1)
                for column, more in zip((speed, spins), later, strict=True)
            )
        share = np.array([-bodies.mass[1], bodies.mass[0]])[:, None] / bodies.mass.sum()
        position, velocity, omega = (np.zeros((len(t), 2, 3)) for _ in range(3))
        centre, drift = (
            bodies.mass @ column / bodies.mass.sum()
            for column in (bodies.position, bodies.velocity)
        )
        position[:, :, :2] = place.T[:, None] * share
        velocity[:, :, :2] = speed.T[:, None] * share
        omega[:, :, 2] = spins.T
        position += centre + drift * (t - t[0])[:, None, None]
        still = np.broadcast_to(bodies.attitude, (len(t), 2, 4)).copy()
        return Trajectory(
            t=t, position=position, velocity=velocity + drift, attitude=still, omega=omega
        )


def oblique(scene: Scene) -> Oblique | None:
    """The pair, if it parts where the overlap ends, and the reference's series say it too."""
    laws = scene.all(Contact)
    reference = discovery.engine("reference")
    if not laws or laws[0].cutoff != "zero_overlap" or len(scene.bodies) != 2:
        return None
    if reference.refusal(Motion(scene, np.array([0.0, 1.0])), reference.method("oblique-contact")):
        return None
    line = np.diff(scene.bodies.position, axis=0)[0]
    velocity = scene.bodies.velocity
    spins = scene.bodies.omega
    aside = (*line[1:], *velocity[:, 2], *spins[:, :2].ravel())
    if line[0] > 0 and not any(aside):
        return Oblique(scene, laws[0])
    return None
